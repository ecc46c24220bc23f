"""The shapes of legs and bodies, as an instance file states them under `shapes`.

A leg is a distance of two points. Its shape is a cylinder with round ends, about the straight line
between its joints. That of a body is the convex hull of points that are fixed in it. The arm of a
crank has a diameter at its point (`gspcli.geometry.primitives.Crank`). Nothing else has a shape: no
motor, no joint. Lengths are in the unit of length.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from gspcli.catalogue.kinds import DPP
from gspcli.errors import ArgumentError
from gspcli.geometry.instance import Constraint
from gspcli.geometry.numbers import Number, Real
from gspcli.geometry.primitives import Components, Vector, exact_vector
from gspcli.records import dataclass


@dataclass(frozen=True, init=False)
class Shapes:
    """The shapes of the legs and of both bodies.

    Attributes
    ----------
    diameters
        Of the legs, at least zero: one for all of them, or one for each, in their order.
    platform, base
        Points of each body, in its frame; their convex hull is its shape. Empty if it has none.
    near_joint
        The part of a leg that is nearer to its joint is not compared with what it is joined to
        there: the body, and the legs that share the joint. So it is with an arm, its rod, and the
        body with its axis. If None, or zero, legs that share a joint, and an arm and its rod, are
        not compared at all.
    """

    diameters: tuple[Number, ...]
    platform: tuple[Vector, ...]
    base: tuple[Vector, ...]
    near_joint: Number | None

    def __init__(
        self,
        diameters: Real | Sequence[Real],
        platform: Sequence[Components] = (),
        base: Sequence[Components] = (),
        near_joint: Real | None = None,
    ) -> None:
        several = isinstance(diameters, Sequence) and not isinstance(diameters, str)
        given: Sequence[Real] = diameters if several else [diameters]  # type: ignore[assignment,list-item]
        exact_diameters = tuple(
            _exact(one, f"diameters[{k}]" if several else "diameters")
            for k, one in enumerate(given)
        )
        object.__setattr__(self, "diameters", exact_diameters)
        for name, points in (("platform", platform), ("base", base)):
            exact = tuple(exact_vector(one, f"{name}[{k}]") for k, one in enumerate(points))
            object.__setattr__(self, name, exact)
        near = None if near_joint is None else _exact(near_joint, "near_joint")
        object.__setattr__(self, "near_joint", near)


def _exact(value: Real, where: str) -> Number:
    try:
        return Number.of(value)
    except ArgumentError as error:
        raise error.within(where) from None


#: Most points of a hull: all of them are compared at each pose.
MOST_POINTS = 1000


def refuse_mistakes(shapes: Shapes, rows: Sequence[Constraint]) -> None:
    """Raise `ArgumentError` if something is wrong with shapes for some constraints."""
    for place, message in mistakes(shapes, rows):
        parts = [f"[{part}]" if isinstance(part, int) else f".{part}" for part in place]
        raise ArgumentError(message, "".join(["shapes", *parts]).replace("diameter", "diameters"))


def mistakes(
    shapes: Shapes, rows: Sequence[Constraint]
) -> Iterator[tuple[tuple[str | int, ...], str]]:
    """Yield what is wrong with shapes: the keys of the place in a file, and a sentence."""
    legs = sum(row.kind is DPP for row in rows)
    if not legs:
        yield (), "found shapes, but no distance of two points: only legs have a diameter"
        return
    count = len(shapes.diameters)
    if count not in (1, legs):
        each = f"{legs}, one for each leg," if legs > 1 else "one"
        yield ("diameter",), f"found {count} diameters, expected {each} or one for all"
    for k, one in enumerate(shapes.diameters):
        if one.value < 0:
            place: tuple[str | int, ...] = ("diameter", k) if count > 1 else ("diameter",)
            yield place, f"found {one}, expected a diameter of at least 0"
    if shapes.near_joint is not None and shapes.near_joint.value < 0:
        yield ("near_joint",), f"found {shapes.near_joint}, expected a length of at least 0"
    for name in ("platform", "base"):
        points: tuple[Vector, ...] = getattr(shapes, name)
        if points and shapes.near_joint is None:
            message = (
                f"found the hull of the {name} without near_joint, expected both: legs meet it"
            )
            yield (name,), message
        if len(points) > MOST_POINTS:
            yield (name,), f"found {len(points)} points, expected at most {MOST_POINTS}"
