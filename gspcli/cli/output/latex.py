"""Tables for papers, with the rules of the package booktabs."""

from __future__ import annotations

from collections.abc import Sequence

from gspcli.cli.output.table import Table, cell_text

_LATEX_ESCAPES = str.maketrans(
    {
        "&": r"\&",
        "%": r"\%",
        "#": r"\#",
        "_": r"\_",
        "$": r"\$",
        "{": r"\{",
        "}": r"\}",
        "^": r"\textasciicircum{}",
        "~": r"\textasciitilde{}",
        "\\": r"\textbackslash{}",
        "√": r"$\surd$",
        "·": r"$\cdot$",
        "×": r"$\times$",
        "≤": r"$\le$",
        "²": r"\textsuperscript{2}",
        "ρ": r"$\rho$",
    }
)


def render(tables: Sequence[Table]) -> str:
    """Return tables as ``tabular`` environments."""
    return "\n".join(_latex(table) for table in tables)


def _latex(table: Table) -> str:
    def line(cells: list[str]) -> str:
        return " & ".join(cell.translate(_LATEX_ESCAPES) for cell in cells) + r" \\" + "\n"

    layout = "".join("r" if column.align == "right" else "l" for column in table.columns)
    text = f"% {table.title}\n" if table.title else ""
    text += rf"\begin{{tabular}}{{{layout}}}" + "\n\\toprule\n"
    text += line([column.heading for column in table.columns]) + "\\midrule\n"
    for row in table.rows:
        text += line([cell_text(row.get(column.key)) for column in table.columns])
    return text + "\\bottomrule\n\\end{tabular}\n"
