"""Study coordinates of rigid motions, and the constraints as quadrics in them.

A pose (R, T) is a point (e0..e3, f0..f3) with ``e . f = 0`` and ``N = e . e != 0``, up to a
common factor: e is the quaternion of R, scalar first, and ``f = T e / 2``. Then N times each of
the entries of R, T, ``U = R^T T``, ``rho = T . T`` and ``T x R`` is a quadratic form, and every
constraint is made of these forms. Each kind is stated here, in `forms_of`, over any numbers: floats
and arrays of them, sums of doubles, balls, fractions, residues.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from itertools import chain
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import ANGLE_KINDS, DHP, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.geometry.quaternions import Field

#: Positions of the forms in the list that `forms` returns: N, then N times R (rows), T, U, rho
#: and W with W[i][j] = (T x R e_j)_i (rows), then e . f.
NORM = 0
ROTATION = tuple(tuple(1 + 3 * i + j for j in range(3)) for i in range(3))
TRANSLATION = (10, 11, 12)
BODY = (13, 14, 15)
RHO = 16
MOMENT = tuple(tuple(17 + 3 * i + j for j in range(3)) for i in range(3))
STUDY = 26
COUNT = 27


def product(p: Sequence[Any], q: Sequence[Any]) -> list[Any]:
    """Return the product of two quaternions."""
    p0, p1, p2, p3 = p
    q0, q1, q2, q3 = q
    return [
        p0 * q0 - p1 * q1 - p2 * q2 - p3 * q3,
        p0 * q1 + p1 * q0 + p2 * q3 - p3 * q2,
        p0 * q2 + p2 * q0 + p3 * q1 - p1 * q3,
        p0 * q3 + p3 * q0 + p1 * q2 - p2 * q1,
    ]


def motion(point: Sequence[Any]) -> tuple[Any, list[list[Any]], list[Any]]:
    """Return N, N R by rows and N T of a Study point, in the arithmetic of its coordinates."""
    w, x, y, z = point[:4]
    ww, xx, yy, zz = w * w, x * x, y * y, z * z
    wx, wy, wz, xy, xz, yz = w * x, w * y, w * z, x * y, x * z, y * z
    rotation = [
        [ww + xx - yy - zz, 2 * (xy - wz), 2 * (xz + wy)],
        [2 * (xy + wz), ww - xx + yy - zz, 2 * (yz - wx)],
        [2 * (xz - wy), 2 * (yz + wx), ww - xx - yy + zz],
    ]
    moved = product(point[4:], [w, -x, -y, -z])
    return ww + xx + yy + zz, rotation, [2 * entry for entry in moved[1:]]


def forms(point: Sequence[Any]) -> list[Any]:
    """Return all forms at a Study point, in the order of the constants above."""
    e, f = list(point[:4]), list(point[4:])
    conjugate = [e[0], -e[1], -e[2], -e[3]]
    norm, rotation, translation = motion(point)
    body = [2 * entry for entry in product(conjugate, f)[1:]]
    rho = 4 * sum(entry * entry for entry in f)
    units = [[int(i == j + 1) for i in range(4)] for j in range(3)]
    columns = [product(product(f, unit), conjugate)[1:] for unit in units]
    moments = [2 * columns[j][i] for i in range(3) for j in range(3)]
    study = sum(a * b for a, b in zip(e, f, strict=True))
    return [norm, *chain(*rotation), *translation, *body, rho, *moments, study]


def forms_of_pose(R: Sequence[Sequence[Any]] | NDArray[Any], T: Vector) -> list[Any]:
    """Return all forms of a pose with N = 1, in the same order."""
    body = [sum(R[i][j] * T[i] for i in range(3)) for j in range(3)]
    rho = sum(entry * entry for entry in T)
    moments = [
        T[(i + 1) % 3] * R[(i + 2) % 3][j] - T[(i + 2) % 3] * R[(i + 1) % 3][j]
        for i in range(3)
        for j in range(3)
    ]
    return [1, *chain(*R), *T, *body, rho, *moments, 0]


@cache
def form_hessians() -> NDArray[np.float64]:
    """Return the Hessian matrices of all forms, integers, shape (27, 8, 8)."""
    units = np.eye(8, dtype=int)
    single = np.array(forms(list(units)))
    both = np.array(forms(list(units[:, :, None] + units[:, None, :])))
    result: NDArray[np.float64] = (both - single[:, :, None] - single[:, None, :]).astype(float)
    result.setflags(write=False)
    return result


def study_points(R: Field, T: Field) -> tuple[Field, NDArray[np.intp]]:
    """Return Study points of poses, each in a real patch.

    Parameters
    ----------
    R, T
        Complex rotations, shape (n, 3, 3), and translations, shape (n, 3).

    Returns
    -------
    points
        Complex, shape (n, 8); the coordinate of the patch is 1.
    patches
        For each point the index of the largest coordinate of e, shape (n,).
    """
    r = np.moveaxis(np.asarray(R, complex), 0, -1)
    # The products e_j e_k, times four, for N = 1. Every sum and product is rounded in this order:
    # the digits do not depend on the processor.
    ij, ik, jk = r[1, 0] + r[0, 1], r[0, 2] + r[2, 0], r[2, 1] + r[1, 2]
    i, j, k = r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]
    x, y, z = r[0, 0], r[1, 1], r[2, 2]
    squares = 1 + x + y + z, 1 + x - y - z, 1 - x + y - z, 1 - x - y + z
    products = np.array(
        [
            [squares[0], i, j, k],
            [i, squares[1], ij, ik],
            [j, ij, squares[2], jk],
            [k, ik, jk, squares[3]],
        ]
    )
    rows = np.arange(len(R))
    sizes = np.array([square.real**2 + square.imag**2 for square in squares])
    patches = np.argmax(sizes, axis=0)
    column = products[patches, :, rows]
    e = _product(column, 1 / np.take_along_axis(column, patches[:, None], axis=1))
    np.put_along_axis(e, patches[:, None], 1, axis=1)
    (a, b, c, d), (u, v, w) = e.T, np.asarray(T, complex).T
    f = (
        -(_product(u, b) + _product(v, c) + _product(w, d)),
        _product(u, a) + (_product(v, d) - _product(w, c)),
        _product(v, a) + (_product(w, b) - _product(u, d)),
        _product(w, a) + (_product(u, c) - _product(v, b)),
    )
    return np.concatenate((e, np.stack(f, axis=1) / 2), axis=1), patches


def _product(x: Field, y: Field) -> Field:
    """Return products of complex numbers, each part rounded after each operation.

    NumPy's own products differ in the last digit between processors.
    """
    found = np.empty(np.broadcast(x, y).shape, complex)
    found.real = x.real * y.real - x.imag * y.imag
    found.imag = x.real * y.imag + x.imag * y.real
    return found


#: A combination of the forms: coefficients by their position.
Form = dict[int, Any]
#: Three numbers; of arrays, their components are along the first axis.
Vector: TypeAlias = "Sequence[Any] | NDArray[Any]"


def scaled(form: Form, factor: Any) -> Form:
    """Return a multiple of a form."""
    return {position: coefficient * factor for position, coefficient in form.items()}


def rotation_form(left: Vector, right: Vector) -> Form:
    """Return N ``left . R right``."""
    return {ROTATION[i][j]: left[i] * right[j] for i in range(3) for j in range(3)}


def square_distance(a: Vector, b: Vector) -> Form:
    """Return N ``|R a + T - b|^2``, the paper's equation (6)."""
    moved = [-2 * x for x in b]
    form = rotation_form(moved, a) | {NORM: _dot(a, a) + _dot(b, b), RHO: 1}
    return form | dict(zip(TRANSLATION, moved, strict=True)) | {BODY[k]: 2 * a[k] for k in range(3)}


