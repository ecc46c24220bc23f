"""Poses: rotation and translation, quaternion, Study parameters.

All functions take leading batch axes and complex numbers. The conventions are those of the
whole package: ``x_base = R x_platform + T``; quaternions and Study parameters are scalar-first;
``e.f = 0`` and ``N = e.e`` is not zero. Over the complex numbers a dot product is bilinear, so a
complex "rotation" satisfies ``R^T R = 1`` without any conjugate.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli import _kernel

#: Real or complex floating-point numbers.
Field = NDArray[Any]


def dot(a: Field, b: Field) -> Field:
    """Return the bilinear product of vectors, ``(..., n), (..., n) -> (...)``."""
    products: Field = np.einsum("...i,...i->...", a, b)
    return products


def normalized(z: Field) -> Field:
    """Return vectors divided by their Hermitian norm, ``(..., n)``."""
    square = np.einsum("...i,...i->...", z.conj(), z).real
    scaled: Field = z * (1 / np.sqrt(square))[..., None]
    return scaled


def cross(a: Field, b: Field) -> Field:
    """Return the vector product, ``(..., 3), (..., 3) -> (..., 3)``."""
    a0, a1, a2 = a[..., 0], a[..., 1], a[..., 2]
    b0, b1, b2 = b[..., 0], b[..., 1], b[..., 2]
    return np.stack((a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0), axis=-1)


def cross_matrix(a: Field) -> Field:
    """Return the matrices of vector products, ``cross_matrix(a) b = a x b``, (..., 3, 3)."""
    x, y, z = np.moveaxis(a, -1, 0)
    o = np.zeros_like(x)
    return np.stack((o, -z, y, z, o, -x, -y, x, o), axis=-1).reshape(*a.shape, 3)


def apply(R: Field, a: Field) -> Field:
    """Return ``R a``, ``(..., 3, 3), (..., 3) -> (..., 3)``."""
    turned: Field = np.einsum("...ij,...j->...i", R, a)
    return turned


def quaternion_product(a: Field, b: Field) -> Field:
    """Return the Hamilton product, ``(..., 4), (..., 4) -> (..., 4)``."""
    scalar = a[..., :1] * b[..., :1] - dot(a[..., 1:], b[..., 1:])[..., None]
    vector = a[..., :1] * b[..., 1:] + b[..., :1] * a[..., 1:] + cross(a[..., 1:], b[..., 1:])
    return np.concatenate((scalar, vector), axis=-1)


def conjugate(e: Field) -> Field:
    """Return the conjugate quaternion (vector part negated, nothing complex), ``(..., 4)``."""
    negated: Field = e * np.array([1.0, -1.0, -1.0, -1.0])
    return negated


def _quadratic_forms() -> NDArray[np.float64]:
    """Return the forms of ``N R_ij``, shape (9, 16): rows ij, columns products ``e_k e_l``."""
    forms = np.zeros((3, 3, 4, 4))
    for i in range(3):
        forms[i, i, 0, 0] = 1
        j, k = (i + 1) % 3, (i + 2) % 3
        forms[i, i, i + 1, i + 1] = 1
        forms[i, i, j + 1, j + 1] = forms[i, i, k + 1, k + 1] = -1
        forms[i, j, i + 1, j + 1] = forms[i, j, j + 1, i + 1] = 1
        forms[j, i, i + 1, j + 1] = forms[j, i, j + 1, i + 1] = 1
        forms[i, j, 0, k + 1] = forms[i, j, k + 1, 0] = -1
        forms[j, i, 0, k + 1] = forms[j, i, k + 1, 0] = 1
    return forms.reshape(9, 16)


#: ``N R = ROTATION_FORMS @ vec(e e^T)``: the symmetric forms of Euler and Rodrigues.
ROTATION_FORMS = _quadratic_forms()
_IDENTITY = np.eye(4).reshape(16)


def _translation_forms(sign: float) -> NDArray[np.float64]:
    """Return the bilinear forms of ``2 (e0 f_i - e_i f0 + sign (e x f)_i)``, shape (3, 4, 4)."""
    forms = np.zeros((3, 4, 4))
    for i in range(3):
        j, k = (i + 1) % 3 + 1, (i + 2) % 3 + 1
        forms[i, 0, i + 1], forms[i, i + 1, 0] = 2, -2
        forms[i, j, k], forms[i, k, j] = 2 * sign, -2 * sign
    return forms


#: ``N T_i = e^T TRANSLATION_FORMS[i] f``, and the same for ``U = R^T T``.
TRANSLATION_FORMS = _translation_forms(1.0)
BODY_TRANSLATION_FORMS = _translation_forms(-1.0)


def _pose_forms() -> NDArray[np.float64]:
    """Return the forms of N R and N T, columns, in the products ``e_k (e, f)_l``, rows."""
    forms = np.zeros((4, 8, 12))
    forms[:, :4, :9] = ROTATION_FORMS.T.reshape(4, 4, 9)
    forms[:, 4:, 9:] = TRANSLATION_FORMS.transpose(1, 2, 0)
    return forms.reshape(32, 12)


_POSE_FORMS = _pose_forms()


def rotation_from_quaternion(e: Field) -> Field:
    """Return the rotation of a quaternion of any nonzero ``N``, ``(..., 4) -> (..., 3, 3)``."""
    scaled = e * (1 / dot(e, e))[..., None]
    outer = (scaled[..., :, None] * e[..., None, :]).reshape(*e.shape[:-1], 16)
    return (outer @ ROTATION_FORMS.T).reshape(*e.shape[:-1], 3, 3)


def quaternion_from_rotation(R: Field) -> Field:
    """Return the quaternion of a rotation with ``e.e = 1``, ``(..., 3, 3) -> (..., 4)``.

    Of the two signs the one is returned whose first component that is not zero (to nine
    digits) has a positive real part, or a vanishing real and a positive imaginary part.
    """
    batch = R.shape[:-2]
    # The forms of N R are orthogonal with squared norm 4, except for the trace part N itself.
    outer = (R.reshape(-1, 9) @ ROTATION_FORMS + _IDENTITY) * 0.25
    diagonal = outer[:, ::5]
    largest = np.abs(diagonal).argmax(axis=1)
    rows = np.arange(len(outer))
    column = outer.reshape(-1, 4, 4)[rows, largest]
    e = column * (1 / np.sqrt(diagonal[rows, largest]))[:, None]
    return canonical_sign(e).reshape(*batch, 4)


def unit_quaternion(e: Field) -> Field:
    """Return one of the two multiples of a quaternion with ``e.e = 1``, ``(..., 4)``."""
    scaled: Field = e * (1 / np.sqrt(dot(e, e)))[..., None]
    return scaled


def canonical_sign(e: Field) -> Field:
    """Return ``e`` or ``-e`` by the rule of `quaternion_from_rotation`, ``(..., 4)``."""
    # Real parts before imaginary parts, component by component.
    parts = np.ascontiguousarray(e).view(np.float64).reshape(-1, 8 if np.iscomplexobj(e) else 4)
    key = parts.round(9)
    first = key[np.arange(len(key)), (key != 0).argmax(axis=1)]
    # No component is a negative zero.
    signed: Field = e * np.where(first < 0, -1.0, 1.0).reshape(*e.shape[:-1], 1) + 0.0
    return signed


def study_from_pose(R: Field, T: Field) -> tuple[Field, Field]:
    """Return Study parameters ``(e, f)`` with ``N = 1``, each ``(..., 4)``."""
    e = quaternion_from_rotation(R)
    pure = np.concatenate((np.zeros_like(T[..., :1]), T), axis=-1)
    return e, quaternion_product(pure, e) / 2


def pose_from_study(e: Field, f: Field) -> tuple[Field, Field]:
    """Return ``(R, T)`` of Study parameters, ``(..., 4), (..., 4) -> (..., 3, 3), (..., 3)``.

    ``N`` must not vanish; a remainder of ``e.f`` is ignored (`T` is a vector part).
    """
    scaled = e * (1 / dot(e, e))[..., None]
    outer = scaled[..., :, None] * np.concatenate((e, f), axis=-1)[..., None, :]
    pose = outer.reshape(*e.shape[:-1], 32) @ _POSE_FORMS
    return pose[..., :9].reshape(*e.shape[:-1], 3, 3), pose[..., 9:]


def rotation_from_vector(omega: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rotation about ``omega`` by ``|omega|`` radians, ``(..., 3) -> (..., 3, 3)``."""
    half = np.linalg.norm(omega, axis=-1, keepdims=True) / 2
    e = np.concatenate((np.cos(half), np.sinc(half / np.pi) * omega / 2), axis=-1)
    return rotation_from_quaternion(e)


