"""Numbers of primitives that can be changed by name: ``base.B1.x``, ``crank.B1``, ``slide.B1``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import ArgumentError
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, Line, Point
from gspcli.records import dataclass
from gspcli.wording import shown, suggestion

Array = NDArray[np.float64]
Body = Literal["platform", "base"]

BODIES: tuple[Body, Body] = ("platform", "base")
AXES = "xyz"


@dataclass(frozen=True)
class Coordinate:
    """A number of a primitive.

    Attributes
    ----------
    name
        The name: ``base.B1.x``, ``base.L1.direction.z``, ``platform.H2.normal.x``, or
        ``crank.B1`` for the angle of a crank, ``slide.B1`` for the place of a carriage.
    body, primitive
        The body and the name of the primitive.
    vector
        Which field of the primitive, or ``crank`` or ``slide``.
    component
        Which entry of the vector; 0 for a crank or slide.
    """

    name: str
    body: Body
    primitive: str
    vector: Literal["position", "direction", "normal", "crank", "slide"]
    component: int

    @property
    def is_drive(self) -> bool:
        """Whether it is the value of a crank or slide."""
        return self.vector in ("crank", "slide")


def coordinates(instance: Instance) -> tuple[Coordinate, ...]:
    """Return all coordinates of the named primitives of an instance."""
    found: list[Coordinate] = []
    for body in BODIES:
        for name, geometry in _primitives(instance, body).items():
            found += [
                Coordinate(f"{body}.{name}.{axis}", body, name, "position", k)
                for k, axis in enumerate(AXES)
            ]
            if isinstance(geometry, Point):
                if geometry.drive is not None:
                    sort, owner = geometry.drive.sort, geometry.partner or name
                    drive = Coordinate(f"{sort}.{owner}", body, owner, sort, 0)
                    found += [drive] if drive not in found else []
                continue
            vector: Literal["direction", "normal"]
            vector = "direction" if isinstance(geometry, Line) else "normal"
            found += [
                Coordinate(f"{body}.{name}.{vector}.{axis}", body, name, vector, k)
                for k, axis in enumerate(AXES)
            ]
    return tuple(found)


def choose(instance: Instance, names: Sequence[str]) -> tuple[Coordinate, ...]:
    """Return coordinates by name; capitals count only if two names differ in nothing else.

    Raises
    ------
    ArgumentError
        If there is no such coordinate, or more than one, or if a point is moved in two ways.
    """
    every = coordinates(instance)
    found: list[Coordinate] = []
    for name in names:
        same = [one for one in every if one.name == name]
        same = same or [one for one in every if one.name.lower() == name.lower()]
        if len(same) != 1:
            near = suggestion(name, [one.name for one in every])
            what = "a coordinate" if not same else "only one coordinate of the name"
            message = f"found {shown(name)}, expected {what} such as base.NAME.x or crank.NAME"
            raise ArgumentError(message + near)
        found += same
    for one in found:
        if one.is_drive and any(
            other.vector == "position"
            and (other.body, other.primitive) in carried_by(instance, one)
            for other in found
        ):
            message = f"found {one.name} and coordinates of the same point, expected one of both"
            raise ArgumentError(message)
    return tuple(found)


def carried_by(instance: Instance, drive: Coordinate) -> list[tuple[Body, str]]:
    """Return the points that a crank or slide moves: their body and their names."""
    return [
        (drive.body, name)
        for name, geometry in _primitives(instance, drive.body).items()
        if isinstance(geometry, Point)
        and geometry.drive is not None
        and (geometry.partner or name) == drive.primitive
    ]


def nominal_coordinates(instance: Instance, chosen: Sequence[Coordinate]) -> Array:
    """Return the coordinates that the instance states, shape (n,); zero for a crank or slide."""
    return np.array(
        [
            0.0
            if one.is_drive
            else getattr(_primitives(instance, one.body)[one.primitive], one.vector)[
                one.component
            ].value
            for one in chosen
        ]
    )


def drive_corrections(instance: Instance, chosen: Sequence[Coordinate]) -> tuple[Array, Array]:
    """Return offsets and factors of the readings of coordinates, each of shape (n,).

    A number is its reading times the factor, plus the offset; 0 and 1 unless a crank or slide
    states others.
    """
    added, times = np.zeros(len(chosen)), np.ones(len(chosen))
    for k, one in enumerate(chosen):
        if not one.is_drive:
            continue
        (_, name), *_ = carried_by(instance, one)
        point = _primitives(instance, one.body)[name]
        assert isinstance(point, Point)
        assert point.drive is not None
        added[k] = 0.0 if point.drive.offset is None else point.drive.offset.value
        times[k] = 1.0 if point.drive.scale is None else 1 + point.drive.scale.value
    return added, times


def moved(instance: Instance, chosen: Sequence[Coordinate], numbers: Array) -> Instance:
    """Return an instance with other coordinates, rounded to floats.

    A point that a drive has moved has no drive any more, and the instance then no masses.

    Parameters
    ----------
    instance
        The instance.
    chosen
        Which coordinates.
    numbers
        Shape (n,): lengths, components, and values of cranks and slides, in the units of the
        instance.
    """
    if not chosen:
        return instance
    changed: dict[tuple[Body, str], Geometry] = {}
    for one, number in zip(chosen, numbers.tolist(), strict=True):
        if one.is_drive:
            unit = instance.units.angle.in_radians if one.vector == "crank" else 1.0
            for key in carried_by(instance, one):
                point = _primitives(instance, one.body)[key[1]]
                assert isinstance(point, Point)
                changed[key] = point.moved(number * unit)
        else:
            key = one.body, one.primitive
            geometry = changed.get(key) or _primitives(instance, one.body)[one.primitive]
            vector = list(getattr(geometry, one.vector))
            vector[one.component] = Number.of(number)
            fields: dict[str, Any] = {one.vector: tuple(vector)}
            changed[key] = replace(geometry, **fields)
    constraints = tuple(
        replace(
            row,
            platform=changed.get(("platform", row.platform_name), row.platform),
            base=changed.get(("base", row.base_name), row.base),
        )
        for row in instance.constraints
    )
    # The masses are those of the machine with all its drives.
    kept = None if any(one.is_drive for one in chosen) else instance.dynamics
    return replace(instance, constraints=constraints, dynamics=kept)


def _primitives(instance: Instance, body: Body) -> dict[str, Geometry]:
    return {
        getattr(row, f"{body}_name"): getattr(row, body)
        for row in instance.constraints
        if getattr(row, f"{body}_name")
    }
