"""`gsp analyze`: what a platform does at a pose: screws, Jacobian matrix, forces, accuracy."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.options import (
    HOME,
    Command,
    Options,
    Positive,
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
from gspcli.cli.requirements import (
    judged,
    refuse,
    require_option,
    required,
    verdict_entries,
    verdict_lines,
)
from gspcli.cli.result import Field, Fields, Result, vector_text
from gspcli.errors import GspError

if TYPE_CHECKING:
    from gspcli.cli.pose_options import AskedPoses
    from gspcli.dynamics.analyses import Analysis
    from gspcli.geometry.instance import Instance
    from gspcli.geometry.machine import Machine
    from gspcli.motion.statics.wrenches import Wrenches

FIELDS = Fields("analyze")

#: Formats for people.
_READABLE = ("table", "markdown", "latex")
_ZERO = 1e-12


@click.command(cls=Command)
@exclusive("--mode", "--pose", "--near")
@exclusive("ROWS", "--pose")
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
    help="A force and moment on the platform, in the axes of the base, at a point of the base.  "
    "[default: the mean of the platform's points]",
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
def command(o: Options) -> None:
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
    if o.near is not None and o.rows is None:
        raise click.UsageError("--near says which mode to follow: give it with ROWS")
    if o.output.part is not None and o.rows is None and o.pose is None:
        # Parts are of one pose.
        o.mode = o.mode or HOME
    instance = o.instance
    requirements = required(o.require)
    asked = asked_poses(instance, o.rows, o.mode, o.pose, o.near, o.form)
    analysis = _analysis(
        instance, asked, o.load, o.stiffness, o.tolerance, o.geometry_tolerance, o.point, o.length
    )
    given = analysis.given
    names = [asked.named(k) for k in range(len(asked.T))]
    detailed = o.rows is None and (o.mode is not None or o.pose is not None)
    document = None
    if o.output.format == "json":
        document = analysis.to_json(names)
        entries = document["poses"]
    else:
        # Matrices of many poses fill the memory, and a table of poses has none.
        wanted = analysis.entry if detailed else analysis.brief
        entries = [{**name, **wanted(k)} for k, name in enumerate(names)]
    known = analysis.quantities() if requirements else None
    verdicts, more = judged(instance, requirements, given.R, given.T, entries, known)
    more = [column for column in more if column.key != "transmission"]
    tables = details(entries[0], given) if detailed else [overview(entries, given, more)]
    if analysis.moves_points and detailed:
        tables.insert(1, drives_table(entries[0], given.drives))
    if o.output.format in _READABLE:
        tables = [replace(table, rows=[_tidy(row) for row in table.rows]) for table in tables]
    if verdicts:
        tables[0] = replace(tables[0], summary=verdict_lines(verdicts, asked.place))
    if document is not None and verdicts:
        document["requirements"] = verdict_entries(verdicts, asked.named)
    emit(o.output, tables, document=document)
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
        raise GspError(f"--geometry-tolerance: found {text}, expected numbers of at least 0")
    return numbers


_TRANSMISSION = "transmission: the part of a drive's motion along its rod, 0 at a dead point"
_TWIST = ("rx", "ry", "rz", "x", "y", "z")
_WRENCH = ("mx", "my", "mz", "fx", "fy", "fz")


def overview(entries: list[dict[str, Any]], given: Wrenches, more: Sequence[Field] = ()) -> Result:
    """Return a line for each pose; `more` are columns of quantities added to the entries."""
    columns = [
        *FIELDS.of(
            "row t mode condition transmission torque torque_of manipulability largest smallest "
            "worst force force_in moment moment_in least_stiffness worst_shift bound_shift "
            "geometry_shift"
        ),
        *more,
    ]
    rows = [_line(entry, given) for entry in entries]
    # The columns of modes and of computed numbers are always shown.
    always = ("condition", "manipulability", "largest", "smallest", "worst")
    asked = {key for row in rows for key in row}
    kept = [column for column in columns if column.key in always or column.key in asked]
    return Result(kept, rows, title=given.instance.title, notes=_explained(rows[0], given))


def _line(entry: dict[str, Any], given: Wrenches) -> dict[str, Any]:
    """Return the most important numbers of a pose."""
    from gspcli.ties import first_largest

    values = entry["singular_values"]
    plain = {key: value for key, value in entry.items() if not isinstance(value, list | dict)}
    if plain.get("mode") is None:
        del plain["mode"]
    row = {**plain, "largest": values[0], "smallest": values[-1]}
    row["worst"] = entry["worst_force"]["reaction"]
    if "reactions" in entry:
        for name, angles in (("force", False), ("moment", True)):
            loads = {
                k: abs(load or 0.0)
                for k, load in enumerate(entry["reactions"])
                if given.angles[k] == angles
            }
            if loads and None not in entry["reactions"]:
                most = list(loads)[int(first_largest(list(loads.values())))]
                row |= {name: loads[most], f"{name}_in": most + 1}
    if "torques" in entry and None not in entry["torques"]:
        sizes = list(map(abs, entry["torques"]))
        most = sizes.index(max(sizes))
        row |= {"torque": sizes[most], "torque_of": given.drives.names[most]}
    if "accuracy" in entry:
        row |= {key: entry["accuracy"][key] for key in ("worst_shift", "bound_shift")}
    if "geometry" in entry:
        row["geometry_shift"] = entry["geometry"]["shift"]
    return row


def _explained(row: dict[str, Any], given: Wrenches) -> list[str]:
    unit = given.instance.units.length
    notes = [
        f"lengths divided by {given.length:.6g} {unit}; worst force: the largest load of a "
        "constraint by a unit force at the point"
    ]
    if "force" in row or "moment" in row:
        notes.append(
            "largest force, moment: in a constraint under the load, and in which; without @ the "
            "load acts at the mean of the platform's points"
        )
    if "transmission" in row:
        notes.append(_TRANSMISSION)
    if "torque" in row:
        notes.append(f"largest torque: of cranks force times {unit}, of slides a force")
    if "least_stiffness" in row:
        notes.append("least stiffness: a force at the point by the shift that it causes")
    if "worst_shift" in row or "geometry_shift" in row:
        notes.append(
            f"errors in {unit}: the largest of the point, from the values and the geometry"
        )
    return notes + _weights(given)


def drives_table(entry: dict[str, Any], drives: Machine) -> Result:
    """Return a line for each drive of one pose."""
    rows = []
    for k, name in enumerate(drives.names):
        users = drives.users(k)
        shares = [entry["transmissions"][user] for user in users]
        row = {
            "drive": name,
            "rods": " ".join(str(user + 1) for user in users),
            "at": entry["drives"][k],
            "transmission": None if None in shares else min(shares),
        }
        if "torques" in entry:
            row["torque"] = entry["torques"][k]
        rows.append(row)
    columns = FIELDS.of("drive rods at transmission@2")
    units = drives.instance.units
    notes = [f"at: in {units.angle.value} or {units.length} from where it is stated", _TRANSMISSION]
    if "torques" in entry:
        columns.append(FIELDS["torque@2"])
        notes.append(f"torque: of cranks force times {units.length}, of slides a force")
    return Result(columns, rows, title="Drives", notes=notes, part="drives")


def details(entry: dict[str, Any], given: Wrenches) -> list[Result]:
    """Return all tables of one pose."""
    kinds = [constraint.kind.name for constraint in given.instance.constraints]
    labels = [f"{k} {kind}" for k, kind in enumerate(kinds, 1)]
    unit = given.instance.units.length
    title = "Derivatives of the values by the twist"
    tables = [
        _screws(entry, given, kinds),
        _matrix("jacobian", title, "value", labels, _TWIST, entry["jacobian"]),
        _matrix("inverse", "Twist by the values", "twist", _TWIST, labels, entry["inverse"]),
    ]
    if "stiffness" in entry:
        title = "Stiffness: wrench by twist"
        tables.append(_matrix("stiffness", title, "wrench", _WRENCH, _TWIST, entry["stiffness"]))
    if "accuracy" in entry:
        tables.append(_errors(entry["accuracy"], unit))
    if "geometry" in entry:
        tables.append(_geometry_errors(entry["geometry"], unit))
    return tables


def _screws(entry: dict[str, Any], given: Wrenches, kinds: list[str]) -> Result:
    """Return the wrenches of the constraints; notes describe the pose."""
    screws = []
    for k, kind in enumerate(kinds):
        row = {"number": k + 1, "kind": kind, "pitch": entry["pitches"][k]}
        row |= zip(("fx", "fy", "fz"), entry["forces"][k], strict=True)
        row |= zip(("mx", "my", "mz"), entry["moments"][k], strict=True)
        row |= zip(("px", "py", "pz"), entry["feet"][k], strict=True)
        if "reactions" in entry:
            row["reaction"] = entry["reactions"][k]
        screws.append(row)
    forces, moments = ("fx", "fy", "fz"), ("mx", "my", "mz")
    columns = FIELDS.of("number kind")
    if "reactions" in entry:
        columns.append(FIELDS["reaction"])
    for keys, size in ((forces, 1.0), (moments, given.length)):
        columns += [Field(key, "", "right", True, aligned=True, size=size) for key in keys]
    columns += [Field(key, align="right", size=given.length) for key in ("pitch", "px", "py", "pz")]
    notes = _notes(entry, given)
    return Result(columns, screws, title=given.instance.title, notes=notes, part="wrenches")


def _notes(entry: dict[str, Any], given: Wrenches) -> list[str]:
    unit = given.instance.units.length
    worst = entry["worst_force"]
    values = " ".join(f"{value:.4g}" for value in entry["singular_values"])
    condition = "infinite" if entry["condition"] is None else f"{entry['condition']:.6g}"
    point = vector_text(entry["point"], size=given.length)
    notes = [
        f"about the point ({point}) {unit}; lengths divided by {given.length:.6g} {unit}:",
        f"singular values {values}; manipulability {entry['manipulability']:.6g}; "
        f"condition {condition} (rows scaled to one)",
    ]
    if worst["reaction"] is not None:
        along = vector_text(worst["direction"], 4)
        notes.append(
            f"worst unit force: ({along}) loads constraint {worst['constraint']} with "
            f"{worst['reaction']:.6g}"
        )
    return notes + _weights(given)


def _weights(given: Wrenches) -> list[str]:
    """Say that weights are among the reactions, if SPEC states any."""
    if given.instance.dynamics is None:
        return []
    unit = given.instance.units.length
    return [f"reactions hold the weights under dynamics in SPEC, too: N, and N {unit} for angles"]


def _matrix(part: str, title: str, corner: str, rows: Any, columns: Any, matrix: Any) -> Result:
    return Result(
        [Field(corner, essential=True)]
        + [Field(name, align="right", essential=True, aligned=True) for name in columns],
        [
            {corner: name, **dict(zip(columns, values, strict=True))}
            for name, values in zip(rows, matrix, strict=True)
        ],
        title=title,
        part=part,
    )


def _geometry_errors(errors: dict[str, Any], unit: str) -> Result:
    rows = [
        {"error": name, "worst": worst, "rms": rms}
        for name, worst, rms in zip(_TWIST, errors["worst"], errors["rms"], strict=True)
    ]
    rows += [
        {"error": "rotation", "worst": errors["turn"]},
        {"error": "distance", "worst": errors["shift"]},
    ]
    columns = FIELDS.of("error worst@2 rms")
    note = f"rotations in radians, distances in {unit}; upper bounds for rotation and distance"
    return Result(
        columns, rows, title="Errors of the pose from the geometry", notes=[note], part="geometry"
    )


def _errors(errors: dict[str, Any], unit: str) -> Result:
    rows = [
        {"error": name, "worst": a, "bound": b, "rms": c}
        for name, a, b, c in zip(
            _TWIST, errors["worst"], errors["bound"], errors["rms"], strict=True
        )
    ]
    rows += [
        {"error": "rotation", "worst": errors["worst_turn"], "bound": errors["bound_turn"]},
        {"error": "distance", "worst": errors["worst_shift"], "bound": errors["bound_shift"]},
    ]
    columns = FIELDS.of("error worst@2 bound rms@2")
    note = f"rotations in radians, distances in {unit}"
    if any(row["bound"] is None for row in rows):
        note += "; the tolerances are too large for a proof"
    return Result(columns, rows, title="Errors of the pose", notes=[note], part="errors")
