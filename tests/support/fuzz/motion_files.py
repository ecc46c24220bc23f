"""One trajectory that is written in many ways, for `gsp measure` and `gsp track`.

Each attack is a random platform of a random type (perhaps with both
sides of its planes) and a short random trajectory of poses. It is written in many ways. Its rows
are values, differences from the file (`--relative`), or poses: with quaternions of any length,
angles in a random order of axes, or the nine entries of R, about a random pivot or not. Angles are
in degrees or radians. Delimiters, the order of columns, comments, empty lines, quotation marks,
capitals, further columns, ends of lines and the byte-order mark vary. What must hold:

- `gsp measure` gives the same values for all of them, and `gsp track --complete` the same exit
  code, modes, events and poses;
- the pose that was drawn first is one of the modes at the first row;
- each spoilt cell is reported with the line and column where it begins, in order, and the exit code
  is 2.
"""

from __future__ import annotations

import json
import re
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.types import all_types
from gspcli.errors import GspError
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.quaternions import quaternion_from_rotation, rotation_from_vector
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import measure
from gspcli.motion.files.value_files import nominal_values
from gspcli.spec import dumps
from tests.support.fuzz.attacks import call

Array = NDArray[np.float64]

FORMS = ("values", "differences", "quaternions", "angles", "entries", "frames")
SPOILT = ("nan", "inf", "", "1e999", "x", "0x1", "1_0", "--1")
DELIMITERS = (",", ";", "\t", " ", ", ")
#: Columns that the commands do not read.
OTHERS = ("note", "speed.x", "Bemerkung")
POSE = ("qw", "qx", "qy", "qz", "x", "y", "z")
#: Standard deviations of the motion between rows: radians, and lengths of platforms of size one.
TURN, SHIFT = 0.2, 0.2
#: Poses agree to this times their condition, and values to this.
SAME, PRECISE = 1e-9, 1e-9


@dataclass(frozen=True)
class Attack:
    """A platform with angles in degrees, and poses R (n, 3, 3), T (n, 3) with their values."""

    instance: Instance
    R: Array
    T: Array
    values: Array

    @property
    def angles(self) -> NDArray[np.bool_]:
        """Which values are angles, shape (6,)."""
        return np.array([not row.kind.is_distance for row in self.instance.constraints])

    def spec(self, *, radians: bool) -> str:
        """Return the instance file, in either unit."""
        document = yaml.safe_load(dumps(self.instance))
        if radians:
            document["units"]["angle"] = "rad"
            for row, value in zip(document["constraints"], self.values[0].tolist(), strict=True):
                if "angle" in row:
                    row["value"] = float(np.radians(value))
        return str(yaml.safe_dump(document, sort_keys=False))


@dataclass(frozen=True)
class Written:
    """A file: its lines, the names in the heading, the delimiter, and the options it needs."""

    lines: list[str]
    names: list[str]
    delimiter: str
    options: list[str]

    def text(self, rng: np.random.Generator) -> bytes:
        """Return the file with some end of lines."""
        end, mark = ("\n", "\r\n")[rng.integers(2)], ("", "\ufeff")[rng.integers(2)]
        return (mark + end.join(self.lines) + end).encode()


def attack(most: int, rng: np.random.Generator) -> Attack:
    """Return a random trajectory of a random platform of at most ``most`` poses."""
    types = [one for one in all_types() if generic_counts(one).two_sided <= most]
    instance, (R, T) = random_instance(types[rng.integers(len(types))], rng, one_sided=True)
    if rng.integers(2):
        both = [
            replace(row, side=Side.BOTH) if row.kind.has_sides else row
            for row in instance.constraints
        ]
        instance = replace(instance, constraints=tuple(both))
    turns, places = [R], [T]
    for _ in range(rng.integers(1, 4)):
        turns.append(rotation_from_vector(TURN * rng.normal(size=3)) @ turns[-1])
        places.append(places[-1] + SHIFT * rng.normal(size=3))
    rotations, points = np.array(turns), np.array(places)
    return Attack(instance, rotations, points, measure(instance, rotations, points))


