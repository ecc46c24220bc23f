"""The least gap between legs and bodies on the ways between the rows of a proved path.

A way of values is followed once more, and each proved part is kept: on it the pose is within a
radius of a chord in Study coordinates. A way of poses is straight in position and angles. So on a
piece of either all poses are near to the one in its middle, and no gap changes by more than the
corners of its two shapes move. Where that does not suffice a piece is halved.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.equations.local_frames import LocalFrames
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import apply, quaternion_product
from gspcli.motion.collisions.compared import ComparedShapes
from gspcli.motion.following.branch_follower import FollowOptions, StudyUnits
from gspcli.motion.following.branch_steps import BranchSteps, Segment
from gspcli.motion.following.chords import on_patch
from gspcli.motion.paths.between_rows import PathRows
from gspcli.motion.paths.motors import Motors
from gspcli.motion.paths.pose_ways import PoseWays
from gspcli.motion.paths.value_ways import ValueWays

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


class _Near(NamedTuple):
    """Poses, and how near to them all poses of some pieces are."""

    R: Array
    T: Array
    shifts: Array
    """How far the centre of the platform moves, shape (n,)."""
    turns: Array
    """By which angle the platform turns, in radians, shape (n,)."""


class _PoseParts:
    """The straight ways of poses between rows, each one part."""

    def __init__(self, rows: PathRows, ways: PoseWays, centre: Array) -> None:
        assert rows.parameters is not None
        first, last = rows.parameters[:-1], rows.parameters[1:]
        self.way = np.arange(len(first))
        self._ways, self._middle, self._change = ways, (first + last) / 2, last - first
        self.motors = ways.motors
        self._away = float(np.linalg.norm(centre - ways.pivot))

    def near(self, part: Index, place: Array, half: float) -> _Near:
        """Return the poses in the middle of pieces, and how near the others are."""
        change = self._change[part]
        middle = self._middle[part] + place[:, None] * change
        widths = np.abs(change) * half * _OUTWARD + _ROUNDING * np.abs(middle)
        turns = widths[:, 3:].sum(axis=1)
        shifts = np.linalg.norm(widths[:, :3], axis=1) + turns * self._away
        return _Near(*self._ways.poses(middle), shifts * _OUTWARD, turns * _OUTWARD)


class _ValueParts:
    """The proved parts of some ways of values, each of which is followed in steps.

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

    def __init__(self, rows: PathRows, ways: Index, steps: int, centre: Array) -> None:
        assert isinstance(rows.ways, ValueWays)
        system = rows.ways.system
        self._units = StudyUnits(system.scale, LocalFrames.none())
        self._centre, self._scale = centre, system.scale
        self.motors: Motors | None = None
        share = (np.arange(steps + 1) / steps)[:, None]
        first, last = rows.values[ways, None], rows.values[ways + 1, None]
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

    def near(self, part: Index, place: Array, half: float) -> _Near:
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
        return _Near(R, T, np.where(good, shifts, np.inf), np.where(good, turns, np.inf))


def _covered(kept: list[Segment], ways: int, steps: int) -> NDArray[np.bool_]:
    """Return which ways are covered by proved parts, without a gap between them."""
    ends = np.zeros(ways)
    for one in sorted(kept, key=lambda one: one.row + one.part * 2.0**-one.level):
        size = 2.0**-one.level
        if one.row + one.part * size <= ends[one.branch]:
            ends[one.branch] = max(ends[one.branch], one.row + (one.part + 1) * size)
    return np.asarray(ends == steps)


