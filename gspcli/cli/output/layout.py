"""The layout of a table on a terminal of a given width. No cell is cut."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from gspcli.cli.output.cells import column_texts
from gspcli.cli.output.tables import DIGITS, Column, Table
from gspcli.records import dataclass

#: Blanks between two columns.
GAP = 2
#: Digits that are tried when the essential columns do not fit, before records are.
_FEWER_DIGITS = (5, 4, 3)
#: Prose is folded to this width before a column is left out.
_COMFORTABLE = 24


@dataclass(frozen=True)
class Grid:
    """Columns beside each other.

    Attributes
    ----------
    columns, widths
        Those shown, with their widths in cells of the terminal.
    texts
        The cells of each of them, from top to bottom.
    left_out
        Headings of the columns for which there is no room.
    """

    columns: Sequence[Column]
    widths: Sequence[int]
    texts: Sequence[Sequence[str]]
    left_out: Sequence[str] = ()


def lay_out(table: Table, width: int | None = None) -> Grid | None:
    """Choose the layout of a table for a width; None is unlimited.

    Tried in this order: all columns; headings, then prose, folded at blanks; without the columns
    with the largest `minor`; prose as narrow as its words; fewer digits. Columns whose `minor` is
    negative are omitted only if they do not fit with four digits either.

    Returns
    -------
    The grid; None if the table must be shown as records, a line for each cell.
    """
    measured = _Measured(table, DIGITS)
    if width is None:
        return measured.grid(measured.natural)
    important = [k for k, column in enumerate(table.columns) if column.minor < 0]
    tries: list[tuple[int, tuple[int, ...]]]
    tries = [(digits, ()) for digits in (DIGITS, *_FEWER_DIGITS)]
    if important:
        tries[:0] = [(digits, tuple(important)) for digits in (DIGITS, *_FEWER_DIGITS[:2])]
    every = {digits: measured if digits == DIGITS else None for digits, _ in tries}
    for digits, kept in tries:
        found = every[digits] or _Measured(table, digits)
        every[digits] = found
        for widths in found.attempts(width, kept, every=digits == DIGITS):
            if sum(widths.values()) + GAP * (len(widths) - 1) <= width:
                return found.grid(widths)
    return None


class _Measured:
    """The cells of a table with some number of digits, and their widths."""

    def __init__(self, table: Table, digits: int) -> None:
        self.table = table
        self.texts = [column_texts(table, column, digits) for column in table.columns]
        cells = [max(map(cell_width, texts), default=0) for texts in self.texts]
        headings = [column.heading for column in table.columns]
        self.natural = dict(enumerate(map(max, cells, map(cell_width, headings))))
        #: With headings folded, and prose as well.
        self.folded = dict(enumerate(map(max, cells, map(_longest, headings))))
        self.narrowest = {
            k: max([_longest(headings[k]), *(_longest(t, column.fold) for t in self.texts[k])])
            if column.fold
            else folded
            for (k, folded), column in zip(self.folded.items(), table.columns, strict=True)
        }

    def grid(self, widths: dict[int, int]) -> Grid:
        columns = self.table.columns
        return Grid(
            [columns[k] for k in widths],
            list(widths.values()),
            [self.texts[k] for k in widths],
            [column.heading for k, column in enumerate(columns) if k not in widths],
        )

    def attempts(
        self, width: int, important: Sequence[int], *, every: bool
    ) -> Iterator[dict[int, int]]:
        """Yield widths of columns by their positions, the best first; not all of them fit.

        Parameters
        ----------
        width
            The width of the terminal.
        important
            Columns that stay as essential ones do.
        every
            Whether columns are left out one after the other, or all that may be at once.
        """
        columns = self.table.columns
        comfortable = {
            k: max(narrowest, min(self.folded[k], _COMFORTABLE))
            for k, narrowest in self.narrowest.items()
        }
        kept = list(range(len(columns)))
        dispensable = sorted(
            (k for k in kept if not columns[k].essential and k not in important),
            key=lambda k: (-columns[k].minor, -k),
        )[: len(kept) - 1]
        if every:
            yield self.natural
            yield self.folded
            yield self._squeezed(kept, comfortable, width)
            for k in dispensable:
                kept.remove(k)
                yield self._squeezed(kept, comfortable, width)
        else:
            kept = [k for k in kept if k not in dispensable]
        yield self._squeezed(kept, self.narrowest, width)

    def _squeezed(self, kept: list[int], narrowest: dict[int, int], width: int) -> dict[int, int]:
        """Return the widths after columns of prose are narrowed to fit, the widest first."""
        widths = {k: self.folded[k] for k in kept}
        excess = sum(widths.values()) + GAP * (len(widths) - 1) - width
        while excess > 0:
            able = [k for k in kept if widths[k] > narrowest[k]]
            if not able:
                break
            widest = max(able, key=widths.__getitem__)
            widths[widest] -= 1
            excess -= 1
        return widths


def cell_width(text: str) -> int:
    """Return how many cells of a terminal a text takes."""
    if text.isascii():
        return len(text)
    from rich.cells import cell_len

    return cell_len(text)


def _longest(text: str, separator: str = " ") -> int:
    return max(map(cell_width, _pieces(text, separator)))


def _pieces(text: str, separator: str) -> list[str]:
    """Return what a text is made of, without the blanks between."""
    *pieces, last = text.split(separator)
    return [piece + separator.rstrip(" ") for piece in pieces] + [last]


def folded(text: str, width: int, separator: str = " ") -> list[str]:
    """Return a text in lines of at most a width, broken after separators only.

    Its indentation is kept. A piece longer than the width has a line of its own, and is whole.
    """
    pieces = _pieces(text.lstrip(" "), separator)
    indent = " " * (len(text) - len(text.lstrip(" ")))
    lines = [indent + pieces[0]]
    for piece in pieces[1:]:
        longer = f"{lines[-1]} {piece}"
        if cell_width(longer) <= width:
            lines[-1] = longer
        else:
            lines.append(indent + piece)
    return lines
