"""Forces, accelerations and natural frequencies against MuJoCo, and wrong formulas rejected."""

from __future__ import annotations

import importlib.util
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from gspcli.catalogue.types import all_types
from gspcli.dynamics import forces as forces_module
from gspcli.dynamics import inverse_dynamics, natural_modes
from gspcli.dynamics import moving_bodies as bodies_module
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import METRES
from tests.support.masses import (
    MACHINES,
    in_metres,
    machine,
    random_motion,
    random_platform,
    with_masses,
)
from tests.support.reference_modes import reference_squares, soft_springs
from tests.support.simulated_trees import ClosedTree, signs

pytest.importorskip("mujoco")

#: Every kind is in one of them at least.
KINDS = [
    "6DPP",
    "DPL DPP DPP DPP DPH DHP",
    "DLP DPP DPL DPH ALL ALL",
    "DLL DPP DPP DPH DHP DLP",
    "DPP DPL DLP ALH AHL AHH",
    "3DLL 3ALL",
]
RANDOM = np.random.default_rng(2003).choice(len(all_types()), 200, replace=False) + 1


def off(found, expected):
    """Return the largest difference as a share of the largest number."""
    return float(np.abs(found - expected).max() / np.abs(expected).max())


def disagreement(instance, R, T, rng, computed=inverse_dynamics):
    """Return how far forces are from MuJoCo's for a random motion."""
    t, a = random_motion(instance, rng)
    found = computed(instance, R, T, twists=t, accelerations=a).forces[0]
    tree = ClosedTree(instance, R, T)
    expected = tree.forces(in_metres(instance, t), in_metres(instance, a)) * signs(instance, R, T)
    return off(found, expected)


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("universal", [False, True])
def test_forces_of_every_kind_with_drives_that_weigh_something(name, universal):
    rng = np.random.default_rng(5)
    for _ in range(3):
        instance, R, T = random_platform(name, rng, universal=universal)
        assert disagreement(instance, R, T, rng) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("number", RANDOM)
def test_forces_of_random_types(number):
    rng = np.random.default_rng(number)
    instance, R, T = random_platform(str(number), rng)
    assert disagreement(instance, R, T, rng) < 1e-9


@pytest.mark.parametrize("name", MACHINES)
def test_forces_of_shipped_machines(name):
    rng, (instance, R, T) = np.random.default_rng(8), machine(name)
    assert disagreement(with_masses(instance, rng), R, T, rng) < 1e-9


@pytest.mark.parametrize("name", KINDS)
def test_accelerations_under_forces(name):
    rng = np.random.default_rng(6)
    instance, R, T = random_platform(name, rng)
    t, _ = random_motion(instance, rng)
    F = 10 * rng.normal(size=6)
    found = ClosedTree(instance, R, T).acceleration(t, F * signs(instance, R, T))
    needed = inverse_dynamics(instance, R, T, twists=t, accelerations=found)
    assert off(needed.forces[0], F) < 1e-9


@pytest.mark.parametrize("name", KINDS)
@pytest.mark.parametrize("hertz", [50.0, 2.0])
def test_natural_frequencies(name, hertz):
    """The drives are springs with preload."""
    rng = np.random.default_rng(3)
    instance, R, T = random_platform(name, rng, worst=20)
    stiffness = soft_springs(instance, R, T, 6, hertz)
    found = natural_modes(instance, R, T, stiffness=stiffness)
    size, metre = Arrangement.of(instance).length, METRES[instance.units.length]
    expected, _ = reference_squares(partial(ClosedTree, instance), R, T, size, metre, stiffness)
    assert np.abs(found.squares[0] / expected - 1).max() < 1e-9


#: Terms that a wrong formula would lack or have wrong: module, what stands there, what instead.
MUTATIONS = [
    (bodies_module, "+ cross(omega, apply(self.inertia, omega))", ""),
    (bodies_module, "- 2 * speed * turning", "- speed * turning"),
    (bodies_module, "- dot(turning, turning)[..., None] * e", ""),
    (bodies_module, "+ spin * cross(turning, self.e)", ""),
    (bodies_module, "(1 + c * c) / square**2", "1 / square**2"),
    (bodies_module, "+ place * rate - fall", "+ rate - fall"),
    (bodies_module, "on_direction - below * on_rod", "on_direction"),
    (bodies_module, "legs.across * rate", "0 * rate"),
    (bodies_module, "+ cross(omega, turned)", ""),
    (forces_module, "torques += model.rotors *", "torques += 0 *"),
]


def _mutated(module, old, new):
    """Return a module with one formula changed."""
    source = Path(module.__file__).read_text(encoding="utf-8")
    assert source.count(old) == 1
    name = f"{module.__name__}_mutated"
    spec = importlib.util.spec_from_loader(name, loader=None)
    made = importlib.util.module_from_spec(spec)
    sys.modules[name] = made
    exec(compile(source.replace(old, new), name, "exec"), made.__dict__)
    return made


@pytest.mark.parametrize(("module", "old", "new"), MUTATIONS, ids=[m[1] for m in MUTATIONS])
def test_wrong_formulas_are_seen(module, old, new, monkeypatch):
    name = "MovingBodies" if module is bodies_module else "_forces"
    monkeypatch.setattr(forces_module, name, getattr(_mutated(module, old, new), name))
    rng = np.random.default_rng(4)
    instance, R, T = random_platform("6DPP", rng)
    assert disagreement(instance, R, T, rng) > 1e-5
