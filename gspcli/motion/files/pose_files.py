"""Poses in files and on the command line: CSV with a heading, or the output of `gsp solve`.

Rotations are quaternions (scalar first, of any length), three angles about axes, or the nine
entries of R by rows; the position is that of one point of the platform, the pivot.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from gspcli.errors import Location, Mistake, SpecError
from gspcli.geometry.euler import euler_from_rotation, rotation_from_euler
from gspcli.geometry.frames import IDENTITY, PoseFrame
from gspcli.geometry.instance import Array
from gspcli.geometry.numbers import LARGEST
from gspcli.geometry.quaternions import quaternion_from_rotation, rotation_from_quaternion
from gspcli.motion.files.number_tables import FileUnits, NumberTable, check, order_of, wrong_number
from gspcli.records import dataclass
from gspcli.wording import shown

#: Columns: the position of the pivot, that of the frame; a quaternion, angles, the entries of R.
POSITION = ("x", "y", "z")
TRANSLATION = ("tx", "ty", "tz")
QUATERNION = ("qw", "qx", "qy", "qz")
ANGLES = ("rx", "ry", "rz")
ENTRIES = tuple(f"r{i}{j}" for i in "123" for j in "123")
#: All columns of a pose.
COLUMNS = (*POSITION, *TRANSLATION, *QUATERNION, *ANGLES, *ENTRIES)
_DRIVE = re.compile(r"(crank|slide)\..+", re.IGNORECASE)
#: Largest difference of the entries of R from those of a rotation, since they are often rounded to
#: three decimals. The nearest rotation is taken.
ROUNDED = 1e-3


def _nothing(_: str) -> None:
    """Say nothing of a file."""


@dataclass(frozen=True)
class PoseFormat:
    """The conventions that a pose file does not state."""

    #: The order of the axes of rx, ry and rz, as `rotation_from_euler` takes it; None if there are
    #: none.
    euler: str | None = None
    #: The point whose position x, y and z are, in the platform's frame, or that of the tool; length
    #: units.
    pivot: tuple[float, float, float] = (0.0, 0.0, 0.0)
    #: The unit of rx, ry and rz.
    in_radians: float = 1.0
    #: The name of the unit of lengths; empty if it does not matter.
    length: str = ""
    #: Columns that are left out; ``*`` in a name stands for any text
    #: (`gspcli.motion.files.number_tables`).
    ignore: tuple[str, ...] = ()
    #: The frame in which poses are expressed.
    frame: PoseFrame = IDENTITY
    #: The names of the columns of a file without a heading.
    columns: tuple[str, ...] = ()
    #: Takes messages about a file, such as the order of axes in its heading.
    note: Callable[[str], None] = _nothing

    @property
    def pivot_frame(self) -> PoseFrame:
        """The frame in which poses are expressed, with its origin at the pivot."""
        return self.frame.at(self.pivot)

    @property
    def units(self) -> FileUnits:
        """The units to which numbers of files are converted."""
        return FileUnits(self.length, self.in_radians)

    def of(self, table: NumberTable) -> PoseFormat:
        """Return the format with the order of axes that a heading says: roll, pitch, yaw."""
        order = order_of(table.names) if {*ANGLES} <= {*table.heading} else None
        if self.euler is not None or order is None:
            return self
        self.note(order.words)
        return replace(self, euler=order.sequence)


@dataclass(frozen=True, eq=False)
class PoseTable:
    """Poses, one a row."""

    #: The column t, shape (n,), or None if there is none.
    t: Array | None
    #: Rotations (n, 3, 3) and translations (n, 3): ``x_base = R x_platform + T``.
    R: Array
    T: Array


def read_poses(text: str, name: str, form: PoseFormat) -> PoseTable:
    """Read a list of poses.

    CSV has a heading with ``x y z`` (or ``Tx Ty Tz``, as `gsp solve` writes them) and one of
    ``qw qx qy qz``, ``rx ry rz`` or ``r11 … r33``, and perhaps ``t``. Values and what `gsp` writes
    beside poses are left out. Columns that are not known are mistakes. JSON is what `gsp solve`
    prints. Headings of other programs are read where they have one meaning
    (`gspcli.motion.files.number_tables`): ``X [mm]``, ``Roll``, ``Pitch``, ``Yaw``, ``Time``.

    Parameters
    ----------
    text, name
        The content, and how messages name it.
    form
        What the file does not say.

    Raises
    ------
    SpecError
        With all mistakes, each with line and column.
    """
    if text.lstrip()[:1] in ("{", "["):
        return _read_json(text, name, form)
    table = NumberTable(text, name, form.units, form.ignore, form.columns)
    poses = poses_in(table, form, measured_columns(table))
    table.check()
    assert poses is not None
    return poses


def measured_columns(table: NumberTable) -> set[str]:
    """Return the columns of values and drives, which tables of paths have beside their poses."""
    return {*"123456", *(name for name in table.heading if _DRIVE.fullmatch(name))}


def has_poses(text: str, name: str, form: PoseFormat) -> bool:
    """Return whether the heading of a file is that of poses; else it is that of values."""
    if text.lstrip()[:1] in ("{", "["):
        return True
    return names_poses(NumberTable(text, name, ignore=form.ignore, columns=form.columns))


def names_poses(table: NumberTable) -> bool:
    """Return whether a table has the columns of positions."""
    return any({*names} <= set(table.heading) for names in (POSITION, TRANSLATION))


def poses_in(table: NumberTable, form: PoseFormat, more: Collection[str] = ()) -> PoseTable | None:
    """Return the poses of a table; None if it has no columns of poses.

    Mistakes are noted in the table; the numbers of a pose with a mistake are meaningless.

    Parameters
    ----------
    table, form
        The table, and what it does not say.
    more
        Columns besides those of poses and those that `gsp` writes that are known.
    """
    form = form.of(table)
    position = table.choose(POSITION, TRANSLATION)
    rotation = table.choose(QUATERNION, ANGLES, ENTRIES)
    if position == TRANSLATION:
        refuse_own_pose(table, form)
    if rotation is not None and rotation != ANGLES and form.euler:
        table.note_heading(f"found {' '.join(rotation)}, expected rx ry rz with an Euler sequence")
    if rotation == ANGLES and form.euler is None:
        table.note_heading(
            "found rx ry rz without the order of the axes: say it with --euler, such as ZYX or xyz"
        )
    table.refuse_others({"t", *COLUMNS, *more}, "t, x y z, and qw qx qy qz or rx ry rz")
    timed = ["t"] if "t" in table.heading else []
    times, points, turns = table.groups(timed, position or (), rotation or ())
    if rotation is None or (rotation == ANGLES and form.euler is None):
        return None
    whole = np.flatnonzero(np.isfinite(turns).all(axis=1))
    R = np.full((len(turns), 3, 3), np.nan)
    R[whole], wrong = rotations_of(turns[whole], form)
    for row, message in wrong:
        table.note_cell(int(whole[row]), rotation[0], message)
    if position is None:
        return None
    # As in instance files: products of such numbers are finite.
    for row, axis in np.argwhere(np.abs(points) > LARGEST).tolist():
        message = f"found {points[row, axis]:g}, expected a magnitude up to {LARGEST:g}"
        table.note_cell(row, position[axis], message)
    return PoseTable(times[:, 0] if timed else None, *form.pivot_frame.to_platform(R, points))


def refuse_own_pose(table: NumberTable, form: PoseFormat) -> None:
    """Note columns Tx Ty Tz, the pose of the platform's own frame, where others are expressed."""
    if form.frame.is_identity:
        if any(form.pivot):
            table.note_heading("found Tx Ty Tz, the pose of the frame; expected x y z with a pivot")
        return
    message = "found Tx Ty Tz, the pose of the platform's own frame; expected x y z: "
    table.note_heading(message + form.frame.words)


