from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gspcli.catalogue.kinds import KINDS
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side, Units
from gspcli.geometry.measurement import (
    condition_numbers,
    jacobian,
    known_sides,
    measured,
    proved_residuals,
    residuals,
    sides_of,
)
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Line, Plane, Point, vector
from gspcli.geometry.quaternions import rotation_from_quaternion


def test_residuals_respect_sides_and_units():
    point, plane = Point(vector(0, 0, 0)), Plane(vector(0, 0, 0), vector(0, 0, 1))
    instance = Instance(
        (
            Constraint(KINDS[3], point, plane, Number.of(2), Side.NEGATIVE),
            Constraint(KINDS[3], point, plane, Number.of(2), Side.BOTH),
            Constraint(KINDS[9], plane, plane, Number.of(170)),
        ),
        Units("m", AngleUnit.DEGREE),
    )
    arrangement = Arrangement.of(instance)
    pose = np.eye(3), np.array([0.0, 0.0, 2.0])
    np.testing.assert_allclose(residuals(arrangement, *pose), [4, 0, 10], atol=1e-12)
    np.testing.assert_array_equal(sides_of(arrangement, *pose), [-1, 1, 0])


def test_batches_equal_loops(arrangement_of_all_kinds):
    rng = np.random.default_rng(5)
    arrangement = arrangement_of_all_kinds(rng)
    R = rotation_from_quaternion(rng.normal(size=(4, 4)))
    T = rng.normal(size=(4, 3))
    for function in (measured, residuals, jacobian):
        batch = function(arrangement, R, T)
        for k in range(4):
            np.testing.assert_allclose(batch[k], function(arrangement, R[k], T[k]), rtol=1e-12)


def six_of(arrangement: Arrangement) -> Arrangement:
    chosen = [0, 1, 2, 3, 5, 6]
    return replace(
        arrangement,
        kinds=tuple(arrangement.kinds[i] for i in chosen),
        **{name: getattr(arrangement, name)[chosen] for name in ("y", "x", "u", "v", "values")},
        sides=arrangement.sides[chosen],
    )


def test_condition_is_free_of_units_and_frames(arrangement_of_all_kinds, random_pose):
    rng = np.random.default_rng(6)
    arrangement = six_of(arrangement_of_all_kinds(rng))
    R, T = random_pose(rng)
    condition = condition_numbers(arrangement, R, T)
    assert 1 < condition < 1e4
    lengths = arrangement.values * np.where(np.arange(6) < 5, 1e6, 1.0)
    scaled = replace(arrangement, y=arrangement.y * 1e6, x=arrangement.x * 1e6, values=lengths)
    np.testing.assert_allclose(condition_numbers(scaled, R, T * 1e6), condition, rtol=1e-9)
    turn, shift = random_pose(rng)
    moved = replace(arrangement, x=arrangement.x @ turn.T + shift, v=arrangement.v @ turn.T)
    np.testing.assert_allclose(
        condition_numbers(moved, turn @ R, turn @ T + shift), condition, rtol=1e-9
    )
    carried = replace(arrangement, y=arrangement.y @ turn.T + shift, u=arrangement.u @ turn.T)
    np.testing.assert_allclose(
        condition_numbers(carried, R @ turn.T, T - R @ turn.T @ shift), condition, rtol=1e-9
    )


def test_condition_of_a_singular_pose_is_infinite(arrangement_of_all_kinds, random_pose):
    rng = np.random.default_rng(7)
    arrangement = six_of(arrangement_of_all_kinds(rng))
    repeated = replace(
        arrangement,
        kinds=(arrangement.kinds[0],) * 6,
        y=np.zeros((6, 3)),
        x=rng.normal(size=(6, 3)),
    )
    assert condition_numbers(repeated, *random_pose(rng)) == np.inf