def least_gaps(rows: PathRows, wanted: float) -> tuple[Array, Array]:
    """Return proved lower bounds of the least gap at rows, (r,), and between them, (r - 1,).

    Where they are below the gap that is asked for, parts of ways are halved as long as that may
    help. They are minus infinity where nothing is proved, and on ways with an end that is too near.

    Parameters
    ----------
    rows
        The rows of a platform with shapes.
    wanted
        The gap that is asked for.
    """
    compared = ComparedShapes(rows.instance)
    motors = rows.ways.motors if isinstance(rows.ways, PoseWays) else None
    q = None if motors is None else motors.numbers(rows.R, rows.T)
    at = compared.bounds(rows.R, rows.T, q).low.min(axis=1)
    found = np.minimum(at[:-1], at[1:])
    if not len(found):
        return at, found
    if rows.bulges is not None and rows.bulges.any():
        return at, np.minimum(found, rows.gap_bounds(compared))
    centre = Arrangement.of(rows.instance).platform_centre
    lost = ~(found >= wanted)
    found[lost] = -np.inf
    if lost.all():
        return at, found
    if motors is not None and rows.parameters is None:
        # Along drives the poses between rows are not known.
        return at, np.full(len(found), -np.inf)
    if isinstance(rows.ways, PoseWays):
        parts = _PoseParts(rows, rows.ways, centre)
        return at, _judged(compared, parts, centre, found, lost, wanted)
    ways = np.flatnonzero(~lost)
    proved = found
    for steps in _STEPS:
        some = _ValueParts(rows, ways, steps, centre)
        now = np.full(len(found), -np.inf)
        now[some.whole] = found[some.whole]
        proved = proved.copy()
        proved[ways] = _judged(compared, some, centre, now, lost, wanted)[ways]
        ways = np.flatnonzero(~(proved >= wanted) & ~lost)
        if not 0 < len(ways) * steps < _MOST_STEPS:
            break
    return at, proved


def _judged(
    compared: ComparedShapes,
    parts: _PoseParts | _ValueParts,
    centre: Array,
    found: Array,
    lost: NDArray[np.bool_],
    wanted: float,
) -> Array:
    """Return lower bounds on ways, (w,); `lost` gets those on which a pose is seen to be too near.

    Parameters
    ----------
    compared
        The shapes.
    parts
        Of the ways.
    centre
        Of the platform, shape (3,).
    found
        Bounds that are known already, shape (w,).
    lost
        The ways whose ends are too near, shape (w,).
    wanted
        The gap that is asked for.
    """
    found = found.copy()
    part = np.flatnonzero(~lost[parts.way])
    place = np.zeros(len(part))
    for halving in range(_HALVINGS + 1):
        if not len(part):
            break
        half = 0.5 ** (halving + 1)
        low, bounds = _on_pieces(compared, parts.near(part, place, half), centre, parts.motors)
        # A pose that is too near ends the search on its way.
        lost[parts.way[part[~(low >= wanted)]]] = True
        again = ~(bounds >= wanted) & ~lost[parts.way[part]]
        # Halving must help where pieces have no length.
        nearest = parts.near(part[again], place[again], 0.0)
        _, best = _on_pieces(compared, nearest, centre, parts.motors)
        again[np.flatnonzero(again)[~(best >= wanted)]] = False
        last = halving == _HALVINGS or 2 * np.count_nonzero(again) > _MOST_PIECES
        done = ~again | last
        np.minimum.at(found, parts.way[part[done]], bounds[done])
        if last:
            break
        part, place = np.repeat(part[again], 2), np.repeat(place[again], 2)
        place = place + np.tile((-half / 2, half / 2), len(place) // 2)
    return found


def _on_pieces(
    compared: ComparedShapes, near: _Near, centre: Array, motors: Motors | None
) -> tuple[Array, Array]:
    """Return lower bounds of the least gaps in the middle of pieces, and on them, shapes (n,)."""
    q = None if motors is None else motors.numbers(near.R, near.T)
    low = compared.bounds(near.R, near.T, q).low
    driven = None if q is None else (near.R, near.T, q)
    places = near.T + apply(near.R, np.broadcast_to(centre, near.T.shape))
    with np.errstate(invalid="ignore"):
        moves = compared.moves(near.shifts, near.turns, centre, places, driven)
        bounds = np.nan_to_num((low - moves).min(axis=1), nan=-np.inf, neginf=-np.inf)
    return low.min(axis=1), bounds
