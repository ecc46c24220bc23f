"""Upper bounds on the number of solutions of a type: the paper's theorems and refined ones.

All of them bound the complex solutions of platforms that have finitely many. The theorems use the
degrees of Proposition 4.1, the refined bounds the lowest degrees. Bezout's theorem holds on the
variety of rigid motions in any coordinates. So the refined bound is the least over all recorded
sets of coordinates; for 3D3A also over the two steps of Section 6, orientations and then positions.
An angle is linear in all coordinates and has the factor 1.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import field
from functools import cache
from math import prod
from typing import NamedTuple

from gspcli.catalogue.constraints import LowestDegrees, constraint_facts
from gspcli.catalogue.kinds import DISTANCE_KINDS, DLL, DPH, DPP, Kind
from gspcli.catalogue.types import CONSTRAINTS, MAX_ANGLES, Family, GspType
from gspcli.records import dataclass
from gspcli.resources import data_json


@dataclass(frozen=True)
class Variety:
    """The rigid motions as a variety in one set of coordinates (Section 3)."""

    #: The blocks of coordinates, such as ``R,T,U``: R, T, U = RᵀT, rho = T·T and TxR, the matrix
    #: with columns T × R_k.
    coordinates: str
    #: Number of coordinates.
    ambient_dimension: int
    #: Number of the equations that generate the ideal.
    equations: int
    #: 6; 3 for the rotations alone.
    dimension: int
    #: Degree of the projective closure.
    degree: int
    #: Coefficients of h in the Hilbert series h(t) / (1 - t)^(dimension + 1) of the projective
    #: closure; they add up to the degree.
    hilbert_numerator: tuple[int, ...]

    @property
    def label(self) -> str:
        """The coordinates as people write them, such as ``(R, T, U, ρ)``."""
        return coordinates_label(self.coordinates)


#: Lazard's coordinates and Mourrain's, with 16 and with 25 entries (Section 3).
LAZARD = "R,T,U"
MOURRAIN_16 = "R,T,U,rho"
MOURRAIN = "R,T,U,rho,TxR"
#: The rotations alone.
ROTATIONS = "R"


def coordinates_label(coordinates: str) -> str:
    """Return coordinates as people write them.

    >>> coordinates_label("R,T,U,rho,TxR")
    '(R, T, U, ρ, T×R)'
    """
    return f"({coordinates.replace('rho', 'ρ').replace('x', '×').replace(',', ', ')})"


@cache
def varieties() -> dict[str, Variety]:
    """Return the varieties by their coordinates, the smallest first."""
    return {
        record["coordinates"]: Variety(
            **{**record, "hilbert_numerator": tuple(record["hilbert_numerator"])}
        )
        for record in data_json("varieties.json")["varieties"]
    }


_NUMBER_WORDS = ("no", "one", "two", "three", "four", "five", "six")
#: The letters of the surfaces in the order of Table 3.
_SURFACES = "PSC"


@dataclass(frozen=True)
class BezoutSpace:
    """A variety on which Bezout's theorem is applied."""

    #: The coordinates, in words for people.
    name: str
    #: The degree of the variety.
    degree: int
    #: For each kind of distance, by its order, the factors of the first constraint and of any other
    #: one.
    degrees: tuple[tuple[int, int], ...]

    def factors(self, distances: Sequence[Kind]) -> list[tuple[Kind, int]]:
        """Return the factor of each constraint."""
        return [
            (kind, self.degrees[kind.order][min(distances[:position].count(kind), 1)])
            for position, kind in enumerate(distances)
        ]

    def bound(self, counts: Sequence[tuple[Kind, int]]) -> int:
        """Return the product of the degrees for this many constraints of each kind."""
        value = self.degree
        for kind, count in counts:
            first, other = self.degrees[kind.order]
            value *= first * other ** (count - 1)
        return value


def _space(
    name: str, degree: int, lowest: Iterable[LowestDegrees | None], *, one_sided: bool
) -> BezoutSpace:
    """Return a space from the lowest degrees of the kinds of distance, in their order."""
    pairs = []
    for degrees in lowest:
        assert degrees is not None, name
        first = degrees.of(one_sided=one_sided)
        pairs.append((first, first if degrees.difference is None else degrees.difference))
    return BezoutSpace(name, degree, tuple(pairs))


@cache
def motion_spaces(*, one_sided: bool) -> tuple[BezoutSpace, ...]:
    """Return the varieties of all rigid motions, the smallest first."""
    return tuple(
        _space(
            f"motions in {variety.label}",
            variety.degree,
            (constraint_facts(kind).degrees[name] for kind in DISTANCE_KINDS),
            one_sided=one_sided,
        )
        for name, variety in varieties().items()
        if name != ROTATIONS
    )


