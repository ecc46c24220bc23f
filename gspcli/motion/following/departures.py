"""Rows at which a mode that follows a file of poses is at another pose than the file."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import vector_from_rotation
from gspcli.motion.following.tracks import Track
from gspcli.records import dataclass

#: Two poses are different if an angle (radians) or a shift (in lengths of the platform) is larger
#: than this.
_LEAST = 1e-6
#: Near singular poses rounding errors of values move a pose further: by its condition number times
#: this, and not by more than that.
_ROUNDING, _MOST = 1e3 * float(np.finfo(float).eps), 1e-3


@dataclass(frozen=True)
class Departure:
    """A row at which a mode is not at the pose of the file.

    Attributes
    ----------
    mode
        The number of the mode.
    row
        The row of the file, from 0.
    t
        The number of the row there.
    distance
        Between the origins of the platform at the two poses, in the unit of length.
    turn
        The angle between the two orientations, in radians.
    """

    mode: int
    row: int
    t: float
    distance: float
    turn: float

    def to_json(self, in_radians: float) -> dict[str, Any]:
        """Return the departure as plain data; rows are counted from 1.

        Parameters
        ----------
        in_radians
            The unit of angles.
        """
        return {
            "mode": self.mode,
            "row": self.row + 1,
            "t": self.t,
            "distance": self.distance,
            "turn": self.turn / in_radians,
        }


def departures(track: Track, R: ArrayLike, T: ArrayLike) -> list[Departure]:
    """Return the rows at which modes are not at the poses whose values they were followed along.

    Values that change linearly between two poses which are far apart can lead a mode to another
    pose with the same values. Only modes that begin at the first pose are compared. If no mode
    begins there, the mode that begins nearest to it is compared.

    Parameters
    ----------
    track
        The followed modes. Its rows are those of the poses, or have equally many rows between two
        of these.
    R, T
        The n poses, shapes (n, 3, 3) and (n, 3).

    Returns
    -------
    list
        In the order of the modes, then of the rows. Rows at which a mode does not exist are left
        out: `Track.ends` has these modes.
    """
    R, T = np.asarray(R, float), np.asarray(T, float)
    if not len(track.modes) or not len(T):
        return []
    step = max(1, (len(track.t) - 1) // max(1, len(T) - 1))
    there_R, there_T = track.R[:, ::step], track.T[:, ::step]
    with np.errstate(invalid="ignore"):
        distances = np.linalg.norm(there_T - T, axis=-1)
        turns = np.linalg.norm(
            vector_from_rotation(np.swapaxes(R, -1, -2) @ np.nan_to_num(there_R)), axis=-1
        )
        length = Arrangement.of(track.instance).length
        apart = np.maximum(distances / length, turns)
        allowed = np.clip(_ROUNDING * track.conditions[:, ::step], _LEAST, _MOST)
        other = apart > allowed
    begin = np.flatnonzero(~other[:, 0] & ~np.isnan(distances[:, 0]))
    if not len(begin):
        first = np.where(np.isnan(apart[:, 0]), np.inf, apart[:, 0])
        begin = np.array([int(first.argmin())])
    return [
        Departure(
            int(track.modes[mode]),
            row,
            float(track.t[row * step]),
            float(distances[mode, row]),
            float(turns[mode, row]),
        )
        for mode in begin.tolist()
        for row in np.flatnonzero(other[mode]).tolist()
    ]
