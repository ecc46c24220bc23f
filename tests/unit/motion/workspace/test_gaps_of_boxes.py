"""Poses at which legs and bodies are far enough apart: boxes and travels against samples."""

import numpy as np
import pytest

from gspcli.errors import ArgumentError
from gspcli.geometry.machine import Machine
from gspcli.motion.collisions.compared import ComparedShapes
from gspcli.motion.workspace.pose_boxes import PARAMETERS
from gspcli.motion.workspace.travels import travels
from gspcli.motion.workspace.workspaces import workspace
from gspcli.spec.reading import example
from tests.support.thick_legs import thick

HOME = np.eye(3), np.array([0.0, 0.0, 400.0])


@pytest.mark.parametrize(
    ("free", "gap", "near"),
    [
        (("x", "rz"), 12.0, None),
        (("z", "rz"), 10.0, None),
        (("rx", "ry"), 15.0, None),
        (("x", "rz"), 10.0, 30.0),
    ],
)
def test_no_sample_contradicts_a_box(free, gap, near):
    instance = thick("workspace-study", near)
    found = workspace(instance, *HOME, free=free, gap=gap, tolerance=0.1, most_boxes=20_000)
    points = np.random.default_rng(1).uniform(*found.bounds.T, (20_000, len(free)))
    judged = found.judged_at(points / found.units)
    parameters = np.tile(found.boxes.home, (len(points), 1))
    parameters[:, [PARAMETERS.index(name) for name in free]] = points
    R, T = found.boxes.poses(parameters)
    kept = Machine.of(instance).keeps(R, T)
    gaps = ComparedShapes(instance).bounds(R, T)
    apart, near_ = (gaps.low >= gap).all(axis=1), (gaps.high < gap).any(axis=1)
    # The gap matters: some poses violate nothing else.
    assert (kept & near_).sum() > 20
    assert (judged == 1).sum() > 20
    assert not (near_ & (judged == 1)).any()
    assert not (kept & apart & (judged == -1)).any()
    free_of_it = workspace(instance, *HOME, free=free, tolerance=0.1, most_boxes=20_000)
    assert found.volume[1] <= free_of_it.volume[1]


def test_travels_end_where_legs_are_too_near():
    instance, gap = thick("workspace-study"), 15.0
    compared = ComparedShapes(instance)
    (plain,) = travels(instance, *HOME, axes=["rz"])
    (found,) = travels(instance, *HOME, axes=["rz"], gap=gap)
    assert found.reached[1] < plain.reached[1]
    assert found.stops[1] == ("gap",)
    end = np.radians(found.reached[1])
    for share, ok in ((1 - 1e-6, True), (1 + 1e-4, False)):
        c, s = np.cos(end * share), np.sin(end * share)
        R = np.array([[[c, -s, 0], [s, c, 0], [0, 0, 1]]])
        assert (compared.bounds(R, HOME[1][None]).low.min() >= gap) == ok


def test_home_must_keep_the_gap_and_the_platform_must_state_shapes():
    with pytest.raises(ArgumentError, match="the gap between legs 1 and 6 is 23"):
        travels(thick("workspace-study"), *HOME, gap=30.0)
    with pytest.raises(ArgumentError, match="states no shapes"):
        workspace(example("workspace-study"), *HOME, gap=1.0)
    with pytest.raises(ArgumentError, match="expected a finite number"):
        workspace(thick("workspace-study"), *HOME, gap=np.nan)
    with pytest.raises(ArgumentError, match="home does not keep"):
        workspace(thick("workspace-study"), *HOME, free=("x",), gap=30.0, connected=True)


def test_part_connected_with_home():
    instance = thick("workspace-study")
    whole = workspace(instance, *HOME, free=("x", "rz"), gap=10.0, tolerance=0.05)
    part = workspace(instance, *HOME, free=("x", "rz"), gap=10.0, tolerance=0.05, connected=True)
    assert 0 < part.volume[0] <= whole.volume[1]
