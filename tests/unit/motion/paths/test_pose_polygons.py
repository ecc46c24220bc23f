"""Polygons of poses along ways of values, and what they join."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import gspcli
from gspcli.geometry.limits import within_limits
from gspcli.motion import mode_groups
from gspcli.motion.paths.ends import Modes
from gspcli.motion.paths.guides import PROVED_ROWS, PoseGuide
from gspcli.motion.paths.planner import Planner
from gspcli.motion.paths.pose_polygons import pose_polygon
from gspcli.motion.paths.pose_ways import WayProof


@pytest.fixture(scope="module")
def study():
    return gspcli.example("workspace-study")


@pytest.fixture(scope="module")
def on_values(study):
    """A planner with a proved way of values from mode 16 to mode 3."""
    planner, ends = Planner(study), Modes(study).all()
    start, goal = ends[15], ends[2]
    search = planner._on_values(planner.values(start), start, goal, planner.seed)
    guide, corners = next(found for found in search if found is not None)
    trace = guide.trace(corners, np.full(len(corners) - 1, PROVED_ROWS))
    return planner, trace, start, goal


def test_a_polygon_of_poses_is_proved_and_keeps_the_ends(study, on_values):
    planner, trace, start, goal = on_values
    guide = planner.pose_guide()
    corners = pose_polygon(guide, trace.rows, *planner._parameters(start, goal))
    assert 2 < len(corners) < len(trace.T)
    assert all(planner.ways.prove(*pair).sign for pair in pairwise(corners))
    R, T = planner.ways.poses(corners[[0, -1]])
    assert np.abs(R - np.stack((start.R, goal.R))).max() < 1e-12
    assert np.abs(T - np.stack((start.T, goal.T))).max() < 1e-9


def test_without_proofs_of_the_steps_there_is_no_polygon(on_values, monkeypatch):
    planner, trace, start, goal = on_values
    monkeypatch.setattr(type(planner.ways), "prove", lambda *_: WayProof(0, 0, "limit"))
    guide = PoseGuide(planner.ways, 1.0)
    assert pose_polygon(guide, trace.rows, *planner._parameters(start, goal)) is None


def test_a_path_of_poses_within_ranges(study):
    found = gspcli.path(study, "home", 3, along="poses")
    assert (found.verdict, found.along) == ("proved", "poses")
    assert within_limits(study, found.values, found.R, found.T).all()
    assert found.length < 3 * found.straight_length


def test_modes_are_grouped_along_poses_as_along_values(study):
    along = mode_groups(study, along="poses")
    assert along.complete
    assert along.groups == mode_groups(study).groups
    assert len(along.groups) == 2
