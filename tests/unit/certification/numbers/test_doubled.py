"""Exact numbers as sums of two doubles: the remainder is bounded."""

from fractions import Fraction

import numpy as np
import pytest

from gspcli.certification.numbers.doubled import ERROR, Doubled, doubled, two_product
from gspcli.geometry.numbers import Number

LONG = Fraction(2**53 + 1, 3**40)


@pytest.mark.parametrize(
    "value",
    [
        "0.1",
        "-12.345",
        "1/3",
        "-7/11",
        "0",
        "2",
        "1e-30",
        "9007199254740991/9007199254740989",
        LONG,
    ],
)
def test_a_quotient_is_the_sum_of_its_doubles_as_nearly_as_is_said(value):
    exact = Fraction(value)
    ((high,), (low,), (size,)) = doubled([Number.of(value)])
    assert abs(Fraction(high) + Fraction(low) - exact) <= Fraction(ERROR) * abs(exact) / 256
    assert high == float(exact)
    assert size == abs(high)


def test_all_sorts_of_numbers_together_are_as_each_alone():
    root = Number("sqrt", (Number.of(3),))
    numbers = [Number.of("0.7"), root, Number.of(LONG), Number.of(-4)]
    found = doubled(numbers).T
    for row, number in zip(found, numbers, strict=True):
        np.testing.assert_allclose(row, Doubled.of(number), rtol=1e-15, atol=0)
        assert row[0] == Doubled.of(number).high


def test_what_doubles_leave_of_products_is_exact():
    rng = np.random.default_rng(27)
    small = rng.uniform(0, 1e-20, 99)
    a, b = rng.normal(size=(2, 999)) * 1e5
    for x, y in ((a, b), (small, small), (np.array([0.0, 1.0, 3.0]), np.array([2.0, -1.0, 3.0]))):
        products, rest = two_product(x, y)
        for p, q, high, low in zip(*(z.tolist() for z in (x, y, products, rest)), strict=True):
            assert Fraction(p) * Fraction(q) == Fraction(high) + Fraction(low)


def test_differences_of_almost_equal_numbers_keep_all_their_digits():
    number = Number.of("sqrt(2) - 1.41421356237309504880168872420969")
    found = Doubled.of(number)
    # By mpmath with 60 digits.
    assert found.high == pytest.approx(8.078569671875377e-33, rel=1e-15, abs=0)
    assert found.size == found.high
