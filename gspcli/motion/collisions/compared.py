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
from collections.abc import Iterator
from itertools import combinations, product
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli import _kernel
from gspcli.catalogue.kinds import DPP
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.checking import refuse_shape_mistakes
from gspcli.geometry.coordinates import BODIES
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


class _Hull(NamedTuple):
    """A hull that is compared: a body, or the line of a leg or an arm, or a part of one."""

    what: str
    """``leg``, ``arm`` or ``body``."""
    body: str = ""
    """``platform`` or ``base``: the body, or that of the axis of an arm."""
    constraint: int = -1
    """That of a leg, or whose point an arm turns."""
    cut: int | None = None
    """Beyond which end it counts: platform and base of a leg, axis and point of an arm."""


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
        self._drives, self._arrangement = Machine.of(instance), Arrangement.of(instance)
        self._radii = {("leg", k): d / 2 for k, d in zip(self.legs, diameters, strict=True)}
        #: The constraints whose points are turned by arms with a diameter, one of each point.
        self.arms = _arms(instance)
        self._radii |= {("arm", k): one.diameter.value / 2 for k, one in arms_of(instance).items()}
        self._points: dict[str, Array] = {
            name: np.array([[x.value for x in point] for point in getattr(shapes, name)])
            for name in BODIES
        }
        pairs = list(self._pairs())
        if not pairs:
            raise ArgumentError(
                "no two legs of the platform are compared: all of them share joints"
            )
        self._hulls = list(dict.fromkeys(hull for pair in pairs for hull in pair))
        number = {hull: k for k, hull in enumerate(self._hulls)}
        self.pairs = np.array([[number[hull] for hull in pair] for pair in pairs], np.int64)
        #: The names of the pairs, such as ``legs 2 and 5``.
        self.names = tuple(self._name(*pair) for pair in pairs)
        radii = [self._radii.get((one.what, one.constraint), 0.0) for one in self._hulls]
        self._thick = np.array(radii)[self.pairs].sum(axis=1)
        sizes = [len(self._points[one.body]) if one.what == "body" else 2 for one in self._hulls]
        self._starts = np.concatenate(([0], np.cumsum(sizes))).astype(np.int64)

    def _leg(self, k: int, beyond: str = "") -> _Hull:
        """Return a leg, or its part beyond the joint of a body if such parts are compared."""
        return _Hull("leg", "", k, BODIES.index(beyond) if beyond and self._near > 0 else None)

    def _pairs(self) -> Iterator[tuple[_Hull, _Hull]]:
        rows, near = self.instance.constraints, self._near > 0
        for first, second in combinations(self.legs, 2):
            shared = _shared(rows[first], rows[second])
            if not shared or near:
                yield self._leg(first, shared), self._leg(second, shared)
        bodies: dict[str, _Hull] = {
            name: _Hull("body", name) for name in BODIES if len(self._points[name])
        }
        for leg, (name, body) in product(self.legs, bodies.items()):
            yield self._leg(leg, name), body
        if len(bodies) == 2:
            yield bodies["platform"], bodies["base"]
        for place, (k, point, own) in enumerate(self.arms):
            arm = _Hull("arm", own, k)
            for leg in self.legs:
                joined = getattr(rows[leg], own).position == point
                if not joined:
                    yield self._leg(leg), arm
                elif near:
                    yield self._leg(leg, own), arm._replace(cut=1)
            for other, _, name in self.arms[place + 1 :]:
                same = self._drives.index[other] == self._drives.index[k]
                if not same and not (name == own and self._on_one_axis(k, other)):
                    yield arm, _Hull("arm", name, other)
            for name, body in bodies.items():
                if name != own or near:
                    yield arm._replace(cut=0 if name == own else None), body

    def _on_one_axis(self, first: int, second: int) -> bool:
        """Whether two arms begin at one point of the body."""
        a, b = (self._drives.middle[k] for k in (first, second))
        return bool(np.abs(a - b).max() <= _ONE_POINT * self._arrangement.length)

    def _name(self, first: _Hull, second: _Hull) -> str:
        if first.what == second.what == "leg":
            return f"legs {first.constraint + 1} and {second.constraint + 1}"
        return f"{self._called(first)} and {self._called(second)}"

    def _called(self, hull: _Hull) -> str:
        if hull.what != "arm":
            return f"the {hull.body}" if hull.what == "body" else f"leg {hull.constraint + 1}"
        name = getattr(self.instance.constraints[hull.constraint], f"{hull.body}_name")
        return f"the arm of {name or f'rod {hull.constraint + 1}'}"

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
        base, arm, _ = self._drives.ends(R, T, self._numbers(q))
        joints, found = (arm + T[:, None], base), []
        for hull in self._hulls:
            on_platform, k = hull.body == "platform", hull.constraint
            if hull.what == "body":
                points = self._points[hull.body]
                placed = points @ np.swapaxes(R, -1, -2) + T[:, None] if on_platform else points
                found.append(np.broadcast_to(placed, (len(T), *points.shape)))
                continue
            ends = [joint[:, k] for joint in joints]
            if hull.what == "arm":
                axis = np.broadcast_to(self._drives.middle[k], T.shape)
                ends = [apply(R, axis) + T if on_platform else axis, ends[0 if on_platform else 1]]
            if hull.cut is not None:
                ends[hull.cut] = self._beyond(ends[hull.cut], ends[1 - hull.cut])
            found.append(np.stack(ends, axis=1))
        return np.ascontiguousarray(np.concatenate(found, axis=1))

    def _numbers(self, q: Array | None) -> Array:
        """Return the numbers of the drives, any if none moves a point."""
        return np.zeros(self._drives.count) if q is None else q

    def _beyond(self, joint: Array, end: Array) -> Array:
        """Return the point of a leg at the stated length from a joint, but not beyond its end."""
        along = end - joint
        length = np.linalg.norm(along, axis=-1, keepdims=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            part = np.where(length > self._near, self._near / length, 1.0)
        return np.where(np.isfinite(length), joint + part * along, np.nan)

    def moves(
        self,
        R: Array,
        T: Array,
        q: Array | None,
        shifts: Array,
        turns: Array,
        centre: Array,
        slips: Array | None = None,
    ) -> Array:
        """Bound how much each gap changes while the platform moves a little, shape (n, p).

        Parameters
        ----------
        R, T, q, shifts, turns, centre
            As for `slips_near`; q is needed if cranks or slides move points.
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
        drives, q = self._drives, self._numbers(q)
        placed = drives.arrangement(q)
        if slips is None:
            slips = np.zeros((len(T), 6))
            if drives.moves:
                slips = slips_near(drives, R, T, q, shifts, turns, centre)
        on, places = drives.on_platform, T + apply(R, np.broadcast_to(centre, T.shape))
        sides = np.stack([np.where(on, slips, 0.0), np.where(on, 0.0, slips)])
        own = np.linalg.norm(placed.y - centre, axis=-1) + sides[0]
        away = np.linalg.norm(places[:, None] - placed.x, axis=-1) + sides[1]
        from_base, from_platform = np.zeros((2, len(T), len(self._hulls)))
        for k, hull in enumerate(self._hulls):
            side, leg = BODIES.index(hull.body or "platform"), hull.constraint
            # As seen from the other body, and from its own.
            seen = (from_base, from_platform)[side][:, k], (from_platform, from_base)[side][:, k]
            about = (centre[None], places)[side]
            if hull.what == "body":
                far = np.linalg.norm(about[:, None] - self._points[hull.body], axis=-1).max(axis=1)
                seen[0][:] = shifts + turns * far
            elif hull.what == "arm":
                # The axis of the arm is fixed in its body, and the point of the arm moves in this
                # body.
                far = np.linalg.norm(about - drives.middle[leg], axis=-1)
                far = np.maximum(far, (own, away)[side][:, leg])
                seen[0][:] = shifts + turns * far + sides[side, :, leg]
                seen[1][:] = sides[side, :, leg]
            else:
                on_platform, on_base = sides[:, :, leg]
                # If both ends of a part of a leg move, both motions count.
                both = np.maximum if hull.cut is None else np.add
                seen[0][:] = both(shifts + turns * own[:, leg] + on_platform, on_base)
                seen[1][:] = both(shifts + turns * away[:, leg] + on_base, on_platform)
        sums = [one[:, self.pairs].sum(axis=2) for one in (from_base, from_platform)]
        size = np.abs(places).max(axis=1)
        size = size + np.abs(placed.x).max(axis=(-2, -1)) + np.abs(placed.y).max(axis=(-2, -1))
        size = size + np.abs(drives.middle[drives.driven]).max(initial=0.0)
        # Positions of two hulls are rounded, and so is the rotation.
        return np.asarray(above(np.minimum(*sums)) + roundings(16, size[:, None]))


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
    """The gaps of p pairs of legs and bodies at n poses."""

    #: Names of the p pairs, such as ``legs 2 and 5`` or ``leg 3 and the base``. A leg has the
    #: number of its constraint.
    pairs: tuple[str, ...]
    #: The gaps, shape (n, p), in the unit of length; negative where the shapes overlap.
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
