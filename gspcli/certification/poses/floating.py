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
numbers, and are rounded outward at the end, as in `BallSystem.curvatures`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from flint import arb
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.certification.equations import study
from gspcli.certification.equations.ball_system import BallSystem
from gspcli.certification.numbers.rounding import (
    COMPLEX,
    CONVERSION,
    ISOLATED,
    OUTWARD,
    REAL,
    ROUNDING,
    TINY,
)

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
#: Numbers, or bounds of their moduli.
Values = NDArray[Any]


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


# Whatever is not a number proves nothing.
@np.errstate(all="ignore")
def prove(
    system: BallSystem, R: Complex, T: Complex, sides: tuple[int, ...] | None = None
) -> Proofs:
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
    equations = Doubles(system)
    points, patches = study.study_points(R, T)
    chosen = equations.sides(points) if sides is None else np.tile(sides, (len(points), 1))
    improved, error = np.empty_like(points), np.full(len(points), np.nan)
    proved = np.zeros(len(points), np.uint8)
    for one in sorted(set(map(tuple, chosen.tolist()))):
        alike = (chosen == one).all(axis=1)
        found = _kernel.prove(
            equations.hessians[None],
            equations.moduli[None],
            equations.table(one),
            points[None, alike],
            patches[None, alike].astype(np.int32),
        )
        improved[alike], error[alike], proved[alike] = (part[0] for part in found)
    deviation = deviations(improved, error, R, T)
    isolated = ((proved & ISOLATED) > 0) & np.isfinite(deviation)
    real, imaginary = (isolated & ((proved & bit) > 0) for bit in (REAL, COMPLEX))
    return Proofs(isolated, real, imaginary, deviation)


class Doubles:
    """The equations of a system in doubles.

    Attributes
    ----------
    hessians
        Hessian matrices of the quadrics, shape (k, 8, 8).
    moduli
        Bounds of the moduli of the terms of each entry: the errors of what is computed with the
        one are at most `ROUNDING` times the same expression of the other.
    """

    def __init__(self, system: BallSystem) -> None:
        self.equations = system.equations
        nearest, bounds = np.zeros((2, len(system.forms), study.COUNT))
        for row, form in enumerate(system.forms):
            for k, coefficient in form.items():
                nearest[row, k], bounds[row, k] = converted(coefficient)
        self.hessians = np.tensordot(nearest, study.form_hessians(), 1)
        self.moduli = np.tensordot(bounds, np.abs(study.form_hessians()), 1)

    def sides(self, points: Complex) -> NDArray[np.int64]:
        """Return for each point and constraint the side whose equation is nearer to zero."""
        values = np.abs(_quadrics(self.hessians, points)[0])
        return np.stack(
            [values[:, [e.main for e in sides]].argmin(axis=1) for sides in self.equations], axis=1
        )

    def table(self, sides: Sequence[int]) -> NDArray[np.int32]:
        """Return the quadrics of each equation for the kernel, shape (6, 3); -1 for none."""
        rows = np.full((len(self.equations), 3), -1, np.int32)
        for row, equations, side in zip(rows, self.equations, sides, strict=True):
            equation = equations[side]
            row[0] = equation.main
            row[1 : 1 + len(equation.squares)] = equation.squares
        return rows


def converted(coefficient: arb) -> tuple[float, float]:
    """Return a double near a coefficient, and a bound as `CONVERSION` wants it."""
    nearest = float(coefficient)
    error = float((coefficient - nearest).abs_upper()) * OUTWARD + TINY
    return nearest, max(abs(nearest), error / CONVERSION)


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
