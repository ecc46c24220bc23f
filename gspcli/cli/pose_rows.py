"""The poses that a command is given: modes, one pose, or the rows of a file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from gspcli.cli.pose_options import text_of
from gspcli.cli.progress_bars import working
from gspcli.cli.real_poses import mode_number, one_mode, real_poses
from gspcli.errors import GspError, IncompleteError
from gspcli.records import dataclass

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from gspcli.cli.mode_option import Mode
    from gspcli.cli.pose_type import GivenPose
    from gspcli.geometry.instance import Instance
    from gspcli.motion import PoseFormat, Track

    Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class AskedPoses:
    """Poses, and what to call them.

    Attributes
    ----------
    R, T
        The poses, shapes (n, 3, 3) and (n, 3).
    modes
        The number of the mode of each, if it has one.
    rows, t
        The number of its row in the file, from 1, and t there; None without a file.
    lost
        Modes that end before the last row of a file of values, in words.
    """

    R: Array
    T: Array
    modes: list[int | None]
    rows: list[int] | None = None
    t: list[float] | None = None
    lost: tuple[str, ...] = ()

    def named(self, k: int) -> dict[str, Any]:
        """Return what a pose is called, as data."""
        names: dict[str, Any] = {}
        if self.rows is not None and self.t is not None:
            names = {"row": self.rows[k], "t": self.t[k]}
        return {**names, "mode": self.modes[k]}

    def place(self, k: int) -> str:
        """Return what a pose is called, in words: ``in row 7 (t = 1.5), mode 2``."""
        words = []
        if self.rows is not None and self.t is not None:
            words.append(f"in row {self.rows[k]} (t = {self.t[k]:.6g})")
        if self.modes[k] is not None:
            words.append(f"in mode {self.modes[k]}" if not words else f"mode {self.modes[k]}")
        return ", ".join(words) or "there"

    def stated_drives(self, instance: Instance) -> Array | None:
        """Return readings of the drives at modes, where all points are as stated, shape (n, m).

        None without cranks and slides, and for poses that are no modes.
        """
        from gspcli.geometry.drive_numbers import is_driven

        if not is_driven(instance) or None in self.modes:
            return None
        import numpy as np

        from gspcli.geometry.drives import Drives

        drives = Drives.of(instance)
        # A drive without a crank or slide is the value itself; it is not asked for here.
        return drives.readings(np.zeros((len(self.T), drives.count)))

    def check(self) -> None:
        """Raise `IncompleteError` if a mode was lost on the way."""
        if self.lost:
            raise IncompleteError("\n".join(self.lost))


def check_sources(
    spec: str,
    rows: str | None,
    mode: Mode | None,
    pose: GivenPose | None,
    near: GivenPose | None,
) -> None:
    """Raise if poses were asked for in more than one way."""
    given = {"--mode": mode, "--pose": pose, "--near": near}
    names = [name for name, option in given.items() if option is not None]
    if len(names) > 1:
        message = f"give either {' or '.join(names)}"
        raise click.UsageError(message)
    if near is not None and rows is None:
        message = "--near says which mode to follow: give it with ROWS"
        raise click.UsageError(message)
    if rows is not None and pose is not None:
        message = "give either ROWS or --pose"
        raise click.UsageError(message)
    if spec == rows == "-":
        message = "SPEC and ROWS cannot both be standard input"
        raise click.UsageError(message)


def asked_poses(
    instance: Instance,
    rows: str | None,
    mode: Mode | None,
    pose: GivenPose | None,
    near: GivenPose | None,
    form: PoseFormat,
) -> AskedPoses:
    """Return the poses of a file, the one that is given, or the real ones of the instance.

    Parameters
    ----------
    instance
        The platform.
    rows
        A file of poses, as `read_poses` takes it, or of values: then modes are followed along them.
    mode
        Only this mode, by its number of the instance; also along a file of values.
    pose
        This pose instead.
    near
        Only the mode nearest to this pose at the first row of a file of values.
    form
        How the numbers of a pose are meant: order of axes, pivot, units.
    """
    if rows is not None:
        return _of_file(instance, rows, mode, near, form)
    if pose is not None:
        R, T = pose.read(form)
        return AskedPoses(R[None], T[None], [None])
    if mode is not None:
        number, R, T = one_mode(instance, mode)
        return AskedPoses(R, T, [number])
    R, T = real_poses(instance)
    return AskedPoses(R, T, list(range(1, len(R) + 1)))


def _of_file(
    instance: Instance, path: str, mode: Mode | None, near: GivenPose | None, form: PoseFormat
) -> AskedPoses:
    from gspcli.motion import read_poses, read_values, track
    from gspcli.motion.files.pose_files import has_poses

    text, name = text_of(path)
    if has_poses(text, name, form):
        if mode is not None or near is not None:
            option = "--near" if mode is None else "--mode"
            message = f"{option}: found the poses of {name}, expected a file of values to follow"
            raise GspError(message)
        table = read_poses(text, name, form)
        if not len(table.R):
            message = f"{name}: found no poses, expected at least one"
            raise GspError(message)
        rows = list(range(1, len(table.R) + 1))
        t = [float(row) for row in rows] if table.t is None else table.t.tolist()
        return AskedPoses(table.R, table.T, [None] * len(rows), rows, t)
    values = read_values(text, name, instance, form)
    if values.coordinates:
        moving = ", ".join(values.coordinates)
        message = f"{name}: found {moving}, expected values only: the geometry stays as SPEC has it"
        raise GspError(message)
    modes = None if mode is None else [mode_number(instance, mode)]
    with working("following"):
        start = None if near is None else near.read(form)
        followed = track(instance, values.values, t=values.t, modes=modes, near=start)
    return _of_track(followed)


def _of_track(followed: Track) -> AskedPoses:
    """Return a pose for each row and each mode that there is."""
    import numpy as np

    if not len(followed.modes):
        message = "there is no real pose at the first row"
        raise GspError(message)
    rows, modes = np.nonzero(~np.isnan(followed.T[..., 0].T))
    return AskedPoses(
        followed.R[modes, rows],
        followed.T[modes, rows],
        followed.modes[modes].tolist(),
        (rows + 1).tolist(),
        followed.t[rows].tolist(),
        tuple(f"mode {one.mode} ends at t = {one.low:.10g} ({one.kind})" for one in followed.ends),
    )
