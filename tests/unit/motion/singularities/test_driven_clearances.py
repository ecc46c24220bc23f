"""Clearances of machines whose motors move points: what is proved, and each bound of the proof.

Bounds are compared with the equations of the machine with its motors elsewhere.
"""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.geometry.drives import Drives
from gspcli.motion.following.branch_follower import MovingPlatform
from gspcli.motion.singularities.clearances import drive_clearances, each_drive_clearance
from gspcli.motion.singularities.neighbourhoods import Box, DrivenNeighbourhood, Norm
from tests.support.driven_clearances import examine
from tests.support.independent_machines import machines

MACHINES = ("reachy 60", "paradex", "6-PUS", "mixed")


@pytest.fixture(params=MACHINES, scope="module")
def near(request) -> tuple[DrivenNeighbourhood, Drives, np.ndarray]:
    machine = machines()[request.param]()
    drives = Drives.of(machine.instance)
    q = drives.inverse(machine.R, machine.T)
    return DrivenNeighbourhood(drives, machine.R, machine.T, q), drives, q


def moved_hessians(near, drives, q, step) -> np.ndarray:
    """Return the matrices of the quadrics with all motors moved by a step, (6, 8, 8)."""
    there = drives.instance_at(q + step)
    platform = MovingPlatform(there, near.platform.local_frames)
    assert platform.scale == near.platform.scale
    return platform.equations.hessians[:, 0]


def steps(near, drives, size):
    """Yield moves of the motors, and how far they are in units of the equations."""
    for sign in (1, -1):
        step = sign * size * np.where(np.array(drives.sorts) == "slide", near.platform.scale, 1.0)
        yield step, near.widths(np.abs(step)[drives.index])


@pytest.mark.parametrize("size", [0.3, 0.03])
def test_bounds_hold_when_motors_move(near, size: float) -> None:
    near, drives, q = near
    z, driven = near.points[0], near.driven
    before = near.platform.equations.hessians[:, 0]
    for step, widths in steps(near, drives, size):
        change = moved_hessians(near, drives, q, step) - before
        first, whole = near._changes(widths[None])
        residual = np.abs(np.einsum("kij,i,j->k", change, z, z)) / 2
        assert (residual <= (whole * near.factors)[0] + 1e-12)[driven].all()
        # To first order it is the printed number; so the bounds are no larger than necessary.
        if size < 0.1:
            assert (residual >= (first * near.factors)[0] * 0.8 - 1e-3 * size)[driven].all()
        left, scales, _ = np.linalg.svd(near.inverse, full_matrices=False)
        for exponent in (0.0, 0.7):
            norm = Norm(left, (scales[:, :1] / scales) ** exponent, near.inverse)
            slopes = near._gradients(norm, whole, widths[None])
            exact = norm.slopes(np.einsum("kij,j->ki", change, z)[None])
            assert (exact <= slopes * whole + 1e-12)[0, driven].all()
        spread = near._spreads(whole, widths[None])[-1, 0, 1:]
        norms = np.abs(np.linalg.eigvalsh(change)).max(axis=1)
        assert (norms <= spread)[driven].all()


def test_knees_are_kept_where_that_is_said(near) -> None:
    """At the largest proved box some gain is nearly zero."""
    near, _, _ = near
    driven = near.driven
    rng = np.random.default_rng(2)
    closest = 1.0
    for radius in (0.0, 0.01, 0.05, 0.2, 0.4):
        number = np.array([radius])
        box = Box(np.array([0.5]), number, number, number, np.zeros((1, 6, 8)), number)

        def kept(size, box=box):
            return near.keeps_knees(size * np.ones((1, 6)), box)[0]

        low, high = 0.0, 4.0
        for _ in range(40):
            size = (low + high) / 2
            low, high = (size, high) if kept(size) else (low, size)
        if low == 0.0:
            continue
        for _ in range(150):
            part = rng.choice([-1.0, 1.0]) * rng.choice([1.0, rng.uniform()])
            cranks = near._cranks[:, None, None]
            turned = np.cos(low * part) * near.first + np.sin(low * part) * near.second
            slid = near.first + low * part * near.second
            gains = np.where(cranks, turned, slid)
            way = rng.normal(size=8)
            if rng.integers(2):
                way = np.einsum("kij,j->ki", gains, near.points[0])[rng.integers(6)]
            size = np.linalg.norm(way)
            z = near.points[0] + (radius * rng.choice([-1, 1]) * way / size if size else 0)
            now = np.einsum("kij,i,j->k", gains, z, z)[driven] / 2 / near._rates[0, driven]
            assert (now > 0).all()
            closest = min(closest, now.min())
    assert closest < 0.5


def test_gains_change_to_second_order_with_the_pose(near) -> None:
    """Where the pose moves along one line, what the gains differ from their linear part by."""
    near, _, _ = near
    z = near.points[0]
    for k in np.flatnonzero(near.driven):
        sizes, ways = np.linalg.eigh(near.first[k])
        way, far = ways[:, np.abs(sizes).argmax()], 0.1
        shifts = np.zeros((1, 6, 8))
        shifts[0, k] = far * way
        number = np.array([0.5])
        box = Box(number, number, number, np.array([far]), shifts, np.zeros(1))
        found = near.gains(np.zeros((1, 6)), box)
        for u in (-1, 1):
            x = z + u * far * way
            off = x @ near.first[k] @ x / 2 - found.mid[0, k, 0] - u * found.lin[0, k, 0, k]
            assert abs(off) <= found.rad[0, k] * (1 + 1e-12)
            assert abs(off) >= 0.99 * found.rad[0, k]


@pytest.mark.parametrize("name", MACHINES)
def test_no_random_change_contradicts(name: str) -> None:
    row = examine(name, 400)
    assert row.wrong == 0
    assert 0 < row.knees <= row.lower < row.fold_found
    assert row.knees < row.dead_point_found


def test_what_is_not_reached_has_no_clearance() -> None:
    machine = machines()["reachy 60"]()
    R, T = np.stack([machine.R] * 2), np.stack([machine.T, machine.T + 1.0])
    lower, knees = drive_clearances(machine.instance, R, T)
    assert lower[0] > 0
    assert knees[0] > 0
    assert (lower[1], knees[1]) == (0, 0)
    far = each_drive_clearance(machine.instance, R, T)[1]
    assert (far.lower, far.upper, far.ratio) == (0.0, np.inf, np.inf)
