"""How far motors move their points while the platform moves a little: bounds and samples."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gspcli.geometry.instance import Instance, Shapes
from gspcli.geometry.machine import Machine
from gspcli.motion.collisions.compared import ComparedShapes, point_moves, slips_near
from gspcli.motion.poses.inverse_kinematics import drive_values
from gspcli.solver import solve
from gspcli.spec.reading import example
from tests.support.thick_legs import poses_near

#: Machines with cranks, slides, and shared carriages on base and platform.
NAMES = ("reachy-mini-head", "modified-paradex", "delta", "hexaglide")


def at_home(name: str) -> tuple[Instance, np.ndarray, np.ndarray]:
    result = solve(example(name))
    home = 0 if result.home is None else result.home.number - 1
    return result.instance, result.R[home].real, result.T[home].real


def reached(
    instance: Instance, R: np.ndarray, T: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    q = drive_values(instance, R, T)[1]
    good = np.isfinite(q).all(axis=1)
    return R[good], T[good], q[good]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("move", [1e-2, 1e-5])
def test_points_and_gaps_change_no_more_than_is_proved(name: str, move: float) -> None:
    instance, R0, T0 = at_home(name)
    drives = Machine.of(instance)
    size = float(drives.rods[drives.driven].max())
    instance = replace(instance, shapes=Shapes(size / 50, near_joint=size / 10))
    compared = ComparedShapes(instance)
    R, T, q = reached(instance, *poses_near(R0, T0, 4000, move * size, move, 1))
    if drives.count == 6:
        assert len(R) > 3000
    # Machines with shared drives reach few poses near by: those turn about no axis.
    else:
        draw = np.random.default_rng(2).normal(size=(400, 3))
        draw *= move * size / np.linalg.norm(draw, axis=1).max()
        R, T, q = reached(instance, np.tile(R0, (400, 1, 1)), T0 + draw)
        assert len(R) > 0
    centre = np.zeros(3)
    away = np.linalg.norm(T - T0, axis=1).max()
    shift, turn = np.array([away]), np.array([move])
    home = R0[None], T0[None], drive_values(instance, R0[None], T0[None])[1]
    moved = compared.moves(*home, shift, turn, centre)
    change = np.abs(compared.bounds(R, T, q).high - compared.bounds(*home).high).max(axis=0)
    assert (change <= moved[0] + 1e-12 * size).all()
    assert np.isfinite(moved).all()
    if name in NAMES[:2]:
        # The bounds are no more than some times what is seen.
        assert change.max() > moved.max() / 12
    own = np.linalg.norm(drives.points(q) - drives.points(home[2]), axis=-1).max(axis=0)
    b, a, _ = drives.ends(R0[None], T0[None], home[2])
    arms = np.where(drives.on_platform, np.linalg.norm(b - T0, axis=-1), np.linalg.norm(a, axis=-1))
    found = point_moves(drives, *home, shift + turn * arms)
    assert (own <= found[0] + 1e-12 * size).all()


def test_nothing_is_proved_where_a_rod_may_not_reach() -> None:
    instance, R, T = at_home("reachy-mini-head")
    drives = Machine.of(instance)
    q = drive_values(instance, R[None], T[None])[1]
    far = np.full((1, 6), float(drives.arms.max()) * 10)
    assert np.isinf(point_moves(drives, R[None], T[None], q, far)).all()


def test_values_move_no_points() -> None:
    instance, R, T = at_home("three-prs")
    drives = Machine.of(instance)
    q = drive_values(instance, R[None], T[None])[1]
    found = point_moves(drives, R[None], T[None], q, np.full((1, 6), 1e-3))
    assert (found[0][~drives.driven] == 0).all()
    assert (found[0][drives.driven] > 0).all()


def test_the_wrong_working_mode_is_not_proved() -> None:
    """Of the other number of a crank the length passes its value in the other direction."""
    instance, R, T = at_home("reachy-mini-head")
    drives = Machine.of(instance)
    q = drive_values(instance, R[None], T[None])[1]
    moves = np.full((1, 6), 1e-4 * float(drives.arms.max()))
    assert np.isfinite(point_moves(drives, R[None], T[None], q, moves)).all()
    # A number that fits no rod is proved for none, however near it is.
    bound = point_moves(drives, R[None], T[None], q + 1e-2, moves)
    assert np.isinf(bound).any()


@pytest.mark.parametrize("name", ["reachy-mini-head", "hexaglide"])
def test_points_near_dead_points_move_no_more_than_is_proved(name: str) -> None:
    """The platform moves straight, so all joints move as far; some rods then do not reach."""
    instance, R0, T0 = at_home(name)
    drives = Machine.of(instance)
    working_modes = drives.working_modes(R0, T0)
    size = float(drives.rods.max())
    R, T = poses_near(R0, T0, 400, 0.6 * size, 1.2, 4)
    q = drives.inverse(R, T, working_modes)
    reached_ = np.isfinite(q).all(axis=1)
    R, T, q = R[reached_], T[reached_], q[reached_]
    draw = np.random.default_rng(5)
    far = size * 10 ** draw.uniform(-3, -0.7, len(T))
    found = point_moves(drives, R, T, q, np.tile(far[:, None], 6))
    # Of each rod the worst ways are along it.
    rods = drives.ends(R, T, q)[2] / drives.rods[:, None]
    ways = np.concatenate([rods, -rods, draw.normal(size=(len(T), 100, 3))], axis=1)
    ways /= np.linalg.norm(ways, axis=-1, keepdims=True)
    moved = drives.wanted(R[:, None], T[:, None] + far[:, None, None] * ways, working_modes)
    slips = np.linalg.norm(drives.points(moved) - drives.points(q)[:, None], axis=-1)
    unreached = np.isnan(slips).any(axis=1)
    assert np.isinf(found[unreached]).all()
    assert unreached.sum() > 10
    known = ~unreached
    most = np.nanmax(np.where(np.isnan(slips), 0.0, slips), axis=1)
    assert (most[known] <= found[known] + 1e-9 * size).all()
    # Where a gain is small twice and four times the linear change count.
    assert (found / most)[known & np.isfinite(found)].min() < 1.2


def test_points_move_with_the_turn_of_the_platform() -> None:
    instance, R0, T0 = at_home("reachy-mini-head")
    drives, turn = Machine.of(instance), 1e-3
    R, T = poses_near(R0, T0, 200, 0.0, turn, 6)
    start = R0[None], T0[None], drives.inverse(R0[None], T0[None])
    found = slips_near(drives, *start, np.zeros(1), np.full(1, turn), np.zeros(3))[0]
    moved = np.linalg.norm(drives.points(drives.inverse(R, T)) - drives.points(start[2]), axis=-1)
    assert (moved.max(axis=0) <= found).all()
    assert (moved.max(axis=0) > found / 10).all()
