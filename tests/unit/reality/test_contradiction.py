"""Which constraints contradict each other, where that is known beforehand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gspcli.catalogue.kinds import DLP, DPL, DPP, KINDS_BY_NAME
from gspcli.catalogue.names import parse_type
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.measurement import measured
from gspcli.geometry.quaternions import rotation_from_quaternion, unit_quaternion
from gspcli.geometry.random_instances import random_instance
from gspcli.reality.contradiction import contradiction
from gspcli.resources import instance_files
from gspcli.spec import load, loads


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


SHORT_LEG = """
gsp: 1
units: {length: mm, angle: deg}
platform:
  P1: {point: [0, 0, 0]}
  P2: {point: [100, 0, 0]}
  P3: {point: [0, 100, 0]}
  P4: {point: [0, 0, 100]}
  P5: {point: [70, 70, 30]}
  P6: {point: [-50, 20, 80]}
base:
  B1: {point: [0, 0, 0]}
  B2: {point: [140, 30, 10]}
  B3: {point: [20, 130, -20]}
  B4: {point: [10, -20, 150]}
  B5: {point: [90, 80, 40]}
  B6: {point: [-90, 40, 90]}
constraints:
  - {distance: [P1, B1], value: 0.01}
  - {distance: [P2, B2], value: 156.2}
  - {distance: [P3, B3], value: 196.5}
  - {distance: [P4, B4], value: 87.4}
  - {distance: [P5, B5], value: 148.7}
  - {distance: [P6, B6], value: 43.0}
"""


@pytest.mark.parametrize("short", [0.0, 0.01, 0.1])
def test_legs_that_a_pose_meets_beside_a_short_one_are_no_contradiction(short: float) -> None:
    """Legs 1, 5 and 6 are met; with leg 4 too, some length is wrong by 7 mm or more."""
    platform = Arrangement.of(loads(SHORT_LEG))
    T = np.array([0.005425872439604645, -0.003954788412561141, -0.007410773029695505])
    q = [0.7464955677635096, 0.3921478117671411, -0.30940495726750433, -0.4395827947656415]
    found = measured(platform, rotation_from_quaternion(np.array(q)), T)
    assert np.allclose(found[[0, 4, 5]], platform.values[[0, 4, 5]], atol=1e-9)
    assert contradiction(platform.with_values(np.array([short, *platform.values[1:]]))) == (
        0,
        3,
        4,
        5,
    )


#: Kinds of short distances of platforms whose other distances are legs.
SHORT = ["DPP", "DPP DPP", "DPL DPL", "DLP DLP", "DPP DPL", "DPP DPL DLP"]


@pytest.mark.parametrize("count", [4, 5])
@pytest.mark.parametrize("short", [0.0, 0.01, 0.1])
@pytest.mark.parametrize("names", SHORT)
def test_short_distances_beside_long_legs_that_are_met(names, short: float, count: int) -> None:
    """Of random platforms with only some constraints, which a pose meets: nothing contradicts."""
    kinds = [KINDS_BY_NAME[name] for name in names.split()]
    kinds += [DPP] * (count - len(kinds))
    for seed in range(5):
        rng = np.random.default_rng(seed)
        R = rotation_from_quaternion(unit_quaternion(rng.standard_normal(4)))
        y = rng.uniform(-100, 100, (count, 3))
        lines = unit_quaternion(rng.standard_normal((count, 3)))
        v = lines * np.array([[kind is DPL] for kind in kinds])
        w = lines * np.array([[kind is DLP] for kind in kinds])
        legs = (rng.uniform(0.2, 0.6, (count, 1)) * (y - y[0])) @ R.T
        legs += 3 * rng.standard_normal((count, 3))
        for k in range(len(names.split())):
            axis = v[k] + w[k]
            across = rng.standard_normal(3)
            across = unit_quaternion(across - axis * (axis @ across))
            legs[k] = short * across + axis * rng.uniform(-50, 50)
        given = _arrangement("dietmaier")
        keep = {name: getattr(given, name)[:count] for name in ("values", "sides")}
        geometry = {"kinds": tuple(kinds), "y": y, "x": y @ R.T - legs, "u": w @ R, "v": v}
        platform = replace(given, **geometry, **keep)
        met = platform.with_values(measured(platform, R, np.zeros(3)))
        assert met.values[0] == pytest.approx(short, abs=1e-12)
        assert contradiction(met) == ()
