"""Tables of numbers in CSV files: their headings, units and cells, and the place of every mistake.

Headings of other programs that have one meaning, such as ``X [mm]``, ``L1``, ``Roll`` and ``Time``,
are defined only here; a file is read as if it had our names. The meaning of a name that differs
between programs is not guessed: the message says what to write.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from typing import NamedTuple

import numpy as np

from gspcli.errors import Location, Mistake, SpecError
from gspcli.geometry.instance import METRES, Array, Instance
from gspcli.records import dataclass
from gspcli.wording import listed, nearest, shown, suggestion

#: A unit at the end of a heading, in brackets of either sort.
_UNIT = re.compile(r"(.*?)\s*[\[(]\s*([^\[\]()]*?)\s*[\])]")
_LEG = re.compile(r"(?:l|leg|leg length|length|strut|actuator|cylinder) ?([1-6])")
#: Words about a coordinate, before it or after it.
_POSITION, _TURNED, _QUATERNION = (
    re.compile(rf"(?:{words}) ?({axes})|({axes}) (?:{words})")
    for words, axes in (
        ("p|pos|position", "[xyz]"),
        ("rot|rotation|theta|angle", "[xyz]"),
        ("q|quat|quaternion|orientation", "[wxyz]"),
    )
)
_TIMES = ("time", "timestamp")
ROLL_PITCH_YAW = {"roll": "rx", "pitch": "ry", "yaw": "rz"}


class Order(NamedTuple):
    """Headings of turns about x, y and z, and the order that is taken if none is given."""

    names: tuple[str, str, str]
    sequence: str
    """As `gspcli.geometry.euler` has it."""
    source: str
    """Who has it so, for messages."""

    @property
    def words(self) -> str:
        """The message about a file with such headings."""
        heads = " ".join(self.names if len(self.names[0]) > 1 else map(str.upper, self.names))
        return (
            f"{heads}: turns about x, y, z in the order {self.sequence}{self.source} "
            "(--euler gives another)"
        )


#: Roll, pitch and yaw are xyz about the axes of the base, which is ZYX about those of the platform.
ORDERS = (
    Order(("roll", "pitch", "yaw"), "ZYX", ""),
    Order(("u", "v", "w"), "XYZ", ", as controllers of PI have it"),
    Order(("a", "b", "c"), "ZYX", ", as LinuxCNC has it"),
)
#: Words of other programs in full, from which suggestions for misspelt ones are taken.
WORDS = (
    *_TIMES,
    *ROLL_PITCH_YAW,
    *(f"{word} {k}" for word in ("leg", "length") for k in range(1, 7)),
    *(f"{word} {axis}" for word in ("position", "rotation") for axis in "xyz"),
    *(f"quaternion {axis}" for axis in "wxyz"),
)
#: Headings of other programs with more than one meaning, and what to write instead.
_AMBIGUOUS = (
    (("a", "b", "c", "u", "v", "w"), "A B C and U V W may both be turns: leave out one of them"),
    (("alpha", "beta", "gamma"), "alpha beta gamma do not say about which axes: write rx ry rz"),
    (("phi", "theta", "psi"), "phi theta psi do not say about which axes: write rx ry rz"),
    (("q0", "q1", "q2", "q3"), "q0 ... q3 do not say which is the scalar: write qw qx qy qz"),
    (("q1", "q2", "q3", "q4"), "q1 ... q4 do not say which is the scalar: write qw qx qy qz"),
)


@dataclass(frozen=True)
class Heading:
    """A cell of a heading."""

    #: Our name of the column. A name with a dot is kept as written: it contains a name that the
    #: user has chosen.
    name: str
    #: The heading as written, without a unit.
    word: str
    #: What is in brackets, or None.
    unit: str | None = None
    #: Whether it says that the column is the length of a leg.
    is_leg: bool = False

    @classmethod
    def of(cls, text: str) -> Heading:
        """Return what a cell of a heading means."""
        match = _UNIT.fullmatch(text)
        word, unit = (match[1], match[2]) if match and match[1] else (text, None)
        if "." in word:
            return cls(word, word, unit)
        plain = " ".join(re.split(r"[\s_-]+", word.lower().strip()))
        if leg := _LEG.fullmatch(plain):
            return cls(leg[1], word, unit, is_leg=True)
        for pattern, prefix in ((_POSITION, ""), (_TURNED, "r"), (_QUATERNION, "q")):
            if found := pattern.fullmatch(plain):
                return cls(prefix + (found[1] or found[2]), word, unit)
        if plain in _TIMES:
            return cls("t", word, unit)
        return cls(ROLL_PITCH_YAW.get(plain, word.lower()), word, unit)


def headings(texts: Sequence[str]) -> list[Heading]:
    """Return what the cells of a heading mean; A B C or U V W beside X Y Z are turns."""
    found = [Heading.of(text) for text in texts]
    names = {one.name for one in found}
    groups = [order.names for order in ORDERS[1:] if {*order.names} <= names]
    if len(groups) != 1 or not {"x", "y", "z"} <= names or {"rx", "ry", "rz"} & names:
        return found
    turns = dict(zip(groups[0], ("rx", "ry", "rz"), strict=True))
    return [replace(one, name=turns.get(one.name, one.name)) for one in found]


def order_of(words: Collection[str]) -> Order | None:
    """Return the order that the headings of a file say, without units; None if they say none."""
    names = {word.lower().strip() for word in words}
    return next((order for order in ORDERS if {*order.names} <= names), None)


def hints(names: Collection[str]) -> str:
    """Return what to write for names that have no one meaning; nothing if there are no such."""
    found = [text for group, text in _AMBIGUOUS if {*group} <= {name.lower() for name in names}]
    return f": {listed(found, 'and')}" if found else ""


# Which columns of a table are known; the others are refused, unless they are left out by name.
#
# A column with a misspelt heading would otherwise be dropped, and the numbers of the platform taken
# in its place.


#: What stands for any text in the name of a column that is left out.
_ANY = "*"
_NUMBERS = "123456"
#: What `gsp` writes beside poses and values: tables with these are read again without them.
BESIDE = frozenset(
    (
        *("number", "row", "mode", "real", "sides", "multiplicity", "residual", "certified"),
        *("condition", "home", "distance", "turn", "off", "fits", "status", "orientation"),
        *(
            "range",
            "cone",
            "clearance",
            "pose_clearance",
            "gap",
            "gap_between",
            "force",
            "moment",
            "stiffness",
        ),
        *("transmission", "torque", "torque_of"),
        *("power", "frequency", "error", "kinetic", "potential", "work"),
        *("shift", "limits", "way"),
        *(f"{name}{k}" for name in "fva" for k in _NUMBERS),
        *(f"{name}{axis}" for name in ("w", "v", "alpha", "a") for axis in "xyz"),
        *(f"t{axis}_imag" for axis in "xyz"),
        *(f"q{axis}_imag" for axis in "wxyz"),
        *(f"{turn}{axis}_{end}" for turn in ("", "r") for axis in "xyz" for end in ("low", "high")),
    )
)


def left_out(cells: Sequence[str], ignore: Collection[str], name: str) -> frozenset[int]:
    """Return the places of the columns that are left out because they are named.

    Parameters
    ----------
    cells
        The heading, as written.
    ignore
        Names of columns that are left out, as written in the heading or as `gsp` calls them. A name
        with ``*``, which stands for any text, leaves out unknown columns only.
    name
        How messages name the file.

    Raises
    ------
    SpecError
        If there is no such column.
    """
    if not ignore:
        return frozenset()
    meant = [Heading.of(cell).name for cell in cells]
    found: set[int] = set()
    for one in ignore:
        if _ANY in one:
            continue
        places = [k for k, cell in enumerate(cells) if cell == one]
        name_here = Heading.of(one).name.lower()
        places = places or [k for k, key in enumerate(meant) if key and key.lower() == name_here]
        if not places:
            message = f"{name} has no column {shown(one)}{suggestion(one, cells)}"
            raise SpecError([Mistake(None, "--ignore", message)])
        found.update(places)
    return frozenset(found)


def unknown(
    place: int,
    written: str,
    word: str,
    cells: Sequence[str],
    known: Collection[str],
    expected: str,
    ignore: Collection[str],
) -> str:
    """Return the message about an unknown column; empty if the column may be left out.

    That is so if a name with ``*`` in `ignore` is like it, if it has neither a name nor cells, or
    if it has no name, is the first one and counts the rows.

    Parameters
    ----------
    place
        Which column it is, from 0.
    written, word
        Its heading, and that without a unit.
    cells
        What is in it.
    known, expected
        The known names, and the text that lists them if none is spelt like this one.
    ignore
        Names of columns that are left out.
    """
    if any(_is_like(written, one) for one in ignore if _ANY in one):
        return ""
    hint = "(--ignore leaves it out)"
    if written:
        names = {*known, *(name for name in WORDS if Heading.of(name).name in known)}
        near = nearest(word, sorted(names))
        said = f": did you mean {near}?" if near else f", expected {expected}"
        return f"found the unknown column {shown(written)}{said} {hint}"
    stripped = [cell.strip() for cell in cells]
    counted = any(stripped == [str(k + first) for k in range(len(stripped))] for first in (0, 1))
    if not any(stripped) or (place == 0 and counted):
        return ""
    return f"found a column without a name, expected one {hint}"


def _is_like(written: str, pattern: str) -> bool:
    """Return whether a heading is like a name with stars."""
    parts = map(re.escape, pattern.split(_ANY))
    return re.fullmatch(".*".join(parts), written, re.IGNORECASE) is not None


# Units of columns: which kind of quantity a column is, and by what its numbers are multiplied.
#
# A column has its kind by its name: x is a length, rx an angle, t a time. A unit of another kind is
# an error, since the number cannot be what the heading says.


class ColumnQuantity(NamedTuple):
    """A kind of quantity: its name in messages, its units by lower-case names, examples."""

    what: str
    units: Mapping[str, float]
    """In metres, radians, seconds, newtons."""
    examples: tuple[str, ...]


_LENGTH = ColumnQuantity(
    "a length",
    {
        **{unit.lower(): size for unit, size in METRES.items()},
        **dict.fromkeys(("meter", "metre", "meters", "metres"), 1.0),
        **dict.fromkeys(("millimeter", "millimetre", "millimeters", "millimetres"), 1e-3),
    },
    ("m", "mm", "in"),
)
_ANGLE = ColumnQuantity(
    "an angle",
    {
        **dict.fromkeys(("deg", "degree", "degrees", "°"), math.pi / 180),
        **dict.fromkeys(("rad", "radian", "radians"), 1.0),
        "mrad": 1e-3,
    },
    ("deg", "rad", "mrad"),
)
_TIME = ColumnQuantity(
    "a time",
    {**dict.fromkeys(("s", "sec", "second", "seconds"), 1.0), "ms": 1e-3, "min": 60.0},
    ("s", "ms", "min"),
)
_FORCE = ColumnQuantity("a force", {"n": 1.0, "kn": 1e3}, ("N", "kN"))
_TORQUE = ColumnQuantity("a torque", {"nm": 1.0, "n m": 1.0}, ("N m",))
_NUMBER = ColumnQuantity("a number without a unit", {"-": 1.0, "1": 1.0}, ())
_VALUE = (_LENGTH, _ANGLE)

#: The kinds of quantities of columns, by their names as `Heading.name`, and how often the quantity
#: is derived by time; the first pattern that fits counts.
_COLUMNS: tuple[tuple[str, tuple[ColumnQuantity, ...], int], ...] = (
    ("t", (_TIME,), 0),
    ("t?[xyz]", (_LENGTH,), 0),
    ("r[xyz]", (_ANGLE,), 0),
    ("q[wxyz]|r[123][123]", (_NUMBER,), 0),
    ("[1-6]", _VALUE, 0),
    ("v[1-6]", _VALUE, 1),
    ("a[1-6]", _VALUE, 2),
    ("v[xyz]", (_LENGTH,), 1),
    ("a[xyz]", (_LENGTH,), 2),
    ("w[xyz]", (_ANGLE,), 1),
    ("alpha[xyz]", (_ANGLE,), 2),
    ("f[1-6]", (_FORCE, _TORQUE), 0),
    (r"incl\.[xy]|crank\..+", (_ANGLE,), 0),
    (r"slide\..+", (_LENGTH,), 0),
    (r"(platform|base)\..+\.(direction|normal|axis)\.[xyz]", (_NUMBER,), 0),
    (r".+\.[xyz]", (_LENGTH,), 0),
)
_RATE = re.compile(r"(.*?)\s*/\s*s(?:ec)?(\^?2|²)?")


@dataclass(frozen=True)
class FileUnits:
    """The units to which the numbers of a file are converted."""

    #: The name of the unit of lengths; empty if it does not matter.
    length: str = ""
    #: The unit of angles.
    in_radians: float = 1.0
    #: The names of the columns of values that are angles; the others are lengths. None if either is
    #: possible.
    angles: frozenset[str] | None = None

    def of(self, instance: Instance) -> FileUnits:
        """Return the same for files in which the columns 1 to 6 are those of an instance."""
        rows = enumerate(instance.constraints, 1)
        return replace(
            self, angles=frozenset(str(k) for k, row in rows if not row.kind.is_distance)
        )

    def factor(self, column: str, unit: str) -> float | str:
        """Return by what the numbers of a column are multiplied, or what is wrong with its unit.

        Parameters
        ----------
        column
            Its name as it is called here (`Heading`).
        unit
            What is in brackets. Velocities and accelerations have their own: mm/s and deg/s^2.
        """
        if not unit:
            return 1.0
        quantities, order = self._quantities(column)
        rate = _RATE.fullmatch(unit.lower())
        found = (2 if rate[2] else 1) if rate else 0
        base = rate[1] if rate else unit.lower()
        for quantity in quantities if found == order else ():
            if quantity is _LENGTH and not self._metric:
                # Another unit cannot be converted into one that is not known.
                known = base in _LENGTH.units if not self.length else base == self.length.lower()
                if known or base in _NUMBER.units:
                    return 1.0
            elif base in quantity.units:
                return quantity.units[base] / self._size(quantity)
        per = ("", "/s", "/s^2")[order]
        examples = [f"{one}{per}" for kind in quantities for one in self._examples(kind)]
        what = listed(kind.what for kind in quantities) + ("", " per s", " per s^2")[order]
        expected = f"expected {listed(examples)}" if examples else "expected none"
        return f"found the unit {shown(unit)} of the column {column}, {what}: {expected}"

    @property
    def _metric(self) -> bool:
        """Whether the size of the unit of lengths is known."""
        return self.length.lower() in _LENGTH.units

    def _quantities(self, column: str) -> tuple[tuple[ColumnQuantity, ...], int]:
        """Return what a column can be, and how often it is derived by time."""
        for pattern, quantities, order in _COLUMNS:
            if re.fullmatch(pattern, column, re.IGNORECASE):
                if quantities is _VALUE and self.angles is not None:
                    quantities = (_ANGLE if column[-1] in self.angles else _LENGTH,)
                return quantities, order
        return (_NUMBER,), 0

    def _size(self, quantity: ColumnQuantity) -> float:
        """Return the unit to which numbers of a kind are converted, in metres, radians, …."""
        if quantity is _LENGTH:
            return _LENGTH.units[self.length.lower()]
        return self.in_radians if quantity is _ANGLE else 1.0

    def _examples(self, quantity: ColumnQuantity) -> tuple[str, ...]:
        if quantity is _LENGTH and self.length and not self._metric:
            return (self.length,)
        return quantity.examples


#: One cell, in quotation marks or not, up to a delimiter.
_CELL = r'[ ]*(?:"((?:[^"]|"")*)"|([^{d}]*?))[ ]*(?:[{d}]|$)'
#: Decimals with a point or a comma, the line that names the delimiter, units that are kept.
_POINT = re.compile(r"\d\.\d")
_COMMA = re.compile(r"(?<![\w.,])([+-]?\d*),(\d+)(?![\d.,])")
#: What names of columns say that they leave one out, and the message if there are no names.
_NAMELESS = ("", "-")
NO_HEADING = "the first line has numbers: give names with --columns x,y,z,..."
_SEPARATOR = re.compile(r"sep=.")
_ANY_UNITS = FileUnits()
_PLAIN_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


@dataclass(frozen=True)
class Cell:
    """A cell of a file: its text, and the column (of characters, from 1) where it begins."""

    text: str
    column: int


class NumberTable:
    """A table of numbers under a heading, read from CSV text.

    The delimiter is the first of comma, semicolon and tab that the heading has, else blanks.
    Between semicolons or tabs decimals may be written with a comma, if none has a point. Headings
    of other programs are read if they have one meaning (`headings`), and numbers are converted if
    the heading names another unit. Empty lines and lines that begin with # are skipped. Mistakes
    are collected in `mistakes` and reported together (`check`).

    Parameters
    ----------
    text
        The content of the file.
    name
        The name of the file in messages.
    units
        The units to which numbers are converted.
    ignore
        Columns that are left out.
    columns
        The names of the columns, instead of the heading, if there is one; ``-`` and empty names
        leave a column out.
    """

    def __init__(
        self,
        text: str,
        name: str,
        units: FileUnits = _ANY_UNITS,
        ignore: Collection[str] = (),
        columns: Sequence[str] = (),
    ) -> None:
        self.name = name
        self.mistakes: list[Mistake] = []
        lines = _rows(text)
        if not lines:
            raise SpecError(
                [Mistake(Location(name, 1, 1), "", "found nothing, expected a heading and rows")]
            )
        if _SEPARATOR.fullmatch(lines[0][1]) and len(lines) > 1:
            # Spreadsheets write the delimiter in a first line of its own.
            del lines[0]
        self._heading_line, self._named = lines[0][0], bool(columns)
        cells, lines = self._first_cells(lines, columns)
        self._columns = [cell.column for cell in cells]
        self._ignore, self._lacks = ignore, False
        #: Places of the columns that are left out: here they have no name.
        self.left_out = left_out([cell.text for cell in cells], ignore, name)
        self.left_out |= {k for k, one in enumerate(columns) if one in _NAMELESS}
        cells = [
            Cell("", cell.column) if k in self.left_out else cell for k, cell in enumerate(cells)
        ]
        meant = headings([cell.text for cell in cells])
        #: The names in the heading as they are called here (`Heading.name`).
        self.heading = tuple(one.name for one in meant)
        #: The names as written, without units.
        self.names = tuple(one.word for one in meant)
        #: The columns whose heading says that they are lengths of legs.
        self.legs = tuple(one.name for one in meant if one.is_leg)
        self._units = {one.name: one.unit for one in meant if one.unit is not None}
        self._wanted = units
        #: The headings as written.
        self.written = tuple(cell.text for cell in cells)
        for k, cell in enumerate(cells):
            if cell.text and self.heading.index(self.heading[k]) < k:
                self._note(self._heading_line, cell, f"found the column {shown(cell.text)} twice")
        self._lines = lines
        if self._delimiter in (";", "\t"):
            self._read_decimal_commas()
        if not self._lines:
            self.note_heading("found a heading and no rows")
        for number, line in self._lines:
            found = line.count(self._delimiter) + 1 if self._delimiter else len(line.split())
            if found != len(cells) and (row := self._cells(line)) and len(row) != len(cells):
                where = "in --columns" if self._named else "in the heading"
                message = f"found {len(row)} cells, expected {len(cells)} as {where}"
                self.mistakes.append(Mistake(Location(name, number, 1), "", message))

    def _first_cells(
        self, lines: list[tuple[int, str]], columns: Sequence[str]
    ) -> tuple[list[Cell], list[tuple[int, str]]]:
        """Return the cells of the heading, or of the names that stand for it, and the rows.

        Raises
        ------
        SpecError
            If the first line has numbers, and there are no names.
        """
        (number, first), *rest = lines
        self._delimiter = next((mark for mark in ",;\t" if mark in first), "")
        heading = self._cells(first)
        rows = _are_numbers(first, any_numbers=bool(columns))
        if not columns:
            if rows:
                raise SpecError([Mistake(Location(self.name, number, 1), "", NO_HEADING)])
            return heading, rest
        if rows:
            # A comma between other delimiters is that of decimals.
            self._delimiter = next((mark for mark in ";\t," if mark in first), "")
        return [Cell(one, 1) for one in columns], lines if rows else rest

    def _read_decimal_commas(self) -> None:
        """Replace decimal commas by points if all decimals have commas; columns stay the same."""
        lines = [line for _, line in self._lines]
        if any(map(_POINT.search, lines)) or not any("," in line for line in lines):
            return
        self._lines = [(number, _COMMA.sub(r"\1.\2", line)) for number, line in self._lines]

    def __len__(self) -> int:
        return len(self._lines)

    def _cells(self, line: str) -> list[Cell]:
        if not self._delimiter:
            return [Cell(match[0], match.start() + 1) for match in re.finditer(r"\S+", line)]
        cells, start = [], 0
        pattern = re.compile(_CELL.format(d=re.escape(self._delimiter)))
        while match := pattern.match(line, start):
            quoted = match[1] is not None
            text = match[1].replace('""', '"') if quoted else match[2]
            cells.append(Cell(text.strip(), match.start(1 if quoted else 2) + 1))
            start = match.end()
            if not match[0].endswith(self._delimiter):
                break
        return cells

    def _note(self, line: int, cell: Cell, message: str) -> None:
        self.mistakes.append(Mistake(Location(self.name, line, cell.column), cell.text, message))

    def note_column(self, name: str, message: str) -> None:
        """Note a mistake of one heading, by its name as written."""
        column = self._columns[self.written.index(name)]
        self.mistakes.append(Mistake(Location(self.name, self._heading_line, column), "", message))

    def note_heading(self, message: str) -> None:
        """Note a mistake of the heading."""
        self.mistakes.append(Mistake(Location(self.name, self._heading_line, 1), "", message))

    def note_cell(self, row: int, name: str, message: str) -> None:
        """Note a mistake that begins in a column of a row; rows from 0, names as in `heading`."""
        number, line = self._lines[row]
        column = self._cells(line)[self.heading.index(name)].column
        self.mistakes.append(Mistake(Location(self.name, number, column), "", message))

    def refuse_others(self, known: Collection[str], expected: str) -> None:
        """Note each unknown column as a mistake: otherwise it would be ignored silently.

        Parameters
        ----------
        known
            Names as in `heading`, besides those of what `gsp` writes beside poses and values.
        expected
            The text that lists these names in a message if none is spelt like the one found.
        """
        if self._lacks:
            # That message has the whole heading.
            return
        for k, text in enumerate(self.written):
            if k in self.left_out or self.heading[k] in known or self.heading[k] in BESIDE:
                continue
            cells = [row[k] for _, line in self._lines if k < len(row := self._texts(line))]
            if message := unknown(k, text, self.names[k], cells, known, expected, self._ignore):
                place = Location(self.name, self._heading_line, self._columns[k])
                self.mistakes.append(Mistake(place, "", message))

    def choose(self, *groups: Sequence[str]) -> Sequence[str] | None:
        """Return the group of columns that the heading has; None, and a mistake, for none or two.

        Parameters
        ----------
        groups
            Alternatives, names as in `heading`.
        """
        complete = [group for group in groups if set(group) <= set(self.heading)]
        if len(complete) == 1:
            return complete[0]
        expected = listed(" ".join(group) for group in groups)
        if complete:
            both = listed((" ".join(group) for group in complete), "and")
            self.note_heading(f"found {both}, expected only one of {expected}")
            return None
        missing = next(
            (
                name
                for group in groups
                if set(group) & set(self.heading)
                for name in group
                if name not in self.heading
            ),
            None,
        )
        hint = ""
        if missing is not None:
            hint = f": {missing} is missing{suggestion(missing, self._unknown(groups))}"
        found = " ".join(self.written) or "nothing"
        hint = hints(self.written) or hint
        self._lacks = True
        self.note_heading(f"found the columns {shown(found)}, expected {expected}{hint}")
        return None

    def _unknown(self, groups: Sequence[Sequence[str]]) -> list[str]:
        known = {name for group in groups for name in group}
        return [name for name in self.heading if name and name not in known]

    def _texts(self, line: str) -> list[str]:
        if '"' in line:
            return [cell.text for cell in self._cells(line)]
        return line.split(self._delimiter or None)

    def texts(self, name: str) -> list[str]:
        """Return the cells of a column as written; empty where a row is too short."""
        place = self.heading.index(name)
        rows = [self._texts(line) for _, line in self._lines]
        return [row[place].strip() if place < len(row) else "" for row in rows]

    def unit(self, name: str) -> str:
        """Return the unit that the heading names for a column; empty if it names none."""
        return self._units.get(name) or ""

    def leave_out_empty(self, names: Collection[str]) -> None:
        """Remove the rows in which all columns of these names are empty."""
        columns = [self.texts(name) for name in self.heading if name in names]
        if columns:
            filled = [any(cells) for cells in zip(*columns, strict=True)]
            self._lines = [row for row, kept in zip(self._lines, filled, strict=True) if kept]

    def numbers(self, columns: Sequence[str], *, blanks: bool = False) -> Array:
        """Return the numbers in some columns, shape (rows, columns); NaN for each mistake.

        Parameters
        ----------
        columns
            Their names as in `heading`.
        blanks
            Whether cells may be empty: they are NaN, too.
        """
        places = [self.heading.index(name) for name in columns]
        wrong, found = [math.nan] * len(places), []
        for _, line in self._lines:
            texts = self._texts(line)
            try:
                found.append(wrong if "_" in line else [float(texts[place]) for place in places])
            except (ValueError, IndexError):
                found.append(wrong)
        rows = np.array(found, float).reshape(len(found), len(places))
        for k in np.flatnonzero(~np.isfinite(rows).all(axis=1)).tolist():
            rows[k] = self._complain(*self._lines[k], places, columns, blanks=blanks)
        return rows * self._factors(columns) if self._units else rows

    def groups(self, *groups: Collection[str]) -> list[Array]:
        """Return the numbers of some groups of columns, as `numbers` does, read at once."""
        numbers = self.numbers(list(chain.from_iterable(groups)))
        return np.split(numbers, np.cumsum([len(group) for group in groups[:-1]]), axis=1)

    def _factors(self, columns: Sequence[str]) -> list[float]:
        """Return the factors that convert the numbers of columns to the units of the table."""
        factors = []
        for name in columns:
            factor = self._wanted.factor(name, self._units.get(name, ""))
            if isinstance(factor, str):
                self.note_column(self.written[self.heading.index(name)], factor)
                factor = 1.0
            factors.append(factor)
        return factors

    def _complain(
        self, number: int, line: str, places: Sequence[int], columns: Sequence[str], *, blanks: bool
    ) -> list[float]:
        """Return the numbers of a row, and note the cells that are not numbers."""
        cells, found = self._cells(line), []
        for place, name in zip(places, columns, strict=True):
            text = cells[place].text if place < len(cells) else ""
            wrong = wrong_number(text)
            found.append(math.nan if wrong else float(text))
            if wrong and place < len(cells) and (text or not blanks):
                location = Location(self.name, number, cells[place].column)
                self.mistakes.append(Mistake(location, name, wrong))
        return found

    def check(self) -> None:
        """Raise `SpecError` with all mistakes found so far, if there are any."""
        check(self.mistakes)


def rows_without_heading(text: str) -> list[str]:
    """Return the rows of a file whose first line has numbers; none if it has a heading."""
    rows = [line for _, line in _rows(text)]
    if len(rows) > 1 and _SEPARATOR.fullmatch(rows[0]):
        del rows[0]
    return rows if rows and _are_numbers(rows[0], any_numbers=True) else []


def _rows(text: str) -> list[tuple[int, str]]:
    """Return the lines of a file that are neither empty nor comments, with their numbers."""
    return [
        (number, line.rstrip())
        for number, line in enumerate(text.splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]


def _are_numbers(line: str, *, any_numbers: bool) -> bool:
    """Return whether the first line of a file is a row of numbers, not a heading.

    Parameters
    ----------
    line
        The line.
    any_numbers
        Whether numbers of constraints are a row, too, and not their heading.
    """
    cells = [cell for cell in re.split(r"[,;\s]+", line.replace('"', " ")) if cell]
    if not cells or not all(map(_PLAIN_NUMBER.fullmatch, cells)):
        return False
    return any_numbers or not {*cells} <= {*"123456"} or len({*cells}) < len(cells)


def wrong_number(text: str) -> str:
    """Return what is wrong with the text of a number, or nothing."""
    if _PLAIN_NUMBER.fullmatch(text) and math.isfinite(float(text)):
        return ""
    found = shown(text) if text else "nothing"
    comma = "," in text and _PLAIN_NUMBER.fullmatch(text.replace(",", "."))
    hint = " (decimals are written with a point)" if comma else ""
    return f"found {found}, expected a finite number{hint}"


def numbers_of(text: str, counts: Collection[int], name: str) -> list[float]:
    """Return the numbers of an option, between commas.

    Raises
    ------
    SpecError
        If one is none, or there are not as many as there can be.
    """
    cells = [cell.strip() for cell in text.split(",")]
    wrong = next(filter(None, map(wrong_number, cells)), "")
    if len(cells) not in counts:
        expected = listed(map(str, counts))
        wrong = f"found {len(cells)} numbers, expected {expected}"
    check([Mistake(None, name, wrong)] if wrong else [])
    return [float(cell) for cell in cells]


def check(mistakes: Sequence[Mistake]) -> None:
    """Raise `SpecError` if there are mistakes, in the order of their places."""
    if mistakes:
        raise SpecError(sorted(mistakes, key=lambda one: (one.location is None, one.location)))
