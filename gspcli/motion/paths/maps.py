"""Maps of poses, or of sets of values with all their poses, and proved straight ways between them.

In a map of poses ways are sampled first, since that takes less time than a proof of a way that is
singular. Only proved ways count. In a map of values all real poses for each set of values are
found. Each of them is followed along the straight ways to the nearest other sets; where it arrives
it is joined, by proof, with the pose there.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.limits import cone_shares
from gspcli.geometry.measurement import jacobian
from gspcli.geometry.quaternions import apply, cross
from gspcli.motion.paths.planned_paths import WayCosts
from gspcli.motion.paths.pose_ways import PoseWays
from gspcli.motion.paths.value_ways import ValueWays
from gspcli.solver import solve_batch

Array = NDArray[np.float64]
#: Samples of a way, and how near to zero a determinant may come there, by its size at the ends.
_SAMPLES, _NEAR = 48, 0.01
#: Random poses are near a given one in this many cases of ten; how far, in lengths and radians.
_NEARBY, _FAR, _TURN = 5, 0.6, 0.8
#: To how many near nodes, and to how many of each part, a new node is joined.
_NEIGHBOURS, _PARTS, _OTHERS = 10, 24, 5
#: A pose with a smaller determinant is climbed from first: this many small random steps.
_FLAT, _STEPS, _TRIES = 2e-3, 40, 24
#: Numbers of random poses and values are rounded to this part of their size or range, so that
#: files are short and do not depend on last digits.
_DIGITS = 6
#: Sets of values that are solved at a time, and to how many near ones each is joined.
_BATCH, _NEIGHBOURS = 16, 6
#: Random values keep this part of the range away from its ends.
_MARGIN = 1e-3
#: Values that a pose measures differ by less from those that it was solved for.
_SOLVED = 1e-6
#: In how many places cones are tested before they are proved.
_LOOKS = 12


class PoseMap:
    """A map of poses of one platform.

    Parameters
    ----------
    ways
        Straight ways of the platform.
    R, T
        The poses that are to be joined, shapes (n, 3, 3) and (n, 3): nodes 0 to n - 1.
    classes
        A class for each; nodes of different classes are never joined.
    class_of
        The class of a pose (R, T).
    seed
        Of the random poses.
    kept
        Whether poses keep the limits, ``(n, 3, 3), (n, 3) -> (n,)``.
    """

    def __init__(
        self,
        ways: PoseWays,
        R: Array,
        T: Array,
        classes: Sequence[object],
        class_of: Callable[[Array, Array], object],
        *,
        seed: int,
        kept: Callable[[Array, Array], Any] | None = None,
    ) -> None:
        self.ways, self._class_of, self._kept = ways, class_of, kept
        # Rods that share a drive are parallel at one orientation only.
        self._keeps_turn = ways.machine.shared
        self.arrangement = Arrangement.of(ways.boxes.instance)
        self.nodes = [*ways.parameters(R, T)]
        self.classes = list(classes)
        self.connections = Connections()
        self._costs = WayCosts(ways.boxes.instance)
        self._costs.add(*ways.poses(np.array(self.nodes)))
        for _ in self.nodes:
            self.connections.add()
        self.count = len(self.nodes)
        self._random = np.random.default_rng(seed)
        self._signs = [float(np.sign(d)) for d in self.determinants(np.array(self.nodes)).tolist()]
        places = np.array(self.nodes)[:, :3]
        self._span = float(np.ptp(places, axis=0).max()) + self.arrangement.length
        self._refused: set[tuple[int, int]] = set()
        #: Ways that were tried and refused.
        self.refused = 0

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

    def way(self, first: int, last: int) -> list[Array] | None:
        """Return the parameters along a proved way between two nodes; None if there is none.

        Each is continued from the one before: angles by whole turns.
        """
        nodes = self.connections.way(first, last)
        if nodes is None:
            return None
        found = [self.nodes[nodes[0]]]
        for node in nodes[1:]:
            found.append(self.ways.nearest(found[-1], self.nodes[node]))
        return found

    def refuse_on_way(self, first: int, last: int, proved: Callable[[Array], bool]) -> None:
        """Remove the first edge of a way that ``proved`` does not accept; if none, its first."""
        nodes = self.connections.way(first, last)
        assert nodes is not None
        for a, b in pairwise(nodes):
            begin = self.nodes[a]
            if not proved(np.stack((begin, self.ways.nearest(begin, self.nodes[b])))):
                self._refuse(a, b)
                return
        # Each is proved alone, and all of them together are not: by angles that are continued.
        self._refuse(nodes[0], nodes[1])

    def _refuse(self, a: int, b: int) -> None:
        self._refused.add((min(a, b), max(a, b)))
        self.connections.remove(a, b)

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
        if self._kept is not None and not self._kept(R[None], T[None])[0]:
            return None
        d = float(self.determinants(one[None])[0])
        if not d:
            return None
        self.nodes.append(one)
        self.classes.append(self._class_of(R, T))
        self._signs.append(float(np.sign(d)))
        self._costs.add(R[None], T[None])
        return self.connections.add()

    def _alike(self, i: int, j: int) -> bool:
        return self._signs[i] == self._signs[j] and not _apart(self.classes[i], self.classes[j])

    def _distances(self, k: int, others: list[int]) -> Array:
        there = np.array([self.nodes[i] for i in others])
        away = self.ways.nearest(self.nodes[k], there) - self.nodes[k]
        size = np.array([self._span] * 3 + [1.0] * 3)
        return np.asarray(np.linalg.norm(away / size, axis=1))

    def _join(self, pairs: list[tuple[int, int]]) -> None:
        """Prove ways between nodes that are not joined yet."""
        open_ = [
            (i, j)
            for i, j in pairs
            if self._alike(i, j)
            and not self._joined(i, j)
            and (min(i, j), max(i, j)) not in self._refused
        ]
        if not open_:
            return
        begins = np.array([self.nodes[i] for i, _ in open_])
        ends = self.ways.nearest(begins, np.array([self.nodes[j] for _, j in open_]))
        for (i, j), begin, end, good in zip(
            open_, begins, ends, self._sampled(begins, ends), strict=True
        ):
            if good and not self._joined(i, j):
                self._try(i, j, begin, end)

    def _joined(self, i: int, j: int) -> bool:
        return self.connections.joined(i, j)

    def _try(self, i: int, j: int, begin: Array, end: Array) -> bool:
        proof = self.ways.prove(begin, end)
        if not proof.sign:
            self.refused += 1
            return False
        self.connections.join(i, j, self._costs.between(i, j))
        return True

    def _sampled(self, begins: Array, ends: Array) -> NDArray[np.bool_]:
        """Return which ways keep the sign of the determinant at samples, and the limits."""
        parts = np.linspace(0, 1, _SAMPLES)[:, None]
        between = begins[:, None] * (1 - parts) + ends[:, None] * parts
        flat = between.reshape(-1, 6)
        found = self.determinants(flat).reshape(len(begins), -1)
        found = found * np.sign(found[:, :1])
        good = found.min(axis=1) > _NEAR * np.minimum(found[:, 0], found[:, -1])
        good &= np.abs(np.diff(found, axis=1)).max(axis=1) < 2 * np.abs(found).max(axis=1)
        if self._kept is not None:
            kept = self._kept(*self.ways.poses(flat)).reshape(len(begins), -1)
            good &= kept.all(axis=1)
        return np.asarray(good)

    def _climb(self, k: int) -> None:
        """From a pose that is nearly singular go to one that is less so, by proved steps."""
        here, size = k, np.array([self._span] * 3 + [1.0] * 3)
        for step in range(_STEPS):
            best = abs(float(self.determinants(self.nodes[here][None])[0]))
            if best > _FLAT:
                return
            width = 0.1 * 0.5 ** (step % 4)
            tries = self.nodes[here] + self._random.normal(size=(_TRIES, 6)) * size * width
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


def _apart(a: object, b: object) -> bool:
    """Whether two classes are proved to differ."""
    differs = getattr(a, "differs", None)
    return differs is not None and differs(b) is not None


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


class ValueMap:
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
    """

    def __init__(
        self, ways: ValueWays, instance: Instance, values: Array, R: Array, T: Array, *, seed: int
    ) -> None:
        self.ways, self.instance = ways, instance
        self.connections = Connections()
        self.count = len(values)
        self._random = np.random.default_rng(seed)
        self._sets: list[Array] = []
        self._members: list[list[int]] = []
        self.points: list[Array] = []
        self.values: list[Array] = []
        self._costs = WayCosts(instance)
        self._add(values, ways.points(R, T))
        low, high, size = ways.low, ways.high, np.abs(values[0])
        self._low = np.where(np.isfinite(low), low, values[0] - 0.5 * size)
        self._high = np.where(np.isfinite(high), high, values[0] + 0.5 * size)
        self._refused: set[tuple[int, int]] = set()

    def _add(self, values: Array, points: Array) -> list[int]:
        """Add poses with their values; return the numbers of their sets."""
        found: list[int] = []
        for row, point in zip(values, points, strict=True):
            if not self._sets or not np.array_equal(self._sets[-1], row):
                self._sets.append(row)
                self._members.append([])
            if not found or found[-1] != len(self._sets) - 1:
                found.append(len(self._sets) - 1)
            self._members[-1].append(self.connections.add())
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
                good &= (cone_shares(self.instance, R, T) <= 1).all(axis=1)
            R, T = R[good], T[good]
            if len(R):
                sets += self._add(np.tile(row, (len(R), 1)), self.ways.points(R, T))
        every, size = np.array(self._sets), self._high - self._low
        size = np.where(size > 0, size, 1.0)
        given = {self._set_of(k) for k in range(self.count)}
        pairs = []
        for i in sets:
            away = np.linalg.norm((every[:i] - every[i]) / size, axis=1)
            near = np.argsort(away, kind="stable")[:_NEIGHBOURS].tolist()
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
            p, node, j = starts[k]
            there = np.array([self.points[other] for other in self._members[j]])
            same = np.flatnonzero(self.ways.same(there, found.points[k, -1]))
            if len(same) != 1:
                continue
            other = self._members[j][int(same[0])]
            if (min(node, other), max(node, other)) in self._refused:
                continue
            if self._looks_kept(ways[p], points[k], found.points[k, -1]):
                self.connections.join(node, other, self._costs.between(node, other))

    def _looks_kept(self, way: Array, first: Array, last: Array) -> bool:
        """Whether samples near a way keep the cones; of ways that are used it is proved."""
        del way
        if not self.ways.cones:
            return True
        last = last if first @ last > 0 else -last
        parts = np.linspace(0, 1, _LOOKS)[:, None]
        R, T = self.ways.poses(first * (1 - parts) + last * parts)
        return bool((cone_shares(self.instance, R, T) <= 1).all())

    def way(self, first: int, last: int) -> Array | None:
        """Return the values along a way from one given pose to another, shape (k, 6), or None."""
        nodes = self.connections.way(first, last)
        return None if nodes is None else np.array([self.values[node] for node in nodes])

    def nodes(self, first: int, last: int) -> list[int] | None:
        """Return the nodes of that way."""
        return self.connections.way(first, last)

    def refuse(self, first: int, second: int) -> None:
        """Take an edge away for good, since it violates what else is required."""
        self._refused.add((min(first, second), max(first, second)))
        self.connections.remove(first, second)
