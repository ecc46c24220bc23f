"""What a command answers: fields that are described once, and rows, for every format."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field, replace
from fnmatch import fnmatchcase
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gspcli.cli.streams import printable
from gspcli.records import dataclass

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance

_FOLDER = Path(__file__).parent / "fields"


@dataclass(frozen=True)
class Field:
    """A number or text of each row: its key, its meaning, and how tables show it."""

    #: The key in the rows, and the heading in CSV and JSON. In a description it may be a pattern:
    #: ``1…6``, ``crank.*``.
    key: str
    #: The heading for people; the key when empty.
    title: str = ""
    #: Side to which the cells are flushed.
    align: str = "left"
    #: Whether the column stays when a terminal is too narrow for all of them.
    essential: bool = False
    #: On a narrow terminal columns with the largest number are omitted first, of several with the
    #: same number the last. With a negative number the column is omitted only if it does not fit
    #: with fewer digits.
    minor: int = 0
    #: After what a cell may go on in the next line: a blank in prose, a comma and a blank in lists;
    #: empty for cells that stay in one line.
    fold: str = ""
    #: Whether the numbers of the column have the same number of decimals, so that the points stand
    #: under each other.
    aligned: bool = False
    #: This many decimals for each number, for any width; None for what `aligned` says.
    decimals: int | None = None
    #: A typical number. In tables for people a number far below it is a rounding error, and shown
    #: as zero. Otherwise one processor would show zero and another one 1e-17.
    size: float = 0.0
    #: What it is; number, whole, text, boolean, list or object, with a question mark if it may be
    #: null.
    meaning: str = ""
    type: str = "text"
    #: Where it is in JSON, such as ``poses[].t``; empty for a column only.
    path: str = ""
    #: Whether it is a column of tables and CSV.
    is_column: bool = True
    #: In JSON the numbers of one list stand in it together, under this key.
    within: str = ""
    #: Where the value is in a row, if not under the key: ``accuracy.worst_shift``, or the last of a
    #: list, ``singular_values.-1``.
    source: str = ""
    #: Whether JSON has the column, too.
    in_json: bool = True

    @property
    def heading(self) -> str:
        """The heading for people."""
        return self.title or self.key

    def but(self, **changes: Any) -> Field:
        """Return the field with other attributes, for what depends on the platform."""
        return replace(self, **changes)


class Fields:
    """All that a command prints, described once: in the file of its name in `fields/`.

    A line of it is ``path | type | meaning | how tables show it``. The path is that in JSON; it is
    one of a column, too, if it is an entry of the rows of a list (``poses[].t``), unless the line
    says ``json``. A line with ``table`` is a column only. Two columns of one name are told apart by
    what follows an @. ``+ platform`` takes the lines of another file. The last part has
    ``essential``, ``aligned``, ``minor=2``, ``fold`` (at blanks), ``list`` (at commas),
    ``left``, ``right``, ``decimals=3``, ``from=singular_values.-1`` and, last, ``title=``.
    ``# gsp.measure/1`` begins a form of JSON. `size` is that of its columns, see `Field`.
    """

    def __init__(self, command: str, size: float = 0.0) -> None:
        self._name, self._size = command.replace(" ", "-"), size

    @cached_property
    def forms(self) -> dict[str, list[Field]]:
        """The fields by the forms of JSON."""
        found: dict[str, list[Field]] = {}
        for line in _lines(self._name):
            if line.startswith("# "):
                found[line[2:]] = []
            else:
                found[next(reversed(found))].append(_field(line))
        return found

    @cached_property
    def _columns(self) -> dict[str, Field]:
        every = [one for fields in self.forms.values() for one in fields if one.is_column]
        return {one.key: one for one in reversed(every)}

    def __getitem__(self, name: str) -> Field:
        """Return the column of a name, perhaps by its pattern."""
        found = self._columns.get(name)
        if found is None:
            patterns = {key.replace("1…6", "[1-6]"): one for key, one in self._columns.items()}
            found = next((one for key, one in patterns.items() if fnmatchcase(name, key)), None)
            if found is None:
                raise KeyError(name)
        key, again, _ = name.partition("@")
        in_json = (self._columns.get(key, found) if again else found).in_json
        return found.but(key=key, in_json=in_json, size=found.size or self._size)

    def of(self, names: str, rows: Sequence[Mapping[str, Any]] = ()) -> list[Field]:
        """Return the columns of names between blanks; with a ? it is one if some row has it."""
        columns = []
        for name in names.split():
            column = self[name.removesuffix("?")]
            if not name.endswith("?") or any(_found(row, column) is not _MISSING for row in rows):
                columns.append(column)
        return columns


def _lines(name: str) -> Iterator[str]:
    for line in (_FOLDER / f"{name}.txt").read_text(encoding="utf-8").splitlines():
        if line.startswith("+ "):
            yield from _lines(line[2:])
        else:
            yield line


def _field(line: str) -> Field:
    path, kind, meaning, shown, *_ = [*map(str.strip, line.split(" | ")), ""]
    shown, _, title = shown.partition("title=")
    words = dict(word.partition("=")[::2] for word in shown.split())
    is_row = path.count("[].") == 1 and "json" not in words
    left = "right" not in words and kind.rstrip("?") in ("text", "list", "boolean")
    return Field(
        path.partition("[].")[2].removesuffix("[]") if is_row else path,
        title,
        "left" if left or "left" in words else "right",
        "essential" in words,
        int(words.get("minor", 0)),
        ", " if "list" in words else " " if "fold" in words else "",
        "aligned" in words,
        int(words["decimals"]) if "decimals" in words else None,
        meaning=meaning,
        type=kind,
        path="" if "table" in words else path.partition("@")[0],
        is_column=is_row or "table" in words,
        within=words.get("in", ""),
        source=words.get("from", ""),
        in_json="table" not in words,
    )


_MISSING = object()


def _found(row: Mapping[str, Any], column: Field) -> Any:
    """Return the value of a column in a row, or `_MISSING`."""
    if not column.source:
        return row.get(column.key, _MISSING)
    value: Any = row
    for step in column.source.split("."):
        if isinstance(value, Mapping):
            value = value.get(step, _MISSING)
        else:
            value = value[int(step)] if isinstance(value, Sequence) else _MISSING
    return value


@dataclass(frozen=True)
class Result:
    """Rows to show, and what is said about them."""

    #: The fields of the rows in their order.
    columns: Sequence[Field]
    #: A mapping from keys to values for each row; missing and None are empty cells.
    rows: Sequence[Mapping[str, Any]]
    #: A heading above the table.
    title: str = ""
    #: Lines below the table, for people only.
    notes: Sequence[str] = ()
    #: Lines between the title and the table that state the result. With CSV they go to standard
    #: error.
    summary: Sequence[str] = ()
    #: What `--part` calls the table, where a command shows several.
    part: str = ""
    #: For JSON: the platform, the name of the form, the key of the rows (else `part`), and other
    #: keys in their order: the rows are first unless their key is one of them.
    instance: Instance | None = None
    schema: str = ""
    name: str = ""
    head: Mapping[str, Any] = field(default_factory=dict)
    #: The tables that are shown instead of that of the rows, the first below the same title and
    #: summary. JSON has the rows.
    parts: Sequence[Result] = ()

    @property
    def tables(self) -> list[Result]:
        """The tables that are shown."""
        if not self.parts:
            return [self]
        return [replace(self.parts[0], title=self.title, summary=self.summary), *self.parts[1:]]

    def document(self) -> dict[str, Any]:
        """Return the result for JSON: the platform, its rows, and what else is in `head`."""
        within = {one.key: one.within for one in self.columns if one.within}
        only = {one.key for one in self.columns if not one.in_json} - within.keys()
        plain = [one.key for one in self.columns if one.in_json and not (one.within or one.source)]
        rows = []
        for row in self.rows:
            entry: dict[str, Any] = {}
            for key, value in row.items():
                if key in within:
                    entry.setdefault(within[key], []).append(value)
                elif key not in only:
                    entry[key] = value
            rows.append(entry | {key: None for key in plain if key not in entry})
        platform = {} if self.instance is None else self.instance.to_json()
        name, schema = self.name or self.part, f"gsp.{self.schema}/1"
        first = {} if name in self.head else {name: rows}
        return {"schema": schema, **platform, **first, **self.head, name: rows}


#: The columns of a pose: the position, then the quaternion.
POSE = ("x", "y", "z", "qw", "qx", "qy", "qz")


def pose_columns(length: float) -> list[Field]:
    """Return the columns of poses; `length` is a typical one of the platform."""
    return [
        Field(key, "", "right", essential=True, aligned=True, size=1.0 if "q" in key else length)
        for key in POSE
    ]


#: Digits of a number in a table for people, unless the column or the width says otherwise.
DIGITS = 6


#: Numbers of a column have the same number of decimals if the largest lies between these; others
#: need exponents.
_SMALLEST, _LARGEST = 1e-3, 1e5
#: Decimals that an aligned column has at least at full width.
_FEWEST_DECIMALS = 2
#: Components of a vector below this part of its size are rounding errors.
_NOTHING = 1e-9
#: Numbers of a column below this part of its size are rounding errors.
_ROUNDING = 1e-12


def cell_text(value: object, digits: int = DIGITS) -> str:
    """Return a value as people read it in a table, with significant digits of its floats."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        # Zero has one sign.
        return f"{value + 0.0:.{digits}g}"
    if isinstance(value, complex):
        return f"{value.real:.{digits}g}{value.imag:+.{digits}g}i"
    if isinstance(value, (list, tuple)):
        return " ".join(cell_text(item, digits) for item in value)
    return printable(str(value).replace("\n", " "))


