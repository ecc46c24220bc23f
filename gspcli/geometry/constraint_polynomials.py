"""The polynomial of each constraint, with its first and second derivatives.

The ten kinds are stated here once for floating point. Measured values, residuals and their
derivatives by the pose and by the numbers of the platform follow from these polynomials. They are
those of the paper's Section 4, in three vectors: ``r = R y + T - x`` from the primitive of the base
to that of the platform; the direction or normal of the platform, ``w = R u``; and that of the base,
v. The vectors w and v are unit vectors. All functions take leading batch axes and complex numbers.

Three other statements exist on purpose. They are evidence that does not use this one:
`gspcli.certification` (the exact equations in ball arithmetic), `tools.atlas.groebner`
(modulo a prime), and the programs in benchmarks and tools. The quadrics that paths are tracked on
(`gspcli.solver.study_systems`, `gspcli.geometry.distance_forms`) are the same polynomials in Study
coordinates.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.geometry.quaternions import Field, cross, dot

_IDENTITY = np.eye(3)
#: ``_CROSS[i, j, k] a_j b_k`` is the vector product.
_CROSS = np.zeros((3, 3, 3))
for _i, _j, _k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    _CROSS[_i, _j, _k], _CROSS[_i, _k, _j] = 1.0, -1.0


class Gradient(NamedTuple):
    """Derivatives by the three vectors, each of shape (..., 3)."""

    r: Field
    w: Field
    v: Field


class Hessian(NamedTuple):
    """Second derivatives by r and w, each of shape (..., 3, 3); v belongs to the base."""

    rr: Field
    rw: Field
    ww: Field


class ConstraintPolynomial(NamedTuple):
    """A polynomial p in (r, w, v), all of shape (..., 3)."""

    value: Callable[[Field, Field, Field], Field]
    """Shape (...)."""
    gradient: Callable[[Field, Field, Field], Gradient]
    hessian: Callable[[Field, Field, Field], Hessian]


def polynomial(kind: Kind) -> ConstraintPolynomial:
    """Return the polynomial of a kind.

    It is the square of a DPP, DPL or DLP distance, and the signed distance of a DPH or DHP. For a
    DLL it is the mutual moment ``r . (w x v)``: the signed distance times the sine of the angle of
    the lines. For an angle it is ``w . v``.

    Raises
    ------
    KeyError
        If the kind is not one of the ten.
    """
    return _POLYNOMIALS[kind] if kind.is_distance else COSINE


def perpendicular(r: Field, axis: Field) -> Field:
    """Return the part of r perpendicular to a unit vector, ``(..., 3), (..., 3) -> (..., 3)``."""
    across: Field = r - dot(r, axis)[..., None] * axis
    return across


def _outer(a: Field, b: Field) -> Field:
    product: Field = a[..., :, None] * b[..., None, :]
    return product


def _cross_matrix(a: Field) -> Field:
    """Return the matrix of ``b -> a x b``, shape (..., 3, 3)."""
    matrix: Field = np.einsum("ijk,...j->...ik", _CROSS, a)
    return matrix


def _zeros(r: Field) -> Field:
    return np.zeros((*r.shape, 3), r.dtype)


def _point_point() -> ConstraintPolynomial:
    """``r . r``."""
    return ConstraintPolynomial(
        lambda r, w, v: dot(r, r),
        lambda r, w, v: Gradient(2 * r, np.zeros_like(r), np.zeros_like(r)),
        lambda r, w, v: Hessian(2 * _IDENTITY + _zeros(r), _zeros(r), _zeros(r)),
    )


def _point_line() -> ConstraintPolynomial:
    """``r . r - (r . v)^2``, without the cancellation."""

    def value(r: Field, w: Field, v: Field) -> Field:
        across = perpendicular(r, v)
        return dot(across, across)

    def gradient(r: Field, w: Field, v: Field) -> Gradient:
        by_v = -2 * dot(r, v)[..., None] * r
        return Gradient(2 * perpendicular(r, v), np.zeros_like(r), by_v)

    def hessian(r: Field, w: Field, v: Field) -> Hessian:
        return Hessian(2 * (_IDENTITY - _outer(v, v)), _zeros(r), _zeros(r))

    return ConstraintPolynomial(value, gradient, hessian)


def _line_point() -> ConstraintPolynomial:
    """``r . r - (r . w)^2``, without the cancellation."""

    def value(r: Field, w: Field, v: Field) -> Field:
        across = perpendicular(r, w)
        return dot(across, across)

    def gradient(r: Field, w: Field, v: Field) -> Gradient:
        by_w = -2 * dot(r, w)[..., None] * r
        return Gradient(2 * perpendicular(r, w), by_w, np.zeros_like(r))

    def hessian(r: Field, w: Field, v: Field) -> Hessian:
        along = dot(r, w)[..., None, None]
        return Hessian(
            2 * (_IDENTITY - _outer(w, w)),
            -2 * (_outer(w, r) + along * _IDENTITY),
            -2 * _outer(r, r),
        )

    return ConstraintPolynomial(value, gradient, hessian)


def _point_plane() -> ConstraintPolynomial:
    """``r . v``."""
    return ConstraintPolynomial(
        lambda r, w, v: dot(r, v),
        lambda r, w, v: Gradient(v, np.zeros_like(r), r),
        lambda r, w, v: Hessian(_zeros(r), _zeros(r), _zeros(r)),
    )


def _plane_point() -> ConstraintPolynomial:
    """``-r . w``."""
    return ConstraintPolynomial(
        lambda r, w, v: -dot(r, w),
        lambda r, w, v: Gradient(-w, -r, np.zeros_like(r)),
        lambda r, w, v: Hessian(_zeros(r), -_IDENTITY + _zeros(r), _zeros(r)),
    )


def _line_line() -> ConstraintPolynomial:
    """``r . (w x v)``."""
    return ConstraintPolynomial(
        lambda r, w, v: dot(r, cross(w, v)),
        lambda r, w, v: Gradient(cross(w, v), cross(v, r), cross(r, w)),
        lambda r, w, v: Hessian(_zeros(r), -_cross_matrix(v) + _zeros(r), _zeros(r)),
    )


def _directions() -> ConstraintPolynomial:
    """``w . v``."""
    return ConstraintPolynomial(
        lambda r, w, v: dot(w, v),
        lambda r, w, v: Gradient(np.zeros_like(w), v, w),
        lambda r, w, v: Hessian(_zeros(r), _zeros(r), _zeros(r)),
    )


#: The cosine of two directions: the polynomial of all angles, and in the distance of two lines.
COSINE = _directions()
_POLYNOMIALS = {
    DPP: _point_point(),
    DPL: _point_line(),
    DLP: _line_point(),
    DPH: _point_plane(),
    DHP: _plane_point(),
    DLL: _line_line(),
}
