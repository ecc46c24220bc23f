"""Scans: modes, or determinants, at the nodes of a grid of values, readings of drives, or poses."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from functools import partial
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.certification.branches.curves import prove_fold
from gspcli.certification.branches.taylor import MovingSystem, equations_at
from gspcli.defaults import SEED
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.checking import wrong_value
from gspcli.geometry.coordinates import choose, drive_corrections, moved
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.machine import Machine, value_machine
from gspcli.geometry.measurement import condition_numbers, jacobian, printed_conditions
from gspcli.geometry.numbers import Number
from gspcli.geometry.quaternions import Field, quaternion_from_rotation
from gspcli.geometry.readings import factors, offsets, without_corrections
from gspcli.motion.bisection import bisected
from gspcli.motion.files.pose_files import PoseFormat, pose_columns, poses_of
from gspcli.motion.files.value_files import nominal_values
from gspcli.motion.following.branch_follower import (
    FollowOptions,
    MovingGeometry,
    MovingPlatform,
    at_values,
)
from gspcli.motion.following.tracks import NEARLY_SINGULAR, Event, Run, Track, track
from gspcli.motion.poses.inverse_kinematics import drive_values
from gspcli.motion.singularities.clearances import clearances
from gspcli.motion.singularities.pose_clearances import pose_clearances
from gspcli.records import Tabular, dataclass
from gspcli.solver import solve, solve_batch
from gspcli.ties import definite_sign
from gspcli.wording import counted, listed, shown
from gspcli.workers import HERE, Workers

Array = NDArray[np.float64]
#: An edge of a grid: its axis and its first node.
Edge = tuple[int, tuple[int, ...]]
#: Stands instead of a number of modes where not all poses were found.
UNKNOWN = -1
#: Nodes of one piece of work; over drives each node is another geometry.
_PIECE, _DRIVEN_PIECE = 1000, 25
#: The coordinates of a pose that may vary.
_VARIABLE = ("x", "y", "z", "rx", "ry", "rz")
#: Halvings of an edge of the grid: to the last digit of a double.
_HALVINGS = 52


@dataclass(frozen=True)
class Axis:
    """What varies."""

    #: The number of a constraint, from 1, the name of a crank or slide, or ``x``, ``y``, ``z``,
    #: ``rx``, ``ry``, ``rz`` of the pose.
    name: str
    #: The nodes, increasing: readings, or coordinates, in the units of the instance.
    values: tuple[float, ...]

    @property
    def constraint(self) -> int | None:
        """The index of the constraint whose value varies, from 0; None if another thing does."""
        return int(self.name) - 1 if self.name.isdecimal() else None


class Varied(ABC):
    """What varies along one or two axes: a function of the nodes of their grid.

    Raises
    ------
    ArgumentError
        If there are not one or two different axes.
    """

    #: The columns of a node, without that of clearances, and what they are at first.
    columns: ClassVar[dict[str, float]]
    #: Nodes of one piece of work.
    piece = _PIECE

    def __init__(self, instance: Instance, axes: Sequence[Axis]) -> None:
        self.instance, self.axes = instance, tuple(axes)
        if len(self.axes) not in (1, 2) or len(set(self.names)) < len(self.axes):
            message = "expected one or two different constraints, drives or coordinates to vary"
            raise ArgumentError(message, "axes")

    @property
    def names(self) -> list[str]:
        """The names of the axes."""
        return [axis.name for axis in self.axes]

    @property
    def key(self) -> tuple[Any, ...]:
        """What distinguishes it from other ones of the same instance."""
        return (self.axes,)

    @property
    def nodes(self) -> Array:
        """The nodes, shape (n1, axes) or (n1, n2, axes)."""
        return np.stack(np.meshgrid(*(axis.values for axis in self.axes), indexing="ij"), axis=-1)

    @abstractmethod
    def at(self, nodes: Array, *, clearance: bool, seed: int) -> dict[str, Array]:
        """Return the columns at nodes, shape (n, axes); with ``clearance`` if asked for."""

    @abstractmethod
    def levels(self, numbers: Mapping[str, Array]) -> Array:
        """Return what differs on both sides of a singularity, NaN where it is not known."""


@dataclass(frozen=True, eq=False)
class Scan:
    """A grid over one or two axes, and what is known at its nodes, n1 or n1 x n2."""

    #: What varies, and the axes.
    varied: Varied
    #: By name, shape (n1,) or (n1, n2). Of values and drives: the number of real poses in
    #: ``modes``, `UNKNOWN` where not all were found or where they are infinitely many, and the
    #: smallest condition number of one in ``condition``, infinite where there is none. Of poses:
    #: ``determinant`` and ``condition``. In ``clearance``, if it was asked for, the smallest proved
    #: clearance of a mode in its values or, where drives vary, in the drives
    #: (`gspcli.motion.singularities.clearances`), infinite where there is none; that of a pose.
    numbers: dict[str, Array]
    #: Which nodes were looked at, the same shape.
    done: NDArray[np.bool_]

    @classmethod
    def of(cls, varied: Varied, *, clearance: bool = False) -> Scan:
        """Return a scan without any results."""
        shape = tuple(len(axis.values) for axis in varied.axes)
        columns = varied.columns | ({"clearance": np.inf} if clearance else {})
        numbers = {name: np.full(shape, first) for name, first in columns.items()}
        return cls(varied, numbers, np.zeros(shape, bool))

    @property
    def instance(self) -> Instance:
        """The platform."""
        return self.varied.instance

    @property
    def axes(self) -> tuple[Axis, ...]:
        """What varies."""
        return self.varied.axes

    @property
    def pieces(self) -> int:
        """The number of pieces of the work."""
        return -(-self.done.size // self.varied.piece)

    def enter(self, piece: Piece) -> None:
        """Enter the results at some nodes."""
        start = piece.number * self.varied.piece
        for name, numbers in piece.numbers.items():
            self.numbers[name].reshape(-1)[start : start + len(numbers)] = numbers
            self.done.reshape(-1)[start : start + len(numbers)] = True

    @property
    def edges(self) -> list[Edge]:
        """The edges between nodes on different sides of a singularity, both known."""
        levels, found = np.where(self.done, self.varied.levels(self.numbers), np.nan), []
        for axis in range(levels.ndim):
            low, high = (np.delete(levels, end, axis) for end in (-1, 0))
            found += [(axis, tuple(node)) for node in np.argwhere(np.abs(low - high) > 0).tolist()]
        return found


def _ahead(edge: Edge) -> tuple[int, ...]:
    """Return the last node of an edge."""
    return tuple(k + (d == edge[0]) for d, k in enumerate(edge[1]))


@dataclass(frozen=True)
class Piece:
    """The columns at the nodes of one piece, lists of numbers."""

    number: int
    numbers: dict[str, list[float]]


def scanned(found: Scan, seed: int, number: int) -> Piece:
    """Return a piece of a scan."""
    varied = found.varied
    nodes = varied.nodes.reshape(-1, len(varied.axes))
    nodes = nodes[number * varied.piece : (number + 1) * varied.piece]
    columns = varied.at(nodes, clearance="clearance" in found.numbers, seed=seed)
    return Piece(number, {name: column.tolist() for name, column in columns.items()})


def scan_grid(
    varied: Varied, *, clearance: bool = False, seed: int = SEED, workers: Workers = HERE
) -> Scan:
    """Return what is at all nodes of a grid; of values and drives all poses are found at each.

    Parameters
    ----------
    varied
        What varies, and the axes.
    clearance
        Whether to bound the clearance of each pose, too.
    seed
        As for `solve_values`.
    workers
        The processes that do the work.
    """
    found = Scan.of(varied, clearance=clearance)
    for piece in workers.as_completed(partial(scanned, found, seed), range(found.pieces)):
        found.enter(piece)
    return found


class Solved(NamedTuple):
    """All poses at n places with the same geometry, at most m each.

    The instance there, its row, or the first one, R (n, m, 3, 3), T (n, m, 3), which are real
    (n, m), and of which places all poses are known (n,).
    """

    instance: Instance
    row: Array
    R: Field
    T: Field
    real: NDArray[np.bool_]
    complete: NDArray[np.bool_]


class VariedNumbers(Varied):
    """Values, or readings of drives, that vary: the modes at each node.

    Rows are six values, then the numbers of the drives that vary. Cranks and slides that do not
    vary stay where their points are stated.

    Raises
    ------
    ArgumentError
        As for `Varied`, and if a value is outside the range of its kind of constraint.
    """

    columns: ClassVar = {"modes": UNKNOWN, "condition": np.inf}

    def __init__(self, instance: Instance, axes: Sequence[Axis]) -> None:
        super().__init__(instance, axes)
        #: The platform with its values as readings; its drives keep their offsets and scales.
        self.plain = without_corrections(instance)
        drives = [axis.name for axis in self.axes if axis.constraint is None]
        self.piece = _DRIVEN_PIECE if drives else _PIECE
        self._chosen = choose(self.plain, drives)
        self._values = nominal_values(self.plain)
        #: The entries of a row that vary, one of each axis: its reading times the scale, plus what
        #: is added.
        self._varied = [
            6 + drives.index(axis.name) if axis.constraint is None else axis.constraint
            for axis in self.axes
        ]
        added, scales = drive_corrections(self.plain, self._chosen)
        added = np.append(offsets(instance, signed=False), added)
        self._scales = np.append(factors(instance), scales)[self._varied]
        self._added = added[self._varied]
        # Distances to planes are signed in rows.
        sides = [row.side is Side.NEGATIVE for row in self.plain.constraints]
        self._signs = np.append(np.where(sides, -1.0, 1.0), np.ones(len(drives)))
        #: The first and the last node of each axis, as it is read.
        self.low, self.high = (
            np.array([axis.values[end] for axis in self.axes]) for end in (0, -1)
        )
        for axis, *ends in zip(self.axes, *map(self._read_as, (self.low, self.high)), strict=True):
            if (k := axis.constraint) is not None:
                kind, unit = instance.constraints[k].kind, instance.units.angle
                for value in ends:
                    if wrong := wrong_value(kind, Number.of(float(value)), unit):
                        message = f"found {value:g} for constraint {k + 1}, {wrong}"
                        raise ArgumentError(message, "vary")

    def read(self, node: Sequence[int]) -> Array:
        """Return what varies at a node, as it is read, shape (axes,)."""
        return np.array([axis.values[k] for axis, k in zip(self.axes, node, strict=True)])

    def _read_as(self, read: Array) -> Array:
        """Return the values and the numbers of drives of readings, shape (..., axes)."""
        return np.asarray(read * self._scales + self._added)

    def row(self, read: Array) -> Array:
        """Return the row of what varies, as it is read."""
        row = np.concatenate((self._values, np.zeros(len(self._chosen))))
        row[self._varied] = self._read_as(read) * self._signs[self._varied]
        return row

    def platform(self) -> MovingPlatform | MovingGeometry:
        """Return the platform that moves with what varies."""
        there = at_values(self.plain, self.row(self.high))
        return MovingGeometry(there, self._chosen) if self._chosen else MovingPlatform(there)

    def _machine(self, row: Array) -> Instance:
        """Return the machine with the values of a row; those that stay are as they are stated."""
        varied = [k for k in self._varied if k < len(self._values)]
        return self.plain.with_values({k: Number.of(row[k] * self._signs[k]) for k in varied})

    def solved(self, read: Array, seed: int) -> Iterator[Solved]:
        """Yield all poses at places, (n, axes): of all at once, or of each if joints move."""
        rows = np.array([self.row(one) for one in read])
        if not self._chosen:
            stated = [constraint.value.value for constraint in self.plain.constraints]
            values = np.tile(stated, (len(read), 1))
            values[:, self._varied] = self._read_as(read)
            batch = solve_batch(self.plain, values, seed=seed)
            yield Solved(self.plain, rows[0], batch.R, batch.T, batch.real, batch.complete)
            return
        for row in rows:
            there = moved(self._machine(row), self._chosen, row[len(self._values) :])
            one = solve(there, seed=seed)
            known = np.array([one.verdict == "complete"])
            yield Solved(there, row, one.R[None], one.T[None], one.real[None], known)

    def each(self, read: Array, seed: int) -> Iterator[Solved]:
        """Yield all poses at each of some places, as `solved`."""
        for one in self.solved(read, seed):
            for k in range(len(one.R)):
                yield Solved(*one[:2], *(part[k : k + 1] for part in one[2:]))

    def at(self, nodes: Array, *, clearance: bool, seed: int) -> dict[str, Array]:
        """Return the number of modes and the least of their quantities at nodes."""
        parts = []
        for one in self.solved(nodes, seed):
            place, column = np.nonzero(one.real)
            R, T = one.R[place, column].real, one.T[place, column].real
            quantities = {"condition": condition_numbers(Arrangement.of(one.instance), R, T)}
            if clearance:
                quantities["clearance"] = self._clearances(one.row, R, T)
            part = {"modes": np.where(one.complete, one.real.sum(axis=1), UNKNOWN)}
            for name, quantity in quantities.items():
                part[name] = np.full(len(one.real), np.inf)
                np.minimum.at(part[name], place, quantity)
            parts.append(part)
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}

    def levels(self, numbers: Mapping[str, Array]) -> Array:
        """Return the numbers of modes, NaN where not all are known."""
        return np.where(numbers["modes"] < 0, np.nan, numbers["modes"])

    def _clearances(self, row: Array, R: Array, T: Array) -> Array:
        """Return proved clearances of poses at a row, in what varies: values or drives, (n,)."""
        if not self._chosen or not len(R):
            return clearances(value_machine(self.plain), R, T)[0]
        drives = Machine.of(self._machine(row))
        q = np.zeros(drives.count)
        at = [drives.names.index(one.name) for one in self._chosen]
        q[at] = row[len(self._values) :] * drives.units[at]
        # Each pose is in working modes of its own: those that have the drives there.
        gains = drives.gains(R, T, np.tile(q, (len(T), 1)))
        return clearances(drives, R, T, working_modes=np.where(gains < 0, -1, 1))[0]

    def track(self, start: Sequence[int], goal: Sequence[int], seed: int) -> Track:
        """Follow all real modes from one node to another, with proof; t is 1 and 2 there."""
        ends = np.stack([self.row(self.read(start)), self.row(self.read(goal))])
        begin = at_values(self.plain, ends[0])
        # From the first node, so that the numbers of modes need not be carried along.
        if not self._chosen:
            return track(begin, ends, seed=seed)
        (there,) = self.solved(self.read(start)[None], seed)
        R, T = there.R[there.real].real, there.T[there.real].real
        platform = MovingGeometry(begin, self._chosen)
        run = Run(self.plain, platform, np.array([1.0, 2.0]), ends, FollowOptions())
        return run.follow(R, T, np.arange(1, len(R) + 1))


class VariedPoses(Varied):
    """Coordinates of a pose that vary: the determinant of the Jacobian matrix at each node.

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

    columns: ClassVar = {"determinant": np.nan, "condition": np.inf}

    def __init__(
        self, instance: Instance, axes: Sequence[Axis], pose: Sequence[float], form: PoseFormat
    ) -> None:
        super().__init__(instance, axes)
        self.pose, self.form = pose, form
        names = pose_columns(len(pose)) or ()
        for name in self.names:
            if name not in names or name not in _VARIABLE:
                message = f"found {name} to vary, expected one of {' '.join(_VARIABLE)}"
                raise ArgumentError(f"{message} that the pose has: {' '.join(names)}", "axes")
        self._columns = [names.index(name) for name in self.names]

    @property
    def key(self) -> tuple[Any, ...]:
        """What distinguishes it from other ones of the same instance."""
        return self.axes, list(self.pose), self.form

    def poses(self, places: Array) -> tuple[Array, Array]:
        """Return the poses (R, T) for numbers of the coordinates that vary, shape (n, axes)."""
        rows = np.tile(np.asarray(self.pose, dtype=float), (len(places), 1))
        rows[:, self._columns] = places
        return poses_of(rows, self.form)

    def _placed(self, R: Array, T: Array) -> Arrangement:
        """Return the platform with its joints where its drives have them, NaN out of reach."""
        drives, q = drive_values(self.instance, R, T, along=False)
        return drives.arrangement(q)

    def determinants(self, places: Array) -> Array:
        """Return determinants of the Jacobian matrix without units; NaN where there is none, (n,).

        Turns are about the centre of the platform's points, lengths in units of the typical
        length of the instance.
        """
        R, T = self.poses(places)
        arrangement = self._placed(R, T)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            rows = jacobian(arrangement, R, T)
            length = Arrangement.of(self.instance).length
            rows[..., :3] /= length
            rows[:, arrangement.angles] *= length
            regular = np.asarray(np.isfinite(rows).all(axis=(1, 2)))
            found = np.linalg.det(np.where(regular[:, None, None], rows, np.eye(6)))
        # The determinant does not depend on the point that the platform turns about.
        return np.asarray(np.where(regular, found, np.nan))

    def at(self, nodes: Array, *, clearance: bool, seed: int) -> dict[str, Array]:
        """Return determinants, condition numbers and proved distances from singular poses."""
        del seed
        if clearance and Machine.of(self.instance).moves:
            message = (
                "of poses of a machine with cranks or slides there is none here: gsp clearance has "
                "that of one pose"
            )
            raise ArgumentError(message, "clearance")
        R, T = self.poses(nodes)
        conditions = condition_numbers(self._placed(R, T), R, T)
        found = {"determinant": self.determinants(nodes), "condition": conditions}
        return found | ({"clearance": pose_clearances(self.instance, R, T)} if clearance else {})

    def levels(self, numbers: Mapping[str, Array]) -> Array:
        """Return the signs of the determinants, NaN where they are zero or not known."""
        signs = np.sign(numbers["determinant"])
        return np.where(signs == 0, np.nan, signs)

    def singular(self, found: Scan) -> dict[Edge, Array]:
        """Return the changes of the sign of the determinant on edges of a grid, each shape (axes,).

        They are found by halving to the last digit. Two changes on one edge are not found.
        """
        edges, nodes = found.edges, self.nodes
        if not edges:
            return {}
        a = np.array([nodes[node] for _, node in edges])
        b = np.array([nodes[_ahead(edge)] for edge in edges])
        before = np.sign(self.determinants(a))

        def same(part: Array) -> NDArray[np.bool_]:
            return np.asarray(np.sign(self.determinants(a + part[:, None] * (b - a))) == before)

        parts = bisected(same, np.zeros(len(a)), np.ones(len(a)), _HALVINGS)
        a, b = (a + part[:, None] * (b - a) for part in parts)
        # Where a machine with cranks or slides does not reach, the sign is not known.
        known = np.isfinite(self.determinants(a)) & np.isfinite(self.determinants(b))
        return {edges[k]: (a[k] + b[k]) / 2 for k in np.flatnonzero(known).tolist()}

    def joined(self, singular: Mapping[Edge, Array], signs: Array) -> Iterator[tuple[Edge, Edge]]:
        """Yield the points in cells of a grid that are joined; signs of determinants, (n1, n2).

        Two points in a cell are joined; four are joined by the sign in the middle.
        """
        nodes = self.nodes
        for i, j in np.ndindex(signs.shape[0] - 1, signs.shape[1] - 1):
            around: list[Edge] = [(0, (i, j)), (1, (i + 1, j)), (0, (i, j + 1)), (1, (i, j))]
            here = [edge for edge in around if edge in singular]
            if len(here) == 2:
                yield here[0], here[1]
            elif len(here) == 4:
                middle = nodes[i : i + 2, j : j + 2].reshape(-1, 2).mean(axis=0)
                sign = np.sign(self.determinants(middle[None]))[0]
                # The curve cuts off the corners whose sign is not that of the middle.
                turn = 1 if sign == signs[i, j] else 3
                yield around[0], around[turn]
                yield around[2], around[4 - turn]


