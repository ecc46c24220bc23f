"""Machines with cranks and slides against MuJoCo: closed models, torques, motions, frequencies."""

from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.dynamics import inverse_dynamics
from gspcli.export.mjcf import mjcf
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.machine import Machine
from gspcli.geometry.quaternions import rotation_from_vector
from tests.support.driven_machines import (
    MADE_UP,
    SHIPPED,
    driven,
    random_motion,
    rebased,
    some_pose,
    weighed,
)
from tests.support.masses import in_metres
from tests.support.reference_modes import frequencies_off, mass_off
from tests.support.simulated_trees import ClosedTree

mujoco = pytest.importorskip("mujoco")

#: Of sizes and radians: what the pose of a closed model may be off from that of `gsp`.
CLOSED = 1e-9
#: A motion along which the condition grows by more is made shorter.
MOST_GROWTH = 3
#: Steps of the motion, and of the rest after it.
_MOVING, _RESTING = 1500, 1500


def _goal(instance, R, T, seed):
    """Return how far each drive is to go: a line along which no pose is nearly singular."""
    drives, size = Machine.of(instance), Arrangement.of(instance).length
    goal = np.random.default_rng(seed).uniform(-0.05, 0.05, drives.count)
    goal *= np.where([sort == "crank" for sort in drives.sorts], 1.0, size)
    while _followed(drives, R, T, goal) is None:
        goal /= 2
    return goal


def _driven_to(instance, R, T, goal):
    """Return where MuJoCo's drives and its platform come to rest."""
    model = mujoco.MjModel.from_xml_string(mjcf(instance, R, T, gravity=0.0))
    data = mujoco.MjData(model)
    joints = model.actuator_trnid[:, 0]
    names = [model.actuator(k).name.replace("drive", "hold") for k in range(model.nu)]
    holds = [model.equality(name).id for name in names]
    at_start = np.array([data.qpos[model.jnt_qposadr[joint]] for joint in joints])
    for step in range(_MOVING + _RESTING):
        part = min(1.0, (step + 1) / _MOVING)
        model.eq_data[holds, 0] = goal * (1 - np.cos(np.pi * part)) / 2
        mujoco.mj_step(model, data)
    reached = np.array([data.qpos[model.jnt_qposadr[joint]] for joint in joints]) - at_start
    assert np.abs(reached - goal).max() < 1e-4 * np.abs(goal).max()
    body = data.body("platform")
    return reached, body.xmat.reshape(3, 3).copy(), body.xpos.copy()


def _ends_there(instance, R, T, seed):
    """Compare where a driven model ends with the proved pose for the same numbers of its drives."""
    drives, size = Machine.of(instance), Arrangement.of(instance).length
    reached, turned, moved = _driven_to(instance, R, T, _goal(instance, R, T, seed))
    expected = _followed(drives, R, T, reached)
    assert expected is not None
    assert np.abs(moved - expected[1]).max() < CLOSED * size
    assert np.abs(turned - expected[0]).max() < CLOSED
    # It has moved.
    assert np.abs(moved - T).max() + size * np.abs(turned - R).max() > 1e-3 * size


def _followed(drives, R, T, reached):
    """Return the pose where the drives have moved by this much, by Newton's method in small steps.

    None if it comes near to a singular pose.
    """
    values = np.array([row.value.value for row in drives.instance.constraints])
    own = np.where(drives.driven, 0.0, reached[drives.index])
    most = MOST_GROWTH * np.linalg.cond(drives.jacobian(R, T, 0 * reached))
    for part in np.linspace(0, 1, 21)[1:]:
        q = part * reached
        if np.linalg.cond(drives.jacobian(R, T, q)) > most:
            return None
        for _ in range(20):
            _, _, r = drives.ends(R, T, q)
            off = np.linalg.norm(r, axis=-1) - (values + part * own)
            twist = np.linalg.solve(drives.jacobian(R, T, q), -off)
            R, T = rotation_from_vector(twist[:3]) @ R, T + twist[3:]
            if np.abs(twist).max() < 1e-14:
                break
    return R, T


@pytest.mark.parametrize("name", SHIPPED)
def test_a_closed_model_driven_by_its_hinges_ends_where_gsp_says(name):
    instance = driven(name)
    pose = gspcli.solve(instance).home
    _ends_there(instance, pose.R.real, pose.T.real, 1)


@pytest.mark.slow
@pytest.mark.parametrize("name", [*SHIPPED, *MADE_UP])
def test_closed_models_in_all_modes_end_where_gsp_says(name):
    instance = driven(name)
    poses = gspcli.solve(instance).real_solutions
    assert poses
    for number, pose in enumerate(poses):
        _ends_there(instance, pose.R.real, pose.T.real, number)


def off(found, expected):
    """Return the largest difference as a share of the largest number."""
    return float(np.abs(found - expected).max() / np.abs(expected).max())


def _weighed(name, seed, **limits):
    """Return a machine with masses, a random pose of it, and the numbers of its drives there."""
    rng = np.random.default_rng(seed)
    instance = weighed(driven(name), rng)
    return instance, *some_pose(instance, rng, **limits), rng


@pytest.mark.parametrize("name", [*SHIPPED, *MADE_UP])
def test_torques_at_rest_and_moving(name):
    """With arms, carriages, rods, rotors and gravity, at poses where all drives have moved."""
    for seed in range(3):
        instance, R, T, q, rng = _weighed(name, seed)
        tree = ClosedTree(rebased(instance, q), R, T)
        twist, change = random_motion(instance, rng)
        found = inverse_dynamics(instance, R, T, twists=twist, accelerations=change)
        expected = tree.forces(in_metres(instance, twist), in_metres(instance, change))
        assert off(found.torques[0], expected) < 1e-9
        at_rest = inverse_dynamics(instance, R, T)
        assert off(at_rest.torques[0], tree.forces(np.zeros(6), np.zeros(6))) < 1e-9
        # The power of the drives is that of the wrench which they hold.
        assert found.powers.shape == found.torques.shape


@pytest.mark.parametrize("name", [*SHIPPED, *MADE_UP])
def test_mass_matrices(name):
    assert mass_off(ClosedTree, name, 4) < 1e-9


@pytest.mark.parametrize("name", [*SHIPPED, *MADE_UP])
def test_accelerations_under_torques(name):
    instance, R, T, q, rng = _weighed(name, 5)
    twist, _ = random_motion(instance, rng)
    torques = 10 * rng.normal(size=len(q))
    tree = ClosedTree(rebased(instance, q), R, T)
    found = tree.acceleration(in_metres(instance, twist), torques)
    found = found / in_metres(instance, np.ones(6))
    needed = inverse_dynamics(instance, R, T, twists=twist, accelerations=found)
    assert off(needed.torques[0], torques) < 1e-9


@pytest.mark.parametrize("name", [*SHIPPED, *MADE_UP])
def test_natural_frequencies_with_preload(name):
    """The drives are springs, so soft that the weights count."""
    squares, torques = frequencies_off(ClosedTree, name, 6, 5.0)
    assert squares < 1e-9
    assert torques < 1e-9
