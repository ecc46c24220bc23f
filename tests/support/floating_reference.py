"""The proofs of `native/proofs.cpp` in NumPy: the same expressions, with the moduli themselves.

Of the values here a test shows in ball arithmetic that their rounding errors are bounded; the
kernel's answers are compared with these.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from gspcli.certification.poses.floating import Doubles, _quadrics
from numpy.typing import NDArray

from gspcli.certification.equations import study
from gspcli.certification.equations.ball_system import BallSystem
from gspcli.certification.numbers.rounding import OUTWARD, ROUNDING, TINY
from gspcli.certification.poses.isolation import REACH

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Values = NDArray[Any]
NEWTON_STEPS = 2


class Reference(NamedTuple):
    """Improved points (n, 8), their errors (n,), and what is proved (n,)."""

    points: Complex
    error: Array
    isolated: NDArray[np.bool_]
    real: NDArray[np.bool_]
    complex: NDArray[np.bool_]


@np.errstate(all="ignore")
def reference(system: BallSystem, R: Complex, T: Complex) -> Reference:
    """Prove what can be proved about poses; T in units of the scale of the system."""
    equations = Doubles(system)
    points, patches = study.study_points(R, T)
    chosen = equations.sides(points)
    free = np.array([[k for k in range(8) if k != patch] for patch in range(8)])[patches]
    rows = np.arange(len(points))[:, None]
    for step in range(NEWTON_STEPS + 1):
        values, jacobian, value_moduli, jacobian_moduli = evaluated(equations, points, chosen)
        square = np.take_along_axis(jacobian, free[:, None, :], axis=2)
        inverse = np.linalg.inv(square)
        if step < NEWTON_STEPS:
            points[rows, free] -= (inverse @ values[..., None])[..., 0]
    sizes = np.abs(inverse)
    defect = np.abs(np.eye(7) - inverse @ square) + ROUNDING * (sizes @ np.abs(square))
    moduli = np.take_along_axis(jacobian_moduli, free[:, None, :], axis=2)
    a = (defect + sizes @ (ROUNDING * moduli)).sum(axis=2).max(axis=1) * OUTWARD + TINY
    delta = np.abs(values) + ROUNDING * value_moduli + TINY
    delta = (sizes @ delta[..., None])[..., 0].max(axis=1) * OUTWARD
    curvatures = system.curvatures((np.abs(points) + REACH) * OUTWARD)
    b = (sizes @ curvatures[..., None])[..., 0].max(axis=1) * OUTWARD
    radius = np.minimum(REACH, (1 - a) / (2 * b))
    q = (a + b * radius) * OUTWARD
    isolated = (q < 1) & (delta * OUTWARD <= (1 - q) * radius)
    error = delta / (1 - q) * OUTWARD
    imaginary = np.abs(points.imag).max(axis=1)
    real = isolated & ((2 * imaginary + error) * OUTWARD <= radius)
    return Reference(points, error, isolated, real, isolated & (imaginary > error))


def evaluated(
    equations: Doubles, points: Complex, sides: NDArray[np.int64]
) -> tuple[Complex, Complex, Array, Array]:
    """Return values (n, 7) and Jacobian matrices (n, 7, 8), and the same of the moduli."""
    values, jacobian = _combined(equations, *_quadrics(equations.hessians, points), sides, -1)
    moduli = _quadrics(equations.moduli, np.abs(points))
    value_moduli, jacobian_moduli = _combined(equations, *moduli, sides, 1)
    return values, jacobian, value_moduli * OUTWARD, jacobian_moduli * OUTWARD


def _combined(
    system: Doubles, v: Values, g: Values, sides: NDArray[np.int64], sign: int
) -> tuple[Values, Values]:
    """Return e.f and the equations, ``A`` or ``N A + sign (B^2 + ...)``, and their gradients.

    Parameters
    ----------
    v, g
        Values (n, k) and gradients (n, k, 8) of the quadrics.
    """
    points = np.arange(len(v))
    values, gradients = [v[:, 1]], [g[:, 1]]
    for equations, side in zip(system.equations, sides.T, strict=True):
        main = np.array([equation.main for equation in equations])[side]
        value, gradient = v[points, main], g[points, main]
        if equations[0].squares:
            gradient = value[:, None] * g[:, 0] + v[:, :1] * gradient
            value = v[:, 0] * value
        for k in equations[0].squares:
            value = value + sign * v[:, k] ** 2
            gradient = gradient + sign * 2 * v[:, k, None] * g[:, k]
        values.append(value)
        gradients.append(gradient)
    return np.stack(values, axis=1), np.stack(gradients, axis=1)
