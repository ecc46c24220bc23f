"""Tables for papers, with the rules of the package booktabs."""

from __future__ import annotations

import re
from collections.abc import Sequence

from gspcli.cli.result import Field, Result, column_texts
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
