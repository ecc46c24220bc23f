"""Where the lines of a DLL are parallel its equation holds at every distance: no pose."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gspcli.catalogue.names import parse_type
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.measurement import measured
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Line, vector
from gspcli.geometry.random_instances import random_instance
from gspcli.solver import SolveResult, solve
from gspcli.spec import loads

SPEC = """
gsp: 1
units: {{length: m, angle: deg}}
platform:
  L: {{line: {{point: [0, 0, 0], direction: [0, 0, 1]}}}}
  P1: {{point: [0.3, 0.2, 0.1]}}
  P2: {{point: [-0.3, 0.4, 0.5]}}
  P3: {{point: [0.1, -0.6, 0.3]}}
  P4: {{point: [0.5, 0.6, -0.3]}}
base:
  l: {{line: {{point: [0.25, 0, 0], direction: [0, 0, 1]}}}}
  p1: {{point: [1, 0, 0]}}
  p2: {{point: [0, 1.2, 0.1]}}
  p3: {{point: [-0.8, 0.1, 0.4]}}
  p4: {{point: [-0.8, -0.9, 0.4]}}
constraints:
  - {{distance: [L, l], value: {distance}}}
  - {{angle: [L, l], value: {angle}}}
  - {{distance: [P1, p1], value: sqrt(0.7*0.7 + 0.2*0.2 + 0.1*0.1)}}
  - {{distance: [P2, p2], value: sqrt(0.3*0.3 + 0.8*0.8 + 0.4*0.4)}}
  - {{distance: [P3, p3], value: sqrt(0.9*0.9 + 0.7*0.7 + 0.1*0.1)}}
  - {{distance: [P4, p4], value: sqrt(1.3*1.3 + 1.5*1.5 + 0.7*0.7)}}
"""


def _solved(distance: str, angle: str) -> SolveResult:
    return solve(loads(SPEC.format(distance=distance, angle=angle)))


def _accounted(result: SolveResult) -> int:
    return int(result.multiplicity.sum()) + result.account.expected - result.account.found


def test_parallel_lines_at_the_distance_asked_for_are_a_pose() -> None:
    result = _solved("0.25", "0")
    assert result.verdict == "complete"
    # The identity is the pose that the values were taken from; its parallel lines are right.
    at_identity = [np.allclose(s.R, np.eye(3), atol=1e-4) for s in result.real_solutions]
    assert sum(at_identity) == 1
    assert result.account.spurious > 0
    assert _accounted(result) == result.expected


def test_parallel_lines_at_another_distance_are_none() -> None:
    result = _solved("0.3", "0")
    assert result.verdict == "complete"
    # The others are complex directions whose difference is isotropic: not parallel, angle zero.
    assert not result.real_solutions
    assert result.account.spurious > 0
    assert _accounted(result) == result.expected


def test_lines_that_are_not_parallel_are_left_alone() -> None:
    result = _solved("0.25", "20")
    assert result.account.spurious == 0
    assert _accounted(result) == result.expected


def test_nearly_parallel_lines_are_a_pose() -> None:
    """A regular end is never spurious: the lines are 1e-6 from parallel and the pose is simple."""
    rng = np.random.default_rng(3)
    instance, (R, T) = random_instance(parse_type("5PP DLL"), rng)
    tilted = instance.constraints[5]
    # The line of the platform is turned to be almost parallel to that of the base at the pose.
    along = R.T @ (tilted.base.unit + 1e-6 * np.cross(tilted.base.unit, [1.0, 2.0, 3.0]))
    line = Line(tilted.platform.position, vector(*map(float, along)))
    arrangement = Arrangement.of(
        replace(instance, constraints=(*instance.constraints[:5], replace(tilted, platform=line)))
    )
    values = np.abs(measured(arrangement, R, T))
    moved = replace(
        instance,
        constraints=tuple(
            replace(c, platform=line if i == 5 else c.platform, value=Number.of(float(values[i])))
            for i, c in enumerate(instance.constraints)
        ),
    )
    result = solve(moved)
    assert result.account.spurious == 0
    distance = min(np.abs(s.R - R).max() + np.abs(s.T - T).max() for s in result.real_solutions)
    assert distance < 1e-6
