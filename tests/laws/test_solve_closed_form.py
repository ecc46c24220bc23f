"""The closed form does not care about frames, units, order, or which body is the base."""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matching import pose_set_distance

from gspcli.catalogue.kinds import ANGLE_KINDS, DISTANCE_KINDS
from gspcli.catalogue.names import parse_type
from gspcli.catalogue.types import GspType, type_by_number
from gspcli.geometry.instance import Instance
from gspcli.geometry.random_instances import random_instance
from gspcli.solver import SolveResult, solve, solve_values

#: Sets of poses that are equal in exact arithmetic agree to this; poses are simple.
AGREE = 1e-7
DISTANCE_TRIPLES = list(combinations_with_replacement(DISTANCE_KINDS, 3))
ANGLE_TRIPLES = list(combinations_with_replacement(ANGLE_KINDS, 3))

numbers_of_3d3a = st.integers(1, len(DISTANCE_TRIPLES) * len(ANGLE_TRIPLES))
seeds = st.integers(0, 10**6)


def instance_of(number: int, seed: int) -> Instance:
    return random_instance(type_by_number(number), np.random.default_rng(seed))[0]


def solved(instance: Instance) -> SolveResult:
    result = solve(instance)
    assert result.verdict == "complete"
    return result


def distance(result: SolveResult, R: np.ndarray, T: np.ndarray) -> float:
    return pose_set_distance((result.R, result.T), (R, T), result.arrangement.length)


@pytest.mark.parametrize("index", range(len(DISTANCE_TRIPLES)))
def test_every_distance_triple_and_angle_triple(index):
    """All poses of random instances, and the pose from which the values were taken."""
    for shift in (0, 3, 7, 11, 16):
        angles = ANGLE_TRIPLES[(index + shift) % len(ANGLE_TRIPLES)]
        gsp_type = GspType.of((*DISTANCE_TRIPLES[index], *angles))
        rng = np.random.default_rng([index, shift])
        instance, (R, T) = random_instance(gsp_type, rng)
        result = solved(instance)
        counts = result.counts
        assert counts.found == result.expected
        assert counts.singular == result.account.at_infinity == result.account.lost == 0
        assert_small_residuals(result)
        nearest = np.abs(result.R - R).max(axis=(1, 2)) + np.abs(result.T - T).max(axis=1)
        assert nearest.min() < 1e-9
        assert result.real[nearest.argmin()]


def assert_small_residuals(result: SolveResult) -> None:
    """Assert that real poses are exact to 1e-10 lengths, and complex ones as near as can be.

    Of a complex pose of size s, terms of size s^2 cancel in a squared distance. When its numbers
    are rounded to double precision the distance changes by that many units.
    """
    a = result.arrangement
    residual = result.residuals.max(axis=1)
    size = 1 + np.abs(result.R).max(axis=(1, 2)) + np.abs(result.T).max(axis=1) / a.length
    assert residual[result.real].max() < 1e-10 * a.length
    assert (residual / size**2).max() < 1e-10 * a.length


@pytest.mark.parametrize(
    ("name", "seed"),
    [("DLP DLP DLP ALL ALL AHH", [7, 1843]), ("DLP DLP DLP ALL ALL ALL", [1, 869])],
)
def test_far_poses_are_finite(name, seed):
    """Conjugate rotations with entries near 100, and translations up to 10^6 lengths."""
    instance, _ = random_instance(parse_type(name), np.random.default_rng(seed))
    result = solved(instance)
    assert result.counts.found == result.expected == 64
    assert np.abs(result.T).max() > 1e4
    assert_small_residuals(result)


@pytest.mark.parametrize("index", range(len(DISTANCE_TRIPLES)))
def test_every_random_set_of_values_has_all_its_poses(index):
    """One geometry of each triple with 16 sets of values, most of them without a real pose."""
    gsp_type = GspType.of((*DISTANCE_TRIPLES[index], *ANGLE_TRIPLES[3 * index % 20]))
    rng = np.random.default_rng([index, 99])
    instance, _ = random_instance(gsp_type, rng)
    ranges = [(0.1, 2) if c.kind.is_distance else (20, 80) for c in instance.constraints]
    for poses in solve_values(instance, rng.uniform(*np.transpose(ranges), size=(16, 6))):
        assert len(poses.R) == poses.account.found == poses.account.expected


@given(numbers_of_3d3a, seeds)
def test_the_seed_does_not_matter(number, seed):
    instance = instance_of(number, seed)
    first, second = (solve(instance, seed=s) for s in (1, 2))
    np.testing.assert_array_equal(first.R, second.R)
    np.testing.assert_array_equal(first.T, second.T)


@given(numbers_of_3d3a, seeds)
def test_real_poses_come_first_and_others_in_conjugate_pairs(number, seed):
    result = solved(instance_of(number, seed))
    assert (np.diff(result.real.astype(int)) <= 0).all()
    assert not result.R[result.real].imag.any()
    assert distance(result, result.R.conj(), result.T.conj()) < AGREE
