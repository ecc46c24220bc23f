"""Answers do not depend on how a machine is stated: each command, each way, several machines."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

import gspcli
from tests.support.matching import pose_set_distance
from tests.support.restated import Array, Statement, statements

Answer = dict[str, Any]
#: Machines of legs, lines, planes, cranks and slides: what their clearances are measured in.
MACHINES = {
    "workspace-study": "",
    "rubin-m2": "",
    "nano-hexapod": "length",
    "example-6.8": "mixed",
    "fixture-3-2-1": "length",
    "tricept": "mixed",
    "t-top-head": "angle",
    "hexaglide": "",
}
WAYS = (
    "another order",
    "platform moved",
    "base moved",
    "bodies exchanged",
    "in m",
    "in mm",
    "in in",
    "in radians",
)


def solve(s: Statement, R: Array, T: Array) -> Answer:
    result = gspcli.solve(s.instance)
    real = result.real
    told = (result.verdict, result.expected, result.counts.found, result.counts.real)
    return {"told": told, "poses": s.first(result.R[real].real, result.T[real].real)}


def count(s: Statement, R: Array, T: Array) -> Answer:
    found = gspcli.count(s.instance)
    counts = [found.exact, found.geometry]
    told = [(one.finite, one.solutions, one.distinct, one.spurious) for one in counts if one]
    return {"told": (told, found.type_count)}


def certify(s: Statement, R: Array, T: Array) -> Answer:
    poses = s.pose(np.concatenate([R, R]), np.concatenate([T, T * 1.01 + 0.01]))
    return {"told": [(one.certified, one.real) for one in gspcli.certify(s.instance, *poses)]}


def measure(s: Statement, R: Array, T: Array) -> Answer:
    return {"numbers": s.values(np.abs(gspcli.measure(s.instance, *s.pose(R, T))))}


def analyze(s: Statement, R: Array, T: Array) -> Answer:
    point = s.place([0.1, 0.2, 0.3], R[0], T[0])
    found = gspcli.analyze(s.instance, *s.pose(R[0], T[0]), point=point, length=0.5 * s.length)
    return {"numbers": found.to_frame()["condition"].to_numpy()}


def clearance(s: Statement, R: Array, T: Array) -> Answer:
    found = gspcli.clearance(s.instance, *s.pose(R[:1], T[:1]))
    return {"bounds": np.concatenate([found.lower, found.upper])}


def freedoms(s: Statement, R: Array, T: Array) -> Answer:
    return {"told": gspcli.freedoms(s.instance, *s.pose(R[0], T[0])).rank}


def scan(s: Statement, R: Array, T: Array) -> Answer:
    row = s.order.index(0)
    value = s.instance.constraints[row].value.value
    found = gspcli.scan(s.instance, {row + 1: value * np.array([0.97, 0.99, 1.001, 1.02])})
    return {"told": found.found.numbers["modes"].tolist()}


def track(s: Statement, R: Array, T: Array) -> Answer:
    values = np.array([row.value.value for row in s.instance.constraints])
    found = gspcli.track(s.instance, values * (1 + 1e-3 * np.arange(4)[:, None]))
    end = np.isfinite(found.R[:, -1]).all(axis=(1, 2))
    return {"told": len(end), "poses": s.first(found.R[end, -1], found.T[end, -1])}


def path(s: Statement, R: Array, T: Array) -> Answer:
    start = s.pose(R[0], T[0])
    goal = s.pose(R[0], T[0] * 1.001)
    found = gspcli.path(s.instance, start, goal, along="values")
    return {"told": found.verdict, "poses": s.first(found.R[-1:], found.T[-1:])}


def workspace(s: Statement, R: Array, T: Array) -> Answer:
    if s.instance.constraints[0].limits is None:
        return {}
    found = gspcli.workspace(s.instance, *s.pose(R[0], T[0]), tolerance=0.3)
    return {"volume": np.array(found.volume) / s.length**3}


COMMANDS = (
    solve,
    count,
    certify,
    measure,
    analyze,
    clearance,
    freedoms,
    scan,
    track,
    path,
    workspace,
)


#: What takes seconds is asked once; a condition weighs displacements of the platform's points.
LEFT_OUT = {
    "fixture-3-2-1": {(clearance, way) for way in WAYS},
    "t-top-head": {(clearance, way) for way in WAYS if way != "in radians"},
    "hexaglide": {(clearance, way) for way in WAYS if way != "base moved"},
}
CASES = [
    (name, way, command)
    for name in MACHINES
    for way in WAYS
    if way in statements(gspcli.example(name))
    for command in COMMANDS
    if (command, way) not in LEFT_OUT.get(name, ())
    if (command, way) != (analyze, "bodies exchanged")
]


@cache
def first(name: str, command: Callable[..., Answer]) -> tuple[Array, Array, float, Answer]:
    """Return the real poses of a machine, its size, and what a command answers."""
    result = gspcli.solve(gspcli.example(name))
    R, T = result.R[result.real].real, result.T[result.real].real
    return R, T, result.arrangement.length, command(Statement(result.instance), R, T)


@pytest.mark.parametrize(
    ("name", "way", "command"), CASES, ids=lambda x: x if isinstance(x, str) else x.__name__
)
def test_a_command_answers_alike(name: str, way: str, command: Callable[..., Answer]) -> None:
    s = statements(gspcli.example(name))[way]()
    R, T, length, expected = first(name, command)
    answer = command(s, R, T)
    assert answer.get("told") == expected.get("told")
    if "numbers" in expected:
        assert answer["numbers"] == pytest.approx(expected["numbers"], rel=1e-7, abs=1e-7)
    if "poses" in expected:
        assert pose_set_distance(answer["poses"], expected["poses"], length) < 1e-6
    if "bounds" in expected and not (MACHINES[name] == "mixed" and way.startswith("in ")):
        unit = {"length": s.length, "angle": s.angle}.get(MACHINES[name], 1.0)
        (lower, upper), (least, most) = answer["bounds"] / unit, expected["bounds"]
        # Bounds of one number: how near they are to it may depend on the frame.
        assert lower <= most
        assert least <= upper
    if "volume" in expected:
        assert answer["volume"][0] <= expected["volume"][1]
        assert expected["volume"][0] <= answer["volume"][1]