def vector_from_rotation(R: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rotation vector (axis times angle, 0 to pi) of real rotations, (..., 3)."""
    e = unit_quaternion(quaternion_from_rotation(R))
    e = np.where(e[..., :1] < 0, -e, e)
    sine = np.linalg.norm(e[..., 1:], axis=-1, keepdims=True)
    # The angle over the sine of its half tends to two.
    factor = np.where(sine > 0, 2 * np.arctan2(sine, e[..., :1]) / np.where(sine > 0, sine, 1), 2)
    return np.asarray(factor * e[..., 1:])


Complex = NDArray[np.complex128]


def stable_order(
    real: NDArray[np.bool_], quaternions: Complex, translations: Complex, length: float
) -> NDArray[np.int64]:
    """Return the permutation that puts poses in order, shape (n,).

    Real poses come first. Then poses are compared by the components of the quaternion and of the
    translation in turn, real parts before imaginary parts, rounded to nine decimals (translations
    in powers of ten of the typical length). Poses that agree in all of these are compared with all
    their digits.

    Parameters
    ----------
    real
        Which poses are real, shape (n,).
    quaternions, translations
        Shapes (n, 4) and (n, 3).
    length
        The typical length.
    """
    unit = 10.0 ** math.floor(math.log10(length))
    return _kernel.order(
        np.ascontiguousarray(real),
        np.ascontiguousarray(quaternions),
        np.ascontiguousarray(translations),
        unit=unit,
    )


Array = NDArray[np.float64]


def made_real(points: Complex) -> Array:
    """Return real representatives of real points, norm 1, shape (..., n + 1)."""
    flat = points.reshape(-1, points.shape[-1])
    pivot = flat[np.arange(len(flat)), np.abs(flat).argmax(axis=1)]
    return np.asarray(normalized((flat * (1 / pivot)[:, None]).real).reshape(points.shape))
