"""Members of a start among many sets of values, against its first system."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from gspcli.catalogue.names import parse_type
from gspcli.continuation.reduced_homotopy import ReducedHomotopy
from gspcli.continuation.tracker import PathStatus
from gspcli.continuation.tracker_options import VALUE_STEPS
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.random_instances import random_instance
from gspcli.solver import solve_batch, solve_values
from gspcli.solver.all_poses import first_poses
from gspcli.solver.problem import Problem
from gspcli.solver.starts import start as start_module
from gspcli.solver.starts.solved_starts import SolvedStarts
from gspcli.solver.starts.start import Start, start_among, with_conjugates

SETS = 160


@cache
def case(name: str = "DPP DPP DPP DPP DPP DPP"):
    """Return an instance, sets of values, and a start with members for them."""
    instance, _ = random_instance(parse_type(name), np.random.default_rng(41), one_sided=True)
    own = np.array([row.value.value for row in instance.constraints])
    rows = own * (1 + 0.1 * np.random.default_rng(42).normal(size=(SETS, 6)))
    return instance, rows, start_of(instance, rows)


def start_of(instance: Instance, rows: np.ndarray) -> Start:
    arrangement, starts = Arrangement.of(instance), SolvedStarts()
    found = start_among(arrangement, rows, lambda: None, 1, 1, starts)
    assert found is not None
    return found


def _first_of(start: Start) -> Start:
    """Return a start without members."""
    return replace(start, parameters=start.parameters[:1], reduced=start.reduced[:1])


def _overlaps(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    a, b = (z / np.linalg.norm(z, axis=-1, keepdims=True) for z in (a, b))
    return np.abs(a.conj() @ b.swapaxes(1, 2))


@pytest.mark.parametrize("name", ["DPP DPP DPP DPP DPP DPP", "DPP DPP DPP DPH DHP ALL"])
def test_paths_from_the_pool_end_where_those_from_the_start_do(name):
    _, rows, start = case(name)
    assert len(start.parameters) == 1 + SETS // 32
    near, far = start.quick_ends(rows).points[:, 0], start.short_ends(rows).points[:, 0]
    found = np.isfinite(near).all(axis=(1, 2)) & np.isfinite(far).all(axis=(1, 2))
    assert found.mean() > 0.9
    # Each end of one is an end of the other.
    same = _overlaps(near[found], far[found]) > 1 - 1e-9
    assert (same.sum(axis=1) == 1).all()
    assert (same.sum(axis=2) == 1).all()


def test_paths_from_the_pool_are_shorter():
    _, rows, start = case()
    parameters = start._parameters(rows)
    steps = []
    for each in (start, _first_of(start)):
        given = parameters.astype(complex), each._nearest(parameters), VALUE_STEPS, 1
        steps.append(each._track(*given).steps.mean())
    assert steps[0] < 0.8 * steps[1]


def test_the_nearest_member_is_taken():
    _, rows, start = case()
    members, parameters = start.parameters[1:].real, start._parameters(rows)
    far = ((parameters[:, None] - members) / start.unit) ** 2
    np.testing.assert_array_equal(start._nearest(parameters), 1 + far.sum(axis=2).argmin(axis=1))
    # Each member is one of the sets.
    assert len(np.unique(start._nearest(members))) == len(members)


def test_few_sets_start_from_the_geometry():
    instance, rows, _ = case()
    start = start_of(instance, rows[:100])
    assert len(start.parameters) == 1
    assert not start._nearest(start._parameters(rows)).any()


@pytest.mark.parametrize("wrong", ["lost", "jumped"])
def test_members_whose_paths_went_wrong_are_left_out(wrong, monkeypatch):
    _, rows, start = case()
    follow = Start._track

    def spoiled(*given):
        ends = follow(*given)
        if wrong == "lost":
            ends.status[1, 7] = PathStatus.FAILED
        else:
            ends.study[1, 7] = 2j * ends.study[1, 8]
        return ends

    monkeypatch.setattr(Start, "_track", spoiled)
    found = _first_of(start).among(rows, 1)
    np.testing.assert_array_equal(found.parameters, np.delete(start.parameters, 2, axis=0))


def test_what_long_steps_lose_is_found_by_short_ones(monkeypatch):
    instance, rows, start = case()
    track = ReducedHomotopy.track
    tolerances = []

    def losing(*given, options, jobs):
        ends = track(*given, options=options, jobs=jobs)
        tolerances.append(options.predictor_tolerance)
        if options is VALUE_STEPS:
            ends.status[2, 3] = PathStatus.FAILED
        return ends

    monkeypatch.setattr(ReducedHomotopy, "track", losing)
    monkeypatch.setattr(start_module, "track", None)  # the paths of the equations as they are
    problem = Problem(instance, Arrangement.of(instance), rows=rows[:4])
    problem.start = start
    assert not len(first_poses(problem).left)
    assert len(tolerances) == 2
    assert tolerances[1] < tolerances[0]


def test_lost_ends_are_conjugates_of_ends_without_one():
    rng = np.random.default_rng(3)
    (a, b, c), d = np.moveaxis(rng.normal(size=(2, 3, 8)), 0, -1) @ [1, 1j], rng.normal(size=8)
    row = np.array([a, a.conj(), b, d * 1j, c])
    lost = np.full(8, np.nan)
    study = np.array([[2j * b, lost, d, a, a.conj()], [lost] * 5, row, [a, b, lost, c, d]])
    ends = with_conjugates(study.copy())
    np.testing.assert_allclose(_overlaps(ends[:1, 1:2], b.conj()[None, None]), 1)
    np.testing.assert_array_equal(ends[1:3], study[1:3])  # None are there; none are lost.
    assert np.isfinite(ends[3]).all()  # One of three candidates: what it is must be proved.
    kept = np.isfinite(study)
    np.testing.assert_array_equal(ends[kept], study[kept])


def test_long_steps_end_as_near_to_the_poses_as_short_ones():
    instance, rows, start = case()
    batch = solve_batch(instance, rows)
    lengths = np.array([start.given.length_with(row) for row in rows])
    size = np.maximum(1, np.abs(batch.R).max(axis=(2, 3)))
    size += np.abs(batch.T).max(axis=2) / lengths[:, None]
    # Relative to what the largest numbers in the equations are.
    assert np.nanmax(batch.residuals / lengths[:, None] / size**2) < 1e-11


def test_threads_and_pools_give_the_same_poses():
    instance, rows, _ = case()
    alone, shared = (list(solve_values(instance, rows, jobs=jobs)) for jobs in (1, 2))
    for a, b in zip(alone, shared, strict=True):
        np.testing.assert_array_equal(a.R, b.R)
        assert a.proof is not None
