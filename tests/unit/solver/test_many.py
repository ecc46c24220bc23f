"""Many sets of values of one platform."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import islice
from types import SimpleNamespace

import numpy as np
import pytest
from matching import pose_set_distance

from benchmarks.cases import random_instances
from gspcli import hexapod
from gspcli.catalogue.names import parse_type
from gspcli.continuation.paths import Basis
from gspcli.errors import ArgumentError, GspError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import AngleUnit, Instance
from gspcli.geometry.measurement import condition_numbers, residuals
from gspcli.geometry.numbers import Number
from gspcli.geometry.random_instances import random_instance
from gspcli.resources import data_path, instance_files
from gspcli.solver import api, solve, solve_batch, solve_values
from gspcli.solver import poses as pose_module
from gspcli.solver.all_poses import all_poses, closed_form, first_poses
from gspcli.solver.api import groups_of
from gspcli.solver.poses import CountKind
from gspcli.solver.problem import Problem
from gspcli.solver.solved_starts import SolvedStarts
from gspcli.solver.start import start_among
from gspcli.spec import load
from tests.support.oracle.poses_by_paths import solve_by_tracking
from tests.support.strategies import added


def instance_of(name: str):
    return random_instance(parse_type(name), np.random.default_rng(12))[0]


@pytest.mark.parametrize(
    "name",
    [
        "DPL DPL DLP ALL ALH AHH",
        "DPP DPP DPP ALL ALL ALL",
        "DPH DHP DLL ALL ALL ALH",
        "DPP DPP DPP DPP DPP DPP",
        "DPP DPP DPH DPH DLP ALL",
    ],
)
def test_batches_equal_single_solves(name):
    instance = instance_of(name)
    rng = np.random.default_rng(0)
    own = np.array([c.value.value for c in instance.constraints])
    values = own * (1 + 0.05 * rng.normal(size=(5, 6)))
    results = list(solve_values(instance, values))
    assert len(results) == 5
    for row, poses in zip(values, results, strict=True):
        numbers = {i: Number.of(float(value)) for i, value in enumerate(row)}
        single = solve(instance.with_values(numbers))
        assert poses.account.expected == single.expected
        assert poses.real.sum() == single.counts.real
        distance = pose_set_distance(
            (poses.R, poses.T), (single.R, single.T), single.arrangement.length
        )
        assert distance < 1e-7


def test_zeros_among_the_values_change_the_structure():
    instance = instance_of("DPH DHP DLL ALL ALL ALH")
    own = np.array([c.value.value for c in instance.constraints])
    values = np.tile(own, (4, 1))
    distance = next(i for i, c in enumerate(instance.constraints) if c.kind.has_sides)
    values[1:3, distance] = 0
    paths = [poses.account.expected for poses in solve_values(instance, values)]
    assert paths == [64, 32, 32, 64]


def test_wrong_shapes_are_refused():
    instance = instance_of("DPL DPL DLP ALL ALH AHH")
    with pytest.raises(ArgumentError, match=r"^values: found shape \(6,\), expected \(batch, 6\)"):
        solve_values(instance, np.ones(6))
    with pytest.raises(
        ArgumentError, match=r"^values: found something that is no array of numbers"
    ):
        solve_values(instance, [["a"] * 6])


@pytest.mark.parametrize("name", ["DPL DPL DLP ALL ALH AHH", "DPP DPP DPP DPP DPL ALL"])
def test_a_wrong_row_spoils_itself_only(name):
    instance = instance_of(name)
    own = np.array([c.value.value for c in instance.constraints])
    values = np.tile(own, (6, 1))
    values[1, 2] = np.nan
    values[2, 0] = -1.0
    values[4, 5] = 181.0
    values[5, 0] = np.inf
    found = list(solve_values(instance, values))
    assert [poses.problem for poses in found] == [
        None,
        "values[1][2]: found nan, expected a finite number",
        "values[2][0]: found -1, expected a distance of at least 0",
        None,
        f"values[4][5]: found 181, expected an angle of {instance.constraints[5].kind.short}"
        " from 0 to 180 (deg)",
        "values[5][0]: found inf, expected a finite number",
    ]
    for poses in found:
        wrong = poses.problem is not None
        assert poses.account.expected == instance.expected
        assert poses.account.lost == (instance.expected if wrong else 0)
        assert len(poses.R) == (0 if wrong else poses.account.found)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"instance": "platform.yaml"}, "instance: found a str, expected an Instance"),
        ({"seed": -1}, "seed: found -1, expected a whole number of at least 0"),
        ({"seed": 1.5}, "seed: found 1.5, expected a whole number of at least 0"),
        ({"jobs": 0}, "jobs: found 0, expected a whole number of at least 1"),
    ],
)
def test_wrong_arguments_are_named(arguments, message):
    given = {"instance": instance_of("DPL DPL DLP ALL ALH AHH"), **arguments}
    instance = given.pop("instance")
    for call in (solve, lambda *a, **k: solve_values(*a, np.ones((1, 6)), **k)):
        with pytest.raises(GspError) as caught:
            call(instance, **given)
        assert str(caught.value).startswith(message)


def test_an_instance_that_is_none():
    instance = instance_of("DPL DPL DLP ALL ALH AHH")
    five = replace(instance, constraints=instance.constraints[:5])
    with pytest.raises(GspError, match=r"^constraints: found 5 constraints, expected exactly six"):
        solve(five)
    negative = instance.with_values({0: Number.of(-1)})
    with pytest.raises(GspError, match=r"^constraints\[0\].value: found -1, expected a distance"):
        solve(negative)


def test_no_values_no_results():
    assert list(solve_values(instance_of("DPL DPL DLP ALL ALH AHH"), np.ones((0, 6)))) == []


def _near(instance, spread: float, count: int, seed: int) -> np.ndarray:
    own = np.array([c.value.value for c in instance.constraints])
    return own * (1 + spread * np.random.default_rng(seed).normal(size=(count, 6)))


def _same(one, other, length: float) -> bool:
    distance = pose_set_distance((one.R, one.T), (other.R, other.T), length)
    return distance < 1e-7 and bool(one.real.sum() == other.real.sum())


def _quickly(instance, values, monkeypatch=None, count=None):
    """Return what is found from the geometry's own start, None where nothing is."""
    problem, found = Problem(instance, starts=SolvedStarts()), [None] * len(values)
    if monkeypatch is not None:
        monkeypatch.setattr(SolvedStarts, "count", lambda *_: count)
    for rows, group in groups_of(problem, values, all_poses):
        search = first_poses(group)
        for k in np.delete(np.arange(len(rows)), search.left).tolist():
            found[rows[k]] = search.poses(k)
    return found


