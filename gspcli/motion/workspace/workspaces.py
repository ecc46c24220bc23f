"""The workspace as boxes of poses, which are judged and divided until its volume is accurate.

A pose can be reached if its values, and the motors that move points, are in their ranges and its
legs in their cones; no equation has to be solved for this. Boxes of poses are judged by interval
arithmetic with bounded rounding (native/reach.cpp). Undecided boxes are halved in each direction
until their volume is small enough.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli import _kernel
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.euler import euler_from_rotation
from gspcli.geometry.instance import Instance
from gspcli.motion.workspace.pose_boxes import (
    NEGATIVE,
    PARAMETERS,
    REGULAR,
    BoxSet,
    Conditions,
    PoseBoxes,
    places,
)
from gspcli.progress import Progress, silent
from gspcli.records import Tabular, dataclass

Array = NDArray[np.float64]

_DEEPEST = 20
#: Boxes judged at a time; between two calls Ctrl-C and the bounds of the volume are checked.
_CHUNK = 50_000
#: Relative error of volumes: they are sums of many products in floating point, far more accurate.
_ROUNDING = 1e-9
#: Parameters that differ by less, in lengths of the platform and radians, are the same.
_SAME = 1e-7


@dataclass(frozen=True, eq=False)
class Workspace(Tabular):
    """The poses that keep all limits, enclosed between two sets of boxes.

    It is proved that every pose of an inner box keeps the limits, and that every pose outside the
    inner and the open boxes violates one.

    Attributes
    ----------
    boxes
        The platform, its home pose and its limits.
    free
        The parameters that vary, of `PARAMETERS`, d of them; the others are those of home.
    connected
        Whether only the part counts that is connected with home by poses that are not singular.
    bounds
        The box that was divided, shape (d, 2); lengths, and radians.
    inner_boxes, open_boxes
        Boxes by their keys in the grid of their level.
    judged
        The number of boxes that were tested.
    """

    boxes: PoseBoxes
    free: tuple[str, ...]
    connected: bool
    bounds: Array
    inner_boxes: BoxSet
    open_boxes: BoxSet
    judged: int

    def __repr__(self) -> str:
        low, high = self.volume
        kinds = self.instance.name or self.instance.type.id
        return f"<Workspace of {kinds}: {low:.6g} to {high:.6g} {self.measure}>"

    def rows(self) -> list[dict[str, Any]]:
        """Return the extent of the set in each parameter, as plain data."""
        rows = []
        for name, ends in zip(self.free, self.extents.tolist(), strict=True):
            (low, high), (least, most) = (
                [None if end != end else end for end in pair] for pair in ends
            )
            row = {"name": name, "least": least, "lowest": low, "highest": high, "most": most}
            rows.append(row)
        return rows

    def to_json(self) -> dict[str, Any]:
        """Return the numbers of the volume that `gsp workspace` prints, as plain data."""
        low, high = self.volume
        return {
            "volume": {"lower": low, "upper": high, "unit": self.measure, "gap": self.gap},
            "extents": self.rows(),
            "inner": len(self.inner_boxes.keys),
            "open": len(self.open_boxes.keys),
            "judged": self.judged,
        }

    @property
    def instance(self) -> Instance:
        """The platform."""
        return self.boxes.instance

    @cached_property
    def units(self) -> Array:
        """The divisors that convert parameters to the units of the instance, shape (d,)."""
        radian = self.instance.units.angle.in_radians
        return np.array([radian if name.startswith("r") else 1.0 for name in self.free])

    @cached_property
    def inner(self) -> Array:
        """Boxes of poses that keep all limits, in the units of the instance, shape (n, d, 2)."""
        return self.inner_boxes.corners(self.bounds) / self.units[:, None]

    @cached_property
    def open(self) -> Array:
        """Undecided boxes, shape (n, d, 2); together with the inner boxes they contain the set."""
        return self.open_boxes.corners(self.bounds) / self.units[:, None]

    @cached_property
    def volume(self) -> tuple[float, float]:
        """Proved bounds of the volume, in the units that `measure` names."""
        inner, rest = map(self._volume, (self.inner_boxes, self.open_boxes))
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
        """The extent of the set in each parameter, proved from both sides, shape (d, 2, 2).

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
        """Return the place of points: 1 in an inner box, 0 in an open one, -1 outside, shape (n,).

        Parameters
        ----------
        points
            Values of the free parameters, in the units of the instance, shape (n, d). Angles may be
            any that give the rotation, the middle one beyond a right angle, too.
        """
        given = self._as_bounded(np.asarray(points, float) * self.units)
        low, high = self.bounds.T
        found = np.full(len(given), -1, np.int8)
        with np.errstate(divide="ignore", invalid="ignore"):
            part = (given - low) / (high - low)
        within = ((part >= 0) & (part <= 1)).all(axis=1)
        bits = np.uint64(64 // len(self.free))
        for boxes, sign in ((self.open_boxes, 0), (self.inner_boxes, 1)):
            for level in np.unique(boxes.levels):
                side = 2.0**level
                place = np.minimum(np.where(within[:, None], part, 0) * side, side - 1)
                key = np.zeros(len(given), np.uint64)
                for d in range(len(self.free)):
                    key |= place[:, d].astype(np.uint64) << np.uint64(d * int(bits))
                found[within & np.isin(key, boxes.keys[boxes.levels == level])] = sign
        return found

    def _as_bounded(self, given: Array) -> Array:
        """Return the same poses with angles by whole turns near the middle of their bounds.

        Each rotation has two triples of angles; that with the middle angle within a right angle.
        """
        given = given.copy()
        turns = [k for k, name in enumerate(self.free) if name.startswith("r")]
        centre = self.bounds.mean(axis=1)
        if len(turns) == 3:
            middle = self.free.index(self.boxes.middle)
            beyond = np.cos(given[:, middle]) < 0
            other = given.copy()
            other[:, turns] += np.pi
            other[:, middle] = np.pi - given[:, middle]
            given = np.where(beyond[:, None], other, given)
        whole = 2 * np.pi * np.round((given - centre)[:, turns] / (2 * np.pi))
        given[:, turns] -= whole
        return given

    def judged_poses(self, R: ArrayLike, T: ArrayLike) -> NDArray[np.int8]:
        """Return the place of poses as `judged_at`; -1 if a parameter that is not free differs.

        Parameters
        ----------
        R, T
            Poses, shapes (n, 3, 3) and (n, 3).
        """
        R, T = np.asarray(R, float), np.asarray(T, float)
        parameters = np.zeros((len(R), 6))
        parameters[:, :3] = T + R @ self.boxes.pivot
        parameters[:, 3:] = euler_from_rotation(self.boxes.sequence, R @ self.boxes.R.T)
        size = np.array([Arrangement.of(self.instance).length] * 3 + [1.0] * 3)
        indices = [PARAMETERS.index(name) for name in self.free]
        fixed = [k for k in range(6) if k not in indices]
        off = np.abs(parameters - self.boxes.home)[:, fixed] / size[fixed]
        found = self.judged_at(parameters[:, indices] / self.units)
        return np.where((off < _SAME).all(axis=1), found, -1).astype(np.int8)

    def _volume(self, boxes: BoxSet) -> float:
        dimensions = len(self.free)
        if sum(name.startswith("r") for name in self.free) < 3:
            whole = float(np.prod((self.bounds[:, 1] - self.bounds[:, 0]) / self.units))
            counts = np.bincount(boxes.levels, minlength=1).tolist()
            return whole * sum(
                math.ldexp(count, -dimensions * level) for level, count in enumerate(counts)
            )
        corners = boxes.corners(self.bounds)
        sides = corners[:, :, 1] - corners[:, :, 0]
        # The measure of the second angle is the difference of its sine.
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
    pivot, sequence
        As for `PoseBoxes`.
    within
        The interval of some free parameters, in the units of the instance. It is needed for x, y, z
        if no leg (DPP) has a range.
    connected
        Whether only the part that can be reached from home by poses that are not singular counts.
    working_modes, gap
        As for `PoseBoxes`.
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
        self.inner: list[BoxSet] = []
        self.open: list[BoxSet] = []

    def _bounds(self, within: dict[str, tuple[float, float]]) -> Array:
        boxes = self.boxes
        turns = any(name.startswith("r") for name in self.free)
        bounds = boxes.bounds(turning=turns)
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
        whole = BoxSet.of_level(np.zeros(1, np.uint64), np.array([self.boxes.conditions]), 0)
        self._judge(0, whole, split=False)
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
            boxes.chosen(slice(start, start + _CHUNK))
            for boxes in sorted(self.open, key=lambda boxes: int(boxes.levels[0]))
            for start in range(0, len(boxes.keys), _CHUNK)
        ]
        self.open = []
        inner = self._share(self.inner)
        still = self._share(waiting)
        for k, boxes in enumerate(waiting):
            # Weighted shares and parts of a connected set are computed only at the end.
            near = still <= tolerance * (1 - 10 * _ROUNDING) * (inner + still)
            simple = not (self.boxes.regular or self.weighted)
            if stop() or (near and simple):
                self.open += waiting[k:]
                return
            before = len(self.inner), len(self.open)
            self._judge(int(boxes.levels[0]) + 1, boxes, split=True)
            inner += self._share(self.inner[before[0] :])
            still += self._share(self.open[before[1] :]) - self._share([boxes])

    def _share(self, parts: list[BoxSet]) -> float:
        """Return the share of boxes, each part of one level, in the whole box."""
        return sum(
            math.ldexp(len(boxes.keys), -len(self.free) * int(boxes.levels[0])) for boxes in parts
        )

    def _judge(self, level: int, boxes: BoxSet, *, split: bool) -> None:
        """Judge boxes of a level, or the parts of boxes of the level before."""
        inside, signs, open_, left = self.boxes.judge(
            self.bounds, self.indices, level, *boxes[:2], split=split, jobs=self.jobs
        )
        self.judged += len(boxes.keys) << (len(self.free) if split else 0)
        self.inner += [BoxSet.of_level(inside, signs, level)] if len(inside) else []
        self.open += [BoxSet.of_level(open_, left, level)] if len(open_) else []

    def _result(self) -> Workspace:
        inner, open_ = map(BoxSet.joined, (self.inner, self.open))
        if self.home:
            inner, open_ = self.home.split(inner, open_)
        bounds, connected = self.bounds[self.indices], self.boxes.regular
        return Workspace(self.boxes, self.free, connected, bounds, inner, open_, self.judged)

    def _keep_connected(self, result: Workspace) -> None:
        """Remove boxes that cannot be connected with home."""
        near = BoxSet.joined((result.inner_boxes, result.open_boxes))
        for parts in (self.inner, self.open):
            parts[:] = [
                boxes.chosen(kept)
                for boxes in parts
                if (kept := np.isin(boxes.keys, near.keys[near.levels == boxes.levels[0]])).any()
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
        near = self._connected(BoxSet.joined((inner, open_)), touching=True)
        count = len(inner.keys)
        # Inner boxes that may be connected with home, but are not proved to be.
        maybe = inner.chosen(near[:count] & ~reached)
        return inner.chosen(reached), BoxSet.joined((maybe, open_.chosen(near[count:])))

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
