"""Constraints that do not hold at poses known to many digits."""

from __future__ import annotations

import pytest

from gspcli.certification import certify, refine
from gspcli.certification.poses.certificates import excluded
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.resources import data_path
from gspcli.solver import solve
from gspcli.spec import load


@pytest.fixture(scope="module")
def dietmaier() -> Instance:
    return load(data_path("examples/dietmaier.yaml"))


def test_a_value_that_is_off_by_the_fortieth_decimal(dietmaier: Instance) -> None:
    result = solve(dietmaier)
    pose = refine(dietmaier, certify(dietmaier, result.R[:1], result.T[:1])[0], 50)
    assert not excluded(dietmaier, pose)
    for k, row in enumerate(dietmaier.constraints):
        for power, expected in ((40, True), (60, False)):
            other = Number.of(f"{row.value} + 1e-{power}")
            assert excluded(dietmaier.with_values({k: other}), pose) is expected
