"""What holds on the whole way between the rows of a proved path, not only at its rows.

A way is cut into pieces. All poses of a piece are near to the one in its middle: on a way of values
or drives by the proved chords that it is followed on, on a way of poses since position and angles
are linear. Each quantity has a measure: its number in the middle of a piece, and by how much it
can change on the piece. Where that does not suffice the piece is halved.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.drives import Drives
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import apply
from gspcli.geometry.residuals import condition_numbers
from gspcli.motion.collisions.compared import ComparedShapes, slips_near
from gspcli.motion.following.followed_rows import RowFollower, Segments
from gspcli.motion.following.moving_geometry import MovingGeometry
from gspcli.motion.paths.condition_bounds import condition_bounds
from gspcli.motion.paths.drive_travels import drive_travels
from gspcli.motion.paths.motors import Motors
from gspcli.motion.paths.pose_ways import PoseWays
from gspcli.motion.paths.value_ways import ValueWays
from gspcli.motion.singularities.clearances import (
    clearances,
    drive_clearances,
    drive_weights,
    range_weights,
)
from gspcli.records import dataclass

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: How often a piece is halved at most; clearances of drives take long.
HALVINGS, CLEARANCE_HALVINGS, _DRIVE_HALVINGS = 14, 8, 3
#: Most pieces that are judged together: beyond that the search ends.
_MOST_PIECES = 10_000
#: Into how many rows ways of values are divided, one after the other, where that is needed, and
#: most of such rows.
_STEPS, _MOST_STEPS = (1, 8, 64), 4000
_OUTWARD = 1 + 2.0**-30
#: Rounding errors of Study points of norm one and of parameters, relative to their sizes.
_ROUNDING = 2.0**-44


@dataclass(frozen=True, eq=False)
class PathRows:
    """Rows of a proved path.

    Attributes
    ----------
    ways
        Straight ways of values, or of poses, whichever leads from row to row.
    values, R, T
        Shapes (r, 6), (r, 3, 3) and (r, 3); the values without offsets.
    parameters
        Position and angles, shape (r, 6), for ways of poses; None for others.
    weights
        The unit of each value's changes in clearances, shape (6,); None for those of the instance.
    motors
        The cranks and slides of the machine, on the knees of the path.
    numbers, geometry
        For ways of drives: what they are at, shape (r, m), and the platform that they move.
    """

    ways: ValueWays | PoseWays
    values: Array
    R: Array
    T: Array
    parameters: Array | None = None
    weights: Array | None = None
    motors: Motors | None = None
    numbers: Array | None = None
    geometry: MovingGeometry | None = None

    @property
    def instance(self) -> Instance:
        """The platform."""
        return self.ways.instance

    @property
    def units(self) -> Array:
        """The unit of each value's or drive's changes in clearances."""
        if self.motors is not None:
            return drive_weights(self.instance)[0]
        weights = range_weights(self.instance) if self.weights is None else self.weights
        return np.ones(6) if weights is None else weights

    def placed(self, R: Array, T: Array, q: Array | None = None) -> Arrangement:
        """Return the platform at poses, its driven points where they are there."""
        if self.motors is None:
            return Arrangement.of(self.instance)
        return self.motors.arrangement(R, T) if q is None else self.motors.drives.arrangement(q)

    def drive_numbers(self) -> Array | None:
        """Return what cranks and slides are at in the rows, shape (r, m); None without motors."""
        if self.motors is None or self.numbers is not None:
            return self.numbers
        return self.motors.numbers(self.R, self.T)

    def conditions(self) -> Array:
        """Return condition numbers at the rows, with the drives still, shape (r,)."""
        length = Arrangement.of(self.instance).length
        return condition_numbers(self.placed(self.R, self.T), self.R, self.T, length)

    def clearances(self, R: Array, T: Array) -> Array:
        """Return proved clearances of poses, in values or drives, shape (n,)."""
        if self.motors is not None:
            return drive_clearances(self.instance, R, T, knees=self.motors.knees)[0]
        return clearances(self.instance, R, T, weights=self.units)

    def travels(self) -> Array:
        """Bound how far values or drives move from row to row, shape (r - 1, 6 or m)."""
        if self.parameters is not None:
            return self.moved(self.parameters[:-1], self.parameters[1:])
        return np.asarray(np.abs(np.diff(self.moving_numbers, axis=0)) * _OUTWARD)

    def moved(self, begins: Array, ends: Array) -> Array:
        """Bound how far values or drives move on straight ways of poses, shape (n, 6 or m)."""
        assert isinstance(self.ways, PoseWays)
        found = drive_travels(self.ways, begins, ends)
        if self.motors is None:
            a = Arrangement.of(self.instance)
            found[:, a.angles] /= a.in_radians
        return found * _OUTWARD

    @property
    def moving_numbers(self) -> Array:
        """Return what changes linearly between rows of values or drives, shape (r, 6 or m)."""
        return self.values if self.numbers is None else self.numbers

    def followed(self) -> tuple[RowFollower, Array] | None:
        """Return what moves linearly between the rows, and its numbers there, shape (r, k)."""
        if self.motors is None:
            assert isinstance(self.ways, ValueWays)
            return self.ways.follower, self.values
        if self.geometry is None or self.numbers is None or self.geometry.rows is None:
            return None
        drives, follower = self.motors.drives, self.geometry.rows
        values = self.values.copy()
        # Rods that drives move have the stated lengths.
        rods = np.array([row.value.value for row in self.geometry.instance.constraints])
        values[:, follower.driven] = rods[follower.driven]
        return follower, np.column_stack((values, (self.numbers / drives.units)[:, drives.moved]))


class Near(NamedTuple):
    """Poses, and how near to them all poses of some pieces are."""

    R: Array
    T: Array
    shifts: Array
    """How far the centre of the platform moves, shape (n,)."""
    turns: Array
    """By which angle the platform turns, in radians, shape (n,)."""
    changes: Callable[[], Array]
    """Returns how far each value, or each drive, is from that in the middle, shape (n, 6 or m)."""
    q: Array | None = None
    """The numbers of cranks and slides at the poses, shape (n, m), if there are any."""
    slips: Array | None = None
    """How far these move the points of constraints, in their bodies, shape (n, 6)."""


#: Returns a quantity in the middle of pieces, and proved lower bounds of it on them, shapes (n,).
Measure = Callable[[Near], tuple[Array, Array]]


def least_clearances(rows: PathRows, wanted: float) -> tuple[Array, Array]:
    """Return proved clearances at rows, (r,), and on the ways between them, (r - 1,).

    A pose whose values or drives differ by at most s from those of one with the clearance r has at
    least ``r - s``. From both ends of a way of length s that gives ``(r1 + r2 - s) / 2``. Poses
    between the rows are looked at if some clearance is wanted.
    """
    at = rows.clearances(rows.R, rows.T)
    travels = (rows.travels() / rows.units).max(axis=1)
    known = (at[:-1] + at[1:] - travels) / 2 / _OUTWARD
    if wanted:
        halvings = CLEARANCE_HALVINGS if rows.motors is None else _DRIVE_HALVINGS

        def measure(near: Near) -> tuple[Array, Array]:
            low = rows.clearances(near.R, near.T)
            return low, low - (near.changes() / rows.units).max(axis=1) * _OUTWARD

        known = _least(rows, at, measure, wanted, halvings, known)
    return at, np.maximum(known, 0.0)


def largest_conditions(rows: PathRows, wanted: float) -> tuple[Array, Array]:
    """Return condition numbers at rows, (r,), and bounds on the ways between them, (r - 1,)."""
    length = Arrangement.of(rows.instance).length

    def measure(near: Near) -> tuple[Array, Array]:
        placed = rows.placed(near.R, near.T, near.q)
        sides = None
        if near.slips is not None and rows.motors is not None:
            on = rows.motors.drives.on_platform
            sides = np.stack([np.where(on == side, near.slips, 0.0) for side in (True, False)])
        at = condition_numbers(placed, near.R, near.T, length)
        most = condition_bounds(placed, near.R, near.T, near.shifts, near.turns, length, sides)
        return -at, -most

    at = rows.conditions()
    return at, -_least(rows, -at, measure, -wanted)


def least_gaps(rows: PathRows, wanted: float) -> tuple[Array, Array]:
    """Return lower bounds of the least gap of legs and bodies at rows and between them."""
    compared = ComparedShapes(rows.instance)
    at = compared.bounds(rows.R, rows.T, rows.drive_numbers()).low.min(axis=1)
    centre = Arrangement.of(rows.instance).platform_centre

    def measure(near: Near) -> tuple[Array, Array]:
        low = compared.bounds(near.R, near.T, near.q).low
        driven = None if near.q is None else (near.R, near.T, near.q)
        places = near.T + apply(near.R, np.broadcast_to(centre, near.T.shape))
        with np.errstate(invalid="ignore"):
            moves = compared.moves(near.shifts, near.turns, centre, places, driven, near.slips)
            bounds = np.nan_to_num((low - moves).min(axis=1), nan=-np.inf, neginf=-np.inf)
        return low.min(axis=1), bounds

    return at, _least(rows, at, measure, wanted)


def least_transmissions(rows: PathRows, wanted: float) -> tuple[Array, Array]:
    """Return the least transmission of all drives at rows, (r,), and bounds between, (r - 1,)."""
    assert rows.motors is not None
    drives = rows.motors.drives
    centre = Arrangement.of(rows.instance).platform_centre

    def measure(near: Near) -> tuple[Array, Array]:
        low, changes = _transmissions(drives, near, centre)
        bounds = np.nan_to_num((low - changes).min(axis=1), nan=-np.inf, neginf=-np.inf)
        return low.min(axis=1), bounds

    q = rows.drive_numbers()
    assert q is not None
    gains = drives.gains(rows.R, rows.T, q)
    at = drives.transmission(gains)[:, drives.driven].min(axis=1)
    return at, _least(rows, at, measure, wanted)


def _transmissions(drives: Drives, near: Near, centre: Array) -> tuple[Array, Array]:
    """Return transmissions of the driven rods, and bounds of their changes, shapes (n, d).

    The transmission is ``|f.b|``: f is the unit vector of the rod r, b the velocity of the driven
    point by the arm. If r changes by at most d, f changes by at most ``2 d / (2 |r| - d)``.
    """
    assert near.q is not None
    assert near.slips is not None
    base, arm, r = drives.ends(near.R, near.T, near.q)
    places = near.T + apply(near.R, np.broadcast_to(centre, near.T.shape))
    # Seen from the body of the driven point; r is a vector of that body.
    own = np.linalg.norm(arm - (places - near.T)[:, None], axis=-1)
    away = np.linalg.norm(places[:, None] - base, axis=-1)
    arms = np.where(drives.on_platform, away, own)
    with np.errstate(all="ignore"):
        change = near.shifts[:, None] + near.turns[:, None] * arms + near.slips
        size = np.linalg.norm(r, axis=-1)
        left = size - change / 2
        turned = np.where(left > 0, change / left, np.inf)
        cranks = np.array([drives.sorts[k] == "crank" for k in drives.index])
        turned += np.where(cranks, near.slips / drives.arms, 0.0)
        far = (
            np.abs(near.T).max(axis=1)[:, None]
            + np.abs(base).max(axis=-1)
            + np.abs(arm).max(axis=-1)
        )
        turned = turned * _OUTWARD + _ROUNDING * (1 + far / size)
    at = drives.transmission(drives.gains(near.R, near.T, near.q))
    return at[:, drives.driven], turned[:, drives.driven]


class PoseParts:
    """Straight ways of poses between rows, each one part.

    Parameters
    ----------
    rows
        The rows.
    way
        Which ways: the indices of the rows before them, shape (w,).
    centre
        Of the platform, shape (3,).
    """

    def __init__(self, rows: PathRows, way: Index, centre: Array) -> None:
        assert rows.parameters is not None
        assert isinstance(rows.ways, PoseWays)
        first, last = rows.parameters[way], rows.parameters[way + 1]
        self.way, self.whole = way, way
        self._rows, self._ways, self._centre = rows, rows.ways, centre
        self._middle, self._change = (first + last) / 2, last - first
        self._away = float(np.linalg.norm(centre - rows.ways.pivot))

    def near(self, part: Index, place: Array, half: float) -> Near:
        """Return the poses in the middle of pieces, and how near the others are."""
        change = self._change[part]
        middle = self._middle[part] + place[:, None] * change
        widths = np.abs(change) * half * _OUTWARD + _ROUNDING * np.abs(middle)
        turns = widths[:, 3:].sum(axis=1) * _OUTWARD
        shifts = (np.linalg.norm(widths[:, :3], axis=1) + turns * self._away) * _OUTWARD
        R, T = self._ways.poses(middle)

        def changes() -> Array:
            ends = [middle + sign * half * change for sign in (-1, 1)]
            return np.maximum(*(self._rows.moved(middle, end) for end in ends))

        motors = self._rows.motors
        if motors is None:
            return Near(R, T, shifts, turns, changes)
        q = motors.drives.inverse(R, T, motors.knees)
        slips = slips_near(motors.drives, R, T, q, shifts, turns, self._centre)
        return Near(R, T, shifts, turns, changes, q, slips)


class ValueParts:
    """The proved parts of some ways of values or drives, each of which is followed in steps.

    Parameters
    ----------
    rows
        The rows.
    ways
        Which ways: the indices of the rows before them, shape (w,).
    steps
        How many rows each way is divided into at least: parts are near to shorter chords.
    centre
        Of the platform, shape (3,).
    """

    def __init__(
        self,
        rows: PathRows,
        ways: Index,
        steps: int,
        centre: Array,
    ) -> None:
        followed = rows.followed()
        assert followed is not None
        follower, numbers = followed
        share = (np.arange(steps + 1) / steps)[:, None]
        modes = []
        for k in ways.tolist():
            values = numbers[k] + (numbers[k + 1] - numbers[k]) * share
            values[-1] = numbers[k + 1]
            modes.append(follower.follow(values, rows.R[k], rows.T[k], keep=True))
        self._segments = found = Segments.joined([mode.segments for mode in modes])
        self.way = np.repeat(ways, [len(mode.segments.row) for mode in modes])
        #: The ways that are proved from end to end.
        self.whole = ways[[mode.reached == steps for mode in modes]]
        # Where the segments are on their ways, from 0 to 1.
        self._begin = (found.row + found.begin) / steps
        self._width = (found.end - found.begin) / steps
        self._follower, self._rows, self._centre = follower, rows, centre

    def near(self, part: Index, place: Array, half: float) -> Near:
        """Return the poses in the middle of pieces, and how near the others are.

        Rotations exp(w) R differ by an angle of |w - w'| at most.
        """
        segments, follower = self._segments, self._follower
        R, T = segments.chord(part, 0.5 + place)
        middle = np.broadcast_to(follower.middle, T.shape)
        T = T * follower.reach + follower.origin - apply(R, middle)
        d, radius = segments.d[part], segments.radius[part] + 2 * _ROUNDING
        turns = (np.linalg.norm(d[:, :3], axis=1) * half + radius) * _OUTWARD
        moved = (np.linalg.norm(d[:, 3:], axis=1) * half + radius) * _OUTWARD
        away = float(np.linalg.norm(self._centre - follower.middle))
        size = float(np.linalg.norm(follower.origin) + np.linalg.norm(follower.middle))
        shifts = (moved * follower.reach + turns * away + _ROUNDING * size) * _OUTWARD
        rows, way, width = self._rows, self.way[part], self._width[part]
        # Values and drives move linearly on the whole way.
        numbers = rows.moving_numbers
        change = numbers[way + 1] - numbers[way]
        sweep = np.abs(change) * (half * width)[:, None] * _OUTWARD
        sweep += _ROUNDING * (np.abs(numbers[way]) + np.abs(change))
        if rows.motors is None:
            return Near(R, T, shifts, turns, lambda: sweep)
        drives = rows.motors.drives
        share = self._begin[part] + (0.5 + place) * width
        q = numbers[way] + change * share[:, None]
        slips = np.where(drives.driven, drives.arms * sweep[:, drives.index], 0.0)
        return Near(R, T, shifts, turns, lambda: sweep, q, slips)


def _least(
    rows: PathRows,
    at: Array,
    measure: Measure,
    wanted: float,
    halvings: int = HALVINGS,
    known: Array | None = None,
) -> Array:
    """Return proved lower bounds of a quantity on the ways between rows, shape (r - 1,).

    Minus infinity where nothing is proved, as on ways with an end that has less than is wanted.

    Parameters
    ----------
    rows, at
        The rows, and the quantity there, shape (r,).
    measure
        Bounds it on pieces.
    wanted
        What is asked for.
    halvings
        How often pieces are halved at most.
    known
        Bounds that are known already, shape (r - 1,).
    """
    proved = np.full(len(at) - 1, -np.inf) if known is None else known.copy()
    ends = np.minimum(at[:-1], at[1:])
    centre = Arrangement.of(rows.instance).platform_centre
    ways = np.flatnonzero(~(proved >= wanted) & (ends >= wanted))
    along_poses = rows.parameters is not None
    if not along_poses and rows.followed() is None:
        return proved
    for steps in (1,) if along_poses else _STEPS:
        if not 0 < len(ways) * steps < _MOST_STEPS:
            break
        parts = (
            PoseParts(rows, ways, centre) if along_poses else ValueParts(rows, ways, steps, centre)
        )
        found, lost = _judged(measure, parts, ends, wanted, halvings)
        proved[ways] = np.maximum(proved, found)[ways]
        ways = ways[~((proved >= wanted) | lost)[ways]]
    return proved


def _judged(
    measure: Measure,
    parts: PoseParts | ValueParts,
    ends: Array,
    wanted: float,
    halvings: int,
) -> tuple[Array, NDArray[np.bool_]]:
    """Return lower bounds on ways, and on which of them a pose is seen to have less, shapes (w,).

    Parameters
    ----------
    measure
        Bounds the quantity on pieces.
    parts
        Of the ways.
    ends
        The least at the ends of each way, shape (w,).
    wanted, halvings
        What is asked for, and how often pieces are halved at most.
    """
    found = np.full(len(ends), -np.inf)
    found[parts.whole] = ends[parts.whole]
    lost = np.zeros(len(ends), bool)
    part = np.arange(len(parts.way))
    place = np.zeros(len(part))
    for halving in range(halvings + 1):
        if not len(part):
            break
        half = 0.5 ** (halving + 1)
        low, bounds = measure(parts.near(part, place, half))
        lost[parts.way[part[~(low >= wanted)]]] = True
        again = ~((bounds >= wanted) | lost[parts.way[part]])
        if again.any() and halvings == HALVINGS:
            # Halving must help where pieces have no length.
            _, best = measure(parts.near(part[again], place[again], 0.0))
            again[np.flatnonzero(again)[~(best >= wanted)]] = False
        last = halving == halvings or 2 * np.count_nonzero(again) > _MOST_PIECES
        done = ~again | last
        np.minimum.at(found, parts.way[part[done]], bounds[done])
        if last:
            break
        part, place = np.repeat(part[again], 2), np.repeat(place[again], 2)
        place = place + np.tile((-half / 2, half / 2), len(place) // 2)
    return found, lost
