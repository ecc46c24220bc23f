"""Recognizes a graph as a platform with six constraints, or says what it is instead.

There is no table of chains. The drives are held, and bodies that then do not move against each
other are one body. Two bodies on which three or more chains end are the base and the platform.
A chain whose passive screws have rank r holds 6 - r constraints: distances and angles of primitives
of its joints that stay the same over random finite motions, the first with independent gradients in
the order of `ORDER`. Six constraints are a platform. If the file does not name drives, the usual
ones are tried, and the notes say which.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import replace
from itertools import combinations, pairwise

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import KINDS_BY_NAME
from gspcli.defaults import MEETING_SHARE
from gspcli.geometry.arrangement import Bodies
from gspcli.geometry.measurement import jacobian
from gspcli.geometry.measurement import measured as values_of_pairs
from gspcli.geometry.tolerances import MEASURED_PARALLEL_SINE
from gspcli.machines.graph import (
    Graph,
    Joint,
    NoPlatform,
    Part,
    extent,
    frame,
    inverse,
    opposite,
    place,
    scaled,
    split,
    turn,
)
from gspcli.machines.source import LARGEST_NUMBER
from gspcli.records import dataclass
from gspcli.wording import counted, listed, nearest, shown

Array = NDArray[np.float64]

#: A joint by its place in `Clusters.joints`, and whether it is passed from its first body.
Step = tuple[int, bool]


@dataclass(frozen=True, eq=False)
class Clusters:
    """The bodies of a graph; bodies that rigid or held joints join are one cluster."""

    #: The machine.
    graph: Graph
    #: Its joints of at most one part each (`graph.split`).
    joints: tuple[Joint, ...]
    #: The indices of the held ones.
    held: frozenset[int]
    #: For each body the one that stands for its cluster.
    of: dict[str, str]
    #: The indices of the joints between clusters.
    passive: tuple[int, ...]
    _branches: dict[str, list[Step]]

    @staticmethod
    def made(graph: Graph, joints: Sequence[Joint], held: Collection[int]) -> Clusters:
        """Return the clusters of a graph while some of its joints are held."""
        bodies = dict.fromkeys(
            [*graph.bodies, *(end for j in joints for end in (j.first, j.second))]
        )
        rigid = [k for k, joint in enumerate(joints) if not joint.parts or k in held]
        # Frames come from the tree of the file: closures join what nothing else does.
        rigid.sort(key=lambda k: joints[k].closure)
        branches: dict[str, list[Step]] = {body: [] for body in bodies}
        of = {body: body for body in bodies}
        members = {body: [body] for body in bodies}
        for k in rigid:
            first, second = joints[k].first, joints[k].second
            if of[first] != of[second]:
                moved = members.pop(of[second])
                members[of[first]] += moved
                of |= dict.fromkeys(moved, of[first])
                branches[first].append((k, True))
                branches[second].append((k, False))
        loose = [k for k, j in enumerate(joints) if k not in rigid and of[j.first] != of[j.second]]
        return Clusters(graph, tuple(joints), frozenset(held), of, tuple(loose), branches)

    def members(self, cluster: str) -> list[str]:
        """Return the bodies of the file in a cluster."""
        return [body for body in self.graph.bodies if self.of[body] == cluster]

    def ends(self, k: int) -> tuple[str, str]:
        """Return the clusters at the ends of a joint."""
        return self.of[self.joints[k].first], self.of[self.joints[k].second]

    def step(self, step: Step) -> Joint:
        """Return the joint of a step in the direction of the step."""
        k, forwards = step
        return self.joints[k] if forwards else opposite(self.joints[k])

    def path(self, start: str, end: str) -> list[Step]:
        """Return the steps from a body to another of its cluster, through rigid and held joints."""
        before: dict[str, tuple[str, Step] | None] = {start: None}
        waiting = [start]
        while end not in before:
            body = waiting.pop()
            for step in self._branches[body]:
                joint = self.joints[step[0]]
                other = joint.second if step[1] else joint.first
                if other not in before:
                    before[other] = body, step
                    waiting.append(other)
        steps: list[Step] = []
        while (link := before[end]) is not None:
            end, step = link
            steps.append(step)
        return steps[::-1]


#: What names of bases and of platforms contain.
_BASE_WORDS = ("base", "ground", "bottom", "fixed", "world")
_PLATFORM_WORDS = ("top", "platform", "head", "effector", "moving", "plate")


@dataclass(frozen=True, eq=False)
class ChainPart:
    """A part of a joint in a chain."""

    #: The part in the frame of the base, in the configuration of the file.
    part: Part
    #: Whether it is held: driven.
    held: bool
    #: Its place relative to the passive joints: ``base``, ``inside`` or ``platform``.
    where: str


@dataclass(frozen=True, eq=False)
class BodyChain:
    """What joins the base and the platform."""

    #: The name of its drive, else of its first joint.
    name: str
    #: From the base to the platform.
    parts: tuple[ChainPart, ...]
    #: The pose of the platform in the base along the chain, shape (4, 4).
    pose: Array

    @property
    def letters(self) -> str:
        """Its parts, as U-P*-S is R-R-P*-S; a star marks those that are held."""
        return "-".join(p.part.letter + "*" * p.held for p in self.parts)

    @property
    def size(self) -> float:
        """The diagonal of the box around its joints."""
        return extent([*(p.part.point for p in self.parts), self.pose[:3, 3]])


@dataclass(frozen=True, eq=False)
class JoinedBodies:
    """Two bodies and what joins them."""

    #: The bodies.
    base: str
    platform: str
    #: From the base to the platform.
    chains: tuple[BodyChain, ...]
    #: Why this body is the base.
    reason: str


def structure(clusters: Clusters, base: str | None, platform: str | None) -> JoinedBodies:
    """Return the base, the platform and the chains of a machine while its drives are held.

    Raises
    ------
    NoPlatform
        If there are no two bodies on which at least three chains end.
    """
    asked = [body for body in (base, platform) if body is not None]
    hubs, passive = _hubs(clusters, asked)
    hanging = set(clusters.passive) - set(passive)
    first, second, reason = _ordered(clusters, hubs, hanging, base, platform)
    walks = _walks(clusters, passive, first, second)
    starts = [clusters.step(walk[0]).first for walk in walks]
    ends = [clusters.step(walk[-1]).second for walk in walks]
    bottom = base or _own_body(clusters, first, starts)
    top = platform or _own_body(clusters, second, ends)
    chains = tuple(_chain(clusters, bottom, top, walk) for walk in walks)
    return JoinedBodies(bottom, top, chains, reason)


def _hubs(clusters: Clusters, asked: Sequence[str]) -> tuple[list[str], list[int]]:
    """Return the two clusters on which chains end, and the joints of the chains.

    Bodies with one joint only, such as an antenna, are left out.
    """
    keep = {clusters.of[body] for body in asked}
    passive = list(clusters.passive)
    while True:
        degree = Counter(end for k in passive for end in clusters.ends(k))
        hanging = {c for c, count in degree.items() if count == 1 and c not in keep}
        left = [k for k in passive if not hanging & set(clusters.ends(k))]
        if len(left) == len(passive):
            break
        passive = left
    hubs = [cluster for cluster, count in degree.most_common() if count >= 3]
    if len(hubs) != 2:
        found = ", ".join(f"{shown(hub)} ({degree[hub]} chains)" for hub in hubs[:6]) or "none"
        if len(hubs) > 6:
            found += f" and {len(hubs) - 6} more"
        message = f"found bodies on which three chains or more end: {found}; expected two, "
        raise NoPlatform(message + "a base and a platform")
    return hubs, passive


def _ordered(
    clusters: Clusters,
    hubs: list[str],
    hanging: Collection[int],
    base: str | None,
    platform: str | None,
) -> tuple[str, str, str]:
    """Return the clusters of the base and the platform, and the reason of the choice."""
    first, second = hubs
    if base is not None or platform is not None:
        asked = [None if body is None else clusters.of[body] for body in (base, platform)]
        for body, cluster in zip((base, platform), asked, strict=True):
            if cluster is not None and cluster not in hubs:
                ends = listed(map(shown, hubs), "and")
                message = f"found no three chains that end on {shown(str(body))}, but on {ends}"
                raise NoPlatform(message)
        if asked[0] == asked[1]:
            raise NoPlatform(f"found {shown(str(base))} and {shown(str(platform))} rigid together")
        swapped = asked[0] == second or asked[1] == first
        return (second, first, "as asked for") if swapped else (first, second, "as asked for")
    world = clusters.graph.world
    tests: tuple[tuple[str, Callable[[Clusters, str], float]], ...] = (
        ("it does not move", lambda c, hub: world is not None and c.of[world] == hub),
        ("the world hangs on it", lambda c, hub: _near_the_world(c, hub, hanging)),
        ("by its name", _named_base),
        ("the file begins with it", _above),
        ("it is heavier", _mass),
    )
    for reason, test in tests:
        here, there = test(clusters, first), test(clusters, second)
        if here != there:
            return (first, second, reason) if here > there else (second, first, reason)
    return first, second, "the file has it first"


def _near_the_world(clusters: Clusters, hub: str, hanging: Collection[int]) -> float:
    """Return whether joints that belong to no chain connect the world with a hub."""
    seen, waiting = {hub}, [hub]
    while waiting:
        here = waiting.pop()
        for k in hanging:
            ends = clusters.ends(k)
            if here in ends and not seen.issuperset(ends):
                waiting += set(ends) - seen
                seen.update(ends)
    world = clusters.graph.world
    return world is not None and clusters.of[world] in seen


def _named_base(clusters: Clusters, hub: str) -> float:
    names = [name.lower() for name in clusters.members(hub)]
    return sum(any(word in name for word in _BASE_WORDS) for name in names) - sum(
        any(word in name for word in _PLATFORM_WORDS) for name in names
    )


def _above(clusters: Clusters, hub: str) -> float:
    count = 0
    for k in clusters.passive:
        if not clusters.joints[k].closure:
            first, second = clusters.ends(k)
            count += (first == hub) - (second == hub)
    return count


def _mass(clusters: Clusters, hub: str) -> float:
    return sum(clusters.graph.bodies[body].mass or 0.0 for body in clusters.members(hub))


def _walks(
    clusters: Clusters, passive: Collection[int], first: str, second: str
) -> list[list[Step]]:
    """Return the passive joints of each chain from the first cluster to the second."""
    touching: dict[str, list[int]] = {}
    for k in passive:
        for end in clusters.ends(k):
            touching.setdefault(end, []).append(k)
    walks, used = [], set()
    for start in touching[first]:
        here, walk, k = first, list[Step](), start
        while k not in used:
            used.add(k)
            ends = clusters.ends(k)
            forwards = ends[0] == here
            walk.append((k, forwards))
            here = ends[1] if forwards else ends[0]
            if here in (first, second):
                break
            k = next((other for other in touching[here] if other != k), k)
        if walk and here == first:
            joints = "-".join(clusters.joints[k].letters for k, _ in walk)
            raise NoPlatform(f"found a chain that begins and ends on {shown(first)}: {joints}")
        if walk:
            walks.append(walk)
    return walks


def _own_body(clusters: Clusters, cluster: str, ends: Sequence[str]) -> str:
    """Return the body of a cluster from which the drives of the chains are fewest.

    A drive between this body and the ends of all chains would not move the platform.
    """
    members = clusters.members(cluster)
    if not members:
        raise NoPlatform(f"found only {counted(0, 'body')} at one end of the chains")

    def drives(body: str) -> int:
        return sum(k in clusters.held for end in ends for k, _ in clusters.path(body, end))

    fewest = min(map(drives, members))
    own = [body for body in members if drives(body) == fewest]
    world = clusters.graph.world
    if world in own:
        return str(world)
    return max(own, key=lambda body: (clusters.graph.bodies[body].mass or 0.0, body == cluster))


def _chain(clusters: Clusters, base: str, platform: str, walk: list[Step]) -> BodyChain:
    legs: list[tuple[Joint, bool, str]] = []

    def through(start: str, end: str, where: str) -> None:
        path = clusters.path(start, end)
        legs.extend((clusters.step(step), step[0] in clusters.held, where) for step in path)

    joints = [clusters.step(step) for step in walk]
    through(base, joints[0].first, "base")
    for joint, following in pairwise(joints):
        legs.append((joint, False, "inside"))
        through(joint.second, following.first, "inside")
    legs.append((joints[-1], False, "inside"))
    through(joints[-1].second, platform, "platform")
    X, parts = np.eye(4), []
    for joint, held, where in legs:
        parts += [ChainPart(part.moved(X), held, where) for part in joint.parts]
        X = X @ joint.relative
    driven = (p.part.name for p in parts if p.held and p.part.name)
    name = next(driven, clusters.joints[walk[0][0]].name)
    return BodyChain(name, tuple(parts), X)


#: The kinds that are looked for, in this order. A chain that holds an angle of a line or plane
#: holds the angle of two lines, too: ALL stands for all four. DLL is the last: lines that are
#: parallel in one pose are held there by more than one constraint.
ORDER = ("DPP", "ALL", "DPL", "DLP", "DPH", "DHP", "DLL")


@dataclass(frozen=True, eq=False)
class Primitives:
    """Points or lines or planes of one body; of a point the direction is not used."""

    #: A point of each, shape (n, 3).
    points: Array
    #: The unit direction or normal of each, shape (n, 3); zeros for points.
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


def _bodies(kind: str, platform: Primitives, base: Primitives) -> Bodies:
    """Return all pairs of n primitives of the platform and m of the base, one after the other."""
    i, j = np.indices((len(platform), len(base))).reshape(2, -1, 1)
    ends = platform.points[i], base.points[j], platform.directions[i], base.directions[j]
    return Bodies((KINDS_BY_NAME[kind],), *ends)


def measured(kind: str, platform: Primitives, base: Primitives, X: Array) -> Array:
    """Return the distances or angles of all pairs at a pose, shape (n, m); those to planes signed.

    The primitives are in the frames of their bodies, the pose of the platform has shape (4, 4).
    """
    values = values_of_pairs(_bodies(kind, platform, base), X[:3, :3], X[:3, 3])
    values = np.abs(values) if kind == "DLL" else values
    return np.asarray(values).reshape(len(platform), len(base))


#: Primitives that agree to this share of the size are one.
_SAME = 1e-9


@dataclass(frozen=True, eq=False)
class CandidatePrimitives:
    """Primitives of a chain in the configuration of the file, in the frame of the base."""

    #: Centres of balls and crossings of hinge axes: only these have distances of two points.
    centres: Primitives
    #: All points that can have a distance from a line or plane.
    points: Primitives
    #: The axes of hinges.
    lines: Primitives
    #: Directions that can have angles: those of the lines.
    directions: Primitives
    #: Normals, with any point: it is moved to where the distance is to be measured.
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
    """Return the candidates of a chain with parts that are not held, in the frame of the base.

    Axes that pass each other at a distance smaller than `near` cross.
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
    return np.asarray((first.point + s * first.axis + second.point + t * second.axis) / 2)


