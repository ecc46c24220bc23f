"""A real browser for tests of pages (`tests.support.browser`)."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from gspcli.pictures.live_numbers import live_numbers, live_page
from gspcli.pictures.stage import first_mode, scene_of
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec import load
from tests.support.browser import CHROMIUM, Browser


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


@pytest.fixture(scope="session")
def live(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """What writes the live page of a shipped platform and returns the file."""
    folder = tmp_path_factory.mktemp("live")

    def write(name: str = "workspace-study") -> Path:
        path = folder / f"{name}.html"
        if not path.exists():
            result = solve(load(instance_files()[name]))
            text = live_page(scene_of(result), live_numbers(result), first_mode(result))
            path.write_text(text, encoding="utf-8")
        return path

    return write
