"""Platforms whose coordinates are thousands of lengths away from the origins of their frames."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from gspcli.certification import certify, refine
from gspcli.certification.equations.local_frames import LocalFrames
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import vector
from gspcli.motion.following.tracks import track
from gspcli.resources import data_path
from gspcli.solver import solve, solve_batch
from gspcli.spec import load, loads

OFFSETS = np.array([1.0, -2.0, 0.5])
DEPENDENT = """
gsp: 1
units: {length: unit, angle: rad}
platform:
  P1: {point: [-0.692, -0.041, 0.935]}
  P2: {point: [-0.464, 0.141, 0.491]}
  P3: {point: [-0.705, 0.87, 0.5]}
  L1: {line: {point: [-0.497, -0.048, 0.107], direction: [-1, 2, -2]}}
  L2: {line: {point: [-0.004, 0.154, 0.004], direction: [-6, -7, -6]}}
  L3: {line: {point: [0.912, -0.262, -0.051], direction: [-9, 8, 12]}}
base:
  H1: {plane: {point: [40000001.62, -80000001.038, 39999998.674], normal: [-30/7, -15/7, -10/7]}}
  H2: {plane: {point: [39999998.06, -79999998.476, 39999999.374], normal: [-10/7, 30/7, -15/7]}}
  H3: {plane: {point: [40000001.972, -79999998.654, 40000000.962], normal:
    [-6918483563837526/700000012761595, -1140338156873919/140000002552319,
    -1560548107473218/700000012761595]}}
  L1: {line: {point: [39999999.972, -80000000.788, 40000001.946], direction: [9, -12, -8]}}
  L2: {line: {point: [39999999.822, -80000001.804, 39999999.086], direction: [-3, -2, -6]}}
  L3: {line: {point: [39999999.734, -80000001.582, 40000001.31], direction: [8, -4, -1]}}
constraints:
  - {distance: [P1, H1], value: 66029/35000, side: positive}
  - {distance: [P2, H2], value: 101263/35000, side: negative}
  - {distance: [P3, H3], value: 1832354874012542569/455000008295036750, side: positive}
  - {angle: [L1, L1], value: acos(-5/21)}
  - {angle: [L2, L2], value: acos(-162/539)}
  - {angle: [L3, L3], value: acos(-118/1071)}
"""


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
    result = solve(instance)
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
        assert certify(far, R, moved).certified == 40


def test_the_tolerance_is_relative_to_the_platform_and_not_to_its_offset(dietmaier: tuple) -> None:
    instance, R, T = dietmaier
    wrong = T + 0.3 * np.eye(3)[0]
    near = certify(instance, R, wrong)
    far = certify(shifted(instance, 0, 1e6), R, wrong + 1e6 * OFFSETS)
    assert near.certified == far.certified == 0


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
    assert LocalFrames.of(instance).is_none
    assert LocalFrames.of(instance).applied(instance) is instance
    assert not LocalFrames.of(shifted(instance, 0, 100)).is_none


def test_poses_of_a_nearly_dependent_platform_far_away_are_as_good_as_nearby() -> None:
    # The planes' normals are dependent up to 1e-4: what doubles of 10^8 have lost, 10^-8, is
    # 10^4 times as large in T, and more than the tolerance.
    far = loads(DEPENDENT)
    solved = solve(far)
    assert (solved.verdict, int(solved.certified.sum())) == ("complete", 8)
    proved = certify(far, solved.R, solved.T)
    assert (proved.certified, proved.distinct) == (8, 8)
    assert max(item.deviation for item in proved) < 1e-6


@pytest.mark.parametrize("offsets", [(0.0, 1e7), (1e6, 0.0), (1e6, 1e7)])
def test_poses_far_away_are_those_nearby(offsets: tuple[float, float], dietmaier: tuple) -> None:
    far = shifted(dietmaier[0], *offsets)
    solved = solve(far)
    assert solved.instance is far
    assert (solved.verdict, int(solved.certified.sum())) == ("complete", 40)
    proved = certify(far, solved.R, solved.T)
    assert proved.real == 40
    assert max(item.deviation for item in proved) < 1e-8


@pytest.mark.parametrize("offsets", [(0.0, 1e7), (1e6, 0.0), (1e6, 1e7)])
def test_poses_of_batches_far_away_are_those_nearby(
    offsets: tuple[float, float], dietmaier: tuple
) -> None:
    instance, _, _ = dietmaier
    far = shifted(instance, *offsets)
    values = np.array([c.value.value for c in instance.constraints])
    rows = np.vstack((values * np.linspace(1, 1.01, 5)[:, None], np.full(6, -1.0)))
    found = solve_batch(far, rows)
    assert found.number.tolist() == [40] * 5 + [0]
    assert found.proved[:5].all()
    given = {i: Number.of(x) for i, x in enumerate(rows[3].tolist())}
    proved = certify(far.with_values(given), found.R[3], found.T[3])
    assert proved.distinct == 40
    assert max(item.deviation * item.length for item in proved) < 1e-8 * proved.scale


def test_translations_taken_back_are_next_to_the_exact_ones() -> None:
    random = np.random.default_rng(7)
    R, T = (random.normal(size=(20, *shape, 2)) @ [1, 1j] for shape in ((3, 3), (3,)))
    origins = [[Fraction(x) for x in row] for row in (1e7 * random.normal(size=(2, 3))).tolist()]
    local_frames = LocalFrames(*map(tuple, origins))
    # What cancels, too: the first is that of the origin of the platform.
    T[0] = (R[0] @ [*map(float, origins[0])]) - [*map(float, origins[1])]
    found = local_frames.doubles_back(R, T)
    for k in range(20):
        for part in ("real", "imag"):
            rotation, place = (
                [*map(Fraction, getattr(x, part).ravel().tolist())] for x in (R[k], T[k])
            )
            for i in range(3):
                row = rotation[3 * i : 3 * i + 3]
                exact = place[i] - sum(r * p for r, p in zip(row, origins[0], strict=True))
                exact += origins[1][i] if part == "real" else 0
                error = abs(Fraction(float(getattr(found[k, i], part))) - exact)
                assert error <= abs(exact) * Fraction(1, 2**53) + Fraction(1, 2**70)


def test_modes_far_away_are_those_nearby(dietmaier: tuple) -> None:
    instance, _, _ = dietmaier
    values = np.array([c.value.value for c in instance.constraints])
    rows = values * np.linspace(1, 1.01, 3)[:, None]
    here, there = track(instance, rows), track(shifted(instance, 1e5, 1e6), rows)
    assert there.certified
    assert np.array_equal(here.modes, there.modes)
    folds = [(event.kind, event.mode, event.partner) for event in here.events]
    assert folds == [(event.kind, event.mode, event.partner) for event in there.events]
    assert folds
    for first, second in zip(here.events, there.events, strict=True):
        assert first.low <= second.high
        assert second.low <= first.high
        assert np.allclose(first.R, second.R, atol=1e-9)
    assert np.allclose(here.R, there.R, atol=1e-9, equal_nan=True)
    back = there.T + 1e5 * there.R @ OFFSETS - 1e6 * OFFSETS
    assert np.allclose(here.T, back, atol=1e-8, equal_nan=True)