def _foot(part: Part) -> Array:
    return np.asarray(part.point - part.axis * (part.point @ part.axis))


def _places(vectors: list[Array], same: float) -> list[int]:
    """Return the indices of the vectors that differ from all earlier ones."""
    kept: list[int] = []
    for k, vector in enumerate(vectors):
        if all(np.linalg.norm(vector - vectors[other]) > same for other in kept):
            kept.append(k)
    return kept


def _different(vectors: list[Array], same: float) -> list[Array]:
    return [vectors[k] for k in _places(vectors, same)]


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


@dataclass(frozen=True, eq=False)
class Held:
    """A constraint that a chain holds."""

    #: One of `ORDER`.
    kind: str
    #: One primitive each, in the frame of its body.
    platform: Primitives
    base: Primitives
    #: The distance, signed towards the normal of a plane, or the angle in radians.
    value: float
    #: The largest change of the value over random motions.
    change: float


def held_constraints(chain: BodyChain, meet: float) -> tuple[list[Held], int]:
    """Return the constraints that were found, and how many the chain holds with its drives held.

    Axes meet, and constants may change, up to the share `meet` of the size.
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
    return np.asarray(X @ chain.pose)


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
    """What is constant over some poses of the platform, that of the file first."""

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
        scale = 1.0 if kind[0] == "A" else self.size
        with np.errstate(all="ignore"):
            (row,) = jacobian(_bodies(kind, platform, base), X[:3, :3], X[:3, 3])[0]
        return np.asarray(row * ([1.0] * 3 + [self.size] * 3) / scale)

    def _adds(self, gradient: Array) -> bool:
        length = float(np.linalg.norm(gradient))
        if not length > 0:
            return False
        rows = np.array([*self.gradients, gradient])
        rows /= np.linalg.norm(rows, axis=1, keepdims=True)
        return float(np.linalg.svd(rows, compute_uv=False)[-1]) > _INDEPENDENT


#: A drive changes a value if it does by more than this, as a share of the size, or in radians.
_CHANGED = 1e-9
#: A value is the coordinate of its drive if the slope is 1 to this.
_SLOPE = 1e-6
#: The widest range of a crank, in degrees.
_TURN = 360.0
#: Points of a range at which a value is computed.
_SAMPLES = 17


@dataclass(frozen=True, eq=False)
class PointDrive:
    """A crank or a rail, which moves the base's point of a constraint."""

    #: The unit axis of the crank, or direction of the rail, in the frame of the base, shape (3,).
    axis: Array
    #: The least and the greatest angle (degrees) or way from where the point is; None if they are
    #: not known, or more than a turn apart.
    limits: tuple[float, float] | None
    #: The point of the axis of a crank that is nearest to the point, shape (3,); None of a rail.
    centre: Array | None = None
    #: The distance of the point from it.
    radius: float = 0.0


