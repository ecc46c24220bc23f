"""The rotations that satisfy three angle constraints (Section 6.1, Proposition 6.1).

An angle constraint is linear in R, so times ``N = e.e`` a real quadric in the quaternion space
P^3. Three of them meet in eight points, or in infinitely many. Points with N = 0 are no rotations;
they are at infinity.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.poses import ROTATION_FORMS, Field, dot, rotation_from_quaternion
from gspcli.geometry.quadrics import all_roots, generic_roots, made_real, real_points

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

#: The number of rotations in general (Proposition 6.1).
ROTATIONS = 8
#: Quaternions of norm 1 with a smaller |N| are at infinity.
_INFINITY = 1e-12
#: The same for points on components, which are less accurate.
_SAMPLE_INFINITY = 1e-7
#: Two real linear forms without special position.
_FORMS = np.array([[0.31, 0.53, -0.83, 0.17], [0.71, -0.29, 0.37, 0.59]])


@dataclass(frozen=True, eq=False)
class RotationGroup:
    """Isolated rotations.

    Attributes
    ----------
    R
        The rotations, shape (f, 3, 3).
    multiplicity
        Of each, shape (f,).
    errors
        Their estimated errors, shape (f,).
    """

    R: Field
    multiplicity: NDArray[np.int64]
    errors: Array

    @classmethod
    def of(cls, e: Field, multiplicity: NDArray[np.int64], errors: Array) -> RotationGroup:
        """Return the rotations of quaternions of norm 1 with known errors."""
        return cls(rotation_from_quaternion(e), multiplicity, errors / np.abs(dot(e, e)))


@dataclass(frozen=True, eq=False)
class Rotations:
    """The solutions of three angle constraints.

    Attributes
    ----------
    real
        The real ones, real arrays.
    upper
        One of each pair of conjugates that are not real, complex arrays.
    samples
        Rotations on positive-dimensional components, shape (m, 3, 3).
    at_infinity, on_curves, lost
        How many of the eight are at infinity, on components, or could not be made out.
    """

    real: RotationGroup
    upper: RotationGroup
    samples: Complex
    at_infinity: int
    on_curves: int
    lost: int


def angle_forms(u: Array, v: Array, cosines: Array) -> Array:
    """Return the quadrics of ``R u . v = cosine`` in quaternions, (..., 3) -> (..., 4, 4)."""
    linear = (v[..., :, None] * u[..., None, :]).reshape(*u.shape[:-1], 9) @ ROTATION_FORMS
    return linear.reshape(*u.shape[:-1], 4, 4) - cosines[..., None, None] * np.eye(4)


def rotations(u: Array, v: Array, cosines: Array) -> list[Rotations]:
    """Return, for each row of cosines, all rotations with ``R u_k . v_k = cosine_k``.

    Parameters
    ----------
    u, v
        Unit vectors of the platform and of the base, shape (3, 3).
    cosines
        Shape (b, 3).
    """
    forms = angle_forms(u, v, cosines)
    e, errors, ok = generic_roots(forms)
    finite = np.abs(dot(e, e)) > np.maximum(_INFINITY, 100 * errors)
    imaginary = (e.imag != 0).any(axis=-1)
    # Conjugates come one directly after the other.
    first = imaginary & (np.cumsum(imaginary, axis=-1) % 2 == 1)
    return [
        _simple(e[k], errors[k], finite[k] & ~imaginary[k], finite[k] & first[k])
        if ok[k]
        else _careful(forms[k])
        for k in range(len(forms))
    ]


def _simple(
    e: Complex, errors: Array, real: NDArray[np.bool_], upper: NDArray[np.bool_]
) -> Rotations:
    """Return the record of eight simple points, the finite ones marked as real or upper."""
    ones = np.ones(ROTATIONS, int)
    return Rotations(
        real=RotationGroup.of(e[real].real, ones[real], errors[real]),
        upper=RotationGroup.of(e[upper], ones[upper], errors[upper]),
        samples=np.zeros((0, 3, 3), complex),
        at_infinity=ROTATIONS - int(real.sum()) - 2 * int(upper.sum()),
        on_curves=0,
        lost=0,
    )


def _careful(forms: Field) -> Rotations:
    """Return the rotations of quadrics in any position."""
    roots = all_roots(forms)
    e, samples = roots.points, roots.samples
    finite = np.abs(dot(e, e)) > np.maximum(_INFINITY, 100 * roots.errors)
    real = finite & real_points(e)
    # The quotient of two real linear forms tells conjugates apart by its imaginary part.
    quotient = (e @ _FORMS[0]) / (e @ _FORMS[1])
    upper = finite & ~real & (quotient.imag > 0)
    on_curve = np.abs(dot(samples, samples)) > _SAMPLE_INFINITY
    mult = roots.multiplicity
    known = mult[~finite].sum() + mult[real].sum() + 2 * mult[upper].sum() + len(samples)
    return Rotations(
        real=RotationGroup.of(made_real(e[real]), mult[real], roots.errors[real]),
        upper=RotationGroup.of(e[upper], mult[upper], roots.errors[upper]),
        samples=rotation_from_quaternion(samples[on_curve]),
        at_infinity=int(mult[~finite].sum() + (~on_curve).sum()),
        on_curves=int(on_curve.sum()),
        lost=ROTATIONS - int(known),
    )