@pytest.mark.parametrize(
    "name",
    [
        "DPP DPP DPP DPP DPP DPP",
        "DPP DPP DPP DPL DLP DLL",
        "DPH DPH DPH DHP DHP DHP",
        "DPP DPL DPH DHP ALL ALH",
    ],
)
def test_values_of_one_geometry_are_followed_from_its_own_start(name):
    instance = instance_of(name)
    arrangement = Arrangement.of(instance)
    values = _near(instance, 0.1, 6, 1)
    found = _quickly(instance, values)
    for row, poses in zip(values, found, strict=True):
        alone = solve_by_tracking(arrangement.with_values(row), seed=4)
        assert poses.account == alone.account
        assert poses.proof.by is CountKind.TYPE
        assert poses.account.found == poses.account.expected == len(poses.R)
        assert _same(poses, alone, arrangement.length)
        assert not poses.R[poses.real].imag.any()


def _three_three():
    """Six legs between two triangles, each corner with two of them: 16 poses and not 40."""
    y, x = np.random.default_rng(5).uniform(-1, 1, (2, 3, 3))
    return hexapod(x[[0, 0, 1, 1, 2, 2]], y[[0, 1, 1, 2, 2, 0]], [2.0, 2.1, 2.2, 2.3, 2.4, 2.5])


