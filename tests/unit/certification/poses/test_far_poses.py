"""Poses far away are proved for other values in local coordinates, as balls prove them."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest

import gspcli
from gspcli import _kernel
from gspcli.catalogue.kinds import DLP, DPL, DPP
from gspcli.certification.numbers.rounding import COMPLEX, ISOLATED, REAL
from gspcli.certification.poses.far_poses import (
    FarPoses,
    Shifts,
    Values,
    combined,
    local_coordinates,
)
from gspcli.certification.poses.locator import Located
from gspcli.certification.poses.many_values import ValueProofs
from gspcli.certification.poses.pose_arrays import PoseProofs
from gspcli.geometry.building import hexapod
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Line
from gspcli.resources import data_path
from gspcli.solver import solve
from gspcli.solver.problem import Problem
from gspcli.solver.solved_starts import SolvedStarts
from gspcli.spec import load

PARTS = ("R", "T", "quaternions", "real", "certified", "rounded", "deviation")


def rounded_hexagons():
    """Regular hexagons, whose numbers have six decimals."""
    angles = np.radians([0, 20, 120, 140, 240, 260])
    ring = np.stack((np.cos(angles), np.sin(angles), 0 * angles), axis=1).round(6)
    return hexapod(300 * ring, 200 * ring[[5, 0, 1, 2, 3, 4]], [250, 255] * 3)


def rounded_rods(kind):
    """Hexagons, whose last two points are at distances from lines of the other body."""
    ring = np.radians([24, -24, 144, 96, 264, 216])
    other = np.radians([48, -18, 168, 102, 288, 222])
    x, y = (np.stack((np.cos(a), np.sin(a), 0 * a), axis=1).round(5) for a in (ring, other))
    plain = hexapod(x, (0.81 * y).round(5), [1.2, 1.25, 1.22, 1.21, 0.9, 1.1])
    rows = list(plain.constraints)
    for k, direction in ((4, (1, 0, 0)), (5, (0, 0, 1))):
        vector, row = tuple(map(Number.of, direction)), rows[k]
        ends = [row.platform, row.base]
        which = int(kind is DPL)
        ends[which] = Line(ends[which].position, vector)
        rows[k] = replace(row, kind=kind, platform=ends[0], base=ends[1])
    return replace(plain, constraints=tuple(rows))


INSTANCES = {
    "hexagons": rounded_hexagons,
    "rods": lambda: rounded_rods(DPL),
    "rods of the platform": lambda: rounded_rods(DLP),
    "reachy-mini-head": lambda: load(data_path("platforms", "reachy-mini-head.yaml")),
}


@pytest.fixture(scope="module", params=INSTANCES)
def known(request):
    """Return an instance and its far poses."""
    instance, starts = INSTANCES[request.param](), SolvedStarts()
    poses = solve(instance, starts=starts)
    far = poses[np.abs(poses.R).max(axis=(1, 2)) > 64]
    problem = Problem(instance, starts=starts)
    points = starts.platform(problem.arrangement).points
    equations = problem.locator, problem.proofs, problem.choices[0], problem.sides[0]
    length = problem.arrangement.length
    return instance, FarPoses.of(*equations, far.R, far.T, points, length)


def others(instance, count, spread, seed=1):
    """Yield problems with other values."""
    rng = np.random.default_rng(seed)
    own = np.array([row.value.value for row in instance.constraints])
    for _ in range(count):
        values = own * (1 + spread * rng.uniform(-1, 1, 6))
        numbers = {i: Number.of(Fraction(x)) for i, x in enumerate(values.tolist())}
        yield Problem(instance.with_values(numbers), starts=SolvedStarts())


def decided(far, problem):
    values = problem.proofs.values(problem.choices)[0]
    return far.decide(values, np.ones(1), problem.proofs.scale)


def located_in_balls(problem, R, T, points):
    """Return the pose that balls prove near R and T, or from those that are known."""
    near = problem.locator.near(R, T, (0,) * 6, 512)
    if isinstance(near, Located):
        return near
    found = (problem.locator.locate_exactly(point, (0,) * 6, 512) for point in points)
    return next(x for x in found if isinstance(x, Located) and np.allclose(x.T, T, rtol=1e-9))


def test_poses_for_other_values_are_those_that_balls_prove_to_the_bit(known):
    instance, far = known
    starts = SolvedStarts()
    solve(instance, starts=starts)
    points = starts.platform(Problem(instance).arrangement).points.values()
    kind = instance.constraints[5].kind
    assert len(far) == {DPP: 12, DPL: 16, DLP: 20}[kind]
    for problem in others(instance, 1, 0.1):
        found, complete = decided(far, problem)
        assert complete.all()
        for k in range(len(far)):
            located = located_in_balls(problem, found.R[0, k], found.T[0, k], points)
            assert located.real == found.real[0, k]
            assert located.R.tobytes() == found.R[0, k].tobytes()
            assert located.T.tobytes() == found.T[0, k].tobytes()
            assert located.quaternion.tobytes() == found.quaternions[0, k].tobytes()


def test_many_sets_of_values_are_as_each_alone_with_each_build(known):
    instance, far = known
    problems = list(others(instance, 5, 0.2))
    alone = [decided(far, problem)[0] for problem in problems]
    scale = max(problem.proofs.scale for problem in problems)
    assert all(problem.proofs.scale == scale for problem in problems)
    values = np.concatenate([p.proofs.values(p.choices)[0] for p in problems])
    together, _ = far.decide(values, np.ones(len(values)), scale, jobs=2)
    for name in PARTS:
        one = np.concatenate([getattr(each, name) for each in alone])
        np.testing.assert_array_equal(getattr(together, name), one)
    builds = ["portable", "avx2", "avx512"]
    shifts = far._shifts(values, scale / far.scale)
    given = far.numbers, far.errors, far.real, far._paired, far.origin, far.starts, shifts
    given = *given, np.ones(len(values))
    for build in builds[: builds.index(_kernel.build())]:
        R, T, *_ = _kernel.decide_far(
            *given, scale=far.scale, tolerance=1e-9, products=far.products, build=build
        )
        np.testing.assert_array_equal(R, together.R[:])
        np.testing.assert_array_equal(T, together.T[:])


def test_numbers_that_are_hardly_known_prove_nothing(known):
    instance, far = known
    doubtful = replace(far, errors=np.full_like(far.errors, 1e-2))
    for problem in others(instance, 2, 0.1):
        assert not decided(doubtful, problem)[0].certified.any()
        # Known to fewer digits than doubles have, they exist, but are not rounded.
        roughly, _ = decided(replace(far, errors=np.full_like(far.errors, 1e-12)), problem)
        assert roughly.certified.all()
        assert not roughly.rounded.any()


def test_the_bound_of_a_pose_covers_what_is_wrong_with_its_numbers(known):
    instance, far = known
    rng = np.random.default_rng(2)
    wrong = far.numbers * 1.0
    wrong[0] += 1e-13 * rng.uniform(-1, 1, wrong[0].shape)
    doubted = replace(far, numbers=wrong, errors=np.full_like(far.errors, 2e-13))
    for problem in others(instance, 2, 0.1):
        right, other = decided(far, problem)[0], decided(doubted, problem)[0]
        scale = problem.proofs.scale
        entries = [
            np.concatenate((x.R.reshape(1, -1, 9), x.T / scale), axis=2) for x in (right, other)
        ]
        off = np.abs(entries[0] - entries[1]).max(axis=2)
        assert other.certified.all()
        assert (off <= other.deviation + right.deviation).all()


def test_values_out_of_reach_are_left_to_others(known):
    instance, far = known
    for problem in others(instance, 2, 0.0):
        values = problem.proofs.values(problem.choices)[0]
        values[:, [0, 1]] *= 1e12
        values[:, 3] *= 1e12
        assert not far.decide(values, np.ones(1), problem.proofs.scale)[1].any()


def test_a_pose_without_its_conjugate_is_no_start():
    instance = INSTANCES["hexagons"]()
    poses = solve(instance, starts=SolvedStarts())
    far = poses[np.abs(poses.R).max(axis=(1, 2)) > 64]
    problem = Problem(instance, starts=SolvedStarts())
    equations = problem.locator, problem.proofs, problem.choices[0], problem.sides[0]
    length = problem.arrangement.length
    assert FarPoses.of(*equations, far.R[:-1], far.T[:-1], {}, length) is None


def test_poses_not_that_far_are_rounded_for_nearly_all_values():
    # 5000 lengths away coordinates are bent: bounds of moduli alone leave four of ten rows open.
    instance = load(data_path("platforms", "rubin-camera.yaml"))
    own = np.array([row.value.value for row in instance.constraints])
    rows = own * (1 + 0.03 * np.random.default_rng(1).uniform(-1, 1, (200, 6)))
    batch = gspcli.solve_batch(instance, rows)
    assert batch.proved.all()
    assert len(batch.others) < 20


def poses_at(size, deviation):
    """Return one set of values with one pose, whose largest entry has a size."""
    yes = np.ones((1, 1), bool)
    R, T = np.eye(3, dtype=complex)[None, None], np.array([[[size, 0, 0]]], complex)
    e = np.array([[[1, 0, 0, 0]]], complex)
    given = dict.fromkeys(("real", "certified", "multiplicity", "rounded"), yes)
    return PoseProofs(R=R, T=T, quaternions=e, deviation=np.array([[deviation]]), **given)


@pytest.mark.parametrize(
    ("near", "far", "deviations", "complete"),
    [
        (2.0, 5.0, (1.0, 1.0), True),
        (5.0, 5.0, (1e-9, 1e-9), False),
        (5.0, 2.0, (1e-9, 1e-9), True),
        (5.0, 2.0, (2.9, 0.2), False),
        (4.0, 5.0, (0.4, 0.7), False),
        (4.0, 5.0, (1.1, 1e-9), False),
        (4.0, 5.0, (1e-9, 1.1), False),
    ],
)
def test_far_poses_are_others_only_beyond_their_error_bounds(near, far, deviations, complete):
    """A far pose may be found by paths, too: another one differs by more than both errors."""
    yes = np.ones(1, bool)
    there = SimpleNamespace(
        decide=lambda *_, **__: (poses_at(far, deviations[1]), yes), shifts=None
    )
    proofs = SimpleNamespace(
        scale=1.0, values=lambda *_: np.zeros((1, 1, 6, 6)), units=lambda _: np.ones(1)
    )
    given = there, poses_at(near, deviations[0]), yes, proofs, np.ones(6), None
    found, are_all = FarPoses.beside(*given)
    assert are_all.tolist() == [complete]
    assert found.T.shape == (1, 2, 3)


def made_up(constant, square):
    """Return one far pose whose first equation is constant + s + square s^2.

    The others are linear, and the pose is the identity, with e = (1, s, 0, 0).
    """
    numbers = np.zeros((2, 1, 794), complex)
    forms = numbers[0, 0, : 20 * 36].reshape(20, 36)
    for k in range(7):
        forms[k, 1 + k] = 1
    forms[0, [0, 1, 8]] = constant, 1, square
    forms[[7, 8, 12, 16], 0] = 1
    quaternion = numbers[0, 0, 20 * 36 : 752].reshape(4, 8)
    quaternion[0, 0] = quaternion[1, 1] = 1
    numbers[0, 0, 752:].reshape(7, 6)[1:] = np.eye(6)
    return numbers


def decide_made_up(
    numbers, *, error=0.0, shift=0.0, gap=0.0, real=1, entry=2, start=None, products=0
):
    shifts = np.zeros((1, 3, 6))
    shifts[0, 0, 0], shifts[0, 2, 0] = shift, gap
    origin = np.full(6, 0.3j)
    starts = np.zeros((0, 7), complex)
    if start is not None:
        starts, found = _kernel.follow_far(
            numbers, np.zeros(6, complex), origin, start, products=products
        )
        assert found.all()
    *poses, deviation, bits, complete = _kernel.decide_far(
        numbers,
        np.array([error]),
        np.array([real], np.uint8),
        np.array([1 - real], np.uint8),
        origin,
        starts,
        shifts,
        np.ones(1),
        scale=1.0,
        tolerance=1e9,
        products=products,
    )
    return poses[entry][0], deviation[0], bits[0], complete


def test_a_simple_root_of_a_made_up_equation_is_proved():
    e, _, bits, _ = decide_made_up(made_up(0.1, 1.0))
    root = (-1 + np.sqrt(1 - 0.4)) / 2
    assert bits[0] & ISOLATED
    np.testing.assert_allclose(e[0, 1], root, rtol=1e-12)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("constant", [0.4, 1e-3])
def test_next_to_two_roots_of_a_made_up_equation_none_is_isolated(sign, constant):
    """The discriminant is nearly zero: Newton's method only halves the distance."""
    _, _, bits, _ = decide_made_up(made_up(constant, (1 - sign * 1e-8) / (4 * constant)))
    assert not bits.any()