def base_height(a: Vector, b: Vector, v: Vector) -> Form:
    """Return N ``v . (R a + T - b)`` with v fixed in the base."""
    return rotation_form(v, a) | {NORM: -_dot(v, b)} | dict(zip(TRANSLATION, v, strict=True))


def platform_height(a: Vector, b: Vector, u: Vector) -> Form:
    """Return N ``R u . (R a + T - b)`` with u fixed in the platform."""
    turned = rotation_form([-x for x in b], u)
    return turned | {NORM: _dot(u, a)} | dict(zip(BODY, u, strict=True))


def plane_height(a: Vector, b: Vector, u: Vector) -> Form:
    """Return N times the height of b over the plane through a with the normal u."""
    return platform_height(a, b, [-x for x in u])


def mutual_moment(a: Vector, b: Vector, u: Vector, v: Vector) -> Form:
    """Return N ``(R a + T - b) . (R u x v)``."""
    # It is v . R (a x u) + v . (T x R u) - (v x b) . R u.
    form = rotation_form(v, _cross(a, u))
    for position, coefficient in rotation_form(_cross(v, b), u).items():
        form[position] = form[position] - coefficient
    return form | {MOMENT[i][j]: v[i] * u[j] for i in range(3) for j in range(3)}


def _directions(a: Vector, b: Vector, u: Vector, v: Vector) -> list[Form]:
    return [rotation_form(v, u)]


_FORMS: dict[Kind, Callable[[Vector, Vector, Vector, Vector], list[Form]]] = {
    DPP: lambda a, b, u, v: [square_distance(a, b)],
    DPL: lambda a, b, u, v: [square_distance(a, b), base_height(a, b, v)],
    DLP: lambda a, b, u, v: [square_distance(a, b), platform_height(a, b, u)],
    DPH: lambda a, b, u, v: [base_height(a, b, v)],
    DHP: lambda a, b, u, v: [plane_height(a, b, u)],
    DLL: lambda a, b, u, v: [mutual_moment(a, b, u, v), rotation_form(v, u)],
    **dict.fromkeys(ANGLE_KINDS, _directions),
}


def forms_of(kind: Kind, a: Vector, b: Vector, u: Vector, v: Vector) -> list[Form]:
    """Return the quadrics of a constraint without its value, one or two.

    For an angle it is the product of the directions, for a plane the height of the point. For two
    points it is the square of their distance. A point and a line have this square and the height
    along the line. Two lines have the mutual moment and the product of the directions.

    Parameters
    ----------
    kind
        Of the constraint.
    a, b
        A point of the platform and of the base primitive.
    u, v
        Their directions or normals; those of points are not used.

    Raises
    ------
    KeyError
        If the kind is not one of the ten.
    """
    return _FORMS[kind](a, b, u, v)


def _dot(a: Vector, b: Vector) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector, b: Vector) -> list[Any]:
    return [a[j] * b[k] - a[k] * b[j] for j, k in ((1, 2), (2, 0), (0, 1))]
