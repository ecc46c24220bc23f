"""The page of `gsp view --live` in a real browser, opened as a file, without a network."""

from __future__ import annotations

import io
import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib.image
import numpy as np
import pytest

import gspcli
from gspcli.geometry.euler import euler_from_rotation, rotation_from_euler
from gspcli.geometry.frames import PoseFrame
from gspcli.pictures.live_numbers import live_numbers
from gspcli.pictures.whole_views import viewed
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec import load, set_values
from tests.support.live_pages import give, opened, settle, text

if TYPE_CHECKING:
    from tests.support.browser import Browser


NAME = "workspace-study"


def modes(browser: Browser) -> dict[int, list[float]]:
    """Return x, y, z and condition of each mode of the list."""
    rows = browser.run(
        "[...document.querySelectorAll('#modes tbody tr:not(.gone)')]"
        ".map((row) => [...row.cells].map((cell) => cell.textContent))"
    )
    return {
        int(number.removesuffix("home")): [
            float(x.replace("−", "-").replace("∞", "inf")) for x in cells
        ]
        for number, *cells in rows
    }


def followed(browser: Browser) -> int:
    return int(browser.run("document.querySelector('#modes [aria-current]').dataset.mode"))


def account(total: int, real: int) -> str:
    """Return what is said where all poses are proved."""
    return f"{real} ways to assemble it; none is missing {total} poses, {real} real: proved"


def is_what_solve_says(browser: Browser, name: str, values: dict[int, float]) -> None:
    result = solve(set_values(load(instance_files()[name]), values))
    assert text(browser, "status") == account(len(result.solutions), result.counts.real)
    listed = sorted(tuple(row[:3]) for row in modes(browser).values())
    places = 1 if name == NAME else 3
    expected = sorted(
        tuple((row.round(places) + 0.0).tolist()) for row in result.T.real[: result.counts.real]
    )
    np.testing.assert_allclose(listed, expected, atol=1.01 * 10.0**-places)


@pytest.mark.parametrize("name", [NAME, "t-top-head", "example-6.8", "figure-3", "dietmaier"])
def test_the_page_opens_without_errors_or_requests(
    browser: Browser, live: Callable[..., Path], name: str
) -> None:
    path = live(name)
    opened(browser, path)
    result = solve(load(instance_files()[name]))
    assert f", {result.counts.real} real" in text(browser, "status")
    assert followed(browser) == (1 if result.home is None else result.home.number)
    assert list(modes(browser)) == list(range(1, result.counts.real + 1))
    assert browser.messages == []
    assert [url for url in browser.requests if not url.startswith("blob:")] == [path.as_uri()]


def test_the_pointer_drags_a_value(browser: Browser, live: Callable[..., Path]) -> None:
    opened(browser, live())
    left, top, width, height = browser.run(
        "(({x, y, width, height}) => [x, y, width, height])"
        "(document.querySelector('#values input[type=range]').getBoundingClientRect())"
    )
    middle = top + height / 2
    at = left + 0.52 * width
    browser.mouse("mousePressed", at, middle, button="left", clickCount=1)
    for k in range(1, 6):
        browser.mouse("mouseMoved", at - 8 * k, middle, button="left", buttons=1)
        browser.settle()
    browser.mouse("mouseReleased", at - 40, middle, button="left", clickCount=1)
    settle(browser)
    value = float(browser.run("document.getElementById('value-1').value"))
    assert 380 < value < 410
    assert followed(browser) == 16
    is_what_solve_says(browser, NAME, {1: value})
    assert browser.messages == []


def test_modes_meet_in_a_fold_and_come_back_with_their_numbers(
    browser: Browser, live: Callable[..., Path]
) -> None:
    opened(browser, live())
    before = modes(browser)
    for value in (415.0, 405.0, 402.0):
        give(browser, "value-1", value)
    assert text(browser, "event") == ("modes 7 and 10, 8 and 13 have met and vanished")
    assert set(before) - set(modes(browser)) == {7, 8, 10, 13}
    for value in (405.0, 415.0, 423.68345110029213):
        give(browser, "value-1", value)
    assert modes(browser) == before


