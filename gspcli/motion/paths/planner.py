"""From one pose to another: a proved path, a proof that there is none, or neither.

What costs least is tried first:

- the limits at the ends, and the signs that a regular path cannot change (`Classes`);
- the straight way of values, and the straight way in position and angles;
- the proof that the mode fills its ranges (`fills_ranges`);
- a map of poses, or of sets of values with all their poses, and a smoother path.

Last the rows that are returned are proved.

In a map of poses ways are sampled first, since that takes less time than a proof of a way that is
singular. Only proved ways count. In a map of values all real poses for each set of values are
found. Each of them is followed along the straight ways to the nearest other sets; where it arrives
it is joined, by proof, with the pose there. Maps also tell which modes belong together
(`mode_groups`), and how the live page goes home (`home_map`).

Paths are made smoother by short cuts and moves of corners, each proved. The cost of a path is the
integral of its condition number by its length, in lengths of the platform. The length is that of
the way of the platform's points, as a root mean square. A change is kept if the new path is proved
and costs less. While a path is longer than three times the straight way, more tries follow in which
the condition number counts less. The numbers of tries are fixed, so that the result does not depend
on the speed of the computer. A change must save a thousandth of the cost, so that the result does
not depend on last digits either.

The determinant of the Jacobian matrix J is not zero on a regular path, so it keeps its sign. It is
a product if the screws of k constraints lie in a space of dimension k at every pose, with a basis
that is continuous and never degenerate. Their determinant in that basis is not zero either, so it
keeps its sign, too. Two factors can vanish together where det J does not change its sign: comparing
signs of det J alone would miss that. The spaces are:

- of angles: the moments;
- of distances to planes (DPH) with one normal n, and angles to n: the force n and the moments at
  right angles to it; the same with the bodies exchanged (DHP);
- of distances (DPP, DPL, DPH) of one point of the platform: the forces through it; the same for one
  point of the base (DPP, DLP, DHP).

Two of these determinants are products themselves:

- Three distances of one point to lines at right angles that meet (DPL, DLP). With the coordinates
  x, y, z of the point along the lines the determinant of the forces is a multiple of x y z.
- Angles of three directions at right angles to three others at right angles. With the unit
  quaternion q of the turn between them the determinant of the moments is a multiple of q0 q1 q2 q3.
"""

from __future__ import annotations

import heapq
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property, partial
from itertools import pairwise, takewhile
from time import monotonic
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.catalogue.kinds import DHP, DLP, DPH, DPL, DPP
from gspcli.defaults import PATH_SECONDS, SEED
from gspcli.errors import ArgumentError, IncompleteError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import jacobian
from gspcli.geometry.quaternions import apply, cross, quaternion_from_rotation
from gspcli.geometry.readings import without_corrections
from gspcli.motion.collisions.compared import NO_SHAPES, ComparedShapes
from gspcli.motion.paths.between import least_clearances, least_gaps
from gspcli.motion.paths.planned_paths import (
    PROVED_ROWS,
    DriveGuide,
    End,
    Guide,
    GuideRows,
    Modes,
    PathEnd,
    PathLimits,
    PathPart,
    PlannedPath,
    PoseGuide,
    ValueGuide,
    WayCosts,
    cost,
    steps,
    timed,
)
from gspcli.motion.paths.ways import PoseWays, ValueWays, fills_ranges
from gspcli.motion.workspace.travels import too_near, violations
from gspcli.records import Tabular, dataclass
from gspcli.solver import solve_batch
from gspcli.solver.result import SolveResult
from gspcli.wording import counted

Array = NDArray[np.float64]

#: Directions and points that differ by less are the same, relative to the sizes. The numbers of a
#: file are equal or differ by much more.
_SAME = 1e-13
#: A determinant of unit vectors whose modulus is above this has a certain sign: its rounding errors
#: are below a thousandth of that.
_CERTAIN = 1e-9


@dataclass(frozen=True)
class Factor:
    """A factor of det J."""

    #: The indices of the constraints whose determinant it is.
    constraints: tuple[int, ...]
    #: What these constraints see, in words.
    space: str

    @property
    def text(self) -> str:
        """The factor in words."""
        names = ", ".join(str(k + 1) for k in self.constraints)
        return f"the factor of constraints {names} ({self.space})"


@dataclass(frozen=True, eq=False)
class PoseClass:
    """The signs at a pose: of det J, and of each factor; 0 where the sign is not proved."""

    signs: tuple[int, ...]

    def differs(self, other: PoseClass) -> int | None:
        """Return the place of the first sign that is proved to differ; None if there is none."""
        for k, (a, b) in enumerate(zip(self.signs, other.signs, strict=True)):
            if a * b < 0:
                return k
        return None

    @property
    def text(self) -> str:
        """The signs, such as ``+-``; ``?`` where one is not proved."""
        return "".join("-?+"[sign + 1] for sign in self.signs)


class Classes:
    """The signs of one platform.

    Parameters
    ----------
    instance
        The platform.
    ways
        Straight ways of the platform, whose limits are not tested.
    """

    def __init__(self, instance: Instance, ways: PoseWays) -> None:
        self.arrangement = Arrangement.of(instance)
        self.ways = ways
        # Points that cranks and slides move are at no time those of the file.
        found = [] if ways.machine.moves else list(_factors(self.arrangement))
        self.factors = tuple(factor for factor, _ in found)
        self._determinants = [determinant for _, determinant in found]

    def of(self, R: Array, T: Array) -> PoseClass:
        """Return the class of a pose, shapes (3, 3) and (3,)."""
        sign = self.ways.at(self.ways.parameters(R, T)).sign
        values = [one(R, T) for one in self._determinants]
        signs = [int(np.sign(v)) if abs(v) > _CERTAIN else 0 for v in values]
        return PoseClass((sign, *signs))

    def name(self, place: int) -> str:
        """Return what a sign is of, in words."""
        return "det J" if place == 0 else self.factors[place - 1].text


Determinant = Callable[[Array, Array], float]


def _factors(a: Arrangement) -> Iterator[tuple[Factor, Determinant]]:
    """Yield the factors with functions that return their determinants at a pose."""
    angles = a.angles.tolist()
    if len(angles) == 3:
        yield Factor(tuple(angles), "angles"), partial(_of_moments, a, angles)
        yield from _of_turns(a, angles)
    for kind, own, said in ((DPH, a.v, "base"), (DHP, a.u, "platform")):
        for members, n in _with_one_direction(a, kind, own):
            planes = [k for k in members if a.kinds[k] is kind]
            if len(members) in (2, 3) and len(members) == (3 if planes else 2):
                space = f"one direction of the {said}"
                yield Factor(tuple(members), space), partial(_of_planes, a, members, n, kind is DPH)
    for kinds, points, said in (((DPP, DPL, DPH), a.y, "platform"), ((DPP, DLP, DHP), a.x, "base")):
        for members in _at_one_point(a, kinds, points):
            if len(members) == 3:
                yield (
                    Factor(tuple(members), f"one point of the {said}"),
                    partial(_of_forces, a, members),
                )
                yield from _of_places(a, members, said == "platform")


def _of_turns(a: Arrangement, members: list[int]) -> Iterator[tuple[Factor, Determinant]]:
    """Yield the signs of the quaternion of a turn between directions at right angles."""
    own, base = a.u[members], a.v[members]
    if not (_are_orthogonal(own) and _are_orthogonal(base)):
        return
    # The opposite of a direction changes no zero of a moment.
    own, base = own * np.linalg.det(own).round(), base * np.linalg.det(base).round()
    for k in (1, 2, 3):
        space = f"entries 0 and {k} of the quaternion of the turn"
        yield Factor(tuple(members), space), partial(_of_quaternion, own, base, k)


def _of_places(
    a: Arrangement, members: list[int], on_platform: bool
) -> Iterator[tuple[Factor, Determinant]]:
    """Yield the signs of the coordinates of a point along lines at right angles that meet."""
    lines = [a.kinds[k] is (DPL if on_platform else DLP) for k in members]
    points, directions = (a.x, a.v) if on_platform else (a.y, a.u)
    if not all(lines) or not _are_orthogonal(directions[members]):
        return
    first, v = points[members], directions[members]
    # The common point in the coordinates along the lines: each line gives two of the three.
    along = first @ v.T
    centre = np.array([(along.sum(axis=0)[k] - along[k, k]) / 2 for k in range(3)])
    off = along - centre
    off[np.arange(3), np.arange(3)] = 0
    if np.abs(off).max() > _SAME * max(float(np.abs(first).max()), a.length):
        return
    for k in range(3):
        space = f"place along the line of constraint {members[k] + 1}"
        yield (
            Factor(tuple(members), space),
            partial(_of_place, a, members[0], v[k], float(centre[k]), on_platform),
        )


