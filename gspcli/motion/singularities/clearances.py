"""Clearance: how far values, drives or the pose may change before a mode meets a singularity.

The distance of two sets of values, or of drives, is the largest difference of one, divided by its
weight. A clearance of r means that all together may change by up to r times their weights, in any
combination.

Of values the lower bound is proved: up to it the pose has exactly one continuation, which is
regular. The upper bound is the nearest fold that was found by following the mode with proof.
Of drives two numbers are proved: the same, and up to where no drive comes to a dead point, so that
all keep their knees. The nearest fold and the nearest dead point that were found bound them:
numbers, not proofs.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.certification.poses.multiple import nearly_parallel
from gspcli.defaults import SEED
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.checking import value_range
from gspcli.geometry.drives import Drives, is_driven
from gspcli.geometry.instance import Instance
from gspcli.geometry.measurement import measured
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.geometry.readings import readings_of
from gspcli.motion.following.branch_follower import MovingPlatform, Stop, apart
from gspcli.motion.following.row_instances import over_rows
from gspcli.motion.following.tracks import Event
from gspcli.motion.following.trajectories import track_from
from gspcli.motion.poses.inverse_kinematics import (
    checked_poses,
    drive_values,
    measure,
    value_slopes,
    values_at,
)
from gspcli.motion.singularities.neighbourhoods import DrivenNeighbourhood, Neighbourhood
from gspcli.motion.singularities.pose_clearances import PoseClearance, pose_clearance
from gspcli.progress import Progress, silent
from gspcli.records import EqualByContent, dataclass
from gspcli.ties import ALIKE, definite_signs, definite_vectors, first_smallest
from gspcli.wording import counted

if TYPE_CHECKING:
    import pandas as pd


Array = NDArray[np.float64]

#: Halvings of the interval in which the clearance is sought, after a first estimate.
_HALVINGS = 7
_REFINEMENTS = 7
#: Straight lines of values and drives are followed up to this many weights.
_FARTHEST = 1e3
#: The part of the way to the end of a range up to which a mode is followed.
_SHORT = 1 - 1e-6
#: Lines are followed this much farther than to the nearest fold, since symmetric ones are as near.
_BEYOND = 1 + 1e-6
#: First directions of the search for the nearest singularity, and rounds that improve each.
_STARTS, _MANY_STARTS, _ROUNDS = 6, 30, 6
#: Halvings of the interval of a clearance, and the ratio of its ends that suffices.
_DRIVE_HALVINGS, _CLOSE = 60, 1.002
#: Steps along a line of drives: the first in clearances, their growth, and the least relatively.
_FIRST, _GROWTH, _LEAST, _STEPS = 1.0, 1.5, 1e-7, 400
#: Folds of drives whose distances differ by less than this part are equally near.
_NEAR = 4 * _LEAST
#: Iterations of Newton's method, its residual, and the farthest that a step may move the pose.
_ITERATIONS, _RESIDUAL, _JUMP = 8, 1e-11, 0.1
#: The quantities that may change.
KINDS = ("values", "drives", "pose")


def clearances(
    instance: Instance, R: ArrayLike, T: ArrayLike, *, weights: ArrayLike | None = None
) -> Array:
    """Return proved lower bounds of the clearance of poses, shape (n,); zero if there is no proof.

    For all values within the clearance the pose has exactly one continuation, which is regular.

    Parameters
    ----------
    instance
        Geometry and units; its values are not used.
    R, T
        Poses, shapes (n, 3, 3) and (n, 3).
    weights
        The unit of each value's changes, in the units of the instance, shape (6,); ones if None.
    """
    R, T = np.asarray(R, float), np.asarray(T, float)
    # The distance of parallel lines jumps when they tilt.
    parallel = nearly_parallel(instance, R.astype(complex)).any(axis=1)
    if parallel.any():
        proved = np.zeros(len(R))
        if not parallel.all():
            proved[~parallel] = clearances(instance, R[~parallel], T[~parallel], weights=weights)
        return proved
    platform = MovingPlatform(apart(instance))
    widths = platform.internal(_weights(weights))
    values = platform.internal(values_at(instance, R, T))
    near = Neighbourhood(platform, platform.points(R, T), values)
    scale = _estimate(near, widths)
    low, high = np.zeros_like(scale), scale
    for k in range(_HALVINGS):
        middle = high * 0.9 if k == 0 else (low + high) / 2
        good = near.box(middle[:, None] * widths).measure < 1
        low, high = np.where(good, middle, low), np.where(good, high, middle)
    return low


def range_weights(instance: Instance) -> Array | None:
    """Return half the ranges of the values, shape (6,); None unless each constraint has one."""
    limits = [constraint.limits for constraint in instance.constraints]
    spans = [(high.value - low.value) / 2 for low, high in (pair for pair in limits if pair)]
    return np.array(spans) if len(spans) == len(limits) and min(spans) > 0 else None


def _weights(given: ArrayLike | None) -> Array:
    weights = np.ones(6) if given is None else np.asarray(given, float)
    if weights.shape != (6,) or not (np.isfinite(weights) & (weights > 0)).all():
        message = f"found {weights.tolist()}, expected six positive numbers"
        raise ArgumentError(message, "weights")
    return weights


def _estimate(near: Neighbourhood, widths: Array) -> Array:
    """Return about twice the largest changes that can be proved, shape (n,)."""
    size = np.full(len(near.points), 1e-6)
    for _ in range(3):
        box = near.box(size[:, None] * widths)
        # q grows with the size, the other term with its square root.
        a, b = box.q / size, box.root / np.sqrt(size)
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            size = (2 / (b + np.sqrt(b**2 + 4 * a))) ** 2
        size = np.where(np.isfinite(size), np.clip(size, 1e-15, 1e6), 1e-15)
    return 1.5 * size


@dataclass(frozen=True, eq=False)
class Clearance:
    """Bounds of the clearance of one mode.

    Attributes
    ----------
    lower
        Proved lower bound: nothing singular is nearer.
    upper
        The distance of a fold of this mode, or of the end of the range of a value; infinite if
        neither was found.
    values
        The values there, shape (6,), or None.
    fold
        The fold, the last point of the straight line of values to there; None if there is none.
    end
        The index of the constraint whose value is at an end of its range, such as a distance of
        zero; None for a fold.
    """

    lower: float
    upper: float
    values: Array | None
    fold: Event | None
    end: int | None = None

    @property
    def ratio(self) -> float:
        """Upper bound by lower bound."""
        return self.upper / self.lower if self.lower > 0 else np.inf


def each_clearance(
    instance: Instance,
    R: Array,
    T: Array,
    *,
    weights: ArrayLike | None = None,
    refine: bool = False,
    seed: int = SEED,
    progress: Progress = silent,
) -> list[Clearance]:
    """Return proved bounds of the clearance of each of some poses.

    For the upper bound the mode is followed along straight lines of values until it ends in a
    fold, or until a value reaches the end of its range, such as a distance of zero. At the nearest
    fold the change of the values has the signs of the left null vector of the Jacobian matrix. So
    each fold gives a better direction; several first directions are tried.

    Parameters
    ----------
    instance
        Geometry and units; its values are not used.
    R, T
        The poses, shapes (n, 3, 3) and (n, 3).
    weights
        As for `clearances`.
    refine
        Whether to prove the box in 64 parts and to try more directions, which takes some seconds
        a pose.
    seed
        The seed of the random directions.
    progress
        Receives each pose that is done.

    Notes
    -----
    One call of the kernel follows the lines of all poses. Only the modes that do not reach the end
    of a line are followed one by one.
    """
    if not len(R):
        return []
    units = _weights(weights)
    lowers = clearances(instance, R, T, weights=units)
    starts = _MANY_STARTS if refine else _STARTS
    searches = [
        _search(instance, R[k], T[k], units, float(lowers[k]), starts, seed) for k in range(len(R))
    ]
    found: dict[int, Clearance] = {}
    # What is sent to each search next: None first, then whether the mode reaches the end of a line.
    answers: dict[int, bool | None] = dict.fromkeys(range(len(R)))
    steps = iter(progress(range(len(R)), total=len(R), label="poses"))
    while answers:
        lines: dict[int, Array] = {}
        for k, answer in answers.items():
            try:
                lines[k] = searches[k].send(answer)
            except StopIteration as end:
                found[k] = end.value
                if refine:
                    found[k] = _refined(instance, R[k], T[k], units, found[k])
                next(steps, None)
        answers = dict(zip(lines, _reach_ends(instance, R, T, lines), strict=True))
    next(steps, None)
    return [found[k] for k in range(len(R))]


def _reach_ends(
    instance: Instance, R: Array, T: Array, lines: dict[int, Array]
) -> list[bool | None]:
    """Return whether modes reach the ends of lines of values, by the indices of their poses."""
    if not lines:
        return []
    ends, chosen = np.array(list(lines.values())), list(lines)
    platform = MovingPlatform(over_rows(instance, ends.reshape(-1, 6)))
    followed = platform.follow(
        platform.internal(ends), np.arange(len(ends)), platform.points(R[chosen], T[chosen])
    )
    return [bool(stop == Stop.END) for stop in followed.stop]


def _refined(instance: Instance, R: Array, T: Array, units: Array, found: Clearance) -> Clearance:
    if not np.isfinite(found.upper) or found.lower == 0:
        return found
    values = values_at(instance, R, T)
    better = _in_octants(instance, values, R, T, units, found.lower, found.upper)
    return replace(found, lower=better)


def _search(
    instance: Instance, R: Array, T: Array, units: Array, lower: float, starts: int, seed: int
) -> Generator[Array, bool | None, Clearance]:
    """Look for the nearest fold of one pose; return it with the bounds.

    The generator yields lines of values (2, 6), and receives whether the mode reaches the end. Of
    folds that are equally near but for rounding errors the first is taken.
    """
    values = values_at(instance, R, T)
    best = _range_end(instance, values, units, lower)
    room = best.upper * _SHORT
    if lower == 0:
        # No branch leads away from a singular pose.
        return best
    seen: set[tuple[int, ...]] = set()
    for signs in _directions(instance, R, T, units, starts, seed):
        for _ in range(_ROUNDS):
            key = tuple(signs.astype(int).tolist())
            if key in seen:
                break
            seen.add(key)
            most = min(best.upper * _BEYOND, room)
            first = min(most, max(8 * lower, 1e-6)) if best.fold is None else most
            found = yield from _along(instance, values, R, T, signs * units, first, most)
            if found is None:
                break
            size, fold, following = found
            if size < best.upper * (1 - ALIKE):
                best = Clearance(lower, size, values + size * signs * units, fold)
            signs = following
    return best


def _in_octants(
    instance: Instance, values: Array, R: Array, T: Array, units: Array, low: float, high: float
) -> float:
    """Return a better lower bound: the box is proved as 64 boxes with a corner at the values.

    The mode is followed with proof to the centre of each small box, within this box. A small box
    has one regular solution for all its values, and it is the mode at the centre. Regular solutions
    that agree at one point agree along the whole way, so it is the mode at the common corner, too.
    For the same reason small boxes have the same solutions on common faces.
    """
    platform = MovingPlatform(apart(instance))
    signs = np.array(list(product((1.0, -1.0), repeat=6)))
    widths = platform.internal(units)
    centre = platform.internal(values)
    pose = platform.points(R[None], T[None])
    for _ in range(_REFINEMENTS):
        size = (low + high) / 2
        ends = np.stack(
            (np.broadcast_to(centre, signs.shape), centre + size / 2 * signs * widths), axis=1
        )
        followed = platform.follow(ends, np.arange(len(signs)), np.repeat(pose, len(signs), axis=0))
        proved = bool((followed.stop == Stop.END).all())
        if proved:
            near = Neighbourhood(platform, followed.points[:, -1], ends[:, 1])
            proved = bool((near.box(size / 2 * widths * (1 + 1e-12)).measure < 1).all())
        low, high = (size, high) if proved else (low, size)
    return low


def _directions(
    instance: Instance, R: Array, T: Array, units: Array, starts: int, seed: int
) -> Iterator[Array]:
    """Yield corners of the box of values to go to first, vectors of signs, shape (6,)."""
    arrangement = Arrangement.of(instance)
    rows = value_slopes(arrangement, R, T) / units[:, None]
    rows[:, :3] /= arrangement.length
    left, sizes, _ = np.linalg.svd(rows)
    left = definite_vectors(sizes, left)
    rng = np.random.default_rng(seed)
    for k in range(starts):
        vector = left[:, -1 - k // 2] if k < 6 else rng.normal(size=6)
        sense = 1 if k % 2 else -1
        yield definite_signs(vector) * sense
        # Where an entry is zero, as for symmetric platforms, the other sign is tried, too.
        yield -definite_signs(-vector) * sense


def _range_end(instance: Instance, values: Array, units: Array, lower: float) -> Clearance:
    """Return the largest change of values: up to the nearest end of the range of a kind."""
    ranges = [value_range(row.kind, instance.units.angle) for row in instance.constraints]
    ends = np.array(ranges)
    rooms = np.abs(ends - values[:, None]) / units[:, None]
    k, which = np.unravel_index(int(first_smallest(rooms.ravel())), rooms.shape)
    size = float(rooms[k, which])
    if np.isinf(size):
        return Clearance(lower, np.inf, None, None)
    there = values.copy()
    there[k] = ends[k, which]
    return Clearance(lower, size, there, None, int(k))


def _along(
    instance: Instance, values: Array, R: Array, T: Array, step: Array, reach: float, most: float
) -> Generator[Array, bool | None, tuple[float, Event, Array] | None]:
    """Return the distance of the fold on a line of values, the fold, and the next signs to try.

    The search goes up to ``reach`` first, and then up to ``most`` if nothing was found. It yields
    lines of values as `_search` does.
    """
    while True:
        ends = np.stack((values, values + reach * step))
        reaches_end = yield ends
        if not reaches_end:
            found = track_from(instance, ends, R[None], T[None])
            if found.events:
                break
        if reach == most or reach > _FARTHEST:
            return None
        reach = min(8 * reach, most)
    (event,) = found.events
    if event.kind != "fold":
        return None
    rows = value_slopes(Arrangement.of(instance), event.R, event.T)
    normal = np.linalg.svd(rows)[0][:, -1]
    outward = normal * np.sign(normal @ step)
    return (event.high - 1) * reach, event, definite_signs(outward)


@dataclass(frozen=True, eq=False)
class DriveClearance:
    """Bounds of the clearance of one pose in its drives.

    Attributes
    ----------
    lower
        Proved: up to here there is exactly one continuation, and no singularity.
    knees
        Proved: up to here no drive comes to a dead point; at most ``lower``.
    upper
        The change at the nearest fold that was found; infinite if there is none.
    dead_point
        The change at the nearest dead point that was found; infinite if there is none.
    drive
        The index of the drive that is at it, or None.
    q, R, T
        The drives and the pose at the fold: shapes (m,), (3, 3) and (3,), or None.
    """

    lower: float
    knees: float
    upper: float
    dead_point: float
    drive: int | None
    q: Array | None
    R: Array | None
    T: Array | None

    @property
    def ratio(self) -> float:
        """Upper bound by lower bound."""
        return self.upper / self.lower if self.lower > 0 else np.inf


def drive_weights(instance: Instance) -> tuple[Array, bool]:
    """Return the weights of the drives, lengths and radians, shape (m,).

    Also whether they are half the ranges; otherwise they are one in the unit of each drive.
    """
    drives = Drives.of(instance)
    half = (drives.high - drives.low) / 2
    if np.isfinite(half).all() and (half > 0).all():
        return half, True
    return drives.units.copy(), False


def drive_clearances(
    instance: Instance,
    R: ArrayLike,
    T: ArrayLike,
    *,
    weights: ArrayLike | None = None,
    knees: ArrayLike | None = None,
) -> tuple[Array, Array]:
    """Return what is proved of poses: `DriveClearance.lower` and `knees`, shape (n,) each.

    Zero if there is no proof, or the drives do not reach the pose.

    Parameters
    ----------
    instance
        The machine; its home pose decides the knees, without one each pose does.
    R, T
        Poses, shapes (n, 3, 3) and (n, 3).
    weights
        The unit of each drive's changes, lengths and radians, shape (m,); as `drive_weights`.
    knees
        The signs of the gains, shape (6,) or (n, 6), instead of those of the home pose.
    """
    drives, units = _given(instance, weights)
    R, T = np.asarray(R, float), np.asarray(T, float)
    signs = [None] * len(T) if knees is None else np.broadcast_to(knees, (len(T), 6))
    proved = [_proved(drives, R[k], T[k], units, signs[k]) for k in range(len(T))]
    return np.array([one for one, _ in proved]), np.array([one for _, one in proved])


def each_drive_clearance(
    instance: Instance, R: Array, T: Array, *, progress: Progress = silent
) -> list[DriveClearance]:
    """Return bounds of the clearance of each of some poses.

    For the upper bounds the pose is followed by Newton's method along the lines to all corners of
    the box of drives, until it ends in a fold, and until a gain changes its sign.

    Parameters
    ----------
    instance, R, T
        As for `drive_clearances`, with the weights of `drive_weights`.
    progress
        Receives each pose that is done.
    """
    drives, units = Drives.of(instance), drive_weights(instance)[0]
    found = []
    for k in progress(range(len(T)), total=len(T), label="poses"):
        lower, knees = _proved(drives, R[k], T[k], units)
        found.append(_Corners(drives, R[k], T[k], units, lower).bounds(lower, knees))
    return found


def _given(instance: Instance, weights: ArrayLike | None) -> tuple[Drives, Array]:
    drives = Drives.of(instance)
    units = drive_weights(instance)[0] if weights is None else np.asarray(weights, float)
    if units.shape != (drives.count,) or not (np.isfinite(units) & (units > 0)).all():
        message = f"found {units.tolist()}, expected {drives.count} positive numbers"
        raise ArgumentError(message, "weights")
    return drives, units


def _proved(
    drives: Drives, R: Array, T: Array, units: Array, knees: NDArray[np.int64] | None = None
) -> tuple[float, float]:
    q = drives.inverse(R, T, knees)
    if np.isnan(q).any():
        return 0.0, 0.0
    near = DrivenNeighbourhood(drives, R, T, q)
    # Constraints that share a drive move together; it is proved for all their changes.
    widths = near.widths(units[drives.index])[None]

    def regular(size: float) -> bool:
        return bool(near.box(size * widths).measure[0] < 1)

    def kept(size: float) -> bool:
        return bool(near.keeps_knees(size * widths, near.box(size * widths))[0])

    lower = _largest(regular, _FARTHEST)
    return lower, _largest(kept, lower)


def _largest(good: Callable[[float], bool], most: float) -> float:
    """Return a size for which something is proved, nearly the largest, found by halving."""
    if good(most):
        return most
    low, high = 0.0, most
    for _ in range(_DRIVE_HALVINGS):
        # Any order of magnitude is possible; it is found first.
        size = (low + high) / 2 if low > 0 else high / 8
        low, high = (size, high) if good(size) else (low, size)
        if low > 0 and high <= low * _CLOSE:
            break
    return low


#: How often the part of a way on which a gain changes its sign is halved.
_CROSSING_HALVINGS = 40


class _Corners:
    """A pose followed to the corners of the box of its drives.

    Parameters
    ----------
    drives, R, T
        The machine and the pose.
    units
        The weights, shape (m,).
    lower
        The clearance that is proved: the first step.
    """

    def __init__(self, drives: Drives, R: Array, T: Array, units: Array, lower: float) -> None:
        signs = product((1.0, -1.0), repeat=drives.count)
        self.drives, self.units = drives, units
        self.q = drives.inverse(R, T)
        self.ways = np.array(list(signs)) * units
        count = len(self.ways)
        self.R, self.T = np.repeat(R[None], count, axis=0), np.repeat(T[None], count, axis=0)
        self.far = np.zeros(count)
        self.step = np.full(count, max(_FIRST * lower, 1e-9))
        self.length = float(np.nanmax(drives.rods))

    def bounds(self, lower: float, knees: float) -> DriveClearance:
        """Return the bounds, with the nearest fold and dead point."""
        nothing = DriveClearance(lower, knees, np.inf, np.inf, None, None, None, None)
        if lower == 0:
            return nothing
        drives = self.drives
        J = drives.jacobian(self.R[:1], self.T[:1], self.q[None])
        sign = np.sign(np.linalg.det(J))[0]
        gains = np.sign(drives.gains(self.R[:1], self.T[:1], self.q[None]))[0]
        dead, drive = np.inf, None
        active, ended = np.ones(len(self.ways), bool), np.zeros(len(self.ways), bool)
        for _ in range(_STEPS):
            some = np.flatnonzero(active)
            if not len(some):
                break
            size = self.far[some] + self.step[some]
            R, T, good = self._newton(some, size)
            q = self.q + size[:, None] * self.ways[some]
            with np.errstate(all="ignore"):
                J = drives.jacobian(R, T, q)
                good &= np.isfinite(J).all(axis=(1, 2))
                J[~good] = np.eye(6)
                good &= np.sign(np.linalg.det(J)) == sign
                changed = (np.sign(drives.gains(R, T, q)) != gains) & drives.driven
            moved = some[good]
            if (crossed := good & changed.any(axis=1)).any():
                size_, nearest = self._crossing(
                    some[crossed], size[crossed], changed[crossed], gains
                )
                if size_ < dead * (1 - _NEAR):
                    dead, drive = size_, nearest
            self.R[moved], self.T[moved], self.far[moved] = R[good], T[good], size[good]
            self.step[some] *= np.where(good, _GROWTH, 0.5)
            ended |= active & (self.step < _LEAST * self.far)
            upper = float(self.far[ended].min(initial=np.inf))
            active &= ~ended & (self.far < min(upper * (1 + _NEAR), _FARTHEST))
        if not ended.any():
            return DriveClearance(lower, knees, np.inf, dead, drive, None, None, None)
        # Of corners that are equally near but for rounding errors the first is taken.
        at = int((ended & (self.far <= upper * (1 + _NEAR))).argmax())
        upper = float(self.far[at])
        q = self.q + upper * self.ways[at]
        return DriveClearance(lower, knees, upper, dead, drive, q, self.R[at], self.T[at])

    def _crossing(
        self, some: NDArray[np.intp], high: Array, changed: NDArray[np.bool_], gains: Array
    ) -> tuple[float, int]:
        """Return the least size at which a gain changes its sign on some ways, and its drive."""
        low, high = self.far[some].copy(), high.copy()
        which = changed.argmax(axis=1)
        for _ in range(_CROSSING_HALVINGS):
            middle = (low + high) / 2
            beyond = self._changed(some, middle, gains).any(axis=1)
            low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
        k = int(first_smallest(high))
        # A little farther the gains of all drives that change there together have changed.
        changed = self._changed(some, high * (1 + _NEAR), gains)
        drive = changed[k].argmax() if changed[k].any() else which[k]
        return float(high[k]), int(self.drives.index[drive])

    def _changed(self, some: NDArray[np.intp], size: Array, gains: Array) -> NDArray[np.bool_]:
        """Return which gains have other signs at some corners and sizes, shape (n, 6)."""
        R, T, _ = self._newton(some, size)
        q = self.q + size[:, None] * self.ways[some]
        with np.errstate(all="ignore"):
            changed = np.sign(self.drives.gains(R, T, q)) != gains
        return np.asarray(changed & self.drives.driven)

    def _newton(
        self, some: NDArray[np.intp], size: Array
    ) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Return the poses at some corners and sizes, and which are solutions nearby."""
        drives = self.drives
        R, T = self.R[some].copy(), self.T[some].copy()
        q = self.q + size[:, None] * self.ways[some]
        arrangement = drives.arrangement(q)
        wanted = np.where(drives.driven, drives.rods, q[:, drives.index])
        with np.errstate(all="ignore"):
            for _ in range(_ITERATIONS):
                off = wanted - measured(arrangement, R, T)
                J = drives.jacobian(R, T, q)
                fine = np.isfinite(J).all(axis=(1, 2)) & np.isfinite(off).all(axis=1)
                J[~fine], off[~fine] = np.eye(6), 0.0
                J[np.abs(np.linalg.det(J)) == 0] = np.eye(6)
                twist = np.linalg.solve(J, off[..., None])[..., 0]
                R, T = _turned(twist[:, :3]) @ R, T + twist[:, 3:]
            off = np.abs(wanted - measured(arrangement, R, T)).max(axis=1)
            far = np.linalg.norm(T - self.T[some], axis=1) / self.length
            far += np.abs(R - self.R[some]).max(axis=(1, 2))
            good = (off <= _RESIDUAL * self.length) & (far < _JUMP)
        return R, T, np.asarray(good)