@dataclass(frozen=True, eq=False)
class Found:
    """A constraint of a machine."""

    #: The constraint.
    held: Held
    #: The name of the chain.
    chain: str
    #: The letters of its joints, such as RRP.
    letters: str
    #: The smallest and the largest value, if they are known; equal where nothing drives it.
    limits: tuple[float, float] | None
    #: Whether a drive changes the value.
    driven: bool
    #: Of a distance to a plane: whether the point lies where the normal does not point. The limits
    #: are then those of the modulus.
    negative: bool
    #: What moves the base's point of a distance of two points.
    drive: PointDrive | None
    #: What an instance file cannot state.
    remarks: tuple[str, ...]


def with_drives(held: Held, chain: BodyChain, length: str) -> Found:
    """Return a constraint of a chain, held in the configuration of the file, with its drives."""
    driven = [(k, p) for k, p in enumerate(chain.parts) if p.held]
    inside = [(k, p) for k, p in driven if p.where == "inside" and _changes(held, chain, k)]
    remarks: list[str] = []
    limits: tuple[float, float] | None = None
    if not driven:
        limits = held.value, held.value
    elif len(inside) == 1:
        place_, drive = inside[0]
        held = _at_the_coordinate(held, chain, place_)
        limits = _limits(held, chain, place_, remarks)
        if not _linear(held, chain, place_):
            remarks.append(f"the value is no coordinate of {_named(drive)}")
    elif inside:
        remarks.append(f"{len(inside)} drives change the value")
    elif all(p.where == "inside" for _, p in driven):
        limits = held.value, held.value
    negative = held.value < 0 or (held.value == 0 and limits is not None and limits[1] <= 0)
    if held.kind in ("DPH", "DHP") and limits is not None and negative:
        limits = -limits[1], -limits[0]
    moved = _moved(held, [p for _, p in driven if p.where == "base"], remarks, length)
    if above := [p for _, p in driven if p.where == "platform"]:
        names = ", ".join(map(_named, above))
        remarks.append(f"the platform's {_sort(held, 1)} is moved by {names}")
    if limits is not None and limits[0] < 0:
        low, high = limits
        remarks.append(f"range [{low:.6g}, {high:.6g}], which passes zero")
        limits = None
    said, letters = tuple(remarks), chain.letters
    return Found(held, chain.name, letters, limits, bool(inside), negative, moved, said)