def test_the_pose_moves_and_values_are_measured(
    browser: Browser, live: Callable[..., Path]
) -> None:
    opened(browser, live())
    browser.run("document.querySelector('input[value=pose]').click()")
    give(browser, "pose-x", 20)
    give(browser, "pose-ry", 5)
    values = browser.run(
        "[1, 2, 3, 4, 5, 6].map((k) => document.getElementById(`value-${k}`).value)"
    )
    assert modes(browser)[followed(browser)][:3] == [20, 0, 400]
    turned = "5° about (0, 1, 0)"
    assert turned in text(browser, "pose")
    is_what_solve_says(browser, NAME, {k: float(x) for k, x in enumerate(values, start=1)})


def test_another_mode_is_followed(browser: Browser, live: Callable[..., Path]) -> None:
    opened(browser, live())
    browser.run("document.querySelector('#modes [data-mode=\"3\"] button').click()")
    assert (followed(browser), text(browser, "followed-name")) == (3, "Mode 3")
    browser.run("document.activeElement.blur()")
    browser.key("ArrowRight")
    assert followed(browser) == 4
    browser.key("h")
    assert followed(browser) == 16


def test_a_ghost_is_followed_at_a_click(browser: Browser, live: Callable[..., Path]) -> None:
    opened(browser, live("example-6.8"))
    first = followed(browser)
    left, top, width, height = browser.run(
        "(({x, y, width, height}) => [x, y, width, height])(canvas.getBoundingClientRect())"
    )
    for k in range(400):
        x, y = left + width * (k % 20 + 0.5) / 20, top + height * (k // 20 + 0.5) / 20
        for event in ("mousePressed", "mouseReleased"):
            browser.mouse(event, x, y, button="left", clickCount=1)
        if followed(browser) != first:
            break
    assert followed(browser) != first


def test_the_keyboard_moves_sliders_and_map(browser: Browser, live: Callable[..., Path]) -> None:
    opened(browser, live())
    value = "Number(document.getElementById('value-1').value)"
    browser.run("document.querySelector('#values input[type=range]').focus()")
    before = browser.run(value)
    browser.key("ArrowLeft")
    browser.key("ArrowLeft")
    browser.settle()
    assert browser.run(value) == pytest.approx(before - 0.2, abs=0.06)
    browser.run("document.getElementById('map').focus()")
    browser.key("ArrowRight")
    browser.settle()
    assert browser.run(value) == pytest.approx(before + 0.8, abs=0.06)


def test_the_link_keeps_the_state(browser: Browser, live: Callable[..., Path]) -> None:
    path = live()
    opened(browser, path)
    give(browser, "value-1", 430.5)
    give(browser, "value-4", 420)
    browser.run("document.querySelector('#modes [data-mode=\"12\"] button').click()")
    browser.wait("location.hash.includes('mode')")
    assert browser.run("location.hash") == "#1=430.5&4=420&mode=12"
    there = modes(browser)
    opened(browser, path, "#1=430.5&4=420&mode=12")
    assert modes(browser) == there
    assert followed(browser) == 12
    browser.run("location.hash = '#2=425&mode=15'")
    browser.wait("document.getElementById('value-2').value === '425'")
    assert followed(browser) == 15
    is_what_solve_says(browser, NAME, {2: 425})
    opened(browser, path, "#1=nonsense&mode=99&9=2")
    assert text(browser, "status") == account(28, 16)


def test_the_map_fills_with_numbers_of_real_modes(
    browser: Browser, live: Callable[..., Path]
) -> None:
    opened(browser, live("figure-3"))
    browser.wait("document.getElementById('map').dataset.filled === 'true'")
    legend = browser.run(
        "[...document.querySelectorAll('#map-legend li')]"
        ".map((item) => [item.textContent, item.querySelector('i').style.background])"
    )
    colours = {
        tuple(map(int, re.findall(r"\d+", colour))): int(words.split()[0])
        for words, colour in legend
        if not words.startswith("not all proved")
    }
    pixels = browser.run("[...map.getContext('2d').getImageData(0, 0, 128, 128).data]")
    image = np.array(pixels).reshape(128, 128, 4)
    instance = load(instance_files()["figure-3"])
    ranges = live_numbers(solve(instance))["ranges"]
    for column, row in ((3, 5), (40, 90), (64, 64), (100, 20), (120, 120)):
        x, y = (
            low + (high - low) * (k + 0.5) / 128
            for k, (low, high) in zip((column, row), ranges, strict=False)
        )
        result = solve(set_values(instance, {1: x, 2: y}))
        assert colours[tuple(image[127 - row, column, :3].tolist())] == result.counts.real
    assert browser.run("map.getAttribute('aria-label')").startswith(
        "Map of the number of real modes over values 1 and 2: "
    )
    assert browser.messages == []


def test_the_map_moves_two_values(browser: Browser, live: Callable[..., Path]) -> None:
    opened(browser, live("figure-3"))
    browser.run(
        "(() => { const x = document.getElementById('map-x'); x.value = '2';"
        " x.dispatchEvent(new Event('change')); })()"
    )
    browser.run("map.scrollIntoView()")
    left, top, width, height = browser.run(
        "(({x, y, width, height}) => [x, y, width, height])(map.getBoundingClientRect())"
    )
    x, y = left + 0.75 * width, top + 0.25 * height
    browser.mouse("mousePressed", x, y, button="left", clickCount=1)
    browser.mouse("mouseReleased", x, y, button="left", clickCount=1)
    settle(browser)
    values = [float(browser.run(f"document.getElementById('value-{k}').value")) for k in (3, 2)]
    assert values == pytest.approx([3.85 + 0.75 * 3.3, 4.2 + 0.75 * 3.6], rel=0.01)
    browser.wait("location.hash.includes('map=3,2')")
    assert browser.messages == []


def picture(browser: Browser) -> np.ndarray:
    return matplotlib.image.imread(io.BytesIO(browser.screenshot()), format="png")[..., :3]


def test_light_and_dark(browser: Browser, live: Callable[..., Path]) -> None:
    browser.prefer("dark")
    opened(browser, live("figure-3"))
    assert picture(browser)[300, 500].max() < 0.5
    browser.key("d")
    browser.settle()
    assert picture(browser)[10, 500].min() > 0.8


@pytest.mark.parametrize("width", [360, 800, 1280])
def test_nothing_is_wider_than_the_window(
    browser: Browser, live: Callable[..., Path], width: int
) -> None:
    browser.size(width, 740)
    opened(browser, live("figure-3"))
    assert browser.run("document.documentElement.scrollWidth") == width
    beyond: list[Any] = browser.run(
        "[...document.querySelectorAll('.panel *, .told *')]"
        ".filter((one) => one.checkVisibility() && !one.closest('.scroll, .unseen'))"
        ".filter((one) => one.getBoundingClientRect().right > innerWidth)"
        ".map((one) => one.outerHTML)"
    )
    assert beyond == []


def test_without_webgl_it_solves(browser: Browser, live: Callable[..., Path]) -> None:
    script = """const all = HTMLCanvasElement.prototype.getContext;
        HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
          return kind === "2d" ? all.call(this, kind, ...more) : null; }"""
    added = browser.call("Page.addScriptToEvaluateOnNewDocument", source=script)
    opened(browser, live())
    browser.call("Page.removeScriptToEvaluateOnNewDocument", identifier=added["identifier"])
    assert "needs WebGL" in text(browser, "notice")
    give(browser, "value-1", 430)
    is_what_solve_says(browser, NAME, {1: 430})


def test_what_changed_is_spoken(browser: Browser, live: Callable[..., Path]) -> None:
    opened(browser, live())
    give(browser, "value-1", 402)
    browser.wait("document.getElementById('spoken').textContent.includes('12 real')")
    assert text(browser, "spoken").startswith(
        "12 ways to assemble it; none is missing; 28 poses, 12 real: proved; mode 16, condition "
    )


def test_the_followed_mode_goes_home_along_a_proved_way(
    browser: Browser, live: Callable[..., Path]
) -> None:
    opened(browser, live())
    home, values = text(browser, "pose"), "[...document.querySelectorAll('#values input')]"
    before = browser.run(f"{values}.map((one) => one.value)")
    opened(browser, live(), "#1=320&4=420")
    settle(browser)
    assert text(browser, "pose") != home
    said = "Home by straight leg lengths: proved, not singular; ranges kept."
    browser.wait(f"document.getElementById('way-said').textContent === {json.dumps(said)}")
    browser.run("document.getElementById('way-home').click()")
    assert text(browser, "event") == said
    # It is on the way, not there at once.
    assert text(browser, "pose") != home
    browser.wait(f"{values}[0].value === {json.dumps(before[0])} && !location.hash")
    settle(browser)
    assert browser.run(f"{values}.map((one) => one.value)") == before
    assert text(browser, "pose") == home
    assert browser.messages == []


def test_from_another_mode_no_way_home_is_claimed(
    browser: Browser, live: Callable[..., Path]
) -> None:
    opened(browser, live(), "#mode=2")
    settle(browser)
    at = text(browser, "pose")
    browser.run("document.dispatchEvent(new KeyboardEvent('keydown', {key: 'w'}))")
    assert "No safe way home: all ways pass a singular pose" in text(browser, "event")
    browser.wait("document.getElementById('way-home').disabled")
    assert text(browser, "way-said") in text(browser, "event")
    assert text(browser, "pose") == at


def test_another_mode_goes_home_through_stored_poses(
    browser: Browser, live: Callable[..., Path]
) -> None:
    """The mode that is followed keeps its number until it is at home, and is home then."""
    opened(browser, live(), "#mode=5")
    browser.wait("document.getElementById('way-said').dataset.kind === 'stored'")
    assert " stored poses: proved, not singular; ranges kept." in text(browser, "way-said")
    # What is shown on the way, however long a picture takes.
    browser.run(
        "(() => { window.shown = []; const all = ['followed-name', 'event'];"
        " const note = () => shown.push(all.map((id) => {"
        "   return document.getElementById(id).textContent; }));"
        " for (const id of ['followed-name', 'event'])"
        "   new MutationObserver(note).observe(document.getElementById(id),"
        "     { childList: true, subtree: true, characterData: true });"
        " note(); document.getElementById('way-home').click(); })()"
    )
    browser.wait("document.getElementById('way-said').textContent === 'It is at home.'")
    shown = browser.run("shown")
    assert {name for name, _ in shown} <= {"Mode 5", "Mode 16, home"}
    assert not any("singular pose" in event for _, event in shown)
    assert text(browser, "followed-name") == "Mode 16, home"
    assert browser.messages == []


# Sliders of the pose in a live page, in the frames of the file or relative to home.


AXES = ("x", "y", "z", "rx", "ry", "rz")
MACHINE = replace(
    gspcli.example("workspace-study"),
    frames=gspcli.Frames(
        tool=gspcli.Frame([3, -5, 30], euler="xyz", angles=(10, -20, 30)),
        work=gspcli.Frame([100, 20, -7], euler="xyz", angles=(-15, 25, 40)),
    ),
)
FRAMES = {
    "work": (PoseFrame.of(MACHINE), "poses of the tool in the work frame"),
    "home": (
        PoseFrame.of(MACHINE, relative=True),
        "poses of the tool relative to home, along the axes of the work frame",
    ),
    "none": (PoseFrame(), "poses of the platform in the base"),
}


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    folder, result = tmp_path_factory.mktemp("framed"), solve(MACHINE)
    assert result.home is not None
    start = result.home.number - 1

    def write(name: str) -> Path:
        path = folder / f"{name}.html"
        path.write_bytes(viewed(result, "html", start, live=True, frame=FRAMES[name][0])[1])
        return path

    return write


def numbers(browser: Browser, name: str, keys: tuple[str, ...]) -> np.ndarray:
    return np.array(
        [float(browser.run(f"document.getElementById('{name}-{k}').value")) for k in keys]
    )


@pytest.mark.parametrize("name", FRAMES)
def test_sliders_are_expressed_poses(
    browser: Browser, page: Callable[[str], Path], name: str
) -> None:
    frame, words = FRAMES[name]
    opened(browser, page(name))
    browser.run("document.querySelector('input[value=pose]').click()")
    assert text(browser, "coordinates").startswith(words + "; turns about its fixed axes x, y, z")

    def shown(R: np.ndarray, T: np.ndarray) -> np.ndarray:
        turn, at = frame.from_platform(R, T)
        return np.concatenate((at, np.rad2deg(euler_from_rotation("xyz", turn))))

    home = MACHINE.home
    assert home is not None
    start = shown(home.R(1.0), home.T)
    assert numbers(browser, "pose", AXES) == pytest.approx(start, abs=1e-2)
    if name == "home":
        assert start == pytest.approx(np.zeros(6), abs=1e-9)
    # A number that is typed moves the platform there; the values are those of that pose.
    moved = numbers(browser, "pose", AXES)
    for k, step in ((0, 12.0), (4, 5.0), (5, -8.0)):
        moved[k] += step
        give(browser, f"pose-{AXES[k]}", moved[k])
    R, T = frame.to_platform(rotation_from_euler("xyz", np.deg2rad(moved[3:])), moved[:3])
    values = gspcli.measure(MACHINE, R, T)
    assert numbers(browser, "value", tuple("123456")) == pytest.approx(
        np.asarray(values).ravel(), abs=2e-2
    )


# Links, the way home and the text about both on live pages.


#: The machine of the page: mode 16 is home, and of 16 real modes four vanish where value 1 is 402.
HOME = 16


def followed_mode(browser: Browser) -> str:
    return str(browser.run("document.querySelector('#modes [aria-current]')?.dataset.mode ?? ''"))


def test_a_link_is_not_overwritten_by_the_move_before(
    browser: Browser, live: Callable[..., Path]
) -> None:
    # The timers of the page are due when the link is set, and its event comes after them.
    script = """window.addEventListener("hashchange", (event) => {
          if (window.isLate) return;
          window.isLate = true;
          event.stopImmediatePropagation();
          setTimeout(() => window.dispatchEvent(new Event("hashchange")), 600);
        });"""
    added = browser.call("Page.addScriptToEvaluateOnNewDocument", source=script)
    opened(browser, live())
    browser.call("Page.removeScriptToEvaluateOnNewDocument", identifier=added["identifier"])
    browser.run(
        "(async () => { const one = document.getElementById('value-1'); one.value = 430.5;"
        " one.dispatchEvent(new Event('change'));"
        " await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));"
        " location.hash = '#2=425&mode=15'; })()"
    )
    browser.run("new Promise((done) => setTimeout(done, 1000))")
    browser.wait("document.getElementById('value-2').value === '425'")
    assert browser.run("location.hash") == "#2=425&mode=15"
    assert followed_mode(browser) == "15"


def test_a_mode_that_is_not_there_is_home(browser: Browser, live: Callable[..., Path]) -> None:
    opened(browser, live(), "#mode=999")
    assert followed_mode(browser) == str(HOME)
    assert text(browser, "followed-name") == f"Mode {HOME}, home"


def test_what_vanished_is_not_said_at_home(browser: Browser, live: Callable[..., Path]) -> None:
    opened(browser, live())
    give(browser, "value-1", 402)
    assert "have met and vanished" in text(browser, "event")
    browser.run("document.getElementById('home').click()")
    assert text(browser, "event") == ""
    browser.wait("document.getElementById('spoken').textContent.includes('16 real')")
    assert "vanished" not in text(browser, "spoken")


@pytest.mark.parametrize(
    ("fragment", "said"),
    [
        ("#1=1e308", "No real pose is known for these values."),
        ("#1=-1", "There is no real pose for these values."),
    ],
)
def test_poses_that_are_not_known_may_be_there(
    browser: Browser, live: Callable[..., Path], fragment: str, said: str
) -> None:
    opened(browser, live("nano-hexapod"), fragment)
    browser.wait("document.getElementById('busy').hidden")
    assert text(browser, "no-mode") == said


def test_values_that_take_long_are_solved_when_the_slider_rests(
    browser: Browser, live: Callable[..., Path]
) -> None:
    # A processor on which all poses take 40 ms.
    script = """let late = 0; const now = performance.now.bind(performance);
        performance.now = () => now() + (late += 40);
        window.Worker = class extends Worker {
          addEventListener(type, hear) {
            const later = ({ data }) => hear({ data: { ...data, milliseconds: 40 } });
            super.addEventListener(type, later);
          }
        };"""
    added = browser.call("Page.addScriptToEvaluateOnNewDocument", source=script)
    opened(browser, live())
    browser.call("Page.removeScriptToEvaluateOnNewDocument", identifier=added["identifier"])
    for value in (422, 421, 420, 419):
        give(browser, "value-1", value)
    rows = "document.querySelectorAll('#modes tbody tr:not(.gone)').length"
    browser.run(
        f"(() => {{ window.seen = []; new MutationObserver(() => seen.push([busy.hidden, {rows}]))"
        ".observe(busy, {attributes: true}); })()"
    )
    give(browser, "value-1", 402)
    # The live_links_followed mode moves at once; the others come when it rests.
    assert browser.run("seen") == [[False, 1], [True, 12]]
    assert "12 real" in text(browser, "status")
    assert text(browser, "event") == "modes 7 and 10, 8 and 13 have met and vanished"
    assert followed_mode(browser) == str(HOME)
    # Rows that came did not push the followed one out of the list; the frame of the list, of one
    # pixel, and a part of a pixel may cover its lower edge.
    below = browser.run(
        "document.querySelector('#modes [aria-current]').getBoundingClientRect().bottom"
        " - document.querySelector('#mode-list .scroll').getBoundingClientRect().bottom"
    )
    assert below < 2
    assert browser.messages == []


# Words of live pages are explained; their texts can be read and their controls touched.


#: Pixels that a finger needs, and contrasts that small text needs.
TARGET, CONTRAST = 24, 4.5
_SMALL = f"""
[...document.querySelectorAll("button, input, select, summary")]
  .filter((one) => one.checkVisibility() && !one.closest(".tabs"))
  .map((one) => {{
    const around = one.type === "checkbox" ? one.closest("label") : one;
    const {{ width, height }} = around.getBoundingClientRect();
    return [one.outerHTML.slice(0, 80), width, height];
  }})
  .filter(([, width, height]) => Math.min(width, height) < {TARGET})
"""


@pytest.mark.parametrize("width", [360, 1280])
def test_fingers_find_everything(browser: Browser, live: Callable[..., Path], width: int) -> None:
    browser.size(width, 800)
    opened(browser, live("example-6.8"))
    assert browser.run(_SMALL) == []


def test_the_dot_of_the_map_is_seen_where_the_pose_is_moved(
    browser: Browser, live: Callable[..., Path]
) -> None:
    opened(browser, live("nano-hexapod"))
    browser.run("document.querySelector('input[value=pose]').click()")
    # So far that both values are beyond the map.
    give(browser, "pose-z", 0.2)
    inside = browser.run(
        "(() => { const [dot, map] = ['map-dot', 'map']"
        "   .map((id) => document.getElementById(id).getBoundingClientRect());"
        " return dot.width > 0 && dot.left > map.left - 12 && dot.right < map.right + 12"
        "   && dot.top > map.top - 12 && dot.bottom < map.bottom + 12; })()"
    )
    assert inside
    assert browser.run("document.getElementById('map-dot').className") == "beyond"


def cues(browser: Browser) -> list[Any]:
    return browser.run(
        "[...document.querySelectorAll('#modes tbody .chip')]"
        ".map((chip) => `${chip.style.background} ${chip.dataset.cue}`)"
    )


def test_of_many_modes_the_nearest_are_drawn_and_all_are_told_apart(
    browser: Browser, live: Callable[..., Path]
) -> None:
    opened(browser, live("dietmaier"))
    assert browser.run("document.getElementById('others').value") == "near"
    # Nine colours with four signs.
    assert len(set(cues(browser))) == 36
    opened(browser, live("nano-hexapod"))
    assert browser.run("document.getElementById('others').value") == "all"
    assert len(set(cues(browser))) == 8


def test_a_followed_row_near_a_fold_can_be_read(
    browser: Browser, live: Callable[..., Path]
) -> None:
    opened(browser, live("dietmaier"))
    colours = browser.run(
        "(() => { const row = document.querySelector('#modes tr.near[aria-current]');"
        " return [getComputedStyle(row.lastElementChild).color,"
        " getComputedStyle(row).backgroundColor]; })()"
    )
    ink, paper = (brightness(colour) for colour in colours)
    assert (max(ink, paper) + 0.05) / (min(ink, paper) + 0.05) >= CONTRAST


def brightness(colour: str) -> float:
    """Return the relative luminance of WCAG 2."""
    parts = [int(x) / 255 for x in colour[4:-1].split(",")]
    linear = [x / 12.92 if x <= 0.03928 else ((x + 0.055) / 1.055) ** 2.4 for x in parts]
    return float(0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2])


def test_the_notice_without_webgl_hides_nothing(
    browser: Browser, live: Callable[..., Path]
) -> None:
    script = """const all = HTMLCanvasElement.prototype.getContext;
        HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
          return kind === "2d" ? all.call(this, kind, ...more) : null; }"""
    added = browser.call("Page.addScriptToEvaluateOnNewDocument", source=script)
    opened(browser, live("nano-hexapod"))
    browser.call("Page.removeScriptToEvaluateOnNewDocument", identifier=added["identifier"])
    status, notice = browser.run(
        "['status', 'notice'].map((id) => document.getElementById(id).getBoundingClientRect())"
        ".map(({ top, bottom }) => [top, bottom])"
    )
    assert notice[0] >= status[1]
