"""What the page on dynamics shows is what comes out."""

from __future__ import annotations

import contextlib
import io
import re
import shlex
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
PAGE = (ROOT / "docs" / "dynamics.md").read_text(encoding="utf-8")


def _blocks(kind: str) -> list[str]:
    return re.findall(rf"```{kind}\n(.*?)```", PAGE, re.DOTALL)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with the files of the page."""
    for name, content in zip(
        ("hexapod.yaml", "path.csv", "forces.csv"), _blocks("yaml") + _blocks("csv"), strict=True
    ):
        (tmp_path / name).write_text(content, encoding="utf-8")
    monkeypatch.chdir(tmp_path)


def _same(found: str, shown: str) -> bool:
    """Return whether two outputs agree but for blanks at the ends of lines."""
    return [line.rstrip() for line in found.splitlines()] == shown.splitlines()


def test_the_commands(folder, gsp):
    calls = 0
    for block in _blocks("console"):
        for call in re.split(r"^\$ gsp ", block, flags=re.MULTILINE)[1:]:
            line, _, shown = call.partition("\n")
            run = gsp(*shlex.split(line))
            assert _same(run.out + run.err, shown), line
            calls += 1
    assert calls >= 6


def test_the_python(folder):
    pytest.importorskip("scipy")
    (code,), (shown,) = _blocks("python"), _blocks("text")
    text = io.StringIO()
    with contextlib.redirect_stdout(text):
        exec(code, {})
    assert text.getvalue() == shown
