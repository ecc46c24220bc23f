"""Helps on a narrow terminal: examples first, then options in groups, then the text."""

from __future__ import annotations

import re

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
