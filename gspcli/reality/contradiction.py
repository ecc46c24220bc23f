"""Why a platform has no real pose: the fewest of its constraints that contradict each other.

Subsystems are solved by minimization (Levenberg and Marquardt) from many random poses: numerical
evidence, which can miss a pose, and is called so wherever it is shown. A distance of points is not
smooth where it is zero; so the shortest one is also held exactly while the others are minimized.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DPP
from gspcli.defaults import SEED
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.measurement import jacobian, measured
from gspcli.geometry.quaternions import (
    rotation_from_quaternion,
    rotation_from_vector,
    unit_quaternion,
)

Array = NDArray[np.float64]

#: Random poses that each subsystem is tried from.
STARTS = 100
_STEPS = 60
#: A subsystem is solved when all values are right to this, lengths by the platform's.
_SOLVED = 1e-7
_FIRST_DAMPING, _LESS, _MORE = 1e-2, 0.2, 5.0
_LARGEST_DAMPING = 1e10
#: The damping is at least this part of the trace of the matrix, so that rounding errors, at most
#: some 1e-15 of the trace, cannot make the matrix singular.
_LEAST_DAMPING = 1e-12


def contradiction(arrangement: Arrangement, *, seed: int = SEED) -> tuple[int, ...]:
    """Return constraints that no pose was found to satisfy together, none of them needless.

    Parameters
    ----------
    arrangement
        A platform without a real pose.
    seed
        Source of the random poses.

    Returns
    -------
    tuple of int
        Their indices: for each of them there is a pose that satisfies all the others of the
        list. Empty if a pose was found that satisfies all.
    """
    platform = arrangement.normalized
    needed = list(range(len(platform.kinds)))
    if _is_satisfied(platform, needed, seed):
        return ()
    for index in tuple(needed):
        others = [k for k in needed if k != index]
        if others and not _is_satisfied(platform, others, seed):
            needed = others
    return tuple(needed)


def _is_satisfied(platform: Arrangement, chosen: list[int], seed: int) -> bool:
    """Return whether some of the constraints are satisfied where the minimization ends."""
    part = replace(
        platform,
        kinds=tuple(platform.kinds[k] for k in chosen),
        **{
            name: getattr(platform, name)[chosen]
            for name in ("y", "x", "u", "v", "values", "sides")
        },
    )
    rng = np.random.default_rng(seed)
    R = rotation_from_quaternion(unit_quaternion(rng.standard_normal((STARTS, 4))))
    T = rng.uniform(-2, 2, (STARTS, 3))
    # A distance to a plane or between lines has a sign; where it is free, some starts have each.
    free = np.array([kind.is_distance for kind in part.kinds]) & (part.signs == 0)
    signs = np.where(free, rng.choice((-1.0, 1.0), (STARTS, len(chosen))), 1.0)
    targets = part.targets * np.where(part.signs < 0, -1.0, signs)
    unsigned = np.array([kind.name in ("DPP", "DPL", "DLP") for kind in part.kinds])
    targets = np.where(unsigned, np.abs(targets), targets)
    if _least(part, R, T, targets).min() < _SOLVED:
        return True
    legs = [k for k, kind in enumerate(part.kinds) if kind is DPP]
    if not legs:
        return False
    held = min(legs, key=lambda k: float(targets[0, k]))
    T = _closed(part, held, R, rng.standard_normal((STARTS, 3)), targets)
    return bool(_least(part, R, T, targets, held).min() < _SOLVED)


def _closed(part: Arrangement, held: int, R: Array, directions: Array, targets: Array) -> Array:
    """Return the translations that put a leg of its length along each direction, shape (n, 3)."""
    units = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    return np.asarray(part.x[held] + targets[:, held, None] * units - R @ part.y[held])


def _least(part: Arrangement, R: Array, T: Array, targets: Array, held: int | None = None) -> Array:
    """Return the largest deviation of the values where each start ends, shape (n,).

    A leg that is held keeps its length: the platform turns about its end, and it about its foot.
    """
    damping = np.full(len(R), _FIRST_DAMPING)
    values = measured(part, R, T) - targets
    with np.errstate(all="ignore"):
        for _ in range(_STEPS):
            J = np.nan_to_num(jacobian(part, R, T), posinf=0.0, neginf=0.0)
            if held is not None:
                arm = R @ part.y[held]
                leg = arm + T - part.x[held]
                J = _by_turns(J, arm, leg)
            transposed = np.swapaxes(J, -1, -2)
            matrix = transposed @ J
            least = _LEAST_DAMPING * np.trace(matrix, axis1=1, axis2=2)
            matrix += np.maximum(damping, least)[:, None, None] * np.eye(6)
            step = -np.linalg.solve(matrix, (transposed @ values[..., None]))[..., 0]
            moved_R = rotation_from_vector(step[:, :3]) @ R
            if held is None:
                moved_T = T + step[:, 3:]
            else:
                turned = (rotation_from_vector(step[:, 3:]) @ leg[..., None])[..., 0]
                moved_T = part.x[held] + turned - moved_R @ part.y[held]
            moved = measured(part, moved_R, moved_T) - targets
            better = (moved**2).sum(axis=1) < (values**2).sum(axis=1)
            R = np.where(better[:, None, None], moved_R, R)
            T = np.where(better[:, None], moved_T, T)
            values = np.where(better[:, None], moved, values)
            damping = np.minimum(damping * np.where(better, _LESS, _MORE), _LARGEST_DAMPING)
            if np.abs(values).max(axis=1).min() < _SOLVED:
                break
    return np.asarray(np.abs(values).max(axis=1))


def _by_turns(J: Array, arm: Array, leg: Array) -> Array:
    """Return the derivatives by a turn of the platform about the leg's end and one of the leg.

    Together they translate the platform by ``leg_turn x leg - platform_turn x arm``.
    """
    by_T = J[..., 3:]
    by_platform = J[..., :3] - np.cross(arm[:, None, :], by_T)
    return np.concatenate((by_platform, np.cross(leg[:, None, :], by_T)), axis=-1)
