"""How many assembly modes there are where one or two values vary, and where that changes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gspcli.defaults import SEED
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.residuals import condition_numbers
from gspcli.motion.trajectories import track
from gspcli.motion.value_files import stated_values
from gspcli.solver import solve_values

Array = NDArray[np.float64]


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
        The number of real poses at each node, shape (n1,) or (n1, n2); -1 where not all poses
        were found, or where they are infinitely many.
    conditions
        The smallest condition number of a real pose, infinite where there is none, same shape.
    """

    instance: Instance
    axes: tuple[Axis, ...]
    modes: NDArray[np.int64]
    conditions: Array

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
        values = stated_values(self.instance)
        for axis, k in zip(self.axes, node, strict=True):
            values[axis.constraint] = axis.values[k]
        return values


@dataclass(frozen=True, eq=False)
class Crossing:
    """A proved fold between two neighbouring nodes: a point of the discriminant.

    Attributes
    ----------
    values
        The values that vary, there.
    change
        How many modes there are more on the side of the greater value: 2 or -2.
    """

    values: tuple[float, ...]
    change: int


def scan(
    instance: Instance,
    axes: Sequence[Axis],
    *,
    seed: int = SEED,
    jobs: int = 1,
    progress: Iterable[object] | None = None,
) -> Scan:
    """Count the real poses at all nodes of a grid, all poses being found at each.

    Parameters
    ----------
    instance
        Geometry, units, sides, and the values that do not vary.
    axes
        One or two values that vary.
    seed, jobs
        As for `solve_values`.
    progress
        Consumed one item a node.

    Raises
    ------
    ArgumentError
        If there are not one or two axes of different constraints.
    """
    if len(axes) not in (1, 2) or len({axis.constraint for axis in axes}) < len(axes):
        message = "expected one or two different constraints to vary"
        raise ArgumentError(message, "axes")
    shape = tuple(len(axis.values) for axis in axes)
    values = np.tile([c.value.value for c in instance.constraints], (*shape, 1))
    for axis, grid in zip(
        axes, np.meshgrid(*(axis.values for axis in axes), indexing="ij"), strict=True
    ):
        values[..., axis.constraint] = grid
    arrangement = Arrangement.of(instance)
    modes = np.empty(values[..., 0].size, np.int64)
    conditions = np.full(modes.shape, np.inf)
    real: list[tuple[Array, Array]] = []
    steps = iter(progress) if progress is not None else None
    found = solve_values(instance, values.reshape(-1, values.shape[-1]), seed=seed, jobs=jobs)
    for k, poses in enumerate(found):
        complete = poses.problem is None and poses.account.verdict == "complete"
        modes[k] = poses.real.sum() if complete else -1
        real.append((poses.R[poses.real].real, poses.T[poses.real].real))
        if steps is not None:
            next(steps, None)
    # All at once: most nodes have a few poses only.
    R, T = (np.concatenate([pose[k] for pose in real]) for k in (0, 1))
    nodes = np.repeat(np.arange(len(real)), [len(pose[1]) for pose in real])
    np.minimum.at(conditions, nodes, condition_numbers(arrangement, R, T))
    return Scan(instance, tuple(axes), modes.reshape(shape), conditions.reshape(shape))


def crossings(found: Scan, *, seed: int = SEED) -> Iterator[tuple[Crossing, ...]]:
    """Yield, for each edge of the grid where the number of modes changes, the folds on it.

    The modes are followed from the node that has more of them, with proof.
    """
    for node, other in found.edges:
        first, last = (node, other) if found.modes[node] > found.modes[other] else (other, node)
        ends = np.stack([found.values_at(first), found.values_at(last)])
        path = track(found.instance, ends, seed=seed)
        folds = {round(event.low, 12): event for event in path.events if event.kind == "fold"}
        here = []
        for event in folds.values():
            at = ends[0] + (event.low - 1) * (ends[1] - ends[0])
            values = tuple(float(at[axis.constraint]) for axis in found.axes)
            here.append(Crossing(values, -2 if first == node else 2))
        yield tuple(here)
