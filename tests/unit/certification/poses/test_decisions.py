"""Which of given poses are certified, by the kernel or in balls, against certificates."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest

from gspcli.catalogue.kinds import DISTANCE_KINDS
from gspcli.catalogue.types import all_types
from gspcli.certification import certify, decide
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.solver import solve
from gspcli.solver.generate import random_instance

TYPES = [
    *(" ".join([kind.name] * 6) for kind in DISTANCE_KINDS),
    "DPP DPL DLP DPH DHP DLL",
    "DPL DLP DLL ALL ALH AHH",
]


@pytest.mark.parametrize("number", range(1, len(all_types()) + 1, 355))
def test_decisions_are_those_of_certificates(number: int) -> None:
    instance, _ = random_instance(all_types()[number - 1], np.random.default_rng(number))
    poses = solve(instance, certify=False)
    R, T = poses.R[:40], poses.T[:40]
    certificates = certify(instance, R, T)
    decisions = decide(instance, R, T)
    assert decisions.certified.tolist() == [item.certified for item in certificates]
    assert decisions.real.tolist() == [item.real is True for item in certificates]
    assert decisions.certified.all()
    assert decisions.real.tolist() == poses.real[:40].tolist()


@pytest.mark.parametrize("names", TYPES)
@pytest.mark.parametrize("sided", [True, False])
def test_a_known_solution_is_rounded_correctly(names: str, sided: bool, known: Callable) -> None:
    platform = known(names, 11, sided=sided)
    R, T = platform.floats
    rng = np.random.default_rng(12)
    turn = rotation_from_quaternion(np.r_[1, 1e-9 * rng.normal(size=3)])
    found = decide(platform.instance, [turn @ R], [T + 1e-9 * rng.normal(size=3)])
    assert found.certified.all()
    assert found.real.all()
    # Rational numbers of ordinary size: that none is below 2^-12 units is seen from the result.
    np.testing.assert_array_equal(found.R[0], [[float(x) for x in row] for row in platform.R])
    np.testing.assert_array_equal(found.T[0], [float(x) for x in platform.T])


def test_duplicates_count_once(dietmaier: Instance, forty: tuple[np.ndarray, np.ndarray]) -> None:
    R, T = forty
    decisions = decide(dietmaier, np.concatenate((R, R[7:9])), np.concatenate((T, T[7:9] + 1e-9)))
    assert decisions.certified.tolist() == [True] * 40 + [False] * 2
    assert decisions.real[:40].all()


@pytest.mark.parametrize("size", [1e-4, 1e-2, 1.0])
def test_rough_poses_are_not_certified(size: float, known: Callable) -> None:
    platform = known("DPP DPL DLP DPH DHP DLL", 12)
    R, T = platform.floats
    assert decide(platform.instance, [R], [T]).certified.all()
    assert not decide(platform.instance, [R], [T + size * np.array([1, -1, 1])]).certified.any()


def test_a_matrix_that_is_no_rotation_is_not_certified(known: Callable) -> None:
    platform = known("DPP DPP DPP DPP DPP DPP", 3)
    R, T = platform.floats
    wrong = [-R, 1.001 * R, R[[1, 0, 2]], np.zeros((3, 3)), np.full((3, 3), np.nan)]
    assert not decide(platform.instance, wrong, [T] * 5).certified.any()
    assert (
        decide(platform.instance, [R, *wrong], [T] * 6).certified.tolist() == [True] + [False] * 5
    )


def test_a_double_root_is_never_proved(tangent: Callable) -> None:
    pair = [np.eye(3)] * 2, [[1, 0, 0], [1, 0, 1e-9]]
    assert not decide(tangent(Fraction(1)), *pair).certified.any()


@pytest.mark.parametrize("exponent", [4, 6, 8, 10, 12, 20])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_close_pair_is_told_real_or_not_real(exponent: int, sign: int, tangent: Callable) -> None:
    instance = tangent(1 + sign * Fraction(1, 10**exponent))
    z = np.sqrt(complex(sign * 2 * 10.0**-exponent))
    pair = [np.eye(3)] * 2, [[1, 0, z], [1, 0, -z]]
    decisions = decide(instance, *pair)
    assert decisions.certified.all()
    assert decisions.real.tolist() == [sign > 0] * 2
