"""Trajectories to look at: the table that `gsp track` writes, or any like it."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np

from gspcli.errors import Location, Problem, SpecError
from gspcli.geometry.coordinates import BODIES
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.pictures.shown_poses import Poses

#: Names of the columns of a pose; those of `gsp solve` are accepted too.
_POSITION = (("x", "y", "z"), ("tx", "ty", "tz"))
_QUATERNION = ("qw", "qx", "qy", "qz")
#: What moves the platform: the first of these that there is, else the number of the row.
_PARAMETERS = ("t", "row")
_MODE = "mode"
#: What coordinates that move begin with.
_MOVING = tuple(f"{word}." for word in (*BODIES, "crank"))
#: Numbers or words said of each pose where there are such columns.
_FACTS = ("clearance", "pose_clearance", "certified", "status")
#: Longer tracks are thinned: a page cannot show more poses one after the other.
MOST_POSES = 2000
_MOST_PROBLEMS = 20


@dataclass(frozen=True)
class _Row:
    line: int
    cells: Mapping[str, str]

    def has(self, names: Iterable[str]) -> bool:
        return all(self.cells.get(name, "") for name in names)


def read_tracks(text: str, name: str) -> list[Poses]:
    """Read trajectories from CSV with a heading, one for each value of the column ``mode``.

    Needed are ``x y z`` (or ``Tx Ty Tz``) and ``qw qx qy qz``, for
    ``x_base = R x_platform + T``. ``t`` or ``row`` says where a pose lies on its way,
    ``condition``, ``clearance``, ``certified`` and ``status`` what else is known of it. Columns
    such as ``base.B1.x`` or ``crank.B1`` are coordinates that move; other ones are left out. Rows
    without a pose, where a mode has ended, are skipped.

    Parameters
    ----------
    text, name
        The content, and how messages name it.

    Raises
    ------
    SpecError
        With all mistakes, each with its line.
    """
    reader = csv.DictReader(_lines(text), restval="")
    written = [cell.strip() for cell in reader.fieldnames or ()]
    # Names of primitives may differ in capitals only.
    heading = [cell if cell.lower().startswith(_MOVING) else cell.lower() for cell in written]
    reader.fieldnames = heading
    position = next((names for names in _POSITION if {*names} <= {*heading}), None)
    if position is None or not {*_QUATERNION} <= {*heading}:
        message = (
            f"found the columns {' '.join(heading) or '(none)'}, "
            "expected x y z qw qx qy qz and perhaps t, mode, condition, clearance"
        )
        raise SpecError([Problem(Location(name, 1, 1), "", message)])
    pose = (*position, *_QUATERNION)
    rows = []
    for row in reader:
        cells = {key: str(value).strip() for key, value in row.items() if key}
        rows.append(_Row(reader.line_num, cells))
    placed = [row for row in rows if row.has(pose)]
    modes = list(dict.fromkeys(row.cells.get(_MODE, "") for row in placed))
    problems = list(islice(_problems(placed, pose, heading, name), _MOST_PROBLEMS))
    if problems:
        raise SpecError(problems)
    if not placed:
        message = "found no row with a pose"
        raise SpecError([Problem(Location(name, 1, 1), "", message)])
    return [
        _track(mode, [row for row in placed if row.cells.get(_MODE, "") == mode], pose, heading)
        for mode in modes
    ]


def _lines(text: str) -> list[str]:
    """Return the lines with comments emptied, so that the others keep their numbers."""
    return ["" if line.startswith("#") else line for line in text.splitlines()]


def _problems(
    rows: Sequence[_Row], pose: Sequence[str], heading: Sequence[str], name: str
) -> Iterator[Problem]:
    moving = _moving(heading)
    numeric = [*pose, *(key for key in (*_PARAMETERS, "condition") if key in heading), *moving]
    for row in rows:
        location = Location(name, row.line, 1)
        wrong = False
        for key in numeric:
            cell = row.cells.get(key, "")
            needed = key in pose or key in _PARAMETERS or key in moving
            if _number(cell) is None and (needed or cell):
                wrong = True
                yield Problem(location, key, f"found {cell!r}, expected a number")
        if not wrong and not any(_number(row.cells[key]) for key in _QUATERNION):
            yield Problem(location, "", "found a quaternion of length zero")


def _moving(heading: Sequence[str]) -> list[str]:
    """Return the columns that name coordinates."""
    return [key for key in heading if key.lower().startswith(_MOVING)]


def _number(cell: str) -> float | None:
    try:
        value = float(cell)
    except ValueError:
        return None
    return None if math.isnan(value) else value


def _track(mode: str, rows: list[_Row], pose: Sequence[str], heading: Sequence[str]) -> Poses:
    every = len(rows)
    step = -(-every // MOST_POSES)
    # The last pose stays: it is where the motion ends.
    kept = rows[::step] if (every - 1) % step == 0 else [*rows[::step], rows[-1]]
    numbers = np.array([[float(row.cells[key]) for key in pose] for row in kept])
    quaternions = numbers[:, 3:] / np.abs(numbers[:, 3:]).max(axis=1, keepdims=True)
    parameter = next((key for key in _PARAMETERS if key in heading), "row")
    values = np.array(
        [
            float(row.cells[parameter]) if parameter in heading else 1.0 + index * step
            for index, row in enumerate(kept)
        ]
    )
    conditions = None
    if "condition" in heading:
        given = [_number(row.cells.get("condition", "")) for row in kept]
        conditions = np.array([math.inf if value is None else value for value in given])
    facts = {
        key: [_fact(row.cells.get(key, "")) for row in kept] for key in _FACTS if key in heading
    }
    moving = _moving(heading)
    note = f"Every {step}th of {every} poses is shown." if step > 1 else ""
    return Poses(
        f"Trajectory of mode {mode}" if mode else "Trajectory",
        "pose",
        rotation_from_quaternion(quaternions),
        numbers[:, :3],
        facts=facts,
        parameter=(parameter, values),
        conditions=conditions,
        coordinates=tuple(moving),
        places=np.array([[float(row.cells[key]) for key in moving] for row in kept]),
        note=note,
    )


def _fact(cell: str) -> float | str:
    number = _number(cell)
    return cell if number is None or math.isinf(number) else number
