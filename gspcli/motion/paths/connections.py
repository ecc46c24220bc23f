"""Nodes and proved edges between them: which belong together, and the way from one to another."""

from __future__ import annotations

import heapq


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