def _singular_poses(found: Scan, varied: VariedPoses) -> Boundary:
    """Return the singular poses on edges of the grid, and the curves through them."""
    singular = varied.singular(found)
    places = np.array(list(singular.values())).reshape(-1, len(found.axes))
    signs = np.sign(found.numbers["determinant"])
    limits = Boundary()
    for edge, at, R, T in zip(singular, places, *varied.poses(places), strict=True):
        change = int(signs[_ahead(edge)] - signs[edge[1]])
        limits.crossings.append(Crossing(tuple(at.tolist()), change, R, T))
    if len(found.axes) == 2:
        links: dict[Edge, list[Edge]] = {edge: [] for edge in singular}
        for first, second in varied.joined(singular, signs):
            links[first].append(second)
            links[second].append(first)
        for chain in _chains(links):
            values = np.stack([singular[edge] for edge in chain])
            limits.curves.append(Curve(values, bool((values[0] == values[-1]).all())))
    return limits


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


#: Steps along a curve, in units in which points and directions have norm one and the ranges of
#: both values are one: the first, the longest and the shortest.
_FIRST, _LONGEST, _SHORTEST = 5e-3, 2.5e-2, 1e-7
_MOST_POINTS = 20_000
#: Newton's method: the most steps, and the size of a step after which it has converged.
_STEPS, _CONVERGED = 5, 1e-9
#: The cosine of the largest turn of a curve in one step.
_STRAIGHT = 0.98
#: Steps of derivatives: a part of the ranges, and one whose square vanishes beside one.
_DIFFERENCE, _TINY = 1e-5, 1e-50
#: At a cusp the part of the unit tangent in the values is below this.
_STILL = 1e-4


