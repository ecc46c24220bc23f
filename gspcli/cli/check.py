"""`gsp check`: is an instance file correct, and what does it describe."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.names import spec_source
from gspcli.cli.output import Column, Output, Table, emit, output_options
from gspcli.errors import Problem, SpecError
from gspcli.wording import MOST_LINES

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance

_COLUMNS = (
    Column("file", essential=True),
    Column("valid", essential=True),
    Column("class"),
    Column("number", "no.", align="right"),
    Column("type", fold=" "),
    Column("expected", align="right"),
    Column("bound", align="right"),
    Column("warnings", align="right"),
    Column("shared", fold=", ", minor=1),
)


@click.command()
@click.argument("specs", metavar="SPEC...", nargs=-1, required=True)
@output_options()
def command(specs: tuple[str, ...], output: Output) -> None:
    """Check instance files and say which platforms they describe.

    Every mistake in every file is reported with its line and column. Warnings tell what is
    allowed but perhaps not meant: values that are not one equation, primitives that no
    constraint uses, sharing that can never fix the platform. Expected is the generic count of
    the type, bound the refined bound, both for the sides that the file asks for.

    SPEC is a file, - for standard input, or @NAME of an example (`gsp example`). The exit
    code is 2 if a file has mistakes.

    \b
    Examples:
      gsp check platform.yaml
      gsp check data/examples/*.yaml --format csv
      gsp new 6PP | gsp check -
    """
    from gspcli.spec import read

    rows: list[dict[str, Any]] = []
    entries: list[dict[str, Any]] = []
    notes: list[str] = []
    problems: list[Problem] = []
    for spec in specs:
        try:
            reading = read(spec_source(spec))
        except SpecError as error:
            problems += error.problems
            rows.append({"file": spec, "valid": False})
            found = [_problem(problem) for problem in error.problems]
            entries.append({"file": spec, "valid": False, "problems": found})
        else:
            facts = _facts(reading.instance)
            row = {**facts, "shared": _shared(facts["shared"]), "warnings": len(reading.warnings)}
            rows.append({"file": spec, "valid": True, **row, **_type_cells(reading.instance)})
            found = [_problem(warning) for warning in reading.warnings]
            entries.append({"file": spec, "valid": True, **facts, "warnings": found})
            notes += [f"warning: {warning}" for warning in reading.warnings]
    if len(problems) > MOST_LINES:
        # The error has the first ones only.
        notes += [f"mistake: {problem}" for problem in problems]
    document = {"schema": "gsp.check/1", "files": entries}
    emit(output, Table(_COLUMNS, rows, notes=notes), document=document)
    if problems:
        raise SpecError(problems)


def _facts(instance: Instance) -> dict[str, Any]:
    from gspcli.catalogue.bounds import type_bounds
    from gspcli.catalogue.coincidence import canonical_bonds
    from gspcli.spec import bonds, sharing

    platform, base = sharing(instance)
    gsp_type = instance.type
    return {
        **instance.to_json(),
        "shared": {"platform": platform, "base": base},
        "pattern": " ".join(map(str, canonical_bonds(bonds(instance)))),
        "expected": instance.expected,
        "bound": type_bounds(gsp_type).refined_one_sided.value * instance.side_choices,
    }


def _type_cells(instance: Instance) -> dict[str, object]:
    gsp_type = instance.type
    return {
        "class": gsp_type.platform_class.id,
        "number": gsp_type.number,
        "type": gsp_type.id,
    }


def _shared(shared: dict[str, dict[str, list[int]]]) -> str:
    """Return the shared primitives with the numbers of their constraints, as ``P1(4 5 6)``."""
    return ", ".join(
        f"{body} {name}({' '.join(map(str, numbers))})"
        for body, names in shared.items()
        for name, numbers in names.items()
    )


def _problem(problem: Problem) -> dict[str, object]:
    location = problem.location
    return {
        "line": location.line if location else None,
        "column": location.column if location else None,
        "path": problem.path,
        "message": problem.message,
    }
