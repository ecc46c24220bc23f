"""What holds between the rows of a proved path: bounds of clearances and of condition numbers.

Between two rows either the values change linearly, or the position and the angles do. Each half of
the way between them belongs to the row at its end. The poses on it are near to that of the row: for
values by the theorem of `gspcli.motion.singularities.neighbourhoods`, else since parameters
are known. Where a bound does not suffice the way is halved, by a pose in its middle.

Clearances need less. Let a pose have the clearance r, and let the values on the way from it change
by at most s, by their weights. Then a pose on the way has at least the clearance ``r - s``: its box
lies in the box of the first. From both ends together this gives ``(r1 + r2 - s) / 2`` on a way of
length s.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL, Primitive
from gspcli.certification.branches.taylor import MovingSystem
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import apply
from gspcli.geometry.residuals import condition_numbers
from gspcli.motion.collisions.compared import ComparedShapes
from gspcli.motion.following.branch_follower import MovingPlatform
from gspcli.motion.paths.condition_bounds import condition_bounds
from gspcli.motion.paths.pose_ways import PoseWays
from gspcli.motion.paths.value_ways import ValueWays
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.motion.singularities.clearances import clearances, range_weights
from gspcli.motion.singularities.neighbourhoods import Neighbourhood
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: How often ways between rows are halved at most where a bound does not suffice.
HALVINGS = 8
_OUTWARD = 1 + 2.0**-30
_INWARD = 1 - 2.0**-30


@dataclass(frozen=True, eq=False)
class PathRows:
    """Rows of a proved path.

    Attributes
    ----------
    ways
        Straight ways of values, or of poses, whichever leads from row to row.
    values
        Shape (r, 6), without offsets.
    R, T
        The poses, shapes (r, 3, 3) and (r, 3).
    parameters
        Position and angles, shape (r, 6), for ways of poses: each row is continued from the one
        before; None for ways of values.
    weights
        The unit of each value's changes in clearances, shape (6,); None for those of the instance.
    bulges
        How far the way between two rows is from the straight one at most, in values or parameters,
        shape (r - 1, 6); None if all ways are straight.
    """

    ways: ValueWays | PoseWays
    values: Array
    R: Array
    T: Array
    parameters: Array | None = None
    weights: Array | None = None
    bulges: Array | None = None

    @property
    def most_halvings(self) -> int:
        """How often ways between rows are halved at most for clearances."""
        return HALVINGS

    @staticmethod
    def weights_of(instance: Instance) -> Array:
        """Return the units of changes of values in the clearances of a platform, shape (6,)."""
        weights = range_weights(instance)
        return np.ones(6) if weights is None else weights

    @property
    def units(self) -> Array:
        """The unit of each value's changes in clearances, shape (6,)."""
        return self.weights_of(self.instance) if self.weights is None else self.weights

    @property
    def instance(self) -> Instance:
        """The platform."""
        return self.ways.instance

    def drive_numbers(self) -> Array | None:
        """Return what cranks and slides are at in the rows, shape (r, m); None without motors."""
        motors = self.ways.motors if isinstance(self.ways, PoseWays) else None
        return None if motors is None else motors.numbers(self.R, self.T)

    def followed(self) -> tuple[MovingSystem, Array] | None:
        """Return what moves linearly between the rows, and its numbers there, shape (r, k).

        None if the mode cannot be followed again. Not for ways of poses.
        """
        assert isinstance(self.ways, ValueWays)
        return self.ways.system, self.values

    def halved(self, gaps: NDArray[np.int64]) -> PathRows | None:
        """Return the rows with one more in the middle of some ways; None if one is not found.

        Parameters
        ----------
        gaps
            Indices of the rows before these ways, increasing, shape (g,).
        """
        if self.bulges is not None and self.bulges[gaps].any():
            return None
        if isinstance(self.ways, PoseWays):
            assert self.parameters is not None
            middle = (self.parameters[gaps] + self.parameters[gaps + 1]) / 2
            R, T = self.ways.poses(middle)
            values = values_at(self.instance, R, T)
            parameters = np.insert(self.parameters, gaps + 1, middle, axis=0)
            return replace(self._with(gaps, values, R, T), parameters=parameters)
        middle = (self.values[gaps] + self.values[gaps + 1]) / 2
        ways = np.stack((self.values[gaps], middle), axis=1)
        points = self.ways.points(self.R[gaps], self.T[gaps])
        found = self.ways.follow(ways, np.arange(len(gaps)), points)
        if not found.there.all():
            return None
        return self._with(gaps, middle, *self.ways.poses(found.points[:, -1]))

    def _with(self, gaps: NDArray[np.int64], values: Array, R: Array, T: Array) -> PathRows:
        more = {"values": values, "R": R, "T": T}
        bulges = self.bulges
        return replace(
            self,
            bulges=None if bulges is None else np.insert(bulges, gaps, 0.0, axis=0),
            **{
                name: np.insert(getattr(self, name), gaps + 1, rows, axis=0)
                for name, rows in more.items()
            },
        )

    def conditions(self) -> Array:
        """Return condition numbers at the rows, shape (r,)."""
        return condition_numbers(Arrangement.of(self.instance), self.R, self.T)

    def clearances(self) -> Array:
        """Return proved clearances of the rows, shape (r,)."""
        return clearances(self.instance, self.R, self.T, weights=self.units)

    def condition_bounds(self) -> Array:
        """Bound the condition numbers on the ways between the rows, shape (r - 1,)."""
        shifts, turns, geometry, T = self._near_rows()
        length = Arrangement.of(self.instance).length
        found = [
            condition_bounds(geometry, self.R[rows], T[rows], shifts[k], turns[k], length)
            for k, rows in enumerate((slice(None, -1), slice(1, None)))
        ]
        return np.maximum(*found)

    def gap_bounds(self, compared: ComparedShapes) -> Array:
        """Return proved lower bounds of the least gap on the ways between rows, shape (r - 1,).

        Minus infinity where there is no bound.

        Parameters
        ----------
        compared
            The shapes of the instance.
        """
        shifts, turns, _, _ = self._near_rows()
        centre = Arrangement.of(self.instance).platform_centre
        places = self.T + apply(self.R, np.broadcast_to(centre, self.T.shape))
        low = compared.bounds(self.R, self.T).low
        found = []
        for k, rows in enumerate((slice(None, -1), slice(1, None))):
            with np.errstate(invalid="ignore"):
                moves = compared.moves(shifts[k], turns[k], centre, places[rows])
            found.append((low[rows] - moves).min(axis=1))
        return np.asarray(np.nan_to_num(np.minimum(*found), nan=-np.inf, neginf=-np.inf))

    def _near_rows(self) -> tuple[Array, Array, Arrangement, Array]:
        if isinstance(self.ways, PoseWays):
            return self._on_ways(self.ways)
        return self._enclosed(self.ways.platform)

    def _on_ways(self, ways: PoseWays) -> tuple[Array, Array, Arrangement, Array]:
        """Return the same as `_enclosed` for straight ways in position and angles."""
        assert self.parameters is not None
        half = self._changes(self.parameters) / 2 * _OUTWARD
        turns = half[:, 3:].sum(axis=1)
        a = Arrangement.of(self.instance)
        away = float(np.linalg.norm(a.platform_centre - ways.pivot))
        shifts = np.linalg.norm(half[:, :3], axis=1) + turns * away
        return np.stack((shifts, shifts)), np.stack((turns, turns)), a, self.T

    def _enclosed(self, platform: MovingPlatform) -> tuple[Array, Array, Arrangement, Array]:
        """Return how far poses on the halves of the ways are from the rows at their ends.

        Shifts of the centre and turns, shapes (2, r - 1), infinite where that is not proved; the
        geometry in frames near the bodies, and T there.
        """
        near = platform.near
        T = platform.local_frames.doubles(self.R, self.T)
        points = platform.points(self.R, self.T)
        widths = np.abs(np.diff(platform.internal(self.values), axis=0)) / 2 * _OUTWARD
        if self.bulges is not None:
            widths = widths + platform.internal(self.bulges) * _OUTWARD
        a = Arrangement.of(near)
        away = float(np.linalg.norm(a.platform_centre))
        shifts, turns = [], []
        for rows in (slice(None, -1), slice(1, None)):
            there = Neighbourhood(platform, points[rows], platform.internal(self.values[rows]))
            box = there.box(widths)
            radius = np.where(box.measure < 1, box.radius, np.inf)
            n = np.linalg.norm(points[rows, :4], axis=1)
            f = np.linalg.norm(points[rows, 4:], axis=1)
            with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
                good = radius < n
                # Directions of e and e + d in four dimensions, and 2 f e^-1, the translation.
                turn = 2 * np.arcsin(np.where(good, radius / n, 1.0)) * _OUTWARD
                shift = 2 * radius / (n - radius) * (1 + f / n) * platform.scale * _OUTWARD
            turns.append(np.where(good, turn, np.inf))
            shifts.append(np.where(good, shift + turn * away, np.inf))
        return np.array(shifts), np.array(turns), a, T

    def _changes(self, numbers: Array) -> Array:
        """Bound how far numbers of a way are from both rows at its ends together, (r - 1, 6)."""
        change = np.abs(np.diff(numbers, axis=0))
        return change if self.bulges is None else change + 2 * self.bulges

    def travels(self) -> Array:
        """Bound how far values change on the ways between rows, by their weights, shape (r - 1,).

        Infinite where there is no bound.
        """
        if isinstance(self.ways, ValueWays):
            change = self._changes(self.values) * _OUTWARD
            return np.asarray((change / self.units).max(axis=1))
        assert self.parameters is not None
        a = Arrangement.of(self.instance)
        change = self._changes(self.parameters)
        move, turn = np.linalg.norm(change[:, :3], axis=1), change[:, 3:].sum(axis=1)
        own = np.linalg.norm(a.y - self.ways.pivot, axis=1)
        places = self.parameters[:-1, :3]
        base = np.linalg.norm(places[:, None] - a.x, axis=2) + move[:, None]
        seen = np.array([kind.platform is Primitive.POINT for kind in a.kinds])
        arms = np.where(seen, own, base)
        found = move[:, None] + turn[:, None] * arms
        found[:, a.angles] = turn[:, None] / a.in_radians
        found[:, [k for k, kind in enumerate(a.kinds) if kind is DLL]] = np.inf
        return np.asarray((found / self.units).max(axis=1) * _OUTWARD)


