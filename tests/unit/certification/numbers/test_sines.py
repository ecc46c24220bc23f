"""Sines in 32 digits against balls."""

import numpy as np
import pytest
from flint import arb, ctx

from gspcli.certification.numbers.doubled import ERROR, sines


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
