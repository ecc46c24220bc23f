"""Scenes of solved platforms, and the page that holds one."""

from __future__ import annotations

import dataclasses
import json
import re
from functools import cache
from html import unescape
from itertools import pairwise

import numpy as np
import pytest

import gspcli
from gspcli.catalogue.kinds import AHH, ALL, KINDS, Kind, Primitive
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Shapes, Units
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import measured
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, Line, Plane, Point, vector
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.pictures.page import page
from gspcli.pictures.scene import Scene, Stroke, StrokeStyle
from gspcli.pictures.stage import (
    ConstraintEnds,
    Poses,
    Sizes,
    angle_strokes,
    connection,
    distance_strokes,
    drawn_diameters,
    drawn_shells,
    scene_of,
)
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec import load, loads
from gspcli.spec.reading import example
from tests.support.driven_machines import driven, some_pose
from tests.support.thick_legs import thick

#: What the page may weigh besides trajectories.
LIMIT = 750_000


@cache
def scene(name: str) -> Scene:
    return scene_of(solve(load(instance_files()[name])))


@pytest.mark.parametrize("name", ["example-6.8", "octahedral-3-3", "six-planes", "sdss-primary"])
def test_drawn_distances_and_angles_have_their_values(name: str) -> None:
    shown = scene(name)
    modes = shown.series[0]
    values = np.array([bond.value for bond in shown.bonds])
    np.testing.assert_allclose(modes.measured, np.broadcast_to(values, modes.measured.shape))
    for bond, strokes, value in zip(shown.bonds, modes.strokes, values, strict=True):
        if bond.kind.is_distance:
            drawn = np.linalg.norm(strokes[0].points[:, 0] - strokes[0].points[:, 1], axis=1)
            np.testing.assert_allclose(drawn, value)


def test_primitives_are_drawn_once_and_reach_the_feet() -> None:
    shown = scene("example-6.8")
    assert [element.name for element in shown.base.elements] == ["L4", "L5", "L6"]
    elements = {element.name: element for element in shown.base.elements}
    for bond, strokes in zip(shown.bonds, shown.series[0].strokes, strict=True):
        if bond.kind.is_distance:
            element = elements[bond.base_name]
            low, high = element.outline @ element.direction
            feet = strokes[0].points[:, 1] @ element.direction
            assert low < feet.min() < feet.max() < high


def test_a_self_motion_is_a_series_of_its_own() -> None:
    shown = scene("griffis-duffy")
    assert len(shown.series[0]) == 0
    motion = shown.series[1]
    assert motion.parameter is not None
    np.testing.assert_allclose(motion.measured, motion.measured[:1].repeat(len(motion), axis=0))


def test_without_a_real_pose_the_base_is_shown() -> None:
    shown = scene("no-real-pose")
    assert [len(series) for series in shown.series] == [0]
    assert "There is no real pose" in page(shown)


@pytest.mark.parametrize("name", ["example-6.8", "dietmaier", "figure-4"])
def test_the_page_is_small_and_holds_the_scene(name: str) -> None:
    text = page(scene(name))
    assert len(text.encode()) <= LIMIT
    found = re.search(r'<script type="application/json" id="scene">(.*?)</script>', text)
    assert found
    document = json.loads(found[1])
    assert document["schema"] == "gsp.scene/1"
    assert len(document["series"][0]["T"]) == len(scene(name).series[0])
    assert "@@" not in text


def test_all_numbers_are_text_too() -> None:
    text = page(scene("octahedral-3-3"))
    body = text.partition('<script type="application/json"')[0]
    assert body.count('aria-label="show mode') == 4
    assert "1.296" in body
    assert "P1 – B1" in body


def test_names_cannot_leave_their_place() -> None:
    source = instance_files()["octahedral-3-3"].read_text(encoding="utf-8")
    wicked = source.replace("name: Octahedral 3-3 platform", "name: '</script><i>'")
    assert wicked != source
    text = page(scene_of(solve(loads(wicked))))
    assert "</script><i>" not in text


# Legs and bodies in pictures with the shapes that a file states.


def test_scenes_have_stated_shapes() -> None:
    scene = scene_of(solve(thick("workspace-study", near=40))).to_json()
    assert [one["diameter"] for one in scene["constraints"]] == [20] * 6
    # A plate has six sides, and its corners are those of the file.
    assert {name: len(faces) for name, faces in scene["shells"].items()} == {
        "platform": 6,
        "base": 6,
    }
    assert np.abs(np.array(scene["shells"]["platform"])).max(axis=(0, 1)).tolist() == [120, 120, 6]


