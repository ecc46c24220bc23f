"""The proof of `isolation` for many points at a time, in floating point with bounds of all errors.

Doubles are rounded to nearest, sums (those in products of matrices too) are taken in any order,
and a product may be added with one rounding or with two. Then an expression with at most m
roundings on the way from any of its terms to the result differs from its exact value by at most
``m u / (1 - m u)``, u = 2^-53, times the same expression of the moduli of its terms (N. Higham,
*Accuracy and Stability of Numerical Algorithms*, chapter 3); for complex numbers by at most
sqrt(2) times that in each product.

The Hessian matrices of the quadrics need 4 roundings (no more of the forms of `study` have the same
monomial), a gradient 8, a value 16 more. So with products of complex numbers a value errs by less
than gamma_41, and the difference of products of two of those by less than gamma_90, as do
derivatives. `ROUNDING` is more than twice that. Bounds are sums and products of nonnegative
numbers, and are rounded outward at the end, as in `System.curvatures`.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from flint import arb
from numpy.typing import NDArray

from gspcli.certification import study
from gspcli.certification.balls import OUTWARD, TINY
from gspcli.certification.isolation import REACH
from gspcli.certification.system import System

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
#: Numbers, or bounds of their moduli.
Values = NDArray[Any]

#: Bounds the relative error (of the expression of the moduli) of everything computed here.
ROUNDING = 2.0**-45
#: A coefficient differs from its double by at most this part of its bound.
_CONVERSION = 2.0**-50
_NEWTON_STEPS = 2


class Proofs(NamedTuple):
    """What is proved about n points.

    Attributes
    ----------
    isolated
        Near which of them there is exactly one solution, and a simple one; shape (n,).
    real, complex
        Which of those are proved real, and proved not to be; shape (n,).
    deviation
        Bound of the difference between the pose as given and the solution in any entry of R, and
        of T by the scale of the system; shape (n,).
    """

    isolated: NDArray[np.bool_]
    real: NDArray[np.bool_]
    complex: NDArray[np.bool_]
    deviation: Array


@cache
def form_hessians() -> Array:
    """Return the Hessian matrices of all forms, integers, shape (27, 8, 8)."""
    rows = study.hessians().tolist()
    return np.array([[int(entry) for entry in row] for row in rows], float).reshape(-1, 8, 8)


# Whatever is not a number proves nothing.
@np.errstate(all="ignore")
def prove(system: System, R: Complex, T: Complex, sides: tuple[int, ...] | None = None) -> Proofs:
    """Prove what double precision can about approximate poses.

    Parameters
    ----------
    system
        The equations; their coefficients should have a few bits more than doubles.
    R, T
        Rotations (n, 3, 3), and translations in units of the scale of the system (n, 3).
    sides
        For each constraint the index of its equation; for each pose the nearest if None.
    """
    equations = _Equations(system)
    points, patches = study.study_points(R, T)
    chosen = equations.sides(points) if sides is None else np.tile(sides, (len(points), 1))
    free = np.array([[k for k in range(8) if k != patch] for patch in range(8)])[patches]
    rows = np.arange(len(points))[:, None]
    for step in range(_NEWTON_STEPS + 1):
        values, jacobian, value_moduli, jacobian_moduli = equations.at(points, chosen)
        square = np.take_along_axis(jacobian, free[:, None, :], axis=2)
        try:
            inverse = np.linalg.inv(square)
        except np.linalg.LinAlgError:
            inverse = np.full_like(square, np.nan)
        if step < _NEWTON_STEPS:
            points[rows, free] -= (inverse @ values[..., None])[..., 0]
    sizes = np.abs(inverse)
    defect = np.abs(np.eye(7) - inverse @ square) + ROUNDING * (sizes @ np.abs(square))
    moduli = np.take_along_axis(jacobian_moduli, free[:, None, :], axis=2)
    a = (defect + sizes @ (ROUNDING * moduli)).sum(axis=2).max(axis=1) * OUTWARD + TINY
    delta = np.abs(values) + ROUNDING * value_moduli + TINY
    delta = (sizes @ delta[..., None])[..., 0].max(axis=1) * OUTWARD
    curvatures = system.curvatures((np.abs(points) + REACH) * OUTWARD)
    b = (sizes @ curvatures[..., None])[..., 0].max(axis=1) * OUTWARD
    # As in `isolation`: any radius may be tried.
    radius = np.minimum(REACH, (1 - a) / (2 * b))
    q = (a + b * radius) * OUTWARD
    isolated = (q < 1) & (delta * OUTWARD <= (1 - q) * radius)
    error = delta / (1 - q) * OUTWARD
    imaginary = np.abs(points.imag).max(axis=1)
    deviation = deviations(points, error, R, T)
    isolated &= np.isfinite(deviation)
    return Proofs(
        isolated,
        isolated & ((2 * imaginary + error) * OUTWARD <= radius),
        isolated & (imaginary > error),
        deviation,
    )


class _Equations:
    """The equations of a system in doubles.

    Each of their values comes with the same expression of moduli: its error is at most
    `ROUNDING` times that.
    """

    def __init__(self, system: System) -> None:
        self.equations = system.equations
        nearest, bounds = np.zeros((2, len(system.forms), study.COUNT))
        for row, form in enumerate(system.forms):
            for k, coefficient in form.items():
                nearest[row, k], bounds[row, k] = converted(coefficient)
        self.hessians = np.tensordot(nearest, form_hessians(), 1)
        self.moduli = np.tensordot(bounds, np.abs(form_hessians()), 1)

    def sides(self, points: Complex) -> NDArray[np.int64]:
        """Return for each point and constraint the side whose equation is nearer to zero."""
        values = np.abs(_quadrics(self.hessians, points)[0])
        return np.stack(
            [values[:, [e.main for e in sides]].argmin(axis=1) for sides in self.equations], axis=1
        )

    def at(
        self, points: Complex, sides: NDArray[np.int64]
    ) -> tuple[Complex, Complex, Array, Array]:
        """Return values (n, 7) and Jacobian matrices (n, 7, 8), and the same of the moduli."""
        values, jacobian = self._combined(*_quadrics(self.hessians, points), sides, -1)
        moduli = _quadrics(self.moduli, np.abs(points))
        value_moduli, jacobian_moduli = self._combined(*moduli, sides, 1)
        return values, jacobian, value_moduli * OUTWARD, jacobian_moduli * OUTWARD

    def _combined(
        self, v: Values, g: Values, sides: NDArray[np.int64], sign: int
    ) -> tuple[Values, Values]:
        """Return e.f and the equations, ``A`` or ``N A + sign (B^2 + ...)``, and their gradients.

        Parameters
        ----------
        v, g
            Values (n, k) and gradients (n, k, 8) of the quadrics.
        """
        points = np.arange(len(v))
        values, gradients = [v[:, 1]], [g[:, 1]]
        for equations, side in zip(self.equations, sides.T, strict=True):
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


def converted(coefficient: arb) -> tuple[float, float]:
    """Return a double near a coefficient, and a bound as `_CONVERSION` wants it."""
    nearest = float(coefficient)
    error = float((coefficient - nearest).abs_upper()) * OUTWARD + TINY
    return nearest, max(abs(nearest), error / _CONVERSION)


def _quadrics(hessians: Array, points: Values) -> tuple[Values, Values]:
    """Return values (n, k) and gradients (n, k, 8) of quadrics at points (n, 8)."""
    gradients = (points @ hessians.reshape(-1, 8).T).reshape(len(points), -1, 8)
    return (gradients @ points[..., None])[..., 0] / 2, gradients


def deviations(points: Complex, error: Array, R: Complex, T: Complex) -> Array:
    """Bound the difference between given poses and those of all points in balls.

    The Hessian matrices of the forms N, N R and N T have rows whose moduli add up to 2. So over a
    ball of radius r about x = (e, f) they change by at most ``2 |x| r + 8 r^2`` (sum norm), and the
    moduli of their terms at x add up to at most ``|x|^2``; for N and N R that holds with e for x.
    So N R and N T, N times the computed pose p, and N itself are known up to the three sums below.
    """
    norm, rotation, translation = study.motion([*points.T])
    sizes = np.abs(points[:, :4]).sum(axis=1), np.abs(points).sum(axis=1)
    turning, moving = (2 * size * error + 8 * error**2 + ROUNDING * size**2 for size in sizes)
    least = np.abs(norm) * (1 - ROUNDING) - turning * OUTWARD
    bounds = []
    for numbers, given, change in (
        (np.stack([*rotation[0], *rotation[1], *rotation[2]], axis=1), R.reshape(-1, 9), turning),
        (np.stack(translation, axis=1), T, moving),
    ):
        pose = numbers / norm[:, None]
        size = np.abs(pose)
        product = size * (turning + ROUNDING * np.abs(norm))[:, None]
        spread = (change[:, None] + product) / least[:, None]
        bounds.append((np.abs(pose - given) + spread).max(axis=1) * OUTWARD)
    return np.where(least > 0, np.maximum(*bounds), np.inf)
