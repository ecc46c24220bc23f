"""The polynomial of each constraint, with its first and second derivatives.

The ten kinds are stated here once for floating point. Measured values, residuals and their
derivatives by the pose and by the numbers of the platform follow from these polynomials. They are
those of the paper's Section 4, in three vectors: ``r = R y + T - x`` from the primitive of the base
to that of the platform; the direction or normal of the platform, ``w = R u``; and that of the base,
v. The vectors w and v are unit vectors. All functions take leading batch axes and complex numbers.

Three other statements exist on purpose. They are evidence that does not use this one:
`gspcli.certification` (the exact equations in ball arithmetic), `tools.atlas.groebner`
(modulo a prime), and the programs in benchmarks and tools. The quadrics that paths are tracked on
(`gspcli.solver.study_systems`, `Measures` below) are the same polynomials in Study
coordinates.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import (
    BODY_TRANSLATION_FORMS,
    ROTATION_FORMS,
    TRANSLATION_FORMS,
    Field,
    cross,
    dot,
)
from gspcli.records import dataclass

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


Array = NDArray[np.float64]
#: A vector of a constraint: a list is quicker than an array for so few numbers.
_Vector = list[float]


@dataclass(frozen=True, eq=False)
class Measures:
    """The measured distances as forms in the Study parameters.

    A form (a, b), shape (4, 8), is ``s^2 e^T a e + s e^T b f`` at the Study point (s e, f).

    Attributes
    ----------
    forms
        All forms, shape (count, 4, 8), each times N. First the heights over planes and the moments
        of two lines. Then the squared distances of points without ``4 f.f``: those for spheres,
        those for cylinders. Then the height along the axis of each cylinder. Last the three
        components of the vector product of the directions of two lines.
    skew
        Which of the heights are moments of two lines.
    flat, curved
        Positions of the heights and of the squares among the distances.
    spheres
        How many of the squares are those of spheres.
    basis
        The forms of T or of U if all distances are simplest in them, else None.
    signs
        The combinations of sides asked for: ``height = sign distance``, shape (s, k).
    """

    forms: Array
    skew: list[int]
    flat: list[int]
    curved: list[int]
    spheres: int
    basis: Array | None
    signs: Array


def measures(arrangement: Arrangement) -> Measures:
    """Return the forms of the distances of an arrangement."""
    indices = arrangement.distances.tolist()
    heights: list[tuple[int, _Vector]] = []
    spheres: list[tuple[int, _Vector]] = []
    cylinders: list[tuple[int, _Vector]] = []
    axial: list[_Vector] = []
    normals: list[_Vector] = []
    skew: list[int] = []
    sorts = set()
    given = arrangement
    for j, i in enumerate(indices):
        kind = given.kinds[i]
        y, x, u, v = (part[i].tolist() for part in (given.y, given.x, given.u, given.v))
        if kind is DPH:
            heights.append((j, _base_height(y, x, v)))
        elif kind is DHP:
            heights.append((j, [-number for number in _platform_height(y, x, u)]))
        elif kind is DPP:
            spheres.append((j, _square(y, x)))
        elif kind is DLP:
            cylinders.append((j, _square(y, x)))
            axial.append(_platform_height(y, x, u))
        elif kind is DPL:
            cylinders.append((j, _square(y, x)))
            axial.append(_base_height(y, x, v))
        elif kind is DLL:
            skew.append(len(heights))
            heights.append((j, _moment(y, x, u, v)))
            normals += [_combination(R=_of_rotation(_cross(v, axis), u)) for axis in _AXES]
        else:
            raise ValueError(kind)
        sorts.add("q" if kind in (DHP, DLP) else "s" if kind is DPP else "p")
    flat = [j for j, _ in heights]
    rows = [row for _, row in (*heights, *spheres, *cylinders)] + axial + normals
    return Measures(
        forms=(np.array(rows) @ _FORMS).reshape(-1, 4, 8),
        skew=skew,
        flat=flat,
        curved=[j for j, _ in (*spheres, *cylinders)],
        spheres=len(spheres),
        basis=TRANSLATION_FORMS
        if "q" not in sorts
        else BODY_TRANSLATION_FORMS
        if "p" not in sorts
        else None,
        signs=signs_of(arrangement, [indices[j] for j in flat]),
    )


_ZEROS = [0.0] * 9
_AXES = np.eye(3).tolist()


def _combination(
    one: float = 0.0,
    R: _Vector = _ZEROS,
    T: _Vector = _ZEROS[:3],
    U: _Vector = _ZEROS[:3],
    moment: _Vector = _ZEROS,
) -> _Vector:
    """Return the coefficients of a combination of 1, R, T, U and T x R, 25 numbers."""
    return [one, *R, *T, *U, *moment]


def _function_forms() -> Array:
    """Return the forms of N times 1, R, T, U and T x R, shape (25, 32)."""
    forms = np.zeros((25, 4, 8))
    forms[0, :, :4] = np.eye(4)
    forms[1:10, :, :4] = ROTATION_FORMS.reshape(9, 4, 4)
    forms[10:13, :, 4:] = TRANSLATION_FORMS
    forms[13:16, :, 4:] = BODY_TRANSLATION_FORMS
    # N R is quadratic in e, and N [T]x R is its derivative along f: twice the polar form.
    forms[16:, :, 4:] = 2 * ROTATION_FORMS.reshape(9, 4, 4)
    return forms.reshape(25, 32)


_FORMS = _function_forms()


def _dot(a: _Vector, b: _Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: _Vector, b: _Vector) -> _Vector:
    return [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]


def _of_rotation(b: _Vector, a: _Vector, factor: float = 1.0) -> _Vector:
    """Return the coefficients of R in ``factor b . R a``."""
    return [factor * p * q for p in b for q in a]


def _base_height(y: _Vector, x: _Vector, v: _Vector) -> _Vector:
    """Return ``v . (R y + T - x)``."""
    return _combination(-_dot(v, x), R=_of_rotation(v, y), T=v)


def _platform_height(y: _Vector, x: _Vector, u: _Vector) -> _Vector:
    """Return ``R u . (R y + T - x) = u . (y + U - R^T x)``."""
    return _combination(_dot(u, y), R=_of_rotation(x, u, -1.0), U=u)


def _moment(y: _Vector, x: _Vector, u: _Vector, v: _Vector) -> _Vector:
    """Return ``(R y + T - x) . (R u x v)``."""
    about_base = _of_rotation(_cross(v, x), u)
    turned = [p - q for p, q in zip(_of_rotation(v, _cross(y, u)), about_base, strict=True)]
    return _combination(R=turned, moment=_of_rotation(v, u))


def _square(y: _Vector, x: _Vector) -> _Vector:
    """Return ``|R y + T - x|^2`` but for ``T.T``."""
    return _combination(
        _dot(x, x) + _dot(y, y),
        R=_of_rotation(x, y, -2.0),
        T=[-2.0 * number for number in x],
        U=[2.0 * number for number in y],
    )


@cache
def _signs(free: tuple[bool, ...], fixed: tuple[int, ...]) -> Array:
    choices = [(1, -1) if f else (s,) for f, s in zip(free, fixed, strict=True)]
    return np.array(list(product(*choices)), float)


def signs_of(arrangement: Arrangement, planes: list[int]) -> Array:
    """Return the sign combinations of some plane constraints, shape (s, k).

    A line-line distance has both signs, a distance to a plane those of its sides; a distance
    of zero has one.
    """
    sides = arrangement.signs[planes].tolist() if planes else []
    values = arrangement.values[planes].tolist() if planes else []
    free = tuple(s == 0 and value != 0 for s, value in zip(sides, values, strict=True))
    return _signs(free, tuple(s or 1 for s in sides))
