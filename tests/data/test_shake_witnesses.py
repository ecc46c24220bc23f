"""The program that shakes witnesses, on a random platform instead of the one on record."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from gspcli.catalogue.witnesses import named_family
from gspcli.reality.platforms import Platforms, random_platforms, reduced
from gspcli.reality.solved_platforms import solved

FAMILY = named_family("PP PP PP PP PP PP")
KINDS = FAMILY.types[0].kinds


@pytest.fixture
def shake(load_tool, monkeypatch, tmp_path):
    """Run the program for the family with a random platform in the journal; return the journal."""
    program, known = load_tool("witnesses.__main__"), load_tool("witnesses.known")
    monkeypatch.setattr(known, "recorded", dict)
    journal = tmp_path / "journal"
    first = solved(reduced(random_platforms(KINDS, 1, np.random.default_rng(1)))[0])
    assert first is not None
    known.add_entry(journal, known.result(FAMILY, first))

    def run(*options: str) -> list[dict]:
        command = ["witnesses", "shake", str(journal), "PP PP PP PP PP PP", *options]
        monkeypatch.setattr(sys, "argv", command)
        assert program.main() == 0
        return known.read_journal(journal)

    return run


def test_each_entry_has_more_real_solutions_than_the_last(shake) -> None:
    entries = shake("--tries", "60")
    counts = [entry["real"] for entry in entries]
    assert len(counts) > 2
    assert counts == sorted(set(counts))
    platform = Platforms(KINDS, *(np.array(part, float) for part in entries[-1]["numbers"]))
    again = solved(platform)
    assert again is not None
    assert again.count == counts[-1]


def test_without_tries_nothing_is_found(shake) -> None:
    assert len(shake("--tries", "0")) == 1


def test_points_far_away_move_further(load_tool) -> None:
    program = load_tool("witnesses.shake")
    platform = random_platforms(KINDS, 1, np.random.default_rng(1))[0]
    far = platform.x.copy()
    far[0] = 1e6
    changes = [
        program.change(one, np.random.default_rng(0)).reshape(6, 13)
        for one in (
            platform,
            Platforms(KINDS, platform.y, far, platform.u, platform.v, platform.values),
        )
    ]
    assert np.allclose(changes[1][0, 3:6], 1e4 * changes[0][0, 3:6])
    assert np.array_equal(changes[1][1:], changes[0][1:])
    assert (changes[0][:, 6:12] == 0).all()
