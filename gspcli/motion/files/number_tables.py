"""Numbers in CSV files with a heading, and the place of every mistake in them."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Sequence
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import Location, Mistake, SpecError
from gspcli.motion.files.headings import BESIDE, FileUnits, headings, hints, left_out, unknown
from gspcli.records import dataclass
from gspcli.wording import listed, shown, suggestion

Array = NDArray[np.float64]

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
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


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
        Columns that are left out (`gspcli.motion.files.headings`).
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
        self,
        number: int,
        line: str,
        places: Sequence[int],
        columns: Sequence[str],
        *,
        blanks: bool,
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
    if not cells or not all(map(_NUMBER.fullmatch, cells)):
        return False
    return any_numbers or not {*cells} <= {*"123456"} or len({*cells}) < len(cells)


def wrong_number(text: str) -> str:
    """Return what is wrong with the text of a number, or nothing."""
    if _NUMBER.fullmatch(text) and math.isfinite(float(text)):
        return ""
    found = shown(text) if text else "nothing"
    comma = "," in text and _NUMBER.fullmatch(text.replace(",", "."))
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
