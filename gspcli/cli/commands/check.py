"""`gsp check`: whether an instance file is correct, and which platform it describes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.options import Command, Options, option, output_options
from gspcli.cli.render import emit, write
from gspcli.cli.result import Fields, Result
from gspcli.cli.specs import spec_source
from gspcli.errors import SpecError
from gspcli.resources import data_path
from gspcli.wording import MOST_LINES

if TYPE_CHECKING:
    from gspcli.spec.checks import CheckedFile

FIELDS = Fields("check")

_COLUMNS = FIELDS.of("file valid class number type expected bound warnings shared")


@click.command(cls=Command)
@click.argument("specs", metavar="[SPEC...]", nargs=-1)
@option("--schema", "Print the JSON Schema of instance files instead, for an editor.")
@output_options()
def command(o: Options) -> None:
    """Check instance files and say which platforms they describe.

    Every mistake in every file is reported with its line and column. Warnings name what is allowed
    but probably a mistake: values that are not one equation, primitives that no constraint uses,
    sharing that can never fix the platform. Expected is the generic count of the type, bound the
    refined bound, both for the sides that the file asks for.

    SPEC is a file, - for standard input, or @NAME of an example (`gsp example`). The exit
    code is 2 if a file has mistakes.

    \b
    Examples:
      gsp check platform.yaml
      gsp check data/examples/*.yaml --format csv
      gsp new 6PP | gsp check -
      gsp check --schema
    """
    if o.schema == bool(o.specs):
        raise click.UsageError("give SPEC, or --schema without one")
    if o.schema:
        from gspcli.spec.form_of_instance import FILE_NAME

        write(o.output, data_path(FILE_NAME).read_text(encoding="utf-8"))
        return
    from gspcli.spec.checks import check

    found = check(*map(spec_source, o.specs), names=o.specs)
    notes = [f"warning: {warning}" for one in found.files for warning in one.warnings]
    if len(found.mistakes) > MOST_LINES:
        # The error has the first ones only.
        notes += [f"mistake: {mistake}" for mistake in found.mistakes]
    rows = [_row(one) for one in found.files]
    emit(o.output, Result(_COLUMNS, rows, notes=notes), document=found.to_json())
    if not found.valid:
        raise SpecError(found.mistakes)


def _row(checked: CheckedFile) -> dict[str, Any]:
    """Return a row, shared primitives with the numbers of their constraints: ``P1(4 5 6)``."""
    entry = checked.to_json()
    if checked.instance is None:
        return entry
    gsp_type = checked.instance.type
    shared = [
        f"{body} {name}({' '.join(map(str, numbers))})"
        for body, names in entry["shared"].items()
        for name, numbers in names.items()
    ]
    more = {"class": gsp_type.platform_class.id, "number": gsp_type.number, "type": gsp_type.id}
    return {**entry, **more, "shared": ", ".join(shared), "warnings": len(checked.warnings)}
