"""Pieces of the ways between the rows of a proved path, and how near their poses are to each other.

A way of values is followed once more, and each proved part is kept: on it the pose is within a
radius of a chord in Study coordinates. A way of poses is straight in position and angles. So on a
piece of either all poses are near to the one in its middle. A bound of what changes on a piece
bounds a quantity on it; where that does not suffice the piece is halved.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.branches.taylor import MovingSystem
from gspcli.certification.equations.local_frames import LocalFrames
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import apply, quaternion_product
from gspcli.motion.collisions.driven_moves import slips_near
from gspcli.motion.following.branch_follower import FollowOptions, StudyUnits
from gspcli.motion.following.branch_steps import BranchSteps, Segment
from gspcli.motion.following.chords import on_patch
from gspcli.motion.paths.between_rows import PathRows
from gspcli.motion.paths.driven_rows import DrivenRows
from gspcli.motion.paths.pose_ways import PoseWays

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: How often a part of a way is halved at most.
_HALVINGS = 14
#: Most pieces that are judged together: beyond that the search ends.
_MOST_PIECES = 10_000
#: Into how many rows ways of values are divided, one after the other, where that is needed, and
#: most of such rows.
_STEPS, _MOST_STEPS = (1, 8, 64), 4000
_OUTWARD = 1 + 2.0**-30
#: Rounding errors of Study points of norm one and of parameters, relative to their sizes.
_ROUNDING = 2.0**-44


class Near(NamedTuple):
    """Poses, and how near to them all poses of some pieces are."""

    R: Array
    T: Array
    shifts: Array
    """How far the centre of the platform moves, shape (n,)."""
    turns: Array
    """By which angle the platform turns, in radians, shape (n,)."""
    q: Array | None = None
    """The numbers of cranks and slides at the poses, shape (n, m), if there are any."""
    slips: Array | None = None
    """How far these move the points of constraints, in their bodies, shape (n, 6)."""


#: Returns a quantity in the middle of pieces, and proved lower bounds of it on them, shapes (n,).
Measure = Callable[[Near], tuple[Array, Array]]


class PoseParts:
    """The straight ways of poses between rows, each one part.

    Parameters
    ----------
    rows
        The rows.
    ways
        The straight ways between them.
    centre
        Of the platform, shape (3,).
    """

    def __init__(self, rows: PathRows, ways: PoseWays, centre: Array) -> None:
        assert rows.parameters is not None
        first, last = rows.parameters[:-1], rows.parameters[1:]
        self.way = np.arange(len(first))
        self._ways, self._middle, self._change = ways, (first + last) / 2, last - first
        self._centre = centre
        self._away = float(np.linalg.norm(centre - ways.pivot))

    def near(self, part: Index, place: Array, half: float) -> Near:
        """Return the poses in the middle of pieces, and how near the others are."""
        change = self._change[part]
        middle = self._middle[part] + place[:, None] * change
        widths = np.abs(change) * half * _OUTWARD + _ROUNDING * np.abs(middle)
        turns = widths[:, 3:].sum(axis=1) * _OUTWARD
        shifts = (np.linalg.norm(widths[:, :3], axis=1) + turns * self._away) * _OUTWARD
        R, T = self._ways.poses(middle)
        motors = self._ways.motors
        if motors is None:
            return Near(R, T, shifts, turns)
        q = motors.drives.inverse(R, T, motors.knees)
        slips = slips_near(motors.drives, R, T, q, shifts, turns, self._centre)
        return Near(R, T, shifts, turns, q, slips)


class ValueParts:
    """The proved parts of some ways of values or drives, each of which is followed in steps.

    Parameters
    ----------
    rows
        The rows.
    followed
        What moves between them, and its numbers at the rows, shape (r, k).
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
        followed: tuple[MovingSystem, Array],
        ways: Index,
        steps: int,
        centre: Array,
    ) -> None:
        system, numbers = followed
        self._units = StudyUnits(system.scale, LocalFrames.none())
        self._centre, self._scale = centre, system.scale
        share = (np.arange(steps + 1) / steps)[:, None]
        first, last = numbers[ways, None], numbers[ways + 1, None]
        values = first + (last - first) * share
        values[:, -1:] = last
        kept: list[Segment] = []
        follower = BranchSteps(system, values, FollowOptions(), kept=kept)
        follower.run(np.arange(len(ways)), self._units.points(rows.R[ways], rows.T[ways]))
        self.way = ways[[one.branch for one in kept]] if kept else np.zeros(0, np.int64)
        #: The ways that are proved from end to end.
        self.whole = ways[_covered(kept, len(ways), steps)]
        ends = [np.array([getattr(one, key) for one in kept]) for key in ("first", "last")]
        _, self._z, self._d = on_patch(*(one.reshape(-1, 8) for one in ends))
        self._radius = np.array([one.radius for one in kept])
        # Where the parts are on their ways, from 0 to 1.
        self._width = np.array([2.0**-one.level / steps for one in kept])
        self._begin = np.array([(one.row + one.part * 2.0**-one.level) / steps for one in kept])
        self._rows = rows

    def near(self, part: Index, place: Array, half: float) -> Near:
        """Return the poses in the middle of pieces, and how near the others are.

        With e and f of a Study point, the platform's centre c is at ``(2 f + e c) / e`` times the
        scale. In a frame with its origin there, at b in the middle of the piece, that is
        ``(2 f + e c - b e) / e``. The numerator is linear in the Study point. In the middle it is
        ``2 (e . f) / |e|^2`` times e, for a chord leaves the Study quadric.
        """
        d = self._d[part]
        x = self._z[part] + place[:, None] * d
        R, T = self._units.poses(x)
        c = np.broadcast_to(self._centre / self._scale, T.shape)
        b = (T + apply(R, np.broadcast_to(self._centre, T.shape))) / self._scale
        c, b = (np.concatenate((np.zeros((len(T), 1)), one), axis=1) for one in (c, b))
        radius = self._radius[part] + _ROUNDING * np.linalg.norm(x, axis=1)
        moving = 2 * d[:, 4:] + quaternion_product(d[:, :4], c) - quaternion_product(b, d[:, :4])
        arms = 2 + np.linalg.norm(c, axis=1) + np.linalg.norm(b, axis=1)
        n = np.linalg.norm(x[:, :4], axis=1)
        moved = np.linalg.norm(moving, axis=1) * half + (radius + _ROUNDING) * arms
        moved += 2 * np.abs(np.einsum("ni,ni->n", x[:, :4], x[:, 4:])) / n
        turned = np.linalg.norm(d[:, :4], axis=1) * half + radius
        good = turned < n
        with np.errstate(all="ignore"):
            turns = 2 * np.arcsin(np.where(good, turned / n, 1.0)) * _OUTWARD
            shifts = moved / (n - turned) * self._scale * _OUTWARD
        shifts, turns = np.where(good, shifts, np.inf), np.where(good, turns, np.inf)
        rows = self._rows
        if not isinstance(rows, DrivenRows):
            return Near(R, T, shifts, turns)
        # Drives move linearly on the whole way.
        assert rows.motors is not None
        assert rows.numbers is not None
        drives, way = rows.motors.drives, self.way[part]
        width = self._width[part]
        change = rows.numbers[way + 1] - rows.numbers[way]
        share = self._begin[part] + (0.5 + place) * width
        q = rows.numbers[way] + change * share[:, None]
        sweep = np.abs(change) * (half * width)[:, None] * _OUTWARD
        sweep += _ROUNDING * (np.abs(rows.numbers[way]) + np.abs(change))
        slips = np.where(drives.driven, drives.arms * sweep[:, drives.index], 0.0)
        return Near(R, T, shifts, turns, q, slips)


