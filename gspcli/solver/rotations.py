"""The rotations that satisfy three angle constraints (Section 6.1, Proposition 6.1).

An angle constraint is linear in R, so times ``N = e.e`` a real quadric in the quaternion space
P^3. Three of them meet in eight points, or in infinitely many. Points with N = 0 are no rotations;
they are at infinity.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.paths import Basis, PathAccount
from gspcli.geometry.conjugates import find_real_points
from gspcli.geometry.intersections import generic_points
from gspcli.geometry.quadric_intersections import all_roots
from gspcli.geometry.quaternions import Field, dot, rotated_forms
from gspcli.geometry.surfaces import certainly_not_zero
from gspcli.records import dataclass
from gspcli.solver.infinity import refined_rotation

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
_NOTHING = np.zeros((0, 4), complex)
_account = partial(PathAccount, expected=ROTATIONS, basis=Basis.COUNT)
_ALL_FOUND = _account(found=ROTATIONS)


@dataclass(frozen=True, eq=False)
class Rotations:
    """The solutions of three angle constraints.

    Attributes
    ----------
    e
        Isolated rotations: the real ones, exactly real, and one of each pair of conjugates that
        are not; quaternions of norm 1, shape (f, 4).
    real
        Which of them are real, shape (f,).
    multiplicity
        Of each, shape (f,).
    errors
        Their estimated errors, shape (f,).
    samples
        Quaternions on positive-dimensional components, shape (m, 4).
    account
        What became of the eight.
    """

    e: Complex
    real: NDArray[np.bool_]
    multiplicity: NDArray[np.int64]
    errors: Array
    samples: Complex
    account: PathAccount

    @property
    def are_general(self) -> bool:
        """Whether they are eight simple finite points."""
        return self.account is _ALL_FOUND


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
    count = len(forms)
    points, distances, solved = generic_points(
        np.empty((count, 1, 0, 4)), forms, np.full(count, _EPS), np.ones(count, bool)
    )
    e, errors = points[:, 0], distances[:, 0]
    norm = np.abs(dot(e, e))
    known = certainly_not_zero(norm, errors) & (errors < _ACCURACY * norm)
    ok = solved[:, 0] & known.all(axis=1)
    return [_simple(e[k], errors[k]) if ok[k] else _careful(forms[k]) for k in range(count)]


def _simple(e: Complex, errors: Array) -> Rotations:
    """Return the rotations of eight simple finite points."""
    imaginary = (e.imag != 0).any(axis=1)
    # Conjugates come one directly after the other.
    chosen = ~imaginary | (imaginary.cumsum() % 2 == 1)
    e, real = e[chosen], ~imaginary[chosen]
    ones = np.ones(len(e), int)
    return Rotations(e, real, ones, errors[chosen], _NOTHING, _ALL_FOUND)


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
    e, real = find_real_points(e)
    real &= finite
    # The quotient of two real linear forms tells conjugates apart by its imaginary part.
    quotient = (e @ _FORMS[0]) / (e @ _FORMS[1])
    chosen = real | (finite & (quotient.imag > 0))
    on_curve = np.abs(dot(samples, samples)) > _SAMPLE_INFINITY
    at_infinity = int(multiplicity[infinite].sum())
    at_infinity += int((~on_curve).sum())
    samples = samples[on_curve]
    found = int(multiplicity[chosen] @ np.where(real[chosen], 1, 2))
    lost = ROTATIONS - found - at_infinity - len(samples)
    if lost < 0:
        # Conjugates that do not pair contradict the number of points: nothing is known.
        return Rotations(
            _NOTHING, real[:0], multiplicity[:0], errors[:0], _NOTHING, _account(lost=ROTATIONS)
        )
    return Rotations(
        e=e[chosen],
        real=real[chosen],
        multiplicity=multiplicity[chosen],
        errors=errors[chosen],
        samples=samples,
        account=_account(found=found, at_infinity=at_infinity, on_curves=len(samples), lost=lost),
    )
