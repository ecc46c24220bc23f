"""The test that a result of Newton's method is a simple solution, despite rounding.

Rounding of the coefficients and the residual of Newton's step move a solution to first order by
some d. The solution is clearly simple if the second-order terms move it much less: ``|J^-1 F''(d,
d)| << |d|``, the condition of Kantorovich's theorem. At a double solution that rounding has split
both are of one size, also if Newton's step is small. The same holds where both factors of a product
vanish, although the Jacobian matrix with scaled rows is well-conditioned there.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.quadrics import (
    NORM,
    ComplexArray,
    FloatArray,
    evaluate,
)
from gspcli.continuation.systems import EQUATIONS, System
from gspcli.continuation.tracker import PathResults, PathStatus

_ROUNDING = 4e-16
#: Largest ratio of second to first order of a clearly simple solution: for bounds, for estimates.
_CLEARLY = 1e-3
_LIMIT = 0.1
#: The number of changes of the equations by rounding that are tried.
_CHANGES = 8


def clearly_simple(results: PathResults) -> NDArray[np.bool_]:
    """Return which ends (B, P) are simple solutions by the numbers of the kernel."""
    step = results.correction + _ROUNDING * results.condition
    bounded = results.curvature * step < _CLEARLY
    return np.asarray((results.status == PathStatus.REGULAR) & bounded)


def simple(target: System, points: ComplexArray) -> NDArray[np.bool_]:
    """Return which points (P, 8) of one system are simple solutions."""
    return np.asarray(nonlinearity(target, points) < _LIMIT)


def nonlinearity(target: System, points: ComplexArray) -> FloatArray:
    """Return the ratio of second to first order at points (P, 8); infinite or NaN if singular.

    The units of e and f are their sizes, so that a solution far away, whose e is small, does not
    count as singular.
    """
    unit = np.repeat(
        np.stack([np.linalg.norm(part, axis=1) for part in (points[:, :4], points[:, 4:])], 1),
        4,
        axis=1,
    )
    jacobian = target.jacobians(points)
    size = np.linalg.norm(jacobian * unit[:, None, :], axis=2)
    # A row is added for the scale of the point.
    patch = (points / np.where(unit > 0, unit, 1.0)).conj()[:, None, :]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        rows = jacobian * unit[:, None, :] / size[:, :, None]
        inverse = _inverse(np.concatenate([rows, patch], axis=1))[:, :, :-1] / size[:, None, :]
        values = target.values(points)[:, None, :] + _changes(target, points)
        # The first-order move for each change, (P, changes, 8).
        first = values @ inverse.swapaxes(1, 2)
        second = np.stack(
            [target.bends(points, first[:, k] * unit) for k in range(_CHANGES)],
            axis=1,
        )
        bent = np.linalg.norm(second @ inverse.swapaxes(1, 2), axis=2)
        return np.asarray((bent / np.linalg.norm(first, axis=2)).max(axis=1))


def _inverse(matrices: ComplexArray) -> ComplexArray:
    """Return the inverses (P, 8, 8); infinite for singular matrices."""
    try:
        return np.asarray(np.linalg.inv(matrices))
    except np.linalg.LinAlgError:
        if len(matrices) == 1:
            return np.full(matrices.shape, np.inf, dtype=np.complex128)
        return np.concatenate([_inverse(matrix[None]) for matrix in matrices])


def _changes(target: System, points: ComplexArray) -> ComplexArray:
    """Return changes of the values (P, changes, 7) of the size of rounding in the coefficients."""
    monomials = [np.linalg.norm(part, axis=1) for part in (points[:, :4], points[:, 4:])]
    e, f = monomials
    parts = (slice(0, 10), slice(10, 26), slice(26, 27))

    def terms(quadrics: ComplexArray) -> FloatArray:
        sizes = np.stack([np.linalg.norm(quadrics[:, part], axis=1) for part in parts])
        return np.asarray(np.stack([e * e, e * f, f * f], axis=1) @ sizes)

    coefficients = target.coefficients
    first = terms(coefficients.g)
    g, h = (np.abs(evaluate(quadrics, points)) for quadrics in coefficients[:2])
    n = np.abs(evaluate(NORM[None], points)) * (e * e)[:, None]
    product = first * h + terms(coefficients.h) * g + np.abs(coefficients.tau) * n
    rows = np.where(target.structure.is_product, product, first)
    size = np.concatenate([(e * f)[:, None], rows], axis=1)
    rng = np.random.default_rng(EQUATIONS)
    phases = np.exp(2j * np.pi * rng.random((_CHANGES, 1 + EQUATIONS)))
    return np.asarray(_ROUNDING * size[:, None, :] * phases)
