"""The equations of an instance without its values: real quadrics in doubles, with error bounds.

For values that move, each constraint is one of these, with N = e.e and a number c that is the
square of the value, the value itself, or the cosine or sine of an angle:

* plain, ``A - c N = 0``: PP, PH and HP with signed values, and angles;
* product, ``N (A - c N) = B^2``: PL and LP, A the quadric of PP, B the height along the line;
* lines, ``A^2 = c (N^2 - B^2)``: LL, with the mutual moment A and ``B = N Ru . v``.

Directions are divided by their lengths here, unlike in `ball_system`.
"""

from __future__ import annotations

from enum import IntEnum

import flint
import numpy as np
from flint import arb
from numpy.typing import NDArray

from gspcli.catalogue import kinds
from gspcli.catalogue.kinds import Kind
from gspcli.certification.equations.local_frames import length_scale
from gspcli.certification.equations.statement import statements
from gspcli.certification.numbers.balls import unit_vector
from gspcli.certification.numbers.rounding import CONVERSION, TINY
from gspcli.geometry import study
from gspcli.geometry.enclosures import above
from gspcli.geometry.instance import Array, Instance
from gspcli.records import dataclass

_PRECISION = 128
#: A bound of the relative error of norms of matrices that are computed in doubles.
_NORM_ERROR = 1e-9


class Shape(IntEnum):
    """The form of an equation; the numbers are those of native/branch_follower.hpp."""

    PLAIN = 0
    PRODUCT = 1
    LINES = 2


class ValueFunction(IntEnum):
    """The function that gives c for a value; numbers as in native/branch_follower.hpp."""

    SQUARE = 0
    LINEAR = 1
    COSINE = 2
    SINE = 3


@dataclass(frozen=True, eq=False)
class MovingEquations:
    """The equations of the six constraints, lengths in units of `scale`."""

    #: A power of two, the unit of length.
    scale: float
    #: Of each constraint, shape (6,).
    shapes: NDArray[np.int32]
    laws: NDArray[np.int32]
    #: The sign of c, shape (6,).
    signs: Array
    #: Hessian matrices of A and B (zero if there is none), shape (6, 2, 8, 8). They differ from the
    #: exact ones by less than 2^-50 of `moduli`.
    hessians: Array
    #: Upper bounds of the spectral norms of these matrices, and of those of the moduli of the terms
    #: that add up to their entries, shape (6, 2).
    spectral: Array
    moduli: Array

    def spectral_between(self, low: Array, high: Array) -> Array:
        """Bound the norms of the Hessian matrices of A - c N for all c in intervals, shape (6,).

        The norm is convex in c, so it is largest at an end.

        Parameters
        ----------
        low, high
            Ends of the intervals, shape (6,).
        """
        turning = np.diag([2.0] * 4 + [0.0] * 4)
        ends = [self.hessians[:, 0] - c[:, None, None] * turning for c in (low, high)]
        norms = np.abs(np.linalg.eigvalsh(np.stack(ends))).max(axis=(0, 2))
        return np.asarray(norms * (1 + _NORM_ERROR) + CONVERSION * self.moduli[:, 0])


def moving_equations(instance: Instance) -> MovingEquations:
    """Return the equations of an instance without its values.

    A DLL whose value is exactly zero has the plain equation ``A = 0``: its lines meet.
    """
    with flint.ctx.workprec(_PRECISION):
        rows, _ = ball_equations(instance)
        nearest, bounds = np.zeros((2, len(rows), 2, study.COUNT))
        for i, (_, _, _, forms) in enumerate(rows):
            for j, form in enumerate(forms):
                for k, coefficient in form.items():
                    nearest[i, j, k] = value = float(coefficient)
                    error = above(float((coefficient - value).abs_upper())) + TINY
                    bounds[i, j, k] = max(abs(value), error / CONVERSION)
        terms = study.form_hessians().reshape(study.COUNT, -1)
    hessians, moduli = nearest @ terms, bounds @ np.abs(terms)
    shape = (len(rows), 2, 8, 8)
    norms = [np.linalg.norm(m.reshape(shape), ord=2, axis=(2, 3)) for m in (hessians, moduli)]
    norms[1] = norms[1] * (1 + _NORM_ERROR)
    return MovingEquations(
        scale=length_scale(instance),
        shapes=np.array([shape for shape, _, _, _ in rows], np.int32),
        laws=np.array([law for _, law, _, _ in rows], np.int32),
        signs=np.array([sign for _, _, sign, _ in rows]),
        hessians=hessians.reshape(shape),
        spectral=norms[0] * (1 + _NORM_ERROR) + CONVERSION * norms[1],
        moduli=norms[1],
    )


