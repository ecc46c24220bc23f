"""Differences of values in combinations of nearly dependent equations."""

from fractions import Fraction

import numpy as np
import pytest

from gspcli.certification.poses.far_poses import Shifts, Values
from gspcli.certification.poses.many_values import ValueProofs
from gspcli.geometry.building import hexapod

BASE = np.array([[3, 0, 0], [0, 3, 0], [-3, 0, 0], [0, -3, 0], [2, 2, 1], [-2, -2, 1]])
LENGTHS = ["1.1", "1.7", "2.3", "1.9", "1.3", "4/3"]
#: One combination is 1e12 times as large as the others.
MATRIX = np.eye(6) + 1e12 * np.outer([0, 0, 0, 0, 0, 1], [0.3, -0.7, 0.1, 1.3, -0.9, 0.2])


def shifts_of(rows, lengths=LENGTHS):
    instance = hexapod(BASE, 0.5 * BASE, LENGTHS)
    known = ValueProofs(instance, None)
    choice = np.ones(6)
    own = Values.of(known, choice, None, known.values(choice[None])[0], known.scale)
    shifts = Shifts(MATRIX, own, known.scale)
    proofs = ValueProofs(hexapod(BASE, 0.5 * BASE, lengths), rows)
    values = proofs.values(choice[None], rows)[:, 0]
    return known.scale, shifts.of(proofs, choice, rows, values)


def exact(scale, row):
    """Return the products with the matrix in rational numbers."""
    own = [Fraction(x) for x in LENGTHS]
    differences = [
        (Fraction(x) ** 2 - y**2) / Fraction(scale) ** 2 for x, y in zip(row, own, strict=True)
    ]
    return [
        sum(Fraction(a) * d for a, d in zip(line, differences, strict=True))
        for line in MATRIX.tolist()
    ]


def check(scale, row, found):
    for k, wanted in enumerate(exact(scale, row)):
        error = abs(Fraction(found[0, k]) + Fraction(found[1, k]) - wanted)
        assert error <= Fraction(found[2, k])
        assert found[2, k] <= 2.0**-90 * abs(found[0, k])


def test_sets_of_values_are_doubles_that_are_meant_exactly():
    own = np.array([float(Fraction(x)) for x in LENGTHS])
    rows = own + np.random.default_rng(2).uniform(-0.1, 0.1, (3, 6))
    # The last differs by the rounding of decimals only: 1e-17, times 1e12.
    rows[2] = own
    scale, found = shifts_of(rows)
    for row, each in zip(rows.tolist(), found, strict=True):
        check(scale, row, each)


def test_values_of_an_instance_are_exact():
    lengths = ["1.1000000000000001", "1.7", "2.3", "5/3", "1.3", "1.33333"]
    scale, found = shifts_of(None, lengths)
    check(scale, lengths, found[0])


@pytest.mark.parametrize("longest", ["1.7", "70"])
def test_values_that_are_no_fractions_err(longest):
    """Also where the unit of length of the other values is larger."""
    lengths = ["sqrt(1.3)", longest, "2.3", "5/3", "1.3", "1.33333"]
    scale, found = shifts_of(None, lengths)
    wanted = exact(scale, ["1", *lengths[1:]])
    more = Fraction(3, 10) / Fraction(scale) ** 2
    for k, x in enumerate(wanted):
        error = abs(
            Fraction(found[0, 0, k]) + Fraction(found[0, 1, k]) - x - Fraction(MATRIX[k, 0]) * more
        )
        assert error <= Fraction(found[0, 2, k])
    # Beside the rounding of the sum, the error of this value, 2^-96 of it, times the matrix.
    of_value = found[0, 2, 5] - 2.0**-96 * abs(found[0, 0, 5])
    assert of_value == pytest.approx(0.3e12 * 1.3 / scale**2 * 2.0**-96, rel=0.1, abs=0)