def test_a_special_geometry_is_followed_if_its_count_says_that_nothing_is_missing(monkeypatch):
    instance = _three_three()
    values = _near(instance, 0.02, 5, 6)
    for number, trusted in ((16, True), (18, False), (None, False)):
        count = (
            None
            if number is None
            else SimpleNamespace(solutions=number, distinct=number, error=1e-9, has_lone_lines=True)
        )
        with monkeypatch.context() as patch:
            found = _quickly(instance, values, patch, count)
        assert [poses is not None for poses in found] == [trusted] * 5
        for poses in found if trusted else []:
            assert poses.account.verdict == "complete"
            assert (poses.account.found, poses.account.at_infinity) == (16, 24)
            assert poses.account.basis is Basis.COUNT
    for row, poses in zip(values, solve_values(instance, values), strict=True):
        alone = solve_by_tracking(Arrangement.of(instance).with_values(row), seed=8)
        assert _same(poses, alone, 1.0)


def _singular():
    """A platform with a double pose: all legs meet a line there; and its lengths."""
    rng = np.random.default_rng(9)
    y = rng.uniform(-1, 1, (6, 3))
    T = np.array([0.1, 0.2, 2.0])
    point, direction = rng.normal(size=(2, 3))
    ends = y + T
    on_line = point + rng.normal(size=(6, 1)) * direction
    x = ends + (1.5 + rng.random((6, 1))) * (on_line - ends)
    lengths = np.linalg.norm(ends - x, axis=1)
    return hexapod(x, y, lengths.tolist()), lengths


def test_values_next_to_a_double_pose_give_the_poses_that_they_give_alone():
    instance, lengths = _singular()
    values = lengths * (1 + np.array([0.0, 0.01, 0.02, 0.0, 0.03]))[:, None]
    for poses, row in zip(_quickly(instance, values), values, strict=True):
        exactly = {i: Number.of(Fraction(x)) for i, x in enumerate(row.tolist())}
        alone = solve(instance.with_values(exactly), starts=SolvedStarts())
        assert poses is None or pose_set_distance((poses.R, poses.T), (alone.R, alone.T), 1.0) == 0


def test_few_sets_of_values_are_not_worth_a_start():
    instance = instance_of("DPP DPP DPP DPP DPP DPP")
    values = _near(instance, 0.1, 3, 11)
    assert _quickly(instance, values) == [None] * 3
    assert len(list(solve_values(instance, values))) == 3


def test_batches_do_not_depend_on_what_was_solved_before_nor_on_threads():
    instance = instance_of("DPP DPP DPP DPP DPL DPH")
    values = _near(instance, 0.05, 8, 13)
    first = list(solve_values(instance, values))
    list(solve_values(instance, _near(instance, 0.3, 8, 14)))
    for one, other in zip(first, solve_values(instance, values, jobs=2), strict=True):
        np.testing.assert_array_equal(one.T, other.T)


@pytest.mark.parametrize(
    "name",
    [
        "DPP DPP DPP DPP DPP DPP",
        "DPP DPP DPP DPL DLP DLL",
        "DPP DPL DPH DHP ALL ALH",
        "DPL DPL DLP ALL ALH AHH",
    ],
)
def test_batches_are_certified_as_single_platforms_are(name):
    instance = instance_of(name)
    values = _near(instance, 0.05, 4, 15)
    for row, poses in zip(values, solve_values(instance, values), strict=True):
        numbers = {i: Number.of(float(value)) for i, value in enumerate(row)}
        single = solve(instance.with_values(numbers))
        assert poses.certified.all()
        assert poses.proof == single.proof
        assert poses.proof.by is CountKind.TYPE
        assert poses.real.sum() == single.counts.real


def test_the_closed_form_is_certified_on_both_sides_of_planes():
    """The second set has a distance of zero."""
    instance = instance_of("DPH DHP DLL ALL ALL ALH")
    values = _near(instance, 0.02, 4, 18)
    values[1, next(i for i, c in enumerate(instance.constraints) if c.kind.has_sides)] = 0
    sets = list(solve_values(instance, values))
    for row, poses in zip(values, sets, strict=True):
        numbers = {i: Number.of(float(value)) for i, value in enumerate(row)}
        single = solve(instance.with_values(numbers))
        assert poses.proof == single.proof
        assert poses.proof.by is CountKind.TYPE
        assert poses.certified.all()
        assert single.certified.all()
        assert poses.account == single.account
        assert _same(poses, single, 1.0)


