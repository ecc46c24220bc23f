"""Rebuild what says what commands print as JSON and CSV: pages, schemas and data/keys/.

python -m tools.build.output_reference [--check]
"""

from __future__ import annotations

import json
import sys
from typing import Any

from tools.build.command_keys import COMMAND_KEYS
from tools.build.output_keys import KEYS
from tools.build.output_schemas import DIALECT, Printed, printed
from tools.build.samples import choices, described
from tools.recording import ROOT, parser, save

DOCS = ROOT / "docs"
DATA = ROOT / "data" / "keys"
HEAD = """\
# What commands print for programs

`--format json` prints one object, `--format csv` one table, both with full precision. Standard
output holds nothing else. `gsp COMMAND --keys` prints what the keys and columns of a command mean:

    gsp check --keys

- The first key of an object, `schema`, names its form and version. Within a version keys are added,
  never removed or given another meaning.
- `gsp bound` and `gsp count` print a list of objects if they are given several types or platforms.
- In CSV an empty cell, in JSON `null`, stands for what is not known or does not apply.
- In the tables of these pages `[]` marks the entries of a list, `*` names or numbers of the
  instance.
- `gsp maximize-real` writes an instance file; its page describes the file of its `--resume`.

| command | objects, with their JSON Schemas |
|---|---|
"""


def main() -> int:
    """Write or compare the pages, the schemas and the meanings; return the exit code."""
    arguments = parser(__doc__).parse_args()
    index, files = HEAD, {}
    known = Meanings()
    commands = described()
    for name, command in commands.items():
        page = name.replace(" ", "-")
        forms = printed(name, command)
        meanings = [
            _meanings_of(name, schema_id, found, known) for schema_id, found in forms.items()
        ]
        if "json" in choices(command, "format"):
            files[DATA / f"{page}.json"] = _lines(meanings)
        files[DOCS / "output" / f"{page}.md"] = _page(name, meanings, forms)
        index += f"| [gsp {name}](output/{page}.md) | {_schemas(forms)} |\n"
        for schema_id, found in forms.items():
            schema = {"$schema": DIALECT, "title": schema_id, **found.shape.schema()}
            files[DOCS / "schemas" / _file(schema_id)] = json.dumps(schema, indent=1) + "\n"
    if known.missing or known.unused:
        print(
            "keys without a meaning in tools/build/{output,command}_keys.py:",
            *sorted(known.missing),
        )
        print("meanings of keys that no sample prints:", *sorted(known.unused))
        return 1
    pages = "\n".join(f"output/{name.replace(' ', '-')}" for name in commands)
    index += f"\n```{{toctree}}\n:hidden:\n\n{pages}\n```\n"
    files[DOCS / "output.md"] = index
    return save(files, check=arguments.check, confirmed=f"what {len(commands)} commands print")


def _file(schema_id: str) -> str:
    return f"{schema_id.removeprefix('gsp.').partition('/')[0]}.schema.json"


def _schemas(forms: dict[str, Printed]) -> str:
    return ", ".join(f"[`{one}`](schemas/{_file(one)})" for one in forms)


class Meanings:
    """The meanings of keys and columns, which keys have none, and which meanings no key has."""

    def __init__(self) -> None:
        special = ((c, key) for c, keys in COMMAND_KEYS.items() for key in keys)
        self.missing: set[str] = set()
        self.unused = {("", key) for key in KEYS} | set(special)

    def of(self, command: str, path: str) -> str:
        """Return what a key or column means: for the command, in its object, or everywhere."""
        whole = path.replace("[]", "")
        *_, parent, leaf = ("", *whole.split("."))
        for where, key in ((command, whole), ("", f"{parent}.{leaf}"), (command, leaf), ("", leaf)):
            meanings = COMMAND_KEYS.get(where, {}) if where else KEYS
            if key in meanings:
                self.unused.discard((where, key))
                return meanings[key]
        if leaf.endswith("_imag") and leaf.removesuffix("_imag") in KEYS:
            return "imaginary part, of solutions that are not real"
        self.missing.add(f"{command}.{path}")
        return ""


def _meanings_of(command: str, schema_id: str, found: Printed, known: Meanings) -> dict[str, Any]:
    """Return the keys and columns of one form with their meaning."""
    keys = [[path, types, known.of(command, path)] for path, types in found.shape.rows()]
    headings = [heading for several in found.columns.values() for heading in several]
    names = dict.fromkeys(column for heading in headings for column in heading)
    columns = [[column, known.of(command, column)] for column in names]
    return {"schema": schema_id, "keys": keys, "columns": columns}


def _lines(meanings: list[dict[str, Any]]) -> str:
    """Return the meanings as JSON with a key or column in each line."""

    def rows(several: list[list[str]]) -> str:
        return ",\n".join(f"   {json.dumps(row, ensure_ascii=False)}" for row in several)

    forms = (
        f' {{\n  "schema": {json.dumps(form["schema"])},\n'
        f'  "keys": [\n{rows(form["keys"])}\n  ],\n'
        f'  "columns": [\n{rows(form["columns"])}\n  ]\n }}'
        for form in meanings
    )
    return "[\n" + ",\n".join(forms) + "\n]\n"


def _page(command: str, meanings: list[dict[str, Any]], forms: dict[str, Printed]) -> str:
    """Return the page of a command."""
    text = f"# What gsp {command} prints for programs\n"
    if command != "maximize-real":
        text += f"\n`gsp {command} --keys` prints these tables.\n"
    for form in meanings:
        schema_id = form["schema"]
        text += f"\n## {schema_id}\n\n[JSON Schema](../schemas/{_file(schema_id)})\n"
        text += "\n| key | type | meaning |\n|---|---|---|\n"
        text += "".join(f"| `{path}` | {types} | {said} |\n" for path, types, said in form["keys"])
        for part, headings in forms[schema_id].columns.items():
            for heading in headings:
                label = f" (`--part {part}`)" if part else ""
                text += f"\nCSV{label}: `{','.join(heading)}`\n"
    return text


if __name__ == "__main__":
    sys.exit(main())
