"""`gsp bound`: how many solutions a type can have at most, and why."""

from __future__ import annotations

from collections.abc import Sequence

import click

from gspcli.catalogue.bounds import BOUND_MEANINGS, BOUND_NAMES, bound_sides, coordinates_label
from gspcli.catalogue.constraints import Degrees, constraint_facts
from gspcli.catalogue.counts import best_real
from gspcli.catalogue.kinds import Kind
from gspcli.catalogue.known_facts import KnownBounds
from gspcli.catalogue.known_facts import bound as known
from gspcli.catalogue.types import GspType
from gspcli.cli.options import Command, Options, output_options
from gspcli.cli.render import emit
from gspcli.cli.result import Field, Fields, Result
from gspcli.cli.specs import read_names

FIELDS = Fields("bound")

_SURFACES = {"P": "plane", "S": "sphere", "C": "cylinder"}
_GENERIC = ("generic_one_sided", "generic_two_sided")


@click.command(cls=Command)
@click.argument("names", nargs=-1, required=True, metavar="TYPE...")
@output_options(parts=("constraints", "bounds"))
def command(o: Options) -> None:
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
    subjects = [known(subject) for subject in read_names(o.names)]
    documents = [subject.to_json() for subject in subjects]
    one_line_each = o.output.format in ("csv", "markdown", "latex") and len(subjects) > 1
    if one_line_each or (o.output.format == "csv" and o.output.part is None):
        tables = [_summary(subjects)]
    else:
        tables = [table for subject in subjects for table in _tables(subject)]
    emit(o.output, tables, document=documents[0] if len(documents) == 1 else documents)


def _degrees(degrees: Degrees) -> str:
    if degrees.one_sided == degrees.two_sided:
        return str(degrees.two_sided)
    return f"{degrees.two_sided} ({degrees.one_sided} one-sided)"


def _tables(found: KnownBounds) -> list[Result]:
    subject = found.subject
    if isinstance(subject, GspType):
        title = f"{subject.id}  (no. {subject.number}, {subject.platform_class})"
    else:
        title = f"{subject.id}  (a family of {len(subject.types)} types, angles left open)"
    return [constraint_table(found.kinds, title), bound_table(found)]


def constraint_table(kinds: Sequence[Kind], title: str) -> Result:
    """Return a row for each constraint: its degrees and the surface it gives."""
    rows = [
        {
            "kind": kind.name,
            "degree_lazard": _degrees(facts.paper_lazard),
            "degree_mourrain": _degrees(facts.paper_mourrain),
            "degree_lowest": _degrees(facts.lowest),
            "coordinates": coordinates_label(facts.lowest_coordinates),
            "surface": _SURFACES.get(facts.surface or "", ""),
        }
        for kind, facts in ((kind, constraint_facts(kind)) for kind in kinds)
    ]
    columns = FIELDS.of("kind degree_lazard degree_mourrain degree_lowest coordinates surface")
    return Result(columns, rows, title, part="constraints")


def bound_table(found: KnownBounds) -> Result:
    """Return rows: the bounds that apply with their reasons, the counts, the best known real."""
    subject, counts, real = found.subject, found.counts, best_real(found.subject)
    applying = {name: bound for name, bound in found.bounds.items() if bound is not None}
    facts: list[tuple[str, str, int, str]] = [
        ("bound", BOUND_MEANINGS[name].title, one.value, bound_sides(name, subject.distances))
        for name, one in applying.items()
    ]
    facts.append(("generic count", "atlas", counts.one_sided, "one-sided"))
    facts.append(("generic count", "atlas", counts.two_sided, "two-sided"))
    if real is not None:
        facts.append(("real, best known (lower bound)", "witness", real, "two-sided"))
    columns = FIELDS.of("kind@2 source value sides")
    rows = [dict(zip(("kind", "source", "value", "sides"), fact, strict=True)) for fact in facts]
    reasons = [*dict.fromkeys(bound.reason for bound in applying.values())]
    notes = [*reasons, f"Generic count: {counts.established}"]
    return Result(columns, rows, notes=notes, part="bounds")


def _summary(subjects: list[KnownBounds]) -> Result:
    rows = [
        subject.identity
        | subject.bounds.values()
        | {name: getattr(subject.counts, name.removeprefix("generic_")) for name in _GENERIC}
        | {"best_real": best_real(subject.subject)}
        for subject in subjects
    ]
    names = [Field(key) for key in ("number", "id", "class", "family")]
    numbers = [Field(name, align="right") for name in (*BOUND_NAMES, *_GENERIC, "best_real")]
    return Result([*names, *numbers], rows)