@cache
def orientation_space(*, one_sided: bool) -> BezoutSpace:
    """Return the orientations that three angles allow, with the degrees in T for each of them."""
    return _space(
        "orientations in (R), then positions",
        varieties()[ROTATIONS].degree,
        (constraint_facts(kind).fixed_orientation for kind in DISTANCE_KINDS),
        one_sided=one_sided,
    )


@dataclasses.dataclass(frozen=True, slots=True)
class Bound:
    """A proved ceiling for the number of solutions."""

    #: The number.
    value: int
    #: Returns the reason. It is called only if the reason is shown: there are thousands of bounds.
    explain: Callable[[], str] = field(repr=False, compare=False)

    @property
    def reason(self) -> str:
        """The theorem or the variety, with the product spelled out."""
        return self.explain()


@dataclasses.dataclass(frozen=True, slots=True)
class Bounds:
    """The bounds of a type or family."""

    #: Two-sided, with the paper's degrees.
    theorem_5_2: Bound
    theorem_5_3: Bound
    #: One-sided; only for the 35 types of DPH distances and angles.
    theorem_5_4: Bound | None
    #: The paper's N1, one-sided and with one of the two planes of a DLL; only for 3D3A.
    table_3: Bound | None
    #: With the side of each DPH and DHP chosen, or left open; both planes of a DLL.
    refined_one_sided: Bound
    refined_two_sided: Bound

    def items(self) -> Iterator[tuple[str, Bound | None]]:
        """Yield the names, as in the columns of the catalogue, with their bounds."""
        for name in BOUND_NAMES:
            yield name, getattr(self, name)

    def values(self) -> dict[str, int | None]:
        """Return the numbers by name; None where a theorem does not apply."""
        return {name: None if bound is None else bound.value for name, bound in self.items()}


class BoundMeaning(NamedTuple):
    """The title of a bound, and the solutions that it counts."""

    title: str
    sides: str
    """Which number it limits: the theorems leave the side of a plane open (Section 5)."""


#: The meanings of the bounds by name, in the order of the catalogue's columns.
BOUND_MEANINGS = {
    "theorem_5_2": BoundMeaning("Theorem 5.2", "two-sided"),
    "theorem_5_3": BoundMeaning("Theorem 5.3", "two-sided"),
    "theorem_5_4": BoundMeaning("Theorem 5.4", "one-sided"),
    "table_3": BoundMeaning("Table 3", "one-sided"),
    "refined_one_sided": BoundMeaning("refined, one-sided", "one-sided"),
    "refined_two_sided": BoundMeaning("refined, two-sided", "two-sided"),
}
BOUND_NAMES = tuple(BOUND_MEANINGS)


#: Table 3 counts one of the two planes that a DLL gives for each orientation.
ONE_ORIENTATION = "one orientation of each DLL"


def bound_sides(name: str, distances: Sequence[Kind]) -> str:
    """Return which solutions a bound counts: the sides, and the orientations of a DLL."""
    sides = BOUND_MEANINGS[name].sides
    return f"{sides}, {ONE_ORIENTATION}" if name == "table_3" and DLL in distances else sides


def type_bounds(gsp_type: GspType) -> Bounds:
    """Return the bounds of a type; the kinds of its angles make no difference."""
    return _bounds(gsp_type.distances)


def family_bounds(family: Family) -> Bounds:
    """Return the bounds that all types of a family share."""
    return _bounds(family.distances)


@cache
def _bounds(distances: tuple[Kind, ...]) -> Bounds:
    return Bounds(
        theorem_5_2=_theorem_5_2(distances),
        theorem_5_3=_theorem_5_3(distances),
        theorem_5_4=_theorem_5_4(distances),
        table_3=_table_3(distances),
        refined_one_sided=_refined(distances, one_sided=True),
        refined_two_sided=_refined(distances, one_sided=False),
    )


def _theorem_5_2(distances: tuple[Kind, ...]) -> Bound:
    return _by_paper_degrees("Theorem 5.2", varieties()[MOURRAIN_16].degree, distances)


def _theorem_5_3(distances: tuple[Kind, ...]) -> Bound:
    degree = varieties()[LAZARD].degree
    if DPP not in distances:
        return _by_paper_degrees("Theorem 5.3, no DPP", degree, distances)
    first = constraint_facts(DPP).paper_lazard.two_sided
    factors = _paper_factors(distances)
    value = _product(degree * first, factors)

    def explain() -> str:
        powers, counts = _powers(factors)
        product = " · ".join([str(degree), str(first), *powers])
        reasons = [f"one DPP of degree {first}, differences linear", *counts]
        return f"Theorem 5.3: {product} = {value}: {'; '.join(reasons)}"

    return Bound(value, explain)


