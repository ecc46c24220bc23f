"""Residuals of the equations along a chord, in ball arithmetic.

Near a fold the proof of a segment (`gspcli.motion.following.chords`) multiplies residuals twice
with a large inverse matrix. Residuals in doubles have errors of 1e-14, so modes can be
distinguished down to distances of about 1e-5. Derivatives are not multiplied twice. So more
accurate residuals suffice; they are computed here.
"""

from __future__ import annotations

import flint
import numpy as np
from flint import arb, arb_poly, arb_series
from numpy.typing import NDArray

from gspcli.certification.branches.parametric_quadrics import Shape
from gspcli.certification.branches.taylor import Element, MovingSystem
from gspcli.certification.equations import study
from gspcli.certification.numbers.rounding import OUTWARD, TINY
from gspcli.records import dataclass

Array = NDArray[np.float64]

_PRECISION = 192
#: Degree of the polynomials in tau for the coefficients that move.
_DEGREE = 3


@dataclass(frozen=True)
class _Row:
    """One equation: its form, A and B in terms of the forms of a Study point, and c."""

    shape: Shape
    forms: list[dict[int, arb_poly]]
    factor: arb_poly


class ExactChords:
    """The equations on a part of the way between two rows, along any chords.

    Parameters
    ----------
    system
        What moves.
    rows
        As for `MovingSystem.equations`.
    begin, end
        The part, from 0 to 1; exact.
    """

    def __init__(
        self, system: MovingSystem, rows: tuple[Array, Array], begin: float, end: float
    ) -> None:
        with flint.ctx.workprec(_PRECISION):
            width = arb(end) - arb(begin)
            middle = (arb(begin) + arb(end)) / 2
            near = system.equations(rows, middle, width, _DEGREE)
            # Lagrange's form of the remainder.
            far = system.equations(rows, middle + arb(0, 0.5) * width, width, _DEGREE + 1)
            self.rows = [
                _Row(
                    shape,
                    [
                        {k: _polynomial(x, other[k]) for k, x in form.items()}
                        for form, other in zip(forms, others, strict=True)
                    ],
                    _polynomial(c, spread),
                )
                for ((shape, _, _, forms), c), ((_, _, _, others), spread) in zip(
                    near, far, strict=True
                )
            ]

    def residuals(self, z: Array, d: Array, count: int) -> tuple[Array, Array]:
        """Return the Study condition and the six equations along ``z + tau d``.

        Parameters
        ----------
        z, d
            The middle of the chord and the difference of its ends, shape (8,); exact.
        count
            How many coefficients to return.

        Returns
        -------
        values
            Coefficients of powers of tau, shape (7, count).
        errors
            Bounds of the remainders for ``|tau| <= 1/2``, shape (7,).
        """
        with flint.ctx.workprec(_PRECISION):
            point = [arb_poly([a, b]) for a, b in zip(z.tolist(), d.tolist(), strict=True)]
            forms = study.forms(point)
            n = forms[study.NORM]
            found = [forms[study.STUDY]]
            for row in self.rows:
                a, *rest = (_combined(form, forms) for form in row.forms)
                if row.shape is Shape.LINES:
                    found.append(a * a - row.factor * (n * n - rest[0] * rest[0]))
                elif row.shape is Shape.PRODUCT:
                    found.append(n * (a - row.factor * n) - rest[0] * rest[0])
                else:
                    found.append(a - row.factor * n)
            return _rounded(found, count)


def _polynomial(near: Element, far: Element) -> arb_poly:
    """Return an element as a polynomial whose last coefficient is a ball, for the remainder."""
    if not isinstance(near, arb_series):
        return arb_poly([near])
    rest = far[_DEGREE + 1] if isinstance(far, arb_series) else arb(0)
    return arb_poly([*(near[d] for d in range(_DEGREE + 1)), rest])


def _combined(form: dict[int, arb_poly], forms: list[arb_poly]) -> arb_poly:
    return sum((coefficient * forms[k] for k, coefficient in form.items()), arb_poly([0]))


def _rounded(polynomials: list[arb_poly], count: int) -> tuple[Array, Array]:
    values, errors = np.zeros((len(polynomials), count)), np.zeros(len(polynomials))
    for row, polynomial in enumerate(polynomials):
        for j, coefficient in enumerate(polynomial.coeffs()):
            if j < count:
                values[row, j] = float(coefficient.mid())
            left = coefficient - (values[row, j] if j < count else 0)
            errors[row] += 0.5**j * (float(left.abs_upper()) * OUTWARD + TINY)
    return values, errors * OUTWARD
