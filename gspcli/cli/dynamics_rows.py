"""The poses of `gsp dynamics`, with their times and the motion of the platform there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gspcli.cli.mode_option import HOME
from gspcli.cli.pose_options import text_of
from gspcli.cli.pose_rows import asked_poses
from gspcli.cli.progress_bars import working
from gspcli.cli.real_poses import mode_number
from gspcli.errors import GspError, IncompleteError
from gspcli.records import dataclass

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from gspcli.cli.mode_option import Mode
    from gspcli.cli.pose_type import GivenPose
    from gspcli.dynamics.motion_files import ValueRows
    from gspcli.dynamics.trajectories import PoseRates
    from gspcli.geometry.instance import Instance
    from gspcli.motion import PoseFormat

    Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class AskedMotion:
    """Poses, and what to call them.

    Attributes
    ----------
    R, T
        The poses, shapes (n, 3, 3) and (n, 3).
    t
        Times, shape (n,), or None: then the platform stands still unless `motion` says more.
    motion
        How it moves there, or None if that is not given.
    modes
        Whether the poses are the modes of the instance.
    drives
        Readings of the drives, shape (n, m), of a platform with cranks or slides whose rows say
        where they are; None for the knees of home.
    """

    R: Array
    T: Array
    t: Array | None = None
    motion: PoseRates | None = None
    modes: tuple[int, ...] = ()
    drives: Array | None = None

    @property
    def how(self) -> str:
        """Where the accelerations come from, in words."""
        if self.motion is not None:
            return "velocities and accelerations as given"
        if self.t is not None:
            return "along quintic splines through the rows, least accurate at both ends"
        return "at rest" if len(self.T) == 1 or self.modes else "no column t: at rest at each row"

    @property
    def first_column(self) -> str:
        """What the rows are counted by."""
        return "mode" if self.modes else "t" if self.t is not None else "row"

    @property
    def labels(self) -> list[float]:
        """What is in the first column, n of them."""
        if self.t is not None:
            labels: list[float] = self.t.tolist()
            return labels
        return list(self.modes or range(1, len(self.T) + 1))

    def named(self, k: int) -> dict[str, Any]:
        """Return what a row is called, as data."""
        names: dict[str, Any] = {"row": k + 1}
        if self.t is not None:
            names["t"] = float(self.t[k])
        return {"mode": self.modes[k]} if self.modes else names

    def place(self, k: int) -> str:
        """Return what a row is called, in words: ``in row 7 (t = 1.5)``."""
        if self.modes:
            return f"in mode {self.modes[k]}"
        return f"in row {k + 1}" + ("" if self.t is None else f" (t = {self.t[k]:.6g})")


def start_of(
    instance: Instance, mode: Mode | None, pose: GivenPose | None, form: PoseFormat
) -> AskedMotion:
    """Return the one pose that a motion begins at."""
    return _without_file(instance, mode or HOME, pose, form)


def asked_rows(
    instance: Instance,
    rows: str | None,
    mode: Mode | None,
    pose: GivenPose | None,
    near: GivenPose | None,
    form: PoseFormat,
) -> AskedMotion:
    """Return the poses of a file, the one that is given, or the real ones of the instance."""
    from gspcli.dynamics.motion_files import PoseRows, read_rows

    if rows is None:
        return _without_file(instance, mode, pose, form)
    found = read_rows(*text_of(rows), instance, form)
    if isinstance(found, PoseRows):
        if mode is not None or near is not None:
            message = "--mode and --near are for files of values: this one says the poses"
            raise GspError(message)
        if not len(found.T):
            message = f"{rows}: found no poses, expected at least one"
            raise GspError(message)
        return AskedMotion(found.R, found.T, found.t, found.motion)
    return _followed(instance, found, mode, near, form)


def _without_file(
    instance: Instance, mode: Mode | None, pose: GivenPose | None, form: PoseFormat
) -> AskedMotion:
    found = asked_poses(instance, None, mode, pose, None, form)
    modes = tuple(mode for mode in found.modes if mode is not None)
    return AskedMotion(found.R, found.T, modes=modes, drives=found.stated_drives(instance))


def _followed(
    instance: Instance, rows: ValueRows, mode: Mode | None, near: GivenPose | None, form: PoseFormat
) -> AskedMotion:
    """Return the poses of one mode along rows of values."""
    from gspcli.dynamics.motion_files import motion_of_values
    from gspcli.motion import track

    start = None if near is None else near.read(form)
    modes = None if start is not None else [mode_number(instance, mode)]
    with working("following"):
        moving = dict(rows.coordinates)
        found = track(instance, rows.values, coordinates=moving, t=rows.t, modes=modes, near=start)
    if found.ends:
        (end,) = found.ends
        message = (
            f"mode {end.mode} ends at t = {end.low:.10g} ({end.kind}): there are no forces beyond\n"
            "end the rows before it (gsp track shows where it ends)"
        )
        raise IncompleteError(message)
    R, T = found.R[0], found.T[0]
    motion = None
    if rows.rates is not None and rows.second_rates is not None:
        motion = motion_of_values(instance, R, T, rows.rates, rows.second_rates)
    return AskedMotion(R, T, rows.t, motion, drives=rows.drives(instance))