@pytest.mark.parametrize("doubt", [1e-3, 1e-2, 2e-2])
def test_what_is_not_known_of_the_numbers_is_not_known_of_the_root(doubt):
    """The constant of a nearly double root may be off by as much: then there may be none."""
    assert not decide_made_up(made_up(0.1, 2.5 * (1 - doubt)), error=doubt)[2].any()


def test_a_root_that_a_little_more_would_remove_is_proved_only_if_it_is_known():
    numbers = made_up(0.1, 2.5 * (1 - 2.5e-3))
    assert decide_made_up(numbers, error=1e-9)[2][0] & ISOLATED
    assert not decide_made_up(numbers, error=2.6e-4)[2].any()


def of_a_value(square=1.0, square_of_norm=0.0):
    """Return one whose second equation is s_1 + square s_1^2 = D (1 + square_of_norm s_1^2)."""
    numbers = made_up(0.0, 0.0)
    forms = numbers[0, 0, : 20 * 36].reshape(20, 36)
    forms[[0, 1]] = forms[[1, 0]]
    forms[1, 8], forms[7, 8] = square, square_of_norm
    # The first entry of the rotation moves with it.
    forms[8, 1] = 1
    return numbers


def test_values_that_may_have_two_roots_have_no_proof():
    """s + s^2 = D has a double root at D = -1/4."""
    assert decide_made_up(of_a_value(), shift=-0.1)[2][0] & ISOLATED
    assert not decide_made_up(of_a_value(), shift=-0.2, gap=0.06)[2].any()
    assert not decide_made_up(of_a_value(), shift=-0.26)[2].any()
    # s = D (1 + m s^2) has one where 4 m D^2 = 1.
    assert decide_made_up(of_a_value(0, 0.2), shift=0.4)[2][0] & ISOLATED
    for sign in (1, -1):
        assert not decide_made_up(of_a_value(0, (1 + sign * 1e-8) / 0.64), shift=0.4)[2].any()


