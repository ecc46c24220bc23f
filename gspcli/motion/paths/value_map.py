"""A map of values: sets of values with all their poses, and modes followed between them.

For each set of values all real poses are found. Each of them is followed along the straight ways to
the nearest other sets; where it arrives it is joined, by proof, with the pose there.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.instance import Instance
from gspcli.geometry.limits import cone_shares
from gspcli.motion.paths.connections import Connections
from gspcli.motion.paths.value_ways import ValueWays
from gspcli.motion.paths.way_costs import WayCosts
from gspcli.solver import solve_batch

Array = NDArray[np.float64]

#: Sets of values that are solved at a time, and to how many near ones each is joined.
_BATCH, _NEIGHBOURS = 16, 6
#: Random values keep this part of the range away from its ends.
_MARGIN = 1e-3
#: Numbers of random values are rounded to this part of the range, so that files are short and do
#: not depend on last digits.
_DIGITS = 6
#: Values that a pose measures differ by less from those that it was solved for.
_SOLVED = 1e-6
#: In how many places cones are tested before they are proved.
_LOOKS = 12


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
