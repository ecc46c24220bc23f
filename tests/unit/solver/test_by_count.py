"""Platforms whose numbers have no exact count: how far the count of their geometry goes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from gspcli import load
from gspcli.catalogue.kinds import ALL, DLL, DPH, DPL, DPP, KINDS_BY_NAME
from gspcli.catalogue.names import parse_type
from gspcli.certification.counting import count_geometry, exact_count
from gspcli.certification.counting.modular_platform import ModularPlatform
from gspcli.certification.poses.far_points import conjugate_sources
from gspcli.continuation.endpoints import clusters, infinite, may_coincide
from gspcli.continuation.tracked_paths import TrackedPaths
from gspcli.defaults import SEED
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side, Units
from gspcli.geometry.local_motions import real_statement
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Line, Plane, Point, vector
from gspcli.geometry.quaternions import study_from_pose
from gspcli.geometry.random_instances import random_instance
from gspcli.solver import by_count, solve
from gspcli.solver.by_count import _by_geometry, _different, _multiplicities, _proof
from gspcli.solver.poses import CountKind
from gspcli.solver.problem import Problem
from gspcli.solver.search import Search
from gspcli.solver.side_search import SideSearch
from gspcli.solver.solved_starts import SolvedStarts

ORIGIN, X, Y, Z = (vector(*v) for v in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)))
P = Point(ORIGIN)
EXAMPLES = Path(__file__).parents[3] / "data" / "examples"
#: More decimals of a degree than there are primes with this many roots of unity.
MANY_DIGITS = "0.1234567890123"


def instance(*rows: tuple[object, ...]) -> Instance:
    constraints = (
        Constraint(KINDS_BY_NAME[kind], platform, base, Number.of(value))
        for kind, platform, base, value in rows
    )
    return Instance(tuple(constraints), Units("m", AngleUnit.DEGREE))


def one_axis(value: str) -> Instance:
    """Two angles from one line of the base: half of the eight rotations."""
    angles = (("ALL", Line(ORIGIN, X), Line(ORIGIN, Z), 60 + float(value)),)
    angles += (("ALL", Line(ORIGIN, Y), Line(ORIGIN, Z), 50),)
    angles += (("ALL", Line(ORIGIN, Z), Line(ORIGIN, X), 70),)
    return instance(
        *angles, *(("DPP", P, Point(vector(*c)), 2) for c in ((0, 1, 0), (1, 0, 0), (0, 0, 1)))
    )


def test_as_many_poses_as_the_geometry_has_are_all() -> None:
    platform = one_axis(MANY_DIGITS)
    assert exact_count(platform) is None
    result = solve(platform)
    assert (result.verdict, result.counts.found, result.expected) == ("complete", 8, 16)
    assert result.proof is not None
    assert result.to_json()["proof"]["by"] == "geometry count"
    assert result.geometry_count == 8


def test_where_few_primes_leave_doubts_the_geometry_decides() -> None:
    platform = one_axis("0.123456789")
    count = exact_count(platform)
    assert count is not None
    assert count.error > 1e-9
    proof = solve(platform).proof
    assert proof is not None
    assert (proof.by, proof.error < 1e-9) == (CountKind.GEOMETRY, True)


def test_without_a_count_nothing_is_proved_to_be_at_infinity() -> None:
    result = solve(one_axis(MANY_DIGITS), prove=False)
    assert (result.verdict, result.counts.found, result.proof) == ("incomplete", 8, None)


@pytest.mark.parametrize(("second", "alone"), [((0, 1, 1), False), ((0, 2, 1), True)])
def test_lines_that_can_be_parallel_at_once_are_seen(second: tuple[int, ...], alone: bool) -> None:
    rows = [("DPP", Point(vector(k, k * k, 1)), Point(vector(k, 0, -k)), 3) for k in range(4)]
    first = ("DLL", Line(ORIGIN, Z), Line(ORIGIN, X), 1)
    other = (
        "DLL",
        Line(vector(1, 2, 0), vector(*second)),
        Line(vector(0, 1, 1), vector(1, -1, 0)),
        2,
    )
    platform = ModularPlatform(instance(*rows, first, other), SEED, values_free=True)
    assert platform.has_lone_lines == alone


def test_a_geometry_without_poses_for_most_values_proves_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    platform = load(EXAMPLES / "similar-hexagons.yaml")
    assert count_geometry(platform).solutions == 0
    monkeypatch.setattr("gspcli.solver.further._MOST_ATTEMPTS", 0)
    monkeypatch.setattr("gspcli.solver.further._MOST", 0)
    monkeypatch.setattr("gspcli.solver.by_count.exact_count", lambda *_, **__: None)
    assert solve(platform).verdict == "incomplete"


def test_large_general_platforms_are_not_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Some paths of 2 x 640 go wrong: with 32 digits they lead to what a count would ask for."""

    def refused(*_: object, **__: object) -> None:
        message = "this is not to be needed"
        raise AssertionError(message)

    monkeypatch.setattr(by_count, "exact_count", refused)
    platform, _ = random_instance(parse_type("6D PP PL PL PL LP HP"), np.random.default_rng(9))
    result = solve(platform)
    assert result.proof is not None
    assert result.proof.by is CountKind.TYPE
    assert len(result.R) == result.certified.sum() == result.expected == 1280


