"""Whether a fit can be believed, and ten mistakes of files that are recognized where it cannot.

Right data are doubted seldom: chi-squared is above its limit in one of a thousand, and a number is
three times as far from what is stated as it is known before. A mistake is named only where data
without it are as near to the machine as it is known before; otherwise no cause is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.fitting import Fit
from gspcli.calibration.measurements import Measurements, Noise, value_rows
from gspcli.calibration.numbers import FileNumbers
from gspcli.calibration.parameters import Model
from gspcli.geometry.euler import euler_from_rotation, rotation_from_euler
from gspcli.geometry.quaternions import (
    apply,
    quaternion_from_rotation,
    rotation_from_quaternion,
)
from gspcli.wording import counted

Array = NDArray[np.float64]

#: One of a thousand standard normal numbers is larger.
_SELDOM = 3.0902
#: A number may differ from what is stated by this many times what it is known to before.
_FAR = 3.0
#: This part of the rows may have outliers.
_MANY = 0.25
#: Data without their mistake scatter by this part of what they do with it at most, and by less than
#: this many times what the machine is known to before.
_LESS, _KNOWN = 1 / 3, 3.0
#: At most this many rows are tested.
_ROWS = 1000
#: Units that are taken for another: powers of ten, inches and millimetres; degrees and radians.
_LENGTHS = (1000.0, 100.0, 10.0, 25.4)
_ANGLES = (180 / np.pi,)

Mended = Iterator[tuple[str, Measurements]]


def quantile(freedom: int, z: float) -> float:
    """Return a quantile of chi-squared, by that of the normal law (Wilson and Hilferty 1931)."""
    part = 2 / (9 * freedom)
    found: float = freedom * max(1 - part + z * part**0.5, 0.0) ** 3
    return found


def doubts(
    found: Fit,
    numbers: FileNumbers,
    stated: FileNumbers,
    noise: Noise,
    scatter: float,
    prior: float,
    outliers: int,
    unit: str,
) -> tuple[str, ...]:
    """Return why the data do not fit the machine, in sentences; none if they do.

    Parameters
    ----------
    found
        The fit.
    numbers, stated
        The numbers of the file for the model found, and as they are stated.
    noise, scatter
        The deviations, and what they are multiplied by; one if they were stated.
    prior
        How well the numbers are known before, a length.
    outliers
        How many rows have numbers that are left out.
    unit
        Of lengths.
    """
    sentences = [] if found.converged else ["the fit did not come to an end"]
    chi, freedom, rows = float(np.nansum(found.residual**2)), found.freedom, len(found.residual)
    if outliers > _MANY * rows:
        sentences.append(f"{outliers} of {rows} rows are outliers by more than 5 sigma")
    if scatter == 1.0 and freedom > 0 and chi > (limit := quantile(freedom, _SELDOM)):
        sentences.append(
            f"chi-squared is {chi:.4g} of {freedom}: with the sigmas as stated it is above "
            f"{limit:.4g} once in 1000 times"
        )
    if scatter != 1.0 and noise.value * scatter > prior:
        sentences.append(
            f"the scatter ({noise.value * scatter:.2g} {unit}) is more than what the numbers "
            f"are known to before ({prior:.2g} {unit})"
        )
    ratio = np.abs(numbers.values - stated.values) / _tolerances(found, numbers, prior)
    far = np.flatnonzero(ratio > _FAR)
    if len(far):
        worst = int(far[ratio[far].argmax()])
        change = numbers.values[worst] - stated.values[worst]
        more = f", and {counted(len(far) - 1, 'other number')} too" if len(far) > 1 else ""
        sentences.append(
            f"{numbers.names[worst]} changes by {change:.3g}, {ratio[worst]:.2g} times what "
            f"it is known to before (--prior {prior:.2g} {unit}){more}"
        )
    return tuple(sentences)


def _tolerances(found: Fit, numbers: FileNumbers, prior: float) -> Array:
    """Return how well each number of the file is known before; infinite for those of frames."""
    model = found.model
    by = np.linalg.norm(numbers.slopes[:, model.free] * model.sizes[model.free], axis=1) * prior
    by[(numbers.slopes[:, model.geometry + 12 :] != 0).any(axis=1)] = np.inf
    return np.where(by > 0, by, np.inf)


def likely_cause(model: Model, seen: Measurements, prior: float, unit: str) -> str | None:
    """Return the mistake without which the data are nearest to the machine as stated.

    None if no mistake of `RULES` explains them, or no pose was measured whole.

    Parameters
    ----------
    model
        The machine as stated.
    seen
        What was measured, poses in the frame of the base.
    prior
        How well the machine is known before, a length.
    unit
        Of lengths.
    """
    if not seen.whole.any():
        return None
    rows = np.flatnonzero(seen.whole)
    seen = seen.taken(rows[:: -(-len(rows) // _ROWS)])
    before = _apart(model, seen)
    mended = [(_apart(model, one), what) for rule in RULES for what, one in rule(model, seen)]
    after, what = min(mended, key=lambda pair: pair[0])
    if not after < min(_LESS * before, _KNOWN * prior):
        return None
    return (
        f"probably {what}: the worst column scatters by {before:.2g} {unit} (median) about what "
        f"the machine as stated reads, and by {after:.2g} {unit} without that mistake"
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


def _both(factors: tuple[float, ...], what: str) -> Iterator[tuple[float, str]]:
    """Yield factors and their inverses with the mistake that each mends."""
    for factor in factors:
        yield factor, f"{what} are too small by {factor:.4g}, as in another unit"
        yield 1 / factor, f"{what} are too large by {factor:.4g}, as in another unit"


def _readings(model: Model, seen: Measurements) -> Mended:
    distances = np.array([kind.is_distance for kind in model.kinds])
    for columns, factors, what in (
        (distances & ~seen.rods, _LENGTHS, "the readings of lengths"),
        (~distances, _ANGLES, "the readings of angles"),
    ):
        for factor, said in _both(factors, what) if columns.any() else ():
            yield said, replace(seen, readings=seen.readings * np.where(columns, factor, 1.0))


def _positions(model: Model, seen: Measurements) -> Mended:
    del model
    for factor, said in _both(_LENGTHS, "the measured positions"):
        yield said, replace(seen, positions=seen.positions * factor)


def _rotations(model: Model, seen: Measurements) -> Mended:
    """Yield data whose rx ry rz were radians, read as degrees."""
    del model
    if seen.euler:
        angles = np.rad2deg(euler_from_rotation(seen.euler, seen.rotations))
        turned = rotation_from_euler(seen.euler, angles)
        yield "rx, ry, rz are radians, not degrees", replace(seen, rotations=turned)


def _drives(model: Model, seen: Measurements) -> Mended:
    """Yield data with the cranks, or the slides, in another unit or with the other sign."""
    for sort, what, factors in (
        ("crank", "the angles of cranks", _ANGLES),
        ("slide", "the places of slides", _LENGTHS),
    ):
        columns = np.array([drive.sort == sort for drive in model.drives], bool)
        if seen.drives is None or not columns.any():
            continue
        for factor, said in (*_both(factors, what), (-1.0, f"{what} have the wrong sign")):
            yield said, replace(seen, drives=seen.drives * np.where(columns, factor, 1.0))


def _exchanged_readings(model: Model, seen: Measurements) -> Mended:
    for j, k in combinations(np.flatnonzero(~seen.rods).tolist(), 2):
        readings = seen.readings[:, _swap(len(model.kinds), j, k)]
        yield f"the readings {j + 1} and {k + 1} are exchanged", replace(seen, readings=readings)


def _exchanged_drives(model: Model, seen: Measurements) -> Mended:
    for j, k in combinations(range(len(model.drives)), 2):
        one, other = model.drives[j], model.drives[k]
        if seen.drives is not None and one.sort == other.sort:
            drives = seen.drives[:, _swap(len(model.drives), j, k)]
            names = f"{one.drive_name} and {other.drive_name}"
            yield f"the readings of {names} are exchanged", replace(seen, drives=drives)


def _exchanged_positions(model: Model, seen: Measurements) -> Mended:
    del model
    for j, k in combinations(range(3), 2):
        what = f"the positions {'xyz'[j]} and {'xyz'[k]} are exchanged"
        yield what, replace(seen, positions=seen.positions[:, _swap(3, j, k)])


def _transposed(model: Model, seen: Measurements) -> Mended:
    del model
    back = np.swapaxes(seen.rotations, 1, 2)
    yield "the rotations are transposed (from base to platform)", replace(seen, rotations=back)


def _inverted(model: Model, seen: Measurements) -> Mended:
    del model
    back = np.swapaxes(seen.rotations, 1, 2)
    yield (
        "the poses are inverted (those of the base in the platform's frame)",
        replace(seen, rotations=back, positions=-apply(back, seen.positions)),
    )


def _scalar_last(model: Model, seen: Measurements) -> Mended:
    del model
    rolled = np.roll(quaternion_from_rotation(seen.rotations), 1, axis=1)
    turned = rotation_from_quaternion(rolled)
    yield "the quaternions have the scalar last", replace(seen, rotations=turned)


def _swap(count: int, j: int, k: int) -> NDArray[np.intp]:
    order = np.arange(count)
    order[[j, k]] = k, j
    return order


#: Ten mistakes of files, each as the data without it. All poses are whole.
RULES: tuple[Callable[[Model, Measurements], Mended], ...] = (
    _readings,
    _positions,
    _rotations,
    _drives,
    _exchanged_readings,
    _exchanged_drives,
    _exchanged_positions,
    _transposed,
    _inverted,
    _scalar_last,
)
