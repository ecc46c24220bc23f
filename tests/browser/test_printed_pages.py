"""Pages on paper: all modes, all values, the picture with its names where they belong."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from gspcli.pictures.page import page
from gspcli.pictures.stage import scene_of
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec import load
from tests.support.live_pages import opened

if TYPE_CHECKING:
    from tests.support.browser import Browser

#: A4 at 96 pixels an inch.
PAPER = (794, 1123)


@pytest.fixture
def printed(browser: Browser) -> Iterator[Callable[[], None]]:
    """What lays the page out for paper, as a browser does that prints it."""

    def lay_out() -> None:
        browser.run("window.dispatchEvent(new Event('beforeprint'))")
        browser.size(*PAPER)
        browser.call("Emulation.setEmulatedMedia", media="print")
        browser.settle()

    yield lay_out
    browser.call("Emulation.setEmulatedMedia", media="")


def unseen(browser: Browser, rows: str) -> Any:
    """Return the rows that are cut off by something around them, or not shown."""
    return browser.run(
        f"[...document.querySelectorAll('{rows}')].filter((row) => {{"
        " if (!row.checkVisibility()) return true;"
        " for (let one = row; one !== document.body; one = one.parentElement) {"
        "   const [box, around] = [row, one].map((x) => x.getBoundingClientRect());"
        "   const clips = getComputedStyle(one).overflowY !== 'visible';"
        "   if (clips && box.bottom > around.bottom + 1) return true;"
        " } return false; }).map((row) => row.textContent)"
    )


def test_a_live_page_is_printed_whole(
    browser: Browser, live: Callable[..., Path], printed: Callable[[], None]
) -> None:
    browser.prefer("dark")
    opened(browser, live("example-6.8"))
    browser.run("document.querySelector('input[value=pose]').click()")
    printed()
    assert browser.run("document.querySelectorAll('#modes tbody tr').length") == 64
    assert unseen(browser, "#modes tbody tr") == []
    assert unseen(browser, "#values .slider") == []
    assert unseen(browser, "#pose > div") == []
    # The picture has its names in it; nothing is laid over it.
    shown = [
        f"document.getElementById('{name}').checkVisibility()" for name in ("canvas", "labels")
    ]
    assert [browser.run(each) for each in shown] == [False, False]
    width, height, shape = browser.run(
        "(({ clientWidth, clientHeight, width, height }) =>"
        " [clientWidth, clientHeight, width / height])(document.getElementById('printed'))"
    )
    assert width > 300
    assert width / height == pytest.approx(shape, rel=0.01)
    # Paper is white for any colours of the screen.
    assert browser.run("document.documentElement.dataset.theme") == "light"
    browser.run("window.dispatchEvent(new Event('afterprint'))")
    assert browser.run("document.getElementById('printed')") is None
    assert browser.run("document.documentElement.dataset.theme") == "system"


def test_an_ordinary_page_is_printed_whole(
    browser: Browser, tmp_path: Path, printed: Callable[[], None]
) -> None:
    path = tmp_path / "page.html"
    path.write_text(page(scene_of(solve(load(instance_files()["example-6.8"])))), encoding="utf-8")
    browser.open(path)
    printed()
    assert unseen(browser, "#modes tbody tr") == []
    assert unseen(browser, "#constraints tbody tr") == []
    assert browser.run("document.getElementById('labels').checkVisibility()") is False
    assert browser.run("document.getElementById('printed').checkVisibility()") is True
    browser.run("window.dispatchEvent(new Event('afterprint'))")
    assert browser.messages == []
