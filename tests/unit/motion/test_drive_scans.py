"""Scans over what motors do: each node is the machine with its joints moved."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.coordinates import choose, moved
from gspcli.geometry.instance import HomePose
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import condition_numbers
from gspcli.geometry.numbers import Number
from gspcli.motion.files.pose_files import PoseFormat
from gspcli.motion.following.branch_follower import MovingGeometry
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.motion.singularities.clearances import clearances, weights_of
from gspcli.motion.singularities.scans import Axis, VariedPoses, scan, scan_grid
from tests.support.driven_machines import driven


@pytest.mark.parametrize(
    ("name", "drive"),
    [
        ("6-PUS", "slide.B2"),
        ("delta", "slide.B3"),
        ("mixed", "crank.P1"),
        ("t-top-head", "crank.B1"),
    ],
)
def test_nodes_are_solved_with_the_joints_moved(name, drive):
    """As `solve` of a platform whose points were moved by `coordinates.moved`."""
    machine = driven(name)
    places = [-0.05, 0.0, 0.04] if drive.startswith("slide") else [-20.0, 0.0, 35.0]
    found = scan(machine, {drive: places})
    for place, modes, condition in zip(
        places, found.found.numbers["modes"], found.found.numbers["condition"], strict=True
    ):
        there = gspcli.solve(moved(machine, choose(machine, [drive]), np.array([place])))
        assert there.verdict == "complete"
        assert modes == there.real.sum()
        assert condition == pytest.approx(there.conditions[there.real].min(), rel=1e-6)
    assert list(found.to_frame().columns) == [drive, "modes", "condition"]
    assert found.to_json()["vary"] == {drive: places}


def test_a_motor_and_a_value_vary_together():
    machine = driven("mixed")
    free = int(np.flatnonzero(~Machine.of(machine).driven)[0])
    value = machine.constraints[free].value.value
    found = scan(machine, {"crank.P1": [0.0, 30.0], free + 1: [value, 1.02 * value]})
    assert found.names == ["crank.P1", str(free + 1)]
    there = moved(machine, choose(machine, ["crank.P1"]), np.array([30.0]))
    there = there.with_values({free: Number.of(1.02 * value)})
    assert found.found.numbers["modes"][1, 1] == gspcli.solve(there).real.sum()
    assert found.found.numbers["modes"][0, 0] == gspcli.solve(machine).real.sum()


def test_readings_are_corrected():
    """A reading of 0.02 is 0.05 along the rail."""
    machine = driven("6-PUS")
    row = machine.constraints[0]
    slide = gspcli.Slide(row.base.slide.direction, None, None, 0.01, 1.0)
    changed = replace(row, base=replace(row.base, slide=slide))
    read = replace(machine, constraints=(changed, *machine.constraints[1:]))
    one = scan(read, {"slide.B1": [-0.03, 0.02]}).found
    other = scan(machine, {"slide.B1": [-0.05, 0.05]}).found
    assert one.numbers["modes"].tolist() == other.numbers["modes"].tolist()
    np.testing.assert_allclose(one.numbers["condition"], other.numbers["condition"], rtol=1e-9)


def _least_singular_value(machine, moves, R, T):
    """Of the Jacobian matrix (free of units) with the joints where motors and values are."""
    there = moved(machine, choose(machine, list(moves)), np.array(list(moves.values())))
    return 1 / condition_numbers(Arrangement.of(there), R[None], T[None])[0]


@pytest.mark.parametrize(
    ("name", "drive", "ends", "count"),
    [
        ("t-top-head", "crank.B1", [-30.0, 0.0, 30.0], 2),
        ("6-PUS", "slide.B1", [0.0, 0.2, 0.4], None),
        ("mixed", "slide.P5", [0.0, 0.3, 0.6], None),
    ],
)
def test_folds_over_a_motor_are_where_two_modes_meet(name, drive, ends, count):
    machine = driven(name)
    result = scan(machine, {drive: ends}, folds=True)
    assert result.limits.unexplained == []
    assert len(result.limits.crossings) == count or (count is None and result.limits.crossings)
    for fold in result.limits.crossings:
        (at,) = fold.values
        assert _least_singular_value(machine, {drive: at}, fold.R, fold.T) < 1e-6
        # Two modes more on the one side than on the other, a thousandth of the range away.
        near = 1e-3 * (ends[-1] - ends[0])
        before, after = scan(machine, {drive: [at - near, at + near]}).found.numbers["modes"]
        assert after - before == fold.change
    changes = [
        np.diff(result.found.numbers["modes"]).sum(),
        sum(one.change for one in result.limits.crossings),
    ]
    assert changes[0] == changes[1]


def test_folds_over_two_motors_are_curves():
    machine = driven("t-top-head")
    names = ["crank.B1", "crank.B2"]
    result = scan(machine, dict(zip(names, ([15.0, 25.0], [-5.0, 5.0]), strict=True)), folds=True)
    assert result.limits.unexplained == []
    assert [len(result.limits.crossings), len(result.limits.curves)] == [2, 1]
    (curve,) = result.limits.curves
    assert len(curve.values) > 4
    platform = MovingGeometry(machine, choose(machine, names))
    for values, unknowns in zip(curve.values, curve.unknowns, strict=True):
        R, T = platform.poses(unknowns[:8])
        assert _least_singular_value(machine, dict(zip(names, values, strict=True)), R, T) < 1e-7
        there = moved(machine, choose(machine, names), values)
        assert values_at(there, R[None], T[None])[0] == pytest.approx(
            [row.value.value for row in machine.constraints], rel=1e-9
        )
    # The curve passes through the folds that are proved on the edges.
    for fold in result.limits.crossings:
        assert np.linalg.norm(curve.values - np.array(fold.values), axis=1).min() < 0.5


def test_folds_over_a_motor_and_a_value():
    machine = driven("t-top-head")
    length = machine.constraints[2].value.value
    nodes = {"crank.B1": [15.0, 25.0], 3: [length, 1.0001 * length]}
    result = scan(machine, nodes, folds=True)
    assert result.limits.unexplained == []
    (curve,) = result.limits.curves
    assert curve.values[:, 1] == pytest.approx(length, rel=1.1e-4)
    assert all(one.values[0] == pytest.approx(21.78, abs=0.2) for one in result.limits.crossings)


def test_folds_are_told_as_readings():
    machine = driven("t-top-head")
    row = machine.constraints[0]
    crank = replace(row.base.crank, offset=Number.of(5), scale=Number.of(1))
    read = replace(
        machine,
        constraints=(replace(row, base=replace(row.base, crank=crank)), *machine.constraints[1:]),
    )
    (one,) = scan(machine, {"crank.B1": [15.0, 25.0]}, folds=True).limits.crossings
    (other,) = scan(read, {"crank.B1": [5.0, 10.0]}, folds=True).limits.crossings
    assert other.values[0] * 2 + 5 == pytest.approx(one.values[0], rel=1e-12)
    nodes = {"crank.B1": [5.0, 10.0], "crank.B2": [-5.0, 5.0]}
    result = scan(read, nodes, folds=True)
    (curve,) = result.limits.curves
    assert [fold.values[1] for fold in result.limits.crossings] == [-5, 5]
    # The curve passes at the one fold of before, where the second crank is still.
    assert np.interp(0, *curve.values[np.argsort(curve.values[:, 1])].T[::-1]) == pytest.approx(
        other.values[0], abs=0.02
    )


@pytest.mark.parametrize(
    ("name", "drive", "places"), [("6-PUS", "slide.B2", [0.04]), ("t-top-head", "crank.B1", [15.0])]
)
def test_the_clearance_of_a_node_is_the_least_of_its_modes(name, drive, places):
    machine = driven(name)
    found = scan(machine, {drive: places}, clearance=True)
    drives = Machine.of(machine)
    for place, clearance in zip(places, found.found.numbers["clearance"], strict=True):
        readings = np.zeros(drives.count)
        readings[drives.names.index(drive)] = place
        q = drives.from_readings(readings)
        there = gspcli.solve(drives.instance_at(q))
        R, T = there.R[there.real].real, there.T[there.real].real
        least = []
        for k in range(len(T)):
            one = slice(k, k + 1)
            working_modes = np.sign(drives.gains(R[one], T[one], q[None]))[0]
            assert drives.inverse(R[k], T[k], working_modes) == pytest.approx(q, abs=1e-9)
            least.append(clearances(drives, R[one], T[one], working_modes=working_modes)[0][0])
        assert clearance == pytest.approx(min(least), rel=1e-3)
        assert clearance > 0
    assert list(found.to_frame().columns) == [drive, "modes", "condition", "clearance"]


def test_no_fold_is_nearer_than_the_clearance():
    machine = driven("t-top-head")
    found = scan(machine, {"crank.B1": [15.0, 25.0]}, folds=True, clearance=True)
    (fold,) = found.limits.crossings
    near = found.found.numbers["clearance"] * weights_of(Machine.of(machine))[0][0] / np.radians(1)
    assert 0 < near[0] <= fold.values[0] - 15
    assert 0 < near[1] <= 25 - fold.values[0]


def test_what_is_not_supported_is_said():
    machine = driven("6-PUS")
    with pytest.raises(ArgumentError, match=r"found 'slide\.B9', expected a number from 1 to 6 or"):
        scan(machine, {"slide.B9": [0.0, 0.1]})
    with pytest.raises(ArgumentError, match="found constraint 7, expected a number from 1 to 6"):
        scan(machine, {7: [0.0, 0.1]})


def test_determinants_at_poses_are_those_of_the_moved_joints():
    """Arms turn with the pose; where they do not reach, there is no determinant."""
    machine = driven("t-top-head")
    home = machine.home
    assert isinstance(home, HomePose)
    z = home.T[2]
    pose, form = [0, 0, z + 0.005, 1, 0, 0, 0], PoseFormat()
    varied = VariedPoses(machine, (Axis("x", (-0.5, 0.0, 0.01)),), pose, form)
    found = scan_grid(varied)
    determinants = found.numbers["determinant"]
    assert np.isnan(determinants[0])
    assert varied.singular(found) == {}
    drives = Machine.of(machine)
    for k, x in ((1, 0.0), (2, 0.01)):
        R, T = np.eye(3), np.array([x, 0, z + 0.005])
        there = drives.instance_at(drives.inverse(R, T))
        axes = (Axis("x", (x - 1e-9, x)),)
        alone = scan_grid(VariedPoses(there, axes, pose, form))
        assert determinants[k] == pytest.approx(alone.numbers["determinant"][1], rel=1e-6)
        rows = tuple(
            replace(row, base=gspcli.Point(row.base.position)) for row in machine.constraints
        )
        stated = scan_grid(VariedPoses(replace(machine, constraints=rows), axes, pose, form))
        assert abs(stated.numbers["determinant"][1] / determinants[k] - 1) > 1e-3
    with pytest.raises(ArgumentError, match="gsp clearance has that of one pose"):
        scan_grid(varied, clearance=True)
