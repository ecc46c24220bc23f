"""Speeds, accelerations and travels of drives, compared with differences of many samples."""

from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.machine import Machine
from gspcli.motion.paths.between import drive_travels
from gspcli.motion.paths.planned_paths import largest_rates
from gspcli.motion.paths.ways import PoseWays
from gspcli.motion.poses.inverse_kinematics import values_at

PIVOT = np.array([0.1, 0.2, -0.05])
NAMES = [
    *("workspace-study", "six-planes", "figure-2", "fixture-3-2-1", "surfaces-scc"),
    *("example-6.8", "hexaglide", "t-top-head", "reachy-mini-head"),
]


def ways_and_home(name, sequence):
    instance = gspcli.example(name)
    solved = gspcli.solve(instance)
    home = solved.home or solved.solutions[int(np.flatnonzero(solved.real)[0])]
    R, T = home.R.real, home.T.real
    signs = Machine.of(instance).at_home(R, T).signs
    return PoseWays(instance, pivot=PIVOT, sequence=sequence, working_modes=signs), R, T


@pytest.mark.parametrize("sequence", ["ZYX", "xyz", "YXZ"])
@pytest.mark.parametrize("name", NAMES)
def test_rates_are_those_of_many_samples(name, sequence):
    ways, R, T = ways_and_home(name, sequence)
    machine = ways.machine
    draw = np.random.default_rng(3)
    velocity = draw.normal(size=6) * 0.003 * ways.sizes
    place = ways.parameters(R, T)
    speeds, bends = largest_rates(ways, place, velocity)
    t = np.linspace(0, 1, 1001)[:, None]
    turned, moved = ways.poses(place + velocity * t)
    if machine.moves:
        numbers = machine.along(turned, moved) / machine.units
    else:
        numbers = values_at(ways.instance, turned, moved)
    step = t[1, 0]
    seen = np.abs(np.diff(numbers, axis=0)).max(axis=0) / step
    seen_bends = np.abs(np.diff(numbers, 2, axis=0)).max(axis=0) / step**2
    assert (seen <= speeds[:-2]).all()
    assert speeds[:-2] == pytest.approx(seen, rel=1e-2)
    assert bends[:-2] == pytest.approx(seen_bends, rel=1e-2, abs=1e-7 * np.abs(numbers).max())
    spin = turned[:-1].swapaxes(1, 2) @ turned[1:]
    angle = np.arccos(np.minimum((np.trace(spin, axis1=1, axis2=2) - 1) / 2, 1))
    assert angle.max() / step == pytest.approx(speeds[-1], rel=0.01)
    assert np.linalg.norm(velocity[:3]) == pytest.approx(speeds[-2], rel=0.01)


@pytest.mark.parametrize("sequence", ["ZYX", "xyz", "YXZ"])
@pytest.mark.parametrize("name", NAMES)
def test_drives_move_at_most_as_far_as_is_proved_and_nearly_as_far(name, sequence):
    ways, R, T = ways_and_home(name, sequence)
    machine, draw = ways.machine, np.random.default_rng(3)
    place = ways.parameters(R, T)
    ends = place + draw.normal(size=6) * 0.003 * ways.sizes * [[1.0], [0.01]]
    found = drive_travels(ways, np.stack((place, place)), ends)
    for bound, end in zip(found, ends, strict=True):
        turned, moved = ways.poses(place + (end - place) * np.linspace(0, 1, 400)[:, None])
        if machine.moves:
            numbers, angles = machine.along(turned, moved), []
        else:
            given = Arrangement.of(ways.instance)
            numbers, angles = values_at(ways.instance, turned, moved), given.angles
            numbers[:, angles] *= given.in_radians
        seen = np.abs(np.diff(numbers, axis=0)).sum(axis=0)
        assert (seen <= bound + 1e-12).all()
        # Of an angle the bound is that of the turn.
        others = np.delete(np.arange(len(bound)), angles)
        assert (bound[others] <= 1.02 * seen[others] + 1e-12).all()
