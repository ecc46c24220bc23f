from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matching import pose_set_distance

from gspcli.catalogue.parsing import parse_type
from gspcli.errors import ArgumentError, GspError
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
    with pytest.raises(ArgumentError, match=r"^values: found shape \(6,\), expected \(batch, 6\)"):
        solve_values(instance, np.ones(6))
    with pytest.raises(ArgumentError, match=r"^values: found what is no array of numbers"):
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
