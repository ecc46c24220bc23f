"""`gsp example`: the instance files that are shipped: the examples and the real platforms."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.options import FORMATS, Command, Options, output_options
from gspcli.cli.render import emit
from gspcli.cli.result import Fields, Result
from gspcli.resources import data_json, instance_files, shipped_file

if TYPE_CHECKING:
    from gspcli.catalogue.types import GspType

FIELDS = Fields("example")

_COLUMNS = FIELDS.of("name group type expected exact real number title source")
#: The format of a file itself; the list has no such form.
_FILE = "yaml"
_LEGEND = (
    "expected: poses of almost every platform of the type; exact: of this one, with "
    "multiplicities; real: real ones; empty where not known"
)


@click.command(cls=Command)
@click.argument("name", required=False)
@output_options(formats=(*FORMATS, _FILE))
def command(o: Options) -> None:
    """List the instance files that come with gsp, or print one.

    The examples are the paper's and special positions; the platforms are real machines with
    published dimensions. Wherever a command takes a SPEC, @NAME stands for one of them.
    NAME prints the file itself, in any format. Its first line tells editors that the schema is
    beside it: gsp check --schema -o instance.schema.json.

    \b
    Examples:
      gsp example
      gsp example dietmaier
      gsp example rubin-m2 -o mine.yaml
      gsp solve @sdss-primary
    """
    if o.name is not None:
        from gspcli.spec.form_of_instance import beside_schema

        text = beside_schema(shipped_file(o.name.removeprefix("@")).read_text(encoding="utf-8"))
        emit(o.output, [], texts={o.output.format: text})
        return
    if o.output.format == _FILE:
        raise click.UsageError("the list has no YAML form: give a NAME, or another format")
    rows = [_row(name, path) for name, path in instance_files().items()]
    emit(o.output, Result(_COLUMNS, rows, notes=[_LEGEND], schema="example", name="files"))


def _row(name: str, path: Path) -> dict[str, Any]:
    from gspcli.spec import load

    instance = load(path)
    folder = path.parent.name
    record = data_json(folder, "expected.json")["examples"].get(name, {})
    return {
        "name": name,
        "group": folder.removesuffix("s"),
        "type": short_name(instance.type),
        "expected": instance.expected,
        "exact": "infinite" if record.get("dimension") else record.get("complex"),
        "real": record.get("real"),
        "number": instance.type.number,
        "title": instance.name,
        "source": instance.source,
    }


def short_name(gsp_type: GspType) -> str:
    """Return a name of a type with equal kinds counted, as ``2DPP 4DPH`` or ``6DPP``."""
    runs = ((kind, len(list(run))) for kind, run in groupby(gsp_type.kinds))
    return " ".join(f"{count if count > 1 else ''}{kind.name}" for kind, count in runs)
