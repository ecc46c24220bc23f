"""Newton's method on the constraints as stated: distances and angles, not polynomials."""

from __future__ import annotations

import numpy as np

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.measurement import jacobian, measured
from gspcli.geometry.quaternions import Field
from gspcli.geometry.residuals import relative_residuals


def improved(
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
