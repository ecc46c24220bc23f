"""The program that lifts witnesses from simpler families, on a few small ones."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gspcli.catalogue.witnesses import named_family
from gspcli.reality.platforms import Platforms
from gspcli.reality.solved_platforms import solved

#: Each has 8 solutions and is simpler than the next.
CHAIN = tuple(named_family(" ".join(["PH"] * n)) for n in (3, 4, 5))


@pytest.fixture
def lift(load_tool, monkeypatch, tmp_path) -> Callable[..., list[dict]]:
    """Run the program for the chain, only the first of which is on record; return the journal."""
    program, known = load_tool("witnesses.__main__"), load_tool("witnesses.known")
    record = {CHAIN[0].id: known.recorded()[CHAIN[0].id]}
    monkeypatch.setattr(known, "recorded", lambda: record)
    monkeypatch.setattr(load_tool("witnesses.lift"), "canonical_families", lambda: CHAIN[::-1])
    journal: Path = tmp_path / "journal"

    def run(*options: str) -> list[dict]:
        monkeypatch.setattr(sys, "argv", ["witnesses", "lift", str(journal), *options])
        assert program.main() == 0
        return known.read_journal(journal)

    return run


def test_all_solutions_are_real_all_along_a_chain(lift) -> None:
    entries = lift()
    assert [(entry["family"], entry["real"]) for entry in entries] == [
        (family.id, 8) for family in CHAIN[1:]
    ]
    for family, entry in zip(CHAIN[1:], entries, strict=True):
        kinds = family.types[0].kinds
        platform = Platforms(kinds, *(np.array(part, float) for part in entry["numbers"]))
        again = solved(platform)
        assert again is not None
        assert again.count == len(again.points) == 8


def test_what_is_known_is_not_lifted_again(lift) -> None:
    assert lift() == lift()


@pytest.mark.parametrize("options", [("--most", "7"), ("--below", "0")])
def test_families_can_be_left_out(lift, options) -> None:
    assert lift(*options) == []
