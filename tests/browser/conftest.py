"""A real browser for tests of pages (`tools.browser`)."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest

from tools.browser import CHROMIUM, Browser


@pytest.fixture(scope="session")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """The browser; without one on the machine its tests are left out, but not in CI."""
    if CHROMIUM is None:
        if os.environ.get("CI_NEEDS_CHROMIUM"):
            pytest.fail("no chromium on this machine, and CI_NEEDS_CHROMIUM is set")
        pytest.skip("no chromium on this machine (Debian: apt-get install chromium)")
    browser = Browser(tmp_path_factory.mktemp("chromium"))
    yield browser
    browser.close()


@pytest.fixture
def browser(chromium: Browser) -> Browser:
    """The browser with a wide window and light pages."""
    chromium.size(1000, 600)
    chromium.prefer("light")
    return chromium