def least_clearances(
    rows: PathRows, wanted: float, halvings: int = HALVINGS
) -> tuple[Array, Array]:
    """Return proved clearances at rows, (r,), and on the ways between them, (r - 1,).

    Ways are halved where the bounds are below the least that is asked for, if that may help.

    Parameters
    ----------
    rows
        The rows.
    wanted
        The least clearance that is asked for.
    halvings
        How often ways are halved at most.
    """
    owner = np.arange(len(rows.values) - 1)
    at = rows.clearances()
    first = at
    for halving in range(halvings + 1):
        ends = np.minimum(at[:-1], at[1:])
        with np.errstate(invalid="ignore"):
            between = np.minimum(ends, (at[:-1] + at[1:] - rows.travels()) / 2 * _INWARD)
        short = np.flatnonzero((between < wanted) & (ends >= wanted))
        if not len(short) or halving == min(halvings, rows.most_halvings):
            break
        more = rows.halved(short)
        if more is None:
            break
        rows = more
        owner = np.insert(owner, short + 1, owner[short])
        middles = short + 1 + np.arange(len(short))
        fresh = replace(rows, values=rows.values[middles], R=rows.R[middles], T=rows.T[middles])
        at = np.insert(at, short + 1, fresh.clearances())
    found = np.full(len(first) - 1, np.inf)
    np.minimum.at(found, owner, between)
    return first, np.maximum(found, 0.0)


def largest_conditions(rows: PathRows, wanted: float) -> tuple[Array, Array]:
    """Return condition numbers at rows, (r,), and bounds on the ways between them, (r - 1,).

    Ways are halved where the bounds are above the largest that is allowed, if that may help.
    """
    owner = np.arange(len(rows.values) - 1)
    first = rows.conditions()
    for halving in range(HALVINGS + 1):
        at, between = rows.conditions(), rows.condition_bounds()
        long = np.flatnonzero((between > wanted) & (np.maximum(at[:-1], at[1:]) <= wanted))
        if not len(long) or halving == HALVINGS:
            break
        more = rows.halved(long)
        if more is None:
            break
        rows = more
        owner = np.insert(owner, long + 1, owner[long])
    found = np.zeros(len(first) - 1)
    np.maximum.at(found, owner, between)
    return first, found
