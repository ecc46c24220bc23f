"""Shorter paths that keep away from singular poses: short cuts and moves of corners, each proved.

The cost of a path is the integral of its condition number by its length, in lengths of the
platform. The length is that of the way of the platform's points, as a root mean square. A change is
kept if the new path is proved and costs less. While a path is longer than three times the straight
way, more tries follow in which the condition number counts less. The numbers of tries are fixed, so
that the result does not depend on the speed of the computer. A change must save a thousandth of the
cost, so that the result does not depend on last digits either.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.instance import Instance
from gspcli.motion.paths.guides import PROVED_ROWS, Guide
from gspcli.motion.paths.way_costs import cost, steps

Array = NDArray[np.float64]

#: Random tries, at first and with each of the other powers of the condition number.
_TRIES, _MORE, _POWERS = 400, 300, (0.5, 0.25)
#: Random tries where each proof has clearances or gaps, which take long.
_SLOW_TRIES = 40
#: A path that is this many times as long as the straight way is long.
LONG = 3.0
_ROWS = np.array([PROVED_ROWS])
#: How far corners are moved, by their ranges, and what a change must be worth.
_MOVES, _WORTH = (0.02, 0.08, 0.25), 1e-3


def smoothed(instance: Instance, guide: Guide, corners: Array, seed: int) -> Array:
    """Return the corners of a path that costs less, shape (k, 6).

    Parameters
    ----------
    instance
        The platform.
    guide
        Proves paths.
    corners
        Those of a proved path.
    seed
        Of the tries.
    """
    draw = np.random.default_rng(seed)
    slow = bool(guide.clear) or guide.gap is not None
    corners = _cheaper(instance, guide, corners, draw, 1.0, _SLOW_TRIES if slow else _TRIES)
    for power in () if slow else _POWERS:
        if len(corners) == 2 or stretch(instance, guide, corners) <= LONG:
            break
        corners = _cheaper(instance, guide, corners, draw, power, _MORE)
    return corners


def stretch(instance: Instance, guide: Guide, corners: Array) -> float:
    """Return how many times a path is as long as the straight way."""
    trace = guide.trace(corners, np.full(len(corners) - 1, PROVED_ROWS))
    if trace is None:
        return 0.0
    ends = [0, -1]
    straight = float(steps(instance, trace.R[ends], trace.T[ends])[0])
    length = float(steps(instance, trace.R, trace.T).sum())
    return length / straight if straight > 0 else np.inf


def _cheaper(
    instance: Instance,
    guide: Guide,
    corners: Array,
    draw: np.random.Generator,
    power: float,
    tries: int,
) -> Array:
    """Return the corners of a path that costs less with a power of the condition number."""
    #: What straight parts cost whose poses are known without a proof.
    parts: dict[tuple[bytes, bytes], float] = {}

    def part(first: Array, last: Array) -> float | None:
        """Return the cost of a straight part; None if its poses depend on the parts before."""
        key = first.tobytes(), last.tobytes()
        if key not in parts:
            poses = guide.unproved(np.stack((first, last)), _ROWS)
            if poses is None:
                return None
            parts[key] = cost(instance, *poses, power)
        return parts[key]

    def value(tried: Array, below: float) -> float:
        """Return the cost of a path if it is proved and costs less, else infinity."""
        rows = np.full(len(tried) - 1, PROVED_ROWS)
        known = 0.0
        for first, last in pairwise(tried):
            one = part(first, last)
            if one is None:
                trace = guide.trace(tried, rows)
                found = np.inf if trace is None else cost(instance, trace.R, trace.T, power)
                return found if found < below else np.inf
            known += one
            if not known < below:
                return np.inf
        return known if guide.trace(tried, rows) is not None else np.inf

    best = value(corners, np.inf)
    corners, best = _short_cuts(corners, best, value)
    for _ in range(tries):
        tried = _changed(guide, corners, draw)
        if tried is not None:
            new = value(tried, best * (1 - _WORTH))
            if new < np.inf:
                corners, best = tried, new
    return corners


def _short_cuts(
    corners: Array, best: float, value: Callable[[Array, float], float]
) -> tuple[Array, float]:
    """Leave out corners, the longest short cuts first, where that costs less."""
    begin = 0
    while begin + 2 < len(corners):
        for end in range(len(corners) - 1, begin + 1, -1):
            tried = np.concatenate((corners[: begin + 1], corners[end:]))
            new = value(tried, best * (1 - _WORTH))
            if new < np.inf:
                corners, best = tried, new
                break
        begin += 1
    return corners, best


def _changed(guide: Guide, corners: Array, draw: np.random.Generator) -> Array | None:
    """Return a random change of a path, or None if there is none of the sort drawn."""
    count, sort = len(corners), draw.random()
    noise = draw.normal(size=6) * guide.sizes
    width = float(draw.choice(_MOVES))
    if sort < 0.2:
        if count < 3:
            return None
        first = int(draw.integers(0, count - 2))
        last = int(draw.integers(first + 2, count))
        return np.concatenate((corners[: first + 1], corners[last:]))
    if sort < 0.45:
        if count < 3:
            return None
        # From a place on one part to a place on another.
        places = np.sort(draw.random(2) * (count - 1))
        i, j = places.astype(int).tolist()
        if i == j:
            return None
        parts = zip((i, j), places.tolist(), strict=True)
        ends = [
            guide.placed(corners[k] + (corners[k + 1] - corners[k]) * (x - k)) for k, x in parts
        ]
        return np.concatenate((corners[: i + 1], ends, corners[j + 1 :]))
    if sort < 0.85:
        if count < 3:
            return None
        k = int(draw.integers(1, count - 1))
        tried = corners.copy()
        tried[k] = guide.placed(tried[k] + noise * width)
        return tried
    k = int(draw.integers(0, count - 1))
    middle = (corners[k] + corners[k + 1]) / 2
    return np.insert(corners, k + 1, guide.placed(middle + noise * 0.1), axis=0)
