"""The slacks of limits, against other formulas and differences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.geometry.drives import Drives
from gspcli.geometry.instance import Side
from gspcli.geometry.limits import tilts
from gspcli.geometry.primitives import Cone
from gspcli.geometry.quaternions import quaternion_from_rotation, rotation_from_vector
from gspcli.motion.following.limit_numbers import limit_numbers
from gspcli.motion.following.limit_search import MARGIN, LimitSearch
from gspcli.motion.following.platform_numbers import platform_numbers
from tests.support.independent_machines import Machine, machines

LEGS = ["workspace-study-cones", "rubin-m2", "three-rps"]
DRIVEN = ["reachy 60", "t-top 60", "paradex", "6-PUS", "mixed"]


def machine_of(name: str) -> Machine:
    if name in LEGS:
        instance = gspcli.example(name)
        home = gspcli.solve(instance).home
        return Machine(name, instance, home.R.real, home.T.real, (0, 0))
    machine = machines()[name]()
    up, down = Cone((0, 0, 1), 60), Cone((0, 0, -1), 60)
    rows = tuple(
        replace(
            row,
            base=replace(row.base, cone=up),
            platform=replace(row.platform, cone=down),
        )
        for row in machine.instance.constraints
    )
    return replace(machine, instance=replace(machine.instance, constraints=rows))


def about(machine: Machine, search: LimitSearch, draw, size: float):
    R = rotation_from_vector(size * draw.normal(size=3)) @ machine.R
    return R, machine.T + size * search.length * draw.normal(size=3)


@pytest.mark.parametrize("name", [*LEGS, *DRIVEN])
def test_the_slopes_are_those_of_the_slack(name):
    """Where rods do not reach, too."""
    machine = machine_of(name)
    search = LimitSearch(machine.instance, machine.R, machine.T, np.zeros(3))
    middle = platform_numbers(machine.instance).middle
    draw = np.random.default_rng(3)
    for _ in range(10):
        R, T = about(machine, search, draw, 0.15)
        twist, step = draw.normal(size=6), 1e-6 * search.length
        twist[:3] /= search.length
        ends = []
        for sign in (1, -1):
            turn = rotation_from_vector(sign * step * twist[:3])
            # A twist is about the middle of the platform.
            place = T + R @ middle + sign * step * twist[3:] - turn @ R @ middle
            ends.append(search.slack(turn @ R, place))
        room, slopes = search._kernel.slack(np.concatenate((T, quaternion_from_rotation(R))))
        stated = slopes[room < search._far] @ twist
        assert np.abs((ends[0] - ends[1]) / (2 * step) - stated).max() < 1e-3


@pytest.mark.parametrize("name", DRIVEN)
def test_slacks_of_motors_and_cones_change_sign_at_their_limits(name):
    """By the numbers of the drives, and the tilts of cones that turn with the arms."""
    machine = machine_of(name)
    instance, drives = machine.instance, Drives.of(machine.instance)
    search = LimitSearch(instance, machine.R, machine.T, np.zeros(3))
    knees = drives.knees(machine.R, machine.T)
    draw = np.random.default_rng(4)
    seen = set()
    for _ in range(200):
        R, T = about(machine, search, draw, 0.12)
        q = drives.inverse(R, T, knees)
        room = search._room(R, T)
        for k in np.flatnonzero(drives.driven):
            drive = drives.index[k]
            inside = bool(drives.low[drive] < q[drive] < drives.high[drive])
            assert inside == bool(room[2 * k : 2 * k + 2].min() > 0), k
            seen.add(inside)
        if np.isfinite(q).all():
            radians = np.deg2rad(tilts(instance, R, T, q))
            assert np.allclose(room[12:], search.length * (np.pi / 3 - MARGIN - radians))
    assert seen == {True, False}


def test_signed_distances_keep_their_side():
    instance = gspcli.example("three-rps")
    numbers = platform_numbers(instance)
    side = [row.side for row in instance.constraints]
    limits = limit_numbers(instance, numbers)
    for k, row in enumerate(instance.constraints):
        low, high = (limit.value / numbers.reach for limit in row.limits)
        wanted = (-high, -low) if side[k] is Side.NEGATIVE else (low, high)
        assert np.allclose((limits.low[k], limits.high[k]), wanted)
