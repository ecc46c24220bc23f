"""Proved enclosures of a pose when its drives move: cranks and slides beside values.

As `gspcli.motion.singularities.enclosures`. Of a constraint with a crank or a slide the quadric
moves, and its value does not: when its drive has moved by t,

    H(t) = H + H' sin t + H'' (1 - cos t)   of a crank,   H + H' t + H'' t^2 / 2   of a slide

with constant matrices, so that |t| <= d changes a value of the quadric by at most
``|F'| d + |F''| d^2 / 2``, and its derivatives in the same way. The equation depends on its own
drive only. The gain of the drive is proportional to ``z . H'(t) z``. The drive keeps its knee if
that keeps its sign for all numbers in the box and all z near the pose, within the bound of where
the solutions are.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.branches.moved_quadrics import moved_quadric
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.drives import Drives
from gspcli.motion.following.branch_follower import MovingPlatform, apart
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.motion.singularities.enclosures import Box, Neighbourhood, Norm

Array = NDArray[np.float64]

_OUTWARD = 1 + 2.0**-30
#: A bound of the rounding of the gain, relative to the sizes of its terms.
_ROUNDING = 2.0**-40


class DrivenNeighbourhood(Neighbourhood):
    """The equations near one pose, with the drives that its poses have.

    Parameters
    ----------
    drives
        The drives.
    R, T
        The pose, shapes (3, 3) and (3,).
    q
        The numbers of the drives there, shape (m,).
    """

    def __init__(self, drives: Drives, R: Array, T: Array, q: Array) -> None:
        placed = apart(drives.instance_at(q))
        platform = MovingPlatform(placed)
        self.driven = drives.driven
        cranks = np.array([drives.sorts[k] == "crank" for k in drives.index])
        self._cranks = cranks & self.driven
        #: H' and H'' of the driven constraints, shapes (6, 8, 8); zero for the others.
        self.first, self.second = _derivatives(drives, platform, q)
        lengths = np.where(cranks, 1.0, 1 / platform.scale)
        #: Widths of the equations of widths of q: of slides in units of the scale.
        self._units = np.where(self.driven, lengths, _of_values(platform, drives))
        values = platform.internal(values_at(placed, R[None], T[None]))
        super().__init__(platform, platform.points(R[None], T[None]), values)
        self._pull = np.einsum("kij,nj->nki", self.first, self.points)
        self._bend = np.einsum("kij,nj->nki", self.second, self.points)
        self._rates = np.einsum("nki,ni->nk", self._pull, self.points) / 2
        self._bends = np.einsum("nki,ni->nk", self._bend, self.points) / 2

    @cached_property
    def _sizes(self) -> tuple[Array, Array]:
        """The spectral norms of H' and H'', shape (6,) each."""
        first, second = (
            np.abs(np.linalg.eigvalsh(part)).max(axis=1) for part in (self.first, self.second)
        )
        return first * _OUTWARD + _ROUNDING, second * _OUTWARD + _ROUNDING

    def widths(self, widths: Array) -> Array:
        """Return widths of the equations for widths of q by constraint, shape (6,)."""
        return widths * self._units

    @property
    def plain(self) -> NDArray[np.bool_]:
        """Which constraints change by c N only, shape (6,)."""
        return super().plain & ~self.driven

    def _changes(self, widths: Array) -> tuple[Array, Array]:
        first, whole = super()._changes(widths)
        # As changes of c, which the factors N turn into those of the equations.
        moved = np.abs(self._rates) * widths / self.factors
        bent = np.abs(self._bends) * widths**2 / 2 / self.factors
        return np.where(self.driven, moved, first), np.where(self.driven, moved + bent, whole)

    def _gradients(self, norm: Norm, whole: Array, widths: Array) -> Array:
        others = super()._gradients(norm, whole, widths)
        moved = norm.slopes(self._pull) * widths + norm.slopes(self._bend) * widths**2 / 2
        # At a dead point, where the residual does not change, there is no proof: NaN.
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(self.driven, moved / whole, others)

    def _spread(self, whole: Array, largest: Array, reach: float, widths: Array) -> Array:
        found = super()._spread(whole, largest, reach, widths)
        first, second = self._sizes
        moved = first * widths + second * widths**2 / 2
        rounding = 2.0**-40 * (1 + self.platform.equations.moduli.sum(axis=1) ** 2 + 8 * largest)
        found[:, 1:] = np.where(self.driven, moved + rounding, found[:, 1:])
        return found

    def keeps_knees(self, widths: Array, box: Box) -> NDArray[np.bool_]:
        """Return whether it is proved that all drives keep their knees in a box, shape (1,).

        Parameters
        ----------
        widths
            Of the equations, shape (1, 6).
        box
            What `box` returns for them.
        """
        first, second = self._sizes
        radius, rest = box.radius[:, None], box.rest[:, None]
        shifts = np.abs(np.einsum("nki,nji->nkj", self._pull, box.shifts)).sum(axis=2)
        pull = np.linalg.norm(self._pull, axis=2)
        turned = np.where(self._cranks, np.abs(self._rates) * widths**2 / 2, 0.0)
        rounding = _ROUNDING * (first + second * widths + self.platform.equations.moduli[:, 0])
        # A radius is infinite where the box is not proved.
        with np.errstate(invalid="ignore"):
            moved = shifts + pull * rest + first * radius**2 / 2
            bent = np.abs(self._bends) + np.linalg.norm(self._bend, axis=2) * radius
            bent = bent + second * radius**2 / 2
            most = (moved + bent * widths + turned) * _OUTWARD + rounding
            kept = (np.abs(self._rates) > most) | ~self.driven
        return np.asarray(kept.all(axis=1) & (box.measure < 1))


def _of_values(platform: MovingPlatform, drives: Drives) -> Array:
    """Return the internal widths of widths of driven values, lengths and radians, shape (6,)."""
    units = drives.units[drives.index]
    return platform.internal(np.ones(6)) / units


def _derivatives(drives: Drives, platform: MovingPlatform, q: Array) -> tuple[Array, Array]:
    """Return the first and second derivatives of the quadrics by the numbers of their drives."""
    first, second = np.zeros((2, 6, 8, 8))
    scale = platform.scale
    near = Arrangement.of(platform.local_frames.applied(platform.instance))
    velocity, bend = drives.velocities(q), drives.bends(q)
    for k in np.flatnonzero(drives.driven).tolist():
        y, x = near.y[k] / scale, near.x[k] / scale
        crank = drives.sorts[drives.index[k]] == "crank"
        unit = 1 / scale if crank else 1.0
        v, w = velocity[k] * unit, bend[k] * unit
        on = bool(drives.on_platform[k])
        moving, other = (y, x) if on else (x, y)
        first[k] = moved_quadric(v, other, float(moving @ v), on_platform=on)
        second[k] = moved_quadric(w, other, float(moving @ w + v @ v), on_platform=on)
    return first, second
