"""Gaps of machines with motors that move points: paths and workspaces, against samples."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from gspcli.geometry.instance import Instance, Shapes
from gspcli.geometry.machine import Machine
from gspcli.motion.collisions.compared import ComparedShapes
from gspcli.motion.paths.planned_paths import DriveGuide, PathEnd
from gspcli.motion.paths.planner import path
from gspcli.motion.paths.ways import PoseWays
from gspcli.motion.workspace.workspaces import workspace
from gspcli.solver import solve
from gspcli.spec.reading import example

#: Of the machine: the length of its rods.
SIZE = Machine.of(example("reachy-mini-head")).rods.max()


def thick_machine() -> tuple[Instance, np.ndarray, np.ndarray, float]:
    """Return cranks whose rods are thick, their home, and the gap there."""
    result = solve(example("reachy-mini-head"))
    assert result.home is not None
    R, T = result.R[result.home.number - 1].real, result.T[result.home.number - 1].real
    instance = replace(result.instance, shapes=Shapes(SIZE / 25))
    least = ComparedShapes(instance).bounds(R[None], T[None]).low.min()
    return instance, R, T, float(least)


@pytest.mark.parametrize("share", [0.5, 0.9])
def test_samples_of_a_path_keep_the_gap(share: float) -> None:
    instance, R, T, least = thick_machine()
    goal = R, T + np.array([0.1, 0.05, 0.02]) * SIZE
    found = path(instance, "home", goal, along="poses", gap=share * least, time=5)
    assert (found.verdict, found.along) == ("proved", "poses")
    assert len(found.T) >= 2
    assert found.gaps is not None
    motors = Machine.of(instance).at_home()
    ways = PoseWays(instance, limits=False)
    numbers = ways.parameters(found.R, found.T)
    for a, b in pairwise(numbers):
        part = np.linspace(0, 1, 200)[:, None]
        R_there, T_there = ways.poses(a + (ways.nearest(a, b) - a) * part)
        q = motors.along(R_there, T_there)
        low = ComparedShapes(instance).bounds(R_there, T_there, q).low
        assert (low >= share * least - 1e-9).all()


def test_samples_of_a_path_of_drives_keep_the_gap() -> None:
    instance, R, T, least = thick_machine()
    goal = T + np.array([0.1, 0.05, 0.02]) * SIZE
    found = path(instance, "home", (R, goal), gap=least / 2, time=5)
    assert (found.verdict, found.along) == ("proved", "drives")
    ends = [PathEnd("", found.values[k], found.R[k], found.T[k]) for k in (0, -1)]
    guide = DriveGuide(Machine.of(instance).at_home(), *ends)
    samples = guide.trace(guide.corners, np.array([300]))
    assert samples is not None
    low = (
        ComparedShapes(instance)
        .bounds(samples.rows.R, samples.rows.T, samples.rows.drive_numbers())
        .low
    )
    least_proved = min(part.gap for part in found.parts if part.gap is not None)
    assert least / 2 <= least_proved <= low.min() + 1e-9


def test_a_gap_that_home_does_not_keep_is_impossible() -> None:
    instance, R, T, least = thick_machine()
    found = path(instance, "home", (R, T + 0.01 * SIZE), gap=2 * least, time=1)
    assert found.verdict == "impossible"
    assert "the gap between legs" in found.reason


def test_samples_of_a_workspace_keep_the_gap_inside_and_not_outside() -> None:
    instance, R, T, least = thick_machine()
    x, y = T[:2].tolist()
    within = {"x": (x - 0.5 * SIZE, x + 0.5 * SIZE), "y": (y - 0.5 * SIZE, y + 0.5 * SIZE)}
    asked = 0.8 * least
    given = {"free": "xy", "within": within, "tolerance": 0.05, "connected": False}
    found = workspace(instance, R, T, gap=asked, **given)
    without = workspace(instance, R, T, **given)
    assert 0 < found.volume[0] <= found.volume[1] < without.volume[1]
    draw = np.random.default_rng(3).uniform(size=(3000, 2))
    low, high = np.array(list(within.values())).T
    places = np.tile(T, (3000, 1))
    places[:, :2] = low + (high - low) * draw
    turned = np.tile(R, (3000, 1, 1))
    judged, plain = (one.judged_poses(turned, places) for one in (found, without))
    inside = judged == judged.max()
    q = Machine.of(instance).at_home().inverse(turned, places)
    gaps = ComparedShapes(instance).bounds(turned, places, q)
    assert inside.sum() > 100
    assert (gaps.low.min(axis=1)[inside] >= asked - 1e-9).all()
    # Nothing that is known to keep all limits and the gap is left out.
    out = (judged == judged.min()) & (plain == plain.max())
    assert (gaps.low.min(axis=1)[out] < asked).all()
