"""Proved ways of machines with motors against samples, and the judge itself."""

from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.errors import ArgumentError
from gspcli.motion.collisions.compared import ComparedShapes
from gspcli.motion.paths.ways import WayProof
from gspcli.spec.reading import example
from tests.support import driven_paths
from tests.support.thick_legs import thick


@pytest.mark.parametrize("name", ["t-top 120", "mixed"])
def test_no_sample_contradicts_a_proved_way(name):
    found = driven_paths.segments(name, 25, 500)
    assert found.proved > 5
    assert found.wrong == 0


def test_ways_that_are_not_proved_are_found_wrong(monkeypatch):
    class Credulous(driven_paths.PoseWays):
        def prove(self, begin, end):
            del begin, end
            return WayProof(1, 1)

    monkeypatch.setattr(driven_paths, "PoseWays", Credulous)
    assert driven_paths.segments("reachy 90", 40, 300).wrong > 0


def test_paths_of_drives_are_followed_to_their_ends():
    assert driven_paths.paths("6-PUS", 1).proved == 1
    draw = driven_paths.Draw("6-PUS", 3)
    R, T = draw.machine.R[None], draw.machine.T[None]
    q = draw.geometry.numbers(R, T)
    rows = [np.concatenate((one, one)) for one in (R, T, q)]
    assert driven_paths.is_kept(draw, *rows)
    rows[2][1] += 1e-3
    assert not driven_paths.is_kept(draw, *rows)


# Planned paths on which legs keep a gap.


NEAR = np.eye(3), [10.0, 0, 420]


def test_a_path_keeps_a_gap_and_says_what_is_proved():
    found = gspcli.path(thick("workspace-study"), "home", NEAR, gap=15.0)
    assert found.verdict == "proved"
    assert found.gaps.min() >= 15
    assert all(part.gap >= 15 for part in found.parts)
    assert ComparedShapes(found.instance).bounds(found.R, found.T).high.min() >= 15
    row = found.rows()[0]
    assert row["gap"] == pytest.approx(23.412044, abs=1e-6)
    assert found.to_json()["parts"][0]["gap"] >= 15
    assert "gap" not in gspcli.path(thick("workspace-study"), "home", NEAR).rows()[0]


def test_a_gap_leads_a_path_another_way():
    """The straight way turns the platform so far that its legs come near to each other."""
    instance = thick("workspace-study", diameter=40)
    turn = np.radians(25)
    R = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    gaps = gspcli.motion.gaps(instance, R, [0, 0, 400]).least[0]
    found = gspcli.path(instance, "home", (R, [0, 0, 400]), gap=gaps - 0.5, time=1000)
    assert found.verdict == "proved"
    assert found.gaps.min() >= gaps - 0.5


def test_an_end_that_is_too_near_is_told():
    found = gspcli.path(thick("workspace-study"), "home", NEAR, gap=30.0)
    assert found.verdict == "impossible"
    assert "the gap between legs 1 and 6 is 23.412 mm, at least 30 is asked for" in found.reason


def test_what_cannot_be_asked_for():
    with pytest.raises(ArgumentError, match="states no shapes"):
        gspcli.path(example("workspace-study"), "home", 3, gap=1.0)
    with pytest.raises(ArgumentError, match="finite"):
        gspcli.path(thick("workspace-study"), "home", 3, gap=np.inf)
    with pytest.raises(ArgumentError, match="states no shapes"):
        gspcli.path(example("t-top-head"), "home", 2, gap=0.0)