def read_pose(text: str, form: PoseFormat, name: str = "--pose") -> PoseTable:
    """Read one pose: x,y,z and a quaternion, three angles or nine entries, between commas.

    Parameters
    ----------
    text
        The numbers.
    form
        What they do not say.
    name
        The option that they were given with.

    Raises
    ------
    SpecError
        With what is wrong.
    """
    names, numbers = pose_numbers(text, name)
    heading = ",".join(names)
    row = ",".join(repr(number) for number in numbers)
    try:
        return read_poses(f"{heading}\n{row}", name, form)
    except SpecError as error:
        # An option has no lines.
        raise SpecError([Mistake(None, name, one.message) for one in error.mistakes]) from None


def pose_columns(count: int) -> tuple[str, ...] | None:
    """Return the columns of a pose with this many numbers, or None if there are none."""
    names = {7: QUATERNION, 6: ANGLES, 12: ENTRIES}.get(count)
    return None if names is None else (*POSITION, *names)


def pose_numbers(text: str, name: str) -> tuple[tuple[str, ...], list[float]]:
    """Return the columns of a pose on the command line and its numbers; see `read_pose`."""
    cells = [cell for cell in re.split(r"[,;\s]+", text.strip()) if cell]
    names = pose_columns(len(cells))
    if names is None:
        message = (
            f"found {len(cells)} numbers in {shown(text)}, expected x,y,z and qw,qx,qy,qz; or "
            "rx,ry,rz (with --euler); or the nine entries of R"
        )
        raise SpecError([Mistake(None, name, message)])
    check(
        [
            Mistake(None, f"{name}: {key}", message)
            for key, cell in zip(names, cells, strict=True)
            if (message := wrong_number(cell))
        ]
    )
    return names, [float(cell) for cell in cells]


def poses_of(numbers: Array, form: PoseFormat) -> tuple[Array, Array]:
    """Return poses (R, T) of rows of numbers: positions of the pivot, then rotations.

    Parameters
    ----------
    numbers
        Shape (n, 6), (n, 7) or (n, 12), as the columns of a file of poses.
    form
        What they do not say.
    """
    R, _ = rotations_of(numbers[:, 3:], form)
    return form.pivot_frame.to_platform(R, numbers[:, :3])


