"""Tables of joints: one row for each leg; each heading must have one meaning."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Sequence

import numpy as np

from gspcli.errors import SpecError
from gspcli.machines.graph import Graph
from gspcli.machines.readers.legs import RowLeg, legs_graph
from gspcli.machines.source import SourceLine
from gspcli.records import dataclass
from gspcli.wording import listed, shown

#: Words for the bodies, in the order of `_POINTS`.
_BASE = {"b", "base", "bottom", "fixed", "ground", "a"}
_PLATFORM = {"p", "platform", "top", "moving", "plate", "head"}
_POINTS = tuple(body + axis for body in "bp" for axis in "xyz")
#: Words for the other columns.
_WORDS = {
    "name": ("name", "leg", "strut", "joint", "actuator", "no", "number", "id", "i"),
    "length": ("length", "value", "l", "leglength", "strutlength", "distance"),
    "min": ("min", "lmin", "minl", "minimum", "minlength", "lengthmin", "shortest", "low"),
    "max": ("max", "lmax", "maxl", "maximum", "maxlength", "lengthmax", "longest", "high"),
}
_UNITS = {"m", "dm", "cm", "mm", "um", "µm", "km", "in", "inch", "ft"}
_HEADING = re.compile(r"([^\[(]*)(?:[\[(]([^\])]*)[\])])?\s*")
_NUMBER = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")


@dataclass(frozen=True)
class _Column:
    """What a column is, and the unit in its heading."""

    meaning: str
    unit: str


def read(text: str, file: str, name: str) -> Graph:
    """Return the graph of a table.

    Parameters
    ----------
    text
        The table: its first row has headings; comments begin with ``#``.
    file, name
        The file, and what the machine is called.

    Raises
    ------
    SpecError
        With the line and the column of what is wrong.
    """
    lines = [(i, line) for i, line in enumerate(text.splitlines(), 1) if _counts(line)]
    if not lines:
        raise SourceLine(file).error("found an empty table")
    delimiter = max("\t;,", key=lines[0][1].count)
    head, *rows = [(i, _cells(line, delimiter)) for i, line in lines]
    columns = _columns(head[1], SourceLine(file, head[0]))
    units = {column.unit for column in columns if column.unit}
    if len(units) > 1:
        message = f"found columns in {listed(sorted(units), 'and')}, expected one unit"
        raise SourceLine(file, head[0]).error(message)
    comma = delimiter != ","
    legs = [_leg(number, cells, columns, SourceLine(file, i), comma)
            for number, (i, cells) in enumerate(rows, 1)]  # fmt: skip
    ignored = [shown(c) for c, m in zip(head[1], columns, strict=True) if not m.meaning]
    notes = ["the table states no pose: no home is written"]
    if all(column.meaning != "length" for column in columns):
        notes.append("the table states no lengths: they are those in the middle of min and max")
    if ignored:
        notes.append(f"not read: {listed(ignored, 'and')}")
    if not units:
        notes.append("the table states no unit: lengths are taken for mm")
    if any(leg.length is None for leg in legs):
        message = "found no length of each leg, expected a column length, or columns min and max"
        raise SourceLine(file, head[0]).error(message)
    return legs_graph("table", name, legs, None, length=units.pop() if units else "mm", notes=notes)


def is_table(text: str) -> bool:
    """Return whether the first row of a text has the headings of joints."""
    first = next((line for line in text.splitlines() if _counts(line)), "")
    cells = _cells(first, max("\t;,", key=first.count))
    return sum(_meaning(_split(cell)[0]) in _POINTS for cell in cells) >= 2


def _counts(line: str) -> bool:
    """Return whether a line is a row: not empty, and no comment."""
    return bool(line.strip(" \t;,")) and not line.lstrip().startswith("#")


def _cells(line: str, delimiter: str) -> list[str]:
    try:
        rows = list(csv.reader(io.StringIO(line), delimiter=delimiter, skipinitialspace=True))
    except csv.Error:
        return [line]
    return [cell.strip() for cell in rows[0]] if rows else []


def _split(heading: str) -> tuple[str, str]:
    match = _HEADING.fullmatch(heading)
    return (match[1].strip(), (match[2] or "").strip()) if match else (heading, "")


def _meaning(heading: str) -> str:
    """Return what a heading means: one of `_POINTS` or `_WORDS`, or nothing."""
    text = heading.lower()
    for meaning, words in _WORDS.items():
        if re.sub(r"[\s_.-]", "", text) in words:
            return meaning
    words_ = [word for word in re.split(r"[\s_.,:-]+", text) if word]
    if len(words_) == 1 and len(words_[0]) > 1:
        word = words_[0]
        # bx, xb, basex: one letter is the axis.
        words_ = [word[:-1], word[-1]] if word[-1] in "xyz" else [word[1:], word[0]]
    axes = [word for word in words_ if word in ("x", "y", "z")]
    bodies = {
        body for word in words_ for body, names in (("b", _BASE), ("p", _PLATFORM)) if word in names
    }
    known = len(axes) + sum(word in _BASE | _PLATFORM | {"joint", "point"} for word in words_)
    if len(axes) == 1 and len(bodies) == 1 and known == len(words_):
        return bodies.pop() + axes[0]
    return ""


def _columns(headings: Sequence[str], place: SourceLine) -> list[_Column]:
    columns = []
    for heading in headings:
        words, unit = _split(heading)
        meaning = _meaning(words)
        if meaning and meaning != "name" and unit and unit not in _UNITS:
            raise place.error(f"found the unit {shown(unit)}, expected {listed(sorted(_UNITS))}")
        columns.append(_Column(meaning, unit if meaning != "name" else ""))
    for meaning in (*_POINTS, *_WORDS):
        same = [shown(h) for h, c in zip(headings, columns, strict=True) if c.meaning == meaning]
        if len(same) > 1:
            raise place.error(f"found {listed(same, 'and')}, expected one column for {meaning}")
    missing = [m for m in _POINTS if all(c.meaning != m for c in columns)]
    if missing:
        found = listed(map(shown, headings[:20]), "and")
        message = f"found the columns {found}, expected also {listed(missing, 'and')}"
        raise place.error(message + " (b for the base, p for the platform)")
    return columns


def _leg(
    number: int, cells: list[str], columns: list[_Column], place: SourceLine, comma: bool
) -> RowLeg:
    if len(cells) != len(columns):
        raise place.error(f"found {len(cells)} cells, expected {len(columns)}")
    found: dict[str, str] = {}
    values: dict[str, float] = {}
    for k, (cell, column) in enumerate(zip(cells, columns, strict=True), 1):
        found[column.meaning] = cell
        if column.meaning not in ("", "name") and cell:
            values[column.meaning] = _number(
                cell, SourceLine(place.location.file, place.location.line, k), comma
            )
    missing = [m for m in _POINTS if m not in values]
    if missing:
        raise place.error(f"found no number for {listed(missing, 'and')}")
    low, high = values.get("min"), values.get("max")
    length = values.get("length")
    if length is None and low is not None and high is not None:
        length = (low + high) / 2
    if (length is not None and length <= 0) or (
        low is not None and high is not None and low > high
    ):
        raise place.error("found a length of zero or less, or a smallest above the largest")
    ends = [np.array([values[body + axis] for axis in "xyz"]) for body in "bp"]
    return RowLeg(
        found.get("name") or f"leg {number}",
        ends[0],
        ends[1],
        length,
        0.0 if low is None else low,
        math.inf if high is None else high,
    )


def _number(cell: str, place: SourceLine, comma: bool) -> float:
    """Return a number; its decimal point may be a comma where cells are not divided by commas."""
    text = cell.replace(",", ".") if comma and cell.count(",") == 1 and "." not in cell else cell
    if not _NUMBER.fullmatch(text):
        error: SpecError = place.error(f"found {shown(cell)}, expected a number")
        raise error
    return place.number(text)