def _named(drive: ChainPart) -> str:
    return drive.part.name or {"R": "a hinge", "P": "a slide"}.get(drive.part.letter, "a ball")


def _sort(held: Held, position: int) -> str:
    return {"P": "point", "L": "line", "H": "plane"}[held.kind[position]]


def _value(held: Held, chain: BodyChain, drive: int) -> Callable[[float], float]:
    """Return what the constraint measures after a change of a drive."""

    def value(change: float) -> float:
        X = pose_after(chain, drive, change)
        return float(measured(held.kind, held.platform, held.base, X)[0, 0])

    return value


def _unit(held: Held, chain: BodyChain, drive: int) -> tuple[float, float]:
    """Return the unit of the drive's coordinate and that of the value."""
    size = chain.size
    own = size if chain.parts[drive].part.letter == "P" else 1.0
    return own, 1.0 if held.kind[0] == "A" else size


def _changes(held: Held, chain: BodyChain, drive: int) -> bool:
    if chain.parts[drive].part.letter == "S":
        return True
    value, (step, unit) = _value(held, chain, drive), _unit(held, chain, drive)
    return any(abs(value(d * step) - held.value) > _CHANGED * unit for d in (0.05, -0.05, 0.1))


def _linear(held: Held, chain: BodyChain, drive: int) -> bool:
    """Return whether the value changes by as much as the coordinate, in the file."""
    if chain.parts[drive].part.letter == "S":
        return False
    value, (step, unit) = _value(held, chain, drive), _unit(held, chain, drive)
    slopes = [(value(d * step) - value(-d * step)) / (2 * d * unit) for d in (1e-4, 1e-2)]
    return step == unit and all(abs(abs(slope) - 1) < _SLOPE for slope in slopes)


