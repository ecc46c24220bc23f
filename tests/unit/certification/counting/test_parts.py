"""Poses counted by which lines of a DLL are parallel, and dimensions by random hyperplanes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gspcli.catalogue.names import parse_name
from gspcli.certification.counting import (
    NotCountedError,
    count_exactly,
    dimension_exactly,
    exact_count,
)
from gspcli.certification.counting.exact_counts import count_parts
from gspcli.geometry.instance import Instance
from gspcli.geometry.random_instances import random_instance
from gspcli.resources import data_directory
from gspcli.spec import load, loads
from tests.support.posts import PLATE_ON_POSTS
from tests.support.special.platforms import platform

#: A plate on three points between three round posts: one foot is longer.
SPEC = PLATE_ON_POSTS.replace("F1: {point: [3, 0, 0]}", "F1: {point: [3, 0, 1]}").replace(
    "{distance: [F1, table], value: 0}", "{distance: [F1, table], value: 1, side: positive}"
)
WORK = 10**10


def _example(name: str) -> Instance:
    return load(data_directory() / "examples" / f"{name}.yaml")


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("dietmaier", 0),
        ("bricard-octahedron", 1),
        ("griffis-duffy", 1),
        ("similar-hexagons", 1),
        ("congruent-equal-legs", 2),
    ],
)
def test_dimensions_are_those_of_groebner_bases(name: str, expected: int) -> None:
    dimension, error = dimension_exactly(_example(name))
    assert dimension == expected
    assert 0 < error < 1e-9


def test_no_poses_have_no_dimension() -> None:
    flat = SPEC.replace("value: 1, side: positive", "value: 100")
    assert dimension_exactly(loads(flat))[0] == -1


def test_the_limit_of_a_dimension_is_kept() -> None:
    with pytest.raises(NotCountedError, match="limit"):
        dimension_exactly(_example("griffis-duffy"), limit=1e-5)


@pytest.mark.parametrize("name", ["parallel-lines", "figure-2", "surfaces-ppp"])
def test_without_parallel_lines_there_is_one_part(name: str) -> None:
    instance = _example(name)
    first, *others = count_parts(instance, 1, WORK)
    count = count_exactly(instance)
    assert (first.solutions, first.distinct) == (count.solutions, count.distinct)
    assert {part.solutions for part in others} == {0}


def test_poses_with_parallel_lines_are_a_part_of_their_own() -> None:
    # Upright the plate has four poses; turned over it is tilted, and has none.
    parts = {part.parallel: part for part in count_parts(loads(SPEC), 1, WORK)}
    assert len(parts) == 8
    assert {key: part.solutions for key, part in parts.items() if part.solutions} == {(3, 4, 5): 4}
    skew = SPEC.replace("[0, -2, 0], direction: [0, 0, 1]", "[0, -2, 0], direction: [1, 0, 1]")
    parts = {part.parallel: part for part in count_parts(loads(skew), 1, WORK)}
    found = {key: part.solutions for key, part in parts.items() if part.solutions}
    assert found == {(): 16, (3, 4): 12}
    assert max(part.error for part in parts.values()) < 1e-9


def test_seeds_change_the_primes_and_not_the_parts() -> None:
    counts = [
        [
            (part.parallel, part.solutions, part.distinct)
            for part in count_parts(loads(SPEC), k, WORK)
        ]
        for k in range(3)
    ]
    assert counts[0] == counts[1] == counts[2]


def test_infinitely_many_are_proved_where_a_count_is_too_much_work() -> None:
    # A constraint that is said twice: two billion multiplications do not count it.
    instance, _ = random_instance(
        parse_name("DPP DPP DPL DPL DLP DLP"), np.random.default_rng(1), one_sided=True
    )
    *rows, fifth, _ = instance.constraints
    twice = replace(instance, constraints=(*rows, fifth, fifth))
    count = count_exactly(twice, limit=1.0)
    assert not count.finite
    assert count.solutions is None
    assert 0 < count.error < 1e-9
    assert len(count.primes) > 1
    # Finitely many are not proved so, and nothing is unless there is a suspicion.
    assert exact_count(instance, limit=0.01) is None
    assert exact_count(twice, limit=1.0, suspect=False) is None


@pytest.mark.parametrize("kind", ["DPP", "DPH", "DPL"])
def test_equal_constraints_are_cut_with_as_many_hyperplanes(kind: str) -> None:
    """Five legs between the same two points: the elimination took 250 s and 3.3 GB."""
    found = count_exactly(platform(f"same-points/{kind}/exact").instance, limit=0.05)
    assert not found.finite
    assert found.error < 1e-9
