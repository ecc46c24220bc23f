"""The machine of a platform: what its drives move, and the poses that follow.

A drive is the value of a constraint, or it moves a point of a distance: a crank turns the point, a
slide shifts it along a rail. The numbers of the drives are q, in units of length and radians; zero
is where the point is stated. Let f be the force part of the row J_k of the Jacobian matrix: the
unit vector of the rod, from the base to the platform. Let B'(q) be the velocity of the point. The
gain of the drive of constraint k is

    g = f.B'(q)     for a point of the base
    g = -f.R p'(q)  for a point of the platform
    g = 1           for the value itself

so that ``J t = D q'`` with the twist t and ``D[k, drive of k] = g_k``; the forces of the drives are
``tau = D^T F`` with the forces F in the rods. Where a gain is zero the drive is at a dead point: it
moves nothing along the rod. A pose has two numbers for each crank or slide, one with a positive and
one with a negative gain. The sign of the gain is the *working mode*; a machine keeps it from its
home pose.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.catalogue.kinds import DLL, DPP
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement, Array, Placed
from gspcli.geometry.coordinates import BODIES
from gspcli.geometry.instance import Constraint, Instance, Side
from gspcli.geometry.measurement import (
    Gradient,
    by_twist,
    curvature,
    gradients,
    jacobian,
    measured,
    value_signs,
)
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Cone, Crank, Geometry, Point, Slide, as_array
from gspcli.geometry.quaternions import apply, cross, dot
from gspcli.records import dataclass

#: The cosine of an angle above one by less is one: at the end of what a crank or slide can reach.
_END = 1e-12
#: Two numbers of a drive whose moduli differ by less are equally near to the stated point: radians
#: for a crank, parts of the rod for a slide.
_EQUALLY_NEAR = 1e-6
#: A number is outside a limit if it is so by more than this part of it (tilts: of a radian).
ROUNDING = 1e-12
#: The least share above 1.
_ABOVE_ONE = float(np.nextafter(1.0, 2.0))
#: Constraints with a drive together must ask for the same place, up to this part of the size.
_SAME = 1e-9
#: Below this transmission the working mode is not known.
_DEAD = 1e-6
_TURN = 2 * np.pi


@dataclass(frozen=True)
class JointCone:
    """The cone of a joint as it limits one leg."""

    #: The index of the leg.
    constraint: int
    #: The body of the joint, ``platform`` or ``base``.
    body: Literal["platform", "base"]
    #: The name of the joint.
    name: str
    #: Its axis, fixed in the body, and its half angle.
    cone: Cone


@dataclass(frozen=True, eq=False)
class Machine:
    """The m drives of a platform, in the order of the first constraint that each moves."""

    #: The platform.
    instance: Instance
    #: The names of the drives: ``crank.B1``, ``slide.B2``, or the number of a constraint whose
    #: value is driven.
    names: tuple[str, ...]
    #: ``crank``, ``slide`` or ``value``, m of them.
    sorts: tuple[str, ...]
    #: The drive of each constraint, shape (6,).
    index: NDArray[np.int64]
    #: Whether the drive of a constraint is a crank or a slide, shape (6,).
    driven: NDArray[np.bool_]
    #: Whether it moves the platform's point, shape (6,).
    on_platform: NDArray[np.bool_]
    #: The units of the numbers in radians or lengths, shape (m,).
    units: Array
    #: The ranges of q, shape (m,); infinite without a range. For the distance of a point and a
    #: plane on both sides they are those of the modulus.
    low: Array
    high: Array
    #: The errors of q, shape (m,); NaN where none is stated.
    tolerances: Array
    #: A number of a drive in the unit of the instance is its reading times the factor, plus the
    #: offset; shape (m,).
    offsets: Array
    factors: Array
    #: The place of each driven point in the frame of its body, shapes (6, 3): that of a crank is
    #: ``middle + across cos q + beside sin q``, that of a slide ``middle + beside q``.
    middle: Array
    across: Array
    beside: Array
    #: The lengths of the arms of cranks; 1 for slides and values, shape (6,).
    arms: Array
    #: The values of constraints with a crank or a slide, which stay the same, signed on a chosen
    #: side of a plane; NaN for others.
    rods: Array
    #: The working modes that `inverse` takes, (6,) or (n, 6) of n poses; None for those of home.
    signs: NDArray[np.int64] | None = None

    @classmethod
    def of(cls, instance: Instance) -> Machine:
        """Return the drives of an instance.

        Raises
        ------
        ArgumentError
            If both points of a constraint have drives.
        """
        rows, count = instance.constraints, len(instance.constraints)
        found: dict[tuple[str, str], tuple[str, str, list[float]]] = {}
        index, driven, on_platform = [], np.zeros(count, bool), np.zeros(count, bool)
        middle, across, beside = np.zeros((3, count, 3))
        arms, rods = np.ones(count), np.full(count, np.nan)
        radian = instance.units.angle.in_radians
        for k, row in enumerate(rows):
            one = _only(k, driven_points(row))
            if one is None:
                key = ("", str(k + 1))
                unit = 1.0 if row.kind.is_distance else radian
                found[key] = (str(k + 1), "value", _numbers(row, unit))
                middle[k] = as_array(row.base.position)
            else:
                owner, sort = one.point.partner or one.name or str(k + 1), one.drive.sort
                key = (one.body, owner)
                unit = radian if sort == "crank" else 1.0
                found.setdefault(key, (f"{sort}.{owner}", sort, _numbers(one.drive, unit)))
                driven[k], on_platform[k] = True, one.body == BODIES[0]
                rods[k] = row.value.value * (-1 if row.side is Side.NEGATIVE else 1)
                middle[k], across[k], beside[k] = _place(one.point, one.drive)
                arms[k] = np.linalg.norm(beside[k])
            index.append(list(found).index(key))
        names, sorts, numbers = zip(*found.values(), strict=True)
        units, low, high, tolerances, offsets, factors = np.array(numbers).T
        return cls(
            instance, names, sorts, np.array(index), driven, on_platform,
            units, low, high, tolerances, offsets, factors, middle, across, beside, arms, rods,
        )  # fmt: skip

    @property
    def count(self) -> int:
        """The number of drives, m."""
        return len(self.names)

    @cached_property
    def cranked(self) -> NDArray[np.bool_]:
        """Which constraints have a crank, shape (6,)."""
        return np.array([self.sorts[k] == "crank" for k in self.index])

    @cached_property
    def first(self) -> NDArray[np.int64]:
        """The first constraint of each drive, shape (m,)."""
        return np.array([self.users(k)[0] for k in range(self.count)])

    @cached_property
    def moved(self) -> NDArray[np.bool_]:
        """Which drives are cranks or slides, shape (m,)."""
        return np.array([sort != "value" for sort in self.sorts])

    @cached_property
    def moves(self) -> bool:
        """Whether a drive moves a point: is a crank or a slide."""
        return bool(self.driven.any())

    @property
    def shared(self) -> bool:
        """Whether two constraints share a drive."""
        return self.count < len(self.index)

    @cached_property
    def turns(self) -> NDArray[np.bool_]:
        """Which drives are angles, of cranks or of values, shape (m,)."""
        angles = [not row.kind.is_distance for row in self.instance.constraints]
        of_values = np.array(angles)[self.first]
        cranks = np.array([sort == "crank" for sort in self.sorts])
        return np.asarray(cranks | (~self.moved & of_values))

    @cached_property
    def stays(self) -> NDArray[np.bool_]:
        """Which values stay as they are stated, shape (6,).

        Beside cranks and slides a value without a range has no motor, nor has one with a range of
        one number.
        """
        if not self.driven.any():
            return self.driven.copy()
        low, high = self.low[self.index], self.high[self.index]
        return np.asarray(~self.driven & (~np.isfinite(high - low) | (low == high)))

    @cached_property
    def planes(self) -> NDArray[np.bool_]:
        """Which constraints are distances of a driven point and a plane, shape (6,)."""
        sided = [row.kind.has_sides for row in self.instance.constraints]
        return np.asarray(self.driven & sided)

    @cached_property
    def _single(self) -> NDArray[np.bool_]:
        """Which constraints ask for one number only: values, and slides to planes, shape (6,)."""
        return np.asarray(~self.driven | (self.planes & ~self.cranked))

    @cached_property
    def stated_arrangement(self) -> Arrangement:
        """The platform with all points where they are stated."""
        return Arrangement.of(self.instance)

    @cached_property
    def cones(self) -> tuple[JointCone, ...]:
        """The cones of joints, one for each leg and joint that has one."""
        return joint_cones(self.instance)

    @property
    def limited(self) -> bool:
        """Whether some drive has a range or some joint a cone."""
        return bool(np.isfinite(self.high).any()) or bool(self.cones)

    @cached_property
    def _half_angles(self) -> Array:
        angles = np.array([joint.cone.half_angle.value for joint in self.cones])
        return np.asarray(angles * self.instance.units.angle.in_radians)

    @cached_property
    def two_sided(self) -> NDArray[np.bool_]:
        """Of which drives the range is that of the modulus, shape (m,)."""
        rows = [self.instance.constraints[k] for k in self.first]
        both = np.array([row.kind.has_sides and row.side is Side.BOTH for row in rows])
        return np.asarray(both & ~self.moved)

    @cached_property
    def room(self) -> Array:
        """By how much numbers of drives may be outside their ranges, shape (m,)."""
        size = np.maximum(np.abs(self.low), np.abs(self.high))
        # A distance to a plane is a difference of coordinates: it has their rounding error.
        plane = [self.instance.constraints[k].kind.has_sides for k in self.first]
        held = np.array(plane) & ~self.moved & (self.low == self.high)
        size[held] = np.maximum(size[held], self.stated_arrangement.length)
        return np.where(np.isfinite(size), ROUNDING * size, 0.0)

    def outside(self, q: ArrayLike) -> NDArray[np.bool_]:
        """Return which numbers of drives are outside their ranges, shape (..., m).

        By more than the rounding of doubles. NaN, which is out of reach, is outside.
        """
        q = np.where(self.two_sided, np.abs(q), q)
        return np.asarray(~((q >= self.low - self.room) & (q <= self.high + self.room)))

    def range_shares(self, q: Array) -> Array:
        """Return the position of each drive in its range as a share, shape (..., m).

        The share is 0 in the middle of a range, 1 at its ends and above 1 where `outside` is true.
        It is 1 at the only number of a range of one, infinite out of reach, NaN without a range.
        """
        half, outside = (self.high - self.low) / 2, self.outside(q)
        with np.errstate(all="ignore"):
            off = np.abs(np.where(self.two_sided, np.abs(q), q) - (self.low + self.high) / 2)
            shares = np.where(half > 0, off / half, np.where(outside, np.inf, 1.0))
        shares = np.where(np.isfinite(half), _agreeing(shares, outside), np.nan)
        return np.where(np.isnan(q), np.inf, shares)

    def tilts(self, R: ArrayLike, T: ArrayLike, q: ArrayLike | None = None) -> Array:
        """Return how far legs are tilted from the axes of their cones, in radians.

        Parameters
        ----------
        R, T
            Poses, shapes (..., 3, 3) and (..., 3).
        q
            The numbers of the drives there, shape (..., m): cones turn with the arms of cranks.
            Those that the poses ask for if None.

        Returns
        -------
        Array
            In the order of `cones`, shape (..., cones). The direction of a leg leads from the joint
            of the cone to its other end; NaN at length zero.
        """
        R, T = np.asarray(R, float), np.asarray(T, float)
        found = np.empty((*T.shape[:-1], len(self.cones)))
        if not self.cones:
            return found
        if q is None:
            q = self.inverse(R, T) if self.moves else np.zeros(self.count)
        r = self.ends(R, T, q)[2]
        for k, joint in enumerate(self.cones):
            leg = r[..., joint.constraint, :]
            axis = self.turned(joint.constraint, joint.body, joint.cone.unit, q)
            axis = np.broadcast_to(axis, leg.shape)
            direction, axis = (leg, axis) if joint.body == "base" else (-leg, apply(R, axis))
            across = np.linalg.norm(np.cross(axis, direction), axis=-1)
            along = dot(axis, direction)
            length = np.hypot(across, along)
            found[..., k] = np.where(length > 0, np.arctan2(across, along), np.nan)
        return found

    def out_of_cones(
        self, R: ArrayLike, T: ArrayLike, q: ArrayLike | None = None
    ) -> NDArray[np.bool_]:
        """Return which cones are violated at poses, by more than rounding, shape (..., cones).

        A leg of length zero has no direction and violates none. Arguments as for `tilts`.
        """
        return np.asarray(self.tilts(R, T, q) > self._half_angles + ROUNDING)

    def cone_shares(self, R: ArrayLike, T: ArrayLike, q: ArrayLike | None = None) -> Array:
        """Return tilts by the half angles of their cones, shape (..., cones); 0 at length zero.

        The share is above 1 where `out_of_cones` is true; arguments as for `tilts`.
        """
        tilts = self.tilts(R, T, q)
        shares = np.nan_to_num(tilts / self._half_angles, nan=0.0)
        return _agreeing(shares, tilts > self._half_angles + ROUNDING)

    def keeps(self, R: Array, T: Array, q: Array | None = None) -> NDArray[np.bool_]:
        """Return whether poses are reached within all ranges and cones, shape (...)."""
        q = self.inverse(R, T) if q is None else q
        left = np.concatenate((self.outside(q), self.out_of_cones(R, T, q)), axis=-1)
        return np.asarray(~left.any(axis=-1))

    def user(self, k: int) -> str:
        """Return what a constraint is called: a rod, if a drive moves an end of it."""
        return f"{'rod' if self.driven[k] and not self.planes[k] else 'constraint'} {k + 1}"

    @cached_property
    def fixed(self) -> NDArray[np.bool_]:
        """Which values cannot change, of any machine: those that stay, or have one, shape (6,)."""
        low, high = self.low[self.index], self.high[self.index]
        return np.asarray(self.stays | (~self.driven & (low == high)))

    def users(self, drive: int) -> list[int]:
        """Return the constraints with a drive, by their indices."""
        return np.flatnonzero(self.index == drive).tolist()

    def points(self, q: ArrayLike) -> Array:
        """Return the driven points in the frames of their bodies, ``(..., m) -> (..., 6, 3)``."""
        x = self._of_constraints(q)
        turned = self.middle + self.across * np.cos(x) + self.beside * np.sin(x)
        return np.where(self.cranked[:, None], turned, self.middle + self.beside * x)

    def velocities(self, q: ArrayLike) -> Array:
        """Return the derivatives of `points` by the number of their drive, shape (..., 6, 3)."""
        x = self._of_constraints(q)
        turned = self.beside * np.cos(x) - self.across * np.sin(x)
        return np.where(self.cranked[:, None], turned, self.beside)

    def bends(self, q: ArrayLike) -> Array:
        """Return the second derivatives of `points`, shape (..., 6, 3)."""
        x = self._of_constraints(q)
        turned = -self.across * np.cos(x) - self.beside * np.sin(x)
        return np.where(self.cranked[:, None], turned, 0.0)

    def turned(self, k: int, body: str, vector: Array, q: ArrayLike) -> Array:
        """Return a vector of the joint of constraint k on a body after its arm has turned.

        In the frame of the body, shape (..., 3); unchanged unless a crank moves the joint.
        """
        own = BODIES[0] if self.on_platform[k] else BODIES[1]
        if body != own or not self.cranked[k]:
            return vector
        point = getattr(self.instance.constraints[k], body)
        axis = point.crank.unit
        along = (axis @ vector) * axis
        x = np.asarray(q, float)[..., self.index[k], None]
        turned: Array = along + np.cos(x) * (vector - along) + np.sin(x) * np.cross(axis, vector)
        return turned

    def _of_constraints(self, q: ArrayLike) -> Array:
        return np.asarray(q, float)[..., self.index, None]

    def arrangement(self, q: ArrayLike) -> Arrangement:
        """Return the platform with its points at q: coordinates of shapes (..., 6, 3).

        As it is stated, without batch axes, if no drive moves a point.
        """
        if not self.driven.any():
            return self.stated_arrangement
        points, stated = self.points(q), self.stated_arrangement
        shape = points.shape
        moves = [self.driven & self.on_platform, self.driven & ~self.on_platform]
        y, x = (
            np.where(moved[:, None], points, np.broadcast_to(own, shape))
            for moved, own in zip(moves, (stated.y, stated.x), strict=True)
        )
        return stated.with_points(y, x)

    def at(self, R: ArrayLike, T: ArrayLike, q: ArrayLike) -> MachineAtPoses:
        """Return the machine at poses, (..., 3, 3) and (..., 3), and at numbers, (..., m)."""
        return MachineAtPoses(self, np.asarray(R, float), np.asarray(T, float), q)

    def scaled(self, factor: float) -> Machine:
        """Return the machine with its lengths times a factor: in another unit of length."""
        lengths, arms = np.where(self.turns, 1.0, factor), np.where(self.cranked, factor, 1.0)
        low, high, tolerances = (x * lengths for x in (self.low, self.high, self.tolerances))
        found = replace(
            self,
            units=self.units * lengths,
            low=low,
            high=high,
            tolerances=tolerances,
            middle=self.middle * factor,
            across=self.across * factor,
            beside=self.beside * arms[:, None],
            arms=self.arms * arms,
            rods=self.rods * factor,
        )
        stated, home = self.stated_arrangement, self._home
        values = stated.values.copy()
        values[stated.distances] *= factor
        found.__dict__["stated_arrangement"] = replace(
            stated, y=stated.y * factor, x=stated.x * factor, values=values
        )
        found.__dict__["_home"] = None if home is None else (home[0], home[1] * factor)
        return found

    def ends(self, R: ArrayLike, T: ArrayLike, q: ArrayLike) -> tuple[Array, Array, Array]:
        """Return base points, the turned platform points R y and the vectors of the rods.

        Each of shape (..., 6, 3), in the axes of the base; ``r = R y + T - b``.
        """
        arrangement = self.arrangement(q)
        placed = arrangement.placed(np.asarray(R, float), np.asarray(T, float))
        return np.broadcast_to(arrangement.x, placed.arm.shape), placed.arm, placed.r

    def jacobian(self, R: ArrayLike, T: ArrayLike, q: ArrayLike) -> Array:
        """Return the derivatives of the values by a twist with all drives still, (..., 6, 6).

        A twist is that of `gspcli.geometry.measurement`: (omega, velocity of the origin).
        """
        return np.asarray(jacobian(self.arrangement(q), np.asarray(R, float), np.asarray(T, float)))

    def gains(self, R: ArrayLike, T: ArrayLike, q: ArrayLike) -> Array:
        """Return the gains of the drives at their constraints, shape (..., 6)."""
        return self.at(R, T, q).gains

    def modes_at(self, R: ArrayLike, T: ArrayLike, q: ArrayLike) -> NDArray[np.int64]:
        """Return the working modes in which drives at q reach poses, shape (..., 6)."""
        return np.where(self.driven & (self.gains(R, T, q) < 0), -1, 1)

    def matrix(self, gains: Array) -> Array:
        """Return D with ``J t = D q'`` and ``tau = D^T F``, ``(..., 6) -> (..., 6, m)``."""
        matrix = np.zeros((*gains.shape, self.count))
        matrix[..., np.arange(len(self.index)), self.index] = gains
        return matrix

    def transmission(self, gains: Array) -> Array:
        """Return the share of a point's velocity that acts along its rod, 0 to 1, (..., 6)."""
        share: Array = np.abs(gains) / self.arms
        return share

    def rates(
        self,
        R: ArrayLike,
        T: ArrayLike,
        q: ArrayLike,
        twist: ArrayLike,
        change: ArrayLike | None = None,
    ) -> tuple[Array, Array]:
        """Return the first and second derivatives of q by the time.

        Parameters
        ----------
        R, T, q
            Poses and the numbers of the drives there.
        twist
            Angular velocity and velocity of the platform's origin, shape (..., 6).
        change
            Its derivative by the time; zero if None.

        Returns
        -------
        q', q''
            Shapes (..., m); infinite or NaN at a dead point. The mean where constraints share.
        """
        t = np.asarray(twist, float)
        a = np.zeros_like(t) if change is None else np.asarray(change, float)
        first, second = self.at(R, T, q).rates(t, a)
        return self.per_drive(first), self.per_drive(second)

    def per_drive(self, of_constraints: Array) -> Array:
        """Return the means over the constraints of each drive, ``(..., 6) -> (..., m)``."""
        if not self.shared:
            return of_constraints
        parts = [of_constraints[..., self.users(k)].mean(axis=-1) for k in range(self.count)]
        return np.stack(parts, axis=-1)

    def roots(self, R: ArrayLike, T: ArrayLike) -> Array:
        """Return the two numbers of each drive at poses, shape (..., 6, 2).

        The first has a positive gain, the second a negative one; NaN where the constraint does not
        reach the circle or the rail. Of a crank without a range they are between -pi and pi, of one
        with a range the nearest to its middle. A value stands twice, and so does a slide at a
        distance to a plane.

        Raises
        ------
        ArgumentError
            If a point with a drive belongs to another constraint than a distance of two points, or
            to a plane on a chosen side.
        """
        R, T = np.asarray(R, float), np.asarray(T, float)
        stated = self.stated_arrangement
        values = self._measured(R, T)
        if not self.driven.any():
            return np.stack((values, values), axis=-1)
        self._check_kinds()
        base = stated.y @ np.swapaxes(R, -1, -2) + T[..., None, :]
        platform = (stated.x - T[..., None, :]) @ R
        other = np.where(self.on_platform[:, None], platform, base)
        w = other - self.middle
        square = dot(w, w)
        along, beside = dot(w, self.across), dot(w, self.beside)
        # The value falls with ``along cos q + beside sin q``, which must be `right`.
        right = (square + self.arms**2 - self.rods**2) / 2
        if self.planes.any():
            f = gradients(stated, stated.placed(R, T)).r
            f = np.where(self.on_platform[:, None], -(f @ R), f)
            along = np.where(self.planes, dot(f, self.across), along)
            beside = np.where(self.planes, dot(f, self.beside), beside)
            right = np.where(self.planes, dot(f, w) - self.rods, right)
        with np.errstate(all="ignore"):
            half = _arc(right / np.hypot(along, beside))
            turn = self._wrapped(np.arctan2(beside, along)[..., None] + _pair(half))
            across = np.maximum(square - beside**2, 0.0)
            step = np.sqrt(_room(self.rods**2 - across, self.rods**2))
            shift = beside[..., None] + _pair(step)
            single = (right / beside)[..., None]
            single = np.where(np.isfinite(single), single, np.nan)
        found = np.where(self.cranked[:, None], turn, shift)
        found = np.where((self.planes & ~self.cranked)[:, None], single, found)
        return np.where(self.driven[:, None], found, values[..., None])

    def _check_kinds(self) -> None:
        for k in np.flatnonzero(self.driven):
            row, name = self.instance.constraints[k], self.names[self.index[k]]
            if row.kind is not DPP and not row.kind.has_sides:
                raise ArgumentError(
                    f"constraint {k + 1} of its point is {row.kind.name}, expected a DPP: a rod, "
                    "or a distance to a plane",
                    name,
                )
            if row.side is Side.BOTH and row.kind.has_sides and row.value.value:
                raise ArgumentError(
                    f"constraint {k + 1} of its point is a distance on both sides of a plane, "
                    "expected a side: positive or negative",
                    name,
                )

    def refuse_planes(self, what: str) -> None:
        """Raise if a drive moves the point of a distance to a plane, for what knows only rods.

        Raises
        ------
        ArgumentError
            Naming the drive, and what is not computed.
        """
        for k in np.flatnonzero(self.planes)[:1]:
            raise ArgumentError(
                f"constraint {k + 1} of its point is a distance to a plane: {what} of such a "
                "machine is not computed yet; gsp solve, measure --drives, track, scan, analyze, "
                "dynamics and clearance know it",
                self.names[self.index[k]],
            )

    def _wrapped(self, angles: Array) -> Array:
        """Return angles (..., 6, 2) by whole turns: nearest to the middle of their range, or 0."""
        low, high = self.low[self.index], self.high[self.index]
        stated = np.isfinite(low) & np.isfinite(high)
        middle = np.where(stated, low + high, 0.0)[:, None] / 2
        near: Array = angles - _TURN * np.round((angles - middle) / _TURN)
        return near

    def working_modes(
        self, R: ArrayLike, T: ArrayLike, what: str = "the pose"
    ) -> NDArray[np.int64]:
        """Return the signs of the gains at one pose, shape (6,); 1 for what has one number.

        Of the two numbers of a drive the one nearer to zero is taken: the stated point.

        Parameters
        ----------
        R, T
            The pose, shapes (3, 3) and (3,).
        what
            What the pose is called in errors.

        Raises
        ------
        ArgumentError
            If a drive does not reach the pose, or both its numbers are equally near to zero.
        """
        both = self.roots(R, T)
        size = np.where(self.cranked, 1.0, self.rods)
        for k in np.flatnonzero(self.driven).tolist():
            name, unit = self.names[self.index[k]], self.units[self.index[k]]
            if np.isnan(both[k]).any():
                raise ArgumentError(f"{self.user(k)} does not reach {what}", name)
            first, second = np.abs(both[k]).tolist()
            if not self._single[k] and abs(first - second) <= _EQUALLY_NEAR * size[k]:
                a, b = (f"{x:.10g}" for x in sorted(both[k] / unit))
                raise ArgumentError(
                    f"{what} is reached at {a} and at {b}, equally near to the stated point: "
                    "state the point where it is at home",
                    name,
                )
        return _nearer(both, self.driven)

    @cached_property
    def _home(self) -> tuple[Array, Array] | None:
        """The stated home pose, shapes (3, 3) and (3,), or None if the file states none."""
        home = self.instance.home
        return None if home is None else (home.R(self.stated_arrangement.in_radians), home.T)

    @cached_property
    def home_working_modes(self) -> NDArray[np.int64] | None:
        """The working modes at the stated home pose; None if the file states none."""
        return None if self._home is None else self.working_modes(*self._home, "the home pose")

    def in_other_working_modes(self, R: Array, T: Array) -> NDArray[np.bool_]:
        """Return which drives have another working mode at poses than at home, shape (n, 6).

        With all drives at zero at the poses and at the stated home. A gain of nearly zero has no
        sign that is known, and is in no other working mode.
        """
        assert self._home is not None
        zero = np.zeros(self.count)
        stated = self.gains(*self._home, zero)
        gains = self.gains(R, T, zero)
        known = np.minimum(np.abs(gains), np.abs(stated)) > _DEAD * self.arms
        return known & (gains * stated < 0)

    def wanted(
        self, R: ArrayLike, T: ArrayLike, working_modes: NDArray[np.int64] | None = None
    ) -> Array:
        """Return what each constraint asks of its drive, shape (..., 6); as `inverse`."""
        if not self.moves:
            return self._measured(np.asarray(R, float), np.asarray(T, float))
        both = self.roots(R, T)
        if working_modes is None:
            working_modes = self.home_working_modes if self.signs is None else self.signs
        if working_modes is None:
            working_modes = _first_working_modes(both, self.driven)
        return self._kept(np.where(working_modes > 0, both[..., 0], both[..., 1]))

    @cached_property
    def held(self) -> tuple[Array, Array]:
        """Between what values that stay are, up to 1e-9 of the size or of a radian, shapes (6,).

        Lengths and radians, signed on a chosen side, the modulus on both; infinite for others.
        """
        a = self.stated_arrangement
        stated = np.where(a.sides < 0, -a.targets, a.targets)
        room = np.full(len(stated), _SAME * a.length)
        room[a.angles] = _SAME
        never = np.where(self.stays, 0.0, np.inf)
        return stated - room - never, stated + room + never

    def _kept(self, wanted: Array) -> Array:
        """Return what constraints ask for, NaN for values that must stay and do not."""
        a, (low, high) = self.stated_arrangement, self.held
        values = np.where(a.sided & (a.sides == 0), np.abs(wanted), wanted)
        off = (values < low) | (values > high)
        return np.where(self.stays & off, np.nan, wanted)

    def inverse(
        self, R: ArrayLike, T: ArrayLike, working_modes: NDArray[np.int64] | None = None
    ) -> Array:
        """Return the numbers of the drives at poses (inverse kinematics), shape (..., m).

        Parameters
        ----------
        R, T
            Poses, shapes (..., 3, 3) and (..., 3), ``x_base = R x_platform + T``.
        working_modes
            The signs of the gains, shape (6,). Those of the stated home if None; without a home
            those of the first pose that the rod reaches, with the number nearer to zero.

        Returns
        -------
        Array
            NaN where a rod does not reach, where constraints with one drive ask for different
            numbers (`wanted` has them), and for values that must stay and do not.
        """
        return self._shared(self.wanted(R, T, working_modes))

    def stated(self, R: ArrayLike, T: ArrayLike) -> Array:
        """Return the numbers at poses with all points where they are stated, shape (..., m)."""
        values = self._measured(np.asarray(R, float), np.asarray(T, float))
        return self.per_drive(np.where(self.driven, 0.0, values))

    def along(self, R: Array, T: Array) -> Array:
        """Return `inverse` along rows of poses, shape (r, m): no crank jumps by a whole turn."""
        q = self.inverse(R, T)
        for k in np.flatnonzero(~np.isfinite(self.high - self.low)).tolist():
            known = np.isfinite(q[:, k])
            if self.sorts[k] == "crank":
                q[known, k] = np.unwrap(q[known, k])
        return q

    def at_home(self, R: Array | None = None, T: Array | None = None) -> Machine:
        """Return the machine in the working modes of the stated home, or without one of a pose.

        Raises
        ------
        ArgumentError
            If a drive does not reach the pose, or reaches it at two numbers equally near to the
            stated point.
        """
        if (signs := self.home_working_modes) is None:
            signs = np.ones(len(self.index), np.int64)
            if self.driven.any():
                assert R is not None
                assert T is not None
                signs = self.working_modes(R, np.asarray(T, float), "home")
        return replace(self, signs=signs)

    def placed(self, R: Array, T: Array) -> Arrangement:
        """Return the platform with its points where poses ask for them."""
        return self.arrangement(self.inverse(R, T)) if self.moves else self.stated_arrangement

    def values(self, R: Array, T: Array) -> Array:
        """Return the values at poses, those of rods as stated, in the file's units, (..., 6)."""
        values = self._measured(R, T)
        values[..., self.stated_arrangement.angles] /= self.stated_arrangement.in_radians
        return np.where(self.driven, self.rods, values)

    def _measured(self, R: Array, T: Array) -> Array:
        """Return what constraints measure with all points where they are stated, (..., 6)."""
        values = np.asarray(measured(self.stated_arrangement, R, T))
        skew = [kind is DLL for kind in self.stated_arrangement.kinds]
        values[..., skew] = np.abs(values[..., skew])
        return values

    def nearest(self, R: ArrayLike, T: ArrayLike) -> Array:
        """Return at each pose the numbers nearer to zero, in any working mode, shape (..., m)."""
        both = self.roots(R, T)
        first = np.abs(both[..., 0]) <= np.abs(both[..., 1])
        return self._shared(self._kept(np.where(first, both[..., 0], both[..., 1])))

    def _shared(self, wanted: Array) -> Array:
        """Return what all constraints of each drive ask for, NaN where they differ, (..., m)."""
        if self.count == len(self.index):
            return wanted
        q = self.per_drive(wanted)
        off = (
            np.abs(wanted - q[..., self.index]) * self.arms > _SAME * self.stated_arrangement.length
        )
        return np.where(self.matrix(off.astype(float)).any(axis=-2), np.nan, q)

    def with_points_at(self, q: ArrayLike) -> Instance:
        """Return the platform with its points at q of shape (m,), and its values as stated.

        Its coordinates there are doubles; it has no cranks, no slides and no masses.
        """
        numbers = (np.asarray(q, float) / np.where(self.turns, 1.0, self.units)).tolist()
        rows = list(self.instance.constraints)
        for k in np.flatnonzero(self.driven).tolist():
            body = BODIES[0] if self.on_platform[k] else BODIES[1]
            there = getattr(rows[k], body).moved(numbers[self.index[k]])
            rows[k] = replace(rows[k], **{body: there})
        return replace(self.instance, constraints=tuple(rows), dynamics=None)

    def instance_at(self, q: ArrayLike) -> Instance:
        """Return the platform with its points, and driven values, at q of shape (m,).

        As `with_points_at`; the values are doubles, too.
        """
        values = (np.asarray(q, float)[self.index] / self.units[self.index]).tolist()
        moved = self.with_points_at(q)
        rows = [
            row
            if self.driven[k]
            else replace(row, value=Number.of(abs(value) if row.kind.has_sides else value))
            for k, (row, value) in enumerate(zip(moved.constraints, values, strict=True))
        ]
        return replace(moved, constraints=tuple(rows))

    def of_values(self, values: ArrayLike) -> Array:
        """Return q at values in the units of the file, ``(..., 6) -> (..., m)``.

        Cranks and slides are where the file states them.
        """
        return np.where(self.moved, 0.0, np.asarray(values, float)[..., self.first] * self.units)

    def read(self, readings: ArrayLike, moved: Mapping[str, ArrayLike]) -> Array:
        """Return q of readings of constraints, (n, 6), and of cranks and slides by name, each (n,).

        Those that are not named are where the file states them.
        """
        found = self.readings(self.of_values(np.zeros_like(readings)))
        found[..., ~self.moved] = np.asarray(readings, float)[..., self.first[~self.moved]]
        for name, column in moved.items():
            found[..., self.names.index(name)] = column
        return self.from_readings(found)

    def readings(self, q: ArrayLike) -> Array:
        """Return readings of q, shape (..., m), in the units of the instance."""
        return (np.asarray(q, float) / self.units - self.offsets) / self.factors

    def from_readings(self, readings: ArrayLike) -> Array:
        """Return q of readings, shape (..., m)."""
        return (np.asarray(readings, float) * self.factors + self.offsets) * self.units


