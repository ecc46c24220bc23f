"""Torques of cranks and slides by hand, laws that they keep, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.dynamics import inverse_dynamics, natural_modes
from gspcli.dynamics.arrays import RowError
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.building import distance
from gspcli.geometry.building import instance as build
from gspcli.geometry.machine import Machine
from gspcli.geometry.masses import Carriage
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Plane, Point
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.motion import measure
from tests.support.driven_machines import MADE_UP, SHIPPED, driven, some_pose, weighed
from tests.support.masses import random_platform
from tests.support.surface_machines import print_bed
from tests.unit.dynamics.test_forces import hexapod


@pytest.fixture(params=[*SHIPPED, *MADE_UP])
def case(request):
    """Return a machine with masses, a pose, the numbers of its drives and a generator."""
    rng = np.random.default_rng(2)
    instance = weighed(driven(request.param), rng)
    return instance, *some_pose(instance, rng), rng


def test_forces_of_rods_without_mass_give_the_torques(case):
    """With the platform alone the torques are D^T F: of rods, arms and rotors nothing is added."""
    instance, R, T, q, _ = case
    bare = replace(instance.dynamics, legs=(), arms=(), carriages=(), drives=gspcli.Drives())
    found = inverse_dynamics(replace(instance, dynamics=bare), R, T)
    drives = Machine.of(instance)
    D = drives.matrix(drives.gains(R, T, q))
    assert np.allclose(found.torques[0], found.forces[0] @ D, rtol=1e-12)
    J = drives.jacobian(R, T, q)
    weight = np.array([g.value for g in bare.gravity]) * bare.platform.mass.value
    at = R @ [c.value for c in bare.platform.centre]
    held = J.T @ found.forces[0] + np.concatenate((np.cross(at, weight), weight))
    assert np.abs(held).max() < 1e-12 * np.abs(weight).max()


def test_drives_at_given_numbers_are_those_of_the_pose(case):
    instance, R, T, q, _ = case
    drives = Machine.of(instance)
    given = inverse_dynamics(instance, R, T, drives=q / drives.units)
    assert np.allclose(given.torques, inverse_dynamics(instance, R, T).torques, rtol=1e-9)
    other = (
        q + 0.1 * drives.driven[[drives.users(k)[0] for k in range(drives.count)]]
    ) / drives.units
    with pytest.raises(RowError, match="another length"):
        inverse_dynamics(instance, R, T, drives=other)


def test_a_weight_on_one_carriage_is_lifted_by_its_drive_alone():
    instance = driven("6-PUS")
    rng = np.random.default_rng(3)
    R, T, _ = some_pose(instance, rng)
    weighs = weighed(instance, rng).dynamics
    light, heavy = (
        replace(weighs, carriages=tuple(Carriage(1 + 2.5 * (k == 3 and more)) for k in range(6)))
        for more in (0, 1)
    )
    a, b = (
        inverse_dynamics(replace(instance, dynamics=d), R, T).torques[0] for d in (light, heavy)
    )
    rail = instance.constraints[3].base.slide.unit
    gravity = np.array([g.value for g in weighs.gravity])
    assert np.allclose(b - a, -2.5 * np.eye(6)[3] * (rail @ gravity), atol=1e-12 * np.abs(a).max())


def test_slides_under_planes_lift_a_bed():
    """What the slides do in a small lift is the change of the potential energy."""
    bed = replace(
        print_bed(),
        dynamics=gspcli.Dynamics(gspcli.RigidBody(2, [30, 40, 20], [1e4] * 3 + [0] * 3)),
    )
    drives, R, T = Machine.of(bed), np.eye(3), np.zeros(3)
    found = inverse_dynamics(bed, R, T)
    J, D = drives.jacobian(R, T, np.zeros(3)), drives.matrix(drives.gains(R, T, np.zeros(3)))
    lifts = np.linalg.solve(J, D)
    rise = lifts[5] + np.cross(lifts[:3].T, [30, 40, 20])[:, 2]
    np.testing.assert_allclose(found.torques[0], 2 * 9.81 * rise, rtol=1e-9)
    assert found.torques.sum() == pytest.approx(2 * 9.81)


def test_a_hand_computed_crank():
    """A mass of 1 kg on an arm of 0.1 m that stands out level: the motor holds m g c."""
    instance = driven("reachy-mini-head")
    weighs = weighed(instance, np.random.default_rng(1)).dynamics
    drives = Machine.of(instance)
    home = instance.home
    T = np.array([x.value for x in home.position])
    with_arm, without = (
        inverse_dynamics(replace(instance, dynamics=replace(weighs, arms=arms)), np.eye(3), T)
        for arms in ((gspcli.Arm(0.5, 0.02),), ())
    )
    gravity = np.array([g.value for g in weighs.gravity])
    q = drives.inverse(np.eye(3), T)
    way = drives.velocities(q) / drives.arms[:, None] * 0.02
    assert np.allclose(with_arm.torques[0] - without.torques[0], -0.5 * way @ gravity, atol=1e-14)
    # The forces in the rods are the same.
    assert np.allclose(with_arm.forces, without.forces, rtol=1e-12)


def test_a_pose_out_of_reach_and_a_dead_point_name_the_drive():
    instance = weighed(driven("6-PUS"), np.random.default_rng(1))
    far = np.array([[0, 0, 0.6], [0, 0, 3.0]])
    with pytest.raises(RowError, match=r"row 2: the leg of slide\.B1 does not reach"):
        inverse_dynamics(instance, np.tile(np.eye(3), (2, 1, 1)), far)
    # Where the rod is across its rail the carriage cannot push.
    drives = Machine.of(instance)
    rod = drives.rods[0]
    rail = drives.beside[0]
    across = np.cross(rail, [1.0, 0.3, 0.2])
    T = (
        drives.middle[0]
        + rod * across / np.linalg.norm(across)
        - instance.constraints[0].platform.point
    )
    long = [replace(row, value=gspcli.Number.of(10.0)) for row in instance.constraints[1:]]
    alone = replace(instance, constraints=(instance.constraints[0], *long), home=None)
    with pytest.raises(RowError, match=r"slide\.B1 is at a dead point"):
        inverse_dynamics(alone, np.eye(3), T)


def test_rods_of_one_carriage_must_ask_for_one_speed():
    instance = weighed(driven("delta"), np.random.default_rng(1))
    T = [0, 0, -0.25]
    turning = [1.0, 0, 0, 0, 0, 0]
    with pytest.raises(RowError, match=r"rods 3 and 4 ask for different speeds of slide\.B3"):
        inverse_dynamics(instance, np.eye(3), T, twists=turning, accelerations=0)
    found = inverse_dynamics(instance, np.eye(3), T)
    assert found.torques.shape == found.powers.shape == (1, 3)
    assert found.forces.shape == (1, 6)
    assert natural_modes(instance, np.eye(3), T, stiffness=1e5).frequencies.shape == (1, 3)


def test_modes_of_the_file_have_their_drives_at_zero():
    """In the working modes of home most modes have other angles, which hold other rods."""
    instance = weighed(driven("reachy-mini-head"), np.random.default_rng(1))
    result = gspcli.solve(instance)
    R, T = result.R[result.real].real, result.T[result.real].real
    stated = inverse_dynamics(instance, R, T, drives=0.0)
    assert np.isfinite(stated.torques).all()
    on_home = inverse_dynamics(instance, R, T)
    assert not np.allclose(stated.torques, on_home.torques)
    home = result.home.number - 1
    assert np.allclose(stated.torques[home], on_home.torques[home], rtol=1e-6)


def test_what_is_told_of_torques():
    instance = weighed(driven("mixed"), np.random.default_rng(1))
    found = inverse_dynamics(instance, np.eye(3), [0, 0, 0.6])
    names = Machine.of(instance).names
    assert found.torque_units == ("N m", "N m", "N m", "N m", "N", "N")
    assert list(found.to_frame().columns) == [
        *("t", "F1", "F2", "F3", "F4", "F5", "F6"),
        *(f"torque.{name}" for name in names),
        "power",
    ]
    document = found.to_json()
    assert document["drives"] == list(names)
    assert document["rows"][0]["torques"] == found.torques[0].tolist()
    assert document["worst_torque"]["torque"] == found.worst_torque.force
    # A driven distance has the same number in both.
    assert found.torques[0, 5] == found.forces[0, 5]
    legs = gspcli.example("rubin-m2")
    bare = replace(
        legs, dynamics=gspcli.Dynamics(gspcli.RigidBody(1, [0, 0, 0], [1, 1, 1, 0, 0, 0]))
    )
    told = inverse_dynamics(bare, np.eye(3), [0, 0, 0])
    assert np.array_equal(told.torques, told.forces)
    assert not {"drives", "torque_units", "worst_torque"} & set(told.to_json())


def test_a_crank_in_line_with_its_rod_is_at_a_dead_point():
    """The error of the gain there is the root of the rounding error, 2e-8 and more."""
    instance = weighed(driven("reachy-mini-head"), np.random.default_rng(1))
    drives = Machine.of(instance)
    first, *others = instance.constraints
    # Legs have motors if they have ranges.
    reach = (Number.of(0), Number.of(10))
    legs = [
        replace(row, base=gspcli.Point(m), limits=reach)
        for row, m in zip(others, drives.middle[1:], strict=True)
    ]
    bare = replace(instance.dynamics, legs=(), arms=(), carriages=(), drives=gspcli.Drives())
    alone = replace(instance, constraints=(first, *legs), dynamics=bare, home=None)
    met = 0
    for turn in np.linspace(0, 2 * np.pi, 24, endpoint=False):
        arm = drives.across[0] * np.cos(turn) + drives.beside[0] * np.sin(turn)
        reach = drives.rods[0] / np.linalg.norm(arm)
        T = drives.middle[0] + (1 + reach) * arm - first.platform.point
        with pytest.raises(RowError, match=r"is at a dead point|does not reach") as caught:
            inverse_dynamics(alone, np.eye(3), T)
        met += "dead" in str(caught.value)
    assert met


# Natural frequencies where the answer is known.


START = np.eye(3), np.array([0, 0, 150.0])


def test_frequencies_that_are_known_by_hand():
    """A block in a 3-2-1 fixture of springs: no motion is coupled to another."""
    arm, k, mass, low, high = 2.0, 1e5, 12.0, 3.0, 5.0
    x, y, z = np.eye(3)
    corners = [arm * np.array([np.cos(s), np.sin(s), 0]) for s in np.radians([0, 120, 240])]
    touched = [(p, z) for p in corners] + [(arm * x, y), (-arm * x, y), (0 * x, x)]
    rows = [distance(Point(p), Plane((p - n).tolist(), n.tolist()), 1) for p, n in touched]
    body = gspcli.RigidBody(mass, [0, 0, 0], [low, low, high, 0, 0, 0])
    instance = replace(build(rows, length="m"), dynamics=gspcli.Dynamics(body, gravity=[0, 0, 0]))
    found = natural_modes(instance, np.eye(3), np.zeros(3), stiffness=k)
    turns = [1.5 * arm**2 / low, 1.5 * arm**2 / low, 2 * arm**2 / high]
    expected = k * np.sort([1 / mass, 2 / mass, 3 / mass, *turns])
    assert np.allclose(found.squares[0], expected, rtol=1e-12)
    assert np.allclose(np.abs(found.shapes[0, 0]), [0, 0, 0, Arrangement.of(instance).length, 0, 0])


@pytest.mark.parametrize("name", ["6DPP", "DPP DPL DLP ALH AHL AHH"])
def test_shapes_are_what_a_small_motion_does(name):
    """K x = w^2 M x, with the accelerations that springs give for a small shape."""
    rng = np.random.default_rng(5)
    instance, R, T = random_platform(name, rng, worst=20)
    found = natural_modes(instance, R, T, stiffness=1e7)
    radian = np.where(
        [row.kind.is_distance for row in instance.constraints], 1.0, instance.units.angle.in_radians
    )
    for square, shape in zip(found.squares[0], found.shapes[0], strict=True):
        left = []
        for s in (-1e-5, 1e-5):
            pose = rotation_from_vector(s * shape[:3]) @ R, T + s * shape[3:]
            off = (measure(instance, *pose) - measure(instance, R, T)) * radian
            springs = found.preload[0] - 1e7 * off
            needed = inverse_dynamics(instance, *pose, twists=0, accelerations=-s * square * shape)
            left.append(needed.forces[0] - springs)
        assert np.abs(left[1] - left[0]).max() < 1e-5 * np.abs(1e7 * off).max()


def test_soft_drives_do_not_hold_the_platform_up():
    found = natural_modes(hexapod(), *START, stiffness=10)
    assert found.squares[0, 0] < 0
    assert found.frequencies[0, 0] < 0
    stiff = natural_modes(hexapod(), *START, stiffness=1e6)
    assert (stiff.squares > 0).all()


def test_singular_poses_have_no_modes():
    poses = np.tile(np.eye(3), (2, 1, 1)), [[0, 0, 150.0], [0, 0, 0]]
    found = natural_modes(hexapod(), *poses, stiffness=[1e6] * 6)
    assert found.singular.tolist() == [False, True]
    assert np.isnan(found.frequencies[1]).all()
    assert found.to_json()["rows"][1]["frequencies"] == [None] * 6
    assert list(found.to_frame().columns) == ["row", "f1", "f2", "f3", "f4", "f5", "f6"]
    assert "2 poses" in repr(found)


@pytest.mark.parametrize(
    ("stiffness", "message"),
    [(None, "found no stiffness: state drives"), (-1.0, "expected stiffnesses above 0")],
)
def test_a_stiffness_is_needed(stiffness, message):
    with pytest.raises(ArgumentError, match=message):
        natural_modes(hexapod(), *START, stiffness=stiffness)
