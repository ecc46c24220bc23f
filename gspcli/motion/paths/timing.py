"""The time of paths: speeds and accelerations below limits.

Of straight ways of values the motors move linearly, so their limits hold exactly. On straight ways
of poses the speeds and accelerations of motors, and of the turn of the platform, are those at
samples, with a margin. Corners are stops, or parabolas that are
proved again: of values in the boxes about their rows that the clearance proves, of poses in boxes
that are proved to keep all limits.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import ArgumentError
from gspcli.motion.paths.guides import Guide, GuideRows, PoseGuide, RowsOnWay, ValueGuide
from gspcli.motion.paths.moves import Corner, LineMove, Moves, moves_of
from gspcli.motion.paths.pose_ways import PoseWays
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: What can be limited: each motor, the pivot, the turn of the platform.
MOTORS, PLATFORM, TURN = NAMES = ("motors", "platform", "turn")
#: Shares of the parts that a parabola may have: the first one that is proved.
_SHARES = (0.45, 0.2, 0.08, 0.03, 0.01)
#: Where a parabola is too quick, its rate is lowered by this factor; below the least one it stops.
_SLOWER, _SLOWEST = 0.97, 0.05
#: Rows of a parabola, least rows while the speed changes.
_CURVED, _CHANGING = 16, 4
#: Shares of the acceleration that full speed may need on a bent way of the motors.
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
        By name: of each of the ``motors`` (lengths, or angles in the unit of the instance), of the
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
        """Return limits from numbers, which are of the motors, or by name; None without any.

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
                message = "found none: a path is timed by a speed and an acceleration"
                raise ArgumentError(message, name)
            limits = dict(given) if isinstance(given, Mapping) else {MOTORS: float(given)}
            for what, number in limits.items():
                if what not in NAMES:
                    message = f"found {what!r}, expected {', '.join(NAMES[:-1])} or {TURN}"
                    raise ArgumentError(message, name)
                if not (np.isfinite(number) and number > 0):
                    message = f"found {number} for {what}, expected a number above zero"
                    raise ArgumentError(message, name)
            if MOTORS not in limits and not {PLATFORM, TURN} <= set(limits):
                message = "found no limit of the motors, nor of both the platform and its turn"
                raise ArgumentError(message, name)
            found[name] = limits
        return cls(**found)

    @property
    def of_platform(self) -> bool:
        """Whether the platform is limited, too, not only the motors."""
        return bool({*self.speed, *self.acceleration} - {MOTORS})

    def arrays(self, motors: int, in_radians: float) -> tuple[Array, Array]:
        """Return the limits in the order of `Rates.largest`, infinite where there is none."""
        units = [1.0] * motors + [1.0, in_radians]
        names = [MOTORS] * motors + [PLATFORM, TURN]
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
    rounded
        How many corners are rounded; at the others the platform stops.
    corners
        How many corners there are.
    """

    limits: PathLimits
    moves: Moves
    rounded: int
    corners: int

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
            "corners": self.corners,
            "rounded": self.rounded,
        }


class TimedTrace(NamedTuple):
    """Rows of a path with their times."""

    trace: GuideRows
    t: Array
    """Seconds, shape (r,)."""
    timing: Timing
    curved: NDArray[np.bool_]
    """Which parts of the trace are parabolas at corners."""


class _Law(Protocol):
    """What limits the moves along the parts of a path."""

    def line(self, first: Array, last: Array) -> LineMove:
        """Return a straight part with its limits."""
        ...

    def bend(self, corner: Array, change: Array) -> float:
        """Return how long a change of the velocity at a corner takes at least."""
        ...

    def excess(self, moves: Moves, k: int) -> float:
        """Return by which factor a curved move is too quick; at most 1 if it is not."""
        ...


class _ValueLaw:
    """Limits of motors that move linearly."""

    def __init__(self, speed: Array, acceleration: Array) -> None:
        self._speed, self._acceleration = speed, acceleration

    def line(self, first: Array, last: Array) -> LineMove:
        way = last - first
        duration = float((np.abs(way) / self._speed).max()) * _MARGIN
        with np.errstate(divide="ignore"):
            rise = float((self._acceleration * duration / np.abs(way)).min()) / _MARGIN
        return LineMove(way, duration, rise)

    def bend(self, corner: Array, change: Array) -> float:
        del corner
        return float((np.abs(change) / self._acceleration).max()) * _MARGIN

    def excess(self, moves: Moves, k: int) -> float:
        del moves, k
        return 0.0


class Rates:
    """Speeds and accelerations of what moves with position and angles.

    Parameters
    ----------
    ways
        The ways of poses of a platform.
    """

    def __init__(self, ways: PoseWays) -> None:
        self.ways = ways

    def _motors(self, R: Array, T: Array) -> Array:
        """Return what the motors are at along rows of poses, in their units, shape (r, m)."""
        motors = self.ways.motors
        if motors is None:
            return values_at(self.ways.instance, R, T)
        return motors.numbers(R, T) / motors.drives.units

    def largest(
        self, place: Array, velocity: Array, acceleration: Array, duration: float
    ) -> tuple[Array, Array]:
        """Return the largest speeds and accelerations at samples of one move of the parameters.

        Parameters
        ----------
        place, velocity, acceleration
            At its beginning, shape (6,) each; the acceleration is constant.
        duration
            Of the move.

        Returns
        -------
        speeds, accelerations
            Of the m motors in the units of the instance, of the pivot, and of the turn of the
            platform in radians, shapes (m + 2,). Infinite where a motor does not reach.
        """
        fast = np.abs(velocity) + np.abs(acceleration) * duration
        step = _STEP / max(float((fast / self.ways.sizes).max()), 1e-300)
        middles = np.linspace(0.0, duration, _SAMPLES + 1 if duration else 1)[:, None]
        t = (middles + step * np.array([-1.0, 0.0, 1.0])).ravel()[:, None]
        R, T = self.ways.poses(place + velocity * t + acceleration * t**2 / 2)
        x = self._motors(R, T).reshape(len(middles), 3, -1)
        R = R.reshape(-1, 3, 3, 3)
        before, after = (R[:, k].swapaxes(1, 2) @ R[:, k + 1] for k in range(2))
        first, second = (_spin(one) for one in (before, after))
        speeds = [
            np.abs(x[:, 2] - x[:, 0]) / (2 * step),
            np.linalg.norm((velocity + acceleration * middles)[:, :3], axis=1)[:, None],
            np.linalg.norm(first + second, axis=1)[:, None] / (2 * step),
        ]
        bends = [
            np.abs(x[:, 2] - 2 * x[:, 1] + x[:, 0]) / step**2,
            np.full((len(middles), 1), np.linalg.norm(acceleration[:3])),
            np.linalg.norm(second - first, axis=1)[:, None] / step**2,
        ]
        both = (np.concatenate(parts, axis=1).max(axis=0) for parts in (speeds, bends))
        fastest, most = (np.where(np.isnan(one), np.inf, one * _SAMPLED) for one in both)
        return fastest, most


def _spin(turns: Array) -> Array:
    """Return the vectors of small rotations, ``(n, 3, 3) -> (n, 3)``."""
    odd = (turns - turns.swapaxes(1, 2)) / 2
    return np.stack((odd[:, 2, 1], odd[:, 0, 2], odd[:, 1, 0]), axis=1)


class _PoseLaw:
    """Limits of what moves with position and angles."""

    def __init__(self, rates: Rates, speed: Array, acceleration: Array) -> None:
        self._rates, self._speed, self._acceleration = rates, speed, acceleration

    def line(self, first: Array, last: Array) -> LineMove:
        way = last - first
        speeds, bends = self._rates.largest(first, way, 0 * way, 1.0)
        v, a = self._speed, self._acceleration
        best = LineMove(way, np.inf, 0.0)
        time = np.inf
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

    def bend(self, corner: Array, change: Array) -> float:
        speeds, _ = self._rates.largest(corner, change, 0 * change, 0.0)
        return float((speeds / self._acceleration).max()) * 2

    def excess(self, moves: Moves, k: int) -> float:
        speeds, bends = self._rates.largest(
            moves.places[k], moves.velocities[k], moves.accelerations[k], moves.durations[k]
        )
        quick = (speeds / self._speed).max()
        return float(max(quick, np.sqrt((bends / self._acceleration).max())))


def timed(
    guide: Guide,
    corners: Array,
    limits: PathLimits,
    counts: NDArray[np.int64],
    *,
    rounded: bool,
) -> TimedTrace | None:
    """Return rows along a path with their times, or None if they are not proved.

    Parameters
    ----------
    guide
        Proves paths.
    corners
        Those of a proved path, shape (k + 1, 6).
    limits
        Of speeds and accelerations.
    counts
        About how many rows each straight part has, shape (k,).
    rounded
        Whether corners are rounded where that is proved.
    """
    law = _law(guide, limits)
    moving = [k for k in range(len(counts)) if np.any(corners[k] != corners[k + 1])]
    places = np.stack([corners[0], *(corners[k + 1] for k in moving)])
    counts = counts[moving]
    lines = [law.line(a, b) for a, b in pairwise(places)]
    turns = [b.full - a.full for a, b in pairwise(lines)]
    bends = [law.bend(place, turn) for place, turn in zip(places[1:-1], turns, strict=True)]
    # Of curved ways of values the cones are not proved.
    cones = isinstance(guide, ValueGuide) and bool(guide.ways.cones)
    round_ = rounded and not cones
    levels = [0 if round_ else len(_SHARES)] * len(bends)
    most = [1.0] * len(bends)
    while True:
        asked = [
            Corner(b, (*_SHARES, 0.0)[n], m) for b, n, m in zip(bends, levels, most, strict=True)
        ]
        moves = moves_of(places, lines, asked)
        quick = _too_quick(law, moves)
        for k, excess in quick.items():
            # Lower rates bend the ways of the motors less, longer parabolas bend less.
            most[k] = float(moves.rates[k + 1]) * _SLOWER / min(excess, 2.0)
            bends[k] *= excess if excess > 1 / _SLOWER else 1.0
            levels[k] = len(_SHARES) if most[k] < _SLOWEST else levels[k]
        if quick:
            continue
        made = _Rows(moves, places, counts)
        trace = guide.through(made.given)
        if trace is not None:
            stops = sum(not rate for rate in moves.rates[1:-1])
            timing = Timing(limits, moves, len(bends) - stops, len(bends))
            return TimedTrace(trace, made.t, timing, made.curved)
        open_ = {k for k, level in enumerate(levels) if level < len(_SHARES)}
        if not open_:
            return None
        wrong = made.corners(guide.refused(made.given)) & open_ or open_
        levels = [level + (k in wrong) for k, level in enumerate(levels)]


def _too_quick(law: _Law, moves: Moves) -> dict[int, float]:
    """Return by which factors the moves at rounded corners are too quick, where they are."""
    found = {}
    for k in np.flatnonzero(moves.round).tolist():
        excess = law.excess(moves, k)
        if excess > 1:
            found[int(moves.parts[k])] = excess
    return found


def _law(guide: Guide, limits: PathLimits) -> _Law:
    if isinstance(guide, PoseGuide):
        ways = guide.ways
        motors = len(ways.instance.constraints) if ways.motors is None else ways.motors.drives.count
        in_radians = ways.instance.units.angle.in_radians
        return _PoseLaw(Rates(ways), *limits.arrays(motors, in_radians))
    motors = guide.sizes.size
    speed, acceleration = limits.arrays(motors, 1.0)
    return _ValueLaw(speed[:motors], acceleration[:motors])


class _Rows:
    """Rows along moves: the ends of all moves, and between them evenly in the time."""

    def __init__(self, moves: Moves, places: Array, counts: NDArray[np.int64]) -> None:
        self.moves = moves
        spans = np.linalg.norm(np.diff(places, axis=0), axis=1)
        times, owners = [], []
        for k, duration in enumerate(moves.durations.tolist()):
            owner = int(moves.parts[k])
            far = np.linalg.norm(moves.at(moves.begins[k : k + 1] + duration)[0] - moves.places[k])
            number = int(np.ceil(counts[owner] * far / spans[owner])) if len(spans) else 1
            if moves.round[k]:
                number = max(number, _CURVED)
            elif moves.accelerations[k].any():
                number = max(number, _CHANGING)
            times.append(moves.begins[k] + duration * np.arange(number) / number)
            owners += [k] * number
        self.t = np.append(np.concatenate(times), moves.seconds)
        move = np.array([*owners, owners[-1]])
        # Straight parts and parabolas are numbered one after the other.
        group = 2 * moves.parts[move] + moves.round[move]
        kept, part = np.unique(group, return_inverse=True)
        self.curved = kept % 2 == 1
        self._move = move
        bend = np.abs(moves.accelerations[move[:-1]]) * moves.round[move[:-1], None]
        bulges = bend * np.diff(self.t)[:, None] ** 2 / 8 * _MARGIN
        numbers = self._numbers(places)
        first = np.searchsorted(part, np.arange(len(kept)))
        begins, ends = self.t[first], np.append(self.t[first[1:]], moves.seconds)
        width = np.maximum(ends - begins, 1e-300)
        fraction = (self.t - begins[part]) / width[part]
        fraction[-1] = 1.0
        self.given = RowsOnWay(
            np.asarray(part, np.int64), fraction, numbers, bulges if self.curved.any() else None
        )

    def _numbers(self, places: Array) -> Array:
        """Return the parameters at the rows; those at stops are the corners themselves."""
        p, v, a = (
            one[self._move]
            for one in (self.moves.places, self.moves.velocities, self.moves.accelerations)
        )
        since = (self.t - self.moves.begins[self._move])[:, None]
        found: Array = p + v * since + a * since**2 / 2
        found[0], found[-1] = places[0], places[-1]
        return found

    def corners(self, refused: list[int]) -> set[int]:
        """Return the rounded corners that are the last ones before some rows."""
        curved = [k for k in range(len(self._move)) if self.moves.round[self._move[k]]]
        found = set()
        for row in refused:
            before = [k for k in curved if k <= row]
            if before:
                found.add(int(self.moves.parts[self._move[before[-1]]]))
        return found
