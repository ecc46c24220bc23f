from __future__ import annotations

import numpy as np
import pytest
from matching import pose_set_distance

from gspcli.catalogue.parsing import parse_type
from gspcli.geometry.numbers import Number
from gspcli.solver import solve, solve_values
from gspcli.solver.generate import random_instance


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
        single = solve(instance.with_values(numbers), certify=False)
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
    with pytest.raises(ValueError, match=r"\(batch, 6\), not \(6,\)"):
        solve_values(instance, np.ones(6))


def test_no_values_no_results():
    assert list(solve_values(instance_of("DPL DPL DLP ALL ALH AHH"), np.ones((0, 6)))) == []
