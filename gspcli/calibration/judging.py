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

from gspcli.calibration.fitting import Fit, reduced
from gspcli.calibration.measurements import Measurements, Noise, alike, value_rows
from gspcli.calibration.model import FileNumbers, Model
from gspcli.geometry.euler import euler_from_rotation, rotation_from_euler
from gspcli.geometry.quaternions import (
    apply,
    quaternion_from_rotation,
    rotation_from_quaternion,
    rotation_from_vector,
    vector_from_rotation,
)
from gspcli.records import dataclass
from gspcli.wording import counted, listed

# Which numbers data determine: the null space of the derivatives, in words, and what to measure.
#
# Along some directions of the parameters nothing that was measured changes, or less than is known
# before. A basis of them in which each has a number that all others lack names the numbers. With an
# unknown measuring device and target twelve directions only say where the frames are.


#: A motion of a frame is unknown if it agrees with an unknown direction up to this: the first where
#: derivatives vanish, the second where noise hides it.
_EXACT, _HIDDEN = 1e-5, 0.1
#: A direction is described by at most this many numbers, those above a part of the largest, and at
#: most this many directions are.
_SHOWN, _PART, _MOST = 4, 0.2, 3
#: Random poses that show what a sort of measurements determines: how many, turned (radians) and
#: shifted (typical lengths) by how much.
_POSES, _TURN, _SHIFT = 60, 0.4, 0.3
#: Poses that differ by less than these (radians; of a typical length) do not differ.
_SAME_TURN, _SAME_PLACE = 0.01, 1e-3


@dataclass(frozen=True)
class Unknowns:
    """What data do not determine.

    Attributes
    ----------
    count
        Of how many independent directions.
    frames
        How many of these only say where the frames of base and platform are; with an unknown
        measuring device and target they are kept as stated.
    sentences
        Which the others are, in words.
    """

    count: int
    frames: int
    sentences: tuple[str, ...]

    @property
    def missing(self) -> int:
        """How many directions are unknown that should be known."""
        return self.count - self.frames


def identifiable(found: Fit, seen: Measurements) -> Unknowns:
    """Return the directions that the data of a fit do not determine."""
    model, rows = found.model, found.directions[~found.known]
    if not len(rows):
        return Unknowns(0, 0, ())
    rounding = found.singular[~found.known].max() <= 1e-9 * found.singular.max()
    limit = _EXACT if rounding else _HIDDEN
    left, frames = rows.copy(), 0
    for motion in _frame_motions(model):
        scaled = (motion / model.sizes)[model.free]
        direction = scaled / np.linalg.norm(scaled)
        part = left @ direction
        hidden = np.linalg.norm(direction - rows.T @ (rows @ direction)) <= limit
        if hidden and np.linalg.norm(part) > 0.1:
            frames += 1
            left = np.linalg.svd(part[None])[2][1:] @ left
    sentences = []
    if unread := _unread(seen):
        sentences.append(f"no row has a reading of {listed(map(str, unread), 'and')}")
    # With fewer numbers than are to be estimated any combination is unknown.
    enough = found.freedom + int(found.known.sum()) >= int(model.free.sum())
    if len(left) and enough:
        names = [name for name, free in zip(model.names, model.free, strict=True) if free]
        sentences += [_combination(row, names) for row in _sparse(left)[:_MOST]]
        if len(left) > _MOST:
            sentences.append(f"{len(left) - _MOST} more combinations of them")
    return Unknowns(len(rows), frames, tuple(sentences))


def _unread(seen: Measurements) -> list[int]:
    """Return the constraints, from 1, that have no reading in any row."""
    return (np.flatnonzero(~np.isfinite(seen.readings).any(axis=0)) + 1).tolist()


def _frame_motions(model: Model) -> Iterator[Array]:
    """Yield how all parameters change as a body moves with its device or target, each (p,)."""
    if not model.with_frames:
        return
    A, at = rotation_from_vector(model.frames[:3]), model.geometry + 12
    for axis in np.eye(3):
        for body in ("base", "platform"):
            for turning in (False, True):
                change = np.zeros(len(model.free))
                for block, span in model.spans():
                    if block.body == body:
                        shift = np.cross(axis, block.point) if turning else axis
                        turn = axis if turning else np.zeros(3)
                        parts = (block.shifts @ shift, block.tilts @ turn)
                        change[span][: len(block.shifts) + len(block.tilts)] = np.concatenate(parts)
                frames = change[at:]
                if body == "base":
                    # A body that moves by xi looks the same from a device moved by A xi A^-1.
                    turn, shift = (-A @ axis, np.zeros(3)) if turning else (np.zeros(3), -A @ axis)
                    frames[:3], frames[3:6] = _vector_rate(model.frames[:3], turn), shift
                else:
                    shift = np.cross(axis, model.frames[9:]) if turning else axis
                    turn = axis if turning else np.zeros(3)
                    frames[6:9], frames[9:] = _vector_rate(model.frames[6:9], turn), shift
                yield change


