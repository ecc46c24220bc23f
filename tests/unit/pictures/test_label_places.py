"""Names and numbers stand apart, near their points."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.pictures.line_drawings import drawing
from gspcli.pictures.projection import Label, Paper, apart
from gspcli.pictures.stage import scene_of
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec import load

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

    monkeypatch.setattr("gspcli.pictures.projection.apart", recorded)
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
