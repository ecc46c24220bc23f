"""The parameters of the primitives and drives of a platform, a block for each.

A point has three parameters. A line has two shifts across it and two tilts, and so has the axis of
a crank. A plane has one shift along its normal and two tilts, a rail the two tilts of its
direction. A primitive that only angles use has its tilts alone. A crank and a rail have the offset
and the scale of their readings besides.

The offset moves the points along the circle or the rail, as their own shifts do. So it is estimated
on request only, and then the point that has the drive keeps its place along it. A primitive that
several constraints share is one block, and so is a drive that moves several points. Tilts turn
about the point of the block, which is chosen near what is measured: about a far point they would be
small differences of large shifts.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import field, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import Primitive
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.primitives import Crank, Point, Slide, as_array
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.records import dataclass

Array = NDArray[np.float64]
_AXES = "xyz"
#: What a drive has besides its place: numbers of its readings.
CORRECTIONS = ("offset", "scale")
Body = Literal["platform", "base"]
Sort = Literal["point", "line", "plane", "crank", "slide"]

_SORTS: dict[Primitive, Sort] = {
    Primitive.POINT: "point",
    Primitive.LINE: "line",
    Primitive.PLANE: "plane",
}


@dataclass(frozen=True, eq=False)
class Block:
    """The parameters of one primitive.

    Attributes
    ----------
    body, name, sort
        Whose it is, its name in the file (``of 3`` if it has none), and what it is.
    rows
        The constraints that use it, from 0.
    point, unit
        Where it is now, shapes (3,); the direction, normal or axis is zero for a point.
    shifts, tilts
        Along what it can shift, shape (s, 3), and about what it can turn, shape (t, 3).
    corrections
        Of a drive what is added to its readings, in units of length or radians, and what they are
        multiplied by, less one; shape (2,), and (0,) of what is no drive.
    carried
        The names of the points that a drive moves.
    """

    body: Body
    name: str
    sort: Sort
    rows: tuple[int, ...]
    point: Array
    unit: Array
    shifts: Array
    tilts: Array
    corrections: Array = field(default_factory=lambda: np.zeros(0))
    carried: tuple[str, ...] = ()

    @property
    def is_drive(self) -> bool:
        """Whether it is a crank or a rail."""
        return self.sort in ("crank", "slide")

    @property
    def drive_name(self) -> str:
        """The name of a drive: ``crank.B1`` or ``slide.B1``."""
        return f"{self.sort}.{self.name.removeprefix('of ')}"

    @property
    def size(self) -> int:
        """The number of its parameters."""
        return len(self.shifts) + len(self.tilts) + len(self.corrections)

    @property
    def names(self) -> list[str]:
        """The names of its parameters."""
        label = f"{self.body}.{self.name}" + (f".{self.sort}" if self.is_drive else "")
        whole = self.sort == "point" and len(self.shifts) == len(_AXES)
        shifts = list(_AXES) if whole else ["shift1", "shift2"][: len(self.shifts)]
        tilts = ("tilt1", "tilt2")[: len(self.tilts)]
        return [
            f"{label}.{part}" for part in (*shifts, *tilts, *CORRECTIONS[: len(self.corrections)])
        ]

    def sizes(self, turn: float) -> list[float]:
        """Return the change of each parameter that moves values by about a length of one.

        Parameters
        ----------
        turn
            Of an angle, in radians.
        """
        offset = 1.0 if self.sort == "slide" else turn
        parts = [1.0] * len(self.shifts) + [turn] * len(self.tilts)
        return parts + [offset, turn][: len(self.corrections)]

    def moved(self, step: Array) -> Block:
        """Return the block after a step of its parameters, shape (s + t + c,)."""
        s, t = len(self.shifts), len(self.shifts) + len(self.tilts)
        point = self.point + step[:s] @ self.shifts
        if not len(self.tilts):
            return replace(self, point=point)
        turn = rotation_from_vector(step[s:t] @ self.tilts)
        return replace(
            self,
            point=point,
            unit=turn @ self.unit,
            shifts=self.shifts @ turn.T,
            tilts=self.tilts @ turn.T,
            corrections=self.corrections + step[t:],
        )

    def numbers(self, readings: Array) -> Array:
        """Return the numbers q of a drive for its readings."""
        offset, scale = self.corrections
        numbers: Array = readings * (1 + scale) + offset
        return numbers

    def readings(self, numbers: Array) -> Array:
        """Return the readings of a drive at its numbers q."""
        offset, scale = self.corrections
        readings: Array = (numbers - offset) / (1 + scale)
        return readings

    def anchored(self, near: Array) -> Block:
        """Return the same primitive with its point moved within it, nearest to another one."""
        if self.sort in ("point", "slide"):
            return self
        away = near - self.point
        across = away @ self.unit
        inside = away - across * self.unit if self.sort == "plane" else across * self.unit
        return replace(self, point=self.point + inside)


def across(unit: Array) -> Array:
    """Return two unit vectors perpendicular to one and to each other, shape (2, 3)."""
    rows: Array = np.linalg.svd(unit[None])[2][1:]
    return rows


def blocks_of(
    instance: Instance, arrangement: Arrangement, *, drives: bool, zeros: Collection[str] = ()
) -> Iterator[Block]:
    """Yield the blocks of an instance, those of a platform's primitive before the base's.

    Parameters
    ----------
    instance, arrangement
        The platform.
    drives
        Whether there are blocks of its cranks and rails.
    zeros
        The drives whose offset is estimated, by name: the point of the drive has no shift along it.
    """
    users: dict[tuple[Body, str], list[int]] = {}
    for k, row in enumerate(instance.constraints):
        users.setdefault(("platform", row.platform_name or f"of {k + 1}"), []).append(k)
        users.setdefault(("base", row.base_name or f"of {k + 1}"), []).append(k)
    motors = _drive_blocks(instance, users) if drives else {}
    nothing = np.zeros((0, 3))
    for (body, name), rows in users.items():
        points, units = (
            (arrangement.y, arrangement.u) if body == "platform" else (arrangement.x, arrangement.v)
        )
        geometry = getattr(instance.constraints[rows[0]], body)
        point, unit = points[rows[0]].copy(), units[rows[0]].copy()
        sort = _SORTS[geometry.primitive]
        if isinstance(geometry, Point):
            motor = motors.get((body, name))
            shifts = np.eye(3)
            if motor is not None and motor.drive_name in zeros:
                shifts = across(_along(motor, point))
            yield Block(body, name, sort, tuple(rows), point, unit, shifts, nothing)
            if motor is not None:
                yield motor.anchored(point)
            continue
        tilts = across(unit)
        placed = any(instance.constraints[k].kind.is_distance for k in rows)
        shifts = nothing if not placed else tilts if sort == "line" else unit[None]
        yield Block(body, name, sort, tuple(rows), point, unit, shifts, tilts)


def _along(motor: Block, point: Array) -> Array:
    """Return the direction in which a drive moves a point that is not on its axis, (3,)."""
    if motor.sort == "slide":
        return motor.unit
    tangent: Array = np.cross(motor.unit, point - motor.point)
    return tangent / np.linalg.norm(tangent)


def _drive_blocks(
    instance: Instance, users: Mapping[tuple[Body, str], list[int]]
) -> dict[tuple[Body, str], Block]:
    """Return the blocks of cranks and rails, by the first of the points that they move."""
    carried: dict[tuple[Body, str], list[str]] = {}
    for (body, name), rows in users.items():
        point = getattr(instance.constraints[rows[0]], body)
        if isinstance(point, Point) and point.drive is not None:
            carried.setdefault((body, point.partner or name), []).append(name)
    found: dict[tuple[Body, str], Block] = {}
    for (body, owner), names in carried.items():
        rows = sorted(k for name in names for k in users[body, name])
        drive = getattr(instance.constraints[users[body, names[0]][0]], body).drive
        turns = across(drive.unit)
        rail = isinstance(drive, Slide)
        found[body, names[0]] = Block(
            body,
            owner,
            drive.sort,
            tuple(rows),
            np.zeros(3) if rail else as_array(drive.centre),
            drive.unit,
            np.zeros((0, 3)) if rail else turns,
            turns,
            _corrections(drive, instance.units.angle.in_radians),
            tuple(names),
        )
    return found


def _corrections(drive: Crank | Slide, in_radians: float) -> Array:
    unit = 1.0 if isinstance(drive, Slide) else in_radians
    offset = 0.0 if drive.offset is None else drive.offset.value * unit
    return np.array([offset, 0.0 if drive.scale is None else drive.scale.value])
