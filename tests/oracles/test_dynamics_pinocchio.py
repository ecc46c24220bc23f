"""Forces, masses and frequencies against Pinocchio, which uses bodies and no formula of ours."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.catalogue.types import all_types
from gspcli.dynamics import inverse_dynamics
from tests.support.driven_machines import MADE_UP, SHIPPED, driven, rebased, some_pose, weighed
from tests.support.driven_machines import random_motion as driven_motion
from tests.support.masses import (
    MACHINES,
    in_metres,
    machine,
    random_motion,
    random_platform,
    with_masses,
)
from tests.support.pinocchio_trees import PinocchioTree
from tests.support.reference_modes import frequencies_off, mass_off
from tests.support.simulated_trees import signs

pytest.importorskip("pinocchio")

RANDOM = np.random.default_rng(2004).choice(len(all_types()), 200, replace=False) + 1


def disagreement(instance, R, T, rng):
    """Return how far forces are from Pinocchio's for a random motion."""
    t, a = random_motion(instance, rng)
    found = inverse_dynamics(instance, R, T, twists=t, accelerations=a).forces[0]
    tree = PinocchioTree(instance, R, T)
    expected = tree.forces(in_metres(instance, t), in_metres(instance, a)) * signs(instance, R, T)
    return float(np.abs(found - expected).max() / np.abs(expected).max())


@pytest.mark.parametrize("name", MACHINES)
def test_forces_of_shipped_machines(name):
    rng, (instance, R, T) = np.random.default_rng(9), machine(name)
    for universal in (False, True):
        weighed = with_masses(instance, rng, universal=universal)
        assert disagreement(weighed, R, T, rng) < 1e-9


@pytest.mark.parametrize("name", [*SHIPPED, *MADE_UP])
def test_torques_of_cranks_and_forces_of_slides(name):
    for seed in range(3):
        rng = np.random.default_rng(seed)
        instance = weighed(driven(name), rng)
        R, T, q = some_pose(instance, rng)
        t, a = driven_motion(instance, rng)
        found = inverse_dynamics(instance, R, T, twists=t, accelerations=a).torques[0]
        tree = PinocchioTree(rebased(instance, q), R, T)
        expected = tree.forces(in_metres(instance, t), in_metres(instance, a))
        assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("name", [*SHIPPED, *MADE_UP])
def test_mass_matrices_of_machines_with_cranks_and_slides(name):
    assert mass_off(PinocchioTree, name, 4) < 1e-9


@pytest.mark.parametrize("name", [*SHIPPED, *MADE_UP])
def test_natural_frequencies_of_machines_with_cranks_and_slides(name):
    squares, torques = frequencies_off(PinocchioTree, name, 7, 5.0)
    assert squares < 1e-9
    assert torques < 1e-9


@pytest.mark.parametrize(
    "name", ["DPL DPP DPP DPP DPH DHP", "DLL DPP DPP DPH DHP DLP", "DPP DPL DLP ALH AHL AHH"]
)
def test_forces_of_every_kind(name):
    rng = np.random.default_rng(10)
    for _ in range(3):
        assert disagreement(*random_platform(name, rng), rng) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("number", RANDOM)
def test_forces_of_random_types(number):
    rng = np.random.default_rng(number)
    assert disagreement(*random_platform(str(number), rng), rng) < 1e-9
