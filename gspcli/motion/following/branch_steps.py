"""Branches followed while values and coordinates move, each step proved (`chords`), in NumPy.

The equations of each step are computed in ball arithmetic. All branches take their steps together.
Where modes are too near to each other for doubles, residuals are computed in balls, too
(`follow_closely`).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import field, replace

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.branches.chord_residuals import ExactChords
from gspcli.certification.branches.taylor import MovingQuadrics, MovingSystem
from gspcli.motion.following.branch_follower import Branches, FollowOptions, Stop
from gspcli.motion.following.chord_equations import VALUES, Parts, equations_at
from gspcli.motion.following.chords import EASY, LONGEST, prove
from gspcli.motion.following.part_models import PartModels
from gspcli.records import dataclass

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Newton's method: a correction below this leaves an error of its square; its most steps.
_CONVERGED, _DIVERGED, _STEPS = 1e-8, 0.5, 6
#: The most steps of Newton's method with exact residuals.
_CORRECTIONS = 10
#: A chord is proved if its measure is below this.
PROVED = 0.98
#: What points may move by when they are scaled to another patch: of rounding alone, and with
#: a margin.
SCALED, SCALED_EXACTLY = 2.0**-40, 2.0**-48
#: How often a step may be halved where residuals are known in balls, and how often it is at first.
_MOST_HALVINGS, _HALVINGS = 50, 24
#: After this many tries in balls, of some milliseconds each, a branch is given up if it is
#: `BranchSteps.hopeless`, and after the most in any case.
_TRIES, _MOST_TRIES = 50, 1000


@dataclasses.dataclass(eq=False)
class _Cursor:
    """Where a branch is: at ``part`` of 2^``level`` steps from ``row`` to the next one."""

    branch: int
    trajectory: int
    z: Array
    before: Array
    row: int = 0
    part: int = 0
    level: int = 0
    #: How long the next step is, in lengths of the last one.
    ratio: float = 0.0
    #: A bound of the distance of the last proved pose, and a distance within which there is no
    #: other pose.
    end: float = 0.0
    alone: float = 0.0

    def halve(self, times: int) -> None:
        """Take shorter steps."""
        self.level += times
        self.part <<= times
        self.ratio *= 2.0**-times

    def advance(self, z: Array, *, easy: bool) -> None:
        """Go to the end of the step."""
        self.before, self.z, self.ratio = self.z, z, 1.0
        self.part += 1
        if self.part == 1 << self.level:
            self.row, self.part = self.row + 1, 0
        if easy and self.level and self.part % 2 == 0:
            self.level, self.part, self.ratio = self.level - 1, self.part // 2, 2.0


@dataclass(frozen=True, eq=False)
class Segment:
    """A part of a branch that is proved to be near a chord.

    Attributes
    ----------
    branch
        The number of the branch.
    row, part, level
        The part number ``part`` of the 2^``level`` equal parts between a row and the next one.
    first, last
        The ends of the chord, Study points of norm one, shape (8,).
    end, radius, alone
        Bounds as in `ChordProofs`: of the distance of the pose at the ends and on the whole chord,
        and a distance within which there is no other pose.
    """

    branch: int
    row: int
    part: int
    level: int
    first: Array
    last: Array
    end: float
    radius: float
    alone: float


@dataclasses.dataclass(eq=False)
class BranchSteps:
    """Follows branches, all of them one step at a time.

    Attributes
    ----------
    system, values, options
        As for `MovingGeometry.follow`.
    exact
        Whether residuals are computed in balls.
    hopeless
        Whether to stop computing in balls at a Study point. Where a platform goes to infinity, the
        steps become shorter without end.
    kept
        The list to which the proved parts are added, or None.
    """

    system: MovingSystem
    values: Array
    options: FollowOptions
    exact: bool = False
    hopeless: Callable[[Array], bool] = lambda point: False
    kept: list[Segment] | None = None
    _models: dict[tuple[int, int], PartModels] = field(default_factory=dict)

    def run(self, trajectory: Index, start: Array, near: Array | None = None) -> Branches:
        """Follow branches from the first row; see `MovingGeometry.follow`."""
        self.found = _not_started(start, self.values.shape[1])
        return self._run(self._started(trajectory, start, near))

    def resumed(self, cursor: _Cursor) -> Branches:
        """Follow one branch from where it is."""
        self.found = _not_started(cursor.z[None], self.values.shape[1])
        return self._run([cursor])

    def _run(self, cursors: list[_Cursor]) -> Branches:
        while cursors:
            cursors = [cursor for cursor in cursors if not self._done(cursor)]
            pieces = [self._piece(cursor) for cursor in cursors]
            for cursor, piece in zip(cursors, pieces, strict=True):
                if piece is None:
                    cursor.halve(1)
            pairs = [(c, p) for c, p in zip(cursors, pieces, strict=True) if p is not None]
            if pairs:
                self._step(*map(list, zip(*pairs, strict=True)))
        return self.found

    def _started(self, trajectory: Index, start: Array, near: Array | None) -> list[_Cursor]:
        if not len(start):
            return []
        first = [self._part(int(t), 0, 0.0, 0.0) for t in trajectory]
        points, converged = newton(self.system.shapes, first, start)
        cursors = []
        for k in np.flatnonzero(converged).tolist():
            self.found.stop[k], self.found.reached[k] = Stop.STEP, 0
            self.found.points[k, 0] = points[k]
            cursors.append(_Cursor(k, int(trajectory[k]), points[k], points[k]))
            if near is not None and near[k] > 0:
                cursors[-1].end = near[k] + float(np.linalg.norm(points[k] - start[k]))
        return cursors

    def _part(self, trajectory: int, row: int, begin: float, end: float) -> MovingQuadrics:
        rows = self.values[trajectory]
        return self.system.on_part((rows[row], rows[min(row + 1, len(rows) - 1)]), begin, end)

    def _done(self, cursor: _Cursor) -> bool:
        """Whether a branch is at the last row, or its steps are too small; then it is noted."""
        found, k = self.found, cursor.branch
        at_end = cursor.row + 1 == self.values.shape[1]
        lasting = cursor.level <= self.options.most_halvings and not self._given_up(cursor)
        if not at_end and lasting:
            return False
        found.stop[k] = Stop.END if at_end else Stop.STEP
        found.reached[k] = cursor.row
        found.fraction[k] = cursor.part * 2.0**-cursor.level
        found.last[k], found.previous[k] = cursor.z, cursor.before
        found.near[k], found.alone[k] = cursor.end, cursor.alone
        return True

    def _given_up(self, cursor: _Cursor) -> bool:
        tries = self.found.tries[cursor.branch]
        if not self.exact or tries < _TRIES:
            return False
        return bool(tries >= _MOST_TRIES) or self.hopeless(cursor.z)

    def _model(self, cursor: _Cursor) -> PartModels:
        key = cursor.trajectory, cursor.row
        if key not in self._models:
            self._models = {k: m for k, m in self._models.items() if k[1] >= cursor.row - 2}
            rows = self.values[cursor.trajectory, cursor.row : cursor.row + 2]
            self._models[key] = PartModels(self.system, (rows[0], rows[1]))
        return self._models[key]

    def _piece(self, cursor: _Cursor) -> MovingQuadrics | None:
        """Return the equations on the next step of a branch, or None if it is too long for them."""
        return self._model(cursor).piece(cursor.part, cursor.level)

    def _step(self, cursors: list[_Cursor], pieces: list[MovingQuadrics]) -> None:
        """Take one step of each branch, or shorten it."""
        parts = Parts.of(self.system.shapes, pieces)
        here = np.stack([cursor.z for cursor in cursors])
        ahead = [c.z + c.ratio * (c.z - c.before) for c in cursors]
        points, converged = newton(self.system.shapes, pieces, np.stack(ahead))
        exact = None
        if self.exact:
            exact = [self._model(c).exact(c.part, c.level) for c in cursors]
            points = corrected(self.system.shapes, pieces, exact, points)
        converged &= np.linalg.norm(points - here, axis=1) < LONGEST
        count = len(cursors)
        measure, end, uniqueness = np.zeros(count), np.zeros(count), np.full(count, np.inf)
        radius = np.full(count, np.inf)
        if self.options.certify:
            proofs = prove(parts, here, points, exact)
            measure, end, uniqueness = proofs.measure, proofs.end, proofs.uniqueness
            radius = proofs.radius
        scaled = SCALED_EXACTLY if self.exact else SCALED
        for k, cursor in enumerate(cursors):
            self.found.tries[cursor.branch] += 1
            # Points are scaled to another patch: a factor of at most four.
            joined = 4 * cursor.end + scaled < uniqueness[k]
            joined |= 4 * end[k] + scaled < cursor.alone
            if not (converged[k] and measure[k] < PROVED and joined):
                cursor.halve(2 if not measure[k] < 4 else 1)
                continue
            if self.kept is not None:
                at = cursor.branch, cursor.row, cursor.part, cursor.level
                ends = here[k], points[k]
                self.kept.append(Segment(*at, *ends, end[k], radius[k], uniqueness[k]))
            cursor.end, cursor.alone = end[k], uniqueness[k]
            cursor.advance(points[k], easy=bool(measure[k] < EASY))
            self.found.segments[cursor.branch] += 1
            self.found.worst[cursor.branch] = max(self.found.worst[cursor.branch], measure[k])
            if cursor.part == 0:
                self.found.points[cursor.branch, cursor.row] = cursor.z


def _not_started(start: Array, rows: int) -> Branches:
    """Return branches at the first row, before any step."""
    count = len(start)
    return Branches(
        points=np.full((count, rows, 8), np.nan),
        stop=np.full(count, Stop.START, np.int32),
        reached=np.full(count, -1, np.int32),
        fraction=np.zeros(count),
        last=start.copy(),
        previous=start.copy(),
        segments=np.zeros(count, np.int64),
        tries=np.zeros(count, np.int64),
        worst=np.zeros(count),
        near=np.zeros(count),
        alone=np.zeros(count),
    )


def follow_closely(
    system: MovingSystem,
    rows: Array,
    branches: Branches,
    k: int,
    options: FollowOptions,
    hopeless: Callable[[Array], bool],
) -> Branches:
    """Follow a branch further from where it ended, to the next row, with residuals in balls.

    Parameters
    ----------
    system
        The moving instance.
    rows
        The row before and the next one, in the units of the instance, shape (2, n).
    branches, k
        The branch.
    options
        As for `MovingGeometry.follow`, except that the step may be halved more often.
    hopeless
        As for `BranchSteps`.
    """
    part, steps = float(branches.fraction[k]).as_integer_ratio()
    level = max(_HALVINGS, steps.bit_length() - 1)
    cursor = _Cursor(0, 0, branches.last[k].copy(), branches.previous[k].copy())
    cursor.part, cursor.level = part * (2**level // steps), level
    cursor.end, cursor.alone = float(branches.near[k]), float(branches.alone[k])
    more = replace(options, most_halvings=_MOST_HALVINGS)
    return BranchSteps(system, rows[None], more, exact=True, hopeless=hopeless).resumed(cursor)


def newton(
    shapes: NDArray[np.int32], parts: Sequence[MovingQuadrics], points: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """Return solutions near points at the end of each part, and whether they were found."""
    quadrics, factors = (np.stack([part.end[k] for part in parts]) for k in (0, 1))
    points = points / np.linalg.norm(points, axis=1, keepdims=True)
    size = np.full(len(points), np.inf)
    bad = np.zeros(len(points), bool)
    for _ in range(_STEPS):
        values, rows = equations_at(shapes, quadrics, factors, points)
        step, good = _newton_step(values, rows, points)
        bad |= ~good
        now = np.linalg.norm(step, axis=1)
        bad |= ~(now < _DIVERGED)
        busy = (size >= _CONVERGED) & ~bad
        points = np.where(busy[:, None], points - np.where(busy[:, None], step, 0.0), points)
        points /= np.linalg.norm(points, axis=1, keepdims=True)
        size = np.where(busy, now, size)
        if not (busy & (size >= _CONVERGED)).any():
            break
    return points, (size < _CONVERGED) & ~bad


def corrected(
    shapes: NDArray[np.int32],
    parts: Sequence[MovingQuadrics],
    exact: Sequence[ExactChords],
    points: Array,
) -> Array:
    """Return points at the end of each part after more steps of Newton's, of exact residuals."""
    quadrics, factors = (np.stack([part.end[k] for part in parts]) for k in (0, 1))
    still, halves = np.zeros(8), 0.5 ** np.arange(VALUES)
    for _ in range(_CORRECTIONS):
        found = [one.residuals(z, still, VALUES)[0] for one, z in zip(exact, points, strict=True)]
        rows = equations_at(shapes, quadrics, factors, points)[1]
        step, good = _newton_step(np.stack(found) @ halves, rows, points)
        size = np.linalg.norm(step, axis=1)
        good &= size < _DIVERGED
        points = np.where(good[:, None], points - np.where(good[:, None], step, 0.0), points)
        points /= np.linalg.norm(points, axis=1, keepdims=True)
        if not (good & (size > SCALED_EXACTLY)).any():
            break
    return points


def _newton_step(values: Array, rows: Array, points: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return steps of Newton's method orthogonal to points, and whether there is one."""
    matrix = np.concatenate((rows, points[:, None]), axis=1)
    right = np.concatenate((values, np.zeros_like(values[:, :1])), axis=1)
    with np.errstate(all="ignore"):
        good = np.abs(np.linalg.det(matrix)) > 0
        matrix = np.where(good[:, None, None], matrix, np.eye(8))
        step: Array = np.linalg.solve(matrix, right[..., None])[..., 0].astype(float)
    return step, good
