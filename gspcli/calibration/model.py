"""What a calibration estimates: the numbers of primitives and drives, offsets, scales, two frames.

A block has the parameters of one primitive or drive. A point has three. A line has two shifts
across it and two tilts, and so has the axis of a crank. A plane has one shift along its normal and
two tilts, a rail the two tilts of its direction. A primitive that only angles use has its tilts
alone. A crank and a rail have the offset and the scale of their readings besides.

The offset moves the points along the circle or the rail, as their own shifts do. So it is estimated
on request only, and then the point that has the drive keeps its place along it. A primitive that
several constraints share is one block, and so is a drive that moves several points. Tilts turn
about the point of the block, which is chosen near what is measured: about a far point they would be
small differences of large shifts.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import Kind, Primitive
from gspcli.geometry.arrangement import Bodies
from gspcli.geometry.coordinates import BODIES, Body
from gspcli.geometry.instance import Constraint, Instance, as_read
from gspcli.geometry.machine import Machine, value_machine
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Crank, Geometry, Line, Plane, Point, Slide, Vector, as_array
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.geometry.readings import factors, offsets
from gspcli.records import dataclass

Array = NDArray[np.float64]
_AXES = "xyz"
#: What a drive has besides its place: numbers of its readings.
CORRECTIONS = ("offset", "scale")
Sort = Literal["point", "line", "plane", "crank", "slide"]

_SORTS: dict[Primitive, Sort] = {
    Primitive.POINT: "point",
    Primitive.LINE: "line",
    Primitive.PLANE: "plane",
}


@dataclass(frozen=True, eq=False)
class Block:
    """The parameters of one primitive."""

    #: Whose it is, its name in the file (``of 3`` if it has none), and what it is.
    body: Body
    name: str
    sort: Sort
    #: The constraints that use it, from 0.
    rows: tuple[int, ...]
    #: Where it is now, shapes (3,); the direction, normal or axis is zero for a point.
    point: Array
    unit: Array
    #: Along what it can shift, shape (s, 3), and about what it can turn, shape (t, 3).
    shifts: Array
    tilts: Array
    #: Of a drive what is added to its readings, in units of length or radians, and what they are
    #: multiplied by, less one; shape (2,), and (0,) of what is no drive.
    corrections: Array = field(default_factory=lambda: np.zeros(0))
    #: The names of the points that a drive moves.
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
        """Return the change of each parameter that moves values by about 1, an angle by `turn`."""
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
        return np.asarray(readings * (1 + scale) + offset)

    def readings(self, numbers: Array) -> Array:
        """Return the readings of a drive at its numbers q."""
        offset, scale = self.corrections
        return np.asarray((numbers - offset) / (1 + scale))

    def motion(self, numbers: Array) -> tuple[Array, Array]:
        """Return how a drive turns and shifts what it carries, (n, 3, 3) and (n, 3)."""
        along = numbers[:, None] * self.unit
        none = np.zeros_like(along)
        turn, shift = (none, along) if self.sort == "slide" else (along, none)
        return rotation_from_vector(turn), shift

    def rate(self, arm: Array) -> Array:
        """Return the derivative of a point by the number of its drive, from its arm, (..., 3)."""
        if self.sort == "slide":
            return np.broadcast_to(self.unit, arm.shape)
        return np.asarray(np.cross(self.unit, arm))

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
    return np.asarray(np.linalg.svd(unit[None])[2][1:])


def blocks_of(machine: Machine, zeros: Collection[str] = ()) -> Iterator[Block]:
    """Yield the blocks of a machine with its cranks and rails, the platform's before the base's.

    The points of the drives `zeros`, whose offset is estimated, have no shift along them.
    """
    arrangement, rows = machine.stated_arrangement, machine.instance.constraints
    users: dict[tuple[Body, str], list[int]] = {}
    for k, row in enumerate(rows):
        users.setdefault(("platform", row.platform_name or f"of {k + 1}"), []).append(k)
        users.setdefault(("base", row.base_name or f"of {k + 1}"), []).append(k)
    drives = dict(_drive_blocks(machine))
    nothing = np.zeros((0, 3))
    for (body, name), used in users.items():
        points, units = (
            (arrangement.y, arrangement.u) if body == "platform" else (arrangement.x, arrangement.v)
        )
        point, unit = points[used[0]].copy(), units[used[0]].copy()
        sort = _SORTS[getattr(rows[used[0]], body).primitive]
        if sort == "point":
            drive, shifts = drives.get((body, name)), np.eye(3)
            if drive is not None and drive.drive_name in zeros:
                along = drive.rate(point - drive.point)
                shifts = across(along / np.linalg.norm(along))
            yield Block(body, name, sort, tuple(used), point, unit, shifts, nothing)
            if drive is not None:
                yield drive.anchored(point)
            continue
        tilts = across(unit)
        placed = any(rows[k].kind.is_distance for k in used)
        shifts = nothing if not placed else tilts if sort == "line" else unit[None]
        yield Block(body, name, sort, tuple(used), point, unit, shifts, tilts)


def _drive_blocks(machine: Machine) -> Iterator[tuple[tuple[Body, str], Block]]:
    """Yield the blocks of cranks and rails, each with the first of the points that it moves."""
    for drive in np.flatnonzero(machine.moved).tolist():
        rows = machine.users(drive)
        body = BODIES[0 if machine.on_platform[rows[0]] else 1]
        used = [machine.instance.constraints[k] for k in rows]
        names = [
            getattr(row, f"{body}_name") or f"of {k + 1}" for k, row in zip(rows, used, strict=True)
        ]
        point = getattr(used[0], body)
        turns = across(point.drive.unit)
        rail = isinstance(point.drive, Slide)
        corrections = (machine.offsets * machine.units, machine.factors - 1)
        yield (
            (body, names[0]),
            Block(
                body,
                point.partner or names[0],
                point.drive.sort,
                tuple(rows),
                np.zeros(3) if rail else as_array(point.drive.centre),
                point.drive.unit,
                np.zeros((0, 3)) if rail else turns,
                turns,
                np.array([part[drive] for part in corrections]),
                tuple(dict.fromkeys(names)),
            ),
        )


#: A pose of the measuring device and one of the target: turns (3), then shifts (3), of each.
FRAMES = 12
_FRAME_NAMES = tuple(
    f"{frame}.{q}" for frame in ("device", "target") for q in ("rx", "ry", "rz", "x", "y", "z")
)


@dataclass(frozen=True, eq=False)
class Model:
    """A platform whose numbers can change."""

    #: The kinds of the six constraints.
    kinds: tuple[Kind, ...]
    #: A typical length, in which turns are weighed against shifts.
    length: float
    #: The unit of angles.
    in_radians: float
    #: The primitives.
    blocks: tuple[Block, ...]
    #: What is added to readings, in units of length and radians, and what they are multiplied by,
    #: less one; shapes (6,).
    offsets: Array
    scales: Array
    #: The pose of the base in the measuring device's frame and that of the target in the
    #: platform's: a rotation vector and a shift each, shape (12,).
    frames: Array
    #: Which of all parameters are estimated, shape (p,).
    free: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))

    @classmethod
    def of(cls, instance: Instance, *, drives: bool = False, zeros: Collection[str] = ()) -> Model:
        """Return the model of an instance, all parameters free but scales and frames.

        Where its cranks and slides are read, axes and rails are estimated, too; the offsets of the
        drives `zeros` in place of a shift of their point along them.

        Raises
        ------
        ArgumentError
            If both points of a constraint have drives.
        """
        machine = Machine.of(instance) if drives else value_machine(instance)
        arrangement = machine.stated_arrangement
        shifts = offsets(instance)
        shifts[arrangement.angles] *= arrangement.in_radians
        model = cls(
            arrangement.kinds,
            arrangement.length,
            arrangement.in_radians,
            tuple(blocks_of(machine, zeros)),
            shifts,
            factors(instance) - 1,
            np.zeros(FRAMES),
        )
        free = np.ones(len(model.names), bool)
        free[model.geometry + 6 :] = False
        # The offset of a distance to a plane is a shift of the plane: one of both is enough.
        planes = [k for k, kind in enumerate(model.kinds) if kind.has_sides]
        free[[model.geometry + k for k in planes]] = False
        # So is that of a drive along which its points shift.
        for block, span in model.spans():
            if block.is_drive:
                free[span.stop - 2] = block.drive_name in zeros
                free[span.stop - 1] = False
        return replace(model, free=free)

    @property
    def geometry(self) -> int:
        """How many parameters the primitives have; offsets, scales and frames follow."""
        return sum(block.size for block in self.blocks)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all parameters."""
        geometry = [name for block in self.blocks for name in block.names]
        numbers = range(1, len(self.kinds) + 1)
        values = [f"{what}.{k}" for what in ("offset", "scale") for k in numbers]
        return (*geometry, *values, *_FRAME_NAMES)

    @property
    def sizes(self) -> Array:
        """The change of each parameter that moves values by about a length of one, shape (p,)."""
        turn = 1 / self.length
        parts = [block.sizes(turn) for block in self.blocks]
        parts.append([1.0 if kind.is_distance else turn for kind in self.kinds])
        parts.append([turn] * len(self.kinds))
        parts.append(([turn] * 3 + [1.0] * 3) * 2)
        return np.concatenate(parts)

    @property
    def with_frames(self) -> bool:
        """Whether the frames of device and target are estimated."""
        return bool(self.free[self.geometry + 12 :].any())

    def spans(self) -> Iterator[tuple[Block, slice]]:
        """Yield the blocks and where their parameters are."""
        at = 0
        for block in self.blocks:
            yield block, slice(at, at + block.size)
            at += block.size

    def moved(self, step: Array) -> Model:
        """Return the model after a step of all parameters, shape (p,)."""
        at = self.geometry
        return replace(
            self,
            blocks=tuple(block.moved(step[span]) for block, span in self.spans()),
            offsets=self.offsets + step[at : at + 6],
            scales=self.scales + step[at + 6 : at + 12],
            frames=self.frames + step[at + 12 :],
        )

    def anchored(self, R: Array, T: Array) -> Model:
        """Return the same with the points of lines and planes near what is measured at poses."""
        places = {(b.body, k): b for b in self.blocks if not b.is_drive for k in b.rows}
        found = []
        for block in self.blocks:
            if block.sort in ("line", "plane"):
                other: Body = "base" if block.body == "platform" else "platform"
                ends = [places[other, k] for k in block.rows]
                near = [b.point for b in ends if b.sort == "point"] or [np.zeros(3)]
                if block.body == "base":
                    block = block.anchored((R @ np.mean(near, axis=0) + T).mean(axis=0))
                elif ends[0].sort == "point":
                    away = np.mean(near, axis=0) - T
                    block = block.anchored(np.einsum("nba,nb->na", R, away).mean(axis=0))
                else:
                    block = block.anchored(np.zeros(3))
            found.append(block)
        return replace(self, blocks=tuple(found))

    @property
    def drives(self) -> tuple[Block, ...]:
        """The blocks of cranks and slides."""
        return tuple(block for block in self.blocks if block.is_drive)

    def driven(self, readings: Array | None) -> NDArray[np.bool_]:
        """Return which values are those of legs whose drives are read, shape (6,)."""
        rows = [k for drive in self.drives for k in drive.rows] if readings is not None else []
        return np.isin(np.arange(len(self.kinds)), rows)

    @property
    def drive_units(self) -> Array:
        """The units of the readings of drives in radians and lengths, shape (m,)."""
        return np.array([self.in_radians if one.sort == "crank" else 1.0 for one in self.drives])

    def bodies(self, readings: Array | None = None) -> Bodies:
        """Return the primitives as they are now.

        With readings of the drives in radians and lengths, (n, m), the points are (n, 6, 3).
        """
        y, x = np.zeros((2, 1 if readings is None else len(readings), 6, 3))
        u, v = np.zeros((2, 6, 3))
        for block in self.blocks:
            if not block.is_drive:
                points, units = (y, u) if block.body == "platform" else (x, v)
                rows = list(block.rows)
                points[:, rows] = self._moving(block, readings)[0][:, None]
                units[rows] = block.unit
        if readings is None:
            y, x = y[0], x[0]
        return Bodies(self.kinds, y, x, u, v)

    def displacements(
        self, block: Block, readings: Array | None = None
    ) -> Iterator[tuple[list[int], Array, Array]]:
        """Yield how the parameters of a block move points and turn its direction.

        Constraints, and derivatives by each of the s parameters in the frame of the body: of their
        point, shape (n or 1, s, 3), and of the direction, shape (s, 3). A drive has one for each of
        the points that it moves; readings are as for `bodies`.
        """
        still = np.zeros((block.size, 3))
        if block.is_drive:
            for point in self._points_of(block):
                yield list(point.rows), self._by_drive(block, point, readings), still
            return
        moves, turns, s = still.copy(), still, len(block.shifts)
        moves[:s], turns[s:] = block.shifts, np.cross(block.tilts, block.unit)
        turned, _ = self._moving(block, readings)[1]
        yield list(block.rows), moves @ np.swapaxes(turned, 1, 2), turns

    def by_drives(self, readings: Array) -> Iterator[tuple[int, Block, Array]]:
        """Yield the number of a drive, a point of it, and its derivative by the reading, (n, 3)."""
        for k, drive in enumerate(self.drives):
            for point in self._points_of(drive):
                place, _ = self._moving(point, readings)
                rate = drive.rate(place - drive.point) * (1 + drive.corrections[1])
                yield k, point, np.broadcast_to(rate, (len(readings), 3))

    def _by_drive(self, drive: Block, point: Block, readings: Array | None) -> Array:
        """Return the derivatives of a point by the parameters of its drive, (n or 1, s, 3)."""
        place, (turn, _) = self._moving(point, readings)
        arm, back = point.point - drive.point, np.swapaxes(turn, 1, 2)
        rate, read = drive.rate(place - drive.point), self._reading(drive, readings)
        tilted = np.cross(drive.tilts, (place - drive.point)[:, None])
        tilted = tilted - np.cross(drive.tilts, arm) @ back
        shifted = drive.shifts - drive.shifts @ back
        corrected = np.stack((rate, rate * read[:, None]), axis=1)
        return np.concatenate((shifted, tilted, corrected), axis=1)

    def _moving(self, block: Block, readings: Array | None) -> tuple[Array, tuple[Array, Array]]:
        """Return the point of a block, (n or 1, 3), and how its drive turns and shifts it."""
        drive = self._drive_of(block)
        if drive is None:
            return block.point[None], (np.eye(3)[None], np.zeros((1, 3)))
        read = self._reading(drive, readings)
        turn, shift = drive.motion(read if readings is None else drive.numbers(read))
        return drive.point + turn @ (block.point - drive.point) + shift, (turn, shift)

    def _reading(self, drive: Block, readings: Array | None) -> Array:
        """Return the readings of a drive, shape (n,); zero where points are as stated."""
        if readings is None:
            return np.zeros(1)
        return np.asarray(readings[:, [one is drive for one in self.drives].index(True)])

    def _drive_of(self, block: Block) -> Block | None:
        same = (b for b in self.drives if b.body == block.body and block.name in b.carried)
        return next(same, None)

    def _points_of(self, drive: Block) -> list[Block]:
        return [
            b
            for b in self.blocks
            if b.body == drive.body and b.sort == "point" and b.name in drive.carried
        ]


