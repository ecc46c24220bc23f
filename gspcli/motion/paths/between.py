"""What holds on the whole way between the rows of a proved path or track, not only at its rows.

A way is cut into pieces. All poses of a piece are near to the one in its middle: on a way of values
or drives by the proved chords that it is followed on, on a way of poses since position and angles
are linear. Each quantity has a measure: its number in the middle of a piece, and by how much it
can change on the piece. Where that does not suffice the piece is halved.

For condition numbers the rows of the Jacobian matrix, (moment / L, force) of norm one, are enclosed
by the formulas for screws: all arms, offsets and directions are in balls. The singular values of
all matrices of such rows are bounded. For drives along straight ways of poses all vectors are
enclosed as functions of one parameter of the way.

Values and drives change linearly between rows, so they leave a range at one time. A mode passes a
dead point between two rows if the gain of a drive has different signs there; gains between rows
are not computed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.coordinates import choose
from gspcli.geometry.enclosures import Enclosure, above, joined, roundings, singular_values, size
from gspcli.geometry.frames import PoseFrame
from gspcli.geometry.instance import Instance
from gspcli.geometry.machine import Machine, arms_of, value_machine
from gspcli.geometry.measurement import condition_numbers
from gspcli.geometry.quaternions import apply
from gspcli.geometry.readings import without_corrections
from gspcli.motion.collisions.compared import ComparedShapes, slips_near
from gspcli.motion.following.branch_follower import MovingGeometry
from gspcli.motion.following.follower import FRAME_ERROR, RowFollower, Segments
from gspcli.motion.following.tracks import Event, Track
from gspcli.motion.paths.ways import PoseWays, ValueWays, WayProof
from gspcli.motion.poses.inverse_kinematics import refusals
from gspcli.motion.screws import screw
from gspcli.motion.singularities.clearances import clearances, weights_of
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
_EVERY = slice(None)
#: Into how many steps a part is divided that is followed again.
_STEPS_AGAIN = 8
#: Signs: the shortest piece of a way, how often pieces are divided, and most pieces at a time.
_SHORTEST, _SIGN_HALVINGS, _MOST_SIGNS = 2.0**-36, 60, 20_000
#: A transmission that is at least this is not zero.
_TINY = float(np.finfo(float).tiny)
#: Parts of a way.
_PARTS = 16
_AXES = np.eye(3)


@dataclass(frozen=True, eq=False)
class PathRows:
    """Rows of a proved path, between which values, drives or poses change linearly."""

    #: The machine, in the working modes of the path.
    machine: Machine
    #: Shapes (r, 6), (r, 3, 3) and (r, 3); the values without offsets.
    values: Array
    R: Array
    T: Array
    #: What changes linearly: what all drives are at, lengths and radians, shape (r, m); on ways of
    #: poses position and angles, shape (r, 6).
    numbers: Array
    #: The straight ways of poses, if poses lead from row to row.
    ways: PoseWays | None = None
    #: Else what follows the mode, and the rows as it takes them, shape (r, 6 + d); None if no step
    #: knows what moves.
    follower: RowFollower | None = None
    rows: Array | None = None
    #: The unit of each drive's changes in clearances, lengths and radians, shape (m,); None for
    #: those of the machine.
    weights: Array | None = None

    @classmethod
    def of_values(
        cls, ways: ValueWays, values: Array, R: Array, T: Array, weights: Array | None = None
    ) -> PathRows:
        """Return rows between which the values change linearly."""
        q = values * ways.machine.units
        return cls(ways.machine, values, R, T, q, None, ways.follower, values, weights)

    @classmethod
    def of_poses(cls, ways: PoseWays, R: Array, T: Array, parameters: Array) -> PathRows:
        """Return rows between which position and angles change linearly."""
        return cls(ways.machine, ways.machine.values(R, T), R, T, parameters, ways)

    @classmethod
    def of_drives(
        cls, machine: Machine, follower: RowFollower | None, q: Array, R: Array, T: Array
    ) -> PathRows:
        """Return rows between which all drives change linearly; rods have the stated lengths."""
        values = machine.values(R, T)
        for k in np.flatnonzero(~machine.moved).tolist():
            values[:, machine.users(k)[0]] = q[:, k] / machine.units[k]
        rows = None
        if follower is not None:
            rods = np.array([row.value.value for row in follower.instance.constraints])
            rows = np.column_stack((values, (q / machine.units)[:, machine.moved]))
            rows[:, :6] = np.where(follower.driven, rods, rows[:, :6])
        return cls(machine, values, R, T, q, None, follower, rows)

    @property
    def instance(self) -> Instance:
        """The platform."""
        return self.machine.instance

    @property
    def units(self) -> Array:
        """The unit of each drive's changes in clearances, lengths and radians, shape (m,)."""
        return weights_of(self.machine)[0] if self.weights is None else self.weights

    def placed(self, R: Array, T: Array, q: Array | None = None) -> Arrangement:
        """Return the platform at poses, its driven points where they are there."""
        return self.machine.placed(R, T) if q is None else self.machine.arrangement(q)

    def drive_numbers(self) -> Array:
        """Return what the drives are at in the rows, shape (r, m)."""
        return self.numbers if self.ways is None else self.machine.along(self.R, self.T)

    def conditions(self) -> Array:
        """Return condition numbers at the rows, with the drives still, shape (r,)."""
        length = Arrangement.of(self.instance).length
        return condition_numbers(self.placed(self.R, self.T), self.R, self.T, length)

    def clearances(self, R: Array, T: Array) -> Array:
        """Return proved clearances of poses, in values or drives, shape (n,)."""
        return clearances(self.machine, R, T, weights=self.units)[0]

    def travels(self) -> Array:
        """Bound how far drives move from row to row, shape (r - 1, m)."""
        if self.ways is not None:
            return self.moved(self.numbers[:-1], self.numbers[1:])
        return np.asarray(above(np.abs(np.diff(self.numbers, axis=0))))

    def moved(self, begins: Array, ends: Array) -> Array:
        """Bound how far drives move on straight ways of poses, shape (n, m)."""
        assert self.ways is not None
        return np.asarray(above(drive_travels(self.ways, begins, ends)))


class Near(NamedTuple):
    """Poses, and how near to them all poses of some pieces are."""

    R: Array
    T: Array
    shifts: Array
    """How far the centre of the platform moves, shape (n,)."""
    turns: Array
    """By which angle the platform turns, in radians, shape (n,)."""
    changes: Callable[[], Array]
    """Returns how far each drive is from that in the middle, lengths and radians, shape (n, m)."""
    q: Array | None = None
    """The numbers of cranks and slides at the poses, shape (n, m), if there are any."""
    slips: Array | None = None
    """How far these move the points of constraints, in their bodies, shape (n, 6)."""


#: Returns c quantities in the middle of pieces, and by how much each can change, shapes (n, c).
Measure = Callable[[Near], tuple[Array, Array]]


