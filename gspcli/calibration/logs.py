"""Logs of a machine: lengths of its legs and poses as columns, in conventions not yet known."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gspcli.motion.files.headings import FileUnits, order_of
from gspcli.motion.files.number_tables import NumberTable
from gspcli.motion.files.pose_files import (
    ANGLES,
    COLUMNS,
    ENTRIES,
    POSITION,
    QUATERNION,
    PoseFormat,
    rotations_of,
)
from gspcli.records import dataclass
from gspcli.wording import listed

Array = NDArray[np.float64]

LEGS = tuple("123456")
_EXPECTED = "t, 1 ... 6, x y z, and qw qx qy qz, rx ry rz or r11 ... r33"
#: Units of a log as they are read: lengths as written, angles in radians if the heading says so.
_AS_WRITTEN = FileUnits("", 1.0, frozenset())


@dataclass(frozen=True, eq=False)
class Log:
    """The numbers of a log, as written; NaN where a cell is blank.

    Attributes
    ----------
    lengths
        Of the six legs, shape (n, 6).
    positions
        Of one point of the platform, shape (n, 3).
    angles
        About x, y and z, shape (n, 3); None if the log has rotations.
    rotations
        Shape (n, 3, 3); None if the log has angles.
    leg_unit, place_unit
        Units that the heading names; empty if it names none.
    angle_unit
        That of angles, ``deg`` or ``rad``, if it names it: these are read as radians then.
    order
        The order of the axes that the heading says; None if it says none.
    heads
        The headings of angles that do not name their axes, such as A, B, C; empty for others.
    lines
        Where each row stands, for people: its t or its number.
    """

    lengths: Array
    positions: Array
    angles: Array | None
    rotations: Array | None
    leg_unit: str
    place_unit: str
    angle_unit: str
    order: str | None
    heads: tuple[str, ...]
    lines: tuple[str, ...]

    @property
    def turns(self) -> Array:
        """The numbers of rotations, shape (n, 3) or (n, 9)."""
        if self.rotations is not None:
            return self.rotations.reshape(-1, 9)
        assert self.angles is not None
        return self.angles

    @property
    def whole(self) -> NDArray[np.bool_]:
        """Which rows have six lengths and a full pose, shape (n,)."""
        numbers = np.hstack((self.lengths, self.positions, self.turns))
        return np.asarray(np.isfinite(numbers).all(axis=1))


def read_log(
    text: str, name: str, ignore: tuple[str, ...] = (), columns: tuple[str, ...] = ()
) -> Log:
    """Read a log: CSV with the columns 1 to 6, x y z and a rotation; cells may be blank.

    Parameters
    ----------
    text, name
        The content, and how messages name it.
    ignore
        Columns that are left out.
    columns
        The names of the columns of a log without a heading.

    Raises
    ------
    SpecError
        With all mistakes, each with line and column.
    """
    table = NumberTable(text, name, _AS_WRITTEN, ignore, columns)
    table.check()
    legs = table.choose(LEGS)
    places = table.choose(POSITION)
    turns = table.choose(QUATERNION, ANGLES, ENTRIES)
    table.refuse_others({"t", *LEGS, *COLUMNS}, _EXPECTED)
    table.check()
    assert legs is not None
    assert places is not None
    assert turns is not None
    units = [_unit(table, group) for group in (legs, places, turns)]
    lengths, positions, numbers = (
        table.numbers(group, blanks=True) for group in (legs, places, turns)
    )
    rotations = None
    if turns != ANGLES:
        rotations = _rotations(table, turns, numbers)
    lines = [str(k + 1) for k in range(len(table))]
    if "t" in table.heading:
        lines = [text or line for text, line in zip(table.texts("t"), lines, strict=True)]
    table.check()
    order = None if rotations is not None else order_of(table.names)
    return Log(
        lengths,
        positions,
        numbers if rotations is None else None,
        rotations,
        units[0],
        units[1],
        "" if not units[2] else "rad" if units[2].lower().startswith("rad") else "deg",
        order.sequence if order else None,
        tuple(table.names[table.heading.index(one)] for one in ANGLES) if order else (),
        tuple(lines),
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


def _rotations(table: NumberTable, columns: Sequence[str], numbers: Array) -> Array:
    """Return rotations, NaN in rows without one; note those that are none."""
    rotations = np.full((len(numbers), 3, 3), np.nan)
    whole = np.flatnonzero(np.isfinite(numbers).all(axis=1))
    rotations[whole], wrong = rotations_of(numbers[whole], PoseFormat())
    for row, message in wrong:
        table.note_cell(int(whole[row]), columns[0], message)
    return rotations
