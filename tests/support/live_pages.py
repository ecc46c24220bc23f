"""What tests do on live pages."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tests.support.browser import Browser


def opened(browser: Browser, path: Path, fragment: str = "") -> None:
    browser.call("Page.navigate", url="about:blank")
    browser.open(path, fragment)
    browser.wait("document.documentElement.dataset.ready === 'true'")


def text(browser: Browser, element: str) -> str:
    return str(browser.run(f"document.getElementById('{element}').textContent"))


def give(browser: Browser, element: str, value: float) -> None:
    """Type a number."""
    browser.run(
        f"(() => {{ const one = document.getElementById('{element}'); one.value = {value};"
        " one.dispatchEvent(new Event('change')); })()"
    )
    settle(browser)


def settle(browser: Browser) -> None:
    """Wait for all poses after a move, also where they are solved when the slider rests."""
    browser.settle()
    browser.wait("document.getElementById('busy').hidden")