def least_clearances(rows: PathRows, wanted: float) -> tuple[Array, Array]:
    """Return proved clearances at rows, (r,), and on the ways between them, (r - 1,).

    A pose whose values or drives differ by at most s from those of one with the clearance r has at
    least ``r - s``. From both ends of a way of length s that gives ``(r1 + r2 - s) / 2``. Poses
    between the rows are looked at if some clearance is wanted.
    """
    at = rows.clearances(rows.R, rows.T)
    travels = (rows.travels() / rows.units).max(axis=1)
    known = (at[:-1] + at[1:] - travels) / above(2)
    if wanted:
        halvings = _DRIVE_HALVINGS if rows.machine.moves else CLEARANCE_HALVINGS

        def measure(near: Near) -> tuple[Array, Array]:
            change = above((near.changes() / rows.units).max(axis=1))
            return rows.clearances(near.R, near.T)[:, None], change[:, None]

        known = _least(rows, at, measure, wanted, halvings, known)
    return at, np.maximum(known, 0.0)


def largest_conditions(rows: PathRows, wanted: float) -> tuple[Array, Array]:
    """Return condition numbers at rows, (r,), and bounds on the ways between them, (r - 1,)."""
    length = Arrangement.of(rows.instance).length

    def measure(near: Near) -> tuple[Array, Array]:
        placed = rows.placed(near.R, near.T, near.q)
        sides = None
        if near.slips is not None:
            on = rows.machine.on_platform
            sides = np.stack([np.where(on == side, near.slips, 0.0) for side in (True, False)])
        at = condition_numbers(placed, near.R, near.T, length)
        most = condition_bounds(placed, near.R, near.T, near.shifts, near.turns, length, sides)
        return -at[:, None], above(most - at)[:, None]

    at = rows.conditions()
    return at, -_least(rows, -at, measure, -wanted)


def least_gaps(rows: PathRows, wanted: float) -> tuple[Array, Array]:
    """Return lower bounds of the least gap of legs and bodies at rows and between them."""
    compared = ComparedShapes(rows.instance)
    at = compared.bounds(rows.R, rows.T, rows.drive_numbers()).low.min(axis=1)
    centre = _centre(rows)

    def measure(near: Near) -> tuple[Array, Array]:
        low = compared.bounds(near.R, near.T, near.q).low
        poses = near.R, near.T, near.q
        with np.errstate(invalid="ignore"):
            moves = compared.moves(*poses, near.shifts, near.turns, centre, near.slips)
        return low, moves

    return at, _least(rows, at, measure, wanted)


def least_transmissions(rows: PathRows, wanted: float) -> tuple[Array, Array]:
    """Return the least transmission of all drives at rows, (r,), and bounds between, (r - 1,)."""
    drives = rows.machine
    centre = _centre(rows)

    def measure(near: Near) -> tuple[Array, Array]:
        return _transmissions(drives, near, centre)

    q = rows.drive_numbers()
    gains = drives.gains(rows.R, rows.T, q)
    at = drives.transmission(gains)[:, drives.driven].min(axis=1)
    return at, _least(rows, at, measure, wanted)


def keeps_working_modes(rows: PathRows) -> bool:
    """Return whether it is proved that no drive passes a dead point between the rows."""
    return bool((least_transmissions(rows, _TINY)[1] >= _TINY).all())


def _transmissions(drives: Machine, near: Near, centre: Array) -> tuple[Array, Array]:
    """Return transmissions of the driven rods, and bounds of their changes, shapes (n, d).

    The transmission is ``|f.b|``: f is the unit vector of the rod r, b the velocity of the driven
    point by the arm. If r changes by at most d, f changes by at most ``2 d / (2 |r| - d)``.
    """
    assert near.q is not None
    assert near.slips is not None
    ends = drives.ends(near.R, near.T, near.q)
    # Seen from the body of the driven point; r is a vector of that body.
    moves, rounding = _leg_moves(near, ends, drives.on_platform, centre)
    with np.errstate(all="ignore"):
        size = np.linalg.norm(ends[2], axis=-1)
        left = size - moves / 2
        turned = np.where(left > 0, moves / left, np.inf)
        turned += np.where(drives.cranked, near.slips / drives.arms, 0.0)
        turned = above(turned) + rounding
    at = drives.transmission(drives.gains(near.R, near.T, near.q))
    return at[:, drives.driven], turned[:, drives.driven]


def cones_kept(rows: PathRows) -> bool:
    """Return whether it is proved that all cones are kept between the rows."""
    if not rows.machine.cones:
        return True
    measure = cone_margins(rows.machine)
    shares = rows.machine.cone_shares(rows.R, rows.T, rows.drive_numbers())
    return bool((_least(rows, 1 - shares.max(axis=1), measure, 0.0) >= 0).all())


def cone_margins(machine: Machine) -> Measure:
    """Return the measure of cones: by how much less legs are tilted than allowed, in radians.

    A leg r that changes by at most d turns by at most the angle with the sine ``d / |r|``. It is
    seen from the body of the cone, in which only an arm turns the cone.
    """
    cones, a = machine.cones, machine.stated_arrangement
    legs = [one.constraint for one in cones]
    on_platform = np.array([one.body == "platform" for one in cones])
    allowed = np.array([one.cone.half_angle.value for one in cones]) * a.in_radians

    def measure(near: Near) -> tuple[Array, Array]:
        placed = a.placed(near.R, near.T)
        ends, turned = (a.x, placed.arm, placed.r), np.zeros(len(cones))
        if near.q is not None and near.slips is not None:
            ends = machine.ends(near.R, near.T, near.q)
            arms = machine.cranked[legs] & (machine.on_platform[legs] == on_platform)
            turned = np.where(arms, (near.slips / machine.arms)[:, legs], 0.0)
        base, arm, r = (vectors[..., legs, :] for vectors in ends)
        moves, rounding = _leg_moves(near, (base, arm, r), on_platform, a.platform_centre, legs)
        with np.errstate(all="ignore"):
            sine = above(moves / np.linalg.norm(r, axis=-1))
            leans = np.where(sine < 1, np.arcsin(np.minimum(sine, 1.0)), np.inf)
            changes = above(leans + turned) + rounding
        tilted = machine.tilts(near.R, near.T, near.q)
        return allowed - np.nan_to_num(tilted, nan=0.0), changes

    return measure


def limit_margins(machine: Machine) -> Measure:
    """Return the measure of all limits: how far drives are within their ranges, and of cones.

    Ranges come first, those that `ranged` lists; lengths and radians.
    """
    k, cones = ranged(machine), cone_margins(machine)
    low, high, two_sided = machine.low[k], machine.high[k], machine.two_sided[k]

    def measure(near: Near) -> tuple[Array, Array]:
        q = (machine.inverse(near.R, near.T) if near.q is None else near.q)[:, k]
        changes = near.changes()[:, k] + roundings(16, np.abs(q) + machine.room[k])
        q = np.where(two_sided, np.abs(q), q)
        margins = np.minimum(q - low, high - q) + machine.room[k]
        if not machine.cones:
            return margins, changes
        more = cones(near)
        return np.hstack((margins, more[0])), np.hstack((changes, more[1]))

    return measure