#: Numbers are rounded by at most this part of their standard deviation.
_PART = 1e-3
#: A number without a standard deviation has this many significant digits, relative to the typical
#: length.
_DIGITS = 15


@dataclass(frozen=True, eq=False)
class FileNumbers:
    """The numbers of an instance that parameters change."""

    #: ``base.B1.x``, ``platform.L2.direction.z``, ``base.B1.crank.centre.x``,
    #: ``base.B1.slide.scale``, ``offset.3`` …, m of them.
    names: tuple[str, ...]
    #: In the units of the file (frames: lengths and the angle unit), shape (m,).
    values: Array
    #: Derivatives by the parameters, shape (m, p).
    slopes: Array


def file_numbers(instance: Instance, model: Model) -> FileNumbers:
    """Return the numbers of a file for a model of the instance; as stated for a model of it."""
    names: list[str] = []
    values: list[Array] = []
    slopes: list[Array] = []
    count = len(model.free)
    for block, span in model.spans():
        stated = getattr(instance.constraints[block.rows[0]], block.body)
        for label, vector, by in _vectors(stated, block):
            whole = np.zeros((3, count))
            whole[:, span] = by
            names += [f"{block.body}.{block.name}.{label}{axis}" for axis in _AXES]
            values.append(vector)
            slopes.append(whole)
        if block.is_drive:
            unit = np.array([model.in_radians if block.sort == "crank" else 1.0, 1.0])
            names += block.names[-len(unit) :]
            values.append(block.corrections / unit)
            slopes.append(np.eye(count)[span.stop - len(unit) : span.stop] / unit[:, None])
    at = model.geometry
    angle = np.array([1.0 if kind.is_distance else model.in_radians for kind in model.kinds])
    turn = np.array(([model.in_radians] * 3 + [1.0] * 3) * 2)
    names += model.names[at:]
    values.append(np.concatenate((model.offsets / angle, model.scales, model.frames / turn)))
    units = np.concatenate((angle, np.ones(6), turn))
    slopes.append(np.eye(count)[at:] / units[:, None])
    return FileNumbers(tuple(names), np.concatenate(values), np.concatenate(slopes))


