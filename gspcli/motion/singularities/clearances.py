"""Clearance: how far drives or the pose may change before a mode meets a singularity.

The distance of two sets of numbers of drives, the values of plain legs among them, is the largest
difference of one, divided by its weight. A clearance of r means that all together may change by up
to r times their weights, in any combination. Values that stay do not change.

The lower bound is proved: up to it the pose has exactly one continuation, which is regular. Of
cranks and slides a second number is proved: up to where none comes to a dead point, so that all
keep their working modes. For the upper bound the mode is followed with proof along straight lines
to the corners of the box until it is singular, in a proved fold. Where symmetric modes of cranks
and slides meet that is seen and not proved, as is the nearest dead point that was found.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
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
from gspcli.geometry.machine import Machine, value_machine
from gspcli.geometry.measurement import condition_numbers
from gspcli.motion.bisection import bisected
from gspcli.motion.following.branch_follower import (
    FollowOptions,
    MovingGeometry,
    MovingPlatform,
    Stop,
    apart,
    at_values,
    over_rows,
)
from gspcli.motion.following.follower import FollowedMode, RowFollower
from gspcli.motion.following.tracks import Run
from gspcli.motion.poses.inverse_kinematics import checked_poses
from gspcli.motion.singularities.neighbourhoods import Neighbourhood, neighbourhoods
from gspcli.motion.singularities.pose_clearances import Clearance, pose_clearance
from gspcli.progress import Progress, silent
from gspcli.records import EqualByContent, dataclass
from gspcli.ties import ascending, first_smallest
from gspcli.wording import counted

if TYPE_CHECKING:
    import pandas as pd


Array = NDArray[np.float64]

#: Most halvings of the interval in which a clearance is sought: of values, of cranks and slides, of
#: boxes in parts. They end when the ends are so near to each other.
_HALVINGS, _MACHINE_HALVINGS, _REFINEMENTS, _CLOSE = 7, 40, 7, 1.002
#: Straight lines of drives are followed up to this many weights.
_FARTHEST = 1e3
#: The first length of lines in proved clearances, the least, and how it grows.
_FIRST, _LEAST, _GROWTH = 8, 1e-6, 8
#: The part of the way to the end of a range up to which a mode is followed.
_SHORT = 1 - 1e-6
#: Lines that end at lengths which differ by less than this part are equally long.
_EQUAL = 1e-6
#: Parts into which lines are divided for dead points, and how sharply these are found.
_PARTS, _SHARP = 16, 1e-9
#: From poses of a line of drives this part of it before its end the end is extrapolated.
_BEFORE = 1e-4
#: Points of drives are at the same place up to this part of the size.
_SAME = 1e-6
#: The quantities that may change.
KINDS = ("values", "drives", "pose")


def held(machine: Machine) -> NDArray[np.bool_]:
    """Return which values do not change, shape (6,): none if there is nothing else that could."""
    return machine.fixed & ~machine.fixed.all()


def weights_of(machine: Machine) -> tuple[Array, bool]:
    """Return the unit of each drive's changes, lengths and radians, shape (m,).

    Also whether they are half the ranges; otherwise they are one in the unit of each drive, as is
    that of values that stay.
    """
    half, moves = (machine.high - machine.low) / 2, ~held(machine)[machine.first]
    ranged = bool((np.isfinite(half) & (half > 0))[moves].all())
    return np.where(moves & ranged, half, machine.units), ranged


def clearances(
    machine: Machine,
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
    machine
        The machine; its home pose decides the working modes, without one each pose does.
    R, T
        Poses, shapes (n, 3, 3) and (n, 3).
    weights
        The unit of each drive's changes, lengths and radians, shape (m,); as `weights_of`.
    working_modes
        The signs of the gains, shape (6,) or (n, 6), instead of those of the home pose.

    Raises
    ------
    ArgumentError
        If the weights are not m positive numbers.
    """
    R, T = np.asarray(R, float), np.asarray(T, float)
    q = _numbers(machine, R, T, working_modes)
    # The distance of parallel lines jumps when they tilt.
    parallel = nearly_parallel(machine.instance, R.astype(complex)).any(axis=1)
    known = np.flatnonzero(np.isfinite(q).all(axis=1) & ~parallel)
    # Constraints that share a drive move together; it is proved for all their changes.
    units = np.where(held(machine), 0.0, _weights(machine, weights)[machine.index])
    lower, kept = np.zeros((2, len(T)))
    halvings = _MACHINE_HALVINGS if machine.moves else _HALVINGS
    for which, near in neighbourhoods(machine, R[known], T[known], q[known]):
        widths = near.widths(units)

        def regular(size: Array, near: Neighbourhood = near, widths: Array = widths) -> Any:
            return near.box(size[:, None] * widths).measure < 1

        def keeps(size: Array, near: Neighbourhood = near, widths: Array = widths) -> Any:
            moved = size[:, None] * widths
            return near.keeps_working_modes(moved, near.box(moved))

        found = _largest(regular, _estimate(near, widths), halvings)
        lower[known[which]] = found
        kept[known[which]] = _largest(keeps, found, halvings) if machine.moves else found
    return lower, kept


