"""`gsp analyze`: what a platform does at a pose: screws, Jacobian matrix, forces, accuracy."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.analysis_tables import details, drives_table, overview
from gspcli.cli.mode_option import HOME, Mode, mode_option
from gspcli.cli.names import load_instance
from gspcli.cli.number_types import Positive
from gspcli.cli.output import Output, emit, output_options
from gspcli.cli.pose_options import ColumnOptions, PoseConventions, column_options, pose_options
from gspcli.cli.pose_rows import asked_poses, check_sources
from gspcli.cli.pose_type import GivenPose, near_option, pose_value_option
from gspcli.cli.requirements import (
    judged,
    refuse,
    require_option,
    required,
    verdict_entries,
    verdict_lines,
)
from gspcli.cli.value_options import Changes, value_options
from gspcli.errors import GspError

if TYPE_CHECKING:
    from gspcli.cli.pose_rows import AskedPoses
    from gspcli.dynamics.analyses import Analysis
    from gspcli.geometry.instance import Instance

#: Formats for people.
_READABLE = ("table", "markdown", "latex")
_ZERO = 1e-12


@click.command()
@click.argument("spec", metavar="SPEC")
@click.argument("rows", metavar="[ROWS]", required=False)
@mode_option("only this one, in detail; also along a file of values.")
@pose_value_option("instead of the modes of SPEC")
@near_option("of a file of values only this one is followed")
@value_options
@pose_options
@column_options
@click.option(
    "--point",
    metavar="X,Y,Z",
    help="The point of the base about which twists and wrenches are taken.  [default: the mean of "
    "the platform's points]",
)
@click.option(
    "--length",
    type=Positive(),
    metavar="LENGTH",
    help="The length that makes angles and lengths comparable.  [default: the typical length]",
)
@click.option(
    "--load",
    metavar="FX,FY,FZ[,MX,MY,MZ][@X,Y,Z]",
    help="A force and moment on the platform, in the axes of the base, at a point of the base.",
)
@click.option(
    "--stiffness",
    metavar="K",
    help="Stiffness of the constraints, one number or six: in the unit of force of --load per unit "
    "of length of SPEC, such as N/mm, for angles moment per radian. gsp dynamics takes N/m.  "
    "[default: that of the drives in SPEC]",
)
@click.option("--tolerance", metavar="D", help="How far each value may be off: one number or six.")
@click.option(
    "--geometry-tolerance",
    metavar="D[,A]",
    help="How far each coordinate of each primitive may be off, and how far each direction may be "
    "turned.",
)
@require_option("range, cone, condition<=50, clearance>=0.5, force<=200")
@output_options(
    parts=("wrenches", "drives", "jacobian", "inverse", "stiffness", "errors", "geometry")
)
def command(
    spec: str,
    changes: Changes,
    rows: str | None,
    mode: Mode | None,
    pose: GivenPose | None,
    near: GivenPose | None,
    conventions: PoseConventions,
    columns: ColumnOptions,
    point: str | None,
    length: float | None,
    load: str | None,
    stiffness: str | None,
    tolerance: str | None,
    geometry_tolerance: str | None,
    require: str | None,
    output: Output,
) -> None:
    """Analyze assembly modes: screws, Jacobian matrix, forces, stiffness and accuracy.

    Without options there is one line for each real pose of SPEC. ROWS gives one line for each
    of its rows instead. It is a file of poses as `gsp measure` takes it, or a file of values as
    `gsp track` takes it, along which the modes are followed. Poses of files and --pose need not
    be modes of SPEC.

    One pose is shown in detail: that of --mode or --pose, or home with --part. A table has the
    wrench of each constraint: a force along an axis with a pitch, or a couple for angles.
    Others have the Jacobian matrix, the derivatives of the values by a twist, and its inverse.
    A twist is a rotation in radians about the axes through the point, and the velocity of the
    point. Below are the singular values and the manipulability of the matrix, its lengths
    divided by the stated length, and the condition number of `gsp solve`. With cranks or slides
    in SPEC their places are shown, and their transmission: the part of their motion that acts
    along their rods.

    --load gives the forces in the constraints that balance it, moments for angles, and the
    torques of cranks and forces of slides. A positive force pushes towards a greater value.
    --stiffness gives the stiffness of the platform. --tolerance, or tolerance: in SPEC, gives
    the largest errors of the pose, exact to first order, a proved bound that includes second
    order, and root mean squares for independent errors. --geometry-tolerance gives the errors
    that inaccurate points, lines and planes cause, largest and root mean square, exact to first
    order. Where there are many poses each of these is one column: the largest force, the least
    stiffness of the point, its largest errors.

    --require names the worst row of each requirement, and the exit code is 1 unless all rows keep
    all of them. Without further options the names are range, cone, condition, clearance and
    pose-clearance. transmission needs cranks or slides, force, moment and torque need --load,
    stiffness needs --stiffness, and error needs --tolerance.

    \b
    Examples:
      gsp analyze platform.yaml
      gsp analyze platform.yaml --mode home --load 0,0,-100@0,0,250 \\
        --tolerance 0.01
      gsp analyze platform.yaml --pose 0,0,1.5,1,0,0,0 --stiffness 2e6
      gsp analyze platform.yaml path.csv --load 0,0,-9 --require "force<=20"
    """
    check_sources(spec, rows, mode, pose, near)
    if output.part is not None and rows is None and pose is None:
        # Parts are of one pose.
        mode = mode or HOME
    instance = load_instance(spec, changes)
    requirements = required(require)
    asked = asked_poses(instance, rows, mode, pose, near, conventions.form(instance, columns))
    analysis = _analysis(
        instance, asked, load, stiffness, tolerance, geometry_tolerance, point, length
    )
    given = analysis.given
    names = [asked.named(k) for k in range(len(asked.T))]
    detailed = rows is None and (mode is not None or pose is not None)
    document = None
    if output.format == "json":
        document = analysis.to_json(names)
        entries = document["poses"]
    else:
        # Matrices of many poses fill the memory, and a table of poses has none.
        wanted = analysis.entry if detailed else analysis.brief
        entries = [{**name, **wanted(k)} for k, name in enumerate(names)]
    known = analysis.quantities() if requirements else None
    statics = analysis.statics
    verdicts, more = judged(instance, requirements, given.R, given.T, entries, known)
    more = [column for column in more if column.key != "transmission"]
    tables = details(entries[0], given) if detailed else [overview(entries, given, more)]
    if statics is not None and detailed:
        tables.insert(1, drives_table(entries[0], statics.drives))
    if output.format in _READABLE:
        tables = [replace(table, rows=[_tidy(row) for row in table.rows]) for table in tables]
    if verdicts:
        tables[0] = replace(tables[0], summary=verdict_lines(verdicts, asked.place))
    if document is not None and verdicts:
        document["requirements"] = verdict_entries(verdicts, asked.named)
    emit(output, tables, document=document)
    refuse(verdicts)
    asked.check()


def _analysis(
    instance: Instance,
    asked: AskedPoses,
    load: str | None,
    stiffness: str | None,
    tolerance: str | None,
    geometry_tolerance: str | None,
    point: str | None,
    length: float | None,
) -> Analysis:
    """Return what the options ask for."""
    from gspcli.dynamics.analyses import analyze

    force, at = (None, None) if load is None else _load(load)
    return analyze(
        instance,
        asked.R,
        asked.T,
        load=force,
        at=at,
        stiffness=_given(stiffness, (1, 6), "--stiffness"),
        tolerance=_given(tolerance, (1, 6), "--tolerance"),
        geometry_tolerance=_geometry(geometry_tolerance),
        point=_given(point, (3,), "--point"),
        length=length,
        drives=asked.stated_drives(instance),
    )


def _tidy(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row for people, in which rounding errors about zero are zero."""
    return {
        key: 0.0 if isinstance(value, float) and abs(value) < _ZERO else value
        for key, value in row.items()
    }


def _given(text: str | None, counts: tuple[int, ...], option: str) -> list[float] | None:
    """Return the numbers of an option, or None without it."""
    if text is None:
        return None
    from gspcli.motion.files.number_tables import numbers_of

    return numbers_of(text, counts, option)


def _load(text: str) -> tuple[list[float] | None, list[float] | None]:
    """Return a force with its moment, and where it acts or None."""
    wrench, _, where = re.sub(r"\s", "", text).partition("@")
    return _given(wrench, (3, 6), "--load"), _given(where or None, (3,), "--load")


def _geometry(text: str | None) -> list[float] | None:
    numbers = _given(text, (1, 2), "--geometry-tolerance")
    if numbers is not None and min(numbers) < 0:
        message = f"--geometry-tolerance: found {text}, expected numbers of at least 0"
        raise GspError(message)
    return numbers