def ranged(machine: Machine) -> Index:
    """Return the drives with a range."""
    return np.flatnonzero(np.isfinite(machine.high - machine.low))


def _leg_moves(
    near: Near,
    ends: tuple[Array, Array, Array],
    on_platform: NDArray[np.bool_],
    centre: Array,
    legs: slice | list[int] = _EVERY,
) -> tuple[Array, Array]:
    """Bound how far legs r change, and rounding errors of their directions, shapes (n, c).

    Parameters
    ----------
    near
        The poses.
    ends
        Points of the base, turned points of the platform, and r: of c legs, as `Machine.ends`.
    on_platform
        Which legs are seen from the platform, shape (c,); the others are from the base.
    centre
        Of the platform, shape (3,).
    legs
        The constraints of the legs.
    """
    base, arm, r = ends
    turned = apply(near.R, np.broadcast_to(centre, near.T.shape))
    own = np.linalg.norm(arm - turned[:, None], axis=-1)
    away = np.linalg.norm((near.T + turned)[:, None] - base, axis=-1)
    moves = near.shifts[:, None] + near.turns[:, None] * np.where(on_platform, away, own)
    if near.slips is not None:
        moves = moves + near.slips[:, legs]
    far = np.abs(near.T).max(axis=1)[:, None]
    far = far + np.abs(base).max(axis=-1) + np.abs(arm).max(axis=-1)
    with np.errstate(divide="ignore"):
        return moves, roundings(16, 1 + far / np.linalg.norm(r, axis=-1))


def _centre(rows: PathRows) -> Array:
    """Return the centre of the platform, shape (3,)."""
    return Arrangement.of(rows.instance).platform_centre


