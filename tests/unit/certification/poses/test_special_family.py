"""Points nearly on a line: the platforms with them farther from it, and poses far away."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from flint import acb, arb, ctx

from gspcli.catalogue.kinds import DLP, DPL
from gspcli.catalogue.names import parse_type
from gspcli.certification.equations.ball_system import BallSystem
from gspcli.certification.poses.locator import Located
from gspcli.certification.poses.special_family import (
    FamilyPaths,
    SpecialFamily,
    points_off_lines,
    turned_directions,
)
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Units
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Line, Point, Vector, vector
from gspcli.geometry.random_instances import random_instance
from gspcli.solver import further, solve
from gspcli.solver.problem import Problem
from gspcli.solver.solved_starts import SolvedStarts
from tests.support.special.platforms import platform
from tests.support.turned_machines import machine


def _members(family: SpecialFamily | None) -> tuple[Instance, Instance]:
    """Return a platform from its family, and one with differences 1e17 times as large."""
    assert family is not None
    assert 1e-22 < family.size < 1e-19
    with ctx.workprec(600):
        return family.instance_at(arb(1)), family.instance_at(arb(10) ** 17)


def _fraction(number: Number) -> Fraction:
    assert number.fraction is not None
    return number.fraction


def _four_on_a_line(eps: Fraction, *, on_platform: bool = True) -> Instance:
    """Return a platform of which four points are on a line up to eps, at equal heights at home."""
    places = [(Fraction(k), Fraction(2 * k), Fraction(-k)) for k in (0, 1, -2, 3)]
    x, y, z = places[3]
    points = [Point(tuple(map(Number.of, place))) for place in (*places[:3], (x + eps, y, z - eps))]
    line = Line([Number.of(k) for k in (5, 1, 2)], [Number.of(k) for k in (2, -1, 2)])
    kind = DPL if on_platform else DLP
    rows = [
        Constraint(kind, *((point, line) if on_platform else (line, point)), Number.of(4 + k))
        for k, point in enumerate(points)
    ]
    others = random_instance(parse_type("DPP DPP DPP DPP DPP DPP"), np.random.default_rng(1))
    return Instance((*others[0].constraints[:2], *rows), others[0].units)


@pytest.mark.parametrize("on_platform", [True, False])
def test_points_are_moved_off_their_line_and_nothing_else_changes(on_platform: bool) -> None:
    body = "platform" if on_platform else "base"
    instance = _four_on_a_line(Fraction(1, 10**20), on_platform=on_platform)
    same, apart = _members(points_off_lines(instance))
    for row, other, given in zip(
        same.constraints, apart.constraints, instance.constraints, strict=True
    ):
        for one in (row, other):
            assert (one.kind, one.value, one.side) == (given.kind, given.value, given.side)
            unmoved = "base" if on_platform else "platform"
            assert getattr(one, unmoved) == getattr(given, unmoved)
        exact, stated = (
            [_fraction(number) for number in getattr(one, body).position] for one in (row, given)
        )
        assert all(abs(x - y) < Fraction(1, 10**100) for x, y in zip(exact, stated, strict=True))
    moved = np.array([getattr(row, body).position for row in apart.constraints[2:]], float)
    along = moved[3] - moved[2]
    off = np.linalg.norm(np.cross(moved - moved[2], along), axis=1) / np.linalg.norm(along)
    assert 1e-4 < off.max() < 1e-2


@pytest.mark.parametrize("eps", [Fraction(0), Fraction(1, 10**2)])
def test_points_that_are_on_a_line_or_not_nearly_so_are_not_moved(eps: Fraction) -> None:
    assert points_off_lines(_four_on_a_line(eps)) is None


def test_three_points_on_a_line_are_not_moved() -> None:
    """Their distances from another line are independent."""
    rows = list(_four_on_a_line(Fraction(1, 10**20)).constraints)
    rows[2] = rows[0]
    assert points_off_lines(Instance(tuple(rows), Units("m", AngleUnit.DEGREE))) is None


def test_equations_of_a_family_are_those_of_its_platforms_also_where_s_is_complex() -> None:
    family = points_off_lines(_four_on_a_line(Fraction(1, 10**14)))
    assert family is not None
    point, sides = [acb(k + 1, -k) for k in range(8)], (0,) * 6
    with ctx.workprec(400):
        s = arb(10) ** 10
        at_s, of_platform, above, below = (
            BallSystem(platform, 400, given).at(point, sides)[0].entries()
            for platform, given in (
                (family.instance, family.at(s)),
                (family.instance_at(s), None),
                (family.instance, family.at(acb(s, 10**7))),
                (family.instance, family.at(acb(s, -(10**7)))),
            )
        )
        for one, other, up, down in zip(at_s, of_platform, above, below, strict=True):
            assert abs(one - other) < 1e-90
            # Analytic in s: differences are of first order, those of the mean of second order.
            assert abs((up + down) / 2 - one) <= 1e-3 * abs(up - down) + 1e-90
        assert any(abs(up - down) > 1e-6 for up, down in zip(above, below, strict=True))


def _nearly_parallel(eps: Fraction = Fraction(1, 10**20), sign: int = 1) -> Instance:
    """Return a platform two of whose base lines are parallel up to eps."""
    instance, _ = random_instance(parse_type("DPL DPL DPP DPP DPP DPP"), np.random.default_rng(1))
    rows = sorted(instance.constraints, key=lambda row: not isinstance(row.base, Line))
    first, second = rows[:2]
    assert isinstance(first.base, Line)
    near = [sign * _fraction(number) for number in first.base.vector]
    turned = [x + eps * k for x, k in zip(near, (1, -2, 3), strict=True)]
    line = Line(second.base.position, [Number.of(x) for x in turned])
    rows[1] = Constraint(second.kind, second.platform, line, second.value, second.side)
    return Instance(tuple(rows), instance.units)


@pytest.mark.parametrize("power", [14, 20])
def test_poses_far_away_are_found_and_proved(power: int) -> None:
    result = solve(_nearly_parallel(Fraction(1, 10**power)), starts=SolvedStarts())
    assert (result.verdict, result.counts.certified) == ("complete", 160)
    assert result.proof is not None
    assert result.proof.by.name == "TYPE"
    # Those of parallel lines are 128; the others go to infinity with the angle.
    far = np.abs(result.T).max(axis=1) > 1 / np.float64(f"1e-{power}") ** 0.9
    assert far.sum() >= 16


def test_they_are_found_from_the_other_side(monkeypatch: pytest.MonkeyPatch) -> None:
    """With s < 0 at the beginning."""
    monkeypatch.setattr(further, "_APART", (-3e-3,))
    result = solve(_nearly_parallel(), starts=SolvedStarts())
    assert (result.verdict, result.counts.certified) == ("complete", 160)


def test_differences_are_multiplied_and_nothing_else_changes() -> None:
    instance = _nearly_parallel(sign=-1)
    same, apart = _members(turned_directions(instance))
    for row, other, given in zip(
        same.constraints, apart.constraints, instance.constraints, strict=True
    ):
        assert (row.kind, row.value, row.platform) == (given.kind, given.value, given.platform)
        assert other.base.position == given.base.position
    first, second = (row.base.unit for row in apart.constraints[:2])
    difference = np.abs(first + second).max()
    assert 1e-4 < difference < 1e-2
    # To within the digits of the angle, as a direction of the same orientation.
    exact, given = (
        [_fraction(number) for number in platform.constraints[1].base.vector]
        for platform in (same, instance)
    )
    k = max(range(3), key=lambda i: abs(given[i]))
    scale = exact[k] / given[k]
    assert scale > 0
    assert all(abs(x - scale * y) < Fraction(1, 10**100) for x, y in zip(exact, given, strict=True))


@pytest.mark.parametrize("eps", [Fraction(0), Fraction(1, 10**3)])
def test_directions_that_are_parallel_or_not_nearly_so_are_not_turned(eps: Fraction) -> None:
    assert turned_directions(_nearly_parallel(eps)) is None


def _three_rods(power: int, *, same_axis: bool = False) -> Instance:
    """Return a platform with three base lines that are parallel, or the same, up to 10^-power."""
    types = parse_type("DPL DPL DPL DPP DPP DPP")
    instance, _ = random_instance(types, np.random.default_rng(1))
    eps, rows = Fraction(1, 10**power), list(instance.constraints)
    for k, row in enumerate(rows):
        if isinstance(row.base, Line):
            vector = (1 + k * eps, 2 - eps, 2 + k**2 * eps)
            place = row.base.position
            if same_axis:
                place = vector_of(1 + k**i * eps for i in range(3))
            rows[k] = replace(row, base=Line(place, vector_of(vector)))
    return Instance(tuple(rows), instance.units)


def vector_of(numbers: Iterable[Fraction]) -> Vector:
    return vector(*(Number.of(Fraction(x)) for x in numbers))


def test_equations_of_three_parallel_rods_have_enough_bits() -> None:
    """Their matrices lose more bits than N has zeros: with five for each of eps paths are lost."""
    problem = Problem(_three_rods(30))
    family = turned_directions(problem.instance)
    assert family is not None
    paths = FamilyPaths(family, problem.locator, problem.sides[0], 1e-3)
    begin = problem.like(paths.instance)
    ends = list(further._ends(begin, 0))
    located = [paths.locate(begin.locator, *end) for end in ends[:24]]
    assert all(isinstance(end, Located) for end in located)


def test_lines_that_are_nearly_the_same_are_moved_apart_too() -> None:
    """If they were only turned, they would meet in a point at the beginning."""
    family = turned_directions(_three_rods(20, same_axis=True))
    assert family is not None
    with ctx.workprec(600):
        larger = family.instance_at(arb(10) ** 17)
    lines = [row.base for row in larger.constraints if isinstance(row.base, Line)]
    assert len(lines) == 3
    first = np.array(lines[0].position, float)
    across = [np.cross(np.array(line.position, float) - first, lines[0].unit) for line in lines[1:]]
    assert all(1e-4 < np.linalg.norm(x) < 1e-1 for x in across)
    parallel = turned_directions(_three_rods(20))
    assert parallel is not None
    assert not any("b" in names for names in parallel.differences)


@pytest.mark.parametrize(
    ("instance", "family_of", "index"),
    [
        # N is of size s^2; N is not small, and T has a pole.
        (machine("points on a line at rods/doubles/1"), points_off_lines, slice(0, 48, 8)),
        (platform("parallels/DLL-2/1e-12").instance, turned_directions, slice(9, 15)),
    ],
)
def test_a_path_takes_few_steps(
    instance: Instance, family_of: Any, index: slice, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem, places = Problem(instance), []
    paths = FamilyPaths(family_of(instance), problem.locator, problem.sides[0], 1e-2)
    solution = FamilyPaths._solution

    def counted(self: FamilyPaths, x: float, *given: Any, **named: Any) -> Any:
        places.append(x)
        return solution(self, x, *given, **named)

    monkeypatch.setattr(FamilyPaths, "_solution", counted)
    begin = problem.like(paths.instance)
    ends = list(further._ends(begin, 0))[index]
    assert all(isinstance(paths.locate(begin.locator, *end), Located) for end in ends)
    assert len(places) <= 18 * len(ends)