def numbers_of_pose(R: Array, T: Array, form: PoseFormat) -> list[float]:
    """Return a pose as numbers: the position of the pivot, then angles or a quaternion.

    Parameters
    ----------
    R, T
        The pose, shapes (3, 3) and (3,).
    form
        The pivot, and the order of the axes of angles; without one it is a quaternion.
    """
    R, at = form.pivot_frame.from_platform(R, T)
    if form.euler is None:
        return [*at.tolist(), *quaternion_from_rotation(R).tolist()]
    return [*at.tolist(), *(euler_from_rotation(form.euler, R) / form.in_radians).tolist()]


def rotations_of(numbers: Array, form: PoseFormat) -> tuple[Array, list[tuple[int, str]]]:
    """Return rotations (n, 3, 3) of rows of numbers, and the mistakes of rows."""
    wrong: list[tuple[int, str]] = []
    if numbers.shape[1] == len(ANGLES):
        assert form.euler is not None
        return rotation_from_euler(form.euler, numbers * form.in_radians), wrong
    if numbers.shape[1] == len(QUATERNION):
        sizes = np.abs(numbers).max(axis=1, initial=0.0, keepdims=True)
        wrong += [
            (int(row), "found a quaternion of length zero, expected that of a rotation")
            for row in np.flatnonzero(sizes == 0)
        ]
        # Numbers are divided by their size, so that no square under- or overflows.
        scaled = np.where(sizes > 0, numbers / np.where(sizes > 0, sizes, 1.0), 1.0)
        return rotation_from_quaternion(scaled), wrong
    given = numbers.reshape(-1, 3, 3)
    left, _, right = np.linalg.svd(given)
    R = left @ right
    errors = np.abs(R - given).max(axis=(1, 2))
    for row in np.flatnonzero((errors > ROUNDED) | (np.linalg.det(R) < 0)):
        what = (
            f"a matrix {errors[row]:.1g} away from the nearest orthogonal one"
            if errors[row] > ROUNDED
            else "a matrix with determinant -1"
        )
        wrong.append((int(row), f"found {what}, expected a rotation"))
    return R, wrong


def _read_json(text: str, name: str, form: PoseFormat) -> PoseTable:
    try:
        # Integers of any length are read as floats, which may be infinite.
        document = json.loads(text, parse_int=float)
    except json.JSONDecodeError as error:
        message = f"not JSON: {error.msg}"
        raise SpecError(
            [Mistake(Location(name, error.lineno, error.colno), "", message)]
        ) from error
    except RecursionError:
        message = (
            "found lists that are nested too deeply, expected what gsp solve --format json prints"
        )
        raise SpecError([Mistake(Location(name, 1, 1), "", message)]) from None
    entries = document.get("solutions") if isinstance(document, dict) else None
    if not isinstance(entries, list):
        message = "found no list of solutions, expected CSV or what gsp solve --format json prints"
        raise SpecError([Mistake(Location(name, 1, 1), "", message)])
    mistakes: list[Mistake] = []
    if any(form.pivot) or form.euler:
        message = "found what gsp solve prints, which has neither a pivot nor Euler angles"
        mistakes.append(Mistake(None, name, message))
    poses = []
    for number, entry in enumerate(entries, 1):
        pose = _pose(entry)
        if isinstance(pose, str):
            mistakes.append(Mistake(None, f"{name}: solutions[{number}]", pose))
        else:
            poses.append(pose)
    check(mistakes)
    R = np.array([R for R, _ in poses]).reshape(-1, 3, 3)
    return PoseTable(None, R, np.array([T for _, T in poses]).reshape(-1, 3))


def _pose(entry: Any) -> tuple[Array, Array] | str:
    """Return the pose of an entry, or the mistake in it."""
    if not isinstance(entry, dict):
        return f"found {shown(str(entry))}, expected a pose with R and T"
    if entry.get("real") is False:
        return "found a pose that is not real, expected a real one: leave out --all"
    parts: list[Array] = []
    for key, shape in (("R", (3, 3)), ("T", (3,))):
        try:
            part = np.array(entry[key], dtype=float)
        except (KeyError, TypeError, ValueError):
            part = np.array(np.nan)
        if part.shape != shape or not np.isfinite(part).all():
            return f"found no {key} of {' x '.join(map(str, shape))} finite numbers"
        parts.append(part)
    R, wrong = rotations_of(parts[0].reshape(1, 9), PoseFormat())
    return wrong[0][1] if wrong else (R[0], parts[1])


def pivot_from_text(text: str) -> tuple[float, float, float]:
    """Return the point that a text such as ``0,0,-12.5`` names.

    Raises
    ------
    SpecError
        If it is not three numbers.
    """
    parts: Sequence[str] = text.split(",")
    try:
        x, y, z = (float(part) for part in parts)
    except ValueError:
        x = y = z = np.nan
    if not np.isfinite([x, y, z]).all():
        message = f"found {shown(text)}, expected the three coordinates of a point: x,y,z"
        raise SpecError([Mistake(None, "--pivot", message)])
    return x, y, z
