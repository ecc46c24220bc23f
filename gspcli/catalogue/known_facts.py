"""The facts about a type or family that need no solution of a platform."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gspcli.catalogue.bounds import Bounds, family_bounds, type_bounds
from gspcli.catalogue.coincidence import count_coincident
from gspcli.catalogue.constraints import constraint_facts
from gspcli.catalogue.counts import (
    GenericCounts,
    best_real,
    family_counts,
    generic_counts,
    real_counts,
)
from gspcli.catalogue.kinds import Kind
from gspcli.catalogue.names import any_subject, parse_type
from gspcli.catalogue.realization import mechanism_of_type, realization
from gspcli.catalogue.types import Family, GspType
from gspcli.records import dataclass

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False)
class KnownBounds:
    """The bounds and the generic counts of a type or family.

    Attributes
    ----------
    subject
        The type or family.
    """

    subject: GspType | Family

    def __repr__(self) -> str:
        refined, count = self.bounds.refined_one_sided.value, self.counts.one_sided
        return f"<KnownBounds of {self.subject.id}: at most {refined}, generically {count}>"

    @property
    def bounds(self) -> Bounds:
        """The bounds, each with its reason."""
        subject = self.subject
        return type_bounds(subject) if isinstance(subject, GspType) else family_bounds(subject)

    @property
    def counts(self) -> GenericCounts:
        """The generic counts."""
        subject = self.subject
        return generic_counts(subject) if isinstance(subject, GspType) else family_counts(subject)

    @property
    def kinds(self) -> tuple[Kind, ...]:
        """The kinds of the constraints; of a family those of the distances."""
        return self.subject.kinds if isinstance(self.subject, GspType) else self.subject.distances

    @property
    def identity(self) -> dict[str, Any]:
        """The identity of the subject as plain data."""
        family = self.subject.family if isinstance(self.subject, GspType) else self.subject
        return {**self.subject.to_json(), "family": family.id}

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each bound: its value and its reason (pandas is imported now)."""
        import pandas as pd

        rows = [
            {"bound": name, "value": found and found.value, "reason": found and found.reason}
            for name, found in self.bounds.items()
        ]
        return pd.DataFrame(rows).astype({"value": "Int64"})

    def to_json(self) -> dict[str, Any]:
        """Return everything as plain data of schema ``gsp.bound/1``."""
        subject, bounds, counts = self.subject, self.bounds, self.counts
        return {
            "schema": "gsp.bound/1",
            "type": self.identity,
            "constraints": [_constraint(kind) for kind in self.kinds],
            "bounds": bounds.values(),
            "reasons": {
                name: None if found is None else found.reason for name, found in bounds.items()
            },
            "generic": {
                "one_sided": counts.one_sided,
                "two_sided": counts.two_sided,
                "established": counts.established,
            },
            "best_real": best_real(subject),
            "real_counts": list(real_counts(subject)),
        }


@dataclass(frozen=True, eq=False)
class KnownFacts(KnownBounds):
    """The facts about a type.

    Attributes
    ----------
    subject
        The type.
    """

    subject: GspType

    def __repr__(self) -> str:
        return f"<KnownFacts of {self.subject.id}: number {self.subject.number}, {self.method}>"

    @property
    def method(self) -> str:
        """The method that solves its platforms, in words."""
        if self.subject.angles and len(self.subject.angles) == len(self.subject.distances):
            steps = "eight rotations, then the meeting points of three surfaces (Alg. 6.6)"
            return f"closed form: {steps}"
        return "path tracking from a stored start system"

    @property
    def sharing_patterns(self) -> int:
        """The number of ways in which its constraints may share primitives."""
        return count_coincident(self.subject)

    def to_json(self) -> dict[str, Any]:
        """Return everything as plain data of schema ``gsp.show/1``."""
        return {
            **super().to_json(),
            "schema": "gsp.show/1",
            "mirrored": self.subject.mirrored.number,
            "sharing_patterns": self.sharing_patterns,
            "method": self.method,
            "chains": [realization(kind).chain.name for kind in self.kinds],
            "mobility": mechanism_of_type(self.subject).sum_shown,
        }


def bound(subject: GspType | Family | str | int) -> KnownBounds:
    """Return the bounds and the generic counts of a type or family, given itself or by its name.

    Raises
    ------
    TypeNameError
        If a text is the name of neither.

    Examples
    --------
    >>> bound("6PP").counts.one_sided
    40
    """
    return KnownBounds(any_subject(subject))


def show(gsp_type: GspType | str | int) -> KnownFacts:
    """Return the facts about a type, given itself, by its name or by its number.

    Raises
    ------
    TypeNameError
        If a text is the name of no type.

    Examples
    --------
    >>> show("6PP").sharing_patterns > 0
    True
    """
    named = parse_type(str(gsp_type)) if isinstance(gsp_type, str | int) else gsp_type
    return KnownFacts(named)


def _constraint(kind: Kind) -> dict[str, Any]:
    facts = constraint_facts(kind)
    return {
        "kind": kind.name,
        "degree_lazard": facts.paper_lazard.two_sided,
        "degree_mourrain": facts.paper_mourrain.two_sided,
        "degree_lowest": facts.lowest.two_sided,
        "degree_lowest_one_sided": facts.lowest.one_sided,
        "surface": facts.surface,
    }