@pytest.mark.filterwarnings("error")
def test_the_end_of_a_lost_path_may_be_no_point() -> None:
    ends = np.array(
        [[0j] * 8, [np.nan] * 8, [1, 2j, 3, 4, 5, 6, 7j, 8], [1, -2j, 3, 4, 5, 6, -7j, 8]]
    )
    assert conjugate_sources(ends).tolist() == [0, 1, 2, 2]


def test_points_near_conjugates_are_no_conjugates() -> None:
    """Nearly parallel lines have pairs of poses, 1e-5 apart: of two of these, one was left out."""
    one = np.array([1, 2j, 3, 4, 5, 6, 7j, 8])
    other = (one * (1 + 1e-5 * np.arange(8))).conj()
    assert conjugate_sources(np.array([one, other, one.conj()])).tolist() == [0, 1, 0]


@pytest.mark.parametrize(("gap", "source"), [(0, 0), (1e-30, 0), (1e-20, 1), (1e-17, 1)])
def test_points_near_conjugates_in_further_digits_are_no_conjugates(gap, source) -> None:
    one = np.array([1, 2j, 3, 4, 5, 6, 7j, 8])
    low = np.zeros((2, 3, 8), complex)
    low[1, 0] = gap * np.arange(8)
    assert conjugate_sources(np.array([one, one.conj()]), low).tolist() == [0, source]


def test_many_paths_astray_are_not_followed_before_a_count(monkeypatch: pytest.MonkeyPatch) -> None:
    """Half of the paths end elsewhere, as with every special geometry."""

    def refused(*_: object, **__: object) -> None:
        raise AssertionError

    monkeypatch.setattr(TrackedPaths, "track", refused)
    monkeypatch.setattr(Problem, "geometry_count", None)
    problem = Problem(one_axis("0.5"))
    search = Search(problem)
    assert by_count._by_geometry_or_type(problem, search) is None
    assert not len(search)


def test_a_second_prime_confirms_a_count() -> None:
    platform = load(EXAMPLES / "congruent-platform.yaml")
    one, both = solve(platform, starts=SolvedStarts()), solve(platform, prove=True)
    assert one.proof is not None
    assert both.proof is not None
    assert 0 < both.proof.error < one.proof.error**1.5
    assert both.proof.by is one.proof.by


def test_a_second_prime_that_counts_otherwise_is_no_proof(monkeypatch: pytest.MonkeyPatch) -> None:
    platform = load(EXAMPLES / "congruent-platform.yaml")
    problem = Problem(platform, prove=True)
    poses = solve(platform)
    count = count_geometry(platform)
    fewer = replace(count, solutions=count.solutions - 8)
    monkeypatch.setattr(by_count, "geometry_count", lambda *_, **__: fewer)
    monkeypatch.setattr(by_count, "exact_count", lambda *_, **__: fewer)
    assert by_count.confirmed(problem, poses).proof is None


# What an answer must not claim: that near poses are one, that counts prove more than they do.


@pytest.mark.parametrize(
    ("gap", "known"), [(0.0, True), (1e-14, True), (1e-11, False), (1e-8, False)]
)
def test_an_end_beside_a_known_pose_is_looked_at(gap: float, known: bool) -> None:
    """Of two poses so near to each other the second would be missed."""
    arrangement = SimpleNamespace(length=1.0, restored=lambda R, T: T)
    side = SideSearch.__new__(SideSearch)
    side.problem = SimpleNamespace(arrangement=arrangement)
    R, T = np.eye(3, dtype=complex)[None], np.array([[0.5, 0.25, 1]], complex)
    entries = np.concatenate((R.reshape(1, 9), T), axis=1)
    side.poses = SimpleNamespace(entries=lambda _: entries)
    moved = T + gap * np.array([1, -1, 1])
    point = np.concatenate(study_from_pose(R, moved), axis=-1)
    assert side._near_known(point).tolist() == [[known]]


@pytest.mark.parametrize(
    ("share", "away"), [(0.01, True), (0.04, True), (0.06, False), (0.5, False), (3, False)]
)
def test_solutions_that_are_far_away_are_not_called_infinite(share: float, away: bool) -> None:
    """N is a share of the error: poses at 1e5 lengths have so small an N."""
    error = 1e-9
    e = np.array([1, 1j * np.sqrt(1 - share * error * np.sqrt(2)), 0, 0])
    point = np.concatenate((e, np.zeros(4)))[None]
    assert infinite(point, np.array([error])).tolist() == [away]


