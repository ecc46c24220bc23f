"""Exact numbers as sums of two doubles: the remainder is bounded."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from flint import arb, ctx

from gspcli.certification.numbers.doubled import ERROR, Doubled, doubled, sines, two_product
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


# Sines in 32 digits against balls.


@pytest.mark.parametrize("degrees", [True, False])
@pytest.mark.parametrize("complement", [True, False])
def test_sines_and_cosines_are_as_exact_as_they_say(degrees, complement):
    angles = np.concatenate((np.linspace(-90, 90, 999), [1e-300, 30, 89.99999999999999, -1e-17]))
    if complement:
        angles = np.abs(angles + 90)
    if not degrees:
        angles = np.radians(angles)
    high, low = sines(angles, np.array(complement), degrees=degrees)
    with ctx.workprec(200):
        for angle, parts in zip(angles.tolist(), zip(high, low, strict=True), strict=True):
            given = arb(angle) * (arb.pi() / 180 if degrees else 1)
            exact = given.cos() if complement else given.sin()
            error = exact - float(parts[0]) - float(parts[1])
            assert error.abs_upper() < ERROR / 4
            assert abs(parts[1]) <= 2.0**-53 * abs(parts[0])


def test_both_at_once_are_what_each_is_alone():
    angles = np.random.default_rng(1).uniform(0, 90, (4, 3))
    complements = np.array([True, False, True])
    for k, both in enumerate(sines(angles, complements, degrees=True)):
        for i in range(3):
            alone = sines(angles[:, i], complements[i], degrees=True)[k]
            np.testing.assert_array_equal(both[:, i], alone)


def test_right_angles_are_exact():
    assert [float(x[0]) for x in sines(np.array([90.0]), np.array(True), degrees=True)] == [0, 0]
    assert [float(x[0]) for x in sines(np.array([0.0]), np.array(False), degrees=True)] == [0, 0]
