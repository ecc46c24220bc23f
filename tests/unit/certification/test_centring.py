"""Platforms whose coordinates are thousands of lengths away from the origins of their frames."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from gspcli.certification import certify, decide, refine
from gspcli.certification.centring import Centring
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import vector
from gspcli.resources import data_path
from gspcli.solver import solve
from gspcli.spec import load

OFFSETS = np.array([1.0, -2.0, 0.5])


def shifted(instance: Instance, platform: float, base: float) -> Instance:
    """Return the platform with the origins of its frames moved away."""

    def moved(primitive: object, by: float) -> object:
        position = (
            Number.of(x.fraction + Fraction(by) * Fraction(o))
            for x, o in zip(primitive.position, OFFSETS, strict=True)
        )
        return replace(primitive, position=vector(*position))

    return replace(
        instance,
        constraints=tuple(
            replace(c, platform=moved(c.platform, platform), base=moved(c.base, base))
            for c in instance.constraints
        ),
    )


@pytest.fixture(scope="module")
def dietmaier() -> tuple[Instance, np.ndarray, np.ndarray]:
    instance = load(data_path("examples", "dietmaier.yaml"))
    result = solve(instance, certify=False)
    return instance, result.R, result.T


@pytest.mark.parametrize("base", [1e3, 1e7, 1e9])
@pytest.mark.parametrize("platform", [0.0, 1e6])
def test_an_offset_is_no_part_of_the_problem(
    platform: float, base: float, dietmaier: tuple
) -> None:
    instance, R, T = dietmaier
    far = shifted(instance, platform, base)
    moved = T + base * OFFSETS - platform * R @ OFFSETS
    proved = certify(far, R, moved, tolerance=1e-4)
    assert [item.outcome.value for item in proved] == ["certified"] * 40
    assert (proved.distinct, proved.real) == (40, 40)
    if base < 1e9:
        assert decide(far, R, moved).certified.all()


def test_the_tolerance_is_relative_to_the_platform_and_not_to_its_offset(dietmaier: tuple) -> None:
    instance, R, T = dietmaier
    wrong = T + 0.3 * np.eye(3)[0]
    near = certify(instance, R, wrong)
    far = certify(shifted(instance, 0, 1e6), R, wrong + 1e6 * OFFSETS)
    assert near.certified == far.certified == 0
    assert not decide(shifted(instance, 0, 1e6), R, wrong + 1e6 * OFFSETS).certified.any()


def test_digits_are_those_in_the_frames_of_the_instance(dietmaier: tuple) -> None:
    instance, R, T = dietmaier
    far = shifted(instance, 0, 2.0**20)
    here = refine(instance, certify(instance, R[:1], T[:1])[0], 30)
    there = refine(far, certify(far, R[:1], T[:1] + 2.0**20 * OFFSETS)[0], 40)
    for x, y, offset in zip(here.T, there.T, OFFSETS, strict=True):
        assert abs(Fraction(y) - Fraction(x) - 2**20 * Fraction(offset)) < Fraction(1, 10**29)
    assert [[x[:20] for x in row] for row in here.R] == [[x[:20] for x in row] for row in there.R]


def test_nothing_is_moved_without_need(dietmaier: tuple) -> None:
    instance, _, _ = dietmaier
    assert Centring.of(instance).is_none
    assert Centring.of(instance).applied(instance) is instance
    assert not Centring.of(shifted(instance, 0, 100)).is_none
