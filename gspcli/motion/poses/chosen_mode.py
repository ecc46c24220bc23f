"""The choice of a real pose: by its number, or home."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gspcli.errors import GspError
from gspcli.wording import counted

if TYPE_CHECKING:
    from gspcli.geometry.home_mode import HomeMode


def chosen_mode(mode: int | None, home: HomeMode | None, count: int) -> int:
    """Return the number of the real pose that is asked for.

    Parameters
    ----------
    mode
        Its number, from 1; None for home.
    home
        The home mode, if there is one.
    count
        How many real poses there are.

    Raises
    ------
    GspError
        If there is no such pose.
    """
    if home is None:
        message = "the platform has no real pose for its values (gsp solve says why)"
        raise GspError(message)
    if mode is None:
        return home.number
    if not 1 <= mode <= count:
        message = f"found mode {mode}, expected one of the {counted(count, 'real pose')}"
        raise GspError(message)
    return mode
