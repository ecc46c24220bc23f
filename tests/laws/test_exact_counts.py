"""Exact counts do not depend on how a platform is described; wrong equations are noticed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.names import parse_name
from gspcli.certification.counting import count_exactly, count_geometry
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Point
from gspcli.geometry.random_instances import random_instance
from gspcli.resources import data_directory
from gspcli.spec import load


def example(name: str) -> Instance:
    return load(data_directory() / "examples" / f"{name}.yaml")


def counts(instance: Instance) -> tuple[int | None, int | None, bool]:
    count = count_exactly(instance)
    return count.solutions, count.distinct, count.finite


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
