"""Freedoms that constraints leave: joints of every sort, redundancy, candidates."""

from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli import Line, Plane, Point, angle, distance, freedoms
from gspcli.errors import ArgumentError
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.motion.poses.inverse_kinematics import values_at

UNITS = gspcli.example("dietmaier").units
HERE = np.eye(3), np.zeros(3)
ORIGIN, AXIS, FLOOR = Point([0, 0, 0]), Line([0, 0, 0], [0, 0, 1]), Plane([0, 0, 0], [0, 0, 1])
X = Line([0, 0, 0], [1, 0, 0])


def words(*rows, R=HERE[0], T=HERE[1]):
    return [one.words("mm") for one in freedoms(Instance(tuple(rows), UNITS), R, T).screws]


def test_joints_by_constraints():
    """A ball, a hinge, a slider, a cylinder, a plane contact: what textbooks say."""
    ball = distance(ORIGIN, ORIGIN, 0)
    assert words(ball) == [
        f"rotation about the axis {axis} through (0, 0, 0)"
        for axis in ("(1, 0, 0)", "(0, 1, 0)", "(0, 0, 1)")
    ]
    assert words(ball, angle(AXIS, AXIS, 0)) == [
        "rotation about the axis (0, 0, 1) through (0, 0, 0)"
    ]
    along = distance(ORIGIN, AXIS, 0)
    assert words(along, angle(AXIS, AXIS, 0)) == [
        "rotation about the axis (0, 0, 1) through (0, 0, 0)",
        "translation along (0, 0, 1)",
    ]
    assert words(along, angle(AXIS, AXIS, 0), angle(X, X, 0)) == ["translation along (0, 0, 1)"]
    assert words(distance(ORIGIN, FLOOR, 0), angle(FLOOR, FLOOR, 0)) == [
        "rotation about the axis (0, 0, 1) through (0, 0, 0)",
        "translation along (1, 0, 0)",
        "translation along (0, 1, 0)",
    ]


def test_a_screw_with_its_pitch():
    """Two legs of a hexapod removed or not: the twist of a five-legged platform moves no leg."""
    machine = gspcli.example("platform-6-6")
    home = gspcli.solve(machine).home
    five = Instance(machine.constraints[:5], machine.units, home=None)
    found = freedoms(five, home.R, home.T)
    (screw,) = found.screws
    assert found.rank == 5
    assert screw.pitch
    h, twist = 1e-6, screw.twist
    moved = [
        values_at(
            five, rotation_from_vector(s * h * twist[:3]) @ home.R, home.T + s * h * twist[3:]
        )
        for s in (1, -1)
    ]
    assert np.abs(moved[0] - moved[1]).max() < 1e-9
    # The axis and the pitch are those of the twist.
    size = np.linalg.norm(twist[:3])
    velocity = twist[3:] + np.cross(twist[:3], screw.point - home.T)
    assert velocity == pytest.approx(
        twist[:3] / size * size * screw.pitch / (2 * np.pi),
        abs=1e-9 * machine.coordinates[0] + 1e-9,
    )
    # The sixth leg would take it.
    assert all(one.removes == 1 for one in found.candidates)


@pytest.mark.parametrize("name", ["rubin-m2", "sdss-primary", "example-6.8", "three-rps"])
def test_six_constraints_of_machines_leave_nothing(name):
    machine = gspcli.example(name)
    result = gspcli.solve(machine)
    found = freedoms(machine, result.home.R, result.home.T)
    assert (found.rank, found.screws, found.redundant) == (6, (), {})
    assert np.abs(found.off).max() < 1e-6


@pytest.mark.parametrize("count", range(1, 6))
def test_each_leg_takes_one(count):
    machine = gspcli.example("workspace-study")
    home = gspcli.solve(machine).home
    found = freedoms(Instance(machine.constraints[:count], machine.units), home.R, home.T)
    assert found.rank == count
    assert len(found.screws) == 6 - count
    twists = np.array([one.twist for one in found.screws])
    assert np.linalg.matrix_rank(twists) == 6 - count


