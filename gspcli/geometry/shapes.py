"""The shapes of legs and bodies, as an instance file states them under `shapes`.

A leg is a distance of two points. Its shape is a cylinder with round ends, about the straight line
between its joints. That of a body is the convex hull of points that are fixed in it. The arm of a
crank has a diameter at its point (`gspcli.geometry.primitives.Crank`). Nothing else has a shape: no
motor, no joint. Lengths are in the unit of length.
"""

from __future__ import annotations

from collections.abc import Sequence

from gspcli.errors import ArgumentError
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