def _are_orthogonal(directions: Array) -> bool:
    return bool(np.abs(directions @ directions.T - np.eye(3)).max() < _SAME)


def _with_one_direction(
    a: Arrangement, kind: object, directions: Array
) -> Iterator[tuple[list[int], Array]]:
    """Yield constraints with one common direction of a body, and that direction."""
    angles = set(a.angles.tolist())
    left = [k for k, one in enumerate(a.kinds) if one is kind or k in angles]
    while left:
        n = directions[left[0]]
        same = [k for k in left if np.abs(np.cross(directions[k], n)).max() < _SAME]
        left = [k for k in left if k not in same]
        yield same, n


def _at_one_point(a: Arrangement, kinds: tuple[object, ...], points: Array) -> Iterator[list[int]]:
    """Yield the distances of each common point of a body."""
    left = [k for k, one in enumerate(a.kinds) if one in kinds]
    size = np.abs(points).max(initial=0.0)
    while left:
        here = points[left[0]]
        same = [k for k in left if np.abs(points[k] - here).max() <= _SAME * size]
        left = [k for k in left if k not in same]
        yield same


def _unit(vectors: Array) -> Array:
    """Return unit vectors; zero for vectors that are nearly zero, whose direction is not known."""
    sizes = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.where(sizes > 0, vectors / np.where(sizes > 0, sizes, 1.0), 0.0)


def _of_moments(a: Arrangement, members: list[int], R: Array, T: Array) -> float:
    """Return the determinant of moments of angles."""
    del T
    w, v = a.u[members] @ R.T, a.v[members]
    moments = np.cross(w, v)
    # Near parallel directions a unit moment would have rounding errors that are not small.
    scale = np.maximum(np.linalg.norm(moments, axis=1), 1e-3)[:, None]
    return float(np.linalg.det(moments / scale))


def _across(n: Array) -> Array:
    """Return two unit vectors at right angles to n and to each other, shape (2, 3).

    They depend on n alone, so they are the same at all poses of a path.
    """
    first = _unit(np.cross(n, np.eye(3)[np.abs(n).argmin()]))
    return np.stack((first, np.cross(n, first)))


def _of_quaternion(own: Array, base: Array, k: int, R: Array, T: Array) -> float:
    """Return the product of two entries of the quaternion of a turn between directions."""
    del T
    q = quaternion_from_rotation(base @ R @ own.T)
    return float(q[0] * q[k])


def _of_place(
    a: Arrangement, member: int, v: Array, centre: float, on_platform: bool, R: Array, T: Array
) -> float:
    """Return the place of a point along a line, from where the lines meet, by the sizes."""
    point = R @ a.y[member] + T if on_platform else (a.x[member] - T) @ R
    size = a.length + np.abs(T).max() + np.abs(a.x[member]).max() + abs(centre)
    return float((point @ v - centre) / size)


def _of_planes(
    a: Arrangement, members: list[int], n: Array, of_base: bool, R: Array, T: Array
) -> float:
    """Return the determinant of screws that see one direction n of a body only.

    In the frame of that body; seen from the platform, the base moves.
    """
    if of_base:
        arms, others, far = a.y[members] @ R.T, a.u[members] @ R.T, 0.0
    else:
        arms, others = (a.x[members] - T) @ R, a.v[members] @ R
        far = float(np.abs(T).max() + np.abs(a.x[members]).max())
    middle = arms.mean(axis=0)
    basis = _across(n)
    rows = []
    for k, arm, other in zip(members, arms, others, strict=True):
        plane = a.kinds[k] in (DPH, DHP)
        moment = np.cross(arm - middle, n) if plane else np.cross(other, n)
        row = basis @ moment
        rows.append([*row, 1.0 if plane else 0.0] if len(members) == 3 else row)
    matrix = np.array(rows)
    if len(members) == 3:
        size = np.abs(matrix[:, :2]).max(initial=0.0)
        # Differences of arms have rounding errors relative to these.
        size = max(size, 1e-3 * (far + float(np.abs(arms).max(initial=0.0))), 1e-300)
        planes = matrix[:, 2] == 1.0
        matrix[planes, :2] /= size
    return float(np.linalg.det(matrix))


def _of_forces(a: Arrangement, members: list[int], R: Array, T: Array) -> float:
    """Return the determinant of the unit forces of distances."""
    placed = a.placed(R, T)
    forces = []
    for k in members:
        r, w, v = placed.r[k], placed.w[k], a.v[k]
        kind = a.kinds[k]
        if kind is DPP:
            force = r
        elif kind is DPL:
            force = r - (r @ v) * v
        elif kind is DLP:
            force = r - (r @ w) * w
        else:
            force = v if kind is DPH else w
        # A distance near zero has no direction that is known well.
        size = float(np.linalg.norm(force))
        sizes = (np.linalg.norm(part) for part in (T, a.x[k], a.y[k]))
        known = size > 1e-5 * float(sum(sizes))
        forces.append(force / size if known or kind in (DPH, DHP) else np.zeros(3))
    return float(np.linalg.det(forces))


#: Samples of a way, and how near to zero a determinant may come there, by its size at the ends.
_SAMPLES, _NEAR = 48, 0.01
#: Random poses are near a given one in this many cases of ten; how far, in lengths and radians.
_NEARBY, _FAR, _TURN = 5, 0.6, 0.8
#: To how many near nodes, and to how many of each part, a new node is joined.
_NEIGHBOURS, _PARTS, _OTHERS = 10, 24, 5
#: A pose with a smaller determinant is climbed from first: this many small random steps.
_FLAT, _STEPS, _CLIMB_TRIES = 2e-3, 40, 24
#: Numbers of random poses and values are rounded to this part of their size or range, so that
#: files are short and do not depend on last digits.
_DIGITS = 6
#: Sets of values that are solved at a time, and to how many near ones each is joined.
_BATCH, _NEAR_SETS = 16, 6
#: Random values keep this part of the range away from its ends.
_MARGIN = 1e-3
#: Values that a pose measures differ by less from those that it was solved for.
_SOLVED = 1e-6
#: In how many places cones are tested before they are proved.
_LOOKS = 12


class Connections:
    """Nodes 0, 1, ... with edges between them."""

    def __init__(self) -> None:
        self._parent: list[int] = []
        self._edges: list[dict[int, float]] = []

    def __len__(self) -> int:
        return len(self._parent)

    def add(self) -> int:
        """Add a node and return its number."""
        self._parent.append(len(self._parent))
        self._edges.append({})
        return len(self._parent) - 1

    def root(self, node: int) -> int:
        """Return the number that all nodes joined with a node have in common."""
        while self._parent[node] != node:
            self._parent[node] = self._parent[self._parent[node]]
            node = self._parent[node]
        return node

    def joined(self, first: int, second: int) -> bool:
        """Whether there is a way from one node to another."""
        return self.root(first) == self.root(second)

    def join(self, first: int, second: int, cost: float = 1.0) -> None:
        """Add an edge. The smaller root stays, so that the order of edges does not matter."""
        if second not in self._edges[first]:
            self._edges[first][second] = self._edges[second][first] = cost
        a, b = sorted((self.root(first), self.root(second)))
        self._parent[b] = a

    def remove(self, first: int, second: int) -> None:
        """Remove an edge."""
        del self._edges[first][second], self._edges[second][first]
        self._parent = list(range(len(self._parent)))
        for node, others in enumerate(self._edges):
            for other in others:
                a, b = sorted((self.root(node), self.root(other)))
                self._parent[b] = a

    def way(self, first: int, last: int) -> list[int] | None:
        """Return the nodes of the cheapest way from one to another; None if there is no way."""
        if not self.joined(first, last):
            return None
        before: dict[int, int] = {}
        done: set[int] = set()
        queue = [(0.0, first, first)]
        while queue:
            cost, node, previous = heapq.heappop(queue)
            if node in done:
                continue
            done.add(node)
            before[node] = previous
            if node == last:
                break
            for other, more in self._edges[node].items():
                if other not in done:
                    heapq.heappush(queue, (cost + more, other, node))
        found = [last]
        while found[-1] != first:
            found.append(before[found[-1]])
        return found[::-1]


