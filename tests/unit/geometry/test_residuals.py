from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gspcli.catalogue.kinds import KINDS
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side, Units
from gspcli.geometry.numbers import Number
from gspcli.geometry.poses import rotation_from_quaternion
from gspcli.geometry.primitives import Line, Plane, Point, vector
from gspcli.geometry.residuals import (
    Arrangement,
    condition_numbers,
    jacobian,
    measured,
    residuals,
    sides_of,
)


def arrangement_of_all_kinds(rng: np.random.Generator) -> Arrangement:
    """Every kind once: ten constraints, whatever the number in an instance."""
    rows = len(KINDS)

    def directions(letters: list[str]) -> np.ndarray:
        d = rng.normal(size=(rows, 3))
        d /= np.linalg.norm(d, axis=1, keepdims=True)
        return d * np.array([[letter != "P"] for letter in letters])

    return Arrangement(
        kinds=KINDS,
        y=rng.normal(size=(rows, 3)),
        x=rng.normal(size=(rows, 3)),
        u=directions([kind.platform.value for kind in KINDS]),
        v=directions([kind.base.value for kind in KINDS]),
        values=rng.uniform(0.2, 1, size=rows),
        sides=np.zeros(rows, int),
        in_radians=1.0,
    )


def random_pose(rng: np.random.Generator, imaginary: float = 0.0):
    e, T = rng.normal(size=4), rng.normal(size=3)
    if imaginary:
        e = e + imaginary * 1j * rng.normal(size=4)
        T = T + imaginary * 1j * rng.normal(size=3)
    return rotation_from_quaternion(e), T


def test_measured_values_of_known_positions():
    """A platform point or line at (3, 4, 12) against primitives along the z axis."""
    origin, z = vector(0, 0, 0), vector(0, 0, 2)
    units = Units("m", AngleUnit.DEGREE)
    body = {"P": Point(origin), "L": Line(origin, vector(5, 0, 0)), "H": Plane(origin, z)}
    base = {"P": Point(origin), "L": Line(origin, z), "H": Plane(origin, z)}
    expected = {
        "DPP": 13,
        "DPL": 5,
        "DLP": np.hypot(4, 12),
        "DPH": 12,
        "DHP": -12,
        "DLL": 4,
        "ALL": np.pi / 2,
        "ALH": 0,
        "AHL": np.pi / 2,
        "AHH": np.pi,
    }
    for kind in KINDS:
        constraint = Constraint(
            kind, body[kind.platform.value], base[kind.base.value], Number.of(1)
        )
        arrangement = Arrangement.of(Instance((constraint,), units))
        value = measured(arrangement, np.eye(3), np.array([3.0, 4.0, 12.0]))
        assert abs(value[0]) == pytest.approx(abs(expected[kind.name]), abs=1e-15), kind
        if kind.has_sides or not kind.is_distance:
            assert value[0] == pytest.approx(expected[kind.name], abs=1e-15), kind


def test_parallel_lines_are_measured_like_a_point_and_a_line():
    line = Line(vector(0, 0, 0), vector(0, 0, 1))
    constraint = Constraint(KINDS[5], line, line, Number.of(5))
    arrangement = Arrangement.of(Instance((constraint,), Units("m", AngleUnit.RADIAN)))
    pose = np.eye(3), np.array([3.0, 4.0, 7.0])
    assert measured(arrangement, *pose)[0] == 5
    assert residuals(arrangement, *pose)[0] == 0


def test_complex_values_continue_the_real_ones():
    rng = np.random.default_rng(0)
    arrangement = arrangement_of_all_kinds(rng)
    R, T = random_pose(rng)
    real = measured(arrangement, R, T)
    np.testing.assert_allclose(measured(arrangement, R + 0j, T + 0j), real, rtol=1e-12)
    np.testing.assert_allclose(measured(arrangement, R, T + 1e-8j), real, atol=1e-6)


def test_jacobian_against_complex_step():
    rng = np.random.default_rng(1)
    arrangement = arrangement_of_all_kinds(rng)
    step = 1e-30
    for _ in range(5):
        R, T = random_pose(rng)
        columns = []
        for twist in np.eye(6):
            turn = rotation_from_quaternion(np.concatenate(([1], 1j * step * twist[:3] / 2)))
            values = measured(arrangement, turn @ R, T + 1j * step * twist[3:])
            columns.append(values.imag / step)
        np.testing.assert_allclose(
            jacobian(arrangement, R, T), np.array(columns).T, rtol=1e-9, atol=1e-9
        )


def test_jacobian_at_complex_poses_against_differences():
    rng = np.random.default_rng(2)
    arrangement = arrangement_of_all_kinds(rng)
    R, T = random_pose(rng, imaginary=0.2)
    h = 1e-6
    for column, twist in enumerate(np.eye(6)):
        ahead, behind = (
            measured(
                arrangement,
                rotation_from_quaternion(np.concatenate(([1], s * twist[:3] / 2))) @ R,
                T + s * twist[3:],
            )
            for s in (h, -h)
        )
        difference = (ahead - behind) / (2 * h)
        np.testing.assert_allclose(jacobian(arrangement, R, T)[:, column], difference, atol=1e-7)


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


def test_batches_equal_loops():
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


def test_condition_is_free_of_units_and_frames():
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


def test_condition_of_a_singular_pose_is_infinite_or_huge():
    rng = np.random.default_rng(7)
    arrangement = six_of(arrangement_of_all_kinds(rng))
    repeated = replace(
        arrangement,
        kinds=(arrangement.kinds[0],) * 6,
        y=np.zeros((6, 3)),
        x=rng.normal(size=(6, 3)),
    )
    assert condition_numbers(repeated, *random_pose(rng)) > 1e12


def test_normalised_arrangement_has_the_same_poses():
    rng = np.random.default_rng(8)
    arrangement = six_of(arrangement_of_all_kinds(rng))
    R, T = random_pose(rng)
    inner = arrangement.normalised
    values = measured(inner, R, T)
    values[:5] *= arrangement.length
    np.testing.assert_allclose(
        measured(arrangement, R, arrangement.restored(R, T)), values, rtol=1e-9
    )
