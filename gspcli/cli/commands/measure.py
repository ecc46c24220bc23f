"""`gsp measure`: from poses to values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from gspcli.cli import pose_options
from gspcli.cli.options import Command, Options, option, output_options
from gspcli.cli.render import emit
from gspcli.cli.requirements import refuse, require_option, required, settled
from gspcli.cli.result import POSE, Field, Fields, Result
from gspcli.cli.streams import say
from gspcli.errors import CheckFailed, IncompleteError
from gspcli.wording import counted

if TYPE_CHECKING:
    from gspcli.geometry.instance import Array, Instance
    from gspcli.motion import PoseFormat, PoseTable
    from gspcli.motion.files.requirements import QuantityParts, RequirementVerdict

FIELDS = Fields("measure")
#: What stands for the limits of a nearest pose where none is found.
_NOT_FOUND = "none found"


@click.command(cls=Command)
@click.argument("spec", metavar="SPEC")
@click.argument("poses", metavar="[POSES]", required=False)
@pose_options.pose_value_option("instead of POSES")
@option("--drives", "The numbers of the drives: angles of cranks, places of slides, other values.")
@option("--nearest", "The nearest poses within ranges and cones, and their values.")
@pose_options.pose_options
@pose_options.column_options
@require_option("range, cone, clearance>=0.5, condition<=50")
@output_options()
def command(o: Options) -> None:
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

    --drives gives the places of the drives instead: the angle of each crank and the place of each
    slide, from where its point is stated. A constraint without either has its value. The rods keep
    the lengths of SPEC. If two angles or places reach the pose, the one on the side of home is
    taken; without a home, the one that is nearer to zero at the first pose. The column transmission
    is the least part of a drive's motion that acts along its rod. `gsp track` takes these columns.

    If SPEC states shapes of its legs, each row has the least gap between two of them, or
    between a leg and a body, and names the two. A negative gap is an overlap.

    --nearest gives the nearest pose that was found within all ranges and cones, with its values
    and the limits that it meets. For a machine with cranks or slides it gives the places of the
    drives. The platform is at home first, then where the row before is.
    The distance adds the squares of the shift and of the turn times the platform's size.

    A pose that the machine cannot take has a blank row, and the column refused says why: a rod
    does not reach it, two rods ask for different places of one carriage, or a value that no motor
    changes would not be the stated one.

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
    if (o.poses is None) == (o.pose is None):
        raise click.UsageError("give either POSES or --pose")
    if o.nearest and o.require is not None:
        raise click.UsageError("--require needs the values or --drives, not --nearest")
    from gspcli.motion import PoseTable, read_poses

    instance = o.instance
    requirements = required(o.require)
    form = o.form
    text = name = ""
    if o.pose is None:
        text, name = pose_options.text_of(str(o.poses))
        table = read_poses(text, name, form)
    else:
        R, T = o.pose.read(form)
        table = PoseTable(None, R[None], T[None])
    t = list(range(1, len(table.R) + 1)) if table.t is None else table.t.tolist()
    if o.nearest:
        result = _nearest(instance, table, t, form)
    elif o.drives:
        result = _motors(instance, table, t)
    else:
        values, result = _values(instance, table, t)
        pose_options.warn_of_values(text, name, form, instance, values)
    verdicts: list[RequirementVerdict] = []
    if not o.nearest:
        # Poses that are refused have no other numbers.
        reached = [k for k, row in enumerate(result.rows) if not row.get("refused")]
        places = [{"row": k + 1, "t": t[k]} for k in reached]
        part = replace(result, rows=[result.rows[k] for k in reached])
        R, T = table.R[reached], table.T[reached]
        part, known = _with_gaps(part, R, T)
        part, verdicts = settled(part, requirements, R, T, places, known)
        blank = dict.fromkeys(column.key for column in part.columns)
        rows = [blank | dict(row) for row in result.rows]
        for k, row in zip(reached, part.rows, strict=True):
            rows[k] = dict(row)
        result = replace(part, rows=rows)
    emit(o.output, result)
    if not (o.drives or o.nearest):
        pose_options.warn_of_range(instance, t, values)
    refuse(verdicts)
    _say_refused(result.rows, required=bool(requirements))
    missing = [row["t"] for row in result.rows if row.get("limits") == [_NOT_FOUND]]
    if missing:
        raise IncompleteError(
            f"no pose is found for {counted(len(missing), 'row')}, first t = {missing[0]:.10g}: "
            "the platform stays where it is"
        )


def _with_gaps(result: Result, R: Array, T: Array) -> tuple[Result, dict[str, QuantityParts]]:
    """Return a result with gaps between legs, if SPEC states their shapes; and these gaps."""
    if result.instance is None or result.instance.shapes is None:
        return result, {}
    from gspcli.motion.collisions.compared import gaps
    from gspcli.motion.files.requirements import QuantityParts

    found = gaps(result.instance, R, T)
    rows = [{**row, **gap} for row, gap in zip(result.rows, found.to_json(), strict=True)]
    columns = [*result.columns, *FIELDS.of("gap gap_between")]
    quantity = QuantityParts(found.values, found.pairs)
    return replace(result, columns=columns, rows=rows), {"gap": quantity}


def _say_refused(rows: Sequence[Mapping[str, Any]], *, required: bool) -> None:
    """Say on standard error how many poses are refused; raise if something is required."""
    if refused := [row for row in rows if row.get("refused")]:
        message = (
            f"{len(refused)} of {counted(len(rows), 'pose')} cannot be taken, first at "
            f"t = {refused[0]['t']:.10g}: {refused[0]['refused']}"
        )
        if required:
            raise CheckFailed(message)
        say(message)


def _values(instance: Instance, table: PoseTable, t: list[float]) -> tuple[Array, Result]:
    """Return the values of the constraints."""
    from gspcli.geometry.arrangement import Arrangement
    from gspcli.motion.poses.measured_values import measure

    units, values = instance.units, measure(instance, table.R, table.T)
    length, angle = Arrangement.of(instance).length, 1 / units.angle.in_radians
    columns, sided = FIELDS.of("t"), []
    for k, constraint in enumerate(instance.constraints, 1):
        size = length if constraint.kind.is_distance else angle
        title = f"{k} {constraint.kind.name}"
        columns.append(FIELDS[str(k)].but(title=title, within="values", size=size, essential=True))
        sided += [str(k)] if constraint.kind.has_sides else []
    rows: list[dict[str, Any]] = []
    for time, numbers in zip(t, values.tolist(), strict=True):
        row = {"t": time, **{str(k): x for k, x in enumerate(numbers, 1)}}
        rows.append(row | {"sides": {k: "negative" if row[k] < 0 else "positive" for k in sided}})
    note = f"distances in {units.length}, angles in {units.angle.value}"
    if sided:
        note += "; DPH and DHP signed, positive where the normal points"
    return values, _result(instance, columns, rows, [note])


def _result(
    instance: Instance,
    columns: list[Field],
    rows: list[dict[str, Any]],
    notes: list[str],
    summary: Sequence[str] = (),
    **head: Any,
) -> Result:
    title = instance.title
    return Result(columns, rows, title, notes, summary, "", instance, "measure", "poses", head)


def _motors(instance: Instance, table: PoseTable, t: list[float]) -> Result:
    """Return the numbers of the drives and their transmissions."""
    from gspcli.motion import drive_values
    from gspcli.motion.poses.inverse_kinematics import refusals

    drives, q = drive_values(instance, table.R, table.T)
    refused = refusals(drives, table.R, table.T, q)
    names = drives.names
    columns = [
        *FIELDS.of("t"),
        *(FIELDS["crank.*"].but(key=name, within="numbers") for name in names),
    ]
    rows: list[dict[str, Any]] = [
        {"t": time, **dict(zip(names, numbers, strict=True))}
        for time, numbers in zip(t, drives.readings(q).tolist(), strict=True)
    ]
    for k, one in enumerate(rows if refused else []):
        one["refused"] = refused.get(k)
        if k in refused:
            one |= dict.fromkeys(names)
    more = FIELDS.of("refused") if refused else []
    units = instance.units
    notes = [
        f"lengths in {units.length}, angles in {units.angle.value}; cranks and slides from where "
        "their points are stated"
    ]
    if drives.driven.any():
        columns.append(FIELDS["transmission"])
        notes.append(
            "transmission: the least part of a drive's motion along its rod, 0 at a dead point"
        )
        share = drives.transmission(drives.gains(table.R, table.T, q))[:, drives.driven]
        for k, least in enumerate(share.min(axis=1).tolist()):
            rows[k]["transmission"] = None if k in refused else least
    return _result(instance, [*columns, *more], rows, notes, drives=list(names))


def _nearest(instance: Instance, table: PoseTable, t: list[float], form: PoseFormat) -> Result:
    """Return the nearest pose to each pose of a table, from home and then from row to row."""
    from gspcli.geometry.machine import Machine
    from gspcli.geometry.quaternions import quaternion_from_rotation
    from gspcli.motion.paths.nearest_poses import NearestPoses

    _, R, T = pose_options.one_mode(instance, None)
    tool = form.frame.tool.shifted(form.pivot).T
    pivot = None if tool is None else tool.tolist()
    machine, kinds = Machine.of(instance), [row.kind.name for row in instance.constraints]
    names = {
        name: name if machine.moved[k] else f"{name} {kinds[machine.first[k]]}"
        for k, name in enumerate(machine.names)
    }
    rows: list[dict[str, Any]] = []
    found = NearestPoses(instance, R[0], T[0], pivot=pivot).along(table.R, table.T)
    for time, one in zip(t, found, strict=True):
        R, T = form.frame.from_platform(one.R, one.T)
        numbers = [*one.values.tolist(), *T.tolist(), *quaternion_from_rotation(R).tolist()]
        row = {"t": time, **dict(zip((*names, *POSE), numbers, strict=True))}
        rows.append(row | {"shift": one.shift, "turn": one.turn, "limits": [*one.limits]})
    columns = [
        *FIELDS.of("t"),
        *(FIELDS["1…6"].but(key=key, title=said, minor=1) for key, said in names.items()),
        *FIELDS.of(" ".join(POSE)),
        FIELDS["shift"].but(title=f"shift [{instance.units.length}]"),
        FIELDS["turn"].but(title=f"turn [{instance.units.angle.value}]"),
        FIELDS["limits"],
    ]
    moved = sum(bool(row["limits"]) for row in rows)
    summary = f"{counted(moved, 'pose')} of {len(rows)} moved to the nearest one within the limits"
    return _result(instance, columns, rows, [*pose_options.frame_note(form.frame)], [summary])
