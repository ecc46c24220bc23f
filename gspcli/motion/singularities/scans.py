"""Scans: modes, or determinants, at the nodes of a grid of values, readings of drives, or poses."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.defaults import SEED
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.coordinates import choose, drive_corrections
from gspcli.geometry.drive_numbers import is_driven
from gspcli.geometry.drives import Drives
from gspcli.geometry.instance import Instance
from gspcli.geometry.measurement import jacobian
from gspcli.geometry.numbers import Number
from gspcli.geometry.printed_numbers import printed_conditions
from gspcli.geometry.quaternions import Field, quaternion_from_rotation
from gspcli.geometry.ranges import wrong_value
from gspcli.geometry.readings import factors, is_corrected, offsets, values_of, without_corrections
from gspcli.geometry.residuals import condition_numbers
from gspcli.motion.files.pose_files import PoseFormat, pose_columns, poses_of, rotations_of
from gspcli.motion.files.value_files import nominal_values
from gspcli.motion.following.branch_follower import FollowOptions, MovingPlatform
from gspcli.motion.following.branch_runs import Run
from gspcli.motion.following.moving_geometry import MovingGeometry
from gspcli.motion.following.row_instances import at_values
from gspcli.motion.following.tracks import Track
from gspcli.motion.following.trajectories import track
from gspcli.motion.poses.cranks import drive_values
from gspcli.motion.singularities.clearances import (
    clearances,
    drive_clearances,
    drive_weights,
    range_weights,
)
from gspcli.motion.singularities.pose_clearances import pose_clearances
from gspcli.records import EqualByContent, dataclass
from gspcli.solver import solve, solve_batch
from gspcli.wording import counted, listed, shown
from gspcli.workers import HERE, Workers

if TYPE_CHECKING:
    import pandas as pd

    from gspcli.motion.singularities.crossings import Boundary


Array = NDArray[np.float64]

#: Marks instead of a number of modes: not all poses were found, or none were searched for.
UNKNOWN, MISSING = -1, -2
#: Nodes of one piece of work; over drives each node is another geometry.
_PIECE, _DRIVEN_PIECE = 1000, 25


@dataclass(frozen=True)
class Axis:
    """A value, or the reading of a crank or slide, that varies.

    Attributes
    ----------
    constraint
        The index of the constraint, from 0; of a drive of the first that it moves.
    values
        The nodes, increasing, in the units of the instance.
    drive
        The name of the crank or slide; empty for a value.
    """

    constraint: int
    values: tuple[float, ...]
    drive: str = ""

    @property
    def name(self) -> str:
        """The drive, or the number of the constraint, from 1."""
        return self.drive or str(self.constraint + 1)


@dataclass(frozen=True, eq=False)
class Scan:
    """The modes at the nodes of a grid of values.

    Attributes
    ----------
    instance
        Geometry and the values that do not vary.
    axes
        One or two values that vary; n1 and n2 nodes.
    modes
        The number of real poses at each node, shape (n1,) or (n1, n2); `UNKNOWN` where not all
        poses were found, or where they are infinitely many, and `MISSING` where none were sought.
    conditions
        The smallest condition number of a real pose, infinite where there is none, same shape.
    clearances
        The smallest proved clearance of a real pose (`gspcli.motion.singularities.clearances`),
        infinite where there is none, same shape; None if not asked for. Where drives vary it is
        that of the drives (`gspcli.motion.singularities.clearances`).
    """

    instance: Instance
    axes: tuple[Axis, ...]
    modes: NDArray[np.int64]
    conditions: Array
    clearances: Array | None = None

    @classmethod
    def empty(cls, instance: Instance, axes: Sequence[Axis], *, clearance: bool = False) -> Scan:
        """Return a scan without any results.

        Raises
        ------
        ArgumentError
            If there are not one or two axes of different constraints or drives.
        """
        if len(axes) not in (1, 2) or len({axis.name for axis in axes}) < len(axes):
            message = "expected one or two different constraints or drives to vary"
            raise ArgumentError(message, "axes")
        shape = tuple(len(axis.values) for axis in axes)
        return cls(
            instance,
            tuple(axes),
            np.full(shape, MISSING),
            np.full(shape, np.inf),
            np.full(shape, np.inf) if clearance else None,
        )

    @property
    def pieces(self) -> int:
        """The number of pieces of the work."""
        return -(-self.modes.size // self.piece)

    @property
    def over_drives(self) -> bool:
        """Whether the reading of a crank or slide varies."""
        return any(axis.drive for axis in self.axes)

    @property
    def piece(self) -> int:
        """The number of nodes of a piece of the work."""
        return _DRIVEN_PIECE if self.over_drives else _PIECE

    def enter(self, piece: Piece) -> None:
        """Enter the results at some nodes."""
        rows = slice(piece.number * self.piece, piece.number * self.piece + len(piece.modes))
        self.modes.reshape(-1)[rows] = piece.modes
        self.conditions.reshape(-1)[rows] = piece.conditions
        if self.clearances is not None:
            self.clearances.reshape(-1)[rows] = piece.clearances

    @property
    def edges(self) -> Iterator[tuple[tuple[int, ...], tuple[int, ...]]]:
        """Neighbouring nodes with different numbers of modes, both known."""
        for axis in range(self.modes.ndim):
            for node in np.ndindex(*self.modes.shape):
                other = tuple(k + (d == axis) for d, k in enumerate(node))
                if other[axis] == self.modes.shape[axis]:
                    continue
                here, there = self.modes[node], self.modes[other]
                if here != there and min(here, there) >= 0:
                    yield node, other

    def values_at(self, node: Sequence[int]) -> Array:
        """Return the six values at a node; distances to planes are signed."""
        values = nominal_values(self.instance)
        for axis, k in zip(self.axes, node, strict=True):
            values[axis.constraint] = axis.values[k]
        return values


@dataclass(frozen=True)
class Piece:
    """The results at the nodes of one piece: modes, conditions and clearances, or empty."""

    number: int
    modes: tuple[int, ...]
    conditions: tuple[float, ...]
    clearances: tuple[float, ...]


def scanned(found: Scan, seed: int, number: int) -> Piece:
    """Return a piece of a scan: all poses are found at each node."""
    nodes = np.arange(number * found.piece, min((number + 1) * found.piece, found.modes.size))
    if found.over_drives:
        return _scanned_drives(found, seed, number, nodes)
    values = np.tile([c.value.value for c in found.instance.constraints], (len(nodes), 1))
    places = np.unravel_index(nodes, found.modes.shape)
    for axis, place in zip(found.axes, places, strict=True):
        values[:, axis.constraint] = np.array(axis.values)[place]
    batch = solve_batch(found.instance, values, seed=seed)
    modes = np.where(batch.complete, batch.real.sum(axis=1), UNKNOWN)
    rows, columns = np.nonzero(batch.real)
    R, T = batch.R[rows, columns].real, batch.T[rows, columns].real
    conditions = np.full(len(nodes), np.inf)
    np.minimum.at(conditions, rows, condition_numbers(Arrangement.of(found.instance), R, T))
    spaces = np.full(len(nodes) if found.clearances is not None else 0, np.inf)
    if found.clearances is not None and len(rows):
        weights = range_weights(found.instance)
        np.minimum.at(spaces, rows, clearances(found.instance, R, T, weights=weights))
    return Piece(number, *(tuple(array.tolist()) for array in (modes, conditions, spaces)))


def _scanned_drives(found: Scan, seed: int, number: int, nodes: NDArray[np.int64]) -> Piece:
    """Return a piece of a scan over drives: each node is solved with its joints moved."""
    drives = Drives.of(found.instance)
    places = np.unravel_index(nodes, found.modes.shape)
    counts, conditions, spaces = [], [], []
    for node in zip(*places, strict=True):
        here = [int(k) for k in node]
        result = solve(moved_to(found, drives, here), seed=seed)
        known = result.verdict == "complete"
        counts.append(int(result.real.sum()) if known else UNKNOWN)
        R, T = result.R[result.real].real, result.T[result.real].real
        real = condition_numbers(Arrangement.of(result.instance), R, T)
        conditions.append(float(real.min(initial=np.inf)))
        if found.clearances is not None:
            spaces.append(_drive_clearance(found, drives, here, R, T))
    return Piece(number, tuple(counts), tuple(conditions), tuple(spaces))


def _drive_clearance(found: Scan, drives: Drives, node: Sequence[int], R: Array, T: Array) -> float:
    """Return the smallest proved clearance of the poses at a node in their drives."""
    there = _with_values(found, node, found.instance)
    weights, _ = drive_weights(there)
    least = np.inf
    # Each pose is on knees of its own: those that have the drives at this node.
    gains = Drives.of(there).gains(R, T, np.tile(_places(found, drives, node), (len(T), 1)))
    for k, knees in enumerate(np.where(gains < 0, -1, 1)):
        one = slice(k, k + 1)
        lower, _ = drive_clearances(there, R[one], T[one], weights=weights, knees=knees)
        least = min(least, float(lower[0]))
    return least


def moved_to(found: Scan, drives: Drives, node: Sequence[int]) -> Instance:
    """Return the platform at a node: joints moved by the drives that vary, and other values.

    Other cranks and slides stay where their points are stated.
    """
    return _with_values(found, node, drives.instance_at(_places(found, drives, node)))


def _places(found: Scan, drives: Drives, node: Sequence[int]) -> Array:
    """Return where the cranks and slides are at a node, shape (m,)."""
    readings, q = np.zeros(drives.count), np.zeros(drives.count)
    for axis, k in zip(found.axes, node, strict=True):
        if axis.drive:
            readings[drives.names.index(axis.drive)] = axis.values[k]
    moved = np.array([name in {axis.drive for axis in found.axes} for name in drives.names])
    q[moved] = drives.from_readings(readings)[moved]
    return q


def _with_values(found: Scan, node: Sequence[int], instance: Instance) -> Instance:
    """Return an instance with the values as stated, but for those that vary."""
    changed = {
        axis.constraint: Number.of(axis.values[k])
        for axis, k in zip(found.axes, node, strict=True)
        if not axis.drive
    }
    stated = {k: row.value for k, row in enumerate(found.instance.constraints)}
    return instance.with_values(stated | changed)


def scan_grid(
    instance: Instance,
    axes: Sequence[Axis],
    *,
    clearance: bool = False,
    seed: int = SEED,
    workers: Workers = HERE,
) -> Scan:
    """Count the real poses at all nodes of a grid; all poses are found at each node.

    Parameters
    ----------
    instance
        Geometry, units, sides, and the values that do not vary.
    axes
        One or two values, or readings of drives, that vary.
    clearance
        Whether to bound the clearance of each pose, too.
    seed
        As for `solve_values`.
    workers
        The processes that do the work.

    Raises
    ------
    ArgumentError
        As for `Scan.empty`.
    """
    found = Scan.empty(instance, axes, clearance=clearance)
    for piece in workers.as_completed(partial(scanned, found, seed), range(found.pieces)):
        found.enter(piece)
    return found


class ScanRows:
    """The rows of a scan: six values, then the numbers of the drives that vary.

    Parameters
    ----------
    found
        The scan; its values have no offsets and scales any more, its drives have theirs.

    Attributes
    ----------
    varied
        The entries of a row that vary, one of each axis.
    scales, added
        The number of each axis is its reading times the scale, plus what is added; shape (axes,).
    """

    def __init__(self, found: Scan) -> None:
        self.found = found
        drives = [axis.drive for axis in found.axes if axis.drive]
        self._chosen = choose(found.instance, drives)
        self._values = nominal_values(found.instance)
        self.varied = [
            6 + drives.index(axis.drive) if axis.drive else axis.constraint for axis in found.axes
        ]
        self.scales, self.added = np.ones(len(found.axes)), np.zeros(len(found.axes))
        moves = np.array([bool(axis.drive) for axis in found.axes])
        self.added[moves], self.scales[moves] = drive_corrections(found.instance, self._chosen)

    @property
    def low(self) -> Array:
        """The first node of each axis, as it is read."""
        return np.array([axis.values[0] for axis in self.found.axes])

    @property
    def high(self) -> Array:
        """The last node of each axis, as it is read."""
        return np.array([axis.values[-1] for axis in self.found.axes])

    def read(self, node: Sequence[int]) -> Array:
        """Return what varies at a node, as it is read, shape (axes,)."""
        pairs = zip(self.found.axes, node, strict=True)
        return np.array([axis.values[k] for axis, k in pairs])

    def row(self, read: Array) -> Array:
        """Return the row of what varies, as it is read: values and numbers of drives."""
        row = np.concatenate((self._values, np.zeros(len(self._chosen))))
        row[self.varied] = read * self.scales + self.added
        return row

    def platform(self) -> MovingPlatform | MovingGeometry:
        """Return the platform that moves with what varies."""
        there = at_values(self.found.instance, self.row(self.high))
        return MovingGeometry(there, self._chosen) if self._chosen else MovingPlatform(there)

    def track(self, start: Sequence[int], goal: Sequence[int], seed: int) -> Track:
        """Follow all real modes from one node to another, with proof; t is 1 and 2 there."""
        ends = np.stack([self.row(self.read(start)), self.row(self.read(goal))])
        # From the first node, so that the numbers of modes need not be carried along.
        if not self._chosen:
            begin = values_of(self.found.instance, ends[:1])[0]
            return track(at_values(self.found.instance, begin), ends, seed=seed)
        there = moved_to(self.found, Drives.of(self.found.instance), start)
        result = solve(there, seed=seed)
        R, T = result.R[result.real].real, result.T[result.real].real
        platform = MovingGeometry(at_values(self.found.instance, ends[0]), self._chosen)
        run = Run(self.found.instance, platform, np.array([1.0, 2.0]), ends, FollowOptions())
        return run.follow(R, T, np.arange(1, len(R) + 1))

    def solved(
        self, read: Array, seed: int
    ) -> list[tuple[Arrangement, Field, Field, NDArray[np.bool_]]]:
        """Return all poses at some places: where the joints are, R, T, and which are real.

        Parameters
        ----------
        read
            What varies, as it is read, shape (n, axes).
        seed
            As for `solve`.
        """
        if not self._chosen:
            stated = [constraint.value.value for constraint in self.found.instance.constraints]
            values = np.tile(stated, (len(read), 1))
            values[:, self.varied] = read
            batch = solve_batch(self.found.instance, values, seed=seed)
            still = Arrangement.of(self.found.instance)
            return [(still, *of) for of in zip(batch.R, batch.T, batch.real, strict=True)]
        moving = MovingGeometry(self.found.instance, self._chosen)
        every = []
        for row in map(self.row, read):
            there = at_values(moving.instance_at(row), row)
            one = solve(there, seed=seed)
            every.append((Arrangement.of(there), one.R, one.T, one.real))
        return every


#: Columns of the pose at a fold.
POSE = ("Tx", "Ty", "Tz", "qw", "qx", "qy", "qz")


@dataclass(frozen=True, eq=False)
class ScanResult(EqualByContent):
    """The result of a scan of values.

    Attributes
    ----------
    found
        The modes at the nodes.
    limits
        The folds between nodes; empty if they were not asked for.
    folds
        Whether tables show the folds instead of the nodes.
    """

    found: Scan
    limits: Boundary
    folds: bool = False

    def __repr__(self) -> str:
        known = self.found.modes[self.found.modes >= 0]
        modes = f", {known.min()} to {known.max()} modes" if known.size else ""
        folds = f", {counted(len(self.limits.crossings), 'fold')}" if self.folds else ""
        instance = self.found.instance
        size = counted(self.found.modes.size, "node")
        return f"<ScanResult of {instance.name or instance.type.id}: {size}{modes}{folds}>"

    @property
    def names(self) -> list[str]:
        """The numbers of the constraints, and the drives, that vary."""
        return [axis.name for axis in self.found.axes]

    def rows(self) -> list[dict[str, Any]]:
        """Return the nodes that are known, or the folds, as plain data."""
        return self._crossings() if self.folds else self._nodes()

    def to_frame(self) -> pd.DataFrame:
        """Return the nodes, or the folds, as a table (pandas is imported now)."""
        import pandas as pd

        return pd.DataFrame(self.rows())

    def to_json(self) -> dict[str, Any]:
        """Return everything as plain data of schema ``gsp.scan/1``."""
        axes = zip(self.names, self.found.axes, strict=True)
        document: dict[str, Any] = {
            "schema": "gsp.scan/1",
            **self.found.instance.to_json(),
            "vary": {name: list(axis.values) for name, axis in axes},
        }
        if not self.folds:
            return document | {"nodes": self.rows()}
        curves = [
            {
                "closed": curve.closed,
                "values": curve.values.tolist(),
                "cusps": curve.cusps.tolist(),
            }
            for curve in self.limits.curves
        ]
        meetings = [
            {
                "from": dict(zip(self.names, one.low, strict=True)),
                "to": dict(zip(self.names, one.high, strict=True)),
                "modes": [one.before, one.after],
                "poses": [
                    {
                        "modes": [before, after],
                        **dict(zip(POSE, _pose_numbers(R, T), strict=True)),
                    }
                    for before, after, R, T in one.poses
                ],
            }
            for one in self.limits.meetings
        ]
        return document | {"folds": self.rows(), "curves": curves, "meetings": meetings}

    def _nodes(self) -> list[dict[str, Any]]:
        found, rows = self.found, []
        conditions = printed_conditions(found.conditions)
        for node in np.ndindex(*found.modes.shape):
            axes = zip(self.names, found.axes, node, strict=True)
            row: dict[str, Any] = {name: axis.values[k] for name, axis, k in axes}
            modes = int(found.modes[node])
            if modes == MISSING:
                continue
            row |= {
                "modes": None if modes < 0 else modes,
                "condition": _finite(conditions[node]),
            }
            if found.clearances is not None:
                row["clearance"] = _finite(found.clearances[node])
            rows.append(row)
        return rows

    def _crossings(self) -> list[dict[str, Any]]:
        from gspcli.motion.singularities.crossings import in_order

        return [
            {
                **dict(zip(self.names, one.values, strict=True)),
                "change": one.change,
                **dict(zip(POSE, _pose_numbers(one.R, one.T), strict=True)),
            }
            for one in in_order(self.limits.crossings)
        ]


def scan(
    instance: Instance,
    vary: Mapping[int | str, ArrayLike],
    *,
    folds: bool = False,
    clearance: bool = False,
    seed: int = SEED,
    workers: Workers = HERE,
) -> ScanResult:
    """Count the real assembly modes while one or two values vary.

    Parameters
    ----------
    instance
        Geometry, units, sides, and the values that do not vary.
    vary
        Increasing values by the numbers of the constraints, from 1, or readings by the names of
        cranks and slides (``crank.B1``), in the units of the instance: one or two, shapes (n1,) and
        (n2,). Other cranks and slides stay where their points are stated.
    folds
        Whether to prove the folds between neighbouring nodes with different numbers.
    clearance
        Whether to bound the clearance of each pose, too.
    seed
        As for `solve_values`; nothing depends on it.
    workers
        The processes that do the work.

    Raises
    ------
    ArgumentError
        If a constraint or drive does not exist, or a value is impossible.
    """
    from gspcli.motion.singularities.crossings import Boundary, boundary

    axes = [axis_of(instance, k, np.asarray(v, float).tolist()) for k, v in vary.items()]
    asked = Scan.empty(instance, axes, clearance=clearance)
    check_values(asked, "vary")
    platform, moved = corrected(asked)
    found = scan_grid(platform, moved, clearance=clearance, seed=seed, workers=workers)
    result = as_read(asked, found, boundary(found) if folds else Boundary(), folds=folds)
    for array in (result.found.modes, result.found.conditions, result.found.clearances):
        if array is not None:
            array.setflags(write=False)
    return result


def axis_of(instance: Instance, name: int | str, values: Sequence[float]) -> Axis:
    """Return the axis of a constraint by its number, or of a crank or slide by its name.

    Raises
    ------
    ArgumentError
        If there is no such constraint or drive.
    """
    if not isinstance(name, str) and name in range(1, len(instance.constraints) + 1):
        return Axis(int(name) - 1, tuple(values))
    drives = Drives.of(instance)
    known = drive_names(instance)
    if not isinstance(name, str) or name not in known:
        what = shown(name) if isinstance(name, str) else f"constraint {name}"
        others = f" or {listed(known)}" if known else ""
        message = f"found {what}, expected a number from 1 to 6{others}"
        raise ArgumentError(message, "vary")
    return Axis(drives.users(drives.names.index(name))[0], tuple(values), name)


def drive_names(instance: Instance) -> list[str]:
    """Return the names of the cranks and slides of an instance."""
    drives = Drives.of(instance)
    return [name for name, moves in zip(drives.names, drives.moved, strict=True) if moves]


def corrected(asked: Scan) -> tuple[Instance, list[Axis]]:
    """Return the scan of values for a scan of readings: with offsets and scales applied."""
    if not is_corrected(asked.instance):
        return asked.instance, list(asked.axes)
    axes = [
        replace(axis, values=tuple(value * factor + offset for value in axis.values))
        for axis, factor, offset in zip(asked.axes, *_corrections(asked), strict=True)
    ]
    return without_corrections(asked.instance), axes


def as_read(asked: Scan, found: Scan, limits: Boundary, *, folds: bool) -> ScanResult:
    """Return the results with readings instead of values: offsets and scales are removed."""
    if not is_corrected(asked.instance):
        return ScanResult(found, limits, folds)
    scales, added = _corrections(asked)
    limits.crossings = [
        replace(one, values=tuple(((one.values - added) / scales).tolist()))
        for one in limits.crossings
    ]
    limits.curves = [
        replace(
            curve,
            values=(curve.values - added) / scales,
            cusps=(curve.cusps - added) / scales,
        )
        for curve in limits.curves
    ]
    limits.meetings = [
        replace(
            one,
            low=tuple(((one.low - added) / scales).tolist()),
            high=tuple(((one.high - added) / scales).tolist()),
        )
        for one in limits.meetings
    ]
    return ScanResult(replace(found, instance=asked.instance, axes=asked.axes), limits, folds)


def check_values(found: Scan, name: str) -> None:
    """Raise `ArgumentError` if a value is outside the range of its kind of constraint."""
    for axis in found.axes:
        if axis.drive:
            continue
        kind = found.instance.constraints[axis.constraint].kind
        for value in (axis.values[0], axis.values[-1]):
            wrong = wrong_value(kind, Number.of(value), found.instance.units.angle)
            if wrong and not kind.has_sides:
                message = f"found {value:g} for constraint {axis.constraint + 1}, {wrong}"
                raise ArgumentError(message, name)


def _corrections(asked: Scan) -> tuple[Array, Array]:
    """Return the factors of the values of the axes, and the numbers that are added to them."""
    chosen = [axis.constraint for axis in asked.axes]
    values = np.array([not axis.drive for axis in asked.axes])
    times, added = factors(asked.instance), offsets(asked.instance, signed=False)
    # Drives correct their own readings.
    return np.where(values, times[chosen], 1.0), np.where(values, added[chosen], 0.0)


def _pose_numbers(R: Array, T: Array) -> list[float]:
    return [*T.tolist(), *quaternion_from_rotation(R).tolist()]


def _finite(number: Any) -> float | None:
    return float(number) if number < float("inf") else None


#: An edge of the grid: its axis and its first node.
Edge = tuple[int, int, int]

_VARIABLE = ("x", "y", "z", "rx", "ry", "rz")
#: Halvings of an edge of the grid: to the last digit of a double.
_HALVINGS = 52


@dataclass(frozen=True)
class PoseAxis:
    """A coordinate of the pose that varies.

    Attributes
    ----------
    name
        ``x``, ``y``, ``z``, or ``rx``, ``ry``, ``rz``.
    values
        The nodes, increasing, in the units of the instance.
    """

    name: str
    values: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class PoseScan:
    """A grid of poses, and the determinant of the Jacobian matrix on it.

    Parameters
    ----------
    instance
        Geometry and units; its values are not used but for the rods that cranks and slides move:
        these are where the pose asks them to be, on the side of home.
    axes
        One or two coordinates that vary.
    pose
        The numbers of the pose, some of which vary: x, y, z and a quaternion, or three angles, or
        the nine entries of R.
    form
        The conventions of these numbers.
    """

    instance: Instance
    axes: tuple[PoseAxis, ...]
    pose: Sequence[float]
    form: PoseFormat

    def __post_init__(self) -> None:
        names = [axis.name for axis in self.axes]
        if len(names) not in (1, 2) or len(set(names)) < len(names):
            message = "expected one or two different coordinates to vary"
            raise ArgumentError(message, "axes")
        self._check_pose()
        for name in names:
            if name not in self._names or name not in _VARIABLE:
                found = " ".join(self._names)
                message = f"found {name} to vary, expected one of {' '.join(_VARIABLE)}"
                raise ArgumentError(f"{message} that the pose has: {found}", "axes")

    def _check_pose(self) -> None:
        if not self._names:
            message = f"found {len(self.pose)} numbers, expected 6, 7 or 12"
        elif len(self.pose) == len(_VARIABLE) and self.form.euler is None:
            message = "found angles without the order of their axes: say it with euler"
        else:
            wrong = rotations_of(np.array([self.pose[3:]]), self.form)[1]
            message = wrong[0][1] if wrong else ""
        if message:
            raise ArgumentError(message, "pose")

    @property
    def _names(self) -> tuple[str, ...]:
        return pose_columns(len(self.pose)) or ()

    def poses(self, places: Array) -> tuple[Array, Array]:
        """Return the poses (R, T) for numbers of the coordinates that vary, shape (n, axes)."""
        names = self._names
        rows = np.tile(np.asarray(self.pose, dtype=float), (len(places), 1))
        for axis, column in zip(self.axes, places.T, strict=True):
            rows[:, names.index(axis.name)] = column
        return poses_of(rows, self.form)

    def determinants_at(self, places: Array) -> Array:
        """Return determinants of the Jacobian matrix without units; NaN where there is none, (n,).

        Turns are about the centre of the platform's points, lengths in units of the typical
        length of the instance.
        """
        R, T = self.poses(places)
        arrangement = self._arrangement(R, T)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            rows = jacobian(arrangement, R, T)
            length = Arrangement.of(self.instance).length
            rows[..., :3] /= length
            rows[:, arrangement.angles] *= length
            regular = np.asarray(np.isfinite(rows).all(axis=(1, 2)))
            found = np.linalg.det(np.where(regular[:, None, None], rows, np.eye(6)))
        # The determinant does not depend on the point that the platform turns about.
        return np.asarray(np.where(regular, found, np.nan))

    def _arrangement(self, R: Array, T: Array) -> Arrangement:
        """Return the platform with its joints where its drives have them, NaN out of reach."""
        if not is_driven(self.instance):
            return Arrangement.of(self.instance)
        drives, q = drive_values(self.instance, R, T, along=False)
        return drives.arrangement(q)

    @cached_property
    def places(self) -> Array:
        """The nodes, shape (n1, axes) or (n1, n2, axes)."""
        return np.stack(np.meshgrid(*(axis.values for axis in self.axes), indexing="ij"), axis=-1)

    @cached_property
    def determinants(self) -> Array:
        """At the nodes, shape (n1,) or (n1, n2)."""
        flat = self.places.reshape(-1, len(self.axes))
        return self.determinants_at(flat).reshape(self.places.shape[:-1])

    @cached_property
    def conditions(self) -> Array:
        """Condition numbers at the nodes, shape (n1,) or (n1, n2)."""
        R, T = self.poses(self.places.reshape(-1, len(self.axes)))
        found = condition_numbers(self._arrangement(R, T), R, T)
        return np.asarray(found.reshape(self.places.shape[:-1]))

    @cached_property
    def clearances(self) -> Array:
        """Proved distances from singular poses (`pose_clearances`), shape (n1,) or (n1, n2)."""
        if is_driven(self.instance):
            message = (
                "of poses of a machine with cranks or slides there is none here: gsp clearance has "
                "that of one pose"
            )
            raise ArgumentError(message, "clearance")
        R, T = self.poses(self.places.reshape(-1, len(self.axes)))
        found = pose_clearances(self.instance, R, T)
        return np.asarray(found.reshape(self.places.shape[:-1]))

    @cached_property
    def singular(self) -> dict[Edge, Array]:
        """The changes of the sign of the determinant on edges of the grid, each shape (axes,).

        They are found by halving to the last digit. Two changes on one edge are not found.
        """
        signs = np.sign(self.determinants)
        starts, ends, edges = [], [], []
        for axis in range(len(self.axes)):
            low, high = (np.take(signs, _span(signs, axis, k), axis) for k in (0, 1))
            for node in np.argwhere(low * high < 0).tolist():
                other = [k + (d == axis) for d, k in enumerate(node)]
                starts.append(self.places[tuple(node)])
                ends.append(self.places[tuple(other)])
                edges.append((axis, node[0], node[1] if len(node) == 2 else 0))
        if not edges:
            return {}
        a, b = np.array(starts), np.array(ends)
        before = np.sign(self.determinants_at(a))
        for _ in range(_HALVINGS):
            middle = (a + b) / 2
            same = np.sign(self.determinants_at(middle)) == before
            a, b = np.where(same[:, None], middle, a), np.where(same[:, None], b, middle)
        # Where a machine with cranks or slides does not reach, the sign is not known.
        known = np.isfinite(self.determinants_at(a)) & np.isfinite(self.determinants_at(b))
        middles = zip(edges, (a + b) / 2, known.tolist(), strict=True)
        return {edge: middle for edge, middle, there in middles if there}

    @cached_property
    def curves(self) -> list[Array]:
        """The singular curve through these points, over two coordinates, in parts of shape (n, 2).

        Two points in a cell of the grid are joined; four are joined by the sign in the middle.
        """
        if len(self.axes) != 2:
            return []
        links: dict[Edge, list[Edge]] = {edge: [] for edge in self.singular}
        for first, second in self._joined():
            links[first].append(second)
            links[second].append(first)
        return [np.stack([self.singular[edge] for edge in chain]) for chain in _chains(links)]

    def _joined(self) -> Iterator[tuple[Edge, Edge]]:
        rows, columns = self.determinants.shape
        cells = {
            (i - di, j - dj)
            for axis, i, j in self.singular
            for di, dj in (((0, 0), (0, 1)) if axis == 0 else ((0, 0), (1, 0)))
        }
        for i, j in sorted(cells):
            if not (0 <= i < rows - 1 and 0 <= j < columns - 1):
                continue
            around: list[Edge] = [(0, i, j), (1, i + 1, j), (0, i, j + 1), (1, i, j)]
            here = [edge for edge in around if edge in self.singular]
            if len(here) == 2:
                yield here[0], here[1]
            elif len(here) == 4:
                corners = self.places[i : i + 2, j : j + 2].reshape(-1, 2)
                middle = np.sign(self.determinants_at(corners.mean(axis=0)[None]))[0]
                # The curve cuts off the corners whose sign is not that of the middle.
                turn = 0 if middle == np.sign(self.determinants[i, j]) else 1
                yield around[0], around[1 if turn == 0 else 3]
                yield around[2], around[3 if turn == 0 else 1]


def _span(array: Array, axis: int, first: int) -> NDArray[np.intp]:
    return np.arange(first, array.shape[axis] - 1 + first)


def _chains(links: dict[Edge, list[Edge]]) -> list[Sequence[Edge]]:
    """Return the chains and rings of a graph whose nodes have at most two neighbours."""
    left = dict(links)
    chains: list[Sequence[Edge]] = []
    starts = [edge for edge, others in links.items() if len(others) < 2]
    for start in (*starts, *links):
        if start not in left:
            continue
        chain, here = [start], left.pop(start)
        while ahead := [edge for edge in here if edge in left]:
            chain.append(ahead[0])
            here = left.pop(ahead[0])
        if len(chain) > 2 and start in here and len(links[start]) == 2:
            chain.append(start)
        chains.append(chain)
    return chains
