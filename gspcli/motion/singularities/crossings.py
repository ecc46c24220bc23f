"""Changes of the number of modes between the nodes of a scan: folds and curves of folds."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.branches.folds import prove_fold
from gspcli.certification.branches.taylor import MovingSystem
from gspcli.defaults import SEED
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import Field
from gspcli.geometry.residuals import condition_numbers
from gspcli.motion.following.branch_runs import NEARLY_SINGULAR
from gspcli.motion.following.chord_equations import equations_at
from gspcli.motion.following.moving_geometry import MovingGeometry
from gspcli.motion.following.tracks import Event
from gspcli.motion.singularities.discriminant import Curve, Discriminant, DrivenDiscriminant
from gspcli.motion.singularities.scan_rows import ScanRows
from gspcli.motion.singularities.value_scans import Scan, scan
from gspcli.records import dataclass

Array = NDArray[np.float64]
#: A point nearer than this to the border of the grid, in parts of the ranges, is on it.
_BORDER = 1e-9
#: Poses of folds that differ by more, as rotations or relatively, are different ones.
_APART = 1e-6
#: The number of random values at which curves are searched for that cross no edge.
_SAMPLES = 32
#: Of the parts of an edge: modes that stop as near to each other stop at one place. Numbers of
#: modes are proved so far before and after it.
_AT_ONCE, _ROOMS = 1e-4, (1e-6, 1e-5, 1e-4, 1e-3)
#: Poses of modes that meet agree to this when they stop, as rotations and relatively.
_TOGETHER = 1e-3
#: Derivatives along an edge are differences over this part of it; a fold may be this many edges
#: ahead of complex solutions, by its estimate.
_NEXT, _AHEAD = 2.0**-20, 1.5
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


@dataclass(frozen=True, eq=False)
class Meeting:
    """A place between two nodes where modes meet that is no simple fold, as symmetries cause.

    The modes are followed with proof to both sides of the place. That they meet there, and in which
    pose, is seen and not proved.

    Attributes
    ----------
    low, high
        What varies, before and after the place.
    before, after
        The numbers of modes there, each proved: all poses are found.
    poses
        Of each pose in which modes meet: how many there are before and after, R and T.
    """

    low: tuple[float, ...]
    high: tuple[float, ...]
    before: int
    after: int
    poses: tuple[tuple[int, int, Array, Array], ...]


def in_order(crossings: Iterable[Crossing]) -> list[Crossing]:
    """Return folds by their values, and mirror images by their poses; rounding errors aside."""
    return sorted(
        crossings, key=lambda one: [float(f"{x:.9g}") for x in (*one.values, *one.T.tolist())]
    )


@dataclasses.dataclass(eq=False)
class Boundary:
    """The part of the discriminant that was found.

    Attributes
    ----------
    crossings
        Proved folds on the edges of the grid.
    curves
        Over two values: the discriminant through them.
    meetings
        Places on edges where modes meet that are no simple folds.
    unexplained
        Edges on which the changes at the crossings and meetings do not add up to the difference of
        the numbers of modes at the ends.
    """

    crossings: list[Crossing] = field(default_factory=list)
    curves: list[Curve] = field(default_factory=list)
    meetings: list[Meeting] = field(default_factory=list)
    unexplained: list[Edge] = field(default_factory=list)


def boundary(found: Scan, *, seed: int = SEED) -> Boundary:
    """Return the last result of `boundaries`."""
    *_, last = boundaries(found, seed=seed)
    return last


def boundaries(found: Scan, *, seed: int = SEED) -> Iterator[Boundary]:
    """Yield the boundary that is known so far, after each edge of the grid.

    Over one value, folds are sought from the complex solutions at each node: two of them become
    real in a fold, also where another fold before the next node takes them away again. It is not
    proved that no such pair of folds is missed. If the folds do not explain a change, the modes are
    followed with proof from the node that has more of them, and then from the other node, too: some
    may end and others begin between.
    Over two values the discriminant is followed as a curve from each fold. Where the curve crosses
    other edges of the grid its folds are proved, so that only a few edges have to be searched.
    Curves that cross no edge are searched for at random values; it is not proved that none is
    missed.
    """
    search = _Search(found, seed)
    search.look_for_pairs()
    edges = []
    for node, other in found.edges:
        axis = next(axis for axis, k in enumerate(node) if other[axis] != k)
        edges.append(((axis, node), int(found.modes[other] - found.modes[node])))
        search.explain(edges[-1][0], other, edges[-1][1])
        yield search.result
    for k in range(len(found.modes) - 1 if found.modes.ndim == 1 else 0):
        # A fold was found, and not the one that cancels it.
        edge = (0, (k,))
        if found.modes[k] == found.modes[k + 1] >= 0 and search.change(edge):
            edges.append((edge, 0))
            search.explain(edge, (k + 1,), 0)
    search.look_for_hidden_curves()
    search.result.unexplained = [edge for edge, wanted in edges if search.change(edge) != wanted]
    yield search.result


class _Stopped(NamedTuple):
    """A mode that stops between two nodes: the part of the edge, from which node, and its pose."""

    part: float
    forward: bool
    R: Array
    T: Array


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
        #: The changes at meetings.
        self._met: dict[Edge, int] = {}
        self._curves = _Curves(self._rows) if len(found.axes) == 2 else None

    def change(self, edge: Edge) -> int:
        """Return the change of the number of modes along an edge that is explained."""
        folds = sum(crossing.change for crossing in self._known.get(edge, ()))
        return folds + self._met.get(edge, 0)

    def explain(self, edge: Edge, other: tuple[int, ...], wanted: int) -> None:
        """Search for the folds on an edge along which the number of modes changes by ``wanted``."""
        first, last = (edge[1], other) if wanted < 0 else (other, edge[1])
        ends = []
        for start, goal in ((first, last), (last, first)):
            if self.change(edge) != wanted:
                ends += self._follow(edge, start, goal, wanted)
        if self.change(edge) != wanted:
            self._meet(edge, other, ends)

    def look_for_pairs(self) -> None:
        """Search for folds over one value from the complex solutions at each node."""
        if self._curves is not None:
            return
        platform, nodes = self._rows.platform(), range(len(self._rows.found.modes))
        read = np.array([self._rows.read((k,)) for k in nodes])
        rows = [self._rows.row(one) for one in read]
        solved = self._rows.solved(read, self._seed)
        for k, (_, R, T, real) in zip(nodes, solved, strict=True):
            rest = ~real & np.isfinite(R).all(axis=(1, 2)) & np.isfinite(T).all(axis=1)
            for step in (-1, 1):
                if rest.any() and 0 <= k + step < len(rows):
                    points = platform.points(R[rest], T[rest])
                    first = min(k, k + step)
                    starts = _becoming_real(platform.system, rows[k], rows[k + step], points)
                    for ahead, point, direction in starts:
                        part = ahead if step > 0 else 1 - ahead
                        ends = (rows[first], rows[first + 1])
                        fold = prove_fold(platform.system, ends, part, point, direction)
                        if fold is not None and 0 <= fold.low <= fold.high <= 1:
                            low, high = read[first], read[first + 1]
                            values = tuple((low + fold.low * (high - low)).tolist())
                            pose = platform.poses(fold.point)
                            self._add((0, (first,)), Crossing(values, 2 * fold.bends, *pose))

    def look_for_hidden_curves(self) -> None:
        """Follow curves that cross no edge, too."""
        if self._curves is not None:
            for curve in self._curves.hidden(self.result.curves, self._seed):
                self._enter(curve, new=True)

    def _follow(
        self, edge: Edge, start: tuple[int, ...], goal: tuple[int, ...], wanted: int
    ) -> list[_Stopped]:
        """Add the folds in which modes end from one node to another, or the curves through them.

        Returns the modes that could not be followed through a nearly singular pose.
        """
        ends = np.stack([self._rows.read(start), self._rows.read(goal)])
        forward = start == edge[1]
        stopped = []
        for event in self._rows.track(start, goal, self._seed).events:
            part = event.low - 1
            if event.kind == "undecided" and event.reason == NEARLY_SINGULAR:
                stopped.append(_Stopped(part if forward else 1 - part, forward, event.R, event.T))
            # Two modes that meet end in the same fold.
            told = event.partner is not None and event.partner < event.mode
            if event.kind != "fold" or told:
                continue
            values = tuple((ends[0] + part * (ends[1] - ends[0])).tolist())
            curve = self._curves.through(event, values) if self._curves else None
            if curve is None:
                self._add(edge, Crossing(values, -2 if forward else 2, event.R, event.T))
                continue
            self._enter(curve, new=False)
            if self.change(edge) == wanted:
                break
        return stopped

    def _meet(self, edge: Edge, other: tuple[int, ...], stopped: list[_Stopped]) -> None:
        """Add the places between two nodes where modes stop that end in no simple fold."""
        axis, node = edge
        ends = self._rows.read(node), self._rows.read(other)
        stopped = sorted(stopped, key=lambda one: one.part)
        while stopped:
            least = stopped[0].part
            group = [one for one in stopped if one.part - least < _AT_ONCE]
            stopped = stopped[len(group) :]
            for room in _ROOMS:
                parts = max(least - room, 0.0), min(group[-1].part + room, 1.0)
                low, high = (tuple((ends[0] + p * (ends[1] - ends[0])).tolist()) for p in parts)
                axes = [
                    dataclasses.replace(one, values=(a, b) if k == axis else (a,))
                    for k, (one, a, b) in enumerate(
                        zip(self._rows.found.axes, low, high, strict=True)
                    )
                ]
                counts = scan(self._rows.found.instance, axes, seed=self._seed).modes.ravel()
                if counts.min() >= 0:
                    break
            else:
                continue
            before, after = map(int, counts)
            meeting = Meeting(low, high, before, after, _places(group))
            self.result.meetings.append(meeting)
            inside = [
                one
                for one in self._known.get(edge, ())
                if low[axis] <= one.values[axis] <= high[axis]
            ]
            self._met[edge] = (
                self._met.get(edge, 0) + after - before - sum(one.change for one in inside)
            )

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
    return np.allclose(first.values, second.values, rtol=1e-9, atol=1e-12) and _near(
        first, second, _APART
    )


def _near(first: Crossing | _Stopped, second: Crossing | _Stopped, least: float) -> bool:
    """Whether two poses agree, as rotations and relatively."""
    size = np.abs(first.T).max() + np.abs(second.T).max()
    turned, moved = np.abs(first.R - second.R).max(), np.abs(first.T - second.T).max()
    return bool(turned < least and moved <= least * size)


def _places(group: Sequence[_Stopped]) -> tuple[tuple[int, int, Array, Array], ...]:
    """Return the poses of modes that stop at once: how many before and after, R and T."""
    left, found = list(group), []
    while left:
        same = [one for one in left if _near(left[0], one, _TOGETHER)]
        # The mode that comes nearest to the singular pose.
        best = min(same, key=lambda one: -one.part if one.forward else one.part)
        before = sum(one.forward for one in same)
        found.append((before, len(same) - before, best.R, best.T))
        left = [one for one in left if not any(one is other for other in same)]
    return tuple(found)


def _becoming_real(
    system: MovingSystem, row: Array, goal: Array, points: Any
) -> Iterator[tuple[float, Array, Array]]:
    """Yield where complex solutions may become real from a row to another one.

    Near a fold at s = f the imaginary part is about ``w = c sqrt(f - s)``. So ``w.w`` is linear in
    s, and vanishes where its tangent does.

    Parameters
    ----------
    system
        What moves.
    row, goal
        The row of the solutions, s = 0, and the next one, s = 1.
    points
        Complex Study points at the first row, shape (n, 8).

    Yields
    ------
    tuple
        About f, a real Study point there and the direction of the branches.
    """
    here, ahead = (system.on_part((row, goal), at, at) for at in (0.0, _NEXT))
    # In the phase and on the patch in which the real part is the largest.
    points = points * np.exp(-0.5j * np.angle(np.sum(points**2, axis=1)))[:, None]
    patch = points.real / np.sum(points.real**2, axis=1)[:, None]
    points = points / np.sum(patch * points, axis=1)[:, None]
    _, jacobian = equations_at(
        system.shapes, here.quadrics[None, :, :, 0], here.factors[None, :, 0], points
    )
    change = [
        equations_at(system.shapes, one.quadrics[None, :, :, 0], one.factors[None, :, 0], points)[0]
        for one in (here, ahead)
    ]
    moving = (change[1] - change[0]) / _NEXT
    matrix = np.concatenate((jacobian, patch[:, None]), axis=1)
    right = np.concatenate((-moving, np.zeros((len(points), 1))), axis=1)
    for z, rows, b in zip(points, matrix, right, strict=True):
        try:
            slope = np.linalg.solve(rows, b)
        except np.linalg.LinAlgError:
            continue
        size, falls = z.imag @ z.imag, -2 * (z.imag @ slope.imag)
        if size > 0 and 0 < size < _AHEAD * falls:
            at = float(size / falls)
            yield at, z.real + at * slope.real, z.imag


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
