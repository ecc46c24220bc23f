"""What `gsp analyze` says about poses, as tables for people."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from gspcli.cli.output import Column, Table
from gspcli.cli.output.cells import vector_text

if TYPE_CHECKING:
    from gspcli.geometry.drives import Drives
    from gspcli.motion.statics.wrenches import Wrenches

_TRANSMISSION = "transmission: the part of a motor's motion along its rod, 0 at a dead point"
_TWIST = ("rx", "ry", "rz", "x", "y", "z")
_WRENCH = ("mx", "my", "mz", "fx", "fy", "fz")


def overview(entries: list[dict[str, Any]], given: Wrenches, more: Sequence[Column] = ()) -> Table:
    """Return a line for each pose; `more` are columns of quantities added to the entries."""
    columns = [
        Column("row", align="right", essential=True),
        Column("t", align="right"),
        Column("mode", align="right", essential=True),
        Column("condition", align="right", essential=True),
        Column("transmission", align="right", essential=True),
        Column("torque", "largest torque", align="right", essential=True),
        Column("torque_of", "of", essential=True),
        Column("manipulability", align="right", minor=2),
        Column("largest", "largest σ", align="right", minor=3),
        Column("smallest", "smallest σ", align="right", minor=3),
        Column("worst", "worst force", align="right", minor=1),
        Column("force", "largest force", align="right", essential=True),
        Column("force_in", "in", align="right"),
        Column("moment", "largest moment", align="right", essential=True),
        Column("moment_in", "in", align="right"),
        Column("least_stiffness", "least stiffness", align="right", essential=True),
        Column("worst_shift", "error of point", align="right"),
        Column("bound_shift", "proved ≤", align="right", essential=True),
        Column("geometry_shift", "from geometry", align="right", essential=True),
        *more,
    ]
    rows = [_line(entry, given) for entry in entries]
    # The columns of modes and of computed numbers are always shown.
    always = ("condition", "manipulability", "largest", "smallest", "worst")
    asked = {key for row in rows for key in row}
    kept = [column for column in columns if column.key in always or column.key in asked]
    return Table(kept, rows, title=given.instance.title, notes=_explained(rows[0], given))


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
    if given.drives is not None and "torques" in entry and None not in entry["torques"]:
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
        notes.append("largest force, moment: in a constraint under the load, and in which")
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


def drives_table(entry: dict[str, Any], drives: Drives) -> Table:
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
    columns = [
        Column("drive", essential=True),
        Column("rods", essential=True),
        Column("at", align="right", essential=True, aligned=True),
        Column("transmission", align="right", essential=True, aligned=True),
    ]
    units = drives.instance.units
    notes = [f"at: in {units.angle.value} or {units.length} from where it is stated", _TRANSMISSION]
    if "torques" in entry:
        columns.append(Column("torque", align="right", essential=True, aligned=True))
        notes.append(f"torque: of cranks force times {units.length}, of slides a force")
    return Table(columns, rows, title="Drives", notes=notes, part="drives")


def details(entry: dict[str, Any], given: Wrenches) -> list[Table]:
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


def _screws(entry: dict[str, Any], given: Wrenches, kinds: list[str]) -> Table:
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
    columns = [
        Column("number", "no.", align="right", essential=True),
        Column("kind", essential=True),
    ]
    if "reactions" in entry:
        columns.append(Column("reaction", align="right", essential=True))
    for keys, size in ((forces, 1.0), (moments, given.length)):
        columns += [Column(key, "", "right", True, aligned=True, size=size) for key in keys]
    columns += [
        Column(key, align="right", size=given.length) for key in ("pitch", "px", "py", "pz")
    ]
    notes = _notes(entry, given)
    return Table(columns, screws, title=given.instance.title, notes=notes, part="wrenches")


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


def _matrix(part: str, title: str, corner: str, rows: Any, columns: Any, matrix: Any) -> Table:
    return Table(
        [Column(corner, essential=True)]
        + [Column(name, align="right", essential=True, aligned=True) for name in columns],
        [
            {corner: name, **dict(zip(columns, values, strict=True))}
            for name, values in zip(rows, matrix, strict=True)
        ],
        title=title,
        part=part,
    )


def _geometry_errors(errors: dict[str, Any], unit: str) -> Table:
    rows = [
        {"error": name, "worst": worst, "rms": rms}
        for name, worst, rms in zip(_TWIST, errors["worst"], errors["rms"], strict=True)
    ]
    rows += [
        {"error": "rotation", "worst": errors["turn"]},
        {"error": "distance", "worst": errors["shift"]},
    ]
    columns = (
        Column("error", essential=True),
        Column("worst", "worst, first order", align="right", essential=True),
        Column("rms", align="right", essential=True),
    )
    note = f"rotations in radians, distances in {unit}; upper bounds for rotation and distance"
    return Table(
        columns, rows, title="Errors of the pose from the geometry", notes=[note], part="geometry"
    )


def _errors(errors: dict[str, Any], unit: str) -> Table:
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
    columns = (
        Column("error", essential=True),
        Column("worst", "worst, first order", align="right", essential=True),
        Column("bound", "proved ≤", align="right", essential=True),
        Column("rms", align="right"),
    )
    note = f"rotations in radians, distances in {unit}"
    if any(row["bound"] is None for row in rows):
        note += "; the tolerances are too large for a proof"
    return Table(columns, rows, title="Errors of the pose", notes=[note], part="errors")
