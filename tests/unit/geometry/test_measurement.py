"""What constraints measure, and its derivatives, at real and at complex poses."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gspcli.catalogue.kinds import ALL, DLL, KINDS
from gspcli.geometry.arrangement import Arrangement, Bodies
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Units
from gspcli.geometry.measurement import (
    _angle,
    curvature,
    jacobian,
    measured,
    polynomial,
    printed_condition,
    printed_conditions,
    printed_residual,
    printed_residuals,
    residuals,
)
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Line, Plane, Point, vector
from gspcli.geometry.quaternions import Field, rotation_from_quaternion


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


def test_complex_values_continue_the_real_ones(arrangement_of_all_kinds, random_pose):
    rng = np.random.default_rng(0)
    arrangement = arrangement_of_all_kinds(rng)
    R, T = random_pose(rng)
    real = measured(arrangement, R, T)
    np.testing.assert_allclose(measured(arrangement, R + 0j, T + 0j), real, rtol=1e-12)
    np.testing.assert_allclose(measured(arrangement, R, T + 1e-8j), real, atol=1e-6)


def test_jacobian_against_complex_step(arrangement_of_all_kinds, random_pose):
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


def test_jacobian_at_complex_poses_against_differences(arrangement_of_all_kinds, random_pose):
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


def _along(twist: np.ndarray, s: complex, R: Field, T: Field) -> tuple[Field, Field]:
    """Return the pose moved along a twist, by Rodrigues' formula; s may be complex."""
    omega, angle = twist[:3], np.linalg.norm(twist[:3])
    K = np.cross(np.eye(3), omega / angle)
    turn = np.eye(3) + np.sin(s * angle) * K + (1 - np.cos(s * angle)) * K @ K
    return turn @ R, T + s * twist[3:]


@pytest.mark.parametrize("imaginary", [0.0, 0.2])
def test_curvature_against_differences_of_the_jacobian(
    arrangement_of_all_kinds, random_pose, imaginary
):
    """Along a screw the first derivative is ``J t`` everywhere, so its change is ``t.H t``."""
    rng = np.random.default_rng(3)
    arrangement = arrangement_of_all_kinds(rng)
    h = 1e-5
    for _ in range(5):
        R, T = random_pose(rng, imaginary)
        for twist in rng.normal(size=(10, 6)):
            ahead, behind = (
                jacobian(arrangement, *_along(twist, s, R, T)) @ twist for s in (h, -h)
            )
            expected = (ahead - behind) / (2 * h)
            found = curvature(arrangement, R, T, twist)
            np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-6)


def test_curvature_against_complex_step(arrangement_of_all_kinds, random_pose):
    rng = np.random.default_rng(4)
    arrangement = arrangement_of_all_kinds(rng)
    R, T = random_pose(rng)
    for twist in rng.normal(size=(10, 6)):
        first = jacobian(arrangement, *_along(twist, 1e-30j, R, T)) @ twist
        found = curvature(arrangement, R, T, twist)
        np.testing.assert_allclose(found, first.imag / 1e-30, rtol=1e-9, atol=1e-9)


def test_measured_of_many_platforms_at_once(arrangement_of_all_kinds, random_pose):
    """Geometries may have batch axes as poses do."""
    rng = np.random.default_rng(9)
    each = [arrangement_of_all_kinds(rng) for _ in range(3)]
    parts = ("y", "x", "u", "v")
    many = Bodies(KINDS, *(np.array([getattr(one, part) for one in each]) for part in parts))
    poses = [random_pose(rng) for _ in each]
    R, T = (np.array(part) for part in zip(*poses, strict=True))
    for function in (measured, jacobian):
        expected = [function(one, *pose) for one, pose in zip(each, poses, strict=True)]
        np.testing.assert_allclose(function(many, R, T), expected, rtol=1e-12)


def test_polynomials_against_what_is_measured(arrangement_of_all_kinds, random_pose):
    """Squares of distances to points and lines, moments, and the cosines asked for."""
    rng = np.random.default_rng(10)
    arrangement = arrangement_of_all_kinds(rng)
    R, T = random_pose(rng)
    r, w, _ = arrangement.placed(R, T)
    values = measured(arrangement, R, T)
    cosines = arrangement.cosines(values)
    for i, kind in enumerate(KINDS):
        found = polynomial(kind).value(r[i], w[i], arrangement.v[i])
        sine = np.linalg.norm(np.cross(w[i], arrangement.v[i]))
        if not kind.is_distance:
            expected = cosines[i - 6]
        elif kind.has_sides:
            expected = values[i]
        else:
            expected = values[i] * sine if kind is DLL else values[i] ** 2
        assert found == pytest.approx(expected, rel=1e-12), kind


