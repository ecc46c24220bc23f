"""Exact counts do not depend on how a platform is described; wrong equations are noticed."""

from __future__ import annotations

import random
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.kinds import AHL, ALH, DHP, DLP, DPH, DPL
from gspcli.catalogue.names import parse_name
from gspcli.certification.counting import count_exactly, count_geometry
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, Line, Plane, Point
from gspcli.geometry.random_instances import random_instance
from gspcli.resources import data_directory
from gspcli.spec import load

#: A rotation with rational entries, of the quaternion (1, 2, 3, 4), and a translation.
TURN = np.array([[-20, 4, 22], [20, -10, 20], [10, 28, 4]], dtype=object) / Fraction(30)
SHIFT = np.array([Fraction(1, 3), Fraction(-7, 5), Fraction(2)], dtype=object)
#: Platforms of all kinds of constraint, and special ones.
NAMES = [
    "planar-hexagons",
    "parallel-lines",
    "surfaces-pcc",
    "point-on-line",
    "figure-3",
    "six-planes",
]
SWAPPED = {DPL: DLP, DLP: DPL, DPH: DHP, DHP: DPH, ALH: AHL, AHL: ALH}


def example(name: str) -> Instance:
    return load(data_directory() / "examples" / f"{name}.yaml")


def counts(instance: Instance) -> tuple[int | None, int | None, bool]:
    count = count_exactly(instance)
    return count.solutions, count.distinct, count.finite


def number(terms: list[tuple[Fraction, Number]], constant: Fraction) -> Number:
    total = Number.of(constant)
    for factor, x in terms:
        total = Number("+", (total, Number("*", (Number.of(factor), x))))
    return total


def moved(geometry: Geometry) -> Geometry:
    def turned(vector, shift):
        return tuple(
            number([(a, x) for a, x in zip(row, vector, strict=True)], t)
            for row, t in zip(TURN, shift, strict=True)
        )

    position = turned(geometry.position, SHIFT)
    zero = (Fraction(0),) * 3
    if isinstance(geometry, Point):
        return Point(position)
    if isinstance(geometry, Line):
        return Line(position, turned(geometry.direction, zero))
    return Plane(position, turned(geometry.normal, zero))


@pytest.mark.parametrize("name", NAMES)
def test_motions_of_either_body(name):
    instance = example(name)
    expected = counts(instance)
    assert np.array_equal(TURN @ TURN.T, np.eye(3, dtype=int))
    for body in ("platform", "base"):
        rows = tuple(
            replace(row, **{body: moved(getattr(row, body))}) for row in instance.constraints
        )
        assert counts(replace(instance, constraints=rows)) == expected


@pytest.mark.parametrize("name", NAMES)
def test_base_and_platform_exchanged(name):
    instance = example(name)

    def swapped(row: Constraint) -> Constraint:
        kind = SWAPPED.get(row.kind, row.kind)
        return replace(row, kind=kind, platform=row.base, base=row.platform)

    rows = tuple(map(swapped, instance.constraints))
    assert counts(replace(instance, constraints=rows)) == counts(instance)


@pytest.mark.parametrize("name", NAMES)
def test_another_order(name):
    instance = example(name)
    rows = list(instance.constraints)
    random.Random(name).shuffle(rows)
    assert counts(replace(instance, constraints=tuple(rows))) == counts(instance)


@pytest.mark.parametrize(
    "family",
    [
        "DPP DPP DPP DPP DPP DPL",
        "DPP DPP DPH DPH DHP DLL",
        "DPL DLP DPH DHP ALL AHH",
        "DLL DLL DPH ALH AHL ALL",
        "DPL DPL DPP DPP ALL AHH",
    ],
)
@pytest.mark.parametrize("seed", [1, 2])
def test_random_platforms_have_the_generic_count(family, seed):
    gsp_type = parse_name(family)
    instance, _ = random_instance(gsp_type, np.random.default_rng(seed), one_sided=True)
    expected = generic_counts(gsp_type).one_sided
    for count in (count_exactly(instance), count_geometry(instance)):
        assert (count.solutions, count.distinct) == (expected, expected)
        assert count.error < 1e-14


def test_neighbours_of_special_platforms_are_counted_as_what_they_are():
    instance = example("octahedral-3-3")

    def shaken(point: Point, by: int) -> Point:
        x, y, z = point.position
        return Point((Number("+", (x, Number.of(f"{by}e-20"))), y, z))

    rows = tuple(
        replace(row, platform=shaken(row.platform, k * k), base=shaken(row.base, 2 * k + 1))
        for k, row in enumerate(instance.constraints, 1)
    )
    assert counts(instance)[0] == 16
    assert counts(replace(instance, constraints=rows))[0] > 16
