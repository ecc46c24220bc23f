"""Every command of the tour runs as it stands there, in an empty folder, one after the other."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable
from pathlib import Path

import pytest

TOUR = Path(__file__).resolve().parents[2] / "docs" / "tour.md"
COMMANDS = re.findall(r"^    \$ gsp (.*?)(?: +#.*)?$", TOUR.read_text(encoding="utf-8"), re.M)


def test_the_tour(gsp: Callable, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert len(COMMANDS) > 10
    monkeypatch.chdir(tmp_path)
    for command in COMMANDS:
        if "--check" in command:
            continue  # a test of its own, and a long one
        words = shlex.split(command)
        if words[0] == "certify" and Path(words[-1]).suffix in (".out", ".phc"):
            continue  # what another program has answered
        outcome = gsp(*words)
        assert outcome.code == 0, (command, outcome.err)
