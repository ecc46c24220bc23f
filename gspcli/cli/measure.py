"""`gsp measure`: from poses to values."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.drive_rows import times_of
from gspcli.cli.gap_columns import add_gaps
from gspcli.cli.names import load_instance
from gspcli.cli.output import Column, Output, Table, emit, output_options
from gspcli.cli.pose_options import (
    ColumnOptions,
    PoseConventions,
    column_options,
    pose_options,
    text_of,
    warn_of_range,
)
from gspcli.cli.pose_type import GivenPose, pose_value_option
from gspcli.cli.requirements import (
    judged,
    refuse,
    require_option,
    required,
    verdict_entries,
    verdict_lines,
)

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from gspcli.geometry.instance import Instance
    from gspcli.motion import PoseTable

    Array = NDArray[np.float64]


@click.command()
@click.argument("spec", metavar="SPEC")
@click.argument("poses", metavar="[POSES]", required=False)
@pose_value_option("instead of POSES")
@click.option(
    "--drives",
    is_flag=True,
    help="The numbers of the motors: angles of cranks, places of slides, other values.",
)
@click.option(
    "--cranks",
    is_flag=True,
    help="The angles of the cranks only; the values of SPEC are kept.",
)
@click.option(
    "--nearest",
    is_flag=True,
    help="The nearest poses within ranges and cones, and their values.",
)
@pose_options
@column_options
@require_option("range, cone, clearance>=0.5, condition<=50")
@output_options()
def command(
    spec: str,
    poses: str | None,
    pose: GivenPose | None,
    drives: bool,
    cranks: bool,
    nearest: bool,
    conventions: PoseConventions,
    columns: ColumnOptions,
    require: str | None,
    output: Output,
) -> None:
    """Measure the values of constraints at given poses (inverse kinematics).

    Each pose gives one row: the distances and angles of SPEC, in its units and order. Distances
    to planes (DPH, DHP) are signed: positive on the side to which the normal points. The values
    that SPEC states are not used.

    SPEC is an instance file, POSES a CSV file with a heading, or what `gsp solve --format json`
    prints; one of them may be - for standard input. Columns of POSES are x, y, z, a rotation
    and perhaps t, for x_base = R x_platform + T. The rotation is qw, qx, qy, qz (a quaternion
    of any length), rx, ry, rz (with --euler, in the angle unit of SPEC) or r11 ... r33 (by
    rows). Headings of other programs are read where they have one meaning: X [mm], Roll, Pitch,
    Yaw, Time. Decimals may have a comma if columns are separated by semicolons. An unknown
    column is a mistake; --ignore leaves it out.

    --drives gives the places of the motors instead: the angle of each crank and the place of each
    slide, from where its point is stated. A constraint without a motor has its value. The rods keep
    the lengths of SPEC. If two angles or places reach the pose, the one on the side of home is
    taken; without a home, the one that is nearer to zero at the first pose. The column transmission
    is the least part of a motor's motion that acts along its rod. `gsp track` takes these columns.
    --cranks gives the cranks only.

    If SPEC states shapes of its legs, each row has the least gap between two of them, or
    between a leg and a body, and names the two. A negative gap is an overlap.

    --nearest gives the nearest pose that was found within all ranges and cones, with its values
    and the limits that it meets. For a machine with cranks or slides it gives the places of the
    motors. The platform goes there from home, then from row to row. The pose is proved to keep
    the limits, and so is a straight way to it, without a singular pose. If no such way leads to
    the nearest pose, the platform goes as far as one does: limits has "no way farther".
    The distance adds the squares of the shift and of the turn times the platform's size.

    --require names the worst row of each requirement, and the exit code is 1 unless all rows keep
    all of them. For range and cone the number is a share: 1 is the end of a range or the edge of a
    cone. condition, transmission (of cranks and slides), gap, clearance and pose-clearance can be
    required, too. Each becomes a column.

    \b
    Examples:
      gsp measure platform.yaml poses.csv -o values.csv
      gsp measure platform.yaml path.csv --euler ZYX --pivot 0,0,-12.5
      gsp measure platform.yaml path.csv --euler ZYX --ignore "motor *"
      gsp measure platform.yaml --pose 0,0,1.5,1,0,0,0
      gsp measure platform.yaml path.csv --require "range, cone, condition<=50"
      gsp solve platform.yaml --format json | gsp measure platform.yaml -
      gsp measure rotary.yaml poses.csv --drives -o angles.csv
      gsp measure rotary.yaml poses.csv --drives --require "transmission>=0.3"
      gsp measure machine.yaml --pose 0,0,200,1,0,0,0 --nearest
      gsp measure thick.yaml poses.csv --require "gap>=2"
    """
    _check_options(spec, poses, pose, (drives, cranks, nearest), require)
    from gspcli.motion import PoseTable, read_poses
    from gspcli.motion.poses.measured_values import measure

    instance = load_instance(spec)
    requirements = required(require)
    form = conventions.form(instance, columns)
    if pose is None:
        table = read_poses(*text_of(str(poses)), form)
    else:
        R, T = pose.read(form)
        table = PoseTable(None, R[None], T[None])
    if cranks or drives:
        from gspcli.cli.drive_rows import emit_cranks, emit_drives

        if cranks:
            emit_cranks(instance, table, output)
        else:
            emit_drives(instance, table, requirements, output)
        return
    if nearest:
        from gspcli.cli.nearest_rows import emit_nearest

        emit_nearest(instance, table, form, output)
        return
    values = measure(instance, table.R, table.T)
    rows = _rows(instance, table, values.tolist())
    gaps, known = add_gaps(instance, table.R, table.T, rows)
    verdicts, more = judged(instance, requirements, table.R, table.T, rows, known)
    more = [*gaps, *more]
    times = times_of(table)
    document = None
    if output.format == "json":
        document = values.to_json(times)
        for pose_, row in zip(document["poses"], rows, strict=True):
            pose_ |= {column.key: row[column.key] for column in more}
        if verdicts:
            document["requirements"] = verdict_entries(
                verdicts, lambda k: {"row": k + 1, "t": times[k]}
            )
    lines = verdict_lines(verdicts, lambda k: f"in row {k + 1} (t = {times[k]:.6g})")
    emit(output, _table(instance, rows, more, lines), document=document)
    warn_of_range(instance, times, values)
    refuse(verdicts)


def _check_options(
    spec: str,
    poses: str | None,
    pose: GivenPose | None,
    kinds: tuple[bool, bool, bool],
    require: str | None,
) -> None:
    """Raise if the options contradict each other; `kinds` are --drives, --cranks and --nearest."""
    if (poses is None) == (pose is None):
        message = "give either POSES or --pose"
        raise click.UsageError(message)
    if spec == poses == "-":
        message = "SPEC and POSES cannot both be standard input"
        raise click.UsageError(message)
    drives, cranks, nearest = kinds
    if cranks and require is not None:
        message = "--require needs the values or --drives, not --cranks"
        raise click.UsageError(message)
    if nearest and (cranks or drives or require is not None):
        message = "--nearest gives the values of poses within the limits: leave out other options"
        raise click.UsageError(message)


def _rows(instance: Instance, table: PoseTable, values: list[list[float]]) -> list[dict[str, Any]]:
    """Return a row for each pose."""
    sided = [k for k, row in enumerate(instance.constraints, 1) if row.kind.has_sides]
    rows = []
    for t, row in zip(times_of(table), values, strict=True):
        named = {str(k): value for k, value in enumerate(row, 1)}
        sides = {str(k): "negative" if row[k - 1] < 0 else "positive" for k in sided}
        rows.append({"t": t, **named, "sides": sides})
    return rows


def _sizes(instance: Instance) -> list[float]:
    """Return typical sizes of the values: lengths of the platform, and a radian."""
    from gspcli.geometry.arrangement import Arrangement

    length, angle = Arrangement.of(instance).length, 1 / instance.units.angle.in_radians
    return [length if row.kind.is_distance else angle for row in instance.constraints]


def _table(
    instance: Instance, rows: list[dict[str, Any]], more: list[Column], summary: list[str]
) -> Table:
    kinds = [constraint.kind.name for constraint in instance.constraints]
    columns = [Column("t", align="right", essential=True)]
    columns += [
        Column(str(k), f"{k} {name}", align="right", essential=True, aligned=True, size=size)
        for k, (name, size) in enumerate(zip(kinds, _sizes(instance), strict=True), 1)
    ]
    columns += more
    units = instance.units
    title = instance.title
    note = f"distances in {units.length}, angles in {units.angle.value}"
    if any(row["sides"] for row in rows):
        note += "; DPH and DHP signed, positive where the normal points"
    return Table(columns, rows, title=title, notes=[note], summary=summary)
