"""Clearance: how far values, drives or the pose may change before a mode meets a singularity.

The distance of two sets of values, or of drives, is the largest difference of one, divided by its
weight. A clearance of r means that all together may change by up to r times their weights, in any
combination.

The lower bound is proved: up to it the pose has exactly one continuation, which is regular. Of
drives a second number is proved: up to where no drive comes to a dead point, so that all keep their
working modes. For the upper bound the mode is followed with proof along straight lines to the
corners of the box until it is singular. Of values that is a proved fold; of drives it is not
proved, and neither is the nearest dead point that was found.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.certification.poses.multiple import nearly_parallel
from gspcli.errors import ArgumentError
from gspcli.geometry.checking import value_range
from gspcli.geometry.coordinates import BODIES, coordinates
from gspcli.geometry.instance import Instance
from gspcli.geometry.machine import Machine, is_driven
from gspcli.geometry.measurement import condition_numbers
from gspcli.geometry.readings import readings_of
from gspcli.motion.following.branch_follower import MovingPlatform, Stop, apart, over_rows
from gspcli.motion.following.follower import FollowedMode, RowFollower
from gspcli.motion.following.tracks import track_from
from gspcli.motion.poses.inverse_kinematics import checked_poses, drive_values, measure, values_at
from gspcli.motion.singularities.neighbourhoods import MachineNeighbourhood, Neighbourhood
from gspcli.motion.singularities.pose_clearances import PoseClearance, pose_clearance
from gspcli.progress import Progress, silent
from gspcli.records import EqualByContent, dataclass
from gspcli.ties import ascending, first_smallest
from gspcli.wording import counted

if TYPE_CHECKING:
    import pandas as pd


Array = NDArray[np.float64]

#: Halvings of the interval in which the clearance of values is sought, after a first estimate.
_HALVINGS = 7
_REFINEMENTS = 7
#: Straight lines of values and drives are followed up to this many weights.
_FARTHEST = 1e3
#: The first length of lines in proved clearances, the least, and how it grows.
_FIRST, _LEAST, _GROWTH = 8, 1e-6, 8
#: The part of the way to the end of a range up to which a mode is followed.
_SHORT = 1 - 1e-6
#: Lines that end at lengths which differ by less than this part are equally long.
_EQUAL = 1e-6
#: Halvings of the interval of a clearance of drives, and the ratio of its ends that suffices.
_DRIVE_HALVINGS, _CLOSE = 60, 1.002
#: Parts into which lines are divided for dead points, and how sharply these are found.
_PARTS, _SHARP = 16, 1e-9
#: From poses of a line of drives this part of it before its end the end is extrapolated.
_BEFORE = 1e-4
#: The corners of a box of values.
_CORNERS = np.array(list(product((1.0, -1.0), repeat=6)))
#: The quantities that may change.
KINDS = ("values", "drives", "pose")


def default_kind(instance: Instance) -> str:
    """Return the quantity that changes by default: drives where motors move points, else values."""
    return "drives" if is_driven(instance) else "values"


def range_weights(instance: Instance) -> Array | None:
    """Return half the ranges of the values, shape (6,); None unless each constraint has one."""
    limits = [constraint.limits for constraint in instance.constraints]
    spans = [(high.value - low.value) / 2 for low, high in (pair for pair in limits if pair)]
    return np.array(spans) if len(spans) == len(limits) and min(spans) > 0 else None


def drive_weights(instance: Instance) -> tuple[Array, bool]:
    """Return the weights of the drives, lengths and radians, shape (m,).

    Also whether they are half the ranges; otherwise they are one in the unit of each drive.
    """
    drives = Machine.of(instance)
    half = (drives.high - drives.low) / 2
    ranged = bool(np.isfinite(half).all() and (half > 0).all())
    return (half if ranged else drives.units.copy()), ranged


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


def drive_clearances(
    instance: Instance,
    R: ArrayLike,
    T: ArrayLike,
    *,
    weights: ArrayLike | None = None,
    working_modes: ArrayLike | None = None,
) -> tuple[Array, Array]:
    """Return what is proved of poses: `Clearance.lower` and `working_modes`, shape (n,) each.

    Zero if there is no proof, or the drives do not reach the pose.

    Parameters
    ----------
    instance
        The machine; its home pose decides the working modes, without one each pose does.
    R, T
        Poses, shapes (n, 3, 3) and (n, 3).
    weights
        The unit of each drive's changes, lengths and radians, shape (m,); as `drive_weights`.
    working_modes
        The signs of the gains, shape (6,) or (n, 6), instead of those of the home pose.
    """
    drives = Machine.of(instance)
    units = drive_weights(instance)[0] if weights is None else np.asarray(weights, float)
    if units.shape != (drives.count,) or not (np.isfinite(units) & (units > 0)).all():
        message = f"found {units.tolist()}, expected {drives.count} positive numbers"
        raise ArgumentError(message, "weights")
    R, T = np.asarray(R, float), np.asarray(T, float)
    signs = (
        [None] * len(T) if working_modes is None else np.broadcast_to(working_modes, (len(T), 6))
    )
    proved = [_proved(drives, R[k], T[k], units, signs[k]) for k in range(len(T))]
    return np.array([one for one, _ in proved]), np.array([one for _, one in proved])


def _proved(
    drives: Machine,
    R: Array,
    T: Array,
    units: Array,
    working_modes: NDArray[np.int64] | None = None,
) -> tuple[float, float]:
    q = drives.inverse(R, T, working_modes)
    if np.isnan(q).any():
        return 0.0, 0.0
    near = MachineNeighbourhood(drives, R, T, q)
    # Constraints that share a drive move together; it is proved for all their changes.
    widths = near.widths(units[drives.index])[None]

    def regular(size: float) -> bool:
        return bool(near.box(size * widths).measure[0] < 1)

    def kept(size: float) -> bool:
        return bool(near.keeps_working_modes(size * widths, near.box(size * widths))[0])

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


@dataclass(frozen=True, eq=False)
class Clearance:
    """Bounds of the clearance of one pose in its values, or in its drives.

    Attributes
    ----------
    lower
        Proved lower bound: up to here there is exactly one continuation, and no singularity.
    upper
        The distance of the nearest singularity that was found on the lines to the corners of the
        box, or of the end of the range of a value; infinite if neither was found. Of values it is
        a proved fold of this mode.
    numbers
        The values there, shape (6,), or the numbers of the drives, shape (m,); None if infinite.
    R, T
        The singular pose, shapes (3, 3) and (3,); None if there is none.
    end
        The index of the constraint whose value is at an end of its range, such as a distance of
        zero; None for a singular pose.
    working_modes
        Of drives, proved: up to here no drive comes to a dead point; at most ``lower``.
    dead_point
        The change at the nearest dead point that was found; infinite if there is none.
    drive
        The index of the drive that is at it, or None.
    """

    lower: float
    upper: float = np.inf
    numbers: Array | None = None
    R: Array | None = None
    T: Array | None = None
    end: int | None = None
    working_modes: float = 0.0
    dead_point: float = np.inf
    drive: int | None = None

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
    progress: Progress = silent,
) -> list[Clearance]:
    """Return bounds of the clearance of each of some poses in the values.

    Parameters
    ----------
    instance
        Geometry and units; its values are not used.
    R, T
        The poses, shapes (n, 3, 3) and (n, 3).
    weights
        As for `clearances`.
    refine
        Whether to prove the box in 64 parts, which takes some seconds a pose.
    progress
        Receives each pose that is done.
    """
    if not len(R):
        return []
    units = _weights(weights)
    lowers = clearances(instance, R, T, weights=units)
    values = values_at(instance, R, T)
    every = []
    for k in progress(range(len(R)), total=len(R), label="poses"):
        found = _range_end(instance, values[k], units, float(lowers[k]))
        # No branch leads away from a singular pose.
        if found.lower > 0:
            lines = _ValueLines(instance, values[k], _CORNERS * units, R[k], T[k])
            nearest = lines.nearest(found.lower, found.upper * _SHORT)
            found = found if nearest is None else Clearance(found.lower, *nearest)
        if refine and found.lower > 0 and np.isfinite(found.upper):
            better = _in_octants(instance, values[k], R[k], T[k], units, found.lower, found.upper)
            found = replace(found, lower=better)
        every.append(found)
    return every


def each_drive_clearance(
    instance: Instance, R: Array, T: Array, *, progress: Progress = silent
) -> list[Clearance]:
    """Return bounds of the clearance of each of some poses in the drives.

    Parameters
    ----------
    instance, R, T
        As for `drive_clearances`, with the weights of `drive_weights`.
    progress
        Receives each pose that is done.
    """
    drives, units = Machine.of(instance), drive_weights(instance)[0]
    # On the lines values that stay do so.
    stay = set(drives.index[drives.stays].tolist())
    corners = product(*((0.0,) if k in stay else (1.0, -1.0) for k in range(drives.count)))
    ways = np.array(list(corners)) * units
    every = []
    for k in progress(range(len(T)), total=len(T), label="poses"):
        lower, working_modes = _proved(drives, R[k], T[k], units)
        found = Clearance(lower, working_modes=working_modes)
        # Points at distances to planes are not followed along lines.
        if lower > 0 and not drives.planes.any():
            q = drives.inverse(R[k], T[k])
            lines = _DriveLines(drives, q, ways, R[k], T[k])
            nearest = lines.nearest(lower, np.inf)
            found = (
                found
                if nearest is None
                else Clearance(lower, *nearest, working_modes=working_modes)
            )
            dead_point, drive = lines.dead_point(_FIRST * lower)
            found = replace(found, dead_point=dead_point, drive=drive)
        every.append(found)
    return every


class _Lines(ABC):
    """A mode followed with proof from a pose along straight lines to the corners of a box.

    At the nearest of all folds the change of the numbers has the signs of a left null vector of
    the Jacobian matrix, in units of the weights: the box of numbers touches the set of folds in a
    corner.

    Parameters
    ----------
    instance
        Geometry and units; its values are not used.
    start
        The numbers at the pose, shape (m,).
    ways
        Their changes on each line in units of the weights, shape (n, m).
    R, T
        The pose, shapes (3, 3) and (3,).
    """

    def __init__(self, instance: Instance, start: Array, ways: Array, R: Array, T: Array) -> None:
        self.instance, self.start, self.ways, self.R, self.T = instance, start, ways, R, T

    @abstractmethod
    def ends(self, reach: float) -> Array:
        """Return where lines up to a size end before it, infinite for others, shape (n,)."""

    @abstractmethod
    def singular(self, k: int, end: float, reach: float) -> tuple[float, Array, Array] | None:
        """Return the size and the pose where a line ends, if it is singular there."""

    def nearest(self, lower: float, most: float) -> tuple[float, Array, Array, Array] | None:
        """Return the size, the numbers and the pose of the nearest singularity up to a size.

        Of lines that are equally long but for rounding errors the first is taken.
        """
        reach = min(most, max(_FIRST * lower, _LEAST))
        while True:
            ends = self.ends(reach)
            best: tuple[float, Array, Array, Array] | None = None
            for k in ascending(ends, _EQUAL)[: np.isfinite(ends).sum()].tolist():
                if best is not None and ends[k] >= best[0] * (1 - _EQUAL):
                    break
                end = self.singular(k, float(ends[k]), reach)
                if end is not None and (best is None or end[0] < best[0] * (1 - _EQUAL)):
                    best = end[0], self.start + end[0] * self.ways[k], *end[1:]
            if best is not None or reach >= most or reach > _FARTHEST:
                return best
            reach = min(_GROWTH * reach, most)


class _ValueLines(_Lines):
    """Lines of values, which end in proved folds."""

    def ends(self, reach: float) -> Array:
        rows = self.start + np.array([[0.0], [reach]]) * self.ways[:, None]
        platform = MovingPlatform(over_rows(self.instance, rows.reshape(-1, 6)))
        pose = platform.points(self.R[None], self.T[None])
        found = platform.follow(
            platform.internal(rows), np.arange(len(rows)), np.repeat(pose, len(rows), axis=0)
        )
        return np.where(found.stop == Stop.STEP, found.fraction * reach, np.inf)

    def singular(self, k: int, end: float, reach: float) -> tuple[float, Array, Array] | None:
        rows = np.stack((self.start, self.start + reach * self.ways[k]))
        for event in track_from(self.instance, rows, self.R[None], self.T[None]).events:
            if event.kind == "fold":
                return (event.high - 1) * reach, event.R, event.T
        return None


class _DriveLines(_Lines):
    """Lines of the numbers of drives. They are followed with proof; that they end is seen.

    Parameters
    ----------
    drives
        The drives.
    start, ways, R, T
        As for `_Lines`.
    """

    def __init__(self, drives: Machine, start: Array, ways: Array, R: Array, T: Array) -> None:
        super().__init__(drives.instance, start, ways, R, T)
        self.drives, self.moved = drives, np.flatnonzero(drives.moved).tolist()
        owners = {(one.name, one.body): one for one in coordinates(drives.instance)}
        bodies = [BODIES[int(not drives.on_platform[drives.users(k)[0]])] for k in self.moved]
        names = [drives.names[k] for k in self.moved]
        chosen = [owners[pair] for pair in zip(names, bodies, strict=True)]
        self.follower = RowFollower(drives.instance, chosen)
        self.last: dict[int, tuple[Array, Array]] = {}

    def follow(self, k: int, sizes: Array) -> FollowedMode:
        """Follow a line over rows at increasing sizes."""
        drives, q = self.drives, self.start + sizes[:, None] * self.ways[k]
        values = np.where(drives.driven, drives.rods, (q / drives.units)[:, drives.index])
        rows = np.concatenate((values, (q / drives.units)[:, self.moved]), axis=1)
        return self.follower.follow(rows, self.R, self.T)

    def ends(self, reach: float) -> Array:
        found = np.full(len(self.ways), np.inf)
        for k in range(len(found)):
            mode = self.follow(k, np.array([0.0, reach]))
            if mode.reached == 0:
                found[k], self.last[k] = mode.part * reach, mode.last
        return found

    def singular(self, k: int, end: float, reach: float) -> tuple[float, Array, Array] | None:
        """Return the size and the pose at the end of a line if it is singular there.

        Towards a fold the square of 1 / condition falls linearly to zero; where modes meet that are
        symmetric, 1 / condition itself does. Which of them is straighter is extrapolated.
        """
        sizes = end * (1 - _BEFORE * np.array([3, 2, 1]))
        mode = self.follow(k, np.concatenate(([0.0], sizes)))
        if len(mode.T) < len(sizes) + 1:
            return None
        q = self.start + sizes[:, None] * self.ways[k]
        fall = 1 / condition_numbers(self.drives.arrangement(q), mode.R[1:], mode.T[1:])
        x = min(fall, fall**2, key=lambda x: abs(x[0] + x[2] - 2 * x[1]) / x[0])
        a, b, c = (np.prod(np.delete(x, j) / (np.delete(x, j) - x[j])) for j in range(3))
        size = float(sizes @ [a, b, c])
        if not abs(size / end - 1) < _BEFORE:
            return None
        return max(size, end), *self.last[k]

    def dead_point(self, high: float) -> tuple[float, int | None]:
        """Return the least size at which a gain changes its sign on a line, and its drive."""
        drives = self.drives
        gains = np.sign(drives.gains(self.R, self.T, self.start))
        some, low, drive = np.arange(len(self.ways)), 0.0, None
        while len(some) and high - low > _SHARP * high:
            parts = np.linspace(low, high, _PARTS + 1)
            changed = np.zeros((len(some), _PARTS + 1, 6), bool)
            alive = np.zeros(len(some), bool)
            for line, k in enumerate(some.tolist()):
                mode = self.follow(k, np.concatenate(([0.0], parts)))
                R, T, sizes = mode.R[1:], mode.T[1:], parts[: len(mode.T[1:])]
                alive[line] = len(sizes) == len(parts)
                if 0 < len(sizes) < len(parts):
                    # The last pose stands for the row that is not reached.
                    R, T = np.append(R, mode.last[0][None], 0), np.append(T, mode.last[1][None], 0)
                    sizes = np.append(sizes, sizes[-1] + mode.part * (parts[1] - parts[0]))
                signs = np.sign(drives.gains(R, T, self.start + sizes[:, None] * self.ways[k]))
                changed[line, : len(sizes)] = (signs * gains < 0) & drives.driven
            if changed.any():
                k = int(changed.any(axis=(0, 2)).argmax())
                drive = int(drives.index[changed[:, k].any(axis=0).argmax()])
                some, low, high = some[changed[:, k].any(axis=1)], parts[k - 1], parts[k]
            elif drive is None and high < _FARTHEST:
                some, low, high = some[alive], high, _GROWTH * high
            else:
                break
        return (np.inf if drive is None else float(high)), drive


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
    signs, widths = _CORNERS, platform.internal(units)
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


def _range_end(instance: Instance, values: Array, units: Array, lower: float) -> Clearance:
    """Return the largest change of values: up to the nearest end of the range of a kind."""
    ranges = [value_range(row.kind, instance.units.angle) for row in instance.constraints]
    ends = np.array(ranges)
    rooms = np.abs(ends - values[:, None]) / units[:, None]
    k, which = np.unravel_index(int(first_smallest(rooms.ravel())), rooms.shape)
    size = float(rooms[k, which])
    if np.isinf(size):
        return Clearance(lower)
    there = values.copy()
    there[k] = ends[k, which]
    return Clearance(lower, size, there, end=int(k))


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
    bounds: tuple[Clearance | PoseClearance, ...]

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
        return [_row(self.instance, self.of, one) for one in self.bounds]

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each pose, without places; imports pandas.

        The columns are lower, upper, ratio, and by and constraint, or, of drives, working_modes,
        dead_point and drive.
        """
        import pandas as pd

        last = (
            ["working_modes", "dead_point", "drive"]
            if self.of == "drives"
            else ["by", "constraint"]
        )
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


def _row(instance: Instance, of: str, found: Clearance | PoseClearance) -> dict[str, Any]:
    if isinstance(found, PoseClearance):
        return _of_pose(instance, found)
    return _of_drives(instance, found) if of == "drives" else _of_values(instance, found)


def _of_drives(instance: Instance, found: Clearance) -> dict[str, Any]:
    """Return the bounds of the clearance of one pose in its drives."""
    drives = Machine.of(instance)
    q, R, T = (
        None if part is None else part.tolist() for part in (found.numbers, found.R, found.T)
    )
    return {
        "lower": found.lower,
        "working_modes": found.working_modes,
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
    if found.numbers is None:
        return row
    readings = readings_of(instance, found.numbers).tolist()
    row |= {"by": "fold" if found.end is None else "end of range", "values": readings}
    if found.end is not None:
        row["constraint"] = found.end + 1
    if found.R is not None and found.T is not None:
        row |= {"R": found.R.tolist(), "T": found.T.tolist()}
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
