"""The number of assembly modes while one or two values vary."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from gspcli.defaults import SEED
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.residuals import condition_numbers
from gspcli.motion.files.value_files import nominal_values
from gspcli.motion.singularities.clearances import clearances, range_weights
from gspcli.records import dataclass
from gspcli.solver import solve_batch
from gspcli.workers import HERE, Workers

Array = NDArray[np.float64]

#: Marks instead of a number of modes: not all poses were found, or none were searched for.
UNKNOWN, MISSING = -1, -2
#: Nodes of one piece of work.
_PIECE = 1000


@dataclass(frozen=True)
class Axis:
    """A value that varies.

    Attributes
    ----------
    constraint
        Its index, from 0.
    values
        The nodes, increasing, in the units of the instance.
    """

    constraint: int
    values: tuple[float, ...]


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
        infinite where there is none, same shape; None if not asked for.
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
            If there are not one or two axes of different constraints.
        """
        if len(axes) not in (1, 2) or len({axis.constraint for axis in axes}) < len(axes):
            message = "expected one or two different constraints to vary"
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
        return -(-self.modes.size // _PIECE)

    def enter(self, piece: Piece) -> None:
        """Enter the results at some nodes."""
        rows = slice(piece.number * _PIECE, piece.number * _PIECE + len(piece.modes))
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
    """The results at `_PIECE` nodes: modes, conditions and clearances, or empty."""

    number: int
    modes: tuple[int, ...]
    conditions: tuple[float, ...]
    clearances: tuple[float, ...]


def scanned(found: Scan, seed: int, number: int) -> Piece:
    """Return a piece of a scan: all poses are found at each node."""
    nodes = np.arange(number * _PIECE, min((number + 1) * _PIECE, found.modes.size))
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
        One or two values that vary.
    clearance
        Whether to bound the clearance of each pose, too.
    seed
        As for `solve_values`.
    workers
        The processes that do the work.

    Raises
    ------
    ArgumentError
        If there are not one or two axes of different constraints.
    """
    found = Scan.empty(instance, axes, clearance=clearance)
    for piece in workers.as_completed(partial(scanned, found, seed), range(found.pieces)):
        found.enter(piece)
    return found