def _weights(machine: Machine, given: ArrayLike | None) -> Array:
    weights = weights_of(machine)[0] if given is None else np.asarray(given, float)
    if weights.shape != (machine.count,) or not (np.isfinite(weights) & (weights > 0)).all():
        message = f"found {weights.tolist()}, expected {machine.count} positive numbers"
        raise ArgumentError(message, "weights")
    return weights


def _numbers(machine: Machine, R: Array, T: Array, working_modes: ArrayLike | None = None) -> Array:
    """Return the numbers of the drives at poses, each in its own working modes without a home."""
    given = machine.signs if working_modes is None else np.asarray(working_modes)
    if given is None and machine.instance.home is None:
        return machine.nearest(R, T)
    return machine.inverse(R, T, given)


def _estimate(near: Neighbourhood, widths: Array) -> Array:
    """Return somewhat more than the largest changes that can be proved, shape (n,)."""
    size = np.full(len(near.points), 1e-6)
    for _ in range(3):
        box = near.box(size[:, None] * widths)
        # q grows with the size, the other term with its square root.
        a, b = box.q / size, box.root / np.sqrt(size)
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            size = (2 / (b + np.sqrt(b**2 + 4 * a))) ** 2
        size = np.where(np.isfinite(size), np.clip(size, 1e-15, 1e6), 1e-15)
    return 1.35 * size


def _largest(good: Callable[[Array], Any], most: Array, halvings: int) -> Array:
    """Return sizes for which something is proved, nearly the largest, (n,)."""
    low = np.where(good(most), most, 0.0)
    return bisected(good, low, most, halvings - 1, close=_CLOSE)[0]


def each_clearance(
    machine: Machine,
    R: Array,
    T: Array,
    *,
    weights: ArrayLike | None = None,
    refine: bool = False,
    progress: Progress = silent,
) -> list[Clearance]:
    """Return bounds of the clearance of each of some poses in the drives.

    Parameters
    ----------
    machine, R, T, weights
        As for `clearances`.
    refine
        Whether to prove the box in 64 parts, which takes some seconds a pose; not of cranks and
        slides.
    progress
        Receives each pose that is done.
    """
    units = _weights(machine, weights)
    lowers, kept = clearances(machine, R, T, weights=units)
    q = _numbers(machine, R, T)
    # On the lines values that stay do so.
    stay = set(machine.index[held(machine)].tolist())
    corners = product(*((0.0,) if k in stay else (1.0, -1.0) for k in range(machine.count)))
    ways = np.array(list(corners)) * units
    every = []
    for k in progress(range(len(T)), total=len(T), label="poses"):
        found = Clearance(float(lowers[k]), working_modes=float(kept[k]))
        if not machine.moves:
            found = _range_end(machine, q[k], units, found)
        # No branch leads away from a singular pose, and points at distances to planes are not
        # followed along lines.
        if found.lower > 0 and not machine.planes.any():
            lines = (_MachineLines if machine.moves else _ValueLines)(
                machine, q[k], ways, R[k], T[k]
            )
            nearest = lines.nearest(found.lower, found.upper * _SHORT)
            if nearest is not None:
                upper, numbers, turn, place, by = nearest
                found = replace(
                    found, upper=upper, numbers=numbers, R=turn, T=place, by=by, end=None
                )
            if isinstance(lines, _MachineLines):
                dead_point, drive = lines.dead_point(_FIRST * found.lower)
                found = replace(found, dead_point=dead_point, drive=drive)
            elif refine and np.isfinite(found.upper):
                found = replace(found, lower=lines.in_octants(units, found))
        every.append(found)
    return every


