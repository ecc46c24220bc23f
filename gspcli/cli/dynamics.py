"""`gsp dynamics`: forces of the drives, motions under forces, natural frequencies."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import click

from gspcli.cli.dynamics_rows import AskedMotion, asked_rows, start_of
from gspcli.cli.dynamics_tables import (
    force_rows,
    force_table,
    mode_rows,
    mode_tables,
    motion_table,
)
from gspcli.cli.mode_option import Mode, mode_option
from gspcli.cli.names import load_instance
from gspcli.cli.output import Column, Output, Table, emit, output_options
from gspcli.cli.pose_options import (
    ColumnOptions,
    PoseConventions,
    column_options,
    pose_options,
    text_of,
)
from gspcli.cli.pose_rows import check_sources
from gspcli.cli.pose_type import GivenPose, near_option, pose_value_option
from gspcli.cli.progress_bars import working
from gspcli.cli.requirements import (
    judged,
    refuse,
    require_option,
    required,
    verdict_entries,
    verdict_lines,
)
from gspcli.cli.value_options import Changes, value_options
from gspcli.errors import GspError, IncompleteError
from gspcli.wording import listed

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from typing import Any

    import numpy as np
    from numpy.typing import NDArray

    from gspcli.dynamics import DriveForces, NaturalModes
    from gspcli.geometry.instance import Instance
    from gspcli.motion import PoseFormat
    from gspcli.motion.files.requirements import QuantityParts, Requirement, RequirementVerdict

    Array = NDArray[np.float64]

#: A message names at most this many rows.
_MOST_NAMED = 5


@click.command()
@click.argument("spec", metavar="SPEC")
@click.argument("rows", metavar="[ROWS]", required=False)
@mode_option("only this one; also along a file of values.  [default: home, all without ROWS]")
@pose_value_option("instead of the modes of SPEC")
@near_option("of a file of values only this one is followed")
@value_options
@pose_options
@column_options
@click.option(
    "--forward",
    metavar="FORCES",
    help="How the platform moves under forces: a file with t and F1 ... F6 (with cranks or slides "
    "torque.crank.B1 ...), linear between rows.",
)
@click.option(
    "--twist",
    metavar="NUMBERS",
    help="Its velocity at the start: wx,wy,wz,vx,vy,vz.  [default: at rest]",
)
@click.option("--modes", "modal", is_flag=True, help="Natural frequencies and mode shapes instead.")
@click.option(
    "--stiffness",
    metavar="K",
    help="Stiffness of the drives, one number or one each: N/m and N m/rad, for any unit of "
    "length in SPEC.  [default: that of the drives in SPEC]",
)
@require_option("force<=200, range, condition<=50")
@output_options()
def command(
    spec: str,
    changes: Changes,
    rows: str | None,
    mode: Mode | None,
    pose: GivenPose | None,
    near: GivenPose | None,
    conventions: PoseConventions,
    columns: ColumnOptions,
    forward: str | None,
    twist: str | None,
    modal: bool,
    stiffness: str | None,
    require: str | None,
    output: Output,
) -> None:
    """Compute forces of the drives along a motion, motions under forces, natural frequencies.

    Each row has the forces of the six drives in N (moments in N m for angles), and the power of
    all in W. A force is positive if the drive pushes towards a greater value. The worst row and
    drive are named. With cranks or slides each row also has their torques in N m
    (torque.crank.B1) and forces in N (torque.slide.B1), with the weights of arms and carriages;
    F1 ... F6 are then the forces along the rods. A singular pose has no forces: such rows are
    named, and the exit code is 4.

    SPEC states the masses under dynamics: (docs/dynamics.md). ROWS is a CSV file of poses as
    `gsp measure` takes it, or of values as `gsp track` takes it, along which one mode is
    followed. One of the files may be - for standard input. Without ROWS there is one row for
    each real pose of SPEC.

    A column t, in seconds, makes the rows a motion: the platform moves along quintic splines
    through them. Without t the platform stands still at each row, unless columns state its
    motion. For poses wx wy wz is the angular velocity, and vx vy vz the velocity of the point x
    y z, in the axes of the base. Their derivatives are alphax alphay alphaz ax ay az. For
    values these are v1 ... v6 and a1 ... a6. All are per second, in the units of SPEC.

    --forward computes how the platform moves under given forces, from home, --pose or --mode.
    Each row is a pose with velocities and accelerations, as this command reads them, and
    energies in J. The exit code is 4 if the motion cannot be followed to the end.

    --modes gives the six natural frequencies in Hz of the platform on its drives as springs,
    with the geometric stiffness of the weights. A frequency is negative where the pose is not
    stable. For one pose the shape of each vibration is shown, too.

    --require names the worst row of each requirement, and the exit code is 1 unless all rows
    keep all of them: force, moment, torque, power; with --modes frequency; range, cone,
    condition and clearance as for `gsp measure`.

    \b
    Examples:
      gsp dynamics platform.yaml
      gsp dynamics rotary.yaml --mode home --require "torque<=2"
      gsp dynamics platform.yaml path.csv -o forces.csv
      gsp dynamics platform.yaml path.csv --require "force<=200, power<=50"
      gsp dynamics platform.yaml --mode home --modes --stiffness 2e6
      gsp dynamics platform.yaml --pose 0,0,150,1,0,0,0 --forward forces.csv
    """
    if forward is not None and (rows is not None or modal or require is not None):
        message = "--forward takes a pose to start from: no ROWS, --modes or --require"
        raise click.UsageError(message)
    for name, given, needs, other in (
        ("--twist", twist, "--forward", forward is not None),
        ("--stiffness", stiffness, "--modes", modal),
    ):
        if given is not None and not other:
            message = f"{name} is for {needs} only"
            raise click.UsageError(message)
    if spec == forward == "-":
        message = "SPEC and FORCES cannot both be standard input"
        raise click.UsageError(message)
    check_sources(spec, rows, mode, pose, near)
    instance = load_instance(spec, changes)
    form = conventions.form(instance, columns)
    if forward is not None:
        start = start_of(instance, mode, pose, form)
        _forward(instance, forward, start, twist, form, output)
        return
    requirements = required(require)
    asked = asked_rows(instance, rows, mode, pose, near, form)
    if modal:
        _modes(instance, asked, stiffness, requirements, output)
    else:
        _forces(instance, asked, requirements, output)


def _forces(
    instance: Instance, asked: AskedMotion, requirements: list[Requirement], output: Output
) -> None:
    import numpy as np

    from gspcli.dynamics import inverse_dynamics
    from gspcli.motion.files.requirements import QuantityParts

    motion = asked.motion
    found = inverse_dynamics(
        instance,
        asked.R,
        asked.T,
        t=asked.t,
        twists=None if motion is None else motion.twists,
        accelerations=None if motion is None else motion.accelerations,
        drives=asked.drives,
    )
    names = [f"drive {k}" for k in range(1, 7)]
    known: dict[str, Array | QuantityParts] = {"power": np.abs(found.power)}
    for name, unit in (("force", "N"), ("moment", "N m")):
        which = [k for k, one in enumerate(found.units) if one == unit]
        if which:
            known[name] = QuantityParts(np.abs(found.forces[:, which]), [names[k] for k in which])
    if found.torques is not None and found.drives is not None:
        moved = [k for k, sort in enumerate(found.drives.sorts) if sort != "value"]
        called = [found.drives.names[k] for k in moved]
        known["torque"] = QuantityParts(np.abs(found.torques[:, moved]), called)
    rows = force_rows(found, asked)
    _tell(found, asked, requirements, known, rows, partial(force_table, found, asked, rows), output)


def _tell(
    found: DriveForces | NaturalModes,
    asked: AskedMotion,
    requirements: list[Requirement],
    known: Mapping[str, Array | QuantityParts],
    rows: list[dict[str, Any]],
    tables: Callable[[list[Column], list[str]], Table | list[Table]],
    output: Output,
) -> None:
    """Write the result, warn of singular poses, and fail if a requirement is not kept.

    Parameters
    ----------
    found, asked
        What was found, and where.
    requirements, known
        What is required, and the numbers that it may be about.
    rows, tables
        What is shown; the tables, given columns that requirements add and lines with verdicts.
    output
        Where.
    """
    verdicts, more = judged(found.instance, requirements, asked.R, asked.T, rows, known)
    shown = tables(more, verdict_lines(verdicts, asked.place))
    document = _document(found, verdicts, asked) if output.format == "json" else None
    emit(output, shown, document=document)
    _warn(found, asked)
    if not any(one.worst == one.worst for one in verdicts if not one.met):
        # A requirement about unknown numbers of a singular pose is neither kept nor violated.
        _refuse_singular(found, asked)
    refuse(verdicts)
    _refuse_singular(found, asked)


def _document(
    found: DriveForces | NaturalModes, verdicts: list[RequirementVerdict], asked: AskedMotion
) -> dict[str, Any]:
    document = found.to_json()
    for mode, row in zip(asked.modes, document["rows"], strict=False):
        row["mode"] = mode
    if verdicts:
        document["requirements"] = verdict_entries(verdicts, asked.named)
    return document


def _warn(found: DriveForces | NaturalModes, asked: AskedMotion) -> None:
    """Say at which rows numbers have lost digits."""
    import numpy as np

    for row in np.flatnonzero(found.nearly_singular < np.inf)[:_MOST_NAMED].tolist():
        if found.singular[row]:
            continue
        condition = found.nearly_singular[row]
        digits = max(0, 16 - int(np.ceil(np.log10(condition))))
        click.echo(
            f"warning: {asked.place(row)} the pose is nearly singular (condition {condition:.2g}): "
            f"about {digits} digits of its forces are right",
            err=True,
        )


def _refuse_singular(found: DriveForces | NaturalModes, asked: AskedMotion) -> None:
    """Raise if there are singular poses, and name them."""
    rows = found.singular.nonzero()[0].tolist()
    if not rows:
        return
    named = listed([asked.place(row) for row in rows[:_MOST_NAMED]], "and")
    more = f" and {len(rows) - _MOST_NAMED} more" if len(rows) > _MOST_NAMED else ""
    message = f"{named}{more} the pose is singular: no forces hold every load there"
    raise IncompleteError(message)


def _modes(
    instance: Instance,
    asked: AskedMotion,
    stiffness: str | None,
    requirements: list[Requirement],
    output: Output,
) -> None:
    from gspcli.dynamics import natural_modes
    from gspcli.geometry.drive_numbers import is_driven
    from gspcli.geometry.drives import Drives
    from gspcli.motion.files.number_tables import numbers_of

    count = len(Drives.of(instance).names) if is_driven(instance) else 6
    given = None if stiffness is None else numbers_of(stiffness, (1, count), "--stiffness")
    found = natural_modes(instance, asked.R, asked.T, stiffness=given, drives=asked.drives)
    rows = mode_rows(found, asked)
    known = {"frequency": found.frequencies[:, 0]}
    _tell(found, asked, requirements, known, rows, partial(mode_tables, found, asked, rows), output)


def _forward(
    instance: Instance,
    forces: str,
    start: AskedMotion,
    twist: str | None,
    form: PoseFormat,
    output: Output,
) -> None:
    import numpy as np

    from gspcli.dynamics import simulate
    from gspcli.dynamics.motion_files import read_forces
    from gspcli.dynamics.trajectories import PoseRates, motion_of_platform
    from gspcli.motion.files.number_tables import numbers_of

    table = read_forces(*text_of(forces), instance, form)
    angles = np.repeat([instance.units.angle.in_radians, 1.0], 3)
    first: Array | float = 0.0
    if twist is not None:
        first = angles * numbers_of(twist, (6,), "--twist")
        rows = first[None]
        first = motion_of_platform(form.frame, start.R, PoseRates(rows, rows)).twists[0]
    with working("simulating"):
        found = simulate(
            instance,
            start.R[0],
            start.T[0],
            table.t,
            table.forces,
            twist=first,
            drives=start.drives,
        )
    document = found.to_json(form.frame) if output.format == "json" else None
    emit(output, motion_table(found, form.frame), document=document)
    if not found.energy_error < 1e-6:
        message = (
            f"the energy is wrong by {found.shown_error:.0e} of its changes: do not use this motion"
        )
        raise GspError(message)
