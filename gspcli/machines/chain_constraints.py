"""The constraints that a chain of joints holds while its drives are held.

There is no table of chains. A chain whose passive screws have rank r holds 6 - r constraints. They
are distances and angles of primitives of its joints that stay the same over random finite motions:
the first with independent gradients, in the order of `kinds.ORDER`.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.geometry.tolerances import MEASURED_PARALLEL_SINE, PARALLEL_SINE
from gspcli.machines.graph import Part, frame, inverse, place, scaled, turn
from gspcli.machines.structure import BodyChain
from gspcli.records import dataclass

# What points, lines and planes of a chain's joints measure while the chain moves.
#
# A primitive is a point and a direction: of a point the direction is not used.


#: The kinds that are looked for, in this order. A chain that holds an angle of a line or plane
#: holds the angle of two lines, too: ALL stands for all four. DLL is the last: lines that are
#: parallel in one pose are held there by more than one constraint.
ORDER = ("DPP", "ALL", "DPL", "DLP", "DPH", "DHP", "DLL")


@dataclass(frozen=True, eq=False)
class Primitives:
    """Points or lines or planes of one body.

    Attributes
    ----------
    points
        A point of each, shape (n, 3).
    directions
        The unit direction or normal of each, shape (n, 3); zeros for points.
    """

    points: Array
    directions: Array

    @staticmethod
    def of(points: list[Array], directions: list[Array] | None = None) -> Primitives:
        """Return primitives from lists."""
        made = np.array(points, float).reshape(-1, 3)
        if directions is None:
            return Primitives(made, np.zeros_like(made))
        return Primitives(made, np.array(directions, float).reshape(-1, 3))

    def __len__(self) -> int:
        return len(self.points)

    def moved(self, X: Array) -> Primitives:
        """Return them in another frame."""
        return Primitives(place(X, self.points), turn(X, self.directions))

    def one(self, index: int) -> Primitives:
        """Return one of them, still with an axis of length 1."""
        return Primitives(self.points[[index]], self.directions[[index]])


def measured(kind: str, platform: Primitives, base: Primitives, X: Array) -> Array:
    """Return the distances or angles of primitives at a pose.

    Parameters
    ----------
    kind
        One of `ORDER`.
    platform, base
        Those of the platform, in its frame, and of the base, in its own: n and m.
    X
        The pose of the platform, shape (4, 4).

    Returns
    -------
    Array
        Shape (n, m). Angles are between 0 and pi; distances to planes are signed.
    """
    own = platform.moved(X)
    r = own.points[:, None] - base.points[None]
    u, v = own.directions[:, None], base.directions[None]
    if kind == "DPP":
        return np.asarray(np.linalg.norm(r, axis=-1))
    if kind == "DPL":
        return np.asarray(np.linalg.norm(np.cross(r, v), axis=-1))
    if kind == "DLP":
        return np.asarray(np.linalg.norm(np.cross(r, u), axis=-1))
    if kind == "DPH":
        return np.asarray((r * v).sum(axis=-1))
    if kind == "DHP":
        return np.asarray(-(r * u).sum(axis=-1))
    normal = np.cross(u, v)
    sine = np.linalg.norm(normal, axis=-1)
    if kind == "ALL":
        return np.asarray(np.arctan2(sine, (u * v).sum(axis=-1)))
    across = np.abs((r * normal).sum(axis=-1)) / np.where(sine > PARALLEL_SINE, sine, 1.0)
    apart = np.linalg.norm(np.cross(r, v), axis=-1)
    return np.asarray(np.where(sine > PARALLEL_SINE, across, apart))


#: Primitives that agree to this share of the size are one.
_SAME = 1e-9


@dataclass(frozen=True, eq=False)
class CandidatePrimitives:
    """Primitives of a chain in the configuration of the file, in the frame of the base.

    Attributes
    ----------
    centres
        Centres of balls and crossings of hinge axes: only these have distances of two points.
    points
        All points that can have a distance from a line or plane.
    lines
        The axes of hinges.
    directions
        Directions that can have angles: those of the lines.
    planes
        Normals, with any point: it is moved to where the distance is to be measured.
    """

    centres: Primitives
    points: Primitives
    lines: Primitives
    directions: Primitives
    planes: Primitives

    def pairs(self, kind: str) -> tuple[Primitives, Primitives]:
        """Return candidates for both primitives of a kind, platform's and base's, in one frame.

        The points of planes are not chosen yet.
        """
        sorts = {"P": self.points, "L": self.lines, "H": self.planes}
        if kind == "DPP":
            return self.centres, self.centres
        if kind == "ALL":
            return self.directions, self.directions
        return sorts[kind[1]], sorts[kind[2]]


def candidates(passive: list[Part], size: float, near: float) -> CandidatePrimitives:
    """Return the candidates of a chain.

    Parameters
    ----------
    passive
        Its parts that are not held, in the frame of the base.
    size
        The size of the chain.
    near
        Axes that pass each other at a smaller distance than this cross.
    """
    balls = [part.point for part in passive if part.letter == "S"]
    hinges = [part for part in passive if part.letter == "R"]
    slides = [part for part in passive if part.letter == "P"]
    same = _SAME * size
    centres = balls + [
        crossing
        for first, second in combinations(hinges, 2)
        if (crossing := _crossing(first, second, near)) is not None
    ]
    for hinge in hinges:
        centres += [hinge.point + hinge.axis * ((c - hinge.point) @ hinge.axis) for c in centres]
        centres = _different(centres, same)
    centres = _different(centres, same)
    further = [hinge.point for hinge in hinges]
    further += [hinge.point + size * hinge.axis for hinge in hinges]
    points = _different(centres + further + [slide.point for slide in slides], same)
    lines = [np.concatenate((_foot(hinge), hinge.axis)) for hinge in hinges]
    kept = _places(lines, same)
    normals = _normals(balls, hinges, slides) if passive else []
    normals = _different(normals, _SAME)
    directions = _different([hinge.axis for hinge in hinges], _SAME)
    return CandidatePrimitives(
        Primitives.of(centres),
        Primitives.of(points),
        Primitives.of([hinges[k].point for k in kept], [hinges[k].axis for k in kept]),
        Primitives.of([np.zeros(3)] * len(directions), directions),
        Primitives.of([np.zeros(3)] * len(normals), normals),
    )


def _normals(balls: list[Array], hinges: list[Part], slides: list[Part]) -> list[Array]:
    """Return normals of planes in which points may stay: of slides, of hinges and across them."""
    normals = [
        across / np.linalg.norm(across)
        for first, second in combinations(slides, 2)
        if np.linalg.norm(across := np.cross(first.axis, second.axis)) > MEASURED_PARALLEL_SINE
    ]
    normals += [hinge.axis for hinge in hinges]
    if len(balls) == 1 and not hinges and not slides:
        return list(np.eye(3))
    for part in [*hinges, *slides]:
        first = np.cross(part.axis, np.eye(3)[np.argmin(np.abs(part.axis))])
        first /= np.linalg.norm(first)
        normals += [first, np.cross(part.axis, first)]
    return normals


def _crossing(first: Part, second: Part, near: float) -> Array | None:
    """Return where two axes cross, if they do."""
    across = np.cross(first.axis, second.axis)
    length = float(np.linalg.norm(across))
    if length < MEASURED_PARALLEL_SINE:
        return None
    sides = np.array([first.axis, -second.axis, across]).T
    s, t, gap = np.linalg.solve(sides, second.point - first.point)
    if abs(gap) * length > near:
        return None
    middle: Array = (first.point + s * first.axis + second.point + t * second.axis) / 2
    return middle


def _foot(part: Part) -> Array:
    foot: Array = part.point - part.axis * (part.point @ part.axis)
    return foot


def _places(vectors: list[Array], same: float) -> list[int]:
    """Return the indices of the vectors that differ from all earlier ones."""
    kept: list[int] = []
    for k, vector in enumerate(vectors):
        if all(np.linalg.norm(vector - vectors[other]) > same for other in kept):
            kept.append(k)
    return kept


def _different(vectors: list[Array], same: float) -> list[Array]:
    return [vectors[k] for k in _places(vectors, same)]


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
                    R = rotation_from_vector(step * axis)
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
