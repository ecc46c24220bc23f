"""Where a fit starts: poses from what is known of them, and frames of device and target.

A pose that was measured whole is its own start. Of others all real poses for the readings with the
stated geometry are found, and the one is taken that agrees best with what was measured.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.fitting import fit
from gspcli.calibration.measurements import Measurements, Noise, value_rows
from gspcli.calibration.parameters import Model
from gspcli.errors import GspError
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.quaternions import apply, vector_from_rotation
from gspcli.geometry.readings import values_of, without_corrections
from gspcli.solver import solve, solve_values

Array = NDArray[np.float64]


def started(
    instance: Instance, model: Model, seen: Measurements, noise: Noise
) -> tuple[Model, Array, Array]:
    """Return the model and the poses to start from.

    Raises
    ------
    GspError
        If a row has neither a whole pose nor six readings, or no real pose has its readings.
    """
    if not model.with_frames:
        R, T = seen.rotations.copy(), seen.positions - apply(seen.rotations, seen.pivot)
        rest = ~seen.whole
        if rest.any():
            R[rest], T[rest] = _modes(instance, model, seen.taken(rest), noise)
        return model, R, T
    R, T = _modes(instance, model, seen, noise)
    # With the stated geometry first, so that the frames of base and platform stay where they are.
    near = replace(model, frames=_frames(model, seen, R, T), free=model.free & _of_frames(model))
    first = fit(near, R, T, seen, noise)
    return replace(first.model, free=model.free), first.R, first.T


def _of_frames(model: Model) -> NDArray[np.bool_]:
    return np.arange(len(model.free)) >= model.geometry + 12


def _modes(
    instance: Instance, model: Model, seen: Measurements, noise: Noise
) -> tuple[Array, Array]:
    """Return for each row the real pose of its readings that agrees best with what was measured."""
    gaps = np.flatnonzero(~np.isfinite(seen.readings).all(axis=1))
    if len(gaps):
        message = (
            f"row {seen.lines[gaps[0]]}: a pose that was not measured whole needs all six "
            "readings: fill them in, or leave the row out"
        )
        raise GspError(message)
    R, T = np.zeros((len(seen), 3, 3)), np.zeros((len(seen), 3))
    values = values_of(instance, _in_file_units(model, seen.readings))
    sided = [row.kind.has_sides for row in instance.constraints]
    home = _home(instance) if model.with_frames else None
    rows = solve_values(_both_sides(instance), np.where(sided, np.abs(values), values))
    for k, poses in enumerate(rows):
        found = poses.R[poses.real].real, poses.T[poses.real].real
        same = seen.taken(np.full(len(found[0]), k))
        apart = np.abs(value_rows(model, *found, same, noise).residual).max(axis=1, initial=0.0)
        # Readings of distances to planes have a sign.
        right = apart * noise.value < 1e-3 * model.length
        if not right.any():
            message = (
                f"row {seen.lines[k]}: no real pose has these readings with the stated geometry: "
                "measure the whole pose, or leave the row out"
            )
            raise GspError(message)
        found = found[0][right], found[1][right]
        if home is None:
            there = same.taken(right).rows(model, *found, noise).residual
            costs = np.nansum(there**2, axis=1)
        else:
            costs = np.linalg.norm(found[0] - home[0], axis=(1, 2))
            costs += np.linalg.norm(found[1] - home[1], axis=1) / model.length
        best = int(costs.argmin())
        R[k], T[k] = found[0][best], found[1][best]
    return R, T


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


def _home(instance: Instance) -> tuple[Array, Array]:
    """Return the home pose."""
    result = solve(instance)
    if result.home is None:
        message = "the stated values have no real pose: state those of a pose of the machine"
        raise GspError(message)
    return result.home.R, result.home.T


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
