"""Examples 6.2 and 6.8 in exact radicals."""

import pytest
from sympy import Rational, eye, radsimp, sqrt, zeros

from gspcli.errors import GspError
from gspcli.symbolic.examples import equal_numbers, example_6_2_rotations, example_6_8_points


def _exact(matrix):
    return matrix.applyfunc(lambda entry: radsimp(entry).expand())


def test_the_eight_rotations_are_rotations_with_the_given_angles():
    rotations = example_6_2_rotations()
    assert len({tuple(rotation) for rotation in rotations}) == 8
    for rotation in rotations:
        assert _exact(rotation.T * rotation - eye(3)) == zeros(3)
        assert radsimp(rotation.det()).expand() == 1
        assert [rotation[k, k] for k in range(3)] == [Rational(1, 2)] * 3
        assert all(entry.is_real for entry in rotation)


def test_other_angles():
    cosines = (Rational(1, 3), Rational(1, 4), Rational(-1, 5))
    rotation = example_6_2_rotations(*cosines)[0]
    assert all(entry.equals(0) for entry in rotation.T * rotation - eye(3))
    assert [rotation[k, k] for k in (2, 1, 0)] == list(cosines)


@pytest.mark.parametrize(
    ("cosines", "word"),
    [
        ((1, Rational(1, 4), Rational(1, 5)), "r33"),
        ((Rational(1, 2),) * 2 + (Rational(1, 4),), "h3"),
    ],
)
def test_special_angles_are_refused(cosines, word):
    with pytest.raises(GspError, match=word):
        example_6_2_rotations(*cosines)


def test_the_eight_points_lie_on_the_cylinders():
    points = example_6_8_points(6, 4, 5)
    assert len(set(points)) == 8
    for x, y, z in points:
        assert (x**2 + y**2, x**2 + z**2, y**2 + z**2) == (36, 16, 25)


def test_equal_numbers_is_exact():
    assert equal_numbers("1/(-1+sqrt(5))", str((1 + sqrt(5)) / 4))
    assert not equal_numbers("1/(-1+sqrt(5))", "0.80901699437494742")
    assert not equal_numbers("1/(-1+sqrt(5))", "1/(1-sqrt(5))")
