"""Clusters: bodies that do not move against each other while some joints are held."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from gspcli.machines.graph import Graph, Joint, opposite, split
from gspcli.records import dataclass

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

    def drives_between(self, start: str, end: str) -> int:
        """Return how many held joints lie between two bodies of a cluster."""
        return sum(k in self.held for k, _ in self.path(start, end))


def unhindered(graph: Graph) -> tuple[Joint, ...]:
    """Return the joints of a graph, each of at most one part."""
    return tuple(split(graph.joints))
