"""A platform and its assembly modes as the content of a file: a page, or a drawing."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import ArgumentError
from gspcli.geometry.frames import IDENTITY, PoseFrame
from gspcli.geometry.home_mode import distances
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import quaternion_from_rotation
from gspcli.motion.files.number_tables import NumberTable, wrong_number
from gspcli.motion.files.pose_files import COLUMNS, PoseFormat, poses_in
from gspcli.motion.poses.mode_filters import chosen_mode
from gspcli.pictures.line_drawings import View, drawing
from gspcli.pictures.page import number, page
from gspcli.pictures.scene import Scene
from gspcli.pictures.stage import Poses, scene_of
from gspcli.solver import SolveResult, solve
from gspcli.ties import first_smallest
from gspcli.wording import listed, shown

Array = NDArray[np.float64]


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
    facts: dict[str, list[float | str]] = {
        key: [cell if wrong_number(cell) else float(cell) for cell in table.texts(key)]
        for key in _FACTS
        if key in table.heading
    }
    tracks = []
    for mode in dict.fromkeys(cells):
        every = [row for row, cell in enumerate(cells) if cell == mode]
        # The last pose is shown: there the motion ends.
        places = [*range(0, len(every) - 1, -(-len(every) // MOST_POSES)), len(every) - 1]
        rows = [every[place] for place in places]
        tracks.append(
            Poses(
                f"Trajectory of mode {mode}" if mode else "Trajectory",
                "pose",
                poses.R[rows],
                poses.T[rows],
                facts={key: [column[row] for row in rows] for key, column in facts.items()},
                parameter=(
                    parameter or "row",
                    np.array(places) + 1.0 if way is None else way[rows],
                ),
                conditions=None if conditions is None else conditions[rows],
                coordinates=tuple(moving),
                places=coordinates[rows],
                note=f"{len(rows)} of {len(every)} poses are shown." if rows != every else "",
            )
        )
    return tracks


def _conditions(table: NumberTable) -> Array:
    """Return the column of condition numbers, infinite where it is empty."""
    column = []
    for row, cell in enumerate(table.texts(_CONDITION)):
        infinite = cell.lower() in _INFINITE
        if message := "" if infinite else wrong_number(cell):
            table.note_cell(row, _CONDITION, message)
        column.append(math.inf if infinite or message else float(cell))
    return np.array(column)


_PAGE, _DRAWINGS = "html", ("svg", "png", "pdf")


def view(
    platform: Instance | SolveResult,
    fmt: str = _PAGE,
    *,
    mode: int | None = None,
    all_modes: bool = False,
    seen_from: tuple[float, float] | None = None,
    names: bool = True,
    live: bool = False,
) -> bytes:
    """Return the content of a file that shows a platform, as `gsp view` writes it.

    Parameters
    ----------
    platform
        It is solved, or what `gspcli.solve` has found.
    fmt
        ``html`` for the page, which has all modes; ``svg``, ``png`` or ``pdf`` for a drawing
        (needs matplotlib).
    mode
        The number of the real pose that is shown (first); home if None.
    all_modes
        Of a drawing, whether there is a panel for each mode.
    seen_from
        Azimuth and elevation, degrees.
    names
        Whether primitives and constraints are named in the picture.
    live
        Whether the page solves again when values or the pose are moved.

    Raises
    ------
    ArgumentError
        If there is no such format, or it is no page and is to be live.
    GspError
        If there is no such mode, or a page cannot solve this platform.
    """
    if fmt not in (_PAGE, *_DRAWINGS):
        raise ArgumentError(f"found {shown(fmt)}, expected {listed((_PAGE, *_DRAWINGS))}", "fmt")
    if live and fmt != _PAGE:
        raise ArgumentError(f"found a {fmt} that is to be live, expected {_PAGE}", "fmt")
    result = solve(platform) if isinstance(platform, Instance) else platform
    seen = None if seen_from is None else View(*seen_from)
    start = 0
    if mode is not None or result.home is not None:
        start = chosen_mode(mode, result.home, result.drawn.counts.real) - 1
    return viewed(result, fmt, start, all_modes=all_modes, view=seen, names=names, live=live)[1]


def viewed(
    result: SolveResult,
    fmt: str,
    start: int,
    *,
    all_modes: bool = False,
    view: View | None = None,
    names: bool = True,
    live: bool = False,
    tracks: Sequence[Poses] = (),
    summary: str = "",
    frame: PoseFrame = IDENTITY,
) -> tuple[Scene, bytes]:
    """Return the scene of a result and the content of a file that shows it.

    Parameters
    ----------
    result, fmt, all_modes, names, live
        As for the function `view`.
    start
        The index of the real pose that is shown (first).
    view
        From where it is seen first; a usual one if None.
    tracks, summary
        Of a page, as for `scene_of`.
    frame
        Of a page, the frame in which poses are expressed beside the platform's own. Sliders of a
        live page move the pose there.
    """
    if fmt == _PAGE:
        scene = _expressed(scene_of(result, tracks, summary=summary), frame)
        if live:
            from gspcli.pictures.live_numbers import live_numbers, live_page

            text = live_page(scene, live_numbers(result), start, view, names=names, frame=frame)
        else:
            text = page(
                scene, start, _first_series(scene, tracks, result, start), view, names=names
            )
        return scene, text.encode()
    alone = not all_modes and result.drawn.counts.real > 0
    scene = scene_of(result, only=start if alone else None)
    return scene, drawing(scene, fmt, range(len(scene.series[0])), view, names=names)


def _expressed(scene: Scene, frame: PoseFrame) -> Scene:
    """Return a scene in which each pose has what it is expressed as among its facts."""
    if frame.is_identity:
        return scene
    series = []
    for one in scene.series:
        R, T = frame.from_platform(one.R, one.T)
        numbers = {"expressed x, y, z": T, "expressed qw, qx, qy, qz": quaternion_from_rotation(R)}
        size = {"expressed x, y, z": scene.size}
        facts = {
            name: [", ".join(number(x, size.get(name, 1.0)) for x in row) for row in rows.tolist()]
            for name, rows in numbers.items()
        }
        series.append(replace(one, facts={**one.facts, **facts}))
    return replace(scene, series=tuple(series))


def _first_series(
    scene: Scene, tracks: Sequence[Poses], result: SolveResult, start: int
) -> int | None:
    """Return the series that the page opens on: the trajectory that begins nearest to a mode."""
    if not tracks:
        return None
    drawn = result.drawn
    before, nearest = len(scene.series) - len(tracks), 0
    if drawn.counts.real:
        R, T = (np.stack([getattr(one, part)[0] for one in tracks]) for part in "RT")
        moved, turned = distances(R, T, drawn.R[start].real, drawn.T[start].real)
        nearest = int(first_smallest(np.hypot(moved / drawn.arrangement.length, turned)))
    return before + nearest
