"""Straight ways in position and angles: what is proved is true at all samples."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import gspcli
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import condition_numbers
from gspcli.motion.paths.planned_paths import PoseGuide
from gspcli.motion.paths.planner import PoseClass, PoseMap
from gspcli.motion.paths.ways import PoseWays

#: Machines of all kinds of constraint, and with ranges and cones.
MACHINES = (
    "platform-6-6",
    "workspace-study",
    "workspace-study-cones",
    "surfaces-ccc",
    "surfaces-ppp",
    "sdss-primary",
    "figure-2",
    "fixture-3-2-1",
    "example-6.8",
)


@cache
def ways_of(name: str, *, limits: bool) -> tuple[PoseWays, np.ndarray]:
    """Return straight ways and the parameters of the modes."""
    instance = gspcli.example(name)
    ways = PoseWays(instance, limits=limits)
    solved = gspcli.solve(instance)
    real = solved.real
    return ways, ways.parameters(solved.R[real].real, solved.T[real].real)


def determinants(ways: PoseWays, parameters: np.ndarray) -> np.ndarray:
    R, T = ways.poses(parameters[:1])
    found = PoseMap(PoseGuide(ways, 1.0), R, T, lambda *_: PoseClass(()), seed=0)
    return found.determinants(parameters)


@pytest.mark.parametrize("name", MACHINES)
def test_a_regular_way_keeps_the_sign_of_the_determinant(name):
    ways, modes = ways_of(name, limits=False)
    draw = np.random.default_rng(1)
    parts = np.linspace(0, 1, 200)[:, None]
    proved, senses = 0, set()
    for k in range(60):
        begin = modes[k % len(modes)]
        width = 10.0 ** -draw.integers(0, 3)
        end = begin + draw.normal(size=6) * ways.sizes * width
        found = ways.prove(begin, end)
        signs = np.sign(determinants(ways, begin + (end - begin) * parts))
        if found.sign:
            proved += 1
            assert (signs == signs[0]).all()
            senses.add(found.sign * signs[0])
            assert ways.prove(end, begin).sign == found.sign
    assert proved > 10
    # Screws of angles have either sense, the same one at all poses.
    assert len(senses) == 1


@pytest.mark.parametrize("name", [name for name in MACHINES if name != "figure-2"])
def test_a_way_whose_determinant_changes_its_sign_is_not_proved(name):
    ways, modes = ways_of(name, limits=False)
    signs = np.sign(determinants(ways, modes))
    tried = 0
    for i in range(min(len(modes), 12)):
        for j in range(i):
            if signs[i] != signs[j]:
                tried += 1
                found = ways.prove(modes[i], ways.nearest(modes[i], modes[j]))
                assert found.sign == 0
                assert found.reason
    assert tried


@pytest.mark.parametrize("name", ["workspace-study", "workspace-study-cones"])
def test_a_way_within_the_limits_keeps_them_at_samples(name):
    ways, modes = ways_of(name, limits=True)
    instance = ways.instance
    draw = np.random.default_rng(2)
    parts = np.linspace(0, 1, 100)[:, None]
    proved = left = 0
    for _ in range(150):
        begin = modes[-1] + draw.normal(size=6) * ways.sizes * 0.02
        end = begin + draw.normal(size=6) * ways.sizes * 0.15
        R, T = ways.poses(begin + (end - begin) * parts)
        kept = Machine.of(instance).keeps(R, T).all()
        found = ways.prove(begin, end)
        if found.sign:
            proved += 1
            assert kept
        left += not kept
    assert proved > 20
    assert left > 20


def test_a_way_that_leaves_a_range_between_its_ends_is_refused():
    ways, modes = ways_of("workspace-study", limits=True)
    # Half a turn about z and back again by the other way: both ends are home, and no leg is then.
    found = ways.prove(modes[-1], modes[-1] + [0, 0, 0, 0, 0, 2 * np.pi])
    assert found.sign == 0


def test_angles_are_continued_by_whole_turns_and_over_the_pole():
    ways, _ = ways_of("platform-6-6", limits=False)
    draw = np.random.default_rng(3)
    here = draw.uniform(-7, 7, size=(50, 6))
    R, T = ways.poses(here + 0.1 * draw.normal(size=(50, 6)))
    found = ways.nearest(here, ways.parameters(R, T))
    assert np.abs(found - here).max() < 1
    again = ways.poses(found)
    assert np.abs(again[0] - R).max() < 1e-9
    assert np.abs(again[1] - T).max() < 1e-9


def test_a_singular_pose_is_not_proved():
    instance = gspcli.example("singular-pose")
    solved = gspcli.solve(instance)
    real = solved.real
    R, T = solved.R[real].real, solved.T[real].real
    singular = ~np.isfinite(condition_numbers(Arrangement.of(instance), R, T))
    assert singular.any()
    ways = PoseWays(instance, limits=False)
    at = ways.parameters(R, T)[singular][0]
    assert ways.at(at).sign == 0
    for size in (1e-1, 1e-5, 1e-9):
        away = np.full(6, size) * ways.sizes
        assert ways.prove(at - away, at + away).sign == 0
