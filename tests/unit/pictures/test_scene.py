"""Scenes of solved platforms, and the page that holds one."""

from __future__ import annotations

import json
import re
from functools import cache

import numpy as np
import pytest

from gspcli.pictures.page import page
from gspcli.pictures.scene import Scene
from gspcli.pictures.stage import scene_of
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec import load, loads

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