class Map(Connections, ABC):
    """Poses joined by proved straight ways: nodes 0 to `count` - 1 are given, others random."""

    def __init__(self, instance: Instance, count: int, seed: int) -> None:
        super().__init__()
        self.count = count
        self._costs = WayCosts(instance)
        self._random = np.random.default_rng(seed)
        self._refused: set[tuple[int, int]] = set()

    @abstractmethod
    def join_given(self) -> None:
        """Try the straight ways between the given poses."""

    @abstractmethod
    def grow(self) -> None:
        """Add random poses and join them."""

    @abstractmethod
    def poses(self, nodes: Sequence[int]) -> tuple[Array, Array]:
        """Return the poses (R, T) of nodes."""

    @abstractmethod
    def corners(self, nodes: Sequence[int]) -> Array:
        """Return the polygon through nodes, as guides take it, shape (k, 6)."""

    @abstractmethod
    def guide(self, first: int, last: int) -> Guide:
        """Return what proves polygons from one node to another."""

    def refuse(self, first: int, last: int) -> None:
        """Take an edge away for good, since it violates what else is required."""
        self._refused.add((min(first, last), max(first, last)))
        self.remove(first, last)

    def unproved(self, nodes: Sequence[int]) -> tuple[int, int] | None:
        """Return the first edge of a way that is not proved alone; None if all are."""
        for a, b in pairwise(nodes):
            if self.guide(a, b).trace(self.corners((a, b)), _ROWS) is None:
                return a, b
        return None

    def all_joined(self, pairs: Iterable[tuple[int, int]]) -> bool:
        """Whether both nodes of all pairs are joined."""
        return all(self.joined(a, b) for a, b in pairs)


class PoseMap(Map):
    """A map of poses of one platform.

    Parameters
    ----------
    guide
        Proves straight ways of the platform.
    R, T
        The poses that are to be joined, shapes (n, 3, 3) and (n, 3): nodes 0 to n - 1.
    class_of
        The class of a pose (R, T); nodes of different classes are never joined.
    seed
        Of the random poses.
    limited
        Whether poses must keep the limits of the guide.
    """

    def __init__(
        self,
        guide: PoseGuide,
        R: Array,
        T: Array,
        class_of: Callable[[Array, Array], PoseClass],
        *,
        seed: int,
        limited: bool = False,
    ) -> None:
        self.ways, self._guide, self._class_of, self._limited = guide.ways, guide, class_of, limited
        # Rods that share a drive are parallel at one orientation only.
        self._keeps_turn = self.ways.machine.shared
        self.arrangement = Arrangement.of(self.ways.instance)
        super().__init__(self.ways.instance, len(T), seed)
        self.nodes = [*self.ways.parameters(R, T)]
        self.classes = [class_of(*pose) for pose in zip(R, T, strict=True)]
        self._costs.add(*self.poses(range(len(T))))
        for _ in self.nodes:
            self.add()
        self._signs = [float(np.sign(d)) for d in self.determinants(np.array(self.nodes)).tolist()]
        places = np.array(self.nodes)[:, :3]
        self._span = float(np.ptp(places, axis=0).max()) + self.arrangement.length
        self._sizes = np.array([self._span] * 3 + [1.0] * 3)

    def determinants(self, parameters: Array) -> Array:
        """Return determinants of J with rows of norm one, about the pivot, ``(n, 6) -> (n,)``."""
        length = self.arrangement.length
        R, T = self.ways.poses(parameters)
        with np.errstate(all="ignore"):
            rows = jacobian(self.ways.arrangement(R, T), R, T)
            offset = apply(R, np.broadcast_to(self.ways.pivot, T.shape))[..., None, :]
            rows[..., :3] -= cross(np.broadcast_to(offset, rows[..., 3:].shape), rows[..., 3:])
            rows[..., :3] /= length
            rows /= np.linalg.norm(rows, axis=-1, keepdims=True)
            finite = np.isfinite(rows).all(axis=(-1, -2))
            found = np.linalg.det(np.where(np.asarray(finite)[..., None, None], rows, 0.0))
        return np.asarray(found, float)

    def poses(self, nodes: Sequence[int]) -> tuple[Array, Array]:
        """Return the poses (R, T) of nodes."""
        return self.ways.poses(np.array([self.nodes[k] for k in nodes]))

    def corners(self, nodes: Sequence[int]) -> Array:
        """Return the parameters of nodes, each continued from the one before, shape (k, 6)."""
        found = [self.nodes[nodes[0]]]
        for node in nodes[1:]:
            found.append(self.ways.nearest(found[-1], self.nodes[node]))
        return np.array(found)

    def guide(self, first: int, last: int) -> PoseGuide:
        """Return what proves polygons of poses."""
        del first, last
        return self._guide

    def join_given(self) -> None:
        """Try the straight ways between all given poses."""
        for k in range(self.count):
            self._climb(k)
        pairs = [(i, j) for i in range(self.count) for j in range(i)]
        self._join(pairs)
        tops = list(range(self.count, len(self.nodes)))
        self._join([(i, j) for i in tops for j in range(len(self.nodes)) if j < i])

    def grow(self) -> None:
        """Add a random pose and join it."""
        k = self._new(self._drawn())
        if k is None:
            return
        old = [i for i in range(k) if self._alike(i, k)]
        if not old:
            return
        shuffled = self._random.permutation(len(old))
        old = [old[i] for i in shuffled.tolist()]
        far = self._distances(k, old)
        near = [old[i] for i in np.argsort(far, kind="stable")[:_NEIGHBOURS].tolist()]
        given = [i for i in range(self.count) if self._alike(i, k) and i not in near]
        self._join([(i, k) for i in [*near, *given[:_PARTS], *old[:_OTHERS]]])

    def _drawn(self) -> Array:
        draw = self._random
        base = self.nodes[int(draw.integers(self.count))]
        away = np.concatenate((draw.normal(size=3) * self._span * _FAR, draw.normal(size=3)))
        one: Array = base.copy()
        one[:3] += away[:3]
        if self._keeps_turn:
            return one
        if draw.integers(10) < _NEARBY:
            one[3:] += away[3:] * _TURN
        else:
            one[3:] = draw.uniform(-np.pi, np.pi, size=3)
        return one

    def _new(self, parameters: Array) -> int | None:
        """Add a pose unless it is singular or violates a limit; return its number."""
        digits = _DIGITS - int(np.floor(np.log10(self._span)))
        turn = parameters[3:] if self._keeps_turn else parameters[3:].round(_DIGITS)
        one = np.concatenate((parameters[:3].round(digits), turn))
        R, T = self.ways.poses(one)
        if self._limited and not self._guide.kept(R[None], T[None])[0]:
            return None
        d = float(self.determinants(one[None])[0])
        if not d:
            return None
        self.nodes.append(one)
        self.classes.append(self._class_of(R, T))
        self._signs.append(float(np.sign(d)))
        self._costs.add(R[None], T[None])
        return self.add()

    def _alike(self, i: int, j: int) -> bool:
        return self._signs[i] == self._signs[j] and self.classes[i].differs(self.classes[j]) is None

    def _distances(self, k: int, others: list[int]) -> Array:
        there = np.array([self.nodes[i] for i in others])
        away = self.ways.nearest(self.nodes[k], there) - self.nodes[k]
        return np.asarray(np.linalg.norm(away / self._sizes, axis=1))

    def _join(self, pairs: list[tuple[int, int]]) -> None:
        """Prove ways between nodes that are not joined yet."""
        open_ = [
            (i, j)
            for i, j in pairs
            if self._alike(i, j)
            and not self.joined(i, j)
            and (min(i, j), max(i, j)) not in self._refused
        ]
        if not open_:
            return
        begins = np.array([self.nodes[i] for i, _ in open_])
        ends = self.ways.nearest(begins, np.array([self.nodes[j] for _, j in open_]))
        for (i, j), begin, end, good in zip(
            open_, begins, ends, self._sampled(begins, ends), strict=True
        ):
            if good and not self.joined(i, j):
                self._try(i, j, begin, end)

    def _try(self, i: int, j: int, begin: Array, end: Array) -> bool:
        proved = bool(self.ways.prove(begin, end).sign)
        if proved:
            self.join(i, j, self._costs.between(i, j))
        return proved

    def _sampled(self, begins: Array, ends: Array) -> NDArray[np.bool_]:
        """Return which ways keep the sign of the determinant at samples, and the limits."""
        parts = np.linspace(0, 1, _SAMPLES)[:, None]
        between = begins[:, None] * (1 - parts) + ends[:, None] * parts
        flat = between.reshape(-1, 6)
        found = self.determinants(flat).reshape(len(begins), -1)
        found = found * np.sign(found[:, :1])
        good = found.min(axis=1) > _NEAR * np.minimum(found[:, 0], found[:, -1])
        good &= np.abs(np.diff(found, axis=1)).max(axis=1) < 2 * np.abs(found).max(axis=1)
        if self._limited:
            kept = self._guide.kept(*self.ways.poses(flat)).reshape(len(begins), -1)
            good &= kept.all(axis=1)
        return np.asarray(good)

    def _climb(self, k: int) -> None:
        """From a pose that is nearly singular go to one that is less so, by proved steps."""
        here = k
        for step in range(_STEPS):
            best = abs(float(self.determinants(self.nodes[here][None])[0]))
            if best > _FLAT:
                return
            width = 0.1 * 0.5 ** (step % 4)
            tries = (
                self.nodes[here] + self._random.normal(size=(_CLIMB_TRIES, 6)) * self._sizes * width
            )
            sizes = self.determinants(tries) * self._signs[here]
            for one in np.argsort(-sizes, kind="stable")[:3].tolist():
                if sizes[one] < 1.2 * best:
                    break
                new = self._new(tries[one])
                if new is None:
                    continue
                begin, end = self.nodes[here], self.ways.nearest(self.nodes[here], self.nodes[new])
                if self._sampled(begin[None], end[None])[0] and self._try(here, new, begin, end):
                    here = new
                    break


