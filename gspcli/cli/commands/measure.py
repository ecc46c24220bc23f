"""`gsp measure`: from poses to values."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.options import Command, load_instance, output_options
from gspcli.cli.pose_options import (
    ColumnOptions,
    GivenPose,
    PoseConventions,
    column_options,
    frame_note,
    one_mode,
    pose_options,
    pose_value_option,
    text_of,
    warn_of_range,
)
from gspcli.cli.render import Output, emit
from gspcli.cli.requirements import (
    judged,
    refuse,
    require_option,
    required,
    verdict_entries,
    verdict_lines,
)
from gspcli.cli.result import Field, Fields, Result
from gspcli.cli.streams import say
from gspcli.errors import GspError, IncompleteError
from gspcli.wording import counted

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from gspcli.geometry.instance import Instance
    from gspcli.motion import PoseTable

    Array = NDArray[np.float64]
    from gspcli.geometry.drives import Drives
    from gspcli.motion import PoseFormat
    from gspcli.motion.files.requirements import QuantityParts, Requirement
    from gspcli.motion.paths.nearest_poses import NearestPose

FIELDS = Fields("measure")


@click.command(cls=Command)
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
    text = name = ""
    if pose is None:
        text, name = text_of(str(poses))
        table = read_poses(text, name, form)
    else:
        R, T = pose.read(form)
        table = PoseTable(None, R[None], T[None])
    if cranks or drives:
        if cranks:
            emit_cranks(instance, table, output)
        else:
            emit_drives(instance, table, requirements, output)
        return
    if nearest:
        emit_nearest(instance, table, form, output)
        return
    values = measure(instance, table.R, table.T)
    _say_other_values(text, name, form, instance, values)
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


def _say_other_values(
    text: str, name: str, form: PoseFormat, instance: Instance, values: Array
) -> None:
    """Say on standard error that values beside poses, which are not used, contradict them."""
    from gspcli.motion.files.number_tables import NumberTable
    from gspcli.motion.files.value_files import compare_values

    if not text or text.lstrip()[:1] in "{[":
        return
    table = NumberTable(text, name, form.units.of(instance), form.ignore, form.columns)
    compare_values(table, instance, values)
    if table.mistakes:
        more = f" (and {len(table.mistakes) - 1} more)" if len(table.mistakes) > 1 else ""
        say(f"warning: {table.mistakes[0]}{more}: not used, the values are measured")


def _check_options(
    spec: str,
    poses: str | None,
    pose: GivenPose | None,
    kinds: tuple[bool, bool, bool],
    require: str | None,
) -> None:
    """Raise if the options contradict each other; `kinds` are --drives, --cranks and --nearest."""
    if (poses is None) == (pose is None):
        raise click.UsageError("give either POSES or --pose")
    if spec == poses == "-":
        raise click.UsageError("SPEC and POSES cannot both be standard input")
    drives, cranks, nearest = kinds
    if cranks and require is not None:
        raise click.UsageError("--require needs the values or --drives, not --cranks")
    if nearest and (cranks or drives or require is not None):
        raise click.UsageError(
            "--nearest gives the values of poses within the limits: leave out other options"
        )


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
    instance: Instance, rows: list[dict[str, Any]], more: list[Field], summary: list[str]
) -> Result:
    kinds = [constraint.kind.name for constraint in instance.constraints]
    columns = FIELDS.of("t")
    columns += [
        Field(str(k), f"{k} {name}", align="right", essential=True, aligned=True, size=size)
        for k, (name, size) in enumerate(zip(kinds, _sizes(instance), strict=True), 1)
    ]
    columns += more
    units = instance.units
    title = instance.title
    note = f"distances in {units.length}, angles in {units.angle.value}"
    if any(row["sides"] for row in rows):
        note += "; DPH and DHP signed, positive where the normal points"
    return Result(columns, rows, title=title, notes=[note], summary=summary)


#: A message names at most this many poses that are out of reach.
_TOLD = 3


def times_of(table: PoseTable) -> list[float]:
    """Return t of the poses, which are counted from 1 if the file has none."""
    times: list[float] = list(range(1, len(table.R) + 1)) if table.t is None else table.t.tolist()
    return times


def emit_cranks(instance: Instance, table: PoseTable, output: Output) -> None:
    """Write the angles of the cranks at poses."""
    from gspcli.motion import crank_angles, drive_values

    cranks, _ = crank_angles(instance, table.R, table.T)
    drives, q = drive_values(instance, table.R, table.T)
    _refuse_unreached(drives, q, table)
    names = [one.name for one in cranks]
    angles = drives.readings(q)[:, [drives.names.index(name) for name in names]].tolist()
    times = times_of(table)
    document = {
        "schema": "gsp.measure/1",
        **instance.to_json(),
        "cranks": names,
        "poses": [{"t": t, "angles": row} for t, row in zip(times, angles, strict=True)],
    }
    rows = _drive_rows(times, names, angles)
    note = f"angles in {instance.units.angle.value}, from where the points are stated"
    emit(output, _drive_table(instance, rows, names, [], [note], []), document=document)


def emit_drives(
    instance: Instance, table: PoseTable, requirements: Sequence[Requirement], output: Output
) -> None:
    """Write the numbers of all drives at poses, and their transmissions."""
    from gspcli.motion import drive_values

    drives, q = drive_values(instance, table.R, table.T)
    _refuse_unreached(drives, q, table)
    readings, times = drives.readings(q).tolist(), times_of(table)
    rows = _drive_rows(times, drives.names, readings)
    shown = []
    if drives.driven.any():
        share = drives.transmission(drives.gains(table.R, table.T, q))[:, drives.driven]
        for row, least in zip(rows, share.min(axis=1).tolist(), strict=True):
            row["transmission"] = least
        shown = FIELDS.of("transmission")
    gaps, known = add_gaps(instance, table.R, table.T, rows)
    verdicts, more = judged(instance, requirements, table.R, table.T, rows, known)
    more = [*gaps, *more]
    more = [column for column in more if column.key != "transmission"]
    document = None
    if output.format == "json":
        document = {
            "schema": "gsp.measure/1",
            **instance.to_json(),
            "drives": list(drives.names),
            "poses": [
                {
                    "t": t,
                    "numbers": numbers,
                    **{k: row[k] for k in row if k not in ("t", *drives.names)},
                }
                for t, numbers, row in zip(times, readings, rows, strict=True)
            ],
        }
        if verdicts:
            document["requirements"] = verdict_entries(
                verdicts, lambda k: {"row": k + 1, "t": times[k]}
            )
    units = instance.units
    notes = [f"lengths in {units.length}, angles in {units.angle.value}; cranks and slides from "]
    notes[0] += "where their points are stated"
    if shown:
        notes.append(
            "transmission: the least part of a motor's motion along its rod, 0 at a dead point"
        )
    lines = verdict_lines(verdicts, lambda k: f"in row {k + 1} (t = {times[k]:.6g})")
    made = _drive_table(instance, rows, list(drives.names), [*shown, *more], notes, lines)
    emit(output, made, document=document)
    refuse(verdicts)


def _refuse_unreached(drives: Drives, q: Array, table: PoseTable) -> None:
    """Raise if a rod does not reach a pose, or the rods of a carriage ask for two places."""
    import numpy as np

    missing = np.argwhere(np.isnan(q)).tolist()
    if not missing:
        return
    times = times_of(table)
    wanted = drives.wanted(table.R, table.T)
    lines = []
    for row, k in missing:
        users, name = drives.users(k), drives.names[k]
        numbers = wanted[row, users] / drives.units[k]
        where = f"the pose at t = {times[row]:.10g}"
        if np.isnan(numbers).any():
            rod = "leg" if len(users) == 1 else f"rod {users[int(np.isnan(numbers).argmax())] + 1}"
            lines.append(f"the {rod} of {name} does not reach {where}")
        else:
            rods = " and ".join(str(one + 1) for one in users)
            asked = " and ".join(f"{x:.6g}" for x in numbers)
            lines.append(f"rods {rods} ask for {asked} of {name} at {where}")
    more = [f"and at {len(lines) - _TOLD} more places"] if len(lines) > _TOLD + 1 else []
    raise GspError("\n".join(lines[:_TOLD] + more if more else lines))


def _drive_rows(
    times: Sequence[float], names: Sequence[str], numbers: Sequence[Sequence[float]]
) -> list[dict[str, Any]]:
    return [
        {"t": t, **dict(zip(names, row, strict=True))}
        for t, row in zip(times, numbers, strict=True)
    ]


def _drive_table(
    instance: Instance,
    rows: list[dict[str, Any]],
    names: Sequence[str],
    more: Sequence[Field],
    notes: list[str],
    summary: list[str],
) -> Result:
    columns = [
        Field(key, align="right", essential=True, aligned=key != "t") for key in ("t", *names)
    ]
    title = ": ".join(part for part in (instance.name, instance.type.id) if part)
    return Result([*columns, *more], rows, title=title, notes=notes, summary=summary)


def add_gaps(
    instance: Instance, R: Array, T: Array, rows: Sequence[dict[str, Any]]
) -> tuple[list[Field], dict[str, Array | QuantityParts]]:
    """Add to rows the least gap of each pose, and what it is between; nothing without shapes."""
    if instance.shapes is None:
        return [], {}
    from gspcli.motion.collisions.leg_gaps import gaps
    from gspcli.motion.files.requirements import QuantityParts

    found = gaps(instance, R, T)
    for row, said in zip(rows, found.to_json(), strict=True):
        row |= said
    columns = FIELDS.of("gap gap_between")
    return columns, {"gap": QuantityParts(found.values, found.pairs)}


_POSE = ("x", "y", "z", "qw", "qx", "qy", "qz")


def emit_nearest(instance: Instance, table: PoseTable, form: PoseFormat, output: Output) -> None:
    """Write the nearest pose to each pose of a table, from home and then from row to row."""
    from gspcli.motion.paths.nearest_poses import NearestPoses

    _, R, T = one_mode(instance, None)
    nearest = NearestPoses(instance, R[0], T[0], pivot=_pivot(form))
    found = list(nearest.along(table.R, table.T))
    times = times_of(table)
    columns = _columns(instance)
    rows = [_row(t, one, form, list(columns)) for t, one in zip(times, found, strict=True)]
    document = {"schema": "gsp.measure/1", **instance.to_json(), "poses": rows}
    emit(output, _nearest_table(instance, rows, form, columns), document=document)
    stays = [t for t, one in zip(times, found, strict=True) if not one.way]
    if stays:
        message = f"no way is proved to {counted(len(stays), 'row')}, first t = {stays[0]:.10g}"
        raise IncompleteError(f"{message}: the platform stays where it is")


def _pivot(form: PoseFormat) -> list[float] | None:
    """Return the point whose position the table gives, in the platform's frame; None: origin."""
    tool = form.frame.tool.shifted(form.pivot)
    return None if tool.T is None else tool.T.tolist()


