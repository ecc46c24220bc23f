"""The cranks and slides of an instance by name, as they move points: ``crank.B1``, ``slide.B1``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from gspcli.errors import ArgumentError
from gspcli.geometry.instance import Array, Instance
from gspcli.geometry.primitives import Geometry, Point
from gspcli.records import dataclass
from gspcli.wording import shown, suggestion

Body = Literal["platform", "base"]

BODIES: tuple[Body, Body] = ("platform", "base")


@dataclass(frozen=True)
class Coordinate:
    """The number of a drive: the angle of a crank, or the place of a carriage."""

    #: ``crank.B1`` or ``slide.B1``.
    name: str
    #: The body and the name of the point that states the drive.
    body: Body
    primitive: str
    #: Which of both it is.
    vector: Literal["crank", "slide"]


def coordinates(instance: Instance) -> tuple[Coordinate, ...]:
    """Return the cranks and slides of the named points of an instance."""
    found: dict[Coordinate, None] = {}
    for body in BODIES:
        for name, geometry in _primitives(instance, body).items():
            if isinstance(geometry, Point) and geometry.drive is not None:
                sort, owner = geometry.drive.sort, geometry.partner or name
                found[Coordinate(f"{sort}.{owner}", body, owner, sort)] = None
    return tuple(found)


def choose(instance: Instance, names: Sequence[str]) -> tuple[Coordinate, ...]:
    """Return drives by name; capitals count only if two names differ in nothing else.

    Raises
    ------
    ArgumentError
        If there is no such drive, or more than one.
    """
    every = coordinates(instance)
    found: list[Coordinate] = []
    for name in names:
        same = [one for one in every if one.name == name]
        same = same or [one for one in every if one.name.lower() == name.lower()]
        if len(same) != 1:
            near = suggestion(name, [one.name for one in every])
            what = "a drive" if not same else "only one drive of the name"
            raise ArgumentError(f"found {shown(name)}, expected {what} such as crank.NAME" + near)
        found += same
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


def drive_corrections(instance: Instance, chosen: Sequence[Coordinate]) -> tuple[Array, Array]:
    """Return offsets and factors of the readings of drives, each of shape (n,).

    A number is its reading times the factor, plus the offset; 0 and 1 unless a crank or slide
    states others.
    """
    added, times = np.zeros(len(chosen)), np.ones(len(chosen))
    for k, one in enumerate(chosen):
        (_, name), *_ = carried_by(instance, one)
        point = _primitives(instance, one.body)[name]
        assert isinstance(point, Point)
        assert point.drive is not None
        added[k] = 0.0 if point.drive.offset is None else point.drive.offset.value
        times[k] = 1.0 if point.drive.scale is None else 1 + point.drive.scale.value
    return added, times


def moved(instance: Instance, chosen: Sequence[Coordinate], numbers: Array) -> Instance:
    """Return an instance with its drives elsewhere, rounded to floats.

    A point that a drive has moved has no drive any more, and the instance then no masses: those
    are of the machine with all its drives.

    Parameters
    ----------
    instance
        The instance.
    chosen
        Which drives.
    numbers
        Shape (n,), in the units of the instance.
    """
    if not chosen:
        return instance
    changed: dict[tuple[Body, str], Geometry] = {}
    for one, number in zip(chosen, numbers.tolist(), strict=True):
        unit = instance.units.angle.in_radians if one.vector == "crank" else 1.0
        for key in carried_by(instance, one):
            point = _primitives(instance, one.body)[key[1]]
            assert isinstance(point, Point)
            changed[key] = point.moved(number * unit)
    constraints = tuple(
        replace(
            row,
            platform=changed.get(("platform", row.platform_name), row.platform),
            base=changed.get(("base", row.base_name), row.base),
        )
        for row in instance.constraints
    )
    return replace(instance, constraints=constraints, dynamics=None)


def _primitives(instance: Instance, body: Body) -> dict[str, Geometry]:
    return {
        getattr(row, f"{body}_name"): getattr(row, body)
        for row in instance.constraints
        if getattr(row, f"{body}_name")
    }
