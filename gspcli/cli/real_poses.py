"""The real poses of a platform, for commands that need one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gspcli.cli.progress_bars import working
from gspcli.errors import GspError, IncompleteError, NotFiniteError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from gspcli.geometry.instance import Instance

    Array = NDArray[np.float64]


def real_poses(instance: Instance, mode: int | None = None) -> tuple[Array, Array]:
    """Return the real poses in the order of `gsp solve`, shapes (n, 3, 3) and (n, 3); at least one.

    Parameters
    ----------
    instance
        The platform.
    mode
        One that must be among them, counted from 1; else None.

    Raises
    ------
    GspError
        If there is none, or no such one.
    NotFiniteError, IncompleteError
        If the poses are infinitely many, or could not all be found, so that they have no numbers.
    """
    from gspcli.solver import solve

    with working("solving"):
        result = solve(instance, certify=False)
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
    if mode is not None and mode > len(R):
        message = f"found mode {mode}, expected one of the {len(R)} real poses"
        raise GspError(message)
    return R, T
