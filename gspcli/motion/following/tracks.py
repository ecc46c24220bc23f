"""Assembly modes along a trajectory: their events, all their poses, and where a file has others."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import field
from functools import cached_property
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.coordinates import Coordinate, drive_corrections, moved
from gspcli.geometry.frames import IDENTITY, PoseFrame
from gspcli.geometry.instance import Instance
from gspcli.geometry.measurement import condition_numbers, printed_conditions
from gspcli.geometry.quaternions import quaternion_from_rotation, vector_from_rotation
from gspcli.records import Tabular, dataclass
from gspcli.wording import counted

Array = NDArray[np.float64]
#: Columns of a pose.
POSE = ("x", "y", "z", "qw", "qx", "qy", "qz")
_NOTHING: Mapping[str, Array] = MappingProxyType({})
#: Two poses are different if an angle (radians) or a shift (in lengths of the platform) is larger
#: than this.
_LEAST = 1e-6
#: Near singular poses rounding errors of values move a pose further: by its condition number times
#: this, and not by more than that.
_ROUNDING, _MOST = 1e3 * float(np.finfo(float).eps), 1e-3


@dataclass(frozen=True, eq=False)
class Event:
    """The end or the beginning of a mode.

    Attributes
    ----------
    kind
        ``fold``: it is proved that the mode and its partner meet and vanish. ``undecided``: the
        mode was followed up to here, and was neither continued nor proved to end.
    reason
        For an undecided event what was observed at its pose: lines of a DLL become parallel, the
        platform goes far away, or the pose is nearly singular.
    begins
        Whether the mode begins here instead of ending.
    mode
        Its number.
    row
        The row (from 0) before the event.
    low, high
        An interval of t: for a fold it is proved to contain the fold, otherwise it leads from the
        last point of the mode to the next row.
    R, T
        The pose, shapes (3, 3) and (3,); of a fold the singular one. Not finite where the platform
        goes to infinity.
    partner
        The number of the mode that vanishes with it, if that mode was followed.
    partner_R, partner_T
        The pose of the partner at the row before (after, if it begins); None if not found.
    """

    kind: Literal["fold", "undecided"]
    reason: str
    begins: bool
    mode: int
    row: int
    low: float
    high: float
    R: Array
    T: Array
    partner: int | None = None
    partner_R: Array | None = None
    partner_T: Array | None = None

    def to_json(self) -> dict[str, Any]:
        """Return the event as plain data; rows are counted from 1."""
        return {
            "kind": self.kind,
            "reason": self.reason,
            "begins": self.begins,
            "mode": self.mode,
            "partner": self.partner,
            "row": self.row + 1,
            "t": [self.low, self.high],
            "R": _finite(self.R),
            "T": _finite(self.T),
            "partner_R": None if self.partner_R is None else self.partner_R.tolist(),
            "partner_T": None if self.partner_T is None else self.partner_T.tolist(),
        }


@dataclass(frozen=True, eq=False)
class Track(Tabular):
    """Assembly modes along a trajectory.

    Attributes
    ----------
    instance
        Geometry and units, as given.
    followed
        The instance with points for lines of a DLL that stay parallel all along.
    t, values
        The rows, shapes (r,) and (r, 6); the values, with the offsets of the instance added, change
        linearly between them.
    modes
        The numbers of the modes as `solve` orders them for the values of the instance
        (`gspcli.motion.following.trajectories`); modes that are new at the first row, or begin
        later, have the next numbers. Shape (m,).
    R, T
        Poses, shapes (m, r, 3, 3) and (m, r, 3); NaN where a mode does not exist or was not
        followed.
    certified
        Whether every part of every mode is proved to be one branch with no other branch near it.
    events
        The ends of modes, and with ``everything`` also their beginnings.
    complete
        Whether, with ``everything``, the modes at the last row are exactly the real poses there.
    segments
        The number of proved (or followed) parts of all modes.
    poses_at_end
        With ``everything``: all real poses (R, T) at the last row, found without following.
    known
        The number of real poses for the values of the instance; modes with larger numbers are new.
    coordinates, places
        The c coordinates that move, and their numbers at each row, shape (r, c).
    """

    instance: Instance
    followed: Instance
    t: Array
    values: Array
    modes: NDArray[np.int64]
    R: Array
    T: Array
    certified: bool
    events: tuple[Event, ...]
    complete: bool | None
    segments: int
    poses_at_end: tuple[Array, Array] | None = None
    known: int = 0
    coordinates: tuple[Coordinate, ...] = ()
    places: Array = field(default_factory=lambda: np.zeros((0, 0)))

    def __post_init__(self) -> None:
        for array in (self.t, self.values, self.modes, self.R, self.T, self.places):
            array.setflags(write=False)

    def __repr__(self) -> str:
        how = "proved" if self.certified else "not proved"
        kinds = self.instance.name or self.instance.type.id
        size = f"{counted(len(self.modes), 'mode')}, {counted(len(self.t), 'row')}"
        return f"<Track of {kinds}: {size}, {how}, {counted(len(self.events), 'event')}>"

    def instances(self) -> Iterator[tuple[slice, Instance]]:
        """Yield runs of rows, each with the instance that is followed; its values are not used."""
        if not self.coordinates:
            yield slice(None), self.followed
            return
        for k, place in enumerate(self.places):
            yield slice(k, k + 1), moved(self.followed, self.coordinates, place)

    @cached_property
    def readings(self) -> Array:
        """The numbers of `places` as in files: cranks and slides as readings, shape (r, c)."""
        added, times = drive_corrections(self.instance, self.coordinates)
        if not added.any() and (times == 1).all():
            return self.places
        return (self.places - added) / times

    @cached_property
    def conditions(self) -> Array:
        """Condition numbers of the poses, shape (m, r); NaN where there is none.

        The unit of length is the size of the given instance, at all rows.
        """
        length = Arrangement.of(self.instance).length
        conditions = np.full(self.T.shape[:2], np.nan)
        there = ~np.isnan(self.T[..., 0])
        for rows, instance in self.instances():
            here = np.zeros(there.shape, bool)
            here[:, rows] = there[:, rows]
            conditions[here] = condition_numbers(
                Arrangement.of(instance), self.R[here], self.T[here], length
            )
        return conditions

    @cached_property
    def quaternions(self) -> Array:
        """Unit quaternions of the rotations, shape (m, r, 4), continuous along each mode.

        The first one of a mode has the sign of `quaternion_from_rotation`.
        """
        return continuous_quaternions(self.R)

    def rows(
        self, more: Mapping[str, Array] = _NOTHING, frame: PoseFrame = IDENTITY
    ) -> list[dict[str, Any]]:
        """Return a row for each pose, as plain data.

        Parameters
        ----------
        more
            Further columns, each of shape (m, r).
        frame
            The frame in which poses are expressed.
        """
        keys = ("t", "mode", *POSE, "condition", *more)
        conditions = printed_conditions(self.conditions)
        R, T = frame.from_platform(self.R, self.T)
        quaternions = self.quaternions if R is self.R else continuous_quaternions(R)
        numbers = np.dstack((T, quaternions, conditions, *more.values()))
        there = ~np.isnan(self.T[..., 0])
        modes = self.modes.tolist()
        return [
            dict(zip(keys, (t, mode, *pose), strict=True))
            for t, poses, known in zip(
                self.t.tolist(), numbers.swapaxes(0, 1).tolist(), there.T.tolist(), strict=True
            )
            for mode, pose, here in zip(modes, poses, known, strict=True)
            if here
        ]

    def to_json(
        self, rows: list[dict[str, Any]] | None = None, frame: PoseFrame = IDENTITY
    ) -> dict[str, Any]:
        """Return the track as plain data of schema ``gsp.track/1``, without ranges and cones.

        Parameters
        ----------
        rows
            Those of `rows`, perhaps with more columns.
        frame
            The frame in which their poses are expressed; R and T of events are the platform's.
        """
        return {
            "schema": "gsp.track/1",
            **self.instance.to_json(),
            "certified": self.certified,
            "complete": self.complete,
            "modes": self.modes.tolist(),
            "new": self.new,
            "coordinates": {
                one.name: self.readings[:, k].tolist() for k, one in enumerate(self.coordinates)
            },
            "parts": self.segments,
            **({} if frame.is_identity else {"frames": frame.to_json()}),
            "poses": self.rows(frame=frame) if rows is None else rows,
            "events": [event.to_json() for event in self.events],
        }

    @property
    def new(self) -> list[int]:
        """The numbers of modes at the first row that do not occur for the instance's values."""
        there = ~np.isnan(self.T[:, 0, 0]) if self.T.shape[1] else np.zeros(0, bool)
        return [mode for mode in self.modes[there].tolist() if mode > self.known]

    @property
    def ends(self) -> tuple[Event, ...]:
        """The events at which a mode ends."""
        return tuple(event for event in self.events if not event.begins)


def continuous_quaternions(R: Array) -> Array:
    """Return unit quaternions of rotations, shape (m, r, 4), continuous along each mode."""
    quaternions = np.full((*R.shape[:2], 4), np.nan)
    there = ~np.isnan(R[..., 0, 0])
    quaternions[there] = quaternion_from_rotation(R[there])
    turns = np.einsum("mri,mri->mr", quaternions[:, 1:], quaternions[:, :-1])
    signs = np.where(turns < 0, -1.0, 1.0).cumprod(axis=1)
    quaternions[:, 1:] *= signs[..., None]
    return quaternions


def _finite(part: Array) -> Any:
    """Return a part of a pose; None for a pose at infinity."""
    return part.tolist() if np.isfinite(part).all() else None


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
