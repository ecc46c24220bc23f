from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.geometry.coordinates import choose, coordinates, moved
from gspcli.geometry.quaternions import rotation_from_vector, vector_from_rotation
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import FollowOptions, MovingPlatform, measure, track
from gspcli.motion.following.branch_follower import MovingGeometry, Stop
from gspcli.motion.following.follower import RowFollower
from gspcli.motion.following.tracks import track_from
from gspcli.resources import data_path

MIXED = ["6PP", "6DLL", "PP PL LP PH HP DLL", "PL PL LP ALL ALH AHH"]


def random_platform(gsp_type, seed=1):
    rng = np.random.default_rng(seed)
    instance, (R, T) = random_instance(gspcli.parse_type(gsp_type), rng)
    return rng, instance, R, T


def nominal_values(instance):
    return np.array([constraint.value.value for constraint in instance.constraints])


def matrix_about(axis, angle):
    return rotation_from_vector(np.asarray(axis) / np.linalg.norm(axis) * angle)


@pytest.mark.parametrize("gsp_type", MIXED)
def test_both_proofs_agree_where_only_values_move(gsp_type):
    rng, instance, R, T = random_platform(gsp_type)
    t = np.linspace(0, 1, 6)[:, None]
    turn, move = rng.normal(size=(2, 1, 3)) * 0.03
    values = measure(instance, rotation_from_vector(t * turn) @ R, T + t * move)
    one, other = MovingPlatform(instance), MovingGeometry(instance, ())
    branch = np.zeros(1, int)
    start = one.points(R[None], T[None])
    quick = one.follow(one.internal(values)[None], branch, start)
    slow = other.follow(values[None], branch, start, FollowOptions())
    assert quick.stop == slow.stop == 0
    assert np.allclose(quick.points, slow.points, atol=1e-12)


def test_cranks_about_one_axis_turn_everything():
    text = data_path("examples", "platform-6-6.yaml").read_text(encoding="utf-8")
    head, tail = text.split("base:\n")
    crank = ", crank: {centre: [1, 2, 0.5], axis: [1, -2, 2]}}"
    points, constraints = tail.split("constraints:")
    turning = "\n".join(
        line.replace("]}", "]" + crank) if "{point" in line else line for line in points.split("\n")
    )
    instance = gspcli.loads(f"{head}base:\n{turning}constraints:{constraints}")
    assert gspcli.loads(gspcli.dumps(instance)) == instance
    names = [c.name for c in coordinates(instance)]
    assert len(names) == 6
    angles = np.array([0, 25, -70, 120.0])
    values = np.tile(nominal_values(instance), (4, 1))
    found = track(instance, values, coordinates=dict.fromkeys(names, angles), modes=[1])
    assert found.certified
    assert not found.events
    for k, angle in enumerate(np.radians(angles)):
        Q, centre = matrix_about([1, -2, 2], angle), np.array([1, 2, 0.5])
        assert np.allclose(found.R[0, k], Q @ found.R[0, 0], atol=1e-11)
        assert np.allclose(found.T[0, k], Q @ (found.T[0, 0] - centre) + centre, atol=1e-11)
    # The same in one step as in the other three, and the claim is about the circle, not the chord.
    direct = track(
        instance, values[[0, 3]], coordinates=dict.fromkeys(names, angles[[0, 3]]), modes=[1]
    )
    assert np.allclose(direct.R[0, -1], found.R[0, -1], atol=1e-11)
    assert direct.segments > 3


def test_following_from_given_poses_needs_no_coordinates():
    _, instance, R, T = random_platform("6PP")
    values = measure(instance, R, T)
    found = track_from(instance, np.stack((values, values * 1.001)), R[None], T[None])
    assert found.coordinates == ()
    assert np.isfinite(found.conditions).all()


def random_twist(rng, size):
    x = rng.normal(size=6)
    return x * size / np.linalg.norm(x)


