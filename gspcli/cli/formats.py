"""Tables for other programs: CSV, Markdown, and LaTeX with the rules of the package booktabs."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence

from gspcli.cli.result import Field, Result, cell_of, column_texts
from gspcli.cli.streams import printable

_HEAD = "% needs \\usepackage{booktabs}\n"
_NUMBER = re.compile(r"-?\d+(\.\d+)?(?:e([+-]\d+))?")
#: Characters and what they are in LaTeX.
_IN_LATEX = r"""
& \&   % \%   # \#   _ \_   $ \$   { \{   } \}   ^ \textasciicircum{}   ~ \textasciitilde{}
\ \textbackslash{}   | \textbar{}   < \textless{}   > \textgreater{}   · $\cdot$
× $\times$   ± $\pm$   − $-$   ≤ $\le$   ≥ $\ge$   ≠ $\ne$   ∠ $\angle$   → $\to$
∞ $\infty$   ─ --   ° $^\circ$   ² \textsuperscript{2}   ³ \textsuperscript{3}
ᵀ \textsuperscript{T}   ρ $\rho$   σ $\sigma$   τ $\tau$   α $\alpha$   θ $\theta$
φ $\varphi$   Σ $\Sigma$   Δ $\Delta$   … \dots{}   “ ``   ” ''
"""
_ESCAPES = str.maketrans(dict(re.findall(r"(\S) (\S+)", _IN_LATEX)))
_ROOT = re.compile(r"√(\d+|)")


#: What is written as `repr` has it, and never needs quotation marks; floats with all their digits.
_NUMBERS = {float, int}
#: What the writer itself writes as `_cell` does.
_PLAIN = _NUMBERS | {str}


def csv_text(table: Result) -> str:
    """Return a table as CSV."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    keys = [column.key for column in table.columns]
    writer.writerow(keys)
    columns = [[cell_of(row, column) for row in table.rows] for column in table.columns]
    if all(_NUMBERS.issuperset(map(type, column)) for column in columns):
        # Long tables are of numbers alone; joined, they take two thirds of the writer's time.
        texts = [map(repr, column) for column in columns]
        buffer.writelines(f"{','.join(cells)}\n" for cells in zip(*texts, strict=True))
    else:
        writer.writerows(
            [cell if type(cell) in _PLAIN else _csv_cell(cell) for cell in cells]
            for cells in zip(*columns, strict=True)
        )
    return buffer.getvalue()


def _csv_cell(value: object) -> str:
    """Return a value for a machine: full precision, `true` and `false`."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return " ".join(_csv_cell(item) for item in value)
    return repr(value) if isinstance(value, float) else str(value)


def markdown(tables: Sequence[Result]) -> str:
    """Return tables in Markdown, with their titles, summaries and notes."""
    return "\n".join(filter(None, map(_markdown, tables)))


def _markdown(table: Result) -> str:
    title = f"### {printable(table.title)}\n" if table.title else ""
    paragraphs = [title, *map(_paragraph, table.summary), _grid(table)]
    return "\n".join(filter(None, [*paragraphs, *map(_paragraph, table.notes)]))


def _paragraph(line: str) -> str:
    return f"{printable(line)}\n"


def _grid(table: Result) -> str:
    if not table.columns:
        return ""
    rules = ["---:" if column.align == "right" else "---" for column in table.columns]
    text = _markdown_line([column.heading for column in table.columns])
    text += "|" + "|".join(rules) + "|\n"
    cells = [column_texts(table, column) for column in table.columns]
    return text + "".join(map(_markdown_line, zip(*cells, strict=True)))


def _markdown_line(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |\n"


def latex(tables: Sequence[Result]) -> str:
    """Return tables as ``tabular`` environments; titles, summaries and notes are comments."""
    return _HEAD + "\n".join(filter(None, map(_latex, tables)))


def _latex(table: Result) -> str:
    comments = "".join(
        f"% {line}\n"
        for text in filter(None, [table.title, *table.summary, *table.notes])
        for line in printable(text).split("\n")
    )
    if not table.columns:
        return comments
    layout = "".join("r" if column.align == "right" else "l" for column in table.columns)
    text = comments + rf"\begin{{tabular}}{{{layout}}}" + "\n\\toprule\n"
    text += _latex_line([_escaped(column.heading) for column in table.columns]) + "\\midrule\n"
    cells = [_cells(table, column) for column in table.columns]
    text += "".join(map(_latex_line, zip(*cells, strict=True)))
    return text + "\\bottomrule\n\\end{tabular}\n"


def _latex_line(cells: Sequence[str]) -> str:
    line = " & ".join(cells) + " \\\\\n"
    # After the end of a row a bracket or a star would be an argument of it.
    return "{}" + line if line.startswith(("[", "*")) else line


def _cells(table: Result, column: Field) -> list[str]:
    values = (row.get(column.key) for row in table.rows)
    return [
        _number(text) if isinstance(value, (int, float)) else _escaped(text)
        for value, text in zip(values, column_texts(table, column), strict=True)
    ]


def _number(text: str) -> str:
    """Return a number as mathematics, ``1e-05`` as a power of ten."""
    match = _NUMBER.fullmatch(text)
    if match is None:
        return _escaped(text)
    mantissa = text.partition("e")[0]
    power = rf" \times 10^{{{int(match[2])}}}" if match[2] else ""
    return f"${mantissa}{power}$" if power or mantissa.startswith("-") else mantissa


def _escaped(text: str) -> str:
    # The translation would escape what it has made of a root.
    parts = _ROOT.split(text)
    pieces = [parts[0].translate(_ESCAPES)]
    for radicand, rest in zip(parts[1::2], parts[2::2], strict=True):
        root = rf"$\sqrt{{{radicand}}}$" if radicand else r"$\surd$"
        pieces.append(root + rest.translate(_ESCAPES))
    return "".join(pieces)
