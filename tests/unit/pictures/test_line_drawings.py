"""Drawings for papers: the right thing, the same bytes, all formats."""

from __future__ import annotations

import io
import xml.etree.ElementTree as ET
from functools import cache

import matplotlib.image
import numpy as np
import pytest
from matplotlib.figure import Figure

from gspcli.errors import GspError
from gspcli.pictures.figures import styled, written, written_drawing
from gspcli.pictures.line_drawings import drawing
from gspcli.pictures.projection import View
from gspcli.pictures.scene import Scene
from gspcli.pictures.stage import scene_of
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec import load


@cache
def scene(name: str) -> Scene:
    return scene_of(solve(load(instance_files()[name])))


def image(data: bytes) -> np.ndarray:
    return matplotlib.image.imread(io.BytesIO(data), format="png")[..., :3]


def test_the_same_bytes_every_time() -> None:
    once = drawing(scene("octahedral-3-3"), "svg", [0])
    assert once == drawing(scene("octahedral-3-3"), "svg", [0])
    root = ET.fromstring(once)
    assert root.tag.endswith("svg")
    assert b"http://www.w3.org" in once
    assert b"matplotlib" not in once.lower().replace(b"matplotlib.axis", b"")


@pytest.mark.parametrize(("fmt", "begin"), [("pdf", b"%PDF"), ("png", b"\x89PNG")])
def test_other_formats(fmt: str, begin: bytes) -> None:
    assert drawing(scene("octahedral-3-3"), fmt, [0]).startswith(begin)


def test_the_eye_is_where_it_was_asked_to_be() -> None:
    top = View(azimuth=-90, elevation=90)
    np.testing.assert_allclose(top.axes @ [1, 2, 3], [1, 2, 3], atol=1e-12)
    front = View(azimuth=-90, elevation=0)
    np.testing.assert_allclose(front.axes @ [1, 2, 3], [1, 3, -2], atol=1e-12)
    other = View(30, 40).axes
    np.testing.assert_allclose(other @ other.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(other) == pytest.approx(1)


def test_modes_differ_and_all_fit_on_one_sheet() -> None:
    shown = scene("octahedral-3-3")
    first, third = (image(drawing(shown, "png", [mode])) for mode in (0, 2))
    assert first.shape != third.shape or np.abs(first - third).max() > 0.5
    sheet = image(drawing(shown, "png", range(4)))
    assert sheet.size > first.size
    assert (sheet < 0.9).any()


def test_nothing_is_cut_off() -> None:
    pixels = image(drawing(scene("surfaces-ppp"), "png", [0]))
    border = np.concatenate((pixels[0], pixels[-1], pixels[:, 0], pixels[:, -1]))
    assert (border > 0.99).all()


def test_the_base_alone() -> None:
    assert (image(drawing(scene("no-real-pose"), "png", [])) < 0.9).any()


def test_without_matplotlib_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gspcli.pictures.figures.find_spec", lambda name: None)
    with pytest.raises(GspError, match=r"pip install 'gspcli\[plot\]'"):
        drawing(scene("octahedral-3-3"), "svg", [0])


def test_the_last_bits_of_coordinates_do_not_show() -> None:
    def figure(width: float) -> Figure:
        made = Figure()
        axes = made.add_axes((0.1, 0.1, width, 0.8))
        axes.set_axis_off()
        axes.plot([0, width], [-0.0, 1])
        return made

    with styled():
        one, other = (figure(width) for width in (0.8, np.nextafter(0.8, 1)))
        assert written(one, "svg") != written(other, "svg")
        assert written_drawing(one, "svg") == written_drawing(other, "svg")
        assert written_drawing(one, "svg") != written_drawing(figure(0.7), "svg")
