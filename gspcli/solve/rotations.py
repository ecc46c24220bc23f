"""The rotations that satisfy three angle constraints (Section 6.1, Proposition 6.1).

An angle constraint is linear in R, so times ``N = e.e`` a real quadric in the quaternion space
P^3. Three of them meet in eight points, or in infinitely many. Points with N = 0 are no rotations;
they are at infinity.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.poses import Field, dot, rotated_forms
from gspcli.geometry.quadrics import all_roots, generic_roots, made_real, real_points
from gspcli.geometry.surfaces import certainly_not_zero
from gspcli.solve.infinity import refined_rotation

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

#: The number of rotations in general (Proposition 6.1).
ROTATIONS = 8
#: A multiple point, a quaternion of norm 1, is at infinity if |N| is not larger than this.
_INFINITY = 1e-9
#: Simple points with a larger error relative to N are refined.
_ACCURACY = 1e-11
_EPS = float(np.finfo(float).eps)
#: The same for points on components, which are less accurate.
_SAMPLE_INFINITY = 1e-7
#: Two real linear forms without special position.
_FORMS = np.array([[0.31, 0.53, -0.83, 0.17], [0.71, -0.29, 0.37, 0.59]])


@dataclass(frozen=True, eq=False)
class RotationGroup:
    """Isolated rotations.

    Attributes
    ----------
    e
        Quaternions of norm 1, shape (f, 4).
    multiplicity
        Of each, shape (f,).
    errors
        Their estimated errors, shape (f,).
    """

    e: Field
    multiplicity: NDArray[np.int64]
    errors: Array


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
        Quaternions on positive-dimensional components, shape (m, 4).
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
    return np.asarray(rotated_forms(u, v) - cosines[..., None, None] * np.eye(4))


def rotations(forms: Array) -> list[Rotations]:
    """Return, for each three quadrics of angles, all rotations.

    Parameters
    ----------
    forms
        From `angle_forms`, shape (b, 3, 4, 4).
    """
    e, errors, ok = generic_roots(forms)
    norm = np.abs(dot(e, e))
    ok &= (certainly_not_zero(norm, errors) & (errors < _ACCURACY * norm)).all(axis=-1)
    imaginary = (e.imag != 0).any(axis=-1)
    # Conjugates come one directly after the other.
    first = imaginary & (np.cumsum(imaginary, axis=-1) % 2 == 1)
    return [
        _simple(e[k], errors[k], ~imaginary[k], first[k]) if ok[k] else _careful(forms[k])
        for k in range(len(forms))
    ]


def _simple(
    e: Complex, errors: Array, real: NDArray[np.bool_], upper: NDArray[np.bool_]
) -> Rotations:
    """Return the record of eight simple finite points, marked as real or upper."""
    ones = np.ones(ROTATIONS, int)
    return Rotations(
        real=RotationGroup(e[real].real, ones[real], errors[real]),
        upper=RotationGroup(e[upper], ones[upper], errors[upper]),
        samples=np.zeros((0, 4), complex),
        at_infinity=0,
        on_curves=0,
        lost=0,
    )


def _careful(forms: Field) -> Rotations:
    """Return the rotations of quadrics in any position."""
    roots = all_roots(forms)
    e, errors, multiplicity = roots.points.copy(), roots.errors.copy(), roots.multiplicity
    samples = roots.samples
    norm = np.abs(dot(e, e))
    finite = certainly_not_zero(norm, errors)
    # A multiple point may only be called infinite if N is as good as zero.
    infinite = ~finite & (norm < _INFINITY)
    # R is only as accurate as N is.
    for k in ((multiplicity == 1) & (~finite | (errors > _ACCURACY * norm))).nonzero()[0]:
        e[k], decided = refined_rotation(forms, e[k])
        finite[k], infinite[k] = decided is True, decided is False
        errors[k] = _EPS
    real = finite & real_points(e)
    # The quotient of two real linear forms tells conjugates apart by its imaginary part.
    quotient = (e @ _FORMS[0]) / (e @ _FORMS[1])
    upper = finite & ~real & (quotient.imag > 0)
    on_curve = np.abs(dot(samples, samples)) > _SAMPLE_INFINITY
    at_infinity = int(multiplicity[infinite].sum())
    known = multiplicity[real].sum() + 2 * multiplicity[upper].sum() + len(samples)
    return Rotations(
        real=RotationGroup(made_real(e[real]), multiplicity[real], errors[real]),
        upper=RotationGroup(e[upper], multiplicity[upper], errors[upper]),
        samples=samples[on_curve],
        at_infinity=at_infinity + int((~on_curve).sum()),
        on_curves=int(on_curve.sum()),
        lost=ROTATIONS - at_infinity - int(known),
    )
