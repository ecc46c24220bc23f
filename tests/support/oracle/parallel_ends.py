"""Ends of paths where the two lines of a DLL distance are parallel, or almost.

The paper's equation of a line-line distance (Section 4, DLL) is multiplied by the squared sine of
the angle of the lines, so it holds wherever they are parallel, at every distance. Such an end is
a pose only if the distance of the parallel lines is the one that was asked for.

For parallel lines the gradient of M^2 - d^2 (N^2 - C^2) vanishes: M = 0, and N - C or N + C is a
sum of two squares that vanish. So several paths end there, and the end of a single path is always a
pose, for any angle of its lines. But it has lost the digits of that sine, and its distance loses
them once more; `polish_parallel_lines` restores them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.measurement import jacobian, measured, relative_residuals
from gspcli.geometry.quaternions import Field, cross, dot, rotation_from_vector
from gspcli.geometry.tolerances import NEARLY_PARALLEL_SINE

#: Zero up to the error of an end at which several paths meet, which has half the digits.
_PARALLEL_SINE = 1e-5
#: Distances, in lengths of the platform, that differ by less are equal at such an end ...
_EQUAL = 1e-5
#: ... and those that differ by more are not.
_DIFFERENT = 1e-3
_POLISHING_STEPS = 2
#: Poses are sought about an end from this many places turned by this much, by this many steps.
_TRIALS, _TURNS, _TRIAL_STEPS = 24, (1e-7, 1e-6, 1e-5), 12
#: Residual, lengths by that of the platform, at which a trial has arrived, and how near to the end
#: it must be.
_ARRIVED, _NEAR = 1e-9, 1e-3
#: Near parallel lines residuals are as small as the sine, at any distance. A trial that only
#: approaches the end itself has not arrived.
_ARRIVED_OF_SINE = 1e-3


def judge_parallel_lines(
    arrangement: Arrangement, R: Field, T: Field, multiple: NDArray[np.bool_]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which poses are none because parallel lines have another distance, or may be none.

    Parameters
    ----------
    arrangement
        The platform.
    R, T
        Solutions of its equations, shapes (n, 3, 3) and (n, 3).
    multiple
        At which of them several paths end, shape (n,).

    Returns
    -------
    spurious, undecided
        Shape (n,): no pose, by the distance of the lines; and too near to poses to tell.
    """
    spurious = np.zeros(len(R), dtype=np.bool_)
    undecided = np.zeros(len(R), dtype=np.bool_)
    lines = _lines(arrangement)
    if not lines or not multiple.any():
        return spurious, undecided
    r, w = (field[:, lines] for field in arrangement.placed(R, T)[:2])
    v = arrangement.v[lines]
    apart = [np.sqrt((np.abs(w - sign * v) ** 2).sum(axis=-1)) for sign in (1, -1)]
    parallel = multiple[:, None] & (np.minimum(*apart) < _PARALLEL_SINE)
    # The squares of complex distances are compared: their roots have no sign.
    across = r - dot(r, v)[..., None] * v
    square = arrangement.targets[lines] ** 2
    error = np.abs(dot(across, across) - square)
    size = arrangement.length * (arrangement.length + np.sqrt(square))
    wrong = (parallel & (error > _EQUAL * size)).any(axis=1)
    clearly = (parallel & (error > _DIFFERENT * size)).any(axis=1)
    for i in np.flatnonzero(wrong):
        # Two simple poses on either side of parallel lines look like one end of two paths.
        undecided[i] = not clearly[i] or _poses_nearby(arrangement, R[i], T[i])
    spurious[wrong] = ~undecided[wrong]
    return spurious, undecided


def polish_parallel_lines(
    arrangement: Arrangement, R: Field, T: Field, simple: NDArray[np.bool_]
) -> tuple[Field, Field]:
    """Return the poses with simple ones of almost parallel lines improved; shapes as above."""
    lines = _lines(arrangement)
    if not lines or not len(R):
        return R, T
    sines = _sines(arrangement, R, T)
    chosen = np.flatnonzero(simple & (sines < NEARLY_PARALLEL_SINE).any(axis=1))
    if len(chosen):
        R, T = R.copy(), T.copy()
    for i in chosen:
        R[i], T[i], _ = _improved(arrangement, R[i], T[i], _POLISHING_STEPS)
    return R, T


def _lines(arrangement: Arrangement) -> list[int]:
    return [i for i, kind in enumerate(arrangement.kinds) if kind is DLL]


def _sines(arrangement: Arrangement, R: Field, T: Field) -> NDArray[np.float64]:
    """Return the sines of the angles of the line pairs at poses, shape (..., lines)."""
    lines = _lines(arrangement)
    w = arrangement.placed(R, T).w
    normals = cross(w[..., lines, :], np.broadcast_to(arrangement.v[lines], w[..., lines, :].shape))
    return np.asarray(np.linalg.norm(normals, axis=-1))


def _poses_nearby(arrangement: Arrangement, R: Field, T: Field) -> bool:
    """Say whether Newton's method on the constraints as stated finds a pose beside an end."""
    rng = np.random.default_rng(0)
    for size in _TURNS:
        for _ in range(_TRIALS):
            turned = rotation_from_vector(size * rng.standard_normal(3)) @ R
            with np.errstate(divide="ignore", invalid="ignore"):
                pose, place, residual = _improved(arrangement, turned, T, _TRIAL_STEPS)
            distance = np.abs(pose - R).max() + np.abs(place - T).max() / arrangement.length
            least = min(_ARRIVED, _ARRIVED_OF_SINE * _sines(arrangement, pose, place).min())
            if residual < least and distance < _NEAR:
                return True
    return False


def _improved(
    arrangement: Arrangement, R: Field, T: Field, steps: int
) -> tuple[Field, Field, float]:
    """Return one pose after Newton steps, as long as they make its largest residual smaller.

    Parameters
    ----------
    arrangement
        The platform.
    R, T
        The pose, shapes (3, 3) and (3,), complex.
    steps
        How many steps at most.

    Returns
    -------
    R, T, residual
        The pose, and its largest residual, lengths by that of the platform and angles in radians.
    """
    best = float(relative_residuals(arrangement, R, T).max())
    for _ in range(steps):
        try:
            step = np.linalg.solve(jacobian(arrangement, R, T), -_errors(arrangement, R, T))
        except np.linalg.LinAlgError:
            break
        if not np.isfinite(step).all():
            break
        moved = _turned(step[:3], R), T + step[3:]
        residual = float(relative_residuals(arrangement, *moved).max())
        if not residual < best:
            break
        (R, T), best = moved, residual
    return R, T, best


def _turned(omega: Field, R: Field) -> Field:
    """Return ``(I - K/2)^-1 (I + K/2) R``, K the cross product with omega: Cayley's rotation."""
    x, y, z = omega / 2
    half = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turned: Field = np.linalg.solve(np.eye(3) - half, (np.eye(3) + half) @ R)
    return turned


def _errors(arrangement: Arrangement, R: Field, T: Field) -> Field:
    """Return measured less stated values, shape (6,); of two signs the nearer one counts."""
    values, targets = measured(arrangement, R, T), arrangement.targets
    distances = np.array([kind.is_distance for kind in arrangement.kinds])
    free = distances & (arrangement.signs == 0)
    signs = np.where(distances & ~free, arrangement.signs, 1)
    opposite = free & (np.abs(values + targets) < np.abs(values - targets))
    errors: Field = values - np.where(opposite, -1, signs) * targets
    return errors
