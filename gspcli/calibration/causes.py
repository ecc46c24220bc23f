"""Why data do not fit a machine: usual mistakes in files, each tried on the data.

Of poses that were measured whole it is known what the machine reads there as it is stated. Data
with a mistake of the file differ from that by much more than the same data without it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.measurements import Measurements, Noise, value_rows
from gspcli.calibration.parameters import Model
from gspcli.geometry.quaternions import (
    apply,
    quaternion_from_rotation,
    rotation_from_quaternion,
)
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: What a file without its mistake differs by from the stated machine, of what it does with it.
_LESS = 1 / 3
#: Data that scatter by less than this part of a typical length have no mistake.
_ROUNDING = 1e-9
#: At most this many rows are tested.
_ROWS = 1000
#: Units that are taken for another: powers of ten, inches and millimetres; degrees and radians.
_LENGTHS = (1000.0, 100.0, 10.0, 25.4)
_ANGLES = (180 / np.pi,)
#: What is read of drives.
_READ = {"crank": "angles of cranks", "slide": "places of slides"}


@dataclass(frozen=True, eq=False)
class Cause:
    """A possible mistake in a file: its message, and the data without it."""

    what: str
    seen: Measurements


def likely_cause(model: Model, seen: Measurements, unit: str) -> str | None:
    """Return the mistake without which the data are nearest to the machine as stated.

    None if no mistake explains them, or no pose was measured whole.

    Parameters
    ----------
    model
        The machine as stated.
    seen
        What was measured, poses in the frame of the base.
    unit
        Of lengths.
    """
    if not seen.whole.any():
        return None
    rows = np.flatnonzero(seen.whole)
    seen = seen.taken(rows[:: -(-len(rows) // _ROWS)])
    before = _apart(model, seen)
    if not before > _ROUNDING * model.length:
        return None
    tried = [(_apart(model, one.seen), one) for one in _causes(model, seen)]
    after, best = min(tried, key=lambda pair: pair[0])
    if not after < _LESS * before:
        return None
    return (
        f"probably {best.what}: the worst column scatters by {before:.2g} {unit} (median) about "
        f"what the machine as stated reads, and by {after:.2g} {unit} without that mistake"
    )


def _apart(model: Model, seen: Measurements) -> float:
    """Return how far the worst column of readings scatters about what the stated machine reads.

    The median of its rows, a length: wrong rows do not count, and an offset does not either.
    """
    seen = seen.taken(seen.whole)
    noise = Noise(1.0, 1 / model.length, 1.0, 1.0, 1.0, 0.0, 0.0)
    T = seen.positions - apply(seen.rotations, seen.pivot)
    with np.errstate(all="ignore"):
        left = value_rows(model, seen.rotations, T, seen, noise).residual
    columns = [column[np.isfinite(column)] for column in left.T]
    medians = [np.median(np.abs(one - np.median(one))) for one in columns if len(one)]
    return float(max(medians, default=np.inf))


def _causes(model: Model, seen: Measurements) -> Iterator[Cause]:
    """Yield data without one mistake each."""
    yield from _units(model, seen)
    yield from _columns(model, seen)
    yield from _poses(seen)


def _units(model: Model, seen: Measurements) -> Iterator[Cause]:
    distances = np.array([kind.is_distance for kind in model.kinds])
    for columns, factors, what in (
        (distances & ~seen.rods, _LENGTHS, "lengths"),
        (~distances, _ANGLES, "angles"),
    ):
        for factor in (*factors, *(1 / one for one in factors)) if columns.any() else ():
            readings = np.where(columns, seen.readings * factor, seen.readings)
            yield Cause(_in_another_unit(f"readings of {what}", factor), _with(seen, readings))
    for factor in (*_LENGTHS, *(1 / one for one in _LENGTHS)):
        yield Cause(
            _in_another_unit("measured positions", factor),
            replace(
                seen,
                positions=seen.positions * factor,
                points={name: one * factor for name, one in seen.points.items()},
            ),
        )
    for sort, factors in (("crank", _ANGLES), ("slide", _LENGTHS)):
        columns = _of_sort(model, sort)
        if seen.drives is None or not columns.any():
            continue
        for factor in (*factors, *(1 / one for one in factors)):
            drives = np.where(columns, seen.drives * factor, seen.drives)
            yield Cause(_in_another_unit(_READ[sort], factor), replace(seen, drives=drives))


def _of_sort(model: Model, sort: str) -> NDArray[np.bool_]:
    """Return which drives are cranks, or slides, shape (m,)."""
    return np.array([drive.sort == sort for drive in model.drives], bool)


def _in_another_unit(what: str, factor: float) -> str:
    how = f"small by {factor:.4g}" if factor > 1 else f"large by {1 / factor:.4g}"
    return f"the {what} are too {how}, as in another unit"


def _columns(model: Model, seen: Measurements) -> Iterator[Cause]:
    for j, k in combinations(np.flatnonzero(~seen.rods).tolist(), 2):
        order = np.arange(len(model.kinds))
        order[[j, k]] = order[[k, j]]
        what = f"the readings {j + 1} and {k + 1} are exchanged"
        yield Cause(what, _with(seen, seen.readings[:, order]))
    for k, kind in enumerate(model.kinds):
        if kind.has_sides:
            sign = np.where(np.arange(len(model.kinds)) == k, -1.0, 1.0)
            yield Cause(
                f"the readings {k + 1} have the wrong sign", _with(seen, seen.readings * sign)
            )
    if seen.drives is not None:
        yield from _drives(model, seen, seen.drives)


def _drives(model: Model, seen: Measurements, readings: Array) -> Iterator[Cause]:
    """Yield data with readings of drives of the other sign, and exchanged ones."""
    for sort, what in _READ.items():
        columns = _of_sort(model, sort)
        at = np.flatnonzero(columns).tolist()
        if not at:
            continue
        turned = np.where(columns, -readings, readings)
        yield Cause(f"the {what} have the wrong sign", replace(seen, drives=turned))
        for k in at:
            sign = np.where(np.arange(len(columns)) == k, -1.0, 1.0)
            name = model.drives[k].drive_name
            one = f"the readings of {name} have the wrong sign"
            yield Cause(one, replace(seen, drives=readings * sign))
        for j, k in combinations(at, 2):
            order = np.arange(len(columns))
            order[[j, k]] = order[[k, j]]
            names = f"{model.drives[j].name} and {model.drives[k].name}"
            exchanged = f"the {what.replace('of', 'of the')} {names} are exchanged"
            yield Cause(exchanged, replace(seen, drives=readings[:, order]))


def _poses(seen: Measurements) -> Iterator[Cause]:
    R, T = seen.rotations, seen.positions
    back = np.swapaxes(R, 1, 2)
    yield Cause(
        "the rotations are transposed (from base to platform)", replace(seen, rotations=back)
    )
    yield Cause(
        "the poses are inverted (those of the base in the platform's frame)",
        replace(seen, rotations=back, positions=-apply(back, T)),
    )
    there = np.asarray(np.isfinite(R).all(axis=(1, 2)))[:, None, None]
    turned = np.where(there, R, np.eye(3))
    scalar_last = rotation_from_quaternion(np.roll(quaternion_from_rotation(turned), 1, axis=1))
    yield Cause(
        "the quaternions have the scalar last",
        replace(seen, rotations=np.where(there, scalar_last, np.nan)),
    )
    for j, k in combinations(range(3), 2):
        order = np.arange(3)
        order[[j, k]] = order[[k, j]]
        what = f"the positions {'xyz'[j]} and {'xyz'[k]} are exchanged"
        yield Cause(what, replace(seen, positions=T[:, order]))


def _with(seen: Measurements, readings: Array) -> Measurements:
    return replace(seen, readings=readings)