def _vectors(stated: Geometry, block: Block) -> list[tuple[str, Array, Array]]:
    """Return name, numbers and derivatives by parameters (3, p) of a primitive's vectors."""
    none = np.zeros((len(block.corrections), 3))
    turns = np.vstack((np.zeros_like(block.shifts), np.cross(block.tilts, block.unit), none))
    shifts = np.vstack((block.shifts, np.zeros_like(block.tilts), none))
    if block.sort == "point":
        return [("", block.point, shifts.T)]
    if isinstance(stated, Point):
        drive = stated.drive
        if isinstance(drive, Crank):
            place, vector, names = drive.centre, drive.axis, ("crank.centre.", "crank.axis.")
        else:
            assert drive is not None
            place, vector, names = stated.position, drive.direction, ("", "slide.direction.")
    else:
        place, vector = stated.position, stated.vector
        names = ("", "direction." if block.sort == "line" else "normal.")
    length = float(np.linalg.norm(as_array(vector)))
    direction = (names[1], length * block.unit, length * turns.T)
    if not len(block.shifts):
        return [direction]
    # The point of the primitive that is nearest to the one stated: the foot of a perpendicular.
    away, u = as_array(place) - block.point, block.unit
    height = u @ away
    by_height = turns @ away - shifts @ u
    foot = np.outer(by_height, u) + height * turns
    if block.sort == "plane":
        return [(names[0], as_array(place) - height * u, -foot.T), direction]
    # The foot moves when the line is shifted across, and when its direction turns.
    return [(names[0], block.point + height * u, (shifts + foot).T), direction]


