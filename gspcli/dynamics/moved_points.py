r"""The points of rods that cranks and slides move, and how fast, at poses.

Let r be the vector from the base's point to the platform's, l = |r| the length of the rod, and q
the number of the drive. The rod keeps its length: ``r . r' = 0``. The platform moves r with a
velocity v while the drives are still, so r' = v + ``(dr/dq) q'``. Hence q' = f . v / g with f = r /
l and the gain g = -f . dr/dq. The second derivative follows in the same way. Everything is in
metres and radians.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.dynamics.arrays import RowError, checked_array
from gspcli.dynamics.mass_model import MassModel
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import cross, dot

Array = NDArray[np.float64]
Knees = NDArray[np.int64]

#: The square of a gain is a difference of squared lengths: four sums and products of coordinates,
#: and their squares, are wrong by at most so many units of the sum of the lengths, squared.
_ROUNDING = 16 * np.finfo(float).eps
#: Lengths of rods are those of the instance up to this part of the size.
_SAME = 1e-6


def given_numbers(model: MassModel, R: Array, T: Array, given: ArrayLike | None) -> Array | None:
    """Return the numbers of the drives at poses in metres, as `driven_numbers`.

    Parameters
    ----------
    model, R, T
        The platform, and poses in metres, shapes (n, 3, 3) and (n, 3).
    given
        The readings of the drives, (n, m) or (m,); None for the numbers on the knees of home.

    Raises
    ------
    ArgumentError
        If a rod has another length with its drive at such a number.
    RowError
        As `driven_numbers`.
    """
    drives = model.drives
    if given is None:
        return driven_numbers(model, R, T)
    count = model.drive_count
    array = checked_array(given, (len(T), count), "drives")
    if drives is None:
        return None
    found = drives.from_readings(array)[..., drives.index] * model.drive_metres
    numbers: Array = np.where(drives.driven, found, 0.0)
    points = MovedPoints(model, R, T, numbers)
    rods = np.where(drives.driven, model.bodies.values, points.length)
    wrong = np.abs(points.length - rods) > _SAME * model.bodies.length
    if wrong.any():
        row, k = np.argwhere(wrong)[0].tolist()
        name = drives.names[drives.index[k]]
        message = f"with {name} so rod {k + 1} has another length, expected numbers of this pose"
        raise RowError(row, message)
    return numbers


def driven_numbers(
    model: MassModel, R: Array, T: Array, knees: Knees | None = None
) -> Array | None:
    """Return the numbers of the drives at poses in metres, (n, 6): a constraint's own.

    They are radians and metres, zero for a value that is its own drive; None if all are.

    Raises
    ------
    RowError
        If a drive does not reach a pose, or rods of one drive ask for different numbers.
    """
    drives = model.drives
    if drives is None:
        return None
    found = drives.inverse(R, T / model.metre, knees)
    lost = np.isnan(found)
    if lost.any():
        row, drive = np.argwhere(np.atleast_2d(lost))[0].tolist()
        rods = " and ".join(str(k + 1) for k in np.flatnonzero(drives.index == drive).tolist())
        what = f"the rod {rods} is" if len(rods) == 1 else f"the rods {rods} are"
        message = f"{drives.names[drive]} does not reach this pose: {what} too long or too short"
        raise RowError(row, message)
    numbers: Array = np.where(drives.driven, found[..., drives.index], 0.0)
    return numbers * model.drive_metres


class DriveMotion(NamedTuple):
    """How the driven numbers change: zero for values."""

    rates: Array
    """Shape (..., 6), as both."""
    second_rates: Array


class MovedPoints:
    """The driven points at poses, shapes (..., 3, 3) and (..., 3), and at numbers (..., 6).

    Attributes
    ----------
    ends
        The points of the platform relative to its origin, ``R p``, shape (..., 6, 3).
    along
        From the points of the base to those of the platform, shape (..., 6, 3).
    ways, bends
        How ``along`` changes with the drive, and the second derivative; zero for values.
    gains
        Shape (..., 6): 1 for values.

    Raises
    ------
    RowError
        If a drive is at a dead point.
    """

    def __init__(self, model: MassModel, R: Array, T: Array, numbers: Array) -> None:
        drives = model.drives
        assert drives is not None
        self.model, self.drives = model, drives
        self.numbers = numbers
        points = self._points(np.cos(numbers), np.sin(numbers), numbers)
        turned = np.swapaxes(R, -1, -2)
        on_platform = drives.on_platform[:, None]
        base = ~drives.on_platform & drives.driven
        self.x = np.where(base[:, None], points[0], model.bodies.x)
        self.y = np.where(on_platform, points[0], model.bodies.y)
        self.ends = self.y @ turned
        self.along = self.ends + T[..., None, :] - self.x
        self.ways, self.bends = (
            np.where(on_platform, part @ turned, -part) for part in (points[1], points[2])
        )
        self.length = _norm(self.along)
        self.f = self.along / self.length[..., None]
        self.gains = np.where(drives.driven, -dot(self.f, self.ways), 1.0)
        self._check()

    def _points(self, cosine: Array, sine: Array, numbers: Array) -> tuple[Array, Array, Array]:
        """Return the driven points in the frames of their bodies with two derivatives."""
        drives, metre = self.drives, self.model.metre
        turns = self.model.turns
        across = drives.across * metre
        # The direction of a slide has no unit: its number is a length.
        beside = drives.beside * np.where(turns, metre, 1.0)[:, None]
        c, s = cosine[..., None], sine[..., None]
        middles = drives.middle * metre
        crank = turns[:, None]
        moved = np.where(crank, across * c + beside * s, beside * numbers[..., None])
        first = np.where(crank, beside * c - across * s, beside)
        second = np.where(crank, -moved, 0.0)
        still = drives.driven[:, None]
        return middles + moved, np.where(still, first, 0.0), np.where(still, second, 0.0)

    def _check(self) -> None:
        """Raise where a gain is zero up to the root of its rounding error.

        The gain times l is the root of a number D: for a slide D is a difference of squared
        lengths; for a crank with arm a it is a d times one, where d <= a + l is the distance of its
        centre from the other end of the rod. Where D is zero the gain has the root of its error.
        """
        drives = self.drives
        size = _norm(self.ends) + _norm(self.x) + self.length
        arms = drives.arms * self.model.metre
        reach = np.where(self.model.turns, np.sqrt(arms * (arms + self.length)), 1.0)
        lost = np.sqrt(_ROUNDING) * reach * size / self.length
        dead = drives.driven & ~(np.abs(self.gains) > lost)
        if dead.any():
            row, *_, k = np.argwhere(np.atleast_2d(dead))[0].tolist()
            name = drives.names[drives.index[k]]
            message = f"{name} is at a dead point: it cannot move the rod of constraint {k + 1}"
            raise RowError(row, message)

    @property
    def bodies(self) -> Arrangement:
        """The primitives with the driven points where they are."""
        return replace(self.model.bodies, x=self.x, y=self.y)

    def motion(self, twists: Array, accelerations: Array) -> DriveMotion:
        """Return how the driven numbers change as the platform moves so, each (..., 6)."""
        t, a = twists[..., None, :], accelerations[..., None, :]
        omega, driven = t[..., :3], self.drives.driven
        turned = cross(omega, self.ends)
        moving = turned + t[..., 3:]
        rates: Array = np.where(driven, dot(self.f, moving) / self.gains, 0.0)
        q = rates[..., None]
        way = self.ways * q
        change = moving + way
        rate = cross(a[..., :3], self.ends) + a[..., 3:] + cross(omega, turned)
        rate = rate + self.bends * q * q
        if self.drives.on_platform.any():
            own = self.drives.on_platform[:, None]
            rate = rate + np.where(own, 2 * cross(omega, way), 0.0)
        needed = dot(change, change) / self.length + dot(self.f, rate)
        return DriveMotion(rates, np.where(driven, needed / self.gains, 0.0))


def _norm(vectors: Array) -> Array:
    lengths: Array = np.sqrt(dot(vectors, vectors))
    return lengths