class MachineAtPoses:
    """A machine at poses, shapes (..., 3, 3) and (..., 3), with its drives at q, shape (..., m).

    Attributes
    ----------
    arrangement
        The platform with its points at q.
    """

    def __init__(self, machine: Machine, R: Array, T: Array, q: ArrayLike) -> None:
        self.machine, self.R, self.T, self.q = machine, R, T, q
        self.arrangement = machine.arrangement(q)

    @cached_property
    def placed(self) -> Placed:
        """The vectors of the constraints in the axes of the base."""
        return self.arrangement.placed(self.R, self.T)

    @cached_property
    def by(self) -> Gradient:
        """Derivatives of the values by these vectors; not finite where there is none."""
        with np.errstate(all="ignore"):
            return gradients(self.arrangement, self.placed)

    @cached_property
    def ways(self) -> Array:
        """The derivatives of r by the number of the drive of each constraint, shape (..., 6, 3).

        In the axes of the base; zero where that is the value.
        """
        return self._turned(self.machine.velocities)

    @cached_property
    def bends(self) -> Array:
        """The second derivatives of r, as `ways`."""
        return self._turned(self.machine.bends)

    def _turned(self, of: Callable[[ArrayLike], Array]) -> Array:
        if not self.machine.moves:
            return np.zeros((*self.T.shape[:-1], 6, 3))
        part, on_platform = of(self.q), self.machine.on_platform[:, None]
        return np.where(on_platform, part @ np.swapaxes(self.R, -1, -2), -part)

    @cached_property
    def gains(self) -> Array:
        """The gains of the drives at their constraints, shape (..., 6)."""
        if not self.machine.moves:
            return np.ones((*self.T.shape[:-1], 6))
        return np.where(self.machine.driven, -dot(self.by.r, self.ways), 1.0)

    @cached_property
    def _signs(self) -> Array:
        return value_signs(self.arrangement, self.R, self.T)

    @cached_property
    def jacobian(self) -> Array:
        """Derivatives of the values by a twist with all drives still, shape (..., 6, 6).

        Those of the values of `gsp measure`: distances of two lines are not negative.
        """
        rows = by_twist(self.by, self.placed.arm, self.placed.w)
        return np.asarray(self._signs[..., None] * rows)

    def rates(self, twist: Array, change: Array) -> tuple[Array, Array]:
        """Return the derivatives of what each constraint asks of its drive, each (..., 6).

        The first and the second by the time, where the platform moves with a twist and its
        derivative, shapes (..., 6); infinite or NaN at a dead point.
        """
        machine, slip = self.machine, None
        with np.errstate(all="ignore"):
            first = apply(self.jacobian, twist)
            if machine.moves:
                first = first / self.gains
                moved = self.ways * first[..., None]
                bent = self.bends * first[..., None] ** 2
                turning = 2 * cross(twist[..., None, :3], moved)
                slip = moved, bent + np.where(machine.on_platform[:, None], turning, 0.0)
            second = self._signs * curvature(self.arrangement, self.R, self.T, twist, slip)
            if change.any():
                second = second + apply(self.jacobian, change)
            return first, second / self.gains if machine.moves else second