def _range_end(machine: Machine, q: Array, units: Array, found: Clearance) -> Clearance:
    """Return the bounds up to the nearest end of the range of a kind, such as a distance of 0."""
    angle = machine.instance.units.angle
    ends = np.array([value_range(row.kind, angle) for row in machine.instance.constraints])
    ends = ends * machine.units[:, None]
    rooms = np.abs(ends - q[:, None]) / units[:, None]
    rooms[held(machine)] = np.inf
    k, which = np.unravel_index(int(first_smallest(rooms.ravel())), rooms.shape)
    if np.isinf(rooms[k, which]):
        return found
    there = q.copy()
    there[k] = ends[k, which]
    size = float(rooms[k, which])
    return replace(found, upper=size, numbers=there, by="end of range", end=int(k))


class _Lines(ABC):
    """A mode followed with proof from a pose along straight lines to the corners of a box.

    At the nearest of all folds the change of the numbers has the signs of a left null vector of
    the Jacobian matrix, in units of the weights: the box of numbers touches the set of folds in a
    corner. The numbers at the pose have shape (m,), the ways to the corners (n, m).
    """

    def __init__(self, machine: Machine, start: Array, ways: Array, R: Array, T: Array) -> None:
        self.machine, self.start, self.ways, self.R, self.T = machine, start, ways, R, T

    @abstractmethod
    def ends(self, reach: float) -> Array:
        """Return where lines up to a size end before it, infinite for others, shape (n,)."""

    @abstractmethod
    def singular(self, k: int, end: float, reach: float) -> tuple[float, Array, Array, str] | None:
        """Return size and pose where a line ends, if it is singular there, and what it is."""

    @abstractmethod
    def platform(self, rows: Array) -> MovingPlatform | MovingGeometry:
        """Return what moves along rows."""

    def rows(self, k: int, sizes: Array) -> Array:
        """Return the rows at sizes on a line, in the units of the instance."""
        numbers: Array = (self.start + sizes[:, None] * self.ways[k]) / self.machine.units
        return numbers

    def fold(self, k: int, reach: float) -> tuple[float, Array, Array, str] | None:
        """Return the size and the pose of the proved fold in which the mode ends on a line."""
        rows, times = self.rows(k, np.array([0.0, reach])), np.array([1.0, 2.0])
        run = Run(self.machine.instance, self.platform(rows), times, rows, FollowOptions())
        for event in run.follow(self.R[None], self.T[None], np.ones(1, np.int64)).events:
            if event.kind == "fold":
                return (event.high - 1) * reach, event.R, event.T, "fold"
        return None

    def nearest(self, lower: float, most: float) -> tuple[float, Array, Array, Array, str] | None:
        """Return size, numbers and pose of the nearest singularity up to a size, and what it is.

        Of lines that are equally long but for rounding errors the first is taken.
        """
        reach = min(most, max(_FIRST * lower, _LEAST))
        while True:
            ends = self.ends(reach)
            best: tuple[float, Array, Array, Array, str] | None = None
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
        sizes = np.array([0.0, reach])
        rows = np.stack([self.rows(k, sizes) for k in range(len(self.ways))])
        platform = self.platform(rows.reshape(-1, 6))
        pose = platform.points(self.R[None], self.T[None])
        found = platform.follow(
            platform.internal(rows), np.arange(len(rows)), np.repeat(pose, len(rows), axis=0)
        )
        return np.where(found.stop == Stop.STEP, found.fraction * reach, np.inf)

    def platform(self, rows: Array) -> MovingPlatform:
        return MovingPlatform(over_rows(self.machine.instance, rows))

    def singular(self, k: int, end: float, reach: float) -> tuple[float, Array, Array, str] | None:
        return self.fold(k, reach)

    def in_octants(self, units: Array, found: Clearance) -> float:
        """Return a better lower bound: the box is proved as 64 boxes with a corner at the values.

        The mode is followed with proof to the centre of each small box, within this box. A small
        box has one regular solution for all its values, and it is the mode at the centre. Regular
        solutions that agree at one point agree along the whole way, so it is the mode at the common
        corner, too. For the same reason small boxes have the same solutions on common faces.
        """
        platform, numbers = MovingPlatform(apart(self.machine.instance)), self.machine.units
        centre, step = (platform.internal(part / numbers) for part in (self.start, self.ways))
        pose = np.repeat(platform.points(self.R[None], self.T[None]), len(step), axis=0)

        def proved(sizes: Array) -> NDArray[np.bool_]:
            size = float(sizes[0])
            middles = centre + size / 2 * step
            ends = np.stack((np.broadcast_to(centre, step.shape), middles), axis=1)
            followed = platform.follow(ends, np.arange(len(step)), pose)
            if not (followed.stop == Stop.END).all():
                return np.zeros(1, bool)
            near = Neighbourhood(platform, followed.points[:, -1], middles)
            box = near.box(near.widths(size / 2 * units) * (1 + 1e-12))
            return np.array([(box.measure < 1).all()])

        low, high = np.array([found.lower]), np.array([found.upper])
        return float(bisected(proved, low, high, _REFINEMENTS)[0][0])