def _at_the_coordinate(held: Held, chain: BodyChain, drive: int) -> Held:
    """Return a distance to a plane that is the coordinate of its drive, signed.

    The chain does not say where the plane is: only its normal. Other kinds are unchanged.
    """
    if held.kind not in ("DPH", "DHP") or not _linear(held, chain, drive):
        return held
    value, (step, _) = _value(held, chain, drive), _unit(held, chain, drive)
    sign = 1.0 if value(1e-3 * step) > value(-1e-3 * step) else -1.0
    shift = held.value - sign * chain.parts[drive].part.at
    own, base = held.platform, held.base
    if held.kind == "DPH":
        base = Primitives(base.points + shift * base.directions, sign * base.directions)
    else:
        own = Primitives(own.points + shift * own.directions, sign * own.directions)
    return replace(held, platform=own, base=base, value=sign * (held.value - shift))


def _limits(
    held: Held, chain: BodyChain, drive: int, remarks: list[str]
) -> tuple[float, float] | None:
    """Return the values in the range of a drive, if they are between those at its ends."""
    part = chain.parts[drive].part
    if part.letter == "S" or not (math.isfinite(part.low) and math.isfinite(part.high)):
        return None
    value = _value(held, chain, drive)
    values = [value(x - part.at) for x in np.linspace(part.low, part.high, _SAMPLES)]
    rises = np.diff(values)
    if (rises > 0).all() or (rises < 0).all():
        return min(values), max(values)
    remarks.append(f"{_named(chain.parts[drive])} in [{part.low:.6g}, {part.high:.6g}]")
    return None


