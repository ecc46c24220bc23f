"""The page of all options: what each means, and which commands have it."""

from __future__ import annotations

import re
from collections import defaultdict

import click

from tools.build.samples import commands

_INTRODUCTION = """\
# Options

Generated from the helps of the commands; do not edit.

An option is spelled the same and means the same in every command that has it; what a command does
with it is in [its help](commands.md). A test compares them.

- A **POSE** is `x,y,z,qw,qx,qy,qz` (a quaternion of any length, scalar first), or
  `x,y,z,rx,ry,rz` with `--euler AXES`, which names the order of the axes. It may also be `@FILE`, a
  file with one pose as `gsp measure` reads it (`@-` is standard input). x, y, z are the position of
  the `--pivot`, by default the origin of the platform's frame. `--euler` says how given poses are
  read, `--rotation` how poses are printed.
- **I=V** is a constraint from 1 to 6 and a number: `--set 1=5.2` gives the value, `--delta 1=0.1`
  adds to it; both are exact, and may be expressions such as `sqrt(3)/2`.
- **FILE** of `-o` is replaced, whole or not at all; that of `--resume` is kept up to date while a
  command works, so that it can be stopped and continued.
"""


def page() -> str:
    """Return the page."""
    uses: dict[str, list[tuple[str, click.Option]]] = defaultdict(list)
    for name, command in commands():
        for parameter in command.params:
            if isinstance(parameter, click.Option):
                uses[_spelled(parameter)].append((name, parameter))
    everyone = sum(1 for _ in commands())
    shared = {spelled: those for spelled, those in uses.items() if len(those) > 1}
    alone = {spelled: those for spelled, those in uses.items() if len(those) == 1}
    parts = [_INTRODUCTION, "\n## In several commands\n\n", _table(shared, everyone)]
    parts += ["\n## In one command\n\n", _table(alone, everyone)]
    return "".join(parts)


def _table(uses: dict[str, list[tuple[str, click.Option]]], everyone: int) -> str:
    lines = ["| option | what it means | commands |", "| --- | --- | --- |"]
    for spelled in sorted(uses, key=lambda text: text.lstrip("`-").lower()):
        names = [name for name, _ in uses[spelled]]
        where = ", ".join(names)
        if len(names) > everyone / 2:
            missing = [name for name, _ in commands() if name not in names]
            where = "all" + (f" but {', '.join(missing)}" if missing else "")
        helps = [str(option.help) for _, option in uses[spelled]]
        meaning = helps[0] if len(set(helps)) == 1 else f"{_first_clause(helps[0])}"
        meaning = re.sub(r"\s+", " ", meaning).replace("|", "\\|").rstrip(".")
        lines.append(f"| {spelled} | {meaning} | {where} |")
    return "\n".join(lines) + "\n"


def _spelled(option: click.Option) -> str:
    """Return the spelling of an option: ``--jobs N``."""
    spelling = " / ".join(f"`{name}`" for name in (*option.opts, *option.secondary_opts))
    if option.is_flag:
        return spelling
    metavar = option.metavar or "TEXT"
    if isinstance(option.type, click.Choice) and option.metavar is None:
        metavar = "…"
    return f"{spelling[:-1]} {metavar}`".replace("|", "\\|")


def _first_clause(text: str) -> str:
    """Return what the helps of an option have in common."""
    return re.split(r"[.:;](?:\s|$)", text)[0]