class ValueMap(Map):
    """A map of values of one platform within its ranges.

    Parameters
    ----------
    ways
        Straight ways of values.
    instance
        The platform; its values are used where a value has no range.
    values, R, T
        The poses that are to be joined with their values, shapes (n, 6), (n, 3, 3) and (n, 3):
        nodes 0 to n - 1. Poses next to each other with equal values are one set.
    seed
        Of the random values.
    clear, gap
        As for `Guide`.
    """

    def __init__(
        self,
        ways: ValueWays,
        instance: Instance,
        values: Array,
        R: Array,
        T: Array,
        *,
        seed: int,
        clear: float = 0.0,
        gap: float | None = None,
    ) -> None:
        super().__init__(instance, len(values), seed)
        self.ways, self.instance, self._kept = ways, instance, (clear, gap)
        self._sets: list[Array] = []
        self._members: list[list[int]] = []
        self.points: list[Array] = []
        self.values: list[Array] = []
        self._add(values, ways.points(R, T))
        low, high, size = ways.low, ways.high, np.abs(values[0])
        self._low = np.where(np.isfinite(low), low, values[0] - 0.5 * size)
        self._high = np.where(np.isfinite(high), high, values[0] + 0.5 * size)

    def _add(self, values: Array, points: Array) -> list[int]:
        """Add poses with their values; return the numbers of their sets."""
        found: list[int] = []
        for row, point in zip(values, points, strict=True):
            if not self._sets or not np.array_equal(self._sets[-1], row):
                self._sets.append(row)
                self._members.append([])
            if not found or found[-1] != len(self._sets) - 1:
                found.append(len(self._sets) - 1)
            self._members[-1].append(self.add())
            self.points.append(point)
            self.values.append(row)
        self._costs.add(*self.ways.poses(points))
        return found

    def join_given(self) -> None:
        """Follow the given poses between their sets of values."""
        sets = range(len(self._sets))
        self._follow([(i, j) for i in sets for j in sets if i < j])

    def grow(self) -> None:
        """Add random sets of values with all their poses and join them."""
        drawn = self._drawn()
        batch = solve_batch(self.instance, np.abs(drawn))
        sets: list[int] = []
        for k, row in enumerate(drawn):
            real = batch.real[k] & batch.certified[k]
            R, T = batch.R[k][real].real, batch.T[k][real].real
            if not len(R):
                continue
            size = self._high - self._low
            good = (np.abs(self.ways.values(R, T) - row) <= _SOLVED * size).all(axis=1)
            if self.ways.cones:
                good &= (self.ways.machine.cone_shares(R, T) <= 1).all(axis=1)
            R, T = R[good], T[good]
            if len(R):
                sets += self._add(np.tile(row, (len(R), 1)), self.ways.points(R, T))
        every, size = np.array(self._sets), self._high - self._low
        size = np.where(size > 0, size, 1.0)
        given = {self._set_of(k) for k in range(self.count)}
        pairs = []
        for i in sets:
            away = np.linalg.norm((every[:i] - every[i]) / size, axis=1)
            near = np.argsort(away, kind="stable")[:_NEAR_SETS].tolist()
            pairs += [(i, j) for j in near]
            pairs += [(j, i) for j in sorted(given) if j not in near]
        self._follow(pairs)

    def _set_of(self, node: int) -> int:
        return next(k for k, members in enumerate(self._members) if node in members)

    def _drawn(self) -> Array:
        u = self._random.random((_BATCH, 6))
        # Half of them near the ends of the ranges, where modes come near to each other.
        near = self._random.random(_BATCH) < 0.5
        u = np.where(near[:, None], np.sin(np.pi / 2 * u) ** 2, u)
        u = _MARGIN + (1 - 2 * _MARGIN) * u
        return np.asarray(self._low + (self._high - self._low) * u.round(_DIGITS))

    def _follow(self, pairs: Sequence[tuple[int, int]]) -> None:
        """Follow all poses of sets to other sets, and join those that arrive."""
        if not pairs:
            return
        ways = np.array([[self._sets[i], self._sets[j]] for i, j in pairs])
        starts = [(p, node, j) for p, (i, j) in enumerate(pairs) for node in self._members[i]]
        which = np.array([p for p, _, _ in starts], np.int64)
        points = np.array([self.points[node] for _, node, _ in starts])
        found = self.ways.follow(ways, which, points)
        for k in np.flatnonzero(found.there).tolist():
            _, node, j = starts[k]
            there = np.array([self.points[other] for other in self._members[j]])
            same = np.flatnonzero(self.ways.same(there, found.points[k, -1]))
            if len(same) != 1:
                continue
            other = self._members[j][int(same[0])]
            if (min(node, other), max(node, other)) in self._refused:
                continue
            if self._looks_kept(points[k], found.points[k, -1]):
                self.join(node, other, self._costs.between(node, other))

    def _looks_kept(self, first: Array, last: Array) -> bool:
        """Whether samples near a way keep the cones; of ways that are used it is proved."""
        if not self.ways.cones:
            return True
        last = last if first @ last > 0 else -last
        parts = np.linspace(0, 1, _LOOKS)[:, None]
        R, T = self.ways.poses(first * (1 - parts) + last * parts)
        return bool((self.ways.machine.cone_shares(R, T) <= 1).all())

    def poses(self, nodes: Sequence[int]) -> tuple[Array, Array]:
        """Return the poses (R, T) of nodes."""
        return self.ways.poses(np.array([self.points[node] for node in nodes]))

    def corners(self, nodes: Sequence[int]) -> Array:
        """Return the values of nodes, shape (k, 6)."""
        return np.array([self.values[node] for node in nodes])

    def guide(self, first: int, last: int) -> ValueGuide:
        """Return what proves polygons of values from one node to another."""
        return ValueGuide(self.ways, self.points[first], self.points[last], *self._kept)


#: Yields None while it goes on, and at last a path with what proves it.
Search = Iterator[tuple[Guide, Array] | None]
#: How many times as many rows of a way of values are tried as places of straight ways of poses.
_FINER = (1, 4, 16)
#: Random tries, at first and with each of the other powers of the condition number.
_TRIES, _MORE, _POWERS = 400, 300, (0.5, 0.25)
#: Random tries where each proof has clearances or gaps, which take long.
_SLOW_TRIES = 40
#: A path that is this many times as long as the straight way is long.
LONG = 3.0
_ROWS = np.array([PROVED_ROWS])
#: How far corners are moved, by their ranges, and what a change must be worth.
_MOVES, _WORTH = (0.02, 0.08, 0.25), 1e-3
#: How far a platform moves from row to row, in its lengths; how many rows a part has.
_STEP, _LEAST, _MOST = 0.03, 4, 200