def _moved(
    held: Held, outer: list[ChainPart], remarks: list[str], length: str
) -> PointDrive | None:
    """Return what turns or slides the base's point; refuse other drives with what they move."""
    if not outer:
        return None
    drive = outer[0]
    part = drive.part
    primitive = f"the base's {_sort(held, 2)}"
    if len(outer) > 1:
        names = ", ".join(map(_named, outer))
        remarks.append(f"{primitive} is moved by {len(outer)} drives: {names}")
        return None
    bounded = math.isfinite(part.low) and math.isfinite(part.high)
    low, high = part.low - part.at, part.high - part.at
    if part.letter == "R" and held.kind == "DPP":
        point = held.base.points[0]
        centre = part.point + part.axis * ((point - part.point) @ part.axis)
        limits = None
        if bounded:
            low, high = np.degrees([low, high]).tolist()
            if high - low <= _TURN:
                limits = low, high
            else:
                remarks.append(f"the crank {_named(drive)} turns from {low:.6g} to {high:.6g} deg")
        return PointDrive(part.axis, limits, centre, float(np.linalg.norm(point - centre)))
    if part.letter == "P" and held.kind == "DPP":
        return PointDrive(part.axis, (low, high) if bounded else None)
    moves = "slides" if part.letter == "P" else "turns"
    axis = ", ".join(f"{x:.12g}" for x in part.axis)
    said = f"{primitive} {moves} with {_named(drive)} along [{axis}]"
    if part.letter != "P":
        centre = ", ".join(f"{x:.12g}" for x in part.point)
        said = f"{primitive} {moves} with {_named(drive)} about [{axis}] through [{centre}]"
    if bounded and part.letter == "P":
        said += f" by {low:.6g} to {high:.6g} {length}"
    remarks.append(said)
    return None


#: What the configuration of a file misses by more than this share of the size is said.
_EXACT = 1e-9
#: Bodies of a machine, and joints at one of them, at most.
_MOST_BODIES = 1500


@dataclass(frozen=True, eq=False)
class Machine:
    """A platform that was recognized."""

    #: The graph in which it was recognized.
    graph: Graph
    #: Its base, its platform and its chains.
    structure: JoinedBodies
    #: The six constraints.
    constraints: tuple[Found, ...]
    #: Of the platform in the base, as the file states it, shape (4, 4).
    pose: Array
    #: The diagonal of the box around all joints.
    size: float
    #: How far the constraints are from their values at that pose: lengths, and angles times the
    #: size.
    gap: float
    #: What was assumed, and what the file leaves open.
    notes: tuple[str, ...]
    #: The bodies of the file that move with the platform, and their poses in it.
    carried: tuple[tuple[str, Array], ...]


