"""Directions of a body that are nearly parallel, and the platforms with them turned apart."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

from flint import arb, ctx

from gspcli.certification.equations.statement import statements
from gspcli.certification.numbers.balls import dot, norm
from gspcli.certification.poses.special_family import DIFFERENCE_BITS, exact
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.primitives import Line, Plane, Point, Vector
from gspcli.geometry.tolerances import TURNED_APART_RADIANS
from gspcli.records import dataclass


class _Turn(NamedTuple):
    """A direction of a row and its difference from a nearly parallel one of the same length."""

    near: list[arb]
    difference: list[arb]
    angle: float


@dataclass(frozen=True)
class TurnedDirections:
    """A platform with nearly parallel directions as a member of a family.

    Attributes
    ----------
    instance
        The platform at s = 1.
    turns
        For each constraint the directions that are turned in the platform and in the base.
    """

    instance: Instance
    turns: tuple[tuple[_Turn | None, _Turn | None], ...]

    @classmethod
    def of(cls, instance: Instance) -> TurnedDirections | None:
        """Return the family of a platform; None if no directions of it are nearly parallel."""
        with ctx.workprec(DIFFERENCE_BITS):
            given = statements(instance)
            sides = (_turns([row.u for row in given]), _turns([row.v for row in given]))
        if not any(turn for turns in sides for turn in turns):
            return None
        return cls(instance, tuple(zip(*sides, strict=True)))

    @cached_property
    def size(self) -> float:
        """The largest difference of nearly parallel directions."""
        return max(turn.angle for pair in self.turns for turn in pair if turn)

    def at(self, s: arb) -> Instance:
        """Return the platform with the differences multiplied by s, to the working precision."""
        rows = (
            _turned(row, *(turn and _vector(turn, s) for turn in pair))
            for row, pair in zip(self.instance.constraints, self.turns, strict=True)
        )
        return Instance(tuple(rows), self.instance.units)


def _turns(directions: Sequence[Sequence[arb]]) -> list[_Turn | None]:
    """Return for each direction its turn from the first that it is nearly parallel to."""
    found: list[_Turn | None] = []
    for k, direction in enumerate(directions):
        turns = (_turn(other, direction) for other in directions[:k] if other and direction)
        found.append(next((turn for turn in turns if turn), None))
    return found


def _turn(other: Sequence[arb], direction: Sequence[arb]) -> _Turn | None:
    length = norm(direction)
    factor = length / norm(other)
    if dot(other, direction) < 0:
        factor = -factor
    near = [factor * x for x in other]
    difference = [x - y for x, y in zip(direction, near, strict=True)]
    if all(x.contains(0) for x in difference):
        return None
    angle = float((norm(difference) / length).mid())
    least, most = TURNED_APART_RADIANS
    return _Turn(near, difference, angle) if least < angle < most else None


def _vector(turn: _Turn, s: arb) -> Vector:
    x, y, z = (exact(a + s * b) for a, b in zip(turn.near, turn.difference, strict=True))
    return x, y, z


def _turned(row: Constraint, u: Vector | None, v: Vector | None) -> Constraint:
    """Return a constraint with new directions in the platform and in the base, if there are any."""
    platform = row.platform if u is None else _along(row.platform, u)
    base = row.base if v is None else _along(row.base, v)
    return Constraint(row.kind, platform, base, row.value, row.side)


def _along(geometry: Point | Line | Plane, vector: Vector) -> Line | Plane:
    assert not isinstance(geometry, Point)
    return type(geometry)(geometry.position, vector)
