"""What commands print as JSON and CSV: schemas and columns, inferred from runs of each."""

from __future__ import annotations

import contextlib
import io
import json
import shlex
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gspcli.cli.main import run
from gspcli.resources import instance_files
from gspcli.spec import load

DIALECT = "https://json-schema.org/draft/2020-12/schema"
#: Runs of each command that together print all its keys; POSES and VALUES are files made here.
SAMPLES: dict[str, tuple[str, ...]] = {
    "enumerate": ("--class 6D --only PP,PH", "--class 3D3A --only PH,HP,A", "--class 5D1A --count"),
    "show": ("6PP", "421", "1007"),
    "bound": ("3D3A PL PL LP", "6PP", "3D3A PH PH PH ALL ALL ALL"),
    "constraint": ("DPL", "DLL", "ALH", "DPP"),
    "realize": ("6PP", "DLL DLL DLL ALL ALL ALH", "3000", "@octahedral-3-3"),
    "table": ("1", "2", "3", "errata"),
    "derive": ("ppp", "ccc"),
    "atlas summary": ("",),
    "example": ("",),
    "check": ("@dietmaier @three-vee-250mm @point-on-line @fixture-3-2-1",),
    "solve": (
        "@dietmaier --all",
        "@figure-3 --all --digits 20",
        "@planar-hexagons --all",
        "@no-real-pose",
        "@griffis-duffy",
        "@singular-pose",
    ),
    "certify": ("@figure-3 POSES", "@figure-3 POSES --digits 20"),
    "sample": ("6PP --count 20",),
    "measure": ("@figure-3 POSES",),
    "track": ("@rubin-m2 VALUES",),
    "analyze": ("@rubin-m2", "@figure-3"),
}
#: Commands of several tables: the parts that CSV gives one at a time.
PARTS: dict[str, tuple[str, ...]] = {
    "show": ("constraints", "bounds", "chains"),
    "atlas summary": ("counts", "bounds"),
}
#: Objects whose keys are names or numbers of the instance and not fixed words.
MAPS = ("sides", "degrees", "loci", "platform", "base", "real")
#: Text for people and not tables.
WITHOUT_CSV = ("derive",)


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
                self.keys.setdefault("*" if self.is_map else key, Shape()).add(entry, key)
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


@dataclass(frozen=True)
class Printed:
    """What a command prints.

    Attributes
    ----------
    schema_id
        The value of the key `schema`.
    shape
        The JSON.
    columns
        The columns of each CSV, by the part (empty for the only one).
    """

    schema_id: str
    shape: Shape
    columns: dict[str, list[tuple[str, ...]]]


def printed(command: str) -> Printed:
    """Run the samples of a command."""
    shape, schema_id = Shape(), ""
    columns: dict[str, list[tuple[str, ...]]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for sample in SAMPLES[command]:
            words = [*command.split(), *_words(sample, Path(folder))]
            document = json.loads(_output([*words, "--format", "json"]))
            shape.add(document)
            schema_id = document["schema"]
            if command in WITHOUT_CSV:
                continue
            for part in PARTS.get(command, ("",)):
                more = ["--part", part] if part else []
                heading = _output([*words, *more, "--format", "csv"]).splitlines()[0]
                known = columns.setdefault(part, [])
                if (row := tuple(heading.split(","))) not in known:
                    known.append(row)
    return Printed(schema_id, shape, columns)


def _words(sample: str, folder: Path) -> list[str]:
    poses, values = folder / "poses.json", folder / "values.csv"
    if "POSES" in sample:
        poses.write_text(_output(["solve", "@figure-3", "--format", "json"]), encoding="utf-8")
    if "VALUES" in sample:
        rows = load(instance_files()["rubin-m2"]).constraints
        lines = [",".join(repr(row.value.value + k / 1000) for row in rows) for k in range(3)]
        values.write_text("\n".join([",".join("123456"), *lines]) + "\n", encoding="utf-8")
    text = sample.replace("POSES", str(poses)).replace("VALUES", str(values))
    return shlex.split(text)


def _output(words: list[str]) -> str:
    """Return what a command prints; poses that are infinitely many are an answer."""
    text = io.StringIO()
    with contextlib.redirect_stdout(text), contextlib.redirect_stderr(io.StringIO()) as errors:
        code = run(words)
    if code not in (0, 3) or not text.getvalue():
        message = f"gsp {shlex.join(words)}: exit code {code}: {errors.getvalue()}"
        raise SystemExit(message)
    return text.getvalue()
