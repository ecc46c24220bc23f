"""Where a fit starts: poses from what is known of them, and frames of device and target.

A pose that was measured whole is its own start. Of others with six readings all real poses for the
readings with the stated geometry are found, and the one is taken that agrees best with what was
measured. Rows of less start at the pose of another row, or a mode of the stated values, from which
least squares lead to what they tell.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.fitting import Fit, fit
from gspcli.calibration.measurements import Measurements, Noise, WhitenedRows, value_rows
from gspcli.calibration.model import Model
from gspcli.errors import GspError
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.least_squares import descend
from gspcli.geometry.machine import Machine
from gspcli.geometry.numbers import Number
from gspcli.geometry.quaternions import apply, rotation_from_vector, vector_from_rotation
from gspcli.geometry.readings import values_of, without_corrections
from gspcli.solver import SolveResult, solve, solve_values
from gspcli.solver.poses import PoseSet

Array = NDArray[np.float64]
#: Poses R, T of a row.
Poses = tuple[Array, Array]

#: Rows with fewer numbers start at this many poses of others and take this many steps; in the end
#: they may be off by this part of a typical length.
_STARTS, _STEPS, _AGREES = 8, 30, 0.05


class FitStart(NamedTuple):
    """Where a fit starts: the model, with its frames, and poses, (n, 3, 3) and (n, 3)."""

    model: Model
    R: Array
    T: Array
    home: str = ""
    """Which pose was taken for home and why, in words; empty if none was needed, or it is stated.
    """


def started(instance: Instance, model: Model, seen: Measurements, noise: Noise) -> FitStart:
    """Return the model and the poses to start from.

    With unknown frames the pose of a row is the one nearest to home. If no home is stated all real
    poses for the stated values are tried, and the one is taken whose poses are nearest to those
    measured.

    Raises
    ------
    GspError
        If no pose agrees with a row.
    """
    read = np.asarray(np.isfinite(seen.readings).all(axis=1))
    if seen.drives is not None:
        read &= np.isfinite(seen.drives).all(axis=1)
    R, T = seen.rotations.copy(), seen.positions - apply(seen.rotations, seen.pivot)
    if not model.with_frames:
        rest = ~seen.whole & read
        if rest.any():
            some = seen.taken(rest)
            R[rest], T[rest] = _agreeing(model, some, _modes(instance, model, some, noise), noise)
        return FitStart(model, *_with_less(instance, model, seen, R, T, noise, ~seen.whole & ~read))
    if not read.any():
        message = "no row has all six readings: with unknown frames some rows must have them"
        raise GspError(message)
    some = seen.taken(read)
    first, home = _from_home(instance, model, some, _modes(instance, model, some, noise), noise)
    R[read], T[read] = first.R, first.T
    R, T = _with_less(instance, first.model, seen, R, T, noise, ~read)
    return FitStart(replace(first.model, free=model.free), R, T, home)


def _from_home(
    instance: Instance, model: Model, seen: Measurements, modes: list[Poses], noise: Noise
) -> tuple[Fit, str]:
    """Return the fit of frames to the poses of all rows near home, and which home that is."""
    result = solve(instance)
    if result.home is None:
        message = "the stated values have no real pose: state those of a pose of the machine"
        raise GspError(message)

    if instance.home is not None:
        places = _nearest(model, modes, result.home.R, result.home.T)
        return fit(_with_frames(model, seen, *places), *places, seen, noise), ""
    tried = []
    for R, T in zip(result.R[result.real].real, result.T[result.real].real, strict=True):
        places = _nearest(model, modes, R, T)
        near = _with_frames(model, seen, *places)
        tried.append((float(_costs(seen.rows(near, *places, noise)).sum()), near, places))
    order = sorted(range(len(tried)), key=lambda k: tried[k][0])
    best = order[0]
    home = f"no home is stated, and mode {best + 1} of {len(tried)} was taken"
    if len(tried) > 1:
        # Before the machine is fitted chi-squared means nothing, but their ratio does.
        ratio = (tried[order[1]][0] / max(tried[best][0], 1e-300)) ** 0.5
        home += f": poses of the next best are {ratio:.2g} times as far from those measured"
    _, near, places = tried[best]
    return fit(near, *places, seen, noise), f"{home}; `home` in SPEC says which is right"


def _with_frames(model: Model, seen: Measurements, R: Array, T: Array) -> Model:
    """Return the model with the frames that poses show, only these free."""
    # With the stated geometry first, so that the frames of base and platform stay where they are.
    return replace(model, frames=_frames(model, seen, R, T), free=model.free & _of_frames(model))


def _with_less(
    instance: Instance,
    model: Model,
    seen: Measurements,
    R: Array,
    T: Array,
    noise: Noise,
    less: NDArray[np.bool_],
) -> tuple[Array, Array]:
    """Return poses R, T with those filled in of rows that have less than a pose and six readings.

    Raises
    ------
    GspError
        If no pose agrees with a row.
    """
    if not less.any():
        return R, T
    R, T = R.copy(), T.copy()
    if less.all():
        modes = solve(instance)
        starts = modes.R[modes.real].real, modes.T[modes.real].real
    else:
        starts = R[~less], T[~less]
    if not len(starts[0]):
        message = "the stated values have no real pose, and no row has a whole pose or six readings"
        raise GspError(message)
    for k in np.flatnonzero(less).tolist():
        there = seen.taken(np.full(len(starts[0]), k))
        costs = _costs(there.rows(model, *starts, noise))
        nearest = np.argsort(costs)[:_STARTS]
        found = _settled(model, there.taken(nearest), starts[0][nearest], starts[1][nearest], noise)
        costs = _costs(there.taken(nearest).rows(model, *found, noise))
        best = int(costs.argmin())
        # As far off as poses of stated numbers can be, and not only noise.
        if not costs[best] < (_AGREES * model.length / (noise.value or noise.position)) ** 2:
            message = (
                f"row {seen.lines[k]}: no pose near those of other rows agrees with what it has: "
                "leave the row out"
            )
            raise GspError(message)
        R[k], T[k] = found[0][best], found[1][best]
    return R, T


def _costs(rows: WhitenedRows) -> Array:
    """Return the sum of squares of each row, infinite where one is not a number."""
    return np.asarray(np.nansum(rows.residual**2, axis=1))


def _settled(
    model: Model, seen: Measurements, R: Array, T: Array, noise: Noise
) -> tuple[Array, Array]:
    """Return the poses of least squares for each row, from poses near them."""
    sizes = np.array([1.0] * 3 + [model.length] * 3)

    def equations(R: Array, T: Array) -> tuple[Array, Array]:
        r, _, P = seen.rows(model, R, T, noise)
        there = np.isfinite(r)
        return np.where(there, r, 0.0), np.where(there[..., None], P, 0.0) * sizes

    def moved(step: Array, R: Array, T: Array) -> tuple[Array, Array]:
        twist = step * sizes
        return rotation_from_vector(twist[:, :3]) @ R, T + twist[:, 3:]

    R, T = descend(equations, moved, (R, T), steps=_STEPS, noise=1.0).point
    return R, T


def _of_frames(model: Model) -> NDArray[np.bool_]:
    return np.arange(len(model.free)) >= model.geometry + 12


def _modes(instance: Instance, model: Model, seen: Measurements, noise: Noise) -> list[Poses]:
    """Return for each row the real poses of its readings."""
    found = []
    plain = replace(noise, crank=0.0, slide=0.0, value=noise.value or noise.position)
    for k, poses in enumerate(_solved(instance, model, seen)):
        R, T = poses.R[poses.real].real, poses.T[poses.real].real
        same = seen.taken(np.full(len(R), k))
        apart = np.abs(value_rows(model, R, T, same, plain).residual).max(axis=1, initial=0.0)
        # Readings of distances to planes have a sign.
        right = apart * plain.value < 1e-3 * model.length
        if not right.any():
            message = (
                f"row {seen.lines[k]}: no real pose has these readings with the stated geometry: "
                "measure the whole pose, or leave the row out"
            )
            raise GspError(message)
        found.append((R[right], T[right]))
    return found


def _solved(
    instance: Instance, model: Model, seen: Measurements
) -> Iterator[PoseSet | SolveResult]:
    """Yield all poses of each row for its readings, with the drives where they are."""
    values = values_of(instance, _in_file_units(model, seen.readings))
    sided = [row.kind.has_sides for row in instance.constraints]
    values = np.where(sided, np.abs(values), values)
    if seen.drives is None or not model.drives:
        yield from solve_values(_both_sides(instance), values)
        return
    drives = Machine.of(instance)
    q = np.zeros((len(seen), drives.count))
    for one, readings in zip(model.drives, seen.drives.T, strict=True):
        q[:, drives.names.index(one.drive_name)] = one.numbers(readings)
    for numbers, row in zip(q, values.tolist(), strict=True):
        there = _both_sides(drives.instance_at(numbers))
        yield solve(there.with_values(dict(enumerate(map(Number.of, row)))))


def _agreeing(
    model: Model, seen: Measurements, modes: list[Poses], noise: Noise
) -> tuple[Array, Array]:
    """Return for each row the pose that agrees best with what was measured."""
    chosen = []
    for k, (R, T) in enumerate(modes):
        rows = seen.taken(np.full(len(R), k)).rows(model, R, T, noise)
        best = int(_costs(rows).argmin())
        chosen.append((R[best], T[best]))
    return _stacked(chosen)


def _nearest(model: Model, modes: list[Poses], home_R: Array, home_T: Array) -> tuple[Array, Array]:
    """Return for each row the pose that is nearest to home."""
    chosen = []
    for R, T in modes:
        apart = np.linalg.norm(R - home_R, axis=(1, 2))
        apart += np.linalg.norm(T - home_T, axis=1) / model.length
        best = int(apart.argmin())
        chosen.append((R[best], T[best]))
    return _stacked(chosen)


def _stacked(poses: list[Poses]) -> tuple[Array, Array]:
    return np.array([R for R, _ in poses]), np.array([T for _, T in poses])


def _both_sides(instance: Instance) -> Instance:
    """Return the platform whose readings are values, on either side of its planes."""
    plain = without_corrections(instance)
    rows = tuple(replace(row, side=Side.BOTH) for row in plain.constraints)
    return replace(plain, constraints=rows)


def _in_file_units(model: Model, readings: Array) -> Array:
    angles = [k for k, kind in enumerate(model.kinds) if not kind.is_distance]
    scaled = readings.copy()
    scaled[:, angles] /= model.in_radians
    return scaled


def _frames(model: Model, seen: Measurements, R: Array, T: Array) -> Array:
    """Return frames of device and target in which poses of the base's frame are those measured."""
    A, B = np.eye(3), np.eye(3)
    turned = np.isfinite(seen.rotations).all(axis=(1, 2))
    if turned.any():
        A, B = _common_turns(R[turned], seen.rotations[turned])
    sights = [(seen.pivot, seen.positions)] if np.isfinite(seen.positions).any() else []
    blocks = {b.name: b.point for b in model.blocks if b.body == "platform" and b.sort == "point"}
    for name, where in seen.points.items():
        at = seen.targets.get(name)
        sights.append((blocks[name] if at is None else at, where))
    frames = np.zeros(12)
    if sights:
        A, frames[3:6], frames[9:] = _places(A, B, R, T, sights, turned=bool(turned.any()))
    frames[:3], frames[6:9] = vector_from_rotation(A), vector_from_rotation(B)
    return frames