def _columns(instance: Instance) -> dict[str, str]:
    """Return the keys and headings of what the motors are at."""
    from gspcli.geometry.drive_numbers import is_driven

    if is_driven(instance):
        from gspcli.geometry.drives import Drives

        return {name: name for name in Drives.of(instance).names}
    return {str(k): f"{k} {row.kind.name}" for k, row in enumerate(instance.constraints, 1)}


def _row(t: float, one: NearestPose, form: PoseFormat, names: list[str]) -> dict[str, Any]:
    from gspcli.geometry.quaternions import quaternion_from_rotation

    R, T = form.frame.from_platform(one.R, one.T)
    numbers = (*T.tolist(), *quaternion_from_rotation(R).tolist())
    return {
        "t": t,
        **dict(zip(names, one.values.tolist(), strict=True)),
        **dict(zip(_POSE, numbers, strict=True)),
        "shift": one.shift,
        "turn": one.turn,
        "limits": list(one.limits),
        "way": one.way or None,
    }


def _nearest_table(
    instance: Instance, rows: list[dict[str, Any]], form: PoseFormat, names: dict[str, str]
) -> Result:
    units = instance.units
    columns = [
        FIELDS["t"],
        *(
            Field(key, heading, align="right", minor=1, aligned=True)
            for key, heading in names.items()
        ),
        *(Field(key, align="right", essential=True, aligned=True) for key in _POSE),
        FIELDS["shift"].but(title=f"shift [{units.length}]"),
        FIELDS["turn"].but(title=f"turn [{units.angle.value}]"),
        FIELDS["limits"],
        FIELDS["way"],
    ]
    moved = sum(bool(row["limits"]) for row in rows)
    summary = f"{counted(moved, 'pose')} of {len(rows)} moved to the nearest one within the limits"
    notes = [
        "way: values, drives or poses change linearly from the row before, proved",
        *frame_note(form.frame),
    ]
    rows = [{**row, "limits": ", ".join(row["limits"])} for row in rows]
    return Result(columns, rows, title=instance.title, notes=notes, summary=[summary])