@pytest.mark.parametrize("factor", [16.0, 1 / 16, -3.0])
def test_multiplied_equations_prove_the_same(factor):
    """What is not known of a value is multiplied, too."""
    plain, mixed = of_a_value(), of_a_value()
    mixed[0, 0, 36:72] *= factor
    mixed[0, 0, 752:].reshape(7, 6)[1, 0] = factor
    for gap in (0.0, 1e-6, 1e-3):
        poses, deviation, bits, _ = decide_made_up(mixed, shift=-0.1, gap=gap, entry=0)
        known, least, wanted, _ = decide_made_up(plain, shift=-0.1, gap=gap, entry=0)
        assert bits[0] == wanted[0]
        np.testing.assert_allclose(poses, known, rtol=1e-15)
        if gap:
            assert deviation[0] == pytest.approx(least[0], rel=1e-3)
    assert not decide_made_up(mixed, shift=-0.2, gap=0.06)[2].any()
    assert not decide_made_up(mixed, shift=-0.26)[2].any()


@pytest.mark.parametrize("gap", [1e-9, 1e-6, 1e-3])
def test_the_bound_of_a_pose_covers_what_is_not_known_of_its_values(gap):
    def root(value):
        return (-1 + np.sqrt(1 + 4 * value)) / 2

    R, deviation, bits, _ = decide_made_up(of_a_value(), shift=-0.1, gap=gap, entry=0)
    assert bits[0] & ISOLATED
    for moved in (-gap, gap):
        assert abs(R[0, 0, 0] - 1 - root(-0.1 + moved)) <= deviation[0]


