"""`gsp clearance`: how far values or poses may change before a mode can meet a singularity."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.options import (
    HOME,
    Command,
    Options,
    exclusive,
    output_options,
    value_options,
)
from gspcli.cli.pose_options import (
    asked_poses,
    column_options,
    mode_option,
    near_option,
    pose_options,
    pose_value_option,
)
from gspcli.cli.render import emit
from gspcli.cli.result import Field, Fields, Result
from gspcli.cli.streams import progress
from gspcli.errors import GspError

if TYPE_CHECKING:
    from gspcli.geometry.instance import Instance

FIELDS = Fields("clearance")


@click.command(cls=Command)
@exclusive("--mode", "--pose", "--near")
@exclusive("ROWS", "--pose")
@exclusive("--all-modes", "--mode")
@exclusive("--all-modes", "--pose")
@click.argument("spec", metavar="SPEC")
@click.argument("rows", metavar="[ROWS]", required=False)
@mode_option("only this one; also along a file of values.  [default: home]")
@click.option("--all-modes", is_flag=True, help="All real poses: not home only.")
@pose_value_option("instead of the modes of SPEC")
@near_option("of a file of values only this one is followed")
@value_options
@pose_options
@column_options
@click.option(
    "--of",
    type=click.Choice(["values", "drives", "pose"]),
    help="What changes.  [default: drives if cranks or slides move points, else values]",
)
@click.option(
    "--points",
    metavar="X,Y,Z;...",
    help="With --of pose: the points of the platform, in its frame, whose displacements count.  "
    "[default: those of the distances]",
)
@click.option("--refine", is_flag=True, help="Better bounds: a few seconds for each mode.")
@output_options()
def command(o: Options) -> None:
    """Bound how far values, or the pose, may change before a mode meets a singularity.

    A clearance of r means: if every value changes by at most r times its weight, all at once and in
    any combination, the mode exists all the while and is not singular. The weight is half the range
    of the constraint, if each has one in SPEC; else 1 in the unit of the value.

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
    working modes. The nearest fold and the nearest dead point that were found are shown; they are
    not proved.

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
    if o.near is not None and o.rows is None:
        raise click.UsageError("--near says which mode to follow: give it with ROWS")
    if o.rows is None and o.pose is None and not o.all_modes:
        o.mode = o.mode or HOME
    if o.points is not None and o.of != "pose":
        raise click.UsageError("--points needs --of pose")
    from gspcli.motion.singularities.clearances import clearance, range_weights

    instance = o.instance
    chosen = None if o.points is None else _points(o.points)
    asked = asked_poses(instance, o.rows, o.mode, o.pose, o.near, o.form)
    found = clearance(
        instance, asked.R, asked.T, of=o.of, points=chosen, refine=o.refine, progress=progress
    )
    document = found.to_json([asked.named(k) for k in range(len(asked.T))])
    if found.of == "drives":
        emit(o.output, _drive_table(instance, document["modes"]), document=document)
    else:
        unit = _unit(instance, found.of, ranged=range_weights(instance) is not None)
        emit(o.output, _table(instance, document["modes"], found.of, unit), document=document)
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


def _unit(instance: Instance, of: str, *, ranged: bool) -> str:
    units = instance.units
    if of == "pose":
        return f"{units.length}, root mean squares of the displacements of points"
    if ranged:
        return "units of half the range of each value"
    return f"units of 1 {units.length} for distances, 1 {units.angle.value} for angles"


def _drive_table(instance: Instance, rows: list[dict[str, Any]]) -> Result:
    from gspcli.geometry.machine import Machine
    from gspcli.motion.singularities.clearances import drive_weights

    names, units = Machine.of(instance).names, instance.units
    columns = [
        *_name_columns(rows),
        *FIELDS.of("lower working_modes upper dead_point drive"),
        *(Field(name, align="right") for name in names),
    ]
    what = f"1 {units.angle.value} for cranks, 1 {units.length} for slides"
    if drive_weights(instance)[1]:
        what = "half the range of each drive"
    note = f"changes of all drives, in units of {what}; last columns: the drives at the fold"
    shown = [
        {key: value for key, value in row.items() if key not in ("drives", "R", "T")}
        | dict(zip(names, row["drives"] or (), strict=False))
        for row in rows
    ]
    return Result(columns, shown, title=instance.title, notes=[note])


def _name_columns(rows: list[dict[str, Any]]) -> list[Field]:
    names = [key for key in ("row", "t", "mode") if any(row.get(key) is not None for row in rows)]
    return [Field(key, align="right", essential=True) for key in names or ("mode",)]


def _table(instance: Instance, rows: list[dict[str, Any]], of: str, unit: str) -> Result:
    columns = [
        *_name_columns(rows),
        FIELDS["lower@2"],
        FIELDS["upper@2"].but(title="singular at" if of == "pose" else "ends at"),
        FIELDS["ratio"],
    ]
    columns.append(FIELDS["by"])
    if of == "values":
        columns.append(FIELDS["constraint"])
    columns += [
        Field(str(k), f"{k} {constraint.kind.name}", align="right")
        for k, constraint in enumerate(instance.constraints, 1)
    ]
    note = f"clearances in {unit}; last columns: the values "
    note += "of the nearest singular pose found" if of == "pose" else "where the mode ends"
    return Result(columns, [_shown(row) for row in rows], title=instance.title, notes=[note])


def _shown(row: dict[str, Any]) -> dict[str, Any]:
    """Return a row of the table."""
    values = {str(k): value for k, value in enumerate(row["values"] or (), 1)}
    return {key: value for key, value in row.items() if key not in ("values", "R", "T")} | values
