"""Points of poses far away, from quaternions in double precision."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli import hexapod
from gspcli.certification.equations.mirror_images import has_mirror_images, mirrored, mirrored_pose
from gspcli.certification.poses.far_points import far_points
from gspcli.certification.poses.locator import Located
from gspcli.continuation.tracked_paths import TrackedPaths
from gspcli.geometry.quaternions import canonical_sign, study_from_pose
from gspcli.solver import further, solve
from gspcli.solver.poses import are_far
from gspcli.solver.problem import Problem
from gspcli.solver.side_search import SideSearch
from gspcli.solver.solved_starts import SolvedStarts


def hexagons(digits=None, *, height=0.0):
    """Return hexagons with half angles, rounded to some digits, or in floating point."""
    k, side = np.arange(6) * np.pi / 3, (-1.0) ** np.arange(6)

    def ring(turn, half):
        angles = k + turn + half * side
        return np.c_[np.cos(angles), np.sin(angles), 0 * k]

    base, top = ring(0, 0.2), 0.6 * ring(np.pi / 6, 0.1)
    top[0, 2] = height
    if digits is not None:
        base, top = base.round(digits), top.round(digits)
    return hexapod(base, top, [1.2, 1.25, 1.22, 1.21, 1.23, 1.24])


@pytest.mark.parametrize("digits", [3, 6, None])
def test_poses_far_away_need_neither_more_paths_nor_elimination(digits, monkeypatch):
    instance = hexagons(digits)
    known = solve(instance, starts=SolvedStarts())
    assert known.verdict == "complete"
    assert known.proof is not None
    far = are_far(known.R, known.T, 1.0)
    assert far.sum() >= 6
    with monkeypatch.context() as context:
        # The same by the further strategies.
        context.setattr(SideSearch, "add_far", lambda *_: None)
        other = solve(instance, starts=SolvedStarts())
    for part in ("quaternions", "R", "T", "real"):
        np.testing.assert_array_equal(getattr(known, part), getattr(other, part))
    monkeypatch.setattr(TrackedPaths, "track", None)
    monkeypatch.setattr(further, "poses_by_elimination", None)
    assert solve(instance, starts=SolvedStarts()).counts == known.counts


def test_points_are_right_to_many_digits_and_conjugates_are_left_out():
    problem = Problem(hexagons(6))
    known = solve(problem.instance)
    e, _ = study_from_pose(known.R, known.T)
    e = e[are_far(known.R, known.T, 1.0)]
    e /= np.linalg.norm(e, axis=1, keepdims=True)
    locator, sides = problem.locator, problem.sides[0]
    points = far_points(locator, sides, e)
    assert len(points) == len(e) // 2
    for point in points:
        located = locator.locate_exactly(point, sides, 128)
        assert isinstance(located, Located)
        assert (located.T == known.T).all(axis=1).any()


def test_there_is_no_point_at_infinity_or_far_from_solutions():
    rng = np.random.default_rng(1)
    problem = Problem(hexagons(6))
    e = rng.normal(size=(20, 4)) + 1j * rng.normal(size=(20, 4))
    e /= np.linalg.norm(e, axis=1, keepdims=True)
    assert not len(far_points(problem.locator, problem.sides[0], e))


def test_mirror_images_of_poses_are_poses():
    problem = Problem(hexagons(2))
    assert has_mirror_images(problem.instance)
    assert not has_mirror_images(hexagons(2, height=0.01))
    known = solve(problem.instance)
    R, T = mirrored_pose(known.R, known.T)
    poses = {(x.tobytes(), y.tobytes()) for x, y in zip(known.R, known.T, strict=True)}
    assert {(x.tobytes(), y.tobytes()) for x, y in zip(R, T, strict=True)} == poses
    e, f = study_from_pose(known.R, known.T)
    images = mirrored(np.concatenate((e, f), axis=1))
    expected = np.concatenate(study_from_pose(R, T), axis=1)
    signs = np.sign((images[:, :4] * expected[:, :4].conj()).real.sum(axis=1))[:, None]
    np.testing.assert_allclose(images, signs * expected, rtol=1e-9, atol=1e-9)
    located = problem.locator.near(known.R[-1], known.T[-1], problem.sides[0])
    assert isinstance(located, Located)
    image = located.mirrored
    for one, other in zip(mirrored_pose(located.R, located.T), (image.R, image.T), strict=True):
        np.testing.assert_array_equal(one, other)
    quaternion = canonical_sign(mirrored(located.quaternion)[None])[0]
    np.testing.assert_array_equal(image.quaternion, quaternion)
    again = problem.locator.near(image.R, image.T, problem.sides[0])
    assert isinstance(again, Located)
    assert image.isolation.contains(again.isolation)
