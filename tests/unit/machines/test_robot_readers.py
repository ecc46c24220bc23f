"""One hexapod as a robot in SDF and URDF: the same hexapod is read, or a message has the reason."""

from __future__ import annotations

import re

import machine_models as models
import numpy as np
import pytest
from one_hexapod import BASE, LENGTHS, PLATFORM, UP, Write, same

import gspcli
from gspcli.errors import GspError, SpecError
from gspcli.geometry.euler import rotation_from_euler
from gspcli.machines.api import import_machine

# -- SDF --------------------------------------------------------------------------------------


def sdf(version: str = "1.7", plugin: str = "", scale: float = 1e-3) -> str:
    inner = f'<link name="base"/><link name="plate"><pose>0 0 {100 * scale} 0 0 0</pose></link>'
    inner += '<joint name="held" type="fixed"><parent>world</parent><child>base</child></joint>'
    for i, (b, p) in enumerate(zip(BASE * scale, (PLATFORM + UP) * scale, strict=True)):
        e = (p - b) / np.linalg.norm(p - b)
        yaw, pitch = np.arctan2(e[1], e[0]), -np.arcsin(e[2])
        along = "1 0 0" if version != "1.4" else models.row(e)
        across = ("0 1 0", "0 0 1")
        if version == "1.4":
            z = np.array([np.cos(yaw) * np.sin(pitch), np.sin(yaw) * np.sin(pitch), np.cos(pitch)])
            across = models.row([-np.sin(yaw), np.cos(yaw), 0]), models.row(z)
        pose = f"<pose>{models.row(b)} 0 {pitch:.17g} {yaw:.17g}</pose>"
        inner += (
            f'<link name="lower{i}">{pose}</link><link name="upper{i}">{pose}</link>'
            f'<joint name="u{i}" type="universal"><parent>base</parent><child>lower{i}</child>'
            f"<axis><xyz>{across[0]}</xyz></axis><axis2><xyz>{across[1]}</xyz></axis2></joint>"
            f'<joint name="s{i}" type="prismatic"><parent>lower{i}</parent><child>upper{i}</child>'
            f"<axis><xyz>{along}</xyz><limit><lower>-0.01</lower><upper>0.02</upper></limit></axis></joint>"
            f'<joint name="b{i}" type="ball"><parent>upper{i}</parent><child>plate</child>'
            f"<pose>{models.row(PLATFORM[i] * scale)} 0 0 0</pose></joint>"
        )
    model = f'<model name="m">{inner}{plugin}</model>'
    return f'<?xml version="1.0"?>\n<sdf version="{version}">{model}</sdf>'


@pytest.mark.parametrize("version", ["1.4", "1.5", "1.7", "1.11"])
def test_sdf(read: Write, version: str) -> None:
    found = read("model.sdf", sdf(version))
    same(found, 1e-3)
    assert found.base == "world"
    assert any("names no drives; taken for drives: all slides" in note for note in found.notes)
    for k, row in enumerate(found.instance.constraints):
        low, high = (x.value * 1e3 for x in row.limits)
        assert (low, high) == pytest.approx((LENGTHS[k] - 10, LENGTHS[k] + 20))


def test_sdf_with_frames_and_drives(read: Write) -> None:
    names = "".join(f"<joint_name>s{i}</joint_name>" for i in range(6))
    plugin = f'<plugin filename="gz-sim-joint-position-controller-system" name="x">{names}</plugin>'
    states = '<plugin name="state-publisher" filename="y"><joint_name>u0</joint_name></plugin>'
    text = sdf(plugin=plugin + states + '<frame name="f"><pose>0 0 0.05 0 0 0</pose></frame>')
    lifted = text.replace(
        '<link name="plate"><pose>0 0 0.1 ', '<link name="plate"><pose relative_to="f">0 0 0.05 '
    )
    assert lifted != text
    found = read("model.sdf", lifted)
    same(found, 1e-3)
    assert not found.notes


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("<parent>base</parent>", "<parent>bse</parent>"), "the parent 'bse', expected 'base'"),
        (('type="ball"', 'type="screw"'), "of the type 'screw'"),
        (("<xyz>0 1 0</xyz>", "<xyz>0 0 0</xyz>"), "an axis of length 0"),
        (("<xyz>0 1 0</xyz>", "<xyz>0 1</xyz>"), "found '0 1', expected 3 numbers"),
        (('<link name="base"/>', "<include><uri>model://x</uri></include>"), "found <include> too"),
        (('<link name="base"/>', '<link name="base"/><model name="n"/>'), "found <model> too"),
        (('<link name="base"/>', '<link name="base"/><link name="base"/>'), "'base' twice"),
        (('"base"/>', '"base"><pose relative_to="g"/></link>'), "the frame 'g'"),
        (('"base"/>', '"base"><pose relative_to="base"/></link>'), "the frame 'base'"),
    ],
)  # fmt: skip
def test_sdf_with_mistakes(read: Write, change: tuple[str, str], says: str) -> None:
    text = sdf()
    assert change[0] in text
    with pytest.raises(GspError, match=re.escape(says)):
        read("model.sdf", text.replace(*change, 1))