def test_ends_that_differ_by_less_than_their_errors_may_be_one() -> None:
    rng = np.random.default_rng(1)
    point = rng.normal(size=8) + 1j * rng.normal(size=8)
    point /= np.linalg.norm(point)
    other = rng.normal(size=8) + 1j * rng.normal(size=8)
    other -= (point.conj() @ other) * point
    other /= np.linalg.norm(other)
    for gap, errors, groups in (
        (0.5e-6, (1e-6, 1e-9), 1),
        (0.5e-6, (1e-9, 1e-6), 1),
        (2e-6, (1e-6, 1e-6), 2),
    ):
        pair = np.stack((point, np.cos(gap) * point + np.sin(gap) * other))
        assert len(clusters(pair, np.array(errors))) == groups
        near = may_coincide(pair[None], np.array([errors]))[1]
        assert near.all() or groups == 2


def search(**count: object) -> Search:
    found = Search.__new__(Search)
    known = SimpleNamespace(**{"solutions": 28, "has_lone_lines": True, "error": 1e-12, **count})
    found.problem = SimpleNamespace(expected=40, known_geometry_count=known)
    return found


def test_poses_are_all_if_the_type_or_the_geometry_has_as_many() -> None:
    assert search()._counted(40).by is CountKind.TYPE
    assert search()._counted(28).by is CountKind.GEOMETRY
    assert search()._counted(27) is None
    assert search()._counted(29) is None
    # Two pairs of lines that may be parallel at once hide solutions of the equations.
    assert search(has_lone_lines=False)._counted(28) is None
    poses = SimpleNamespace(certified=np.ones(28, bool), account=SimpleNamespace(expected=40))
    count = SimpleNamespace(solutions=28, has_lone_lines=True, error=1e-12)
    assert _by_geometry(poses, count).by is CountKind.GEOMETRY
    for changes in ({"solutions": 29}, {"has_lone_lines": False}):
        changed = SimpleNamespace(**{**vars(count), **changes})
        assert _by_geometry(poses, changed) is None
    poses.certified[3] = False
    assert _by_geometry(poses, count) is None


def test_multiplicities_are_those_that_the_counts_leave() -> None:
    def found(known: int, paths: list[int], solutions: int, distinct: int) -> list[int]:
        multiple = [SimpleNamespace(multiplicity=number) for number in paths]
        return _multiplicities(known, multiple, solutions, distinct)

    assert found(10, [2, 2], 14, 12) == [2, 2]
    assert found(10, [3], 13, 11) == [3]
    assert found(10, [3, 2], 15, 12) == [3, 2]
    # One more or one less than there are, and paths that do not add up.
    assert found(10, [2], 14, 12) == []
    assert found(10, [2, 2, 2], 14, 12) == []
    assert found(10, [3, 3], 15, 12) == []


PLATFORM, BASE = Point(vector(1, 2, 3)), Plane(vector(0, 0, 1), vector(0, 1, 1))


def test_constraints_that_differ_are_not_repeated() -> None:
    """Fewer than six equations have infinitely many solutions: only the same count as one."""
    row = Constraint(DPH, PLATFORM, BASE, Number.of("0.5"), Side.POSITIVE)
    assert len(_different([row, replace(row)])) == 1
    others = [
        replace(row, side=Side.NEGATIVE),
        replace(row, value=Number.of("0.50000000000000000001")),
        replace(row, platform=Point(vector(1, 2, 4))),
        replace(row, base=Plane(vector(0, 0, 1), vector(0, 1, 2))),
    ]
    assert len(_different([row, *others])) == 5


def test_only_ends_of_a_range_are_several_real_constraints() -> None:
    """A distance of zero is three planes; any other distance, however small, is itself."""
    line = Line(vector(0, 0, 1), vector(0, 1, 1))
    for kind, base, count in ((DPP, PLATFORM, 3), (DPL, line, 2)):
        for value, rows in (("0", count), ("1e-30", 1), ("2", 1)):
            given = Constraint(kind, PLATFORM, base, Number.of(value))
            assert len(real_statement(given, AngleUnit.DEGREE)) == rows
    for value, rows in (("0", 2), ("180", 2), ("90", 1), ("1e-9", 1), ("179.999", 1)):
        given = Constraint(ALL, line, line, Number.of(value))
        assert len(real_statement(given, AngleUnit.DEGREE)) == rows


def test_infinitely_many_solutions_are_no_poses_where_lines_are_parallel() -> None:
    """The equation of a DLL holds wherever its lines are parallel: only a part proves poses."""
    part = SimpleNamespace(error=1e-12)
    plain, lines = (
        SimpleNamespace(constraints=[SimpleNamespace(kind=kind)] * 6) for kind in (DPP, DLL)
    )
    for parts, error in (((None, None), None), ((None, part), 1e-12)):
        sides = [SimpleNamespace(infinite_part=one) for one in parts]
        count = SimpleNamespace(error=1e-20, sides=sides)
        assert _proof(plain, count).error == 1e-20
        found = _proof(lines, count)
        assert found is None if error is None else found.error == error