def test_a_singular_pose_has_a_freedom_and_a_redundant_leg():
    machine = gspcli.example("singular-pose")
    home = gspcli.solve(machine).home
    found = freedoms(machine, home.R, home.T)
    assert (found.rank, len(found.screws)) == (5, 1)
    assert found.redundant == {6: (1, 2, 3, 4, 5)}
    assert found.sentences[1].startswith("constraint 6 is redundant: 1, 2, 3, 4 and 5 already")


def test_more_than_six_name_the_redundant_ones():
    machine = gspcli.example("rubin-m2")
    home = gspcli.solve(machine).home
    again = (*machine.constraints, machine.constraints[2])
    found = freedoms(Instance(again, machine.units), home.R, home.T)
    assert found.redundant == {7: (3,)}
    assert found.sentences[1] == "constraint 7 is redundant: 3 already prevents what it prevents"


def test_candidates_restrain_what_they_say():
    """Of a cylinder: a distance along the axis takes the slide, an angle across it the turn."""
    rows = (distance(ORIGIN, AXIS, 0), angle(AXIS, AXIS, 0))
    platform, base = {"P": ORIGIN, "L": AXIS, "X": X}, {"H": FLOOR, "L": AXIS, "X": X}
    further = [("platform", name, one) for name, one in platform.items()]
    further += [("base", name, one) for name, one in base.items()]
    found = freedoms(Instance(rows, UNITS, further=tuple(further)), *HERE)
    assert [one.point is None for one in found.screws] == [False, True]
    by = {(one.kind.name, one.platform, one.base): one.touches for one in found.candidates}
    assert by["DPH", "P", "H"] == (2,)
    assert by["ALL", "X", "X"] == (1,)
    assert ("ALL", "L", "L") not in by
    # A turn about the axis moves neither the point nor the axis.
    assert ("DPL", "P", "L") not in by


def test_zero_distances_take_what_they_take():
    """Along a random pose: ranks of coincidences by the derivative of vectors."""
    rng = np.random.default_rng(1)
    R, T = rotation_from_vector(rng.normal(size=3)), rng.normal(size=3)
    p = rng.normal(size=3)
    at = (R @ p + T).tolist()
    direction = rng.normal(size=3)
    there = (R @ direction).tolist()
    other = (np.array(at) + 3 * np.array(there)).tolist()
    for row, rank in (
        (distance(Point(p.tolist()), Point(at), 0), 3),
        (distance(Point(p.tolist()), Line(at, there), 0), 2),
        (distance(Line(p.tolist(), direction.tolist()), Point(other), 0), 2),
        (angle(Line(p.tolist(), direction.tolist()), Line(at, there), 0), 2),
        (distance(Point(p.tolist()), Plane(at, there), 0), 1),
    ):
        found = freedoms(Instance((row,), UNITS), R, T)
        assert found.rank == rank, row.kind
        h = 1e-4
        for screw in found.screws:
            step = h * screw.twist / np.linalg.norm(screw.twist)
            moved = rotation_from_vector(step[:3]) @ R, T + step[3:]
            # Nothing of first order.
            value = values_at(Instance((row,), UNITS), *moved)[0]
            assert abs(value) < 1e-2 * h * 60


def test_what_is_needed():
    with pytest.raises(ArgumentError, match="found no pose"):
        freedoms(Instance((distance(ORIGIN, FLOOR, 1),), UNITS))
    with pytest.raises(ArgumentError, match="found none"):
        freedoms(Instance((), UNITS), *HERE)


def test_files_with_any_number(tmp_path):
    text = gspcli.dumps(gspcli.example("rubin-m2"))
    lines = text.splitlines()
    start = lines.index("constraints:")
    del lines[start + 1 : start + 3]
    path = tmp_path / "four.yaml"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    with pytest.raises(
        gspcli.SpecError, match="expected exactly six; gsp freedoms takes any number"
    ):
        gspcli.load(path)
    four = gspcli.spec.read(path, any_number=True).instance
    assert len(four.constraints) == 4
    assert freedoms(four).rank == 4
