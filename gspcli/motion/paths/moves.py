"""When a platform is where on a path of straight parts: moves with constant accelerations.

On each part the speed rises, stays, and falls again; at a corner the platform stops, or it leaves
the parts for a parabola that touches both. Let d and e be the full velocities of the parts. The
rates are ``s d`` before the parabola and ``s e`` after it, and it takes the time s b. Then the
acceleration on it is ``(e - d) / b``, and its nearest place to the corner is ``s^2 b (e - d) / 8``
away.
The rates at corners are the largest from which the next ones can be reached, as controllers of
machine tools look ahead.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.records import dataclass

Array = NDArray[np.float64]
Index = NDArray[np.int64]


class LineMove(NamedTuple):
    """A straight part with its limits."""

    way: Array
    """From its first to its last corner, shape (d,), not zero."""
    duration: float
    """How long it takes at the full velocity ``way / duration``."""
    rise: float
    """How quickly the rate, 1 at the full velocity, may change, a second."""

    @property
    def full(self) -> Array:
        """The full velocity, shape (d,)."""
        return self.way / self.duration


class Corner(NamedTuple):
    """What is asked of the corner between two parts."""

    bend: float
    """How long the change from one full velocity to the other takes at least."""
    share: float
    """The parabola begins and ends within this share of the parts, at most a half; 0 to stop."""
    most: float = 1.0
    """The largest rate."""


@dataclass(frozen=True, eq=False)
class Moves:
    """n moves, one after the other.

    Attributes
    ----------
    begins
        When each begins, and at last when all end, shape (n + 1,).
    places, velocities, accelerations
        Of the parameters at its beginning, shapes (n, d).
    parts
        The straight part, or the corner after it, that each belongs to, shape (n,).
    round
        Whether it is a parabola at a corner, shape (n,).
    rates
        At the corners, those of both ends included, shape (k + 1,); 0 where the platform stops.
    """

    begins: Array
    places: Array
    velocities: Array
    accelerations: Array
    parts: Index
    round: NDArray[np.bool_]
    rates: Array

    @property
    def seconds(self) -> float:
        """How long all moves take."""
        return float(self.begins[-1])

    @property
    def durations(self) -> Array:
        """How long each move takes, shape (n,)."""
        return np.diff(self.begins)

    def at(self, times: Array) -> tuple[Array, Array, Array]:
        """Return places, velocities and accelerations of the parameters, shapes (r, d)."""
        move = np.searchsorted(self.begins[1:-1], times, side="right")
        since = (times - self.begins[move])[:, None]
        p, v, a = self.places[move], self.velocities[move], self.accelerations[move]
        return p + v * since + a * since**2 / 2, v + a * since, a


def moves_of(places: Array, lines: list[LineMove], corners: list[Corner]) -> Moves:
    """Return the moves along straight parts, from rest to rest.

    Parameters
    ----------
    places
        Where the k parts meet, with both ends of the path, shape (k + 1, d).
    lines
        The parts.
    corners
        Those between them, k - 1.
    """
    rates = _rates(lines, corners)
    found = _Collected(places[0])
    for k, line in enumerate(lines):
        before = corners[k - 1].bend * rates[k] ** 2 / 2 if k else 0.0
        after = corners[k].bend * rates[k + 1] ** 2 / 2 if k < len(corners) else 0.0
        begin, end = float(rates[k]), float(rates[k + 1])
        left = max(line.duration - before - after, 0.0)
        top = min(1.0, float(np.sqrt(line.rise * left + (begin**2 + end**2) / 2)))
        top = max(top, begin, end)
        up, down = (top - begin) / line.rise, (top - end) / line.rise
        even = max(left - (top**2 - begin**2 + top**2 - end**2) / (2 * line.rise), 0.0) / max(
            top, 1e-300
        )
        full = line.full
        found.add(up, begin * full, line.rise * full, k, curved=False)
        found.add(even, top * full, 0 * full, k, curved=False)
        found.add(down, top * full, -line.rise * full, k, curved=False)
        if k < len(corners) and end:
            bent = (lines[k + 1].full - full) / max(corners[k].bend, 1e-300)
            found.add(end * corners[k].bend, end * full, bent, k, curved=True)
        elif not end:
            found.stop(places[k + 1])
    return found.moves(rates)


def _rates(lines: list[LineMove], corners: list[Corner]) -> Array:
    """Return the rates at all corners."""
    most = np.zeros(len(lines) + 1)
    for k, corner in enumerate(corners, 1):
        room = corner.share * min(lines[k - 1].duration, lines[k].duration)
        if room:
            bend = max(corner.bend, 1e-300)
            most[k] = min(corner.most, np.sqrt(min(2 * room / bend, 1.0)))
    used = np.array([0.0, *(c.bend * s**2 / 2 for c, s in zip(corners, most[1:], strict=False)), 0])
    squares = most**2
    for k, line in enumerate(lines):
        left = max(line.duration - used[k] - used[k + 1], 0.0)
        squares[k + 1] = min(squares[k + 1], squares[k] + 2 * line.rise * left)
    for k in range(len(lines) - 1, -1, -1):
        left = max(lines[k].duration - used[k] - used[k + 1], 0.0)
        squares[k] = min(squares[k], squares[k + 1] + 2 * lines[k].rise * left)
    return np.sqrt(squares)


class _Collected:
    """Moves that are added one by one, each where the one before ends."""

    def __init__(self, start: Array) -> None:
        self._place, self._time = np.asarray(start, float), 0.0
        self._rows: list[tuple[float, Array, Array, Array, int, bool]] = []

    def add(
        self, duration: float, velocity: Array, acceleration: Array, part: int, *, curved: bool
    ) -> None:
        """Add a move, unless it takes no time."""
        if duration <= 0:
            return
        self._rows.append((self._time, self._place, velocity, acceleration, part, curved))
        self._time += duration
        self._place = self._place + velocity * duration + acceleration * duration**2 / 2

    def stop(self, place: Array) -> None:
        """Set the place where the next move begins: without the rounding errors of the last."""
        self._place = place

    def moves(self, rates: Array) -> Moves:
        """Return all moves; a path of one pose has one that takes no time."""
        rows = self._rows or [(0.0, self._place, 0 * self._place, 0 * self._place, 0, False)]
        begins, places, velocities, accelerations, parts, curved = zip(*rows, strict=True)
        return Moves(
            np.array([*begins, self._time]),
            np.array(places),
            np.array(velocities),
            np.array(accelerations),
            np.array(parts, np.int64),
            np.array(curved, bool),
            rates,
        )
