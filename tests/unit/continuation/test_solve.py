"""Whole solution sets of random real platforms, and of special ones."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.continuation.endpoints import nonlinearity, random_start, simple
from gspcli.continuation.quadrics import evaluate
from gspcli.continuation.systems import System
from gspcli.continuation.tracked_paths import follow, solve_systems, start_system
from gspcli.continuation.tracker import track
from tests.support.systems import solve_system

KINDS = [
    "PP PP PP PP PP PP",
    "PH PH PH PH PH PH",
    "PH PH PH HP HP HP",
    "HP HP HP HP PH PP",
    "PL PL PL PL PL PL",
    "PP PP LP HP HP HP",
    "PP PP PP PP PP PL",
    "A A A PL PL LP",
    "A A PP PL LP LL",
    "A LL LL PH PP HP",
    "LL LL LL PP HP PH",
]


def is_account_consistent(solutions) -> bool:
    return int(solutions.multiplicity.sum()) == solutions.account.found


@pytest.mark.parametrize("kinds", KINDS)
def test_random_platforms_are_complete(build, kinds):
    rng = np.random.default_rng(9)
    cases = [build.platform(kinds, rng) for _ in range(2)]
    for (target, r, t), solutions in zip(
        cases, solve_systems(target for target, _, _ in cases), strict=True
    ):
        assert solutions.account.verdict == "complete"
        assert len(solutions.points) == solutions.account.expected
        assert is_account_consistent(solutions)
        unit = solutions.points / np.linalg.norm(solutions.points, axis=1)[:, None]
        assert target.normalized().residuals(unit).max() < 1e-13
        rotations, translations = build.poses(solutions.points)
        error = np.abs(rotations - r).max(axis=(1, 2)) + np.abs(translations - t).max(axis=1)
        assert error.min() < 1e-9


def test_dietmaier_has_forty_real_poses(build):
    x = [[0, 0, 0], [1.107915, 0, 0], [0.549094, 0.756063, 0], [0.735077, -0.223935, 0.525991],
         [0.514188, -0.526063, -0.368418], [0.590473, 0.094733, -0.205018]]  # fmt: skip
    y = [[0, 0, 0], [0.542805, 0, 0], [0.956919, -0.528915, 0], [0.665885, -0.353482, 1.402538],
         [0.478359, 1.158742, 0.107672], [-0.137087, -0.235121, 0.353913]]  # fmt: skip
    d = [1, 0.645275, 1.086284, 1.503439, 1.281933, 0.771071]
    solutions = solve_system(build.legs(np.array(y), np.array(x), d))
    assert len(solutions.points) == 40
    assert np.abs(solutions.points.imag).max() < 1e-9


def triangle(p: np.ndarray) -> list[np.ndarray]:
    return [p[0], p[0], p[1], p[1], p[2], p[2]]


def special(name: str, build, rng: np.random.Generator):
    r, t = build.rotation(rng), rng.standard_normal(3)
    x, y = rng.standard_normal((2, 6, 3))
    flat = np.array([1.0, 1.0, 0.0])
    if name == "octahedral":
        return build.legs_at(triangle(y), [x[0], x[1], x[1], x[2], x[2], x[0]], r, t)
    if name == "6-3":
        return build.legs_at(triangle(y), x, r, t)
    if name == "planar":
        return build.legs_at(y * flat, x * flat, r, t)
    if name == "no real solution":
        return build.legs(y, x, [0.01] * 6)
    assert name == "singular pose"
    # All legs meet a common line: the inverse Jacobian matrix is singular there.
    point, direction = rng.standard_normal((2, 3))
    ends = y @ r.T + t
    on_line = point + rng.standard_normal((6, 1)) * direction
    return build.legs_at(y, ends + (1.5 + rng.random((6, 1))) * (on_line - ends), r, t)


@pytest.mark.parametrize(
    ("name", "finite", "distinct"),
    [
        ("octahedral", 16, 16),
        ("6-3", 16, 16),
        ("planar", 40, 40),
        ("no real solution", 40, 40),
        ("singular pose", 40, 39),
    ],
)
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_special_positions(build, name, finite, distinct, seed):
    solutions = solve_system(special(name, build, np.random.default_rng(seed)))
    assert is_account_consistent(solutions)
    assert solutions.account.verdict == "complete"
    assert (solutions.account.found, len(solutions.points)) == (finite, distinct)
    assert solutions.singular.sum() == finite - distinct


def test_congruent_platform_with_equal_legs_moves(build):
    x = np.random.default_rng(10).standard_normal((6, 3))
    solutions = solve_system(build.legs(x, x, [1.5] * 6))
    assert solutions.account.verdict == "infinite"
    assert is_account_consistent(solutions)
    # R = 1 and T on a sphere.
    assert {curve.dimension for curve in solutions.curves} == {2}
    moving = [curve for curve in solutions.curves if curve.real]
    assert moving
    for curve in moving:
        assert len(curve.motion) > 5
        assert not curve.motion.imag.any()
        rotations, translations = build.poses(curve.motion)
        np.testing.assert_allclose(rotations - np.eye(3), 0, atol=1e-5)
        np.testing.assert_allclose(np.linalg.norm(translations, axis=1), 1.5, atol=1e-5)


def test_griffis_duffy_moves(build):
    angle = 2 * np.pi * np.arange(3) / 3
    corners = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    sides = np.array([p for k in range(3) for p in (corners[k], (corners[k] + corners[k - 2]) / 2)])
    target = build.legs_at(np.roll(sides, -1, axis=0), sides, np.eye(3), np.array([0, 0, 1.3]))
    solutions = solve_system(target)
    assert solutions.account.verdict == "infinite"
    assert is_account_consistent(solutions)
    assert any(curve.real and curve.dimension == 1 for curve in solutions.curves)


# Simple solutions are distinguished from double ones for any condition numbers.


def solved(target: System):
    """The system in its canonical order and balanced, its paths, and the results."""
    start = start_system(target.structure.canonical())
    balanced, _ = target.canonical().coefficients.balanced()
    system = System(start.system.structure, balanced)
    return system, track(random_start(start, 1, 0), system, start.points)


@pytest.mark.parametrize("kinds", ["PP PP PP PP PP PP", "PL LP PH HP A A", "LL LL PP PL PH A"])
def test_solutions_of_random_platforms_are_simple(build, kinds):
    target, _, _ = build.platform(kinds, np.random.default_rng(5))
    system, results = solved(target)
    assert results.is_simple.all()
    assert nonlinearity(system, results.points[0]).max() < 1e-6


@pytest.mark.parametrize(("distance", "found"), [(0.0, 79), (1e-5, 80), (1e-2, 80)])
def test_a_point_on_a_line_is_a_double_solution_and_one_near_it_two(build, distance, found):
    """Both factors of the product vanish, which leaves the scaled rows well-conditioned."""
    solutions = solve_system(build.point_at_a_line(distance, np.random.default_rng(8)))
    assert solutions.account.verdict == "complete"
    assert solutions.account.found == 80
    assert len(solutions.points) == found
    assert solutions.singular.sum() == 80 - found


def test_a_point_on_a_line_is_not_simple(build):
    system, results = solved(build.point_at_a_line(0.0, np.random.default_rng(8)))
    ends = results.points[0]
    product = system.structure.is_product
    factors = [np.abs(evaluate(x[product], ends)[:, 0]) for x in system.coefficients[:2]]
    on_line = (factors[0] < 1e-6) & (factors[1] < 1e-6)
    assert on_line.sum() == 2
    assert not simple(system, ends[on_line]).any()
    assert not results.is_simple[0][on_line].any()
    # Dividing the rows by what cancels in them hides it.
    assert results.condition[0][on_line].max() < 1e6
    assert simple(system, ends[~on_line]).all()


# Following solutions from one system to another.


def lines(points: np.ndarray) -> np.ndarray:
    return points / np.linalg.norm(points, axis=1, keepdims=True)


@pytest.mark.parametrize("kinds", ["PP PP PP PP PP PP", "PP PL LP PH HP A"])
def test_all_solutions_lead_to_all(build, kinds):
    known, _, _ = build.platform(kinds, np.random.default_rng(1))
    target, _, _ = build.platform(kinds, np.random.default_rng(2))
    found = follow(known, solve_system(known).points, target, rng=np.random.default_rng(3))
    assert found is not None
    expected = solve_system(target).points
    assert len(found.points) == len(expected)
    np.testing.assert_allclose((found.points[:, :4] ** 2).sum(axis=1), 1)
    inner = np.abs(lines(found.points).conj() @ lines(expected).T)
    assert sorted(inner.argmax(axis=1)) == list(range(len(expected)))
    assert inner.max(axis=1).min() > 1 - 1e-9
    assert (found.condition > 0).all()


def test_scale_of_the_equations_does_not_matter(build):
    rng = np.random.default_rng(4)
    known, target = (build.platform("PP PP PP PP PP PL", rng)[0] for _ in range(2))
    points = solve_system(known).points
    sizes = np.exp(rng.standard_normal(6))
    one, other = (
        follow(known, points, system, rng=np.random.default_rng(5))
        for system in (target, target.scaled(sizes, sizes[::-1]))
    )
    assert one is not None
    assert other is not None
    np.testing.assert_allclose(one.points, other.points, atol=1e-8)


def test_paths_that_end_together_are_not_said_to_have_been_followed(build):
    """Congruent bodies: an infinite set of solutions."""
    rng = np.random.default_rng(6)
    y = rng.standard_normal((6, 3))
    known = build.legs(y, rng.standard_normal((6, 3)), rng.uniform(1, 2, 6))
    special = build.legs(y, y, [1.0] * 6)
    points = solve_system(known).points
    assert follow(known, points, special, rng=np.random.default_rng(7)) is None


def test_what_is_no_solution_is_not_followed(build):
    known, target = (build.platform("PP " * 6, np.random.default_rng(s))[0] for s in (8, 9))
    wrong = np.random.default_rng(10).standard_normal((3, 8)).astype(complex)
    assert follow(known, wrong, target, rng=np.random.default_rng(11)) is None