# -- URDF -------------------------------------------------------------------------------------


def urdf(ball: str = "revolute", extra: str = "") -> str:
    text = '<link name="base"/><link name="plate"><inertial><mass value="2"/>'
    text += '<inertia ixx="1" iyy="1" izz="1"/></inertial></link>'
    rows = []
    for i, (b, p) in enumerate(zip(BASE * 1e-3, (PLATFORM + UP) * 1e-3, strict=True)):
        e = (p - b) / np.linalg.norm(p - b)
        yaw, pitch = np.arctan2(e[1], e[0]), -np.arcsin(e[2])
        rows += [
            (
                f"u{i}",
                "continuous",
                "base",
                f"lower{i}",
                f"{models.row(b)}",
                f"0 {pitch:.17g} {yaw:.17g}",
                "0 1 0",
            ),
            (f"v{i}", "continuous", f"lower{i}", f"mid{i}", "0 0 0", "0 0 0", "0 0 1"),
            (f"s{i}", "prismatic", f"mid{i}", f"upper{i}", "0 0 0", "0 0 0", "1 0 0"),
        ]
        if i == 0:
            # The tree goes through the first leg: its end carries the platform.
            R = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
            R = R @ [
                [np.cos(pitch), 0, np.sin(pitch)],
                [0, 1, 0],
                [-np.sin(pitch), 0, np.cos(pitch)],
            ]
            angles = (
                np.arctan2(R[1, 2], R[2, 2]),
                -np.arcsin(R[0, 2]),
                np.arctan2(R[0, 1], R[0, 0]),
            )
            length = np.linalg.norm(p - b)
            rows += [
                ("x0", "continuous", "upper0", "t0", f"{length:.17g} 0 0", "0 0 0", "1 0 0"),
                ("y0", "continuous", "t0", "t1", "0 0 0", "0 0 0", "0 1 0"),
                ("z0", "continuous", "t1", "t2", "0 0 0", "0 0 0", "0 0 1"),
                (
                    "e0",
                    "fixed",
                    "t2",
                    "plate",
                    models.row(R.T @ (-PLATFORM[0] * 1e-3)),
                    models.row(angles),
                    "1 0 0",
                ),
            ]
        else:
            length = np.linalg.norm(p - b)
            rows.append(
                (f"e{i}", "fixed", f"upper{i}", f"end{i}", f"{length:.17g} 0 0", "0 0 0", "1 0 0")
            )
            rows.append(
                (
                    f"f{i}",
                    "fixed",
                    "plate",
                    f"hole{i}",
                    models.row(PLATFORM[i] * 1e-3),
                    "0 0 0",
                    "1 0 0",
                )
            )
    for name, kind, parent, child, xyz, rpy, axis in rows:
        if child != "plate":
            text += f'<link name="{child}"/>'
        text += (
            f'<joint name="{name}" type="{kind}"><origin xyz="{xyz}" rpy="{rpy}"/>'
            f'<parent link="{parent}"/><child link="{child}"/><axis xyz="{axis}"/>'
            '<limit lower="-0.01" upper="0.02"/></joint>'
        )
    return f'<robot name="r">{text}{extra}</robot>'


PAIRS = ", ".join(f"[end{i}, hole{i}]" for i in range(1, 6))
YAML = f"closed_loop: [{PAIRS}]\ntype: [3d, 3d, 3d, 3d, 3d]\nname_mot: [s0, s1, s2, s3, s4, s5]\n"


def test_urdf_with_loops_in_yaml(read: Write) -> None:
    found = read("robot.urdf", urdf(), robot__yaml=YAML)
    same(found, 1e-3)
    assert found.instance.dynamics.platform.mass.value == 2
    plain = read("robot.urdf", urdf(), robot__yaml=YAML.replace("name_mot", "names"))
    same(plain, 1e-3)
    assert any("taken for drives: all slides" in note for note in plain.notes)


def test_urdf_with_loops_of_joints(read: Write) -> None:
    """Frames of Pinocchio are those of joints, too: each is that of the link below the joint."""
    text = urdf()
    above = dict(re.findall(r'<joint name="(\w+)".*?<child link="(\w+)"', text))
    joints = {link: joint for joint, link in above.items()}
    named = re.sub(r"end\d|hole\d", lambda found: joints.get(found[0], found[0]), YAML)
    assert named != YAML
    same(read("robot.urdf", text, robot__yaml=named), 1e-3)


