"""The pages that programs write: made in docs/ when the site is built, and not committed."""

from __future__ import annotations

import contextlib
import io
import json
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
import platform_page

from gspcli.cli.commands import COMMANDS
from gspcli.cli.help import type_in_json
from gspcli.cli.main import cli, run
from gspcli.cli.result import Field, Fields

DOCS = Path(__file__).resolve().parents[1]
WIDTH = 95
DIALECT = "https://json-schema.org/draft/2020-12/schema"

#: What holds for all commands.
STREAMS = """\
What a command finds goes to standard output or, with `-o`, to a file, which appears whole or not at
all and replaces another. All else is said on standard error: an error in at most five lines, where
what was written is repeated up to 60 characters. Characters that the encoding of a stream lacks are
written in ASCII (`...` for an ellipsis, `>=`, `rho`), texts in JSON as escapes. A full disk or a
closed standard output is exit code 2; a reader that stops early, as `head` does, is no failure.
Exit code 70 is a mistake in gsp itself: please report it with the output of `gsp --debug …`.
"""

OPTIONS = """\
# Options

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

OUTPUT = """\
# What commands print for programs

`--format json` prints one object, `--format csv` one table, both with full precision. Standard
output holds nothing else. `gsp COMMAND --keys` prints what the keys and columns of a command mean:

    gsp check --keys

- The first key of an object, `schema`, names its form and version.
- `gsp bound` and `gsp count` print a list of objects if they are given several types or platforms.
- In CSV an empty cell, in JSON `null`, stands for what is not known or does not apply.
- In these tables `[]` marks the entries of a list, `*` names or numbers of the instance, `1…6` the
  numbers of the constraints.
- `gsp maximize-real` writes an instance file.
"""


def leaves(group: click.Group = cli, above: str = "") -> Iterator[tuple[str, click.Command]]:
    """Yield all commands by their names, such as ``atlas summary``, in the order of the help."""
    with click.Context(group) as context:
        for name in group.list_commands(context):
            command = group.get_command(context, name)
            if isinstance(command, click.Group):
                yield from leaves(command, f"{above}{name} ")
            elif command is not None:
                yield above + name, command


def commands() -> str:
    """Return the reference of all commands, from their help."""
    text = "# Commands\n\n" + STREAMS
    settings = {**cli.context_settings, "max_content_width": WIDTH, "terminal_width": WIDTH}
    with click.Context(cli, info_name="gsp", **settings) as top:
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


def options() -> str:
    """Return the page of all options: what each means, and which commands have it."""
    uses: dict[str, list[tuple[str, click.Option]]] = defaultdict(list)
    for name, command in leaves():
        for parameter in command.params:
            if isinstance(parameter, click.Option):
                uses[_spelled(parameter)].append((name, parameter))
    everyone = sum(1 for _ in leaves())
    shared = {spelled: those for spelled, those in uses.items() if len(those) > 1}
    alone = {spelled: those for spelled, those in uses.items() if len(those) == 1}
    parts = [OPTIONS, "\n## In several commands\n\n", _table(shared, everyone)]
    parts += ["\n## In one command\n\n", _table(alone, everyone)]
    return "".join(parts)


def _table(uses: dict[str, list[tuple[str, click.Option]]], everyone: int) -> str:
    lines = ["| option | what it means | commands |", "| --- | --- | --- |"]
    for spelled in sorted(uses, key=lambda text: text.lstrip("`-").lower()):
        names = [name for name, _ in uses[spelled]]
        where = ", ".join(names)
        if len(names) > everyone / 2:
            missing = [name for name, _ in leaves() if name not in names]
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


def errata() -> str:
    """Return the errata with the evidence of their proofs."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        code = run(["table", "errata", "--check", "--format", "markdown"])
    assert code == 0, "an erratum is not proved"
    return (
        "# Errata of the paper\n\n"
        "`gsp table errata --check` runs the proofs.\n\n" + printed.getvalue().partition("\n\n")[2]
    )


def geometries() -> str:
    """Return the counts of hexapods with special geometries."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        code = run(["count", "--type", "6PP", "--geometry", "all", "--format", "markdown"])
    assert code == 0
    return (
        "# Counts of special hexapods\n\n"
        "`gsp count --type 6PP --geometry all` computes them.\n\n"
        "The table has the number of complex poses of six legs between points, for special "
        "geometries with random lengths of the legs. All that *what is special* does not fix is "
        "random. *count* is with multiplicities, *distinct* without. "
        "[Exact counts](exact-counts.md) has the methods. If a geometry is "
        "special only up to rounding, it has as many poses as a generic one, and the additional "
        "poses are far away.\n\n" + printed.getvalue().partition("\n\n")[2]
    )


def output() -> tuple[str, dict[str, str]]:
    """Return the page of what commands print for programs, and their JSON Schemas by file."""
    text, schemas = OUTPUT, {}
    for name, command in leaves():
        if not any("--keys" in parameter.opts for parameter in command.params):
            continue
        text += f"\n## gsp {name}\n"
        for form, fields in Fields(name).forms.items():
            made = form.removeprefix("gsp.").partition("/")[0] + ".schema.json"
            schemas[made] = json.dumps(schema(form, fields), indent=1) + "\n"
            text += f"\n[`{form}`](static/made/{made})\n\n"
            text += "| key | type | meaning |\n|---|---|---|\n"
            for one in fields:
                if one.path:
                    text += f"| `{one.path}` | {type_in_json(one)} | {one.meaning} |\n"
            if columns := [one for one in fields if one.is_column and "@" not in one.key]:
                text += f"\nColumns of CSV: {', '.join(f'`{one.key}`' for one in columns)}\n"
    return text, schemas


def schema(form: str, fields: list[Field]) -> dict[str, Any]:
    """Return the JSON Schema of one form: the types of its keys, where each may be missing."""
    whole: dict[str, Any] = {"type": "object"}
    for one in fields:
        if not one.path:
            continue
        here = whole
        for word in one.path.replace("crank.*", "*").split("."):
            name = word.rstrip("[]")
            if name == "*":
                here = here.setdefault("additionalProperties", {})
            elif name == "1…6":
                here = here.setdefault("patternProperties", {}).setdefault("^[1-6]$", {})
            else:
                here = here.setdefault("properties", {}).setdefault(name, {})
            for _ in range(word.count("[]")):
                here.setdefault("type", "array")
                here = here.setdefault("items", {})
        several = type_in_json(one).split(" or ")
        if several != ["null"] and "any" not in several:
            here["type"] = several[0] if len(several) == 1 else several
        here["description"] = one.meaning
    return {"$schema": DIALECT, "title": form, **whole}


def pages() -> dict[str, str]:
    """Return the text of every page and schema that is made, by its path in docs/."""
    reference, schemas = output()
    return {
        "commands.md": commands(),
        "options.md": options(),
        "output.md": reference,
        "errata.md": errata(),
        "geometry-counts.md": geometries(),
        "platforms.md": platform_page.page(),
        **{f"static/made/{name}": text for name, text in schemas.items()},
    }


def write(app: Any = None) -> None:
    """Write what is made into docs/, where it differs."""
    del app
    for name, text in pages().items():
        path = DOCS / name
        path.parent.mkdir(exist_ok=True)
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def setup(app: Any) -> None:
    """Make the pages before Sphinx looks for pages."""
    app.connect("builder-inited", write)
