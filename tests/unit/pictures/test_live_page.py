"""The page that solves: what is in it."""

from __future__ import annotations

import json
import re
from functools import cache

import pytest

from gspcli.pictures.live_numbers import live_module, live_numbers, live_page
from gspcli.pictures.stage import scene_of
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec import load

#: What the page may weigh.
LIMIT = 2_000_000
ELEMENT = '<script type="{}" id="{}">(.*?)</script>'


@cache
def content(name: str) -> str:
    result = solve(load(instance_files()[name]))
    return live_page(scene_of(result), live_numbers(result), 1)


def element(text: str, name: str, kind: str = "application/json") -> str:
    found = re.search(ELEMENT.format(kind, name), text, re.DOTALL)
    assert found is not None
    return found[1]


@pytest.mark.parametrize("name", ["octahedral-3-3", "dietmaier", "example-6.8"])
def test_the_page_is_one_small_file(name: str) -> None:
    text = content(name)
    assert len(text.encode()) < LIMIT
    assert "@@" not in text
    assert re.findall("(?:src|href)=[\"']", text) == []
    assert "http:" not in written(text)
    assert "https:" not in written(text)
    assert not re.search(r"\bfetch\(|XMLHttpRequest|importScripts|WebSocket", written(text))


def test_what_the_count_rests_on_is_said() -> None:
    said = "no pose is missing is proved by the geometry count up to a random prime: error below"
    assert said in content("octahedral-3-3")
    assert "random prime" not in content("dietmaier").partition("<footer")[2]


def written(text: str) -> str:
    """Return the page without three.js, which could load textures if it were asked to."""
    start = text.index('<script type="module">')
    return text[:start]


def test_what_the_page_solves_from_is_in_it() -> None:
    text = content("octahedral-3-3")
    live = json.loads(element(text, "live"))
    assert live["values"] == [1.5, 1.8, 1.6, 1.9, 1.5, 1.7]
    assert element(text, "module", "text/plain") == live_module()
    scene = json.loads(element(text, "scene"))
    assert scene["start"] == 1
    assert len(scene["series"][0]["T"]) == 4


def test_numbers_are_there_without_a_script() -> None:
    text = content("octahedral-3-3")
    modes = text[text.index('<table id="modes">') :].partition("</table>")[0]
    assert modes.count("<tr>") == 5
    assert '<table id="constraints">' in text
