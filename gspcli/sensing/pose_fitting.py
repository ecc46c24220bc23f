"""What fits readings of sensors: modes of a solved platform, and poses of least squares.

Least squares of more than six measurements find each pose that fits, and the outlier.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import ArgumentError, GspError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.building import angle, distance
from gspcli.geometry.checking import checked
from gspcli.geometry.instance import Constraint, Instance, Side
from gspcli.geometry.least_squares import Ends, descend
from gspcli.geometry.measurement import value_slopes
from gspcli.geometry.primitives import Line, Point, unit_vectors
from gspcli.geometry.quaternions import (
    quaternion_from_rotation,
    rotation_from_vector,
    vector_from_rotation,
)
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.records import EqualByContent, Tabular, dataclass
from gspcli.sensing.sensor_kinds import (
    Inclinometer,
    JointSensor,
    SensorReading,
    ValueSensor,
    check_sigmas,
    each_parsed,
    parse_reading,
    verticals,
)
from gspcli.solver import SolveResult, solve
from gspcli.ties import first_largest
from gspcli.wording import counted, listed

if TYPE_CHECKING:
    import pandas as pd


Array = NDArray[np.float64]

#: A mode fits if no reading differs by more than this many standard deviations.
_MOST_OFF = 3.0


@dataclass(frozen=True, eq=False)
class ReadingFit(EqualByContent):
    """The differences of readings from the expected ones at the m real modes of a platform."""

    #: The modes: real poses, in this order.
    result: SolveResult
    #: The r readings.
    readings: tuple[SensorReading, ...]
    #: The expected readings of each sensor at each mode: r arrays of shape (m, 1), for
    #: inclinometers (m, 2), in the units of the instance.
    expected: tuple[Array, ...]
    #: The differences of the readings from these, in their standard deviations, shape (m, r).
    off: Array

    def __repr__(self) -> str:
        return f"<ReadingFit: {self.sentence}>"

    @cached_property
    def worst(self) -> Array:
        """The largest difference for each mode, shape (m,)."""
        return np.asarray(self.off.max(axis=1, initial=0.0))

    @property
    def fits(self) -> NDArray[np.bool_]:
        """Which modes fit: all readings are within three standard deviations, shape (m,)."""
        return np.asarray(self.worst <= _MOST_OFF)

    @property
    def modes(self) -> list[int]:
        """The numbers of the modes that fit, from 1, the best first."""
        order = np.argsort(self.worst, kind="stable")
        return [int(k) + 1 for k in order if self.fits[k]]

    @property
    def mode(self) -> int | None:
        """The number of the only mode that fits; None if there is no or more than one mode."""
        return self.modes[0] if len(self.modes) == 1 else None

    @property
    def sentence(self) -> str:
        """The result in a sentence."""
        what = "reading" if len(self.readings) == 1 else "readings"
        if not len(self.worst):
            return f"there is no mode that could fit the {what}"
        order = np.argsort(self.worst, kind="stable").tolist()
        texts = [f"{self.worst[k]:.3g}" for k in order]
        if not self.modes:
            nearest = f"mode {order[0] + 1} is nearest, off by {texts[0]} standard deviations"
            return f"no mode fits the {what}: {nearest}"
        if self.mode is None:
            names = listed(map(str, sorted(self.modes)), "and")
            return f"{len(self.modes)} modes fit the {what}: {names}"
        text = f"mode {self.mode} fits the {what}: off by {texts[0]} standard deviations"
        return f"{text}, the next, mode {order[1] + 1}, by {texts[1]}" if len(order) > 1 else text

    def rows(self) -> list[dict[str, Any]]:
        """Return for each mode its number, its difference, and whether it fits."""
        return [
            {"number": k + 1, "off": float(self.worst[k]), "fits": bool(self.fits[k])}
            for k in range(len(self.worst))
        ]

    def to_frame(self) -> pd.DataFrame:
        """Return the modes as a table with the expected readings (pandas is imported now)."""
        import pandas as pd

        frame = pd.DataFrame(self.rows(), columns=["number", "off", "fits"])
        for reading, read in zip(self.readings, self.expected, strict=True):
            names = [str(reading.sensor)] if read.shape[1] == 1 else [
                f"{reading.sensor} rx", f"{reading.sensor} ry"
            ]  # fmt: skip
            frame[names] = read
        return frame

    def to_json(self) -> dict[str, Any]:
        """Return the readings and which modes fit as plain data."""
        return {
            "readings": [
                {
                    "sensor": str(reading.sensor),
                    "values": list(reading.values),
                    "sigma": reading.sigma,
                }
                for reading in self.readings
            ],
            "fitting": self.modes,
        }

    def of_mode(self, k: int) -> dict[str, Any]:
        """Return the fit of a mode, by its index, as plain data."""
        return {
            "expected_readings": [read[k].tolist() for read in self.expected],
            "off": self.off[k].tolist(),
            "fits": bool(self.fits[k]),
        }


def parsed_readings(
    instance: Instance, readings: Sequence[str | SensorReading], *, repeated: bool = False
) -> list[SensorReading]:
    """Return readings, at least one, that are given as texts or as such; as `parse_reading`.

    Raises
    ------
    ArgumentError
        If there is none, or one is wrong.
    """
    given = [readings] if isinstance(readings, str | SensorReading) else list(readings)
    parse = partial(parse_reading, instance=instance, repeated=repeated)
    return each_parsed(given, parse, "readings")


def fit_readings(result: SolveResult, readings: Sequence[str | SensorReading]) -> ReadingFit:
    """Return the differences of readings from the expected ones at each real mode.

    Parameters
    ----------
    result
        A solved platform, as `gspcli.solve` returns it.
    readings
        Texts such as ``"leg P7 B7 = 212.4 ± 0.1"`` (`gspcli.sensing.sensor_kinds`); their errors
        are independent.

    Raises
    ------
    ArgumentError
        If there is none, or one is wrong; the column of the mistake is named.

    Examples
    --------
    >>> import gspcli
    >>> from gspcli.resources import instance_files
    >>> m2 = gspcli.load(instance_files()["rubin-m2"])
    >>> gspcli.fit_readings(gspcli.solve(m2), ["leg P1 B2 = 2.913 ± 0.002"]).mode
    2
    """
    instance, shown = result.instance, result.drawn
    parsed = parsed_readings(instance, readings)
    R, T = shown.R[shown.real].real, shown.T[shown.real].real
    expected = tuple(one.sensor.read(instance, R, T) for one in parsed)
    off = np.stack(
        [
            one.sensor.apart(instance, read, np.array(one.values)) / one.sigma
            for one, read in zip(parsed, expected, strict=True)
        ],
        axis=1,
    )
    for array in (off, *expected):
        array.setflags(write=False)
    return ReadingFit(result, tuple(parsed), expected, off)


#: How many constraints there are, and how many of them can be angles.
_CONSTRAINTS, _MOST_ANGLES = 6, 3
#: The step of central differences, of which the error is least: the cube root of rounding.
_STEP = 6e-6


@dataclass(frozen=True, eq=False)
class PoseNumbers:
    """The six values of a platform and r readings, each with its standard deviation.

    Those of the values are `sigmas`, in the units of the instance, (6,). Measurements that are left
    out, indices into `names`, do not count.
    """

    instance: Instance
    readings: tuple[SensorReading, ...]
    sigmas: Array
    left_out: frozenset[int] = frozenset()

    @property
    def names(self) -> tuple[str, ...]:
        """What the measurements are called: ``value 1`` to ``value 6``, and the sensors."""
        return (*(f"value {k}" for k in range(1, 7)), *(str(one.sensor) for one in self.readings))

    @cached_property
    def _counted(self) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """The measurement of each number, and which numbers count."""
        counts = [1] * _CONSTRAINTS + [len(one.values) for one in self.readings]
        owners = np.repeat(np.arange(len(counts)), counts)
        return owners, ~np.isin(owners, list(self.left_out))

    @property
    def owners(self) -> NDArray[np.int64]:
        """The measurement of each number, shape (m,): an inclinometer has two numbers."""
        owners, kept = self._counted
        return owners[kept]

    @property
    def sizes(self) -> Array:
        """The sizes of a turn and of a shift that move values alike, shape (6,)."""
        return np.array([1.0] * 3 + [Arrangement.of(self.instance).length] * 3)

    def moved(self, step: NDArray[Any], R: Array, T: Array) -> tuple[Array, Array]:
        """Return poses after twists in units of `sizes`, shape (n, 6)."""
        step = step * self.sizes
        return rotation_from_vector(step[:, :3]) @ R, T + step[:, 3:]

    def residuals(self, R: Array, T: Array) -> Array:
        """Return measured less expected numbers at poses, over their deviations, shape (..., m)."""
        values = values_at(self.instance, R, T) * self._signs(R, T)
        measured = np.array([row.value.value for row in self.instance.constraints])
        parts = [(measured - values) / self.sigmas, *self._of_sensors(R, T)]
        return np.concatenate(parts, axis=-1)[..., self._counted[1]]

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
        for size, unit in zip(_STEP * self.sizes, np.eye(6), strict=True):
            step = size * unit
            ends = [
                np.concatenate(self._of_sensors(rotation_from_vector(turn) @ R, T + shift), axis=-1)
                for turn, shift in ((step[:3], step[3:]), (-step[:3], -step[3:]))
            ]
            columns.append((ends[1] - ends[0]) / (2 * size))
        found = np.concatenate((values, np.stack(columns, axis=-1)), axis=1)
        return np.asarray(found[:, self._counted[1]])

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
    rows = dict(enumerate(instance.constraints, 1))
    check_sigmas(sigma, ("value", "angle", *map(str, rows)))
    sorts = {k: "value" if row.kind.is_distance else "angle" for k, row in rows.items()}
    tolerances = {k: row.tolerance.value if row.tolerance else 0.0 for k, row in rows.items()}
    found = [sigma.get(str(k), sigma.get(sorts[k], tolerances[k])) for k in rows]
    if unknown := [k for k, deviation in zip(rows, found, strict=True) if not deviation]:
        how = listed((f"{sort}=NUMBER" for sort in dict.fromkeys(sorts[k] for k in unknown)), "and")
        raise ArgumentError(
            f"nothing says how exact the values {listed(map(str, unknown), 'and')} are: give "
            f"--sigma {how}, or `tolerance` in the file"
        )
    return np.array(found)


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

    Slopes are derivatives of the numbers by a twist, scaled, (m, 6); None if no six determine it.
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


#: A pose fits if a chi-squared as large occurs at least so often by chance.
FITS = 1e-3
#: Decimals of residuals in JSON, in standard deviations: more are those of rounding errors.
_DECIMALS = 4


@dataclass(frozen=True, eq=False)
class FittedPose:
    """A minimum of the sum of squares."""

    #: The pose, shapes (3, 3) and (3,).
    R: Array
    T: Array
    #: The sum of squares of residuals over their deviations, and its degrees of freedom.
    chi_squared: float
    freedom: int
    #: Of a small turn about the axes of the base (radians) and of T, shape (6, 6); infinite if the
    #: measurements do not determine the pose.
    covariance: Array
    #: Measured less fitted numbers over their standard deviations, shape (m,).
    residuals: Array
    #: The same over their own deviations: a residual is smaller than an error, since the pose
    #: follows it. NaN where no other measurement checks a number.
    studentised: Array
    #: The measurement of each number, shape (m,).
    owners: NDArray[np.int64]

    @property
    def probability(self) -> float:
        """How often chi-squared is as large by chance; 1 without degrees of freedom."""
        return chance(self.chi_squared, self.freedom)

    @property
    def fits(self) -> bool:
        """Whether that is at least once in a thousand times."""
        return self.probability >= FITS

    @cached_property
    def sigma(self) -> Array:
        """Standard deviations of the turn (radians) and of T, shape (6,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @cached_property
    def measurement_sizes(self) -> Array:
        """The largest studentised residual of each measurement; NaN if there is none."""
        found = np.full(int(self.owners.max()) + 1, np.nan)
        for owner, size in zip(self.owners.tolist(), np.abs(self.studentised), strict=True):
            found[owner] = np.fmax(found[owner], size)
        return found


@dataclass(frozen=True, eq=False)
class Without:
    """The best fit without one measurement, from 0: the six values, then the readings.

    Those that are alike may be the outlier as well: their studentised residuals are as large.
    """

    measurement: int
    alike: tuple[int, ...]
    pose: FittedPose


@dataclass(frozen=True, eq=False)
class PoseFit(Tabular):
    """The poses that fit six values and further readings.

    Attributes
    ----------
    numbers
        What was measured.
    poses
        The distinct minima found, by their chi-squared.
    choices
        The choices of six measurements that were solved, each by the measurements in it.
    starts
        From how many poses the fits started.
    without
        The fit without the measurement that agrees least, if none fits; None otherwise.
    """

    numbers: PoseNumbers
    poses: tuple[FittedPose, ...]
    choices: tuple[tuple[int, ...], ...]
    starts: int
    without: Without | None

    def __repr__(self) -> str:
        return f"<PoseFit: {self.sentences[0]}>"

    @property
    def fitting(self) -> list[int]:
        """The numbers of the poses that fit, from 1."""
        return [k for k, pose in enumerate(self.poses, 1) if pose.fits]

    @property
    def sentences(self) -> list[str]:
        """The result in sentences."""
        count = len(self.numbers.owners)
        told = counted(count, "number")
        if not self.poses:
            return [f"no minimum was found from {counted(self.starts, 'pose')}"]
        best = self.poses[0]
        said = f"chi-squared {best.chi_squared:.4g} of {best.freedom}, probability "
        said += f"{best.probability:.2g}"
        if not self.fitting:
            first = f"no pose fits the {told}: the best has {said}"
        elif len(self.fitting) == 1:
            first = f"one pose fits the {told}: {said}"
        else:
            names = listed(map(str, self.fitting), "and")
            first = f"{len(self.fitting)} poses fit the {told}: {names}"
        if len(self.poses) > len(self.fitting) > 0:
            following = self.poses[len(self.fitting)]
            first += f"; the next has chi-squared {following.chi_squared:.4g}"
        lines = [
            first,
            f"{counted(len(self.poses), 'minimum', 'minima')} from {self.starts} starts, all poses "
            f"of {counted(len(self.choices), 'choice')} of six measurements; it is not proved that "
            "there are no others",
        ]
        if self.without is not None:
            lines.append(self._outlier(self.without))
        return lines

    def _outlier(self, without: Without) -> str:
        """Return which measurement is the outlier, in a sentence."""
        names, worst, pose = self.numbers.names, without.measurement, without.pose
        size = f"studentised residual {self.poses[0].measurement_sizes[worst]:.3g}"
        if without.alike:
            others = listed((names[k] for k in without.alike), "and")
            return (
                f"one measurement is wrong, and the data do not show which: {names[worst]} or "
                f"{others} ({size}); more readings would tell"
            )
        said = f"{pose.chi_squared:.4g} of {pose.freedom}"
        if pose.fits:
            return (
                f"the outlier is {names[worst]} ({size}): without it chi-squared is {said}, "
                f"probability {pose.probability:.2g}"
            )
        return (
            f"{names[worst]} agrees least ({size}), but without it chi-squared is still {said}: "
            "more than one measurement is wrong"
        )

    def rows(self) -> list[dict[str, Any]]:
        """Return the poses as rows of plain data."""
        unit = self.numbers.instance.units.angle.in_radians
        keys = ("Tx", "Ty", "Tz", "qw", "qx", "qy", "qz")
        found = []
        for number, pose in enumerate(self.poses, 1):
            numbers = [*pose.T.tolist(), *np.asarray(quaternion_from_rotation(pose.R)).tolist()]
            row = {"number": number, **dict(zip(keys, numbers, strict=True))}
            row |= {"chi_squared": pose.chi_squared, "probability": pose.probability}
            row |= {"sigma_T": float(pose.sigma[3:].max())}
            found.append(
                row | {"sigma_turn": float(pose.sigma[:3].max()) / unit, "fits": pose.fits}
            )
        return found

    def to_json(self) -> dict[str, Any]:
        """Return all of it as plain data."""
        names, numbers, without = self.numbers.names, self.numbers, self.without
        values = [[row.value.value] for row in numbers.instance.constraints]
        values += [list(one.values) for one in numbers.readings]
        sigmas = [*numbers.sigmas.tolist(), *(one.sigma for one in numbers.readings)]
        return {
            "freedom": self.poses[0].freedom if self.poses else 0,
            "measurements": [
                {"name": name, "values": given, "sigma": sigma}
                for name, given, sigma in zip(names, values, sigmas, strict=True)
            ],
            "choices": [[names[k] for k in choice] for choice in self.choices],
            "starts": self.starts,
            "fitting": self.fitting,
            "poses": [self._of(pose) for pose in self.poses],
            "outlier": None
            if without is None
            else {
                "name": names[without.measurement],
                "alike": [names[k] for k in without.alike],
                "without": self._of(without.pose),
            },
        }

    def _of(self, pose: FittedPose) -> dict[str, Any]:
        unit = self.numbers.instance.units.angle.in_radians
        scale = np.array([1 / unit] * 3 + [1.0] * 3)
        finite = bool(np.isfinite(pose.covariance).all())
        names = self.numbers.names
        return {
            "R": pose.R.tolist(),
            "T": pose.T.tolist(),
            "chi_squared": pose.chi_squared,
            "freedom": pose.freedom,
            "probability": pose.probability,
            "fits": pose.fits,
            "covariance": (pose.covariance * np.outer(scale, scale)).tolist() if finite else None,
            "residuals": [
                {
                    "name": names[owner],
                    "residual": round(left, _DECIMALS) + 0.0,
                    "studentised": None if math.isnan(size) else round(size, _DECIMALS) + 0.0,
                }
                for owner, left, size in zip(
                    pose.owners.tolist(),
                    pose.residuals.tolist(),
                    pose.studentised.tolist(),
                    strict=True,
                )
            ],
        }


def chance(chi_squared: float, freedom: int) -> float:
    """Return how often chi-squared with some degrees of freedom is larger."""
    from mpmath import gammainc

    if freedom <= 0:
        return 1.0
    return float(gammainc(freedom / 2, chi_squared / 2, regularized=True))


#: At most this many choices of six measurements are solved.
CHOICES = 8
#: Descents take at most this many steps; short ones, which choose measurements, this many.
_STEPS, _SHORT = 400, 10
#: Newton's method then takes this many steps, with central differences of this much.
_POLISH, _APART = 4, 1e-4
#: Sums of squares that differ by less than this part, or than this, are equal: rounding decides.
_EQUAL = 1e-6
#: Minima nearer than this, in radians and typical lengths, are one.
_SAME = 1e-5
#: Of the outlier the studentised residual is at least this part of the largest; the fit without it
#: starts at this many poses. Others with which data are not a thousand times less likely are alike.
_SUSPECT, _NEAREST = 0.7, 12
_LIKELIER = 2 * math.log(1000)
#: Numbers of which the others leave less than this part open are not checked by them.
_UNCHECKED = 1e-6


class Minima(NamedTuple):
    """Poses of least squares, the best first: (n, 3, 3), (n, 3), and their sums of squares."""

    R: Array
    T: Array
    cost: Array


def fit_poses(
    instance: Instance,
    readings: Sequence[str | SensorReading] | None = None,
    *,
    sigma: Mapping[str, float] | None = None,
) -> PoseFit:
    """Return the poses that fit the six values and further readings best, by least squares.

    Every minimum of the sum of squares that is reached from a pose of six of the measurements is
    returned; several choices of six are solved. It is not proved that there are no others.

    Parameters
    ----------
    instance
        The platform; its values are measurements, too.
    readings
        Texts such as ``"leg P7 B7 = 212.4 ± 0.1"`` (`gspcli.sensing.sensor_kinds`); those of the
        instance if None.
    sigma
        Standard deviations of the values by ``value``, ``angle`` or the number of a constraint, in
        the units of the instance; else the tolerances of the constraints.

    Raises
    ------
    ArgumentError
        If a reading or deviation is wrong or missing.
    GspError
        If no choice of six measurements has a pose.

    Examples
    --------
    >>> import gspcli
    >>> m2 = gspcli.example("rubin-m2")
    >>> fit = gspcli.fit_poses(m2, ["leg P1 B2 = 2.913 ± 0.002"], sigma={"value": 1e-5})
    >>> [pose.fits for pose in fit.poses][:2]
    [True, False]
    """
    checked(instance)
    given = instance.readings if readings is None else readings
    parsed = tuple(parsed_readings(instance, given, repeated=True))
    numbers = PoseNumbers(instance, parsed, value_sigmas(instance, sigma or {}))
    starts, solved = _starts(numbers)
    minima = _minima(numbers, *starts)
    poses = tuple(
        _pose(numbers, R, T, float(cost))
        for R, T, cost in zip(minima.R, minima.T, minima.cost, strict=True)
    )
    without = None
    if poses and not poses[0].fits:
        without = _without(numbers, Minima(*starts, np.zeros(0)), poses[0])
    return PoseFit(numbers, poses, solved, len(starts[0]), without)


def _starts(numbers: PoseNumbers) -> tuple[tuple[Array, Array], tuple[tuple[int, ...], ...]]:
    """Return the poses of choices of six measurements, and the choices that were solved."""
    instance = numbers.instance
    candidates = candidates_of(instance, numbers.readings)
    used, chosen = np.zeros(len(candidates), int), candidates[:6]
    R, T, solved = np.zeros((0, 3, 3)), np.zeros((0, 3)), []
    for _ in range(CHOICES):
        platform = platform_of(instance, chosen)
        owners = tuple(sorted({one.owner for one in chosen}))
        if platform is not None:
            try:
                result = solve(platform)
            except GspError:
                result = None
            if result is not None and len(result.R):
                more = _real_starts(result)
                R, T = np.concatenate((R, more[0])), np.concatenate((T, more[1]))
                solved.append(owners)
        for k, one in enumerate(candidates):
            used[k] += one in chosen
        if len(candidates) == 6:
            break
        # Where the best pose so far is.
        at = _near_best(numbers, *more) if len(R) else (np.eye(3), np.zeros(3))
        slopes = numbers.slopes(at[0][None], at[1][None])[0] * numbers.sizes
        following = next_choice(candidates, slopes, used)
        if following is None or all(used[candidates.index(one)] > 1 for one in following):
            break
        chosen = following
    if not len(R):
        raise GspError(
            "no choice of six of the measurements has a pose: are they in the units of SPEC, and "
            "at one pose?"
        )
    return (R, T), tuple(solved)


def _real_starts(result: SolveResult) -> tuple[Array, Array]:
    """Return the real poses of a result, and the nearest ones to those that are not real.

    With errors of measurement two real poses become complex.
    """
    U, _, V = np.linalg.svd(result.R.real)
    sign = np.linalg.det(U @ V)
    U[..., 2] *= sign[:, None]
    return U @ V, result.T.real.copy()


def _near_best(numbers: PoseNumbers, R: Array, T: Array) -> tuple[Array, Array]:
    """Return where the best of some short descents ends."""
    ends = _descended(numbers, R, T, _SHORT)
    best = _in_order(ends.squares)[0]
    return ends.point[0][best], ends.point[1][best]


def _minima(numbers: PoseNumbers, R: Array, T: Array) -> Minima:
    """Return the distinct ends of descents from poses, the best first."""
    ends = _descended(numbers, R, T)
    (R, T), cost = ends.point, ends.squares
    kept: list[int] = []
    for k in _in_order(cost):
        if not ends.ended[k] or not np.isfinite(cost[k]):
            continue
        turns = np.linalg.norm(vector_from_rotation(R[kept] @ R[k].T), axis=-1) if kept else []
        moves = np.linalg.norm(T[kept] - T[k], axis=-1) / numbers.sizes[-1] if kept else []
        if not any(a < _SAME and b < _SAME for a, b in zip(turns, moves, strict=True)):
            kept.append(k)
    R, T, cost = _polished(numbers, R[kept], T[kept])
    order = _in_order(cost)
    return Minima(R[order], T[order], cost[order])


def _in_order(cost: Array) -> list[int]:
    """Return the indices of sums of squares, the smallest first, equal ones as they were given."""
    order: list[int] = []
    least, first = -math.inf, 0
    for k in np.argsort(cost, kind="stable").tolist():
        if not cost[k] - least <= _EQUAL * (1 + cost[k]):
            least, first = float(cost[k]), len(order)
        order[first:] = sorted([*order[first:], k])
    return order


def _polished(numbers: PoseNumbers, R: Array, T: Array) -> tuple[Array, Array, Array]:
    """Return minima to the last digits, by Newton's method, and their sums of squares.

    Descents end where the sum of squares does not fall: there half of the digits of a pose are
    right. A pose that is not a minimum of its own (not isolated, or a saddle) is returned
    unchanged.
    """

    def gradient(R: Array, T: Array) -> Array:
        slopes = numbers.slopes(R, T) * numbers.sizes
        return np.asarray(np.einsum("nmk,nm->nk", slopes, numbers.residuals(R, T)))

    start = R, T
    if not len(R):
        return R, T, np.zeros(0)
    with np.errstate(all="ignore"):
        columns = []
        for unit in _APART * np.eye(6):
            steps = np.tile(unit, (len(R), 1))
            ends = [gradient(*numbers.moved(sign * steps, R, T)) for sign in (-1, 1)]
            columns.append((ends[0] - ends[1]) / (2 * _APART))
        curvature = np.stack(columns, axis=-1)
        curvature = np.nan_to_num((curvature + np.swapaxes(curvature, 1, 2)) / 2)
        values = np.linalg.eigvalsh(curvature)
        minimum = values[:, 0] > _UNCHECKED * values[:, -1]
        curvature[~minimum] = np.eye(6)
        for _ in range(_POLISH):
            step = np.linalg.solve(curvature, gradient(R, T)[..., None])[..., 0]
            R, T = numbers.moved(step, R, T)
        kept = minimum & (np.linalg.norm(T - start[1], axis=1) < _SAME * numbers.sizes[-1])
        kept &= np.linalg.norm(R - start[0], axis=(1, 2)) < _SAME
    R = np.where(kept[:, None, None], R, start[0])
    T = np.where(kept[:, None], T, start[1])
    return R, T, (numbers.residuals(R, T) ** 2).sum(axis=1)


def _descended(numbers: PoseNumbers, R: Array, T: Array, steps: int = _STEPS) -> Ends:
    """Return where descents from poses end, with steps in radians and typical lengths."""

    def equations(R: Array, T: Array) -> tuple[Array, Array]:
        # A residual is the reading less the value at the pose.
        return numbers.residuals(R, T), -numbers.slopes(R, T) * numbers.sizes

    # Residuals are in standard deviations.
    return descend(equations, numbers.moved, (R, T), steps=steps, noise=1.0)


def _pose(numbers: PoseNumbers, R: Array, T: Array, cost: float) -> FittedPose:
    """Return a minimum with its covariance and residuals."""
    size = numbers.sizes
    residual = numbers.residuals(R, T)
    slopes = numbers.slopes(R[None], T[None])[0] * size
    U, s, V = np.linalg.svd(slopes, full_matrices=False)
    gain: Array = np.asarray(V, float)
    told = len(s) == 6 and s[-1] > 1e-9 * s[0]
    covariance: Array = np.full((6, 6), np.inf)
    if told:
        covariance = (gain.T / np.asarray(s, float) ** 2) @ gain * np.outer(size, size)
    open_part = 1 - (U[:, s > 1e-9 * s[0]] ** 2).sum(axis=1)
    open_part[open_part <= _UNCHECKED] = np.nan
    studentised = residual / np.sqrt(open_part)
    freedom = len(residual) - int((s > 1e-9 * s[0]).sum())
    return FittedPose(R, T, cost, freedom, covariance, residual, studentised, numbers.owners)


def _without(numbers: PoseNumbers, starts: Minima, best: FittedPose) -> Without | None:
    """Return the fit without the measurement that agrees least; None if that tells nothing.

    Measurements with large studentised residuals are left out in turn, and the one is named
    without which chi-squared is least. Others of which the data are not a thousand times less
    likely cannot be distinguished from it: with one number more than six none can.
    """
    sizes = best.measurement_sizes
    if best.freedom < 1 or not np.isfinite(sizes).any():
        return None
    fits = []
    for k in np.flatnonzero(sizes >= _SUSPECT * np.nanmax(sizes)).tolist():
        rest = replace(numbers, left_out=frozenset((k,)))
        if len(rest.owners) < 6:
            continue
        # The outlier has drawn all minima to it: poses of six others are starts, too.
        near = np.argsort((rest.residuals(starts.R, starts.T) ** 2).sum(axis=1))[:_NEAREST]
        R = np.concatenate((best.R[None], starts.R[near]))
        T = np.concatenate((best.T[None], starts.T[near]))
        minima = _minima(rest, R, T)
        if len(minima.R):
            pose = _pose(rest, minima.R[0], minima.T[0], float(minima.cost[0]))
            fits.append((k, pose))
    if not fits:
        return None
    order = _in_order(np.array([pose.chi_squared for _, pose in fits]))
    (worst, pose), *others = (fits[k] for k in order)
    most = pose.chi_squared + _LIKELIER
    return Without(worst, tuple(k for k, one in others if one.chi_squared < most), pose)
