"""Assembly modes followed while values and coordinates move, each step proved (`chords`).

The slower sibling of `MovingPlatform`, which moves values only: the equations of each step are
found in ball arithmetic, and the steps of all branches are taken together in NumPy.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.taylor import MovingQuadrics, MovingSystem
from gspcli.geometry.coordinates import Coordinate, moved
from gspcli.geometry.instance import Instance
from gspcli.motion.chords import DEGREE, LONGEST, Parts, equations_at, prove
from gspcli.motion.following import Branches, FollowOptions, Stop, StudyUnits

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Newton's method: a correction below this leaves an error of its square; its most steps.
_CONVERGED, _DIVERGED, _STEPS = 1e-8, 0.5, 6
_PROVED = 0.98
#: A step is doubled when its measure is below this.
_EASY = 0.35
#: What a polynomial of one part may leave out, relatively; else the part is halved.
_LEFT_OUT = 2.0**-38


@dataclass(eq=False)
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
    end: float = 0.0

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


class MovingGeometry(StudyUnits):
    """An instance whose values and coordinates move, made ready for following branches.

    It is used like `MovingPlatform`; the rows have the six values and then the coordinates, in the
    units of the instance, inside as outside.

    Parameters
    ----------
    instance
        Units, and whatever does not move.
    chosen
        The coordinates that move.
    """

    def __init__(self, instance: Instance, chosen: Sequence[Coordinate]) -> None:
        self.instance = instance
        self.chosen = tuple(chosen)
        self.system = MovingSystem(instance, chosen)
        super().__init__(self.system.scale)

    def internal(self, rows: Array) -> Array:
        """Return rows as they are."""
        return np.ascontiguousarray(rows)

    def instance_at(self, row: Array) -> Instance:
        """Return the instance with the coordinates of a row; its values are not used."""
        return moved(self.instance, self.chosen, row[6:])

    def jacobian(self, point: Array, row: Array) -> Array:
        """Return the derivatives of the seven equations at a Study point, shape (7, 8)."""
        part = self.system.on_part((row, row), 0.0, 0.0)
        quadrics, factors = part.quadrics[None, :, :, 0], part.factors[None, :, 0]
        rows: Array = equations_at(self.system.shapes, quadrics, factors, point[None])[1][0]
        return rows

    def follow(
        self,
        values: Array,
        trajectory: Index,
        start: Array,
        options: FollowOptions,
    ) -> Branches:
        """Follow branches along trajectories, which are linear between their rows.

        Parameters
        ----------
        values
            Rows, shape (trajectories, rows, 6 + coordinates).
        trajectory, start, options
            As for `MovingPlatform.follow`; `FollowOptions.jobs` and ``build`` are not used.
        """
        return _Follower(self.system, values, options).run(trajectory, start)


@dataclass(eq=False)
class _Follower:
    """Follows branches, all of them one step at a time."""

    system: MovingSystem
    values: Array
    options: FollowOptions
    _models: dict[tuple[int, int], _Models] = field(default_factory=dict)

    def run(self, trajectory: Index, start: Array) -> Branches:
        """Follow all branches."""
        count, rows = len(start), self.values.shape[1]
        self.found = Branches(
            np.full((count, rows, 8), np.nan),
            np.full(count, Stop.START, np.int32),
            np.full(count, -1, np.int32),
            np.zeros(count),
            start.copy(),
            start.copy(),
            np.zeros(count, np.int64),
            np.zeros(count, np.int64),
            np.zeros(count),
        )
        cursors = self._started(trajectory, start)
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

    def _started(self, trajectory: Index, start: Array) -> list[_Cursor]:
        if not len(start):
            return []
        first = [self._part(int(t), 0, 0.0, 0.0) for t in trajectory]
        points, converged = newton(self.system.shapes, first, start)
        cursors = []
        for k in np.flatnonzero(converged).tolist():
            self.found.stop[k], self.found.reached[k] = Stop.STEP, 0
            self.found.points[k, 0] = points[k]
            cursors.append(_Cursor(k, int(trajectory[k]), points[k], points[k]))
        return cursors

    def _part(self, trajectory: int, row: int, begin: float, end: float) -> MovingQuadrics:
        rows = self.values[trajectory]
        return self.system.on_part((rows[row], rows[min(row + 1, len(rows) - 1)]), begin, end)

    def _done(self, cursor: _Cursor) -> bool:
        """Whether a branch is at the last row, or its steps are too small; then it is noted."""
        found, k = self.found, cursor.branch
        at_end = cursor.row + 1 == self.values.shape[1]
        if not at_end and cursor.level <= self.options.most_halvings:
            return False
        found.stop[k] = Stop.END if at_end else Stop.STEP
        found.reached[k] = cursor.row
        found.fraction[k] = cursor.part * 2.0**-cursor.level
        found.last[k], found.previous[k] = cursor.z, cursor.before
        return True

    def _piece(self, cursor: _Cursor) -> MovingQuadrics | None:
        """Return the equations on the next step of a branch, or None if it is too long for them."""
        key = cursor.trajectory, cursor.row
        if key not in self._models:
            self._models = {k: m for k, m in self._models.items() if k[1] >= cursor.row - 2}
            rows = self.values[cursor.trajectory, cursor.row : cursor.row + 2]
            self._models[key] = _Models(self.system, (rows[0], rows[1]))
        return self._models[key].piece(cursor.part, cursor.level)

    def _step(self, cursors: list[_Cursor], pieces: list[MovingQuadrics]) -> None:
        """Take one step of each branch, or shorten it."""
        parts = Parts.of(self.system.shapes, pieces)
        here = np.stack([cursor.z for cursor in cursors])
        ahead = [c.z + c.ratio * (c.z - c.before) for c in cursors]
        points, converged = newton(self.system.shapes, pieces, np.stack(ahead))
        converged &= np.linalg.norm(points - here, axis=1) < LONGEST
        count = len(cursors)
        measure, end, uniqueness = np.zeros(count), np.zeros(count), np.full(count, np.inf)
        if self.options.certify:
            proofs = prove(parts, here, points)
            measure, end, uniqueness = proofs.measure, proofs.end, proofs.uniqueness
        for k, cursor in enumerate(cursors):
            self.found.tries[cursor.branch] += 1
            # Points are scaled to another patch: a factor of at most four.
            joined = 4 * cursor.end + 2.0**-40 < uniqueness[k]
            if not (converged[k] and measure[k] < _PROVED and joined):
                cursor.halve(2 if not measure[k] < 4 else 1)
                continue
            cursor.end = end[k]
            cursor.advance(points[k], easy=bool(measure[k] < _EASY))
            self.found.segments[cursor.branch] += 1
            self.found.worst[cursor.branch] = max(self.found.worst[cursor.branch], measure[k])
            if cursor.part == 0:
                self.found.points[cursor.branch, cursor.row] = cursor.z


class _Models:
    """The equations between two rows: polynomials on as many parts as are needed."""

    def __init__(self, system: MovingSystem, rows: tuple[Array, Array]) -> None:
        self.system = system
        self.rows = rows
        self._of_part = lru_cache(maxsize=None)(self._found)
        self.piece = lru_cache(maxsize=256)(self._piece)

    def _found(self, part: int, level: int) -> MovingQuadrics | None:
        """Return the equations on a part, if polynomials leave out little."""
        size = 2.0**-level
        found = self.system.on_part(self.rows, part * size, (part + 1) * size)
        scale = np.sqrt((found.quadrics[:, :, 0] ** 2).sum(axis=(2, 3)))
        good = (found.errors <= _LEFT_OUT * scale + 2.0**-60).all()
        good &= (found.factor_errors <= _LEFT_OUT).all()
        return found if good else None

    def _piece(self, part: int, level: int) -> MovingQuadrics | None:
        """Return the equations on a part, from the longest part around it that has any."""
        for k in range(level + 1):
            around = self._of_part(part >> (level - k), k)
            if around is not None:
                size = 2.0 ** (k - level)
                begin = (part - ((part >> (level - k)) << (level - k))) * size - 0.5
                return around.restricted(begin, begin + size, DEGREE)
        return None


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
        matrix = np.concatenate((rows, points[:, None]), axis=1)
        with np.errstate(all="ignore"):
            bad |= ~(np.abs(np.linalg.det(matrix)) > 0)
            matrix = np.where(bad[:, None, None], np.eye(8), matrix)
            right = np.concatenate((values, np.zeros_like(values[:, :1])), axis=1)
            step = np.linalg.solve(matrix, right[..., None])[..., 0]
        now = np.linalg.norm(step, axis=1)
        bad |= ~(now < _DIVERGED)
        busy = (size >= _CONVERGED) & ~bad
        points = np.where(busy[:, None], points - np.where(busy[:, None], step, 0.0), points)
        points /= np.linalg.norm(points, axis=1, keepdims=True)
        size = np.where(busy, now, size)
        if not (busy & (size >= _CONVERGED)).any():
            break
    return points, (size < _CONVERGED) & ~bad
