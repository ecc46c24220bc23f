"""Changes of the number of modes between the nodes of a scan: folds and curves of folds."""

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
from gspcli.motion.following.moving_geometry import MovingGeometry
from gspcli.motion.following.tracks import Event
from gspcli.motion.singularities.discriminant import Curve, Discriminant, DrivenDiscriminant
from gspcli.motion.singularities.scan_rows import ScanRows
from gspcli.motion.singularities.value_scans import Scan
from gspcli.records import dataclass

Array = NDArray[np.float64]
#: A point nearer than this to the border of the grid, in parts of the ranges, is on it.
_BORDER = 1e-9
#: Poses of folds that differ by more, as rotations or relatively, are different ones.
_APART = 1e-6
#: The number of random values at which curves are searched for that cross no edge.
_SAMPLES = 32
#: An edge of the grid: its axis and its first node.
Edge = tuple[int, tuple[int, ...]]


@dataclass(frozen=True, eq=False)
class Crossing:
    """A proved fold between two neighbouring nodes: a point of the discriminant.

    Mirror images have folds at the same values: each counts once, at its own pose.

    Attributes
    ----------
    values
        The values that vary, there.
    change
        The change of the number of modes towards the greater value: 2 or -2.
    R, T
        The pose at which two modes meet, shapes (3, 3) and (3,).
    """

    values: tuple[float, ...]
    change: int
    R: Array
    T: Array


