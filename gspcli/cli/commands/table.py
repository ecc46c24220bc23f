"""`gsp table`: the paper's tables recomputed, beside what is printed."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.options import Command, Options, output_options
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
_HEADINGS = {"n1": "N1", "surfaces": "case", "distances": "three distance constraints"}


@click.command(cls=Command)
@click.argument("which", type=click.Choice(_CHOICES), metavar="{1|2|3|errata|all}")
@click.option(
    "--check",
    is_flag=True,
    help="Exit with 1 if anything differs. The errata are proved. Table 3 is confirmed by solving "
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
    confirmed = _confirm() if o.check and 3 in numbers else None
    plain = o.output.format == "csv"
    # A row of a CSV names its errata. They are a separate table if nothing else is shown.
    listed = errata and (not plain or not comparisons or o.output.part == "errata")
    emit(
        o.output,
        [
            *(_table(comparison, plain=plain) for comparison in comparisons),
            *([_errata(errata, evidence, confirmed)] if listed else []),
        ],
        document={
            "schema": "gsp.table/1",
            "tables": [comparison.to_json() for comparison in comparisons],
            "errata": [_document(erratum, evidence) for erratum in errata],
            "table_3_confirmed": confirmed,
        },
    )
    unexplained = [str(d) for comparison in comparisons for d in comparison.unexplained]
    if o.check and unexplained:
        lines = "\n".join(unexplained)
        raise CheckFailed(f"printed differently, and no proved erratum accounts for it:\n{lines}")


def _confirm() -> str:
    from gspcli.paper.errata import confirm

    done = confirm(progress=progress)
    return (
        f"Table 3 confirmed: {done.instances} random instances of {done.families} families "
        "solved, each with its N1 solutions for every choice of sides"
    )


def _table(comparison: Comparison, *, plain: bool) -> Result:
    """Return a table for people, or plain for programs."""
    if comparison.number == 3:
        return _grouped(comparison, plain=plain)
    differing = {(d.row, d.column): d for d in comparison.differences}
    rows: list[dict[str, Any]] = []
    for computed in comparison.computed:
        found = {key: differing.get((f"solution {computed['solution']}", key)) for key in computed}
        if plain:
            rows.append({**computed, "erratum": _errata_named(filter(None, found.values()))})
        else:
            rows.append(
                {k: _radical(v) + " *" * (found[k] is not None) for k, v in computed.items()}
            )
    columns = [Field(key, align="right", essential=True) for key in comparison.columns]
    return _compared(comparison, columns, rows, plain=plain)


def _compared(
    comparison: Comparison, columns: list[Field], rows: list[dict[str, Any]], *, plain: bool
) -> Result:
    return Result(
        [*columns, FIELDS["erratum"]] if plain else columns,
        rows,
        comparison.title,
        notes=_verdict(comparison),
        part=f"table-{comparison.number}",
    )


def _errata_named(differences: Iterable[Difference]) -> list[str]:
    from gspcli.paper.tables import erratum_of

    return sorted({erratum_of(difference) or "none" for difference in differences})


def _radical(value: object) -> str:
    """Return an exact number as people write it: (1 + √5)/4."""
    return re.sub(r"sqrt\((\d+)\)", r"√\1", str(value)).replace("*√", "√")


def _grouped(comparison: Comparison, *, plain: bool) -> Result:
    """Show Table 3 by cases, as the paper does."""
    differing = {d.computed: d for d in comparison.differences}
    groups: dict[tuple[int, str], list[str]] = {}
    for row in comparison.computed:
        star = " *" if row["distances"] in differing and not plain else ""
        groups.setdefault((row["n1"], row["surfaces"]), []).append(row["distances"] + star)
    rows = [
        {
            "n1": n1,
            "surfaces": surfaces,
            "families": len(names),
            "distances": ", ".join(names),
            "erratum": _errata_named(differing[name] for name in names if name in differing),
        }
        for (n1, surfaces), names in sorted(groups.items())
    ]
    return _compared(
        comparison,
        [
            FIELDS["n1"].but(title=_HEADINGS["n1"]),
            FIELDS["surfaces"].but(title=_HEADINGS["surfaces"]),
            FIELDS["families"],
            FIELDS["distances"].but(title=_HEADINGS["distances"]),
        ],
        rows,
        plain=plain,
    )


def _verdict(comparison: Comparison) -> list[str]:
    count = len(comparison.differences)
    if not count:
        return ["Every entry is as printed."]
    return [
        f"* {count} {'entry is' if count == 1 else 'entries are'} printed differently: "
        f"{len(comparison.unexplained)} without an erratum."
    ]


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
    return Result(
        FIELDS.of("key sort place printed correct"),
        rows,
        "Errata",
        part="errata",
        notes=[*notes, *([confirmed] if confirmed else [])],
    )