def calibrated(instance: Instance, model: Model, deviations: dict[str, float]) -> Instance:
    """Return the instance with the numbers of a model; readings stay unchanged.

    Numbers that were estimated are those with deviations: rounded to a thousandth of them.
    """
    numbers = file_numbers(instance, model)
    found = dict(zip(numbers.names, numbers.values.tolist(), strict=True))
    least = _DIGITS - int(np.floor(np.log10(model.length)))

    def number(name: str, stated: Any) -> Any:
        if name not in deviations:
            return stated
        sigma = deviations[name]
        places = least if sigma <= 0 else min(least, int(np.ceil(-np.log10(sigma * _PART))))
        return Number.of(round(found[name], max(places, 0)))

    def vector(label: str, stated: Vector) -> Vector:
        x, y, z = (number(f"{label}{axis}", one) for axis, one in zip(_AXES, stated, strict=True))
        return x, y, z

    def primitive(label: str, stated: Geometry) -> Geometry:
        fields: dict[str, Any] = {"position": vector(label, stated.position)}
        if isinstance(stated, Line):
            fields["direction"] = vector(f"{label}direction.", stated.direction)
        elif isinstance(stated, Plane):
            fields["normal"] = vector(f"{label}normal.", stated.normal)
        elif stated.drive is not None:
            owner = f"{label.partition('.')[0]}.{stated.partner}." if stated.partner else label
            fields[stated.drive.sort] = drive(f"{owner}{stated.drive.sort}.", stated.drive)
        return replace(stated, **fields)

    def drive(label: str, stated: Crank | Slide) -> Crank | Slide:
        fields = {what: number(f"{label}{what}", getattr(stated, what)) for what in CORRECTIONS}
        if isinstance(stated, Crank):
            fields |= {"centre": vector(f"{label}centre.", stated.centre)}
            fields |= {"axis": vector(f"{label}axis.", stated.axis), "diameter": stated.diameter}
        else:
            fields |= {"direction": vector(f"{label}direction.", stated.direction)}
        found = type(stated)(tolerance=stated.tolerance, **fields)
        if stated.limits is None or all(
            getattr(found, x) == getattr(stated, x) for x in CORRECTIONS
        ):
            return replace(found, limits=stated.limits)
        # With another offset or scale the stated readings are other values.
        low, high = (found.value_of(stated.reading_of(end)) for end in stated.limits)
        return replace(found, limits=(low, high))

    rows = []
    for k, row in enumerate(instance.constraints, 1):
        changed = replace(
            row,
            platform=primitive(f"platform.{row.platform_name or f'of {k}'}.", row.platform),
            base=primitive(f"base.{row.base_name or f'of {k}'}.", row.base),
        )
        given = [getattr(row, what) for what in CORRECTIONS]
        corrected = [
            number(f"{what}.{k}", old) for what, old in zip(CORRECTIONS, given, strict=True)
        ]
        rows.append(_reread(changed, *corrected) if corrected != given else changed)
    return replace(instance, constraints=tuple(rows))


def _reread(row: Constraint, offset: Number | None, scale: Number | None) -> Constraint:
    """Return a constraint with the same readings.

    With another offset or scale its values differ.
    """
    limits = row.limits
    readings = replace(
        row,
        value=row.reading_of(row.value),
        limits=limits and (row.reading_of(limits[0]), row.reading_of(limits[1])),
    )
    return as_read(readings, offset=offset, scale=scale)
