"""Ways home that live pages find, proved again by the kernel of the package."""

from __future__ import annotations

import shutil
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from gspcli.geometry.machine import Machine
from gspcli.motion.paths.planner import mode_groups
from gspcli.motion.paths.ways import ValueWays
from gspcli.pictures.live_numbers import live_numbers
from gspcli.solver import SolveResult, solve
from gspcli.spec.reading import example
from tests.support.thick_legs import poses_near
from tests.support.ways_home import ways_home

Array = NDArray[np.float64]

pytestmark = pytest.mark.skipif(shutil.which("node") is None, reason="no Node on this machine")


def rows_of(found: dict[str, Any]) -> tuple[Array, Array, Array]:
    rows = np.array(found["rows"])
    return rows[:, :9].reshape(-1, 3, 3), rows[:, 9:12], rows[:, 12:]


def refusal(result: SolveResult, found: dict[str, Any]) -> str:
    """Return why a way is not proved by the package; empty if it is."""
    R, T, values = rows_of(found)
    ways = ValueWays(result.instance, np.sign(values[0]))
    points = ways.points(R, T)
    if not ways.kept(values).all():
        return "ranges"
    arrived = ways.follow(values[None], np.zeros(1, np.int64), points[:1])
    if not arrived.there[0]:
        return "not followed"
    if not ways.same(points, arrived.points[0]).all():
        return "elsewhere"
    home = result.home
    assert home is not None
    at = ways.points(result.R[home.number - 1].real[None], result.T[home.number - 1].real[None])
    return "" if ways.same(at, points[-1])[0] else "not home"


@pytest.fixture(scope="module")
def study() -> SolveResult:
    return solve(example("workspace-study"))


def test_all_modes_that_belong_to_home_go_there(study: SolveResult) -> None:
    found = ways_home(study, study.R[study.real].real, study.T[study.real].real)
    groups = mode_groups(study.instance)
    home = next(group for group in groups.groups.values() if 16 in group)
    assert len(home) == 8
    for number, one in enumerate(found, 1):
        if number == 16:
            assert one["isHome"]
        elif number in home:
            assert (one["kind"], refusal(study, one)) == ("stored", "")
        else:
            assert one["reason"] == "sign"


def test_random_poses_in_the_ranges_go_home(study: SolveResult) -> None:
    home = study.home
    assert home is not None
    R, T = poses_near(
        study.R[home.number - 1].real, study.T[home.number - 1].real, 400, 120, 0.8, 1
    )
    inside = Machine.of(study.instance).keeps(R, T)
    R, T = R[inside][:60], T[inside][:60]
    found = ways_home(study, R, T)
    assert len(found) == 60
    assert [refusal(study, one) for one in found if "kind" in one] == [""] * 60
    assert not any(one["outside"] for one in found)


def test_a_way_that_begins_outside_the_ranges_says_so(study: SolveResult) -> None:
    home = study.home
    assert home is not None
    R, T = study.R[home.number - 1].real, study.T[home.number - 1].real
    (one,) = ways_home(study, R[None], T[None] + [0, 0, 150])
    assert (one["kind"], one["outside"]) == ("values", True)


def test_without_the_map_other_modes_are_not_joined(study: SolveResult) -> None:
    """The map is what joins them, and a pose of it that is elsewhere joins nothing."""
    live = live_numbers(study)
    R, T = study.R[study.real].real[:1], study.T[study.real].real[:1]
    assert ways_home(study, R, T, live)[0]["kind"] == "stored"
    live["ways"]["poses"] = [[*one[:2], -one[2], *one[3:]] for one in live["ways"]["poses"]]
    assert ways_home(study, R, T, live)[0]["reason"] == "none"


def test_cones_are_kept_on_ways() -> None:
    result = solve(example("workspace-study-cones"))
    home = result.home
    assert home is not None
    R, T = result.R[home.number - 1].real, result.T[home.number - 1].real
    R, T = poses_near(R, T, 400, 100, 0.5, 2)
    inside = Machine.of(result.instance).keeps(R, T)
    found = ways_home(result, R[inside][:20], T[inside][:20])
    assert len(found) == 20
    for one in found:
        assert refusal(result, one) == ""
        R, T, _ = rows_of(one)
        assert (Machine.of(result.instance).cone_shares(R, T) <= 1).all()


def test_motors_go_home_within_their_ranges() -> None:
    result = solve(example("reachy-mini-head"))
    live = live_numbers(result)
    found = ways_home(result, result.R[result.real].real, result.T[result.real].real, live)
    kinds = [one.get("kind") or one.get("reason") for one in found]
    assert {"poses", "sign"} <= set(kinds)
    within = np.array(live["ways"]["within"], float)
    for one in found:
        if "rows" in one:
            values = rows_of(one)[2]
            assert (values >= within[:, 0] - 1e-9).all()
            assert (values <= within[:, 1] + 1e-9).all()