class PoseParts:
    """Straight ways of poses between rows, each one part.

    Parameters
    ----------
    rows
        The rows.
    way
        Which ways: the indices of the rows before them, shape (w,).
    """

    def __init__(self, rows: PathRows, way: Index) -> None:
        assert rows.ways is not None
        first, last, centre = rows.numbers[way], rows.numbers[way + 1], _centre(rows)
        self.way, self.whole = way, way
        self.begin, self.end = np.zeros(len(way)), np.ones(len(way))
        self._rows, self._ways, self._centre = rows, rows.ways, centre
        self._middle, self._change = (first + last) / 2, last - first
        self._away = float(np.linalg.norm(centre - rows.ways.pivot))

    def near(self, part: Index, low: Array, high: Array) -> Near:
        """Return the poses in the middle of pieces, and how near the others are.

        Parameters
        ----------
        part
            The part of each piece, shape (n,).
        low, high
            Between which places on its way it is, from 0 to 1, shapes (n,).
        """
        change, half = self._change[part], ((high - low) / 2)[:, None]
        middle = self._middle[part] + ((low + high) / 2 - 0.5)[:, None] * change
        widths = above(np.abs(change) * half) + roundings(16, np.abs(middle))
        turns = above(widths[:, 3:].sum(axis=1))
        shifts = above(np.linalg.norm(widths[:, :3], axis=1) + turns * self._away)
        R, T = self._ways.poses(middle)

        def changes() -> Array:
            ends = [middle + sign * half * change for sign in (-1, 1)]
            return np.maximum(*(self._rows.moved(middle, end) for end in ends))

        machine = self._rows.machine
        if not machine.moves:
            return Near(R, T, shifts, turns, changes)
        q = machine.inverse(R, T)
        slips = slips_near(machine, R, T, q, shifts, turns, self._centre)
        return Near(R, T, shifts, turns, changes, q, slips)

    def finer(self, k: int) -> Index:
        """Return no parts: the poses of a straight way are known exactly."""
        del k
        return np.zeros(0, np.int64)


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
    """

    def __init__(self, rows: PathRows, ways: Index, steps: int = 1) -> None:
        assert rows.follower is not None
        assert rows.rows is not None
        numbers, modes = rows.rows, []
        share = (np.arange(steps + 1) / steps)[:, None]
        for k in ways.tolist():
            values = numbers[k] + (numbers[k + 1] - numbers[k]) * share
            values[-1] = numbers[k + 1]
            modes.append(rows.follower.follow(values, rows.R[k], rows.T[k], keep=True))
        self._path, self._follower, self._rows = rows, rows.follower, numbers
        self._centre = _centre(rows)
        self._segments = found = Segments.joined([mode.segments for mode in modes])
        self._finer: dict[int, Index] = {}
        self.way = np.repeat(ways, [len(mode.segments.row) for mode in modes])
        #: The ways that are proved from end to end.
        self.whole = ways[[mode.reached == steps for mode in modes]]
        #: Where the parts are on their ways, from 0 to 1, shapes (n,).
        self.begin, self.end = (found.row + found.begin) / steps, (found.row + found.end) / steps
        # How near the pose at the beginning is to the chord; 0 stands for Newton's method.
        before = np.concatenate(([0.0], found.error[:-1] + FRAME_ERROR))
        self._error = np.where(self.begin > 0, before, 0.0)

    def near(self, part: Index, low: Array, high: Array) -> Near:
        """Return the poses in the middle of pieces, and how near the others are.

        Rotations exp(w) R differ by an angle of |w - w'| at most. Arguments as for `PoseParts`.
        """
        segments, follower = self._segments, self._follower
        width = self.end[part] - self.begin[part]
        rounding = roundings(16, 1)
        middle, half = (low + high) / 2, (high - low) / 2 + rounding
        R, T = self._poses(part, (middle - self.begin[part]) / width)
        d, radius = segments.d[part], segments.radius[part] + 2 * rounding
        turns = above(np.linalg.norm(d[:, :3], axis=1) * half / width + radius)
        moved = above(np.linalg.norm(d[:, 3:], axis=1) * half / width + radius)
        away = float(np.linalg.norm(self._centre - follower.middle))
        size = float(np.linalg.norm(follower.origin) + np.linalg.norm(follower.middle))
        shifts = above(moved * follower.reach + turns * away + rounding * size)
        # Values and drives move linearly on the whole way.
        way, numbers, drives = self.way[part], self._path.numbers, self._path.machine
        change = numbers[way + 1] - numbers[way]
        sweep = above(np.abs(change) * half[:, None])
        sweep += rounding * (np.abs(numbers[way]) + np.abs(change))
        if not drives.moves:
            return Near(R, T, shifts, turns, lambda: sweep)
        q = numbers[way] + change * middle[:, None]
        slips = np.where(drives.driven, drives.arms * sweep[:, drives.index], 0.0)
        return Near(R, T, shifts, turns, lambda: sweep, q, slips)

    def _poses(self, part: Index, share: Array) -> tuple[Array, Array]:
        """Return poses of the chords of parts, at shares from 0 to 1 of them."""
        follower = self._follower
        R, T = self._segments.chord(part, share)
        middle = np.broadcast_to(follower.middle, T.shape)
        return R, T * follower.reach + follower.origin - apply(R, middle)

    def finer(self, k: int) -> Index:
        """Follow a part again in shorter segments; return these as new parts.

        Returns nothing if they are not nearer to their poses.
        """
        if k not in self._finer:
            self._finer[k] = self._followed_again(k)
        return self._finer[k]

    def _followed_again(self, k: int) -> Index:
        follower, old, begin, end = self._follower, self._segments, self.begin[k], self.end[k]
        first, last = self._rows[self.way[k]], self._rows[self.way[k] + 1]
        share = begin + (end - begin) * np.arange(_STEPS_AGAIN + 1) / _STEPS_AGAIN
        rows = first + (last - first) * share[:, None]
        rods = follower.driven
        rows[:, :6][:, rods] = first[:6][rods]
        (R,), (T,) = self._poses(np.array([k]), np.zeros(1))
        near = float(self._error[k]) * follower.reach
        mode = follower.follow(rows, R, T, near, keep=True)
        new, count = mode.segments, len(mode.segments.row)
        if mode.reached < _STEPS_AGAIN or not (new.radius < 0.5 * old.radius[k]).all():
            return np.zeros(0, np.int64)
        low, high = (
            begin + (end - begin) * (new.row + x) / _STEPS_AGAIN for x in (new.begin, new.end)
        )
        # The ends of neighbours agree, and those of the whole part stay.
        low[1:] = high[:-1]
        low[0], high[-1] = begin, end
        error = np.concatenate((self._error[[k]], new.error[:-1] + FRAME_ERROR))
        self.way = np.append(self.way, np.repeat(self.way[k], count))
        self.begin, self.end = np.append(self.begin, low), np.append(self.end, high)
        self._error = np.append(self._error, error)
        self._segments = Segments.joined([old, new])
        return np.arange(len(self.way) - count, len(self.way))


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
    ways = np.flatnonzero(~(proved >= wanted) & (ends >= wanted))
    if rows.ways is None and rows.rows is None:
        return proved
    for steps in _STEPS if rows.ways is None else (1,):
        if not 0 < len(ways) * steps < _MOST_STEPS:
            break
        parts = ValueParts(rows, ways, steps) if rows.ways is None else PoseParts(rows, ways)
        found, lost = _judged(measure, parts, ends, wanted, halvings)
        proved[ways] = np.maximum(proved, found)[ways]
        ways = ways[~((proved >= wanted) | lost)[ways]]
    return proved


def _judged(
    measure: Measure, parts: PoseParts | ValueParts, ends: Array, wanted: float, halvings: int
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

    def divide(pieces: _Pieces) -> Index:
        part, low, high, middle, _ = pieces
        lost[parts.way[part[~(middle >= wanted).all(axis=1)]]] = True
        again = ~((pieces.least() >= wanted) | lost[parts.way[part]])
        if again.any() and halvings == HALVINGS:
            # Halving must help where pieces have no length.
            here = ((low + high) / 2)[again]
            best = _Pieces.of(measure, parts, part[again], here, here).least()
            again[np.flatnonzero(again)[~(best >= wanted)]] = False
        return again.astype(np.int64)

    for pieces in _divided(measure, parts, divide, halvings, _MOST_PIECES):
        np.minimum.at(found, parts.way[pieces.part], pieces.least())
    return found, lost


def signs(
    measure: Measure, parts: PoseParts | ValueParts, count: int
) -> tuple[Array, Array, Index]:
    """Return on which stretches of ways `count` quantities are proved to be positive or negative.

    Returns
    -------
    tuple
        Where each of n stretches begins and ends: rows with fractions, in order, shapes (n,). The
        signs of the c quantities on it, 0 where none is proved, shape (n, c).
    """
    found = [(np.zeros(0), np.zeros(0), np.zeros((0, count), np.int64))]

    def divide(pieces: _Pieces) -> Index:
        part, low, high, middle, change = pieces
        here = (low + high) / 2
        # What remains of the change on a piece without length is due to the distance of the chord.
        rest = _Pieces.of(measure, parts, part, here, here).change
        open_ = ~(np.abs(middle) > change) & (high - low > _SHORTEST)[:, None]
        again = np.zeros(len(part), np.int64)
        with np.errstate(invalid="ignore"):
            again[(open_ & (change - rest > rest / 4)).any(axis=1)] = 1
        for j in np.flatnonzero((open_ & (2 * rest > change)).any(axis=1)).tolist():
            if len(parts.finer(int(part[j]))):
                again[j] = 2
        return again

    for pieces in _divided(measure, parts, divide, _SIGN_HALVINGS, _MOST_SIGNS):
        part, low, high, middle, change = pieces
        sign = np.where(np.abs(middle) > change, np.sign(middle), 0).astype(np.int64)
        found.append((parts.way[part] + low, parts.way[part] + high, sign))
    begin, end, sign = (np.concatenate(column) for column in zip(*found, strict=True))
    order = np.argsort(begin, kind="stable")
    return begin[order], end[order], sign[order]


class _Pieces(NamedTuple):
    """Pieces of parts, and what is measured on them."""

    part: Index
    low: Array
    high: Array
    middle: Array
    change: Array

    @classmethod
    def of(
        cls, measure: Measure, parts: PoseParts | ValueParts, part: Index, low: Array, high: Array
    ) -> _Pieces:
        """Measure quantities on pieces."""
        return cls(part, low, high, *measure(parts.near(part, low, high)))

    def least(self) -> Array:
        """Return lower bounds of all quantities, shape (n,)."""
        with np.errstate(invalid="ignore"):
            bounds: Array = (self.middle - self.change).min(axis=1)
        return np.nan_to_num(bounds, nan=-np.inf, neginf=-np.inf, posinf=np.inf)


def _divided(
    measure: Measure,
    parts: PoseParts | ValueParts,
    divide: Callable[[_Pieces], Index],
    halvings: int,
    most: int,
) -> Iterator[_Pieces]:
    """Yield pieces that are not divided further, which together fill all parts.

    Parameters
    ----------
    measure, parts
        What is measured on which parts.
    divide
        Returns for each piece 0 if it stays, 1 if it is halved, and 2 if its part is followed
        again in shorter segments, shape (n,).
    halvings, most
        How often pieces are divided, and how many there are at most.
    """
    part, low, high = np.arange(len(parts.way)), parts.begin, parts.end
    for halving in range(halvings + 1):
        if not len(part):
            return
        pieces = _Pieces.of(measure, parts, part, low, high)
        again = divide(pieces)
        last = halving == halvings or 2 * np.count_nonzero(again) > most
        done = (again == 0) | last
        yield _Pieces(*(column[done] for column in pieces))
        if last:
            return
        halved, middle = again == 1, (low + high) / 2
        new = [(part[halved], low[halved], middle[halved])]
        new.append((part[halved], middle[halved], high[halved]))
        for j in np.flatnonzero(again == 2).tolist():
            finer = parts.finer(int(part[j]))
            begin = np.maximum(parts.begin[finer], low[j])
            end = np.minimum(parts.end[finer], high[j])
            there = begin < end
            new.append((finer[there], begin[there], end[there]))
        part, low, high = (np.concatenate(column) for column in zip(*new, strict=True))


def condition_bounds(
    arrangement: Arrangement,
    R: Array,
    T: Array,
    shifts: Array,
    turns: Array,
    length: float,
    slips: Array | None = None,
) -> Array:
    """Return upper bounds of the condition numbers of poses near to given ones, shape (n,).

    Infinite where nothing is proved.

    Parameters
    ----------
    arrangement
        The geometry.
    R, T
        The poses, shapes (n, 3, 3) and (n, 3).
    shifts, turns
        How far the centre of the platform moves and by which angle, in radians, the platform turns,
        at most; shapes (n,).
    length
        The typical length, as for `condition_numbers`.
    slips
        How far cranks and slides move the points of constraints in their bodies, at most: those of
        the platform and those of the base, shape (2, n, 6); None if no point moves.
    """
    with np.errstate(all="ignore"):
        rows = rows_near(arrangement, R, T, shifts, turns, length, slips)
        known = np.asarray(
            np.isfinite(rows.rad).all(axis=1) & np.isfinite(rows.mid).all(axis=(1, 2))
        )
        safe = np.where(known[:, None, None], rows.mid, np.eye(6))
        least, most = singular_values(Enclosure(safe, rows.rad))
        return np.where(known & (least > 0), above(most / least), np.inf)


def rows_near(
    a: Arrangement,
    R: Array,
    T: Array,
    shifts: Array,
    turns: Array,
    length: float,
    slips: Array | None = None,
) -> Enclosure:
    """Enclose (moment / L, force) about the centre, of norm one, shape (n, 6, 6)."""
    chord = above(2 * np.sin(np.minimum(turns, np.pi) / 2))
    own, other = np.zeros((2, len(T), 6)) if slips is None else slips
    centre = a.platform_centre

    def turned(vectors: Array) -> Enclosure:
        placed = Enclosure.rounded(apply(R[:, None], vectors), size(vectors) + size(centre))
        return placed.widened(chord[:, None] * size(vectors))

    arm = turned(a.y - centre).widened(own)
    at = T + apply(R, np.broadcast_to(centre, T.shape))
    far = size(T)[:, None] + size(centre) + size(a.x)
    offset = Enclosure.rounded(at[:, None] - a.x, far).widened(shifts[:, None] + other)
    w = turned(a.u)
    v = Enclosure.rounded(np.broadcast_to(a.v, w.mid.shape))
    mid, rad = np.zeros((len(T), 6, 6)), np.zeros((len(T), 6))
    for kind in set(a.kinds):
        k = [i for i, one in enumerate(a.kinds) if one is kind]
        moment, force = screw(kind, *(part.take(slice(None), k) for part in (arm, offset, w, v)))
        moment = (1 / length) * moment
        row = joined(moment, force or Enclosure(0 * moment.mid)).unit()
        mid[:, k], rad[:, k] = row.mid, row.rad
    return Enclosure(mid, rad)


def drive_travels(ways: PoseWays, begins: Array, ends: Array) -> Array:
    """Bound how far drives move on straight ways in position and angles, shape (n, m).

    Lengths and radians; infinite where nothing is proved.

    Parameters
    ----------
    ways
        The platform, with its drives on their working modes.
    begins, ends
        Parameters of poses, shape (n, 6).
    """
    half = (ends - begins) / (2 * _PARTS)
    middles = begins[:, None] + (2 * np.arange(_PARTS)[:, None] + 1) * half[:, None]
    far = np.repeat(size(begins) + size(ends), _PARTS)
    near = _Vectors(ways, middles.reshape(-1, 6), np.repeat(half, _PARTS, axis=0), far)
    with np.errstate(all="ignore"):
        found = near.moves().reshape(len(half), _PARTS, -1)
    # From one end of a part to the other it is at most twice as far as from the middle.
    return np.asarray(2 * found.sum(axis=1))


class _Vectors:
    """The vectors of a platform on parts of ways, enclosed.

    Middles and half changes have shape (n, 6), sizes of all parameters (n,).
    """

    def __init__(self, ways: PoseWays, middles: Array, halves: Array, far: Array) -> None:
        self.ways, self.arrangement = ways, Arrangement.of(ways.instance)
        rad = Enclosure.rounded(middles, far).rad
        self.place = Enclosure(middles[:, :3], rad, halves[:, :3, None])
        angles = [
            Enclosure(middles[:, k : k + 1], rad, halves[:, k : k + 1, None]) for k in (3, 4, 5)
        ]
        self.turns = [(one.cos(), one.sin()) for one in angles]
        sequence = ways.boxes.sequence
        letters = sequence if sequence.isupper() else sequence[::-1]
        self.axes = ["xyz".index(letter) for letter in letters.lower()]
        self.count = len(middles)

    def fixed(self, vector: Array) -> Enclosure:
        return Enclosure.rounded(np.broadcast_to(vector, (self.count, 3)))

    def turned(self, x: Enclosure, *, back: bool = False) -> Enclosure:
        """Return vectors turned from the platform to the base, or back."""
        for axis in self.axes if back else self.axes[::-1]:
            cos, sin = self.turns[axis]
            along = np.outer(_AXES[axis], _AXES[axis])
            across = np.cross(_AXES[axis], _AXES).T * (-1.0 if back else 1.0)
            x = x.under(along) + x.under(np.eye(3) - along) * cos + x.under(across) * sin
        return x

    def moves(self) -> Array:
        """Bound how far each drive moves from where it is in the middle, shape (n, m)."""
        machine = self.ways.machine
        machine.refuse_planes("how far drives move on a path")
        columns = [
            self._of_drive(k) if machine.driven[k] else self._of_value(k)
            for k in machine.first.tolist()
        ]
        return np.stack(columns, axis=1)

    def _of_value(self, k: int) -> Array:
        a = self.arrangement
        kind = a.kinds[k]
        w, v = self.turned(self.fixed(a.u[k])), self.fixed(a.v[k])
        if not kind.is_distance:
            return _angle(w)
        r = self.place + self.turned(self.fixed(a.y[k] - self.ways.pivot)) - self.fixed(a.x[k])
        if kind is DLL:
            normal = w.cross(v)
            return _moved(r.dot(normal) * normal.norm().inverse())
        if kind in (DPH, DHP):
            return _moved(r.dot(v if kind is DPH else w))
        across = {DPP: r, DPL: r.cross(v), DLP: r.cross(w)}[kind]
        return _moved(across.norm())

    def _of_drive(self, k: int) -> Array:
        """Bound how far a crank turns, or a slide moves."""
        drives, a = self.ways.machine, self.arrangement
        assert drives.signs is not None
        working_mode = float(drives.signs[k])
        if drives.on_platform[k]:
            away = self.fixed(a.x[k]) - self.place
            other = self.turned(away, back=True) + self.fixed(self.ways.pivot)
        else:
            other = self.place + self.turned(self.fixed(a.y[k] - self.ways.pivot))
        w = other - self.fixed(drives.middle[k])
        along, beside = w.dot(self.fixed(drives.across[k])), w.dot(self.fixed(drives.beside[k]))
        rod, square = self._number(drives.rods[k]), w.dot(w)
        if drives.sorts[drives.index[k]] == "slide":
            return _moved(beside - working_mode * (rod * rod - square + beside * beside).sqrt())
        # The angle between w, in the plane of the crank, and the arm; both as unit vectors.
        arm, both = self._number(drives.arms[k]), joined(along, beside)
        far = both.norm()
        cosine = 0.5 * ((square + arm * arm - rod * rod) * far.inverse())
        sine = (self._number(1.0) - cosine * cosine).sqrt()
        direction, left = both.unit(), joined(beside, -along).unit()
        return _angle(direction * cosine + working_mode * (left * sine))

    def _number(self, value: float) -> Enclosure:
        return Enclosure.rounded(np.full((self.count, 1), value))


def _moved(x: Enclosure) -> Array:
    """Bound how far vectors move from where they are in the middle."""
    return np.asarray(x.slope + 2 * x.rad)


def _angle(unit: Enclosure) -> Array:
    """Bound by which angles unit vectors turn from where they are in the middle."""
    chord = _moved(unit)
    return np.where(chord < 2, 2 * np.arcsin(np.minimum(chord / 2, 1.0)), np.inf)


Mask = NDArray[np.bool_]

#: The part of a step between rows next to a fold that may be skipped: parts get too short there.
_BESIDE = 1e-7
#: The sign of a smaller transmission is not known.
_SIGN_KNOWN = 1e-9


@dataclass(frozen=True)
class LimitEvent:
    """A time at which a limit is violated for the first time or kept again."""

    #: ``range`` for a value, a crank or a slide (the same for all modes), ``cone`` for a joint,
    #: ``dead point`` for a crank or slide whose gain changes its sign.
    kind: Literal["range", "cone", "dead point"]
    #: Whether the limit is violated from here on; at the first row, whether it is violated at the
    #: start.
    leaves: bool
    #: The index of the constraint.
    constraint: int
    #: The body of the joint of the cone.
    body: Literal["", "platform", "base"]
    #: The mode whose leg leaves the cone.
    mode: int | None
    #: An interval that contains t; one number where values or drives are linear between rows.
    low: float
    high: float
    #: Whether it is proved that the limit is kept before and violated after, or the reverse. An
    #: unproved event of a certified track means that a cone may be violated between: the leg is
    #: near the edge of the cone, or the mode is nearly singular. Without certification cones are
    #: checked at rows.
    proved: bool
    #: The name of the crank or slide; empty for values and cones.
    drive: str = ""


def limit_events(track: Track) -> list[LimitEvent]:
    """Return the events at which a trajectory leaves limits or keeps them again, by t.

    Those of cranks and slides only if they move.
    """
    machine = machine_of(track)
    q = drive_rows(track, machine)
    found = [*_ranges(track, machine, q), *_dead_points(track, machine, q), *_cones(track)]
    return sorted(found, key=lambda event: (event.low, event.high, event.constraint))


def machine_of(track: Track) -> Machine:
    """Return what moves along a track: its drives, or six values while these stay."""
    return Machine.of(track.instance) if track.coordinates else value_machine(track.instance)


def drive_rows(track: Track, drives: Machine) -> Array:
    """Return the numbers of the drives in each row, lengths and radians, shape (r, m)."""
    q = drives.of_values(track.values)
    for c, one in enumerate(track.coordinates):
        k = drives.names.index(one.name)
        q[:, k] = track.places[:, c] * drives.units[k]
    return q


def _ranges(track: Track, drives: Machine, q: Array) -> Iterator[LimitEvent]:
    for k in ranged(drives).tolist():
        ends = [drives.low[k], drives.high[k]]
        ends += [-end for end in ends] if drives.two_sided[k] else []
        limit = _range_event(drives, k)
        for time, leaves in crossings(track.t, drives, q, k, np.array(ends)):
            yield replace(limit, leaves=leaves, low=time, high=time)


def crossings(
    t: Array, drives: Machine, q: Array, k: int, ends: Array
) -> Iterator[tuple[float, bool]]:
    """Yield when a drive that is linear between rows leaves its range (true) or is in it again.

    Parameters
    ----------
    t, drives, q
        The rows, shape (r,), and the drives there, shape (r, m).
    k, ends
        The drive, and the numbers at which its range begins or ends, shape (e,).
    """
    numbers = q[:, k]
    first, change = numbers[:-1, None], np.diff(numbers)[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        parts = (ends - first) / change
    # Cuts outside the rows are NaN and are sorted last.
    cuts = np.sort(np.where((parts > 0) & (parts < 1), parts, np.nan), axis=1)
    edge = np.zeros((len(cuts), 1))
    begins = np.hstack((edge, cuts))
    stops = np.nan_to_num(np.hstack((cuts, edge + 1)), nan=1.0)
    real = ~np.isnan(begins)
    middles = (first + (begins + stops) / 2 * change)[real]
    times = np.concatenate((t[:1], (t[:-1, None] + begins * np.diff(t)[:, None])[real]))
    looked = np.zeros((1 + len(middles), drives.count))
    looked[:, k] = np.concatenate((numbers[:1], middles))
    now = drives.outside(looked)[:, k]
    changes = np.flatnonzero(now != np.concatenate(([False], now[:-1])))
    yield from zip(times[changes].tolist(), now[changes].tolist(), strict=True)


def _dead_points(track: Track, drives: Machine, q: Array) -> list[LimitEvent]:
    there = ~np.isnan(track.T[..., 0])
    gains = np.full((*track.T.shape[:2], len(drives.index)), np.nan)
    numbers = np.broadcast_to(q, (len(track.modes), *q.shape))
    gains[there] = drives.gains(track.R[there], track.T[there], numbers[there])
    found = []
    for m, mode in enumerate(track.modes.tolist()):
        for k in np.flatnonzero(drives.driven).tolist():
            known = np.abs(gains[m, :, k]) > _SIGN_KNOWN * drives.arms[k]
            rows = np.flatnonzero(known)
            signs = np.sign(gains[m, rows, k])
            for i in np.flatnonzero(signs[1:] != signs[:-1]):
                low, high = track.t[rows[[i, i + 1]]].tolist()
                name = drives.names[drives.index[k]]
                event = LimitEvent(
                    "dead point", True, k, "", mode, low, high, track.certified, name
                )
                found.append(event)
    return found


def cones_proved(track: Track) -> bool:
    """Whether all statements about cones are proved, also between rows."""
    legs = [joint.constraint for joint in machine_of(track).cones]
    if not track.certified or len(track.t) < 2 or not (track.values[:, legs] >= 0).all():
        return False
    try:
        follower = RowFollower(track.followed, track.coordinates)
    except ArgumentError:
        return False
    return follower.knows(_followed(track))


def _followed(track: Track) -> Array:
    """Return values and numbers of drives at the rows, shape (r, 6 + d)."""
    return np.column_stack((track.values, track.places)) if track.coordinates else track.values


def _cones(track: Track) -> list[LimitEvent]:
    if not machine_of(track).cones:
        return []
    return _between_rows(track) if cones_proved(track) else _at_rows(track)


def _between_rows(track: Track) -> list[LimitEvent]:
    """Return the events of cones, proved between rows, too."""
    rows, found = _followed(track), []
    machine = (Machine.of if track.coordinates else value_machine)(track.followed)
    numbers = drive_rows(track, machine)
    follower = RowFollower(track.followed, track.coordinates)
    measure = cone_margins(machine)
    for m, mode in enumerate(track.modes.tolist()):
        # Modes that begin on the way are followed back from the last row.
        step = -1 if np.isnan(track.T[m, 0, 0]) else 1
        R, T = track.R[m, ::step], track.T[m, ::step]
        path = PathRows(
            machine, track.values[::step], R, T, numbers[::step], None, follower, rows[::step]
        )
        end = int(np.isfinite(T[:, 0]).sum())
        parts = ValueParts(path, np.arange(min(end, len(rows) - 1)))
        begin, stop, sign = signs(measure, parts, len(machine.cones))
        if step < 0:
            begin, stop, sign = len(rows) - 1 - stop[::-1], len(rows) - 1 - begin[::-1], sign[::-1]
        stretches = begin, stop, sign
        found += _proved_events(
            track.t, stretches, _cone_events(machine, mode), *_lifetime(track, mode)
        )
    return found


def _range_event(machine: Machine, k: int) -> LimitEvent:
    """Return an event of the range of a drive, without its time."""
    name = machine.names[k] if machine.moved[k] else ""
    return LimitEvent("range", True, int(machine.first[k]), "", None, np.nan, np.nan, True, name)


def _cone_events(machine: Machine, mode: int) -> list[LimitEvent]:
    """Return an event of each cone, without its time."""
    return [
        LimitEvent("cone", True, one.constraint, one.body, mode, np.nan, np.nan, False)
        for one in machine.cones
    ]


def _proved_events(
    t: Array,
    stretches: tuple[Array, Array, Index],
    limits: list[LimitEvent],
    low: float,
    high: float,
) -> list[LimitEvent]:
    """Return the events of some limits from low to high, by the `signs` of their margins."""
    begin, stop, sign = stretches
    rows = np.arange(len(t))
    times = list(zip(*(np.interp(x, rows, t).tolist() for x in (begin, stop)), strict=True))
    # Next to a fold parts get too short to be proved.
    room = float(_BESIDE * np.diff(t).max(initial=0.0))
    return [
        replace(limit, leaves=leaves, low=since, high=until, proved=proved)
        for limit, states in zip(limits, sign.T.tolist(), strict=True)
        for leaves, since, until, proved in _changes(times, states, low, high, room)
    ]


def _lifetime(track: Track, mode: int) -> tuple[float, float]:
    """Return the interval of t on which a mode is known."""
    low, high = float(track.t[0]), float(track.t[-1])
    for event in track.events:
        if event.mode == mode:
            low, high = (event.high, high) if event.begins else (low, event.low)
    return low, high


def _changes(
    times: Sequence[tuple[float, float]],
    states: Sequence[int],
    low: float,
    high: float,
    room: float,
) -> Iterator[tuple[bool, float, float, bool]]:
    """Yield the events of one cone: whether it is left, the interval of t, whether it is proved.

    Parameters
    ----------
    times, states
        The proved stretches, in order; there may be gaps.
    low, high
        The interval that the stretches should cover, up to `room`.
    """
    state, since, allowed = 1, low, room
    for (begin, end), now in zip(times, states, strict=True):
        if now == 0:
            continue
        if now != state:
            yield now < 0, since, begin, True
        elif begin - since > allowed:
            yield True, since, begin, False
        state, since, allowed = now, end, 0.0
    if high - since > room:
        yield True, since, high, False


def _at_rows(track: Track) -> list[LimitEvent]:
    """Return the events of cones by the poses at the rows; each event is between two rows."""
    cones = machine_of(track).cones
    outside = np.zeros((*track.T.shape[:2], len(cones)), bool)
    for rows, instance in track.instances():
        with np.errstate(invalid="ignore"):
            still = value_machine(instance)
            outside[:, rows] = still.out_of_cones(track.R[:, rows], track.T[:, rows])
    there = ~np.isnan(track.T[..., 0])
    found = []
    for m, mode in enumerate(track.modes.tolist()):
        rows_there = there[m].nonzero()[0]
        for k, cone in enumerate(cones):
            state, before = False, None
            for row in rows_there.tolist():
                now = bool(outside[m, row, k])
                if now != state:
                    low, high = track.t[[row if before is None else before, row]].tolist()
                    found.append(
                        LimitEvent("cone", now, cone.constraint, cone.body, mode, low, high, False)
                    )
                    state = now
                before = row
    return found


#: Rods are the stated ones up to this part of their length.
_SAME = 1e-12

#: What is judged between rows: whether the least counts, not the largest.
_BOUNDS = {
    "condition": largest_conditions,
    "clearance": least_clearances,
    "gap": least_gaps,
    "transmission": least_transmissions,
}
BOUNDED = {"condition": False, "clearance": True, "gap": True, "transmission": True}


@dataclass(frozen=True)
class Between:
    """A way between two rows on which a requirement is not proved."""

    #: The number of the mode.
    mode: int
    #: The row before it, from 0.
    row: int
    #: What is proved there: at most this condition number, at least this clearance or gap.
    bound: float


def can_be_bounded(track: Track, quantity: str = "") -> bool:
    """Whether bounds of a quantity between the rows of a track are known.

    Its ways are proved, and where drives move the rods are those stated. Arms
    of cranks that stay while the rods change have gaps at the rows only.
    """
    if not track.certified or len(track.t) < 2:
        return False
    if track.coordinates:
        return moves_by_drives(track)
    return quantity != "gap" or not arms_of(track.instance)


def moves_by_drives(track: Track) -> bool:
    """Whether cranks and slides move a track, and nothing else, with the stated rods."""
    instance = track.instance
    if not track.coordinates:
        return False
    drives = Machine.of(instance)
    rods = track.values[:, drives.driven] - drives.rods[drives.driven]
    return bool((np.abs(rods) <= _SAME * np.abs(drives.rods[drives.driven])).all())


def worst_between(
    track: Track,
    quantity: str,
    wanted: float,
    ways: PoseWays | None = None,
    frame: PoseFrame | None = None,
) -> Between | None:
    """Return the way between two rows on which a quantity is worst; None if all are proved.

    Parameters
    ----------
    track
        A track for which `can_be_bounded` holds.
    quantity
        A key of `BOUNDED`.
    wanted
        The largest condition number, or the least clearance, gap or transmission.
    ways
        Straight ways in position and angles, if they lead from row to row; None for values and
        drives.
    frame
        The frame of the poses of these ways; None for the platform's own.
    """
    worst: Between | None = None
    least = BOUNDED[quantity]
    for k, mode in enumerate(track.modes.tolist()):
        there = np.flatnonzero(~np.isnan(track.T[k, :, 0]))
        if len(there) < 2:
            continue
        at, bounds = _BOUNDS[quantity](_rows(track, k, there, ways, frame), wanted)
        sign = 1 if least else -1
        ends = np.minimum(sign * at[:-1], sign * at[1:])
        row = int(np.lexsort((ends, sign * bounds))[0])
        kept = sign * bounds[row] >= sign * wanted
        if not kept and (worst is None or sign * bounds[row] < sign * worst.bound):
            worst = Between(mode, int(there[row]), float(bounds[row]))
    return worst


def _rows(
    track: Track, k: int, there: NDArray[np.int64], ways: PoseWays | None, frame: PoseFrame | None
) -> PathRows:
    """Return the rows of one mode."""
    R, T, values = track.R[k, there], track.T[k, there], track.values[there]
    if ways is not None:
        if frame is not None:
            R, T = frame.from_platform(R, T)
        return PathRows.of_poses(ways, R, T, ways.continued(R, T))
    if track.coordinates:
        machine = Machine.of(without_corrections(track.instance))
        q = drive_rows(track, machine)[there]
        # Where no home is stated the working modes are those of the mode.
        machine = replace(machine, signs=machine.modes_at(R[0], T[0], q[0]))
        geometry = MovingGeometry(track.followed, track.coordinates)
        return PathRows.of_drives(machine, geometry.rows, q, R, T)
    instance = value_machine(without_corrections(track.followed)).instance
    # Limits are judged apart: a way that leaves them has its condition numbers all the same.
    rows = tuple(replace(row, limits=None) for row in instance.constraints)
    free = ValueWays(replace(instance, constraints=rows), np.sign(values[0]))
    return PathRows.of_values(free, values, R, T, weights_of(value_machine(track.instance))[0])


@dataclass(frozen=True, eq=False)
class PoseTrack:
    """A file of poses as a track."""

    #: The poses as the only mode; it ends with an undecided event before the first way that is not
    #: proved to be regular.
    track: Track
    #: The straight ways in position and angles, in the frames of the poses.
    ways: PoseWays
    #: Where ranges and cones are left, or not proved to be kept.
    limits: tuple[LimitEvent, ...]


def pose_track(
    instance: Instance,
    expressed: Instance,
    frame: PoseFrame,
    t: Array,
    R: Array,
    T: Array,
    *,
    sequence: str,
    mode: int,
    steps: int = 1,
) -> PoseTrack:
    """Prove the straight ways between the rows of a file of poses.

    Parameters
    ----------
    instance
        The platform, without offsets of readings.
    expressed
        The same in the frames in which poses are expressed.
    frame
        These frames; the position that changes linearly is that of their origin on the platform.
    t, R, T
        The n rows, poses of the platform.
    sequence
        The order of the axes of the angles that change linearly.
    mode
        The number of the mode.
    steps
        This many rows are made of each.
    """
    origin = np.zeros(3)
    machine = Machine.of(instance).at_home(R[0], T[0])
    regular, inside = (
        PoseWays(
            expressed, pivot=origin, sequence=sequence, limits=limits, working_modes=machine.signs
        )
        for limits in (False, True)
    )
    parameters = regular.continued(*frame.from_platform(R, T))
    if steps > 1:
        rows = np.arange(len(t))
        places = np.linspace(0, len(t) - 1, steps * (len(t) - 1) + 1)
        parameters = np.stack([np.interp(places, rows, one) for one in parameters.T], axis=1)
        t = np.interp(places, rows, t)
        R, T = frame.to_platform(*regular.poses(parameters))
    moving = _moving(machine, R, T, t)
    events: tuple[Event, ...] = ()
    cells, end = 0, len(t)
    for k in range(len(t) - 1):
        proof = regular.prove(parameters[k], parameters[k + 1])
        cells += proof.cells
        if not proof.sign:
            reason = _reason(proof)
            low, high = float(t[k]), float(t[k + 1])
            events = (Event("undecided", reason, False, mode, k, low, high, R[k], T[k]),)
            end = k + 1
            break
    if len(t) == 1 and not regular.at(parameters[0]).sign:
        reason = "the pose is nearly singular"
        here = float(t[0])
        events = (Event("undecided", reason, False, mode, 0, here, here, R[0], T[0]),)
    known = np.arange(len(t)) < end
    track = Track(
        instance,
        instance,
        t,
        machine.values(R, T),
        np.array([mode]),
        np.where(known[:, None, None], R, np.nan)[None],
        np.where(known[:, None], T, np.nan)[None],
        True,
        events,
        None,
        cells,
        known=mode,
        **moving,
    )
    limits = tuple(_left_on_poses(inside, parameters[:end], t, mode))
    return PoseTrack(track, regular, limits)


def _moving(machine: Machine, R: Array, T: Array, t: Array) -> dict[str, Any]:
    """Return the cranks and slides of a track and what they are at, as `Track` has them.

    Raises
    ------
    ArgumentError
        If the machine cannot take a row.
    """
    if not machine.moves:
        return {}
    q = machine.along(R, T)
    if missing := refusals(machine, R, T, q):
        row = min(missing)
        raise ArgumentError(missing[row], f"the pose at t = {t[row]:.10g}")
    moved = np.flatnonzero(machine.moved).tolist()
    chosen = choose(machine.instance, [machine.names[k] for k in moved])
    return {"coordinates": chosen, "places": (q / machine.units)[:, moved]}


def _reason(proof: WayProof) -> str:
    """Return why a way is not proved to be regular, in words."""
    if proof.shared:
        return "rods that share a motor are not parallel on the straight way"
    if proof.reason.startswith("reach"):
        return f"a rod may not reach its motor on the straight way ({proof.reason})"
    if proof.reason == "limit":
        return "a rod does not reach its motor on the straight way"
    return "a pose on the straight way may be singular"


def _left_on_poses(ways: PoseWays, parameters: Array, t: Array, mode: int) -> list[LimitEvent]:
    """Return where limits are left on straight ways of poses, or kept again."""
    machine, k = ways.machine, ranged(ways.machine)
    open_ = [
        j
        for j in range(len(parameters) - 1)
        if not ways.prove(parameters[j], parameters[j + 1]).sign
    ]
    if not open_ or not (len(k) or machine.cones):
        return []
    limits = [*(_range_event(machine, one) for one in k.tolist()), *_cone_events(machine, mode)]
    path = PathRows.of_poses(ways, *ways.poses(parameters), parameters)
    begin, stop, sign = signs(limit_margins(machine), PoseParts(path, np.array(open_)), len(limits))
    whole = np.setdiff1d(np.arange(len(parameters) - 1), open_)
    begin, stop = np.append(begin, whole), np.append(stop, whole + 1)
    order = np.argsort(begin, kind="stable")
    sign = np.concatenate((sign, np.ones((len(whole), len(limits)), np.int64)))
    stretches = begin[order], stop[order], sign[order]
    ends = float(t[0]), float(t[len(parameters) - 1])
    found = _proved_events(t, stretches, limits, *ends)
    return sorted(found, key=lambda event: (event.low, event.high, event.constraint))
