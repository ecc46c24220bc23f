"""Speeds and accelerations along planned paths, measured at samples between all rows."""

from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.errors import ArgumentError
from gspcli.geometry.euler import rotation_from_euler
from gspcli.motion.following.tracks import departures, track_from
from gspcli.motion.paths.planned_paths import LineMove, PathEnd, PathLimits, moves_of
from gspcli.motion.paths.planner import Planner, finished
from gspcli.motion.poses.inverse_kinematics import values_at

SPEED, ACCELERATION = 50.0, 200.0


def rates(found, samples=20_000):
    """Return the largest speed and acceleration of each value, from differences of samples."""
    moves = found.timing.moves
    times = np.linspace(0, moves.seconds, samples + 1)
    numbers = moves.at(times)[0]
    if found.along == "poses":
        numbers = values_at(found.instance, *Planner(found.instance).ways.poses(numbers))
    step = times[1]
    speeds = np.abs(np.diff(numbers, axis=0)) / step
    return speeds.max(), (np.abs(np.diff(numbers, 2, axis=0)) / step**2).max(), numbers


def least_time(found, speed, acceleration):
    """Return how long the motors need at least from the first to the last values, rest to rest."""
    far = np.abs(found.values[-1] - found.values[0]).max()
    reached = far >= speed**2 / acceleration
    return far / speed + speed / acceleration if reached else 2 * np.sqrt(far / acceleration)


def checked(found, speed=SPEED, acceleration=ACCELERATION):
    """Limits hold between the rows, rows are where the moves are, and the way is proved."""
    v, a, numbers = rates(found)
    assert 0.5 * speed < v < speed * (1 + 1e-6)
    assert 0.5 * acceleration < a < acceleration * (1 + 1e-4)
    assert found.timing.seconds >= least_time(found, speed, acceleration) * (1 - 1e-9)
    assert np.abs(numbers[-1] - found.values[-1]).max() < 1e-9 * np.abs(numbers).max()
    gaps = np.diff(found.t)
    assert (gaps > 0).all()
    assert found.t[-1] == found.timing.seconds
    # What a reader of the file computes from its rows.
    mean = np.diff(found.values, axis=0) / gaps[:, None]
    bent = np.diff(mean, axis=0) / ((gaps[1:] + gaps[:-1]) / 2)[:, None]
    assert np.abs(mean).max() < speed * (1 + 1e-6)
    assert np.abs(bent).max() < acceleration * (1 + 1e-6)
    followed = track_from(found.instance, found.values, found.R[:1], found.T[:1])
    assert followed.ends == ()
    assert departures(followed, found.R, found.T) == []
    return found


@pytest.fixture(scope="module")
def study():
    return gspcli.example("workspace-study")


@pytest.fixture(scope="module")
def plain(study):
    """A path with corners, without a time."""
    return gspcli.path(study, "home", 3)


def timed(study, goal, **more):
    return gspcli.path(study, "home", goal, speed=SPEED, acceleration=ACCELERATION, **more)


def around(plain, *, clear=0.0):
    """Return the path with corners with a time: it is not planned again."""
    ends = [
        PathEnd(name, *(getattr(plain, key)[row] for key in ("values", "R", "T")))
        for name, row in ((plain.start, 0), (plain.goal, -1))
    ]
    planner = Planner(plain.instance, clear=clear)
    guide = planner.value_guide(planner.values(ends[0]), *ends)
    corners = plain.values[[0, *(part.last for part in plain.parts)]]
    limits = PathLimits.of(SPEED, ACCELERATION)
    return finished(plain.instance, guide, corners, *ends, limits)


def test_a_path_that_is_planned_with_a_speed(study, plain):
    found = timed(study, 3)
    again = around(plain)
    assert found.timing.to_json() == again.timing.to_json()
    assert np.abs(found.values - again.values).max() < 1e-9
    assert np.array_equal(found.t, again.t)


