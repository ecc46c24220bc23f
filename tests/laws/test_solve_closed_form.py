"""The closed form does not care about frames, units, order, or which body is the base."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations_with_replacement, product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matching import pose_set_distance

from gspcli.catalogue.kinds import ANGLE_KINDS, DISTANCE_KINDS
from gspcli.catalogue.names import parse_type
from gspcli.catalogue.types import GspType, type_by_number
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side, Units
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, Line, Plane, Point, vector
from gspcli.geometry.quaternions import apply, rotation_from_quaternion
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


def moved(geometry: Geometry, R: np.ndarray, T: np.ndarray, scale: float = 1.0) -> Geometry:
    position = vector(*(scale * (R @ geometry.point + T)).tolist())
    if isinstance(geometry, Point):
        return Point(position)
    return type(geometry)(position, vector(*(R @ geometry.unit).tolist()))


def solved(instance: Instance) -> SolveResult:
    result = solve(instance)
    assert result.verdict == "complete"
    return result


def distance(result: SolveResult, R: np.ndarray, T: np.ndarray) -> float:
    return pose_set_distance((result.R, result.T), (R, T), result.arrangement.length)


def motion(seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rotation_from_quaternion(rng.normal(size=4)), 10 * rng.normal(size=3)


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
def test_a_motion_of_the_base_moves_the_poses(number, seed):
    instance = instance_of(number, seed)
    S, t = motion(seed + 1)
    other = replace(
        instance,
        constraints=tuple(replace(c, base=moved(c.base, S, t)) for c in instance.constraints),
    )
    first = solved(instance)
    assert distance(solved(other), S @ first.R, apply(S, first.T) + t) < AGREE


@given(numbers_of_3d3a, seeds)
def test_a_motion_of_the_platform_moves_the_poses(number, seed):
    instance = instance_of(number, seed)
    S, t = motion(seed + 2)
    other = replace(
        instance,
        constraints=tuple(
            replace(c, platform=moved(c.platform, S, t)) for c in instance.constraints
        ),
    )
    first = solved(instance)
    R = first.R @ S.T
    assert distance(solved(other), R, first.T - apply(R, t)) < AGREE


@given(numbers_of_3d3a, seeds, st.permutations(range(6)))
def test_the_order_of_the_constraints_does_not_matter(number, seed, order):
    instance = instance_of(number, seed)
    other = replace(instance, constraints=tuple(instance.constraints[i] for i in order))
    first = solved(instance)
    assert distance(solved(other), first.R, first.T) < AGREE


@given(numbers_of_3d3a, seeds, st.floats(-6, 6))
def test_units_do_not_matter(number, seed, exponent):
    instance = instance_of(number, seed)
    scale = 10.0**exponent
    still = np.eye(3), np.zeros(3)
    rows = []
    for c in instance.constraints:
        factor = scale if c.kind.is_distance else instance.units.angle.in_radians
        rows.append(
            replace(
                c,
                platform=moved(c.platform, *still, scale),
                base=moved(c.base, *still, scale),
                value=Number.of(c.value.value * factor),
            )
        )
    other = replace(instance, constraints=tuple(rows), units=Units("other", AngleUnit.RADIAN))
    first = solved(instance)
    assert distance(solved(other), first.R, scale * first.T) < AGREE


@given(numbers_of_3d3a, seeds)
def test_base_and_platform_may_be_exchanged(number, seed):
    instance = instance_of(number, seed)
    other = replace(
        instance,
        constraints=tuple(
            Constraint(c.kind.mirrored, c.base, c.platform, c.value, c.side)
            for c in instance.constraints
        ),
    )
    first = solved(instance)
    inverse = np.swapaxes(first.R, -1, -2)
    assert distance(solved(other), inverse, -apply(inverse, first.T)) < AGREE


@given(
    st.sampled_from([d for d in DISTANCE_TRIPLES if any(kind.has_sides for kind in d)]),
    st.sampled_from(ANGLE_TRIPLES),
    seeds,
)
def test_all_sides_together_are_both_sides(distances, angles, seed):
    gsp_type = GspType.of((*distances, *angles))
    instance, _ = random_instance(gsp_type, np.random.default_rng(seed))
    sided = [i for i, c in enumerate(instance.constraints) if c.kind.has_sides]
    parts = []
    for sides in product((Side.POSITIVE, Side.NEGATIVE), repeat=len(sided)):
        rows = list(instance.constraints)
        for i, side in zip(sided, sides, strict=True):
            rows[i] = replace(rows[i], side=side)
        parts.append(solved(replace(instance, constraints=tuple(rows))))
    both = solved(instance)
    assert both.expected == sum(part.expected for part in parts)
    R = np.concatenate([part.R for part in parts])
    T = np.concatenate([part.T for part in parts])
    assert distance(both, R, T) < AGREE


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


def test_the_helpers_move_lines_and_planes():
    S, t = motion(0)
    for shape in (Line, Plane):
        there = moved(shape(vector(0, 0, 0), vector(0, 0, 2)), S, t)
        np.testing.assert_allclose(there.point, t)
        np.testing.assert_allclose(there.unit, S[:, 2], atol=1e-12)
