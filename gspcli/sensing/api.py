"""The additional sensor that best distinguishes the real modes of a platform."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from gspcli.defaults import SEED
from gspcli.errors import ArgumentError, IncompleteError, NotFiniteError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.checking import checked
from gspcli.geometry.drive_numbers import is_driven
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import exact_direction
from gspcli.geometry.ranges import wrong_value
from gspcli.sensing.candidates import candidates
from gspcli.sensing.mirror import mirror_of
from gspcli.sensing.mode_sets import (
    ValueSets,
    about_home,
    given,
    heights,
    home_of,
    motors_within,
    ranges_of,
    rows_of,
    values_within,
)
from gspcli.sensing.notation import parse_sensor
from gspcli.sensing.result import SensorResult
from gspcli.sensing.sensor_kinds import KINDS, Sensor
from gspcli.sensing.separations import best_pair, separations
from gspcli.solver import SolveResult, solve
from gspcli.solver.arguments import whole

#: Readings with this difference in standard deviations are distinct: each is accurate to three.
NEED = 6.0
#: Default standard deviations: of lengths as a part of the platform's size, of angles in degrees.
SIGMA_PART, SIGMA_DEGREES = 1e-3, 0.1
#: The default number of sets of values that are drawn in intervals.
USUAL_COUNT = 100
#: Digits of the default standard deviations of lengths.
_DIGITS = 2


def sensors(
    instance: Instance,
    values: ArrayLike | None = None,
    *,
    coordinates: Mapping[str, ArrayLike] | None = None,
    random: int | None = None,
    within: Mapping[int | str, tuple[float, float]] | None = None,
    seed: int = SEED,
    sensors: Sequence[str | Sensor] | None = None,
    sigma: Mapping[str, float] | None = None,
    need: float = NEED,
    known_side: bool = False,
    up: ArrayLike = (0, 0, 1),
    jobs: int = 1,
) -> SensorResult:
    """Return how well one additional sensor distinguishes the real modes of a platform.

    At each set of values all real modes are found, and the readings of each sensor at them. A
    sensor is judged by the pair of modes whose readings differ least, in its standard deviations.

    Parameters
    ----------
    instance
        The platform.
    values
        Sets of values instead of those of the instance, shape (n, 6), distances to planes signed.
    coordinates
        With values: primitives that move, as `gspcli.track` takes them.
    random
        The number of random sets of values that replace those of the instance: in the ranges of its
        constraints if each has one, else the values at random poses about home.
    within
        Intervals for the values of constraints (by their number, from 1) in which sets are drawn
        instead; the other values are constant. Of a platform with cranks or slides the intervals
        are those of its motors, by name: ``{"crank.B1": (-20, 20)}``. There are 100 sets by
        default.
    seed
        The source of randomness.
    sensors
        The sensors, as `gspcli.sensing.notation` writes them; all of
        `gspcli.sensing.candidates` if None.
    sigma
        Standard deviations by the kind of sensor (``leg``, ``coordinate``, ``joint``,
        ``inclinometer``, ``distance``, ``angle``), in the units of the instance. Without one,
        lengths have a thousandth of the platform's size, and angles a tenth of a degree.
    need
        The difference in standard deviations from which on modes count as distinguished.
    known_side
        Whether the side of the base on which the platform is, is known: that of home, the real pose
        of the instance with the least turn (of several the highest).
    up
        The vertical in the base, shape (3,).
    jobs
        Threads.

    Raises
    ------
    ArgumentError
        If an argument is wrong.
    NotFiniteError, IncompleteError
        If the poses at the values of the instance are infinitely many, or not all known. Such sets
        of random values are skipped and counted.

    Examples
    --------
    >>> import gspcli
    >>> from gspcli.resources import instance_files
    >>> m2 = gspcli.load(instance_files()["rubin-m2"])
    >>> gspcli.sensors(m2, sensors=["leg P1 B2", "inclinometer"])
    <SensorResult of Rubin Observatory M2 hexapod: ...>
    """
    checked(instance)
    seed, jobs = whole(seed, "seed", least=0), whole(jobs, "jobs", least=1)
    count = None if random is None else whole(random, "random", least=1)
    if not (isinstance(need, int | float) and 0 < need < math.inf):
        message = f"found {need!r}, expected a number above 0"
        raise ArgumentError(message, "need")
    vertical = exact_direction(np.asarray(up, float).tolist(), "up")
    chosen = candidates(instance, vertical) if sensors is None else _named(sensors, instance)
    usual = _sigmas(instance, sigma or {})
    deviations = np.array([usual[sensor.kind] for sensor in chosen])
    if values is None and within is not None and is_driven(instance):
        sets = motors_within(instance, _motor_spans(within), count or USUAL_COUNT, seed)
    elif values is None:
        spans = None if within is None else _spans(instance, within)
        sets = _value_sets(instance, spans, count, seed, jobs)
    elif count is None and within is None:
        sets = rows_of(instance, values, coordinates or {})
    else:
        message = "found values and random or within, expected one of them"
        raise ArgumentError(message, "values")
    side = _home_side(instance, seed, jobs) if known_side else None
    blocks = [
        block if side is None else block.on_side(side) for block in sets.modes(instance, seed, jobs)
    ]
    found = separations(blocks, chosen, deviations)
    told = found.complete & (found.modes > 1)
    enough = not told.any() or bool((found.least[:, told] >= need).all(axis=1).any())
    mirror = None if sets.platforms else mirror_of(instance)
    seen = mirror if side is None else None
    return SensorResult(
        instance=instance,
        drawn=sets.drawn,
        values=sets.values,
        seed=None if sets.drawn in ("given", "rows") else seed,
        sensors=tuple(chosen),
        sigmas=deviations,
        close=float(need * usual["leg"]),
        need=float(need),
        known_side=known_side,
        separations=found,
        mirror=mirror,
        blind=np.array([seen is not None and seen.keeps(one, instance) for one in chosen], bool),
        pair=None if enough else best_pair(blocks, chosen, deviations, need, told),
    )


def default_sigmas(instance: Instance) -> dict[str, float]:
    """Return the standard deviations of sensors by their kind, in the units of the instance."""
    arrangement = Arrangement.of(instance)
    size = arrangement.extent or arrangement.length
    length = float(f"{SIGMA_PART * size:.{_DIGITS}g}")
    angle = math.radians(SIGMA_DEGREES) / instance.units.angle.in_radians
    angle = float(f"{angle:.{_DIGITS}g}")
    lengths = ("leg", "coordinate", "distance")
    return {kind: length if kind in lengths else angle for kind in KINDS}


def _sigmas(instance: Instance, given: Mapping[str, float]) -> dict[str, float]:
    """Return the standard deviations by kind: given ones, or else the default."""
    for kind, value in given.items():
        if kind not in KINDS:
            message = f"found {kind!r}, expected one of {', '.join(KINDS)}"
            raise ArgumentError(message, "sigma")
        if not 0 < value < math.inf:
            message = f"found {value!r}, expected a standard deviation above 0"
            raise ArgumentError(message, f"sigma[{kind!r}]")
    return default_sigmas(instance) | {kind: float(value) for kind, value in given.items()}


def _named(given: Sequence[str | Sensor], instance: Instance) -> list[Sensor]:
    if not len(given):
        message = "found none, expected at least one sensor, or None for all"
        raise ArgumentError(message, "sensors")
    found = []
    for k, one in enumerate(given):
        try:
            found.append(parse_sensor(one, instance) if isinstance(one, str) else one)
        except ArgumentError as error:
            raise ArgumentError(error.message, f"sensors[{k}], {error.where}") from None
    return found


def _motor_spans(within: Mapping[int | str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
    """Return intervals of the readings of motors by the names of the drives."""
    for name, (low, high) in within.items():
        _check_order(low, high, f"within[{name!r}]")
    return {str(name): span for name, span in within.items()}


def _check_order(low: float, high: float, where: str) -> None:
    if not -math.inf < low <= high < math.inf:
        message = f"found {low:g} to {high:g}, expected the lower number first"
        raise ArgumentError(message, where)


def _spans(
    instance: Instance, within: Mapping[int | str, tuple[float, float]]
) -> dict[int, tuple[float, float]]:
    spans = {}
    for number, (low, high) in within.items():
        where = f"within[{number!r}]"
        if not isinstance(number, int) or not 1 <= number <= len(instance.constraints):
            message = f"found constraint {number}, expected 1 to {len(instance.constraints)}"
            raise ArgumentError(message, where)
        _check_order(low, high, where)
        row = instance.constraints[number - 1]
        for value in (low, high):
            meant = row.value_of(Number.of(value))
            if wrong := wrong_value(row.kind, meant, instance.units.angle):
                message = f"found {value:g}, {wrong}"
                raise ArgumentError(message, where)
        spans[number - 1] = (float(low), float(high))
    return spans


def _value_sets(
    instance: Instance,
    spans: dict[int, tuple[float, float]] | None,
    count: int | None,
    seed: int,
    jobs: int,
) -> ValueSets:
    """Return the values of the instance, or random ones."""
    if spans is None and count is None:
        return given(_finite(instance, seed, jobs))
    number = count or USUAL_COUNT
    if spans is not None:
        return ValueSets("within", values_within(instance, spans, number, seed))
    ranges = None if is_driven(instance) else ranges_of(instance)
    if ranges is not None:
        return ValueSets("ranges", values_within(instance, ranges, number, seed))
    return about_home(instance, home_of(_finite(instance, seed, jobs)), number, seed)


def _finite(instance: Instance, seed: int, jobs: int) -> SolveResult:
    """Return the poses of an instance; raise an error if they are infinite or incomplete."""
    result = solve(instance, seed=seed, jobs=jobs)
    if result.verdict == "infinite" and not len(result.lone.R):
        message = "the poses are infinitely many: there are no modes to tell apart"
        raise NotFiniteError(message)
    if result.verdict == "incomplete":
        message = "not all poses could be found: gsp solve says what is missing"
        raise IncompleteError(message)
    return result


def _home_side(instance: Instance, seed: int, jobs: int) -> float:
    side = float(np.sign(heights(instance, *home_of(_finite(instance, seed, jobs)))))
    if not side:
        message = "at home the middle of the platform is in the plane of the base: on no side"
        raise ArgumentError(message, "known_side")
    return side
