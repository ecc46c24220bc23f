"""Clearances of many poses, and of their values, with their table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.errors import ArgumentError
from gspcli.geometry.drive_numbers import is_driven
from gspcli.geometry.drives import Drives
from gspcli.geometry.instance import Instance
from gspcli.geometry.readings import readings_of
from gspcli.motion.poses.cranks import drive_values
from gspcli.motion.poses.inverse_kinematics import measure
from gspcli.motion.singularities import clearances, drive_clearances, pose_clearances
from gspcli.motion.singularities.clearances import Clearance
from gspcli.motion.singularities.drive_clearances import DriveClearance
from gspcli.motion.singularities.pose_clearances import PoseClearance
from gspcli.progress import Progress, silent
from gspcli.records import dataclass
from gspcli.wording import counted

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

#: The quantities that may change.
KINDS = ("values", "drives", "pose")


@dataclass(frozen=True, eq=False)
class Clearances:
    """Proved bounds of the clearances of n poses.

    Attributes
    ----------
    instance
        The platform.
    of
        The quantity that changes: one of `KINDS`.
    bounds
        The bounds of each pose.
    """

    instance: Instance
    of: str
    bounds: tuple[Clearance | DriveClearance | PoseClearance, ...]

    def __repr__(self) -> str:
        kinds = self.instance.name or self.instance.type.id
        least = f", at least {self.lower.min():.6g}" if len(self.bounds) else ""
        return f"<Clearances of {kinds}: {counted(len(self.bounds), 'pose')}{least}>"

    @cached_property
    def lower(self) -> Array:
        """Proved lower bounds: nothing singular is nearer, shape (n,); read-only."""
        return self._column("lower")

    @cached_property
    def upper(self) -> Array:
        """Distances of singularities that were found, else infinite, shape (n,); read-only."""
        return self._column("upper")

    def _column(self, name: str) -> Array:
        column = np.array([getattr(one, name) for one in self.bounds], dtype=float)
        column.setflags(write=False)
        return column

    def rows(self) -> list[dict[str, Any]]:
        """Return the bounds of each pose, as plain data."""
        return [_row(self.instance, one) for one in self.bounds]

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each pose, without places; imports pandas.

        The columns are lower, upper, ratio, and by and constraint, or, of drives, knees, dead_point
        and drive.
        """
        import pandas as pd

        last = ["knees", "dead_point", "drive"] if self.of == "drives" else ["by", "constraint"]
        columns = ["lower", "upper", "ratio", *last]
        return pd.DataFrame(self.rows(), columns=columns)

    def to_json(self, names: Sequence[Mapping[str, Any]] | None = None) -> dict[str, Any]:
        """Return everything as plain data of schema ``gsp.clearance/1``.

        Parameters
        ----------
        names
            The name of each pose; without names there is no ``mode``.
        """
        called = [{"mode": None}] * len(self.bounds) if names is None else names
        rows = [{**name, **row} for name, row in zip(called, self.rows(), strict=True)]
        head = {"schema": "gsp.clearance/1", **self.instance.to_json()}
        return {**head, "of": self.of, "modes": rows}


def clearance(
    instance: Instance,
    R: ArrayLike,
    T: ArrayLike,
    *,
    of: str | None = None,
    points: ArrayLike | None = None,
    refine: bool = False,
    progress: Progress = silent,
) -> Clearances:
    """Bound the change of values, drives or the pose before the pose meets a singularity.

    Parameters
    ----------
    instance
        The platform. If each constraint, or each drive, has a range, changes count in halves of
        them.
    R, T
        The poses, shapes (n, 3, 3) and (n, 3).
    of
        ``values``, ``drives`` or ``pose``: the quantity that changes. By default the drives of
        machines with cranks or slides, the values of others.
    points
        For ``pose``: the points of the platform, in its frame, whose displacements count, shape
        (m, 3); by default those of the distances.
    refine
        Whether to look for better bounds: a few seconds a pose; not of drives.
    progress
        Receives the number of each pose.

    Raises
    ------
    ArgumentError
        Naming what is wrong.
    """
    of = of or default_kind(instance)
    if of not in KINDS:
        message = f"found {of!r}, expected {' or '.join(KINDS)}"
        raise ArgumentError(message, "of")
    if points is not None and of != "pose":
        message = "points count for the clearance of a pose only"
        raise ArgumentError(message, "points")
    R, T = np.reshape(np.asarray(R, float), (-1, 3, 3)), np.reshape(np.asarray(T, float), (-1, 3))
    driven = is_driven(instance)
    if of == "pose" and driven:
        message = (
            "not known of the pose of a machine with cranks or slides, whose joints move with it: "
            "use drives"
        )
        raise ArgumentError(message, "of")
    if of == KINDS[0] and driven:
        return Clearances(instance, of, tuple(_with_drives_still(instance, R, T, refine, progress)))
    if of == KINDS[0]:
        weights = clearances.range_weights(instance)
        each = clearances.each_clearance(
            instance, R, T, weights=weights, refine=refine, progress=progress
        )
        return Clearances(instance, of, tuple(each))
    if of == "drives":
        moved = drive_clearances.each_drive_clearance(instance, R, T, progress=progress)
        return Clearances(instance, of, tuple(moved))
    poses = list(zip(R, T, strict=True))
    found = [
        pose_clearances.pose_clearance(instance, turn, place, points=points, refine=refine)
        for turn, place in progress(poses, total=len(poses), label="poses")
    ]
    return Clearances(instance, of, tuple(found))


