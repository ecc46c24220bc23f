"""Numbers in balls, rounded correctly, against fractions."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from flint import acb, arb, ctx, fmpq

from gspcli.certification.numbers.correct_rounding import GRID, SMALL, rounded


@pytest.fixture(autouse=True)
def many_bits():
    with ctx.workprec(1200):
        yield


def ball(number: Fraction, radius: float = 0.0) -> arb:
    return arb(fmpq(number.numerator, number.denominator)) + arb(0, radius)


def expected(number: Fraction, unit: Fraction) -> float:
    """Return the nearest double, or below `SMALL` units the nearest multiple of `GRID` units."""
    if abs(number) >= SMALL * unit:
        return float(number)
    return float(round(number / (GRID * unit)) * GRID * unit)


def one(number: arb, unit: float = 1.0) -> float | None:
    """Return what a number becomes beside another one that sets the unit."""
    found = rounded([acb(0.75 * unit), acb(number)], real=True)
    return None if found is None else float(found[1].real)


@pytest.mark.parametrize("unit", [1.0, 2.0**-30, 2.0**40])
def test_numbers_of_all_sizes_are_rounded_as_fractions_are(unit):
    rng = np.random.default_rng(1)
    for exponent in range(-90, 0):
        number = Fraction(int(rng.integers(2**62, 2**63)), 2**63) * 2 ** Fraction(exponent)
        number *= int(rng.choice([-1, 1])) * Fraction(unit) * Fraction(2, 3)
        found = one(ball(number, unit * 2.0**-300), unit)
        assert found == expected(number, Fraction(unit))


def test_the_grid_begins_where_the_unit_says():
    quarter = Fraction(1, 4)
    for sign in (1, -1):
        # Just above SMALL a double has digits that a multiple of GRID has not, and half of them.
        above = sign * (SMALL + GRID + quarter * GRID)
        below = sign * (SMALL - GRID - quarter * GRID)
        assert one(ball(below, 2.0**-200)) == float(sign * (SMALL - GRID))
        assert one(ball(above, 2.0**-200)) == float(above)
        # A greater number beside it makes it small.
        assert one(ball(above, 2.0**-200), 4.0) == float(sign * SMALL)
    for k in range(-8, 9):
        number = Fraction(k, 3) * GRID
        assert one(ball(number, 2.0**-200)) == float(round(Fraction(k, 3)) * GRID)


def test_the_unit_is_above_all_numbers_and_not_below_the_least():
    number = Fraction(1, 3 * 2**20)
    for largest, unit in ((0.99, 1), (1.0, 2), (-1.5, 2), (3.0, 4)):
        found = rounded([acb(0, largest), acb(ball(number))], real=False)
        assert found[1] == expected(number, Fraction(unit))
        assert found[0] == 1j * largest
    found = rounded([acb(ball(number))], real=True, least_unit=1.0)
    assert found[0] == expected(number, Fraction(1)) != float(number)
    assert rounded([acb(ball(number))], real=True)[0] == float(number)


def test_exact_ties_go_to_the_even_one():
    for k in (0, 1):
        low = Fraction(2**52 + k, 2**53)
        tie = low + Fraction(1, 2**54)
        for sign in (1, -1):
            assert one(ball(sign * tie)) == float(sign * tie)
            even = low if k == 0 else low + Fraction(1, 2**53)
            assert one(ball(sign * tie)) == sign * float(even)
        # As near as that a number counts as the tie; a little farther it is beside it.
        for off in (0, Fraction(1, 2**960), -Fraction(1, 2**960)):
            assert one(ball(tie + off, 2.0**-950)) == float(tie)
        assert one(ball(tie + Fraction(1, 2**200), 2.0**-300)) == float(low + Fraction(1, 2**53))
        assert one(ball(tie - Fraction(1, 2**200), 2.0**-300)) == float(low)
    assert one(ball(GRID / 2)) == 0.0
    assert one(ball(3 * GRID / 2)) == float(2 * GRID)


def test_balls_that_are_too_large_are_refused():
    number = Fraction(2, 3)
    gap = Fraction(float(number)) - number
    assert abs(gap) < Fraction(1, 2**54)
    assert one(ball(number, 2.0**-56)) == float(number)
    assert one(ball(number, 2.0**-52)) is None
    assert one(ball(Fraction(1, 2) + Fraction(1, 2**54), 2.0**-100)) is None
    # Near zero the grid counts.
    assert one(ball(Fraction(0), 2.0**-70)) == 0.0
    assert one(ball(Fraction(0), 2.0**-64)) is None
    assert one(arb.nan()) is None
    assert one(arb(0, math.inf)) is None
    assert rounded([acb(1, arb(0, 1))], real=False) is None


def test_imaginary_parts_of_real_numbers_do_not_count():
    found = rounded([acb(0.5, arb(0, 1)), acb(0.25, 1e-30)], real=True)
    assert found.tolist() == [0.5, 0.25]
    assert not np.signbit(found.imag).any()


def test_zero_has_one_sign():
    for number in (Fraction(0), -GRID / 3, GRID / 3, -Fraction(1, 2**300)):
        found = one(ball(number, 2.0**-400))
        assert found == 0.0
        assert not np.signbit(found)
    found = rounded([acb(1), acb(0, ball(-GRID / 3))], real=False)
    assert not np.signbit(found.real).any()
    assert not np.signbit(found.imag).any()
