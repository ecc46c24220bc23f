"""`gsp measure`: from poses to values."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.names import load_instance
from gspcli.cli.output import Column, Output, Table, emit, output_options
from gspcli.cli.pose_options import ignore_option, pose_format, pose_options, text_of, warn_of_range
from gspcli.cli.pose_type import GivenPose, pose_value_option
from gspcli.cli.requirements import (
    judged,
    refuse,
    require_option,
    required,
    verdict_entries,
    verdict_lines,
)
from gspcli.errors import GspError

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
    "--cranks",
    is_flag=True,
    help="The angles of the cranks instead; the values of SPEC are kept.",
)
@pose_options
@ignore_option
@require_option("range, cone, clearance>=0.5, condition<=50")
@output_options()
def command(
    spec: str,
    poses: str | None,
    pose: GivenPose | None,
    cranks: bool,
    euler: str | None,
    pivot: str | None,
    ignore: tuple[str, ...],
    require: str | None,
    output: Output,
) -> None:
    """Measure the values of constraints at given poses (inverse kinematics).

    SPEC is an instance file, POSES a CSV file with a heading, or what `gsp solve --format json`
    prints; one of them may be - for standard input. Columns of POSES: x, y, z and one of
    qw, qx, qy, qz (a quaternion of any length), rx, ry, rz (with --euler, in the angle unit of
    SPEC) or r11 ... r33 (by rows), for x_base = R x_platform + T; and perhaps t. Headings of other
    programs are read where they have one meaning: X [mm], Roll, Pitch, Yaw, Time; and decimals with
    a comma between semicolons. A column that is not known is a mistake; --ignore leaves it out.

    Each pose is one row with the distances and angles in the units and the order of SPEC. Distances
    to planes (DPH, DHP) are signed: positive on the side to which the normal points. The values of
    SPEC itself are not used.

    With --cranks the columns are the angles of the cranks that turn points of SPEC (rotary
    hexapods), each from where the point is stated, in its angle unit; the values of SPEC are kept.
    Of two angles the one is taken that is nearer to that of the pose before, first to zero.
    `gsp track` takes these columns.

    With --require the worst row is named, and the exit code is 1 unless all rows keep it: range (as
    the share that a value takes of its range, 1 at its ends), cone (likewise), condition, clearance
    and pose-clearance, which become columns.

    \b
    Examples:
      gsp measure platform.yaml poses.csv -o values.csv
      gsp measure platform.yaml path.csv --euler ZYX --pivot 0,0,-12.5
      gsp measure platform.yaml path.csv --euler ZYX --ignore "motor *"
      gsp measure platform.yaml --pose 0,0,1.5,1,0,0,0
      gsp measure platform.yaml path.csv --require "range, cone, condition<=50"
      gsp solve platform.yaml --format json | gsp measure platform.yaml -
      gsp measure rotary.yaml poses.csv --cranks -o angles.csv
    """
    if (poses is None) == (pose is None):
        message = "give either POSES or --pose"
        raise click.UsageError(message)
    if spec == poses == "-":
        message = "SPEC and POSES cannot both be standard input"
        raise click.UsageError(message)
    if cranks and require is not None:
        message = "--require needs the values, not --cranks"
        raise click.UsageError(message)
    from gspcli.motion import PoseTable, read_poses
    from gspcli.motion.poses.measured_values import measure

    instance = load_instance(spec)
    requirements = required(require)
    form = pose_format(instance, euler, pivot, ignore)
    if pose is None:
        table = read_poses(*text_of(str(poses)), form)
    else:
        R, T = pose.read(form)
        table = PoseTable(None, R[None], T[None])
    if cranks:
        _emit_cranks(instance, table, output)
        return
    values = measure(instance, table.R, table.T)
    rows = _rows(instance, table, values.tolist())
    verdicts, more = judged(instance, requirements, table.R, table.T, rows)
    times = _times(table)
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


def _emit_cranks(instance: Instance, table: PoseTable, output: Output) -> None:
    """Write the angles of the cranks at poses.

    Raises
    ------
    GspError
        If a pose is out of reach.
    """
    import numpy as np

    from gspcli.motion import crank_angles

    cranks, angles = crank_angles(instance, table.R, table.T)
    times = _times(table)
    missing = [
        f"the leg of {cranks[k].name} does not reach the pose at t = {times[row]:.10g}"
        for row, k in np.argwhere(np.isnan(angles)).tolist()
    ]
    if missing:
        raise GspError("\n".join(missing))
    names = [one.name for one in cranks]
    rows = [
        {"t": t, **dict(zip(names, row, strict=True))}
        for t, row in zip(times, angles.tolist(), strict=True)
    ]
    columns = [
        Column(key, align="right", essential=True, aligned=key != "t") for key in ("t", *names)
    ]
    title = ": ".join(part for part in (instance.name, instance.type.id) if part)
    note = f"angles in {instance.units.angle.value}, from where the points are stated"
    document = {
        "schema": "gsp.measure/1",
        **instance.to_json(),
        "cranks": names,
        "poses": [{"t": t, "angles": row} for t, row in zip(times, angles.tolist(), strict=True)],
    }
    emit(output, Table(columns, rows, title=title, notes=[note]), document=document)


def _times(table: PoseTable) -> list[float]:
    """Return t of the poses, which are counted from 1 if the file has none."""
    times: list[float] = list(range(1, len(table.R) + 1)) if table.t is None else table.t.tolist()
    return times


def _rows(instance: Instance, table: PoseTable, values: list[list[float]]) -> list[dict[str, Any]]:
    """Return a row for each pose."""
    sided = [k for k, row in enumerate(instance.constraints, 1) if row.kind.has_sides]
    rows = []
    for t, row in zip(_times(table), values, strict=True):
        named = {str(k): value for k, value in enumerate(row, 1)}
        sides = {str(k): "negative" if row[k - 1] < 0 else "positive" for k in sided}
        rows.append({"t": t, **named, "sides": sides})
    return rows


def _table(
    instance: Instance, rows: list[dict[str, Any]], more: list[Column], summary: list[str]
) -> Table:
    kinds = [constraint.kind.name for constraint in instance.constraints]
    columns = [Column("t", align="right", essential=True)]
    columns += [
        Column(str(k), f"{k} {name}", align="right", essential=True, aligned=True)
        for k, name in enumerate(kinds, 1)
    ]
    columns += more
    units = instance.units
    title = instance.title
    note = f"distances in {units.length}, angles in {units.angle.value}"
    if any(row["sides"] for row in rows):
        note += "; DPH and DHP signed, positive where the normal points"
    return Table(columns, rows, title=title, notes=[note], summary=summary)