def test_a_special_geometry_is_certified_by_its_count():
    instance = _three_three()
    values = _near(instance, 0.02, 5, 16)
    for poses in solve_values(instance, values):
        assert poses.certified.all()
        assert poses.proof.by is CountKind.GEOMETRY
        assert (poses.account.found, poses.account.at_infinity) == (16, 24)


def test_special_values_are_proved_too():
    """Legs of one length: what is multiple is not certified."""
    instance = _three_three()
    values = np.tile([2.0, 2.0, 2.0, 2.0, 2.0, 2.0], (4, 1))
    for poses in solve_values(instance, values):
        assert poses.account.verdict in ("complete", "infinite", "incomplete")
        assert not (poses.certified & (poses.multiplicity > 1)).any()


def test_residuals_are_measured_in_blocks(monkeypatch):
    instance, special = _singular()
    values = _near(instance, 0.02, 6, 17)
    values[2] = special
    batch = solve_batch(instance, values)
    together = batch.residuals
    vars(batch).pop("residuals")
    measured, sizes = pose_module.proved_residuals, []

    def counted(given, R, T):
        sizes.append(len(R))
        return measured(given, R, T)

    monkeypatch.setattr(pose_module, "proved_residuals", counted)
    monkeypatch.setattr(pose_module, "_BLOCK", 7)
    np.testing.assert_array_equal(batch.residuals, together)
    assert max(sizes) == 7
    assert sum(sizes) == batch.certified.sum()


def test_a_batch_has_the_same_poses_as_arrays():
    """The third set has a distance of zero, the fifth is wrong: both have answers of their own."""
    instance, _ = _singular()
    values = _near(instance, 0.02, 6, 17)
    values[2, 3], values[4, 1] = 0.0, -1.0
    batch = solve_batch(instance, values)
    sets = list(solve_values(instance, values))
    assert len(batch) == 6
    assert set(batch.others) == {2, 4}
    assert batch.others[4].problem == "values[4][1]: found -1, expected a distance of at least 0"
    for k, poses in enumerate(sets):
        number = batch.number[k]
        assert number == len(poses.R)
        assert batch.complete[k] == (poses.problem is None and poses.account.verdict == "complete")
        assert batch.proved[k] == (batch.complete[k] and poses.proof is not None)
        for name in ("R", "T", "real", "certified", "multiplicity"):
            np.testing.assert_array_equal(getattr(batch, name)[k, :number], getattr(poses, name))
        assert np.isnan(batch.T[k, number:]).all()
        if poses.problem is None:
            given = Arrangement.of(instance).with_values(values[k]), poses.R, poses.T
            largest = residuals(*given).max(axis=1)
            np.testing.assert_allclose(batch.residuals[k, :number], largest, atol=1e-9)
            conditions = condition_numbers(*given)
            np.testing.assert_allclose(batch.conditions[k, :number], conditions, rtol=1e-6)
    assert batch.proved[[0, 1, 3, 5]].all()
    assert not batch.complete[4]


@pytest.mark.parametrize("wrong", [180.00000000000003, -1e-9, 181.0])
def test_an_angle_beyond_its_range_is_wrong_in_a_batch_as_in_a_file(wrong: float) -> None:
    instance = instance_of("DPL DPL DLP ALL ALH AHH")
    own = np.array([c.value.value for c in instance.constraints])
    rows = np.stack([own, own])
    rows[1, 3] = wrong
    first, second = solve_values(instance, rows)
    assert first.problem is None
    assert second.problem is not None
    assert "expected an angle of LL from 0 to 180 (deg)" in second.problem
    with pytest.raises(GspError, match="expected an angle of LL from 0 to 180"):
        solve(instance.with_values({3: Number.of(wrong)}))


