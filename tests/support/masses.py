"""Platforms of any type with masses made up, at poses where they are well conditioned."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from gspcli.catalogue.kinds import DPP
from gspcli.catalogue.names import parse_type
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import METRES
from gspcli.geometry.masses import Drives, Dynamics, Leg, LegBody, RigidBody
from gspcli.geometry.measurement import condition_numbers
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.geometry.random_instances import random_instance
from gspcli.resources import data_directory, instance_files
from gspcli.solver import solve
from gspcli.spec import load

_FILES = {p.stem: p.read_text("utf-8") for p in (data_directory() / "platforms").glob("*.yaml")}
#: Shipped machines with cranks or slides, and those that are driven by their values.
DRIVEN = sorted(name for name, text in _FILES.items() if "crank: {" in text or "slide: {" in text)
MACHINES = sorted({*_FILES} - {*DRIVEN})


@cache
def machine(name):
    """Return a shipped machine and its best conditioned real pose (R, T)."""
    instance = load(instance_files()[name])
    poses = solve(instance).real_solutions
    best = min(poses, key=lambda pose: pose.condition)
    return instance, best.R.real, best.T.real


def with_masses(instance, rng, *, universal=True, rotors=True, legs=True, stiffness=None):
    """Return an instance with random masses, of bodies of about its size."""
    size = Arrangement.of(instance).length
    mass = float(rng.uniform(2, 20))
    Q = rotation_from_vector(rng.normal(size=3))
    inertia = Q @ np.diag(rng.uniform(0.3, 0.45, 3)) @ Q.T * mass * size**2
    body = RigidBody(
        mass,
        (0.3 * size * rng.normal(size=3)).tolist(),
        [*np.diag(inertia).tolist(), inertia[0, 1], inertia[0, 2], inertia[1, 2]],
    )
    count = sum(row.kind is DPP for row in instance.constraints)
    made = [_leg(rng, size, mass, universal=universal) for _ in range(count * legs)]
    moments = np.array([1.0 if row.kind.is_distance else size**2 for row in instance.constraints])
    drives = Drives((rng.uniform(0.1, 1, 6) * moments).tolist() if rotors else 0, stiffness)
    gravity = rng.normal(size=3) - np.array([0, 0, 9])
    # Some shipped machines have no unit of length.
    units = instance.units
    if units.length not in METRES:
        units = replace(units, length="m")
    stated = Dynamics(body, made, drives, gravity.tolist())
    return replace(instance, units=units, dynamics=stated)


def _leg(rng, size, mass, *, universal):
    bodies = []
    for _ in range(2):
        weight = float(rng.uniform(0.02, 0.1)) * mass
        across = weight * size**2 * float(rng.uniform(0.02, 0.1))
        bodies.append(LegBody(weight, float(rng.uniform(0.1, 0.5)) * size, across, across / 2))
    return Leg(*bodies, rng.normal(size=3).tolist() if universal else None)


def random_platform(name, rng, worst=100.0, **masses):
    """Return a random platform of a type in metres with masses, and a pose (R, T)."""
    while True:
        instance, (R, T) = random_instance(parse_type(name), rng)
        if condition_numbers(Arrangement.of(instance), R, T) < worst:
            return with_masses(instance, rng, **masses), R, T


def random_motion(instance, rng):
    """Return a random twist and acceleration, each shape (6,), in length units."""
    sizes = np.repeat([1.0, Arrangement.of(instance).length], 3)
    return rng.normal(size=6) * sizes, 5 * rng.normal(size=6) * sizes


def in_metres(instance, twist):
    """Return a twist in metres."""
    return twist * np.repeat([1.0, METRES[instance.units.length]], 3)
