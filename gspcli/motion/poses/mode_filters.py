"""Which real poses a machine can mean: those in a half space, within its limits, above its base.

The other real poses are poses, too: they are counted, and completeness is about
all. Filters do not change the numbers of modes.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import ArgumentError, GspError
from gspcli.geometry.euler import euler_from_rotation
from gspcli.geometry.frames import IDENTITY, PoseFrame
from gspcli.geometry.instance import Array
from gspcli.geometry.limits import restricts
from gspcli.geometry.primitives import Point
from gspcli.records import dataclass
from gspcli.wording import counted, listed, shown

if TYPE_CHECKING:
    from gspcli.geometry.home_mode import HomeMode
    from gspcli.solver.result import SolveResult


Mask = NDArray[np.bool_]

#: The coordinates of a pose that conditions are about.
COORDINATES = ("x", "y", "z", "rx", "ry", "rz")
_OPERATORS: dict[str, Callable[[Array, float], Mask]] = {
    "<=": operator.le,
    ">=": operator.ge,
    "<": operator.lt,
    ">": operator.gt,
}
_TURNED = {"<": ">", ">": "<", "<=": ">=", ">=": "<="}
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_CONDITION = re.compile(
    rf"\s*(?:(r?[xyz])\s*([<>]=?)\s*({_NUMBER})|({_NUMBER})\s*([<>]=?)\s*(r?[xyz]))\s*"
)
#: Coordinates that are this near to a bound, next to the size of the platform, are equal to it.
_EQUAL = 1e-12
#: Points are not near a plane if their least extent is more than this of the second one.
_ROUND = 0.9


@dataclass(frozen=True)
class Condition:
    """A bound for a coordinate of poses: ``z > 0``."""

    #: One of `COORDINATES`.
    name: str
    #: ``<``, ``>``, ``<=`` or ``>=``.
    sign: str
    #: In the units of the instance.
    bound: float

    @property
    def text(self) -> str:
        """The condition as it can be written."""
        return f"{self.name}{self.sign}{self.bound:g}"


def parse_conditions(text: str) -> list[Condition]:
    """Return the conditions of a text such as ``z>0, -45<=rx and rx<45``.

    Raises
    ------
    ArgumentError
        If a part of it is none.
    """
    found = []
    for part in re.split(r",|&|\band\b", text):
        match = _CONDITION.fullmatch(part)
        if match is None:
            raise ArgumentError(
                f"found {shown(part.strip())}, expected a condition such as z>0: one of "
                f"{listed(COORDINATES)}, one of < <= > >=, and a number"
            )
        name, sign, bound, other, reversed_sign, last = match.groups()
        if name is None:
            name, sign, bound = last, _TURNED[reversed_sign], other
        found.append(Condition(name, sign, float(bound)))
    return found


@dataclass(frozen=True, eq=False)
class ModeFilter:
    """What is asked of real poses; each part leaves out those that do not keep it."""

    #: Bounds for coordinates, all of which are to be kept.
    where: Sequence[Condition] = ()
    #: Whether ranges and cones are to be kept.
    within_limits: bool = False
    #: Whether the platform is to be above its base (`heights`).
    above: bool = False
    #: How coordinates are expressed: the frame, and the order of the axes of rx, ry, rz.
    frame: PoseFrame = IDENTITY
    sequence: str = "ZYX"

    def __bool__(self) -> bool:
        return bool(self.where) or self.within_limits or self.above

    def left_out(self, result: SolveResult) -> dict[str, list[int]]:
        """Return the numbers of the real poses that are left out, from 1, by the first reason.

        Parameters
        ----------
        result
            The poses of a platform.

        Raises
        ------
        ArgumentError
            If the platform has no limits, or its base no plane.
        """
        real = np.flatnonzero(result.real)
        R, T = result.R[real].real, result.T[real].real
        size, masks = result.arrangement.length, {}
        numbers = self._coordinates(result, R, T)
        for one in self.where:
            column, scale = numbers[:, COORDINATES.index(one.name)], 1.0
            if one.name in "xyz":
                scale = size
            near = np.abs(column - one.bound) <= _EQUAL * scale
            kept = _OPERATORS[one.sign](np.where(near, one.bound, column), one.bound)
            masks[one.text] = np.asarray(kept, bool)
        if self.within_limits:
            if not restricts(result.instance):
                raise ArgumentError("the platform states no range and no cone", "within_limits")
            masks["within limits"] = np.array([not result.solutions[k].limits for k in real], bool)
        if self.above:
            masks["above"] = heights(result, R, T) > _EQUAL * size
        left, seen = {}, np.zeros(len(real), bool)
        for reason, kept in masks.items():
            out = ~kept & ~seen
            seen |= out
            left[reason] = (real[out] + 1).tolist()
        return {reason: those for reason, those in left.items() if those}

    def _coordinates(self, result: SolveResult, R: Array, T: Array) -> Array:
        """Return x, y, z, rx, ry, rz of poses, shape (n, 6)."""
        turned, at = self.frame.from_platform(R, T)
        angles = euler_from_rotation(self.sequence, turned) / result.arrangement.in_radians
        return np.hstack((at, angles))


def heights(result: SolveResult, R: Array, T: Array) -> Array:
    """Return how far the platform's centre is above that of the base, along its normal, (n,).

    Centres are the means of the points of distances. The normal is that of the plane that fits the
    points of the base best. It points to where the platform is at the stated home; without one it
    points along the base's z axis.

    Raises
    ------
    ArgumentError
        If there is no such plane or direction.
    """
    arrangement, instance = result.arrangement, result.instance
    points = {
        row.base.position: row.base.point
        for row in instance.constraints
        if isinstance(row.base, Point) and row.kind.is_distance
    }
    sizes, axes = np.zeros(3), np.eye(3)
    if len(points) >= 3:
        places = np.array(list(points.values()))
        _, sizes, axes = np.linalg.svd(places - places.mean(axis=0), full_matrices=True)
    if sizes[1] <= _EQUAL * max(sizes[0], 1e-300) or sizes[2] > _ROUND * sizes[1]:
        raise ArgumentError("the points of the base are in no one plane", "above")
    normal, home = axes[2], instance.home
    up = np.array([0, 0, arrangement.length])
    if home is not None:
        turn = home.R(arrangement.in_radians)
        up = turn @ arrangement.platform_centre + home.T - arrangement.base_centre
    along = float(normal @ up)
    if abs(along) <= 1e-9 * arrangement.length:
        where = "home" if home is not None else "the z axis of the base"
        raise ArgumentError(
            f"{where} is on neither side of the plane of the base's points", "above"
        )
    middles = R @ arrangement.platform_centre + T - arrangement.base_centre
    return np.asarray(middles @ normal * np.sign(along))


def chosen_mode(mode: int | None, home: HomeMode | None, count: int) -> int:
    """Return the number of the real pose that is asked for.

    Parameters
    ----------
    mode
        Its number, from 1; None for home.
    home
        The home mode, if there is one.
    count
        How many real poses there are.

    Raises
    ------
    GspError
        If there is no such pose.
    """
    if home is None:
        raise GspError("the platform has no real pose for its values (gsp solve says why)")
    if mode is None:
        return home.number
    if not 1 <= mode <= count:
        raise GspError(f"found mode {mode}, expected one of the {counted(count, 'real pose')}")
    return mode
