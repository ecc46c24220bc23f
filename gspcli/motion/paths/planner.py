"""From one pose to another: a proved path, a proof that there is none, or neither.

What costs least is tried first:

- the limits at the ends, and the signs that a regular path cannot change (`classes`);
- the straight way of values, and the straight way in position and angles;
- the proof that the mode fills its ranges (`value_ways`);
- a map (`maps`), and a smoother path.

Last the rows that are returned are proved.

Paths are made smoother by short cuts and moves of corners, each proved. The cost of a path is the
integral of its condition number by its length, in lengths of the platform. The length is that of
the way of the platform's points, as a root mean square. A change is kept if the new path is proved
and costs less. While a path is longer than three times the straight way, more tries follow in which
the condition number counts less. The numbers of tries are fixed, so that the result does not depend
on the speed of the computer. A change must save a thousandth of the cost, so that the result does
not depend on last digits either.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.defaults import PATH_SECONDS, SEED
from gspcli.errors import ArgumentError, IncompleteError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.limits import has_limits
from gspcli.geometry.machine import Machine
from gspcli.geometry.readings import without_corrections
from gspcli.motion.collisions.compared import NO_SHAPES, ComparedShapes
from gspcli.motion.paths.between import least_clearances, least_gaps
from gspcli.motion.paths.classes import Classes
from gspcli.motion.paths.ends import End, Modes, PathEnd
from gspcli.motion.paths.guides import (
    PROVED_ROWS,
    DriveGuide,
    Guide,
    GuideRows,
    PoseGuide,
    ValueGuide,
)
from gspcli.motion.paths.maps import PoseMap, ValueMap
from gspcli.motion.paths.planned_paths import PathPart, PlannedPath, cost, steps
from gspcli.motion.paths.pose_ways import PoseWays
from gspcli.motion.paths.timing import PathLimits, timed
from gspcli.motion.paths.value_ways import Sheet, ValueWays, whole_sheet
from gspcli.motion.workspace.travels import too_near, violations

Array = NDArray[np.float64]
#: Yields None while it goes on, and at last a path with what proves it.
Search = Iterator[tuple[Guide, Array] | None]
#: How many times as many rows of a way of values are tried as places of straight ways of poses.
_FINER = (1, 4, 16)
#: Random tries, at first and with each of the other powers of the condition number.
_TRIES, _MORE, _POWERS = 400, 300, (0.5, 0.25)
#: Random tries where each proof has clearances or gaps, which take long.
_SLOW_TRIES = 40
#: A path that is this many times as long as the straight way is long.
LONG = 3.0
_ROWS = np.array([PROVED_ROWS])
#: How far corners are moved, by their ranges, and what a change must be worth.
_MOVES, _WORTH = (0.02, 0.08, 0.25), 1e-3
#: How far a platform moves from row to row, in its lengths; how many rows a part has.
_STEP, _LEAST, _MOST = 0.03, 4, 200


def path(
    instance: Instance,
    start: End,
    goal: End,
    *,
    along: str | None = None,
    clear: float = 0.0,
    gap: float | None = None,
    time: float = PATH_SECONDS,
    seed: int = SEED,
    pivot: Sequence[float] | None = None,
    sequence: str = "ZYX",
    speed: float | Mapping[str, float] | None = None,
    acceleration: float | Mapping[str, float] | None = None,
) -> PlannedPath:
    """Plan a path from one pose to another that is proved on the whole way.

    No pose of the path is singular, and all of them keep the ranges and cones that the instance
    states. If it is proved that there is no such path, the answer says why.

    Parameters
    ----------
    instance
        The platform with its limits.
    start, goal
        A mode by its number of `solve`, ``home``, or a pose (R, T).
    along
        Whether the ``values`` change linearly between the corners of the path, or position and
        angles (``poses``). None tries both straight ways; paths with corners are along values if
        each value has a range, else along poses. With cranks or slides ``values`` are the numbers
        of all drives, and paths with corners are along poses.
    clear
        The clearance that every pose must have, in the units of `clearance`; with cranks or slides
        that of the drives.
    gap
        How far legs and bodies must be apart at every pose, in the unit of length; the instance
        must state their shapes. None for no such limit.
    time
        After this many seconds no more paths are tried. The bytes of a path that is found do not
        depend on it.
    seed
        The seed of all random numbers: the same seed gives the same path.
    pivot, sequence
        The point of the platform, in its frame, and the order of the axes of the angles of straight
        ways of poses.
    speed, acceleration
        Limits on the whole way, also between rows; then the rows have times in seconds. A number is
        of each drive, in the unit of its value a second (squared). By name: of the ``drives``, of
        the ``platform``'s pivot, and of its ``turn`` in the unit of angles; the last two are proved
        on ways of poses.

    Raises
    ------
    ArgumentError
        If an argument is wrong.

    Examples
    --------
    >>> import gspcli
    >>> platform = gspcli.example("workspace-study")
    >>> found = gspcli.path(platform, "home", 3)
    >>> found.verdict, found.along
    ('proved', 'values')
    >>> gspcli.path(platform, "home", 2).reason
    'the sign of det J differs, and a regular path keeps it'
    """
    planner = Planner(
        instance, along=along, clear=clear, gap=gap, seconds=time, seed=seed, pivot=pivot,
        sequence=sequence, limits=PathLimits.of(speed, acceleration),
    )  # fmt: skip
    modes = Modes(instance)
    return planner.path(modes.end(start, "start"), modes.end(goal, "goal"))


class Planner:
    """Plans paths of one platform.

    Parameters
    ----------
    instance
        The platform with its limits.
    along
        ``values``, ``poses``, or None for both.
    clear
        The clearance that every pose must have, in the units of `gsp clearance`.
    gap
        The least gap between legs and bodies; None if gaps are not tested.
    seconds
        After this time nothing more is tried.
    seed
        Of everything random.
    pivot, sequence
        The point of the platform and the order of angles of straight ways of poses.
    limits
        Of speeds and accelerations, if paths are to have a time.
    """

    def __init__(
        self,
        instance: Instance,
        *,
        along: str | None = None,
        clear: float = 0.0,
        gap: float | None = None,
        seconds: float = PATH_SECONDS,
        seed: int = SEED,
        pivot: ArrayLike | None = None,
        sequence: str = "ZYX",
        limits: PathLimits | None = None,
    ) -> None:
        if along not in (None, "values", "poses"):
            raise ArgumentError(f"found {along!r}, expected values or poses", "along")
        if not (np.isfinite(seconds) and seconds >= 0):
            raise ArgumentError(f"found {seconds}, expected seconds, not negative", "time")
        if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
            raise ArgumentError(f"found {seed!r}, expected a whole number, not negative", "seed")
        if not (clear >= 0 and np.isfinite(clear)):
            raise ArgumentError(f"found {clear}, expected a number that is not negative", "clear")
        if limits is not None and limits.of_platform:
            if along == "values":
                raise ArgumentError(
                    "found a limit of the platform, which is proved along poses only", "speed"
                )
            along = "poses"
        self.limits = limits
        if gap is not None:
            _check_gap(instance, gap)
        self.gap = gap
        self.given = instance
        self.instance = without_corrections(instance)
        self.along, self.clear, self.seed = along, clear, int(seed)
        self.seconds = seconds
        self._first: PathEnd | None = None
        self._axes = {"pivot": pivot, "sequence": sequence}

    @cached_property
    def machine(self) -> Machine:
        """The cranks and slides in the working modes of the stated home, else of the start."""
        machine = Machine.of(self.instance)
        if not machine.moves:
            return machine.at_home()
        if self._first is None and self.instance.home is None:
            raise ArgumentError(
                "the file states no home: the working modes of its cranks and slides are not known"
            )
        pose = (None, None) if self._first is None else (self._first.R, self._first.T)
        return machine.at_home(*pose)

    @cached_property
    def ways(self) -> PoseWays:
        """Straight ways in position and angles that keep the limits."""
        return PoseWays(
            self.instance,
            limits=True,
            working_modes=self.machine.signs,
            **self._axes,  # type: ignore[arg-type]
        )

    @cached_property
    def classes(self) -> Classes:
        """The signs that regular paths keep."""
        return Classes(
            self.instance, PoseWays(self.instance, limits=False, working_modes=self.machine.signs)
        )

    def values(self, end: PathEnd) -> ValueWays:
        """Return straight ways of values on the sides of a pose."""
        return ValueWays(self.instance, np.sign(end.values))

    def path(self, start: PathEnd, goal: PathEnd) -> PlannedPath:
        """Plan a path from one pose to another."""
        self._first = start
        reason = self._impossible(start, goal)
        if reason:
            return PlannedPath(self.given, start.name, goal.name, "impossible", reason)
        deadline = time.monotonic() + self.seconds
        guide, corners = self._straight(start, goal)
        if guide is None and not self.machine.moves:
            ways = self.values(start)
            if any(self.fills_ranges(end, ways) for end in (start, goal)):
                reason = "the mode fills its box of ranges, and the other pose is not on it"
                return PlannedPath(self.given, start.name, goal.name, "impossible", reason)
        if guide is None:
            guide, corners = self._on_map(start, goal, lambda: time.monotonic() < deadline)
        if guide is None or corners is None:
            reason = "no path was found in the time given, and none is proved to be impossible"
            return PlannedPath(self.given, start.name, goal.name, "not found", reason)
        if len(corners) > 2:
            corners = smoothed(self.instance, guide, corners, self.seed)
        return finished(self.given, guide, corners, start, goal, self.limits)

    @property
    def stays(self) -> bool:
        """Whether some value that no crank or slide moves must stay: random poses change it."""
        return bool(self.machine.stays.any())

    def left(self, end: PathEnd) -> str:
        """Return the first limit that a pose violates, in words, or nothing."""
        machine = self.machine
        if end.is_mode and self.instance.home is not None:
            other = machine.in_other_working_modes(end.R[None], end.T[None])[0]
            if other.any():
                name = machine.names[machine.index[int(other.argmax())]]
                return f"{name.replace('.', ' ')} is beyond a dead point from home"
        return next(iter(violations(self.instance, end.R, end.T, machine.signs)), "")

    def _impossible(self, start: PathEnd, goal: PathEnd) -> str:
        """Return why there can be no path, or nothing."""
        for end in (start, goal):
            wrong = self.left(end)
            if wrong:
                return f"{end.name} is outside the limits: {wrong}"
            wrong = self._too_near(end)
            if wrong:
                return f"{end.name}: {wrong}"
        first, last = (self.classes.of(end.R, end.T) for end in (start, goal))
        place = first.differs(last)
        if place is not None:
            return f"the sign of {self.classes.name(place)} differs, and a regular path keeps it"
        return ""

    def _too_near(self, end: PathEnd) -> str:
        """Return which legs or bodies are proved to be too near at an end, or nothing."""
        if self.gap is None:
            return ""
        return next(iter(too_near(self.instance, end.R, end.T, self.gap)), "")

    def _straight(self, start: PathEnd, goal: PathEnd) -> tuple[Guide | None, Array | None]:
        """Return a straight path of values or drives, or of poses, if one is proved."""
        tried: list[Callable[[], tuple[Guide, Array]]] = []
        # A straight way of equal values would stay where it is.
        moves = any(not np.array_equal(x, y) for x, y in ((start.R, goal.R), (start.T, goal.T)))
        still = np.array_equal(start.values, goal.values) and moves
        if self.along != "poses" and self.machine.moves:
            drives = DriveGuide(self.machine, self.ways, start, goal, self.clear, self.gap)
            tried.append(lambda: (drives, drives.corners))
        elif self.along != "poses" and not still:
            values = np.stack((start.values, goal.values))
            tried.append(lambda: (self.value_guide(self.values(start), start, goal), values))
        if self.along != "values":
            tried.append(lambda: (self.pose_guide(), np.stack(self._parameters(start, goal))))
        for one in tried:
            guide, corners = one()
            if guide.trace(corners, _ROWS) is not None:
                return guide, corners
        return None, None

    def value_guide(self, ways: ValueWays, start: PathEnd, goal: PathEnd) -> ValueGuide:
        """Return what proves polygons of values between two ends."""
        first, last = (ways.points(end.R[None], end.T[None])[0] for end in (start, goal))
        return ValueGuide(ways, first, last, self.clear, self.gap)

    def pose_guide(self) -> PoseGuide:
        """Return what proves polygons of poses."""
        return PoseGuide(self.ways, Arrangement.of(self.instance).length, self.clear, self.gap)

    def _parameters(self, start: PathEnd, goal: PathEnd) -> tuple[Array, Array]:
        begin, end = (self.ways.parameters(one.R, one.T) for one in (start, goal))
        return begin, self.ways.nearest(begin, end)

    def fills_ranges(self, end: PathEnd, ways: ValueWays | None = None) -> bool:
        """Whether it is proved that a mode is one pose for all values in the ranges.

        Parameters
        ----------
        end
            The mode.
        ways
            Straight ways of values; None for those on the sides of the mode.
        """
        if self.machine.moves or self.clear or self.gap is not None:
            return False
        ways = self.values(end) if ways is None else ways
        if not ways.ranged:
            return False
        point = ways.points(end.R[None], end.T[None])[0]
        return whole_sheet(ways, end.values, point) is Sheet.WHOLE

    def value_map(self, ends: Sequence[PathEnd]) -> ValueMap:
        """Return a map of values with some ends, on the sides of the first."""
        values, R, T = (np.stack([getattr(end, n) for end in ends]) for n in ("values", "R", "T"))
        ways = self.values(ends[0])
        return ValueMap(ways, self.instance, values, R, T, seed=self.seed)

    def pose_map(self, ends: Sequence[PathEnd]) -> PoseMap:
        """Return a map of poses with some ends."""
        R, T = np.stack([end.R for end in ends]), np.stack([end.T for end in ends])
        limited = has_limits(self.instance) or self.machine.moves or self.gap is not None
        kept = self.pose_guide().kept if limited else None
        classes = [self.classes.of(end.R, end.T) for end in ends]
        return PoseMap(self.ways, R, T, classes, self.classes.of, seed=self.seed, kept=kept)

    def _on_map(
        self, start: PathEnd, goal: PathEnd, more: Callable[[], bool]
    ) -> tuple[Guide | None, Array | None]:
        """Return a path on a map of values or poses, if one is found while there is time."""
        if self.machine.moves:
            # Random poses change what must stay.
            turns = self._parameters(start, goal)
            level = not self.machine.shared or (turns[0][3:] == turns[1][3:]).all()
            on_map = self.along != "values" and not self.stays and level
            return _first([self._on_poses(start, goal)], more) if on_map else (None, None)
        ranged = self.values(start).ranged
        if (self.along or ("values" if ranged else "poses")) == "values":
            return _first([self._on_values(start, goal)], more)
        searches = [self._on_poses(start, goal)]
        if ranged:
            searches.insert(0, self._near_values(start, goal))
        return _first(searches, more)

    def _on_values(self, start: PathEnd, goal: PathEnd) -> Search:
        """Search on a map of values."""
        found = self.value_map((start, goal))
        guide = self.value_guide(found.ways, start, goal)
        while True:
            corners = found.way(0, 1)
            if corners is None:
                yield None
                found.grow()
            elif guide.trace(corners, np.full(len(corners) - 1, PROVED_ROWS)) is not None:
                guide.widen(corners)
                yield guide, corners
            else:
                self._refuse(found, guide)
                yield None

    def _near_values(self, start: PathEnd, goal: PathEnd) -> Search:
        """Search on a map of values; straight ways of poses lead along the way that it has."""
        poses, ends = self.pose_guide(), self._parameters(start, goal)
        for found in self._on_values(start, goal):
            if found is None:
                yield None
                continue
            guide, corners = found
            for finer in _FINER:
                trace = guide.trace(corners, np.full(len(corners) - 1, finer * PROVED_ROWS))
                if trace is None:
                    return
                places = self.ways.continued(trace.rows.R, trace.rows.T)
                places = np.stack([ends[0], *places[1:-1], self.ways.nearest(places[-2], ends[1])])
                polygon = _polygon(poses, places)
                if polygon is not None:
                    yield poses, polygon
                    return

    def _refuse(self, found: ValueMap, guide: ValueGuide) -> None:
        """Take the first edge of a way away that does not keep cones or clearance."""
        nodes = found.nodes(0, 1)
        assert nodes is not None
        for a, b in pairwise(nodes):
            one = ValueGuide(guide.ways, found.points[a], found.points[b], self.clear, self.gap)
            corners = np.stack((found.values[a], found.values[b]))
            if one.trace(corners, _ROWS) is None:
                found.refuse(a, b)
                return
        # Each part is proved alone, and all of them together are not: rounding at a corner.
        found.refuse(nodes[0], nodes[1])

    def _on_poses(self, start: PathEnd, goal: PathEnd) -> Search:
        """Search on a map of poses."""
        guide = self.pose_guide()
        found = self.pose_map((start, goal))
        found.join_given()
        while True:
            corners = found.way(0, 1)
            if corners is None:
                yield None
                found.grow()
                continue
            way = np.array(corners)
            if guide.trace(way, np.full(len(way) - 1, PROVED_ROWS)) is not None:
                yield guide, way
            else:
                found.refuse_on_way(0, 1, lambda one: guide.trace(one, _ROWS) is not None)
                yield None


def _polygon(guide: PoseGuide, places: Array) -> Array | None:
    """Return corners of a proved polygon through some places, long straight ways first."""
    corners, spans = [places[0]], [(0, len(places) - 1)]
    while spans:
        first, last = spans.pop()
        if guide.trace(places[[first, last]], _ROWS) is not None:
            corners.append(places[last])
        elif last - first == 1:
            return None
        else:
            middle = (first + last) // 2
            spans += [(middle, last), (first, middle)]
    return np.array(corners)


def _first(searches: list[Search], more: Callable[[], bool]) -> tuple[Guide | None, Array | None]:
    """Return what the first of some searches finds; all take turns while there is time.

    Which one it is does not depend on the time.
    """
    while True:
        for search in searches:
            found = next(search, None)
            if found is not None:
                return found
        if not more():
            return None, None


def _check_gap(instance: Instance, gap: float) -> None:
    """Raise `ArgumentError` if a gap cannot be kept along paths of a platform."""
    if not np.isfinite(gap):
        raise ArgumentError(f"found {gap}, expected a finite number", "gap")
    if instance.shapes is None:
        raise ArgumentError(NO_SHAPES, "gap")


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
    straight = float(steps(instance, trace.rows.R[ends], trace.rows.T[ends])[0])
    length = float(steps(instance, trace.rows.R, trace.rows.T).sum())
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
                found = (
                    np.inf if trace is None else cost(instance, trace.rows.R, trace.rows.T, power)
                )
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


def finished(
    given: Instance,
    guide: Guide,
    corners: Array,
    start: PathEnd,
    goal: PathEnd,
    limits: PathLimits | None = None,
) -> PlannedPath:
    """Return a path with its rows.

    Parameters
    ----------
    given
        The platform, with offsets of readings.
    guide
        Proves paths.
    corners
        Those of a proved path, shape (k + 1, 6).
    start, goal
        Its ends.
    limits
        Of speeds and accelerations, if the path has a time.

    Raises
    ------
    IncompleteError
        If the rows cannot be proved, though the path was.
    """
    proved = np.full(len(corners) - 1, PROVED_ROWS)
    trace = guide.trace(corners, proved)
    timing, t = None, None
    if trace is not None:
        length = Arrangement.of(given).length
        wanted = np.ceil(_lengths(given, trace) / (_STEP * length))
        counts = np.clip(wanted, _LEAST, _MOST).astype(np.int64)
        # Long steps near singular poses are not proved; those of the search are.
        for tried in (counts, np.maximum(counts, proved)):
            if limits is not None:
                found = timed(guide, corners, limits, tried)
                if found is not None:
                    trace, t, timing = found
                    break
            elif (rowed := guide.trace(corners, tried)) is not None:
                trace = rowed
                break
    if trace is None or (limits is not None and timing is None):
        raise IncompleteError("the path that was found could not be proved again: try another seed")
    rows = trace.rows
    # Those of drives take long.
    moves = rows.machine.moves
    if guide.clear or not moves:
        at, between = least_clearances(rows, guide.clear)
    else:
        at, between = np.zeros(len(rows.T)), np.zeros(len(rows.T) - 1)
    conditions = rows.conditions()
    gaps = None if guide.gap is None else least_gaps(rows, guide.gap)[1]
    first = np.searchsorted(trace.part, np.arange(len(trace.proofs)))
    last = np.append(first[1:], len(trace.part) - 1)
    lengths = _lengths(given, trace)
    parts = tuple(
        PathPart(
            int(a),
            int(b),
            int(trace.proofs[k]),
            float(lengths[k]),
            float(conditions[a : b + 1].max()),
            float(between[a:b].min()),
            gap=None if gaps is None else float(gaps[a:b].min()),
        )
        for k, (a, b) in enumerate(zip(first.tolist(), last.tolist(), strict=True))
    )
    return PlannedPath(
        given, start.name, goal.name, "proved", "", guide.along,
        trace.part + trace.fraction if t is None else t,
        rows.values, rows.R, rows.T, conditions, at, parts, timing,
        rows.drive_numbers() if moves else None,
        None if gaps is None else ComparedShapes(given).gaps(rows.R, rows.T).min(axis=1),
    )  # fmt: skip


def _lengths(instance: Instance, trace: GuideRows) -> Array:
    """Return the length of each straight part."""
    moved = steps(instance, trace.rows.R, trace.rows.T)
    return np.asarray(
        np.bincount(trace.part[:-1], weights=moved, minlength=len(trace.proofs)), float
    )
