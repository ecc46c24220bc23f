"""A sample of the attacks on the command line, and that they see what they look for."""

from __future__ import annotations

import pytest


@pytest.fixture(scope="module")
def attacks(load_tool):
    module = load_tool("fuzz.commands")
    module.prepare()
    return module


@pytest.mark.parametrize("kind", ["options", "inputs", "streams"])
def test_nothing_is_undocumented(attacks, kind):
    for seed in range(12):
        code, problems = attacks.attack(kind, seed)
        assert code in attacks.DOCUMENTED
        assert problems == []


def test_a_process(attacks):
    assert attacks.attack("processes", 3)[1] == []


@pytest.mark.parametrize(
    ("told", "found"),
    [
        ((0, ""), ""),
        ((2, "error: no\n"), ""),
        ((130, ""), ""),
        ((70, "error: internal error: ValueError\n"), "exit code 70"),
        ((2, ""), "exit code 2 without an error"),
        ((2, "error: a\n" + "b\n" * 5), "an error of 6 lines"),
        ((2, "error: " + "b" * 1000 + "\n"), "a line of 1007 characters"),
        ((0, "x.py:3: RuntimeWarning: overflow\n"), "'Warning:' is said"),
        ((1, "Traceback (most recent call last):\n"), "'Traceback' is said"),
        ((-11, ""), "exit code -11"),
    ],
)
def test_what_does_not_hold_is_seen(attacks, tmp_path, told, found):
    hostile = attacks.Hostile(["solve", "x"])
    problems = attacks.wrong(hostile, attacks.Told(*told), tmp_path)
    assert problems[:1] == ([f"{found}: gsp 'solve' 'x'"] if found else [])
    (tmp_path / ".a.csv.x1").touch()
    assert ".a.csv.x1 is left: gsp 'solve' 'x'" in attacks.wrong(
        hostile, attacks.Told(*told), tmp_path
    )
