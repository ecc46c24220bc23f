"""`gsp derive`: the closed forms of Section 6."""

from __future__ import annotations

import shutil
import sys
from typing import TYPE_CHECKING

import click

from gspcli.cli.options import Command, Options, option, output_options
from gspcli.cli.render import emit, folded
from gspcli.cli.result import Fields, Result
from gspcli.cli.streams import progress, working

if TYPE_CHECKING:
    from gspcli.symbolic.triangular import TriangularSet

FIELDS = Fields("derive")


@click.command(cls=Command)
@click.argument("case", required=False)
@option("--expand", "Write every coefficient in the parameters alone.")
@output_options(formats=("text", "latex", "json"), default="text")
def command(o: Options) -> None:
    """Derive the triangular set of a CASE of the paper's Section 6; list the cases without one.

    CASE is an intersection of three surfaces (P plane, S sphere, C cylinder), as PSC; AAA for three
    angles; or 6.2 or 6.8 for the example of that number. The set is derived by elimination each
    time. Shown are its polynomials, the degree of each in its leading variable, the coefficients
    z1, z2, ..., and the initials with the geometric meaning of their zeros.

    \b
    Examples:
      gsp derive
      gsp derive PSC
      gsp derive PSC --expand --format latex
      gsp derive AAA -o angles.json
      gsp derive 6.2
    """
    from gspcli.symbolic.closed_forms import CASES
    from gspcli.symbolic.derivation import derive

    if o.case is None:
        names = progress(CASES, total=len(CASES), label="deriving")
        emit(o.output, _listing([derive(name).triangular for name in names]))
        return
    with working("deriving"):
        found = derive(o.case, expand=o.expand)
    if o.output.format == "json":
        emit(o.output, (), document=found.to_json())
    else:
        text = found.to_latex() if o.output.format == "latex" else str(found)
        if o.output.format != "latex" and o.output.path is None and sys.stdout.isatty():
            width = shutil.get_terminal_size().columns
            lines = [part for line in text.splitlines() for part in folded(line, width)]
            text = "".join(f"{line}\n" for line in lines)
        emit(o.output, (), texts={o.output.format: text})


def _listing(sets: list[TriangularSet]) -> Result:
    rows = [
        {
            "case": item.case,
            "title": item.title,
            "degrees": "·".join(map(str, item.degrees)),
            "solutions": item.solutions,
            "source": item.source,
        }
        for item in sets
    ]
    notes = ["degrees: of each polynomial in its leading variable; solutions: their product"]
    columns = FIELDS.of("case title degrees solutions source")
    return Result(columns, rows, notes=notes, part="cases", schema="derive-cases")
