"""Pairs of shapes, the gaps between them, and bounds of how much a motion changes a gap.

A leg is the straight line between its joints, with a radius. So is the arm of a crank with a
diameter, from the axis to the point that it turns. A body is a convex hull. The gap of a pair is
the distance of the lines or hulls less the radii: negative if they overlap. Legs that share a joint
always touch there, and so do a leg and the bodies that it joins, an arm and its rod, and an arm and
the body with its axis. Only the parts of these beyond `Shapes.near_joint` are compared. If it is
not stated, they are not compared. Points of one crank have one arm each, and these arms are not
compared.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli import _kernel
from gspcli.catalogue.kinds import DPP
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.checking import refuse_shape_mistakes
from gspcli.geometry.enclosures import above, roundings
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.machine import Machine, arms_of
from gspcli.geometry.primitives import Vector
from gspcli.geometry.quaternions import apply
from gspcli.motion.poses.inverse_kinematics import checked_poses, drive_values
from gspcli.records import dataclass
from gspcli.ties import first_smallest

if TYPE_CHECKING:
    import pandas as pd

    from gspcli.geometry.machine import Machine


Array = NDArray[np.float64]

#: Poses whose gaps are computed at a time.
_PIECE = 4096
#: Digits of gaps that are shown, relative to the length of the platform.
_DIGITS = 11
#: Two arms begin at one point of a body if these points differ by less than this part of the length
#: of the platform.
_ONE_POINT = 1e-9
NO_SHAPES = "the platform states no shapes of its legs (shapes: {diameter: ...})"


class GapBounds(NamedTuple):
    """Bounds of the gaps of p pairs at n poses."""

    low: Array
    """Proved lower bounds, shape (n, p)."""
    high: Array
    """Proved upper bounds, shape (n, p)."""


class _ComparedHull(NamedTuple):
    """A hull that is compared: a leg, a part of a leg, an arm, or a body."""

    leg: int | None
    """The index of the leg's constraint; None for a body and for an arm."""
    beyond: str
    """The body beyond whose joint a leg counts; ``axis`` or ``point`` of an arm; empty for all."""
    body: str
    """``platform`` or ``base``; empty for a leg."""
    arm: int | None = None
    """The index of the constraint whose point an arm turns; its body is that of the axis."""


