"""One mode followed along rows by the step of the controller, with the segments that it proves.

The step is in ``gspcli/export/controller/platform.c``: Newton-Kantorovich along chords of twists.
Here its numbers move linearly between rows: values, and the numbers of cranks and slides.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.geometry.coordinates import Coordinate, carried_by, coordinates
from gspcli.geometry.enclosures import roundings
from gspcli.geometry.instance import Instance
from gspcli.geometry.primitives import Point
from gspcli.geometry.quaternions import (
    quaternion_from_rotation,
    rotation_from_quaternion,
    rotation_from_vector,
)
from gspcli.motion.following.platform_numbers import platform_numbers
from gspcli.records import dataclass

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: The shortest part of the step between two rows, and the most tries for it.
SHORTEST, _TRIES = 2.0**-40, 2000
#: Numbers without limits.
_NEVER = 1e30
#: A bound of the rounding errors of frames of size one.
FRAME_ERROR: float = roundings(16, 1)


@dataclass(frozen=True, eq=False)
class Segments:
    """Proved segments of one mode.

    On a segment s goes from 0 to 1, and the poses are within ``radius`` of the chord
    ``exp(w) R, T + t`` with ``(w, t) = (s - middle) d``: T is the place of the middle of the
    platform, lengths are in units of `RowFollower.reach`.

    Attributes
    ----------
    row, begin, end
        The row before, and the part of the step to the next one, shapes (n,).
    middle
        0, or 1/2 if the chord is seen from its middle, shape (n,).
    R, T, d
        Shapes (n, 3, 3), (n, 3) and (n, 6).
    radius, error, alone
        Bounds of the distance of the poses from the chord, of the one at the end from the end of
        the chord, and a distance within which there is no other pose, shapes (n,).
    """

    row: Index
    begin: Array
    end: Array
    middle: Array
    R: Array
    T: Array
    d: Array
    radius: Array
    error: Array
    alone: Array

    @classmethod
    def of(cls, table: Array) -> Segments:
        """Return what the kernel has written, shape (n, 20).

        Its twists have twice the tangent of half the angle for the length of the rotation.
        """
        d = table[:, 11:17].copy()
        tangent = np.linalg.norm(d[:, :3], axis=1) / 2
        with np.errstate(invalid="ignore"):
            factor = np.where(tangent > 0, np.arctan(tangent) / tangent, 1.0)
        d[:, :3] *= factor[:, None]
        row = table[:, 0].astype(np.int64)
        begin, end, middle, radius, error, alone = table[:, [1, 2, 3, 17, 18, 19]].T
        R, T = rotation_from_quaternion(table[:, 4:8]), table[:, 8:11]
        return cls(row, begin, end, middle, R, T, d, radius, error, alone)

    @classmethod
    def joined(cls, parts: Sequence[Segments]) -> Segments:
        """Return the segments of several modes, one after the other."""
        names = list(cls.__annotations__)
        return cls(*(np.concatenate([getattr(one, name) for one in parts]) for name in names))

    def chord(self, k: Index, s: Array) -> tuple[Array, Array]:
        """Return R and T of points of the chords of some segments, s from 0 to 1."""
        x = (s - self.middle[k])[:, None] * self.d[k]
        return rotation_from_vector(x[:, :3]) @ self.R[k], self.T[k] + x[:, 3:]


@dataclass(frozen=True, eq=False)
class FollowedMode:
    """A mode along rows.

    Attributes
    ----------
    reached, part
        The last row reached, from 0, and the part of the step to the next one that was followed
        beyond it; -1 if Newton's method found no pose at the first row.
    R, T
        The poses at the rows reached, shapes (r, 3, 3) and (r, 3).
    last
        The last pose (R, T).
    error, alone
        A bound of its distance from the proved pose, and a distance within which there is no other
        one: of twists, as lengths.
    steps, tries, worst
        The numbers of segments that were proved and that were tried, and the largest Kantorovich
        number of a proof.
    segments
        The proved segments, if they were asked for.
    """

    reached: int
    part: float
    R: Array
    T: Array
    last: tuple[Array, Array]
    error: float
    alone: float
    steps: int
    tries: int
    worst: float
    segments: Segments


class RowFollower:
    """A platform whose values, or drives of rods, move linearly between rows.

    Parameters
    ----------
    instance
        The platform. Its values are not used.
    chosen
        The drives that move; other drives stay where the instance states their points.

    Raises
    ------
    ArgumentError
        If a drive moves the point of a constraint that is no leg, or a leg has two.
    """

    def __init__(self, instance: Instance, chosen: Sequence[Coordinate]) -> None:
        self.instance = _without(instance, set(coordinates(instance)) - set(chosen))
        numbers = platform_numbers(self.instance, shared=True)
        self.reach, self.middle, self.origin = numbers.reach, numbers.middle, numbers.origin
        #: The column of each constraint in a row: its value, or the number of its drive.
        self.column = np.arange(6)
        for j, one in enumerate(chosen):
            for body, name in carried_by(instance, one):
                for k, row in enumerate(instance.constraints):
                    if getattr(row, f"{body}_name") == name:
                        self.column[k] = 6 + j
        turns = np.array([kind.endswith("CRANK") or kind[0] == "A" for kind in numbers.kinds])
        self.unit = np.where(turns, instance.units.angle.in_radians, 1 / self.reach)
        self.numbers = replace(
            numbers,
            unit=np.ones(6),
            offset=np.zeros(6),
            least=np.full(6, -_NEVER),
            most=np.full(6, _NEVER),
        )

    @property
    def driven(self) -> NDArray[np.bool_]:
        """Which constraints are rods that a drive moves, shape (6,)."""
        return self.column >= 6

    def knows(self, rows: Array) -> bool:
        """Whether the rods that drives move keep their lengths along rows, shape (r, 6 + d)."""
        rods = rows[:, :6][:, self.driven]
        return bool((rods == rods[:1]).all())

    def in_units(self, rows: Array) -> Array:
        """Return the numbers of the equations: radians, and lengths in units of `reach`, (r, 6)."""
        return np.ascontiguousarray(rows[:, self.column] * self.unit)

    def follow(
        self,
        rows: Array,
        R: Array,
        T: Array,
        near: float = 0.0,
        *,
        shortest: float = SHORTEST,
        tries: int = _TRIES,
        keep: bool = False,
    ) -> FollowedMode:
        """Follow a mode along rows of values and numbers of drives.

        Parameters
        ----------
        rows
            Shape (r, 6 + d), in the units of the instance; rods of drives keep their lengths.
        R, T
            A pose near the mode at the first row.
        near
            A bound of its distance from the mode, a twist as a length; 0 stands for the pose that
            Newton's method finds.
        shortest, tries
            The shortest part of a step between rows that is tried, and how many are tried.
        keep
            Whether to return the proved segments.
        """
        assert self.knows(rows)
        rod = np.where(self.driven, rows[0, :6], 0.0) / self.reach
        numbers = replace(self.numbers, rod=rod)
        kernel = _kernel.Controller(numbers.kind, numbers.either, numbers.doubles)
        pose = np.concatenate((T, quaternion_from_rotation(R)))
        reached, poses, last, part, error, alone, steps, made, worst, table = kernel.follow_rows(
            self.in_units(rows), pose, near, shortest, tries, keep
        )
        return FollowedMode(
            reached,
            part,
            rotation_from_quaternion(poses[:, 3:]),
            poses[:, :3],
            (rotation_from_quaternion(last[3:]), last[:3]),
            error,
            alone,
            steps,
            made,
            worst,
            Segments.of(table),
        )


def _without(instance: Instance, still: set[Coordinate]) -> Instance:
    """Return an instance whose points some drives do not move."""
    places = {key for one in still for key in carried_by(instance, one)}
    constraints = []
    for row in instance.constraints:
        for body in ("platform", "base"):
            point = getattr(row, body)
            if isinstance(point, Point) and (body, getattr(row, f"{body}_name")) in places:
                changed: dict[str, Any] = {body: replace(point, crank=None, slide=None, partner="")}
                row = replace(row, **changed)
        constraints.append(row)
    return replace(instance, constraints=tuple(constraints), dynamics=None) if places else instance