@dataclass(frozen=True, eq=False)
class Curve:
    """A part of the discriminant, or of the singular curve over two coordinates of a pose."""

    #: The two that vary, in the units of the instance, shape (n, 2).
    values: Array
    #: Whether the last point is the first.
    closed: bool
    #: Z, u and the values as parts of their ranges, shape (n, 18); of poses none.
    unknowns: Array = field(default_factory=partial(np.zeros, (0, 18)))
    #: The cusps of the curve, shape (m, 2); of poses none.
    cusps: Array = field(default_factory=partial(np.zeros, (0, 2)))

    def contains(self, x: Array) -> bool:
        """Whether a singular pose, shape (18,), is nearer to a point than its neighbours are."""
        square = np.sum((self.unknowns[:, 16:] - x[16:]) ** 2, axis=1)
        for part in (slice(0, 8), slice(8, 16)):
            # z and u are known up to sign, and of norm one.
            square += 2 - 2 * np.abs(self.unknowns[:, part] @ x[part])
        return bool(square.min() < _LONGEST**2)


class Discriminant:
    """The equations of singular poses over two values, or readings of drives.

    With z a Study point, u a direction and v the two that vary, a singular pose is a zero of

        F(z, v) = 0,  p.z = 1,  F'(z, v) u = 0,  p.u = 0,  c.u = 1,

    seventeen equations for eighteen unknowns (G. Moore and A. Spence, SIAM J. Numer. Anal. 17,
    1980). The solutions are smooth curves also where their projection on the plane of values has a
    cusp: there only z and u change. They are followed by Newton's method in small steps, without
    proof. Where they cross edges of the grid the folds are proved.
    """

    def __init__(self, varied: VariedNumbers) -> None:
        self._varied, self._platform = varied, varied.platform()
        self._low, self._span = varied.low, varied.high - varied.low
        #: The nodes as parts of the ranges.
        self._grids = [
            (np.array(axis.values) - a) / (b - a)
            for axis, a, b in zip(varied.axes, varied.low, varied.high, strict=True)
        ]

    def plane(self, x: Array) -> Array:
        """Return what varies at some unknowns, (..., 18), as it is read."""
        read: Array = self._low + x[..., 16:] * self._span
        return read

    def _internal(self, w: Array) -> Array:
        """Return the row of the platform, of what varies as parts of the ranges."""
        return self._platform.internal(self._varied.row(self._low + w * self._span))

    def start(self, point: Array, read: Array) -> Array | None:
        """Return the unknowns of the singular pose near a Study point and readings, or None."""
        w = (read - self._low) / self._span
        rows = self._platform.jacobian(point, self._internal(w))
        direction = definite_sign(np.linalg.svd(np.vstack((rows, point)))[2][-1])
        x = np.concatenate((point / np.linalg.norm(point), direction, w))
        return self._corrected(x, x, None)

    def _equations(self, x: Array, patch: Array, gauge: Array) -> tuple[Array, Array]:
        """Return the seventeen equations and their derivatives, shape (17, 18).

        F is a polynomial in z: its derivative along u is the imaginary part at ``z + i t u`` with a
        tiny t. Those by v are differences, of an error of the square of their step.
        """
        z, u = x[:8], x[8:16]
        steps = _DIFFERENCE * np.array([[0, 0], [1, 0], [0, 1], [-1, 0], [0, -1]])
        each = [self._platform.quadrics(self._internal(x[16:] + step)) for step in steps]
        quadrics, coefficients = (np.concatenate(part) for part in zip(*each, strict=True))
        points = np.tile(z + 1j * _TINY * u, (len(steps), 1))
        F, J = equations_at(self._platform.shapes, quadrics, coefficients, points)
        moving = (F[1:3] - F[3:]).T / (2 * _DIFFERENCE)
        values = np.concatenate(
            (F[0].real, [patch @ z - 1], F[0].imag / _TINY, [patch @ u, gauge @ u - 1])
        )
        matrix = np.zeros((17, 18))
        matrix[:7, :8], matrix[:7, 16:] = J[0].real, moving.real
        matrix[7, :8] = matrix[15, 8:16] = patch
        matrix[8:15, :8], matrix[8:15, 8:16] = J[0].imag / _TINY, J[0].real
        matrix[8:15, 16:] = moving.imag / _TINY
        matrix[16, 8:16] = gauge
        return values, matrix

    def _corrected(self, x: Array, at: Array, row: Array | None, goal: float = 0.0) -> Array | None:
        """Return the solution near unknowns x by Newton's method, or None.

        The patch and the gauge are those of other unknowns. There is one more linear equation
        ``row . x = goal``, or steps are the shortest.
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
        tangent = definite_sign(np.linalg.svd(self._equations(x, *_units(x))[1])[2][-1])
        return tangent if like is None or tangent @ like > 0 else -tangent

    def follow(self, start: Array) -> Curve:
        """Return the curve through a singular pose, up to the ends of the ranges."""
        start = _scaled(start)
        tangent = self._tangent(start, None)
        ahead, cusps, closed = self._one_way(start, tangent)
        if not closed:
            behind, more, _ = self._one_way(start, -tangent)
            ahead, cusps = [*behind[:0:-1], *ahead], [*more, *cusps]
        x, turns = np.stack(ahead), np.array(cusps).reshape(-1, 18)
        return Curve(self.plane(x), closed, x, self.plane(turns))

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
        """Return the point between two of a curve where one value is given as a part."""
        part = (bound - x[16 + axis]) / (y[16 + axis] - x[16 + axis])
        row = np.zeros(18)
        row[16 + axis] = 1.0
        near = self._corrected((1 - part) * x + part * y, x, row, bound)
        return None if near is None or np.linalg.norm(near - x) > 4 * _LONGEST else near

    def through(self, event: Event, values: tuple[float, ...]) -> Curve | None:
        """Return the curve through a fold."""
        point = self._platform.points(event.R, event.T)
        start = self.start(point, np.array(values))
        return None if start is None else self.follow(start)

    def hidden(self, known: list[Curve], seed: int) -> Iterator[Curve]:
        """Yield curves that are not known, through singular poses near those at random values.

        Newton's method begins at the real pose that is nearest to being singular and at the
        complex one that is nearest to being real. Known curves may grow meanwhile.
        """
        parts = np.random.default_rng(seed).uniform(size=(_SAMPLES, 2))
        read = self.plane(np.pad(parts, ((0, 0), (16, 0))))
        for there, solved in zip(read, self._varied.each(read, seed), strict=True):
            for point in self._nearly_singular(solved):
                x = self.start(point, there)
                if x is None or not ((x[16:] >= 0) & (x[16:] <= 1)).all():
                    continue
                if not any(curve.contains(x) for curve in known):
                    yield self.follow(x)

    def _nearly_singular(self, solved: Solved) -> Iterator[Array]:
        """Yield Study points of one real and one complex solution at some place."""
        if solved.real.any():
            R, T = solved.R[solved.real].real, solved.T[solved.real].real
            worst = int(condition_numbers(Arrangement.of(solved.instance), R, T).argmax())
            yield self._platform.points(R[worst], T[worst])
        points = self._platform.points(*_complex(solved))
        if len(points):
            sizes = np.linalg.norm(points.imag, axis=1) / np.linalg.norm(points.real, axis=1)
            point = points[sizes.argmin()].real
            yield np.asarray(point / np.linalg.norm(point))

    def crossings(self, curve: Curve) -> Iterator[tuple[Edge, Crossing]]:
        """Yield where a curve crosses edges of the grid and the fold there is proved."""
        for x, y in zip(curve.unknowns[:-1], curve.unknowns[1:], strict=True):
            for axis in (0, 1):
                across = 1 - axis
                low, high = sorted((x[16 + across], y[16 + across]))
                lines = self._grids[across]
                # Curves end on the border of the grid.
                inside = (lines > low) & (lines <= high)
                inside[0] |= abs(low) < _BORDER
                inside[-1] |= abs(high - 1) < _BORDER
                for k in np.flatnonzero(inside).tolist():
                    at = self.at_line(x, y, across, float(lines[k]))
                    found = None if at is None else self._proved(at, axis, k)
                    if found is not None:
                        yield found

    def _proved(self, at: Array, axis: int, line: int) -> tuple[Edge, Crossing] | None:
        """Return the crossing of a line of the grid at a singular pose, if it can be proved."""
        place, grid = float(at[16 + axis]), self._grids[axis]
        k = int(np.searchsorted(grid, place)) - 1
        if not 0 <= k < len(grid) - 1:
            return None
        node = (k, line) if axis == 0 else (line, k)
        other = (k + 1, line) if axis == 0 else (line, k + 1)
        ends = self._varied.read(node), self._varied.read(other)
        rows = self._varied.row(ends[0]), self._varied.row(ends[1])
        part = (place - grid[k]) / (grid[k + 1] - grid[k])
        fold = prove_fold(self._platform.system, rows, part, at[:8], at[8:16])
        if fold is None or not 0 <= fold.low <= fold.high <= 1:
            return None
        values = tuple((ends[0] + fold.low * (ends[1] - ends[0])).tolist())
        return (axis, node), Crossing(values, 2 * fold.bends, *self._platform.poses(fold.point))


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
_NEXT, _AHEAD = 1e-6, 1.5


@dataclass(frozen=True, eq=False)
class Crossing:
    """A proved fold between two neighbouring nodes: a point of the discriminant.

    Mirror images have folds at the same values: each counts once, at its own pose. Over poses it
    is where the determinant changes its sign.
    """

    #: The values that vary, there.
    values: tuple[float, ...]
    #: The change of the number of modes, or of the sign, towards the greater value: 2 or -2.
    change: int
    #: The pose at which two modes meet, shapes (3, 3) and (3,).
    R: Array
    T: Array


@dataclass(frozen=True, eq=False)
class Meeting:
    """A place between two nodes where modes meet that is no simple fold, as symmetries cause.

    The modes are followed with proof to both sides of the place. That they meet there, and in which
    pose, is seen and not proved.
    """

    #: What varies, before and after the place.
    low: tuple[float, ...]
    high: tuple[float, ...]
    #: The numbers of modes there, each proved: all poses are found.
    before: int
    after: int
    #: Of each pose in which modes meet: how many there are before and after, R and T.
    poses: tuple[tuple[int, int, Array, Array], ...]


def in_order(crossings: Iterable[Crossing]) -> list[Crossing]:
    """Return folds by their values, and mirror images by their poses; rounding errors aside."""
    return sorted(
        crossings, key=lambda one: [float(f"{x:.9g}") for x in (*one.values, *one.T.tolist())]
    )


@dataclass(frozen=True, eq=False)
class Boundary:
    """The part of the discriminant that was found."""

    #: Proved folds, or singular poses, on the edges of the grid.
    crossings: list[Crossing] = field(default_factory=list)
    #: Over two that vary: the discriminant, or the singular curve, through them.
    curves: list[Curve] = field(default_factory=list)
    #: Places on edges where modes meet that are no simple folds.
    meetings: list[Meeting] = field(default_factory=list)
    #: Edges on which the changes at the crossings and meetings do not add up to the difference of
    #: the numbers of modes at the ends.
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
    varied = found.varied
    if isinstance(varied, VariedPoses):
        yield _singular_poses(found, varied)
        return
    assert isinstance(varied, VariedNumbers)
    search, modes = _Search(found, varied, seed), found.numbers["modes"]
    search.look_for_pairs()
    edges = []
    for edge in found.edges:
        edges.append((edge, int(modes[_ahead(edge)] - modes[edge[1]])))
        search.explain(*edges[-1])
        yield search.result
    for k in range(len(modes) - 1 if modes.ndim == 1 else 0):
        # A fold was found, and not the one that cancels it.
        edge = (0, (k,))
        if modes[k] == modes[k + 1] >= 0 and search.change(edge):
            edges.append((edge, 0))
            search.explain(edge, 0)
    search.look_for_hidden_curves()
    search.result.unexplained.extend(
        edge for edge, wanted in edges if search.change(edge) != wanted
    )
    yield search.result


class _Stopped(NamedTuple):
    """A mode that stops between two nodes: the part of the edge, from which node, and its pose."""

    part: float
    forward: bool
    R: Array
    T: Array


class _Search:
    """The crossings on the edges of a grid, from the numbers of modes at its nodes."""

    def __init__(self, found: Scan, varied: VariedNumbers, seed: int) -> None:
        self.result = Boundary()
        self._varied, self._seed = varied, seed
        self._modes = found.numbers["modes"]
        self._known: dict[Edge, list[Crossing]] = {}
        #: The changes at meetings.
        self._met: dict[Edge, int] = {}
        self._curves = Discriminant(varied) if len(found.axes) == 2 else None

    def change(self, edge: Edge) -> int:
        """Return the change of the number of modes along an edge that is explained."""
        folds = sum(crossing.change for crossing in self._known.get(edge, ()))
        return folds + self._met.get(edge, 0)

    def explain(self, edge: Edge, wanted: int) -> None:
        """Search for the folds on an edge along which the number of modes changes by ``wanted``."""
        other = _ahead(edge)
        first, last = (edge[1], other) if wanted < 0 else (other, edge[1])
        ends = []
        for start, goal in ((first, last), (last, first)):
            if self.change(edge) != wanted:
                ends += self._follow(edge, start, goal, wanted)
        if self.change(edge) != wanted:
            self._meet(edge, ends)

    def look_for_pairs(self) -> None:
        """Search for folds over one value from the complex solutions at each node."""
        if self._curves is not None:
            return
        platform, read = self._varied.platform(), self._varied.nodes
        rows = [self._varied.row(one) for one in read]
        for k, solved in enumerate(self._varied.each(read, self._seed)):
            points = platform.points(*_complex(solved))
            for step in (-1, 1):
                if len(points) and 0 <= k + step < len(rows):
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
        ends = np.stack([self._varied.read(start), self._varied.read(goal)])
        forward = start == edge[1]
        stopped = []
        for event in self._varied.track(start, goal, self._seed).events:
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

    def _meet(self, edge: Edge, stopped: list[_Stopped]) -> None:
        """Add the places between two nodes where modes stop that end in no simple fold."""
        axis, node = edge
        ends = self._varied.read(node), self._varied.read(_ahead(edge))
        stopped = sorted(stopped, key=lambda one: one.part)
        places: list[tuple[list[_Stopped], tuple[float, ...], tuple[float, ...], int, int]] = []
        while stopped:
            least = stopped[0].part
            group = [one for one in stopped if one.part - least < _AT_ONCE]
            stopped = stopped[len(group) :]
            for room in _ROOMS:
                parts = max(least - room, 0.0), min(group[-1].part + room, 1.0)
                low, high = (tuple((ends[0] + p * (ends[1] - ends[0])).tolist()) for p in parts)
                axes = [
                    replace(one, values=(a, b) if k == axis else (a,))
                    for k, (one, a, b) in enumerate(zip(self._varied.axes, low, high, strict=True))
                ]
                there = VariedNumbers(self._varied.instance, axes)
                counts = scan_grid(there, seed=self._seed).numbers["modes"].ravel()
                if counts.min() >= 0:
                    places.append((group, low, high, int(counts[0]), int(counts[1])))
                    break
        # Where the number of modes stays, following stopped on the way to a place where it changes.
        changes = [place for place in places if place[3] != place[4]] or places
        for place in places:
            if not any(place is one for one in changes):
                part = place[0][0].part
                min(changes, key=lambda one: abs(one[0][0].part - part))[0].extend(place[0])
        for group, low, high, before, after in changes:
            self.result.meetings.append(Meeting(low, high, before, after, _meeting_places(group)))
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


def _complex(solved: Solved) -> tuple[Field, Field]:
    """Return the solutions at one place that are finite and no real poses, (k, 3, 3) and (k, 3)."""
    R, T = solved.R[0], solved.T[0]
    rest = ~solved.real[0] & np.isfinite(R).all(axis=(1, 2)) & np.isfinite(T).all(axis=1)
    return R[rest], T[rest]


def _near(first: Crossing | _Stopped, second: Crossing | _Stopped, least: float) -> bool:
    """Whether two poses agree, as rotations and relatively."""
    size = np.abs(first.T).max() + np.abs(second.T).max()
    turned, moved = np.abs(first.R - second.R).max(), np.abs(first.T - second.T).max()
    return bool(turned < least and moved <= least * size)


def _meeting_places(group: Sequence[_Stopped]) -> tuple[tuple[int, int, Array, Array], ...]:
    """Return the poses of modes that stop at once: how many before and after, R and T."""
    left, found = list(group), []
    while left:
        # Modes approach a place where they meet as the square root of the part that is left.
        same = [
            one
            for one in left
            if _near(left[0], one, _TOGETHER + 0.1 * abs(one.part - left[0].part) ** 0.5)
        ]
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
    s, and vanishes where its tangent does. Complex Study points, shape (n, 8), are at the first
    row, s = 0; s = 1 at the next one. Yields about f, a real Study point there and the direction of
    the branches.
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


#: Columns of the pose at a fold.
POSE = ("Tx", "Ty", "Tz", "qw", "qx", "qy", "qz")


@dataclass(frozen=True, eq=False)
class ScanResult(Tabular):
    """The result of a scan.

    Attributes
    ----------
    found
        What is at the nodes.
    limits
        The folds between nodes, of poses the singular ones; empty if they were not asked for.
    folds
        Whether tables show these instead of the nodes.
    """

    found: Scan
    limits: Boundary
    folds: bool = False

    def __repr__(self) -> str:
        known, instance = self.found.numbers.get("modes", np.zeros(0)), self.found.instance
        known = known[known >= 0]
        modes = f", {known.min()} to {known.max()} modes" if known.size else ""
        folds = f", {counted(len(self.limits.crossings), 'fold')}" if self.folds else ""
        size = counted(self.found.done.size, "node")
        return f"<ScanResult of {instance.name or instance.type.id}: {size}{modes}{folds}>"

    @property
    def names(self) -> list[str]:
        """What varies: the numbers of constraints, or the names of drives or coordinates."""
        return self.found.varied.names

    @property
    def of_poses(self) -> bool:
        """Whether coordinates of a pose vary."""
        return isinstance(self.found.varied, VariedPoses)

    def rows(self) -> list[dict[str, Any]]:
        """Return the nodes that are known, or the folds, as plain data."""
        if not self.folds:
            return self._nodes()
        places = [dict(zip(self.names, one.values, strict=True)) for one in self.crossings]
        if self.of_poses:
            return places
        return [
            {**place, "change": one.change, **_pose(one.R, one.T)}
            for place, one in zip(places, self.crossings, strict=True)
        ]

    @property
    def crossings(self) -> list[Crossing]:
        """The folds, in order."""
        return in_order(self.limits.crossings)

    @property
    def kind(self) -> str:
        """The key of the rows in JSON."""
        return ("singular" if self.of_poses else "folds") if self.folds else "nodes"

    def to_json(self) -> dict[str, Any]:
        """Return everything as plain data of schema ``gsp.scan/1``."""
        axes = {axis.name: list(axis.values) for axis in self.found.axes}
        document: dict[str, Any] = {
            "schema": "gsp.scan/1",
            **self.found.instance.to_json(),
            "over" if self.of_poses else "vary": axes,
            self.kind: self.rows(),
        }
        if not self.folds:
            return document
        if self.of_poses:
            curves = [{"values": curve.values.tolist()} for curve in self.limits.curves]
            return document | {"curves": curves}
        document["curves"] = [
            {"closed": curve.closed, "values": curve.values.tolist(), "cusps": curve.cusps.tolist()}
            for curve in self.limits.curves
        ]
        document["meetings"] = [
            {
                "from": dict(zip(self.names, one.low, strict=True)),
                "to": dict(zip(self.names, one.high, strict=True)),
                "modes": [one.before, one.after],
                "poses": [{"modes": [a, b], **_pose(R, T)} for a, b, R, T in one.poses],
            }
            for one in self.limits.meetings
        ]
        return document

    def _nodes(self) -> list[dict[str, Any]]:
        found, nodes = self.found, self.found.varied.nodes
        columns = found.numbers | {"condition": printed_conditions(found.numbers["condition"])}
        rows = []
        for node in np.argwhere(found.done).tolist():
            row: dict[str, Any] = dict(zip(self.names, nodes[*node].tolist(), strict=True))
            for name, column in columns.items():
                row[name] = _finite(column[*node])
            if "modes" in row:
                row["modes"] = None if row["modes"] < 0 else int(row["modes"])
            rows.append(row)
        return rows


def _pose(R: Array, T: Array) -> dict[str, float]:
    numbers = [*T.tolist(), *quaternion_from_rotation(R).tolist()]
    return dict(zip(POSE, numbers, strict=True))


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
    axes = [axis_of(instance, k, np.asarray(v, float).tolist()) for k, v in vary.items()]
    varied = VariedNumbers(instance, axes)
    found = scan_grid(varied, clearance=clearance, seed=seed, workers=workers)
    for array in found.numbers.values():
        array.setflags(write=False)
    return ScanResult(found, boundary(found) if folds else Boundary(), folds)


def axis_of(instance: Instance, name: int | str, values: Sequence[float]) -> Axis:
    """Return the axis of a constraint by its number, or of a crank or slide by its name.

    Raises
    ------
    ArgumentError
        If there is no such constraint or drive.
    """
    if not isinstance(name, str) and name in range(1, len(instance.constraints) + 1):
        return Axis(str(name), tuple(values))
    known = drive_names(instance)
    if not isinstance(name, str) or name not in known:
        what = shown(name) if isinstance(name, str) else f"constraint {name}"
        others = f" or {listed(known)}" if known else ""
        message = f"found {what}, expected a number from 1 to 6{others}"
        raise ArgumentError(message, "vary")
    return Axis(name, tuple(values))


def drive_names(instance: Instance) -> list[str]:
    """Return the names of the cranks and slides of an instance."""
    drives = Machine.of(instance)
    return [name for name, moves in zip(drives.names, drives.moved, strict=True) if moves]


def _finite(number: Any) -> float | None:
    return float(number) if np.isfinite(number) else None
