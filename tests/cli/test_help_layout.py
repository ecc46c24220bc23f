"""Helps on a narrow terminal: examples first, then options in groups, then the text."""

from __future__ import annotations

import re
import subprocess
import sys

import click
import pytest

from gspcli.cli.commands import COMMANDS
from gspcli.cli.main import cli


def _helps() -> list[tuple[str, click.Command]]:
    found = []
    for name in COMMANDS:
        command = cli.get_command(click.Context(cli), name)
        assert command is not None
        leaves = command.commands if isinstance(command, click.Group) else {"": command}
        found += [(f"gsp {name} {leaf}".strip(), one) for leaf, one in leaves.items()]
    return found


@pytest.mark.parametrize(
    ("name", "command"), _helps(), ids=lambda value: value if isinstance(value, str) else ""
)
def test_a_help_fits_sixty_columns_and_its_options_come_soon(
    name: str, command: click.Command
) -> None:
    context = click.Context(command, info_name=name, terminal_width=60)
    lines = command.get_help(context).splitlines()
    assert max(map(len, lines)) <= 60
    first = next(k for k, line in enumerate(lines) if re.match(r"  -", line))
    assert first <= 25, "\n".join(lines[: first + 1])
    assert "Examples:" in lines[:first]


@pytest.mark.parametrize(
    ("words", "most"), [(["enumerate"], 3950), (["solve", "@rubin-m2"], 24_000)]
)
def test_a_command_imports_only_what_it_needs(words: list[str], most: int) -> None:
    code = (
        "import sys; from pathlib import Path; from gspcli.cli.main import run; run(sys.argv[1:]);"
        "files = [m.__file__ for n, m in sys.modules.items() if n.startswith('gspcli')];"
        "texts = [Path(f).read_text() for f in files if f[-3:] == '.py'];"
        "print('lines', sum(len(text.splitlines()) for text in texts))"
    )
    done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True)
    assert int(done.stdout.split()[-1]) <= most


def test_the_help_loads_no_numpy() -> None:
    code = "import sys; from gspcli.cli.main import run; run(['--help']); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert "numpy" not in done.stdout.splitlines()[-1].split()
