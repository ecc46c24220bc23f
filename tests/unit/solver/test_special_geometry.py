"""Platforms of special geometries are followed from a start of their own, proved by its count."""

from dataclasses import replace

import numpy as np
import pytest

from gspcli.certification import counting
from gspcli.geometry.numbers import Number
from gspcli.resources import data_path
from gspcli.solver import solve, special_geometry
from gspcli.solver.geometry_start import StartMethod, geometry_start
from gspcli.solver.proof import CountKind
from gspcli.spec import load

SPECIAL = {
    ("platforms", "nano-hexapod"): 28,
    ("platforms", "linuxcnc-hexapod"): 16,
    ("platforms", "sdss-primary"): 12,
    ("examples", "congruent-platform"): 24,
    ("examples", "platform-6-4"): 32,
}


def platform(folder, name):
    return load(data_path(folder, f"{name}.yaml"))


@pytest.mark.parametrize(("folder", "name"), SPECIAL)
def test_as_many_proved_poses_as_the_geometry_has_are_all(folder, name):
    instance = platform(folder, name)
    found, known = solve(instance), counting.exact_count(instance)
    assert found.verdict == "complete"
    assert found.proof.by is CountKind.GEOMETRY
    assert 0 <= found.proof.error < 1e-9
    assert len(found.R) == found.certified.sum() == SPECIAL[folder, name] == known.solutions
    assert found.geometry_count == known.solutions
    assert found.account.at_infinity == found.expected - known.solutions
    assert found.residuals.max() < 1e-9 * found.arrangement.length


def test_what_is_kept_changes_no_bit(monkeypatch):
    instance = platform("platforms", "simscape-hexapod")
    solve(instance)  # The first one of a geometry may make no start.
    first = solve(instance)
    monkeypatch.setattr(counting, "geometry_count", None)
    again = solve(platform("platforms", "simscape-hexapod"))
    assert again.proof == first.proof
    for part in ("quaternions", "R", "T", "real"):
        np.testing.assert_array_equal(getattr(again, part), getattr(first, part))


@pytest.mark.parametrize("name", ["singular-pose", "point-on-line"])
def test_the_count_of_a_geometry_is_told_of_its_platforms(name, monkeypatch):
    instance = platform("examples", name)
    first = solve(instance)
    assert first.proof.by is CountKind.EXACT
    assert first.geometry_count == counting.geometry_count(instance).solutions
    if name == "singular-pose":  # Where a distance is zero nothing is kept.
        monkeypatch.setattr(counting, "geometry_count", None)
    assert solve(instance).geometry_count == first.geometry_count


def test_a_start_that_lacks_a_solution_proves_nothing(monkeypatch):
    instance = platform("examples", "octahedral-3-3")
    known = solve(instance)

    def lacking(*about, **how):
        start = geometry_start(*about, **how)
        if start is None:
            return None
        pool = replace(start.pool, points=start.pool.points[:, 1:])
        return replace(start, points=start.points[1:], pool=pool)

    geometry_start.cache_clear()
    monkeypatch.setattr("gspcli.solver.one_geometry.geometry_start", lacking)
    found = solve(instance)
    geometry_start.cache_clear()
    assert found.proof == known.proof
    assert len(found.R) == len(known.R) == 16


@pytest.mark.parametrize("name", ["linuxcnc-hexapod", "sdss-primary"])
def test_the_first_of_a_geometry_needs_neither_a_start_nor_an_exact_count(name, monkeypatch):
    ways = []

    def seen(*about, way, solved):
        ways.append(way)
        return geometry_start(*about, way=way, solved=solved)

    def counted(*_, **__):
        raise AssertionError

    special_geometry._visits.cache_clear()
    monkeypatch.setattr("gspcli.solver.one_geometry.geometry_start", seen)
    monkeypatch.setattr("gspcli.solver.special.exact_count", counted)
    first = solve(platform("platforms", name))
    assert set(ways) == {StartMethod.FLAT}
    second = solve(platform("platforms", name))
    assert StartMethod.SOLVED in ways
    assert StartMethod.QUICK not in ways
    assert first.proof == second.proof
    assert len(first.R) == len(second.R) == SPECIAL["platforms", name]


@pytest.mark.parametrize("name", ["linuxcnc-hexapod", "sdss-primary"])
def test_a_start_from_a_solved_platform_has_the_solutions_of_any_other(name, monkeypatch):
    starts = {}

    def each(*about, way, solved):
        start = geometry_start(*about, way=way, solved=solved)
        if way is StartMethod.SOLVED:
            starts.update(
                {way: start, StartMethod.CAREFUL: geometry_start(*about, way=StartMethod.CAREFUL)}
            )
        return start

    special_geometry._visits.cache_clear()
    monkeypatch.setattr("gspcli.solver.one_geometry.geometry_start", each)
    for _ in range(2):
        solve(platform("platforms", name))
    found, known = (
        start.points for start in (starts[StartMethod.SOLVED], starts[StartMethod.CAREFUL])
    )
    found, known = (x / np.linalg.norm(x, axis=1, keepdims=True) for x in (found, known))
    # The points are the same up to factors: each has one of the other at a cosine of one.
    near = np.abs(found.conj() @ known.T) > 1 - 1e-9
    assert len(found) == len(known)
    assert near.sum(axis=0).tolist() == near.sum(axis=1).tolist() == [1] * len(known)


def test_poses_of_which_two_are_the_same_are_no_start():
    instance = platform("examples", "octahedral-3-3")
    special_geometry._visits.cache_clear()
    known = solve(instance)
    [visits] = [special_geometry._visits(special_geometry._rows(instance))]
    arrangement, poses = visits.first
    # Two paths from one pose meet.
    visits.first = arrangement, poses.reordered(np.array([0, 0, *range(2, len(poses.R))]))
    assert solve(instance).proof == known.proof
    assert len(solve(instance).R) == len(known.R)


def test_nearly_special_platforms_are_proved_by_their_geometry_too(monkeypatch):
    # Of its 36 poses doubles can prove 28.
    monkeypatch.setattr("gspcli.solver.special.exact_count", lambda *_, **__: None)
    found = solve(platform("platforms", "rubin-camera"))
    assert found.proof.by is CountKind.GEOMETRY
    assert len(found.R) == found.certified.sum() == 36


def test_values_of_zero_and_platforms_not_to_be_counted_go_other_ways():
    instance = platform("examples", "octahedral-3-3")
    assert solve(instance, prove=False).proof is None
    zero = instance.with_values({0: Number.of(0)})
    assert special_geometry.proved_by_geometry(*given(zero), seed=1, limit=2.0) is None
    special_geometry._visits.cache_clear()
    found = [special_geometry.proved_by_geometry(*given(instance), seed=1, limit=2.0) for _ in "12"]
    assert [poses is None for poses in found] == [True, False]


def given(instance):
    from gspcli.certification.poses.many_values import ValueProofs
    from gspcli.geometry.arrangement import Arrangement

    return instance, ValueProofs.of(instance, None), Arrangement.of(instance)


def test_a_count_of_the_geometry_that_proves_nothing_is_followed_by_that_of_the_platform(
    monkeypatch,
):
    count = special_geometry.kept_count
    monkeypatch.setattr(special_geometry, "proved_by_geometry", lambda *_, **__: None)
    monkeypatch.setattr(
        "gspcli.solver.special.kept_count", lambda *about: replace(count(*about), error=1.0)
    )
    found = solve(platform("examples", "octahedral-3-3"))
    assert found.proof.by is CountKind.EXACT
    assert len(found.R) == found.certified.sum() == 16
