"""How far motors move their points while the platform moves a little: bounds and samples."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gspcli.geometry.drives import Drives
from gspcli.geometry.instance import Instance
from gspcli.geometry.shapes import Shapes
from gspcli.motion.collisions.compared import ComparedShapes
from gspcli.motion.collisions.driven_moves import point_moves
from gspcli.motion.poses.cranks import drive_values
from gspcli.solver import solve
from gspcli.spec.shipped import example
from tests.support.thick_legs import poses_near

#: Machines with cranks, slides, and shared carriages on base and platform.
NAMES = ("reachy-mini-head", "modified-paradex", "three-prs", "hexaglide")


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
    drives = Drives.of(instance)
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
    moved = compared.moves(shift, turn, centre, T0[None], home)
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
    drives = Drives.of(instance)
    q = drive_values(instance, R[None], T[None])[1]
    far = np.full((1, 6), float(drives.arms.max()) * 10)
    assert np.isinf(point_moves(drives, R[None], T[None], q, far)).all()


def test_values_move_no_points() -> None:
    instance, R, T = at_home("three-prs")
    drives = Drives.of(instance)
    q = drive_values(instance, R[None], T[None])[1]
    found = point_moves(drives, R[None], T[None], q, np.full((1, 6), 1e-3))
    assert (found[0][~drives.driven] == 0).all()
    assert (found[0][drives.driven] > 0).all()


def test_the_wrong_knee_is_not_proved() -> None:
    """Of the other number of a crank the length passes its value in the other direction."""
    instance, R, T = at_home("reachy-mini-head")
    drives = Drives.of(instance)
    q = drive_values(instance, R[None], T[None])[1]
    moves = np.full((1, 6), 1e-4 * float(drives.arms.max()))
    assert np.isfinite(point_moves(drives, R[None], T[None], q, moves)).all()
    # A number that fits no rod is proved for none, however near it is.
    bound = point_moves(drives, R[None], T[None], q + 1e-2, moves)
    assert np.isinf(bound).any()