def _covered(kept: list[Segment], ways: int, steps: int) -> NDArray[np.bool_]:
    """Return which ways are covered by proved parts, without a gap between them."""
    ends = np.zeros(ways)
    for one in sorted(kept, key=lambda one: one.row + one.part * 2.0**-one.level):
        size = 2.0**-one.level
        if one.row + one.part * size <= ends[one.branch]:
            ends[one.branch] = max(ends[one.branch], one.row + (one.part + 1) * size)
    return np.asarray(ends == steps)


def least_on_ways(rows: PathRows, at: Array, measure: Measure, wanted: float) -> Array:
    """Return proved lower bounds of a quantity on the ways between rows, shape (r - 1,).

    Where they are below what is asked for, parts of ways are halved as long as that may help. They
    are minus infinity where nothing is proved, and on ways with an end that has less.

    Parameters
    ----------
    rows
        The rows; the ways between them are straight.
    at
        The quantity at the rows, shape (r,).
    measure
        Bounds it on pieces.
    wanted
        What is asked for.
    """
    found = np.minimum(at[:-1], at[1:])
    lost = ~(found >= wanted)
    found[lost] = -np.inf
    if lost.all():
        return found
    centre = Arrangement.of(rows.instance).platform_centre
    if rows.parameters is not None:
        assert isinstance(rows.ways, PoseWays)
        return _judged(measure, PoseParts(rows, rows.ways, centre), found, lost, wanted)
    followed = rows.followed()
    if followed is None:
        return np.full(len(found), -np.inf)
    ways = np.flatnonzero(~lost)
    proved = found
    for steps in _STEPS:
        some = ValueParts(rows, followed, ways, steps, centre)
        now = np.full(len(found), -np.inf)
        now[some.whole] = found[some.whole]
        proved = proved.copy()
        proved[ways] = _judged(measure, some, now, lost, wanted)[ways]
        ways = np.flatnonzero(~(proved >= wanted) & ~lost)
        if not 0 < len(ways) * steps < _MOST_STEPS:
            break
    return proved


def _judged(
    measure: Measure,
    parts: PoseParts | ValueParts,
    found: Array,
    lost: NDArray[np.bool_],
    wanted: float,
) -> Array:
    """Return lower bounds on ways, (w,); `lost` gets those on which a pose is seen to have less.

    Parameters
    ----------
    measure
        Bounds the quantity on pieces.
    parts
        Of the ways.
    found
        Bounds that are known already, shape (w,).
    lost
        The ways whose ends have less, shape (w,).
    wanted
        What is asked for.
    """
    found = found.copy()
    part = np.flatnonzero(~lost[parts.way])
    place = np.zeros(len(part))
    for halving in range(_HALVINGS + 1):
        if not len(part):
            break
        half = 0.5 ** (halving + 1)
        low, bounds = measure(parts.near(part, place, half))
        # A pose that has less ends the search on its way.
        lost[parts.way[part[~(low >= wanted)]]] = True
        again = ~(bounds >= wanted) & ~lost[parts.way[part]]
        if again.any():
            # Halving must help where pieces have no length.
            _, best = measure(parts.near(part[again], place[again], 0.0))
            again[np.flatnonzero(again)[~(best >= wanted)]] = False
        last = halving == _HALVINGS or 2 * np.count_nonzero(again) > _MOST_PIECES
        done = ~again | last
        np.minimum.at(found, parts.way[part[done]], bounds[done])
        if last:
            break
        part, place = np.repeat(part[again], 2), np.repeat(place[again], 2)
        place = place + np.tile((-half / 2, half / 2), len(place) // 2)
    return found
