"""Which poses keep the ranges and cones of a platform: boxes of them, proved, and their volume.

From a pose to values nothing has to be solved: a pose can be reached if its values are in their
ranges and its legs in their cones. Boxes of poses are judged by interval arithmetic with all
rounding bounded (native/reach.cpp), and those of which nothing is proved are halved in each
direction until they are few enough.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli import _kernel
from gspcli.errors import ArgumentError
from gspcli.geometry.instance import Instance
from gspcli.motion.pose_boxes import (
    NEGATIVE,
    PARAMETERS,
    REGULAR,
    Conditions,
    Keys,
    PoseBoxes,
    places,
)
from gspcli.progress import Progress, silent

Array = NDArray[np.float64]
Levels = NDArray[np.int32]

#: Volumes are sums of many products in floating point, with errors far below this, relatively.
_ROUNDING = 1e-9
_DEEPEST = 20
#: Boxes judged at a time: then Ctrl-C is heard, and whether the bounds are near enough is seen.
_CHUNK = 50_000
#: Half the width of the box about the home pose that must keep the limits, relative to the whole.
_NEAR = 1e-9


@dataclass(frozen=True, eq=False)
class Workspace:
    """Poses that keep all limits, between two sets of boxes.

    Every pose of an inner box keeps them, and every pose outside the inner and the open boxes
    violates one; both are proved.

    Attributes
    ----------
    boxes
        The platform, its home pose and its limits.
    free
        The parameters that vary, of `PARAMETERS`, d of them; the others are those of home.
    connected
        Whether only what is connected with home by poses that are not singular is meant.
    bounds
        The box that was divided, shape (d, 2); lengths, and radians.
    inner_keys, inner_levels, open_keys, open_levels
        Boxes by their keys in the grid of their level.
    judged
        How many boxes were judged.
    """

    boxes: PoseBoxes
    free: tuple[str, ...]
    connected: bool
    bounds: Array
    inner_keys: Keys
    inner_levels: Levels
    open_keys: Keys
    open_levels: Levels
    judged: int

    @property
    def instance(self) -> Instance:
        """The platform."""
        return self.boxes.instance

    @cached_property
    def units(self) -> Array:
        """What the parameters are divided by to be in the units of the instance, shape (d,)."""
        radian = self.instance.units.angle.in_radians
        return np.array([radian if name.startswith("r") else 1.0 for name in self.free])

    @cached_property
    def inner(self) -> Array:
        """Boxes of poses that keep all limits, in the units of the instance, shape (n, d, 2)."""
        return self._corners(self.inner_keys, self.inner_levels) / self.units[:, None]

    @cached_property
    def open(self) -> Array:
        """Boxes of which nothing is proved, likewise; with the inner ones they contain the set."""
        return self._corners(self.open_keys, self.open_levels) / self.units[:, None]

    @cached_property
    def volume(self) -> tuple[float, float]:
        """Proved bounds of the volume, in the units that `measure` names."""
        inner = self._volume(self.inner_keys, self.inner_levels)
        rest = self._volume(self.open_keys, self.open_levels)
        return inner * (1 - _ROUNDING), (inner + rest) * (1 + _ROUNDING)

    @property
    def gap(self) -> float:
        """The difference of the bounds of the volume, relative to the upper one; 0 if that is 0."""
        low, high = self.volume
        return (high - low) / high if high else 0.0

    @property
    def measure(self) -> str:
        """The unit of the volume.

        If all three angles vary it is the share of all rotations, by the measure that no rotation
        changes.
        """
        units = self.instance.units
        lengths = sum(name in "xyz" for name in self.free)
        angles = len(self.free) - lengths
        parts = [_power(units.length, lengths)] if lengths else []
        if angles == 3:
            parts.append("of all rotations")
        elif angles:
            parts.append(_power(units.angle.value, angles))
        return " ".join(parts)

    @cached_property
    def extents(self) -> Array:
        """How far the set reaches in each parameter: proved to reach and to end, shape (d, 2, 2).

        The first pair is the interval that the inner boxes span, the second one that contains the
        set; NaN if there are no boxes.
        """
        found = np.full((len(self.free), 2, 2), np.nan)
        for k, boxes in enumerate((self.inner, np.concatenate((self.inner, self.open)))):
            if len(boxes):
                found[:, k, 0] = boxes[:, :, 0].min(axis=0)
                found[:, k, 1] = boxes[:, :, 1].max(axis=0)
        return found

    def judged_at(self, points: ArrayLike) -> NDArray[np.int8]:
        """Return where points lie: 1 in an inner box, 0 in an open one, -1 outside, shape (n,).

        Parameters
        ----------
        points
            Values of the free parameters, in the units of the instance, shape (n, d).
        """
        given = np.asarray(points, float) * self.units
        low, high = self.bounds.T
        found = np.full(len(given), -1, np.int8)
        with np.errstate(divide="ignore", invalid="ignore"):
            part = (given - low) / (high - low)
        within = ((part >= 0) & (part <= 1)).all(axis=1)
        bits = np.uint64(64 // len(self.free))
        for keys, levels, sign in (
            (self.open_keys, self.open_levels, 0),
            (self.inner_keys, self.inner_levels, 1),
        ):
            for level in np.unique(levels):
                side = 2.0**level
                place = np.minimum(np.where(within[:, None], part, 0) * side, side - 1)
                key = np.zeros(len(given), np.uint64)
                for d in range(len(self.free)):
                    key |= place[:, d].astype(np.uint64) << np.uint64(d * int(bits))
                found[within & np.isin(key, keys[levels == level])] = sign
        return found

    def _corners(self, keys: Keys, levels: Levels) -> Array:
        low, high = self.bounds.T
        step = (high - low) / 2.0 ** levels[:, None]
        place = places(keys, len(self.free))
        return np.stack((low + place * step, low + (place + 1) * step), axis=2)

    def _volume(self, keys: Keys, levels: Levels) -> float:
        dimensions = len(self.free)
        if sum(name.startswith("r") for name in self.free) < 3:
            whole = float(np.prod((self.bounds[:, 1] - self.bounds[:, 0]) / self.units))
            counts = np.bincount(levels, minlength=1).tolist()
            return whole * sum(
                math.ldexp(count, -dimensions * level) for level, count in enumerate(counts)
            )
        corners = self._corners(keys, levels)
        sides = corners[:, :, 1] - corners[:, :, 0]
        # The middle angle of the three counts by the difference of its sine.
        middle = self.free.index(self.boxes.middle)
        sides[:, middle] = np.sin(corners[:, middle, 1]) - np.sin(corners[:, middle, 0])
        return float(sides.prod(axis=1).sum() / (8 * math.pi**2))


def _power(unit: str, exponent: int) -> str:
    return unit if exponent == 1 else f"{unit}^{exponent}"


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
        The platform; constraints without a range and joints without a cone limit nothing.
    R, T
        The home pose, shapes (3, 3) and (3,); what does not vary is as there.
    free
        Parameters that vary, one to six: x, y, z, the position of the pivot, and rx, ry, rz,
        angles from home about axes parallel to those of the base.
    pivot
        The point of the platform, in its frame, that x, y, z are the position of, shape (3,).
    sequence
        The order of the three turns, as `gspcli.geometry.euler` has it.
    within
        For some free parameters the interval to look in, in the units of the instance. Needed for
        x, y, z if no leg (DPP) has a range.
    connected
        Only what can be reached from home by poses that are not singular.
    tolerance
        Boxes are divided until the bounds of the volume differ by this, relatively, or
    most_boxes
        until so many were judged.
    jobs
        Threads; the answer does not depend on them.
    progress
        Told of each level.
    stop
        Asked now and then whether to be content with what is proved so far.

    Raises
    ------
    ArgumentError
        If an argument is wrong, nothing is limited, or, with `connected`, home is not proved to
        keep the limits and to be regular.
    """
    boxes = PoseBoxes(instance, R, T, pivot=pivot, sequence=sequence, regular=connected)
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
        self.judged = 0
        self.inner: list[tuple[Keys, Conditions, int]] = []
        self.open: list[tuple[Keys, Conditions, int]] = []

    def _bounds(self, within: dict[str, tuple[float, float]]) -> Array:
        boxes = self.boxes
        turns = any(name.startswith("r") for name in self.free)
        bounds = boxes.bounds() if turns else boxes.bounds_at((0.0, 0.0, 0.0))
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
        if self.boxes.regular:
            self._check_home()
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
            # Of shares that are weighted, or parts of a connected set, not known before the end.
            near = still <= tolerance * (1 - 10 * _ROUNDING) * (inner + still)
            simple = not (self.boxes.regular or self.weighted)
            if stop() or (near and simple):
                self.open += waiting[k:]
                return
            before = len(self.inner), len(self.open)
            self._judge(level + 1, keys, left, split=True)
            inner += self._share(self.inner[before[0] :])
            still += self._share(self.open[before[1] :]) - self._share([(keys, left, level)])

    def _share(self, boxes: list[tuple[Keys, Conditions, int]]) -> float:
        """Return how much of the whole box some boxes are."""
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

    def _check_home(self) -> None:
        """Note the sign of the determinant at home, if that keeps all limits."""
        boxes = self.boxes
        half = _NEAR * (self.bounds[:, 1] - self.bounds[:, 0])
        if not half[self.indices].all():
            message = "home does not keep the limits"
            raise ArgumentError(message)
        near = np.stack((boxes.home - half, boxes.home + half), axis=1)
        one, left = np.zeros(1, np.uint64), np.array([boxes.conditions])
        found = boxes.judge(near, self.indices, 0, one, left, split=False)
        if not len(found.inside):
            if len(found.open):
                names = boxes.names(int(found.open_left[0]))
                message = f"home is at a limit or singular: {', '.join(names)}"
            else:
                message = "home does not keep the limits"
            raise ArgumentError(message)
        self.sign = found.inside_signs[0] & NEGATIVE

    def _same_sign(self, conditions: Conditions) -> NDArray[np.bool_]:
        """Return which boxes are not proved to have the other sign of the determinant."""
        proved = (conditions & REGULAR) == 0
        return np.asarray(~(proved & ((conditions & NEGATIVE) != self.sign)))

    def _result(self) -> Workspace:
        inner, open_ = (_joined(parts) for parts in (self.inner, self.open))
        if self.boxes.regular:
            inner, open_ = self._connected(inner, open_)
        return Workspace(
            self.boxes,
            self.free,
            self.boxes.regular,
            self.bounds[self.indices],
            inner[0],
            inner[2],
            open_[0],
            open_[2],
            self.judged,
        )

    def _connected(self, inner: _Boxes, open_: _Boxes) -> tuple[_Boxes, _Boxes]:
        """Return the inner boxes that are connected with home, and all that may be, besides."""
        inner, open_ = (_chosen(boxes, self._same_sign(boxes[1])) for boxes in (inner, open_))
        reached = self._part_of_home(inner, touching=False)
        near = self._part_of_home(_together(inner, open_), touching=True)
        count = len(inner[0])
        # Inner boxes that may be connected with home, but are not proved to be.
        maybe = _chosen(inner, near[:count] & ~reached)
        return _chosen(inner, reached), _together(maybe, _chosen(open_, near[count:]))

    def _part_of_home(self, boxes: _Boxes, *, touching: bool) -> NDArray[np.bool_]:
        keys, _, levels = boxes
        turning = {k: self.bounds[k, 1] - self.bounds[k, 0] for k in self.indices if k > 2}
        whole = np.array([turning.get(k, 0.0) > 2 * math.pi - 1e-9 for k in self.indices])
        middle = PARAMETERS.index(self.boxes.middle)
        poles = -1
        if turning.get(middle, 0.0) > math.pi - 1e-9:
            poles = self.indices.index(middle)
        labels = _kernel.connected_boxes(keys, levels, len(self.free), touching, whole, poles)
        at = self._at_home(keys, levels)
        part: NDArray[np.bool_] = np.isin(labels, labels[at])
        return part

    def _at_home(self, keys: Keys, levels: Levels) -> NDArray[np.bool_]:
        """Return which boxes contain the home pose, with its boundary."""
        low, high = self.bounds[self.indices].T
        part = (self.boxes.home[self.indices] - low) / (high - low) * 2.0 ** levels[:, None]
        place = places(keys, len(self.free))
        # At a corner rounding decides: half an ulp more does no harm, for home has room about it.
        room = 1e-12 * np.maximum(1.0, part)
        return np.asarray(((part >= place - room) & (part <= place + 1 + room)).all(axis=1))

    def _keep_connected(self, result: Workspace) -> None:
        """Forget boxes that cannot be connected with home."""
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


_Boxes = tuple[Keys, Conditions, Levels]


def _joined(parts: list[tuple[Keys, Conditions, int]]) -> _Boxes:
    return (
        np.concatenate([np.zeros(0, np.uint64), *(keys for keys, _, _ in parts)]),
        np.concatenate([np.zeros(0, np.uint32), *(left for _, left, _ in parts)]),
        np.concatenate(
            [
                np.zeros(0, np.int32),
                *(np.full(len(keys), level, np.int32) for keys, _, level in parts),
            ]
        ),
    )


def _chosen(boxes: _Boxes, which: NDArray[np.bool_]) -> _Boxes:
    keys, left, levels = boxes
    return keys[which], left[which], levels[which]


def _together(one: _Boxes, other: _Boxes) -> _Boxes:
    return (
        np.concatenate((one[0], other[0])),
        np.concatenate((one[1], other[1])),
        np.concatenate((one[2], other[2])),
    )
