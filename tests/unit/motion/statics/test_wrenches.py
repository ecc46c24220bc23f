from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.errors import ArgumentError
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import MovingPlatform, measure
from gspcli.motion.singularities.neighbourhoods import SIGNS
from gspcli.motion.statics.accuracy import accuracy
from gspcli.motion.statics.wrenches import wrenches
from gspcli.resources import data_path

TYPES = ["6PP", "6PL", "6LP", "6PH", "6HP", "6DLL", "PP PL LP PH HP DLL", "PL PL LP ALL ALH AHH"]


def platform(name, seed=0):
    instance, (R, T) = random_instance(gspcli.parse_type(name), np.random.default_rng(seed))
    return instance, R, T


@pytest.mark.parametrize("name", TYPES)
def test_jacobian_agrees_with_finite_differences(name):
    instance, R, T = platform(name)
    point = np.array([0.3, -0.2, 0.5])
    given = wrenches(instance, R, T, point=point)
    step = 1e-6
    columns = []
    for axis in np.eye(6):
        ends = []
        for sign in (1, -1):
            turn = rotation_from_vector(sign * step * axis[:3])
            ends.append(
                measure(instance, turn @ R, point + turn @ (T - point) + sign * step * axis[3:])
            )
        columns.append((ends[0] - ends[1]) / (2 * step))
    difference = np.stack(columns, axis=1)
    difference[given.angles] *= np.pi / 180
    np.testing.assert_allclose(difference, given.jacobian, atol=1e-7)
    np.testing.assert_allclose(given.inverse @ given.jacobian, np.eye(6), atol=1e-10)


def test_lines_that_meet_keep_the_sign_of_their_orientation():
    instance, R, T = platform("DLL PP PP PP PP PP")
    k = next(k for k, row in enumerate(instance.constraints) if row.kind.name == "DLL")
    row = instance.constraints[k]
    away = R @ row.platform.point + T - row.base.point
    normal = np.cross(R @ row.platform.unit, row.base.unit)
    normal /= np.linalg.norm(normal)
    meeting = T - (away @ normal) * normal
    for shift in (-1e-15, 0.0, 1e-15):
        given = wrenches(instance, R, meeting + shift * normal)
        assert measure(instance, R, meeting + shift * normal)[k] < 1e-14
        np.testing.assert_allclose(given.forces[k], normal, atol=1e-12)


@pytest.mark.parametrize("name", TYPES)
def test_reactions_hold_the_load_whatever_the_point(name):
    instance, R, T = platform(name)
    force, moment, at = np.random.default_rng(1).normal(size=(3, 3))
    given = wrenches(instance, R, T, point=np.zeros(3))
    held = given.reactions(force, moment, at)
    np.testing.assert_allclose(held @ given.forces, -force, atol=1e-9)
    np.testing.assert_allclose(held @ given.moments, -moment - np.cross(at, force), atol=1e-9)
    elsewhere = wrenches(instance, R, T, point=[3, 2, 1], length=7)
    np.testing.assert_allclose(elsewhere.reactions(force, moment, at), held, atol=1e-8)
    constraint, direction, reaction = given.worst_force
    assert np.linalg.norm(direction) == pytest.approx(1)
    one = given.reactions(direction, np.zeros(3), given.point)
    assert abs(one).max() == pytest.approx(reaction)
    assert one[constraint] == pytest.approx(reaction)


def test_legs_are_forces_along_themselves():
    instance, R, T = platform("6PP")
    given = wrenches(instance, R, T)
    for k, constraint in enumerate(instance.constraints):
        end = R @ constraint.platform.point + T
        leg = end - constraint.base.point
        np.testing.assert_allclose(given.forces[k], leg / np.linalg.norm(leg), atol=1e-12)
        assert given.pitches[k] == 0
        # The axis of the screw is the leg's line.
        np.testing.assert_allclose(np.cross(given.feet[k] - end, leg), np.zeros(3), atol=1e-12)


def test_angles_are_couples():
    instance, R, T = platform("PP PL LP ALL ALH AHH")
    given = wrenches(instance, R, T)
    assert given.angles.tolist() == [False] * 3 + [True] * 3
    assert not given.forces[3:].any()
    assert np.isinf(given.pitches[3:]).all()
    assert np.isnan(given.feet[3:]).all()
    assert np.allclose(np.linalg.norm(given.moments[3:], axis=1), 1)