def path(
    instance: Instance,
    start: End,
    goal: End,
    *,
    along: str | None = None,
    clear: float = 0.0,
    gap: float | None = None,
    time: float = PATH_SECONDS,
    seed: int = SEED,
    pivot: Sequence[float] | None = None,
    sequence: str = "ZYX",
    speed: float | Mapping[str, float] | None = None,
    acceleration: float | Mapping[str, float] | None = None,
) -> PlannedPath:
    """Plan a path from one pose to another that is proved on the whole way.

    No pose of the path is singular, and all of them keep the ranges and cones that the instance
    states. If it is proved that there is no such path, the answer says why.

    Parameters
    ----------
    instance
        The platform with its limits.
    start, goal
        A mode by its number of `solve`, ``home``, or a pose (R, T).
    along
        Whether the ``values`` change linearly between the corners of the path, or position and
        angles (``poses``). None tries both straight ways; paths with corners are along values if
        each value has a range, else along poses. With cranks or slides ``values`` are the numbers
        of all drives, and paths with corners are along poses.
    clear
        The clearance that every pose must have, in the units of `clearance`; with cranks or slides
        that of the drives.
    gap
        How far legs and bodies must be apart at every pose, in the unit of length; the instance
        must state their shapes. None for no such limit.
    time
        After this many seconds no more paths are tried. The bytes of a path that is found do not
        depend on it.
    seed
        The seed of all random numbers: the same seed gives the same path.
    pivot, sequence
        The point of the platform, in its frame, and the order of the axes of the angles of straight
        ways of poses.
    speed, acceleration
        Limits on the whole way, also between rows; then the rows have times in seconds. A number is
        of each drive, in the unit of its value a second (squared). By name: of the ``drives``, of
        the ``platform``'s pivot, and of its ``turn`` in the unit of angles; the last two are proved
        on ways of poses.

    Raises
    ------
    ArgumentError
        If an argument is wrong.

    Examples
    --------
    >>> import gspcli
    >>> platform = gspcli.example("workspace-study")
    >>> found = gspcli.path(platform, "home", 3)
    >>> found.verdict, found.along
    ('proved', 'values')
    >>> gspcli.path(platform, "home", 2).reason
    'the sign of det J differs, and a regular path keeps it'
    """
    planner = Planner(
        instance, along=along, clear=clear, gap=gap, seconds=time, seed=seed, pivot=pivot,
        sequence=sequence, limits=PathLimits.of(speed, acceleration),
    )  # fmt: skip
    modes = Modes(instance)
    return planner.path(modes.end(start, "start"), modes.end(goal, "goal"))


class Planner:
    """Plans paths of one platform.

    Parameters
    ----------
    instance
        The platform with its limits.
    along
        ``values``, ``poses``, or None for both.
    clear
        The clearance that every pose must have, in the units of `gsp clearance`.
    gap
        The least gap between legs and bodies; None if gaps are not tested.
    seconds
        After this time nothing more is tried.
    seed
        Of everything random.
    pivot, sequence
        The point of the platform and the order of angles of straight ways of poses.
    limits
        Of speeds and accelerations, if paths are to have a time.
    """

    def __init__(
        self,
        instance: Instance,
        *,
        along: str | None = None,
        clear: float = 0.0,
        gap: float | None = None,
        seconds: float = PATH_SECONDS,
        seed: int = SEED,
        pivot: ArrayLike | None = None,
        sequence: str = "ZYX",
        limits: PathLimits | None = None,
    ) -> None:
        if along not in (None, "values", "poses"):
            raise ArgumentError(f"found {along!r}, expected values or poses", "along")
        if not (np.isfinite(seconds) and seconds >= 0):
            raise ArgumentError(f"found {seconds}, expected seconds, not negative", "time")
        if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
            raise ArgumentError(f"found {seed!r}, expected a whole number, not negative", "seed")
        if not (clear >= 0 and np.isfinite(clear)):
            raise ArgumentError(f"found {clear}, expected a number that is not negative", "clear")
        if limits is not None and limits.of_platform:
            if along == "values":
                raise ArgumentError(
                    "found a limit of the platform, which is proved along poses only", "speed"
                )
            along = "poses"
        self.limits = limits
        if gap is not None:
            _check_gap(instance, gap)
        self.gap = gap
        self.given = instance
        self.instance = without_corrections(instance)
        self.along, self.clear, self.seed = along, clear, int(seed)
        self.seconds = seconds
        self._first: PathEnd | None = None
        self._axes = {"pivot": pivot, "sequence": sequence}

    @cached_property
    def machine(self) -> Machine:
        """The cranks and slides in the working modes of the stated home, else of the start."""
        machine = Machine.of(self.instance)
        if not machine.moves:
            return machine.at_home()
        if self._first is None and self.instance.home is None:
            raise ArgumentError(
                "the file states no home: the working modes of its cranks and slides are not known"
            )
        pose = (None, None) if self._first is None else (self._first.R, self._first.T)
        return machine.at_home(*pose)

    @cached_property
    def ways(self) -> PoseWays:
        """Straight ways in position and angles that keep the limits."""
        return PoseWays(
            self.instance,
            limits=True,
            working_modes=self.machine.signs,
            **self._axes,  # type: ignore[arg-type]
        )

    @cached_property
    def classes(self) -> Classes:
        """The signs that regular paths keep."""
        return Classes(
            self.instance, PoseWays(self.instance, limits=False, working_modes=self.machine.signs)
        )

    def values(self, end: PathEnd) -> ValueWays:
        """Return straight ways of values on the sides of a pose."""
        return ValueWays(self.instance, np.sign(end.values))

    def path(self, start: PathEnd, goal: PathEnd) -> PlannedPath:
        """Plan a path from one pose to another."""
        self._first = start
        reason = self._impossible(start, goal)
        if reason:
            return PlannedPath(self.given, start.name, goal.name, "impossible", reason)
        deadline = time.monotonic() + self.seconds
        guide, corners = self._straight(start, goal)
        if guide is None and not self.machine.moves:
            ways = self.values(start)
            if any(self.fills_ranges(end, ways) for end in (start, goal)):
                reason = "the mode fills its box of ranges, and the other pose is not on it"
                return PlannedPath(self.given, start.name, goal.name, "impossible", reason)
        if guide is None:
            guide, corners = self._on_map(start, goal, lambda: time.monotonic() < deadline)
        if guide is None or corners is None:
            reason = "no path was found in the time given, and none is proved to be impossible"
            return PlannedPath(self.given, start.name, goal.name, "not found", reason)
        if len(corners) > 2:
            corners = smoothed(self.instance, guide, corners, self.seed)
        return finished(self.given, guide, corners, start, goal, self.limits)

    @property
    def stays(self) -> bool:
        """Whether some value that no crank or slide moves must stay: random poses change it."""
        return bool(self.machine.stays.any())

    def left(self, end: PathEnd) -> str:
        """Return the first limit that a pose violates, in words, or nothing."""
        machine = self.machine
        if end.is_mode and self.instance.home is not None:
            other = machine.in_other_working_modes(end.R[None], end.T[None])[0]
            if other.any():
                name = machine.names[machine.index[int(other.argmax())]]
                return f"{name.replace('.', ' ')} is beyond a dead point from home"
        return next(iter(violations(self.instance, end.R, end.T, machine.signs)), "")

    def _impossible(self, start: PathEnd, goal: PathEnd) -> str:
        """Return why there can be no path, or nothing."""
        for end in (start, goal):
            wrong = self.left(end)
            if wrong:
                return f"{end.name} is outside the limits: {wrong}"
            wrong = self._too_near(end)
            if wrong:
                return f"{end.name}: {wrong}"
        first, last = (self.classes.of(end.R, end.T) for end in (start, goal))
        place = first.differs(last)
        if place is not None:
            return f"the sign of {self.classes.name(place)} differs, and a regular path keeps it"
        return ""

    def _too_near(self, end: PathEnd) -> str:
        """Return which legs or bodies are proved to be too near at an end, or nothing."""
        if self.gap is None:
            return ""
        return next(iter(too_near(self.instance, end.R, end.T, self.gap)), "")

    def _straight(self, start: PathEnd, goal: PathEnd) -> tuple[Guide | None, Array | None]:
        """Return a straight path of values or drives, or of poses, if one is proved."""
        tried: list[Callable[[], tuple[Guide, Array]]] = []
        # A straight way of equal values would stay where it is.
        moves = any(not np.array_equal(x, y) for x, y in ((start.R, goal.R), (start.T, goal.T)))
        still = np.array_equal(start.values, goal.values) and moves
        if self.along != "poses" and self.machine.moves:
            drives = DriveGuide(self.machine, start, goal, self.clear, self.gap)
            tried.append(lambda: (drives, drives.corners))
        elif self.along != "poses" and not still:
            values = np.stack((start.values, goal.values))
            tried.append(lambda: (self.value_guide(self.values(start), start, goal), values))
        if self.along != "values":
            tried.append(lambda: (self.pose_guide(), np.stack(self._parameters(start, goal))))
        for one in tried:
            guide, corners = one()
            if guide.trace(corners, _ROWS) is not None:
                return guide, corners
        return None, None

    def value_guide(self, ways: ValueWays, start: PathEnd, goal: PathEnd) -> ValueGuide:
        """Return what proves polygons of values between two ends."""
        first, last = (ways.points(end.R[None], end.T[None])[0] for end in (start, goal))
        return ValueGuide(ways, first, last, self.clear, self.gap)

    def pose_guide(self) -> PoseGuide:
        """Return what proves polygons of poses."""
        return PoseGuide(self.ways, Arrangement.of(self.instance).length, self.clear, self.gap)

    def _parameters(self, start: PathEnd, goal: PathEnd) -> tuple[Array, Array]:
        begin, end = (self.ways.parameters(one.R, one.T) for one in (start, goal))
        return begin, self.ways.nearest(begin, end)

    def fills_ranges(self, end: PathEnd, ways: ValueWays | None = None) -> bool:
        """Whether it is proved that a mode is one pose for all values in the ranges.

        Parameters
        ----------
        end
            The mode.
        ways
            Straight ways of values; None for those on the sides of the mode.
        """
        if self.machine.moves or self.clear or self.gap is not None:
            return False
        ways = self.values(end) if ways is None else ways
        if not ways.ranged:
            return False
        point = ways.points(end.R[None], end.T[None])[0]
        return fills_ranges(ways, end.values, point)

    def value_map(self, ends: Sequence[PathEnd]) -> ValueMap:
        """Return a map of values with some ends, on the sides of the first."""
        values, R, T = (np.stack([getattr(end, n) for end in ends]) for n in ("values", "R", "T"))
        return ValueMap(
            self.values(ends[0]), self.instance, values, R, T,
            seed=self.seed, clear=self.clear, gap=self.gap,
        )  # fmt: skip

    def pose_map(self, ends: Sequence[PathEnd]) -> PoseMap:
        """Return a map of poses with some ends."""
        R, T = np.stack([end.R for end in ends]), np.stack([end.T for end in ends])
        limited = self.machine.limited or self.machine.moves or self.gap is not None
        return PoseMap(
            self.pose_guide(), R, T, self.classes.of, seed=self.seed, limited=limited
        )  # fmt: skip

    def _on_map(
        self, start: PathEnd, goal: PathEnd, more: Callable[[], bool]
    ) -> tuple[Guide | None, Array | None]:
        """Return a path on a map of values or poses, if one is found while there is time."""
        if self.machine.moves:
            # Random poses change what must stay.
            turns = self._parameters(start, goal)
            level = not self.machine.shared or (turns[0][3:] == turns[1][3:]).all()
            on_map = self.along != "values" and not self.stays and level
            return _first([self._on_poses(start, goal)], more) if on_map else (None, None)
        ranged = self.values(start).ranged
        if (self.along or ("values" if ranged else "poses")) == "values":
            return _first([self._on_values(start, goal)], more)
        searches = [self._on_poses(start, goal)]
        if ranged:
            searches.insert(0, self._near_values(start, goal))
        return _first(searches, more)

    def _on_nodes(self, found: Map) -> Search:
        """Search on a map for ways from its first node to the second."""
        guide = found.guide(0, 1)
        while True:
            nodes = found.way(0, 1)
            if nodes is None:
                yield None
                found.grow()
                continue
            corners = found.corners(nodes)
            if guide.trace(corners, np.full(len(corners) - 1, PROVED_ROWS)) is not None:
                guide.widen(corners)
                yield guide, corners
            else:
                # If each edge is proved alone, all of them together are not: rounding at a corner.
                found.refuse(*(found.unproved(nodes) or nodes[:2]))
                yield None

    def _on_values(self, start: PathEnd, goal: PathEnd) -> Search:
        """Search on a map of values."""
        return self._on_nodes(self.value_map((start, goal)))

    def _near_values(self, start: PathEnd, goal: PathEnd) -> Search:
        """Search on a map of values; straight ways of poses lead along the way that it has."""
        poses, ends = self.pose_guide(), self._parameters(start, goal)
        for found in self._on_values(start, goal):
            if found is None:
                yield None
                continue
            guide, corners = found
            for finer in _FINER:
                trace = guide.trace(corners, np.full(len(corners) - 1, finer * PROVED_ROWS))
                if trace is None:
                    return
                places = self.ways.continued(trace.rows.R, trace.rows.T)
                places = np.stack([ends[0], *places[1:-1], self.ways.nearest(places[-2], ends[1])])
                polygon = _polygon(poses, places)
                if polygon is not None:
                    yield poses, polygon
                    return

    def _on_poses(self, start: PathEnd, goal: PathEnd) -> Search:
        """Search on a map of poses."""
        found = self.pose_map((start, goal))
        found.join_given()
        yield from self._on_nodes(found)


