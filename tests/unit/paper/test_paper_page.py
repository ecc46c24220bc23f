"""The page *From the paper to a command* leaves nothing out; its commands run with all others."""

from __future__ import annotations

import re
from pathlib import Path

PAGE = Path(__file__).resolve().parents[3] / "docs" / "paper.md"
#: What the paper numbers.
NUMBERED = {
    "Equation": range(1, 19),
    "Figure": range(1, 17),
    "Table": range(1, 4),
    "Proposition": ("2.2", "4.1", "6.1", "6.4", "6.5", "6.7"),
    "Theorem": ("5.1", "5.2", "5.3", "5.4", "6.9"),
    "Example": ("6.2", "6.8"),
    "Definition": ("2.1", "6.3"),
    "Algorithm": ("6.6",),
}


def _named(page: str) -> dict[str, set[str]]:
    """Return what the first column of the tables names, by kind."""
    found: dict[str, set[str]] = {kind: set() for kind in NUMBERED}
    for cell in re.findall(r"^\| ([^|]+) \|.*`gsp ", page, re.MULTILINE):
        for kind in found:
            for match in re.finditer(rf"{kind}s? ((?:\(?[\d.]+\)?(?:, )?)+)", cell, re.IGNORECASE):
                found[kind] |= set(re.findall(r"[\d.]*\d", match[1]))
    return found


def test_everything_that_the_paper_numbers_has_a_command() -> None:
    named = _named(PAGE.read_text(encoding="utf-8"))
    for kind, numbers in NUMBERED.items():
        assert {str(number) for number in numbers} <= named[kind], kind


def test_a_row_that_is_missing_is_seen() -> None:
    page = PAGE.read_text(encoding="utf-8").replace("| Figure 8,", "| Figure 88,")
    assert "8" not in _named(page)["Figure"]
