"""Distinct proved poses of one system: what each new approximation adds to those known already."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from flint import ctx
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.certification import study
from gspcli.certification.distinct import all_different, first_of_each, same
from gspcli.certification.floating import prove
from gspcli.certification.locating import (
    FIRST_PRECISION,
    LAST_PRECISION,
    AtInfinity,
    Located,
    Locator,
)
from gspcli.geometry.primitives import Line
from gspcli.geometry.quaternions import Field, cross, dot

Complex = NDArray[np.complex128]
Array = NDArray[np.float64]

#: Poses for which doubles prove only a larger bound of the error, relative to the largest entry of
#: R and T, are located with more digits. Bounds are a thousand times the errors and more.
_ACCURATE = 1e-6
#: Bound of the relative error of a located pose that has been rounded to doubles.
_ROUNDED = 2.0**-51
#: The square of the sine of two lines errs by less than this many relative errors of the pose.
_SINE = 100


class Collection:
    """Poses proved to be simple solutions, pairwise different, each proved to be real or not.

    Parameters
    ----------
    locator
        Of the instance.
    sides
        For each constraint the index of the equation of the system (`BallSystem.equations`).

    Attributes
    ----------
    R, T
        The poses, shapes (n, 3, 3) and (n, 3), complex; imaginary parts of real ones are zero.
    quaternions
        Of the rotations, with ``e.e = 1``, of either sign, shape (n, 4).
    real
        Which are real, shape (n,).
    """

    def __init__(self, locator: Locator, sides: tuple[int, ...]) -> None:
        self.locator = locator
        self.sides = sides
        self.R = np.zeros((0, 3, 3), complex)
        self.T = np.zeros((0, 3), complex)
        self.quaternions = np.zeros((0, 4), complex)
        self.real = np.zeros(0, np.bool_)
        self._deviations = np.zeros(0)
        self._located: list[Located | None] = []
        self._paired: set[int] = set()

    def __len__(self) -> int:
        """Return how many different solutions are proved."""
        return len(self._located)

    def add_doubles(self, R: Complex, T: Complex, quaternions: Complex) -> NDArray[np.bool_]:
        """Add what can be proved in floating point to an empty collection; return which.

        Parameters
        ----------
        R, T
            Approximate poses, shapes (n, 3, 3) and (n, 3).
        quaternions
            Of the rotations, with ``e.e = 1``, shape (n, 4).
        """
        if not len(R):
            return np.zeros(0, np.bool_)
        with ctx.workprec(FIRST_PRECISION):
            system = self.locator.system(FIRST_PRECISION)
            proofs = prove(system, R, T / system.scale, self.sides)
        proved = proofs.isolated & (proofs.real | proofs.complex)
        entries = _entries(R, T / system.scale)
        size = np.abs(entries).max(axis=1, initial=1)
        proved &= proofs.deviation <= _ACCURATE * size
        proved &= _not_parallel(self.locator, R, proofs.deviation)
        if not all_different(entries[proved], proofs.deviation[proved]):
            proved[proved] = first_of_each(entries[proved], proofs.deviation[proved])
        real = proofs.real[proved]
        self.R, self.T, self.quaternions = (
            _made_real(x[proved], real) for x in (R, T, quaternions)
        )
        self.real = real
        self._deviations = proofs.deviation[proved]
        self._located = [None] * len(real)
        return np.asarray(proved)

    def add(self, poses: Iterable[Located | AtInfinity | None]) -> int:
        """Add those located poses that are proved to be new; return how many."""
        return sum(self._add(pose) for pose in poses if isinstance(pose, Located))

    def add_conjugates(self) -> int:
        """Add the conjugates of located poses: the equations are real. Return how many are new."""
        before = len(self)
        for k, pose in enumerate(self._located[:before]):
            if pose is None or pose.real or k in self._paired:
                continue
            self._paired.add(k)
            if self._add(pose.conjugate):
                self._paired.add(len(self) - 1)
        return len(self) - before

    def _add(self, pose: Located) -> bool:
        scale = pose.scale
        deviation = _ROUNDED * np.abs(_entries(pose.R[None], pose.T[None] / scale)).max(initial=1)
        gaps = np.abs(
            _entries(self.R, self.T / scale) - _entries(pose.R[None], pose.T[None] / scale)
        ).max(axis=1, initial=0)
        for k in np.flatnonzero(gaps <= 2 * (self._deviations + deviation)).tolist():
            other = self._exactly(k)
            if other is None or not _different(other, pose):
                return False
        self.R = np.concatenate([self.R, pose.R[None]])
        self.T = np.concatenate([self.T, pose.T[None]])
        self.quaternions = np.concatenate([self.quaternions, pose.quaternion[None]])
        self.real = np.append(self.real, pose.real)
        self._deviations = np.append(self._deviations, deviation)
        self._located.append(pose)
        return True

    def _exactly(self, k: int) -> Located | None:
        """Return a pose with all its digits, if they can be had."""
        if self._located[k] is None:
            scale = self.locator.scale
            points, _ = study.study_points(self.R[k][None], self.T[k][None] / scale)
            with ctx.workprec(LAST_PRECISION):
                start = self.locator.exactly(points[0])
            found = self.locator.locate_exactly(start, self.sides)
            if isinstance(found, Located) and self._is_near(k, found):
                self._located[k] = found
        return self._located[k]

    def _is_near(self, k: int, pose: Located) -> bool:
        """Return whether a located pose lies where that of doubles is proved."""
        here = _entries(pose.R[None], pose.T[None] / pose.scale)
        gap = np.abs(_entries(self.R[k][None], self.T[k][None] / pose.scale) - here).max()
        error = _ROUNDED * np.abs(here).max(initial=1)
        return bool(gap + error <= self._deviations[k])


def _different(first: Located, second: Located) -> bool:
    """Whether two located poses are proved to be different."""
    if same(first.isolation, second.isolation):
        return False
    return not all(
        x.overlaps(y) for x, y in zip(first.pose.entries, second.pose.entries, strict=True)
    )


def _entries(R: Field, T: Field) -> Field:
    return np.concatenate((R.reshape(-1, 9), T), axis=1)


def _made_real(values: Field, real: NDArray[np.bool_]) -> Field:
    return np.where(real.reshape(-1, *[1] * (values.ndim - 1)), values.real, values)


def _not_parallel(locator: Locator, R: Complex, deviation: Array) -> NDArray[np.bool_]:
    """Return at which poses no lines of a DLL can be parallel, where its equation says nothing."""
    apart = np.ones(len(R), np.bool_)
    for row in locator.instance.constraints:
        u, v = row.platform, row.base
        if row.kind is DLL and isinstance(u, Line) and isinstance(v, Line):
            normal = cross(R @ u.unit, np.broadcast_to(v.unit, (len(R), 3)))
            size = np.abs(R).max(axis=(1, 2), initial=1)
            apart &= np.abs(dot(normal, normal)) > _SINE * (deviation + _ROUNDED * size) * size
    return apart
