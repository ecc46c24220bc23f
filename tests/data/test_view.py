"""The pages of `gsp view`: what they are made of."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ROOT / "viewer"
VIEW = ROOT / "data" / "view"
NAMES = ("page.html", "live.html")
STYLES = {"page.html": ("style.css",), "live.html": ("style.css", "live.css")}


@pytest.mark.parametrize("name", NAMES)
def test_the_page_is_of_the_present_sources(name: str) -> None:
    text = (VIEW / name).read_text(encoding="utf-8")
    for style in STYLES[name]:
        assert (SOURCES / "src" / style).read_text(encoding="utf-8").strip() in text
    before, _, rest = (SOURCES / "src" / name).read_text("utf-8").partition("@@style@@")
    between = re.split("@@(?:worker|script)@@", rest)[0]
    assert text.startswith(before)
    assert between in text


@pytest.mark.parametrize("name", NAMES)
def test_the_licence_of_three_is_in_every_copy(name: str) -> None:
    licence = (VIEW / "LICENSE.three.txt").read_text(encoding="utf-8").strip()
    assert licence.startswith("The MIT License")
    assert licence in (VIEW / name).read_text(encoding="utf-8")


@pytest.mark.parametrize("name", NAMES)
def test_the_page_may_not_ask_for_anything(name: str) -> None:
    text = (VIEW / name).read_text(encoding="utf-8")
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', text)
    assert policy
    assert "default-src 'none'" in policy[1]
    assert "http" not in policy[1]
    assert "'unsafe-eval'" not in policy[1]