def test_scenes_without_shapes_are_as_before() -> None:
    scene = scene_of(solve(example("workspace-study"))).to_json()
    assert "shells" not in scene
    assert not any("diameter" in one for one in scene["constraints"])


def test_only_legs_are_thick_and_zero_is_a_line() -> None:
    three = example("surfaces-sss")
    legs = [k for k, row in enumerate(three.constraints) if row.kind.name == "DPP"]
    shapes = Shapes([0, *range(1, len(legs))] if len(legs) > 1 else 2)
    found = drawn_diameters(dataclasses.replace(three, shapes=shapes))
    assert set(found) == set(legs[1:] if len(legs) > 1 else legs)


def test_of_many_points_those_on_the_outside_are_drawn() -> None:
    draw = np.random.default_rng(1).normal(size=(500, 3))
    draw /= np.linalg.norm(draw, axis=1, keepdims=True)
    inside = (draw * 0.5).tolist()
    shapes = Shapes(1, platform=[*draw.tolist(), *inside], near_joint=1)
    machine = dataclasses.replace(example("workspace-study"), shapes=shapes)
    faces = drawn_shells(machine)["platform"]
    corners = np.concatenate(faces)
    assert np.allclose(np.linalg.norm(corners, axis=1), 1)
    assert 20 < len(np.unique(corners, axis=0)) <= 40


def test_points_in_a_plane_are_one_face_and_on_a_line_none() -> None:
    flat = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    machine = example("workspace-study")
    shapes = Shapes(1, platform=flat, base=flat[:2], near_joint=1)
    found = drawn_shells(dataclasses.replace(machine, shapes=shapes))
    assert {name: len(faces) for name, faces in found.items()} == {"platform": 1}


def test_arms_are_as_thick_as_stated() -> None:
    plain = example("t-top-head")
    row = plain.constraints[1]
    crank = dataclasses.replace(row.base.crank, diameter=Number.of(0.01))
    thick_arm = dataclasses.replace(row, base=dataclasses.replace(row.base, crank=crank))
    rows = (plain.constraints[0], thick_arm, *plain.constraints[2:])
    scene = scene_of(solve(dataclasses.replace(plain, constraints=rows))).to_json()
    assert [one.get("arm") for one in scene["constraints"]] == [None, 0.01, *[None] * 4]


# Arms and rails in pictures: they end at the joints, and move along trajectories.


@pytest.mark.parametrize("name", ["reachy-mini-head", "mixed"])
def test_rods_keep_their_lengths_along_poses_and_arms_end_at_their_joints(name) -> None:
    instance = driven(name)
    drives, rng = Machine.of(instance), np.random.default_rng(1)
    poses = [some_pose(instance, rng, spread=0.05)[:2] for _ in range(4)]
    R, T = (np.array(part) for part in zip(*poses, strict=True))
    scene = scene_of(gspcli.solve(instance), [Poses("Trajectory", "t", R, T)])
    shown = scene.series[-1]
    q = drives.inverse(R, T)
    _, ends, _ = drives.ends(R, T, q)
    for k, strokes in enumerate(shown.strokes):
        rod = strokes[0].points
        assert strokes[0].style is StrokeStyle.LEG
        if not drives.driven[k]:
            assert len(strokes) == 1
            continue
        assert np.linalg.norm(rod[:, 0] - rod[:, 1], axis=1) == pytest.approx(drives.rods[k])
        line = strokes[-1].points
        # One end of the arm is the joint of the rod on its body; a rail passes through it.
        joint = rod[:, 0 if drives.on_platform[k] else 1]
        if drives.sorts[drives.index[k]] == "crank":
            assert np.allclose(line[:, 1], joint, atol=1e-9)
            lengths = np.linalg.norm(line[:, 1] - line[:, 0], axis=1)
            assert lengths == pytest.approx(drives.arms[k])
        else:
            along = line[:, 1] - line[:, 0]
            assert np.abs(np.cross(along, joint - line[:, 0])).max() < 1e-9
    assert np.allclose(
        ends + T[:, None], [[s[0].points[n, 0] for s in shown.strokes] for n in range(4)]
    )


def test_in_modes_the_arms_are_where_the_file_states_them() -> None:
    instance = driven("reachy-mini-head")
    drives = Machine.of(instance)
    modes = scene_of(gspcli.solve(instance)).series[0]
    for k, strokes in enumerate(modes.strokes):
        assert np.allclose(
            strokes[-1].points, [drives.middle[k], instance.constraints[k].base.point]
        )


def test_a_machine_without_drives_has_no_further_strokes() -> None:
    legs = scene_of(gspcli.solve(gspcli.example("rubin-m2"))).series[0]
    assert all(len(strokes) == 1 for strokes in legs.strokes)