def _vector_rate(vector: Array, omega: Array) -> Array:
    """Return how a rotation vector changes when its rotation turns by omega from the left."""
    step = 1e-6
    ends = [
        vector_from_rotation(rotation_from_vector(s * step * omega) @ rotation_from_vector(vector))
        for s in (1, -1)
    ]
    rate: Array = (ends[0] - ends[1]) / (2 * step)
    return rate


def _sparse(rows: Array) -> Array:
    """Return rows that span the same space, each with a number that is zero in all other rows."""
    rows = rows.copy()
    for k in range(len(rows)):
        column = int(np.abs(rows[k:]).max(axis=0).argmax())
        best = k + int(np.abs(rows[k:, column]).argmax())
        rows[[k, best]] = rows[[best, k]]
        rows[k] /= rows[k, column]
        others = np.arange(len(rows)) != k
        rows[others] -= np.outer(rows[others, column], rows[k])
    return rows


def _combination(row: Array, names: list[str]) -> str:
    large = np.abs(row) > _PART * np.abs(row).max()
    shown: list[str] = [names[j] for j in np.argsort(-np.abs(row))[:_SHOWN].tolist() if large[j]]
    more = " among others" if int(large.sum()) > _SHOWN else ""
    if len(shown) == 1 and not more:
        return shown[0]
    return f"a combination of {listed(shown, 'and')}{more}"


def advice(found: Fit, seen: Measurements) -> str:
    """Return what to measure so that more is known."""
    model = found.model
    if unread := _unread(seen):
        return f"give readings of {listed(map(str, unread), 'and')}, or hold what only they use"
    turns = vector_from_rotation(found.R @ found.R[0].T)
    turned = np.linalg.svd(turns, compute_uv=False) > _SAME_TURN
    wanted, limit = int(model.free.sum()), ""
    if not model.drives and not model.with_frames:
        most = _rank_of_sort(found, seen, turning=bool(turned[0]))
        if most < wanted:
            limit = f"poses of this sort tell at most {most}, however many: "
    if turned.sum() < 2:
        return f"{limit}measure poses that turn the platform, about axes that differ"
    places = np.linalg.norm(found.T - found.T.mean(axis=0), axis=1).max(initial=0.0)
    if places < _SAME_PLACE * model.length:
        return f"{limit}measure poses that move the platform, along x, y and z"
    has_turns, has_places = (bool(np.isfinite(a).any()) for a in (seen.rotations, seen.positions))
    if limit:
        if seen.points and not any(name in seen.targets for name in seen.points):
            return f"{limit}say where points are on the platform (--target), or measure whole poses"
        if has_places and not has_turns:
            return f"{limit}measure rotations, too, or three points of the platform"
        what = "positions" if has_turns or len(seen.inclinations) else "whole poses"
        return f"{limit}measure {what} of the platform, too"
    rows = np.isfinite(found.residual).sum(axis=1)
    lacking = wanted - found.freedom - int(found.known.sum())
    if lacking > 0:
        each = max(int(rows.max(initial=7)) - 6, 1)
        return f"measure at least {counted(-(-lacking // each), 'more pose')}"
    return "measure poses farther apart, or more exactly; --plan N says which"


def _rank_of_sort(found: Fit, seen: Measurements, *, turning: bool) -> int:
    """Return how many numbers measurements of these sorts tell at many random poses, a rank."""
    model, random = found.model, np.random.default_rng(0)
    size = _TURN if turning else 0.0
    turns = rotation_from_vector(size * random.normal(size=(_POSES, 3)))
    T = found.T.mean(axis=0) + _SHIFT * model.length * random.uniform(-1, 1, (_POSES, 3))
    there = alike(seen, turns @ found.R[0], T, None)
    slopes = reduced(model, turns @ found.R[0], T, there, Noise.usual(model.length)).slopes
    singular = np.linalg.svd(slopes * model.sizes[model.free], compute_uv=False)
    return int((singular > _EXACT * singular.max(initial=0.0)).sum())


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
