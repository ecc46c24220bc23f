"""Which constraints contradict each other, where that is known beforehand."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.geometry.arrangement import Arrangement
from gspcli.resources import instance_files
from gspcli.solver.contradiction import contradiction
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
