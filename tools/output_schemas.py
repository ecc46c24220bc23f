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
from gspcli.resources import data_directory, instance_files
from gspcli.spec import load

DIALECT = "https://json-schema.org/draft/2020-12/schema"
#: Runs of each command that together print all its keys; POSES, TWICE, VALUES, LOOP and STATE are
#: files made here.
SAMPLES: dict[str, tuple[str, ...]] = {
    "enumerate": (
        "--class 6D --only PP,PH",
        "--class 3D3A --only PH,HP,A",
        "--class 5D1A --count",
        "--coincident --class 4D2A",
        "--coincident 6PP --limit 90",
        "--coincident 'DLL DLL DLL ALL ALL ALH' --limit 40",
    ),
    "show": ("6PP", "421", "1007", "3D3A PH PH PH ALL ALL ALL"),
    "bound": ("3D3A PL PL LP", "6PP", "3D3A PH PH PH ALL ALL ALL", "1 17"),
    "constraint": ("DPL", "DLL", "ALH", "DPP"),
    "realize": (
        "6PP",
        "DLL DLL DLL ALL ALL ALH",
        "3000",
        "@octahedral-3-3",
        "'P1-p1 P1-p2 P1-p3 P1-p4 P2-p5 P3-p6'",
    ),
    "table": ("1", "2", "3", "errata --check"),
    "derive": ("", "ppp", "ccc"),
    "atlas summary": ("",),
    "example": ("",),
    "check": ("@dietmaier @three-vee-250mm @point-on-line @fixture-3-2-1",),
    "solve": (
        "@dietmaier --all",
        "@figure-3 --all --digits 20",
        "@planar-hexagons --all",
        "@workspace-study-cones --set 6=79",
        "@no-real-pose",
        "@griffis-duffy",
        "@singular-pose",
        "@rubin-m2 --reading 'leg P1 B2 = 2.913 ± 0.002' --reading 'inclinometer = 0, 0 ± 0.1'",
    ),
    "sensors": (
        "@rubin-m2",
        "@linuxcnc-hexapod --random 5",
        "@no-real-pose",
        "@workspace-study --random 5 --known-side",
    ),
    "certify": ("@figure-3 POSES", "@figure-3 POSES --digits 20", "@figure-3 TWICE"),
    "count": (
        "@planar-hexagons @griffis-duffy @six-planes",
        "@dietmaier --limit 0.000001",
        "--type 6PP --geometry generic,3-3",
    ),
    "sample": ("6PP --count 20",),
    "maximize-real": ("3D3A PH PH PH --attempts 1 --state STATE",),
    "measure": ("@figure-3 POSES", "@t-top-head --pose 0,0,0.17,1,0,0,0 --cranks"),
    "track": ("@rubin-m2 VALUES", "LOOP --allow-loss --all --clearance --pose-clearance", "REACH"),
    "analyze": ("@rubin-m2", "@figure-3", "@figure-3 --geometry 0.01,0.001"),
    "clearance": (
        "@octahedral-3-3 --mode 1",
        "@singular-pose --mode 1",
        "@octahedral-3-3 --mode 1 --of pose",
    ),
    "scan": (
        "@octahedral-3-3 --vary 1=1:2:5",
        "@octahedral-3-3 --vary 1=1:2:3 --vary 2=1:2:3",
        "@octahedral-3-3 --vary 1=1:2:5 --folds",
        "@platform-6-6 --vary 1=2.2:2.4:2 --vary 4=1.6:1.8:2 --folds --jobs 1",
        "@platform-6-6 --vary 1=2.4:2.6:3 --quantity clearance",
        "@platform-6-6 --over x=-2:2:5 --over y=-2:2:5 --pose 0,0,0.5,1,0.2,0.1,0",
        "@platform-6-6 --over x=-2:2:5 --over y=-2:2:5 --pose 0,0,0.5,1,0.2,0.1,0 --folds",
        "@platform-6-6 --over x=-2:2:3 --pose 0,0,0.5,1,0.2,0.1,0 --quantity clearance",
    ),
    "workspace": (
        "@workspace-study",
        "@workspace-study --hold z=0:200:2",
        "@workspace-study --over x,y --boxes --tolerance 0.5",
        "@workspace-study --position 0,0,400 --tolerance 0.5",
        "@workspace-study --over z --within z=0:100",
    ),
}
#: Commands of several tables: the parts that CSV gives one at a time.
PARTS: dict[str, tuple[str, ...]] = {
    "show": ("constraints", "bounds", "chains"),
    "atlas summary": ("counts", "bounds"),
}
#: Objects whose keys are names or numbers of the instance and not fixed words.
MAPS = ("sides", "degrees", "loci", "platform", "base", "real", "held", "box")
#: Text for people and not tables.
WITHOUT_CSV = ("derive", "maximize-real")
#: Stands for the numbers of constraints among the keys of an object.
NUMBERS = "1…6"
_CONSTRAINTS = frozenset("123456")
#: Values after which the platform is in another mode, and folds of others on the way.
_LOOP = data_directory() / "trajectories" / "mode-change"
#: Exit codes that go with complete output: done, a check failed, not finite, not completed.
_ANSWERS = (0, 1, 3, 4)


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


