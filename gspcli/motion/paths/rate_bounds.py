"""Bounds of the speeds and accelerations of motors while position and angles move.

The parameters of a pose move with a constant acceleration. What the motors do follows by Taylor
series in ball arithmetic (`series`), on short intervals of the time that cover the whole way. So
the bounds hold between all samples, too. A motor is a value, or a crank or slide where the machine
has one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.drives import Drives
from gspcli.geometry.instance import Instance
from gspcli.motion.paths.series import (
    Series,
    Vector,
    angle_rate,
    cross,
    difference,
    dot,
    norm,
)

Array = NDArray[np.float64]

#: Intervals that a way is divided into at first, and at most.
_INTERVALS, _MOST = 48, 48 * 8**2
#: The order of Taylor series: bounds need the third derivative.
_ORDER = 3


class Rates:
    """What moves while the parameters of a platform do.

    Parameters
    ----------
    instance
        The platform.
    pivot
        The point of the platform whose position is a parameter, shape (3,).
    sequence
        The order of the axes of the angles that are the other three.
    drives
        The cranks and slides with their knees, shape (6,), if the platform has some.
    """

    def __init__(
        self,
        instance: Instance,
        pivot: Array,
        sequence: str,
        drives: tuple[Drives, NDArray[np.int64]] | None = None,
    ) -> None:
        self.instance, self.pivot, self.drives = instance, pivot, drives
        self._arrangement = Arrangement.of(instance)
        letters = sequence if sequence.isupper() else sequence[::-1]
        self._axes = ["xyz".index(letter) for letter in letters.lower()]

    @property
    def count(self) -> int:
        """The number of motors, m."""
        return len(self._arrangement.kinds) if self.drives is None else self.drives[0].count

    def bounds(
        self, place: Array, velocity: Array, acceleration: Array, duration: float
    ) -> tuple[Array, Array]:
        """Bound speeds and accelerations on one move of the parameters.

        Parameters
        ----------
        place, velocity, acceleration
            At its beginning, shape (6,) each; the acceleration is constant.
        duration
            Of the move.

        Returns
        -------
        speeds, accelerations
            Of the m motors in the units of the instance, of the pivot, and of the turn of the
            platform in radians, shapes (m + 2,). Infinite where nothing is proved.
        """
        number = _INTERVALS
        while True:
            speeds, bends = self._on_intervals(place, velocity, acceleration, duration, number)
            if np.isfinite([*speeds, *bends]).all() or number >= _MOST:
                return speeds, bends
            number *= 8

    def _on_intervals(
        self, place: Array, velocity: Array, acceleration: Array, duration: float, number: int
    ) -> tuple[Array, Array]:
        """Return the same from this many intervals."""
        width = duration / number
        times = (np.arange(number) + 0.5)[:, None] * width
        middle = place + velocity * times + acceleration * times**2 / 2
        speed = velocity + acceleration * times
        bend = np.broadcast_to(acceleration, speed.shape)
        # The middles are rounded: the intervals overlap.
        half = np.full(number, width / 2 * (1 + 1e-9))
        at = self._rates(Series.of_motion(middle, speed, bend, 0 * half))
        over = self._rates(Series.of_motion(middle, speed, bend, half))
        found = []
        for k in range(2):
            first = at[k] + half[:, None] * over[k + 1]
            both = [np.where(np.isnan(one), np.inf, one) for one in (first, over[k])]
            found.append(np.minimum(*both).max(axis=0))
        return found[0], found[1]

    def _rates(self, motion: Series) -> list[Array]:
        """Bound the first three derivatives of what moves, shapes (n, m + 2)."""
        with np.errstate(all="ignore"):
            p: Vector = tuple(motion.take(slice(None), k) for k in range(3))  # type: ignore[assignment]
            angles = [motion.take(slice(None), k) for k in range(3, 6)]
            R, spin = self._turned(angles)
            rates = [*self._motors(p, R)]
            columns = [[one.balls[k].most * (1, 1, 2)[k] for one in rates] for k in range(3)]
            for vector in ([one.derivative() for one in p], spin):
                for k in range(3):
                    most = [one.balls[k].most for one in vector]
                    size = np.sqrt(sum(x**2 for x in most)) * (1, 1, 2)[k]
                    columns[k].append(size * (1 + 1e-12))
        return [np.stack(column, axis=1) for column in columns]

    def _turned(self, angles: list[Series]) -> tuple[list[Vector], list[Series]]:
        """Return the rows of R, and the angular velocity."""
        zero = Series.constant(np.zeros(angles[0].balls[0].mid.shape), _ORDER)
        one = Series.constant(np.ones(angles[0].balls[0].mid.shape), _ORDER)
        # R by its columns; each turn about an axis of the moving frame mixes two of them.
        columns = [[one if i == j else zero for i in range(3)] for j in range(3)]
        spin = [zero.shortened()] * 3
        for axis in self._axes:
            rate = angles[axis].derivative()
            spin = [s + columns[axis][i].shortened() * rate for i, s in enumerate(spin)]
            cos, sin = angles[axis].cos_sin()
            j, k = (axis + 1) % 3, (axis + 2) % 3
            first = [cos * a + sin * b for a, b in zip(columns[j], columns[k], strict=True)]
            second = [cos * b - sin * a for a, b in zip(columns[j], columns[k], strict=True)]
            columns[j], columns[k] = first, second
        return [(columns[0][i], columns[1][i], columns[2][i]) for i in range(3)], spin

    def _motors(self, p: Vector, R: list[Vector]) -> list[Series]:
        """Return the derivatives of the motors, of one order less."""
        if self.drives is None:
            return [self._of_value(k, p, R) for k in range(len(self._arrangement.kinds))]
        drives, knees = self.drives
        found = []
        for drive in range(drives.count):
            k = drives.users(drive)[0]
            if drives.driven[k]:
                one = self._of_drive(drives, k, int(knees[k]), p, R)
                found.append(one.times(1 / float(drives.units[drive])))
            else:
                found.append(self._of_value(k, p, R))
        return found

    def _of_value(self, k: int, p: Vector, R: list[Vector]) -> Series:
        a = self._arrangement
        kind = a.kinds[k]
        w, v = _applied(R, a.u[k]), _fixed(a.v[k], p)
        if not kind.is_distance:
            sine = norm(cross(w, v)).shortened()
            return dot(w, v).derivative().over(sine).times(1 / a.in_radians)
        arm = _applied(R, a.y[k] - self.pivot)
        r = difference(_sum(p, arm), _fixed(a.x[k], p))
        return _distance(kind, r, w, v).derivative()

    def _of_drive(self, drives: Drives, k: int, knee: int, p: Vector, R: list[Vector]) -> Series:
        """Return the derivative of the angle of a crank or the place of a slide."""
        a = self._arrangement
        if drives.on_platform[k]:
            away = difference(_fixed(a.x[k], p), p)
            turned: Vector = tuple(  # type: ignore[assignment]
                R[0][j] * away[0] + R[1][j] * away[1] + R[2][j] * away[2] for j in range(3)
            )
            other = _sum(turned, _fixed(self.pivot, p))
        else:
            other = _sum(p, _applied(R, a.y[k] - self.pivot))
        w = difference(other, _fixed(drives.middle[k], p))
        rod = float(drives.rods[k])
        along, beside = _along(w, drives.across[k]), _along(w, drives.beside[k])
        if drives.sorts[drives.index[k]] == "slide":
            room = _fixed_one(rod**2, p) + beside * beside - dot(w, w)
            return beside.derivative() - room.sqrt().derivative().times(float(knee))
        far = (along * along + beside * beside).sqrt()
        size = dot(w, w) + _fixed_one(float(drives.arms[k]) ** 2 - rod**2, p)
        cosine = size.over(far).times(0.5)
        one = _fixed_one(1.0, p)
        sine = (one - cosine * cosine).sqrt().shortened()
        bent = cosine.derivative().over(sine)
        # The derivative of an arc cosine is negative; a positive gain is at the lesser angle.
        return angle_rate(along, beside) + bent.times(float(knee))


def _distance(kind: Kind, r: Vector, w: Vector, v: Vector) -> Series:
    """Return the distance of a kind, up to its sign."""
    if kind is DPP:
        return norm(r)
    if kind is DPL:
        return norm(cross(r, v))
    if kind is DLP:
        return norm(cross(r, w))
    if kind is DPH:
        return dot(r, v)
    if kind is DHP:
        return dot(r, w)
    assert kind is DLL
    normal = cross(w, v)
    return dot(r, normal).over(norm(normal))


def _fixed_one(value: float, like: Vector) -> Series:
    return Series.constant(np.full(like[0].balls[0].mid.shape, value), len(like[0].balls) - 1)


def _fixed(vector: Array, like: Vector) -> Vector:
    x, y, z = (_fixed_one(float(one), like) for one in vector)
    return x, y, z


def _sum(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _along(w: Vector, direction: Array) -> Series:
    x, y, z = (w[k].times(float(direction[k])) for k in range(3))
    return x + y + z


def _applied(R: list[Vector], vector: Array) -> Vector:
    x, y, z = (_along(row, vector) for row in R)
    return x, y, z
