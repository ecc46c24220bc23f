"""The polynomial of each constraint, with its first and second derivatives.

The ten kinds are stated here once for floating point. Measured values, residuals and their
derivatives by the pose and by the numbers of the platform follow from these polynomials. They are
those of the paper's Section 4, in three vectors: ``r = R y + T - x`` from the primitive of the base
to that of the platform; the direction or normal of the platform, ``w = R u``; and that of the base,
v. The vectors w and v are unit vectors. All functions take leading batch axes and complex numbers.

In the functions of a motion, over any numbers, the kinds are stated in `gspcli.geometry.study`.
This statement, and that of `tools.atlas.groebner` modulo a prime, are evidence that does not use
it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.geometry import study
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import (
    BODY_TRANSLATION_FORMS,
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
        form, *further = study.forms_of(kind, y, x, u, v)
        if kind.has_sides:
            heights.append((j, _row(form)))
        elif kind is DLL:
            skew.append(len(heights))
            heights.append((j, _row(form)))
            normals += [_row(study.rotation_form(_product(v, axis), u)) for axis in _AXES]
        else:
            (cylinders if further else spheres).append((j, _row(form)))
            axial += map(_row, further)
        sorts.add("q" if kind in (DHP, DLP) else "s" if kind is DPP else "p")
    flat = [j for j, _ in heights]
    rows = [row for _, row in (*heights, *spheres, *cylinders)] + axial + normals
    return Measures(
        forms=(np.array(rows) @ _FUNCTIONS).reshape(-1, 4, 8),
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


_AXES = np.eye(3).tolist()


def _product(a: _Vector, b: _Vector) -> _Vector:
    return [a[j] * b[k] - a[k] * b[j] for j, k in ((1, 2), (2, 0), (0, 1))]


def _row(form: study.Form) -> _Vector:
    return [form.get(place, 0.0) for place in range(study.STUDY)]


def _function_forms() -> Array:
    """Return the forms of N times each function but T.T, which is zero here, shape (26, 32)."""
    forms = study.form_hessians()[: study.STUDY, :4].copy()
    forms[:, :, :4] /= 2
    forms[study.RHO] = 0
    return forms.reshape(study.STUDY, 32)


_FUNCTIONS = _function_forms()


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
