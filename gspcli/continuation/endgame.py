"""The Cauchy endgame: the ends of paths where the Jacobian matrix degenerates.

Near t = 1 a path is a power series in ``(1 - t)^(1/w)`` with the winding number w. After one round
about t = 1 it arrives at another of the w paths of its cycle, and after w rounds at itself. By
Cauchy's theorem the end is the mean of the points on the way. In Study coordinates of a fixed
affine chart this holds at infinity, too.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.quadrics import ComplexArray, FloatArray
from gspcli.continuation.systems import System
from gspcli.continuation.tracker import PathStatus, track
from gspcli.continuation.tracker_options import CAREFUL, TrackerOptions
from gspcli.records import dataclass


@dataclass(frozen=True)
class EndgameOptions:
    """Settings of the endgame."""

    samples: int = 8
    """Points on the circle, an even number. The error of their mean falls with this power of the
    radius, that of every other one with half of it: so the difference estimates the error of the
    latter, and eight are enough for the square of it to be rounding."""
    max_winding: int = 16
    """Rounds after which a path that has not returned is given up: each costs as many steps as the
    first, and a path that is given up is lost, not misjudged."""
    shrink: float = 4.0
    """By how much a circle is made smaller if its mean is not yet the end."""
    rounds: int = 15
    """How many circles are tried: from a radius of 1e-3 to 4e-12, where doubles end."""
    accuracy: float = 1e-8
    """Difference of the two means at which the larger set is accurate to rounding."""
    residual: float = 1e-12
    """Largest residual of an end; the mean over a circle around two branch points has any."""
    closure: float = 1e-5
    """A path has returned if it is nearer to where it began than this part of the extent of its
    circle: other paths of the cycle are further away by about the extent itself, ..."""
    rounding: float = 1e-10
    """... and besides this, which rounding does to a path once around."""


ENDGAME = EndgameOptions()


@dataclass(frozen=True, eq=False)
class WindingEnds:
    """The ends of k paths."""

    points: ComplexArray
    """Shape (k, 8), norm 1; NaN where unknown."""
    winding: NDArray[np.int64]
    """Winding numbers, shape (k,); 0 where no loop closed."""
    error: FloatArray
    """How much the mean of every other point differs, shape (k,); the error of `points` is far
    smaller, with eight points its square. Infinite where unknown or no solution."""


def find_ends(
    start: System,
    target: System,
    points: ComplexArray,
    radius: float,
    tracker: TrackerOptions = CAREFUL,
    options: EndgameOptions = ENDGAME,
) -> WindingEnds:
    """Find the ends of paths from their points at ``t = 1 - radius``.

    The circle is made smaller until the end from all its points and the end from every other point
    agree. They agree if no other branch point is inside the circle or near it.

    Parameters
    ----------
    start, target
        The systems at t = 0 and t = 1.
    points
        Shape (k, 8); the end of a point that is NaN stays unknown.
    radius
        The distance of the points from t = 1.
    tracker, options
        Settings.
    """
    count = len(points)
    best = WindingEnds(
        np.full((count, 8), np.nan, dtype=np.complex128),
        np.zeros(count, dtype=np.int64),
        np.full(count, np.inf),
    )
    todo = np.arange(count)
    for _ in range(options.rounds):
        ends = _circle(start, target, points, radius, tracker, options)
        better = ends.error < best.error[todo]
        for name in ("points", "winding", "error"):
            getattr(best, name)[todo[better]] = getattr(ends, name)[better]
        keep = ~(ends.error < options.accuracy)
        todo, points = todo[keep], points[keep]
        if not len(todo):
            break
        nearer = radius / options.shrink
        here, there = (start.towards(target, 1 - r) for r in (radius, nearer))
        results = track(here, there, points, options=tracker)
        arrived = results.status[0] == PathStatus.REGULAR
        todo, points, radius = todo[arrived], results.points[0][arrived], nearer
    return best


def _circle(
    start: System,
    target: System,
    points: ComplexArray,
    radius: float,
    tracker: TrackerOptions,
    options: EndgameOptions,
) -> WindingEnds:
    """Follow paths around t = 1 until they return, and average."""
    count = len(points)
    ends = np.full((count, 8), np.nan, dtype=np.complex128)
    winding = np.zeros(count, dtype=np.int64)
    error = np.full(count, np.inf)
    turns = np.arange(options.samples) / options.samples
    corners = [start.towards(target, 1 - radius * np.exp(2j * np.pi * turn)) for turn in turns]
    charts = points.conj()
    under_way = np.arange(count)
    samples = [points]
    for rounds in range(1, options.max_winding + 1):
        for here, there in pairwise([*corners, corners[0]]):
            results = track(here, there, samples[-1], options=tracker)
            # A path that fails has a NaN sample and never returns.
            arrived = (results.status[0] == PathStatus.REGULAR)[:, None]
            moved = np.where(arrived, results.points[0], np.nan)
            with np.errstate(invalid="ignore"):
                samples.append(moved / (moved * charts).sum(axis=1, keepdims=True))
        spread = np.max([np.linalg.norm(s - samples[0], axis=1) for s in samples], axis=0)
        returned = (
            np.linalg.norm(samples[-1] - samples[0], axis=1)
            < options.rounding + options.closure * spread
        )
        if returned.any():
            circle = np.array(samples[:-1])[:, returned]
            mean = circle.mean(axis=0)
            halves = np.linalg.norm(mean - circle[::2].mean(axis=0), axis=1)
            size = np.linalg.norm(mean, axis=1)
            index = under_way[returned]
            ends[index] = mean / size[:, None]
            winding[index] = rounds
            # If another branch point is inside the circle, the mean is no solution at all.
            solved = target.residuals(ends[index]) < options.residual
            error[index] = np.where(solved, halves / size, np.inf)
        going = ~returned & np.isfinite(samples[-1]).all(axis=1)
        under_way, charts = under_way[going], charts[going]
        samples = [s[going] for s in samples]
        if not len(under_way):
            break
    return WindingEnds(ends, winding, error)