def test_a_height_that_may_be_rounding_does_not_make_a_pose_complex():
    numbers = made_up(0.1, 1.0)
    numbers[0, 0, 8 * 36] += 1e-12j
    assert decide_made_up(numbers, error=1e-10, real=0)[2][0] == ISOLATED
    assert decide_made_up(numbers, error=1e-15, real=0)[2][0] & COMPLEX


def test_a_real_pose_that_meets_another_becomes_complex_and_is_proved_not_real():
    """s + s^2 = D has real roots above D = -1/4 only."""
    start = np.zeros((1, 7), complex)
    R, deviation, bits, _ = decide_made_up(of_a_value(), shift=-0.1, start=start, entry=0)
    assert bits[0] & ISOLATED
    assert bits[0] & REAL
    assert not R.imag.any()
    R, deviation, bits, _ = decide_made_up(of_a_value(), shift=-0.5, start=start, entry=0)
    assert bits[0] & ISOLATED
    assert bits[0] & COMPLEX
    assert not bits[0] & REAL
    assert abs(abs(R[0, 0, 0] - 1 - complex(-0.5, 0.5))) <= deviation[0] or (
        abs(R[0, 0, 0] - 1 - complex(-0.5, -0.5)) <= deviation[0]
    )


@pytest.mark.parametrize("shift", [-0.2499, -0.24, 0.5, 3.0])
def test_a_path_leads_to_a_root_for_values_beyond_where_two_meet(shift):
    start = np.zeros((1, 7), complex)
    R, deviation, bits, _ = decide_made_up(of_a_value(), shift=shift, start=start, entry=0)
    assert bits[0] & REAL
    roots = [(-1 + sign * np.sqrt(1 + 4 * shift)) / 2 for sign in (1, -1)]
    assert min(abs(R[0, 0, 0] - 1 - root) for root in roots) <= deviation[0]


