"""Six values and further readings of one pose: residuals in standard deviations."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.measurement import value_slopes
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.records import dataclass
from gspcli.sensing.sensor_kinds import Inclinometer, JointSensor, SensorReading, verticals
from gspcli.wording import listed, shown

Array = NDArray[np.float64]

#: The step of central differences, of which the error is least: the cube root of rounding.
_STEP = 6e-6


@dataclass(frozen=True, eq=False)
class PoseNumbers:
    """Six values and r readings, each with its standard deviation.

    Attributes
    ----------
    instance
        The platform; its values were measured.
    readings
        What was measured besides.
    sigmas
        Standard deviations of the six values, in the units of the instance, shape (6,).
    left_out
        Which measurements do not count: indices into `names`.
    """

    instance: Instance
    readings: tuple[SensorReading, ...]
    sigmas: Array
    left_out: frozenset[int] = frozenset()

    @property
    def names(self) -> tuple[str, ...]:
        """What the measurements are called: ``value 1`` to ``value 6``, and the sensors."""
        return (*(f"value {k}" for k in range(1, 7)), *(str(one.sensor) for one in self.readings))

    @property
    def owners(self) -> NDArray[np.int64]:
        """The measurement of each number, shape (m,): an inclinometer has two numbers."""
        counts = [1] * 6 + [len(one.values) for one in self.readings]
        kept = [k not in self.left_out for k in range(len(counts))]
        owners = np.repeat(np.arange(len(counts)), counts)
        return np.asarray(owners[np.array(kept)[owners]])

    def residuals(self, R: Array, T: Array) -> Array:
        """Return measured less expected numbers at poses, over their deviations, shape (..., m)."""
        values = values_at(self.instance, R, T) * self._signs(R, T)
        measured = np.array([row.value.value for row in self.instance.constraints])
        parts = [(measured - values) / self.sigmas, *self._of_sensors(R, T)]
        return self._kept(np.concatenate(parts, axis=-1), -1)

    def slopes(self, R: Array, T: Array) -> Array:
        """Return the derivatives of expected numbers by a twist, shape (n, m, 6).

        In standard deviations; first the rotation (radians), then the translation. Those of
        readings are central differences.
        """
        arrangement = Arrangement.of(self.instance)
        units = np.ones(len(arrangement.kinds))
        units[arrangement.angles] = arrangement.in_radians
        scale = self._signs(R, T) / (self.sigmas * units)
        values = value_slopes(arrangement, R, T) * scale[..., None]
        columns = []
        for size, unit in zip(_STEP * pose_sizes(self.instance), np.eye(6), strict=True):
            step = size * unit
            ends = [
                np.concatenate(self._of_sensors(rotation_from_vector(turn) @ R, T + shift), axis=-1)
                for turn, shift in ((step[:3], step[3:]), (-step[:3], -step[3:]))
            ]
            columns.append((ends[1] - ends[0]) / (2 * size))
        return self._kept(np.concatenate((values, np.stack(columns, axis=-1)), axis=1), 1)

    def _signs(self, R: Array, T: Array) -> Array:
        """Return factors, 1 or -1, that make stated distances of signed ones, shape (..., 6)."""
        rows = self.instance.constraints
        signs = np.ones((*T.shape[:-1], len(rows)))
        for k, row in enumerate(rows):
            if row.kind.has_sides and row.side is not Side.POSITIVE:
                if row.side is Side.NEGATIVE:
                    signs[..., k] = -1.0
                elif row.value.value != 0:
                    away = values_at(self.instance, R, T)[..., k] < 0
                    signs[..., k] = np.where(away, -1.0, 1.0)
        return signs

    def _of_sensors(self, R: Array, T: Array) -> list[Array]:
        """Return the residuals of readings, each (..., k)."""
        return [_apart(self.instance, one, R, T) / one.sigma for one in self.readings]

    def _kept(self, numbers: Array, axis: int) -> Array:
        """Return numbers without those of measurements that are left out."""
        if not self.left_out:
            return numbers
        whole = replace(self, left_out=frozenset())
        kept = [k for k, owner in enumerate(whole.owners.tolist()) if owner not in self.left_out]
        return np.take(numbers, kept, axis=axis)


def pose_sizes(instance: Instance) -> Array:
    """Return the sizes of a turn and of a shift that move values alike, shape (6,)."""
    return np.array([1.0] * 3 + [Arrangement.of(instance).length] * 3)


def _apart(instance: Instance, one: SensorReading, R: Array, T: Array) -> Array:
    """Return what a sensor reads less what it should at poses, shape (..., k)."""
    read = one.sensor.read(instance, R, T)
    given = np.array(one.values)
    unit = instance.units.angle.in_radians
    if isinstance(one.sensor, Inclinometer):
        up, seen = verticals(read * unit), verticals(given * unit)
        # The angle between both verticals, along two directions across the one that was read.
        axes = np.linalg.svd(seen[None])[2][1:]
        across = up @ axes.T
        sine = np.linalg.norm(across, axis=-1, keepdims=True)
        angle = np.arctan2(sine, (up @ seen)[..., None])
        return (
            np.asarray(-across * np.where(sine > 0, angle / np.where(sine > 0, sine, 1), 1)) / unit
        )
    apart: Array = given - read
    if isinstance(one.sensor, JointSensor):
        turn = 2 * math.pi / unit
        apart = (apart + turn / 2) % turn - turn / 2
    return apart


def value_sigmas(instance: Instance, sigma: Mapping[str, float]) -> Array:
    """Return the standard deviations of the six values, shape (6,).

    Parameters
    ----------
    instance
        The platform. A constraint that `sigma` does not mention has its tolerance.
    sigma
        By ``value`` (all distances), ``angle`` (all angles) or the number of a constraint, in the
        units of the instance.

    Raises
    ------
    ArgumentError
        If a name or number is wrong, or nothing is known of a constraint.
    """
    numbers = [str(k) for k in range(1, len(instance.constraints) + 1)]
    for name, deviation in sigma.items():
        if name not in ("value", "angle", *numbers):
            message = f"found {shown(name)}, expected value, angle or the number of a constraint"
            raise ArgumentError(message, "sigma")
        if not 0 < deviation < math.inf:
            message = f"found {deviation:g}, expected a standard deviation above 0"
            raise ArgumentError(message, f"sigma[{name!r}]")
    found: list[float] = []
    unknown: list[str] = []
    for number, row in zip(numbers, instance.constraints, strict=True):
        sort = "value" if row.kind.is_distance else "angle"
        stated = sigma.get(number, sigma.get(sort))
        if stated is None and row.tolerance is not None and row.tolerance.value > 0:
            stated = row.tolerance.value
        if stated is None:
            unknown.append(number)
        found.append(stated or math.nan)
    if unknown:
        sorts = dict.fromkeys(
            "value" if row.kind.is_distance else "angle"
            for number, row in zip(numbers, instance.constraints, strict=True)
            if number in unknown
        )
        how = listed((f"{sort}=NUMBER" for sort in sorts), "and")
        message = (
            f"nothing says how exact the values {listed(unknown, 'and')} are: give --sigma {how}, "
            "or `tolerance` in the file"
        )
        raise ArgumentError(message)
    return np.array(found)
