"""The page on dynamics shows the output of its lines of Python."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
PAGE = (ROOT / "docs" / "dynamics.md").read_text(encoding="utf-8")


def _blocks(kind: str) -> list[str]:
    return re.findall(rf"```{kind}\n(.*?)```", PAGE, re.DOTALL)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with the files of the page."""
    names = ("hexapod.yaml", "rotary.yaml", "path.csv")
    for name, content in zip(names, _blocks("yaml") + _blocks("csv"), strict=True):
        (tmp_path / name).write_text(content, encoding="utf-8")
    monkeypatch.chdir(tmp_path)


def test_the_python(folder):
    pytest.importorskip("scipy")
    (code,), (shown,) = _blocks("python"), _blocks("text")
    text = io.StringIO()
    with contextlib.redirect_stdout(text):
        exec(code, {})
    assert text.getvalue() == shown