def test_an_angle_of_half_a_turn_in_radians_may_be_rounded_up() -> None:
    """The double next to pi is the rounded end of the range, in a batch as in a file."""
    instance = instance_of("DPL DPL DLP ALL ALH AHH")
    units = replace(instance.units, angle=AngleUnit.RADIAN)
    given = replace(instance.with_values(dict.fromkeys((3, 4, 5), Number.of(1))), units=units)
    own = np.array([c.value.value for c in given.constraints])
    own[3] = np.nextafter(np.pi, 4)
    (found,) = solve_values(given, own[None])
    assert found.problem is None


# Sets of values of other sizes among those of a batch: each is solved as if it were alone.


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
    assert single.proof is not None
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

    monkeypatch.setattr(api, "start_among", counting)
    batch = solve_batch(instance, mixed, starts=SolvedStarts())
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
    known = api.start_among

    def unproved(arrangement, group, *rest):
        geometry = known(arrangement, group, *rest)
        if np.abs(group).max() > 10:
            object.__setattr__(geometry, "proof", None)
        return geometry

    monkeypatch.setattr(api, "start_among", unproved)
    batch = solve_batch(instance, mixed, starts=SolvedStarts())
    assert sorted(batch.others) == [5, 6, 7, 8, 9]
    assert batch.proved.all()


def test_tripods_have_a_common_start():
    """Planes at distance zero have one side, and those at another distance both."""
    instance = load(instance_files()["three-rps"])
    own = np.array([row.value.value for row in instance.constraints])
    rows = np.tile(own, (12, 1))
    rows[:, :3] *= np.random.default_rng(2).uniform(0.95, 1.05, (12, 3))
    rows[4:8, 3] = 0.05
    rows[8:, 3:] = 0.03
    groups = api.groups_of(Problem(instance), rows, all_poses)
    counts = {tuple(members): group.known_geometry_count for members, group in groups}
    assert [count and count.solutions for count in counts.values()] == [16, 32, 128]
    batch = solve_batch(instance, rows)
    assert batch.complete.all()
    for k in (1, 5, 9):
        alone = solve(given(instance, rows[k]))
        assert (batch.number[k], batch.real[k].sum()) == (alone.counts.found, alone.counts.real)


# The closed form of one platform at once: as the one of many sets of values finds them.


TYPES = ("DPL DPL DLP 3ALL", "DLL DLP DPP 3ALL", "DPH DPL DPP ALL ALH AHH", "DPP DPP DPP 3AHH")


def refused(*_):
    message = "no paths are to be needed"
    raise AssertionError(message)


def exactly(values):
    return {i: Number.of(Fraction(x)) for i, x in enumerate(values.tolist())}


@pytest.mark.parametrize("type_text", TYPES)
def test_poses_accounts_and_proofs_are_those_of_many_sets_of_values(type_text, monkeypatch):
    monkeypatch.setattr(Problem, "tracked", property(refused))
    for given in islice(random_instances(type_text, 5), 4):
        values = np.array([row.value.value for row in given.constraints])
        instance = given.with_values(exactly(values))
        one = solve(instance)
        (many,) = solve_values(instance, values[None])
        many = many.in_order(Arrangement.of(instance).length)
        assert (one.account, one.proof) == (many.account, many.proof)
        assert len(one.R) == instance.expected
        for name in ("quaternions", "R", "T", "real", "signs"):
            np.testing.assert_array_equal(getattr(one, name), getattr(many, name))


def test_what_is_special_goes_the_careful_way():
    example = load(str(data_path("examples", "example-6.8.yaml")))
    special = example.with_values({5: Number.of("sqrt(52)")})  # cylinders touch
    assert added(closed_form, Problem(special)) == []
    found = solve(special)
    assert found.verdict == "complete"
    assert (found.multiplicity > 1).any()


def test_both_sides_of_planes_are_found_at_once(monkeypatch):
    monkeypatch.setattr(Problem, "tracked", property(refused))
    two_sided = next(random_instances("DPH DPL DPP 3ALL", 5, one_sided=False))
    found = solve(two_sided)
    assert found.verdict == "complete"
    assert found.proof.by is CountKind.TYPE
    assert found.certified.all()
