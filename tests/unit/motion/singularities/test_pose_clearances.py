"""None"""

from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.errors import ArgumentError
from gspcli.geometry.quaternions import apply, cross
from gspcli.geometry.random_instances import random_instance
from gspcli.motion.singularities import pose_clearances as searching
from gspcli.motion.singularities.pose_clearances import (
    Displacements,
    Screws,
    pose_clearance,
    pose_clearances,
    regular,
)
from gspcli.resources import data_path

TYPES = ["6PP", "6PH", "6PL", "6DLL", "PP PL LP PH HP DLL", "PL PL LP ALL ALH AHH"]


def platform(name, seed):
    instance, (R, T) = random_instance(gspcli.parse_type(name), np.random.default_rng(seed))
    return instance, R, T


def at_distance(home, size, count):
    """Return random displacements of a size, and multiples by numbers up to one."""
    rng = np.random.default_rng(5)
    s = rng.normal(size=(count, 6))
    return s / np.linalg.norm(s, axis=1)[:, None] * size * rng.uniform(size=(count, 1)) ** (1 / 6)


def test_coordinates_have_the_length_of_the_displacement_of_the_points():
    instance, R, T = platform("6PP", 1)
    home = Displacements(instance, R[None], T[None])
    s = at_distance(home, home.farthest, 50)
    moved, shifted = home.poses(s)
    points = home.points
    steps = (
        np.einsum("nij,pj->npi", moved, points) + shifted[:, None] - (points @ R.T + T)
    )  # fmt: skip
    distances = np.sqrt((steps**2).sum(axis=2).mean(axis=1))
    assert distances == pytest.approx(np.linalg.norm(s, axis=1))


@pytest.mark.parametrize("name", TYPES)
def test_screws_are_enclosed_over_boxes_and_are_those_of_the_jacobian_matrix(name):
    instance, R, T = platform(name, 2)
    home = Displacements(instance, R[None], T[None])
    screws = Screws(home)
    rng = np.random.default_rng(3)
    s, half = rng.normal(size=(1, 6)) * 0.1, rng.uniform(0.01, 0.1, size=(1, 6))
    found = screws.rows(s, half, cube=True)
    value, linear, rest = found.mid[..., 0], found.lin[..., 0, :], found.rad
    x = np.concatenate((rng.uniform(-1, 1, size=(40, 6)), rng.choice([-1, 1], size=(40, 6))))
    off = screws.matrices(s + half * x) - value - np.einsum("kci,ni->nkc", linear[0], x)
    assert (np.abs(off) <= rest).all()
    # Not enclosed if the derivatives were wrong: the rest is of second order.
    assert (np.abs(off) <= rest / 2).any()
    at, shift = home.poses(s)
    rows = gspcli.geometry.measurement.jacobian(home.arrangement, at[0], shift[0])
    arm = home.centres[0] + s[0, :3] - s[0, :3] - shift[0]
    rows[:, :3] -= cross(np.broadcast_to(arm, (6, 3)), rows[:, 3:])
    rows[:, :3] = rows[:, :3] @ (home.axes[0] / home.radii)
    norms = np.linalg.norm(rows, axis=1) * np.linalg.norm(value[0], axis=1)
    assert np.abs(np.sum(rows * value[0], axis=1) / norms) == pytest.approx(np.ones(6))


@pytest.mark.parametrize("name", ["6PP", *TYPES[4:]])
def test_the_determinant_keeps_its_sign_within_the_lower_bound_and_not_to_the_upper(
    name, monkeypatch
):
    instance, R, T = platform(name, 3)
    monkeypatch.setattr(searching, "_ROUNDS", 8)
    found = pose_clearance(instance, R, T)
    assert 0 < found.lower <= found.upper
    home = Displacements(instance, R[None], T[None])
    here = np.sign(home.determinants(np.zeros((1, 6))))
    within = home.determinants(at_distance(home, found.lower, 2000))
    assert (np.sign(within) == here).all()
    assert np.isfinite(found.upper)
    steps = apply(found.R, home.points) + found.T - apply(R, home.points) - T
    assert np.sqrt((steps**2).sum(axis=1).mean()) == pytest.approx(found.upper)
    rows = gspcli.geometry.measurement.jacobian(home.arrangement, found.R, found.T)
    rows /= np.linalg.norm(rows, axis=1)[:, None]
    assert np.linalg.svd(rows)[1][-1] < 1e-6


def test_refined_bounds_are_nearer_and_hold(monkeypatch):
    monkeypatch.setattr(searching, "_MANY_RAYS", 12)
    instance, R, T = platform("6PP", (5, 0))
    once, refined = (pose_clearance(instance, R, T, refine=k) for k in (False, True))
    assert once.lower < refined.lower <= refined.upper <= once.upper * (1 + 1e-6)
    assert refined.ratio < 1.2 < 1.5 < once.ratio
    home = Displacements(instance, R[None], T[None])
    within = home.determinants(at_distance(home, refined.lower, 20_000))
    assert np.ptp(np.sign(within)) == 0


def test_a_wider_ball_than_the_distance_of_a_singular_pose_is_never_proved(monkeypatch):
    instance, R, T = platform("6PP", 0)
    monkeypatch.setattr(searching, "_ROUNDS", 4)
    found = pose_clearance(instance, R, T)
    screws = Screws(Displacements(instance, R[None], T[None]))
    for size in (found.upper, 2 * found.upper):
        half = np.full((1, 6), size)
        assert screws.judge(np.zeros((1, 6)), half, cube=False).sign == 0
        assert screws.judge(np.zeros((1, 6)), half, cube=True).sign == 0


def test_clearances_follow_the_unit_of_length_and_the_points():
    instance, R, T = platform("6PP", 4)
    both = pose_clearances(instance, np.stack((R, R)), np.stack((T, T)))
    assert both[0] == both[1]
    home = Displacements(instance, R[None], T[None])
    # Points twice as far from their centre: the same turn is worth twice as much.
    far = home.centre + 2 * (home.points - home.centre)
    wider = pose_clearances(instance, R[None], T[None], points=far)
    assert both[0] <= wider[0] * 1.02
    assert wider[0] <= 2 * both[0] * 1.02


def test_a_singular_pose_has_no_clearance():
    instance = gspcli.load(data_path("examples", "singular-pose.yaml"))
    poses = gspcli.solve(instance)
    found = pose_clearance(instance, poses.R[0].real, poses.T[0].real)
    assert (found.lower, found.upper, found.R) == (0, np.inf, None)


def test_points_on_a_line_are_refused():
    instance, R, T = platform("6PP", 0)
    with pytest.raises(ArgumentError, match="points: the points of the platform lie on a line"):
        pose_clearances(instance, R[None], T[None], points=[[0, 0, 0], [1, 1, 0], [2, 2, 0]])


# The sign that a matrix of screws is proved to have is that of its determinant.


def test_the_sign_is_that_of_the_determinant() -> None:
    rng = np.random.default_rng(1)
    rows = rng.normal(size=(40, 6, 6))
    nothing = np.zeros((40, 6, 6, 6)), np.zeros((40, 6, 6))
    found, _ = regular(rows, *nothing, cube=True)
    np.testing.assert_array_equal(found, np.sign(np.linalg.det(rows)))
