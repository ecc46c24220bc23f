"""Other values for the constraints of an instance: texts, and numbers of all kinds."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from gspcli import ArgumentError, Instance, angle, distance, instance, set_values
from gspcli.geometry.primitives import Line, Point


@pytest.fixture(scope="module")
def platform() -> Instance:
    axes = [Line([k, 0, 1], [1, k, 2]) for k in range(3)]
    rows = [distance(Point([k, k * k, 1]), Point([1, k, k]), k + 1) for k in range(5)]
    return instance([*rows, angle(axes[1], axes[2], 60)])


def values(made: Instance) -> list[str]:
    return [str(row.value) for row in made.constraints]


@pytest.mark.parametrize(
    ("given", "exact"),
    [
        (5, "5"),
        (0.1, "0.1"),
        (np.float32(0.5), "0.5"),
        (np.int64(7), "7"),
        (Fraction(1, 3), "1/3"),
        (Decimal("0.25"), "0.25"),
        ("sqrt(2)", "sqrt(2)"),
    ],
)
def test_any_number_is_taken_exactly(platform: Instance, given: Any, exact: str) -> None:
    assert values(set_values(platform, {2: given})) == ["1", exact, "3", "4", "5", "60"]
    all_six = set_values(platform, [given, 2, 3, 4, 5, 60])
    assert values(all_six)[0] == exact
    assert all_six == set_values(platform, {1: given})


def test_texts_arrays_and_mappings_agree(platform: Instance) -> None:
    one = set_values(platform, ["1=2", "6 = 45"])
    assert (
        one
        == set_values(platform, {1: 2, 6: "45"})
        == set_values(platform, {np.int64(6): 45, 1: 2})
    )
    assert one == set_values(platform, np.array([2, 2, 3, 4, 5, 45]))
    assert set_values(platform, "1=2") == set_values(platform, {1: 2})
    assert set_values(platform, {}) == set_values(platform, []) == platform


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({7: 1}, r"settings\[7\]: found constraint 7, expected a number from 1 to 6"),
        ({0: 1}, r"settings\[0\]: found constraint 0, expected a number from 1 to 6"),
        ({True: 1}, r"settings\[True\]: found constraint True, expected a number from 1 to 6"),
        ({"1": 1}, r"settings\['1'\]: found constraint '1', expected a number from 1 to 6"),
        ({1.5: 1}, r"settings\[1.5\]: found constraint 1.5, expected a number from 1 to 6"),
        ({2: float("nan")}, r"settings\[2\]: found nan, expected a finite number"),
        ({2: None}, r"settings\[2\]: found a NoneType, expected a finite number"),
        ({2: "1/0"}, r"settings\[2\]: found a division by zero"),
        ({2: -1}, r"settings\[2\]: found -1, expected a distance of at least 0"),
        ({6: 181}, r"settings\[6\]: found 181, expected an angle of LL from 0 to 180"),
        ([1, 2, 3, 4, -5, 60], r"settings\[4\]: found -5, expected a distance of at least 0"),
        ([1, 2, 3], r"settings: found 3 values, expected 6, or \{1: 5.2\} for some"),
        (5.2, r"settings: found a float, expected values by number, as \{1: 5.2\}"),
        (np.ones((6, 6)), r"settings\[0\]: found a ndarray, expected a finite number"),
    ],
)
def test_mistakes_name_the_argument_and_the_number(
    platform: Instance, settings: Any, message: str
) -> None:
    with pytest.raises(ArgumentError, match=f"^{message}"):
        set_values(platform, settings)