def printed(command: str) -> dict[str, Printed]:
    """Run the samples of a command; return what they print by the value of the key `schema`."""
    forms: dict[str, Printed] = {}
    with tempfile.TemporaryDirectory() as folder:
        for sample in SAMPLES[command]:
            words = [*command.split(), *_words(sample, Path(folder))]
            form = Printed()
            for document in _documents(words):
                form = forms.setdefault(document["schema"], Printed())
                form.shape.add(document)
            if command in WITHOUT_CSV or "--check" in words:
                continue
            for part in PARTS.get(command, ("",)):
                more = ["--part", part] if part else []
                heading = _output([*words, *more, "--format", "csv"]).splitlines()[0]
                known = form.columns.setdefault(part, [])
                if (row := tuple(heading.split(","))) not in known:
                    known.append(row)
    return forms


def _words(sample: str, folder: Path) -> list[str]:
    names = {
        "POSES": "poses.json",
        "TWICE": "twice.json",
        "VALUES": "values.csv",
        "STATE": "s.json",
    }
    paths = {word: folder / name for word, name in names.items()}
    if "POSES" in sample or "TWICE" in sample:
        text = _output(["solve", "@figure-3", "--format", "json"])
        paths["POSES"].write_text(text, encoding="utf-8")
        first = json.loads(text)["solutions"][0]
        rough = first | {"certified": False, "T": [value + 3 for value in first["T"]]}
        twice = {"schema": "gsp.solve/1", "solutions": [first, first, rough]}
        paths["TWICE"].write_text(json.dumps(twice), encoding="utf-8")
    if "VALUES" in sample:
        rows = load(instance_files()["rubin-m2"]).constraints
        lines = [",".join(repr(row.value.value + k / 1000) for row in rows) for k in range(3)]
        paths["VALUES"].write_text("\n".join([",".join("123456"), *lines]) + "\n", encoding="utf-8")
    if "REACH" in sample:
        # To the side until legs leave their cones, then up until they are too long.
        poses = [f"{x},0,{z},1,0,0,0" for x, z in ((0, 60), (60, 60), (0, 60), (0, 160))]
        path = folder / "reach.csv"
        path.write_text("\n".join(["x,y,z,qw,qx,qy,qz", *poses]) + "\n", encoding="utf-8")
        sample = sample.replace("REACH", f"@workspace-study-cones {path} --near 0,0,60,1,0,0,0")
    sample = sample.replace("LOOP", f"{_LOOP}.yaml {_LOOP}.csv")
    for word, path in paths.items():
        sample = sample.replace(word, str(path))
    return shlex.split(sample)


def _documents(words: list[str]) -> list[dict[str, Any]]:
    """Return what a command prints as JSON, or keeps as its state."""
    if "--state" in words:
        _output(words)
        text = Path(words[words.index("--state") + 1]).read_text(encoding="utf-8")
    else:
        text = _output([*words, "--format", "json"])
    document = json.loads(text)
    return document if isinstance(document, list) else [document]


def _output(words: list[str]) -> str:
    """Return what a command prints; that poses are infinitely many, or missing, is an answer."""
    text = io.StringIO()
    with contextlib.redirect_stdout(text), contextlib.redirect_stderr(io.StringIO()) as errors:
        code = run(words)
    if code not in _ANSWERS or not text.getvalue():
        message = f"gsp {shlex.join(words)}: exit code {code}: {errors.getvalue()}"
        raise SystemExit(message)
    return text.getvalue()
