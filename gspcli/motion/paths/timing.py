"""The time of paths: speeds and accelerations below limits.

Of straight ways of values the drives move linearly, so their limits hold exactly. On straight ways
of poses the speeds and accelerations of drives, and of the turn of the platform, are those at
samples, with a margin. The platform stops at corners: on each straight part its
speed rises, stays and falls.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import ArgumentError
from gspcli.motion.paths.guides import Guide, GuideRows, PoseGuide, RowsOnWay
from gspcli.motion.paths.pose_ways import PoseWays
from gspcli.records import dataclass

Array = NDArray[np.float64]
#: What can be limited: each drive, the pivot, the turn of the platform.
DRIVES, PLATFORM, TURN = NAMES = ("drives", "platform", "turn")
#: The least rows of a part.
_CHANGING = 12
#: Shares of the acceleration that full speed may need on a bent way of the drives.
_BENT = (0.02, 0.1, 0.25, 0.5, 0.75, 0.9)
#: Speeds and accelerations are this much larger than what is computed exactly, or from samples.
_MARGIN, _SAMPLED = 1 + 1e-9, 1 + 1e-5
#: Samples of a move of a pose; the step of differences, in sizes of the platform.
_SAMPLES, _STEP = 400, 1e-4


@dataclass(frozen=True)
class PathLimits:
    """Limits of speeds and accelerations.

    Attributes
    ----------
    speed, acceleration
        By name: of each of the ``drives`` (lengths, or angles in the unit of the instance), of the
        ``platform``'s pivot (lengths), of its ``turn`` (angles); a second, and a second squared.
    """

    speed: Mapping[str, float]
    acceleration: Mapping[str, float]

    @classmethod
    def of(
        cls,
        speed: float | Mapping[str, float] | None,
        acceleration: float | Mapping[str, float] | None,
    ) -> PathLimits | None:
        """Return limits from numbers, which are of the drives, or by name; None without any.

        Raises
        ------
        ArgumentError
            If only one is given, a number is not positive, or something would be unlimited.
        """
        if speed is None and acceleration is None:
            return None
        both = {"speed": speed, "acceleration": acceleration}
        found = {}
        for name, given in both.items():
            if given is None:
                raise ArgumentError(
                    "found none: a path is timed by a speed and an acceleration", name
                )
            limits = dict(given) if isinstance(given, Mapping) else {DRIVES: float(given)}
            for what, number in limits.items():
                if what not in NAMES:
                    raise ArgumentError(
                        f"found {what!r}, expected {', '.join(NAMES[:-1])} or {TURN}", name
                    )
                if not (np.isfinite(number) and number > 0):
                    raise ArgumentError(
                        f"found {number} for {what}, expected a number above zero", name
                    )
            if DRIVES not in limits and not {PLATFORM, TURN} <= set(limits):
                raise ArgumentError(
                    "found no limit of the drives, nor of both the platform and its turn", name
                )
            found[name] = limits
        return cls(**found)

    @property
    def of_platform(self) -> bool:
        """Whether the platform is limited, too, not only the drives."""
        return bool({*self.speed, *self.acceleration} - {DRIVES})

    def arrays(self, drives: int, in_radians: float) -> tuple[Array, Array]:
        """Return the limits in the order of `Rates.largest`, infinite where there is none."""
        units = [1.0] * drives + [1.0, in_radians]
        names = [DRIVES] * drives + [PLATFORM, TURN]
        speed, acceleration = (
            np.array([limits.get(n, np.inf) * u for n, u in zip(names, units, strict=True)])
            for limits in (self.speed, self.acceleration)
        )
        return speed, acceleration


@dataclass(frozen=True, eq=False)
class Timing:
    """The time of a path.

    Attributes
    ----------
    limits
        What was asked for.
    moves
        The moves, in values or in positions and angles.
    """

    limits: PathLimits
    moves: Moves

    @property
    def seconds(self) -> float:
        """How long the path takes."""
        return self.moves.seconds

    def to_json(self) -> dict[str, Any]:
        """Return it as plain data."""
        return {
            "seconds": self.seconds,
            "speed": dict(self.limits.speed),
            "acceleration": dict(self.limits.acceleration),
            "corners": len(self.moves.tops) - 1,
        }


class TimedTrace(NamedTuple):
    """Rows of a path with their times."""

    trace: GuideRows
    t: Array
    """Seconds, shape (r,)."""
    timing: Timing


def _value_line(way: Array, speed: Array, acceleration: Array) -> LineMove:
    """Return a straight part of drives that move linearly."""
    duration = float((np.abs(way) / speed).max()) * _MARGIN
    with np.errstate(divide="ignore"):
        rise = float((acceleration * duration / np.abs(way)).min()) / _MARGIN
    return LineMove(way, duration, rise)


class Rates:
    """Speeds and accelerations of what moves with position and angles.

    Parameters
    ----------
    ways
        The ways of poses of a platform.
    """

    def __init__(self, ways: PoseWays) -> None:
        self.ways = ways

    def _drives(self, R: Array, T: Array) -> Array:
        """Return what the drives are at along rows of poses, in their units, shape (r, m)."""
        return self.ways.machine.along(R, T) / self.ways.machine.units

    @property
    def count(self) -> int:
        """The number of drives."""
        return self.ways.machine.count

    def largest(self, place: Array, way: Array) -> tuple[Array, Array]:
        """Return the largest speeds and accelerations at samples of a straight way in one second.

        Parameters
        ----------
        place, way
            Its beginning, and how far the parameters change, shape (6,) each.

        Returns
        -------
        speeds, accelerations
            Of the m drives in the units of the instance, of the pivot, and of the turn of the
            platform in radians, shapes (m + 2,). Infinite where a drive does not reach.
        """
        step = _STEP / max(float((np.abs(way) / self.ways.sizes).max()), 1e-300)
        middles = np.linspace(0.0, 1.0, _SAMPLES + 1)[:, None]
        t = (middles + step * np.array([-1.0, 0.0, 1.0])).ravel()[:, None]
        R, T = self.ways.poses(place + way * t)
        x = self._drives(R, T).reshape(len(middles), 3, -1)
        R = R.reshape(-1, 3, 3, 3)
        before, after = (R[:, k].swapaxes(1, 2) @ R[:, k + 1] for k in range(2))
        first, second = (_spin(one) for one in (before, after))
        speeds = [
            np.abs(x[:, 2] - x[:, 0]) / (2 * step),
            np.full((len(middles), 1), np.linalg.norm(way[:3])),
            np.linalg.norm(first + second, axis=1)[:, None] / (2 * step),
        ]
        bends = [
            np.abs(x[:, 2] - 2 * x[:, 1] + x[:, 0]) / step**2,
            np.zeros((len(middles), 1)),
            np.linalg.norm(second - first, axis=1)[:, None] / step**2,
        ]
        both = (np.concatenate(parts, axis=1).max(axis=0) for parts in (speeds, bends))
        fastest, most = (np.where(np.isnan(one), np.inf, one * _SAMPLED) for one in both)
        return fastest, most


def _spin(turns: Array) -> Array:
    """Return the vectors of small rotations, ``(n, 3, 3) -> (n, 3)``."""
    odd = (turns - turns.swapaxes(1, 2)) / 2
    return np.stack((odd[:, 2, 1], odd[:, 0, 2], odd[:, 1, 0]), axis=1)


def _pose_line(rates: Rates, first: Array, way: Array, v: Array, a: Array) -> LineMove:
    """Return a straight part in position and angles: drives at samples."""
    speeds, bends = rates.largest(first, way)
    best, time = LineMove(way, np.inf, 0.0), np.inf
    for share in _BENT:
        duration = max(float((speeds / v).max()), float(np.sqrt((bends / (share * a)).max())))
        duration *= _MARGIN
        with np.errstate(divide="ignore", invalid="ignore"):
            left = (a - bends / duration**2) * duration / speeds
        rise = float(np.fmin(left, np.inf).min()) / _MARGIN
        quick = rise * duration >= 1
        here = duration + 1 / rise if quick else 2 * np.sqrt(duration / rise)
        if here < time:
            best, time = LineMove(way, duration, rise), here
    if not np.isfinite(time):
        raise ArgumentError("a drive does not reach the path", "speed")
    return best


def timed(
    guide: Guide, corners: Array, limits: PathLimits, counts: NDArray[np.int64]
) -> TimedTrace | None:
    """Return rows along a path with their times, or None if they are not proved.

    Parameters
    ----------
    guide
        Proves paths.
    corners
        Those of a proved path, shape (k + 1, 6); the platform stops at them.
    limits
        Of speeds and accelerations.
    counts
        About how many rows each straight part has, shape (k,).
    """
    moving = [k for k in range(len(counts)) if np.any(corners[k] != corners[k + 1])]
    places = np.stack([corners[0], *(corners[k + 1] for k in moving)])
    if not moving:
        trace = guide.trace(corners, counts)
        still = Moves(*np.zeros((2, 1)), *np.zeros((3, 0)))
        return (
            None
            if trace is None
            else TimedTrace(trace, 0.0 * trace.fraction, Timing(limits, still))
        )
    if isinstance(guide, PoseGuide):
        rates = Rates(guide.ways)
        v, a = limits.arrays(rates.count, guide.ways.instance.units.angle.in_radians)
        lines = [_pose_line(rates, x, y - x, v, a) for x, y in pairwise(places)]
    else:
        v, a = (one[: guide.sizes.size] for one in limits.arrays(guide.sizes.size, 1.0))
        lines = [_value_line(y - x, v, a) for x, y in pairwise(places)]
    moves = moves_of(places, lines)
    times = [
        np.linspace(begin, end, max(int(n), _CHANGING) + 1)[:-1]
        for (begin, end), n in zip(pairwise(moves.begins), counts[moving], strict=True)
    ]
    t = np.append(np.concatenate(times), moves.seconds)
    numbers, part = moves.at(t)
    numbers[-1] = places[-1]
    fraction = (t - moves.begins[part]) / np.diff(moves.begins)[part]
    trace = guide.through(RowsOnWay(np.asarray(part, np.int64), fraction, numbers))
    return None if trace is None else TimedTrace(trace, t, Timing(limits, moves))


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
