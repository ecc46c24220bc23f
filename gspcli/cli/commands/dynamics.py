"""`gsp dynamics`: forces of the drives and natural frequencies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from gspcli.cli.options import Command, Options, option, output_options
from gspcli.cli.pose_options import (
    AskedPoses,
    asked_poses,
    check_poses,
    mode_number,
    refuse_modes,
    rows_options,
    text_of,
)
from gspcli.cli.render import emit
from gspcli.cli.requirements import place_text, refuse, require_option, required, settled
from gspcli.cli.result import Field, Fields, Result
from gspcli.cli.streams import working
from gspcli.errors import IncompleteError
from gspcli.wording import listed

if TYPE_CHECKING:
    from gspcli.dynamics import DriveForces, NaturalModes
    from gspcli.geometry.instance import Array
    from gspcli.motion.files.requirements import QuantityParts

    Quantities = Mapping[str, Array | QuantityParts]

FIELDS = Fields("dynamics")

#: A message names at most this many rows.
_MOST_NAMED = 5
_TWIST = ("rx", "ry", "rz", "x", "y", "z")


@click.command(cls=Command)
@rows_options("only this one; also along a file of values.  [default: home, all without ROWS]")
@option("--modes", "Natural frequencies and mode shapes instead.", name="modal")
@option(
    "--stiffness K",
    "Stiffness of the drives, one number or one each: N/m and N m/rad, for any unit of length in "
    "SPEC.  [default: that of the drives in SPEC]",
)
@require_option("force<=200, range, condition<=50")
@output_options()
def command(o: Options) -> None:
    """Compute forces of the drives along a motion, and natural frequencies.

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
    """
    if o.stiffness is not None and not o.modal:
        raise click.UsageError("--stiffness is for --modes only")
    requirements = required(o.require)
    asked = _asked(o)
    found, result, known = _modes(o, asked) if o.modal else _forces(o, asked)
    result, verdicts = settled(
        result, requirements, asked.R, asked.T, asked.places, known, asked.drives
    )
    emit(o.output, result)
    _warn(found, asked)
    if not any(one.worst == one.worst for one in verdicts if not one.met):
        # A requirement about unknown numbers of a singular pose is neither kept nor violated.
        _refuse_singular(found, asked)
    refuse(verdicts)
    _refuse_singular(found, asked)


def _asked(o: Options) -> AskedPoses:
    """Return the poses of a file, the one that is given, or the real ones of the instance."""
    if o.rows is None:
        asked = asked_poses(o)
        return asked if o.pose is None else replace(asked, places=[{"row": 1}])
    from gspcli.dynamics.motion_files import motion_of_values, read_rows
    from gspcli.dynamics.trajectories import PoseRates
    from gspcli.motion import PoseTable, track

    instance, form = o.instance, o.form
    text, name = text_of(o.rows)
    t, rows, rates = read_rows(text, name, instance, form)
    count = len(rows.R if isinstance(rows, PoseTable) else rows.values)
    places: list[dict[str, Any]] = [{"row": k} for k in range(1, count + 1)]
    if t is not None:
        places = [{**place, "t": time} for place, time in zip(places, t.tolist(), strict=True)]
    if isinstance(rows, PoseTable):
        refuse_modes(o, name)
        check_poses(o, text, name, rows.R, rows.T)
        motion = None if rates is None else PoseRates(*rates)
        return AskedPoses(rows.R, rows.T, places, t=t, motion=motion)
    start = None if o.near is None else o.near.read(form)
    modes = None if start is not None else [mode_number(instance, o.mode)]
    with working("following"):
        moving = rows.coordinates
        found = track(instance, rows.values, coordinates=moving, t=t, modes=modes, near=start)
    if found.ends:
        (end,) = found.ends
        raise IncompleteError(
            f"mode {end.mode} ends at t = {end.low:.10g} ({end.kind}): there are no forces beyond\n"
            "end the rows before it (gsp track shows where it ends)"
        )
    R, T = found.R[0], found.T[0]
    motion = None if rates is None else motion_of_values(instance, R, T, rates)
    return AskedPoses(R, T, places, rows.drives(instance), t=t, motion=motion)


def _result(
    found: DriveForces | NaturalModes, asked: AskedPoses, columns: list[Field], notes: list[str]
) -> Result:
    """Return a row for each pose, with what the forces or modes are as data."""
    document = found.to_json()
    names = [{"mode": place["mode"]} if "mode" in place else {} for place in asked.places]
    rows = [{**row, **name} for row, name in zip(document["rows"], names, strict=True)]
    first = "mode" if names[0] else "row" if asked.t is None else "t"
    columns = [Field(first, align="right", essential=True), *columns]
    return Result(
        columns, rows, found.instance.title, notes, instance=found.instance, schema="dynamics",
        name="rows", head=document,
    )  # fmt: skip


def _forces(o: Options, asked: AskedPoses) -> tuple[DriveForces, Result, Quantities]:
    """Return the forces of the drives, their table, and what may be required."""
    from gspcli.dynamics import inverse_dynamics
    from gspcli.motion.files.requirements import QuantityParts

    motion, t = asked.motion, asked.t
    twists, accelerations = (motion.twists, motion.accelerations) if motion else (None, None)
    found = inverse_dynamics(
        o.instance, asked.R, asked.T, t=t, twists=twists, accelerations=accelerations,
        drives=asked.drives,
    )  # fmt: skip
    known: dict[str, Array | QuantityParts] = {"power": np.abs(found.power)}
    for name, unit in (("force", "N"), ("moment", "N m")):
        which = [k for k, one in enumerate(found.units) if one == unit]
        if which:
            names = [f"drive {k + 1}" for k in which]
            known[name] = QuantityParts(np.abs(found.forces[:, which]), names)
    if motion is not None:
        how = "velocities and accelerations as given"
    elif t is not None:
        how = "along quintic splines through the rows, least accurate at both ends"
    elif len(asked.T) == 1 or "mode" in asked.places[0]:
        how = "at rest"
    else:
        how = "no column t: at rest at each row"
    notes = [f"{how}; positive: the drive pushes towards a greater value"]
    columns: list[Field] = []
    worst, units, called = found.worst, found.units, [f"drive {k}" for k in range(1, 7)]
    if found.torque_columns:
        worst, units, called = found.worst_torque, found.torque_units, list(found.drives.names)
        moved = np.flatnonzero(found.drives.moved)
        known["torque"] = QuantityParts(np.abs(found.torques[:, moved]), [called[k] for k in moved])
        columns = [
            FIELDS[f"torque.{name}"].but(title=f"{name} [{unit}]", source=f"torques.{k}")
            for k, (name, unit) in enumerate(zip(called, units, strict=False))
        ]
        notes.append("F1 ... F6 act along the rods; before them: what the drives do")
    if worst is not None:
        unit, name = units[worst.drive], called[worst.drive]
        place = place_text(asked.places[worst.row])
        notes.append(f"worst: {worst.force:.6g} {unit} by {name} {place}")
    kinds = (row.kind.name for row in found.instance.constraints)
    # Of each drive the largest force of those in the same unit.
    alike = [[unit == other for other in found.units] for unit in found.units]
    sizes = [_size(found.forces[:, those]) for those in alike]
    columns += [
        FIELDS[f"F{k + 1}"].but(
            title=f"F{k + 1} {kind} [{unit}]", source=f"forces.{k}", size=size,
            essential=not known.get("torque"),
        )
        for k, (kind, unit, size) in enumerate(zip(kinds, found.units, sizes, strict=True))
    ]  # fmt: skip
    columns.append(FIELDS["power"].but(size=_size(found.powers)))
    return found, _result(found, asked, columns, notes), known


def _modes(o: Options, asked: AskedPoses) -> tuple[NaturalModes, Result, Quantities]:
    """Return the natural modes, their table, and what may be required."""
    from gspcli.dynamics import natural_modes
    from gspcli.geometry.machine import Machine
    from gspcli.motion.files.number_tables import numbers_of

    instance = o.instance
    count = Machine.of(instance).count
    given = None if o.stiffness is None else numbers_of(o.stiffness, (1, count), "--stiffness")
    found = natural_modes(instance, asked.R, asked.T, stiffness=given, drives=asked.drives)
    known = {"frequency": found.frequencies[:, 0]}
    unstable = (found.squares[~found.singular] < 0).any()
    notes = [
        "natural frequencies in Hz" + "; negative: the pose is not stable that way" * bool(unstable)
    ]
    columns = [
        FIELDS[f"f{k}"].but(title=f"f{k} [Hz]", source=f"frequencies.{k - 1}")
        for k in range(1, found.squares.shape[1] + 1)
    ]
    result = replace(_result(found, asked, columns, notes), schema="dynamics-modes")
    if len(found.T) > 1 or found.singular.any():
        return found, result, known
    frequencies, shapes = found.frequencies[0].tolist(), found.shapes[0].tolist()
    rows = [
        {"mode": k, "frequency": frequency, **dict(zip(_TWIST, shape, strict=True))}
        for k, (frequency, shape) in enumerate(zip(frequencies, shapes, strict=True), 1)
    ]
    lengths = [FIELDS[key].but(title=f"{key} [{instance.units.length}]") for key in _TWIST[3:]]
    notes.append(
        "shapes: turns about the axes of the base, and the way of the platform's origin; the "
        "largest is one radian or the typical length"
    )
    columns = [*FIELDS.of("mode frequency rx ry rz"), *lengths]
    return found, replace(result, parts=[Result(columns, rows, notes=notes)]), known


def _warn(found: DriveForces | NaturalModes, asked: AskedPoses) -> None:
    """Say at which rows numbers have lost digits."""
    for row in np.flatnonzero(found.nearly_singular < np.inf)[:_MOST_NAMED].tolist():
        if not found.singular[row]:
            condition = found.nearly_singular[row]
            digits = max(0, 16 - int(np.ceil(np.log10(condition))))
            click.echo(
                f"warning: {place_text(asked.places[row])} the pose is nearly singular (condition "
                f"{condition:.2g}): about {digits} digits of its forces are right",
                err=True,
            )


def _refuse_singular(found: DriveForces | NaturalModes, asked: AskedPoses) -> None:
    """Raise if there are singular poses, and name them."""
    if rows := found.singular.nonzero()[0].tolist():
        named = listed([place_text(asked.places[row]) for row in rows[:_MOST_NAMED]], "and")
        more = f" and {len(rows) - _MOST_NAMED} more" if len(rows) > _MOST_NAMED else ""
        raise IncompleteError(
            f"{named}{more} the pose is singular: no forces hold every load there"
        )


def _size(numbers: Array) -> float:
    """Return the largest modulus of numbers that are known, or zero."""
    return float(np.nan_to_num(np.abs(numbers)).max(initial=0.0))