def written(given: Attack, form: str, rng: np.random.Generator, *, radians: bool) -> Written:
    """Return the trajectory in a form."""
    columns, options = _columns(given, form, rng, radians=radians)
    others = OTHERS[: rng.integers(len(OTHERS) + 1)]
    for name in others:
        columns[name] = rng.normal(size=len(given.R))
        options = [*options, "--ignore", name]
    names = [str(name) for name in rng.permutation(list(columns))]
    delimiter = DELIMITERS[rng.integers(len(DELIMITERS))]
    quote = '"' if delimiter != " " and rng.integers(3) == 0 else ""
    lines = ["# a remark"] if rng.integers(2) else []
    lines.append(delimiter.join(name.upper() if rng.integers(4) == 0 else name for name in names))
    for row in range(len(given.R)):
        cells = [repr(float(columns[name][row])) for name in names]
        lines.append(delimiter.join(f"{quote}{cell}{quote}" for cell in cells))
        if rng.integers(3) == 0:
            lines.append(("", "# between", "   ")[rng.integers(3)])
    return Written(lines, names, delimiter, options)


def _columns(
    given: Attack, form: str, rng: np.random.Generator, *, radians: bool
) -> tuple[dict[str, Array], list[str]]:
    columns: dict[str, Array] = {"t": np.arange(len(given.R), dtype=float) * 0.5 + 1}
    if form in ("values", "differences"):
        numbers = given.values.copy()
        if form == "differences":
            numbers -= nominal_values(given.instance)
        if radians:
            numbers = np.where(given.angles, np.radians(numbers), numbers)
        columns |= {str(k + 1): column for k, column in enumerate(numbers.T)}
        return columns, ["--relative"] if form == "differences" else []
    pivot = np.zeros(3) if form == "frames" else rng.normal(size=3).round(3)
    names = ("Tx", "Ty", "Tz") if form == "frames" else ("x", "y", "z")
    columns |= dict(zip(names, (given.T + given.R @ pivot).T, strict=True))
    options = [f"--pivot={','.join(map(str, pivot.tolist()))}"] if pivot.any() else []
    if form == "angles":
        axes = "".join(list(permutations("xyz"))[rng.integers(6)])
        order = axes.upper() if rng.integers(2) else axes
        found = Rotation.from_matrix(given.R).as_euler(order, degrees=not radians)
        columns |= {f"r{axis}": column for axis, column in zip(axes, found.T, strict=True)}
        return columns, [*options, "--euler", order]
    if form == "entries":
        columns |= {f"r{i + 1}{j + 1}": given.R[:, i, j] for i in range(3) for j in range(3)}
        return columns, options
    lengths = rng.uniform(0.1, 3, (len(given.R), 1)) * rng.choice([-1, 1])
    columns |= dict(zip(POSE[:4], (quaternion_from_rotation(given.R) * lengths).T, strict=True))
    return columns, options


def problems(given: Attack, rng: np.random.Generator) -> Iterator[str]:
    """Yield what does not hold; the first word `refused` means that nothing can be said."""
    first: dict[str, Any] | None = None
    with tempfile.TemporaryDirectory() as folder:
        spec, path = Path(folder, "platform.yaml"), Path(folder, "rows.csv")
        for radians in (False, True):
            spec.write_text(given.spec(radians=radians), encoding="utf-8")
            for form in FORMS:
                file = written(given, form, rng, radians=radians)
                path.write_bytes(file.text(rng))
                words = [str(spec), str(path), "--format", "json", *file.options]
                what = f"{form}, {'radians' if radians else 'degrees'}, {file.options}"
                if form not in ("values", "differences"):
                    yield from _measured(given, words, what, radians=radians)
                code, out, said = call("track", *words, "--complete")
                if not out:
                    yield f"refused: {what}: {code}: {said}"
                    return
                document = {"code": code, **json.loads(out)}
                if first is not None and document["departures"]:
                    # Values do not say that they lead away from the poses.
                    document["code"] = first["code"]
                if first is None:
                    first = document
                    yield from _begins(given, first)
                yield from (f"{what}: {text}" for text in differences(first, document))
        spec.write_text(given.spec(radians=False), encoding="utf-8")
        yield from _spoilt(given, spec, path, rng)


