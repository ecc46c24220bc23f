"""Enclosures of functions of the time and of their derivatives, on short intervals.

A ball is a number with a radius: all numbers that are at most so far away. A series is a function
about the middle of an interval, by balls of its Taylor coefficients. If the first coefficient of
the time itself is a ball with the half width of the interval, the balls contain the coefficients at
all times of the interval. Rounding errors are part of the radii.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: A bound of the relative rounding error of an operation and of the radius that follows it.
_ROUNDING = 2.0**-51
_OUTWARD = 1 + 2.0**-45


class Ball:
    """Numbers that are at most a radius away from a middle; arrays of the same shape."""

    __slots__ = ("mid", "rad")

    def __init__(self, mid: Array, rad: Array | None = None) -> None:
        self.mid = mid
        self.rad: Array = np.zeros_like(mid) if rad is None else rad

    @staticmethod
    def _rounded(mid: Array, rad: Array) -> Ball:
        return Ball(mid, rad * _OUTWARD + _ROUNDING * np.abs(mid))

    @property
    def most(self) -> Array:
        """The largest modulus."""
        return np.asarray((np.abs(self.mid) + self.rad) * _OUTWARD)

    @property
    def ends(self) -> tuple[Array, Array]:
        """The least and the largest number."""
        room = self.rad * _OUTWARD + _ROUNDING * np.abs(self.mid)
        return self.mid - room, self.mid + room

    @classmethod
    def between(cls, low: Array, high: Array) -> Ball:
        """Return the ball of an interval whose ends may be rounded."""
        mid = (low + high) / 2
        size = np.maximum(np.abs(low), np.abs(high))
        return cls._rounded(mid, (high - low) / 2 + 2 * _ROUNDING * size)

    def __add__(self, other: Ball) -> Ball:
        return self._rounded(self.mid + other.mid, self.rad + other.rad)

    def __sub__(self, other: Ball) -> Ball:
        return self._rounded(self.mid - other.mid, self.rad + other.rad)

    def __mul__(self, other: Ball) -> Ball:
        rad = np.abs(self.mid) * other.rad + self.rad * (np.abs(other.mid) + other.rad)
        return self._rounded(self.mid * other.mid, rad)

    def times(self, factor: Array | float) -> Ball:
        """Return the product with exact numbers."""
        return self._rounded(self.mid * factor, self.rad * np.abs(factor))

    def over(self, other: Ball) -> Ball:
        """Return the quotient; infinite radii where the divisor may be zero."""
        least = np.abs(other.mid) - other.rad * _OUTWARD
        good = least > 0
        mid = np.where(good, self.mid / np.where(good, other.mid, 1.0), 0.0)
        # a / b - m / n = (a - m) / b + m (n - b) / (n b)
        room = (self.rad + np.abs(mid) * other.rad) / np.where(good, least, 1.0)
        return self._rounded(mid, np.where(good, room, np.inf))

    def sqrt(self) -> Ball:
        """Return the square root; infinite radii where the number may be negative."""
        low, high = self.ends
        good = low >= 0
        ends = (np.sqrt(np.where(good, end, 0.0)) for end in (low, high))
        found = Ball.between(*ends)
        return Ball(found.mid, np.where(good, found.rad, np.inf))

    def cos(self) -> Ball:
        """Return the cosine."""
        return self._rounded(np.cos(self.mid), np.minimum(self.rad, 2.0) + 2 * _ROUNDING)

    def sin(self) -> Ball:
        """Return the sine."""
        return self._rounded(np.sin(self.mid), np.minimum(self.rad, 2.0) + 2 * _ROUNDING)

    def take(self, *index: object) -> Ball:
        """Return a part of the arrays."""
        return Ball(self.mid[index], self.rad[index])  # type: ignore[index]


class Series:
    """A function by the balls of its Taylor coefficients, that of order k at place k."""

    __slots__ = ("balls",)

    def __init__(self, balls: Sequence[Ball]) -> None:
        self.balls = tuple(balls)

    @classmethod
    def constant(cls, value: Array, order: int) -> Series:
        """Return a function that does not depend on the time, up to an order."""
        zero = Ball(np.zeros_like(value))
        return cls((Ball(value), *(zero for _ in range(order))))

    @classmethod
    def of_motion(cls, place: Array, velocity: Array, acceleration: Array, half: Array) -> Series:
        """Return the motion with a constant acceleration on intervals, up to the third order.

        Parameters
        ----------
        place, velocity
            In the middle of each interval, shape (n, d).
        acceleration
            Shape (n, d).
        half
            Half the widths of the intervals, shape (n,).
        """
        time = Ball(np.zeros_like(place), half[:, None] + np.zeros_like(place))
        v, a = Ball(velocity), Ball(acceleration)
        c0 = Ball(place) + v * time + (a * time * time).times(0.5)
        return cls((c0, v + a * time, a.times(0.5), Ball(np.zeros_like(place))))

    def __add__(self, other: Series) -> Series:
        return Series([a + b for a, b in zip(self.balls, other.balls, strict=True)])

    def __sub__(self, other: Series) -> Series:
        return Series([a - b for a, b in zip(self.balls, other.balls, strict=True)])

    def __mul__(self, other: Series) -> Series:
        found = []
        for k in range(len(self.balls)):
            total = self.balls[0] * other.balls[k]
            for i in range(1, k + 1):
                total = total + self.balls[i] * other.balls[k - i]
            found.append(total)
        return Series(found)

    def times(self, factor: Array | float) -> Series:
        """Return the product with exact numbers."""
        return Series([ball.times(factor) for ball in self.balls])

    def over(self, other: Series) -> Series:
        """Return the quotient."""
        found: list[Ball] = []
        for k in range(len(self.balls)):
            rest = self.balls[k]
            for i in range(k):
                rest = rest - found[i] * other.balls[k - i]
            found.append(rest.over(other.balls[0]))
        return Series(found)

    def sqrt(self) -> Series:
        """Return the square root."""
        found = [self.balls[0].sqrt()]
        for k in range(1, len(self.balls)):
            rest = self.balls[k]
            for i in range(1, k):
                rest = rest - found[i] * found[k - i]
            found.append(rest.over(found[0].times(2.0)))
        return Series(found)

    def cos_sin(self) -> tuple[Series, Series]:
        """Return cosine and sine."""
        cos, sin = [self.balls[0].cos()], [self.balls[0].sin()]
        for k in range(1, len(self.balls)):
            down = up = None
            for j in range(1, k + 1):
                step = self.balls[j].times(j / k)
                c, s = step * cos[k - j], step * sin[k - j]
                up, down = (c, s) if up is None or down is None else (up + c, down + s)
            assert up is not None
            assert down is not None
            cos.append(down.times(-1.0))
            sin.append(up)
        return Series(cos), Series(sin)

    def derivative(self) -> Series:
        """Return the derivative, of one order less."""
        return Series([ball.times(float(k)) for k, ball in enumerate(self.balls) if k])

    def shortened(self) -> Series:
        """Return the series without its last coefficient."""
        return Series(self.balls[:-1])

    def take(self, *index: object) -> Series:
        """Return a part of the arrays."""
        return Series([ball.take(*index) for ball in self.balls])


Vector = tuple[Series, Series, Series]


def dot(a: Vector, b: Vector) -> Series:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def norm(a: Vector) -> Series:
    """Return the length."""
    return dot(a, a).sqrt()


def difference(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def angle_rate(x: Series, y: Series) -> Series:
    """Return the derivative of the angle of the vector (x, y), of one order less."""
    size = (x * x + y * y).shortened()
    turned = x.shortened() * y.derivative() - y.shortened() * x.derivative()
    return turned.over(size)
