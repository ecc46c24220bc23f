"""Measured distances as forms in the Study parameters (e, f), for any rotation."""

from __future__ import annotations

from functools import cache
from itertools import product

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import BODY_TRANSLATION_FORMS, ROTATION_FORMS, TRANSLATION_FORMS
from gspcli.records import dataclass

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
            normals += [_combination(R=_outer(_cross(v, axis), u)) for axis in _AXES]
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


def _outer(b: _Vector, a: _Vector, factor: float = 1.0) -> _Vector:
    """Return the coefficients of R in ``factor b . R a``."""
    return [factor * p * q for p in b for q in a]


def _base_height(y: _Vector, x: _Vector, v: _Vector) -> _Vector:
    """Return ``v . (R y + T - x)``."""
    return _combination(-_dot(v, x), R=_outer(v, y), T=v)


def _platform_height(y: _Vector, x: _Vector, u: _Vector) -> _Vector:
    """Return ``R u . (R y + T - x) = u . (y + U - R^T x)``."""
    return _combination(_dot(u, y), R=_outer(x, u, -1.0), U=u)


def _moment(y: _Vector, x: _Vector, u: _Vector, v: _Vector) -> _Vector:
    """Return ``(R y + T - x) . (R u x v)``."""
    about_base = _outer(_cross(v, x), u)
    turned = [p - q for p, q in zip(_outer(v, _cross(y, u)), about_base, strict=True)]
    return _combination(R=turned, moment=_outer(v, u))


def _square(y: _Vector, x: _Vector) -> _Vector:
    """Return ``|R y + T - x|^2`` but for ``T.T``."""
    return _combination(
        _dot(x, x) + _dot(y, y),
        R=_outer(x, y, -2.0),
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