def _measured(given: Attack, words: list[str], what: str, *, radians: bool) -> Iterator[str]:
    code, out, said = call("measure", *words)
    if code:
        yield f"measure, {what}: {code}: {said}"
        return
    found = np.array([pose["values"] for pose in json.loads(out)["poses"]], float)
    if radians:
        found = np.where(given.angles, np.degrees(found), found)
    off = float((np.abs(found - given.values) / (1 + np.abs(given.values))).max())
    if not off < PRECISE:
        yield f"measure, {what}: values differ by {off:.2g}"


def _study(pose: dict[str, Any]) -> Array:
    return np.array([pose[name] for name in POSE], float)


def _begins(given: Attack, document: dict[str, Any]) -> Iterator[str]:
    """Yield whether the pose that was drawn is missing at the first row."""
    drawn = np.concatenate((quaternion_from_rotation(given.R[0]), given.T[0]))
    at = [pose for pose in document["poses"] if pose["t"] == 1]
    if not any(np.abs(_study(p) - drawn).max() < SAME * (1 + p["condition"]) for p in at):
        yield "the pose is not among the modes"


def differences(first: dict[str, Any], other: dict[str, Any]) -> Iterator[str]:
    """Yield in what two documents differ."""
    for key in ("code", "complete", "certified", "modes"):
        if first[key] != other[key]:
            yield f"{key} is {other[key]}, was {first[key]}"
            return
    events = [
        sorted((event["kind"], event["begins"], event["row"]) for event in document["events"])
        for document in (first, other)
    ]
    if events[0] != events[1]:
        yield f"events are {events[1]}, were {events[0]}"
        return
    one, two = (
        {(pose["mode"], pose["t"]): pose for pose in document["poses"]}
        for document in (first, other)
    )
    if one.keys() != two.keys():
        yield f"poses are at {sorted(two)}, were at {sorted(one)}"
        return
    for place, pose in one.items():
        off = np.abs(_study(pose) - _study(two[place])).max()
        if not off < SAME * (10 + pose["condition"]):
            yield f"mode and t {place}: poses differ by {off:.2g}"


def _spoilt(given: Attack, spec: Path, path: Path, rng: np.random.Generator) -> Iterator[str]:
    """Yield the spoilt cells that are not reported at their place."""
    form = ("values", "quaternions", "angles", "entries")[rng.integers(4)]
    file = written(given, form, rng, radians=False)
    lines, mark = list(file.lines), file.delimiter.strip() or file.delimiter
    rows = [k for k, line in enumerate(lines) if line.strip() and not line.startswith("#")][1:]
    cells = set()
    for _ in range(rng.integers(1, 4)):
        row, column = int(rng.choice(rows)), int(rng.integers(len(file.names)))
        if file.names[column] in OTHERS:
            continue
        texts = lines[row].split(mark)
        # Blanks cannot be beside nothing.
        texts[column] = SPOILT[rng.integers(len(SPOILT))] or ("x" if mark == " " else "")
        lines[row] = mark.join(texts)
        cells.add((row, column))
    if not cells:
        return
    path.write_text("\n".join(lines), encoding="utf-8")
    expected = {(row + 1, place(lines[row], mark, column)) for row, column in cells}
    code, _, said = call("track", str(spec), str(path), *file.options)
    pattern = re.compile(re.escape(str(path)) + r":(\d+):(\d+): ")
    told = [(int(match[1]), int(match[2])) for match in pattern.finditer(said)]
    if code != GspError.exit_code or not expected <= {*told} or told != sorted(told):
        yield f"spoilt: exit code {code}, mistakes at {sorted(expected)}, told at {told}"


def place(line: str, mark: str, column: int) -> int:
    """Return the column of characters, from 1, in which the text of a cell begins."""
    cells = line.split(mark)
    text = cells[column]
    start = sum(len(cell) + len(mark) for cell in cells[:column]) + 1
    start += len(text) - len(text.lstrip())
    return start + text.lstrip().startswith('"')
