"""Changes of the number of modes between the nodes of a scan: folds and curves of folds."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.branches.fold_system import rounded_along
from gspcli.certification.branches.folds import prove_fold
from gspcli.certification.branches.taylor import MovingSystem, equations_at
from gspcli.defaults import SEED
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.enclosures import Enclosure, Matrix
from gspcli.geometry.quaternions import Field
from gspcli.geometry.residuals import condition_numbers
from gspcli.motion.following.branch_follower import MovingPlatform
from gspcli.motion.following.branch_runs import NEARLY_SINGULAR
from gspcli.motion.following.moving_geometry import MovingGeometry
from gspcli.motion.following.tracks import Event
from gspcli.motion.singularities.neighbourhoods import STUDY, equations
from gspcli.motion.singularities.scans import Scan, ScanRows, scan_grid
from gspcli.records import dataclass
from gspcli.ties import definite_sign

#: Steps along a curve, in units in which points and directions have norm one and the ranges of
#: both values are one: the first, the longest and the shortest.
_FIRST, _LONGEST, _SHORTEST = 5e-3, 2.5e-2, 1e-7
_MOST_POINTS = 20_000
#: Newton's method: the most steps, and the size of a step after which it has converged.
_STEPS, _CONVERGED = 5, 1e-9
#: Points nearer than this to the border of the ranges are on it.
#: The cosine of the largest turn of a curve in one step.
_STRAIGHT = 0.98
#: At a cusp the part of the unit tangent in the values is below this.
_STILL = 1e-4


@dataclass(frozen=True, eq=False)
class Curve:
    """A part of the discriminant.

    Attributes
    ----------
    values
        The two values, in the units of the instance, shape (n, 2).
    unknowns
        z, u and the values as parts of their ranges, shape (n, 18).
    cusps
        The cusps of the curve, shape (m, 2).
    closed
        Whether the last point is the first.
    """

    values: Array
    unknowns: Array
    cusps: Array
    closed: bool

    def contains(self, x: Array) -> bool:
        """Whether a singular pose, shape (18,), is nearer to a point than its neighbours are."""
        square = np.sum((self.unknowns[:, 16:] - x[16:]) ** 2, axis=1)
        for part in (slice(0, 8), slice(8, 16)):
            # z and u are known up to sign, and of norm one.
            square += 2 - 2 * np.abs(self.unknowns[:, part] @ x[part])
        return bool(square.min() < _LONGEST**2)


class _Numbers:
    """Numbers with their derivatives, with the operations of `Jet`."""

    def __init__(self, value: Array, gradient: Array, bend: Array) -> None:
        self.value, self.gradient, self.bend = value, gradient, bend

    @classmethod
    def quadric(cls, matrix: Matrix, x: Array) -> _Numbers:
        gradient = matrix.mid @ x
        return cls(gradient @ x / 2, gradient, matrix.mid)

    def __sub__(self, other: _Numbers) -> _Numbers:
        gradient = self.gradient - other.gradient
        return _Numbers(self.value - other.value, gradient, self.bend - other.bend)

    def __mul__(self, other: _Numbers) -> _Numbers:
        f, g = np.asarray(self.value)[..., None], np.asarray(other.value)[..., None]
        outer = self.gradient[..., :, None] * other.gradient[..., None, :]
        bend = f[..., None] * other.bend + g[..., None] * self.bend
        gradient = f * other.gradient + g * self.gradient
        bend = bend + outer + np.swapaxes(outer, -1, -2)
        return _Numbers(self.value * other.value, gradient, bend)

    def times(self, number: Enclosure) -> _Numbers:
        c = number.mid[0]
        return _Numbers(c[:, 0] * self.value, c * self.gradient, c[..., None] * self.bend)


class Discriminant:
    """The equations of singular poses over two values.

    With z a Study point, u a direction and v two of the values, a singular pose is a zero of

        F(z, v) = 0,  p.z = 1,  F'(z, v) u = 0,  p.u = 0,  c.u = 1,

    seventeen equations for eighteen unknowns (G. Moore and A. Spence, SIAM J. Numer. Anal. 17,
    1980). The solutions are smooth curves also where their projection on the plane of values has a
    cusp: there only z and u change. They are followed by Newton's method in small steps, without
    proof.

    Parameters
    ----------
    platform
        The equations.
    values
        The six values, in the units of the instance; two of them are replaced.
    varied
        Which two constraints vary, from 0.
    low, high
        The ends of their ranges, shape (2,).
    """

    def __init__(
        self,
        platform: MovingPlatform,
        values: Array,
        varied: tuple[int, int],
        low: Array,
        high: Array,
    ) -> None:
        self.platform = platform
        self.varied = list(varied)
        self._base = np.asarray(values, float)
        self._low, self._span = np.asarray(low, float), np.asarray(high - low, float)
        units = platform.internal(np.ones(6))[self.varied]
        #: The widths of the ranges of the two values, in internal units.
        self._widths = units * self._span

    def plane(self, x: Array) -> Array:
        """Return the two values of some unknowns, (..., 18), in the units of the instance."""
        values: Array = self._low + x[..., 16:] * self._span
        return values

    def start(self, point: Array, values: Array) -> Array | None:
        """Return the unknowns of the singular pose near a Study point, or None.

        Parameters
        ----------
        point
            Shape (8,).
        values
            About the two values, shape (2,).
        """
        w = (values - self._low) / self._span
        rows = self._rows(point, w)
        direction = definite_sign(np.linalg.svd(np.vstack((rows, point)))[2][-1])
        x = np.concatenate((point / np.linalg.norm(point), direction, w))
        return self._corrected(x, x, None)

    def _rows(self, point: Array, w: Array) -> Array:
        """Return F' at a Study point, shape (7, 8)."""
        return self.platform.jacobian(point, self._internal(w))

    def _internal(self, w: Array) -> Array:
        values = self._base.copy()
        values[self.varied] = self._low + w * self._span
        return self.platform.internal(values)

    def _equations(self, x: Array, patch: Array, gauge: Array) -> tuple[Array, Array]:
        """Return the seventeen equations and their derivatives, shape (17, 18)."""
        z, u = x[:8], x[8:16]
        residuals, rows, bent, moving = self._terms(x)
        values = np.concatenate((residuals, [patch @ z - 1], rows @ u, [patch @ u, gauge @ u - 1]))
        matrix = np.zeros((17, 18))
        matrix[:7, :8], matrix[:7, 16:] = rows, moving[0]
        matrix[7, :8] = patch
        matrix[8:15, :8], matrix[8:15, 8:16], matrix[8:15, 16:] = bent, rows, moving[1]
        matrix[15, 8:16], matrix[16, 8:16] = patch, gauge
        return values, matrix

    def _terms(self, x: Array) -> tuple[Array, Array, Array, tuple[Array, Array]]:
        """Return F (7,), F' (7, 8), F''u (7, 8), and the derivatives of F and F'u by w (7, 2)."""
        z, u, values = x[:8], x[8:16], self._internal(x[16:])
        F, rows, bent = np.zeros(7), np.zeros((7, 8)), np.zeros((7, 8))
        first, second = np.zeros((7, 2)), np.zeros((7, 2))
        slopes = self.platform.slopes(values)
        study = _Numbers.quadric(STUDY, z)
        F[0], rows[0], bent[0] = study.value, study.gradient, study.bend @ u
        c = Enclosure(self.platform.coefficients(values)[None, :, None])
        for at, found, factor in equations(self.platform, z, c, _Numbers):
            F[at + 1], rows[at + 1], bent[at + 1] = found.value, found.gradient, found.bend @ u
            for k, row in enumerate(self.varied):
                change = -slopes[row] * self._widths[k]
                first[at + 1, k] = np.where(at == row, change * factor.value, 0.0)
                second[at + 1, k] = np.where(at == row, change * (factor.gradient @ u), 0.0)
        return F, rows, bent, (first, second)

    def _corrected(self, x: Array, at: Array, row: Array | None, goal: float = 0.0) -> Array | None:
        """Return the solution near some unknowns by Newton's method, or None.

        Parameters
        ----------
        x
            The unknowns.
        at
            The unknowns that give the patch and the gauge.
        row
            One more linear equation ``row . x = goal``, shape (18,); the shortest steps if None.
        goal
            Its right side.
        """
        patch, gauge = _units(at)
        for _ in range(_STEPS):
            values, matrix = self._equations(x, patch, gauge)
            try:
                if row is None:
                    step = np.linalg.lstsq(matrix, values, rcond=None)[0]
                else:
                    bordered = np.vstack((matrix, row))
                    step = np.linalg.solve(bordered, np.append(values, row @ x - goal))
            except np.linalg.LinAlgError:
                return None
            size = float(np.linalg.norm(step))
            if not size < 0.5:
                return None
            x = x - step
            if size < _CONVERGED:
                return x
        return None

    def _tangent(self, x: Array, like: Array | None) -> Array:
        """Return the unit tangent of the curve, in the direction of another one if there is one."""
        _, matrix = self._equations(x, *_units(x))
        tangent: Array = np.linalg.svd(matrix)[2][-1]
        if like is None:
            return definite_sign(tangent)
        return tangent if tangent @ like > 0 else -tangent

    def follow(self, start: Array) -> Curve:
        """Return the curve through a singular pose, up to the ends of the ranges."""
        start = _scaled(start)
        tangent = self._tangent(start, None)
        ahead, cusps, closed = self._one_way(start, tangent)
        if not closed:
            behind, more, _ = self._one_way(start, -tangent)
            ahead, cusps = [*behind[:0:-1], *ahead], [*more, *cusps]
        x = np.stack(ahead)
        return Curve(
            self.plane(x),
            x,
            self.plane(np.stack(cusps)) if cusps else np.zeros((0, 2)),
            closed,
        )

    def _one_way(self, start: Array, tangent: Array) -> tuple[list[Array], list[Array], bool]:
        """Follow the curve in one direction: its points, its cusps, and whether it closes."""
        points: list[Array] = [start]
        cusps: list[Array] = []
        x, size = start, _FIRST
        while len(points) < _MOST_POINTS and size > _SHORTEST:
            step = self._step(x, tangent, size)
            if step is None:
                size /= 2
                continue
            new, turned = step
            if turned[16:] @ tangent[16:] < 0:
                cusp = self._cusp(x, tangent, size)
                cusps += [] if cusp is None else [cusp]
            if ((new[16:] < 0) | (new[16:] > 1)).any():
                end = self._cut(x, new)
                # A curve that begins on the border ends there, up to rounding errors.
                if end is not None and np.abs(end - x).max() > _BORDER:
                    points.append(end)
                return points, cusps, False
            points.append(new)
            if len(points) > 4 and _passes(x, new, start):
                return [*points, start], cusps, True
            x, tangent = new, turned
            size = min(size * 1.4, _LONGEST)
        return points, cusps, False

    def _step(self, x: Array, tangent: Array, size: float) -> tuple[Array, Array] | None:
        """Return the point of the curve a step ahead, scaled, and its tangent; or None."""
        ahead = x + size * tangent
        found = self._corrected(ahead, x, tangent, float(tangent @ ahead))
        if found is None or np.linalg.norm(found - ahead) > size / 4:
            return None
        new = _scaled(found)
        turned = self._tangent(new, tangent)
        return (new, turned) if turned @ tangent > _STRAIGHT else None

    def _cusp(self, x: Array, tangent: Array, size: float) -> Array | None:
        """Return the point within a step at which the values stand still, if there is one."""
        low, high, found = 0.0, size, None
        for _ in range(40):
            middle = (low + high) / 2
            step = self._step(x, tangent, middle)
            if step is None:
                return None
            found, turned = step
            low, high = (middle, high) if turned[16:] @ tangent[16:] > 0 else (low, middle)
        still = np.linalg.norm(self._tangent(found, None)[16:]) < _STILL if found is not None else 0
        return found if still else None

    def _cut(self, x: Array, new: Array) -> Array | None:
        """Return the point between two at which the curve leaves the ranges."""
        for k in (16, 17):
            for bound in (0.0, 1.0):
                if (x[k] - bound) * (new[k] - bound) < 0:
                    end = self.at_line(x, new, k - 16, bound)
                    if end is not None and ((end[16:] > -_BORDER) & (end[16:] < 1 + _BORDER)).all():
                        return end
        return None

    def at_line(self, x: Array, y: Array, axis: int, bound: float) -> Array | None:
        """Return the point of the curve between two others where one value is given.

        Parameters
        ----------
        x, y
            Unknowns of neighbouring points.
        axis
            Which of the two values.
        bound
            The value, as a part of its range.
        """
        part = (bound - x[16 + axis]) / (y[16 + axis] - x[16 + axis])
        row = np.zeros(18)
        row[16 + axis] = 1.0
        near = self._corrected((1 - part) * x + part * y, x, row, bound)
        return None if near is None or np.linalg.norm(near - x) > 4 * _LONGEST else near


