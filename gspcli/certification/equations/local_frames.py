"""Frames with origins near the bodies of a platform, in which it is certified.

An instance may state its coordinates in the frame of a workshop, thousands of lengths away. Then T
has that size, and so have rounding and tolerances relative to it. The platform with an origin
subtracted from its coordinates is exactly the same problem.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.numbers.doubled import two_product, two_sum
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Array, Constraint, Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, Vector, vector
from gspcli.records import dataclass

if TYPE_CHECKING:
    from flint import acb


#: Real or complex.
Floats = NDArray[Any]

#: Frames are moved if an origin is farther away than this many sizes of the platform.
FAR = 8
#: The least length that distinguishes poses, as a part of the scale.
_LEAST = 2.0**-20
_BODIES = ("platform", "base")
#: Bits with which the translation of a pose in doubles is exact in other frames.
_EXACT = 4096


def length_scale(instance: Instance, distances: Iterable[float] | None = None) -> float:
    """Return a power of two next above the largest length in an instance, 1 if all vanish.

    Parameters
    ----------
    instance
        The instance.
    distances
        Distances that replace those of the instance.
    """
    if distances is None:
        distances = (c.value.value for c in instance.constraints if c.kind.is_distance)
    size = max([reach(instance), *map(abs, distances)])
    return 2.0 ** math.frexp(size)[1] if 0 < size < math.inf else 1.0


def length_scales(instance: Instance, distances: Array) -> Array:
    """Return `length_scale` for each of many sets of distances (b, k), shape (b,)."""
    sizes = np.maximum(reach(instance), np.abs(distances).max(axis=1, initial=0))
    known = (sizes > 0) & (sizes < math.inf)
    return np.asarray(np.where(known, np.exp2(np.frexp(np.where(known, sizes, 1.0))[1]), 1.0))


def least_length(instance: Instance) -> float:
    """Return the power of two below the size of the smaller body that is no point.

    A body of a millimetre in a hall of a kilometre is at another place if it moves by this length.
    The result is at least 2^-20 of the scale: with a tolerance of 1e-6 this is about the accuracy
    of doubles for the poses of such a platform.
    """
    rows = instance.constraints
    sizes = [max(high - low for low, high in _ranges(rows, body)) for body in _BODIES]
    scale = length_scale(instance)
    least = min((size for size in sizes if size > 0), default=scale)
    return max(2.0 ** (math.frexp(least)[1] - 1), _LEAST * scale) if least < math.inf else scale


def _ranges(rows: Sequence[Constraint], body: str) -> list[tuple[float, float]]:
    """Return the least and the largest of each coordinate of the primitives of a body."""
    points = [getattr(row, body).position for row in rows]
    columns = [[number.value for number in column] for column in zip(*points, strict=True)]
    return [(min(column), max(column)) for column in columns]


def reach(instance: Instance) -> float:
    """Return the largest coordinate of a point, without its sign."""
    coordinates = instance.coordinates
    return max(max(coordinates), -min(coordinates))


_NOWHERE = (Fraction(0),) * 3


@dataclass(frozen=True)
class LocalFrames:
    """The origins of the frames: ``T_centred = T + R platform - base``."""

    #: The origins in the frames of the instance, exact.
    platform: tuple[Fraction, Fraction, Fraction]
    base: tuple[Fraction, Fraction, Fraction]

    @classmethod
    def of(cls, instance: Instance, distances: Sequence[float] | None = None) -> LocalFrames:
        """Return origins near the primitives of both bodies; zero unless these are far away.

        Parameters
        ----------
        instance
            The instance.
        distances
            Distances that replace those of the instance, none negative.
        """
        if distances is None:
            distances = [abs(c.value.value) for c in instance.constraints if c.kind.is_distance]
        if reach(instance) <= FAR * max(distances):
            return _OF_THE_INSTANCE
        middles, extents = [], []
        for body in _BODIES:
            ends = _ranges(instance.constraints, body)
            middles.append([(low + high) / 2 for low, high in ends])
            extents += [high - low for low, high in ends]
        size = max(*distances, *extents)
        platform, base = (
            tuple(map(Fraction, middle)) if max(map(abs, middle)) > FAR * size else _NOWHERE
            for middle in middles
        )
        return cls(platform, base)  # type: ignore[arg-type]

    @cached_property
    def is_none(self) -> bool:
        """Whether the frames are those of the instance."""
        return not any(self.platform) and not any(self.base)

    def applied(self, instance: Instance) -> Instance:
        """Return the platform in these frames."""
        if self.is_none:
            return instance

        def moved(constraint: Constraint) -> Constraint:
            return replace(
                constraint,
                platform=_moved(constraint.platform, self.platform),
                base=_moved(constraint.base, self.base),
            )

        return replace(instance, constraints=tuple(map(moved, instance.constraints)))

    @staticmethod
    def none() -> LocalFrames:
        """Return the origins of the frames of the instance."""
        return _OF_THE_INSTANCE

    def translation(self, R: Sequence[Sequence[acb]], T: Sequence[acb]) -> list[acb]:
        """Return the translation of a pose in these frames, lengths in those of the instance.

        Exact numbers give exact results.
        """
        return self._shifted(R, T, 1)

    def back(self, R: Sequence[Sequence[acb]], T: Sequence[acb]) -> list[acb]:
        """Return the translation in the frames of the instance of a pose in these."""
        return self._shifted(R, T, -1)

    def doubles_back(self, R: Floats, T: Floats) -> Floats:
        """Return translations in the frames of the instance, next to the exact ones.

        They are as accurate as with twice the digits and one rounding (T. Ogita, S. M. Rump and
        S. Oishi, Accurate sum and dot product, SIAM Journal on Scientific Computing 26, 2005).

        Parameters
        ----------
        R, T
            Poses in these frames, real or complex, shapes (..., 3, 3) and (..., 3).
        """
        return self._doubles(R, T, -1)

    def doubles(self, R: Floats, T: Floats) -> Floats:
        """Return translations in these frames of poses in those of the instance, as above."""
        return self._doubles(R, T, 1)

    def _doubles(self, R: Floats, T: Floats, sign: int) -> Floats:
        if self.is_none:
            return T
        # Origins are doubles.
        platform, base = (sign * np.array(part, float) for part in (self.platform, self.base))

        def moved(rotations: Array, places: Array, base: Array) -> Array:
            with np.errstate(all="ignore"):
                products, rest = two_product(rotations, platform)
                total, low = two_sum(places, -base)
                low = low + rest.sum(axis=-1)
                for k in range(3):
                    total, lost = two_sum(total, products[..., k])
                    low = low + lost
            found: Array = total + low
            return found

        if not np.iscomplexobj(T):
            return moved(R, T, base)
        return moved(R.real, T.real, base) + 1j * moved(R.imag, T.imag, np.zeros(3))

    def _shifted(self, R: Sequence[Sequence[acb]], T: Sequence[acb], sign: int) -> list[acb]:
        if self.is_none:
            return list(T)
        from flint import acb, arb, ctx, fmpq

        with ctx.workprec(max(ctx.prec, _EXACT if sign > 0 else 0)):
            platform, base = (
                [arb(fmpq(sign * x.numerator, x.denominator)) for x in part]
                for part in (self.platform, self.base)
            )
            return [
                t + sum((r * y for r, y in zip(row, platform, strict=True)), acb(0)) - x
                for t, row, x in zip(T, R, base, strict=True)
            ]


_OF_THE_INSTANCE = LocalFrames(_NOWHERE, _NOWHERE)


def _moved(geometry: Geometry, origin: Sequence[Fraction]) -> Geometry:
    components = (x - Number.of(o) for x, o in zip(geometry.position, origin, strict=True))
    position: Vector = vector(*components)
    return replace(geometry, position=position)


@dataclass(frozen=True, kw_only=True, eq=False)
class StudyFrames:
    """Coordinates of Study points: ``T_instance = length T + base - R platform``."""

    #: The unit of length.
    length: float
    #: The origins in the frames of the instance, shape (3,).
    platform: Sequence[float] | NDArray[np.float64]
    base: Sequence[float] | NDArray[np.float64]

    @classmethod
    def of(cls, arrangement: Arrangement) -> StudyFrames:
        """Return the frames of the points of ``arrangement.normalized``."""
        return cls(
            length=arrangement.length,
            platform=arrangement.platform_centre,
            base=arrangement.base_centre,
        )


#: The frames of the instance.
OWN = StudyFrames(length=1.0, platform=(0.0, 0.0, 0.0), base=(0.0, 0.0, 0.0))
