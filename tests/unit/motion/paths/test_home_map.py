"""The small map of poses from which proved ways lead home."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.geometry.machine import Machine
from gspcli.motion.paths.planner import home_map
from gspcli.motion.paths.ways import PoseWays, ValueWays
from gspcli.pictures.live_numbers import live_home
from gspcli.solver import SolveResult, solve
from gspcli.spec.reading import example


def solved(name: str) -> tuple[SolveResult, int]:
    result = solve(example(name))
    return result, 0 if result.home is None else result.home.number - 1


def test_every_edge_of_a_map_of_values_is_proved_and_leads_home() -> None:
    result, home = solved("workspace-study")
    found = home_map(result, home)
    assert found is not None
    n = len(found.T)
    assert (np.abs(found.T[0] - result.T[home].real) < 1e-9).all()
    ways = ValueWays(result.instance, np.ones(6))
    values, points = ways.values(found.R, found.T), ways.points(found.R, found.T)
    assert ways.kept(values).all()
    pairs = np.stack((values[1:], values[found.after[1:]]), axis=1)
    arrived = ways.follow(pairs, np.arange(n - 1), points[1:])
    assert arrived.there.all()
    assert ways.same(arrived.points[:, -1], points[found.after[1:]]).all()
    here = np.arange(n)
    for _ in range(n):
        here = found.after[here]
    assert not here.any()
    # Seven other modes have the sign of home.
    modes = ways.points(result.R[result.real].real, result.T[result.real].real)
    assert sum(bool(ways.same(points, one).any()) for one in modes) == 8


def test_every_edge_of_a_map_of_poses_is_proved() -> None:
    result, home = solved("nano-hexapod")
    found = home_map(result, home)
    assert found is not None
    ways = PoseWays(result.instance, limits=False)
    numbers = ways.parameters(found.R, found.T)
    for k, after in enumerate(found.after.tolist()):
        if k:
            assert ways.prove(numbers[k], ways.nearest(numbers[k], numbers[after])).sign


def test_of_a_mode_that_fills_its_ranges_there_is_no_map() -> None:
    assert home_map(*solved("rubin-camera")) is None


def test_poses_of_a_map_keep_the_cones() -> None:
    result, home = solved("workspace-study-cones")
    found = home_map(result, home)
    assert found is not None
    assert Machine.of(result.instance).keeps(found.R, found.T).all()


@pytest.mark.parametrize("name", ["three-prs", "modified-paradex", "surfaces-ppp"])
def test_pages_of_all_machines_have_what_they_need(name: str) -> None:
    result, _ = solved(name)
    found = live_home(result)
    assert len(found["poses"]) == len(found["after"])
    assert all(-1 <= k < len(found["poses"]) and k != i for i, k in enumerate(found["after"]))
    assert found["signed"] == (name != "surfaces-ppp")
    within = [pair for pair in found["within"] if pair is not None]
    assert all(low <= high for low, high in within)
