"""Which body is the base and which the platform, and which chains of joints join them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from gspcli.machines.graph import Graph, Joint, NoPlatform, Part, extent, opposite
from gspcli.records import dataclass
from gspcli.wording import counted, listed, shown

#: A joint by its place in `Clusters.joints`, and whether it is passed from its first body.
Step = tuple[int, bool]


@dataclass(frozen=True, eq=False)
class Clusters:
    """The bodies of a graph; bodies that rigid or held joints join are one cluster.

    Attributes
    ----------
    graph
        The machine.
    joints
        Its joints of at most one part each (`graph.split`).
    held
        The indices of the held ones.
    of
        For each body the one that stands for its cluster.
    passive
        The indices of the joints between clusters.
    """

    graph: Graph
    joints: tuple[Joint, ...]
    held: frozenset[int]
    of: dict[str, str]
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


Array = NDArray[np.float64]

#: What names of bases and of platforms contain.
_BASE_WORDS = ("base", "ground", "bottom", "fixed", "world")
_PLATFORM_WORDS = ("top", "platform", "head", "effector", "moving", "plate")


@dataclass(frozen=True, eq=False)
class ChainPart:
    """A part of a joint in a chain.

    Attributes
    ----------
    part
        The part in the frame of the base, in the configuration of the file.
    held
        Whether it is held: driven.
    where
        Its place relative to the passive joints: ``base``, ``inside`` or ``platform``.
    """

    part: Part
    held: bool
    where: str


@dataclass(frozen=True, eq=False)
class BodyChain:
    """What joins the base and the platform.

    Attributes
    ----------
    name
        The name of its drive, else of its first joint.
    parts
        From the base to the platform.
    pose
        The pose of the platform in the base along the chain, shape (4, 4).
    """

    name: str
    parts: tuple[ChainPart, ...]
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
    """Two bodies and what joins them.

    Attributes
    ----------
    base, platform
        The bodies.
    chains
        From the base to the platform.
    reason
        Why this body is the base.
    """

    base: str
    platform: str
    chains: tuple[BodyChain, ...]
    reason: str


def structure(clusters: Clusters, base: str | None, platform: str | None) -> JoinedBodies:
    """Return the base, the platform and the chains of a machine.

    Parameters
    ----------
    clusters
        The machine while its drives are held.
    base, platform
        The names of the bodies to take as base and platform, if known.

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
    starts = [_start(clusters, walk[0]) for walk in walks]
    ends = [_end(clusters, walk[-1]) for walk in walks]
    bottom = base or _own_body(clusters, first, starts)
    top = platform or _own_body(clusters, second, ends)
    chains = tuple(_chain(clusters, bottom, top, walk) for walk in walks)
    return JoinedBodies(bottom, top, chains, reason)


def _start(clusters: Clusters, step: Step) -> str:
    joint = clusters.joints[step[0]]
    return joint.first if step[1] else joint.second


def _end(clusters: Clusters, step: Step) -> str:
    joint = clusters.joints[step[0]]
    return joint.second if step[1] else joint.first


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
            message = f"found {shown(str(base))} and {shown(str(platform))} rigid together"
            raise NoPlatform(message)
        swapped = asked[0] == second or asked[1] == first
        return (second, first, "as asked for") if swapped else (first, second, "as asked for")
    tests: tuple[tuple[str, Callable[[Clusters, str], float]], ...] = (
        ("it does not move", _on_the_world),
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


def _on_the_world(clusters: Clusters, hub: str) -> float:
    world = clusters.graph.world
    return world is not None and clusters.of[world] == hub


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
            message = f"found a chain that begins and ends on {shown(first)}: {joints}"
            raise NoPlatform(message)
        if walk:
            walks.append(walk)
    return walks


def _own_body(clusters: Clusters, cluster: str, ends: Sequence[str]) -> str:
    """Return the body of a cluster from which the drives of the chains are fewest.

    A drive between this body and the ends of all chains would not move the platform.
    """
    members = clusters.members(cluster)
    if not members:
        message = f"found only {counted(0, 'body')} at one end of the chains"
        raise NoPlatform(message)

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

    through(base, _start(clusters, walk[0]), "base")
    for position, step in enumerate(walk):
        legs.append((clusters.step(step), False, "inside"))
        if position + 1 < len(walk):
            through(_end(clusters, step), _start(clusters, walk[position + 1]), "inside")
    through(_end(clusters, walk[-1]), platform, "platform")
    X, parts = np.eye(4), []
    for joint, held, where in legs:
        parts += [ChainPart(part.moved(X), held, where) for part in joint.parts]
        X = X @ joint.relative
    driven = (p.part.name for p in parts if p.held and p.part.name)
    name = next(driven, clusters.joints[walk[0][0]].name)
    return BodyChain(name, tuple(parts), X)