def of_a_product(p, q, constant):
    """Return one whose second equation is P Q = (constant + D) N^2 in s_1, N = 1.

    P and Q are numbers times 1, s_1, s_1^2.
    """
    plain = of_a_value(0.0)
    numbers = np.concatenate((plain, np.zeros((2, 1, 37), complex)), axis=2)
    first = numbers[0, 0, 36:72]
    first[:] = 0
    first[[0, 1, 8]] = p
    numbers[0, 0, 794:][[0, 1, 8, 36]] = *q, constant
    return numbers


PRODUCT = 2


def test_a_root_of_a_product_is_proved():
    """(1 + s / 4) (1/2 + s + s^2) = 1/2 + D."""
    numbers = of_a_product((1, 0.25, 0), (0.5, 1, 1), 0.5)
    for shift in (0.0, -0.1, 0.2):
        R, deviation, bits, _ = decide_made_up(numbers, shift=shift, entry=0, products=PRODUCT)
        assert bits[0] & ISOLATED
        assert bits[0] & REAL
        roots = np.roots(np.polymul([0.25, 1], [1, 1, 0.5]) - [0, 0, 0, 0.5 + shift])
        assert min(abs(R[0, 0, 0] - 1 - roots)) <= deviation[0] + 1e-15


@pytest.mark.parametrize("sign", [1, -1])
def test_next_to_two_roots_of_a_product_none_is_isolated(sign):
    """(1 + 3 s) (1 + s) is -1/3 at s = -2/3, twice."""
    shift = -4 / 3 * (1 - sign * 1e-10)
    near = of_a_product((1, 3, 0), (1, 1, 0), 1.0)
    assert not decide_made_up(near, shift=shift, products=PRODUCT)[2].any()
    # As exactly one root may be meant, or none: what is not known decides.
    assert decide_made_up(near, shift=-0.9, products=PRODUCT)[2][0] & ISOLATED
    assert not decide_made_up(near, shift=-0.9, gap=0.44, products=PRODUCT)[2].any()
    assert not decide_made_up(near, shift=-1.2, error=0.02, products=PRODUCT)[2].any()