def _polygon(guide: PoseGuide, places: Array) -> Array | None:
    """Return corners of a proved polygon through some places, long straight ways first."""
    corners, spans = [places[0]], [(0, len(places) - 1)]
    while spans:
        first, last = spans.pop()
        if guide.trace(places[[first, last]], _ROWS) is not None:
            corners.append(places[last])
        elif last - first == 1:
            return None
        else:
            middle = (first + last) // 2
            spans += [(middle, last), (first, middle)]
    return np.array(corners)


def _first(searches: list[Search], more: Callable[[], bool]) -> tuple[Guide | None, Array | None]:
    """Return what the first of some searches finds; all take turns while there is time.

    Which one it is does not depend on the time.
    """
    while True:
        for search in searches:
            found = next(search, None)
            if found is not None:
                return found
        if not more():
            return None, None


def _check_gap(instance: Instance, gap: float) -> None:
    """Raise `ArgumentError` if a gap cannot be kept along paths of a platform."""
    if not np.isfinite(gap):
        raise ArgumentError(f"found {gap}, expected a finite number", "gap")
    if instance.shapes is None:
        raise ArgumentError(NO_SHAPES, "gap")


def smoothed(instance: Instance, guide: Guide, corners: Array, seed: int) -> Array:
    """Return the corners of a path that costs less, shape (k, 6).

    Parameters
    ----------
    instance
        The platform.
    guide
        Proves paths.
    corners
        Those of a proved path.
    seed
        Of the tries.
    """
    draw = np.random.default_rng(seed)
    slow = bool(guide.clear) or guide.gap is not None
    corners = _cheaper(instance, guide, corners, draw, 1.0, _SLOW_TRIES if slow else _TRIES)
    for power in () if slow else _POWERS:
        if len(corners) == 2 or stretch(instance, guide, corners) <= LONG:
            break
        corners = _cheaper(instance, guide, corners, draw, power, _MORE)
    return corners


def stretch(instance: Instance, guide: Guide, corners: Array) -> float:
    """Return how many times a path is as long as the straight way."""
    trace = guide.trace(corners, np.full(len(corners) - 1, PROVED_ROWS))
    if trace is None:
        return 0.0
    ends = [0, -1]
    straight = float(steps(instance, trace.rows.R[ends], trace.rows.T[ends])[0])
    length = float(steps(instance, trace.rows.R, trace.rows.T).sum())
    return length / straight if straight > 0 else np.inf


def _cheaper(
    instance: Instance,
    guide: Guide,
    corners: Array,
    draw: np.random.Generator,
    power: float,
    tries: int,
) -> Array:
    """Return the corners of a path that costs less with a power of the condition number."""
    #: What straight parts cost whose poses are known without a proof.
    parts: dict[tuple[bytes, bytes], float] = {}

    def part(first: Array, last: Array) -> float | None:
        """Return the cost of a straight part; None if its poses depend on the parts before."""
        key = first.tobytes(), last.tobytes()
        if key not in parts:
            poses = guide.unproved(np.stack((first, last)), _ROWS)
            if poses is None:
                return None
            parts[key] = cost(instance, *poses, power)
        return parts[key]

    def value(tried: Array, below: float) -> float:
        """Return the cost of a path if it is proved and costs less, else infinity."""
        rows = np.full(len(tried) - 1, PROVED_ROWS)
        known = 0.0
        for first, last in pairwise(tried):
            one = part(first, last)
            if one is None:
                trace = guide.trace(tried, rows)
                found = (
                    np.inf if trace is None else cost(instance, trace.rows.R, trace.rows.T, power)
                )
                return found if found < below else np.inf
            known += one
            if not known < below:
                return np.inf
        return known if guide.trace(tried, rows) is not None else np.inf

    best = value(corners, np.inf)
    corners, best = _short_cuts(corners, best, value)
    for _ in range(tries):
        tried = _changed(guide, corners, draw)
        if tried is not None:
            new = value(tried, best * (1 - _WORTH))
            if new < np.inf:
                corners, best = tried, new
    return corners


