"""What commands print as JSON and CSV: schemas and columns, inferred from runs of each."""

from __future__ import annotations

import json
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import click

from tools.build.samples import choices, output, samples, words

DIALECT = "https://json-schema.org/draft/2020-12/schema"
#: Commands of several tables: the parts that CSV gives one at a time.
PARTS: dict[str, tuple[str, ...]] = {
    "show": ("constraints", "bounds", "chains"),
    "atlas summary": ("counts", "bounds"),
}
#: Objects whose keys are names or numbers of the instance and not fixed words.
MAPS = ("sides", "degrees", "loci", "platform", "base", "real", "held", "box")
#: Stands for the numbers of constraints among the keys of an object.
NUMBERS = "1…6"
_CONSTRAINTS = frozenset("123456")


@dataclass
class Shape:
    """What values of one key look like."""

    types: set[str] = field(default_factory=set)
    keys: dict[str, Shape] = field(default_factory=dict)
    always: set[str] | None = None
    items: Shape | None = None
    is_map: bool = False

    def add(self, value: Any, name: str = "") -> None:
        """Take one more value into account."""
        if isinstance(value, dict):
            self.types.add("object")
            self.is_map |= name in MAPS
            self.always = set(value) if self.always is None else self.always & set(value)
            for key, entry in value.items():
                name = "*" if self.is_map else NUMBERS if key in _CONSTRAINTS else key
                self.keys.setdefault(name, Shape()).add(entry, key)
        elif isinstance(value, list):
            self.types.add("array")
            self.items = self.items or Shape()
            for entry in value:
                self.items.add(entry)
        else:
            names = {bool: "boolean", int: "integer", float: "number", str: "string"}
            self.types.add(names.get(type(value), "null"))

    def schema(self) -> dict[str, Any]:
        """Return the JSON Schema."""
        types = self.types - ({"integer"} if "number" in self.types else set())
        result: dict[str, Any] = {"type": sorted(types)[0] if len(types) == 1 else sorted(types)}
        if types <= {"null"}:
            # Never anything else in the samples: what it can be is not known from them.
            result = {}
        if "object" in types:
            entries = {key: shape.schema() for key, shape in self.keys.items()}
            if self.is_map:
                result["additionalProperties"] = entries.get("*", True)
            else:
                if (numbered := entries.pop(NUMBERS, None)) is not None:
                    result["patternProperties"] = {"^[1-6]$": numbered}
                result["properties"] = entries
                result["required"] = [key for key in self.keys if key in (self.always or ())]
                result["additionalProperties"] = False
        if self.items is not None:
            result["items"] = self.items.schema()
        return result

    def rows(self, path: str = "") -> list[tuple[str, str]]:
        """Return the paths of all keys below with their types."""
        found: list[tuple[str, str]] = []
        for key, shape in self.keys.items():
            name = f"{path}.{key}" if path else key
            inner = shape
            while inner.items is not None:
                name, inner = f"{name}[]", inner.items
            found.append((name, " or ".join(sorted(inner.types or {"null"}))))
            found += inner.rows(name)
        return found


@dataclass
class Printed:
    """The output of one form of a command.

    Attributes
    ----------
    shape
        The JSON.
    columns
        The columns of each CSV, by the part (empty for the only one).
    """

    shape: Shape = field(default_factory=Shape)
    columns: dict[str, list[tuple[str, ...]]] = field(default_factory=dict)


def printed(name: str, command: click.Command) -> dict[str, Printed]:
    """Run the samples of a command; return what they print by the value of the key `schema`."""
    forms: dict[str, Printed] = {}
    with tempfile.TemporaryDirectory() as folder:
        for sample in samples(name, command):
            run = words(name, sample, Path(folder))
            form = Printed()
            for document in _documents(run):
                form = forms.setdefault(document["schema"], Printed())
                form.shape.add(document)
            if "csv" not in choices(command, "format") or "--check" in run:
                continue
            for part in PARTS.get(name, ("",)):
                more = ["--part", part] if part else []
                heading = output([*run, *more, "--format", "csv"]).splitlines()[0]
                known = form.columns.setdefault(part, [])
                if (row := tuple(heading.split(","))) not in known:
                    known.append(row)
    return forms


def _documents(run: list[str]) -> list[dict[str, Any]]:
    """Return what a command prints as JSON, or keeps as its state."""
    if "--resume" in run:
        output(run)
        text = Path(run[run.index("--resume") + 1]).read_text(encoding="utf-8")
    else:
        text = output([*run, "--format", "json"])
    document = json.loads(text)
    return document if isinstance(document, list) else [document]