#: Shape, law, sign of c, and the quadrics.
Equation = tuple[Shape, ValueFunction, float, list[study.Form]]


def ball_equations(instance: Instance) -> tuple[list[Equation], list[arb]]:
    """Return shape, law, sign and quadrics of each equation, and the units of the values.

    The working precision is used. The argument of the law is a value times its unit.
    """
    given = statements(instance)
    equations = [
        moving_equation(
            row.kind, row.a, row.b, unit_vector(row.u), unit_vector(row.v), is_zero=row.is_zero
        )
        for row in given
    ]
    return equations, [1 / row.unit for row in given]


def moving_equation(
    kind: Kind, a: list[arb], b: list[arb], u: list[arb], v: list[arb], *, is_zero: bool
) -> Equation:
    """Return shape, law, sign and quadrics of a constraint without its value.

    Parameters
    ----------
    kind
        Of the constraint.
    a, b
        A point of the platform and of the base primitive, in units of the scale.
    u, v
        Unit directions or normals; empty for points.
    is_zero
        Whether the value is always zero.
    """
    forms = study.forms_of(kind, a, b, u, v)
    if study.RHO in forms[0]:
        forms[0][study.RHO] = arb(1)
    if not kind.is_distance:
        law = ValueFunction.COSINE if kind.law.is_cosine else ValueFunction.SINE
        return Shape.PLAIN, law, float(kind.law.sign), forms
    if kind.law is kinds.Law.MOMENT:
        if is_zero:
            return Shape.PLAIN, ValueFunction.LINEAR, 1.0, forms[:1]
        return Shape.LINES, ValueFunction.SQUARE, 1.0, forms
    if kind.law is kinds.Law.SQUARE:
        return Shape.PRODUCT if u or v else Shape.PLAIN, ValueFunction.SQUARE, 1.0, forms
    return Shape.PLAIN, ValueFunction.LINEAR, 1.0, forms


# When a point moves: the quadric of a distance of two points, or of a point and a plane.


def moved_quadric(v: Array, other: Array, norm: float, *, on_platform: bool) -> Array:
    """Return the Hessian matrix of the change of ``|R a + T - b|^2 N`` when a or b changes by v.

    Parameters
    ----------
    v
        The change, or a derivative of the point, shape (3,).
    other
        The point of the other body, shape (3,).
    norm
        Half of the change, or derivative, of the square of the moving point's distance from its
        origin.
    on_platform
        Whether a moves, the point of the platform.

    Returns
    -------
    Array
        Shape (8, 8), in Study coordinates; correct to the rounding of doubles.
    """
    with flint.ctx.workprec(_PRECISION):
        change, fixed = ([arb(x) for x in part.tolist()] for part in (v, other))
        pair = (fixed, change) if on_platform else (change, fixed)
        form = study.scaled(study.rotation_form(*pair), -2)
        form[study.NORM] = arb(2 * norm)
        places = study.BODY if on_platform else study.TRANSLATION
        for k in range(3):
            form[places[k]] = (2 if on_platform else -2) * change[k]
        return _hessian(form)


def moved_height(base: Array, platform: Array) -> Array:
    """Return the Hessian matrix of ``b.(R a) N`` for vectors b of the base and a of the platform.

    One is the change of a point, the other the normal of the plane from which it has a height.
    Shape (8, 8), as `moved_quadric`.
    """
    with flint.ctx.workprec(_PRECISION):
        vectors = ([arb(x) for x in part.tolist()] for part in (base, platform))
        return _hessian(study.rotation_form(*vectors))


def _hessian(form: dict[int, arb]) -> Array:
    numbers = np.array([float(form.get(k, 0)) for k in range(study.COUNT)])
    return np.asarray(np.einsum("f,fij->ij", numbers, study.form_hessians()))
