"""What can be wrong with the shapes of legs and bodies, for files and for Python alike."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from gspcli.catalogue.kinds import DPP
from gspcli.errors import ArgumentError
from gspcli.geometry.instance import Constraint
from gspcli.geometry.primitives import Vector
from gspcli.geometry.shapes import Shapes

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
