"""The parameters of the primitives of a platform, a block for each.

A point has three parameters; a line two shifts across and two tilts, a plane one and two, an axis
of a crank as a line; what only angles use is a direction and has its tilts. A primitive that
several constraints share is one block. Tilts turn about the point of the block, which is chosen
near what is measured: about a far point they would be small differences of large shifts.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import Primitive
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.primitives import Point, as_array
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.records import dataclass

Array = NDArray[np.float64]
Body = Literal["platform", "base"]
Sort = Literal["point", "line", "plane", "crank"]

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
    """

    body: Body
    name: str
    sort: Sort
    rows: tuple[int, ...]
    point: Array
    unit: Array
    shifts: Array
    tilts: Array

    @property
    def size(self) -> int:
        """The number of its parameters."""
        return len(self.shifts) + len(self.tilts)

    @property
    def names(self) -> list[str]:
        """The names of its parameters."""
        label = f"{self.body}.{self.name}" + (".crank" if self.sort == "crank" else "")
        shifts = list("xyz") if self.sort == "point" else ["shift1", "shift2"][: len(self.shifts)]
        return [f"{label}.{part}" for part in (*shifts, *("tilt1", "tilt2")[: len(self.tilts)])]

    def moved(self, step: Array) -> Block:
        """Return the block after a step of its parameters, shape (s + t,)."""
        s = len(self.shifts)
        point = self.point + step[:s] @ self.shifts
        if not len(self.tilts):
            return replace(self, point=point)
        turn = rotation_from_vector(step[s:] @ self.tilts)
        return replace(
            self,
            point=point,
            unit=turn @ self.unit,
            shifts=self.shifts @ turn.T,
            tilts=self.tilts @ turn.T,
        )

    def anchored(self, near: Array) -> Block:
        """Return the same primitive with its point moved within it, nearest to another one."""
        if self.sort == "point":
            return self
        away = near - self.point
        across = away @ self.unit
        inside = away - across * self.unit if self.sort == "plane" else across * self.unit
        return replace(self, point=self.point + inside)


def across(unit: Array) -> Array:
    """Return two unit vectors perpendicular to one and to each other, shape (2, 3)."""
    rows: Array = np.linalg.svd(unit[None])[2][1:]
    return rows


def blocks_of(instance: Instance, arrangement: Arrangement, *, cranks: bool) -> Iterator[Block]:
    """Yield the blocks of an instance, those of a platform's primitive before the base's."""
    users: dict[tuple[Body, str], list[int]] = {}
    for k, row in enumerate(instance.constraints):
        users.setdefault(("platform", row.platform_name or f"of {k + 1}"), []).append(k)
        users.setdefault(("base", row.base_name or f"of {k + 1}"), []).append(k)
    nothing = np.zeros((0, 3))
    for (body, name), rows in users.items():
        points, units = (
            (arrangement.y, arrangement.u) if body == "platform" else (arrangement.x, arrangement.v)
        )
        geometry = getattr(instance.constraints[rows[0]], body)
        point, unit = points[rows[0]].copy(), units[rows[0]].copy()
        sort = _SORTS[geometry.primitive]
        if isinstance(geometry, Point):
            yield Block(body, name, sort, tuple(rows), point, unit, np.eye(3), nothing)
            if cranks and geometry.crank is not None:
                axis = as_array(geometry.crank.axis)
                axis /= np.linalg.norm(axis)
                centre, turns = as_array(geometry.crank.centre), across(axis)
                crank = Block(body, name, "crank", tuple(rows), centre, axis, turns, turns)
                yield crank.anchored(point)
            continue
        tilts = across(unit)
        placed = any(instance.constraints[k].kind.is_distance for k in rows)
        shifts = nothing if not placed else tilts if sort == "line" else unit[None]
        yield Block(body, name, sort, tuple(rows), point, unit, shifts, tilts)
