"""Where the number of modes changes between the nodes of a scan: folds, and curves of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import field

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.branches.folds import prove_fold
from gspcli.defaults import SEED
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import Field
from gspcli.geometry.residuals import condition_numbers
from gspcli.motion.following.branch_follower import MovingPlatform
from gspcli.motion.following.tracks import Event
from gspcli.motion.following.trajectories import at_values, track
from gspcli.motion.singularities.discriminant import Curve, Discriminant
from gspcli.motion.singularities.value_scans import Scan
from gspcli.records import dataclass
from gspcli.solver import solve_batch

Array = NDArray[np.float64]
#: Parts of the ranges: what is nearer to the border of the grid is on it.
_BORDER = 1e-9
#: Random values at which curves are looked for that no edge tells of.
_SAMPLES = 32
#: An edge of the grid: along which axis, and its first node.
Edge = tuple[int, tuple[int, ...]]


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


@dataclasses.dataclass(eq=False)
class Boundary:
    """The discriminant as far as it was found.

    Attributes
    ----------
    crossings
        Proved folds on the edges of the grid.
    curves
        Over two values: the discriminant through them.
    unexplained
        Edges on which the changes at the crossings do not add up to the difference of the numbers
        of modes at the ends.
    """

    crossings: list[Crossing] = field(default_factory=list)
    curves: list[Curve] = field(default_factory=list)
    unexplained: list[Edge] = field(default_factory=list)


def boundary(found: Scan, *, seed: int = SEED) -> Boundary:
    """Return where the number of modes changes; as `boundaries`, at the end."""
    *_, last = boundaries(found, seed=seed)
    return last


def boundaries(found: Scan, *, seed: int = SEED) -> Iterator[Boundary]:
    """Yield what is known of where the number of modes changes, after each edge of the grid.

    The modes are followed with proof from the node that has more of them. Over two values the
    discriminant is followed as a curve from each fold so found, and where it crosses edges of the
    grid, too, its folds are proved there; so only a few edges have to be looked at. Curves that no
    edge tells of are looked for at random values, without a proof that none is missed.
    """
    result = Boundary()
    sums: dict[Edge, int] = {}
    known: dict[Edge, list[Crossing]] = {}
    following = _Curves(found) if len(found.axes) == 2 else None
    edges = [
        (next(axis for axis, k in enumerate(node) if other[axis] != k), node, other)
        for node, other in found.edges
    ]

    def enter(curve: Curve, *, new: bool) -> None:
        before = len(result.crossings)
        for edge, crossing in following.crossings(curve) if following else ():
            # A curve may begin on a line, and be found again from another edge.
            if any(_same(crossing, other) for other in known.get(edge, [])):
                continue
            known.setdefault(edge, []).append(crossing)
            sums[edge] = sums.get(edge, 0) + crossing.change
            result.crossings.append(crossing)
        if new or len(result.crossings) > before:
            result.curves.append(curve)

    for axis, node, other in edges:
        wanted = int(found.modes[other] - found.modes[node])
        if sums.get((axis, node), 0) != wanted:
            for event, values, change in _folds(found, node, other, seed):
                curve = following.through(event, values) if following else None
                if curve is None:
                    sums[axis, node] = sums.get((axis, node), 0) + change
                    result.crossings.append(Crossing(values, change))
                    continue
                enter(curve, new=False)
                if sums.get((axis, node), 0) == wanted:
                    break
        yield result
    if following is not None:
        for curve in following.hidden(result.curves, seed):
            enter(curve, new=True)
    result.unexplained = [
        (axis, node)
        for axis, node, other in edges
        if sums.get((axis, node), 0) != found.modes[other] - found.modes[node]
    ]
    yield result


def _folds(
    found: Scan, node: tuple[int, ...], other: tuple[int, ...], seed: int
) -> Iterator[tuple[Event, tuple[float, ...], int]]:
    """Yield the folds between two nodes, the values there and the change along the axis."""
    first, last = (node, other) if found.modes[node] > found.modes[other] else (other, node)
    ends = np.stack([found.values_at(first), found.values_at(last)])
    path = track(found.instance, ends, seed=seed)
    folds = {round(event.low, 12): event for event in path.events if event.kind == "fold"}
    for event in folds.values():
        at = ends[0] + (event.low - 1) * (ends[1] - ends[0])
        values = tuple(float(at[axis.constraint]) for axis in found.axes)
        yield event, values, -2 if first == node else 2


def _same(first: Crossing, second: Crossing) -> bool:
    return bool(np.allclose(first.values, second.values, rtol=1e-9, atol=1e-12))


class _Curves:
    """Curves of the discriminant and the grid of a scan over two values."""

    def __init__(self, found: Scan) -> None:
        self.found = found
        last = found.values_at([-1] * len(found.axes))
        self.platform = MovingPlatform(at_values(found.instance, last))
        nodes = [np.array(axis.values) for axis in found.axes]
        low, high = (np.array([grid[k] for grid in nodes]) for k in (0, -1))
        varied = (found.axes[0].constraint, found.axes[1].constraint)
        self.equations = Discriminant(self.platform, found.values_at((0, 0)), varied, low, high)
        #: The nodes as parts of the ranges.
        self.grids = [(grid - a) / (b - a) for grid, a, b in zip(nodes, low, high, strict=True)]

    def through(self, event: Event, values: tuple[float, ...]) -> Curve | None:
        """Return the curve through a fold."""
        point = self.platform.points(event.R, event.T)
        start = self.equations.start(point, np.array(values))
        return None if start is None else self.equations.follow(start)

    def hidden(self, known: list[Curve], seed: int) -> Iterator[Curve]:
        """Yield other curves, through singular poses near those at random values.

        Newton's method begins at the real pose that is nearest to being singular and at the
        complex one that is nearest to being real.

        Parameters
        ----------
        known
            Curves that are known; may grow meanwhile.
        seed
            Of the values.
        """
        instance, varied = self.found.instance, self.equations.varied
        parts = np.random.default_rng(seed).uniform(size=(_SAMPLES, 2))
        values = np.tile([row.value.value for row in instance.constraints], (_SAMPLES, 1))
        values[:, varied] = self.equations.plane(np.pad(parts, ((0, 0), (16, 0))))
        batch = solve_batch(instance, values, seed=seed)
        for k in range(_SAMPLES):
            for point in self._nearly_singular(batch.R[k], batch.T[k], batch.real[k]):
                x = self.equations.start(point, values[k, varied])
                if x is None or not ((x[16:] >= 0) & (x[16:] <= 1)).all():
                    continue
                if not any(curve.contains(x) for curve in known):
                    yield self.equations.follow(x)

    def _nearly_singular(self, R: Field, T: Field, real: NDArray[np.bool_]) -> Iterator[Array]:
        """Yield Study points of one real and one complex solution of some values."""
        arrangement = Arrangement.of(self.found.instance)
        if real.any():
            R_real, T_real = R[real].real, T[real].real
            worst = int(condition_numbers(arrangement, R_real, T_real).argmax())
            yield self.platform.points(R_real[worst], T_real[worst])
        rest = ~real & np.isfinite(R).all(axis=(1, 2)) & np.isfinite(T).all(axis=1)
        if rest.any():
            points = self.platform.points(R[rest], T[rest])
            sizes = np.linalg.norm(points.imag, axis=1) / np.linalg.norm(points.real, axis=1)
            point = points[sizes.argmin()].real
            yield np.asarray(point / np.linalg.norm(point))

    def crossings(self, curve: Curve) -> Iterator[tuple[Edge, Crossing]]:
        """Yield where a curve crosses edges of the grid and the fold there is proved."""
        for x, y in zip(curve.unknowns[:-1], curve.unknowns[1:], strict=True):
            for axis in (0, 1):
                across = 1 - axis
                low, high = sorted((x[16 + across], y[16 + across]))
                lines = self.grids[across]
                # Curves end on the border of the grid.
                inside = (lines > low) & (lines <= high)
                inside[0] |= abs(low) < _BORDER
                inside[-1] |= abs(high - 1) < _BORDER
                for k in np.flatnonzero(inside).tolist():
                    at = self.equations.at_line(x, y, across, float(lines[k]))
                    found = None if at is None else self._proved(at, axis, k)
                    if found is not None:
                        yield found

    def _proved(self, at: Array, axis: int, line: int) -> tuple[Edge, Crossing] | None:
        """Return the crossing of a line of the grid at a singular pose, if it can be proved."""
        place, grid = float(at[16 + axis]), self.grids[axis]
        k = int(np.searchsorted(grid, place)) - 1
        if not 0 <= k < len(grid) - 1:
            return None
        node = (k, line) if axis == 0 else (line, k)
        other = (k + 1, line) if axis == 0 else (line, k + 1)
        rows = self.found.values_at(node), self.found.values_at(other)
        part = (place - grid[k]) / (grid[k + 1] - grid[k])
        fold = prove_fold(self.platform.system, rows, part, at[:8], at[8:16])
        if fold is None or not 0 <= fold.low <= fold.high <= 1:
            return None
        exact = rows[0] + fold.low * (rows[1] - rows[0])
        values = tuple(float(exact[one.constraint]) for one in self.found.axes)
        return (axis, node), Crossing(values, 2 * fold.bends)
