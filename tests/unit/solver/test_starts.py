"""From where paths begin."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from gspcli import hexapod
from gspcli.catalogue.kinds import DPH
from gspcli.catalogue.names import parse_type
from gspcli.certification.equations.mirror_images import mirrored
from gspcli.continuation import reduced_homotopy
from gspcli.continuation.reduced_homotopy import LONG_STEPS, ReducedHomotopy, ends_from_start
from gspcli.continuation.start import distinct
from gspcli.continuation.tracker import DEFAULT, QUICK, PathStatus
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.geometry.random_instances import random_instance
from gspcli.resources import data_path
from gspcli.solver import all_poses, solve, solve_batch, solve_values
from gspcli.solver import start as start_module
from gspcli.solver.all_poses import first_poses, planar_starts, structure_start
from gspcli.solver.poses import CountKind
from gspcli.solver.problem import Problem
from gspcli.solver.solved_starts import OFTEN, STARTS, SolvedStarts, Sort
from gspcli.solver.start import Start, start_among, with_conjugates
from gspcli.spec import load
from tests.support.strategies import added, spoilt

# What is kept of solved platforms: inspected, cleared, passed; no answer depends on it.


NONE = dict.fromkeys(Sort, 0)


@cache
def platform(name: str):
    if name == "octahedral-3-3":
        return load(data_path("examples", f"{name}.yaml"))
    return random_instance(parse_type(name), np.random.default_rng(7))[0]


def rows_of(instance, number=6):
    own = np.array([row.value.value for row in instance.constraints])
    return own * (1 + 0.02 * np.random.default_rng(8).normal(size=(number, 6)))


def sizes(starts):
    return {sort: number for sort, number in starts.sizes.items() if number}


def test_of_each_sort_the_last_are_kept():
    starts, made = SolvedStarts(), []
    assert starts.sizes == NONE
    for k in range(70):
        starts.keep(Sort.COUNT, k, str(k))
        starts.fetch(Sort.COUNT, 0)
    assert starts.sizes == {**NONE, Sort.COUNT: 64}
    # What was used last, and what was kept last.
    assert starts.fetch(Sort.COUNT, 0) == "0"
    assert starts.fetch(Sort.COUNT, 1) is None
    assert starts.fetch(Sort.COUNT, 69) == "69"
    assert starts.fetch(Sort.PLATFORM, 69) is None
    for _ in range(2):
        # None is an answer, too: that nothing is known.
        assert starts.kept(Sort.COUNT, 1, lambda: made.append(1)) is None
    assert made == [1]
    starts.clear()
    assert starts.sizes == NONE


def test_a_start_that_is_kept_is_counted():
    starts = SolvedStarts()
    starts.keep(Sort.START, 1, 2)
    assert starts.sizes == dict.fromkeys(Sort, 0) | {Sort.START: 1}


def test_each_has_its_own():
    starts, others = SolvedStarts(), SolvedStarts()
    instance = platform("octahedral-3-3")
    STARTS.clear()
    for _ in range(2):
        solve(instance, starts=starts)
    special = {Sort.PLATFORM: 1, Sort.GEOMETRY: 1, Sort.COUNT: 1}
    assert sizes(starts) == sizes(starts) | special
    assert others.sizes == STARTS.sizes == NONE
    solve(instance)
    assert STARTS.sizes[Sort.PLATFORM] == 1


@pytest.mark.parametrize("call", [solve_batch, lambda *a, **k: list(solve_values(*a, **k))])
def test_batches_keep_what_they_solve_in_what_they_are_given(call):
    starts, instance = SolvedStarts(), platform("6PP")
    STARTS.clear()
    call(instance, rows_of(instance), starts=starts)
    kept = sizes(starts)
    assert set(kept) == {Sort.GEOMETRY}
    assert STARTS.sizes == NONE
    call(instance, rows_of(instance), starts=starts)
    assert sizes(starts) == kept


def test_nothing_is_remembered_elsewhere(monkeypatch):
    """After all was forgotten a call does what the first one did."""
    instance, seen = platform("octahedral-3-3"), []
    starts = SolvedStarts()

    def watched(kind):
        function = getattr(SolvedStarts, kind)

        def call(self, *given):
            found = function(self, *given)
            seen.append((kind, given[0], found is None))
            return found

        monkeypatch.setattr(SolvedStarts, kind, call)

    watched("fetch")
    watched("keep")
    calls = []
    for again in (False, False, True):
        if again:
            starts.clear()
        seen.clear()
        solve(instance, starts=starts)
        calls.append(list(seen))
    first, second, cleared = calls
    assert cleared == first != second


def test_importing_keeps_nothing():
    code = "from gspcli.solver.solved_starts import STARTS as s; print(sum(s.sizes.values()))"
    run = subprocess.run(
        [sys.executable, "-c", f"import gspcli; gspcli.solve; {code}"],
        capture_output=True,
        text=True,
        check=True,
        env=os.environ,
    )
    assert run.stdout.strip() == "0"


# Planar platforms, a new geometry each time, from a solved one with complex values.


def random_bodies(rng, *, height=0.0):
    """Return a random platform whose bodies are planar but for a height of one point."""
    base, top = rng.uniform(-1, 1, (2, 6, 3)).round(6)
    base[:, 2] = top[:, 2] = 0
    top[0, 2] = height
    R, T = rotation_from_quaternion(rng.normal(size=4)), rng.uniform(-1, 1, 3)
    return hexapod(base, top, np.linalg.norm(top @ R.T + T - base, axis=1).round(6))


def test_paths_to_planar_platforms_begin_at_a_planar_one(monkeypatch):
    rng = np.random.default_rng(4)
    instances = [random_bodies(rng) for _ in range(4)]
    with monkeypatch.context() as context:
        # Paths from the stored start.
        context.setattr(all_poses, "planar_starts", lambda given: [])
        known = [solve(instance, starts=SolvedStarts()) for instance in instances]
    # Nothing but what planar starts give.
    monkeypatch.setattr(all_poses, "careful_paths", None)
    for instance, expected in zip(instances, known, strict=True):
        found = solve(instance, starts=SolvedStarts())
        assert found.verdict == "complete"
        assert found.proof == expected.proof
        for part in ("quaternions", "R", "T", "real"):
            np.testing.assert_array_equal(getattr(found, part), getattr(expected, part))


def test_each_start_leads_to_all_poses_in_pairs_of_mirror_images():
    problem = Problem(random_bodies(np.random.default_rng(5)))
    starts = list(planar_starts(problem.arrangement.normalized))
    assert [len(start.points) for start in starts] == [40, 40]
    structure, coefficients = problem.equations
    targets = coefficients.g[:, list(structure.order)]
    for start in starts:
        np.testing.assert_array_equal(mirrored(start.points[:20]), start.points[20:])
        assert distinct(start.points)
        assert np.abs(start.system.values(start.points)).max() < 1e-12
        ends = ends_from_start(start, targets[0], DEFAULT)
        proved, _ = problem.proofs.decide(problem.choices, ends[None, None], problem.frames)
        assert proved.certified.sum() == 40


@pytest.mark.parametrize("what", ["height", "joints", "kinds"])
def test_others_have_no_planar_start(what):
    instance = random_bodies(np.random.default_rng(6), height=1e-6 if what == "height" else 0.0)
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


# The first paths of a platform: the quickest where all ends are proved, careful ones else.


PARTS = ("quaternions", "R", "T", "real")


@pytest.fixture(scope="module")
def one_platform():
    return random_instance(parse_type("5PP PL"), np.random.default_rng(3))[0]


def refused(*_, **__):
    message = "this is not to be needed"
    raise AssertionError(message)


def test_proved_ends_of_quick_paths_are_the_answer(one_platform, monkeypatch):
    monkeypatch.setattr(Problem, "tracked", property(refused))
    found = solve(one_platform, starts=SolvedStarts())
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

    def spoil(ends):
        # With a pair of conjugates each pose of which is lost.
        ends.points[..., :30, :] = ends.points[..., 30:31, :]
        ends.points[..., 31, :] = np.nan

    for quick in ("quick_paths", "reduced_paths"):
        monkeypatch.setattr(all_poses, quick, spoilt(getattr(all_poses, quick), spoil))
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
    monkeypatch.setattr(all_poses, "reduced_paths", lambda _: None)

    def spoil(ends):
        ends.points[..., :lost, :] = np.nan

    careful = spoilt(all_poses.careful_paths, spoil)
    monkeypatch.setattr(all_poses, "careful_paths", careful)
    found = solve(given, starts=SolvedStarts())
    assert found.proof == known.proof
    for part in PARTS:
        np.testing.assert_array_equal(getattr(found, part), getattr(known, part))


def test_platforms_without_products_have_quicker_paths():
    legs = random_instance(parse_type("6PP"), np.random.default_rng(3))[0]
    problem = Problem(legs, starts=SolvedStarts())
    assert added(all_poses.quick_paths, problem) == []
    [ends] = added(all_poses.reduced_paths, problem)[:1]
    assert ends.points.shape == (1, 1, 40, 8)


# Members of a start among many sets of values, against its first system.


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
    near, far = (ends[0][:, 0] for ends in (start.quick_ends(rows), start.short_ends(rows)))
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
        given = parameters.astype(complex), each._nearest(parameters), QUICK, 1
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
        if options is LONG_STEPS:
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
