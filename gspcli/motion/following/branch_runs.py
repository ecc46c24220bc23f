"""Branches followed along one trajectory, and the end of each of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.certification.branches.arcs import follow_closely
from gspcli.certification.branches.folds import Fold, prove_fold
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.tolerances import NEARLY_PARALLEL_SINE
from gspcli.motion.following.branch_follower import Branches, FollowOptions, MovingPlatform, Stop
from gspcli.motion.following.moving_geometry import MovingGeometry
from gspcli.motion.following.tracks import Event, Track
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: Points of norm one at the same pose agree to this.
SAME = 1e-7
#: A platform farther away than this many typical lengths is called "far away" in a reason.
_FAR = 10.0
#: The reason of an undecided end at which nothing else is seen.
NEARLY_SINGULAR = "the pose is nearly singular"


@dataclass(frozen=True, eq=False)
class Run:
    """Following along one trajectory."""

    instance: Instance
    platform: MovingPlatform | MovingGeometry
    t: Array
    values: Array
    options: FollowOptions

    def follow(self, R: Array, T: Array, numbers: NDArray[np.int64]) -> Track:
        """Follow modes from the first row."""
        platform = self.platform
        branches = platform.follow(
            platform.internal(self.values)[None],
            np.zeros(len(R), np.int64),
            platform.points(R, T),
            self.options,
        )
        folds = [self._carried_on(branches, k) for k in range(len(R))]
        self._shared(branches, folds)
        poses = platform.poses(branches.points)
        events = tuple(
            self._event(branches, folds, numbers, k)
            for k in range(len(R))
            if branches.stop[k] != Stop.END
        )
        return Track(
            self.instance,
            platform.instance,
            self.t,
            self.values[:, :6],
            numbers,
            *poses,
            self.options.certify,
            events,
            None,
            int(branches.segments.sum()),
            coordinates=platform.chosen,
            places=self.values[:, 6:],
        )

    @property
    def reversed(self) -> Run:
        """The run from the last row to the first."""
        return Run(
            self.instance, self.platform, -self.t[::-1], self.values[::-1].copy(), self.options
        )

    def time(self, row: int, part: float) -> float:
        """Return t at a part of the step after a row."""
        if row + 1 == len(self.t):
            return float(self.t[row])
        return float(self.t[row] + part * (self.t[row + 1] - self.t[row]))

    def _value(self, row: int, part: float) -> Array:
        if row + 1 == len(self.t):
            return self.platform.internal(self.values[row])
        first, last = self.platform.internal(self.values[row : row + 2])
        value: Array = first + part * (last - first)
        return value

    def _carried_on(self, branches: Branches, k: int) -> tuple[int, Fold] | None:
        """Continue a branch where doubles do not suffice; return the fold at its end, if any.

        The new points are added to the branch.
        """
        closely = False
        while branches.stop[k] == Stop.STEP:
            row = int(branches.reached[k])
            fold = self._fold(branches, k)
            if fold is not None and self._reaches(branches, k, fold):
                return row, fold
            # More digits do not help at parallel lines and at poses far away.
            seen = self._seen(row, *self.platform.poses(branches.last[k]))
            if closely or not self.options.certify or (fold is None and seen is not None):
                return None
            self._follow_closely(branches, k)
            closely = branches.reached[k] == row
        return None

    def _shared(self, branches: Branches, folds: list[tuple[int, Fold] | None]) -> None:
        """Enter the folds that other modes reach for modes that stopped before they were proved."""
        proved = [found for found in folds if found is not None]
        for k in np.flatnonzero(branches.stop == Stop.STEP).tolist():
            for row, fold in proved if folds[k] is None else ():
                near = row == branches.reached[k] and branches.fraction[k] <= fold.high
                if near and self._reaches(branches, k, fold):
                    folds[k] = row, fold
                    break

    def _follow_closely(self, branches: Branches, k: int) -> None:
        """Follow a branch in arcs, to the next row if that is possible, and from there as usual."""
        platform, row = self.platform, int(branches.reached[k])
        rows, part = (self.values[row], self.values[row + 1]), float(branches.fraction[k])
        way = follow_closely(platform.system, rows, branches.last[k], part, float(branches.near[k]))
        if way is None:
            return
        branches.last[k], branches.fraction[k], branches.near[k], count = way
        branches.segments[k] += count
        branches.tries[k] += count
        if branches.fraction[k] < 1:
            return
        rest = platform.follow(
            platform.internal(self.values[row + 1 :])[None],
            np.zeros(1, np.int64),
            branches.last[k][None],
            self.options,
            branches.near[[k]],
        )
        branches.points[k, row + 1 :] = rest.points[0]
        branches.segments[k] += rest.segments[0]
        branches.tries[k] += rest.tries[0]
        branches.reached[k] = row + 1 + max(rest.reached[0], 0)
        branches.stop[k] = Stop.STEP if rest.stop[0] == Stop.START else rest.stop[0]
        branches.fraction[k] = rest.fraction[0]
        # Where the row itself is as far as doubles go, the pose of the arcs is the nearer one.
        if rest.reached[0] > 0 or rest.fraction[0] > 0 or rest.stop[0] == Stop.END:
            branches.last[k], branches.near[k] = rest.last[0], rest.near[0]

    def _fold(self, branches: Branches, k: int) -> Fold | None:
        """Return a proved fold near the end of a branch, if there is one before the next row."""
        row, part, point = int(branches.reached[k]), float(branches.fraction[k]), branches.last[k]
        if row + 1 >= len(self.t):
            return None
        jacobian = self.platform.jacobian(point, self._value(row, part))
        direction = np.linalg.svd(np.vstack((jacobian, point)))[2][-1]
        rows = self.values[row], self.values[row + 1]
        fold = prove_fold(self.platform.system, rows, part, point, direction)
        if fold is None or fold.bends > 0 or not part <= fold.high <= 1:
            return None
        return fold

    def _reaches(self, branches: Branches, k: int, fold: Fold) -> bool:
        """Whether it is proved that a branch reaches a fold and no other fold before it."""
        part, near = float(branches.fraction[k]), float(branches.near[k])
        return bool(fold.sides(branches.last[k][None], part, near)[0])

    def _event(
        self,
        branches: Branches,
        folds: list[tuple[int, Fold] | None],
        numbers: NDArray[np.int64],
        k: int,
    ) -> Event:
        """Return the event at the end of a branch that ended early."""
        row, part = int(branches.reached[k]), float(branches.fraction[k])
        found = folds[k]
        mode = int(numbers[k])
        if found is None:
            point = branches.last[k]
            R, T = self.platform.poses(point)
            row = max(row, 0)
            low, high = self.time(row, part), self.time(row, 1.0)
            reason = self._seen(row, R, T) or NEARLY_SINGULAR
            return Event("undecided", reason, False, mode, row, low, high, R, T)
        before, fold = found
        partner = next(
            (
                int(numbers[j])
                for j, other in enumerate(folds)
                if j != k and other is not None and other[0] == before and _same(other[1], fold)
            ),
            None,
        )
        R, T = self.platform.poses(fold.point)
        other = self._partner(branches, k, fold)
        times = self.time(before, fold.low), self.time(before, fold.high)
        return Event(
            "fold", "", False, mode, before, *times, R, T, partner, *(other or (None, None))
        )

    def _seen(self, row: int, R: Array, T: Array) -> str | None:
        """Return the reason in words, from the pose at which following stopped, if there is one."""
        if not (np.isfinite(R).all() and np.isfinite(T).all()):
            return "the platform goes far away, to infinity"
        arrangement = Arrangement.of(self.platform.instance_at(self.values[row]))
        w, v = arrangement.placed(R, T).w, arrangement.v
        sines = np.linalg.norm(np.cross(w, v), axis=-1)
        for k, kind in enumerate(arrangement.kinds):
            if kind is DLL and sines[k] < NEARLY_PARALLEL_SINE:
                return f"the lines of constraint {k + 1} become parallel"
        distance = float(
            np.linalg.norm(T + R @ arrangement.platform_centre - arrangement.base_centre)
        )
        if distance > _FAR * arrangement.length:
            unit = self.instance.units.length
            return f"the platform goes far away, to {distance:.3g} {unit}"
        return None

    def _partner(self, branches: Branches, k: int, fold: Fold) -> tuple[Array, Array] | None:
        """Return the pose at the row before of the branch that meets this one in a fold."""
        row, part, point = int(branches.reached[k]), float(branches.fraction[k]), branches.last[k]
        mirrored = 2 * _unit(fold.point, point) - point
        here = self._value(row, part)
        back = np.stack((here, self._value(row, 0.0)))[None]
        found = self.platform.follow(back, np.zeros(1, np.int64), mirrored[None], self.options)
        start = found.points[0, 0]
        if found.stop[0] != Stop.END or (
            np.linalg.norm(start - point) < np.linalg.norm(start - mirrored)
        ):
            return None
        R, T = self.platform.poses(found.points[0, -1])
        return R, T


def _unit(point: Array, like: Array) -> Array:
    """Return the multiple of norm one of a Study point, with the sign of another."""
    unit: Array = point / np.linalg.norm(point)
    return unit if unit @ like > 0 else -unit


def _same(first: Fold, second: Fold) -> bool:
    """Whether two folds are the same: their times overlap, and so do their points."""
    overlap = first.low <= second.high and second.low <= first.high
    a = _unit(first.point, first.point)
    return overlap and bool(np.linalg.norm(a - _unit(second.point, a)) < SAME)
