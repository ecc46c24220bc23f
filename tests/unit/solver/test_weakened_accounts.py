"""What an answer must not claim: that near poses are one, that counts prove more than they do."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from gspcli.catalogue.kinds import ALL, DLL, DPH, DPL, DPP
from gspcli.continuation.endpoints import clusters, infinite, may_coincide
from gspcli.geometry.instance import AngleUnit, Constraint, Side
from gspcli.geometry.local_motions import real_statement
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Line, Plane, Point, vector
from gspcli.geometry.quaternions import study_from_pose
from gspcli.solver.by_count import _by_geometry, _different, _multiplicities, _proof
from gspcli.solver.poses import CountKind
from gspcli.solver.search import Search
from gspcli.solver.side_search import SideSearch


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
