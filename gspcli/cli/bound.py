"""`gsp bound`: how many solutions a type can have at most, and why."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import click

from gspcli.catalogue.bounds import (
    BOUND_MEANINGS,
    BOUND_NAMES,
    Bounds,
    bound_sides,
    family_bounds,
    type_bounds,
)
from gspcli.catalogue.constraints import Degrees, constraint_facts
from gspcli.catalogue.counts import GenericCounts, family_counts, generic_counts
from gspcli.catalogue.kinds import Kind
from gspcli.catalogue.real_counts import real_counts
from gspcli.catalogue.recorded_varieties import coordinates_label
from gspcli.catalogue.types import Family, GspType
from gspcli.catalogue.witnesses import best_real
from gspcli.cli.names import read_names
from gspcli.cli.output import Column, Output, Table, emit, output_options

_SURFACES = {"P": "plane", "S": "sphere", "C": "cylinder"}
_GENERIC = ("generic_one_sided", "generic_two_sided")


@click.command
@click.argument("names", nargs=-1, required=True, metavar="TYPE...")
@output_options(parts=("constraints", "bounds"))
def command(names: tuple[str, ...], output: Output) -> None:
    """Bound the number of solutions of a type, by constraint and by theorem.

    TYPE is six kinds in any order, a number of the catalogue, a family with its angles left
    open, or an instance file. Bounds are proved ceilings over the complex numbers, for platforms
    with finitely many solutions; the generic count is what almost every platform of the type has,
    and no platform has more isolated solutions.

    \b
    Examples:
      gsp bound 3D3A PL PL LP
      gsp bound 6PP --format json
      gsp bound DPH DPH DPH DPH DPH ALL
      gsp bound 1 17 3850 platform.yaml --format csv
    """
    subjects = read_names(names)
    documents = [bound_document(subject) for subject in subjects]
    one_line_each = output.format in ("csv", "markdown", "latex") and len(subjects) > 1
    if one_line_each or (output.format == "csv" and output.part is None):
        tables = [_summary(subjects)]
    else:
        tables = [table for subject in subjects for table in _tables(subject)]
    emit(output, tables, document=documents[0] if len(documents) == 1 else documents)


def _bounds(subject: GspType | Family) -> Bounds:
    return type_bounds(subject) if isinstance(subject, GspType) else family_bounds(subject)


def _counts(subject: GspType | Family) -> GenericCounts:
    return generic_counts(subject) if isinstance(subject, GspType) else family_counts(subject)


def _kinds(subject: GspType | Family) -> tuple[Kind, ...]:
    return subject.kinds if isinstance(subject, GspType) else subject.distances


def _identity(subject: GspType | Family) -> dict[str, Any]:
    family = subject.family if isinstance(subject, GspType) else subject
    return {**subject.to_json(), "family": family.id}


def bound_document(subject: GspType | Family) -> dict[str, Any]:
    """Return all that is known of the bounds of a type or family, for JSON."""
    bounds, counts = _bounds(subject), _counts(subject)
    return {
        "schema": "gsp.bound/1",
        "type": _identity(subject),
        "constraints": [_constraint(kind) for kind in _kinds(subject)],
        "bounds": bounds.values(),
        "reasons": {
            name: None if bound is None else bound.reason for name, bound in bounds.items()
        },
        "generic": {
            "one_sided": counts.one_sided,
            "two_sided": counts.two_sided,
            "established": counts.established,
        },
        "best_real": best_real(subject),
        "real_counts": list(real_counts(subject)),
    }


def _constraint(kind: Kind) -> dict[str, Any]:
    facts = constraint_facts(kind)
    return {
        "kind": kind.name,
        "degree_lazard": facts.paper_lazard.two_sided,
        "degree_mourrain": facts.paper_mourrain.two_sided,
        "degree_lowest": facts.lowest.two_sided,
        "degree_lowest_one_sided": facts.lowest.one_sided,
        "surface": facts.surface,
    }


def _degrees(degrees: Degrees) -> str:
    if degrees.one_sided == degrees.two_sided:
        return str(degrees.two_sided)
    return f"{degrees.two_sided} ({degrees.one_sided} one-sided)"


def _tables(subject: GspType | Family) -> list[Table]:
    title = subject.id
    if isinstance(subject, GspType):
        title += f"  (no. {subject.number}, {subject.platform_class})"
    else:
        title += f"  (a family of {len(subject.types)} types, angles left open)"
    return [
        constraint_table(_kinds(subject), title),
        bound_table(subject, _bounds(subject), _counts(subject), best_real(subject)),
    ]


def constraint_table(kinds: Sequence[Kind], title: str) -> Table:
    """Return a row for each constraint: its degrees and the surface it gives."""
    rows = []
    for kind in kinds:
        facts = constraint_facts(kind)
        rows.append(
            {
                "kind": kind.name,
                "degree_lazard": _degrees(facts.paper_lazard),
                "degree_mourrain": _degrees(facts.paper_mourrain),
                "degree_lowest": _degrees(facts.lowest),
                "coordinates": coordinates_label(facts.lowest_coordinates),
                "surface": _SURFACES.get(facts.surface or "", ""),
            }
        )
    return Table(
        columns=[
            Column("kind", "constraint", essential=True),
            Column("degree_lazard", "degree (Lazard)", essential=True),
            Column("degree_mourrain", "degree (Mourrain)", essential=True),
            Column("degree_lowest", "lowest degree", essential=True),
            Column("coordinates", "in coordinates", minor=1),
            Column("surface", "surface"),
        ],
        rows=rows,
        title=title,
        part="constraints",
    )


def bound_table(
    subject: GspType | Family, bounds: Bounds, counts: GenericCounts, real: int | None
) -> Table:
    """Return rows: the bounds that apply with their reasons, the counts, the best known real."""
    applying = [(name, bound) for name, bound in bounds.items() if bound is not None]
    rows = [
        {
            "kind": "bound",
            "source": BOUND_MEANINGS[name].title,
            "value": bound.value,
            "sides": bound_sides(name, subject.distances),
        }
        for name, bound in applying
    ]
    rows += [
        {"kind": "generic count", "source": "atlas", "value": value, "sides": sides}
        for value, sides in ((counts.one_sided, "one-sided"), (counts.two_sided, "two-sided"))
    ]
    if real is not None:
        rows.append(
            {
                "kind": "real, best known (lower bound)",
                "source": "witness",
                "value": real,
                "sides": "two-sided",
            }
        )
    return Table(
        columns=[
            Column("kind", "number of solutions", essential=True, fold=" "),
            Column("source", "by", essential=True, fold=" "),
            Column("value", align="right", essential=True),
            Column("sides", essential=True, fold=" "),
        ],
        rows=rows,
        notes=[
            *dict.fromkeys(bound.reason for _, bound in applying),
            f"Generic count: {counts.established}",
        ],
        part="bounds",
    )


def _summary(subjects: list[GspType | Family]) -> Table:
    rows = [
        _identity(subject)
        | _bounds(subject).values()
        | {name: getattr(_counts(subject), name.removeprefix("generic_")) for name in _GENERIC}
        | {"best_real": best_real(subject)}
        for subject in subjects
    ]
    return Table(
        columns=[
            *(Column(key) for key in ("number", "id", "class", "family")),
            *(Column(name, align="right") for name in (*BOUND_NAMES, *_GENERIC, "best_real")),
        ],
        rows=rows,
    )
