"""Links, the way home and the text about both on live pages."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from tests.support.live_pages import give, opened, text

if TYPE_CHECKING:
    from tests.support.browser import Browser

#: The machine of the page: mode 16 is home, and of 16 real modes four vanish where value 1 is 402.
HOME = 16


def followed(browser: Browser) -> str:
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
    assert followed(browser) == "15"


def test_a_mode_that_is_not_there_is_home(browser: Browser, live: Callable[..., Path]) -> None:
    opened(browser, live(), "#mode=999")
    assert followed(browser) == str(HOME)
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
    # The followed mode moves at once; the others come when it rests.
    assert browser.run("seen") == [[False, 1], [True, 12]]
    assert "12 real" in text(browser, "status")
    assert text(browser, "event") == "modes 7 and 10, 8 and 13 have met and vanished"
    assert followed(browser) == str(HOME)
    # Rows that came did not push the followed one out of the list; the frame of the list, of one
    # pixel, and a part of a pixel may cover its lower edge.
    below = browser.run(
        "document.querySelector('#modes [aria-current]').getBoundingClientRect().bottom"
        " - document.querySelector('#mode-list .scroll').getBoundingClientRect().bottom"
    )
    assert below < 2
    assert browser.messages == []