@dataclasses.dataclass(eq=False)
class Boundary:
    """The part of the discriminant that was found.

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
    """Return the last result of `boundaries`."""
    *_, last = boundaries(found, seed=seed)
    return last


def boundaries(found: Scan, *, seed: int = SEED) -> Iterator[Boundary]:
    """Yield the boundary that is known so far, after each edge of the grid.

    The modes are followed with proof from the node that has more of them. If this does not explain
    the change, they are followed from the other node, too: some may end and others begin between.
    Over two values the discriminant is followed as a curve from each fold. Where the curve crosses
    other edges of the grid its folds are proved, so that only a few edges have to be searched.
    Curves that cross no edge are searched for at random values; it is not proved that none is
    missed.
    """
    search = _Search(found, seed)
    edges = []
    for node, other in found.edges:
        axis = next(axis for axis, k in enumerate(node) if other[axis] != k)
        edges.append(((axis, node), int(found.modes[other] - found.modes[node])))
        search.explain(edges[-1][0], other, edges[-1][1])
        yield search.result
    search.look_for_hidden_curves()
    search.result.unexplained = [edge for edge, wanted in edges if search.change(edge) != wanted]
    yield search.result


class _Search:
    """The crossings on the edges of a grid.

    Parameters
    ----------
    found
        The numbers of modes at its nodes.
    seed
        The seed of random numbers.
    """

    def __init__(self, found: Scan, seed: int) -> None:
        self.result = Boundary()
        self._rows = ScanRows(found)
        self._seed = seed
        self._known: dict[Edge, list[Crossing]] = {}
        self._curves = _Curves(self._rows) if len(found.axes) == 2 else None

    def change(self, edge: Edge) -> int:
        """Return the change of the number of modes along an edge, by its crossings."""
        return sum(crossing.change for crossing in self._known.get(edge, ()))

    def explain(self, edge: Edge, other: tuple[int, ...], wanted: int) -> None:
        """Search for the folds on an edge along which the number of modes changes by ``wanted``."""
        first, last = (edge[1], other) if wanted < 0 else (other, edge[1])
        for start, goal in ((first, last), (last, first)):
            if self.change(edge) != wanted:
                self._follow(edge, start, goal, wanted)

    def look_for_hidden_curves(self) -> None:
        """Follow curves that cross no edge, too."""
        if self._curves is not None:
            for curve in self._curves.hidden(self.result.curves, self._seed):
                self._enter(curve, new=True)

    def _follow(
        self, edge: Edge, start: tuple[int, ...], goal: tuple[int, ...], wanted: int
    ) -> None:
        """Add the folds in which modes end from one node to another, or the curves through them."""
        ends = np.stack([self._rows.read(start), self._rows.read(goal)])
        for event in self._rows.track(start, goal, self._seed).events:
            # Two modes that meet end in the same fold.
            told = event.partner is not None and event.partner < event.mode
            if event.kind != "fold" or told:
                continue
            at = ends[0] + (event.low - 1) * (ends[1] - ends[0])
            values = tuple(at.tolist())
            curve = self._curves.through(event, values) if self._curves else None
            if curve is None:
                change = -2 if start == edge[1] else 2
                self._add(edge, Crossing(values, change, event.R, event.T))
                continue
            self._enter(curve, new=False)
            if self.change(edge) == wanted:
                break

    def _add(self, edge: Edge, crossing: Crossing) -> bool:
        """Add a crossing, unless it is known: a curve may be found again from another edge."""
        known = self._known.setdefault(edge, [])
        if any(_same(crossing, other) for other in known):
            return False
        known.append(crossing)
        self.result.crossings.append(crossing)
        return True

    def _enter(self, curve: Curve, *, new: bool) -> None:
        """Add the crossings of a curve, and the curve if it is new or has new ones."""
        assert self._curves is not None
        added = [self._add(edge, crossing) for edge, crossing in self._curves.crossings(curve)]
        if new or any(added):
            self.result.curves.append(curve)


def _same(first: Crossing, second: Crossing) -> bool:
    """Whether two crossings are the same: the values agree, and so do the poses."""
    if not np.allclose(first.values, second.values, rtol=1e-9, atol=1e-12):
        return False
    size = np.abs(first.T).max() + np.abs(second.T).max()
    turned, moved = np.abs(first.R - second.R).max(), np.abs(first.T - second.T).max()
    return bool(turned < _APART and moved <= _APART * size)


class _Curves:
    """Curves of the discriminant and the grid of a scan over two values."""

    def __init__(self, rows: ScanRows) -> None:
        self.rows = rows
        self.platform = rows.platform()
        self.equations: Discriminant
        if isinstance(self.platform, MovingGeometry):
            self.equations = DrivenDiscriminant(rows, self.platform)
        else:
            first, second = rows.varied
            values, ends = rows.row(rows.low), (rows.low, rows.high)
            self.equations = Discriminant(self.platform, values, (first, second), *ends)
        #: The nodes as parts of the ranges.
        self.grids = [
            (np.array(axis.values) - a) / (b - a)
            for axis, a, b in zip(rows.found.axes, rows.low, rows.high, strict=True)
        ]

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
            The seed of the random values.
        """
        parts = np.random.default_rng(seed).uniform(size=(_SAMPLES, 2))
        read = self.equations.plane(np.pad(parts, ((0, 0), (16, 0))))
        for there, solved in zip(read, self.rows.solved(read, seed), strict=True):
            for point in self._nearly_singular(*solved):
                x = self.equations.start(point, there)
                if x is None or not ((x[16:] >= 0) & (x[16:] <= 1)).all():
                    continue
                if not any(curve.contains(x) for curve in known):
                    yield self.equations.follow(x)

    def _nearly_singular(
        self, arrangement: Arrangement, R: Field, T: Field, real: NDArray[np.bool_]
    ) -> Iterator[Array]:
        """Yield Study points of one real and one complex solution at some place."""
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
        ends = self.rows.read(node), self.rows.read(other)
        rows = self.rows.row(ends[0]), self.rows.row(ends[1])
        part = (place - grid[k]) / (grid[k + 1] - grid[k])
        fold = prove_fold(self.platform.system, rows, part, at[:8], at[8:16])
        if fold is None or not 0 <= fold.low <= fold.high <= 1:
            return None
        values = tuple((ends[0] + fold.low * (ends[1] - ends[0])).tolist())
        return (axis, node), Crossing(values, 2 * fold.bends, *self.platform.poses(fold.point))
