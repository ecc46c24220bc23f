"""From a log of legs and poses to the machine, without a file to start from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.calibrating import calibrate_rows
from gspcli.calibration.convention_choice import (
    EXACT,
    LIKELIER,
    USUAL,
    ConventionFit,
    ambiguous,
    random_starts,
    readings_of,
    units_of,
    words_of,
)
from gspcli.calibration.identification import Identification
from gspcli.calibration.joints import (
    UNKNOWNS,
    Joints,
    all_fitted,
    without_far,
)
from gspcli.calibration.logs import Log, read_log
from gspcli.calibration.measurements import Measurements
from gspcli.calibration.options import PRIOR, Options
from gspcli.errors import ArgumentError, IncompleteError
from gspcli.geometry.building import distance
from gspcli.geometry.building import instance as instance_of
from gspcli.geometry.home_pose import HomePose
from gspcli.geometry.instance import Instance
from gspcli.geometry.primitives import Point
from gspcli.geometry.quaternions import apply, quaternion_from_rotation
from gspcli.spec.document import text_of_table
from gspcli.wording import counted, listed

Array = NDArray[np.float64]

#: This many rows are fitted to find the joints to start from.
_ROWS = 400
#: This many rows more than unknowns of a leg are needed to tell conventions apart.
_SPARE = 2
#: Other joints differ by this part of a length.
_DIFFERENT = 1e-3
#: Joints may have been missed where the linear equations fit this many times better: their residual
#: is a lower bound. With few rows they fit so much better by chance.
_GAP, _BY_CHANCE = 5.0, 10.0
#: Positions that differ by less than this part of their size do not move.
_STILL = 1e-6
#: A constant of each leg is proposed where the lengths fit this many times better with it.
_BETTER = 5.0
_NONE = (
    "no machine with six legs explains the log: look for wrong rows, or try --robust; legs are the "
    "distances from joint to joint"
)


def identify(
    path: str,
    *,
    euler: str | None = None,
    offsets: bool = False,
    pivot: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ignore: tuple[str, ...] = (),
    sigma: dict[str, float] | None = None,
    robust: bool = False,
) -> Identification:
    """Find a hexapod from a log of its legs and poses, without a file to start from.

    Parameters
    ----------
    path
        A CSV file with the columns 1 to 6 (lengths of legs), x y z and a rotation.
    euler
        The order of the axes of rx, ry, rz; found by trying if None.
    offsets
        Whether the lengths of each leg lack a constant, which is estimated.
    pivot
        The point of the platform whose position x, y, z are, in the platform's frame and the
        unit of legs; the frame of the result begins there if it is not given.
    ignore
        Columns that are left out.
    sigma, robust
        As for `calibrate`.

    Raises
    ------
    IncompleteError
        If the log does not determine the machine: what is missing.
    SpecError
        With all mistakes of the file.
    """
    text = text_of_table(path, str(path))
    options = Options(("offsets",) if offsets else (), robust=robust)
    log = read_log(text, str(path), ignore)
    return identify_log(log, euler, np.array(pivot, float), sigma or {}, options)


def identify_log(
    log: Log, euler: str | None, pivot: Array, sigma: dict[str, float], options: Options
) -> Identification:
    """Find a hexapod from a log; as `identify`.

    Parameters
    ----------
    log, euler
        The log, and the order of the axes of its angles if it is known.
    pivot
        The point of the platform that positions are of, shape (3,).
    sigma, options
        As for `calibrate_rows`; offsets are held unless they are to be estimated.
    """
    if euler is not None and log.rotations is not None:
        message = "found whole rotations, expected rx ry rz with an Euler sequence"
        raise ArgumentError(message, "euler")
    offsets = "offsets" in options.estimate
    rows = np.flatnonzero(log.whole)
    _check_rows(log, rows, offsets=offsets)
    some = rows[np.unique(np.linspace(0, len(rows) - 1, _ROWS).astype(int))]
    readings, joints, least = readings_of(log, some, euler, offsets=offsets)
    R, T = readings[0].turns.rotations(log, some), log.positions[some] * readings[0].factor
    kept = np.ones(len(some), bool)
    if options.robust:
        joints, kept = without_far(R, T, log.lengths[some], joints, offsets=offsets)
        left = float(np.sqrt((joints.residual[kept] ** 2).mean()))
        readings[0] = readings[0]._replace(scatter=left)
    best = readings[0]
    found = replace(
        _conventions(log, some, readings, offsets=offsets),
        with_offsets=None if offsets else _with_offsets(log, some, euler, best),
        bound=None if best.scatter <= _gap(len(some), offsets=offsets) * least else least,
    )
    long = float(log.lengths[some].mean())
    if best.scatter > (PRIOR * long if options.prior is None else options.prior):
        raise IncompleteError("\n".join([_NONE, *replace(found, ambiguous=()).doubt]))
    start = _start(log, best, joints, pivot, found.leg_unit, offsets=offsets)
    hold = options.hold if offsets else (*options.hold, "offsets")
    seen = _measured(log, best, pivot)
    try:
        result = calibrate_rows(start, seen, sigma, replace(options, hold=hold))
        if not options.hold_unknown:
            _check_only(R[kept], T[kept], log.lengths[some][kept], joints, kept, offsets=offsets)
    except IncompleteError as error:
        raise IncompleteError("\n".join([str(error), *found.doubt])) from None
    return replace(found, found=result)


def _conventions(
    log: Log, rows: NDArray[np.intp], readings: list[ConventionFit], *, offsets: bool
) -> Identification:
    """Return the conventions that were found, the best first, without a machine yet."""
    best = readings[0]
    leg_unit, place_unit = units_of(log, best.factor)
    return Identification(
        None,
        best.turns,
        leg_unit,
        place_unit,
        bool(log.leg_unit or log.place_unit),
        best.scatter,
        tuple((words_of(one, best, log), one.scatter) for one in readings[1:]),
        tuple(ambiguous(log, rows, readings)),
        offsets,
    )


def _gap(rows: int, *, offsets: bool) -> float:
    """Return how many times better linear equations may fit than joints, by chance."""
    return _GAP * (1 + _BY_CHANCE / (rows - UNKNOWNS - offsets))


def _measured(log: Log, best: ConventionFit, pivot: Array) -> Measurements:
    """Return what was measured, in the convention that was found."""
    turned = np.full((len(log.lengths), 3, 3), np.nan)
    whole = np.flatnonzero(np.isfinite(log.turns).all(axis=1))
    turned[whole] = best.turns.rotations(log, whole)
    return Measurements(log.lengths, turned, log.positions * best.factor, pivot, lines=log.lines)


def _with_offsets(
    log: Log, rows: NDArray[np.intp], euler: str | None, best: ConventionFit
) -> float | None:
    """Return how well lengths fit with a constant of each leg, if that is much better."""
    if best.scatter < USUAL * float(log.lengths[rows].mean()):
        return None
    if len(rows) < UNKNOWNS + 1 + _SPARE:
        return None
    other = readings_of(log, rows, euler, offsets=True)[0][0]
    return other.scatter if other.scatter * _BETTER < best.scatter else None


def _check_rows(log: Log, rows: NDArray[np.intp], *, offsets: bool) -> None:
    """Raise if there are fewer rows than unknowns of a leg."""
    poses = np.hstack((log.positions, log.turns))[rows]
    places = log.positions[rows]
    if len(rows) and np.ptp(places, axis=0).max() <= _STILL * np.abs(places).max(initial=0.0):
        message = "positions do not change: add poses that move the platform, along x, y and z"
        raise IncompleteError(message)
    found, wanted = len(np.unique(poses, axis=0)), UNKNOWNS + offsets + _SPARE
    if found < wanted:
        message = (
            f"found {counted(found, 'different pose')} with all six lengths, expected at least "
            f"{wanted} to find a machine without a file to start from: add rows, or give SPEC"
        )
        raise IncompleteError(message)


def _start(
    log: Log, best: ConventionFit, joints: Joints, pivot: Array, unit: str, *, offsets: bool
) -> Instance:
    """Return the machine with the joints found, at the pose of the first whole row."""
    first = np.flatnonzero(log.whole)[:1]
    R = best.turns.rotations(log, first)
    T = log.positions[first] * best.factor - apply(R, pivot)
    rows = []
    for numbers, length in zip(
        joints.numbers.tolist(), log.lengths[first[0]].tolist(), strict=True
    ):
        rows.append(
            distance(
                Point((np.array(numbers[:3]) + pivot).tolist()),
                Point(numbers[3:6]),
                length,
                offset=numbers[6] if offsets else None,
            )
        )
    made = instance_of(rows, length=unit, name="Machine found from its log")
    # Products with the factor of units have digits of rounding.
    position, turn = (
        [float(f"{number:.12g}") for number in part]
        for part in (T[0].tolist(), quaternion_from_rotation(R)[0].tolist())
    )
    home = HomePose(position, turn)
    return replace(made, home=home)


def _check_only(
    R: Array,
    T: Array,
    lengths: Array,
    joints: Joints,
    kept: NDArray[np.bool_],
    *,
    offsets: bool,
) -> None:
    """Raise if other joints of a leg explain its lengths as well; found from starts at random."""
    long = float(lengths.mean())
    found, left = all_fitted(R, T, lengths, random_starts(long), offsets=offsets)
    floor = (EXACT * long) ** 2 * len(lengths)
    squares = np.maximum((left**2).sum(axis=-1), floor)
    least = np.maximum((joints.residual[kept] ** 2).sum(axis=0), floor)
    alike = len(lengths) * np.log(squares / least) < LIKELIER
    apart = np.abs(found - joints.numbers)[..., :6].max(axis=-1) > _DIFFERENT * long
    legs = sorted({int(leg) + 1 for _, leg in np.argwhere(alike & apart)})
    if legs:
        what = "leg" if len(legs) == 1 else "legs"
        message = (
            f"other joints of {what} {listed(map(str, legs), 'and')} explain the log as well: "
            "add poses that move and turn the platform, along and about all axes"
        )
        raise IncompleteError(message)
