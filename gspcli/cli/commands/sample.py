"""`gsp sample`: how many solutions of random platforms are real."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from gspcli.cli import options
from gspcli.cli.files import write_whole
from gspcli.cli.render import emit, write
from gspcli.cli.result import Fields, Result
from gspcli.cli.specs import read_type
from gspcli.cli.streams import progress, say
from gspcli.errors import INTERRUPTED, GspError

if TYPE_CHECKING:
    from gspcli.reality.real_distribution import Sample, Tally

FIELDS = Fields("sample")

#: The longest bar of the histogram, characters.
_BAR = 40
#: Decimals that keep a number of order one.
_ALL_DIGITS = 17


@click.command(cls=options.Command)
@click.argument("names", nargs=-1, required=True, metavar="TYPE")
@options.option("--count", "How many platforms to draw.", default=1000, type=options.Whole(1))
@options.seed_option("; the same seed gives the same numbers")
@options.one_sided_option
@options.option(
    "--save FOLDER",
    "Keep undecided and incomplete platforms there, as instance files.",
    name="folder",
    type=click.Path(file_okay=False, path_type=Path),
)
@options.worker_options
@options.output_options((*options.FORMATS, *options.DRAWINGS))
def command(o: options.Options) -> int:
    """Count the real solutions of random platforms of a type.

    Points are uniform in a cube, directions and a hidden pose are uniform. The values are those
    that the constraints measure at that pose, so there is always a real solution. Every platform is
    solved completely. A platform with a nearly double solution is counted as undecided. Ctrl-C
    shows the result so far. TYPE may be a family: the kinds of the angles make no difference.

    \b
    Examples:
      gsp sample 6PP --count 10000
      gsp sample 3D3A PL PL LP --format csv
      gsp sample 6PH --one-sided --count 5000 -o planes.svg
    """
    from gspcli.reality.real_distribution import Sample, SampleResult, Tally, tallies

    if o.folder is not None:
        try:
            o.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise GspError(f"{o.folder}: cannot be made: {error.strerror}") from error
    wanted = Sample(read_type(o.names), o.count, o.seed, o.one_sided)
    total = Tally()
    interrupted = False
    try:
        parts = tallies(wanted, o.workers)
        for part in progress(parts, total=len(wanted.pieces), label="solving platforms"):
            total.add(part)
    except KeyboardInterrupt:
        interrupted = True
        say(f"interrupted after {total.platforms} of {o.count} platforms")
    if o.folder is not None:
        _save(o.folder, wanted, total)
    if o.output.format in options.DRAWINGS:
        from gspcli.pictures.charts import bar_chart

        title = f"{wanted.gsp_type.id}: {total.platforms} random platforms by their number of "
        labels = {"title": f"{title}real solutions", "x_label": "real solutions"}
        chart = bar_chart(total.real, o.output.format, **labels, y_label="platforms")
        write(o.output, chart)
    else:
        table = _table(wanted, total, bars=o.output.format == "table")
        emit(o.output, table, document=SampleResult(wanted, total).to_json())
    return INTERRUPTED if interrupted else 0


def _save(folder: Path, wanted: Sample, tally: Tally) -> None:
    """Write the platforms of which the number of real solutions is not known."""
    from gspcli.reality.witness_proofs import rounded
    from gspcli.spec import dumps

    for (piece, index), why in sorted(tally.doubtful.items()):
        platform = wanted.platforms(piece)[index]
        instance = rounded(platform, _ALL_DIGITS, one_sided=wanted.one_sided)
        name = f"{why}-{wanted.seed}-{piece}-{index}"
        write_whole(folder / f"{name}.yaml", dumps(replace(instance, name=name)))


def _table(wanted: Sample, tally: Tally, *, bars: bool) -> Result:
    most = max(tally.real.values(), default=1)
    decided = tally.real.total()
    rows = [
        {
            "real": real,
            "platforms": tally.real[real],
            "share": tally.real[real] / decided,
            "bar": "#" * round(_BAR * tally.real[real] / most),
        }
        for real in sorted(tally.real)
    ]
    columns = FIELDS.of("real platforms share")
    columns += [FIELDS["bar"].but(title=" ")] if bars else []
    sides = " for one choice of sides" if wanted.one_sided else ""
    mean = "" if tally.mean is None else f", {tally.mean:.4g} real on average"
    others = f"{tally.undecided} undecided, {tally.incomplete} incomplete"
    title = f"{wanted.gsp_type.id}: real ones of {wanted.expected} solutions{sides}"
    return Result(columns, rows, title, summary=[f"{tally.platforms} platforms{mean}; {others}"])