def test_urdf_with_loop_joints_and_drives(read: Write) -> None:
    loops = "".join(
        f'<loop_joint name="l{i}" type="spherical"><link1 link="end{i}"/><link2 link="plate" '
        f'xyz="{models.row(PLATFORM[i] * 1e-3)}"/></loop_joint>'
        for i in range(1, 6)
    )
    drives = "".join(f'<transmission><joint name="s{i}"/></transmission>' for i in range(6))
    found = read("robot.urdf", urdf(extra=loops + drives))
    same(found, 1e-3)
    assert not found.notes


@pytest.mark.parametrize("kind", ["fixed", "spherical"])
def test_urdf_with_loops_whose_frames_are_both_moved(read: Write, kind: str) -> None:
    """Frames of loops may lie anywhere in their links, turned: the same points meet.

    A fixed loop follows a ball at the end of the leg, whose link has its frame far from the ball.
    """
    rng = np.random.default_rng(5)
    extra = "".join(f'<transmission><joint name="s{i}"/></transmission>' for i in range(6))
    for i in range(1, 6):
        turns, place = rng.uniform(-3, 3, (2, 3)), PLATFORM[i] * 1e-3
        first, second = rotation_from_euler("ZYX", turns)
        if kind == "fixed":
            extra += (
                f'<link name="tip{i}"/><joint name="ball{i}" type="spherical">'
                f'<parent link="end{i}"/><child link="tip{i}"/></joint>'
            )
            own = rng.uniform(-1, 1, 3)
            ends = (f"tip{i}", own), ("plate", place + second @ first.T @ own)
        else:
            length = LENGTHS[i] * 1e-3
            ends = (f"upper{i}", np.array([length, 0, 0])), ("plate", place)
        extra += f'<loop_joint name="l{i}" type="{kind}">'
        for k, (link, xyz) in enumerate(ends):
            extra += f'<link{k + 1} link="{link}" xyz="{models.row(xyz)}" '
            extra += f'rpy="{models.row(turns[k])}"/>'
        extra += "</loop_joint>"
    found = read("robot.urdf", urdf(extra=extra))
    same(found, 1e-3)
    assert not found.notes


@pytest.mark.parametrize(
    ("change", "yaml", "says"),
    [
        (("", ""), ("hole3", "hole9"), "no link or joint 'hole9' in the robot"),
        (("", ""), ("3d, 3d", "3d"), "found 5 loops and 4 types"),
        (("", ""), ("3d", "4d"), "found a loop of the type '4d'"),
        (("", ""), ("[end1, hole1]", "end1"), "expected two links"),
        (("", ""), ("closed_loop: [", "closed_loop: {"), "robot.yaml:1:15: closed_loop"),
        (('type="prismatic"', 'type="prism"'), ("", ""), "of the type 'prism'"),
        (('<parent link="base"/>', '<parent link="bse"/>'), ("", ""), "found the link 'bse'"),
        (('<child link="mid0"/>', '<child link="lower0"/>'), ("", ""), "below two joints"),
        (('<axis xyz="0 1 0"/>', '<axis xyz="0 0 0"/>'), ("", ""), "an axis of length 0"),
        (('<mass value="2"/>', '<mass value="two"/>'), ("", ""), "found 'two', expected a number"),
        (('<axis xyz="0 1 0"/>', '<axis xyz="0 1 0"/><mimic joint="u1"/>'), ("", ""), "geared"),
    ],
)  # fmt: skip
def test_urdf_with_mistakes(
    read: Write, change: tuple[str, str], yaml: tuple[str, str], says: str
) -> None:
    with pytest.raises(GspError, match=re.escape(says)):
        read("robot.urdf", urdf().replace(*change, 1), robot__yaml=YAML.replace(*yaml, 1))


def test_a_tree_that_is_a_ring_ends(read: Write) -> None:
    ring = "".join(
        f'<link name="{a}"/><joint name="j{a}" type="fixed"><parent link="{a}"/>'
        f'<child link="{b}"/></joint>'
        for a, b in ("ab", "bc", "ca")
    )
    with pytest.raises(SpecError, match="above itself"):
        read("robot.urdf", f'<robot name="r">{ring}</robot>')


def test_a_public_robot_that_is_open() -> None:
    found = import_machine(models.public("wl16.urdf"))
    assert found.instance.home is None
    assert [row.kind.name for row in found.instance.constraints] == ["DPP"] * 6
    assert any(
        "misses the values by 0.14 m; its loops are open by up to 0.37" in n for n in found.notes
    )
    assert gspcli.solve(found.instance).counts.real == 0