@pytest.mark.parametrize("far", [0.1, 1.0, 30.0])
@pytest.mark.parametrize("size", [1e-3, 1e-6])
def test_distances_of_study_points_are_bounded_by_those_of_poses_and_conversely(far, size):
    rng = np.random.default_rng(7)
    _, instance, R, _ = random_platform("6PP")
    geometry = MovingGeometry(instance, ())
    rows = geometry.rows
    for _ in range(50):
        start = R, far * rng.normal(size=3)
        x = random_twist(rng, size)
        turned = rotation_from_vector(x[:3]) @ R
        middle = start[1] + R @ rows.middle + x[3:] * rows.reach
        points = geometry.points(
            np.stack((R, turned)), np.stack((start[1], middle - turned @ rows.middle))
        )
        apart = min(np.linalg.norm(points[0] - sign * points[1]) for sign in (1, -1))
        assert apart <= geometry._distance(size * rows.reach)
        assert size * rows.reach <= geometry._twist(points[0], start[1], apart)


DRIVEN = {
    "t-top-head": [f"crank.B{k}" for k in range(1, 7)],
    "delta": ["crank.B1", "crank.B3", "crank.B5"],
}


@pytest.mark.parametrize("name", [*DRIVEN, "6PP", "PP PL LP PH HP DLL", "PL PL LP ALL ALH AHH"])
def test_poses_on_a_segment_are_within_its_radius(name):
    rng = np.random.default_rng(3)
    if name in DRIVEN:
        instance = gspcli.example(name)
        solved = gspcli.solve(instance)
        # One that is far from the folds of @delta.
        R, T = (x[solved.real][4].real for x in (solved.R, solved.T))
        chosen = choose(instance, DRIVEN[name])
        ends = np.tile(nominal_values(instance), (2, 1))
        rows = np.column_stack((ends, [np.zeros(len(chosen)), 8 * rng.normal(size=len(chosen))]))
    else:
        _, instance, R, T = random_platform(name)
        goal = rotation_from_vector(0.02 * rng.normal(size=3)) @ R, T + 0.01 * rng.normal(size=3)
        rows, chosen = np.stack((measure(instance, R, T), measure(instance, *goal))), ()
    follower = RowFollower(instance, chosen)
    found = follower.follow(rows, R, T, keep=True)
    assert found.reached == 1
    segments = found.segments
    assert (segments.end[:-1] == segments.begin[1:]).all()
    assert (segments.begin[0], segments.end[-1]) == (0, 1)
    shares = []
    for k in range(len(segments.row)):
        for s in (0.0, 0.3, 0.5, 0.8, 1.0):
            part = segments.begin[k] + s * (segments.end[k] - segments.begin[k])
            there = rows[0] + part * (rows[1] - rows[0])
            at = follower.follow(np.stack((rows[0], there)), R, T)
            assert at.reached == 1
            chord, place = (x[0] for x in segments.chord(np.array([k]), np.array([s])))
            turn = np.linalg.norm(vector_from_rotation(at.R[1] @ chord.T))
            centre = at.T[1] + at.R[1] @ follower.middle - follower.origin
            away = np.hypot(turn, np.linalg.norm(centre / follower.reach - place))
            assert away <= segments.radius[k] + 1e-12
            shares.append(away / segments.radius[k])
    # Not by far too much.
    assert max(shares) > 0.05


def test_drives_that_the_step_does_not_know_are_followed_in_arcs():
    """A rod whose length changes while its crank turns, against the same in many short rows."""
    instance = gspcli.example("t-top-head")
    solved = gspcli.solve(instance)
    R, T = (x[solved.real][:1].real for x in (solved.R, solved.T))
    chosen = choose(instance, ["crank.B1"])
    values = nominal_values(instance)
    rows = np.array([[*values, 0.0], [*(values * 1.001), 2.0]])
    geometry = MovingGeometry(instance, chosen)
    assert not geometry.rows.knows(rows)
    start = geometry.points(R, T)
    found = geometry.follow(rows[None], np.zeros(1, int), start, FollowOptions())
    assert found.stop[0] == Stop.END
    there = moved(instance, chosen, rows[1, 6:])
    assert np.allclose(
        measure(there, *(x[0] for x in geometry.poses(found.points[:, 1]))), rows[1, :6], atol=1e-12
    )
