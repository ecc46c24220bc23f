"""Patterns of shared primitives that can never fix the platform, with the proof by counting.

Choose some primitives of either body, at their places in a pose. Consider the motions of the
platform that keep all of them in place (a line may slide along itself, a plane in itself). Such a
motion changes no value of a constraint that has an end among these primitives. If the motions have
s freedoms, at most 6 - s of these constraints are independent. If there are more than 6 - s of
them, the whole pattern is dependent in every pose, and its direct kinematics has no solution or
infinitely many. An angle depends only on the direction of a line or plane.

The converse is a computation, not part of this module: the tests find six independent gradients, in
exact arithmetic, for patterns without such a part.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

from gspcli.catalogue.coincidence import Connection
from gspcli.catalogue.types import CONSTRAINTS
from gspcli.records import dataclass

#: The part of a primitive that the constraints use: all of it, or the direction of a line or plane.
_POINT, _LINE, _PLANE, _DIRECTION = "P", "L", "H", "direction"


@dataclass(frozen=True)
class OverConstraint:
    """Constraints that cannot all be independent.

    Attributes
    ----------
    primitives
        Primitives, or directions of primitives, that have an end of each of the constraints.
    freedoms
        The freedoms of the motions that leave these primitives in place.
    constraints
        The constraints, by index from 0; there are more than six less `freedoms`.
    """

    primitives: tuple[str, ...]
    freedoms: int
    constraints: tuple[int, ...]

    @property
    def reason(self) -> str:
        """The proof in a sentence."""
        fixed = " and ".join(self.primitives)
        plural = "s" * (self.freedoms != 1)
        return (
            f"motions that keep {fixed} in place have {self.freedoms} freedom{plural}, so at most "
            f"{CONSTRAINTS - self.freedoms} of these {len(self.constraints)} constraints "
            "are independent"
        )


def motion_freedoms(points: int, lines: int, planes: int, directions: int) -> int:
    """Return the freedoms of the motions that leave primitives in general position in place.

    In special positions the motions can only be more. `directions` counts primitives of which only
    the direction stays.

    >>> motion_freedoms(1, 0, 0, 0), motion_freedoms(0, 1, 0, 0), motion_freedoms(0, 0, 1, 0)
    (3, 2, 3)
    """
    different = lines + planes + directions
    if different >= 2:
        # No rotation keeps two directions; of the translations a line leaves one, a plane two.
        return max(0, 3 - 3 * points - 2 * lines - planes)
    if different == 1 and points == 0:
        return 1 + 3 - 2 * lines - planes
    if different == 1:
        # The rotation about the parallel through the point, if there is no line and no other point.
        return int(points == 1 and lines == 0)
    return {0: 6, 1: 3, 2: 1}.get(points, 0)


def over_constraint(connections: Iterable[Connection]) -> OverConstraint | None:
    """Return constraints that cannot all be independent, or None if counting shows none.

    >>> from gspcli.catalogue.coincidence import parse_sharing
    >>> print(over_constraint(parse_sharing("P1-p1 P1-p2 P1-p3 P2-p4 P3-p4 P4-p4").bonds).reason)
    motions that keep P1 and p4 in place have 1 freedom, so at most 5 of these 6 constraints are \
independent
    """
    return _search(_features(tuple(connections)), (), frozenset())


#: A primitive: body and name, the part that is used, and the constraints that end there.
_Feature = tuple[tuple[str, str], str, frozenset[int]]


def _features(connections: tuple[Connection, ...]) -> list[_Feature]:
    distances: defaultdict[tuple[str, str], set[int]] = defaultdict(set)
    angles: defaultdict[tuple[str, str], set[int]] = defaultdict(set)
    sorts = {}
    for index, connection in enumerate(connections):
        kind = connection.kind
        for body, name, sort in (
            ("platform", connection.platform_name, kind.platform.value),
            ("base", connection.base_name, kind.base.value),
        ):
            primitive = (body, name or f"that of constraint {index + 1}")
            sorts[primitive] = sort
            (distances if kind.is_distance else angles)[primitive].add(index)
    directions = [(primitive, _DIRECTION, frozenset(ends)) for primitive, ends in angles.items()]
    whole = [
        (primitive, sorts[primitive], frozenset(ends | angles.get(primitive, set())))
        for primitive, ends in distances.items()
    ]
    return directions + whole


def _search(
    candidates: list[_Feature], kept: tuple[_Feature, ...], covered: frozenset[int]
) -> OverConstraint | None:
    """Add one of the candidates in every way that still allows a motion."""
    for position, feature in enumerate(candidates):
        primitive, _, ends = feature
        if any(primitive == other for other, _, _ in kept):
            continue
        now = (*kept, feature)
        seen = [sort for _, sort, _ in now]
        freedoms = motion_freedoms(*map(seen.count, (_POINT, _LINE, _PLANE, _DIRECTION)))
        if freedoms == 0:
            continue
        reached = covered | ends
        if len(reached) > CONSTRAINTS - freedoms:
            names = tuple(
                f"the direction of {name}" if sort == _DIRECTION else name
                for (_, name), sort, _ in now
            )
            return OverConstraint(names, freedoms, tuple(sorted(reached)))
        if found := _search(candidates[position + 1 :], now, reached):
            return found
    return None