def test_units_of_length_change_no_scaled_number():
    instance, R, T = platform("PP PL LP PH ALL AHH", 2)
    given = wrenches(instance, R, T, length=2.0)
    assert given.manipulability == pytest.approx(abs(np.linalg.det(given.scaled)))
    rows = given.scaled / np.linalg.norm(given.scaled, axis=-1, keepdims=True)
    assert given.conditions == pytest.approx(np.linalg.cond(rows))
    elsewhere = wrenches(instance, R, T, length=2.0, point=(1.0, 2.0, 3.0))
    assert elsewhere.conditions == given.conditions
    assert elsewhere.manipulability == pytest.approx(given.manipulability)
    stiffness = given.stiffness(given.compliance(rods=np.arange(1.0, 7)))
    assert np.allclose(stiffness, given.jacobian.T @ np.diag(np.arange(1.0, 7)) @ given.jacobian)


def test_a_singular_pose_has_no_inverse():
    instance = gspcli.load(data_path("examples", "platform-6-6.yaml"))
    fold = gspcli.track(
        instance, [[2.53, 2.08, 0.93, 1.97, 1.46, 1.73], [2.6, 2.0, 1.0, 1.9, 1.46, 1.73]]
    ).events[0]
    given = wrenches(instance, fold.R, fold.T)
    assert given.conditions > 1e14
    assert np.isnan(given.inverse).all()
    errors = accuracy(wrenches(instance, fold.R[None], fold.T[None]), np.full(6, 1e-6))
    assert np.isinf(errors.bound).all()


@pytest.mark.parametrize("name", TYPES)
def test_errors_at_the_corners_are_between_first_order_and_the_bound(name):
    instance, R, T = platform(name)
    given = wrenches(instance, R[None], T[None])
    limits = np.where(given.angles, 5e-5, 1e-6)
    errors = accuracy(given, limits)
    moving = MovingPlatform(instance)
    values = measure(instance, R, T)
    signs = np.concatenate((SIGNS, -SIGNS))
    ends = np.stack((np.broadcast_to(values, signs.shape), values + signs * limits), axis=1)
    start = np.repeat(moving.points(R[None], T[None]), len(signs), axis=0)
    followed = moving.follow(moving.internal(ends), np.arange(len(signs)), start)
    assert (followed.stop == 0).all()
    R2, T2 = moving.poses(followed.points[:, -1])
    point = given.point[0]
    shifts = R2 @ (R.T @ (point - T)) + T2 - point
    turns = R2 @ R.T
    vectors = (
        np.stack(
            (
                turns[:, 2, 1] - turns[:, 1, 2],
                turns[:, 0, 2] - turns[:, 2, 0],
                turns[:, 1, 0] - turns[:, 0, 1],
            ),
            axis=1,
        )
        / 2
    )
    every = np.abs(np.concatenate((vectors, shifts), axis=1)).max(axis=0)
    assert np.isfinite(errors.bound).all()
    assert (every <= errors.bound[0]).all()
    assert np.linalg.norm(shifts, axis=1).max() <= errors.bound_shift[0]
    assert np.linalg.norm(vectors, axis=1).max() <= errors.bound_turn[0]
    # To first order they are the worst, and the bound is not far above.
    np.testing.assert_allclose(every, errors.worst[0], rtol=0.02)
    assert np.linalg.norm(shifts, axis=1).max() == pytest.approx(errors.worst_shift[0], rel=0.02)
    assert (errors.bound[0] < 4 * errors.worst[0] + 1e-5).all()
    assert (errors.rms <= errors.worst).all()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda i, R, T: wrenches(i, R, T, length=0), "length: found 0"),
        (lambda i, R, T: accuracy(wrenches(i, R, T), [1, 2]), "tolerances: found"),
        (lambda i, R, T: accuracy(wrenches(i, R, T), [-1] * 6), "tolerances: found"),
    ],
)
def test_mistakes_are_named(call, message):
    with pytest.raises(ArgumentError, match=message):
        call(*platform("6PP"))
