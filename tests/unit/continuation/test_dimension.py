"""Solution sets of positive dimension, and isolated solutions that look like them."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.continuation.quadrics import NORM
from gspcli.continuation.systems import Coefficients, System
from gspcli.continuation.tracked_paths import (
    correct,
    kernel,
    real_point,
    sample_motions,
    split,
    tangents,
)
from tests.support.systems import solve_system


@pytest.fixture(scope="module")
def sphere(build):
    """Congruent bodies with equal legs: R = 1 and T on a sphere; and a point of it."""
    x = np.random.default_rng(1).standard_normal((6, 3))
    # T = (1.5, 0, 0): f = (T / 2) e.
    point = np.array([1, 0, 0, 0, 0, 0.75, 0, 0], dtype=complex)
    return build.legs(x, x, [1.5] * 6).normalized(), point / np.linalg.norm(point)


@pytest.fixture(scope="module")
def simple(build):
    system, _, _ = build.platform("PP " * 6, np.random.default_rng(2))
    system = system.normalized()
    points = solve_system(system).points
    return system, points / np.linalg.norm(points, axis=1, keepdims=True)


def test_a_simple_solution_has_no_kernel_and_no_tangents(simple):
    system, points = simple
    rng = np.random.default_rng(3)
    for point in points[:5]:
        assert kernel(system, point).shape == (8, 0)
        assert tangents(system, point, rng).shape == (8, 0)


def test_a_surface_of_solutions_has_two_tangents(sphere):
    system, point = sphere
    assert kernel(system, point).shape[1] >= 2
    along = tangents(system, point, np.random.default_rng(4))
    assert along.shape == (8, 2)
    assert not along.imag.any()
    np.testing.assert_allclose(along.T @ along, np.eye(2), atol=1e-12)
    assert np.abs(point @ along).max() < 0.1


def test_a_double_solution_has_a_kernel_but_no_tangents(build):
    system = build.point_at_a_line(0.0, np.random.default_rng(8)).normalized()
    solutions = solve_system(system)
    [double] = solutions.points[solutions.multiplicity == 2]
    double = double / np.linalg.norm(double)
    assert kernel(system, double).shape[1] == 1
    assert tangents(system, double, np.random.default_rng(5)).shape == (8, 0)


def test_correct_returns_to_simple_solutions_and_to_sets(simple, sphere):
    rng = np.random.default_rng(6)
    system, points = simple
    disturbed = points[:4] + 1e-4 * rng.standard_normal((4, 8))
    moved, converged = correct(system, disturbed)
    assert converged.all()
    for point, there in zip(points, moved, strict=False):
        assert abs(np.vdot(point, there)) > 1 - 1e-12
    system, point = sphere
    disturbed = point + 1e-2 * rng.standard_normal((3, 8))
    moved, converged = correct(system, disturbed)
    assert converged.all()
    assert not moved.imag.any()
    assert np.abs(system.values(moved)).max() < 1e-12


def test_correct_says_what_did_not_converge(simple):
    system, points = simple
    bad = np.array([np.full(8, np.nan, dtype=complex), points[0]])
    assert correct(system, bad)[1].tolist() == [False, True]


def test_split_finds_the_two_solutions_that_a_double_one_is(build):
    """Legs at a pose where all meet a line, one of them then changed by 1e-10."""
    rng = np.random.default_rng(9)
    r, t = build.rotation(rng), rng.standard_normal(3)
    y = rng.standard_normal((6, 3))
    start, direction = rng.standard_normal((2, 3))
    ends = y @ r.T + t
    on_line = start + rng.standard_normal((6, 1)) * direction
    x = ends + (1.5 + rng.random((6, 1))) * (on_line - ends)
    system = build.legs_at(y, x, r, t)
    solutions = solve_system(system)
    [double] = solutions.points[solutions.multiplicity == 2]
    double = double / np.linalg.norm(double)
    g, h, tau = system.coefficients
    near = System(system.structure, Coefficients(g + 1e-10 * np.eye(6)[:, :1] * NORM, h, tau))
    guesses = split(near.normalized(), double)
    assert guesses is not None
    guesses /= np.linalg.norm(guesses, axis=1, keepdims=True)
    moved, converged = correct(near.normalized(), guesses)
    assert converged.all()
    assert 1e-7 < np.sqrt(1 - abs(np.vdot(*moved)) ** 2) < 1e-3


def test_nothing_to_split_at_a_simple_solution(simple):
    system, points = simple
    assert split(system, points[0]) is None


def test_sample_motions_stay_on_the_set(sphere, build):
    system, point = sphere
    along = tangents(system, point, np.random.default_rng(7))
    [motion] = sample_motions(system, point[None], along[:, :1].T, steps=10)
    assert len(motion) == 11
    assert not motion.imag.any()
    assert np.abs(system.values(motion)).max() < 1e-12
    scaled = motion / np.sqrt((motion[:, :4] ** 2).sum(axis=1, keepdims=True))
    rotations, translations = build.poses(scaled)
    # The sphere is a double solution set: half of the digits.
    np.testing.assert_allclose(rotations, np.tile(np.eye(3), (11, 1, 1)), atol=1e-5)
    np.testing.assert_allclose(np.linalg.norm(translations, axis=1), 1.5, atol=1e-5)
    steps = np.linalg.norm(np.diff(motion, axis=0), axis=1)
    assert (steps > 0.01).all()


def test_no_motion_from_a_simple_solution(simple):
    system, points = simple
    direction = np.random.default_rng(8).standard_normal(8)
    [motion] = sample_motions(system, points[:1], direction[None].astype(complex))
    assert len(motion) == 1


def test_a_real_point_near_a_complex_one_only_of_real_systems(sphere):
    system, point = sphere
    found = real_point(system, np.exp(1j) * (point + 1e-3j))
    assert found is not None
    assert not found.imag.any()
    assert np.abs(system.values(found[None])).max() < 1e-12
    g, h, tau = system.coefficients
    other = System(system.structure, Coefficients(g * np.exp(0.1j), h, tau))
    assert real_point(other, point) is None