def test_many_conditions_are_those_of_each_pose(arrangement_of_all_kinds, random_pose):
    rng = np.random.default_rng(9)
    arrangement = six_of(arrangement_of_all_kinds(rng))
    poses = [random_pose(rng) for _ in range(1030)]
    R, T = (np.array(part) for part in zip(*poses, strict=True))
    lengths = rng.uniform(1, 2, len(R))
    for length in (None, lengths):
        found = condition_numbers(arrangement, R, T, length)
        for k in (0, 1023, 1024, 1029):
            alone = None if length is None else length[k]
            assert found[k] == condition_numbers(arrangement, R[k], T[k], alone)


def test_normalized_arrangement_has_the_same_poses(arrangement_of_all_kinds, random_pose):
    rng = np.random.default_rng(8)
    arrangement = six_of(arrangement_of_all_kinds(rng))
    R, T = random_pose(rng)
    inner = arrangement.normalized
    values = measured(inner, R, T)
    values[:5] *= arrangement.length
    np.testing.assert_allclose(
        measured(arrangement, R, arrangement.restored(R, T)), values, rtol=1e-9
    )


@pytest.mark.parametrize(
    ("sine", "value", "expected", "unproved"),
    [
        # Skew lines 3 apart, where parallel ones would be 5 apart.
        (1e-3, 3, 0, 0),
        (1e-10, 3, 0, 2),
        (1e-13, 3, 0, 2),
        # Parallel ones, exactly and but for rounding.
        (0, 5, 0, 0),
        (1e-16, 5, 0, 0),
        # And neither: the nearer counts.
        (1e-10, 3.5, 0.5, 1.5),
    ],
)
def test_nearly_parallel_lines_are_measured_as_they_are(sine, value, expected, unproved):
    line = Line(vector(4, 3, 0), vector(sine, 0, 1))
    axis = Line(vector(0, 0, 0), vector(0, 0, 1))
    row = Constraint(KINDS[5], line, axis, Number.of(value))
    arrangement = Arrangement.of(Instance((row,), Units("m", AngleUnit.DEGREE)))
    for dtype in (float, complex):
        pose = np.eye(3, dtype=dtype)[None], np.zeros((1, 3), dtype)
        np.testing.assert_allclose(proved_residuals(arrangement, *pose), expected, atol=1e-12)
        np.testing.assert_allclose(residuals(arrangement, *pose), unproved, atol=1e-9)


@pytest.mark.parametrize(
    ("value", "side", "expected"),
    [
        (2, Side.BOTH, 1),
        (1e-9, Side.BOTH, 1),
        # At 1e-17 of a plane three lengths away rounding decides.
        (1e-17, Side.BOTH, 0),
        (1e-17, Side.NEGATIVE, -1),
        (0, Side.BOTH, 1),
    ],
)
def test_sides_are_told_where_doubles_know_them(value, side, expected):
    point, plane = Point(vector(0, 0, 0)), Plane(vector(0, 0, 3), vector(0, 0, 1))
    row = Constraint(KINDS[3], point, plane, Number.of(value), side)
    arrangement = Arrangement.of(Instance((row,), Units("m", AngleUnit.DEGREE)))
    pose = np.eye(3)[None], np.array([[0.0, 0.0, 3 + value]])
    np.testing.assert_array_equal(known_sides(arrangement, *pose), [[expected]])


@pytest.mark.parametrize("off", [0.0, 1e-17, -3e-16])
def test_a_leg_of_length_zero_has_no_direction(arrangement_of_all_kinds, off) -> None:
    """A pose that is off by rounding errors gives the leg the direction of rounding errors."""
    arrangement = six_of(arrangement_of_all_kinds(np.random.default_rng(5)))
    R, T = np.eye(3), arrangement.x[0] - arrangement.y[0] + np.array([off, 0, 0])
    assert arrangement.kinds[0].name == "DPP"
    assert condition_numbers(arrangement, R, T) == np.inf
    assert np.isfinite(condition_numbers(arrangement, R, T + np.array([0.1, 0, 0])))
