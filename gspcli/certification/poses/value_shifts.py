"""Differences of values from those of a platform, in combinations of nearly dependent equations.

A combination that is smaller than the equations by eps is divided by it
(`gspcli.continuation.balance`). Errors of the values are divided by eps, too. So distances are
rational numbers here.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from flint import fmpq, fmpq_mat
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DPH, DPP
from gspcli.certification.numbers.doubled import ERROR, Doubled
from gspcli.certification.numbers.rounding import OUTWARD
from gspcli.certification.poses.many_values import ValueProofs

Array = NDArray[np.float64]


class Values(NamedTuple):
    """Values of equations, lengths in a unit.

    Attributes
    ----------
    exact
        Rational numbers for each set of values, (b, 6).
    gaps
        How much they err, shape (b, 6).
    """

    exact: list[list[fmpq]]
    gaps: Array

    @classmethod
    def of(
        cls, proofs: ValueProofs, choice: Array, rows: Array | None, given: Array, unit: float
    ) -> Values:
        """Return sets of values.

        Parameters
        ----------
        proofs, choice, rows
            As for `FarPoses.beside`.
        given
            The values in the form of the kernel (`ValueProofs.values`), shape (b, 6, 6).
        unit
            The unit of length.
        """
        # Powers of two: exact.
        ratio = proofs.scale / unit
        factors = [ratio ** (2 * kind.is_distance - kind.has_sides) for kind in proofs.kinds]
        gaps = given[:, 4] * factors
        sets: list[Sequence[Fraction | None]]
        if rows is None:
            sets = [[row.value.fraction for row in proofs.instance.constraints]]
        else:
            sets = [[Fraction(x) for x in row] for row in rows.tolist()]
        exact = []
        for row, found in enumerate(sets):
            numbers = []
            for k, (kind, x) in enumerate(zip(proofs.kinds, found, strict=True)):
                if x is None or kind not in (DPP, DPH, DHP):
                    inexact = _rational(given[row, 0, k]) + _rational(given[row, 3, k])
                    numbers.append(inexact * _rational(factors[k]))
                    continue
                gaps[row, k] = 0.0
                height = fmpq(x.numerator, x.denominator) / _rational(unit)
                numbers.append(height**2 if kind is DPP else height * int(choice[k]))
            exact.append(numbers)
        return cls(exact, gaps)


class Shifts(NamedTuple):
    """Differences from the values of a platform, times a matrix.

    Attributes
    ----------
    matrix
        The matrix, whose numbers are meant exactly, shape (6, 6).
    own
        The values of the platform.
    unit
        Their unit of length.
    """

    matrix: Array
    own: Values
    unit: float

    def of(self, proofs: ValueProofs, choice: Array, rows: Array | None, given: Array) -> Array:
        """Return the products for sets of values, as sums of two, and how much they err: (b, 3, 6).

        The parameters are those of `Values.of`.
        """
        values = Values.of(proofs, choice, rows, given, self.unit)
        differences = [
            [x - y for x, y in zip(each, self.own.exact[0], strict=True)] for each in values.exact
        ]
        turned = fmpq_mat([[_rational(x) for x in row] for row in self.matrix.T.tolist()])
        found = np.array([_doubled(x) for x in (fmpq_mat(differences) * turned).entries()]).reshape(
            -1, len(self.matrix), 3
        )
        gaps = (values.gaps + self.own.gaps) @ np.abs(self.matrix).T
        found[..., 2] += gaps
        return np.ascontiguousarray(np.moveaxis(found * (1.0, 1.0, OUTWARD), 2, 1))


def _rational(x: float) -> fmpq:
    return fmpq(*x.as_integer_ratio())


def _doubled(x: fmpq) -> tuple[float, float, float]:
    """Return a sum of two doubles next to a number, and how much it errs."""
    high, low, size = Doubled.of_ratio(int(x.p), int(x.q))
    return high, low, size * ERROR