def _with_drives_still(
    instance: Instance, R: Array, T: Array, refine: bool, progress: Progress
) -> Iterator[Clearance]:
    """Yield the clearances of values at poses, with cranks and slides still where they are.

    Raises
    ------
    ArgumentError
        If the drives do not reach a pose.
    """
    drives, q = drive_values(instance, R, T, along=False)
    unreached = np.isnan(q).any(axis=1)
    if unreached.any():
        message = f"the drives do not reach pose {int(unreached.argmax()) + 1}"
        raise ArgumentError(message, "R")
    for k in progress(range(len(q)), total=len(q), label="poses"):
        there = drives.instance_at(q[k])
        weights, one = clearances.range_weights(there), slice(k, k + 1)
        yield from clearances.each_clearance(there, R[one], T[one], weights=weights, refine=refine)


def default_kind(instance: Instance) -> str:
    """Return the quantity that changes by default: drives where motors move points, else values."""
    return "drives" if is_driven(instance) else "values"


def _row(instance: Instance, found: Clearance | DriveClearance | PoseClearance) -> dict[str, Any]:
    if isinstance(found, PoseClearance):
        return _of_pose(instance, found)
    if isinstance(found, DriveClearance):
        return _of_drives(instance, found)
    return _of_values(instance, found)


def _of_drives(instance: Instance, found: DriveClearance) -> dict[str, Any]:
    """Return the bounds of the clearance of one pose in its drives."""
    drives = Drives.of(instance)
    q, R, T = (None if part is None else part.tolist() for part in (found.q, found.R, found.T))
    return {
        "lower": found.lower,
        "knees": found.knees,
        "upper": _finite(found.upper),
        "dead_point": _finite(found.dead_point),
        "ratio": _finite(found.ratio),
        "drive": None if found.drive is None else drives.names[found.drive],
        "drives": None if q is None else drives.readings(np.array(q)).tolist(),
        "R": R,
        "T": T,
    }


def _finite(number: float) -> float | None:
    return number if number < float("inf") else None


def _of_values(instance: Instance, found: Clearance) -> dict[str, Any]:
    """Return the bounds of the clearance of one mode in its values."""
    row = _bounds(found.lower, found.upper, found.ratio)
    if found.values is None:
        return row
    readings = readings_of(instance, found.values).tolist()
    row |= {"by": "fold" if found.end is None else "end of range", "values": readings}
    if found.end is not None:
        row["constraint"] = found.end + 1
    if found.fold is not None:
        row |= {"R": found.fold.R.tolist(), "T": found.fold.T.tolist()}
    return row


def _of_pose(instance: Instance, found: PoseClearance) -> dict[str, Any]:
    """Return the bounds of the clearance of one pose."""
    row = _bounds(found.lower, found.upper, found.ratio)
    if found.R is None or found.T is None:
        return row
    values = measure(instance, found.R, found.T).tolist()
    pose = {"R": found.R.tolist(), "T": found.T.tolist()}
    return row | {"by": "singular pose", "values": values, **pose}


def _bounds(lower: float, upper: float, ratio: float) -> dict[str, Any]:
    """Return both bounds, and room for the place of the upper one."""
    return {
        "lower": lower,
        "upper": _finite(upper),
        "ratio": _finite(ratio),
        **dict.fromkeys(("by", "constraint", "values", "R", "T")),
    }
