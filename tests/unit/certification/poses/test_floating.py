"""Proofs in floating point against exact arithmetic, known solutions and proofs in balls."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest
from flint import acb, arb, ctx
from floating_reference import evaluated, reference
from gspcli.certification.poses.floating import Doubles, Proofs, deviations, prove

from gspcli.catalogue.kinds import DISTANCE_KINDS
from gspcli.catalogue.types import all_types
from gspcli.certification import certify, decide
from gspcli.certification.equations import study
from gspcli.certification.equations.ball_system import BallSystem
from gspcli.certification.equations.pose_balls import pose_of_floats, pose_of_point
from gspcli.certification.equations.study import TRANSLATION, study_points
from gspcli.certification.numbers.rounding import ROUNDING
from gspcli.certification.poses.distinct import all_different
from gspcli.certification.poses.isolation import Isolation, refine_point
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.solver import solve
from gspcli.solver.generate import random_instance

TYPES = [
    *(" ".join([kind.name] * 6) for kind in DISTANCE_KINDS),
    "DPP DPL DLP DPH DHP DLL",
    "DPL DLP DLL ALL ALH AHH",
]


def proofs(instance: Instance, R: np.ndarray, T: np.ndarray) -> Proofs:
    with ctx.workprec(64):
        system = BallSystem(instance, 64)
        R, T = np.asarray(R, complex), np.asarray(T, complex)
        return prove(system, R.reshape(-1, 3, 3), T.reshape(-1, 3) / system.scale)


def points_of_all_sizes(count: int) -> np.ndarray:
    rng = np.random.default_rng(7)
    points = rng.normal(size=(count, 8)) + 1j * rng.normal(size=(count, 8))
    return points * 10.0 ** rng.uniform(-6, 6, size=(count, 8))


@pytest.mark.parametrize("names", TYPES)
def test_errors_of_values_and_jacobians_are_bounded(names: str, known: Callable) -> None:
    points = points_of_all_sizes(40)
    with ctx.workprec(64):
        equations = Doubles(BallSystem(known(names, 3).instance, 64))
        sides = equations.sides(points)
    with ctx.workprec(400):
        exact = BallSystem(known(names, 3).instance, 400)
        values, jacobian, value_moduli, jacobian_moduli = evaluated(equations, points, sides)
        for k, point in enumerate(points):
            there = exact.at([acb(x) for x in point.tolist()], sides[k].tolist())
            for i in range(7):
                error = abs(there[0][i, 0] - complex(values[k, i]))
                assert error <= ROUNDING * float(value_moduli[k, i])
                assert abs(there[0][i, 0]) <= float(value_moduli[k, i]) * (1 + ROUNDING)
                for j in range(8):
                    error = abs(there[1][i, j] - complex(jacobian[k, i, j]))
                    assert error <= ROUNDING * float(jacobian_moduli[k, i, j])


@pytest.mark.parametrize("radius", [0.0, 1e-12, 1e-6, 1e-3])
def test_deviations_bound_those_of_balls(radius: float) -> None:
    rng = np.random.default_rng(2)
    R = rotation_from_quaternion(rng.normal(size=(30, 4)) + 1j * rng.normal(size=(30, 4)))
    T = rng.normal(size=(30, 3)) + 1j * rng.normal(size=(30, 3))
    points, patches = study_points(R, T)
    bounds = deviations(points, np.full(30, radius), R, T)
    assert np.isfinite(bounds).any()
    with ctx.workprec(200):
        for point, patch, bound, rotation, place in zip(points, patches, bounds, R, T, strict=True):
            for signs in rng.choice([-1, 1], size=(20, 8)):
                ends = [acb(x) + arb(radius) * int(s) for x, s in zip(point, signs, strict=True)]
                ends[patch] = acb(1)
                pose = pose_of_point(ends)
                assert pose is not None
                assert pose.deviation(pose_of_floats(rotation, place, 1.0))[1] <= float(bound)


@pytest.mark.parametrize("names", TYPES)
@pytest.mark.parametrize("sided", [True, False])
def test_a_known_solution_is_proved_and_within_its_deviation(
    names: str, sided: bool, known: Callable
) -> None:
    platform = known(names, 11, sided=sided)
    R, T = platform.floats
    found = proofs(platform.instance, R, T)
    assert found.isolated.all()
    assert found.real.all()
    assert not found.complex.any()
    scale = BallSystem(platform.instance, 64).scale
    exact = [x for row in platform.R for x in row] + [x / Fraction(scale) for x in platform.T]
    given = [*R.ravel().tolist(), *(T / scale).tolist()]
    errors = [abs(x - Fraction(y)) for x, y in zip(exact, given, strict=True)]
    assert max(errors) <= Fraction(float(found.deviation[0]))
    assert found.deviation[0] < 1e-7


@pytest.mark.parametrize("names", TYPES)
def test_what_is_proved_is_proved_in_balls_too(names: str, known: Callable) -> None:
    """From near and from far, at solutions and at none."""
    platform = known(names, 5)
    rng = np.random.default_rng(6)
    R, T = platform.floats
    for size in (1e-12, 1e-8, 1e-5, 1e-3, 1e-1):
        turns = rotation_from_quaternion(np.r_[1, size * rng.normal(size=3)])
        pose = turns @ R + 0j, T + size * rng.normal(size=3) + size * 1j * rng.normal(size=3)
        found = proofs(platform.instance, *pose)
        if not found.isolated[0]:
            continue
        with ctx.workprec(128):
            system = BallSystem(platform.instance, 128)
            points, patches = study_points(pose[0][None], pose[1][None] / system.scale)
            point = [acb(x) for x in points[0].tolist()]
            sides = system.sides_near(point, pose_of_floats(*pose, system.scale), (0,) * 6)[0]
            proof = refine_point(system, point, int(patches[0]), sides)
            assert isinstance(proof, Isolation)
            assert proof.real == bool(found.real[0]) != bool(found.complex[0])
            there = pose_of_floats(pose[0], pose[1], system.scale)
            reached = pose_of_point(proof.point)
            assert reached is not None
            assert reached.deviation(there)[0] <= float(found.deviation[0])


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


def test_few_forms_have_a_monomial_in_common() -> None:
    """The number of roundings that `ROUNDING` allows for depends on it."""
    assert (study.form_hessians() != 0).sum(axis=0).max() == 4
    assert np.abs(study.form_hessians()[: TRANSLATION[-1] + 1]).sum(axis=2).max() == 2


def test_nearly_all_poses_are_proved_in_floating_point() -> None:
    shares = []
    for number in range(1, 3850, 350):
        instance, _ = random_instance(all_types()[number - 1], np.random.default_rng(number))
        poses = solve(instance, certify=False)
        found = proofs(instance, poses.R, poses.T)
        shares.append((found.isolated & (found.real | found.complex)).mean())
    assert np.mean(shares) > 0.95


@pytest.mark.parametrize("number", [1, 700, 1500, 2300, 3100, 3850])
def test_the_kernel_proves_what_the_reference_proves(number: int) -> None:
    instance, _ = random_instance(all_types()[number - 1], np.random.default_rng(number))
    poses = solve(instance, certify=False)
    with ctx.workprec(64):
        system = BallSystem(instance, 64)
        R, T = poses.R[:100], poses.T[:100] / system.scale
        found, expected = prove(system, R, T), reference(system, R, T)
    # Its bounds of moduli are larger, by the root of two in each product.
    assert not (found.isolated & ~expected.isolated).any()
    assert (found.isolated >= expected.isolated).mean() > 0.95
    known = found.isolated
    assert not (found.real & expected.complex)[known].any()
    assert not (found.complex & expected.real)[known].any()
    ours, theirs = found.deviation[known], deviations(expected.points, expected.error, R, T)[known]
    assert (ours < 10 * theirs + 1e-15).all()
    assert (theirs < 10 * ours + 1e-15).all()


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
    assert not proofs(tangent(Fraction(1)), *pair).isolated.any()
    assert not decide(tangent(Fraction(1)), *pair).certified.any()


@pytest.mark.parametrize("exponent", [4, 6, 8, 10, 12, 20])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_close_pair_is_told_real_or_not_real(exponent: int, sign: int, tangent: Callable) -> None:
    instance = tangent(1 + sign * Fraction(1, 10**exponent))
    z = np.sqrt(complex(sign * 2 * 10.0**-exponent))
    pair = [np.eye(3)] * 2, [[1, 0, z], [1, 0, -z]]
    found = proofs(instance, *pair)
    assert not (found.isolated & (found.complex if sign > 0 else found.real)).any()
    assert found.isolated.all() or exponent > 6
    decisions = decide(instance, *pair)
    assert decisions.certified.all()
    assert decisions.real.tolist() == [sign > 0] * 2


def test_poses_are_different_only_beyond_their_deviations() -> None:
    rng = np.random.default_rng(1)
    entries = rng.normal(size=(50, 12)) + 1j * rng.normal(size=(50, 12))
    assert all_different(entries, np.full(50, 1e-6))
    near = np.concatenate((entries, entries[20:21]))
    assert not all_different(near, np.zeros(51))
    near[50, 4] += 2.5e-6
    assert all_different(near, np.full(51, 1e-6))
    assert not all_different(near, np.full(51, 1.3e-6))
    assert all_different(entries[:0], np.zeros(0))


def test_coefficients_of_any_size_are_taken_exactly(known: Callable) -> None:
    """A coefficient that cancels is known worse than its double: its bound says so."""
    instance = known("DPP DPP DPP DPP DPP DPP", 4).instance
    with ctx.workprec(20):
        rough = BallSystem(instance, 20)
        equations = Doubles(rough)
    with ctx.workprec(200):
        exact = BallSystem(instance, 200)
        points = points_of_all_sizes(5)
        values, _, moduli, _ = evaluated(equations, points, np.zeros((5, 6), int))
        for k, point in enumerate(points):
            there = exact.at([acb(x) for x in point.tolist()], (0,) * 6)[0]
            for i in range(7):
                error = abs(there[i, 0] - complex(values[k, i]))
                assert error <= ROUNDING * float(moduli[k, i])
