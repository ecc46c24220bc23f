"""`gsp table`: the paper's tables recomputed, beside what is printed."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.options import Command, Options, option, output_options
from gspcli.cli.render import emit
from gspcli.cli.result import Field, Fields, Result
from gspcli.cli.streams import progress, working
from gspcli.errors import CheckFailed

if TYPE_CHECKING:
    from gspcli.paper.errata import Erratum
    from gspcli.paper.tables import Comparison, Difference

FIELDS = Fields("table")

_CHOICES = ("1", "2", "3", "errata", "all")
_TABLES = (1, 2, 3)


@click.command(cls=Command)
@click.argument("which", type=click.Choice(_CHOICES), metavar="{1|2|3|errata|all}")
@option(
    "--check",
    "Exit with 1 if anything differs. The errata are proved. Table 3 is confirmed by solving "
    "random instances of all its families. Any other difference is an entry that is printed "
    "wrongly.",
)
@output_options(parts=("table-1", "table-2", "table-3", "errata"))
def command(o: Options) -> None:
    """Recompute Tables 1, 2 and 3 of the paper and compare them with the print.

    Tables 1 and 2 are exact: radicals, not decimals. A star marks an entry that the paper prints
    differently; the erratum that accounts for it is listed below. In CSV the numbers stand as
    sqrt(3)/2 and a column names the errata of a row.

    \b
    Examples:
      gsp table 3
      gsp table all --check
      gsp table 1 --format latex
      gsp table errata --check --format markdown
    """
    from gspcli.paper.errata import ERRATA, prove
    from gspcli.paper.tables import erratum_of, table

    numbers = _TABLES if o.which == "all" else (int(o.which),) if o.which.isdigit() else ()
    with working("computing"):
        comparisons = [table(number) for number in numbers]
    named = {erratum_of(d) for comparison in comparisons for d in comparison.differences}
    errata = [e for e in ERRATA if e.key in named or not o.which.isdigit()]
    evidence = {}
    if o.check:
        proofs = progress(errata, total=len(errata), label="proving errata")
        evidence = {erratum.key: prove(erratum) for erratum in proofs}
    confirmed = None
    if o.check and 3 in numbers:
        from gspcli.paper.errata import confirm

        done = confirm(progress=progress)
        confirmed = (
            f"Table 3 confirmed: {done.instances} random instances of {done.families} families "
            "solved, each with its N1 solutions for every choice of sides"
        )
    plain = o.output.format == "csv"
    # A row of a CSV names its errata. They are a separate table if nothing else is shown.
    listed = errata and (not plain or not comparisons or o.output.part == "errata")
    tables = [_table(comparison, plain=plain) for comparison in comparisons]
    tables += [_errata(errata, evidence, confirmed)] if listed else []
    document = {
        "schema": "gsp.table/1",
        "tables": [comparison.to_json() for comparison in comparisons],
        "errata": [_document(erratum, evidence) for erratum in errata],
        "table_3_confirmed": confirmed,
    }
    emit(o.output, tables, document=document)
    unexplained = [str(d) for comparison in comparisons for d in comparison.unexplained]
    if o.check and unexplained:
        lines = "\n".join(unexplained)
        raise CheckFailed(f"printed differently, and no proved erratum accounts for it:\n{lines}")


def _table(comparison: Comparison, *, plain: bool) -> Result:
    """Return a table for people, or plain for programs."""
    if comparison.number == 3:
        columns, rows = FIELDS.of("n1 surfaces families distances"), _by_case(comparison, plain)
    else:
        columns = [Field(key, align="right", essential=True) for key in comparison.columns]
        rows = []
        differing = {(d.row, d.column): d for d in comparison.differences}
        for computed in comparison.computed:
            row = f"solution {computed['solution']}"
            wrong = {key: differing[row, key] for key in computed if (row, key) in differing}
            if plain:
                rows.append({**computed, "erratum": _errata_named(wrong.values())})
            else:
                rows.append({k: _radical(v) + " *" * (k in wrong) for k, v in computed.items()})
    count = len(comparison.differences)
    verdict = "Every entry is as printed."
    if count:
        entries = "entry is" if count == 1 else "entries are"
        unexplained = len(comparison.unexplained)
        verdict = f"* {count} {entries} printed differently: {unexplained} without an erratum."
    columns += FIELDS.of("erratum" if plain else "")
    part = f"table-{comparison.number}"
    return Result(columns, rows, comparison.title, [verdict], part=part)


def _errata_named(differences: Iterable[Difference]) -> list[str]:
    from gspcli.paper.tables import erratum_of

    return sorted({erratum_of(difference) or "none" for difference in differences})


def _radical(value: object) -> str:
    """Return an exact number as people write it: (1 + √5)/4."""
    return re.sub(r"sqrt\((\d+)\)", r"√\1", str(value)).replace("*√", "√")


def _by_case(comparison: Comparison, plain: bool) -> list[dict[str, Any]]:
    """Return Table 3 by cases, as the paper shows it."""
    differing = {d.computed: d for d in comparison.differences}
    groups: dict[tuple[int, str], list[str]] = {}
    for row in comparison.computed:
        groups.setdefault((row["n1"], row["surfaces"]), []).append(row["distances"])
    rows = []
    for (n1, surfaces), names in sorted(groups.items()):
        marked = [name + " *" * (name in differing and not plain) for name in names]
        row = {"n1": n1, "surfaces": surfaces, "families": len(names)}
        row["distances"] = ", ".join(marked)
        row["erratum"] = _errata_named(differing[name] for name in names if name in differing)
        rows.append(row)
    return rows


def _document(erratum: Erratum, evidence: Mapping[str, str]) -> dict[str, Any]:
    return {**erratum.document(), "evidence": evidence.get(erratum.key)}


def _errata(
    errata: Sequence[Erratum], evidence: Mapping[str, str], confirmed: str | None
) -> Result:
    rows = [_document(erratum, evidence) for erratum in errata]
    notes = []
    for erratum in errata:
        notes += [f"{erratum.place}: {erratum.argument}"]
        if erratum.key in evidence:
            notes += [f"  proved: {evidence[erratum.key]}"]
    notes += [confirmed] if confirmed else []
    columns = FIELDS.of("key sort place printed correct")
    return Result(columns, rows, "Errata", notes, part="errata")