def test_second_derivatives_of_products_are_bounded_where_coordinates_may_be():
    """s (1 - 200 s^2) = D has no second derivative at zero, and two roots meet at D = 0.027."""
    numbers = of_a_product((0, 1, 0), (1, 0, -200), 0.0)
    assert decide_made_up(numbers, gap=1e-3, products=PRODUCT)[2][0] & ISOLATED
    assert not decide_made_up(numbers, gap=0.04, products=PRODUCT)[2].any()


def test_errors_of_a_factor_are_multiplied_by_the_other_one():
    """The first factor has a nearly double root, which a little more would remove."""
    numbers = of_a_product((0.1, 1, 2.5 * (1 - 2.5e-3)), (30, 0, 0), 0.0)
    assert decide_made_up(numbers, error=1e-9, products=PRODUCT)[2][0] & ISOLATED
    assert not decide_made_up(numbers, error=2.6e-4, products=PRODUCT)[2].any()


@pytest.mark.parametrize("gap", [1e-9, 1e-6, 1e-3])
def test_the_bound_of_a_pose_covers_what_is_not_known_of_a_product(gap):
    numbers = of_a_product((1, 0.25, 0), (0.5, 1, 1), 0.5)
    R, deviation, bits, _ = decide_made_up(numbers, shift=-0.1, gap=gap, entry=0, products=PRODUCT)
    assert bits[0] & ISOLATED
    for moved in (-gap, gap):
        roots = np.roots(np.polymul([0.25, 1], [1, 1, 0.5]) - [0, 0, 0, 0.4 + moved])
        assert min(abs(R[0, 0, 0] - 1 - roots)) <= deviation[0]
    # The same if numbers are not known so well.
    for part in (36, 37, 794, 795, 796, 794 + 36):
        wrong = numbers.copy()
        wrong[0, 0, part] += gap
        other = decide_made_up(wrong, shift=-0.1, error=gap, entry=0, products=PRODUCT)
        assert other[2][0] & ISOLATED
        assert abs(other[0][0, 0, 0] - R[0, 0, 0]) <= other[1][0] + deviation[0]


def test_factors_that_are_conjugate_have_a_real_root():
    """(1 + i s) (1 - i s) = 1 + D has a real root for D > 0, and none for D < 0."""
    numbers = of_a_product((1 + 1j, 1j, 0), (1 - 1j, -1j, 0), 2.0)
    for shift, kind in ((0.25, REAL), (-0.25, REAL)):
        R, _, bits, _ = decide_made_up(numbers, shift=shift, entry=0, products=PRODUCT)
        assert bits[0] & ISOLATED
        assert bits[0] & kind
        assert not R.imag.any()
        # |1 + i (1 + s)|^2 = 2 + D.
        assert R[0, 0, 0].real == pytest.approx(np.sqrt(1 + shift), rel=1e-15)


@pytest.mark.parametrize("products", [1, 128])
def test_only_six_equations_can_be_products(products):
    with pytest.raises(ValueError, match="products"):
        decide_made_up(made_up(0.1, 1.0), products=products)


