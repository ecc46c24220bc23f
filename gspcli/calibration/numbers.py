"""From the parameters of a fit to the numbers of a file, with their deviations, and back."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.blocks import CORRECTIONS, Block
from gspcli.calibration.parameters import Model
from gspcli.geometry.instance import Constraint, Instance, as_read
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import (
    Crank,
    Geometry,
    Line,
    Plane,
    Point,
    Slide,
    Vector,
    as_array,
)
from gspcli.records import dataclass

Array = NDArray[np.float64]

_AXES = "xyz"
#: Numbers are rounded by at most this part of their standard deviation.
_PART = 1e-3
#: A number without a standard deviation has this many significant digits, relative to the typical
#: length.
_DIGITS = 15


@dataclass(frozen=True, eq=False)
class FileNumbers:
    """The numbers of an instance that parameters change.

    Attributes
    ----------
    names
        ``base.B1.x``, ``platform.L2.direction.z``, ``base.B1.crank.centre.x``,
        ``base.B1.slide.scale``, ``offset.3`` …, m of them.
    values
        In the units of the file (frames: lengths and the angle unit), shape (m,).
    slopes
        Derivatives by the parameters, shape (m, p).
    """

    names: tuple[str, ...]
    values: Array
    slopes: Array

    def covariance(self, of_parameters: Array) -> Array:
        """Return the covariance of the numbers, shape (m, m)."""
        found: Array = self.slopes @ of_parameters @ self.slopes.T
        return found


def file_numbers(instance: Instance, model: Model) -> FileNumbers:
    """Return the numbers of a file for a model of the instance; as stated for a model of it."""
    names: list[str] = []
    values: list[Array] = []
    slopes: list[Array] = []
    count = len(model.free)
    for block, span in model.spans():
        for label, vector, by in _vectors(_geometry(instance, block), block):
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


def _geometry(instance: Instance, block: Block) -> Geometry:
    geometry: Geometry = getattr(instance.constraints[block.rows[0]], block.body)
    return geometry


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
    """Return the instance with the numbers of a model.

    Parameters
    ----------
    instance
        As stated; numbers that were not estimated stay unchanged, and readings, too.
    model
        With the parameters found.
    deviations
        The standard deviation of each number that was estimated, by its name: numbers are rounded
        to a thousandth of it.
    """
    found = dict(zip(*_named(file_numbers(instance, model)), strict=True))
    least = _DIGITS - int(np.floor(np.log10(model.length)))

    def number(name: str, stated: Number) -> Number:
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
        corrections = {
            what: number(f"{label}{what}", Number.of(0))
            if f"{label}{what}" in deviations
            else getattr(stated, what)
            for what in CORRECTIONS
        }
        found: Crank | Slide
        if isinstance(stated, Crank):
            centre = vector(f"{label}centre.", stated.centre)
            axis = vector(f"{label}axis.", stated.axis)
            found = Crank(
                centre, axis, None, stated.tolerance, diameter=stated.diameter, **corrections
            )
        else:
            along = vector(f"{label}direction.", stated.direction)
            found = Slide(along, None, stated.tolerance, **corrections)
        return _with_range_of(stated, found)

    rows = []
    for k, row in enumerate(instance.constraints, 1):
        changed = replace(
            row,
            platform=primitive(f"platform.{row.platform_name or f'of {k}'}.", row.platform),
            base=primitive(f"base.{row.base_name or f'of {k}'}.", row.base),
        )
        given = {"offset": row.offset, "scale": row.scale}
        found_here = {
            what: number(f"{what}.{k}", Number.of(0)) if f"{what}.{k}" in deviations else stated
            for what, stated in given.items()
        }
        rows.append(_reread(changed, **found_here) if found_here != given else changed)
    return replace(instance, constraints=tuple(rows))


def _with_range_of(stated: Crank | Slide, found: Crank | Slide) -> Crank | Slide:
    """Return a drive whose range has the stated readings.

    With another offset or scale these are other values.
    """
    limits = stated.limits
    if limits and any(getattr(stated, what) != getattr(found, what) for what in CORRECTIONS):
        low, high = (stated.reading_of(end) for end in limits)
        limits = (found.value_of(low), found.value_of(high))
    return replace(found, limits=limits)


def _named(numbers: FileNumbers) -> tuple[tuple[str, ...], list[float]]:
    return numbers.names, numbers.values.tolist()


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
