"""Separations: the differences of readings at modes, in standard deviations, for the worst pair.

Two modes whose readings differ by d standard deviations of the sensor are confused with the
probability Phi(-d / 2) if the nearer one is taken. Sensors that are read together have independent
errors: their differences add up as squares.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import vector_from_rotation
from gspcli.records import dataclass
from gspcli.sensing.mode_sets import ModeSets
from gspcli.sensing.sensor_kinds import Sensor

Array = NDArray[np.float64]
Index = NDArray[np.int64]

#: Decimals of standard deviations up to which equal ones are compared.
_DECIMALS = 6


def differences(sets: ModeSets, sensors: Sequence[Sensor], sigmas: Array) -> Array:
    """Return the differences of the readings at pairs of modes.

    Returns
    -------
    Array
        Standard deviations, shape (s, b, p) for s sensors, b sets of values and the p pairs of
        `pairs_of`; infinite where there is no such pair.
    """
    first, second = pairs_of(sets)
    there = (sets.numbers[:, first] > 0) & (sets.numbers[:, second] > 0)
    found = np.empty((len(sensors), *there.shape))
    for k, (sensor, sigma) in enumerate(zip(sensors, sigmas, strict=True)):
        read = sensor.read(sets.instance, sets.R, sets.T)
        apart = sensor.apart(sets.instance, read[:, first], read[:, second])
        found[k] = np.where(there, apart / sigma, np.inf)
    return found


def pairs_of(sets: ModeSets) -> tuple[Index, Index]:
    """Return the places of the first and the second mode of all pairs in a set, each (p,)."""
    return np.triu_indices(sets.numbers.shape[1], 1)


def told_alike(values: Array) -> Array:
    """Return differences without rounding errors: symmetry makes many of them equal."""
    return np.asarray(np.round(values, _DECIMALS))


@dataclass(frozen=True, eq=False)
class Separations:
    """The separations of s sensors at n sets of values.

    Attributes
    ----------
    least
        The smallest difference of the readings at a pair of modes, in standard deviations, shape
        (s, n); infinite if there is at most one mode.
    worst
        The numbers of these modes, 0 where there are none, shape (s, n, 2).
    modes
        The number of modes, shape (n,).
    complete
        Whether all poses are known, shape (n,).
    closest
        The largest difference by any sensor of the pair for which this number is smallest, shape
        (n,).
    closest_modes
        The numbers of that pair, shape (n, 2).
    distance, turn
        The distance of that pair: the largest displacement of a point of the platform, in the unit
        of length, and the angle of the turn, in radians; shape (n,).
    """

    least: Array
    worst: Index
    modes: Index
    complete: NDArray[np.bool_]
    closest: Array
    closest_modes: Index
    distance: Array
    turn: Array


def separations(
    blocks: Iterable[ModeSets], sensors: Sequence[Sensor], sigmas: Array
) -> Separations:
    """Return the separations of sensors at sets of values, in their order."""
    parts = [_of_block(sets, sensors, sigmas) for sets in blocks]
    fields = zip(*parts, strict=True)
    least, worst, *others = fields
    return Separations(
        np.concatenate(least, axis=1),
        np.concatenate(worst, axis=1),
        *(np.concatenate(part) for part in others),
    )


def _of_block(
    sets: ModeSets, sensors: Sequence[Sensor], sigmas: Array
) -> tuple[NDArray[np.generic], ...]:
    apart = differences(sets, sensors, sigmas)
    first, second = pairs_of(sets)
    rows = np.arange(len(sets.numbers))
    if not len(first):
        nothing = np.full((len(sensors), len(rows)), np.inf)
        none = np.zeros((len(rows), 2), int)
        worst = np.zeros((*nothing.shape, 2), int)
        far = np.full(len(rows), np.inf)
        return nothing, worst, sets.count, sets.complete, far, none, far, far
    at = told_alike(apart).argmin(axis=2)
    least = np.take_along_axis(apart, at[..., None], axis=2)[..., 0]
    pairs = np.stack((sets.numbers[:, first], sets.numbers[:, second]), axis=-1)
    worst = np.where(np.isfinite(least)[..., None], pairs[rows, at], 0)
    best = apart.max(axis=0)
    near = told_alike(best).argmin(axis=1)
    closest = best[rows, near]
    numbers = np.where(np.isfinite(closest)[:, None], pairs[rows, near], 0)
    distance, turn = _apart(sets, first[near], second[near])
    return least, worst, sets.count, sets.complete, closest, numbers, distance, turn


def _apart(sets: ModeSets, first: Index, second: Index) -> tuple[Array, Array]:
    """Return the distance of two modes of each set (`Separations.distance`, `turn`)."""
    rows = np.arange(len(first))
    there = (sets.numbers[rows, first] > 0) & (sets.numbers[rows, second] > 0)
    (R, T), (Q, S) = ((sets.R[rows, k], sets.T[rows, k]) for k in (first, second))
    points = Arrangement.of(sets.instance).y
    way = np.linalg.norm(points @ np.swapaxes(R - Q, 1, 2) + (T - S)[:, None], axis=2).max(axis=1)
    turn = np.linalg.norm(vector_from_rotation(np.swapaxes(Q, 1, 2) @ R), axis=1)
    return np.where(there, way, np.inf), np.where(there, turn, np.inf)


@dataclass(frozen=True, eq=False)
class BestPair:
    """The two sensors that together distinguish modes best.

    Attributes
    ----------
    sensors
        Their indices.
    least
        As in `Separations`, shape (n,).
    """

    sensors: tuple[int, int]
    least: Array


def best_pair(
    blocks: Sequence[ModeSets],
    sensors: Sequence[Sensor],
    sigmas: Array,
    need: float,
    told: NDArray[np.bool_],
) -> BestPair | None:
    """Return the two sensors that suffice for most of the sets.

    Of several pairs the one with the largest mean of the worst difference is taken, where
    differences above ten times the need count as that; then the one with the largest mean without
    this limit. None if there are fewer than two sensors.
    """
    if len(sensors) < 2:
        return None
    first, second = np.triu_indices(len(sensors), 1)
    share, surety, total = np.zeros((3, len(first)))
    begin = 0
    for sets in blocks:
        rows = told[begin : begin + len(sets.numbers)]
        begin += len(rows)
        least = _of_pairs(differences(sets, sensors, sigmas)[:, rows])
        share += (least >= need).sum(axis=1)
        surety += np.minimum(least, 10 * need).sum(axis=1)
        total += least.sum(axis=1)
    means = [told_alike(part / told.sum()) for part in (total, surety)]
    best = int(np.lexsort((-means[0], -means[1], -share))[0])
    pair = int(first[best]), int(second[best])
    two, deviations = [sensors[k] for k in pair], sigmas[list(pair)]
    parts = [_of_pairs(differences(sets, two, deviations))[0] for sets in blocks]
    return BestPair(pair, np.concatenate(parts))


def _of_pairs(apart: Array) -> Array:
    """Return the least difference of each two sensors, shape (pairs of sensors, b)."""
    squares = apart**2
    rows = [
        np.sqrt((squares[k] + squares[k + 1 :]).min(axis=2, initial=np.inf))
        for k in range(len(squares) - 1)
    ]
    return np.concatenate(rows)
