"""Exact numbers as sums of two doubles: what is left is known."""

from fractions import Fraction

import numpy as np
import pytest

from gspcli.certification.doubled import ERROR, Doubled, doubled, two_product
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
    ((high, low, size),) = doubled([Number.of(value)])
    assert abs(Fraction(high) + Fraction(low) - exact) <= Fraction(ERROR) * abs(exact) / 256
    assert high == float(exact)
    assert size == abs(high)


def test_all_sorts_of_numbers_together_are_as_each_alone():
    root = Number("sqrt", (Number.of(3),))
    numbers = [Number.of("0.7"), root, Number.of(LONG), Number.of(-4)]
    found = doubled(numbers)
    for row, number in zip(found, numbers, strict=True):
        np.testing.assert_allclose(row, Doubled.of(number), rtol=1e-15, atol=0)
        assert row[0] == Doubled.of(number).high


def test_products_are_exact():
    a, b = np.random.default_rng(1).normal(size=(2, 1000)) * 1e5
    product, rest = two_product(a, b)
    for x, y, p, r in zip(a.tolist(), b.tolist(), product.tolist(), rest.tolist(), strict=True):
        assert Fraction(x) * Fraction(y) == Fraction(p) + Fraction(r)
