"""LaTeX of every command is compiled by `make verify`; here that none is forgotten, and a few."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable

import click
import pytest

from gspcli.cli.main import COMMANDS, cli


def _writes_latex(name: str) -> bool:
    command = cli.get_command(click.Context(cli), name)
    assert command is not None
    return any(
        isinstance(parameter.type, click.Choice) and "latex" in parameter.type.choices
        for parameter in command.params
    )


def test_no_command_is_forgotten(load_tool: Callable) -> None:
    compiled = {call.split()[0] for call in load_tool("verify.latex").CALLS}
    assert {name for name in COMMANDS if _writes_latex(name)} <= compiled


def _has_latex() -> bool:
    """Whether there is LaTeX, with the package that the tables need."""
    if shutil.which("pdflatex") is None or shutil.which("kpsewhich") is None:
        return False
    return subprocess.run(["kpsewhich", "booktabs.sty"], capture_output=True).returncode == 0


@pytest.mark.skipif(not _has_latex(), reason="needs pdflatex with booktabs")
@pytest.mark.parametrize("call", ["table 1", "show 421", "solve @no-real-pose --legend"])
def test_it_compiles(load_tool: Callable, call: str) -> None:
    tool = load_tool("verify.latex")
    assert tool.complaint(tool.written(call)) is None
    assert tool.complaint(r"\undefined") is not None
