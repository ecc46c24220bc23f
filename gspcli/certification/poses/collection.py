"""Distinct proved poses of one system: what each new approximation adds to those known already."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cached_property, partial

import numpy as np
from flint import acb, ctx
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.certification.equations import study
from gspcli.certification.poses.digit_proofs import DigitProofs
from gspcli.certification.poses.distinct import all_different, first_of_each, same
from gspcli.certification.poses.floating import prove
from gspcli.certification.poses.locator import (
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
#: Returns a point from which a pose can be located.
Start = Callable[[], list[acb]]

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
        #: Points to locate poses from that are known to more digits than those of doubles.
        self._starts: dict[int, Start] = {}
        self._paired: set[int] = set()
        #: Poses whose conjugates doubles do not tell from others.
        self._close: list[int] = []

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

    def add_with_digits(self, points: Complex, low: Complex | None) -> NDArray[np.bool_]:
        """Add the poses near points that 86 digits prove; return near which.

        Only poses that doubles tell from all others are added: of the rest nothing is said.

        Parameters
        ----------
        points, low
            As for `Locator.locate`.
        """
        new = np.zeros(len(points), np.bool_)
        if len(points) and self._digit_proofs is not None:
            found = self._digit_proofs.prove(points, low)
            for k in np.flatnonzero(found.proved).tolist():
                rest = points[k, None][:0] if low is None else low[k]
                start = partial(self._start, points[k], rest)
                new[k] = self._add_doubles(
                    found.R[k], found.T[k], found.quaternions[k], bool(found.real[k]), start
                )
        return new

    def add(self, poses: Iterable[Located | AtInfinity | None]) -> int:
        """Add those located poses that are proved to be new; return how many."""
        return sum(self._add(pose) for pose in poses if isinstance(pose, Located))

    def add_conjugates(self) -> int:
        """Add the conjugates of poses located or proved with more digits: equations are real.

        Only those that doubles tell from all others are added, and how many is returned; for the
        others see `add_close_conjugates`.
        """
        before = len(self)
        for k in range(before):
            pose, start = self._located[k], self._starts.get(k)
            if (pose is None and start is None) or self.real[k] or k in self._paired:
                continue
            self._paired.add(k)
            if self._add_conjugate(k, pose, start):
                self._paired.add(len(self) - 1)
            else:
                self._close.append(k)
        return len(self) - before

    def add_close_conjugates(self) -> int:
        """Add those conjugates that only balls tell from the rest; return how many are new.

        Most are none: both poses of a pair are in the collection. To prove it takes long.
        """
        close, self._close = self._close, []
        before = len(self)
        for k in close:
            pose = self._exactly(k)
            if pose is not None and self._add(pose.conjugate):
                self._paired.add(len(self) - 1)
        return len(self) - before

    @cached_property
    def _digit_proofs(self) -> DigitProofs | None:
        return DigitProofs.of(self.locator, self.sides)

    def _start(self, point: Complex, low: Complex) -> list[acb]:
        with ctx.workprec(LAST_PRECISION):
            return self.locator.in_frames(point, low)

    def _add_doubles(
        self, R: Complex, T: Complex, quaternion: Complex, real: bool, start: Start
    ) -> bool:
        """Add a pose proved with more digits, rounded to doubles, if these tell it from all."""
        near, deviation = self._near(R, T)
        if len(near):
            return False
        # So far from it may a ball of it be, rounded likewise.
        self._append(R, T, quaternion, real, 2 * deviation, None)
        self._starts[len(self) - 1] = start
        return True

    def _add_conjugate(self, k: int, pose: Located | None, start: Start | None) -> bool:
        if start is not None:
            R, T, quaternion = (x[k].conj() for x in (self.R, self.T, self.quaternions))
            return self._add_doubles(R, T, quaternion, False, _conjugates(start))
        assert pose is not None
        return not len(self._near(self.R[k].conj(), self.T[k].conj())[0]) and self._add(
            pose.conjugate
        )

    def _near(self, R: Complex, T: Complex) -> tuple[NDArray[np.intp], float]:
        """Return which poses doubles do not tell from a located one, and how far that is off."""
        scale = self.locator.scale
        here = _entries(R[None], T[None] / scale)
        deviation = float(_ROUNDED * np.abs(here).max(initial=1))
        gaps = np.abs(_entries(self.R, self.T / scale) - here).max(axis=1, initial=0)
        return np.flatnonzero(gaps <= 2 * (self._deviations + deviation)), deviation

    def _append(
        self,
        R: Complex,
        T: Complex,
        quaternion: Complex,
        real: bool,
        deviation: float,
        located: Located | None,
    ) -> None:
        self.R = np.concatenate([self.R, R[None]])
        self.T = np.concatenate([self.T, T[None]])
        self.quaternions = np.concatenate([self.quaternions, quaternion[None]])
        self.real = np.append(self.real, real)
        self._deviations = np.append(self._deviations, deviation)
        self._located.append(located)

    def _add(self, pose: Located) -> bool:
        near, deviation = self._near(pose.R, pose.T)
        for k in near.tolist():
            other = self._exactly(k)
            if other is None or not _different(other, pose):
                return False
        self._append(pose.R, pose.T, pose.quaternion, pose.real, deviation, pose)
        return True

    def _exactly(self, k: int) -> Located | None:
        """Return a pose with all its digits, if they can be had."""
        if self._located[k] is None:
            scale = self.locator.scale
            if k in self._starts:
                start, bits = self._starts[k](), 4 * FIRST_PRECISION
            else:
                points, _ = study.study_points(self.R[k][None], self.T[k][None] / scale)
                with ctx.workprec(LAST_PRECISION):
                    start, bits = self.locator.exactly(points[0]), FIRST_PRECISION
            found = self.locator.locate_exactly(start, self.sides, bits)
            if isinstance(found, Located) and self._is_near(k, found):
                self._located[k] = found
        return self._located[k]

    def _is_near(self, k: int, pose: Located) -> bool:
        """Return whether a located pose lies where that of doubles is proved."""
        here = _entries(pose.R[None], pose.T[None] / pose.scale)
        gap = np.abs(_entries(self.R[k][None], self.T[k][None] / pose.scale) - here).max()
        error = _ROUNDED * np.abs(here).max(initial=1)
        return bool(gap + error <= self._deviations[k])


def _conjugates(start: Start) -> Start:
    return lambda: [x.conjugate() for x in start()]


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
