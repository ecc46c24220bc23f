"""Sets of values of other sizes among those of a batch: each is solved as if it were alone."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from matching import pose_set_distance

from gspcli.catalogue.names import parse_type
from gspcli.continuation.tracked_paths import TrackedPaths
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.random_instances import random_instance
from gspcli.resources import instance_files
from gspcli.solver import solve, solve_batch
from gspcli.solver.all_poses import all_poses
from gspcli.solver.problem import Problem
from gspcli.solver.starts.start import start_among
from gspcli.solver.strategies import elimination, row_groups
from gspcli.spec import load

SETS = 10


@cache
def case(name: str = "DPP DPP DPP DPP DPP DPP"):
    """Return an instance, and sets of values."""
    instance, _ = random_instance(parse_type(name), np.random.default_rng(51), one_sided=True)
    own = np.array([row.value.value for row in instance.constraints])
    return instance, own * (1 + 0.05 * np.random.default_rng(52).normal(size=(SETS, 6)))


def given(instance: Instance, row: np.ndarray) -> Instance:
    return instance.with_values({i: Number.of(x) for i, x in enumerate(row.tolist())})


def times(instance: Instance, row: np.ndarray, factor: float) -> np.ndarray:
    distances = [constraint.kind.is_distance for constraint in instance.constraints]
    return np.where(distances, row * factor, row)


@pytest.mark.parametrize("factor", [1e6, 1e8, 1e-6, 1e-8])
def test_a_set_of_another_size_does_not_disturb_the_others(factor):
    instance, rows = case()
    mixed = rows.copy()
    mixed[4] = times(instance, mixed[4], factor)
    mixed[7] = np.inf
    batch = solve_batch(instance, mixed)
    assert batch.proved.tolist() == [k != 7 for k in range(SETS)]
    assert (batch.number[batch.proved] == 40).all()
    # Paths from the common start lead to all others.
    assert set(batch.others) <= {4, 7}
    single = solve(given(instance, mixed[4]))
    assert single.poses.proof is not None
    n, length = batch.number[4], single.arrangement.length
    assert batch.real[4].sum() == single.counts.real
    size = max(1.0, np.abs(single.R).max())
    found = batch.R[4, :n] / size, batch.T[4, :n] / size
    assert pose_set_distance(found, (single.R / size, single.T / size), length) < 1e-9


@pytest.mark.parametrize("name", ["DPP DPP DPP DPP DPP DPP", "DPP DPP DPP DPH DHP ALL"])
def test_sets_of_several_sizes_have_a_start_each(name, monkeypatch):
    instance, rows = case(name)
    factors = np.tile([1.0, 20.0], SETS // 2)
    mixed = np.array([times(instance, *each) for each in zip(rows, factors, strict=True)])
    sizes = []

    def counting(arrangement, group, *rest):
        sizes.append(len(group))
        return start_among(arrangement, group, *rest)

    monkeypatch.setattr(row_groups, "start_among", counting)
    batch = solve_batch(instance, mixed)
    assert sorted(sizes) == [SETS // 2] * 2
    assert batch.proved.all()
    assert not batch.others
    for factor in (1.0, 20.0):
        chosen = factors == factor
        alone = solve_batch(instance, mixed[chosen])
        np.testing.assert_array_equal(batch.R[chosen], alone.R)
        np.testing.assert_array_equal(batch.real[chosen], alone.real)


def test_a_start_that_proves_something_else_leaves_its_sets_to_others(monkeypatch):
    instance, rows = case()
    mixed = np.concatenate((rows[:5], 20 * rows[5:]))
    known = row_groups.start_among

    def unproved(arrangement, group, *rest):
        geometry = known(arrangement, group, *rest)
        if np.abs(group).max() > 10:
            object.__setattr__(geometry, "proof", None)
        return geometry

    monkeypatch.setattr(row_groups, "start_among", unproved)
    batch = solve_batch(instance, mixed)
    assert sorted(batch.others) == [5, 6, 7, 8, 9]
    assert batch.proved.all()


def watched(monkeypatch):
    """Return a list to which the digits of all paths with more than double precision are added."""
    track, digits = TrackedPaths.track, []

    def counting(*given, **options):
        digits.append(options["digits"])
        return track(*given, **options)

    monkeypatch.setattr(TrackedPaths, "track", counting)
    return digits


def test_poses_nearly_at_infinity_are_not_followed_with_the_most_digits(monkeypatch):
    instance, rows = case()
    digits = watched(monkeypatch)
    result = solve(given(instance, rows[0] * 1e8))
    assert (result.account.verdict, result.account.found) == ("complete", 40)
    assert result.poses.certified.all()
    assert 64 not in digits


def test_more_steps_find_what_stopped_paths_lead_to(monkeypatch):
    instance, rows = case()
    monkeypatch.setattr(elimination, "_MOST", 0)
    result = solve(given(instance, rows[2] * 1e6))
    assert (result.account.verdict, result.account.lost) == ("complete", 0)
    assert result.poses.proof is not None


def test_tripods_have_a_common_start():
    """Planes at distance zero have one side, and those at another distance both."""
    instance = load(instance_files()["three-rps"])
    own = np.array([row.value.value for row in instance.constraints])
    rows = np.tile(own, (12, 1))
    rows[:, :3] *= np.random.default_rng(2).uniform(0.95, 1.05, (12, 3))
    rows[4:8, 3] = 0.05
    rows[8:, 3:] = 0.03
    groups = row_groups.groups_of(Problem(instance), rows, all_poses)
    counts = {tuple(members): group.known_geometry_count for members, group in groups}
    assert [count and count.solutions for count in counts.values()] == [16, 32, 128]
    batch = solve_batch(instance, rows)
    assert batch.complete.all()
    for k in (1, 5, 9):
        alone = solve(given(instance, rows[k]))
        assert (batch.number[k], batch.real[k].sum()) == (alone.counts.found, alone.counts.real)