def _agreeing(shares: Array, outside: NDArray[np.bool_]) -> Array:
    """Return shares that are above 1 exactly where a limit is violated, despite rounding."""
    return np.where(outside, np.maximum(shares, _ABOVE_ONE), np.minimum(shares, 1.0))


def _pair(half: Array) -> Array:
    return np.stack((-half, half), axis=-1)


def _arc(cosine: Array) -> Array:
    """Return the arc cosine; 0 or pi for what is beyond one by rounding, NaN for more."""
    reached = np.abs(cosine) <= 1 + _END
    return np.where(reached, np.arccos(np.clip(cosine, -1, 1)), np.nan)


def _room(square: Array, size: Array) -> Array:
    """Return a square; 0 for what is below zero by rounding, NaN for less."""
    return np.where(square < -_END * size, np.nan, np.maximum(square, 0.0))


def _nearer(both: Array, driven: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return 1 where the first of two numbers is the nearer to zero, -1 elsewhere, shape (6,)."""
    first = np.abs(both[..., 0]) <= np.abs(both[..., 1])
    return np.where(first | ~driven, 1, -1)


def _first_working_modes(both: Array, driven: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return for each drive the working mode at the first pose that it reaches, shape (6,)."""
    pairs = both.reshape(-1, *both.shape[-2:])
    first = np.isfinite(pairs[..., 0]).argmax(axis=0) if len(pairs) else None
    if first is None:
        return np.ones(both.shape[-2], np.int64)
    return _nearer(pairs[first, np.arange(pairs.shape[1])], driven)


class MovedPoint(NamedTuple):
    """A point of a constraint that has a crank or a slide."""

    body: str
    point: Point
    name: str
    drive: Crank | Slide


class ThickArm(NamedTuple):
    """The arm of a crank, from the axis to the point of a constraint."""

    body: str
    point: Point
    name: str
    diameter: Number


def driven_points(row: Constraint) -> list[MovedPoint]:
    """Return the points of a constraint that have cranks or slides."""
    return [
        MovedPoint(body, point, getattr(row, f"{body}_name"), point.drive)
        for body in BODIES
        if isinstance(point := getattr(row, body), Point) and point.drive is not None
    ]


def without_drives(instance: Instance) -> Instance:
    """Return a platform whose points stay where they are stated: its values are its drives."""

    def still(row: Constraint, body: str) -> Geometry:
        end = getattr(row, body)
        return Point(end.position, end.cone) if isinstance(end, Point) else end

    rows = tuple(
        replace(row, platform=still(row, "platform"), base=still(row, "base"))
        for row in instance.constraints
    )
    return replace(instance, constraints=rows, dynamics=None)


def value_machine(instance: Instance) -> Machine:
    """Return the machine whose drives are the six values: cranks and slides stay where stated."""
    return Machine.of(without_drives(instance))


def joint_cones(instance: Instance) -> tuple[JointCone, ...]:
    """Return the cones of an instance, one for each leg and joint that has one."""
    return tuple(
        JointCone(k, body, getattr(row, f"{body}_name"), joint.cone)
        for k, row in enumerate(instance.constraints)
        if row.kind is DPP
        for body in BODIES
        if isinstance(joint := getattr(row, body), Point) and joint.cone is not None
    )


def arms_of(instance: Instance) -> dict[int, ThickArm]:
    """Return the arms whose diameter is stated, by the index of the constraint."""
    return {
        k: ThickArm(one.body, one.point, one.name, one.drive.diameter)
        for k, row in enumerate(instance.constraints)
        for one in driven_points(row)
        if isinstance(one.drive, Crank) and one.drive.diameter is not None
    }


def _only(k: int, found: list[MovedPoint]) -> MovedPoint | None:
    if len(found) > 1:
        names = " and ".join(one.name or "a point" for one in found)
        raise ArgumentError(f"constraint {k + 1} has drives at both ends ({names}), expected one")
    return found[0] if found else None


def _place(point: Point, drive: Crank | Slide) -> tuple[Array, Array, Array]:
    """Return the middle of a circle and its two radii, or a point and the direction of a rail."""
    if isinstance(drive, Slide):
        return point.point, np.zeros(3), drive.unit
    centre = as_array(drive.centre)
    arm = point.point - centre
    height = (drive.unit @ arm) * drive.unit
    return centre + height, arm - height, np.cross(drive.unit, arm - height)


def _numbers(stated: Crank | Slide | Constraint, unit: float) -> list[float]:
    """Return what is kept of a drive: unit, range, tolerance, offset and factor of readings.

    Lengths and radians; on a chosen side the range is that of the signed distance.
    """
    low, high = (-np.inf, np.inf) if stated.limits is None else (x.value for x in stated.limits)
    if isinstance(stated, Constraint) and stated.side is Side.NEGATIVE:
        low, high = -high, -low
    off, offset, scale = (
        default if number is None else number.value
        for number, default in (
            (stated.tolerance, np.nan),
            (stated.offset, 0.0),
            (stated.scale, 0.0),
        )
    )
    return [unit, low * unit, high * unit, off * unit, offset, 1 + scale]
