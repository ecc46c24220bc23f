"""Which constraints contradict each other, where that is known beforehand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gspcli.catalogue.names import parse_type
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.random_instances import random_instance
from gspcli.reality.contradiction import contradiction
from gspcli.resources import instance_files
from gspcli.spec import load


def _arrangement(name: str, **values: float) -> Arrangement:
    arrangement = Arrangement.of(load(instance_files()[name]))
    changed = arrangement.values.copy()
    for key, value in values.items():
        changed[int(key.removeprefix("c")) - 1] = value
    return arrangement.with_values(changed)


@pytest.mark.parametrize(
    ("name", "values", "expected"),
    [
        # x² + y² = 50, x² + z² = 1 and y² + z² = 25 have no real solution, any two of them have.
        ("example-6.8", {"c4": 50**0.5, "c5": 1}, (3, 4, 5)),
        # All is well with the numbers of the paper.
        ("example-6.8", {}, ()),
        ("dietmaier", {}, ()),
    ],
)
def test_known_contradictions(name, values, expected) -> None:
    assert contradiction(_arrangement(name, **values)) == expected


def test_two_legs_whose_lengths_differ_by_more_than_their_joints_are_apart() -> None:
    platform = _arrangement("no-real-pose")
    first, second = contradiction(platform)
    apart = [np.linalg.norm(points[first] - points[second]) for points in (platform.y, platform.x)]
    assert abs(platform.values[first] - platform.values[second]) > sum(apart)


@pytest.mark.parametrize(("name", "seed", "value"), [("6PL", 1, 0.0), ("2PP 4PL", 19, 236.6)])
def test_a_matrix_that_rounding_makes_singular_is_no_obstacle(name, seed, value) -> None:
    """Few equations for six unknowns: the damping alone keeps the matrix regular."""
    rng = np.random.default_rng(seed)
    instance, _ = random_instance(parse_type(name), rng)
    values = [value, *(row.value.value for row in instance.constraints[1:])]
    changed = Arrangement.of(instance).with_values(np.array(values))
    found = contradiction(changed)
    assert set(found) <= set(range(6))


@pytest.mark.parametrize("seed", range(4))
def test_special_geometries_have_an_answer(seed: int) -> None:
    """All points in one place, on one line, in one plane: the Jacobian loses ranks everywhere."""
    rng = np.random.default_rng(seed)
    platform = _arrangement("no-real-pose")
    keep = np.arange(3) < seed % 4
    values = np.abs(rng.standard_normal(6)) * platform.length
    special = replace(platform, y=platform.y * keep, x=platform.x * keep[::-1])
    contradiction(special.with_values(values))
