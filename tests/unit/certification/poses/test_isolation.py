from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from flint import acb, arb, ctx

from gspcli.certification import certify
from gspcli.certification.equations.ball_system import BallSystem, pose_of_point
from gspcli.certification.numbers.balls import float_above, largest
from gspcli.certification.poses.isolation import Isolation, _newton, _prove, refine_point

ONE = acb(1)


def isolated(instance, T: list[float]) -> Isolation:
    return certify(instance, [np.eye(3)], [T])[0].isolation


def record(imaginary: float, error: float, uniqueness: float) -> Isolation:
    centre = (ONE, acb(0, imaginary), *(acb(0),) * 6)
    return Isolation(centre, 0, (0,) * 6, arb(error), uniqueness, 64)


@pytest.mark.parametrize(
    ("imaginary", "error", "uniqueness", "real"),
    [
        (0, 0, 0.1, True),
        (0.01, 0.02, 0.0625, True),
        (0.01, 0.02, 0.03, None),
        (0.02, 0.02, 0.05, None),
        (0.02, 0.01, 0.1, False),
        (1e-300, 0, 0.1, False),
    ],
)
def test_reality_follows_from_the_two_radii(
    imaginary: float, error: float, uniqueness: float, real: bool | None
) -> None:
    assert record(imaginary, error, uniqueness).real is real


def test_the_ball_contains_its_solution_and_no_other(tangent: Callable) -> None:
    instance = tangent(1 + Fraction(1, 10**6))
    z = np.sqrt(2e-6 + 1e-12)
    above, copy, below = (isolated(instance, [1, 0, x]) for x in (z, z + 1e-10, -z))
    with ctx.workprec(64):
        assert above.contains(copy)
        assert copy.contains(above)
        assert not above.contains(below)
        # The same numbers as a solution of other equations would be another solution.
        assert not above.contains(replace(copy, sides=(0, 0, 0, 0, 1, 0)))


def test_a_ball_is_the_same_in_another_patch(known: Callable) -> None:
    platform = known("DPP DPL DLP DPH DHP DLL", 12)
    R, T = platform.floats
    first = certify(platform.instance, [R], [T])[0].isolation
    with ctx.workprec(64):
        system = BallSystem(platform.instance, 64)
        for patch in range(4):
            scaled = [(x / first.centre[patch]).mid() for x in first.centre]
            scaled[patch] = ONE
            other = refine_point(system, scaled, patch, first.sides)
            assert isinstance(other, Isolation)
            assert first.contains(other)
            assert other.contains(first)


@pytest.mark.parametrize("share", [1, 0.5, 0.25])
def test_the_error_is_bounded_even_by_a_poor_inverse(share: float, known: Callable) -> None:
    """With a share of the inverse the step is that share of the true error only."""
    platform = known("DPP DPL DLP DPH DHP DLL", 12)
    R, T = platform.floats
    solution = certify(platform.instance, [R], [T])[0].isolation
    with ctx.workprec(64):
        system = BallSystem(platform.instance, 64)
        moved = [x if k == solution.patch else x + 1e-7 for k, x in enumerate(solution.centre)]
        moved = [x.mid() for x in moved]
        newton = _newton(system, moved, solution.patch, solution.sides)
        poor = replace(
            newton, inverse=newton.inverse * share, length=(newton.length * share).upper()
        )
        proof = _prove(system, poor, solution.patch, solution.sides)
        gap = largest([x - y for x, y in zip(moved, solution.centre, strict=True)])
        assert proof.error > gap * (1 - 1e-3)
        assert proof.uniqueness > proof.error


def test_too_poor_an_inverse_proves_nothing(known: Callable) -> None:
    platform = known("DPP DPL DLP DPH DHP DLL", 12)
    R, T = platform.floats
    solution = certify(platform.instance, [R], [T])[0].isolation
    with ctx.workprec(64):
        system = BallSystem(platform.instance, 64)
        newton = _newton(system, list(solution.centre), solution.patch, solution.sides)
        for factor in (0, 2, -1):
            poor = replace(newton, inverse=newton.inverse * factor)
            assert _prove(system, poor, solution.patch, solution.sides) is None


def test_all_of_the_uniqueness_ball_leads_to_the_one_solution(known: Callable) -> None:
    platform = known("DPL DPL DLL ALL ALH AHH", 5)
    R, T = platform.floats
    solution = certify(platform.instance, [R], [T])[0].isolation
    source = np.random.default_rng(3)
    with ctx.workprec(64):
        system = BallSystem(platform.instance, 64)
        for _ in range(20):
            shift = source.uniform(-1, 1, 8) + 1j * source.uniform(-1, 1, 8)
            shift *= solution.uniqueness / np.abs(shift).max()
            shift[solution.patch] = 0
            start = [(x + y).mid() for x, y in zip(solution.centre, shift.tolist(), strict=True)]
            found = refine_point(system, start, solution.patch, solution.sides)
            assert isinstance(found, Isolation)
            assert solution.contains(found)


def test_a_point_with_vanishing_norm_is_no_pose() -> None:
    assert pose_of_point([ONE, acb(0, 1), *(acb(0),) * 6]) is None
    assert pose_of_point([ONE, acb(0, arb(1, 1e-9)), *(acb(0),) * 6]) is None
    assert pose_of_point([ONE, *(acb(0),) * 7]) is not None


def test_floats_above_are_above() -> None:
    third = arb(1) / 3
    assert arb(float_above(third)) > third
    assert float_above(arb(2) ** -3000) > 0
    assert float_above(arb.nan()) != float_above(arb.nan())
