"""Arms of cranks with a diameter: which pairs are compared, their gaps, and how far they move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.errors import ArgumentError, SpecError
from gspcli.geometry.expressed_instances import expressed_instance
from gspcli.geometry.frames import PoseFrame
from gspcli.geometry.instance import Instance, Shapes
from gspcli.geometry.machine import Machine
from gspcli.motion.collisions.compared import ComparedShapes
from tests.support.independent_machines import upside_down
from tests.support.thick_legs import poses_near

PLATES = {
    body: [[x * side, y * side, z] for x in (-1, 1) for y in (-1, 1) for z in heights]
    for body, side, heights in (("platform", 0.02, (0, 0.01)), ("base", 0.05, (-0.2, -0.15)))
}


def armed(
    name: str, *, near: float | None = None, plates: bool = False, diameter: float = 0.004
) -> tuple[Instance, np.ndarray, np.ndarray]:
    """Return a machine whose rods and arms have shapes, and its home."""
    solved = gspcli.solve(gspcli.example(name))
    home = 0 if solved.home is None else solved.home.number - 1
    rows = []
    for row in solved.instance.constraints:
        crank = row.base.crank
        base = replace(row.base, crank=replace(crank, diameter=gspcli.Number.of(diameter)))
        rows.append(replace(row, base=base))
    shapes = Shapes(0.002, **(PLATES if plates else {}), near_joint=near)
    instance = replace(solved.instance, constraints=tuple(rows), shapes=shapes)
    return instance, solved.R[home].real, solved.T[home].real


def swapped(instance: Instance) -> Instance:
    """Return the machine upside down: its motors are on the platform."""
    rows, shapes = upside_down(instance), instance.shapes
    turned = Shapes(shapes.diameters, shapes.base, shapes.platform, shapes.near_joint)
    return replace(instance, constraints=rows, shapes=turned, home=None)


def sampled_distance(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> float:
    """Return the distance of two segments, from many points of both."""
    part = np.linspace(0, 1, 401)[:, None]
    first, second = a + (b - a) * part, c + (d - c) * part
    return float(np.linalg.norm(first[:, None] - second, axis=-1).min())


def test_an_arm_leads_from_the_axis_to_the_point() -> None:
    instance, R, T = armed("t-top-head")
    compared = ComparedShapes(instance)
    drives = Machine.of(instance)
    R, T = poses_near(R, T, 4, 0.01, 0.1, 3)
    q = Machine.of(instance).at_home().along(R, T)
    found = compared.gaps(R, T, q)
    b, arm, _ = drives.ends(R, T, q)
    for pose in range(4):
        axis, tip, top = drives.middle, b[pose], arm[pose] + T[pose]
        for name, gap in zip(compared.names, found[pose], strict=True):
            numbers = [int(x) - 1 for x in name.replace("B", " ").split() if x.isdecimal()]
            first, second = numbers
            if name.startswith("legs"):
                expected = sampled_distance(top[first], tip[first], top[second], tip[second])
                assert gap == pytest.approx(expected - 0.002, abs=1e-6)
            elif name.startswith("leg"):
                expected = sampled_distance(top[first], tip[first], axis[second], tip[second])
                assert gap == pytest.approx(expected - 0.003, abs=1e-6)
            else:
                assert name.startswith("the arm of B")
                expected = sampled_distance(axis[first], tip[first], axis[second], tip[second])
                assert gap == pytest.approx(expected - 0.004, abs=1e-6)
    kinds = [name.split(" ")[0] for name in compared.names]
    assert (kinds.count("legs"), kinds.count("leg"), kinds.count("the")) == (15, 30, 15)
    assert "leg 1 and the arm of B1" not in compared.names


def test_what_is_joined_is_compared_beyond_the_joint() -> None:
    instance, R, T = armed("t-top-head", near=0.005, plates=True)
    names = ComparedShapes(instance).names
    assert {"leg 1 and the arm of B1", "the arm of B1 and the base"} <= set(names)
    assert "the arm of B1 and the platform" in names
    # The arm and the rod are at an angle: 5 mm from the joint they are apart.
    compared = ComparedShapes(instance)
    k = names.index("leg 1 and the arm of B1")
    gap = compared.gaps(R[None], T[None])[0, k]
    drives = Machine.of(instance)
    b, _, r = drives.ends(R, T, np.zeros(6))
    out = drives.middle[0] - b[0]
    along, out = r[0] / np.linalg.norm(r[0]), out / np.linalg.norm(out)
    expected = 0.005 * np.linalg.norm(along - out) - 0.003
    assert gap == pytest.approx(expected, abs=1e-9)


def test_arms_of_one_motor_are_one_body() -> None:
    """In a delta two rods share a crank; both ends have an arm."""
    instance, R, T = armed("delta", diameter=20)
    compared = ComparedShapes(replace(instance, shapes=Shapes(10)))
    assert len(compared.arms) == 6
    assert "the arms" not in " ".join(compared.names)
    assert "the arm of B1 and the arm of B3" in compared.names
    assert "the arm of B1 and the arm of B2" not in compared.names
    assert np.isfinite(compared.gaps(R[None], T[None])).all()


def test_only_arms_with_a_diameter_are_looked_at() -> None:
    instance, *_ = armed("t-top-head")
    plain = gspcli.example("t-top-head")
    assert ComparedShapes(replace(plain, shapes=Shapes(0.002))).arms == []
    rows = [row if k == 2 else other for k, (row, other) in enumerate(
        zip(instance.constraints, plain.constraints, strict=True))]  # fmt: skip
    compared = ComparedShapes(replace(instance, constraints=tuple(rows)))
    assert [one[0] for one in compared.arms] == [2]


@pytest.mark.parametrize("upside_down", [False, True])
@pytest.mark.parametrize("move", [1e-2, 1e-4])
def test_gaps_of_arms_change_no_more_than_is_proved(move: float, *, upside_down: bool) -> None:
    instance, R0, T0 = armed("reachy-mini-head", near=0.004, plates=True)
    R, T = poses_near(R0, T0, 3000, move * 0.05, move, 1)
    if upside_down:
        instance = swapped(instance)
        T, R = -np.einsum("nji,nj->ni", R, T), np.swapaxes(R, 1, 2)
        T0, R0 = -R0.T @ T0, R0.T
    motors = Machine.of(instance).at_home(R0, T0)
    compared = ComparedShapes(instance)
    q, q0 = motors.along(R, T), motors.along(R0[None], T0[None])
    centre = np.array([0.01, 0, 0])
    places, place = T + R @ centre, T0 + R0 @ centre
    shift = np.array([np.linalg.norm(places - place, axis=1).max()])
    moved = compared.moves(R0[None], T0[None], q0, shift, np.array([move]), centre)
    change = np.abs(compared.bounds(R, T, q).high - compared.bounds(R0[None], T0[None], q0).high)
    change = change.max(axis=0)
    arms = np.array(["arm" in name for name in compared.names])
    assert np.isfinite(moved).all()
    assert (change <= moved[0] + 1e-12).all()
    if not upside_down:
        assert change[arms].max() > moved[0][arms].max() / 12


def test_gaps_of_arms_do_not_depend_on_frames() -> None:
    instance, R, T = armed("t-top-head", near=0.005, plates=True)
    pivot = (0.02, 0.01, -0.05)
    frame, other = PoseFrame.of(instance, pivot=pivot), expressed_instance(instance, pivot=pivot)
    q = Machine.of(instance).at_home().along(R[None], T[None])
    R_there, T_there = frame.from_platform(R[None], T[None])
    found = ComparedShapes(other).gaps(R_there, T_there, q)
    assert found == pytest.approx(ComparedShapes(instance).gaps(R[None], T[None], q), abs=1e-9)


def test_diameters_of_arms_are_read_and_written() -> None:
    instance, *_ = armed("t-top-head", diameter=0.0125)
    text = gspcli.dumps(instance)
    assert text.count("diameter: 0.0125}") == 6
    assert gspcli.loads(text).constraints == instance.constraints
    wrong = text.replace("diameter: 0.0125}", "diameter: -1}", 1)
    line = next(k for k, one in enumerate(wrong.splitlines(), 1) if "diameter: -1" in one)
    with pytest.raises(SpecError) as error:
        gspcli.loads(wrong)
    message = str(error.value)
    assert f":{line}:" in message
    assert "base.B1.crank.diameter: found '-1', expected a diameter of at least 0" in message
    with pytest.raises(SpecError, match="diameter"):
        gspcli.loads(text.replace("diameter: 0.0125}", "diameter: thick}", 1))


def test_a_negative_diameter_of_an_arm_is_refused() -> None:
    instance, *_ = armed("t-top-head", diameter=-1.0)
    with pytest.raises(ArgumentError, match="B1: found -1, expected a diameter of at least 0"):
        ComparedShapes(instance)
