"""None"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from flint import acb, acb_mat, arb, ctx

from gspcli.certification import certify
from gspcli.certification.equations.ball_system import BallSystem, PoseBall, pose_of_point
from gspcli.certification.numbers.balls import float_above, largest
from gspcli.certification.poses.isolation import (
    REACH,
    Isolation,
    _Newton,
    _newton,
    _prove,
    all_different,
    close_pairs,
    places,
    refine_point,
)

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


# The theorem of `isolation` on equations whose solutions are known: no claim is false.


SIDES = (0,) * 6


class MadeUp:
    """A polynomial in the first free coordinate; the others are zero."""

    precision = 128

    def __init__(self, coefficients: Sequence[complex]) -> None:
        self.polynomial = np.polynomial.Polynomial(coefficients)
        #: Its second derivative, with moduli for coefficients.
        self.bend = np.polynomial.Polynomial(np.abs(self.polynomial.deriv(2).coef))

    def at(self, point: Sequence[acb], sides: Sequence[int]) -> tuple[acb_mat, acb_mat]:
        x = point[1]
        value, slope = (
            sum((acb(c) * x**k for k, c in enumerate(p.coef.tolist())), acb(0))
            for p in (self.polynomial, self.polynomial.deriv())
        )
        rows = [[acb(k == i + 1) for k in range(8)] for i in range(7)]
        rows[0][1] = slope
        return acb_mat(7, 1, [value, *point[2:]]), acb_mat(rows)

    def curvatures(self, moduli: np.ndarray) -> np.ndarray:
        return np.array([self.bend(moduli[1]), *[0.0] * 6])

    def proved(self, x: complex, *, share: float = 1.0) -> Isolation | None:
        """Return what is proved at a point, with a share of the inverse."""
        with ctx.workprec(self.precision):
            centre = [acb(1), acb(x), *[acb(0)] * 6]
            newton = _newton(self, centre, 0, SIDES)
            if newton is None:
                return None
            poor = _Newton(
                newton.centre,
                newton.jacobian,
                newton.inverse * share,
                newton.step,
                (newton.length * share).upper(),
                newton.noise,
            )
            return _prove(self, poor, 0, SIDES)

    def is_right(self, found: Isolation, x: complex) -> bool:
        """Whether one root is within the error, and no other root in the uniqueness ball."""
        gaps = np.sort(np.abs(self.polynomial.roots() - x))
        error = float(found.error) * (1 + 1e-9)
        return gaps[0] <= error and (len(gaps) < 2 or gaps[1] > found.uniqueness * (1 - 1e-9))


#: How long Newton's step is, as a part of 1 / b: a quarter is the most that is proved.
PARTS = np.array([0.05, 0.2, 0.24, 0.26, 0.3, 0.4, 0.49, 0.51, 0.6, 0.75])
TURNS = np.exp(1j * np.linspace(0, np.pi, 7))


@pytest.mark.parametrize("x", [1e-3, 0.1, 0.1j, 0.1 + 0.1j])
def test_of_two_roots_no_claim_is_false(x: complex) -> None:
    proved = 0
    for part, turn in product(PARTS, TURNS):
        # z^2 = w with a step of the part of x.
        system = MadeUp([-(x**2) * (1 - 2 * part * turn), 0, 1])
        found = system.proved(x)
        assert (found is not None) == (part < 0.25)
        if found is not None:
            proved += 1
            assert system.is_right(found, x)
    assert proved


@pytest.mark.parametrize("share", [0.3, 0.6, 1.4])
def test_with_a_poor_inverse_no_claim_is_false(share: float) -> None:
    claims = 0
    for part, turn in product((0.0, 0.05, 0.1, 0.2, 0.3), TURNS):
        system = MadeUp([-0.01 * (1 - 2 * part * turn), 0, 1])
        found = system.proved(0.1, share=share)
        if found is not None:
            claims += 1
            assert system.is_right(found, 0.1)
    assert claims


@pytest.mark.parametrize("factor", [0.25, 1.0, 60.0, 100.0, 4000.0])
def test_curvature_that_grows_is_bounded_in_all_of_the_ball(factor: float) -> None:
    """The roots of z + k z^3 are 0 and at a distance of k^(-1/2): for 100 that is below `REACH`."""
    system = MadeUp([0, 1, 0, factor])
    found = system.proved(0.0)
    assert found is not None
    assert found.uniqueness <= REACH
    assert system.is_right(found, 0.0)


def test_rows_of_what_is_not_one_are_summed() -> None:
    """Of two equations that are the same there are infinitely many solutions."""

    class Twice(MadeUp):
        def at(self, point: Sequence[acb], sides: Sequence[int]) -> tuple[acb_mat, acb_mat]:
            rows = [[acb(k == i + 1) for k in range(8)] for i in range(7)]
            for i in (0, 1):
                rows[i][1:3] = [acb(0.5) * (-1) ** i, acb(-0.5) * (-1) ** i]
            column = acb_mat(8, 1, list(point))
            return acb_mat(rows) * column, acb_mat(rows)

    system = Twice([0, 1])
    with ctx.workprec(128):
        centre = [acb(1), *[acb(0)] * 7]
        values, rows = system.at(centre, SIDES)
        jacobian = acb_mat([row[1:] for row in rows.tolist()])
        newton = _Newton(centre, jacobian, acb_mat(7, 7, 1), [acb(0)] * 8, arb(0), arb(0))
        assert largest(values.entries()) == 0
        assert _prove(system, newton, 0, SIDES) is None


def test_a_double_root_is_never_isolated() -> None:
    with ctx.workprec(128):
        for x in (0.0, 1e-30, 1e-9, 1e-3, 0.1):
            system = MadeUp([0, 0, 1])
            centre = [acb(1), acb(x), *[acb(0)] * 6]
            assert not isinstance(refine_point(system, centre, 0, SIDES), Isolation)


def record_of_contraction(x: complex, error: float, uniqueness: float) -> Isolation:
    centre = (acb(1), acb(x), *(acb(0),) * 6)
    return Isolation(centre, 0, SIDES, arb(error), uniqueness, 64)


@pytest.mark.parametrize(
    ("x", "error", "inside"),
    [(0.09, 0, True), (0.11, 0, False), (0.19, 0, False), (0.05, 0.04, True), (0.09, 0.02, False)],
)
@pytest.mark.parametrize("turn", [1, -1, 1j])
def test_what_a_ball_contains_lies_within_its_radius(
    x: float, error: float, inside: bool, turn: complex
) -> None:
    """The whole of the other ball counts: its solution may be anywhere in it."""
    assert (
        record_of_contraction(0, 0, 0.1).contains(record_of_contraction(x * turn, error, 0.2))
        is inside
    )


@pytest.mark.parametrize("imaginary", [0.03, 0.04, 0.06])
def test_a_solution_whose_conjugate_may_be_another_is_not_real(imaginary: float) -> None:
    """The conjugate of a solution within the error is as far as twice the height and the error."""
    assert record_of_contraction(imaginary * 1j, 0.07, 0.1).real is None


def test_only_what_is_off_the_real_numbers_by_more_than_its_error_is_not_real() -> None:
    assert record_of_contraction(0.01j, 0.011, 0.02).real is None
    assert record_of_contraction(0.01j, 0.009, 0.02).real is False


# Which of many poses are different, as far as they are known.


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


def test_the_place_of_a_pose_is_that_of_the_first_that_it_may_be() -> None:
    entries = np.random.default_rng(2).normal(size=(6, 12)) + 0j
    entries[3], entries[5] = entries[1] + 1e-7, entries[0]
    assert places(entries, np.full(6, 1e-6), 0).tolist() == [0, 1, 2, 1, 4, 0]
    assert places(entries, np.full(6, 1e-8), 0).tolist() == [0, 1, 2, 3, 4, 0]
    # Those that are known to be different stay where they are.
    assert places(entries, np.full(6, 1e-6), 4).tolist() == [0, 1, 2, 3, 4, 0]


def test_what_is_left_out_is_no_place_for_others() -> None:
    """A chain of three: the third may be the second, which is left out, but not the first."""
    entries = np.tile(np.random.default_rng(3).normal(size=12) + 0j, (3, 1))
    entries[:, 4] += [0, 1.5e-6, 3e-6]
    assert places(entries, np.full(3, 1e-6), 0).tolist() == [0, 0, 2]


def test_poses_that_differ_in_all_entries_by_less_than_their_bounds_may_be_the_same() -> None:
    """Their linear forms differ by much more than the entries."""
    pose = np.random.default_rng(4).normal(size=12) + 1j
    pair = np.array([pose, pose + (1 + 1j) * 1.3e-6])
    assert np.abs(pair[1] - pair[0]).max() < 2e-6
    assert not all_different(pair, np.full(2, 1e-6))
    assert places(pair, np.full(2, 1e-6), 0).tolist() == [0, 0]
    assert all_different(pair, np.full(2, 0.9e-6))
    assert places(pair, np.full(2, 0.9e-6), 0).tolist() == [0, 1]


def test_the_bounds_of_both_poses_count() -> None:
    entries = np.tile(np.random.default_rng(5).normal(size=12) + 0j, (2, 1))
    entries[1, 7] += 1.5e-6
    for bounds in ([1e-6, 1e-6], [2e-6, 1e-9], [1e-9, 2e-6]):
        assert not all_different(entries, np.array(bounds))
        assert places(entries, np.array(bounds), 0).tolist() == [0, 0]


def _balls(shift: float, radius: float) -> PoseBall:
    entries = [acb(arb(k + shift, radius), arb(0, radius)) for k in range(12)]
    return PoseBall([entries[:3], entries[3:6], entries[6:9]], entries[9:])


def test_balls_with_a_common_point_are_pairs() -> None:
    with ctx.workprec(64):
        balls = [_balls(shift, 1e-6) for shift in (0, 1.9e-6, 5e-6, 6.5e-6, 1)]
        assert sorted(close_pairs(balls)) == [(0, 1), (2, 3)]
        assert sorted(close_pairs(balls[::-1])) == [(1, 2), (3, 4)]


def test_entries_beyond_the_range_of_doubles_are_not_proved_different() -> None:
    entries = np.ones((3, 12), complex)
    entries[1, 3], entries[2, 3] = np.inf, np.inf
    assert not all_different(entries, np.zeros(3))
    assert places(entries, np.zeros(3), 1).tolist()[2] == 1


def test_a_pose_without_a_bound_may_be_any() -> None:
    entries = np.random.default_rng(6).normal(size=(3, 12)) + 0j
    for bound in (np.nan, np.inf):
        bounds = np.array([1e-9, bound, 1e-9])
        assert not all_different(entries, bounds)
        found = places(entries, bounds, 0)
        assert found[1] == 0 or found[0] == 1
