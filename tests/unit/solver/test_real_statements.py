"""Real poses that cannot move, on sets of complex solutions that are infinite."""

from __future__ import annotations

import re

import numpy as np
import pytest

from gspcli.pictures.stage import scene_of
from gspcli.solver import SolveResult, solve
from gspcli.solver.by_count import isolated_real_poses
from gspcli.spec import loads

#: A ball in a seat at the origin, a ball in a groove along the x axis, a ball on the table: real
#: poses put B at (±40, 0, 0) and C at (0, ±30, 0).
SEAT = """
gsp: 1
units: {{length: mm, angle: deg}}
platform:
  A: {{point: [0, 0, 0]}}
  B: {{point: [40, 0, 0]}}
  C: {{point: [0, 30, 0]}}
base:
  O: {{point: [0, 0, 0]}}
  groove: {{line: {{point: [0, 0, 0], direction: [1, 0, 0]}}}}
  table: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}
constraints:
  - {{distance: [A, O], value: 0}}
  - {{distance: [B, groove], value: 0}}
  - {{distance: [C, table], value: 0}}
  - {{distance: [B, O], value: {along}}}
  - {{distance: [C, O], value: 30}}
  - {{distance: [A, table], value: 0}}
"""
#: A shaft in a hole, two points and the direction of which are given, with a key that K = (8 cos t,
#: 8 sin t, 10) stands for: it is 6 - y from the wall.
SHAFT = """
gsp: 1
units: {{length: mm, angle: {unit}}}
platform:
  shaft: {{line: {{point: [0, 0, 0], direction: [0, 0, 2]}}}}
  O: {{point: [0, 0, 0]}}
  E: {{point: [0, 0, 50]}}
  K: {{point: [8, 0, 10]}}
base:
  hole: {{line: {{point: [0, 0, 0], direction: [0, 0, {direction}]}}}}
  end: {{plane: {{point: [0, 0, 0], normal: [0, 0, 1]}}}}
  wall: {{plane: {{point: [0, 6, 0], normal: [0, 1, 0]}}}}
constraints:
  - {{angle: [shaft, hole], value: {angle}}}
  - {{distance: [O, hole], value: 0}}
  - {{distance: [O, end], value: 0}}
  - {{distance: [K, wall], value: {gap}}}
  - {{distance: [E, hole], value: 0}}
  - {{distance: [E, end], value: 50}}
"""


def lone(text: str) -> SolveResult:
    result = solve(loads(text))
    assert result.verdict == "infinite"
    assert result.proof is not None
    return result.lone


def turns(result: SolveResult) -> list[float]:
    """Return the sines of turns about the z axis, which all rotations must be."""
    np.testing.assert_allclose(result.R[:, 2, 2], 1, atol=1e-12)
    return sorted(result.R[:, 1, 0].real.tolist())


def test_ball_in_a_seat() -> None:
    found = lone(SEAT.format(along=40))
    expected = [np.diag([s, t, s * t]) for s in (1.0, -1.0) for t in (1.0, -1.0)]
    assert len(found.R) == len(expected)
    for R in expected:
        assert np.abs(found.R - R).max(axis=(1, 2)).min() < 1e-12
    np.testing.assert_allclose(found.T, 0, atol=1e-12)
    # They are what there is to look at.
    (modes, *_) = scene_of(solve(loads(SEAT.format(along=40)))).series
    assert len(modes) == len(expected)


@pytest.mark.parametrize(("unit", "angle", "direction"), [("deg", 0, 1), ("rad", "pi", -3)])
def test_shaft_in_a_hole(unit: str, angle: object, direction: int) -> None:
    found = lone(SHAFT.format(unit=unit, angle=angle, direction=direction, gap=3))
    # The key is 3 or 9 high, and it reaches up to 8 only.
    np.testing.assert_allclose(turns(found), [3 / 8, 3 / 8], atol=1e-12)


def test_sense_of_a_direction() -> None:
    found = lone(SHAFT.format(unit="deg", angle=180, direction=1, gap=3))
    # Turned over: E is as far below the end as it was above.
    np.testing.assert_allclose(found.R[:, 2, 2], -1, atol=1e-12)
    np.testing.assert_allclose(found.R[:, 1, 0], 3 / 8, atol=1e-12)


@pytest.mark.parametrize(("apart", "poses"), [(5, 0), (0, 2)])
def test_distance_of_parallel_lines(apart: int, poses: int) -> None:
    """Its equation holds at any distance; what is stated does not."""
    text = SHAFT.format(unit="deg", angle=0, direction=1, gap=3)
    other = loads(text.replace("[E, hole], value: 0", f"[shaft, hole], value: {apart}"))
    found = isolated_real_poses(other, lambda platform: solve(platform))
    assert found is not None
    assert len(found) == poses


@pytest.mark.parametrize("size", ["/100000000", "*100000000"])
def test_a_shaft_in_other_units(size: str) -> None:
    """An angle is no length: residuals of both are not compared with the same size."""
    text = SHAFT.format(unit="deg", angle=0, direction=1, gap=3)
    for number in ("50", "8", "10", "6", "3"):
        text = re.sub(rf"(?<=[ \[]){number}(?=[,\]}}])", f"{number}{size}", text)
    found = lone(text)
    np.testing.assert_allclose(turns(found), [3 / 8, 3 / 8], atol=1e-12)


def test_key_that_touches() -> None:
    found = lone(SHAFT.format(unit="deg", angle=0, direction=1, gap=2))
    np.testing.assert_allclose(turns(found), [1 / 2, 1 / 2, 1], atol=1e-7)


def test_planes_that_are_flush() -> None:
    text = """
gsp: 1
units: {length: mm, angle: deg}
platform:
  A: {point: [0, 0, 0]}
  B: {point: [40, 0, 0]}
  C: {point: [0, 30, 0]}
  F: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}
  pin: {line: {point: [0, 0, 3], direction: [0, 0, 1]}}
base:
  P: {point: [10, 0, 0]}
  G: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}
  Q: {point: [70, 20, 5]}
constraints:
  - {angle: [F, G], value: 180}
  - {distance: [A, G], value: 5, side: positive}
  - {distance: [pin, P], value: 0}
  - {distance: [B, Q], value: 50}
  - {distance: [C, G], value: 5, side: positive}
  - {distance: [B, G], value: 5, side: positive}
"""
    found = lone(text)
    assert len(found.R) == 2
    np.testing.assert_allclose(found.T - [10, 0, 5], 0, atol=1e-12)
    # B turns about (10, 0) at the distance 40: where it is 50 from (70, 20).
    B = found.R @ [40, 0, 0] + found.T
    np.testing.assert_allclose(np.linalg.norm(B - [70, 20, 5], axis=1), 50, atol=1e-9)
    assert not np.allclose(B[0], B[1])


def test_platforms_that_move_have_none() -> None:
    turning = SEAT.format(along=40).replace("[A, table], value: 0", "[B, table], value: 0")
    turning = turning.replace("[C, table]", "[A, table]")
    assert solve(loads(turning)).lone.R.shape == (0, 3, 3)
