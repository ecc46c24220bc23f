"""The numbers of a platform in the coordinates of paths, with many digits."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np
from flint import acb, arb, ctx
from numpy.typing import NDArray

from gspcli.certification.equations.frames import StudyFrames
from gspcli.certification.equations.local_frames import length_scale
from gspcli.certification.equations.statement import Statement, statements
from gspcli.certification.numbers.balls import norm
from gspcli.geometry.instance import Instance

#: Arrays of `flint.acb`.
Balls = NDArray[Any]

#: Bits of the numbers: 64 digits, and the digits that cancel.
_PRECISION = 320


class NormalizedNumbers(NamedTuple):
    """The numbers of the constraints, as in `geometry.arrangement.Arrangement`."""

    y: Balls
    """A point of each platform primitive, shape (6, 3)."""
    x: Balls
    """A point of each base primitive, shape (6, 3)."""
    u: Balls
    """The unit direction of each platform primitive, zero for points, shape (6, 3)."""
    v: Balls
    """The unit direction of each base primitive, zero for points, shape (6, 3)."""
    values: Balls
    """The distances without signs, and ``R u . v`` of the angles, shape (6,)."""


@contextmanager
def many_digits() -> Iterator[None]:
    """Set the precision of calculations with these numbers."""
    before = ctx.prec
    ctx.prec = _PRECISION
    try:
        yield
    finally:
        ctx.prec = before


def normalized(instance: Instance, frames: StudyFrames) -> NormalizedNumbers:
    """Return the numbers of an instance in other frames.

    Parameters
    ----------
    instance
        The exact instance.
    frames
        The coordinates; their own numbers are exact.
    """
    unit = arb(length_scale(instance)) / arb(frames.length)
    platform, base = (
        [arb(c) / arb(frames.length) for c in origin] for origin in (frames.platform, frames.base)
    )
    given = statements(instance)
    return NormalizedNumbers(
        _array([[c * unit - o for c, o in zip(row.a, platform, strict=True)] for row in given]),
        _array([[c * unit - o for c, o in zip(row.b, base, strict=True)] for row in given]),
        _array([_unit(row.u) for row in given]),
        _array([_unit(row.v) for row in given]),
        _array([_value(row, unit) for row in given]),
    )


def _unit(direction: list[arb]) -> list[arb]:
    return [c / norm(direction) for c in direction] or [arb(0)] * 3


def _value(row: Statement, unit: arb) -> arb:
    if row.is_zero and row.kind.is_distance:
        return arb(0)
    return row.value * unit if row.kind.is_distance else row.cosine


def _array(numbers: Any) -> Balls:
    given = np.array(numbers, object)
    return np.array([acb(c.mid()) for c in given.flat], object).reshape(given.shape)
