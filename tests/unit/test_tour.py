"""The tour and the page of the mount show shipped files and real output."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from gspcli.cli.main import run

TOUR = Path(__file__).resolve().parents[2] / "docs" / "tour.md"


def test_the_example_is_the_one_that_is_solved() -> None:
    from gspcli.resources import instance_files
    from gspcli.spec import load, loads

    text = re.search(r"```yaml\n(.*?)```", TOUR.read_text(encoding="utf-8"), re.DOTALL)
    assert text is not None
    shipped = load(instance_files()["example-6.8"])
    for ours, theirs in zip(loads(text[1]).constraints, shipped.constraints, strict=True):
        assert (ours.kind, ours.platform, ours.base, ours.value) == (
            theirs.kind,
            theirs.platform,
            theirs.base,
            theirs.value,
        )


MOUNT = TOUR.with_name("mount.md")


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