def _short_cuts(
    corners: Array, best: float, value: Callable[[Array, float], float]
) -> tuple[Array, float]:
    """Leave out corners, the longest short cuts first, where that costs less."""
    begin = 0
    while begin + 2 < len(corners):
        for end in range(len(corners) - 1, begin + 1, -1):
            tried = np.concatenate((corners[: begin + 1], corners[end:]))
            new = value(tried, best * (1 - _WORTH))
            if new < np.inf:
                corners, best = tried, new
                break
        begin += 1
    return corners, best


def _changed(guide: Guide, corners: Array, draw: np.random.Generator) -> Array | None:
    """Return a random change of a path, or None if there is none of the sort drawn."""
    count, sort = len(corners), draw.random()
    noise = draw.normal(size=6) * guide.sizes
    width = float(draw.choice(_MOVES))
    if sort < 0.2:
        if count < 3:
            return None
        first = int(draw.integers(0, count - 2))
        last = int(draw.integers(first + 2, count))
        return np.concatenate((corners[: first + 1], corners[last:]))
    if sort < 0.45:
        if count < 3:
            return None
        # From a place on one part to a place on another.
        places = np.sort(draw.random(2) * (count - 1))
        i, j = places.astype(int).tolist()
        if i == j:
            return None
        parts = zip((i, j), places.tolist(), strict=True)
        ends = [
            guide.placed(corners[k] + (corners[k + 1] - corners[k]) * (x - k)) for k, x in parts
        ]
        return np.concatenate((corners[: i + 1], ends, corners[j + 1 :]))
    if sort < 0.85:
        if count < 3:
            return None
        k = int(draw.integers(1, count - 1))
        tried = corners.copy()
        tried[k] = guide.placed(tried[k] + noise * width)
        return tried
    k = int(draw.integers(0, count - 1))
    middle = (corners[k] + corners[k + 1]) / 2
    return np.insert(corners, k + 1, guide.placed(middle + noise * 0.1), axis=0)


def finished(
    given: Instance,
    guide: Guide,
    corners: Array,
    start: PathEnd,
    goal: PathEnd,
    limits: PathLimits | None = None,
) -> PlannedPath:
    """Return a path with its rows.

    Parameters
    ----------
    given
        The platform, with offsets of readings.
    guide
        Proves paths.
    corners
        Those of a proved path, shape (k + 1, 6).
    start, goal
        Its ends.
    limits
        Of speeds and accelerations, if the path has a time.

    Raises
    ------
    IncompleteError
        If the rows cannot be proved, though the path was.
    """
    proved = np.full(len(corners) - 1, PROVED_ROWS)
    trace = guide.trace(corners, proved)
    timing, t = None, None
    if trace is not None:
        length = Arrangement.of(given).length
        wanted = np.ceil(_lengths(given, trace) / (_STEP * length))
        counts = np.clip(wanted, _LEAST, _MOST).astype(np.int64)
        # Long steps near singular poses are not proved; those of the search are.
        for tried in (counts, np.maximum(counts, proved)):
            if limits is not None:
                found = timed(guide, corners, limits, tried)
                if found is not None:
                    trace, t, timing = found
                    break
            elif (rowed := guide.trace(corners, tried)) is not None:
                trace = rowed
                break
    if trace is None or (limits is not None and timing is None):
        raise IncompleteError("the path that was found could not be proved again: try another seed")
    rows = trace.rows
    # Those of drives take long.
    moves = rows.machine.moves
    if guide.clear or not moves:
        at, between = least_clearances(rows, guide.clear)
    else:
        at, between = np.zeros(len(rows.T)), np.zeros(len(rows.T) - 1)
    conditions = rows.conditions()
    gaps = None if guide.gap is None else least_gaps(rows, guide.gap)[1]
    first = np.searchsorted(trace.part, np.arange(len(trace.proofs)))
    last = np.append(first[1:], len(trace.part) - 1)
    lengths = _lengths(given, trace)
    parts = tuple(
        PathPart(
            int(a),
            int(b),
            int(trace.proofs[k]),
            float(lengths[k]),
            float(conditions[a : b + 1].max()),
            float(between[a:b].min()),
            gap=None if gaps is None else float(gaps[a:b].min()),
        )
        for k, (a, b) in enumerate(zip(first.tolist(), last.tolist(), strict=True))
    )
    return PlannedPath(
        given, start.name, goal.name, "proved", "", guide.along,
        trace.part + trace.fraction if t is None else t,
        rows.values, rows.R, rows.T, conditions, at, parts, timing,
        rows.drive_numbers() if moves else None,
        None if gaps is None else ComparedShapes(given).gaps(rows.R, rows.T).min(axis=1),
    )  # fmt: skip


def _lengths(instance: Instance, trace: GuideRows) -> Array:
    """Return the length of each straight part."""
    moved = steps(instance, trace.rows.R, trace.rows.T)
    return np.asarray(
        np.bincount(trace.part[:-1], weights=moved, minlength=len(trace.proofs)), float
    )


@dataclass(frozen=True, eq=False)
class ModeGroup:
    """One mode among the others."""

    #: Its number.
    mode: int
    #: The proved signs of det J and of its factors, such as ``+-``.
    signs: str
    #: The smallest number of the modes that it is joined with by proved paths; None if the mode
    #: does not keep the limits.
    group: int | None
    #: Whether it is proved that no path within the ranges leads to any other mode.
    alone: bool
    #: The first limit that the mode violates, in words; empty if it keeps all.
    left: str


@dataclass(frozen=True, eq=False)
class ModeGroups(Tabular):
    """All modes of a platform in groups."""

    #: The platform.
    instance: Instance
    #: What the signs are of, in words.
    names: tuple[str, ...]
    #: The modes, in the order of `solve`.
    modes: tuple[ModeGroup, ...]
    #: Pairs of groups of which it is not known whether a path joins them.
    undecided: tuple[tuple[int, int], ...]

    def __repr__(self) -> str:
        kinds = self.instance.name or self.instance.type.id
        modes = counted(len(self.modes), "mode")
        return f"<ModeGroups of {kinds}: {modes}, {counted(len(self.groups), 'group')}>"

    @property
    def groups(self) -> dict[int, list[int]]:
        """The numbers of the modes of each group, by the smallest of them."""
        found: dict[int, list[int]] = {}
        for one in self.modes:
            if one.group is not None:
                found.setdefault(one.group, []).append(one.mode)
        return found

    @property
    def complete(self) -> bool:
        """Whether all pairs of groups are proved to be apart."""
        return not self.undecided

    def rows(self) -> list[dict[str, Any]]:
        """Return a row for each mode, as plain data."""
        unknown = {group for pair in self.undecided for group in pair}
        return [
            {
                "mode": one.mode,
                "signs": one.signs,
                "group": one.group,
                "others": [k for k in self.groups.get(one.group or 0, []) if k != one.mode],
                "alone": one.alone,
                "apart": one.group is not None and one.group not in unknown,
                "left": one.left or None,
            }
            for one in self.modes
        ]

    def to_json(self) -> dict[str, Any]:
        """Return everything as plain data of schema ``gsp.path/1``."""
        return {
            "schema": "gsp.path/1",
            **self.instance.to_json(),
            "complete": self.complete,
            "signs_of": list(self.names),
            "modes": self.rows(),
            "groups": list(self.groups.values()),
            "undecided": [list(pair) for pair in self.undecided],
        }


