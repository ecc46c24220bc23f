"""The recorded facts about each kind of constraint: equations, degrees, loci."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from gspcli.catalogue.kinds import KINDS_BY_NAME, Kind, Primitive
from gspcli.records import dataclass
from gspcli.resources import data_json

_NOUNS = {Primitive.POINT: "point", Primitive.LINE: "line", Primitive.PLANE: "plane"}


@dataclass(frozen=True)
class Writing:
    """A formula in plain text and in LaTeX."""

    text: str
    latex: str


@dataclass(frozen=True)
class Degrees:
    """Degrees of one constraint."""

    #: With the side of a DPH or DHP left open.
    two_sided: int
    #: With that side chosen; the same number for all other kinds.
    one_sided: int

    def of(self, *, one_sided: bool) -> int:
        """Return the one or the other."""
        return self.one_sided if one_sided else self.two_sided


@dataclass(frozen=True)
class LowestDegrees(Degrees):
    """The lowest degrees in one set of coordinates."""

    #: Degree of the difference of two constraints of the kind, where that is lower.
    difference: int | None = None


@dataclass(frozen=True)
class Locus:
    """The locus of a point of the platform primitive under a fixed orientation."""

    #: P, S or C (Proposition 6.7).
    surface: str
    #: The surface in words.
    text: str


@dataclass(frozen=True)
class ConstraintFacts:
    """The recorded facts about one kind of constraint.

    Attributes
    ----------
    kind
        The kind.
    definition
        The constraint in R and T (Section 4).
    equations
        Its equations of lowest degree by coordinates: Lazard's, Mourrain's, and those of
        `lowest_coordinates`.
    paper_lazard, paper_mourrain
        The degrees by Proposition 4.1 in the two sets of coordinates.
    lowest
        The lowest degrees of all.
    lowest_coordinates
        The smallest coordinates in which they are reached.
    why_lowest
        The reason for the lowest degrees, in words.
    degrees
        The lowest degrees in every set of coordinates that can express the constraint.
    fixed_orientation
        The lowest degrees in T when R is constant; None for angles.
    loci
        ``generic`` and, for two lines, ``parallel``; empty for angles.
    """

    kind: Kind
    definition: Writing
    equations: Mapping[str, Writing]
    paper_lazard: Degrees
    paper_mourrain: Degrees
    lowest: Degrees
    lowest_coordinates: str
    why_lowest: str
    degrees: Mapping[str, LowestDegrees]
    fixed_orientation: LowestDegrees | None
    loci: Mapping[str, Locus]

    @property
    def surface(self) -> str | None:
        """The letter of the locus, LL counted as planes; None for angles."""
        return self.loci["generic"].surface if self.loci else None

    @property
    def meaning(self) -> str:
        """The measured quantity, in words."""
        quantity = "distance of a" if self.kind.is_distance else "angle between a"
        joint = "from" if self.kind.is_distance else "and"
        platform, base = _NOUNS[self.kind.platform], _NOUNS[self.kind.base]
        return f"{quantity} {platform} of the platform {joint} a {base} of the base"


@cache
def constraint_facts(kind: Kind | str) -> ConstraintFacts:
    """Return the recorded facts about a kind of constraint, or about that of a name: ``PL``.

    Raises
    ------
    TypeNameError
        If there is no such kind, or if the name fits two.
    """
    if isinstance(kind, str):
        from gspcli.catalogue.names import parse_kind

        kind = parse_kind(kind)
    return _all_facts()[kind]


@cache
def _all_facts() -> dict[Kind, ConstraintFacts]:
    facts = {}
    for record in data_json("constraints.json")["constraints"]:
        kind = KINDS_BY_NAME[record["kind"]]
        lowest = record["lowest"]
        facts[kind] = ConstraintFacts(
            kind,
            Writing(**record["definition"]),
            {name: Writing(**both) for name, both in record["equations"].items()},
            Degrees(**record["paper_degrees"]["lazard"]),
            Degrees(**record["paper_degrees"]["mourrain"]),
            Degrees(lowest["two_sided"], lowest["one_sided"]),
            lowest["coordinates"],
            lowest["why"],
            {name: LowestDegrees(**row) for name, row in record["degrees"].items()},
            LowestDegrees(**fixed) if (fixed := record["fixed_orientation"]) else None,
            {case: Locus(**locus) for case, locus in record["loci"].items()},
        )
    return facts