class ComparedShapes:
    """The pairs of an instance that are compared.

    Parameters
    ----------
    instance
        The platform, with its shapes.

    Raises
    ------
    ArgumentError
        If the platform states no shapes, its shapes are wrong, or there is no pair.
    """

    def __init__(self, instance: Instance) -> None:
        if instance.shapes is None:
            raise ArgumentError(NO_SHAPES)
        self.instance = instance
        shapes, rows = instance.shapes, instance.constraints
        refuse_shape_mistakes(shapes, rows)
        self._near = 0.0 if shapes.near_joint is None else shapes.near_joint.value
        self.legs = [k for k, row in enumerate(rows) if row.kind is DPP]
        diameters = [one.value for one in shapes.diameters]
        if len(diameters) == 1:
            diameters *= len(self.legs)
        self._radii = dict(zip(self.legs, (d / 2 for d in diameters), strict=True))
        #: The constraints whose points are turned by arms with a diameter, one of each point.
        self.arms = _arms(instance)
        self._points = {
            name: np.array([[x.value for x in point] for point in getattr(shapes, name)])
            for name in ("platform", "base")
        }
        self._hulls: list[_ComparedHull] = []
        self.pairs = np.array(self._pairs(), np.int64).reshape(-1, 2)
        if not len(self.pairs):
            raise ArgumentError(
                "no two legs of the platform are compared: all of them share joints"
            )
        #: The names of the pairs, such as ``legs 2 and 5``.
        self.names = tuple(self._name(*(self._hulls[k] for k in pair)) for pair in self.pairs)
        radii = np.array([self._radius(one) for one in self._hulls])
        self._thick = radii[self.pairs].sum(axis=1)

    def _pairs(self) -> list[tuple[int, int]]:
        rows, found = self.instance.constraints, []
        for i, first in enumerate(self.legs):
            for second in self.legs[i + 1 :]:
                shared = _shared(rows[first], rows[second])
                if not shared or self._near > 0:
                    found.append((self._hull(first, shared), self._hull(second, shared)))
        bodies = [name for name in ("platform", "base") if len(self._points[name])]
        found += [(self._hull(leg, body), self._body(body)) for leg in self.legs for body in bodies]
        if len(bodies) == 2:
            found.append((self._body("platform"), self._body("base")))
        found += self._pairs_of_arms(bodies)
        return found

    def _pairs_of_arms(self, bodies: Sequence[str]) -> Iterator[tuple[int, int]]:
        near = self._near > 0
        for place, (k, point, own) in enumerate(self.arms):
            for leg in self.legs:
                joined = _joint(self.instance.constraints[leg], own) == point
                if not joined or near:
                    hull = self._hull(leg, own if joined else "")
                    yield hull, self._arm(k, own, "point" if joined else "")
            for other, _, body in self.arms[place + 1 :]:
                same = self._drives.index[other] == self._drives.index[k]
                one_axis = body == own and self._on_one_axis(k, other)
                if not same and not one_axis:
                    yield self._arm(k, own, ""), self._arm(other, body, "")
            for body in bodies:
                if body != own or near:
                    yield self._arm(k, own, "axis" if body == own else ""), self._body(body)

    def _on_one_axis(self, first: int, second: int) -> bool:
        """Whether two arms begin at one point of the body."""
        a, b = (self._drives.middle[k] for k in (first, second))
        return bool(np.abs(a - b).max() <= _ONE_POINT * self._arrangement.length)

    def _radius(self, hull: _ComparedHull) -> float:
        if hull.arm is not None:
            return arms_of(self.instance)[hull.arm].diameter.value / 2
        return 0.0 if hull.leg is None else self._radii[hull.leg]

    def _hull(self, leg: int, beyond: str) -> int:
        return self._number(_ComparedHull(leg, beyond if self._near > 0 else "", ""))

    def _body(self, name: str) -> int:
        return self._number(_ComparedHull(None, "", name))

    def _arm(self, constraint: int, body: str, beyond: str) -> int:
        return self._number(_ComparedHull(None, beyond, body, constraint))

    def _number(self, hull: _ComparedHull) -> int:
        if hull not in self._hulls:
            self._hulls.append(hull)
        return self._hulls.index(hull)

    def _name(self, first: _ComparedHull, second: _ComparedHull) -> str:
        if first.arm is not None or second.arm is not None:
            return " and ".join(map(self._called, (first, second)))
        if second.leg is not None:
            assert first.leg is not None
            return f"legs {first.leg + 1} and {second.leg + 1}"
        one = "the platform" if first.leg is None else f"leg {first.leg + 1}"
        return f"{one} and the {second.body}"

    def _called(self, hull: _ComparedHull) -> str:
        if hull.arm is None:
            return f"the {hull.body}" if hull.leg is None else f"leg {hull.leg + 1}"
        row = self.instance.constraints[hull.arm]
        return f"the arm of {getattr(row, f'{hull.body}_name') or f'rod {hull.arm + 1}'}"

    @cached_property
    def _drives(self) -> Machine:
        from gspcli.geometry.machine import Machine

        return Machine.of(self.instance)

    @cached_property
    def _arrangement(self) -> Arrangement:
        return Arrangement.of(self.instance)

    @cached_property
    def _starts(self) -> NDArray[np.int64]:
        sizes = [
            len(self._points[one.body]) if one.leg is None and one.arm is None else 2
            for one in self._hulls
        ]
        return np.concatenate(([0], np.cumsum(sizes))).astype(np.int64)

    def bounds(self, R: Array, T: Array, q: Array | None = None) -> GapBounds:
        """Return bounds of the gaps at poses; NaN where a pose is NaN.

        Parameters
        ----------
        R, T
            Poses, shapes (n, 3, 3) and (n, 3).
        q
            The numbers of cranks and slides at the poses, shape (n, m); if None, they are computed
            from the poses.
        """
        low, high = np.empty((2, len(T), len(self.pairs)))
        if q is None and self._drives.moves:
            q = drive_values(self.instance, R, T)[1]
        for begin in range(0, len(T), _PIECE):
            part = slice(begin, begin + _PIECE)
            points = self._placed(R[part], T[part], None if q is None else q[part])
            found = _kernel.hull_gaps(points, self._starts, self.pairs)
            # Radii are sums and halves of doubles.
            low[part] = found[0] - above(self._thick)
            high[part] = found[1] - self._thick * (2 - above(1))
        return GapBounds(low, high)

    def gaps(self, R: Array, T: Array, q: Array | None = None) -> Array:
        """Return the gaps at poses, without digits that are rounding errors, shape (n, p)."""
        decimals = _DIGITS - math.ceil(math.log10(self._arrangement.length))
        return np.round(self.bounds(R, T, q).high, decimals)

    def _placed(self, R: Array, T: Array, q: Array | None) -> Array:
        """Return the points of the hulls at poses, one hull after the other, shape (n, m, 3)."""
        if q is None:
            a = self._arrangement
            ends = a.y @ np.swapaxes(R, -1, -2) + T[:, None], np.broadcast_to(a.x, (len(T), 6, 3))
        else:
            base, arm, _ = self._drives.ends(R, T, q)
            ends = arm + T[:, None], base
        found = []
        for hull in self._hulls:
            if hull.arm is not None:
                found.append(self._placed_arm(hull, R, T, ends))
                continue
            if hull.leg is None:
                points = self._points[hull.body]
                if hull.body == "platform":
                    found.append(points @ np.swapaxes(R, -1, -2) + T[:, None])
                else:
                    found.append(np.broadcast_to(points, (len(T), *points.shape)))
                continue
            platform, base = (end[:, hull.leg] for end in ends)
            if hull.beyond == "platform":
                platform = self._beyond(platform, base)
            elif hull.beyond == "base":
                base = self._beyond(base, platform)
            found.append(np.stack((platform, base), axis=1))
        return np.ascontiguousarray(np.concatenate(found, axis=1))

    def _placed_arm(
        self, hull: _ComparedHull, R: Array, T: Array, ends: tuple[Array, Array]
    ) -> Array:
        """Return both ends of an arm, or of its part beyond one, at poses, shape (n, 2, 3)."""
        k, on_platform = hull.arm, hull.body == "platform"
        point = ends[0 if on_platform else 1][:, k]
        axis = np.broadcast_to(self._drives.middle[k], point.shape)
        if on_platform:
            axis = apply(R, axis) + T
        if hull.beyond == "axis":
            axis = self._beyond(axis, point)
        elif hull.beyond == "point":
            point = self._beyond(point, axis)
        return np.stack((axis, point), axis=1)

    def _beyond(self, joint: Array, end: Array) -> Array:
        """Return the point of a leg at the stated length from a joint, but not beyond its end."""
        along = end - joint
        length = np.linalg.norm(along, axis=-1, keepdims=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            part = np.where(length > self._near, self._near / length, 1.0)
        return np.where(np.isfinite(length), joint + part * along, np.nan)

    def _slips(
        self,
        shifts: Array,
        turns: Array,
        centre: Array,
        driven: tuple[Array, Array, Array],
        slips: Array | None,
    ) -> tuple[Array, Array, Array]:
        """Return the joints at numbers of drives, and how far the drives move them, (2, n, 6)."""
        drives, placed = self._drives, self._drives.arrangement(driven[2])
        if slips is None:
            slips = slips_near(drives, *driven, shifts, turns, centre)
        on = drives.on_platform
        return placed.y, placed.x, np.stack([np.where(on, slips, 0.0), np.where(on, 0.0, slips)])

    def moves(
        self,
        shifts: Array,
        turns: Array,
        centre: Array,
        places: Array,
        driven: tuple[Array, Array, Array] | None = None,
        slips: Array | None = None,
    ) -> Array:
        """Bound how much each gap changes while the platform moves a little, shape (n, p).

        Parameters
        ----------
        shifts, turns
            The largest distance that a point of the platform moves, and the largest angle, in
            radians, by which the platform rotates; shapes (n,).
        centre
            This point of the platform, in its frame, shape (3,).
        places
            The position of this point at the poses, shape (n, 3).
        driven
            The poses R and T, and the numbers q of cranks and slides at the poses; needed if there
            are such drives.
        slips
            How far drives move their points in their bodies, shape (n, 6); if None, the bound of
            `slips_near`.

        Notes
        -----
        No point of a hull moves farther than its corners. A gap changes at most by the sum of the
        motions of its two hulls. In the frame of the base the joints of the base do not move; in
        the frame of the platform those of the platform do not. The smaller of both sums is taken.
        The part of a leg beyond a joint moves no farther than the end that moves. The reason: the
        other end is fixed. The map to the nearest point of a ball increases no distance of two
        points; nor does the difference of a point and its image.
        """
        a = self._arrangement
        y, x, sides = a.y, a.x, np.zeros((2, len(shifts), 6))
        if driven is not None:
            y, x, sides = self._slips(shifts, turns, centre, driven, slips)
        own = np.linalg.norm(y - centre, axis=-1) + sides[0]
        away = np.linalg.norm(places[:, None] - x, axis=-1) + sides[1]
        far = {
            "platform": np.linalg.norm(self._points["platform"] - centre, axis=-1).max()
            if len(self._points["platform"])
            else 0.0
        }
        count = len(self._hulls)
        from_base, from_platform = np.zeros((2, len(shifts), count))
        for k, hull in enumerate(self._hulls):
            if hull.arm is not None:
                # The axis of the arm is fixed in its body, and the point of the arm moves in this
                # body.
                side = 0 if hull.body == "platform" else 1
                slip = sides[side, :, hull.arm]
                axis = self._drives.middle[hull.arm]
                farthest = np.linalg.norm((centre, places)[side] - axis, axis=-1)
                farthest = np.maximum(farthest, (own, away)[side][:, hull.arm])
                (from_platform, from_base)[side][:, k] = slip
                (from_base, from_platform)[side][:, k] = shifts + turns * farthest + slip
            elif hull.leg is not None:
                on_platform, on_base = sides[:, :, hull.leg]
                # If both ends of a part of a leg move, both motions count.
                both = np.add if hull.beyond else np.maximum
                from_base[:, k] = both(shifts + turns * own[:, hull.leg] + on_platform, on_base)
                from_platform[:, k] = both(
                    shifts + turns * away[:, hull.leg] + on_base, on_platform
                )
            elif hull.body == "platform":
                from_base[:, k] = shifts + turns * far["platform"]
            else:
                points = self._points["base"]
                there = np.linalg.norm(places[:, None] - points, axis=-1).max(axis=1)
                from_platform[:, k] = shifts + turns * there
        sums = [one[:, self.pairs].sum(axis=2) for one in (from_base, from_platform)]
        size = np.abs(places).max(axis=1) + max(np.abs(a.x).max(), np.abs(a.y).max())
        if driven is not None:
            size = size + np.abs(x).max(axis=(1, 2)) + np.abs(y).max(axis=(1, 2))
            size = size + np.abs(self._drives.middle[self._drives.driven]).max(initial=0.0)
        # Positions of two hulls are rounded, and so is the rotation.
        return np.asarray(above(np.minimum(*sums)) + roundings(16, size[:, None]))


def _joint(row: Constraint, body: str) -> Vector:
    """Return the stated place of a joint of a leg."""
    position: Vector = getattr(row, body).position
    return position


def _arms(instance: Instance) -> list[tuple[int, Vector, str]]:
    """Return which points have arms with a diameter: constraint, stated place, and body.

    Raises
    ------
    ArgumentError
        If a diameter is negative.
    """
    found: list[tuple[int, Vector, str]] = []
    for k, (body, point, name, diameter) in arms_of(instance).items():
        if diameter.value < 0:
            raise ArgumentError(
                f"found {diameter}, expected a diameter of at least 0", name or f"constraints[{k}]"
            )
        if not any((point.position, body) == one[1:] for one in found):
            found.append((k, point.position, body))
    return found


def _shared(first: Constraint, second: Constraint) -> str:
    """Return the body on which two legs share a joint; empty if they share none."""
    for body in ("platform", "base"):
        names = {getattr(row, f"{body}_name") for row in (first, second)}
        one, other = (getattr(row, body) for row in (first, second))
        if (len(names) == 1 and "" not in names) or one.position == other.position:
            return body
    return ""


#: Changes of drives that are tried, as multiples of the change for linear lengths.
_TRIED = (1.05, 1.3, 2.0, 4.0)


def point_moves(drives: Machine, R: Array, T: Array, q: Array, moves: Array) -> Array:
    """Return bounds of how far driven points move in their bodies, shape (n, 6).

    Parameters
    ----------
    drives
        The drives of a platform.
    R, T
        Poses, shapes (n, 3, 3) and (n, 3).
    q
        The numbers of the drives at the poses, shape (n, m).
    moves
        How far the other end of each rod moves, in the frame of the body of the driven point, shape
        (n, 6).

    Returns
    -------
    Array
        Zero where no crank or slide moves the point, infinite where nothing is proved.

    Notes
    -----
    At a pose the number q of a drive is where the distance of the two ends of the rod is the length
    l of the rod, in the working mode of home. Let one end of the rod move by at most d. Suppose
    that the distance is below ``l - d`` at one of ``q - e`` and ``q + e``, and above ``l + d`` at
    the other. Then the new number is between both: the distance passes l there, in the direction of
    the working mode. For a crank and for a slide there is only one such number for each direction.
    """
    gains = drives.gains(R, T, q)
    size = np.abs(T).max(axis=1) + max(np.abs(drives.rods[drives.driven]).max(), 1e-300)
    size += np.abs(drives.points(q)).max(axis=(1, 2))
    room = above(moves) + roundings(16, size[:, None])
    found = np.where(drives.driven, np.inf, 0.0) * np.ones_like(moves)
    with np.errstate(all="ignore"):
        linear = room / np.abs(gains)
        for factor in _TRIED:
            for k in np.flatnonzero(drives.driven & ~drives.planes).tolist():
                change = np.zeros_like(q)
                change[:, drives.index[k]] = factor * linear[:, k]
                low, high = (
                    np.linalg.norm(drives.ends(R, T, q + sign * change)[2][:, k], axis=-1)
                    - drives.rods[k]
                    for sign in (-1, 1)
                )
                # If the platform does not move, the derivative of the length of the rod is minus
                # the gain.
                working_mode = -np.sign(gains[:, k])
                fits = (working_mode * low < -room[:, k]) & (working_mode * high > room[:, k])
                # The two numbers of a crank differ by less than a turn.
                if drives.sorts[drives.index[k]] == "crank":
                    fits &= factor * linear[:, k] < np.pi / 2
                far = above(drives.arms[k] * factor * linear[:, k])
                found[:, k] = np.where(fits, np.minimum(found[:, k], far), found[:, k])
    return np.asarray(found)


def slips_near(
    drives: Machine, R: Array, T: Array, q: Array, shifts: Array, turns: Array, centre: Array
) -> Array:
    """Return bounds of how far driven points move near poses, shape (n, 6); see `point_moves`.

    Parameters
    ----------
    drives
        The drives of a platform.
    R, T, q
        Poses and the numbers of the drives there, shapes (n, 3, 3), (n, 3) and (n, m).
    shifts, turns
        The largest distance that a point of the platform moves, and the largest angle, in radians,
        by which the platform rotates; shapes (n,).
    centre
        This point of the platform, in its frame, shape (3,).
    """
    placed = drives.arrangement(q)
    places = T + apply(R, np.broadcast_to(centre, T.shape))
    own = np.linalg.norm(placed.y - centre, axis=-1)
    away = np.linalg.norm(places[:, None] - placed.x, axis=-1)
    # In the frame of the body of the driven point the other body moves.
    arms = np.where(drives.on_platform, away, own)
    return point_moves(drives, R, T, q, shifts[:, None] + turns[:, None] * arms)


@dataclass(frozen=True, eq=False)
class Gaps:
    """The gaps of p pairs of legs and bodies at n poses.

    Attributes
    ----------
    pairs
        Names of the p pairs, such as ``legs 2 and 5`` or ``leg 3 and the base``. A leg has the
        number of its constraint.
    values
        The gaps, shape (n, p), in the unit of length; negative where the shapes overlap.
    """

    pairs: tuple[str, ...]
    values: Array

    def __repr__(self) -> str:
        least = f", at least {self.least.min():.6g}" if len(self.values) else ""
        return f"<Gaps of {len(self.pairs)} pairs at {len(self.values)} poses{least}>"

    @property
    def least(self) -> Array:
        """The least gap at each pose, shape (n,)."""
        return np.asarray(self.values.min(axis=1))

    @property
    def nearest(self) -> list[str]:
        """The pair with the least gap at each pose, the first one of equal ones.

        Empty where a rod does not reach the pose, so that the gap is not known.
        """
        known = np.asarray(~np.isnan(self.values).any(axis=1))
        return [
            self.pairs[int(first_smallest(row))] if there else ""
            for row, there in zip(self.values, known.tolist(), strict=True)
        ]

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each pose, a column for each pair (pandas is imported now)."""
        import pandas as pd

        return pd.DataFrame(self.values, columns=[*self.pairs])

    def to_json(self) -> list[dict[str, Any]]:
        """Return the least gap of each pose and its pair, as plain data."""
        return [
            {"gap": gap if pair else None, "gap_between": pair or None}
            for gap, pair in zip(self.least.tolist(), self.nearest, strict=True)
        ]


def gaps(instance: Instance, R: ArrayLike, T: ArrayLike) -> Gaps:
    """Return the gaps between legs and bodies at poses.

    Parameters
    ----------
    instance
        The platform, with the shapes of its legs (`gspcli.Shapes`).
    R, T
        Poses, shapes (n, 3, 3) and (n, 3), or one pose.

    Raises
    ------
    ArgumentError
        If the platform states no shapes, or if the poses have the wrong shapes.

    Examples
    --------
    >>> import dataclasses
    >>> import gspcli
    >>> import numpy as np
    >>> platform = gspcli.example("workspace-study")
    >>> platform = dataclasses.replace(platform, shapes=gspcli.Shapes(diameters=20))
    >>> gspcli.motion.gaps(platform, np.eye(3), [0, 0, 400]).to_json()
    [{'gap': 23.41204442, 'gap_between': 'legs 1 and 6'}]
    """
    R, T = checked_poses(R, T)
    compared = ComparedShapes(instance)
    return Gaps(compared.names, compared.gaps(R.reshape(-1, 3, 3), T.reshape(-1, 3)))
