"""`gsp show`: one type on a page."""

from __future__ import annotations

import click

from gspcli.catalogue.constraints import constraint_facts
from gspcli.catalogue.known_facts import KnownFacts, show
from gspcli.catalogue.names import Alias, find_alias, parse_type
from gspcli.catalogue.realization import mechanism_of_type, realization
from gspcli.cli.commands.bound import bound_table, constraint_table
from gspcli.cli.options import Command, Options, output_options
from gspcli.cli.render import emit
from gspcli.cli.result import Fields, Result
from gspcli.cli.specs import is_file, load_instance

FIELDS = Fields("show")


@click.command(cls=Command)
@click.argument("names", nargs=-1, required=True, metavar="TYPE")
@output_options(parts=("constraints", "meanings", "bounds", "chains"))
def command(o: Options) -> None:
    """Show on one page all that is known of a type.

    The page lists the constraints with their degrees and meaning, the bounds with their reasons,
    how the type is solved, and a mechanism that realizes it. It also counts the ways in which
    constraints can share primitives. TYPE is six kinds in any order, a number of the catalogue, or
    an instance file.

    \b
    Examples:
      gsp show 6PP
      gsp show 421 --format json
      gsp show 3-3
      gsp show PL PL LP ALL ALH AHH
    """
    single = len(o.names) == 1 and is_file(o.names[0])
    gsp_type = load_instance(o.names[0]).type if single else parse_type(o.names)
    known, built = show(gsp_type), mechanism_of_type(gsp_type)
    alias = find_alias(" ".join(o.names))
    title = f"{gsp_type.id}  (no. {gsp_type.number}, {gsp_type.platform_class})"
    meanings, chains = [], []
    for kind in dict.fromkeys(gsp_type.kinds):
        facts, realized = constraint_facts(kind), realization(kind)
        row = {"kind": kind.name, "count": gsp_type.count(kind)}
        meanings.append({**row, "meaning": facts.meaning, "equation": facts.definition.text})
        row = {"kind": kind.name, "chain": realized.chain.drawing}
        chains.append({**row, "description": realized.description, "idle": realized.idle_motion})
    mobility = [f"mobility: {built.sum_shown}"]
    tables = [
        constraint_table(gsp_type.kinds, title),
        Result(FIELDS.of("kind count equation meaning"), meanings, part="meanings"),
        bound_table(known),
        Result(FIELDS.of("kind chain description idle"), chains, "", mobility, part="chains"),
        _facts(known, alias),
    ]
    emit(o.output, tables, document=known.to_json())


def _facts(known: KnownFacts, alias: Alias | None) -> Result:
    gsp_type = known.subject
    mirrored = gsp_type.mirrored
    notes = [
        f"solved by: {known.method}",
        f"base and platform exchanged: {mirrored.id} (no. {mirrored.number})"
        + (", the same type" if mirrored == gsp_type else ""),
        f"ways to share primitives among its constraints: {known.sharing_patterns}"
        f"  (gsp enumerate --coincident {gsp_type.number})",
        f"an instance to start from: gsp new {gsp_type.number}",
    ]
    if alias:
        notes.insert(0, f"{alias.name}: {alias.meaning}")
    if alias and alias.pattern:
        notes.insert(1, f"this pattern of shared joints: {alias.pattern}  (gsp new {alias.name})")
    return Result(columns=[], rows=[], notes=notes)
