"""The page of `gsp view` in a real browser, opened as a file, without a network."""

from __future__ import annotations

import io
import time
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib.image
import numpy as np
import pytest

from gspcli.motion import PoseFormat
from gspcli.pictures.page import page
from gspcli.pictures.stage import scene_of
from gspcli.pictures.whole_views import read_tracks
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec import load
from tests.support.browser import PATIENCE

if TYPE_CHECKING:
    from tests.support.browser import Browser

SHIFT = 8
STAGE = "document.getElementById('canvas').getBoundingClientRect()"


@pytest.fixture(scope="module")
def view(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    folder = tmp_path_factory.mktemp("pages")

    def write(name: str, track: str | None = None) -> Path:
        path = folder / f"{name}-{zlib.crc32((track or '').encode())}.html"
        if not path.exists():
            tracks = read_tracks(track, "track.csv", PoseFormat()) if track else []
            scene = scene_of(solve(load(instance_files()[name])), tracks)
            path.write_text(page(scene), encoding="utf-8")
        return path

    return write


def window(browser: Browser) -> np.ndarray:
    """Return the pixels of the window, (height, width, 3)."""
    return matplotlib.image.imread(io.BytesIO(browser.screenshot()), format="png")[..., :3]


def picture(browser: Browser) -> np.ndarray:
    """Return the pixels of the canvas, as the screen shows them."""
    image = window(browser)
    left, top, width, height = browser.run(
        f"(({{x, y, width, height}}) => [x, y, width, height])({STAGE})"
    )
    return image[int(top) : int(top + height), int(left) : int(left + width)]


def colours(image: np.ndarray) -> int:
    parts = (image.reshape(-1, 3) * 255).astype(np.int64)
    return len(np.unique(parts @ [1, 256, 65536]))


def text(browser: Browser, element: str) -> str:
    return str(browser.run(f"document.getElementById('{element}').textContent"))


def current(browser: Browser) -> list[int]:
    return browser.run(
        "[...document.querySelectorAll('#modes tbody tr')].flatMap((row, k) =>"
        " row.getAttribute('aria-current') ? [k + 1] : [])"
    )


@pytest.mark.parametrize(
    "name",
    ["example-6.8", "figure-3", "surfaces-ppp", "griffis-duffy", "no-real-pose", "dietmaier"],
)
def test_the_page_draws_without_errors_or_requests(
    browser: Browser, view: Callable[..., Path], name: str
) -> None:
    path = view(name)
    browser.open(path)
    assert colours(picture(browser)) > 50
    assert browser.messages == []
    assert browser.requests == [path.as_uri()]


def test_the_slider_the_list_and_the_keys_choose_a_mode(
    browser: Browser, view: Callable[..., Path]
) -> None:
    browser.open(view("octahedral-3-3"))
    assert current(browser) == [1]
    first = picture(browser)
    browser.run("slider.value = 3; slider.dispatchEvent(new Event('input'))")
    assert (current(browser), text(browser, "where")) == ([3], "mode 3 of 4")
    assert np.abs(picture(browser) - first).max() > 0.2
    browser.run("document.querySelectorAll('#modes button')[1].click()")
    assert (current(browser), browser.run("slider.value")) == ([2], "2")
    browser.key("ArrowRight")
    assert current(browser) == [3]
    browser.key("ArrowLeft")
    browser.key("ArrowLeft")
    browser.key("ArrowLeft")
    assert current(browser) == [4]
    assert "1.29559" in text(browser, "pose")
    assert browser.messages == []


def test_joints_that_move_are_moved(browser: Browser, view: Callable[..., Path]) -> None:
    track = "t,x,y,z,qw,qx,qy,qz,crank.B1\n0,0,0,0,1,0,0,0,0\n1,0,0,0,1,0,0,0,60\n"
    browser.open(view("t-top-head", track))
    browser.run("series.value = 1; series.dispatchEvent(new Event('change'))")
    places = []
    for k in (1, 2):
        browser.run(f"slider.value = {k}; slider.dispatchEvent(new Event('input'))")
        found = browser.run(
            "['B1', 'B2', 'B3'].map((name) => {"
            " const span = [...document.querySelectorAll('#labels span')]"
            ".find((one) => one.textContent === name);"
            " const { x, y } = span.getBoundingClientRect(); return [x, y]; })"
        )
        places.append(np.array(found))
    # The crank turns its joint; the others stay where they are to each other.
    moved = (places[1] - places[1][2]) - (places[0] - places[0][2])
    assert np.abs(moved[0]).max() > 5
    assert np.abs(moved[1]).max() < 1
    assert browser.messages == []


def test_playing_moves_on_and_stops(browser: Browser, view: Callable[..., Path]) -> None:
    browser.open(view("octahedral-3-3"))
    browser.key(" ")
    deadline = time.monotonic() + PATIENCE
    while current(browser) == [1]:
        assert time.monotonic() < deadline, "nothing moved"
    assert browser.run("play.getAttribute('aria-label')") == "pause"
    browser.key(" ")
    assert browser.run("play.getAttribute('aria-pressed')") == "false"


def test_light_and_dark(browser: Browser, view: Callable[..., Path]) -> None:
    browser.prefer("dark")
    browser.open(view("octahedral-3-3"))
    assert picture(browser)[5, 5].max() < 0.2
    browser.key("d")
    assert picture(browser)[5, 5].min() > 0.8


def test_colour_by_condition(browser: Browser, view: Callable[..., Path]) -> None:
    browser.open(view("octahedral-3-3"))
    before = picture(browser)
    browser.key("c")
    assert np.abs(picture(browser) - before).max() > 0.2
    assert browser.run("legend.hidden") is False


def test_views_names_frames_and_all_poses_change_the_picture(
    browser: Browser, view: Callable[..., Path]
) -> None:
    browser.open(view("octahedral-3-3"))
    seen = [picture(browser)]
    for key, modifiers in (("t", 0), ("ArrowUp", SHIFT), ("n", 0), ("a", 0), ("g", 0), ("-", 0)):
        browser.key(key, modifiers)
        seen.append(picture(browser))
        assert np.abs(seen[-1] - seen[-2]).max() > 0.1, key
    browser.run("document.querySelector('[data-view=reset]').click()")
    assert browser.messages == []


def test_what_is_under_the_pointer_is_measured(browser: Browser, view: Callable[..., Path]) -> None:
    browser.open(view("octahedral-3-3"))
    left, top = browser.run(
        "(({x, y}) => [x, y])([...document.querySelectorAll('#labels .bond')]"
        ".find((span) => span.textContent === '6').getBoundingClientRect())"
    )
    # The number sits on the leg.
    browser.mouse("mouseMoved", left + 8, top + 8)
    browser.wait("document.getElementById('tooltip').textContent !== ''")
    tooltip = text(browser, "tooltip")
    assert tooltip.startswith("Constraint 6: distance of P3 and B1 (DPP)\nmeasured: ")
    assert "asked for: " in tooltip
    assert browser.run("document.querySelectorAll('#constraints tr.chosen').length") == 1


def test_a_trajectory(browser: Browser, view: Callable[..., Path]) -> None:
    rows = [f"{k / 10},1,0.1,{k / 20},1.2,1,0,0,{k / 50},{3 + k},0.5" for k in range(11)]
    track = "\n".join(["t,mode,x,y,z,qw,qx,qy,qz,condition,clearance", *rows])
    browser.open(view("octahedral-3-3", track))
    browser.run("series.value = '1'; series.dispatchEvent(new Event('change'))")
    assert browser.run("slider.max") == "11"
    browser.run("slider.value = 6; slider.dispatchEvent(new Event('input'))")
    assert text(browser, "where") == "t 0.5"
    assert "clearance0.5" in text(browser, "pose")
    assert current(browser) == []
    assert browser.run("document.querySelectorAll('#chart polyline').length") == 1
    assert browser.messages == []


def test_the_chart_of_a_trajectory_has_numbers(browser: Browser, view: Callable[..., Path]) -> None:
    rows = [f"{2 + k / 10},1,0.1,{k / 20},1.2,1,0,0,{k / 50},{3 + k}" for k in range(11)]
    track = "\n".join(["t,mode,x,y,z,qw,qx,qy,qz,condition", *rows])
    browser.open(view("octahedral-3-3", track))
    browser.run("series.value = '1'; series.dispatchEvent(new Event('change'))")
    spans = "[...document.querySelectorAll('#chart span')].map((span) => span.textContent)"
    assert browser.run(spans) == ["13", "3", "2", "t", "3"]


def boxes(browser: Browser, selector: str) -> np.ndarray:
    """Return left, top, right and bottom of what is shown, shape (n, 4)."""
    found = browser.run(
        f"[...document.querySelectorAll('{selector}')]"
        ".filter((one) => one.style.display !== 'none')"
        ".map((one) => one.getBoundingClientRect())"
        ".map(({ left, top, right, bottom }) => [left, top, right, bottom])"
    )
    return np.array(found)


@pytest.mark.parametrize("width", [400, 1300])
@pytest.mark.parametrize("name", ["example-6.8", "figure-2", "rubin-m2", "fixture-3-2-1"])
def test_names_and_numbers_are_seen_whole(
    browser: Browser, view: Callable[..., Path], name: str, width: int
) -> None:
    browser.size(width, 850)
    try:
        browser.open(view(name))
        labels, (canvas,) = boxes(browser, "#labels span"), boxes(browser, "#canvas")
    finally:
        browser.size(1000, 600)
    low, high = labels[:, None, :2], labels[:, None, 2:]
    shared = np.minimum(high, high.swapaxes(0, 1)) - np.maximum(low, low.swapaxes(0, 1))
    hidden = np.triu(shared.min(axis=2) > 0.1, 1)
    assert len(labels) >= 10
    assert not hidden.any()
    assert (labels[:, :2] >= canvas[:2]).all()
    assert (labels[:, 2:] <= canvas[2:]).all()


def test_a_picture_is_saved(browser: Browser, view: Callable[..., Path], tmp_path: Path) -> None:
    browser.open(view("octahedral-3-3"))
    browser.call("Page.setDownloadBehavior", behavior="allow", downloadPath=str(tmp_path))
    browser.key("s")
    target = tmp_path / "octahedral-3-3-platform-mode-1-of-4.png"
    deadline = time.monotonic() + PATIENCE
    while not target.exists():
        assert time.monotonic() < deadline, list(tmp_path.iterdir())
        time.sleep(0.05)
    image = matplotlib.image.imread(target)
    # Twice the pixels of the canvas.
    assert image.shape[0] == 2 * picture(browser).shape[0]
    assert colours(image[..., :3]) > 50


def test_a_narrow_window_has_all_in_one_column(browser: Browser, view: Callable[..., Path]) -> None:
    browser.size(390, 800)
    browser.open(view("example-6.8"))
    assert browser.run("document.documentElement.scrollWidth") == 390
    assert colours(picture(browser)) > 50


def test_without_webgl_the_numbers_are_there(browser: Browser, view: Callable[..., Path]) -> None:
    script = "HTMLCanvasElement.prototype.getContext = () => null"
    added = browser.call("Page.addScriptToEvaluateOnNewDocument", source=script)
    browser.open(view("octahedral-3-3"))
    browser.call("Page.removeScriptToEvaluateOnNewDocument", identifier=added["identifier"])
    assert "needs WebGL" in text(browser, "notice")
    browser.key("ArrowRight")
    assert current(browser) == [2]


def test_a_notebook_shows_the_page_in_a_frame(browser: Browser, tmp_path: Path) -> None:
    result = solve(load(instance_files()["octahedral-3-3"]))
    path = tmp_path / "notebook.html"
    path.write_text(f"<!doctype html><title>cell</title>{result._repr_html_()}", encoding="utf-8")
    browser.open(path)
    deadline = time.monotonic() + PATIENCE
    while colours(window(browser)) <= 50:
        assert time.monotonic() < deadline, "nothing is drawn"
    assert browser.messages == []
