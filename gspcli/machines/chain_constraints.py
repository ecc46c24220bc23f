"""The constraints that a chain of joints holds while its drives are held.

There is no table of chains. A chain whose passive screws have rank r holds 6 - r constraints. They
are distances and angles of primitives of its joints that stay the same over random finite motions:
the first with independent gradients, in the order of `kinds.ORDER`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.machines.candidates import CandidatePrimitives, candidates
from gspcli.machines.frames import about, frame, inverse
from gspcli.machines.graph import scaled
from gspcli.machines.kinds import ORDER, Primitives, measured
from gspcli.machines.structure import BodyChain
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: Random motions over which a constraint must hold, and configurations for the rank.
_MOTIONS, _CONFIGURATIONS = 8, 6
#: Singular values of screws up to this, or a tenth of the share up to which axes meet, are zero:
#: lengths are in units of the chain's size.
_NO_FREEDOM = 1e-6
#: Shares of the size up to which what is constant may change: rounding, then files of few digits.
_CHANGES = (1e-9, 1e-7, 1e-5)
#: Two gradients are independent if what one adds to the others is at least this share of it.
_INDEPENDENT = 1e-5
#: Distances of points below this share, and angles of lines (radians), are none: two or three
#: constraints in one.
_DEGENERATE = 1e-6
#: Step of difference quotients, as a share of the size, and in radians.
_STEP = 1e-6


@dataclass(frozen=True, eq=False)
class Held:
    """A constraint that a chain holds.

    Attributes
    ----------
    kind
        One of `kinds.ORDER`.
    platform, base
        One primitive each, in the frame of its body.
    value
        The distance, signed towards the normal of a plane, or the angle in radians.
    change
        The largest change of the value over random motions.
    """

    kind: str
    platform: Primitives
    base: Primitives
    value: float
    change: float


def held_constraints(chain: BodyChain, meet: float) -> tuple[list[Held], int]:
    """Return the constraints that were found, and how many the chain holds.

    Parameters
    ----------
    chain
        The chain, with its drives held.
    meet
        The share of the size up to which axes meet and constants may change.
    """
    rng = np.random.default_rng(1)
    size = chain.size
    count = 6 - _rank(chain, size, max(_NO_FREEDOM, meet / 10), rng)
    if count == 0:
        return [], 0
    rest = random_changes(chain, size, None)
    motions = [moved(chain, rest)]
    motions += [moved(chain, random_changes(chain, size, rng)) for _ in range(_MOTIONS)]
    passive = [p.part for p in chain.parts if not p.held]
    found = candidates(passive, size, near=max(meet, 1e-9) * size)
    search = _Search(motions, size, count)
    for change in sorted({*_CHANGES, max(meet, _CHANGES[0])}):
        search.run(found, change)
        if len(search.held) == count or change >= meet:
            break
    return search.held, count


def random_changes(
    chain: BodyChain, size: float, rng: np.random.Generator | None
) -> list[Array | float]:
    """Return changes of all coordinates: zero for held ones, random or zero for the others."""
    changes: list[Array | float] = []
    for p in chain.parts:
        ball = p.part.letter == "S"
        if p.held or rng is None:
            changes.append(np.zeros(3) if ball else 0.0)
        elif ball:
            changes.append(0.6 * rng.normal(size=3))
        else:
            changes.append(float(rng.uniform(-1, 1)) * (size / 2 if p.part.letter == "P" else 1.0))
    return changes


def moved(chain: BodyChain, changes: list[Array | float]) -> Array:
    """Return the pose of the platform after changes of the coordinates, shape (4, 4)."""
    X = np.eye(4)
    for p, change in zip(chain.parts, changes, strict=True):
        X = X @ p.part.motion(change)
    moved: Array = X @ chain.pose
    return moved


def pose_after(chain: BodyChain, place: int, change: float) -> Array:
    """Return the pose of the platform after the change of one coordinate, shape (4, 4)."""
    changes = random_changes(chain, 1.0, None)
    changes[place] = change
    return moved(chain, changes)


def _rank(chain: BodyChain, size: float, least: float, rng: np.random.Generator) -> int:
    """Return how many freedoms the platform has in the chain, in general configurations.

    Singular values of the screws up to `least` count as zero.
    """
    ranks = []
    centre = np.mean([p.part.point for p in chain.parts], axis=0)
    for _ in range(_CONFIGURATIONS):
        X, screws = frame(T=-centre), [np.zeros((0, 6))]
        for p, change in zip(chain.parts, random_changes(chain, size, rng), strict=True):
            if not p.held:
                screws.append(scaled(p.part.moved(X), size).screws)
            X = X @ p.part.motion(change)
        values = np.linalg.svd(np.concatenate(screws), compute_uv=False)
        ranks.append(int((values > least).sum()))
    return max(ranks)


def _through_points(kind: str, platform: Primitives, base: Primitives, X: Array) -> Array:
    """Return distances to planes, each of which goes through the point at the first pose.

    They differ from those of `measured` by a constant, shape (n, m).
    """
    own = platform.moved(X)
    if kind == "DPH":
        return np.asarray(own.points @ base.directions.T)
    return np.asarray(own.directions @ base.points.T - (own.directions * X[:3, 3]).sum(1)[:, None])


class _Search:
    """What is constant over some poses.

    Parameters
    ----------
    motions
        Poses of the platform, that of the file first.
    size
        The size of the chain.
    count
        How many constraints there are.
    """

    def __init__(self, motions: list[Array], size: float, count: int) -> None:
        self.motions, self.size, self.count = motions, size, count
        self.held: list[Held] = []
        self.gradients: list[Array] = []

    def run(self, found: CandidatePrimitives, change: float) -> None:
        """Add what changes by at most a share of the size, until there are enough."""
        back = inverse(self.motions[0])
        for kind in ORDER:
            there, fixed = found.pairs(kind)
            own = there.moved(back)
            values = _through_points if "H" in kind else measured
            measures = np.array([values(kind, own, fixed, X) for X in self.motions])
            changes = np.ptp(measures, axis=0) / (1.0 if kind[0] == "A" else self.size)
            for i, j in np.argwhere(changes <= change):
                value = 0.0 if "H" in kind else float(measures[0, i, j])
                if self._degenerate(kind, value):
                    continue
                pair = own.one(i), fixed.one(j)
                if kind == "DPH":
                    pair = pair[0], Primitives(there.points[[i]], pair[1].directions)
                elif kind == "DHP":
                    through = Primitives(fixed.points[[j]], there.directions[[i]])
                    pair = through.moved(back), pair[1]
                gradient = self._gradient(kind, *pair)
                if self._adds(gradient):
                    self.gradients.append(gradient)
                    moved = float(np.ptp(measures[:, i, j]))
                    self.held.append(Held(kind, *pair, value, moved))
                    if len(self.held) == self.count:
                        return

    def _degenerate(self, kind: str, value: float) -> bool:
        if kind == "DPP":
            return abs(value) < _DEGENERATE * self.size
        return kind == "ALL" and min(value, np.pi - value) < _DEGENERATE

    def _gradient(self, kind: str, platform: Primitives, base: Primitives) -> Array:
        """Return the derivatives by a twist, at the third random pose, shape (6,)."""
        X = self.motions[3]
        gradient = np.zeros(6)
        for k, axis in enumerate((*np.eye(3), *np.eye(3))):
            ends = []
            for step in (_STEP, -_STEP):
                if k < 3:
                    R = about(axis, step)
                    moved = frame(R @ X[:3, :3], X[:3, 3])
                else:
                    moved = frame(X[:3, :3], X[:3, 3] + step * self.size * axis)
                ends.append(float(measured(kind, platform, base, moved)[0, 0]))
            gradient[k] = (ends[0] - ends[1]) / (2 * _STEP)
        return gradient if kind[0] == "A" else gradient / self.size

    def _adds(self, gradient: Array) -> bool:
        length = float(np.linalg.norm(gradient))
        if not length > 0:
            return False
        rows = np.array([*self.gradients, gradient])
        rows /= np.linalg.norm(rows, axis=1, keepdims=True)
        return float(np.linalg.svd(rows, compute_uv=False)[-1]) > _INDEPENDENT