def mode_groups(
    instance: Instance, *, along: str | None = None, time: float = PATH_SECONDS, seed: int = SEED
) -> ModeGroups:
    """Return which assembly modes belong together, joined by proved paths.

    Parameters and errors are those of `gspcli.path`.

    Examples
    --------
    >>> import gspcli
    >>> gspcli.motion.mode_groups(gspcli.example("rubin-m2"))
    <ModeGroups of Rubin Observatory M2 hexapod: 2 modes, 2 groups>
    """
    planner = Planner(instance, along=along, seconds=time, seed=seed)
    deadline = monotonic() + time
    ends = Modes(planner.given).all()
    classes = [planner.classes.of(end.R, end.T) for end in ends]
    left = [planner.left(end) for end in ends]
    inside = [k for k, reason in enumerate(left) if not reason]
    alone = {k for k in inside if planner.fills_ranges(ends[k])}
    joined = Connections()
    for _ in ends:
        joined.add()
    open_ = [k for k in inside if k not in alone]
    _join(planner, ends, classes, open_, joined, deadline)
    group = {k: min(j for j in inside if joined.joined(j, k)) for k in inside}
    modes = tuple(
        ModeGroup(k + 1, classes[k].text, group[k] + 1 if k in group else None, k in alone, left[k])
        for k in range(len(ends))
    )
    firsts = sorted({group[k] for k in open_})
    undecided = tuple(
        (i + 1, j + 1)
        for a, i in enumerate(firsts)
        for j in firsts[a + 1 :]
        if not _groups_differ(classes, group, i, j)
    )
    names = tuple(planner.classes.name(k) for k in range(len(planner.classes.factors) + 1))
    return ModeGroups(planner.given, names, modes, undecided)


def _groups_differ(classes: list[PoseClass], group: dict[int, int], i: int, j: int) -> bool:
    """Whether any mode of a group is proved to be of another class than one of another group."""
    first, second = ([k for k, g in group.items() if g == one] for one in (i, j))
    return any(classes[a].differs(classes[b]) is not None for a in first for b in second)


def _join(
    planner: Planner,
    ends: list[PathEnd],
    classes: list[PoseClass],
    open_: list[int],
    joined: Connections,
    deadline: float,
) -> None:
    """Join modes on a map of poses, or on a map of values for each choice of sides of planes."""
    machine = planner.machine
    ranged = not machine.moves and bool(open_) and planner.values(ends[open_[0]]).ranged
    sides: dict[bytes, list[int]] = {}
    for k in open_:
        sides.setdefault(np.sign(ends[k].values).tobytes(), []).append(k)
    if planner.along != "poses" and ranged:
        for members in sides.values():
            found = planner.value_map([ends[k] for k in members])
            _grow(found, _tried_pairs(classes, members), deadline)
            _take(found, members, joined)
        return
    if len(open_) < 2:
        return
    poses = planner.pose_map([ends[k] for k in open_])
    # Random poses change what must stay. Modes differ in last digits of their orientation.
    grows = not (machine.shared or planner.stays)
    _grow(poses, _tried_pairs(classes, open_), deadline if grows else 0.0)
    _take(poses, open_, joined)


def _grow(found: Map, tried: list[tuple[int, int]], deadline: float) -> None:
    """Let a map grow until all pairs are joined, or until a deadline."""
    found.join_given()
    while monotonic() < deadline and not found.all_joined(tried):
        found.grow()


def _take(found: Map, members: list[int], joined: Connections) -> None:
    """Join the modes that a map joins."""
    for i, a in enumerate(members):
        for j in range(i):
            if found.joined(i, j):
                joined.join(a, members[j])


def _tried_pairs(classes: list[PoseClass], members: list[int]) -> list[tuple[int, int]]:
    """Return the pairs of places in a list of modes that are not proved to be apart."""
    return [
        (i, j)
        for i, a in enumerate(members)
        for j, b in enumerate(members[:i])
        if classes[a].differs(classes[b]) is None
    ]


#: A map grows so often at most: by sets of values with all their poses, or by poses.
_VALUE_STEPS, _POSE_STEPS = 48, 240
#: It grows so often in any case, so that there are poses elsewhere than at the values of the file.
_VALUE_LEAST, _POSE_LEAST = 3, 40
#: This many poses are kept besides those on ways from other modes, and at most in all.
_SPREAD, _MOST_POSES = 16, 80
#: Straight ways of poses are kept in this many parts, which are nearly as straight for any angles.
_HOME_PARTS = 3


class HomeMap(NamedTuple):
    """Poses from which ways lead home."""

    R: Array
    """Shape (n, 3, 3); home is the first."""
    T: Array
    """Shape (n, 3)."""
    after: NDArray[np.int64]
    """The next pose on the way home, shape (n,); that of home is 0."""


def home_map(result: SolveResult, home: int) -> HomeMap | None:
    """Return a map of poses from which proved straight ways lead to a mode.

    Parameters
    ----------
    result
        The platform, solved.
    home
        The index of the mode that is home.

    Returns
    -------
    HomeMap or None
        None if home is the only pose of it, or violates a limit; and if home fills its box of
        ranges, so that all straight ways of values in it lead home.

    Raises
    ------
    GspError
        If nothing can be planned for this platform.
    """
    planner = Planner(result.instance, seed=SEED)
    ends = Modes(result.instance, result).all()
    if planner.left(ends[home]) or planner.fills_ranges(ends[home]):
        return None
    goal = planner.classes.of(ends[home].R, ends[home].T)
    ranged = not planner.machine.moves and planner.values(ends[home]).ranged
    members = [ends[home]]
    for k, end in enumerate(ends):
        if k == home or planner.left(end) or (ranged and not _on_one_side(end, ends[home])):
            continue
        if planner.classes.of(end.R, end.T).differs(goal) is None:
            members.append(end)
    found = planner.value_map(members) if ranged else planner.pose_map(members)
    found.join_given()
    if not (planner.machine.shared or planner.stays):
        _grow_for_home(found, len(members))
    return _kept(found, len(members))


def _on_one_side(first: PathEnd, second: PathEnd) -> bool:
    return bool((np.sign(first.values) == np.sign(second.values)).all())


def _grow_for_home(found: Map, members: int) -> None:
    """Let a map grow until all modes are joined with home, or for some steps."""
    by_values = isinstance(found, ValueMap)
    least = _VALUE_LEAST if by_values else _POSE_LEAST
    for step in range(_VALUE_STEPS if by_values else _POSE_STEPS):
        if step >= least and found.all_joined((0, k) for k in range(members)):
            return
        found.grow()


def _kept(found: PoseMap | ValueMap, members: int) -> HomeMap | None:
    """Return what is kept of a map: ways of the modes, and of poses far from each other."""
    after: dict[int, int] = {0: 0}
    for node in list(_spread(found, members)):
        if len(after) >= _MOST_POSES:
            break
        while (way := found.way(node, 0)) is not None:
            # Edges of maps of poses are proved with their limits.
            looked = isinstance(found, ValueMap) and found.ways.cones
            new = [*takewhile(lambda a: a not in after, way)]
            bad = found.unproved(way[: len(new) + 1]) if looked else None
            if bad is None:
                for a, b in pairwise(way):
                    after.setdefault(a, b)
                break
            found.refuse(*bad)
    return _numbered(found, after) if len(after) > 1 else None


def _spread(found: Map, members: int) -> Iterator[int]:
    """Yield the modes that are joined with home, then poses far from those before."""
    joined = [k for k in range(1, len(found)) if found.joined(0, k)]
    modes = [k for k in joined if k < members]
    yield from modes
    others = [k for k in joined if k >= members]
    if not others:
        return
    # Poses as points: rotations, and positions in their largest distance.
    R, T = found.poses(range(len(found)))
    size = float(np.ptp(T, axis=0).max()) or 1.0
    places = np.concatenate((R.reshape(-1, 9), T / size), axis=1)
    away = np.min([np.linalg.norm(places[others] - places[k], axis=1) for k in [0, *modes]], axis=0)
    for _ in range(min(_SPREAD, len(others))):
        k = int(away.argmax())
        yield others[k]
        away = np.minimum(away, np.linalg.norm(places[others] - places[others[k]], axis=1))


def _numbered(found: PoseMap | ValueMap, after: dict[int, int]) -> HomeMap:
    """Return the poses that are kept, with poses between them on ways of poses."""
    nodes = sorted(after)
    place = {node: k for k, node in enumerate(nodes)}
    R, T = found.poses(nodes)
    to = [place[after[node]] for node in nodes]
    if isinstance(found, ValueMap):
        return HomeMap(R, T, np.array(to))
    more: list[Array] = []
    for node in nodes[1:]:
        begin = found.nodes[node]
        way = found.ways.nearest(begin, found.nodes[after[node]]) - begin
        last = to[place[node]]
        for part in range(_HOME_PARTS - 1, 0, -1):
            more.append(begin + way * (part / _HOME_PARTS))
            to.append(last)
            last = len(nodes) + len(more) - 1
        to[place[node]] = last
    R_more, T_more = found.ways.poses(np.array(more))
    return HomeMap(np.concatenate((R, R_more)), np.concatenate((T, T_more)), np.array(to))