def recognized(
    graph: Graph,
    *,
    base: str | None = None,
    platform: str | None = None,
    meet: float = MEETING_SHARE,
) -> Machine:
    """Return the platform that a graph is.

    Parameters
    ----------
    graph
        The machine.
    base, platform
        The names of the bodies to take as base and platform; found if None.
    meet
        Axes that pass each other at up to this share of the size are taken to meet.

    Raises
    ------
    NoPlatform
        If it is no platform; the message says what it is, and what would make it one.
    """
    if len(graph.bodies) > _MOST_BODIES:
        raise NoPlatform(f"found {len(graph.bodies)} bodies, expected at most {_MOST_BODIES}")
    for body in (base, platform):
        if body is not None and body not in graph.bodies:
            near = nearest(body, graph.bodies)
            expected = f"did you mean {shown(near)}?" if near else _names(graph)
            raise NoPlatform(f"found no body {shown(body)}: {expected}")
    _check_numbers(graph)
    joints = tuple(split(graph.joints))
    reasons: list[str] = []
    for held, assumed in _drives(graph, joints, base):
        try:
            return _recognized(Clusters.made(graph, joints, held), assumed, base, platform, meet)
        except NoPlatform as error:
            reasons.append(f"{assumed}: {error}" if assumed else str(error))
    # What comes after the first are less likely drives.
    raise NoPlatform(f"{graph.described()}\n{reasons[0]}")


def _check_numbers(graph: Graph) -> None:
    """Refuse numbers that cannot be computed with, and name the joint or the body."""
    for joint in graph.joints:
        arrays = [joint.relative, *(x for part in joint.parts for x in (part.axis, part.point))]
        values = [part.at for part in joint.parts]
        if not all(_usable(x) for x in (*arrays, np.array(values))):
            message = f"found numbers of the joint {shown(joint.name)} that are not finite, or huge"
            raise NoPlatform(message)
    for body in graph.bodies.values():
        masses = (np.array(body.mass or 0.0), body.centre, body.inertia)
        if not all(_usable(x) for x in (body.pose, *masses)):
            message = f"found numbers of the body {shown(body.name)} that are not finite, or huge"
            raise NoPlatform(message)


def _usable(numbers: Array) -> bool:
    return bool((np.abs(numbers) < LARGEST_NUMBER).all())


def _names(graph: Graph) -> str:
    names = list(graph.bodies)
    more = f" and {len(names) - 8} more" if len(names) > 8 else ""
    return f"the bodies are {', '.join(map(shown, names[:8]))}{more}"


def _drives(
    graph: Graph, joints: tuple[Joint, ...], base: str | None
) -> Iterator[tuple[set[int], str]]:
    """Yield sets of joints that may be the drives, each with the assumption that it needs."""
    if graph.drives_known:
        yield {k for k, joint in enumerate(joints) if any(p.driven for p in joint.parts)}, ""
        return
    said = "the file names no drives; taken for drives:"
    slides = {k for k, joint in enumerate(joints) if joint.letters == "P"}
    if slides:
        # Hinges are not tried then: that read another machine than the one that was meant.
        yield slides, f"{said} all slides"
        yield set(), f"{said} none"
        return
    free = Clusters.made(graph, joints, set())
    try:
        bodies = [structure(free, base, None).base]
    except NoPlatform:
        # Arms that carry several rods are bodies on which chains end, too.
        degree = Counter(end for k in free.passive for end in free.ends(k))
        bodies = [body for body, count in degree.most_common(6) if count >= 3]
    for body in bodies:
        hinges = {
            k for k in free.passive if joints[k].letters == "R" and free.of[body] in free.ends(k)
        }
        if hinges:
            yield hinges, f"{said} the hinges at {shown(body)}"
    yield set(), f"{said} none"


def _recognized(
    clusters: Clusters, assumed: str, base: str | None, platform: str | None, meet: float
) -> Machine:
    graph = clusters.graph
    shape = structure(clusters, base, platform)
    points = [p.part.point for c in shape.chains for p in c.parts if p.part.letter != "P"]
    size = extent(points or [chain.pose[:3, 3] for chain in shape.chains])
    met = [_meeting(chain, size, meet) for chain in shape.chains]
    shape = replace(shape, chains=tuple(chain for chain, _, _ in met))
    found: list[Found] = []
    problems, count = [], 0
    for chain in shape.chains:
        held, number = held_constraints(chain, meet)
        count += number
        if len(held) < number:
            kinds = ", ".join(h.kind for h in held) or "none"
            problems.append(
                f"{chain.name} holds {number}, of which only {kinds} is of the ten kinds"
            )
        found += [with_drives(h, chain, graph.length) for h in held]
    if count != 6 or problems:
        missed = max((missed for _, _, missed in met), default=0.0)
        raise NoPlatform(_refusal(shape, count, problems, missed, size, graph.length))
    notes = [*graph.notes, *([assumed] if assumed else [])]
    moved = max(moved for _, moved, _ in met)
    if moved > _EXACT * size:
        notes.append(f"axes that pass each other at up to {moved:.2g} {graph.length} are taken "
                     "to meet")  # fmt: skip
    slack = max(f.held.change * (size if f.held.kind[0] == "A" else 1.0) for f in found)
    if slack > 1e-7 * size:
        notes.append(f"constraints hold within {slack:.2g} {graph.length}: the file has few digits")
    bodies = graph.bodies
    pose = inverse(bodies[shape.base].pose) @ bodies[shape.platform].pose
    if not graph.has_home:
        pose = shape.chains[0].pose
    gap = max(_missed(f, pose, size) for f in found)
    if graph.has_home and gap > _EXACT * size:
        loops = max((joint.gap for joint in graph.joints), default=0.0)
        said = f"the pose that the file states misses the values by {gap:.2g} {graph.length}"
        notes.append(said + (f"; its loops are open by up to {loops:.2g}" if loops > 0 else ""))
    return Machine(
        graph, shape, tuple(found), pose, size, gap, tuple(notes), _carried(clusters, shape)
    )