def _by_paper_degrees(theorem: str, start: int, distances: tuple[Kind, ...]) -> Bound:
    factors = _paper_factors(distances)
    return Bound(_product(start, factors), lambda: f"{theorem}: {_spelled(start, factors)}")


def _paper_factors(distances: tuple[Kind, ...]) -> list[tuple[Kind, int]]:
    return [(kind, constraint_facts(kind).paper_mourrain.two_sided) for kind in distances]


def _theorem_5_4(distances: tuple[Kind, ...]) -> Bound | None:
    if any(kind != DPH for kind in distances):
        return None
    value = varieties()[LAZARD].degree
    return Bound(
        value,
        lambda: (
            f"Theorem 5.4: {value}, the degree of Lazard's variety; "
            "one-sided DPH and angles are linear"
        ),
    )


def _table_3(distances: tuple[Kind, ...]) -> Bound | None:
    if len(distances) != CONSTRAINTS - MAX_ANGLES:
        return None
    # A plane is of degree one, also each of the two of a DLL.
    meeting = _product(
        1,
        [
            (kind, 1 if _surface(kind) == "P" else factor)
            for kind, factor in orientation_space(one_sided=True).factors(distances)
        ],
    )
    rotations = varieties()[ROTATIONS].degree
    value = rotations * meeting

    def explain() -> str:
        letters = "".join(sorted(map(_surface, distances), key=_SURFACES.index))
        reason = (
            f"Table 3: {rotations} · {meeting} = {value}: {rotations} orientations, and in each "
            f"the surfaces {letters} meet in {meeting} point{'s' * (meeting > 1)}"
        )
        if any(kind.has_sides for kind in distances):
            reason += "; one-sided"
        if DLL in distances:
            both = value * 2 ** distances.count(DLL)
            reason += f"; for {ONE_ORIENTATION}, one of its two planes; for both {both}"
        return reason

    return Bound(value, explain)


def _surface(kind: Kind) -> str:
    surface = constraint_facts(kind).surface
    assert surface is not None, kind
    return surface


def _refined(distances: tuple[Kind, ...], *, one_sided: bool) -> Bound:
    counts = tuple((kind, distances.count(kind)) for kind in dict.fromkeys(distances))
    spaces = motion_spaces(one_sided=one_sided)
    if len(distances) == CONSTRAINTS - MAX_ANGLES:
        spaces = (*spaces, orientation_space(one_sided=one_sided))
    # The first of equal bounds is that of the smallest variety.
    values = [space.bound(counts) for space in spaces]
    value = min(values)
    best = spaces[values.index(value)]

    def explain() -> str:
        factors = best.factors(distances)
        reason = f"Bezout on the {best.name}: {_spelled(best.degree, factors)}"
        for kind, count in counts:
            first, other = best.degrees[kind.order]
            if count > 1 and other < first:
                reason += f"; differences of {kind} have degree {other}"
        if one_sided and any(kind.has_sides for kind in distances):
            reason += "; one-sided"
        theorem = _theorem_5_3(distances).value
        if value < theorem:
            reason += f"; Theorem 5.3 has {theorem}{_excess(distances, factors, best.degree)}"
        return reason

    return Bound(value, explain)


def _excess(distances: tuple[Kind, ...], factors: Sequence[tuple[Kind, int]], degree: int) -> str:
    """Return why the bound of Theorem 5.3 is larger: degrees of constraints or of the variety."""
    lower = dict(factors)
    higher = [
        f"{kind} of degree {paper}"
        for kind, paper in dict.fromkeys(_paper_factors(distances))
        if paper > lower[kind]
    ]
    lazard = varieties()[LAZARD].degree
    if lazard > degree:
        higher.append(f"a variety of degree {lazard}")
    return f", with {' and '.join(higher)}" if higher else ""


def _product(start: int, factors: Sequence[tuple[Kind, int]]) -> int:
    return start * prod(factor for _, factor in factors)


def _spelled(start: int, factors: Sequence[tuple[Kind, int]]) -> str:
    """Return a product in words, without factors of one."""
    powers, counts = _powers(factors)
    if not powers:
        return f"{start}, all constraints of degree 1"
    product = " · ".join([str(start), *powers])
    return f"{product} = {_product(start, factors)}: {', '.join(counts)}"


def _powers(factors: Sequence[tuple[Kind, int]]) -> tuple[list[str], list[str]]:
    """Return the powers in a product, and the constraints of each."""
    by_factor: dict[int, list[str]] = {}
    for kind, factor in factors:
        if factor > 1:
            by_factor.setdefault(factor, []).append(kind.name)
    powers = [f"{factor}^{len(names)}" for factor, names in sorted(by_factor.items())]
    counts = [
        f"{_NUMBER_WORDS[len(names)]} of degree {factor} ({', '.join(names)})"
        for factor, names in sorted(by_factor.items())
    ]
    return powers, counts
