"""`gsp show`: one page on one type."""

from __future__ import annotations

import json
from collections.abc import Callable

import pytest

Run = Callable[..., object]


def test_the_page_of_the_stewart_platform(gsp: Run) -> None:
    shown = gsp("show", "6PP").out
    for part in (
        "no. 3389, 6D",
        "|RY + T − X|² = d²",
        "Theorem 5.3",
        "platform ─S─P*─S─ base",
        "12 - 6 idle = 6",
        "path tracking",
        "the same type",
        "gsp new 3389",
    ):
        assert part in shown, part


def test_the_document_extends_that_of_bound(gsp: Run) -> None:
    shown = json.loads(gsp("show", "PL PL LP ALL ALH AHH", "--format", "json").out)
    bound = json.loads(gsp("bound", "PL PL LP ALL ALH AHH", "--format", "json").out)
    assert {**shown, **bound} == {**shown, "schema": bound["schema"]}
    assert shown["mirrored"] == 529
    assert shown["method"].startswith("closed form")


@pytest.mark.parametrize("words", [["3D3A", "PL", "PL", "LP"], ["PP"], ["0"]])
def test_what_is_no_type_is_refused(gsp: Run, words: list[str]) -> None:
    outcome = gsp("show", *words)
    assert (outcome.code, outcome.out) == (2, "")