def _missed(found: Found, pose: Array, size: float) -> float:
    held = found.held
    off = abs(float(measured(held.kind, held.platform, held.base, pose)[0, 0]) - held.value)
    return off * (size if held.kind[0] == "A" else 1.0)


def _refusal(
    shape: JoinedBodies, count: int, problems: list[str], missed: float, size: float, length: str
) -> str:
    """Return why the chains are not six constraints, and what would change that."""
    kinds = Counter(chain.letters for chain in shape.chains)
    chains = ", ".join(f"{number} {letters}" for letters, number in kinds.items())
    said = f"found {len(shape.chains)} chains ({chains}) from the base {shown(shape.base)} to the "
    said += f"platform {shown(shape.platform)}, which hold {count} constraints, expected six"
    if count == 6:
        said += " distances and angles of points, lines and planes"
    if missed > 0:
        share = missed / size * 1.1
        return said + (
            f"; the axes at one end of a leg pass each other at {missed:.3g} {length}: "
            f"--meet {share:.2g} takes them to meet"
        )
    if count > 6 and all(p.part.letter != "S" for chain in shape.chains for p in chain.parts):
        said += "; with a ball joint at one end, or a hinge along each leg, it would hold fewer"
    elif count > 6:
        said += f": {counted(count - 6, 'constraint')} too many"
    elif count < 6:
        said += ": name the drives, or the platform is not held"
    return f"{said}; {problems[0]}" if problems else said


def _carried(clusters: Clusters, shape: JoinedBodies) -> tuple[tuple[str, Array], ...]:
    """Return the bodies that always move with the platform."""
    cluster = clusters.of[shape.platform]
    carried = []
    for body in clusters.members(cluster):
        steps = clusters.path(shape.platform, body)
        if not any(k in clusters.held for k, _ in steps):
            X = np.eye(4)
            for step in steps:
                X = X @ clusters.step(step).relative
            carried.append((body, X))
    return tuple(carried)


def _meeting(chain: BodyChain, size: float, meet: float) -> tuple[BodyChain, float, float]:
    """Return a chain in which neighbouring hinge axes that nearly meet are moved to meet.

    It is returned with how far axes were moved, and how far apart the others are.
    """
    moved = missed = 0.0
    parts: list[ChainPart] = []
    for run in _runs(chain.parts):
        axes = [p.part for p in run]
        if not 2 <= len(run) <= 3 or any(_parallel(a, b) for a, b in pairwise(axes)):
            parts += run
            continue
        across = [np.eye(3) - np.outer(a.axis, a.axis) for a in axes]
        rights = np.sum([A @ a.point for A, a in zip(across, axes, strict=True)], axis=0)
        centre = np.linalg.solve(np.sum(across, axis=0), rights)
        off = 2 * max(float(np.linalg.norm(np.cross(centre - a.point, a.axis))) for a in axes)
        if off <= meet * size:
            moved = max(moved, off)
            run = [replace(p, part=replace(p.part, point=centre)) for p in run]
        else:
            missed = max(missed, off)
        parts += run
    return replace(chain, parts=tuple(parts)), moved, missed


def _runs(parts: tuple[ChainPart, ...]) -> Iterator[list[ChainPart]]:
    """Yield passive hinges that follow each other as one group, and each other part alone."""
    run: list[ChainPart] = []
    for p in parts:
        if p.part.letter == "R" and not p.held:
            run.append(p)
            continue
        if run:
            yield run
        run = []
        yield [p]
    if run:
        yield run


def _parallel(first: Part, second: Part) -> bool:
    return float(np.linalg.norm(np.cross(first.axis, second.axis))) < MEASURED_PARALLEL_SINE
