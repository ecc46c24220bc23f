"""`gsp analyze`: what a platform does at a pose: screws, Jacobian matrix, forces, accuracy."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.options import HOME, Command, Options, Positive, option, output_options
from gspcli.cli.pose_options import AskedPoses, asked_poses, rows_options
from gspcli.cli.render import emit
from gspcli.cli.requirements import refuse, require_option, required, settled
from gspcli.cli.result import Field, Fields, Result, vector_text
from gspcli.errors import GspError

if TYPE_CHECKING:
    from gspcli.dynamics.analyses import Analysis
    from gspcli.geometry.machine import Machine
    from gspcli.motion.statics.wrenches import Wrenches

FIELDS = Fields("analyze", size=1.0)

_TRANSMISSION = "transmission: the part of a drive's motion along its rod, 0 at a dead point"
_TWIST = ("rx", "ry", "rz", "x", "y", "z")
_WRENCH = ("mx", "my", "mz", "fx", "fy", "fz")


@click.command(cls=Command)
@rows_options("only this one, in detail; also along a file of values.")
@option(
    "--point X,Y,Z",
    "The point of the base about which twists and wrenches are taken.  [default: the mean of the "
    "platform's points]",
)
@option(
    "--length LENGTH",
    "The length that makes angles and lengths comparable.  [default: the typical length]",
    type=Positive(),
)
@option(
    "--load FX,FY,FZ[,MX,MY,MZ][@X,Y,Z]",
    "A force and moment on the platform, in the axes of the base, at a point of the base.  "
    "[default: the mean of the platform's points]",
)
@option(
    "--stiffness K",
    "Stiffness of the constraints, one number or six: in the unit of force of --load per unit of "
    "length of SPEC, such as N/mm, for angles moment per radian. gsp dynamics takes N/m.  "
    "[default: that of the drives in SPEC]",
)
@option("--tolerance D", "How far each value may be off: one number or six.")
@option(
    "--geometry-tolerance D[,A]",
    "How far each coordinate of each primitive may be off, and how far each direction may be "
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
    if o.output.part is not None and o.rows is None and o.pose is None:
        # Parts are of one pose.
        o.mode = o.mode or HOME
    requirements = required(o.require)
    asked = asked_poses(o)
    analysis = _analysis(o, asked)
    given = analysis.given
    detailed = o.rows is None and (o.mode is not None or o.pose is not None)
    # Matrices of many poses fill the memory, and a table of poses has none.
    brief = not detailed and o.output.format != "json"
    result = overview(analysis, asked, analysis.to_json(asked.places, brief=brief))
    known = analysis.quantities() if requirements else None
    result, verdicts = settled(
        result, requirements, given.R, given.T, asked.places, known, asked.drives
    )
    if detailed:
        result = replace(result, parts=details(result.rows[0], analysis))
    emit(o.output, result)
    refuse(verdicts)
    asked.check()


def _analysis(o: Options, asked: AskedPoses) -> Analysis:
    """Return what the options ask for."""
    from gspcli.dynamics.analyses import analyze

    wrench, _, where = re.sub(r"\s", "", o.load or "").partition("@")
    geometry = _given(o.geometry_tolerance, (1, 2), "--geometry-tolerance")
    if geometry is not None and min(geometry) < 0:
        raise GspError(
            f"--geometry-tolerance: found {o.geometry_tolerance}, expected numbers of at least 0"
        )
    return analyze(
        o.instance,
        asked.R,
        asked.T,
        load=_given(None if o.load is None else wrench, (3, 6), "--load"),
        at=_given(where or None, (3,), "--load"),
        stiffness=_given(o.stiffness, (1, 6), "--stiffness"),
        tolerance=_given(o.tolerance, (1, 6), "--tolerance"),
        geometry_tolerance=geometry,
        point=_given(o.point, (3,), "--point"),
        length=o.length,
        drives=asked.drives,
    )


def _given(text: str | None, counts: tuple[int, ...], option: str) -> list[float] | None:
    """Return the numbers of an option, or None without it."""
    if text is None:
        return None
    from gspcli.motion.files.number_tables import numbers_of

    return numbers_of(text, counts, option)


def overview(analysis: Analysis, asked: AskedPoses, document: dict[str, Any]) -> Result:
    """Return a line for each pose, and what the document of the analysis says for JSON."""
    rows = [{**entry, **_most(entry, analysis)} for entry in document["poses"]]
    given = analysis.given
    unit, row = given.instance.units.length, rows[0]
    notes = [
        f"lengths divided by {given.length:.6g} {unit}; worst force: the largest load of a "
        "constraint by a unit force at the point"
    ]
    load = (
        "largest force, moment: in a constraint under the load, and in which; without @ the load "
        "acts at the mean of the platform's points"
    )
    errors = f"errors in {unit}: the largest of the point, from the values and the geometry"
    for keys, note in (
        (("force", "moment"), load),
        (("transmission",), _TRANSMISSION),
        (("torque",), f"largest torque: of cranks force times {unit}, of slides a force"),
        (("least_stiffness",), "least stiffness: a force at the point by the shift that it causes"),
        (("accuracy", "geometry"), errors),
    ):
        notes += [note] if any(key in row for key in keys) else []
    columns = FIELDS.of(
        f"{asked.columns} condition transmission? torque? torque_of? manipulability largest "
        "smallest worst force? force_in? moment? moment_in? least_stiffness? worst_shift? "
        "bound_shift? geometry_shift?",
        rows,
    )
    notes += _weights(given)
    return Result(
        columns, rows, given.instance.title, notes, instance=given.instance, schema="analyze",
        name="poses", head=document,
    )  # fmt: skip


def _most(entry: Mapping[str, Any], analysis: Analysis) -> dict[str, Any]:
    """Return the largest force and moment of a constraint, and torque of a drive, under a load."""
    from gspcli.ties import first_largest

    found: dict[str, Any] = {}
    loads, angles = entry.get("reactions", [None]), analysis.given.angles
    for name, of_angles in (("force", False), ("moment", True)):
        those = [k for k in range(len(loads)) if None not in loads and angles[k] == of_angles]
        if those:
            sizes = [abs(loads[k]) for k in those]
            most = int(first_largest(sizes))
            found |= {name: sizes[most], f"{name}_in": those[most] + 1}
    torques = entry.get("torques", [None])
    if None not in torques:
        torque, k = max((abs(x), -k) for k, x in enumerate(torques))
        found |= {"torque": torque, "torque_of": analysis.given.drives.names[-k]}
    return found


def details(entry: Mapping[str, Any], analysis: Analysis) -> list[Result]:
    """Return all tables of one pose."""
    given = analysis.given
    units = given.instance.units
    kinds = [constraint.kind.name for constraint in given.instance.constraints]
    labels = [f"{k} {kind}" for k, kind in enumerate(kinds, 1)]
    title = "Derivatives of the values by the twist"
    tables = [
        _screws(entry, given, kinds),
        _matrix("jacobian", title, "value", labels, _TWIST, entry["jacobian"]),
        _matrix("inverse", "Twist by the values", "twist", _TWIST, labels, entry["inverse"]),
    ]
    if analysis.moves_points:
        tables.insert(1, _drives(entry, given.drives))
    if "stiffness" in entry:
        title = "Stiffness: wrench by twist"
        tables.append(_matrix("stiffness", title, "wrench", _WRENCH, _TWIST, entry["stiffness"]))
    note = f"rotations in radians, distances in {units.length}"
    if "accuracy" in entry:
        lost = None in entry["accuracy"]["bound"]
        said = note + "; the tolerances are too large for a proof" * lost
        tables.append(_errors("errors", "Errors of the pose", entry["accuracy"], said))
    if "geometry" in entry:
        title = "Errors of the pose from the geometry"
        note += "; upper bounds for rotation and distance"
        tables.append(_errors("geometry", title, entry["geometry"], note))
    return tables


def _screws(entry: Mapping[str, Any], given: Wrenches, kinds: Sequence[str]) -> Result:
    """Return the wrenches of the constraints; notes describe the pose."""
    rows = []
    for k, kind in enumerate(kinds):
        row = {"number": k + 1, "kind": kind, "pitch": entry["pitches"][k]}
        for letter, key in (("f", "forces"), ("m", "moments"), ("p", "feet")):
            row |= zip((f"{letter}{axis}" for axis in "xyz"), entry[key][k], strict=True)
        if "reactions" in entry:
            row["reaction"] = entry["reactions"][k]
        rows.append(row)
    columns = FIELDS.of("number kind reaction? fx fy fz mx my mz pitch px py pz", rows)
    unit, worst = given.instance.units.length, entry["worst_force"]
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
    return Result(columns, rows, notes=[*notes, *_weights(given)], part="wrenches")


def _weights(given: Wrenches) -> list[str]:
    """Say that weights are among the reactions, if SPEC states any."""
    if given.instance.dynamics is None:
        return []
    unit = given.instance.units.length
    return [f"reactions hold the weights under dynamics in SPEC, too: N, and N {unit} for angles"]


def _drives(entry: Mapping[str, Any], drives: Machine) -> Result:
    """Return a line for each drive of one pose."""
    rows = []
    for k, name in enumerate(drives.names):
        users = drives.users(k)
        shares = [entry["transmissions"][user] for user in users]
        least = None if None in shares else min(shares)
        rods = " ".join(str(user + 1) for user in users)
        row = {"drive": name, "rods": rods, "at": entry["drives"][k], "transmission": least}
        if "torques" in entry:
            row["torque"] = entry["torques"][k]
        rows.append(row)
    units = drives.instance.units
    notes = [f"at: in {units.angle.value} or {units.length} from where it is stated", _TRANSMISSION]
    if "torques" in entry:
        notes.append(f"torque: of cranks force times {units.length}, of slides a force")
    columns = FIELDS.of("drive rods at transmission@2 torque@2?", rows)
    return Result(columns, rows, title="Drives", notes=notes, part="drives")


def _matrix(part: str, title: str, corner: str, rows: Any, columns: Any, matrix: Any) -> Result:
    numbers = [
        Field(name, align="right", essential=True, aligned=True, size=1.0) for name in columns
    ]
    cells = [
        {corner: name, **dict(zip(columns, values, strict=True))}
        for name, values in zip(rows, matrix, strict=True)
    ]
    return Result([Field(corner, essential=True), *numbers], cells, title=title, part=part)


def _errors(part: str, title: str, errors: Mapping[str, Any], note: str) -> Result:
    """Return the errors of each coordinate, and those of the whole rotation and distance."""
    keys = [key for key in ("worst", "bound", "rms") if key in errors]
    rows = [
        {"error": name, **{key: errors[key][k] for key in keys}} for k, name in enumerate(_TWIST)
    ]
    for name, key in (("rotation", "turn"), ("distance", "shift")):
        row = {"error": name, "worst": errors.get(f"worst_{key}", errors.get(key))}
        rows.append(row | ({"bound": errors[f"bound_{key}"]} if "bound" in keys else {}))
    columns = FIELDS.of("error worst@2 bound? rms", rows)
    return Result(columns, rows, title=title, notes=[note], part=part)
