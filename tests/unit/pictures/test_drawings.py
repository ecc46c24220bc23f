"""Drawings for papers: the right thing, the same bytes, all formats."""

from __future__ import annotations

import io
import xml.etree.ElementTree as ET
from functools import cache
from itertools import product

import matplotlib.image
import numpy as np
import pytest
from matplotlib.figure import Figure

from gspcli.errors import GspError
from gspcli.pictures.figures import styled, written, written_drawing
from gspcli.pictures.line_drawings import Label, Paper, View, apart, drawing
from gspcli.pictures.scene import Scene
from gspcli.pictures.stage import convex_hull, scene_of
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


# Hulls of a few points.


CUBE = np.array([*product((0.0, 1.0), repeat=3)])


def test_a_cube_has_six_squares_and_inner_points_none() -> None:
    faces = convex_hull(np.concatenate((CUBE, [[0.5, 0.5, 0.5], [0.5, 0.5, 0.0]])))
    assert sorted(len(face) for face in faces) == [4] * 6


def test_corners_come_in_order() -> None:
    (face,) = convex_hull(np.array([[0, 0, 3], [1, 1, 3], [1, 0, 3], [0, 1, 3], [0.5, 0.2, 3.0]]))
    sides = np.linalg.norm(face - np.roll(face, 1, axis=0), axis=1)
    np.testing.assert_allclose(sides, 1)


@pytest.mark.parametrize(
    ("points", "corners"),
    [
        (np.empty((0, 3)), []),
        (np.ones((4, 3)), []),
        (np.outer([3.0, 1.0, 2.0], [1.0, 1.0, 0.0]), [2]),
    ],
)
def test_less_than_a_plane(points: np.ndarray, corners: list[int]) -> None:
    assert [len(face) for face in convex_hull(points)] == corners


def test_a_measured_plate_is_one_polygon() -> None:
    turns = np.arange(6) * np.pi / 3
    plate = np.column_stack((np.cos(turns), np.sin(turns), 1e-4 * (-1.0) ** np.arange(6)))
    (face,) = convex_hull(plate + 1000.0)
    assert len(face) == 6


def test_every_point_is_inside_the_hull() -> None:
    points = np.random.default_rng(7).normal(size=(12, 3))
    faces = convex_hull(points)
    centre = points.mean(axis=0)
    for a, b, c in faces:
        normal = np.cross(b - a, c - a)
        outward = normal * np.sign(normal @ (a - centre))
        assert ((points - a) @ outward <= 1e-9).all()
    corners = {tuple(corner) for face in faces for corner in face}
    # Euler's formula for a hull of triangles.
    assert len(faces) == 2 * len(corners) - 4


# Names and numbers stand apart, near their points.


SIZE = np.array([12.0, 9.0])
RIGHT = np.array([1.0, 0.0])


def shared(labels: list[Label], shifts: list[np.ndarray]) -> np.ndarray:
    """Return which labels overlap, shape (n, n)."""
    middles = np.array([label.at + shift for label, shift in zip(labels, shifts, strict=True)])
    sizes = np.array([label.size for label in labels])
    gaps = np.abs(middles[:, None] - middles) - (sizes[:, None] + sizes) / 2
    return np.triu((gaps < -1e-6).all(axis=2), 1)


def test_what_has_room_stands_where_it_wants_to() -> None:
    labels = [Label(np.zeros(2), SIZE, RIGHT), Label(np.array([50.0, 0]), SIZE, None)]
    name, number = apart(labels)
    assert name == pytest.approx([10.0, 0.0])
    assert number == pytest.approx([0.0, 0.0])


def test_a_number_leaves_a_point_and_a_name_goes_around_a_number() -> None:
    labels = [Label(np.zeros(2), SIZE, RIGHT), Label(np.array([3.0, 0]), SIZE, None)]
    shifts = apart(labels)
    assert np.abs(shifts[1]).max() > 0
    assert not shared(labels, shifts).any()


def test_many_at_one_place_stand_apart() -> None:
    at = np.random.default_rng(3).uniform(-25, 25, size=(12, 2))
    labels = [Label(p, SIZE, RIGHT if k % 2 else None) for k, p in enumerate(at)]
    assert shared(labels, [np.zeros(2)] * 12).any()
    assert not shared(labels, apart(labels)).any()


def test_a_name_stands_beside_strokes_and_a_number_on_them() -> None:
    stroke = np.array([[[-40.0, 0.0], [40.0, 0.0]]])
    name, number = Label(np.zeros(2), SIZE, RIGHT), Label(np.array([30.0, 0.0]), SIZE, None)
    to_the_right, on_it = apart([name, number])
    assert to_the_right[1] == 0
    beside, still_on_it = apart([name, number], stroke)
    assert abs(beside[1]) > SIZE[1] / 2
    assert np.array_equal(on_it, still_on_it)


def test_a_stroke_that_ends_before_a_name_does_not_move_it() -> None:
    stroke = np.array([[[-40.0, 0.0], [2.0, 0.0]], [[16.5, -9.0], [16.5, 9.0]]])
    (shift,) = apart([Label(np.zeros(2), SIZE, RIGHT)], stroke)
    assert shift == pytest.approx([10.0, 0.0])


@pytest.mark.parametrize("name", ["example-6.8", "figure-2", "rubin-m2", "fixture-3-2-1"])
def test_labels_of_drawings_stand_apart(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    placed = []

    def recorded(labels: list[Label], strokes: np.ndarray) -> list[np.ndarray]:
        shifts = apart(labels, strokes)
        placed.append((labels, shifts))
        return shifts

    monkeypatch.setattr("gspcli.pictures.line_drawings.apart", recorded)
    drawing(scene_of(solve(load(instance_files()[name]))), "svg", [0, 1])
    assert len(placed) == 2
    for labels, shifts in placed:
        assert len(labels) >= 10
        assert not shared(labels, shifts).any()


def test_all_panels_have_one_scale(monkeypatch: pytest.MonkeyPatch) -> None:
    reaches = []
    finish = Paper.finish

    def recorded(paper: Paper, reach: np.ndarray | None = None) -> None:
        finish(paper, reach)
        low, high = paper.axes.get_ylim()
        reaches.append([high - low, paper.reach[1]])

    monkeypatch.setattr(Paper, "finish", recorded)
    scene = scene_of(solve(load(instance_files()["octahedral-3-3"])))
    drawing(scene, "svg", range(4))
    heights, drawn = np.transpose(reaches)
    assert np.ptp(heights) < 1e-9
    assert np.ptp(drawn) > 0.1
    assert heights[0] == pytest.approx(2 * drawn.max())


def test_a_mode_far_away_does_not_make_specks_of_the_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    heights, titles = [], []
    finish = Paper.finish

    def recorded(paper: Paper, reach: np.ndarray | None = None) -> None:
        finish(paper, reach)
        low, high = paper.axes.get_ylim()
        heights.append((high - low) / (2 * paper.reach.max()))
        titles.append(paper.axes.title)

    monkeypatch.setattr(Paper, "finish", recorded)
    drawing(scene_of(solve(load(instance_files()["surfaces-ppp"]))), "svg", range(12))
    # Most are drawn large, and the one that is not says so.
    assert np.median(heights) < 2
    assert ["smaller" in title.get_text() for title in titles].count(True) == 1
