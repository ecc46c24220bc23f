"""Choices of six measurements: each has all its poses, from which fits of all of them start."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import GspError
from gspcli.geometry.building import angle, distance
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.primitives import Line, Point, unit_vectors
from gspcli.records import dataclass
from gspcli.sensing.sensor_kinds import (
    Inclinometer,
    SensorReading,
    ValueSensor,
    verticals,
)
from gspcli.ties import first_largest

Array = NDArray[np.float64]

_CONSTRAINTS, _MOST_ANGLES = 6, 3


@dataclass(frozen=True)
class CandidateMeasurement:
    """A measurement as a constraint: which one it is, and its number among those of the fit."""

    owner: int
    number: int
    constraint: Constraint


def candidates_of(
    instance: Instance, readings: Sequence[SensorReading]
) -> list[CandidateMeasurement]:
    """Return the measurements that are distances or angles of primitives; angles of joints are not.

    Numbers are those of `PoseNumbers` with all measurements.
    """
    found = [CandidateMeasurement(k, k, row) for k, row in enumerate(instance.constraints)]
    number = _CONSTRAINTS
    for k, one in enumerate(readings, _CONSTRAINTS):
        for offset, row in enumerate(_constraints(instance, one)):
            found.append(CandidateMeasurement(k, number + offset, row))
        number += len(one.values)
    return found


def _constraints(instance: Instance, one: SensorReading) -> list[Constraint]:
    """Return the constraints that a reading is, in the units of the instance."""
    sensor = one.sensor
    if isinstance(sensor, ValueSensor):
        parts = sensor.platform.primitive(instance), sensor.base.primitive(instance)
        # A point of a drive is measured where it is stated.
        here, there = (Point(p.position) if isinstance(p, Point) else p for p in parts)
        if not sensor.measured.is_distance:
            return [angle(here, there, one.values[0])]
        side = "both"
        if sensor.measured.has_sides:
            side = "negative" if one.values[0] < 0 else "positive"
        return [distance(here, there, abs(one.values[0]), side=side)]
    if isinstance(sensor, Inclinometer):
        unit = instance.units.angle.in_radians
        seen = verticals(np.array(one.values) * unit)
        axes = np.sort(np.argsort(np.abs(seen), kind="stable")[:2])
        up = Line([0, 0, 0], unit_vectors([sensor.up])[0].tolist())
        return [
            angle(Line([0, 0, 0], np.eye(3)[axis].tolist()), up, math.acos(seen[axis]) / unit)
            for axis in axes.tolist()
        ]
    return []


def next_choice(
    candidates: Sequence[CandidateMeasurement], slopes: Array, used: NDArray[np.int64]
) -> list[CandidateMeasurement] | None:
    """Return six candidates that determine a pose well, those that were used least before others.

    Parameters
    ----------
    candidates
        All of them.
    slopes
        Derivatives of the numbers of the fit by a twist, scaled, at one pose, shape (m, 6).
    used
        How often each candidate was in a choice.

    Returns
    -------
    list
        None if no six of them determine the pose.
    """
    rows = slopes[[one.number for one in candidates]]
    rows = rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-300)
    weight = 0.5 ** (used - used.min())
    chosen: list[int] = []
    left = rows * weight[:, None]
    angles = np.array([not one.constraint.kind.is_distance for one in candidates])
    for _ in range(_CONSTRAINTS):
        sizes = np.linalg.norm(left, axis=1)
        sizes[chosen] = 0.0
        if angles[chosen].sum() >= _MOST_ANGLES:
            sizes[angles] = 0.0
        best = int(first_largest(sizes))
        if not sizes[best] > 1e-6:
            return None
        unit = left[best] / sizes[best]
        left = left - np.outer(left @ unit, unit)
        chosen.append(best)
    return [candidates[k] for k in sorted(chosen)]


def platform_of(instance: Instance, chosen: Sequence[CandidateMeasurement]) -> Instance | None:
    """Return the platform whose six constraints these are; None if it is no platform."""
    from gspcli.geometry.checking import checked

    made = replace(
        instance,
        constraints=tuple(one.constraint for one in chosen),
        dynamics=None,
        further=(),
        name=None,
    )
    try:
        checked(made)
    except GspError:
        return None
    return made
