"""The workspace as boxes of poses, which are judged and divided until its volume is accurate.

A pose can be reached if its values, and the motors that move points, are in their ranges and its
legs in their cones; no equation has to be solved for this. Boxes of poses are judged by interval
arithmetic with bounded rounding (native/reach.cpp). Undecided boxes are halved in each direction
until their volume is small enough.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli import _kernel
from gspcli.errors import ArgumentError
from gspcli.geometry.instance import Instance
from gspcli.motion.workspace.pose_boxes import (
    NEGATIVE,
    PARAMETERS,
    REGULAR,
    BoxSet,
    Conditions,
    Keys,
    Layer,
    PoseBoxes,
    places,
)
from gspcli.motion.workspace.workspaces import ROUNDING, Workspace
from gspcli.progress import Progress, silent

Array = NDArray[np.float64]

_DEEPEST = 20
#: Boxes judged at a time; between two calls Ctrl-C and the bounds of the volume are checked.
_CHUNK = 50_000


def workspace(
    instance: Instance,
    R: ArrayLike,
    T: ArrayLike,
    *,
    free: Sequence[str] = ("x", "y", "z"),
    pivot: ArrayLike = (0.0, 0.0, 0.0),
    sequence: str = "ZYX",
    within: dict[str, tuple[float, float]] | None = None,
    connected: bool = False,
    working_modes: ArrayLike | None = None,
    gap: float | None = None,
    tolerance: float = 0.01,
    most_boxes: int = 100_000_000,
    jobs: int = 1,
    progress: Progress = silent,
    stop: Callable[[], bool] = lambda: False,
) -> Workspace:
    """Return the poses that keep the ranges and cones of a platform, between two sets of boxes.

    Parameters
    ----------
    instance
        The platform. Its limits are the ranges of constraints, cranks and slides, the cones of
        joints, and the reach of rods of cranks and slides, in the working modes of the home pose.
    R, T
        The home pose, shapes (3, 3) and (3,); the parameters that do not vary have its numbers.
    free
        Parameters that vary, one to six: x, y, z, the position of the pivot, and rx, ry, rz,
        angles from home about axes parallel to those of the base.
    pivot
        The point of the platform, in its frame, that x, y, z are the position of, shape (3,).
    sequence
        The order of the three turns, as `gspcli.geometry.euler` has it.
    within
        The interval of some free parameters, in the units of the instance. It is needed for x, y, z
        if no leg (DPP) has a range.
    connected
        Whether only the part that can be reached from home by poses that are not singular counts.
    working_modes
        The signs of the gains of cranks and slides, shape (6,). If None they are those of the
        stated home, or, without one, those of the pose.
    gap
        The least gap between legs and bodies; None if gaps are not tested.
        The instance must state their shapes.
    tolerance
        Boxes are divided until the relative difference of the bounds of the volume is at most this,
    most_boxes
        or until this many boxes were tested.
    jobs
        Threads; the answer does not depend on them.
    progress
        Receives the bounds after each level.
    stop
        Called from time to time; if it returns True, the result so far is returned.

    Raises
    ------
    ArgumentError
        If an argument is wrong, nothing is limited, rods that share a drive are not parallel, or,
        with `connected`, home is not proved to keep the limits and to be regular.
    """
    boxes = PoseBoxes(
        instance,
        R,
        T,
        pivot=pivot,
        sequence=sequence,
        regular=connected,
        working_modes=working_modes,
        gap=gap,
    )
    boxes.refuse_shared(boxes.R, _names(free))
    division = _Division(boxes, _names(free), dict(within or {}), jobs)
    return division.run(tolerance, lambda: division.judged >= most_boxes or stop(), progress)


def _names(free: Sequence[str]) -> tuple[str, ...]:
    names = tuple(name for name in PARAMETERS if name in free)
    if len(names) != len(free) or not names:
        message = f"found {', '.join(free) or 'nothing'}, expected one or more of "
        raise ArgumentError(message + ", ".join(PARAMETERS), "free")
    return names


class _Division:
    """Boxes that are judged and divided."""

    def __init__(
        self,
        boxes: PoseBoxes,
        free: tuple[str, ...],
        within: dict[str, tuple[float, float]],
        jobs: int,
    ) -> None:
        self.boxes, self.free, self.jobs = boxes, free, jobs
        self.indices = [PARAMETERS.index(name) for name in free]
        self.weighted = sum(k > 2 for k in self.indices) == 3
        if not boxes.conditions & ~REGULAR:
            message = "no constraint has a range and no joint a cone: every pose can be reached"
            raise ArgumentError(message)
        self.bounds = self._bounds(within)
        boxes.refuse_fixed(self.bounds, self.indices)
        self.home = HomePart(boxes, self.bounds, self.indices) if boxes.regular else None
        self.judged = 0
        self.inner: list[Layer] = []
        self.open: list[Layer] = []

    def _bounds(self, within: dict[str, tuple[float, float]]) -> Array:
        boxes = self.boxes
        turns = any(name.startswith("r") for name in self.free)
        bounds = boxes.bounds() if turns else boxes.unturned_bounds()
        radian = boxes.instance.units.angle.in_radians
        for name in within:
            if name not in self.free:
                message = f"found {name}, expected a parameter that varies: {', '.join(self.free)}"
                raise ArgumentError(message, "within")
        for k, name in enumerate(PARAMETERS):
            if name not in self.free:
                bounds[k] = boxes.home[k]
            elif name in within:
                low, high = (end * (radian if k > 2 else 1.0) for end in within[name])
                if not (math.isfinite(low) and math.isfinite(high) and low < high):
                    message = f"found {within[name]}, expected a finite interval (low, high)"
                    raise ArgumentError(message, f"within[{name}]")
                room = 1e-12 * (high - low)
                if k > 2 and (low < bounds[k, 0] - room or high > bounds[k, 1] + room):
                    message = f"found {within[name]}, expected at most a whole turn"
                    raise ArgumentError(message, f"within[{name}]")
                bounds[k] = low, high
            elif not np.isfinite(bounds[k]).all():
                message = f"no leg with a range bounds {name}: give the interval to look in"
                raise ArgumentError(message, "within")
        return bounds

    def run(self, tolerance: float, stop: Callable[[], bool], progress: Progress) -> Workspace:
        """Judge and divide until the bounds are near enough."""
        start = self.bounds[self.indices]
        if not (start[:, 0] < start[:, 1]).all():
            return self._result()
        self._judge(0, np.zeros(1, np.uint64), np.array([self.boxes.conditions]), split=False)
        deepest = min(_DEEPEST if len(self.free) > 2 else 30, 62 // len(self.free))
        for _ in progress(range(deepest), label="dividing"):
            result = self._result()
            if result.gap <= tolerance or stop():
                return result
            if self.boxes.regular:
                self._keep_connected(result)
            self._divide(tolerance, stop)
        return self._result()

    def _divide(self, tolerance: float, stop: Callable[[], bool]) -> None:
        """Divide all open boxes, the largest first and a part at a time, as long as needed."""
        waiting = [
            (keys[start : start + _CHUNK], left[start : start + _CHUNK], level)
            for keys, left, level in sorted(self.open, key=lambda boxes: boxes[2])
            for start in range(0, len(keys), _CHUNK)
        ]
        self.open = []
        inner = self._share(self.inner)
        still = self._share(waiting)
        for k, (keys, left, level) in enumerate(waiting):
            # Weighted shares and parts of a connected set are computed only at the end.
            near = still <= tolerance * (1 - 10 * ROUNDING) * (inner + still)
            simple = not (self.boxes.regular or self.weighted)
            if stop() or (near and simple):
                self.open += waiting[k:]
                return
            before = len(self.inner), len(self.open)
            self._judge(level + 1, keys, left, split=True)
            inner += self._share(self.inner[before[0] :])
            still += self._share(self.open[before[1] :]) - self._share([(keys, left, level)])

    def _share(self, boxes: list[Layer]) -> float:
        """Return the share of some boxes in the whole box."""
        return sum(math.ldexp(len(keys), -len(self.free) * level) for keys, _, level in boxes)

    def _judge(self, level: int, keys: Keys, left: Conditions, *, split: bool) -> None:
        found = self.boxes.judge(
            self.bounds, self.indices, level, keys, left, split=split, jobs=self.jobs
        )
        self.judged += len(keys) << (len(self.free) if split else 0)
        if len(found.inside):
            self.inner.append((found.inside, found.inside_signs, level))
        if len(found.open):
            self.open.append((found.open, found.open_left, level))

    def _result(self) -> Workspace:
        inner, open_ = (BoxSet.of(parts) for parts in (self.inner, self.open))
        if self.home:
            inner, open_ = self.home.split(inner, open_)
        return Workspace(
            self.boxes,
            self.free,
            self.boxes.regular,
            self.bounds[self.indices],
            inner.keys,
            inner.levels,
            open_.keys,
            open_.levels,
            self.judged,
        )

    def _keep_connected(self, result: Workspace) -> None:
        """Remove boxes that cannot be connected with home."""
        near = {
            level: np.concatenate(
                (
                    result.inner_keys[result.inner_levels == level],
                    result.open_keys[result.open_levels == level],
                )
            )
            for level in range(_DEEPEST + 12)
        }
        for boxes in (self.inner, self.open):
            boxes[:] = [
                (keys[kept], left[kept], level)
                for keys, left, level in boxes
                if (kept := np.isin(keys, near[level])).any()
            ]


#: Half the width of the box about the home pose that must keep the limits, relative to the whole.
_NEAR = 1e-9


class HomePart:
    """The boxes that are connected with home by poses that are not singular.

    The determinant of the Jacobian matrix keeps its sign on such a set. Two boxes that share a
    side, both with the proved sign of home, are connected; boxes that only touch may be connected.

    Parameters
    ----------
    boxes
        The platform, its home pose and its limits.
    bounds
        The box that is divided, all six parameters, shape (6, 2).
    indices
        The indices of the parameters that vary.

    Raises
    ------
    ArgumentError
        If home is not proved to keep all limits and to be regular.
    """

    def __init__(self, boxes: PoseBoxes, bounds: Array, indices: list[int]) -> None:
        self.boxes, self.bounds, self.indices = boxes, bounds, indices
        half = _NEAR * (bounds[:, 1] - bounds[:, 0])
        if not half[indices].all():
            message = "home does not keep the limits"
            raise ArgumentError(message)
        near = np.stack((boxes.home - half, boxes.home + half), axis=1)
        one, left = np.zeros(1, np.uint64), np.array([boxes.conditions])
        found = boxes.judge(near, indices, 0, one, left, split=False)
        if not len(found.inside):
            if len(found.open):
                names = boxes.names(int(found.open_left[0]))
                message = f"home is at a limit or singular: {', '.join(names)}"
            else:
                message = "home does not keep the limits"
            raise ArgumentError(message)
        self._sign = found.inside_signs[0] & NEGATIVE

    def split(self, inner: BoxSet, open_: BoxSet) -> tuple[BoxSet, BoxSet]:
        """Return the inner boxes that are connected with home, and the other boxes that may be."""
        inner, open_ = (boxes.chosen(self._same_sign(boxes.conditions)) for boxes in (inner, open_))
        reached = self._connected(inner, touching=False)
        near = self._connected(inner.and_also(open_), touching=True)
        count = len(inner.keys)
        # Inner boxes that may be connected with home, but are not proved to be.
        maybe = inner.chosen(near[:count] & ~reached)
        return inner.chosen(reached), maybe.and_also(open_.chosen(near[count:]))

    def _connected(self, boxes: BoxSet, *, touching: bool) -> NDArray[np.bool_]:
        """Return which boxes are connected with one that contains home, by such boxes."""
        turning = {k: self.bounds[k, 1] - self.bounds[k, 0] for k in self.indices if k > 2}
        whole = np.array([turning.get(k, 0.0) > 2 * math.pi - 1e-9 for k in self.indices])
        middle = PARAMETERS.index(self.boxes.middle)
        poles = -1
        if turning.get(middle, 0.0) > math.pi - 1e-9:
            poles = self.indices.index(middle)
        count = len(self.indices)
        labels = _kernel.connected_boxes(boxes.keys, boxes.levels, count, touching, whole, poles)
        part: NDArray[np.bool_] = np.isin(labels, labels[self._at_home(boxes)])
        return part

    def _at_home(self, boxes: BoxSet) -> NDArray[np.bool_]:
        """Return which boxes contain the home pose, with its boundary."""
        low, high = self.bounds[self.indices].T
        part = (self.boxes.home[self.indices] - low) / (high - low) * 2.0 ** boxes.levels[:, None]
        place = places(boxes.keys, len(self.indices))
        # At a corner of a box rounding errors would decide, so there is a margin. It is safe: the
        # box about home keeps the limits.
        room = 1e-12 * np.maximum(1.0, part)
        return np.asarray(((part >= place - room) & (part <= place + 1 + room)).all(axis=1))

    def _same_sign(self, conditions: Conditions) -> NDArray[np.bool_]:
        """Return which boxes are not proved to have the opposite sign of the determinant."""
        proved = (conditions & REGULAR) == 0
        return np.asarray(~(proved & ((conditions & NEGATIVE) != self._sign)))
