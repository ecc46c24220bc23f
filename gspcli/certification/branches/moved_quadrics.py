"""The quadric of a distance of two points, or of a point and a plane, when a point moves."""

from __future__ import annotations

import flint
import numpy as np
from flint import arb
from numpy.typing import NDArray

from gspcli.geometry import study

Array = NDArray[np.float64]

_PRECISION = 128


def moved_quadric(v: Array, other: Array, norm: float, *, on_platform: bool) -> Array:
    """Return the Hessian matrix of the change of ``|R a + T - b|^2 N`` when a or b changes by v.

    Parameters
    ----------
    v
        The change, or a derivative of the point, shape (3,).
    other
        The point of the other body, shape (3,).
    norm
        Half of the change, or derivative, of the square of the moving point's distance from its
        origin.
    on_platform
        Whether a moves, the point of the platform.

    Returns
    -------
    Array
        Shape (8, 8), in Study coordinates; correct to the rounding of doubles.
    """
    with flint.ctx.workprec(_PRECISION):
        change, fixed = ([arb(x) for x in part.tolist()] for part in (v, other))
        pair = (fixed, change) if on_platform else (change, fixed)
        form = study.scaled(study.rotation_form(*pair), -2)
        form[study.NORM] = arb(2 * norm)
        places = study.BODY if on_platform else study.TRANSLATION
        for k in range(3):
            form[places[k]] = (2 if on_platform else -2) * change[k]
        return _hessian(form)


def moved_height(base: Array, platform: Array) -> Array:
    """Return the Hessian matrix of ``b.(R a) N`` for vectors b of the base and a of the platform.

    One is the change of a point, the other the normal of the plane from which it has a height.
    Shape (8, 8), as `moved_quadric`.
    """
    with flint.ctx.workprec(_PRECISION):
        vectors = ([arb(x) for x in part.tolist()] for part in (base, platform))
        return _hessian(study.rotation_form(*vectors))


def _hessian(form: dict[int, arb]) -> Array:
    numbers = np.array([float(form.get(k, 0)) for k in range(study.COUNT)])
    return np.asarray(np.einsum("f,fij->ij", numbers, study.form_hessians()))