def _turned(omega: Array) -> Array:
    """Return the rotations by vectors, ``(n, 3) -> (n, 3, 3)``."""
    half = np.linalg.norm(omega, axis=1, keepdims=True) / 2
    with np.errstate(invalid="ignore", over="ignore"):
        part = np.where(half > 0, np.sin(half) / np.where(half > 0, 2 * half, 1.0), 0.5)
        quaternion = np.concatenate((np.cos(half), omega * part), axis=1)
    quaternion[~np.isfinite(quaternion).all(axis=1)] = [1, 0, 0, 0]
    return np.asarray(rotation_from_quaternion(quaternion))


@dataclass(frozen=True, eq=False)
class Clearances(EqualByContent):
    """Proved bounds of the clearances of n poses.

    Attributes
    ----------
    instance
        The platform.
    of
        The quantity that changes: one of `KINDS`.
    bounds
        The bounds of each pose.
    """

    instance: Instance
    of: str
    bounds: tuple[Clearance | DriveClearance | PoseClearance, ...]

    def __repr__(self) -> str:
        kinds = self.instance.name or self.instance.type.id
        least = f", at least {self.lower.min():.6g}" if len(self.bounds) else ""
        return f"<Clearances of {kinds}: {counted(len(self.bounds), 'pose')}{least}>"

    @cached_property
    def lower(self) -> Array:
        """Proved lower bounds: nothing singular is nearer, shape (n,); read-only."""
        return self._column("lower")

    @cached_property
    def upper(self) -> Array:
        """Distances of singularities that were found, else infinite, shape (n,); read-only."""
        return self._column("upper")

    def _column(self, name: str) -> Array:
        column = np.array([getattr(one, name) for one in self.bounds], dtype=float)
        column.setflags(write=False)
        return column

    def rows(self) -> list[dict[str, Any]]:
        """Return the bounds of each pose, as plain data."""
        return [_row(self.instance, one) for one in self.bounds]

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each pose, without places; imports pandas.

        The columns are lower, upper, ratio, and by and constraint, or, of drives, knees, dead_point
        and drive.
        """
        import pandas as pd

        last = ["knees", "dead_point", "drive"] if self.of == "drives" else ["by", "constraint"]
        columns = ["lower", "upper", "ratio", *last]
        return pd.DataFrame(self.rows(), columns=columns)

    def to_json(self, names: Sequence[Mapping[str, Any]] | None = None) -> dict[str, Any]:
        """Return everything as plain data of schema ``gsp.clearance/1``.

        Parameters
        ----------
        names
            The name of each pose; without names there is no ``mode``.
        """
        called = [{"mode": None}] * len(self.bounds) if names is None else names
        rows = [{**name, **row} for name, row in zip(called, self.rows(), strict=True)]
        head = {"schema": "gsp.clearance/1", **self.instance.to_json()}
        return {**head, "of": self.of, "modes": rows}


def clearance(
    instance: Instance,
    R: Any,
    T: ArrayLike | None = None,
    *,
    of: str | None = None,
    points: ArrayLike | None = None,
    refine: bool = False,
    progress: Progress = silent,
) -> Clearances:
    """Bound the change of values, drives or the pose before the pose meets a singularity.

    Parameters
    ----------
    instance
        The platform. If each constraint, or each drive, has a range, changes count in halves of
        them.
    R, T
        The poses, shapes (n, 3, 3) and (n, 3).
    of
        ``values``, ``drives`` or ``pose``: the quantity that changes. By default the drives of
        machines with cranks or slides, the values of others.
    points
        For ``pose``: the points of the platform, in its frame, whose displacements count, shape
        (m, 3); by default those of the distances.
    refine
        Whether to look for better bounds: a few seconds a pose; not of drives.
    progress
        Receives the number of each pose.

    Raises
    ------
    ArgumentError
        Naming what is wrong.
    """
    of = of or default_kind(instance)
    if of not in KINDS:
        message = f"found {of!r}, expected {' or '.join(KINDS)}"
        raise ArgumentError(message, "of")
    if points is not None and of != "pose":
        message = "points count for the clearance of a pose only"
        raise ArgumentError(message, "points")
    R, T = checked_poses(R, T)
    R, T = R.reshape(-1, 3, 3), T.reshape(-1, 3)
    driven = is_driven(instance)
    if of == "pose" and driven:
        message = (
            "not known of the pose of a machine with cranks or slides, whose joints move with it: "
            "use drives"
        )
        raise ArgumentError(message, "of")
    if of == KINDS[0] and driven:
        return Clearances(instance, of, tuple(_with_drives_still(instance, R, T, refine, progress)))
    if of == KINDS[0]:
        weights = range_weights(instance)
        each = each_clearance(instance, R, T, weights=weights, refine=refine, progress=progress)
        return Clearances(instance, of, tuple(each))
    if of == "drives":
        moved = each_drive_clearance(instance, R, T, progress=progress)
        return Clearances(instance, of, tuple(moved))
    poses = list(zip(R, T, strict=True))
    found = [
        pose_clearance(instance, turn, place, points=points, refine=refine)
        for turn, place in progress(poses, total=len(poses), label="poses")
    ]
    return Clearances(instance, of, tuple(found))


def _with_drives_still(
    instance: Instance, R: Array, T: Array, refine: bool, progress: Progress
) -> Iterator[Clearance]:
    """Yield the clearances of values at poses, with cranks and slides still where they are.

    Raises
    ------
    ArgumentError
        If the drives do not reach a pose.
    """
    drives, q = drive_values(instance, R, T, along=False)
    unreached = np.isnan(q).any(axis=1)
    if unreached.any():
        message = f"the drives do not reach pose {int(unreached.argmax()) + 1}"
        raise ArgumentError(message, "R")
    for k in progress(range(len(q)), total=len(q), label="poses"):
        there = drives.instance_at(q[k])
        weights, one = range_weights(there), slice(k, k + 1)
        yield from each_clearance(there, R[one], T[one], weights=weights, refine=refine)


def default_kind(instance: Instance) -> str:
    """Return the quantity that changes by default: drives where motors move points, else values."""
    return "drives" if is_driven(instance) else "values"


def _row(instance: Instance, found: Clearance | DriveClearance | PoseClearance) -> dict[str, Any]:
    if isinstance(found, PoseClearance):
        return _of_pose(instance, found)
    if isinstance(found, DriveClearance):
        return _of_drives(instance, found)
    return _of_values(instance, found)


def _of_drives(instance: Instance, found: DriveClearance) -> dict[str, Any]:
    """Return the bounds of the clearance of one pose in its drives."""
    drives = Drives.of(instance)
    q, R, T = (None if part is None else part.tolist() for part in (found.q, found.R, found.T))
    return {
        "lower": found.lower,
        "knees": found.knees,
        "upper": _finite(found.upper),
        "dead_point": _finite(found.dead_point),
        "ratio": _finite(found.ratio),
        "drive": None if found.drive is None else drives.names[found.drive],
        "drives": None if q is None else drives.readings(np.array(q)).tolist(),
        "R": R,
        "T": T,
    }


def _finite(number: float) -> float | None:
    return number if number < float("inf") else None


def _of_values(instance: Instance, found: Clearance) -> dict[str, Any]:
    """Return the bounds of the clearance of one mode in its values."""
    row = _bounds(found.lower, found.upper, found.ratio)
    if found.values is None:
        return row
    readings = readings_of(instance, found.values).tolist()
    row |= {"by": "fold" if found.end is None else "end of range", "values": readings}
    if found.end is not None:
        row["constraint"] = found.end + 1
    if found.fold is not None:
        row |= {"R": found.fold.R.tolist(), "T": found.fold.T.tolist()}
    return row


def _of_pose(instance: Instance, found: PoseClearance) -> dict[str, Any]:
    """Return the bounds of the clearance of one pose."""
    row = _bounds(found.lower, found.upper, found.ratio)
    if found.R is None or found.T is None:
        return row
    values = measure(instance, found.R, found.T).tolist()
    pose = {"R": found.R.tolist(), "T": found.T.tolist()}
    return row | {"by": "singular pose", "values": values, **pose}


def _bounds(lower: float, upper: float, ratio: float) -> dict[str, Any]:
    """Return both bounds, and room for the place of the upper one."""
    return {
        "lower": lower,
        "upper": _finite(upper),
        "ratio": _finite(ratio),
        **dict.fromkeys(("by", "constraint", "values", "R", "T")),
    }
