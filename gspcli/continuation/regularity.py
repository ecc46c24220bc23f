"""Whether Newton's method stands at a simple solution, or at what rounding cannot tell from none.

Rounding of the coefficients and what is left of Newton's step move a solution to first order by
some d. The solution is simple beyond doubt if the second-order terms move it much less than that:
``|J^-1 F''(d, d)| << |d|``, which is how Kantorovich's theorem is applied. Of a double solution
that rounding has split, both are of one size; nor does it help there that Newton's step is small.
The same is true where both factors of a product vanish, although the Jacobian matrix with its
rows divided by the size of what cancels in them is well-conditioned.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.quadrics import (
    NORM,
    ComplexArray,
    FloatArray,
    evaluate,
    gradients,
)
from gspcli.continuation.systems import EQUATIONS, Coefficients
from gspcli.continuation.tracker import PathResults, PathStatus

_ROUNDING = 4e-16
#: Largest ratio of second to first order that is beyond doubt: of bounds, and of estimates.
_CLEARLY = 1e-3
_LIMIT = 0.1
#: How many changes of the equations by rounding are tried.
_CHANGES = 8


def clearly_simple(results: PathResults) -> NDArray[np.bool_]:
    """Return which ends (B, P) are simple solutions by the kernel's own numbers."""
    step = results.correction + _ROUNDING * results.condition
    bounded = results.curvature * step < _CLEARLY
    return np.asarray((results.status == PathStatus.REGULAR) & bounded)


def simple(
    products: NDArray[np.bool_], target: Coefficients, points: ComplexArray
) -> NDArray[np.bool_]:
    """Return which points (P, 8) of one system are simple solutions."""
    return np.asarray(nonlinearity(products, target, points) < _LIMIT)


def nonlinearity(
    products: NDArray[np.bool_], target: Coefficients, points: ComplexArray
) -> FloatArray:
    """Return the ratio of second to first order at points (P, 8); infinite or NaN if singular.

    e and f are measured in units of their own size, so that solutions far away, whose e is small,
    are not taken for singular ones.
    """
    unit = np.repeat(
        np.stack([np.linalg.norm(part, axis=1) for part in (points[:, :4], points[:, 4:])], 1),
        4,
        axis=1,
    )
    jacobian = target.jacobians(products, points)
    size = np.linalg.norm(jacobian * unit[:, None, :], axis=2)
    # One row more, for the scale of the point.
    patch = (points / np.where(unit > 0, unit, 1.0)).conj()[:, None, :]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        rows = jacobian * unit[:, None, :] / size[:, :, None]
        inverse = _inverse(np.concatenate([rows, patch], axis=1))[:, :, :-1] / size[:, None, :]
        values = target.values(products, points)[:, None, :] + _changes(products, target, points)
        # Of each change, (P, changes, 8).
        first = values @ inverse.swapaxes(1, 2)
        second = np.stack(
            [_second_order(products, target, points, first[:, k] * unit) for k in range(_CHANGES)],
            axis=1,
        )
        bent = np.linalg.norm(second @ inverse.swapaxes(1, 2), axis=2)
        return np.asarray((bent / np.linalg.norm(first, axis=2)).max(axis=1))


def _inverse(matrices: ComplexArray) -> ComplexArray:
    """Return the inverses (P, 8, 8), infinite where there is none."""
    try:
        return np.asarray(np.linalg.inv(matrices))
    except np.linalg.LinAlgError:
        if len(matrices) == 1:
            return np.full(matrices.shape, np.inf, dtype=np.complex128)
        return np.concatenate([_inverse(matrix[None]) for matrix in matrices])


def _changes(
    products: NDArray[np.bool_], target: Coefficients, points: ComplexArray
) -> ComplexArray:
    """Return changes of the values (P, changes, 7) of the size of rounding in the coefficients."""
    monomials = [np.linalg.norm(part, axis=1) for part in (points[:, :4], points[:, 4:])]
    e, f = monomials
    parts = (slice(0, 10), slice(10, 26), slice(26, 27))

    def terms(quadrics: ComplexArray) -> FloatArray:
        sizes = np.stack([np.linalg.norm(quadrics[:, part], axis=1) for part in parts])
        return np.asarray(np.stack([e * e, e * f, f * f], axis=1) @ sizes)

    first = terms(target.g)
    g, h = (np.abs(evaluate(quadrics, points)) for quadrics in (target.g, target.h))
    n = np.abs(evaluate(NORM[None], points)) * (e * e)[:, None]
    product = first * h + terms(target.h) * g + np.abs(target.tau) * n
    size = np.concatenate([(e * f)[:, None], np.where(products, product, first)], axis=1)
    rng = np.random.default_rng(EQUATIONS)
    phases = np.exp(2j * np.pi * rng.random((_CHANGES, 1 + EQUATIONS)))
    return np.asarray(_ROUNDING * size[:, None, :] * phases)


def _second_order(
    products: NDArray[np.bool_], target: Coefficients, points: ComplexArray, step: ComplexArray
) -> ComplexArray:
    """Return the terms of second order (P, 7) of the equations at points plus steps (P, 8)."""
    rows = evaluate(target.g, step)
    if products.any():
        n, dn = (evaluate(NORM[None], x) for x in (points, step))
        g, h = (evaluate(quadrics, points) for quadrics in (target.g, target.h))
        along_g, along_h, along_n = (
            np.einsum("pkj,pj->pk", gradients(quadrics, points), step)
            for quadrics in (target.g, target.h, NORM[None])
        )
        product = g * evaluate(target.h, step) + h * rows + along_g * along_h
        product = product - target.tau * (2 * n * dn + along_n**2)
        rows = np.where(products, product, rows)
    study = (step[:, :4] * step[:, 4:]).sum(axis=1, keepdims=True)
    return np.concatenate([study, rows], axis=1)