class _MachineLines(_Lines):
    """Lines of the numbers of drives, which end in proved folds, or where symmetric modes meet."""

    def __init__(self, machine: Machine, start: Array, ways: Array, R: Array, T: Array) -> None:
        super().__init__(machine, start, ways, R, T)
        self.moved = np.flatnonzero(machine.moved).tolist()
        owners = {(one.name, one.body): one for one in coordinates(machine.instance)}
        bodies = [BODIES[int(not machine.on_platform[machine.users(k)[0]])] for k in self.moved]
        names = [machine.names[k] for k in self.moved]
        self.chosen = [owners[pair] for pair in zip(names, bodies, strict=True)]
        self.follower = RowFollower(machine.instance, self.chosen)
        self.last: dict[int, tuple[Array, Array]] = {}

    def platform(self, rows: Array) -> MovingGeometry:
        return MovingGeometry(at_values(self.machine.instance, rows[0]), self.chosen)

    def rows(self, k: int, sizes: Array) -> Array:
        """Return the rows at sizes on a line: six values, then the numbers of cranks and slides."""
        machine, numbers = self.machine, super().rows(k, sizes)
        values = np.where(machine.driven, machine.rods, numbers[:, machine.index])
        return np.concatenate((values, numbers[:, self.moved]), axis=1)

    def follow(self, k: int, sizes: Array) -> FollowedMode:
        """Follow a line over rows at increasing sizes."""
        return self.follower.follow(self.rows(k, sizes), self.R, self.T)

    def ends(self, reach: float) -> Array:
        found = np.full(len(self.ways), np.inf)
        for k in range(len(found)):
            mode = self.follow(k, np.array([0.0, reach]))
            if mode.reached == 0:
                found[k], self.last[k] = mode.part * reach, mode.last
        return found

    def singular(self, k: int, end: float, reach: float) -> tuple[float, Array, Array, str] | None:
        """Return size and pose at the end of a line, if it is singular there, and what it is.

        Towards a fold the square of 1 / condition falls linearly to zero; where modes meet that are
        symmetric, 1 / condition itself does. Which of them is straighter is extrapolated; a fold is
        proved.
        """
        sizes = end * (1 - _BEFORE * np.array([3, 2, 1]))
        mode = self.follow(k, np.concatenate(([0.0], sizes)))
        if len(mode.T) < len(sizes) + 1:
            return None
        q = self.start + sizes[:, None] * self.ways[k]
        fall = 1 / condition_numbers(self.machine.arrangement(q), mode.R[1:], mode.T[1:])
        bends = [abs(x[0] + x[2] - 2 * x[1]) / x[0] for x in (fall, fall**2)]
        x = fall if bends[0] <= bends[1] else fall**2
        a, b, c = (np.prod(np.delete(x, j) / (np.delete(x, j) - x[j])) for j in range(3))
        size = float(sizes @ [a, b, c])
        if not abs(size / end - 1) < _BEFORE:
            return None
        proved = self.fold(k, reach) if bends[1] < bends[0] else None
        return proved or (max(size, end), *self.last[k], "singular pose")

    def dead_point(self, high: float) -> tuple[float, int | None]:
        """Return the least size at which a gain changes its sign on a line, and its drive."""
        machine = self.machine
        gains = np.sign(machine.gains(self.R, self.T, self.start))
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
                signs = np.sign(machine.gains(R, T, self.start + sizes[:, None] * self.ways[k]))
                changed[line, : len(sizes)] = (signs * gains < 0) & machine.driven
            if changed.any():
                k = int(changed.any(axis=(0, 2)).argmax())
                drive = int(machine.index[changed[:, k].any(axis=0).argmax()])
                some, low, high = some[changed[:, k].any(axis=1)], parts[k - 1], parts[k]
            elif drive is None and high < _FARTHEST:
                some, low, high = some[alive], high, _GROWTH * high
            else:
                break
        return (np.inf if drive is None else float(high)), drive


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
    bounds: tuple[Clearance, ...]

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
        of_drives = self.of == "drives"
        machine = Machine.of(self.instance) if of_drives else value_machine(self.instance)
        return [(_of_drives if of_drives else _of_values)(machine, one) for one in self.bounds]

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each pose, without places; imports pandas.

        The columns are lower, upper, ratio and by, and constraint, or, of drives, working_modes,
        dead_point and drive.
        """
        import pandas as pd

        drives = ["working_modes", "dead_point", "drive"]
        last = drives if self.of == "drives" else ["constraint"]
        columns = ["lower", "upper", "ratio", "by", *last]
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
    drives: ArrayLike | None = None,
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
    drives
        The readings of the m drives of a machine with cranks or slides at the poses, shape (n, m).
        By default those that reach the poses in the working modes of home.
    progress
        Receives the number of each pose.

    Raises
    ------
    ArgumentError
        Naming what is wrong.
    """
    R, T = checked_poses(R, T)
    R, T = R.reshape(-1, 3, 3), T.reshape(-1, 3)
    machine = Machine.of(instance)
    driven = machine.moves
    if drives is not None and driven:
        machine = _in_modes_of(machine, R, T, machine.from_readings(drives))
    of = of or KINDS[int(driven)]
    if of not in KINDS:
        message = f"found {of!r}, expected {' or '.join(KINDS)}"
        raise ArgumentError(message, "of")
    if points is not None and of != "pose":
        message = "points count for the clearance of a pose only"
        raise ArgumentError(message, "points")
    if of == "pose" and driven:
        message = (
            "not known of the pose of a machine with cranks or slides, whose joints move with it: "
            "use drives"
        )
        raise ArgumentError(message, "of")
    if of == "drives" or (of == "values" and not driven):
        each = each_clearance(machine, R, T, refine=refine, progress=progress)
        return Clearances(instance, of, tuple(each))
    if of == "values":
        q = _numbers(machine, R, T)
        unreached = np.isnan(q).any(axis=1)
        if unreached.any():
            message = f"the drives do not reach pose {int(unreached.argmax()) + 1}"
            raise ArgumentError(message, "R")
    found = []
    for k in progress(range(len(T)), total=len(T), label="poses"):
        if of == "pose":
            found.append(pose_clearance(instance, R[k], T[k], points=points, refine=refine))
        else:
            # Cranks and slides stay where the pose has them.
            still, one = Machine.of(machine.instance_at(q[k])), slice(k, k + 1)
            found += each_clearance(still, R[one], T[one], refine=refine)
    return Clearances(instance, of, tuple(found))


