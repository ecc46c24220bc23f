"""A map of poses: given and random ones, and straight ways between them that are proved.

Ways are sampled first, since that takes less time than a proof of a way that is singular. Only
proved ways count.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.measurement import jacobian
from gspcli.geometry.quaternions import apply, cross
from gspcli.motion.paths.connections import Connections
from gspcli.motion.paths.pose_ways import PoseWays
from gspcli.motion.paths.way_costs import WayCosts

Array = NDArray[np.float64]

#: Samples of a way, and how near to zero a determinant may come there, by its size at the ends.
_SAMPLES, _NEAR = 48, 0.01
#: Random poses are near a given one in this many cases of ten; how far, in lengths and radians.
_NEARBY, _FAR, _TURN = 5, 0.6, 0.8
#: To how many near nodes, and to how many of each part, a new node is joined.
_NEIGHBOURS, _PARTS, _OTHERS = 10, 24, 5
#: A pose with a smaller determinant is climbed from first: this many small random steps.
_FLAT, _STEPS, _TRIES = 2e-3, 40, 24
#: Numbers of random poses are rounded to this part of their size, so that files are short and do
#: not depend on last digits.
_DIGITS = 6


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
        self._keeps_turn = ways.motors is not None and ways.motors.shared
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
