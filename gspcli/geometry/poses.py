"""Poses: rotation and translation, quaternion, Study parameters.

All functions take leading batch axes and complex numbers. The conventions are those of the
whole package: ``x_base = R x_platform + T``; quaternions and Study parameters are scalar-first;
``e.f = 0`` and ``N = e.e`` is not zero. Over the complex numbers a dot product is bilinear, so a
complex "rotation" satisfies ``R^T R = 1`` without any conjugate.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Real or complex floating-point numbers.
Field = NDArray[Any]


def dot(a: Field, b: Field) -> Field:
    """Return the bilinear product of vectors, ``(..., n), (..., n) -> (...)``."""
    products: Field = np.einsum("...i,...i->...", a, b)
    return products


def normalised(z: Field) -> Field:
    """Return vectors divided by their Hermitian norm, ``(..., n)``."""
    scaled: Field = z / np.sqrt((z.real**2 + z.imag**2).sum(axis=-1, keepdims=True))
    return scaled


def cross(a: Field, b: Field) -> Field:
    """Return the vector product, ``(..., 3), (..., 3) -> (..., 3)``."""
    a0, a1, a2 = a[..., 0], a[..., 1], a[..., 2]
    b0, b1, b2 = b[..., 0], b[..., 1], b[..., 2]
    return np.stack((a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0), axis=-1)


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


def rotated_forms(u: Field, v: Field) -> Field:
    """Return the symmetric forms of ``N v . R u``, ``(..., 3), (..., 3) -> (..., 4, 4)``."""
    outer = v[..., :, None] * u[..., None, :]
    forms: Field = (outer.reshape(*outer.shape[:-2], 9) @ ROTATION_FORMS).reshape(
        *outer.shape[:-2], 4, 4
    )
    return forms


def rotation_from_quaternion(e: Field) -> Field:
    """Return the rotation of a quaternion of any nonzero ``N``, ``(..., 4) -> (..., 3, 3)``."""
    outer = (e[..., :, None] * e[..., None, :]).reshape(*e.shape[:-1], 16)
    scaled = outer @ ROTATION_FORMS.T / dot(e, e)[..., None]
    return scaled.reshape(*e.shape[:-1], 3, 3)


def quaternion_from_rotation(R: Field) -> Field:
    """Return the quaternion of a rotation with ``e.e = 1``, ``(..., 3, 3) -> (..., 4)``.

    Of the two signs the one is returned whose first component that is not zero (to nine
    digits) has a positive real part, or a vanishing real and a positive imaginary part.
    """
    flat = R.reshape(*R.shape[:-2], 9)
    # The forms of N R are orthogonal with squared norm 4, except for the trace part N itself.
    identity = np.eye(4).reshape(16)
    outer = (flat @ ROTATION_FORMS + identity) / 4
    square = outer.reshape(*R.shape[:-2], 4, 4)
    diagonal = np.einsum("...ii->...i", square)
    largest = np.argmax(np.abs(diagonal), axis=-1)[..., None]
    column = np.take_along_axis(square, largest[..., None], axis=-1)[..., 0]
    e = column / np.sqrt(np.take_along_axis(diagonal, largest, axis=-1))
    return canonical_sign(e)


def canonical_sign(e: Field) -> Field:
    """Return ``e`` or ``-e`` by the rule of `quaternion_from_rotation`, ``(..., 4)``."""
    key = np.stack((e.real, e.imag), axis=-1).reshape(*e.shape[:-1], 8)
    key = np.round(key, 9)
    first = np.argmax(key != 0, axis=-1)[..., None]
    sign = np.where(np.take_along_axis(key, first, axis=-1) < 0, -1.0, 1.0)
    return e * sign


def study_from_pose(R: Field, T: Field) -> tuple[Field, Field]:
    """Return Study parameters ``(e, f)`` with ``N = 1``, each ``(..., 4)``."""
    e = quaternion_from_rotation(R)
    pure = np.concatenate((np.zeros_like(T[..., :1]), T), axis=-1)
    return e, quaternion_product(pure, e) / 2


def pose_from_study(e: Field, f: Field) -> tuple[Field, Field]:
    """Return ``(R, T)`` of Study parameters, ``(..., 4), (..., 4) -> (..., 3, 3), (..., 3)``.

    ``N`` must not vanish; a remainder of ``e.f`` is ignored (`T` is a vector part).
    """
    T = 2 * quaternion_product(f, conjugate(e))[..., 1:] / dot(e, e)[..., None]
    return rotation_from_quaternion(e), T


def rotation_from_vector(omega: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rotation about ``omega`` by ``|omega|`` radians, ``(..., 3) -> (..., 3, 3)``."""
    half = np.linalg.norm(omega, axis=-1, keepdims=True) / 2
    e = np.concatenate((np.cos(half), np.sinc(half / np.pi) * omega / 2), axis=-1)
    return rotation_from_quaternion(e)
