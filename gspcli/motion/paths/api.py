"""Planning of paths: the Python function, with the checks of its arguments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gspcli.defaults import PATH_SECONDS, SEED
from gspcli.errors import ArgumentError
from gspcli.geometry.instance import Instance
from gspcli.motion.paths.ends import End, Modes
from gspcli.motion.paths.mode_groups import ModeGroups
from gspcli.motion.paths.mode_groups import mode_groups as groups_of
from gspcli.motion.paths.planned_paths import PlannedPath
from gspcli.motion.paths.planner import Planner
from gspcli.motion.paths.timing import PathLimits


def path(
    instance: Instance,
    start: End,
    goal: End,
    *,
    along: str | None = None,
    clear: float = 0.0,
    gap: float | None = None,
    time: float = PATH_SECONDS,
    seed: int = SEED,
    pivot: Sequence[float] | None = None,
    sequence: str = "ZYX",
    speed: float | Mapping[str, float] | None = None,
    acceleration: float | Mapping[str, float] | None = None,
) -> PlannedPath:
    """Plan a path from one pose to another that is proved on the whole way.

    No pose of the path is singular, and all of them keep the ranges and cones that the instance
    states. If it is proved that there is no such path, the answer says why.

    Parameters
    ----------
    instance
        The platform with its limits.
    start, goal
        A mode by its number of `solve`, ``home``, or a pose (R, T).
    along
        Whether the ``values`` change linearly between the corners of the path, or position and
        angles (``poses``). None tries both straight ways; paths with corners are along values if
        each value has a range, else along poses. With cranks or slides ``values`` are the numbers
        of all drives, and paths with corners are along poses.
    clear
        The clearance that every pose must have, in the units of `clearance`; with cranks or slides
        that of the drives.
    gap
        How far legs and bodies must be apart at every pose, in the unit of length; the instance
        must state their shapes. None for no such limit.
    time
        After this many seconds no more paths are tried. The bytes of a path that is found do not
        depend on it.
    seed
        The seed of all random numbers: the same seed gives the same path.
    pivot, sequence
        The point of the platform, in its frame, and the order of the axes of the angles of straight
        ways of poses.
    speed, acceleration
        Limits on the whole way, also between rows; then the rows have times in seconds. A number is
        of each motor, in the unit of its value a second (squared). By name: of the ``motors``, of
        the ``platform``'s pivot, and of its ``turn`` in the unit of angles; the last two are proved
        on ways of poses.

    Raises
    ------
    ArgumentError
        If an argument is wrong.

    Examples
    --------
    >>> import gspcli
    >>> platform = gspcli.example("workspace-study")
    >>> found = gspcli.path(platform, "home", 3)
    >>> found.verdict, found.along
    ('proved', 'values')
    >>> gspcli.path(platform, "home", 2).reason
    'the sign of det J differs, and a regular path keeps it'
    """
    limits = PathLimits.of(speed, acceleration)
    planner = _planner(instance, along, clear, time, seed, pivot, sequence, limits, gap)
    modes = Modes(instance)
    return planner.path(modes.end(start, "start"), modes.end(goal, "goal"))


def mode_groups(
    instance: Instance,
    *,
    along: str | None = None,
    time: float = PATH_SECONDS,
    seed: int = SEED,
) -> ModeGroups:
    """Return which assembly modes belong together, joined by proved paths.

    Parameters and errors are those of `path`.

    Examples
    --------
    >>> import gspcli
    >>> gspcli.motion.mode_groups(gspcli.example("rubin-m2"))
    <ModeGroups of Rubin Observatory M2 hexapod: 2 modes, 2 groups>
    """
    return groups_of(_planner(instance, along, 0.0, time, seed, None, "ZYX"))


def _planner(
    instance: Instance,
    along: str | None,
    clear: float,
    time: float,
    seed: int,
    pivot: Sequence[float] | None,
    sequence: str,
    limits: PathLimits | None = None,
    gap: float | None = None,
) -> Planner:
    if not (np.isfinite(time) and time >= 0):
        message = f"found {time}, expected seconds, not negative"
        raise ArgumentError(message, "time")
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        message = f"found {seed!r}, expected a whole number, not negative"
        raise ArgumentError(message, "seed")
    return Planner(
        instance, along=along, clear=clear, seconds=time, seed=int(seed), pivot=pivot,
        sequence=sequence, limits=limits,
        gap=gap,
    )  # fmt: skip
