"""The tutorial of a machine with legs: every command, and the answers on the page."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from gspcli.cli.main import run

MOUNT = Path(__file__).resolve().parents[2] / "docs" / "tutorial-machine.md"


def test_the_mount_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """From drawing to trajectory: every command, and the answers on the page."""
    monkeypatch.chdir(tmp_path)
    page = MOUNT.read_text(encoding="utf-8")
    table = re.search(r"```text\n(t,x.*?)```", page, re.DOTALL)
    assert table is not None
    Path("path.csv").write_text(table[1], encoding="utf-8")
    said = ""
    for line in re.findall(r"^ {4}\$ gsp (.*)$", page, re.MULTILINE):
        words = shlex.split(line, comments=True)
        assert run(words) == 0, (words, capsys.readouterr().err)
        printed = capsys.readouterr()
        said += printed.out + printed.err
    assert "2 real poses, all proved different; complete, proved" in said
    assert "of constraint 4 leaves its range from 0.4789 to 0.5071 at t = 3.854" in said
