"""Rebuild docs/commands.md from the help texts: `python tools/build_cli_reference.py`."""

from __future__ import annotations

from pathlib import Path

import click

from gspcli.cli.main import COMMANDS, cli

PATH = Path(__file__).resolve().parents[1] / "docs" / "commands.md"
WIDTH = 95


def reference() -> str:
    """Return the page."""
    text = "# Commands\n\nGenerated from `gsp --help`; do not edit.\n"
    with click.Context(cli, info_name="gsp", max_content_width=WIDTH, terminal_width=WIDTH) as top:
        text += _section("gsp", cli.get_help(top))
        for name in COMMANDS:
            command = cli.get_command(top, name)
            assert command is not None, name
            text += _help(command, name, top)
    return text


def _help(command: click.Command, name: str, parent: click.Context) -> str:
    with click.Context(
        command, info_name=name, parent=parent, max_content_width=WIDTH, terminal_width=WIDTH
    ) as context:
        text = _section(context.command_path, command.get_help(context))
        if isinstance(command, click.Group):
            for child in command.list_commands(context):
                found = command.get_command(context, child)
                assert found is not None, child
                text += _help(found, child, context)
    return text


def _section(title: str, help_text: str) -> str:
    lines = [line.rstrip() for line in help_text.splitlines()]
    return f"\n## {title}\n\n```text\n" + "\n".join(lines) + "\n```\n"


if __name__ == "__main__":
    PATH.write_text(reference(), encoding="utf-8")
