"""A collection of distinct proved poses of one system, to which new poses are added."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np
from flint import acb, ctx
from numpy.typing import NDArray

from gspcli.certification.numbers.rounding import NEAREST
from gspcli.certification.poses.isolation import places, same
from gspcli.certification.poses.locator import LAST_PRECISION, AtInfinity, Located, Locator
from gspcli.geometry.quaternions import Field

Complex = NDArray[np.complex128]
Array = NDArray[np.float64]

#: Study points by the bytes of T.
StudyPoints = Mapping[bytes, Sequence[acb]]

#: Bound of the relative error of a located pose that has been rounded to doubles.
_ERROR = 4 * NEAREST
#: Poses that agree to this part of their largest entry are probably the same.
_ALIKE = 1e-9


class Collection:
    """Poses that are proved to be simple, pairwise different, and real or not real.

    Parameters
    ----------
    locator
        The locator of the instance.
    sides
        For each constraint the index of the equation of the system (`BallSystem.equations`).

    Attributes
    ----------
    R, T
        The poses, shapes (n, 3, 3) and (n, 3), complex; imaginary parts of real ones are zero.
    quaternions
        Quaternions of the rotations, with ``e.e = 1``, of either sign, shape (n, 4).
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
        #: Poses whose conjugates doubles do not separate from other poses.
        self._close: list[int] = []

    def __len__(self) -> int:
        """Return the number of different solutions."""
        return len(self._located)

    def points(self) -> Iterator[tuple[bytes, Sequence[acb]]]:
        """Yield the bytes of T and the Study point of each pose proved with many digits."""
        for T, located in zip(self.T, self._located, strict=True):
            if located is not None:
                yield T.tobytes(), located.isolation.centre

    def add_proved(
        self, R: Complex, T: Complex, quaternions: Complex, real: NDArray[np.bool_], off: Array
    ) -> NDArray[np.intp]:
        """Add poses that the kernel has proved; return the place of each in the collection.

        A pose that is not proved to be different from a pose of the collection has its place.

        Parameters
        ----------
        R, T, quaternions, real
            As the attributes of the same names.
        off
            Bounds of their errors (`ProvedPoses.deviation`).
        """
        known, scale = len(self), self.locator.scale
        entries = _entries(np.concatenate([self.R, R]), np.concatenate([self.T, T]) / scale)
        found = places(entries, np.concatenate([self._deviations, off]), known)
        new = found[known:] == np.arange(known, len(found))
        self.R, self.T, self.quaternions, self.real, self._deviations = (
            np.concatenate([old, more[new]])
            for old, more in (
                (self.R, R),
                (self.T, T),
                (self.quaternions, quaternions),
                (self.real, real),
                (self._deviations, off),
            )
        )
        self._located += [None] * int(new.sum())
        place = np.concatenate([np.arange(known), known + np.cumsum(new) - 1])
        return np.asarray(place[found[known:]])

    def add(self, poses: Iterable[Located | AtInfinity | None]) -> int:
        """Add the located poses that are proved to be new; return their number."""
        return sum(self._add(pose) for pose in poses if isinstance(pose, Located))

    def add_conjugates(self) -> int:
        """Add the conjugates of located poses, which are solutions, too: equations are real.

        Only conjugates that doubles separate from all others are added; their number is returned.
        For the others see `add_close_conjugates`.
        """
        before = len(self)
        for k in range(before):
            pose = self._located[k]
            if pose is None or self.real[k] or k in self._paired:
                continue
            self._paired.add(k)
            near, _ = self._near(self.R[k].conj(), self.T[k].conj())
            if not len(near) and self._add(pose.conjugate):
                self._paired.add(len(self) - 1)
            else:
                self._close.append(k)
        return len(self) - before

    def add_close_conjugates(self) -> int:
        """Add the conjugates that only balls separate from the others; return how many are new.

        Most are not new: both poses of a pair are in the collection. The proof takes long.
        """
        close, self._close = self._close, []
        before = len(self)
        for k in close:
            pose = self._exactly(k)
            if pose is not None and self._add(pose.conjugate):
                self._paired.add(len(self) - 1)
        return len(self) - before

    def place_near(self, R: Complex, T: Complex, off: float) -> int:
        """Return the place of the only pose within a bound of a pose; else -1."""
        entries, here = (
            _entries(x, y / self.locator.scale) for x, y in ((self.R, self.T), (R[None], T[None]))
        )
        gaps = np.abs(entries - here).max(axis=1, initial=0)
        near = np.flatnonzero(gaps <= 2 * (self._deviations + off))
        return int(near[0]) if len(near) == 1 else -1

    def surrounds(self, k: int, point: Complex, low: Complex) -> bool:
        """Whether no other solution is as near to a pose as a point is (`Locator.in_frames`).

        The answer is yes, too, for a pose whose digits cannot be computed.
        """
        pose = self._exactly(k)
        with ctx.workprec(LAST_PRECISION):
            there = self.locator.in_frames(point, low)
            return pose is None or pose.isolation.surrounds(there)

    def is_near(self, R: Complex, T: Complex) -> bool:
        """Whether an approximate pose, R (3, 3) and T (3,), is probably in the collection."""
        scale = self.locator.scale
        here, there = _entries(R[None], T[None] / scale), _entries(self.R, self.T / scale)
        gaps = np.abs(there - here).max(axis=1, initial=0)
        return bool((gaps <= _ALIKE * np.abs(here).max(initial=1)).any())

    def _near(self, R: Complex, T: Complex) -> tuple[NDArray[np.intp], float]:
        """Return which poses doubles do not separate from a located one, and its error."""
        scale = self.locator.scale
        here = _entries(R[None], T[None] / scale)
        deviation = float(_ERROR * np.abs(here).max(initial=1))
        gaps = np.abs(_entries(self.R, self.T / scale) - here).max(axis=1, initial=0)
        return np.flatnonzero(gaps <= 2 * (self._deviations + deviation)), deviation

    def _add(self, pose: Located) -> bool:
        near, deviation = self._near(pose.R, pose.T)
        for k in near.tolist():
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
        """Return a pose with all its digits, if they can be computed."""
        if self._located[k] is None:
            found = self.locator.near(self.R[k], self.T[k], self.sides)
            if isinstance(found, Located) and self._is_near(k, found):
                self._located[k] = found
        return self._located[k]

    def _is_near(self, k: int, pose: Located) -> bool:
        """Return whether a located pose has the doubles of a pose, or is within its proved error.

        It is then as different from the other poses as this one, and can take its place.
        """
        if np.array_equal(pose.R, self.R[k]) and np.array_equal(pose.T, self.T[k]):
            return pose.real == bool(self.real[k])
        here = _entries(pose.R[None], pose.T[None] / pose.scale)
        gap = np.abs(_entries(self.R[k][None], self.T[k][None] / pose.scale) - here).max()
        error = _ERROR * np.abs(here).max(initial=1)
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
