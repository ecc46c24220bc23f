"""The real poses of a platform, for commands that need one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gspcli.cli.mode_option import chosen
from gspcli.cli.progress_bars import working
from gspcli.errors import GspError, IncompleteError, NotFiniteError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from gspcli.cli.mode_option import Mode
    from gspcli.geometry.instance import Instance

    Array = NDArray[np.float64]


def one_mode(instance: Instance, mode: Mode | None) -> tuple[int, Array, Array]:
    """Return the number of a mode and its pose, shapes (1, 3, 3) and (1, 3); by default home."""
    from gspcli.geometry.home_mode import home_mode

    R, T = real_poses(instance)
    number = chosen(mode, home_mode(instance, R, T), len(R))
    return number, R[number - 1 : number], T[number - 1 : number]


def mode_number(instance: Instance, mode: Mode | None) -> int:
    """Return the number of a mode. For home it is found, and printed on stderr."""
    return mode if isinstance(mode, int) else one_mode(instance, mode)[0]


def real_poses(instance: Instance) -> tuple[Array, Array]:
    """Return the real poses in the order of `gsp solve`, shapes (n, 3, 3) and (n, 3); at least one.

    Raises
    ------
    GspError
        If there is none.
    NotFiniteError, IncompleteError
        If the poses are infinitely many, or could not all be found, so that they have no numbers.
    """
    from gspcli.solver import solve

    with working("solving"):
        result = solve(instance)
    if result.verdict == "infinite":
        message = "the poses of the platform are infinitely many\ngive one with --pose"
        raise NotFiniteError(message)
    if result.verdict != "complete":
        message = "the poses of the platform could not all be found\ngive one with --pose"
        raise IncompleteError(message)
    R, T = result.R[result.real].real, result.T[result.real].real
    if not len(R):
        message = (
            "the platform has no real pose for its values\n"
            "give a pose with --pose, or other values (gsp solve says which contradict each other)"
        )
        raise GspError(message)
    return R, T
