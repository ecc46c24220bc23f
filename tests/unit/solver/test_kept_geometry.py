"""Platforms of special geometries are followed from a start of their own, proved by its count."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from gspcli.catalogue.kinds import DPL
from gspcli.certification import counting
from gspcli.continuation.tracked_paths import TrackedPaths
from gspcli.geometry.building import hexapod
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Line, Point
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.resources import data_path
from gspcli.solver import by_count, further, solve, solve_batch
from gspcli.solver.api import many_poses
from gspcli.solver.kept_geometry import kept_start
from gspcli.solver.poses import CountKind
from gspcli.solver.problem import Problem
from gspcli.solver.solved_starts import STARTS, SolvedStarts, Sort
from gspcli.solver.start import Start, StartMethod, solved_start
from gspcli.spec import load
from tests.support.matching import pose_set_distance
from tests.support.realistic import machines
from tests.support.special import platforms as special

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
        start = solved_start(*about, **how)
        if start is None:
            return None
        return replace(start, points=start.points[1:], reduced=start.reduced[:, 1:])

    monkeypatch.setattr("gspcli.solver.start.solved_start", lacking)
    starts = SolvedStarts()
    for _ in range(2):
        found = solve(instance, starts=starts)
        assert found.proof == known.proof
        assert len(found.R) == len(known.R) == 16


@pytest.mark.parametrize("name", ["linuxcnc-hexapod", "sdss-primary"])
def test_the_first_of_a_geometry_needs_neither_a_start_nor_an_exact_count(name, monkeypatch):
    ways = []

    def seen(*about, way, solved):
        ways.append(way)
        return solved_start(*about, way=way, solved=solved)

    def counted(*_, **__):
        raise AssertionError

    STARTS.clear()
    monkeypatch.setattr("gspcli.solver.start.solved_start", seen)
    monkeypatch.setattr("gspcli.solver.by_count.exact_count", counted)
    first = solve(platform("platforms", name))
    assert not ways
    second = solve(platform("platforms", name))
    assert ways == [StartMethod.SOLVED]
    assert first.proof == second.proof
    assert len(first.R) == len(second.R) == SPECIAL["platforms", name]


@pytest.mark.parametrize("name", ["linuxcnc-hexapod", "sdss-primary"])
def test_a_start_from_a_solved_platform_has_the_solutions_of_any_other(name, monkeypatch):
    starts = {}

    def each(*about, way, solved):
        start = solved_start(*about, way=way, solved=solved)
        if way is StartMethod.SOLVED:
            starts.update(
                {way: start, StartMethod.CAREFUL: solved_start(*about, way=StartMethod.CAREFUL)}
            )
        return start

    STARTS.clear()
    monkeypatch.setattr("gspcli.solver.start.solved_start", each)
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
    starts = SolvedStarts()
    known = solve(instance, starts=starts)
    kept = starts.platform(known.arrangement)
    poses = kept.poses
    # Two paths from one pose meet.
    twice = poses[[0, 0, *range(2, len(poses.R))]]
    wrong = SolvedStarts()
    wrong.keep_platform(kept._replace(poses=twice))
    for _ in range(2):
        found = solve(instance, starts=wrong)
        assert found.proof == known.proof
        assert len(found.R) == len(known.R)


def test_nearly_special_platforms_are_proved_by_their_geometry_too(monkeypatch):
    # Of its 36 poses doubles can prove 28.
    monkeypatch.setattr("gspcli.solver.by_count.exact_count", lambda *_, **__: None)
    found = solve(platform("platforms", "rubin-camera"))
    assert found.proof.by is CountKind.GEOMETRY
    assert len(found.R) == found.certified.sum() == 36


def test_values_of_zero_and_platforms_not_to_be_counted_go_other_ways():
    instance, starts = platform("examples", "octahedral-3-3"), SolvedStarts()
    assert solve(instance, prove=False, starts=starts).proof is None
    assert kept_start(Problem(instance, starts=starts)) is None
    zero = instance.with_values({0: Number.of(0)})
    solve(zero, starts=starts)
    assert starts.platform(Problem(zero).arrangement) is None
    solve(instance, starts=starts)
    assert kept_start(Problem(instance, starts=starts)).found == 16
    assert not Problem(instance, prove=False, starts=starts).has_kept_geometry
    assert not Problem(zero, starts=starts).has_kept_geometry


def test_a_count_of_the_geometry_that_proves_nothing_is_followed_by_that_of_the_platform(
    monkeypatch,
):
    count = counting.geometry_count
    for room in (counting, by_count):
        monkeypatch.setattr(
            room, "geometry_count", lambda *about, **how: replace(count(*about, **how), solutions=0)
        )
    found = solve(platform("examples", "octahedral-3-3"), starts=SolvedStarts())
    assert found.proof.by is CountKind.EXACT
    assert len(found.R) == found.certified.sum() == 16


def test_far_poses_need_no_paths(monkeypatch):
    # 28 poses are near; 12 are so far away that doubles find none of them.
    instance, starts = platform("platforms", "reachy-mini-head"), SolvedStarts()
    first = solve(instance, starts=starts)
    assert kept_start(Problem(instance, starts=starts)).points.shape == (28, 8)

    def nothing_else(*_):
        raise AssertionError

    monkeypatch.setattr("gspcli.solver.all_poses.reduced_paths", nothing_else)
    again = solve(instance, starts=starts)
    assert again.proof == first.proof
    for part in ("quaternions", "R", "T", "real"):
        np.testing.assert_array_equal(getattr(again, part), getattr(first, part))
    rows = np.array([row.value.value for row in instance.constraints]) * np.linspace(
        0.9, 1.1, 16
    ).reshape(-1, 1)
    batch = solve_batch(instance, rows, starts=starts)
    assert batch.proved.all()
    assert not batch.others


def drawn(number):
    """Return a realistic machine, and other sets of values."""
    machine = next(machines(number + 1, rows=32, begin=number))
    return machine.instance, machine.rows


#: Four legs and two distances from lines: 144 poses are near, 16 far away.
RODS = (102, 377)


@pytest.mark.parametrize("number", RODS)
def test_far_poses_of_machines_with_lines_need_no_paths(number, monkeypatch):
    (instance, rows), starts = drawn(number), SolvedStarts()
    first = solve(instance, starts=starts)
    assert len(kept_start(Problem(instance, starts=starts)).points) == 144

    def nothing_else(*_, **__):
        raise AssertionError

    for way in ("quick_paths", "careful_paths"):
        monkeypatch.setattr(f"gspcli.solver.all_poses.{way}", nothing_else)
    again = solve(instance, starts=starts)
    assert again.proof == first.proof
    assert again.proof.by is CountKind.TYPE
    for part in ("quaternions", "R", "T", "real"):
        np.testing.assert_array_equal(getattr(again, part), getattr(first, part))
    batch = solve_batch(instance, rows, starts=starts)
    assert batch.proved.all()
    assert (batch.number == 160).all()
    assert not batch.others


def test_a_special_geometry_with_lines_is_counted_once(monkeypatch):
    """Two planar, symmetric bodies, and one distance from a line: 72 poses instead of 80."""
    base = [(3, 1, 0), (-3, 1, 0), (3, -1, 0), (-3, -1, 0), (0, 2, 0), (0, -2, 0)]
    joints = [(2, 1, 0), (-2, 1, 0), (2, -1, 0), (-2, -1, 0), (0, 1, 0), (0, -1, 0)]
    plain = hexapod(base, joints, ["1.2", "1.3", "1.25", "1.35", "1.1", "1.15"])
    *legs, last = plain.constraints
    line = Line(last.base.position, tuple(map(Number.of, (1, 0, 0))))
    instance = replace(plain, constraints=(*legs, replace(last, kind=DPL, base=line)))
    starts = SolvedStarts()
    first = solve(instance, starts=starts)
    assert first.proof.by is CountKind.GEOMETRY
    assert len(first.R) == first.certified.sum() == 72
    assert counting.exact_count(instance).solutions == 72

    def counted(*_, **__):
        raise AssertionError

    monkeypatch.setattr(by_count, "exact_count", counted)
    monkeypatch.setattr(counting, "geometry_count", counted)
    other = instance.with_values({0: Number.of("1.31")})
    found = solve(other, starts=starts)
    assert found.proof == first.proof
    assert len(found.R) == 72


def test_far_poses_of_another_geometry_are_not_used():
    # The same in doubles, but not the same platform.
    instance, starts = platform("platforms", "reachy-mini-head"), SolvedStarts()
    solve(instance, starts=starts)
    first = instance.constraints[0]
    point = first.platform.position
    moved = replace(
        first.platform, position=(Number.of(point[0].fraction + Fraction(1, 10**30)), *point[1:])
    )
    other = replace(
        instance, constraints=(replace(first, platform=moved), *instance.constraints[1:])
    )
    assert starts.platform(Problem(other).arrangement) is not None
    assert kept_start(Problem(other, starts=starts)) is None
    assert kept_start(Problem(instance, starts=starts)) is not None


def test_a_count_that_disagrees_proves_nothing_of_far_poses():
    instance, starts = platform("platforms", "rubin-camera"), SolvedStarts()
    known = solve(instance, starts=starts)
    kept = starts.platform(known.arrangement)
    # Without one of the near poses there is no start.
    near = np.flatnonzero(np.abs(kept.poses.R).max(axis=(1, 2)) < 10)
    fewer = SolvedStarts()
    poses = kept.poses[np.delete(np.arange(len(kept.poses.R)), near[0])]
    fewer.keep_platform(kept._replace(poses=poses))
    assert kept_start(Problem(instance, starts=fewer)) is None
    found = solve(instance, starts=fewer)
    assert found.verdict == "complete"
    assert len(found.R) == 36


def test_cranks_are_no_part_of_a_geometry():
    instance = platform("platforms", "t-top-head")
    starts = SolvedStarts()
    solve(instance, starts=starts)
    rods = np.array([row.value.value for row in instance.constraints])
    rows = rods * (1 + 0.01 * np.random.default_rng(3).uniform(-1, 1, (8, 6)))
    still = [replace(row, base=Point(row.base.position)) for row in instance.constraints]
    standing = replace(instance, constraints=tuple(still))
    batch = solve_batch(standing, rows, starts=starts)
    assert batch.proved.all()
    assert not batch.others


def test_a_far_pose_that_doubles_do_not_tell_from_infinity_is_not_approached() -> None:
    """Nothing is divided by zero: a warning of NumPy is an error here."""
    starts = SolvedStarts()
    for digits in (15, 16, 17):
        name = f"many-digits/6-4/planar/{digits}-digits"
        result = solve(special.platform(name).instance, starts=starts)
        assert result.verdict == "complete"
        assert result.proof is not None


@pytest.mark.parametrize("number", [434, 87, 116, 369, 20, 145])
def test_rows_of_realistic_machines_are_solved_together(number):
    """Far poses that come near, conjugates that become real, and poses with few digits.

    Two conjugate far poses of the known platform are two real ones for other values (3-3/434). A
    near and a far pose change places (rotary/87). One complex path stood for two poses (6-6/369).
    Coordinates differ by many powers of ten (6-6/145).
    """
    machine = next(machines(number + 1, rows=10, begin=number))
    starts = SolvedStarts()
    solve(machine.instance, starts=starts)
    (answers,) = many_poses(machine.instance, machine.rows, seed=1, jobs=1, starts=starts)
    assert not answers.alone
    for poses, row in zip(answers.poses(), machine.rows[:2].tolist(), strict=False):
        values = {i: Number.of(Fraction(x)) for i, x in enumerate(row)}
        alone = solve(machine.instance.with_values(values), starts=SolvedStarts())
        assert poses.proof is not None
        there = sorted(map(tuple, alone.T.tolist()), key=repr)
        assert sorted(map(tuple, poses.T.tolist()), key=repr) == there


def test_a_batch_has_a_start_with_poses_1e6_lengths_away():
    """Quick paths find all poses of each platform alone, so that none was kept (rotary/120)."""
    machine = next(machines(121, rows=20, begin=120))
    starts = SolvedStarts()
    (answers,) = many_poses(machine.instance, machine.rows[7:], seed=1, jobs=1, starts=starts)
    assert not answers.alone
    (poses, *_) = answers.poses()
    assert poses.account.verdict == "complete"
    assert np.abs(poses.T).max() > 1e6 * answers.together[0].search.problem.arrangement.length


@pytest.mark.parametrize("number", [40, 205, 386])
def test_rows_whose_poses_come_from_afar_are_solved_together(number, monkeypatch):
    """One path of a conjugate pair is lost, and 64 digits round poses some hundred lengths away.

    Of couplings 5 to 14 of 64 rows were solved one by one; a 6-3 had poses that need no paths.
    """
    machine = next(machines(number + 1, rows=71, begin=number))
    starts = SolvedStarts()
    solve(machine.instance, starts=starts)
    monkeypatch.setattr(Start, "careful_ends", None)
    (answers,) = many_poses(machine.instance, machine.rows[7:], seed=1, jobs=1, starts=starts)
    assert not answers.alone
    assert not starts.sizes[Sort.SAME]


def test_a_number_half_way_between_two_doubles_is_rounded_without_other_paths(monkeypatch):
    """An entry of the rotation is a ratio of two values: 128 bits do not round it (fixture/185)."""
    machine = next(machines(186, rows=71, begin=185))
    starts = SolvedStarts()
    solve(machine.instance, starts=starts)
    monkeypatch.setattr(by_count, "poses_by_count", None)
    values = {i: Number.of(Fraction(x)) for i, x in enumerate(machine.rows[29].tolist())}
    found = solve(machine.instance.with_values(values), starts=starts)
    assert found.verdict == "complete"
    assert found.counts.found == found.certified.sum() == 4


def test_poses_far_away_of_lines_are_found_from_those_for_other_values(monkeypatch):
    """Elimination takes two seconds, and is needed once (4 PP + 2 PL/146)."""
    machine = next(machines(147, rows=1, begin=146))
    starts = SolvedStarts()
    assert solve(machine.instance, starts=starts).verdict == "complete"
    monkeypatch.setattr(further, "poses_by_elimination", None)
    values = {i: Number.of(repr(x)) for i, x in enumerate(machine.rows[0].tolist())}
    other = machine.instance.with_values(values)
    found = solve(other, starts=starts)
    assert found.verdict == "complete"
    assert found.counts.found == found.certified.sum() == found.expected == 160


def test_poses_some_thousand_lengths_away_need_no_paths_with_32_digits(monkeypatch):
    """Of a coupling, for a few sets of values: half of its eight paths have no finite end."""
    machine = next(iter(machines(437, rows=71, begin=436)))
    rows = machine.rows[7:]
    starts = SolvedStarts()
    solve(machine.instance, starts=starts)
    solve_batch(machine.instance, rows[:1], starts=starts)
    with monkeypatch.context() as context:
        context.setattr(TrackedPaths, "track", None)
        batch = solve_batch(machine.instance, rows, starts=starts)
    assert batch.complete.all()
    assert batch.proved.all()
    far = np.flatnonzero(np.abs(batch.T).max(axis=(1, 2)) > 1000 * batch.arrangement.length)
    assert len(far) > 2
    for k in far[:3].tolist():
        values = {i: Number.of(Fraction(x)) for i, x in enumerate(rows[k].tolist())}
        alone = solve(machine.instance.with_values(values), starts=SolvedStarts())
        poses, length = ((batch.R[k], batch.T[k]), (alone.R, alone.T)), batch.arrangement.length
        assert pose_set_distance(*poses, length) <= 2.0**-51
        real = batch.T[k][batch.real[k]].tolist()
        assert sorted(real, key=str) == sorted(alone.T[alone.real].tolist(), key=str)


def similar_plates(half, ratio, turn, digits, count=12):
    """Return a hexapod whose plates are similar but for rounding, and values at other poses."""
    angles = np.radians([60, 60, 180, 180, 300, 300]) + np.radians(half) * np.tile([-1, 1], 3)
    x, y = (
        r * np.stack((np.cos(a), np.sin(a), 0 * a), axis=1).round(digits)
        for r, a in ((1, angles), (1, angles + np.radians(turn)))
    )
    y = (ratio * y).round(digits)
    rng = np.random.default_rng(5)
    rows = []
    for _ in range(count + 1):
        q = np.array([1, *rng.normal(0, 0.1, 3)])
        R = rotation_from_quaternion(q / np.linalg.norm(q))
        T = np.array([*rng.normal(0, 0.1, 2), rng.uniform(0.7, 1.4)])
        rows.append(np.linalg.norm(y @ R.T + T - x, axis=1).round(digits + 2))
    return hexapod(x, y, [repr(v) for v in rows[0].tolist()]), np.array(rows[1:])


@pytest.mark.parametrize(
    ("plates", "poses", "far"), [((8, 0.6, 10, 6), 40, 8), ((12, 1, 60, 4), 22, 6)]
)
def test_rows_of_similar_plates_are_solved_together(plates, poses, far, monkeypatch):
    """Values of poses differ from others: a combination is as small as what was rounded."""
    instance, rows = similar_plates(*plates)
    starts = SolvedStarts()
    known = solve(instance, starts=starts)
    assert known.verdict == "complete"
    assert len(known.T) == poses
    (answers,) = many_poses(instance, rows, seed=1, jobs=1, starts=starts)
    assert not answers.alone
    start = kept_start(Problem(instance, starts=starts))
    assert len(start.far) == far
    assert start.homotopy is not None
    for found, row in zip(answers.poses(), rows[:2].tolist(), strict=False):
        values = {i: Number.of(Fraction(x)) for i, x in enumerate(row)}
        alone = solve(instance.with_values(values), starts=SolvedStarts())
        there = sorted(map(tuple, alone.T.tolist()), key=repr)
        assert sorted(map(tuple, found.T.tolist()), key=repr) == there
    # Other values of the instance, as written, are solved from the same start.
    monkeypatch.setattr("gspcli.solver.all_poses.reduced_paths", None)
    texts = {i: Number.of(repr(x)) for i, x in enumerate(rows[3].tolist())}
    assert solve(instance.with_values(texts), starts=starts).proof == known.proof
