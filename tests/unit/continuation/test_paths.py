"""The account of all paths."""

from __future__ import annotations

import pytest

from gspcli.continuation.paths import Basis, PathAccount

NOTHING = PathAccount(expected=0)


@pytest.mark.parametrize(
    "parts",
    [
        {"found": 39},
        {"found": 41},
        {"found": 41, "lost": -1},
        {"found": 40, "at_infinity": 1},
        {},
    ],
)
def test_an_account_adds_up(parts):
    with pytest.raises(ValueError, match="must add up"):
        PathAccount(expected=40, **parts)


@pytest.mark.parametrize(
    ("parts", "verdict"),
    [
        ({"found": 40}, "complete"),
        ({"found": 1, "at_infinity": 20, "spurious": 19}, "complete"),
        ({"found": 39, "lost": 1}, "incomplete"),
        ({"found": 30, "on_curves": 10}, "infinite"),
        ({"found": 30, "on_curves": 9, "lost": 1}, "infinite"),
    ],
)
def test_verdict(parts, verdict):
    assert PathAccount(expected=40, **parts).verdict == verdict


def test_accounts_add():
    first = PathAccount(expected=40, found=28, at_infinity=12)
    second = PathAccount(expected=40, found=20, on_curves=10, spurious=9, lost=1)
    assert sum([first, second], NOTHING) == PathAccount(
        expected=80, found=48, at_infinity=12, on_curves=10, spurious=9, lost=1
    )
    assert second * 3 == second + second + second
    assert second * 0 == NOTHING


def test_a_sum_rests_on_counts_if_a_part_does():
    followed = PathAccount(expected=1, found=1)
    counted = PathAccount(expected=1, at_infinity=1, basis=Basis.COUNT)
    assert (followed + followed).basis is Basis.PATHS
    assert (followed + counted).basis is (counted + followed).basis is Basis.COUNT
    assert (counted * 2).basis is Basis.COUNT
