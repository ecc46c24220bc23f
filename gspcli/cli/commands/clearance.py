"""`gsp clearance`: how far values or poses may change before a mode can meet a singularity."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from gspcli.cli.options import HOME, Command, Options, exclusive, option, output_options
from gspcli.cli.pose_options import AskedPoses, asked_poses, rows_options
from gspcli.cli.render import emit
from gspcli.cli.result import Fields, Result
from gspcli.cli.streams import progress
from gspcli.errors import GspError

if TYPE_CHECKING:
    from gspcli.motion.singularities.clearances import Clearances

FIELDS = Fields("clearance")


@click.command(cls=Command)
@rows_options("only this one; also along a file of values.  [default: home]")
@exclusive("--all-modes", "--mode")
@exclusive("--all-modes", "--pose")
@option("--all-modes", "All real poses: not home only.")
@option(
    "--of",
    "What changes.  [default: drives if cranks or slides move points, else values]",
    type=click.Choice(["values", "drives", "pose"]),
)
@option(
    "--points X,Y,Z;...",
    "With --of pose: the points of the platform, in its frame, whose displacements count.  "
    "[default: those of the distances]",
)
@option("--refine", "Better bounds: a few seconds for each mode.")
@output_options()
def command(o: Options) -> None:
    """Bound how far values, or the pose, may change before a mode meets a singularity.

    A clearance of r means: if every value changes by at most r times its weight, all at once and in
    any combination, the mode exists all the while and is not singular. The weight is half the range
    of the constraint, if each has one in SPEC; else 1 in the unit of the value. Values that stay,
    because their range is one number, do not change.

    The lower bound is proved for the whole box of values. The upper bound is the nearest fold of
    the same mode that was found; it is proved, and its values are shown. It may also be where a
    value reaches the end of its possible interval, as a distance that becomes zero: beyond it there
    are no poses.

    One row is shown, for the home mode; with --all-modes one for each real pose. ROWS gives one
    for each of its rows. It is a file of poses as `gsp measure` takes it, or of values as `gsp
    track` takes it, along which all modes are followed.

    --of drives, for machines with cranks or slides, bounds how far all drives may move: in half
    their ranges, or in degrees and lengths. Two bounds are proved: no pose is singular within
    the first, and no drive comes to a dead point within the second, so that all keep their
    working modes. The nearest fold that was found is shown; it is proved. Where symmetric modes
    meet (`singular pose`) that is seen and not proved, as is the nearest dead point.

    --of pose bounds how far the platform may move, for any values, before the six screws become
    dependent. Distances of poses are root mean squares of the displacements of the platform's
    points. The lower bound is proved for all poses within. The upper bound is the distance of
    the nearest singular pose found, where the determinant is proved to change its sign.

    \b
    Examples:
      gsp clearance platform.yaml
      gsp clearance platform.yaml --all-modes --refine
      gsp clearance platform.yaml --of pose
      gsp clearance @reachy-mini-head
      gsp clearance platform.yaml path.csv -o clearances.csv
      gsp clearance platform.yaml --pose 0,0,1.5,1,0,0,0 --format json
    """
    if o.rows is None and o.pose is None and not o.all_modes:
        o.mode = o.mode or HOME
    if o.points is not None and o.of != "pose":
        raise click.UsageError("--points needs --of pose")
    from gspcli.motion.singularities.clearances import clearance

    points = None if o.points is None else _points(o.points)
    asked = asked_poses(o)
    found = clearance(
        o.instance, asked.R, asked.T, of=o.of, points=points, refine=o.refine,
        drives=asked.drives, progress=progress,
    )  # fmt: skip
    emit(o.output, _result(found, asked))
    asked.check()


def _points(text: str) -> list[list[float]]:
    """Return the points that are written as coordinates, between semicolons."""
    from gspcli.motion.files.number_tables import wrong_number

    points = [[cell.strip() for cell in point.split(",")] for point in text.split(";")]
    for point in points:
        if len(point) != 3:
            raise GspError(f"--points: found {len(point)} coordinates, expected X,Y,Z;X,Y,Z;...")
        for cell in point:
            if wrong := wrong_number(cell):
                raise GspError(f"--points: {wrong}")
    return [[float(cell) for cell in point] for point in points]


def _result(found: Clearances, asked: AskedPoses) -> Result:
    """Return a row for each pose, with the values or drives at the nearest event."""
    from gspcli.geometry.machine import Machine, value_machine
    from gspcli.motion.singularities.clearances import weights_of

    instance, units, of = found.instance, found.instance.units, found.of
    if of == "drives":
        note = f"1 {units.angle.value} for cranks, 1 {units.length} for slides"
        note = "half the range of each drive" if weights_of(Machine.of(instance))[1] else note
        note = f"changes of all drives, in units of {note}; last columns: the drives at the fold"
        columns = FIELDS.of(f"{asked.columns} lower working_modes upper")
        columns += [FIELDS["by"].but(essential=False), *FIELDS.of("dead_point drive")]
        names = dict.fromkeys(Machine.of(instance).names, "")
    else:
        note = f"units of 1 {units.length} for distances, 1 {units.angle.value} for angles"
        ranged = weights_of(value_machine(instance))[1]
        note = "units of half the range of each value" if ranged else note
        ends = "ends at", "where the mode ends"
        if of == "pose":
            note = f"{units.length}, root mean squares of the displacements of points"
            ends = "singular at", "of the nearest singular pose found"
        note = f"clearances in {note}; last columns: the values {ends[1]}"
        columns = FIELDS.of(f"{asked.columns} lower@2")
        columns += [FIELDS["upper@2"].but(title=ends[0]), *FIELDS.of("ratio by")]
        columns += FIELDS.of("constraint" if of == "values" else "")
        kinds = (one.kind.name for one in instance.constraints)
        names = {str(k): f"{k} {kind}" for k, kind in enumerate(kinds, 1)}
    place = "drives" if of == "drives" else "values"
    columns += [
        FIELDS[name].but(title=title, source=f"{place}.{k}")
        for k, (name, title) in enumerate(names.items())
    ]
    document = found.to_json(asked.places)
    rows, title = document["modes"], instance.title
    return Result(columns, rows, title, [note], schema="clearance", name="modes", head=document)
