"""Logs of machines: CSV of readings and poses, for a stated machine or for one to be found."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from gspcli.calibration.measurements import Measurements
from gspcli.calibration.model import Model
from gspcli.errors import ArgumentError, Mistake, SpecError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.motion.files.number_tables import FileUnits, NumberTable, order_of, wrong_number
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
from gspcli.records import dataclass
from gspcli.wording import listed, shown, suggestion

Array = NDArray[np.float64]

_INCLINATIONS = ("incl.x", "incl.y")
_NUMBERS = tuple("123456")
#: What coordinates that move begin with in `gsp track`: no target has such a name.
_MOVING = ("base", "platform")
_EXPECTED = "t, 1 ... 6, x y z, qw qx qy qz or rx ry rz, NAME.x, incl.x, crank.NAME or slide.NAME"
#: What columns of drives begin with.
_DRIVES = ("crank", "slide")
#: Columns of a log of a machine that is to be found.
_IN_LOGS = "t, 1 ... 6, x y z, and qw qx qy qz, rx ry rz or r11 ... r33"
#: Units of a log as they are read: lengths as written, angles in radians if the heading says so.
_AS_WRITTEN = FileUnits("", 1.0, frozenset())


@dataclass(frozen=True, eq=False)
class Log:
    """The numbers of a log, as written; NaN where a cell is blank."""

    #: Of the six legs, shape (n, 6), and of one point of the platform, shape (n, 3).
    lengths: Array
    positions: Array
    #: Angles, shape (n, 3), or rotations, shape (n, 3, 3).
    turns: Array
    #: Units that the heading names; empty if it names none.
    leg_unit: str
    place_unit: str
    #: That of angles, ``deg`` or ``rad``, if it names it: these are read as radians then.
    angle_unit: str
    #: The order of the axes that the heading says; None if it says none.
    order: str | None
    #: The headings of angles that do not name their axes, such as A, B, C; empty for others.
    heads: tuple[str, ...]
    #: Where each row stands, for people: its t or its number.
    lines: tuple[str, ...]

    @property
    def has_angles(self) -> bool:
        """Whether rotations are stated by angles."""
        return self.turns.ndim == 2

    @property
    def whole(self) -> NDArray[np.bool_]:
        """Which rows have six lengths and a full pose, shape (n,)."""
        turns = self.turns.reshape(len(self.turns), -1)
        numbers = np.hstack((self.lengths, self.positions, turns))
        return np.asarray(np.isfinite(numbers).all(axis=1))


def read_log(
    text: str, name: str, ignore: tuple[str, ...] = (), columns: tuple[str, ...] = ()
) -> Log:
    """Read a log: CSV with the columns 1 to 6, x y z and a rotation; cells may be blank.

    The name is for messages; columns of `ignore` are left out, `columns` stand for a heading.

    Raises
    ------
    SpecError
        With all mistakes, each with line and column.
    """
    table = NumberTable(text, name, _AS_WRITTEN, ignore, columns)
    table.check()
    legs = table.choose(_NUMBERS)
    places = table.choose(POSITION)
    turns = table.choose(QUATERNION, ANGLES, ENTRIES)
    table.refuse_others({"t", *_NUMBERS, *COLUMNS}, _IN_LOGS)
    table.check()
    assert legs is not None
    assert places is not None
    assert turns is not None
    units = [_unit(table, group) for group in (legs, places, turns)]
    lengths, positions, numbers = (
        table.numbers(group, blanks=True) for group in (legs, places, turns)
    )
    if turns != ANGLES:
        numbers = _rotations(table, turns, numbers, PoseFormat())
    lines = _lines(table)
    table.check()
    order = order_of(table.names) if turns == ANGLES else None
    return Log(
        lengths,
        positions,
        numbers,
        units[0],
        units[1],
        "" if not units[2] else "rad" if units[2].lower().startswith("rad") else "deg",
        order.sequence if order else None,
        tuple(table.names[table.heading.index(one)] for one in ANGLES) if order else (),
        lines,
    )


def _unit(table: NumberTable, columns: Sequence[str]) -> str:
    """Return the unit that the heading names for columns; one that some lack is that of all."""
    found = [table.unit(name) for name in columns]
    named = list(dict.fromkeys(unit for unit in found if unit))
    if len(named) > 1 or (named and columns == ANGLES and "" in found):
        what = listed(columns, "and")
        table.note_heading(
            f"found the units {listed(map(repr, found), 'and')} of {what}, expected the same"
        )
    return named[0] if named else ""


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

    The name is for messages; the form has the conventions of poses that the file does not state;
    targets are points in the platform's frame, (3,), by name.

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
    lines = _lines(table)
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
        lines,
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
    model = Model.of(instance, drives=True)
    names = [drive.drive_name for drive in model.drives]
    sorts = {drive.sort for drive in model.drives}
    what = {"crank": "cranks", "slide": "slides"}[sorts.pop()] if len(sorts) == 1 else "drives"
    for name, one in written.items():
        if name not in names:
            known = listed(names) if names else f"no {name.partition('.')[0]}s, for SPEC has none"
            table.note_column(one, f"found {shown(one)}, expected {known}")
    if lacking := [one for one in names if one not in written]:
        table.note_heading(f"the columns of {what} lack {listed(lacking, 'and')}")
    if table.mistakes:
        return None
    return np.asarray(table.numbers(names, blanks=True) * model.drive_units)


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
    return positions, _rotations(table, columns, numbers, form)


def _rotations(
    table: NumberTable, columns: Sequence[str], numbers: Array, form: PoseFormat
) -> Array:
    """Return rotations, NaN in rows without a whole one; note those that are none."""
    rotations = np.full((len(numbers), 3, 3), np.nan)
    whole = np.flatnonzero(np.isfinite(numbers).all(axis=1))
    rotations[whole], wrong = rotations_of(numbers[whole], form)
    for row, message in wrong:
        table.note_cell(int(whole[row]), columns[0], message)
    return rotations


def _lines(table: NumberTable) -> tuple[str, ...]:
    """Return where each row stands, for people: its t or its number."""
    numbers = [str(k + 1) for k in range(len(table))]
    texts = table.texts("t") if "t" in table.heading else [""] * len(table)
    return tuple(text or number for text, number in zip(texts, numbers, strict=True))


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


def check_points(
    instance: Instance, names: Iterable[str], targets: Mapping[str, object], where: str
) -> None:
    """Raise if a name is neither that of a point of the platform nor of a target."""
    known = [row.platform_name for row in instance.constraints if row.kind.platform.value == "P"]
    for name in names:
        if name not in known and name not in targets:
            message = (
                f"found the unknown point {shown(name)}, expected a point of the platform, or "
                f"where it is on the target{suggestion(name, known)}"
            )
            raise ArgumentError(message, where)
