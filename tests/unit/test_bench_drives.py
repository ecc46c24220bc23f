"""Comparing the outputs and times of two versions of `gsp`."""

from __future__ import annotations

from pathlib import Path

import pytest

from bench import drives
from bench.processes import Finished


def compared(monkeypatch: pytest.MonkeyPatch, now: tuple[float, str], before: tuple[float, str]):
    """Return the exit code where both versions take this long and print this."""

    def run(command: list[str | Path], **_: object) -> Finished:
        seconds, said = before if "other" in str(command[0]) else now
        return Finished(seconds, seconds, said, "", "")

    monkeypatch.setattr(drives, "run", run)
    line = ["drives", "nano-hexapod", "--against", "other", "--commands", "measure,track"]
    monkeypatch.setattr("sys.argv", line)
    return drives.main()


def test_what_is_the_same_and_no_slower_passes(monkeypatch, capsys) -> None:
    assert compared(monkeypatch, (1.04, "a\nb"), (1.0, "a\nb")) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "0 outputs differ; slower: none"


def test_another_output_is_shown_where_it_differs(monkeypatch, capsys) -> None:
    assert compared(monkeypatch, (1.0, "a\nb"), (1.0, "a\nc")) == 1
    said = capsys.readouterr().out
    assert "nano-hexapod, measure: now\n    b\nbefore\n    c" in said
    assert said.splitlines()[-1] == "2 outputs differ; slower: none"


def test_a_command_that_takes_longer_is_named(monkeypatch, capsys) -> None:
    assert compared(monkeypatch, (1.06, "a"), (1.0, "a")) == 1
    assert capsys.readouterr().out.splitlines()[-1] == "0 outputs differ; slower: measure, track"


def test_unknown_names_are_refused(monkeypatch, capsys) -> None:
    monkeypatch.setattr("sys.argv", ["drives", "no-such-platform"])
    with pytest.raises(SystemExit):
        drives.main()
    assert "found no-such-platform, expected" in capsys.readouterr().err
