"""When a platform is where on a path: on each straight part the speed rises, stays and falls."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.records import dataclass

Array = NDArray[np.float64]


class LineMove(NamedTuple):
    """A straight part with its limits."""

    way: Array
    """From its first to its last corner, shape (d,), not zero."""
    duration: float
    """How long it takes at the full velocity ``way / duration``."""
    rise: float
    """How quickly the rate, 1 at the full velocity, may change, a second."""


@dataclass(frozen=True, eq=False)
class Moves:
    """Straight parts, one after the other, each from rest to rest.

    Attributes
    ----------
    begins
        When each part begins, and at last when all end, shape (k + 1,).
    places, ways
        Where each begins, and where it leads from there, shapes (k, d).
    tops, rises
        Its largest rate, and how quickly the rate changes, shape (k,).
    """

    begins: Array
    places: Array
    ways: Array
    tops: Array
    rises: Array

    @property
    def seconds(self) -> float:
        """How long all moves take."""
        return float(self.begins[-1])

    def at(self, times: Array) -> tuple[Array, NDArray[np.intp]]:
        """Return the places at times, shape (r, d), and on which parts they are."""
        part = np.searchsorted(self.begins[1:-1], times, side="right")
        span = np.diff(self.begins)[part]
        up = self.tops[part] / self.rises[part]
        since = times - self.begins[part]
        near = np.minimum(since, span - since)
        # The way from the nearer end, by the whole way: a parabola, then a line.
        gone = self.rises[part] * np.minimum(near, up) ** 2 / 2
        gone = gone + self.tops[part] * np.maximum(near - up, 0.0)
        whole = self.tops[part] * (span - up)
        share = np.where(since <= span / 2, gone, whole - gone) / whole
        return self.places[part] + self.ways[part] * share[:, None], part


def moves_of(places: Array, lines: list[LineMove]) -> Moves:
    """Return the moves along straight parts; the corners are of shape (k + 1, d)."""
    durations = np.array([line.duration for line in lines])
    rises = np.array([line.rise for line in lines])
    tops = np.minimum(1.0, np.sqrt(rises * durations))
    spans = durations / tops + tops / rises
    ways = np.array([line.way for line in lines])
    return Moves(np.append(0.0, np.cumsum(spans)), places[:-1], ways, tops, rises)
