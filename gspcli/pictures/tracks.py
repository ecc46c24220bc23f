"""Trajectories to look at: the table that `gsp track` writes, or any like it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from gspcli.motion.files.number_tables import NumberTable, wrong_number
from gspcli.motion.files.pose_files import COLUMNS, PoseFormat, poses_in
from gspcli.pictures.stage import Poses

#: What moves the platform: the first of these that there is, else the number of the row.
_PARAMETERS = ("t", "row")
_MODE = "mode"
_CONDITION = "condition"
#: How infinite condition numbers are written.
_INFINITE = ("", "inf", "infinity", "infinite")
#: What the names of drives begin with.
_MOVING = ("crank.", "slide.")
#: Numbers or words of each pose, if there are such columns.
_FACTS = ("clearance", "pose_clearance", "certified", "status")
#: Longer tracks are thinned: a page cannot show more poses one after the other.
MOST_POSES = 2000

Array = NDArray[np.float64]


def read_tracks(text: str, name: str, form: PoseFormat) -> list[Poses]:
    """Read trajectories from CSV with a heading, one for each value of the column ``mode``.

    Poses are as in `gspcli.motion.read_poses`. ``t`` or ``row`` says where a pose lies on its way,
    ``condition``, ``clearance``, ``certified`` and ``status`` what else is known of it. Columns
    such as ``crank.B1`` are drives that move. Columns that are not known are
    mistakes. Rows without a pose, where a mode has ended, are skipped.

    Parameters
    ----------
    text, name
        The content, and how messages name it.
    form
        What it does not say.

    Raises
    ------
    SpecError
        With all mistakes, each with line and column.
    """
    table = NumberTable(text, name, form.units, form.ignore, form.columns)
    table.leave_out_empty(COLUMNS)
    if not len(table) and not table.mistakes:
        table.note_heading("found no row with a pose")
    moving = [key for key in table.heading if key.lower().startswith(_MOVING)]
    parameter = next((key for key in _PARAMETERS if key in table.heading), None)
    poses = poses_in(table, form, {*moving, *"123456"})
    way = None if poses is None or parameter != "t" else poses.t
    if parameter == "row":
        way = table.numbers(["row"])[:, 0]
    coordinates = table.numbers(moving)
    conditions = _conditions(table) if _CONDITION in table.heading else None
    table.check()
    assert poses is not None
    cells = table.texts(_MODE) if _MODE in table.heading else [""] * len(table)
    facts = {key: table.texts(key) for key in _FACTS if key in table.heading}
    tracks = []
    for mode in dict.fromkeys(cells):
        every = [row for row, cell in enumerate(cells) if cell == mode]
        places = _thinned(len(every))
        rows = [every[place] for place in places]
        tracks.append(
            Poses(
                f"Trajectory of mode {mode}" if mode else "Trajectory",
                "pose",
                poses.R[rows],
                poses.T[rows],
                facts={key: [_fact(column[row]) for row in rows] for key, column in facts.items()},
                parameter=(
                    parameter or "row",
                    np.array(places) + 1.0 if way is None else way[rows],
                ),
                conditions=None if conditions is None else conditions[rows],
                coordinates=tuple(moving),
                places=coordinates[rows],
                note=_note(len(rows), len(every)),
            )
        )
    return tracks


def _thinned(count: int) -> list[int]:
    """Return which of this many poses are shown; the last one is: there the motion ends."""
    step = -(-count // MOST_POSES)
    return [*range(0, count - 1, step), count - 1]


def _note(shown: int, count: int) -> str:
    return f"{shown} of {count} poses are shown." if shown < count else ""


def _conditions(table: NumberTable) -> Array:
    """Return the column of condition numbers, infinite where it is empty."""
    column = []
    for row, cell in enumerate(table.texts(_CONDITION)):
        infinite = cell.lower() in _INFINITE
        if message := "" if infinite else wrong_number(cell):
            table.note_cell(row, _CONDITION, message)
        column.append(math.inf if infinite or message else float(cell))
    return np.array(column)


def _fact(cell: str) -> float | str:
    return cell if wrong_number(cell) else float(cell)