def test_a_path_around_stops_at_corners(plain):
    found = checked(around(plain))
    assert len(found.timing.moves.tops) == len(found.parts) == len(plain.parts)
    # At rest at each corner: the path is the same.
    corners = found.values[[part.last for part in found.parts]]
    assert np.array_equal(corners, plain.values[[part.last for part in plain.parts]])
    moves = found.timing.moves
    ends = [found.t[part.last] for part in found.parts[:-1]]
    short = 1e-6
    near = moves.at(np.add.outer(ends, (0.0, short)).ravel())[0].reshape(len(ends), 2, -1)
    assert np.abs(np.diff(near, axis=1)).max() < ACCELERATION * short**2


def test_motors_keep_limits_on_ways_of_poses(study):
    goal = np.eye(3), [40.0, 20, 430]
    found = checked(timed(study, goal, along="poses"))
    assert (found.along, len(found.parts)) == ("poses", 1)


def test_the_platform_keeps_limits_around_corners():
    platform = gspcli.example("surfaces-sss")
    speed = {"drives": 1.0, "platform": 0.005, "turn": 20.0}
    acceleration = {"platform": 0.02, "turn": 60.0}
    more = {"speed": speed, "acceleration": acceleration}
    found = gspcli.path(platform, 1, 5, **more)
    assert len(found.parts) > 1
    v, _, _ = rates(found)
    assert 0.5 < v < 1 + 1e-6
    moves = found.timing.moves
    times = np.linspace(0, moves.seconds, 40_001)
    numbers, step = moves.at(times)[0], times[1]
    velocity = np.diff(numbers[:, :3], axis=0) / step
    assert 0.004 < np.linalg.norm(velocity, axis=1).max() <= 0.005 * (1 + 1e-6)
    bend = np.diff(velocity, axis=0) / step
    assert np.linalg.norm(bend, axis=1).max() <= 0.02 * (1 + 1e-4)
    R = rotation_from_euler("ZYX", numbers[:, 3:])
    step = np.swapaxes(R[:-1], 1, 2) @ R[1:]
    cosine = (np.trace(step, axis1=1, axis2=2) - 1) / 2
    assert np.degrees(np.arccos(np.minimum(cosine, 1)).max()) / times[1] < 20 * (1 + 1e-3)


def test_a_clearance_is_kept_around_corners(plain):
    least = min(plain.clearances) / 4
    assert least > 0
    found = around(plain, clear=least)
    assert len(found.parts) > 1
    assert min(part.clearance for part in found.parts) >= least


def test_nothing_moves_in_no_time(study):
    found = timed(study, "home")
    assert found.timing.seconds < 1e-6


def test_a_short_part_does_not_reach_its_speed():
    """Speeds rise and fall at 2 a second squared: a way of 0.1 takes 2 sqrt(0.1 / 2) s."""
    lines = [LineMove(np.array([w, 0.0]), w, 2.0) for w in (10.0, 0.1)]
    moves = moves_of(np.array([[0, 0], [10, 0], [10.1, 0]]), lines)
    assert np.diff(moves.begins) == pytest.approx([10.5, 2 * np.sqrt(0.05)])
    places, parts = moves.at(np.array([0.5, 10.5 + np.sqrt(0.05), moves.seconds]))
    assert places[:, 0] == pytest.approx([0.25, 10.05, 10.1])
    assert parts.tolist() == [0, 1, 1]


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"speed": 5}, "acceleration: found none"),
        ({"acceleration": 5}, "speed: found none"),
        ({"speed": 0, "acceleration": 5}, "found 0.0 for drives"),
        ({"speed": np.nan, "acceleration": 5}, "found nan for drives"),
        ({"speed": {"motor": 1}, "acceleration": 5}, "found 'motor'"),
        ({"speed": {"turn": 1}, "acceleration": 5}, "found no limit of the drives"),
        (
            {"speed": {"drives": 1, "turn": 1}, "acceleration": 5, "along": "values"},
            "proved along poses only",
        ),
    ],
)
def test_mistakes(study, more, message):
    with pytest.raises(ArgumentError, match=message):
        gspcli.path(study, "home", 3, **more)