# Results in notebooks.


def test_a_result_shows_itself_in_a_frame() -> None:
    result = gspcli.solve(gspcli.load(instance_files()["octahedral-3-3"]))
    text = result._repr_html_()
    assert text.startswith('<iframe srcdoc="')
    assert text.count("<iframe") == 1
    document = unescape(text.partition('srcdoc="')[2].partition('"')[0])
    assert document.startswith("<!doctype html>")
    assert document.rstrip().endswith("</html>")
    assert "Octahedral 3-3 platform" in document


# What is drawn is what is measured: the length of a leg, the angle of an arc, right angles.


SIZES = Sizes(0.1, 1.0, 0.5)
POSES = 20


def _primitive(sort: Primitive, rng: np.random.Generator) -> Geometry:
    position = vector(*rng.normal(size=3).tolist())
    if sort is Primitive.POINT:
        return Point(position)
    direction = vector(*rng.normal(size=3).tolist())
    return (Line if sort is Primitive.LINE else Plane)(position, direction)


def _drawn(kind: Kind) -> tuple[list[Stroke], np.ndarray, ConstraintEnds]:
    """Return the strokes of a random constraint at random poses, its values and its ends."""
    rng = np.random.default_rng(kind.order)
    row = Constraint(kind, _primitive(kind.platform, rng), _primitive(kind.base, rng), Number.of(1))
    one = Arrangement.of(Instance((row,), Units("m", AngleUnit.RADIAN)))
    R, T = rotation_from_vector(rng.normal(size=(POSES, 3))), rng.normal(size=(POSES, 3))
    ends = ConstraintEnds(
        R @ one.y[0] + T,
        np.broadcast_to(one.x[0], (POSES, 3)),
        R @ one.u[0],
        np.broadcast_to(one.v[0], (POSES, 3)),
    )
    if kind.is_distance:
        ends = connection(kind, ends.platform, ends.w, ends.base, ends.v)
        strokes = [*distance_strokes(kind, ends, SIZES)]
    else:
        strokes = [*angle_strokes(kind, ends, SIZES)]
    return strokes, measured(one, R, T)[:, 0], ends


@pytest.mark.parametrize("kind", [k for k in KINDS if k.is_distance], ids=str)
def test_a_leg_is_as_long_as_the_distance_and_perpendicular(kind: Kind) -> None:
    strokes, values, ends = _drawn(kind)
    leg = strokes[0].points[:, 0] - strokes[0].points[:, 1]
    np.testing.assert_allclose(np.linalg.norm(leg, axis=1), np.abs(values), atol=1e-12)
    for sort, direction in ((kind.platform, ends.w), (kind.base, ends.v)):
        if sort is Primitive.LINE:
            np.testing.assert_allclose(np.einsum("ni,ni->n", leg, direction), 0, atol=1e-12)
        elif sort is Primitive.PLANE:
            np.testing.assert_allclose(np.cross(leg, direction), 0, atol=1e-12)


@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_marks_of_right_angles_are_right(kind: Kind) -> None:
    for stroke in _drawn(kind)[0]:
        if stroke.style is StrokeStyle.SQUARE:
            first, corner, last = np.moveaxis(stroke.points, 1, 0)
            turn = np.einsum("ni,ni->n", first - corner, last - corner)
            np.testing.assert_allclose(turn, 0, atol=1e-12)


@pytest.mark.parametrize("kind", [k for k in KINDS if not k.is_distance], ids=str)
def test_an_arc_is_as_wide_as_the_angle(kind: Kind) -> None:
    strokes, values, ends = _drawn(kind)
    arc = (strokes[0].points - ends.base[:, None]) / SIZES.arc
    steps = [
        np.arccos(np.clip(np.einsum("ni,ni->n", a, b), -1, 1))
        for a, b in pairwise(np.moveaxis(arc, 1, 0))
    ]
    np.testing.assert_allclose(sum(steps), np.abs(values), atol=1e-6)
    if kind in (ALL, AHH):
        np.testing.assert_allclose(arc[:, 0], ends.v, atol=1e-12)


def test_parallel_lines_and_right_angles_to_planes_are_drawn() -> None:
    along = np.array([[0.0, 0.0, 1.0]])
    offset = np.array([[2.0, 0.0, 5.0]])
    ends = connection(KINDS[5], offset, along, np.zeros((1, 3)), along)
    assert np.linalg.norm(ends.platform - ends.base) == pytest.approx(2)
    for kind in KINDS[6:]:
        for stroke in angle_strokes(kind, ConstraintEnds(offset, offset, along, along), SIZES):
            assert np.isfinite(stroke.points).all()