def vector_text(numbers: Sequence[float], digits: int = DIGITS, *, size: float = 1.0) -> str:
    """Return components as people read them, one after the other.

    One below `_NOTHING` times a typical one, the size, is a rounding error, and shown as zero.
    """
    shown = (x if abs(x) > _NOTHING * size else 0.0 for x in numbers)
    return ", ".join(f"{x:.{digits}g}" for x in shown)


def cell_of(row: Mapping[str, Any], column: Field) -> Any:
    """Return the value of a cell; a list of texts as one text between commas, where it may fold."""
    value = _found(row, column)
    if column.fold == ", " and isinstance(value, (list, tuple)):
        return ", ".join(map(str, value))
    return None if value is _MISSING else value


def column_texts(table: Result, column: Field, digits: int = DIGITS) -> list[str]:
    """Return the cells of a column as text, numbers with this many digits."""
    values = [_cleared(cell_of(row, column), column.size) for row in table.rows]
    decimals = column.decimals
    if decimals is None and column.aligned:
        decimals = _decimals([v for v in values if isinstance(v, float)], digits)
    if decimals is None:
        return [cell_text(value, digits) for value in values]
    return [_fixed(value, decimals, digits) for value in values]


def _cleared(value: object, size: float) -> object:
    """Return zero for a float that is a rounding error of numbers of a size, else the value."""
    return 0.0 if isinstance(value, float) and abs(value) < _ROUNDING * size else value


def _fixed(value: object, decimals: int, digits: int) -> str:
    """Return a number with this many decimals, any other value unchanged."""
    if isinstance(value, float) and math.isfinite(value):
        return _without_negative_zero(f"{value:.{decimals}f}")
    if isinstance(value, complex):
        real = _without_negative_zero(f"{value.real:.{decimals}f}")
        return f"{real}{value.imag:+.{decimals}f}i"
    return cell_text(value, digits)


def _decimals(values: Sequence[float], digits: int) -> int | None:
    """Return how many decimals give the largest number this many digits; None if none does."""
    # Rounded, so that 0.9999999999 and 1 have the same decimals.
    largest = float(f"{max(map(abs, values), default=0.0):.{digits}g}")
    if largest == 0:
        return 0
    if not _SMALLEST <= largest < _LARGEST:
        return None
    fewest = max(_FEWEST_DECIMALS - (DIGITS - digits), 0)
    return max(digits - 1 - math.floor(math.log10(largest)), fewest)


def _without_negative_zero(text: str) -> str:
    return text if text.strip("-0.") else text.removeprefix("-")