def _common_turns(R: Array, seen: Array) -> tuple[Array, Array]:
    """Return rotations A and B with ``A R B = seen`` for all poses, as well as it can be.

    ``A R - seen B^T = 0`` is linear (Zhuang, Roth and Sudhakar 1994 solve it by quaternions).
    """
    rows = []
    for turn, measured in zip(R, seen, strict=True):
        rows.append(np.hstack((np.kron(np.eye(3), turn.T), -np.kron(measured, np.eye(3)))))
    null = np.linalg.svd(np.concatenate(rows))[2][-1].reshape(2, 3, 3)
    if np.linalg.det(null[0]) < 0:
        null = -null
    A, B = (_nearest_rotation(part) for part in null)
    return A, B.T


def _nearest_rotation(matrix: Array) -> Array:
    left, _, right = np.linalg.svd(matrix)
    sign = np.array([1.0, 1.0, np.linalg.det(left @ right)])
    rotation: Array = (left * sign) @ right
    return rotation


def _places(
    A: Array,
    B: Array,
    R: Array,
    T: Array,
    sights: list[tuple[Array, Array]],
    *,
    turned: bool,
) -> tuple[Array, Array, Array]:
    """Return A, and the shifts a and b, with ``A (R (B y + b) + T) + a`` as it was seen."""
    rows, right, here, there = [], [], [], []
    for at, seen in sights:
        kept = np.isfinite(seen).all(axis=1)
        here.append((R[kept] @ (B @ at)) + T[kept])
        there.append(seen[kept])
    if not turned:
        p, q = np.concatenate(here), np.concatenate(there)
        A = _nearest_rotation((q - q.mean(axis=0)).T @ (p - p.mean(axis=0)))
    for (_, seen), place, measured in zip(sights, here, there, strict=True):
        turns = A @ R[np.isfinite(seen).all(axis=1)]
        rows.append(np.concatenate((np.broadcast_to(np.eye(3), turns.shape), turns), axis=2))
        right.append(measured - place @ A.T)
    shifts = np.linalg.lstsq(np.concatenate(rows).reshape(-1, 6), np.concatenate(right).ravel())[0]
    found: Array = np.asarray(shifts, float)
    return A, found[:3], found[3:]
