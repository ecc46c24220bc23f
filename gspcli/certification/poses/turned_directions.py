"""Directions of a body that are nearly parallel, and the platforms with them turned apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from flint import arb, ctx

from gspcli.certification.equations.statement import statements
from gspcli.certification.numbers.balls import dot, norm
from gspcli.certification.poses.special_family import DIFFERENCE_BITS, SpecialFamily
from gspcli.geometry.instance import Instance
from gspcli.geometry.tolerances import TURNED_APART_RADIANS


def turned_directions(instance: Instance) -> SpecialFamily | None:
    """Return a platform among those with its nearly parallel directions turned apart.

    The result is None if no directions of a body are nearly parallel.
    """
    differences: list[dict[str, list[arb]]] = [{} for _ in instance.constraints]
    size = 0.0
    with ctx.workprec(DIFFERENCE_BITS):
        given = statements(instance)
        for name in "uv":
            for k, (difference, angle) in _turns([getattr(row, name) for row in given]).items():
                differences[k][name] = difference
                size = max(size, angle)
    return SpecialFamily(instance, tuple(differences), size) if size else None


def _turns(directions: Sequence[Sequence[arb]]) -> Mapping[int, tuple[list[arb], float]]:
    """Return by index the turns from the first direction that another is nearly parallel to."""
    found: dict[int, tuple[list[arb], float]] = {}
    for k, direction in enumerate(directions):
        turns = (_turn(other, direction) for other in directions[:k] if other and direction)
        if (turn := next((turn for turn in turns if turn), None)) is not None:
            found[k] = turn
    return found


def _turn(other: Sequence[arb], direction: Sequence[arb]) -> tuple[list[arb], float] | None:
    """Return the difference of two directions of the same length, and their angle."""
    length = norm(direction)
    factor = length / norm(other)
    if dot(other, direction) < 0:
        factor = -factor
    difference = [x - factor * y for x, y in zip(direction, other, strict=True)]
    if all(x.contains(0) for x in difference):
        return None
    angle = float((norm(difference) / length).mid())
    least, most = TURNED_APART_RADIANS
    return (difference, angle) if least < angle < most else None
