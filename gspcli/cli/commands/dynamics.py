"""`gsp dynamics`: forces of the drives and natural frequencies."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from gspcli.cli.options import (
    Command,
    Options,
    exclusive,
    output_options,
    value_options,
)
from gspcli.cli.pose_options import (
    GivenPose,
    Mode,
    asked_poses,
    column_options,
    mode_number,
    mode_option,
    near_option,
    pose_options,
    pose_value_option,
    text_of,
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
from gspcli.cli.streams import working
from gspcli.dynamics.arrays import plain
from gspcli.dynamics.forces import FORCES
from gspcli.dynamics.vibrations import FREQUENCIES
from gspcli.errors import GspError, IncompleteError
from gspcli.records import dataclass
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
    from gspcli.cli.pose_options import GivenPose, Mode
    from gspcli.dynamics.motion_files import ValueRows
    from gspcli.dynamics.trajectories import PoseRates

FIELDS = Fields("dynamics")

#: A message names at most this many rows.
_MOST_NAMED = 5


@click.command(cls=Command)
@exclusive("--mode", "--pose", "--near")
@exclusive("ROWS", "--pose")
@click.argument("spec", metavar="SPEC")
@click.argument("rows", metavar="[ROWS]", required=False)
@mode_option("only this one; also along a file of values.  [default: home, all without ROWS]")
@pose_value_option("instead of the modes of SPEC")
@near_option("of a file of values only this one is followed")
@value_options
@pose_options
@column_options
@click.option("--modes", "modal", is_flag=True, help="Natural frequencies and mode shapes instead.")
@click.option(
    "--stiffness",
    metavar="K",
    help="Stiffness of the drives, one number or one each: N/m and N m/rad, for any unit of "
    "length in SPEC.  [default: that of the drives in SPEC]",
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
    if o.near is not None and o.rows is None:
        raise click.UsageError("--near says which mode to follow: give it with ROWS")
    instance = o.instance
    form = o.form
    requirements = required(o.require)
    asked = asked_rows(instance, o.rows, o.mode, o.pose, o.near, form)
    if o.modal:
        _modes(instance, asked, o.stiffness, requirements, o.output)
    else:
        _forces(instance, asked, requirements, o.output)


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
    if found.torque_columns:
        moved = np.flatnonzero(found.drives.moved)
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
    tables: Callable[[list[Field], list[str]], Result | list[Result]],
    output: Output,
) -> None:
    """Write the result, warn of singular poses, and fail if a requirement is not kept."""
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
    raise IncompleteError(f"{named}{more} the pose is singular: no forces hold every load there")


def _modes(
    instance: Instance,
    asked: AskedMotion,
    stiffness: str | None,
    requirements: list[Requirement],
    output: Output,
) -> None:
    from gspcli.dynamics import natural_modes
    from gspcli.geometry.machine import Machine
    from gspcli.motion.files.number_tables import numbers_of

    count = Machine.of(instance).count
    given = None if stiffness is None else numbers_of(stiffness, (1, count), "--stiffness")
    found = natural_modes(instance, asked.R, asked.T, stiffness=given, drives=asked.drives)
    rows = mode_rows(found, asked)
    known = {"frequency": found.frequencies[:, 0]}
    _tell(found, asked, requirements, known, rows, partial(mode_tables, found, asked, rows), output)


@dataclass(frozen=True, eq=False)
class AskedMotion:
    """Poses, and what to call them.

    Attributes
    ----------
    R, T
        The poses, shapes (n, 3, 3) and (n, 3).
    t
        Times, shape (n,), or None: then the platform stands still unless `motion` says more.
    motion
        How it moves there, or None if that is not given.
    modes
        The numbers of the modes that the poses are; empty for other poses.
    drives
        Readings of the drives, shape (n, m), of a platform with cranks or slides whose rows say
        where they are; None for the working modes of home.
    """

    R: Array
    T: Array
    t: Array | None = None
    motion: PoseRates | None = None
    modes: tuple[int, ...] = ()
    drives: Array | None = None

    @property
    def how(self) -> str:
        """Where the accelerations come from, in words."""
        if self.motion is not None:
            return "velocities and accelerations as given"
        if self.t is not None:
            return "along quintic splines through the rows, least accurate at both ends"
        return "at rest" if len(self.T) == 1 or self.modes else "no column t: at rest at each row"

    @property
    def first_column(self) -> str:
        """What the rows are counted by."""
        return "mode" if self.modes else "t" if self.t is not None else "row"

    @property
    def labels(self) -> list[float]:
        """What is in the first column, n of them."""
        if self.t is not None:
            labels: list[float] = self.t.tolist()
            return labels
        return list(self.modes or range(1, len(self.T) + 1))

    def named(self, k: int) -> dict[str, Any]:
        """Return what a row is called, as data."""
        names: dict[str, Any] = {"row": k + 1}
        if self.t is not None:
            names["t"] = float(self.t[k])
        return {"mode": self.modes[k]} if self.modes else names

    def place(self, k: int) -> str:
        """Return what a row is called, in words: ``in row 7 (t = 1.5)``."""
        if self.modes:
            return f"in mode {self.modes[k]}"
        return f"in row {k + 1}" + ("" if self.t is None else f" (t = {self.t[k]:.6g})")


def asked_rows(
    instance: Instance,
    rows: str | None,
    mode: Mode | None,
    pose: GivenPose | None,
    near: GivenPose | None,
    form: PoseFormat,
) -> AskedMotion:
    """Return the poses of a file, the one that is given, or the real ones of the instance."""
    from gspcli.dynamics.motion_files import PoseRows, read_rows

    if rows is None:
        return _without_file(instance, mode, pose, form)
    found = read_rows(*text_of(rows), instance, form)
    if isinstance(found, PoseRows):
        if mode is not None or near is not None:
            raise GspError("--mode and --near are for files of values: this one says the poses")
        if not len(found.T):
            raise GspError(f"{rows}: found no poses, expected at least one")
        return AskedMotion(found.R, found.T, found.t, found.motion)
    return _followed(instance, found, mode, near, form)


def _without_file(
    instance: Instance, mode: Mode | None, pose: GivenPose | None, form: PoseFormat
) -> AskedMotion:
    found = asked_poses(instance, None, mode, pose, None, form)
    modes = tuple(mode for mode in found.modes if mode is not None)
    return AskedMotion(found.R, found.T, modes=modes, drives=found.stated_drives(instance))


def _followed(
    instance: Instance, rows: ValueRows, mode: Mode | None, near: GivenPose | None, form: PoseFormat
) -> AskedMotion:
    """Return the poses of one mode along rows of values."""
    from gspcli.dynamics.motion_files import motion_of_values
    from gspcli.motion import track

    start = None if near is None else near.read(form)
    modes = None if start is not None else [mode_number(instance, mode)]
    with working("following"):
        moving = dict(rows.coordinates)
        found = track(instance, rows.values, coordinates=moving, t=rows.t, modes=modes, near=start)
    if found.ends:
        (end,) = found.ends
        raise IncompleteError(
            f"mode {end.mode} ends at t = {end.low:.10g} ({end.kind}): there are no forces beyond\n"
            "end the rows before it (gsp track shows where it ends)"
        )
    R, T = found.R[0], found.T[0]
    motion = None
    if rows.rates is not None and rows.second_rates is not None:
        motion = motion_of_values(instance, R, T, rows.rates, rows.second_rates)
    return AskedMotion(R, T, rows.t, motion, drives=rows.drives(instance))


_TWIST = ("rx", "ry", "rz", "x", "y", "z")


def force_rows(found: DriveForces, asked: AskedMotion) -> list[dict[str, Any]]:
    """Return a row for each pose; cells are empty where no forces are known."""
    keys = (asked.first_column, *FORCES, "power")
    parts = zip(asked.labels, plain(found.forces), plain(found.power), strict=True)
    rows = [dict(zip(keys, (label, *forces, power), strict=True)) for label, forces, power in parts]
    torques = {name: plain(column) for name, column in found.torque_columns.items()}
    return [row | {name: torques[name][k] for name in torques} for k, row in enumerate(rows)]


def force_table(
    found: DriveForces,
    asked: AskedMotion,
    rows: list[dict[str, Any]],
    more: list[Field],
    lines: list[str],
) -> Result:
    """Return the forces of each row, and the worst of them in a note."""
    instance = found.instance
    kinds = [row.kind.name for row in instance.constraints]
    columns = [Field(asked.first_column, align="right", essential=True)]
    torques = found.torque_columns
    columns += [
        Field(key, f"{key.removeprefix('torque.')} [{unit}]", "right", True, aligned=True)
        for key, unit in zip(torques, found.torque_units, strict=False)
    ]
    columns += [
        Field(key, f"{key} {kind} [{unit}]", "right", not torques, aligned=True, size=size)
        for key, kind, unit, size in zip(
            FORCES, kinds, found.units, _sizes(found.forces, found.units), strict=True
        )
    ]
    columns.append(FIELDS["power"].but(size=_size(found.powers)))
    notes = [f"{asked.how}; positive: the drive pushes towards a greater value"]
    if torques:
        notes.append("F1 ... F6 act along the rods; before them: what the drives do")
    most = found.worst_torque
    if most is not None:
        unit, name = found.torque_units[most.drive], found.drives.names[most.drive]
        notes.append(f"worst: {most.force:.6g} {unit} by {name} {asked.place(most.row)}")
    worst = None if torques else found.worst
    if worst is not None:
        unit = found.units[worst.drive]
        notes.append(
            f"worst: {worst.force:.6g} {unit} by drive {worst.drive + 1} {asked.place(worst.row)}"
        )
    return Result(columns + more, rows, title=instance.title, notes=notes, summary=lines)


def mode_rows(found: NaturalModes, asked: AskedMotion) -> list[dict[str, Any]]:
    """Return a row of frequencies for each pose."""
    keys = (asked.first_column, *FREQUENCIES)
    parts = zip(asked.labels, plain(found.frequencies), strict=True)
    return [dict(zip(keys, (label, *numbers), strict=False)) for label, numbers in parts]


def mode_tables(
    found: NaturalModes,
    asked: AskedMotion,
    rows: list[dict[str, Any]],
    more: list[Field],
    lines: list[str],
) -> list[Result]:
    """Return the frequencies of each row, or of one pose the modes with their shapes."""
    instance = found.instance
    notes = ["natural frequencies in Hz" + _unstable(found)]
    if len(found.T) > 1 or found.singular.any():
        columns = [Field(asked.first_column, align="right", essential=True)]
        columns += [
            Field(key, f"{key} [Hz]", align="right", essential=True, aligned=True)
            for key in FREQUENCIES[: found.squares.shape[1]]
        ]
        return [Result(columns + more, rows, title=instance.title, notes=notes, summary=lines)]
    shapes = [
        {"mode": k + 1, "frequency": frequency, **dict(zip(_TWIST, shape, strict=True))}
        for k, (frequency, shape) in enumerate(
            zip(found.frequencies[0].tolist(), found.shapes[0].tolist(), strict=True)
        )
    ]
    columns = [
        *FIELDS.of("mode frequency"),
        *(Field(key, _heading(key, instance), "right", aligned=True) for key in _TWIST),
    ]
    notes.append(
        "shapes: turns about the axes of the base, and the way of the platform's origin; the "
        "largest is one radian or the typical length"
    )
    return [Result(columns, shapes, title=instance.title, notes=notes, summary=lines)]


def _unstable(found: NaturalModes) -> str:
    low = found.squares[~found.singular]
    return "; negative: the pose is not stable that way" if (low < 0).any() else ""


def _heading(key: str, instance: Instance) -> str:
    return f"{key} [{'rad' if key.startswith('r') else instance.units.length}]"


def _size(numbers: Array) -> float:
    """Return the largest modulus of numbers that are known, or zero."""
    return float(np.nan_to_num(np.abs(numbers)).max(initial=0.0))


def _sizes(numbers: Array, units: Sequence[str]) -> list[float]:
    """Return for each column, shape (n, k), the largest modulus of those of the same unit."""
    return [_size(numbers[:, [unit == other for other in units]]) for unit in units]
