"""Lines that are proved not to be parallel."""

import numpy as np
import pytest

from gspcli.catalogue.names import parse_type
from gspcli.certification.equations.skew_lines import are_skew
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.geometry.random_instances import random_instance


@pytest.fixture(scope="module")
def platform():
    return random_instance(parse_type("DPP DPP DPP DPL DLP DLL"), np.random.default_rng(1))[0]


def turned_to(platform, sine, rng):
    """Return a rotation that makes the lines include an angle of this sine."""
    row = platform.constraints[-1]
    u, v = row.platform.unit, row.base.unit
    across = np.cross(v, rng.normal(size=3))
    across /= np.linalg.norm(across)
    aim = np.sqrt(1 - sine**2) * v + sine * across

    def frame(first):
        third = np.cross(first, rng.normal(size=3))
        third /= np.linalg.norm(third)
        return np.column_stack((first, np.cross(third, first), third))

    return frame(aim) @ frame(u).T


@pytest.mark.parametrize("deviation", [1e-15, 1e-12, 1e-8, 1e-3])
def test_lines_that_may_be_parallel_are_not_proved_skew(platform, deviation):
    rng = np.random.default_rng(2)
    R = np.array([turned_to(platform, 0.0, rng) for _ in range(200)]).astype(complex)
    R += deviation * rng.choice([1, -1, 1j, -1j], R.shape)
    assert not are_skew(platform, R, np.full(len(R), deviation)).any()


def test_lines_at_a_small_angle_are_proved_skew_if_the_pose_is_known(platform):
    rng = np.random.default_rng(3)
    R = np.array([turned_to(platform, sine, rng) for sine in (1e-4, 1e-2, 0.5)]).astype(complex)
    for deviation, proved in ((1e-12, [1, 1, 1]), (1e-7, [0, 1, 1]), (1e-3, [0, 0, 1])):
        assert are_skew(platform, R, np.full(3, deviation)).tolist() == [bool(x) for x in proved]
    assert not are_skew(platform, R, np.full(3, np.nan)).any()
    assert not are_skew(platform, R * np.nan, np.zeros(3)).any()


def test_without_lines_at_a_distance_nothing_can_be_parallel():
    legs = random_instance(parse_type("6PP"), np.random.default_rng(4))[0]
    R = rotation_from_quaternion(np.ones((5, 4))).astype(complex)
    assert are_skew(legs, R, np.full(5, 1e-9)).all()