def _units(x: Array) -> tuple[Array, Array]:
    """Return the patch and the gauge at some unknowns: z and u, scaled."""
    z, u = x[:8], x[8:16]
    return z / (z @ z), u / (u @ u)


def _scaled(x: Array) -> Array:
    z, u = x[:8] / np.linalg.norm(x[:8]), x[8:16]
    u = u - (u @ z) * z
    return np.concatenate((z, u / np.linalg.norm(u), x[16:]))


def _passes(x: Array, y: Array, point: Array) -> bool:
    """Whether the part from x to y passes a point, whose z and u are known up to sign."""
    for signs in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        other = point * np.concatenate((np.full(8, signs[0]), np.full(8, signs[1]), (1, 1)))
        d = y - x
        part = np.clip((other - x) @ d / (d @ d), 0, 1)
        if np.linalg.norm(x + part * d - other) < 0.1 * np.linalg.norm(d):
            return True
    return False


class DrivenDiscriminant(Discriminant):
    """The equations of singular poses over two numbers, of which a crank or slide has at least one.

    The equations are those of `Discriminant`; all their coefficients move. They and their
    derivatives come from the equations of folds (`gspcli.certification.branches.fold_system`), once
    along each of the two axes.

    Parameters
    ----------
    rows
        The rows of the scan.
    platform
        The equations.
    """

    def __init__(self, rows: ScanRows, platform: MovingGeometry) -> None:
        self._of = rows
        self._system = platform.system
        self._low, self._span = rows.low, rows.high - rows.low

    def _rows(self, point: Array, w: Array) -> Array:
        return self._along(np.concatenate((point, point, w)), 0)[0][1][:7, :8]

    def _terms(self, x: Array) -> tuple[Array, Array, Array, tuple[Array, Array]]:
        (values, rows), (_, bent) = self._along(x, 0)
        (_, other_rows), (_, other_bent) = self._along(x, 1)
        first = np.column_stack((rows[:7, 8], other_rows[:7, 8]))
        second = np.column_stack((bent[:7, 8], other_bent[:7, 8]))
        return values[:7], rows[:7, :8], bent[:7, :8], (first, second)

    def _along(self, x: Array, axis: int) -> list[tuple[Array, Array]]:
        """Return F and F'u, each with its derivatives by z and by one w: shapes (8,), (8, 9)."""
        read = self.plane(x)
        row = self._of.row(read)
        ahead = row.copy()
        ahead[self._of.varied[axis]] += self._span[axis] * self._of.scales[axis]
        return rounded_along(self._system, (row, ahead), x[:8], x[8:16])


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
                counts = scan_grid(self._rows.found.instance, axes, seed=self._seed).modes.ravel()
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
    here, ahead = (system.at((row, goal), part) for part in (0.0, _NEXT))
    # In the phase and on the patch in which the real part is the largest.
    points = points * np.exp(-0.5j * np.angle(np.sum(points**2, axis=1)))[:, None]
    patch = points.real / np.sum(points.real**2, axis=1)[:, None]
    points = points / np.sum(patch * points, axis=1)[:, None]
    values, jacobian = equations_at(system.shapes, *here, points)
    moving = (equations_at(system.shapes, *ahead, points)[0] - values) / _NEXT
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
