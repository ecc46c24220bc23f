"""In which convention a log is written: the one in which lengths fit best, and those as good."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.conventions import FACTORS, Turns, turns_of
from gspcli.calibration.joints import Joints, fitted, left_of_lengths, linear_starts
from gspcli.calibration.logs import Log
from gspcli.geometry.lengths import METRES

Array = NDArray[np.float64]

#: How many rows are used in linear equations, and how many of the best conventions are fitted.
_FIRST_ROWS, _FITTED = 200, 16
#: Of conventions, or machines, of which the data are not a thousand times as likely none is chosen.
LIKELIER = float(2 * np.log(1000))
#: The residuals of exact data, and of usual logs, in lengths.
EXACT, USUAL = 1e-12, 1e-4
#: This many starts at random, for this many conventions, where linear equations do not decide.
_STARTS, _TRIED_AGAIN = 12, 4
#: Legs longer than this are in millimetres if nothing says their unit.
_MILLIMETRES = 10.0


class ConventionFit(NamedTuple):
    """A convention of a log, and how well it fits."""

    turns: Turns
    factor: float
    scatter: float
    """Root mean square of the residuals of the lengths, in their unit."""
    place: int
    """Where it is among those that are tried, usual ones first."""


def readings_of(
    log: Log, rows: NDArray[np.intp], euler: str | None, *, offsets: bool
) -> tuple[list[ConventionFit], Joints, float]:
    """Return conventions, the best first, its joints, and what any joints leave at least.

    The last is by linear equations, up to noise.
    """
    factors = _factors(log)
    first = rows[np.unique(np.linspace(0, len(rows) - 1, _FIRST_ROWS).astype(int))]
    tried = []
    for place, turns in enumerate(turns_of(log, euler)):
        R, T = turns.rotations(log, first), log.positions[first]
        left = left_of_lengths(R, T, log.lengths[first], factors, offsets=offsets)
        tried += [
            ConventionFit(turns, factor, one, place)
            for factor, one in zip(factors.tolist(), left.tolist(), strict=True)
        ]
    tried.sort(key=lambda one: one.scatter)
    found = _fits(log, rows, tried[:_FITTED], offsets=offsets, random=False)
    least, long = min(one.scatter for one, _ in found), float(log.lengths[rows].mean())
    if least > USUAL * long:
        # Linear equations may tell too little to start from.
        again = [one for one, _ in sorted(found, key=lambda pair: pair[0].scatter)[:_TRIED_AGAIN]]
        again += [one for one in tried[:_TRIED_AGAIN] if one.place not in {a.place for a in again}]
        found += _fits(log, rows, again, offsets=offsets, random=True)
        found = list(
            {
                (one.place, one.factor): (one, joints)
                for one, joints in sorted(found, key=lambda pair: -pair[0].scatter)
            }.values()
        )
        least = min(one.scatter for one, _ in found)
    # Of equal ones the more usual is taken.
    count = 6 * len(rows)
    alike = [pair for pair in found if _as_good(pair[0].scatter, least, count)]
    best = min(alike, key=lambda pair: (pair[0].turns.unusual, pair[0].place))
    rest = sorted((one for one, _ in found if one != best[0]), key=lambda one: one.scatter)
    return [best[0], *rest], best[1], tried[0].scatter


def _fits(
    log: Log, rows: NDArray[np.intp], tried: list[ConventionFit], *, offsets: bool, random: bool
) -> list[tuple[ConventionFit, Joints]]:
    """Return conventions with their scatter after a fit, and the joints."""
    lengths = log.lengths[rows]
    freedom = max(lengths.size - 6 * (7 if offsets else 6), 1)
    long = float(lengths.mean())
    found = []
    for one in tried:
        R, T = one.turns.rotations(log, rows), log.positions[rows] * one.factor
        starts = linear_starts(R, T, lengths, offsets=offsets)
        if random:
            starts = np.concatenate((starts, random_starts(long)))
        joints = fitted(R, T, lengths, starts, offsets=offsets)
        scatter = max((joints.squares / freedom) ** 0.5, EXACT * long)
        found.append((one._replace(scatter=scatter), joints))
    return found


def random_starts(long: float) -> Array:
    """Return joints at random, within about the length of legs, shape (k, 6, 7)."""
    starts = np.zeros((_STARTS, 6, 7))
    starts[..., :6] = long * np.random.default_rng(0).normal(size=(_STARTS, 6, 6))
    return starts


def _as_good(scatter: float, least: float, count: int) -> bool:
    """Whether normal residuals with one scatter are about as likely as with the least."""
    return 2 * count * float(np.log(scatter / least)) < LIKELIER


def _factors(log: Log) -> Array:
    """Return what positions may have to be multiplied by, to be in the unit of lengths."""
    if log.leg_unit and log.place_unit:
        return np.array([METRES[log.place_unit.lower()] / METRES[log.leg_unit.lower()]])
    return np.array(list(FACTORS))


def ambiguous(log: Log, rows: NDArray[np.intp], readings: list[ConventionFit]) -> list[str]:
    """Return the conventions that fit as well as the best and differ in the log."""
    best = readings[0]
    least = min(one.scatter for one in readings)
    here = best.turns.rotations(log, rows)
    found = []
    for one in readings[1:]:
        if not _as_good(one.scatter, least, 6 * len(rows)):
            continue
        apart = np.abs(one.turns.rotations(log, rows) - here).max()
        if apart > EXACT or one.factor != best.factor:
            found.append(words_of(one, best, log))
    return found


def words_of(one: ConventionFit, best: ConventionFit, log: Log) -> str:
    """Return a convention in words, its units if they differ from the best."""
    words = one.turns.words()
    if one.factor != best.factor:
        legs, places = units_of(log, one.factor)
        words += f", legs in {legs} and positions in {places}"
    return words


def units_of(log: Log, factor: float) -> tuple[str, str]:
    """Return the units of legs and of positions, as the heading says them or by their sizes."""
    if log.leg_unit and log.place_unit:
        return log.leg_unit, log.place_unit
    for known, size in ((log.leg_unit, factor), (log.place_unit, 1 / factor)):
        if known:
            wanted = METRES[known.lower()] * size
            other = next(
                (unit for unit, metres in METRES.items() if abs(metres / wanted - 1) < 1e-9),
                f"{size:g} {known}",
            )
            return (known, other) if log.leg_unit else (other, known)
    if factor != 1.0:
        return FACTORS[factor]
    unit = "mm" if float(np.nanmean(np.abs(log.lengths))) > _MILLIMETRES else "m"
    return unit, unit
