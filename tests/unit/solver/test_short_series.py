"""The first paths of a platform: the quickest where all ends are proved, careful ones else."""

import numpy as np
import pytest

from gspcli.catalogue.names import parse_type
from gspcli.geometry.random_instances import random_instance
from gspcli.solver import solve
from gspcli.solver.problem import Problem
from gspcli.solver.results.proof import CountKind
from gspcli.solver.starts.solved_starts import SolvedStarts
from gspcli.solver.strategies import stored_start

PARTS = ("quaternions", "R", "T", "real")


@pytest.fixture(scope="module")
def platform():
    return random_instance(parse_type("5PP PL"), np.random.default_rng(3))[0]


def refused(*_, **__):
    message = "this is not to be needed"
    raise AssertionError(message)


def test_proved_ends_of_short_series_are_the_answer(platform, monkeypatch):
    monkeypatch.setattr(Problem, "tracked", property(refused))
    found = solve(platform, starts=SolvedStarts())
    assert found.proof.by is CountKind.TYPE
    assert len(found.R) == found.certified.sum() == found.expected == 80
    assert found.residuals.max() < 1e-8


def test_mutual_moments_are_proved_too_without_being_asked(monkeypatch):
    """Paths that are judged by eye take three times as long."""
    monkeypatch.setattr(Problem, "tracked", property(refused))
    legs = random_instance(parse_type("6D 4PP PL LL"), np.random.default_rng(5))[0]
    found = solve(legs)
    assert found.proof.by is CountKind.TYPE
    assert len(found.R) == found.certified.sum() == found.expected


@pytest.mark.parametrize("name", ["5PP PL", "6PP"])
def test_what_is_not_proved_is_found_by_careful_paths(name, monkeypatch):
    given = random_instance(parse_type(name), np.random.default_rng(3))[0]
    known = solve(given, starts=SolvedStarts())

    def spoilt(ways):
        def ends(problem):
            for found in ways(problem):
                # With a pair of conjugates each pose of which is lost.
                found.points[..., :30, :] = found.points[..., 30:31, :]
                found.points[..., 31, :] = np.nan
                yield found

        return ends

    for quick in ("short_series", "reduced_paths"):
        monkeypatch.setattr(stored_start, quick, spoilt(getattr(stored_start, quick)))
    careful = []
    monkeypatch.setattr(
        Problem, "tracked", property(lambda problem: careful.append(1) or tracked(problem))
    )
    found = solve(given, starts=SolvedStarts())
    assert careful
    assert found.proof == known.proof
    assert found.proof.by is CountKind.TYPE
    for part in PARTS:
        np.testing.assert_array_equal(getattr(found, part), getattr(known, part))


def tracked(problem):
    from gspcli.continuation.tracked_paths import track_all

    return list(track_all(problem.systems, seed=problem.seed, jobs=problem.jobs))


@pytest.mark.parametrize("lost", [1, 40])
def test_poses_that_every_first_path_misses_are_found_with_more_digits(lost, monkeypatch):
    given = random_instance(parse_type("6PP"), np.random.default_rng(5))[0]
    known = solve(given, starts=SolvedStarts())
    monkeypatch.setattr(stored_start, "reduced_paths", lambda _: iter(()))

    def careful(problem):
        for found in careful_paths(problem):
            found.points[..., :lost, :] = np.nan
            yield found

    careful_paths = stored_start.careful_paths
    monkeypatch.setattr(stored_start, "careful_paths", careful)
    found = solve(given, starts=SolvedStarts())
    assert found.proof == known.proof
    for part in PARTS:
        np.testing.assert_array_equal(getattr(found, part), getattr(known, part))


def test_platforms_without_products_have_quicker_paths():
    legs = random_instance(parse_type("6PP"), np.random.default_rng(3))[0]
    problem = Problem(legs, starts=SolvedStarts())
    assert list(stored_start.short_series(problem)) == []
    [ends] = stored_start.reduced_paths(problem)
    assert ends.points.shape == (1, 1, 40, 8)