def _in_modes_of(machine: Machine, R: Array, T: Array, q: Array) -> Machine:
    """Return the machine in the working modes in which its drives at q reach each of n poses."""
    signs = machine.modes_at(R, T, q)
    away = machine.points(machine.inverse(R, T, signs)) - machine.points(q)
    near = np.abs(away[:, machine.driven]) <= _SAME * machine.stated_arrangement.length
    for k in np.flatnonzero(~near.all(axis=(1, 2)))[:1].tolist():
        raise ArgumentError(f"the rods have other lengths with drives so at pose {k + 1}", "drives")
    return replace(machine, signs=signs)


def _finite(number: float) -> float | None:
    return number if number < float("inf") else None


def _listed(part: Array | None) -> list[Any] | None:
    return None if part is None else part.tolist()


def _of_drives(machine: Machine, found: Clearance) -> dict[str, Any]:
    """Return the bounds of one pose, and the drives at the nearest event."""
    return {
        "lower": found.lower,
        "working_modes": found.working_modes,
        "upper": _finite(found.upper),
        "by": found.by,
        "dead_point": _finite(found.dead_point),
        "ratio": _finite(found.ratio),
        "drive": None if found.drive is None else machine.names[found.drive],
        "drives": None if found.numbers is None else machine.readings(found.numbers).tolist(),
        "R": _listed(found.R),
        "T": _listed(found.T),
    }


def _of_values(machine: Machine, found: Clearance) -> dict[str, Any]:
    """Return the bounds of one pose, and the values at the nearest event; those of a pose, too."""
    numbers = found.numbers
    if numbers is None and found.R is not None:
        numbers = machine.inverse(found.R, np.asarray(found.T))
    return {
        "lower": found.lower,
        "upper": _finite(found.upper),
        "ratio": _finite(found.ratio),
        "by": found.by,
        "constraint": None if found.end is None else found.end + 1,
        "values": None if numbers is None else machine.readings(numbers).tolist(),
        "R": _listed(found.R),
        "T": _listed(found.T),
    }
