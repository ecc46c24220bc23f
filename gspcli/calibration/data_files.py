"""Files of measurements: CSV with a heading, in which any cell may be blank."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.calibrating import check_points
from gspcli.calibration.measurements import Measurements
from gspcli.calibration.parameters import Model
from gspcli.errors import ArgumentError, Mistake, SpecError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.motion.files.number_tables import NumberTable, wrong_number
from gspcli.motion.files.pose_files import (
    ANGLES,
    COLUMNS,
    ENTRIES,
    POSITION,
    QUATERNION,
    TRANSLATION,
    PoseFormat,
    refuse_own_pose,
    rotations_of,
)
from gspcli.motion.files.value_files import note_legs
from gspcli.wording import listed, shown

Array = NDArray[np.float64]

_INCLINATIONS = ("incl.x", "incl.y")
_NUMBERS = tuple("123456")
#: What coordinates that move begin with in `gsp track`: no target has such a name.
_MOVING = ("base", "platform")
_EXPECTED = "t, 1 ... 6, x y z, qw qx qy qz or rx ry rz, NAME.x, incl.x, crank.NAME or slide.NAME"
#: What columns of drives begin with.
_DRIVES = ("crank", "slide")


def read_measurements(
    text: str,
    name: str,
    instance: Instance,
    form: PoseFormat,
    targets: Mapping[str, Array] | None = None,
) -> Measurements:
    """Read what was measured.

    Columns ``1`` to ``6`` are readings of the constraints (DPH and DHP signed). ``x y z`` and a
    rotation are the pose as `gsp measure` reads it. ``P1.x P1.y P1.z`` are the position of a point
    of the platform or of a target, ``incl.x incl.y`` the inclinations of the platform's axes, and
    ``crank.B1`` and ``slide.B1`` are readings of drives. Where drives have columns, a leg without a
    column keeps its stated length. Unknown columns are mistakes.

    Parameters
    ----------
    text, name
        The content, and how messages name it.
    instance
        The platform as stated.
    form
        The conventions of poses that the file does not state.
    targets
        Where points of the target are in the platform's frame, by name.

    Raises
    ------
    SpecError
        With all mistakes, each with line and column.
    """
    table = NumberTable(text, name, form.units.of(instance), form.ignore, form.columns)
    targets = targets or {}
    form = form.of(table)
    # In rows with too few cells it is not known which cell is missing.
    table.check()
    groups = _groups(table, instance, targets)
    dotted = {one for one in table.heading if "." in one or one.isdecimal()}
    table.refuse_others({"t", *_NUMBERS, *COLUMNS, *dotted}, _EXPECTED)
    n = len(table)
    readings = np.full((n, 6), np.nan)
    note_legs(table, instance)
    found = [number for number in _NUMBERS if number in table.heading]
    readings[:, [int(number) - 1 for number in found]] = table.numbers(found, blanks=True)
    drives = _drives(table, instance)
    expressed, (positions, rotations) = form.pivot_frame, _poses(table, form)
    positions, rotations = expressed.point_to_base(positions), expressed.turn_to_platform(rotations)
    seen = {one: table.numbers([f"{one}.{axis}" for axis in "xyz"], blanks=True) for one in groups}
    tilts = np.zeros((0, 2))
    if set(_INCLINATIONS) & set(table.heading):
        if not set(_INCLINATIONS) <= set(table.heading):
            table.note_heading("found one of incl.x and incl.y, expected both")
        else:
            tilts = table.numbers(_INCLINATIONS, blanks=True) * form.in_radians
    lines = [str(k + 1) for k in range(n)]
    if "t" in table.heading:
        lines = [text or line for text, line in zip(table.texts("t"), lines, strict=True)]
    angles = Arrangement.of(instance).angles
    readings[:, angles] *= form.in_radians
    if not table.mistakes and not found and drives is None:
        table.note_heading("found no readings, expected some of the columns 1 2 3 4 5 6")
    table.check()
    return Measurements(
        readings,
        rotations,
        positions,
        expressed.of_platform.origin,
        seen,
        dict(targets),
        tilts,
        drives,
        tuple(lines),
        form.euler if form.euler and form.in_radians != 1 else "",
    )  # fmt: skip


def _groups(table: NumberTable, instance: Instance, targets: Mapping[str, Array]) -> list[str]:
    """Return the points that have columns; note columns that mean nothing."""
    found: dict[str, set[str]] = {}
    for written, name in zip(table.written, table.heading, strict=True):
        head, dot, axis = name.rpartition(".")
        if re.fullmatch(r"[0-9]+", name) and name not in _NUMBERS:
            table.note_column(written, f"found {written}, expected a constraint from 1 to 6")
        elif not dot or head in _DRIVES or name in _INCLINATIONS:
            continue
        elif head.partition(".")[0].lower() in _MOVING:
            message = (
                f"found {shown(written)}, which is a coordinate that moves in gsp track, expected "
                "a measured point of the platform or a target: P1.x"
            )
            table.note_column(written, message)
        elif axis in "xyz" and axis:
            found.setdefault(head, set()).add(axis)
            try:
                check_points(instance, [head], targets, "")
            except ArgumentError as error:
                table.note_column(written, error.message)
        else:
            message = (
                f"found {shown(written)}, expected NAME.x, NAME.y, NAME.z, incl.x, crank.NAME or "
                "slide.NAME"
            )
            table.note_column(written, message)
    for head, axes in found.items():
        if missing := [axis for axis in "xyz" if axis not in axes]:
            table.note_heading(f"the columns of {head} lack {listed(missing, 'and')}")
    return [head for head, axes in found.items() if len(axes) == 3] if not table.mistakes else []


def _drives(table: NumberTable, instance: Instance) -> Array | None:
    """Return the readings of cranks and slides in radians and lengths, if any."""
    written = {
        name: one
        for one, name in zip(table.written, table.heading, strict=True)
        if name.lower().startswith(tuple(f"{sort}." for sort in _DRIVES))
    }
    if not written:
        return None
    drives = Model.of(instance, drives=True).drives
    names = [drive.drive_name for drive in drives]
    sorts = {drive.sort for drive in drives}
    what = {"crank": "cranks", "slide": "slides"}[sorts.pop()] if len(sorts) == 1 else "drives"
    for name, one in written.items():
        if name not in names:
            known = listed(names) if names else f"no {name.partition('.')[0]}s, for SPEC has none"
            table.note_column(one, f"found {shown(one)}, expected {known}")
    if lacking := [one for one in names if one not in written]:
        table.note_heading(f"the columns of {what} lack {listed(lacking, 'and')}")
    if table.mistakes:
        return None
    angle = instance.units.angle.in_radians
    units = np.array([angle if drive.sort == "crank" else 1.0 for drive in drives])
    readings: Array = table.numbers(names, blanks=True) * units
    return readings


def _poses(table: NumberTable, form: PoseFormat) -> tuple[Array, Array]:
    """Return expressed positions and rotations, NaN where there are none."""
    n, heading = len(table), set(table.heading)
    positions, rotations = np.full((n, 3), np.nan), np.full((n, 3, 3), np.nan)
    if heading & {*POSITION, *TRANSLATION}:
        columns = table.choose(POSITION, TRANSLATION)
        if columns == TRANSLATION:
            refuse_own_pose(table, form)
        if columns:
            positions = table.numbers(columns, blanks=True)
    if not heading & {*QUATERNION, *ANGLES, *ENTRIES}:
        return positions, rotations
    columns = table.choose(QUATERNION, ANGLES, ENTRIES)
    if columns is None:
        return positions, rotations
    if (columns == ANGLES) != (form.euler is not None):
        table.note_heading(
            "found rx ry rz without the order of the axes: say it with --euler, such as ZYX or xyz"
            if columns == ANGLES
            else f"found {' '.join(columns)}, expected rx ry rz with an Euler sequence"
        )
        return positions, rotations
    numbers = table.numbers(columns, blanks=True)
    there = np.isfinite(numbers)
    for row in np.flatnonzero(there.any(axis=1) & ~there.all(axis=1)).tolist():
        lacking = columns[int(np.flatnonzero(~there[row])[0])]
        message = "found nothing, expected a number: a rotation is blank or whole"
        table.note_cell(row, lacking, message)
    whole = np.flatnonzero(there.all(axis=1))
    rotations[whole], wrong = rotations_of(numbers[whole], form)
    for row, message in wrong:
        table.note_cell(int(whole[row]), columns[0], message)
    return positions, rotations


def targets_of(texts: tuple[str, ...]) -> dict[str, Array]:
    """Return points of the target, written as ``NAME=X,Y,Z``.

    Raises
    ------
    SpecError
        With all that is wrong.
    """
    found, mistakes = {}, []
    for text in texts:
        name, equals, numbers = text.partition("=")
        cells = numbers.split(",")
        if not name or not equals or len(cells) != 3 or any(map(wrong_number, cells)):
            message = f"found {shown(text)}, expected NAME=X,Y,Z"
            mistakes.append(Mistake(None, "--target", message))
        elif name.partition(".")[0].lower() in _MOVING:
            message = f"found {shown(name)}, expected a name that is no coordinate of gsp track"
            mistakes.append(Mistake(None, "--target", message))
        else:
            found[name] = np.array([float(cell) for cell in cells])
    if mistakes:
        raise SpecError(mistakes)
    return found
