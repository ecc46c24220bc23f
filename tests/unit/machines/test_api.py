"""MJCF: ignored elements, refused files, and models that gsp wrote."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import machine_models as models
import numpy as np
import pytest
from one_hexapod import BASE, LENGTHS, PLATFORM, UP, Write, same

import gspcli
from gspcli.errors import GspError, SpecError
from gspcli.geometry.euler import rotation_from_euler
from gspcli.machines.api import import_machine
from gspcli.machines.graph import NoPlatform


@pytest.fixture
def read(tmp_path: Path):
    def imported(text: str, **options: object):
        path = tmp_path / "robot.xml"
        path.write_text(text, encoding="utf-8")
        return import_machine(path, **options)

    return imported


def without_text(model: str) -> str:
    return re.sub(r"<custom>.*?</custom>", "", model, flags=re.DOTALL)


@pytest.mark.parametrize("name", ["rubin-m2", "nano-hexapod", "figure-4", "fixture-3-2-1"])
def test_a_model_of_gsp_leads_back_exactly(read, name: str) -> None:
    instance = gspcli.example(name)
    found = read(str(gspcli.exported(instance, "mjcf")))
    assert found.instance == instance
    assert gspcli.loads(found.text) == instance


def test_a_changed_model_is_read_itself(read) -> None:
    model = str(gspcli.exported(gspcli.example("nano-hexapod"), "mjcf"))
    moved = re.sub(r'(<body name="chain_1_1" pos=")\S+', r"\g<1>0.25", model)
    assert moved != model
    found = read(moved)
    assert any("changed after gsp wrote it" in note for note in found.notes)
    assert found.instance.constraints[0].base.point[0] == 0.25
    # Other blanks and comments are no change.
    again = read(model.replace("\n", "\n\n").replace("</worldbody>", "<!-- mine --></worldbody>"))
    assert again.instance == gspcli.example("nano-hexapod")


@pytest.mark.parametrize(
    "name",
    ["dietmaier", "figure-2", "figure-3", "figure-4", "example-6.8", "fixture-3-2-1", "six-planes",
     "octahedral-3-3", "rubin-camera"],
)  # fmt: skip
def test_the_joints_of_a_model_of_gsp_have_its_modes(read, name: str) -> None:
    instance = gspcli.example(name)
    found = read(without_text(str(gspcli.exported(instance, "mjcf"))))
    before, after = gspcli.solve(instance), gspcli.solve(found.instance)
    metre = {"m": 1.0, "mm": 1e-3}.get(instance.units.length, 1.0)
    poses = np.concatenate(
        (before.R[before.real].real.reshape(-1, 9), metre * before.T[before.real].real), axis=1
    )
    own = np.concatenate(
        (after.R[after.real].real.reshape(-1, 9), after.T[after.real].real), axis=1
    )
    apart = np.abs(poses[:, None] - own[None]).max(axis=2)
    # Each mode of the import is one of the original, and no two are the same one.
    assert (apart.min(axis=0) < 1e-6).all()
    assert len(set(apart.argmin(axis=0).tolist())) == len(own)
    two_sided = any(row.kind.has_sides and row.side.value == "both" for row in instance.constraints)
    assert len(own) == len(poses) or two_sided


def test_bodies_of_which_a_motor_is_a_stage_below(read) -> None:
    reachy = models.public("reachy_mini.xml")
    found = import_machine(reachy)
    shipped = gspcli.example("reachy-mini-head")
    assert found.platform == "xl_330"
    ends = np.array([row.platform.point for row in found.instance.constraints])
    expected = np.array([row.platform.point for row in shipped.constraints])
    distances = [np.linalg.norm(x[:, None] - x[None], axis=2) for x in (ends, expected)]
    assert np.abs(distances[0] - distances[1]).max() < 4e-9
    for row, own in zip(shipped.constraints, found.instance.constraints, strict=True):
        arms = []
        for point in (row.base, own.base):
            arm = point.point - np.array([x.value for x in point.crank.centre])
            axis = np.array([x.value for x in point.crank.axis])
            arms.append(np.linalg.norm(np.cross(arm, axis / np.linalg.norm(axis))))
        assert arms[0] == pytest.approx(arms[1], abs=1e-8)
        assert own.value.value == pytest.approx(0.085, abs=2e-8)
    assert gspcli.solve(found.instance).counts.real == 8


@pytest.mark.parametrize(
    ("what", "says"),
    [
        ('<include file="/etc/passwd"/>', "found <include>, expected one file"),
        ('<replicate count="9999999"><geom size="1"/></replicate>', "found <replicate>"),
        ('<composite type="grid" count="9999 9999 1"/>', "found <composite>"),
    ],
)
def test_what_leads_elsewhere_is_refused_at_its_place(read, what: str, says: str) -> None:
    with pytest.raises(SpecError, match=says) as error:
        read(models.rps().replace("<worldbody>", f"<worldbody>\n  {what}"))
    assert "robot.xml:2:3" in str(error.value)


def test_meshes_are_not_opened(read) -> None:
    text = models.rps().replace(
        "<worldbody>",
        '<asset><mesh name="seen" file="/nowhere/seen.stl"/></asset><worldbody>'
        '<geom type="mesh" mesh="seen"/>',
    )
    found = read(text.replace('<geom size=".1"/>', '<geom type="mesh" mesh="seen"/>'))
    assert found.instance.dynamics is None
    assert found.instance.constraints == read(models.rps()).instance.constraints


def test_entities_are_refused(read) -> None:
    bomb = '<!DOCTYPE mujoco [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]>' + models.rps()
    with pytest.raises(SpecError, match="entities are not read"):
        read(bomb)
    outside = '<!DOCTYPE mujoco SYSTEM "file:///etc/passwd">' + models.rps()
    assert read(outside).instance == read(models.rps()).instance


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "expected"),
        ("hello", "found 'hello'"),
        ("<mujoco>", "no well-formed XML: no element found"),
        ("<mujoco><a></mujoco>", "mismatched tag"),
        ("<mujoco/>", "none"),
        ("<mujoco><worldbody><body/></worldbody><nonsense/></mujoco>", "cannot compile"),
        ("<a>" * 200 + "</a>" * 200, "100 levels deep"),
    ],
)
def test_wrong_files(read, text: str, says: str) -> None:
    with pytest.raises(GspError, match=re.escape(says)):
        read(text)


def test_gears_and_tendons_are_refused(read) -> None:
    text = models.rps()
    geared = text.replace("</equality>", '<joint joint1="s0" joint2="s1"/></equality>')
    with pytest.raises(NoPlatform, match="'s0' and 's1' geared"):
        read(geared)
    tendon = '<tendon><fixed name="t"><joint joint="s0" coef="1"/></fixed></tendon><actuator>'
    pulled = text.replace("<actuator>", tendon).replace(
        '<motor joint="s0"/>', '<motor name="pull" tendon="t"/>'
    )
    with pytest.raises(NoPlatform, match="'pull' on a tendon"):
        read(pulled)


def test_without_mujoco_only_models_of_gsp_are_read(read, monkeypatch) -> None:
    instance = gspcli.example("figure-4")
    model = str(gspcli.exported(instance, "mjcf"))
    monkeypatch.setitem(sys.modules, "mujoco", None)
    assert read(model).instance == instance
    with pytest.raises(GspError, match=r"pip install 'gspcli\[simulation\]'"):
        read(models.rps())


# Machines of lower mobility: their counts, and the constraints that models of them give.


@pytest.mark.parametrize(
    ("name", "count", "kinds"),
    [
        # Kim and Park 2001: a polynomial of degree 16 for chains of a hinge and a ball.
        ("three-rps", 16, "3DPP 3DPH"),
        ("three-prs", 16, "3DPP 3DPH"),
        ("tricept", 24, "3DPP 2DHP ALL"),
        ("delta", 28, "6DPP"),
        ("hexaglide", 36, "6DPP"),
    ],
)
def test_counts(name: str, count: int, kinds: str) -> None:
    from gspcli.cli.commands.example import short_name

    instance = gspcli.example(name)
    result = gspcli.solve(instance)
    assert short_name(instance.type) == kinds
    assert result.verdict == "complete"
    assert len(result.R) == count


def test_a_delta_robot_that_does_not_turn_is_where_three_spheres_meet() -> None:
    instance = gspcli.example("delta")
    result = gspcli.solve(instance)
    R, T = result.R[result.real].real, result.T[result.real].real
    still = np.abs(R - np.eye(3)).max(axis=(1, 2)) < 1e-9
    across = 524 + 567 * np.sqrt(3) / 6 - 76 * np.sqrt(3) / 3
    height = np.sqrt(1244**2 - across**2)
    assert still.sum() == 2
    assert np.allclose(sorted(T[still, 2]), [-height, height])
    assert height == pytest.approx(1064.45, abs=0.01)


def tricept() -> str:
    """Return a model: legs with balls at both ends, and a passive leg that guides the platform."""
    bodies = closures = actuators = ""
    bodies += (
        '<body name="fork"><joint type="hinge" axis="1 0 0"/><joint type="hinge" axis="0 1 0"/>'
        '<geom size=".1"/><body name="table" pos="0 0 8"><joint type="slide" axis="0 0 1"/>'
        '<geom size=".1"/></body></body>'
    )
    for i in range(3):
        t = 2 * np.pi * i / 3
        b = np.array([5 * np.cos(t), 5 * np.sin(t), 0])
        p = np.array([2 * np.cos(t), 2 * np.sin(t), 8])
        e = (p - b) / np.linalg.norm(p - b)
        bodies += (
            f'<body name="leg{i}" pos="{models.row(b)}"><joint type="ball"/><geom size=".1"/>'
            f'<body name="rod{i}"><joint name="jack{i}" type="slide" axis="{models.row(e)}"/>'
            '<geom size=".1"/></body></body>'
        )
        anchor = models.row(p - [0, 0, 8])
        closures += f'<connect body1="table" body2="rod{i}" anchor="{anchor}"/>'
        actuators += f'<motor joint="jack{i}"/>'
    return (
        f'<mujoco><compiler angle="radian"/><worldbody>{bodies}</worldbody>'
        f"<equality>{closures}</equality><actuator>{actuators}</actuator></mujoco>"
    )


def test_a_model_of_a_tricept_has_its_modes(tmp_path: Path) -> None:
    path = tmp_path / "tricept.xml"
    path.write_text(tricept(), encoding="utf-8")
    found = import_machine(path, digits=17)
    assert sorted(row.kind.name for row in found.instance.constraints) == sorted(
        row.kind.name for row in gspcli.example("tricept").constraints
    )
    poses = []
    for instance in (found.instance, gspcli.example("tricept")):
        result = gspcli.solve(instance)
        R, T = result.R[result.real].real, result.T[result.real].real
        poses.append(np.concatenate((R.reshape(-1, 9), T), axis=1))
    apart = np.abs(poses[0][:, None] - poses[1][None]).max(axis=2)
    assert apart.shape == (8, 8)
    assert apart.min(axis=0).max() < 1e-8
    assert apart.min(axis=1).max() < 1e-8


def test_models_of_tripods_have_their_modes(tmp_path: Path) -> None:
    path = tmp_path / "tripod.xml"
    path.write_text(models.rps(), encoding="utf-8")
    found = import_machine(path)
    assert len(gspcli.solve(found.instance).R) == 16


# One hexapod as a robot in SDF and URDF: the same hexapod is read, or a message has the reason.


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