@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_derivatives_of_polynomials_against_complex_step(kind):
    rng = np.random.default_rng(11)
    vectors = rng.normal(size=(3, 4, 3))
    vectors[1:] /= np.linalg.norm(vectors[1:], axis=-1, keepdims=True)
    gradient, changes = polynomial(kind).gradient(*vectors), []
    for which, direction in enumerate(vectors):
        change = rng.normal(size=direction.shape)
        if which:
            # Directions stay unit vectors.
            change -= (change * direction).sum(-1, keepdims=True) * direction
        moved = vectors.astype(complex)
        moved[which] += 1e-30j * change
        value = polynomial(kind).value(*moved).imag / 1e-30
        np.testing.assert_allclose((gradient[which] * change).sum(-1), value, atol=1e-12)
        changes.append(change)
    a, b, _ = changes
    moved = vectors.astype(complex)
    moved[:2] += 1e-30j * np.array([a, b])
    slope = polynomial(kind).gradient(*moved)
    bent = (slope.r.imag * a + slope.w.imag * b).sum(axis=-1) / 1e-30
    np.testing.assert_allclose(polynomial(kind).bend(*vectors, a, b), bent, atol=1e-12)


def test_the_angle_of_long_complex_directions_is_a_number():
    # Unit vectors by the bilinear product, whose squares cancel beyond all digits of doubles.
    size = 1e10
    w = np.array([np.sqrt(1 + size**2), 1j * size, 0])
    angle = _angle(ALL.law, w[None], np.array([[0.0, 0.0, 1.0]], complex))
    np.testing.assert_allclose(angle, np.pi / 2)
    assert np.isfinite(
        _angle(ALL.law, w[None] * [1, 1j, 0], np.array([[1.0, 0.0, 0.0]], complex))
    ).all()


# Condition numbers and residuals as files have them: rounding errors do not change them.


@pytest.mark.parametrize(
    ("condition", "printed"),
    [
        (1.0, 1.0),
        (36.98214567, 36.9821),
        (123456.789, 123457.0),
        (1.23456e7, 1.235e7),
        (1.23456e11, 1e11),
        (1.2e15, 1e15),
        (math.inf, math.inf),
    ],
)
def test_a_condition_number_has_the_digits_that_are_known(condition, printed) -> None:
    assert printed_condition(condition) == printed


@pytest.mark.parametrize("condition", [1.37, 44.4, 6.1234e4, 7.7e7, 3.21e10])
def test_rounding_errors_change_no_digit_of_a_condition_number(condition: float) -> None:
    error = 3e-15 * condition
    near = condition * (1 + error * np.linspace(-1, 1, 9))
    assert len(set(printed_conditions(near).tolist())) == 1


def test_arrays_keep_their_shape() -> None:
    numbers = np.array([[1.0, np.nan], [np.inf, 2.5]])
    found = printed_conditions(numbers)
    assert found.shape == (2, 2)
    assert np.isnan(found[0, 1])
    assert np.isinf(found[1, 0])
    assert printed_residuals(np.zeros((0,)), 1.0).shape == (0,)


@pytest.mark.parametrize("residual", [0.0, 1e-17, 3.3e-16, 8.9e-15])
def test_residuals_of_rounding_errors_are_written_alike(residual: float) -> None:
    assert printed_residual(residual, 1.0) == 2e-14
    assert printed_residual(residual * 250, 250.0) == 4e-12


@pytest.mark.parametrize(
    ("residual", "printed"), [(1.01e-9, 2e-9), (9.5e-4, 1e-3), (2.0, 2.0), (math.inf, math.inf)]
)
def test_a_residual_is_not_more_than_is_written(residual: float, printed: float) -> None:
    assert printed_residual(residual, 1.0) == printed


def test_without_a_length_a_residual_of_zero_is_zero() -> None:
    assert printed_residual(0.0, 0.0) == 0.0