def test_coordinates_of_too_different_sizes_are_not_combined():
    """With too few bits, their matrix is singular."""
    problem = Problem(rounded_hexagons())
    poses = solve(problem.instance, starts=SolvedStarts())
    k = int(np.abs(poses.T).max(axis=1).argmax())
    given = problem.locator, problem.sides[0]
    found = local_coordinates(*given, poses.R[k], poses.T[k])
    assert found is not None
    assert combined(*given, found, np.eye(7, dtype=complex)) is not None
    assert combined(*given, found, np.ones((7, 7), complex)) is None


# Differences of values in combinations of nearly dependent equations.


BASE = np.array([[3, 0, 0], [0, 3, 0], [-3, 0, 0], [0, -3, 0], [2, 2, 1], [-2, -2, 1]])
LENGTHS = ["1.1", "1.7", "2.3", "1.9", "1.3", "4/3"]
#: One combination is 1e12 times as large as the others.
MATRIX = np.eye(6) + 1e12 * np.outer([0, 0, 0, 0, 0, 1], [0.3, -0.7, 0.1, 1.3, -0.9, 0.2])


def shifts_of(rows, lengths=LENGTHS):
    instance = hexapod(BASE, 0.5 * BASE, LENGTHS)
    known = ValueProofs(instance, None)
    choice = np.ones(6)
    own = Values.of(known, choice, None, known.values(choice[None])[0], known.scale)
    shifts = Shifts(MATRIX, own, known.scale)
    proofs = ValueProofs(hexapod(BASE, 0.5 * BASE, lengths), rows)
    values = proofs.values(choice[None], rows)[:, 0]
    return known.scale, shifts.of(proofs, choice, rows, values)


def exact(scale, row):
    """Return the products with the matrix in rational numbers."""
    own = [Fraction(x) for x in LENGTHS]
    differences = [
        (Fraction(x) ** 2 - y**2) / Fraction(scale) ** 2 for x, y in zip(row, own, strict=True)
    ]
    return [
        sum(Fraction(a) * d for a, d in zip(line, differences, strict=True))
        for line in MATRIX.tolist()
    ]


def check(scale, row, found):
    for k, wanted in enumerate(exact(scale, row)):
        error = abs(Fraction(found[0, k]) + Fraction(found[1, k]) - wanted)
        assert error <= Fraction(found[2, k])
        assert found[2, k] <= 2.0**-90 * abs(found[0, k])


def test_sets_of_values_are_doubles_that_are_meant_exactly():
    own = np.array([float(Fraction(x)) for x in LENGTHS])
    rows = own + np.random.default_rng(2).uniform(-0.1, 0.1, (3, 6))
    # The last differs by the rounding of decimals only: 1e-17, times 1e12.
    rows[2] = own
    scale, found = shifts_of(rows)
    for row, each in zip(rows.tolist(), found, strict=True):
        check(scale, row, each)


def test_values_of_an_instance_are_exact():
    lengths = ["1.1000000000000001", "1.7", "2.3", "5/3", "1.3", "1.33333"]
    scale, found = shifts_of(None, lengths)
    check(scale, lengths, found[0])


@pytest.mark.parametrize("longest", ["1.7", "70"])
def test_values_that_are_no_fractions_err(longest):
    """Also where the unit of length of the other values is larger."""
    lengths = ["sqrt(1.3)", longest, "2.3", "5/3", "1.3", "1.33333"]
    scale, found = shifts_of(None, lengths)
    wanted = exact(scale, ["1", *lengths[1:]])
    more = Fraction(3, 10) / Fraction(scale) ** 2
    for k, x in enumerate(wanted):
        error = abs(
            Fraction(found[0, 0, k]) + Fraction(found[0, 1, k]) - x - Fraction(MATRIX[k, 0]) * more
        )
        assert error <= Fraction(found[0, 2, k])
    # Beside the rounding of the sum, the error of this value, 2^-96 of it, times the matrix.
    of_value = found[0, 2, 5] - 2.0**-96 * abs(found[0, 0, 5])
    assert of_value == pytest.approx(0.3e12 * 1.3 / scale**2 * 2.0**-96, rel=0.1, abs=0)
