"""Legs and bodies in pictures with the shapes that a file states."""

from __future__ import annotations

import dataclasses

import numpy as np

from gspcli.geometry.numbers import Number
from gspcli.geometry.shapes import Shapes
from gspcli.pictures.stage import drawn_diameters, drawn_shells, scene_of
from gspcli.solver import solve
from gspcli.spec.reading import example
from tests.support.thick_legs import thick


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
