"""Ranges of values and cones of joints at poses."""

import numpy as np
import pytest

import gspcli
from gspcli.errors import ArgumentError
from gspcli.geometry.machine import Machine
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.motion import measure

UP = [0, 0, 1]


def hexapod(base_cone=None, platform_cone=None):
    ring = np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [2, 1, 0], [1, 2, 1]])
    return gspcli.instance(
        gspcli.distance(
            gspcli.Point(p.tolist(), platform_cone),
            gspcli.Point(p.tolist(), base_cone),
            2,
            range=("3/2", 3),
        )
        for p in ring
    )


def test_the_tilt_of_a_leg_is_measured_in_the_body_of_its_joint():
    instance = hexapod(gspcli.Cone(UP, 30), gspcli.Cone([0, 0, -3], 40))
    assert [(c.constraint, c.body) for c in Machine.of(instance).cones][:2] == [
        (0, "platform"),
        (0, "base"),
    ]
    # Moved aside by as much as it is high: every leg is tilted by 45 degrees.
    angles = Machine.of(instance).tilts(np.eye(3), np.array([2.0, 0, 2]))
    assert np.allclose(angles, np.pi / 4)
    # Turned about a leg, that keeps its tilt in the base, and all tilts are those of its body.
    turned = rotation_from_quaternion(np.array([np.cos(0.2), 0, np.sin(0.2), 0]))
    angles = Machine.of(instance).tilts(turned, np.array([0, 0, 2.0]))
    legs = instance.constraints[2]
    leg = turned @ legs.platform.point + [0, 0, 2] - legs.base.point
    seen = turned.T @ -leg / np.linalg.norm(leg)
    assert np.isclose(np.cos(angles[4]), -seen[2])
    assert np.isclose(np.cos(angles[5]), leg[2] / np.linalg.norm(leg))


def test_moving_base_and_platform_together_changes_nothing():
    rng = np.random.default_rng(3)
    R = rotation_from_quaternion(rng.normal(size=4))
    T = rng.normal(size=3)
    turn = rotation_from_quaternion(rng.normal(size=4))
    axis = np.array([0.3, 0.1, 1.0])
    one, other = hexapod(gspcli.Cone(axis.tolist(), 50)), hexapod()
    rows = [
        gspcli.distance(
            row.platform,
            gspcli.Point((turn @ row.base.point).tolist(), gspcli.Cone((turn @ axis).tolist(), 50)),
            2,
        )
        for row in other.constraints
    ]
    moved = gspcli.instance(rows)
    assert np.allclose(Machine.of(one).tilts(R, T), Machine.of(moved).tilts(turn @ R, turn @ T))


def test_limits_are_kept_or_left():
    instance = hexapod(gspcli.Cone(UP, 30))
    T = np.array([[0, 0, 2.0], [0, 0, 1.4], [0, 0, 3.0], [2, 0, 2], [0, 0, 3 + 1e-9]])
    R = np.broadcast_to(np.eye(3), (5, 3, 3))
    machine = Machine.of(instance)
    assert machine.keeps(R, T).tolist() == [True, False, True, False, False]
    assert machine.out_of_cones(R, T).any(axis=1).tolist() == [False] * 3 + [True, False]


@pytest.mark.parametrize(
    ("side", "outside"),
    [
        ("positive", [True, False, True, True]),
        ("negative", [True, True, False, True]),
        ("both", [True, False, False, True]),
    ],
)
def test_the_range_of_a_distance_to_a_plane_is_on_its_side(side, outside):
    floor = gspcli.Plane([0, 0, 0], UP)
    rows = [
        gspcli.distance(gspcli.Point([k, k * k, 0]), floor, 1, side=side, range=(1, 2))
        for k in range(3)
    ]
    rows += [gspcli.distance(gspcli.Point([k, 1, k]), gspcli.Point([1, k, 0]), 1) for k in range(3)]
    instance = gspcli.instance(rows)
    values = np.array([[0.5], [1.5], [-1.5], [2.5]]) * np.ones(6)
    assert Machine.of(instance).outside(values)[:, 0].tolist() == outside
    assert not Machine.of(instance).outside(values)[:, 3:].any()
    shares = Machine.of(instance).range_shares(values)
    assert (shares[:, 0] > 1).tolist() == outside
    assert np.isnan(shares[:, 3:]).all()


def test_shares_of_limits():
    instance = hexapod(gspcli.Cone(UP, 30))
    T = np.array([[0, 0, 2.25], [0, 0, 1.5], [0, 0, 3.0], [0, 0, 3 + 1e-9], [np.sqrt(3), 0, 3.0]])
    R = np.broadcast_to(np.eye(3), (5, 3, 3))
    shares = Machine.of(instance).range_shares(measure(instance, R, T))
    assert np.allclose(shares[:4], np.array([0, 1, 1, 1])[:, None])
    assert (shares > 1).all(axis=1).tolist() == [False, False, False, True, True]
    shares = Machine.of(instance).cone_shares(R, T)
    assert np.allclose(shares, np.array([0, 0, 0, 0, 1])[:, None])
    assert ((shares > 1) == Machine.of(instance).out_of_cones(R, T)).all()


def test_the_share_of_a_range_of_one_value():
    rows = [
        gspcli.distance(row.platform, row.base, 2, range=(2, 2)) for row in hexapod().constraints
    ]
    instance = gspcli.instance(rows)
    values = np.array([[2.0] * 6, [2 + 1e-9] * 6])
    assert Machine.of(instance).range_shares(values).tolist() == [[1.0] * 6, [np.inf] * 6]


def test_a_cone_needs_a_leg_and_a_sensible_angle():
    with pytest.raises(ArgumentError, match="half_angle: found 180, expected a half angle above 0"):
        hexapod(gspcli.Cone(UP, 180))
    with pytest.raises(ArgumentError, match="axis: found the zero vector"):
        gspcli.Cone([0, 0, 0], 30)
    with pytest.raises(ArgumentError, match="half_angle"):
        gspcli.Cone(UP, "x")
    limited = gspcli.Point([0, 0, 0], gspcli.Cone(UP, 30))
    line = gspcli.Line([0, 0, 0], UP)
    rows = [gspcli.distance(limited, line, 1)]
    rows += [gspcli.distance(gspcli.Point([k, 1, 0]), line, 1) for k in range(5)]
    with pytest.raises(
        ArgumentError, match=r"platform\.cone: found a cone at a point without a leg"
    ):
        gspcli.instance(rows)


def test_a_distance_held_at_zero_is_kept_up_to_rounding():
    """Home of a tripod is 2e-16 off two of its planes."""
    tripod = gspcli.example("three-rps")
    values = measure(tripod, np.eye(3)[None], np.array([[0.0, 0.0, 4.0]]))[0]
    assert (values[3:] != 0).any()
    assert not Machine.of(tripod).outside(values).any()
    assert Machine.of(tripod).range_shares(values)[3:].tolist() == [1, 1, 1]
    values[4] += 1e-9
    assert Machine.of(tripod).outside(values).tolist() == [k == 4 for k in range(6)]
