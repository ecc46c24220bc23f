"""Varieties on which Bezout's theorem bounds the solutions, with the degrees of distances."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache

from gspcli.catalogue.constraints import LowestDegrees, constraint_facts
from gspcli.catalogue.kinds import DISTANCE_KINDS, Kind
from gspcli.catalogue.recorded_varieties import ROTATIONS, varieties
from gspcli.records import dataclass


@dataclass(frozen=True)
class BezoutSpace:
    """A variety on which Bezout's theorem is applied.

    Attributes
    ----------
    name
        The coordinates, in words for people.
    degree
        The degree of the variety.
    degrees
        For each kind of distance, by its order, the factors of the first constraint and of any
        other one.
    """

    name: str
    degree: int
    degrees: tuple[tuple[int, int], ...]

    def factors(self, distances: Sequence[Kind]) -> list[tuple[Kind, int]]:
        """Return the factor of each constraint."""
        return [
            (kind, self.degrees[kind.order][min(distances[:position].count(kind), 1)])
            for position, kind in enumerate(distances)
        ]

    def bound(self, counts: Sequence[tuple[Kind, int]]) -> int:
        """Return the product of the degrees for so many constraints of each kind."""
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
