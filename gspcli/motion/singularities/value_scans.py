"""The number of assembly modes while one or two values, or readings of motors, vary."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from gspcli.defaults import SEED
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.drives import Drives
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.residuals import condition_numbers
from gspcli.motion.files.value_files import nominal_values
from gspcli.motion.singularities.clearances import clearances, range_weights
from gspcli.motion.singularities.drive_clearances import drive_clearances, drive_weights
from gspcli.records import dataclass
from gspcli.solver import solve, solve_batch
from gspcli.workers import HERE, Workers

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
        that of the drives (`gspcli.motion.singularities.drive_clearances`).
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


def scan(
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
