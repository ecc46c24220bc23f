"""Planar platforms, a new geometry each time, from a solved one with complex values."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gspcli import hexapod
from gspcli.catalogue.kinds import DPH
from gspcli.catalogue.names import parse_type
from gspcli.certification.equations.mirror_images import mirrored
from gspcli.continuation import reduced_homotopy
from gspcli.continuation.reduced_homotopy import ends_from_start
from gspcli.continuation.start import distinct
from gspcli.continuation.tracker_options import SHORT_STEPS
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.geometry.random_instances import random_instance
from gspcli.solver import solve
from gspcli.solver.problem import Problem
from gspcli.solver.starts import platform_starts
from gspcli.solver.starts.platform_starts import planar_starts, structure_start
from gspcli.solver.starts.solved_starts import OFTEN, SolvedStarts
from gspcli.solver.strategies import stored_start


def platform(rng, *, height=0.0):
    """Return a random platform whose bodies are planar but for a height of one point."""
    base, top = rng.uniform(-1, 1, (2, 6, 3)).round(6)
    base[:, 2] = top[:, 2] = 0
    top[0, 2] = height
    R, T = rotation_from_quaternion(rng.normal(size=4)), rng.uniform(-1, 1, 3)
    return hexapod(base, top, np.linalg.norm(top @ R.T + T - base, axis=1).round(6))


def test_paths_to_planar_platforms_begin_at_a_planar_one(monkeypatch):
    rng = np.random.default_rng(4)
    instances = [platform(rng) for _ in range(4)]
    with monkeypatch.context() as context:
        # Paths from the stored start.
        context.setattr(platform_starts, "planar_starts", lambda given: [])
        known = [solve(instance, starts=SolvedStarts()) for instance in instances]
    # Nothing but what planar starts give.
    monkeypatch.setattr(stored_start, "careful_paths", None)
    for instance, expected in zip(instances, known, strict=True):
        found = solve(instance, starts=SolvedStarts())
        assert found.verdict == "complete"
        assert found.proof == expected.proof
        for part in ("quaternions", "R", "T", "real"):
            np.testing.assert_array_equal(getattr(found, part), getattr(expected, part))


def test_each_start_leads_to_all_poses_in_pairs_of_mirror_images():
    problem = Problem(platform(np.random.default_rng(5)))
    starts = list(planar_starts(problem.arrangement.normalized))
    assert [len(start.points) for start in starts] == [40, 40]
    structure, coefficients = problem.equations
    targets = coefficients.g[:, list(structure.order)]
    for start in starts:
        np.testing.assert_array_equal(mirrored(start.points[:20]), start.points[20:])
        assert distinct(start.points)
        assert np.abs(start.system.values(start.points)).max() < 1e-12
        ends = ends_from_start(start, targets[0], SHORT_STEPS)
        proved = problem.proofs.decide(problem.choices, ends[None, None], problem.frames)
        assert proved.certified.sum() == 40


@pytest.mark.parametrize("what", ["height", "joints", "kinds"])
def test_others_have_no_planar_start(what):
    instance = platform(np.random.default_rng(6), height=1e-6 if what == "height" else 0.0)
    given = Problem(instance).arrangement.normalized
    if what == "height":
        # The base alone is planar, and has starts of its own.
        assert list(planar_starts(given))
        given.x[0, 2] = 1e-6
    elif what == "joints":
        given.y[0] = given.y[1]
    else:
        given = replace(given, kinds=(DPH, *given.kinds[1:]))
    assert not list(planar_starts(given))


@pytest.mark.parametrize("name", ["6PP", "3PP 2PH ALL"])
def test_where_a_structure_is_frequent_paths_begin_at_a_platform_of_it(name, monkeypatch):
    rng, starts = np.random.default_rng(8), SolvedStarts()
    instances = [random_instance(parse_type(name), rng)[0] for _ in range(OFTEN + 2)]
    known = [solve(instance, starts=SolvedStarts()) for instance in instances[OFTEN:]]
    for instance in instances[:OFTEN]:
        solve(instance, starts=starts)
    used = []
    start = structure_start(Problem(instances[0]).equations[0].canonical(), starts)
    follow = reduced_homotopy.ends_from_start

    def watched(given, *rest):
        used.append(given is start)
        return follow(given, *rest)

    monkeypatch.setattr(reduced_homotopy, "ends_from_start", watched)
    for instance, expected in zip(instances[OFTEN:], known, strict=True):
        found = solve(instance, starts=starts)
        assert found.proof == expected.proof
        for part in ("quaternions", "R", "T", "real"):
            np.testing.assert_array_equal(getattr(found, part), getattr(expected, part))
    assert all(used)


@pytest.mark.parametrize("name", ["5PP PL", "6D 5PP LL"])
def test_products_have_no_start_of_their_own(name):
    structure = Problem(random_instance(parse_type(name), np.random.default_rng(3))[0]).equations[0]
    starts = SolvedStarts()
    assert all(structure_start(structure.canonical(), starts) is None for _ in range(OFTEN + 1))
