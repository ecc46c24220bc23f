"""The search for one choice of sides: distinct proved poses, and the paths without a pose."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.poses.far_points import conjugate_sources
from gspcli.certification.poses.isolation import Isolation, places, same
from gspcli.certification.poses.locator import DOUBLE, AtInfinity, Located, StudyPoints
from gspcli.certification.poses.pose_arrays import Bits, Complex, PoseProofs
from gspcli.continuation.paths import Basis, PathAccount
from gspcli.continuation.systems import FineCoefficients
from gspcli.continuation.tracked_paths import TrackedPaths
from gspcli.continuation.tracker import PathResults
from gspcli.geometry.quaternions import Field, canonical_sign, pose_from_study
from gspcli.solver.poses import PoseSet
from gspcli.solver.problem import Problem

Index = NDArray[np.intp]

#: If at most one path in this many is missing, paths have jumped rather than that the platform is
#: special: other paths find what is missing. Else no count says whether more would be found.
FEW = 50
#: Poses that agree to this part of their largest entry are not located again.
_KNOWN = 1e-13
#: Bits of points that are known to many digits, half of those of `far_points`.
_FAR_BITS = 160
#: Bound of the relative error of a located pose that has been rounded to doubles.
_ROUNDED = 2.0**-51
#: Poses that agree to this part of their largest entry are probably the same.
_ALIKE = 1e-9


class SideSearch:
    """The search for the poses of a platform for one of its choices of sides, the k-th."""

    def __init__(self, problem: Problem, k: int) -> None:
        self.problem, self.k = problem, k
        #: For each constraint the index of its equation (`BallSystem.equations`).
        self.sides = problem.sides[k]
        #: The equations in balls.
        self.locator = problem.locator
        #: The proved ones, simple and all different; quaternions of either sign.
        self.poses = PoseProofs(
            **PoseProofs.none(0), rounded=np.zeros(0, np.bool_), deviation=np.zeros(0)
        )
        #: The simple solutions at infinity that were met, all different.
        self.infinite: list[Isolation] = []
        #: Which of the ends of the first strategy that came last have led to poses of their own; of
        #: no ends at all if the kernel could prove nothing.
        self.reached: Bits = np.zeros(0, np.bool_)
        #: The paths that have led to no pose with 32 digits.
        self.unresolved: Index = np.arange(0)
        #: How many eliminations have been done.
        self.eliminated = 0
        #: How many simple poses there can be.
        self.wanted = problem.expected // len(problem.choices)
        #: Whether all poses are known to be simple ones.
        self.all_simple = False
        #: How many of the further strategies have ended (`gspcli.solver.further`).
        self.tried = 0
        #: The poses in balls, where these are known.
        self._located: list[Located | None] = []
        self._paired: set[int] = set()
        #: Poses whose conjugates doubles do not separate from other poses.
        self._close: list[int] = []

    def __len__(self) -> int:
        """Return the number of different poses."""
        return len(self._located)

    @property
    def paths(self) -> TrackedPaths:
        """The paths."""
        return self.problem.tracked[self.k]

    @property
    def is_complete(self) -> bool:
        """Whether as many poses are proved as there can be."""
        return len(self) >= min(self.wanted, self.paths.count - len(self.infinite))

    @cached_property
    def target(self) -> FineCoefficients:
        """The equations of paths from the exact numbers, in 32 digits."""
        return self.problem.target(self.k)

    @property
    def points(self) -> StudyPoints:
        """The Study points of the poses that are proved with many digits."""
        known = zip(self.poses.T, self._located, strict=True)
        return {T.tobytes(): pose.isolation.centre for T, pose in known if pose is not None}

    def add_first(self, found: PoseProofs) -> None:
        """Add what the kernel has proved of the ends of a first strategy, one for each path."""
        place = self.add_near(found)
        self.reached = np.zeros(len(place), np.bool_)
        self.reached[np.unique(place, return_index=True)[1]] = True
        self.reached &= place >= 0

    def add_near(self, found: PoseProofs) -> Index:
        """Add what the kernel has proved of n ends, and conjugates; return their places, or -1."""
        place = np.full(len(found.R), -1)
        settled = found.certified & found.rounded
        pairs = found[settled & ~found.real].conjugates
        added = self.add_proved(PoseProofs.together([found[settled], pairs]))
        place[settled] = added[: settled.sum()]
        # Mostly pairs of conjugates, which are one after the other.
        for k in np.flatnonzero(found.certified & ~found.rounded).tolist():
            R, T, off = found.R[k], found.T[k], float(found.deviation[k])
            place[k] = self.place_near(R, T, off)
            if place[k] >= 0:
                continue
            if self.add_located([self.locator.near_proved(R, T, off, self.sides)]):
                self.add_conjugates()
                place[k] = self.place_near(R, T, off)
        return place

    def add_proved(self, found: PoseProofs) -> Index:
        """Add poses that the kernel has proved; return the place of each in the collection.

        A pose that is not proved to be different from a known one has its place.
        """
        known, both = len(self), PoseProofs.together([self.poses, found])
        first = places(both.entries(self.locator.scale), both.deviation, known)
        new = first[known:] == np.arange(known, len(first))
        self.poses = both[np.append(np.ones(known, np.bool_), new)]
        self._located += [None] * int(new.sum())
        place = np.concatenate([np.arange(known), known + np.cumsum(new) - 1])
        return np.asarray(place[first[known:]])

    def add_located(self, poses: Iterable[Located | AtInfinity | None]) -> int:
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
            if pose is None or self.poses.real[k] or k in self._paired:
                continue
            self._paired.add(k)
            near, _ = self._near(self.poses.R[k].conj(), self.poses.T[k].conj())
            if not len(near) and self._add(pose.conjugate):
                self._paired.add(len(self) - 1)
            else:
                self._close.append(k)
        return len(self) - before

    def add_close_conjugates(self) -> int:
        """Add the conjugates that only balls separate from the others; return how many are new.

        Most are not new: both poses of a pair are known. The proof takes long.
        """
        close, self._close = self._close, []
        before = len(self)
        for k in close:
            pose = self._exactly(k)
            if pose is not None and self._add(pose.conjugate):
                self._paired.add(len(self) - 1)
        return len(self) - before

    def add_ends(self, ends: PathResults) -> Bits:
        """Add the poses near ends, by the kernel or in balls; return which have led to new ones."""
        before = len(self)
        problem, new = self.problem, np.zeros(ends.points.shape[1], np.bool_)
        if not len(new):
            return new
        if problem.proofs is not None:
            choice = problem.choices[self.k : self.k + 1]
            found, _ = problem.proofs.decide(choice, ends.points[None], problem.frames)
            place = self.add_near(found[0])
            first = np.unique(place, return_index=True)[1]
            new[first[place[first] >= before]] = True
        # What doubles do not tell from a known pose may be one beside it.
        rest = np.flatnonzero(~new)
        new[rest] = self._locate(ends.points[0, rest], ends.more[rest])
        return new

    def _locate(self, points: Field, low: Field) -> Bits:
        """Add the poses near points in balls, and conjugates; return which have led to new ones."""
        if not len(points):
            return np.zeros(0, np.bool_)
        new = ~self._are_known(points, low)
        index = np.flatnonzero(new)
        # One of each pair of conjugates is enough.
        source = index[conjugate_sources(points[index], low[index])]
        sought = index[source == index]
        bits = DOUBLE * (1 + low.shape[1])
        located = self.locator.locate(points[sought], low[sought], self.sides, bits)
        new[sought] = [bool(self.add_located([end])) for end in located]
        new[index] = new[source]
        self.add_conjugates()
        for end in located:
            if isinstance(end, AtInfinity) and not any(
                same(end.isolation, other) for other in self.infinite
            ):
                self.infinite.append(end.isolation)
        return new

    def add_far(self, ends: Field, planes: Index | None = None) -> None:
        """Add poses far away, their conjugates and mirror images.

        Parameters
        ----------
        ends
            Study points of any norm with quaternions that are right in double precision, up to a
            factor, one for each path, shape (n, 8).
        planes
            As for `Search.add`.
        """
        from gspcli.certification.poses.far_points import far_points

        has_images = self.problem.has_mirror_images
        with np.errstate(invalid="ignore"):
            e = ends[:, :4] / np.linalg.norm(ends[:, :4], axis=1, keepdims=True)
        # Poses to which no paths lead come last.
        is_open = ~self.reached[: len(ends)] & np.isfinite(e).all(axis=1)
        of_open = None if planes is None else planes[is_open]
        points = far_points(self.locator, self.sides, e[is_open], of_open)
        if not points:
            return
        for point in points:
            located = self.locator.locate_exactly(point, self.sides, _FAR_BITS)
            if isinstance(located, Located):
                self.add_located([located, located.mirrored] if has_images else [located])
                self.add_conjugates()
        self.add_close_conjugates()

    def place_near(self, R: Complex, T: Complex, off: float) -> int:
        """Return the place of the only pose within a bound of a pose; else -1."""
        near = np.flatnonzero(self._gaps(R, T)[0] <= 2 * (self.poses.deviation + off))
        return int(near[0]) if len(near) == 1 else -1

    def is_near(self, R: Complex, T: Complex) -> bool:
        """Whether an approximate pose, R (3, 3) and T (3,), is probably known."""
        gaps, size = self._gaps(R, T)
        return bool((gaps <= _ALIKE * size).any())

    def _are_known(self, points: Field, low: Field) -> Bits:
        """Return which points agree with a proved pose in all their digits, shape (k,)."""
        near = self._near_known(points)
        known = np.asarray(near.any(axis=1))
        if low.shape[1]:
            # Another pose may be nearer than doubles tell.
            for i in np.flatnonzero(known).tolist():
                alike = np.flatnonzero(near[i]).tolist()
                known[i] = any(self._surrounds(k, points[i], low[i]) for k in alike)
        return known

    def _near_known(self, points: Field) -> Bits:
        """Return which points agree with which proved poses in double precision, shape (k, n)."""
        given = self.problem.arrangement
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            R, T = pose_from_study(points[:, :4], points[:, 4:])
            T = given.restored(R, T)
            here = _entries(R, T / given.length)
            known = self.poses.entries(given.length)
            size = np.abs(here).max(axis=1, initial=1.0)
            near = [
                np.abs(known - pose).max(axis=1) < _KNOWN * unit
                for pose, unit in zip(here, size.tolist(), strict=True)
            ]
        return np.array(near, np.bool_).reshape(len(here), len(known))

    def _surrounds(self, k: int, point: Complex, low: Complex) -> bool:
        """Whether no other solution is as near to a pose as a point is.

        The answer is yes, too, for a pose whose digits cannot be computed.
        """
        pose = self._exactly(k)
        return pose is None or self.locator.is_surrounded(point, low, pose)

    def _gaps(self, R: Complex, T: Complex) -> tuple[NDArray[np.float64], float]:
        """Return how far proved poses are from a pose, shape (n,), and its size, at least 1."""
        here = _entries(R[None], T[None] / self.locator.scale)
        gaps = np.abs(self.poses.entries(self.locator.scale) - here).max(axis=1, initial=0)
        return gaps, float(np.abs(here).max(initial=1))

    def _near(self, R: Complex, T: Complex) -> tuple[Index, float]:
        """Return which poses doubles do not separate from a located one, and its error."""
        gaps, size = self._gaps(R, T)
        deviation = _ROUNDED * size
        return np.flatnonzero(gaps <= 2 * (self.poses.deviation + deviation)), deviation

    def _add(self, pose: Located) -> bool:
        near, deviation = self._near(pose.R, pose.T)
        for k in near.tolist():
            other = self._exactly(k)
            if other is None or not _different(other, pose):
                return False
        yes = np.ones(1, np.bool_)
        one = PoseProofs(
            quaternions=pose.quaternion[None],
            R=pose.R[None],
            T=pose.T[None],
            real=np.array([pose.real]),
            certified=yes,
            multiplicity=yes.astype(np.int64),
            rounded=yes,
            deviation=np.array([deviation]),
        )
        self.poses = PoseProofs.together([self.poses, one])
        self._located.append(pose)
        return True

    def _exactly(self, k: int) -> Located | None:
        """Return a pose with all its digits, if they can be computed."""
        if self._located[k] is None:
            found = self.locator.near(self.poses.R[k], self.poses.T[k], self.sides)
            if isinstance(found, Located) and self._is_near(k, found):
                self._located[k] = found
        return self._located[k]

    def _is_near(self, k: int, pose: Located) -> bool:
        """Return whether a located pose has the doubles of a pose, or is within its proved error.

        It is then as different from the other poses as this one, and can take its place.
        """
        R, T = self.poses.R[k], self.poses.T[k]
        if np.array_equal(pose.R, R) and np.array_equal(pose.T, T):
            return pose.real == bool(self.poses.real[k])
        gaps, size = self._gaps(pose.R, pose.T)
        return bool(gaps[k] + _ROUNDED * size <= self.poses.deviation[k])

    def answer(self, most: int | None = None) -> PoseSet:
        """Return the proved poses, and an account of all paths.

        Parameters
        ----------
        most
            No other solution is possible beside this many, if that is known.
        """
        paths = self.problem.expected // len(self.problem.choices)
        number = len(self)
        at_infinity = paths - number if number == most else len(self.infinite)
        account = PathAccount(
            expected=paths,
            found=number,
            at_infinity=at_infinity,
            lost=paths - number - at_infinity,
            basis=Basis.COUNT if number == most else Basis.PATHS,
        )
        quaternions = canonical_sign(self.poses.quaternions)
        found = PoseSet.of(self.poses, quaternions=quaternions, account=account)
        return found.on_sides(self.problem.choices[self.k : self.k + 1])


def _different(first: Located, second: Located) -> bool:
    """Whether two located poses are proved to be different."""
    if same(first.isolation, second.isolation):
        return False
    return not all(
        x.overlaps(y) for x, y in zip(first.pose.entries, second.pose.entries, strict=True)
    )


def _entries(R: Field, T: Field) -> Field:
    return np.concatenate((R.reshape(-1, 9), T), axis=1)
