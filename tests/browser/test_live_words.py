"""Words of live pages are explained; their texts can be read and their controls touched."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from tests.support.live_pages import give, opened

if TYPE_CHECKING:
    from tests.support.browser import Browser

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
