"""The page of `gsp view`: what it is made of."""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ROOT / "tools" / "view"
PAGE = ROOT / "data" / "view" / "page.html"


def test_the_manifest_is_that_of_the_page() -> None:
    manifest = json.loads((PAGE.parent / "manifest.json").read_text(encoding="utf-8"))
    content = PAGE.read_bytes()
    assert manifest["page"]["bytes"] == len(content)
    assert manifest["page"]["sha256"] == hashlib.sha256(content).hexdigest()


def test_the_page_is_of_the_present_sources() -> None:
    text = PAGE.read_text(encoding="utf-8")
    style = (SOURCES / "src" / "style.css").read_text(encoding="utf-8").strip()
    assert style in text
    before, _, rest = (SOURCES / "src" / "page.html").read_text("utf-8").partition("@@style@@")
    between = rest.partition("@@script@@")[0]
    assert text.startswith(before)
    assert between in text


def test_versions_are_locked_without_naming_a_registry() -> None:
    lock = (SOURCES / "package-lock.json").read_text(encoding="utf-8")
    assert "http" not in lock
    packages = json.loads(lock)["packages"]
    assert all("integrity" in package for name, package in packages.items() if name)


def test_the_licence_of_three_is_in_every_copy() -> None:
    licence = (PAGE.parent / "LICENSE.three.txt").read_text(encoding="utf-8").strip()
    assert licence.startswith("The MIT License")
    assert licence in PAGE.read_text(encoding="utf-8")


def test_the_page_may_not_ask_for_anything() -> None:
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', PAGE.read_text("utf-8"))
    assert policy
    assert "default-src 'none'" in policy[1]
    assert "http" not in policy[1]
