"""LaTeX of every command is compiled by `make verify`, here that of a few."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable

import pytest


def _has_latex() -> bool:
    """Whether there is LaTeX, with the package that the tables need."""
    if shutil.which("pdflatex") is None or shutil.which("kpsewhich") is None:
        return False
    return subprocess.run(["kpsewhich", "booktabs.sty"], capture_output=True).returncode == 0


@pytest.mark.skipif(not _has_latex(), reason="needs pdflatex with booktabs")
@pytest.mark.parametrize("call", ["table 1", "show 421", "solve @no-real-pose --legend"])
def test_it_compiles(load_tool: Callable, call: str) -> None:
    tool = load_tool("verify.latex")
    assert tool.complaint(tool.written(call.split())) is None
    assert tool.complaint(r"\undefined") is not None
