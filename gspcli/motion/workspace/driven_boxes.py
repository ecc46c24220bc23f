"""The motors of a platform for boxes of poses: what the kernel needs, names, bounds, limits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import ArgumentError
from gspcli.geometry.drive_numbers import driven_points
from gspcli.geometry.drives import Drives
from gspcli.geometry.instance import Instance

Array = NDArray[np.float64]

#: A number is outside its range if it exceeds the range by more than this part of it.
_ROUNDING = 1e-12
#: Rods with one drive must need the same place of it, up to this part of the size.
_SAME = 1e-9
_ADVICE = (
    "\nwrite a machine of parallel rods as three distances (DPP) and three angles that stay "
    "constant"
)


class DrivenBoxes:
    """The cranks and slides of a platform, on given knees.

    Parameters
    ----------
    instance
        The platform.
    quaternion, pivot
        As for `gspcli.certification.numbers.limit_balls.limit_balls`.
    knees
        The signs of the gains, shape (6,).
    """

    def __init__(
        self, instance: Instance, quaternion: Array, pivot: Array, knees: NDArray[np.int64]
    ) -> None:
        # Ball arithmetic takes long to import; it is needed for proofs of boxes only.
        from gspcli.certification.numbers.drive_balls import drive_balls

        self.drives = drives = Drives.of(instance)
        self.rows: list[int] = np.flatnonzero(drives.driven).tolist()
        self.balls = drive_balls(instance, quaternion.tolist(), pivot.tolist(), knees.tolist())

    @property
    def ranged(self) -> list[int]:
        """The constraints whose motor has a range."""
        index, low = self.drives.index, self.drives.low
        return [k for k in self.rows if np.isfinite(low[index[k]])]

    def name(self, constraint: int) -> str:
        """Return what moves a point of a constraint, such as ``crank B2``."""
        return _name(self.drives, constraint)

    def point(self, constraint: int) -> str:
        """Return the name of the point that is moved."""
        (one,) = driven_points(self.drives.instance.constraints[constraint])
        return one.name or str(constraint + 1)

    def places(self, constraint: int, y: Array, x: Array) -> list[tuple[Array, Array, Array]]:
        """Return the points of platform and base that a rod joins, and a margin, shapes (3,).

        The point that the motor moves is between two returned places, or within the margin of one.
        The other point is that of the kernel.
        """
        assert self.balls is not None
        k = self.rows.index(constraint)
        middle, across, beside, _, first, last = self.balls.vectors[k, ..., 0]
        slide, on_platform = self.balls.sorts[k].tolist()
        none = np.zeros(3)
        found: list[tuple[Array, Array]]
        if not slide:
            margin = np.hypot(across, beside)
            found = [(middle, np.full(3, np.linalg.norm(across)) if on_platform else margin)]
        elif constraint in self.ranged:
            found = [(first, none), (last, none)]
        else:
            free = np.full(3, np.inf) if on_platform else np.where(across != 0, np.inf, 0.0)
            found = [(middle, free)]
        return [
            (point, x, margin) if on_platform else (y, point, margin) for point, margin in found
        ]

    def refuse_shared(self, R: Array, free: Sequence[str]) -> None:
        """Raise unless rods that share a drive need the same place of it at all poses that vary.

        Parameters
        ----------
        R
            The orientation, shape (3, 3).
        free
            The parameters that vary.
        """
        drives, instance = self.drives, self.drives.instance
        turning = any(name.startswith("r") for name in free)
        for drive in range(drives.count):
            first, *others = drives.users(drive)
            for k in others:
                rows = instance.constraints[first], instance.constraints[k]
                text = f"rods {first + 1} and {k + 1} share {self.name(k)}"
                if turning:
                    message = (
                        f"{text}: what such a machine reaches when it turns is not computed, "
                        "only its positions (x, y, z)"
                    )
                    raise ArgumentError(message + _ADVICE)
                y, x = (
                    a - b
                    for a, b in (
                        (rows[0].platform.point, rows[1].platform.point),
                        (rows[0].base.point, rows[1].base.point),
                    )
                )
                off = np.linalg.norm(R @ y - x) + abs(rows[0].value.value - rows[1].value.value)
                # The difference of points on one arm turns with it.
                own = y if drives.on_platform[k] else x
                if drives.sorts[drive] == "crank":
                    axis = np.cross(drives.across[k], drives.beside[k])
                    off += np.linalg.norm(np.cross(own, axis / np.linalg.norm(axis)))
                if off > _SAME * np.linalg.norm(np.concatenate((rows[0].platform.point, x, y))):
                    message = (
                        f"{text} and are not parallel at this orientation: what such a machine "
                        "reaches is computed only where they are"
                    )
                    raise ArgumentError(message + _ADVICE)


def knees_of(
    instance: Instance, R: Array | None = None, T: Array | None = None
) -> NDArray[np.int64]:
    """Return the knees of the stated home, or without one those of a pose, shape (6,).

    Raises
    ------
    ArgumentError
        If a drive does not reach the pose, or reaches it at two numbers equally near to the stated
        point.
    """
    drives = Drives.of(instance)
    stated = drives.home_knees
    if stated is not None:
        return stated
    assert R is not None
    assert T is not None
    return drives.knees(R, np.asarray(T, float), "home")


def drive_violations(drives: Drives, knees: NDArray[np.int64], R: Array, T: Array) -> Iterator[str]:
    """Yield the drives that do not reach a pose, or are out of range there, in words."""
    wanted = drives.wanted(R, T, knees)
    for k in np.flatnonzero(drives.driven).tolist():
        drive = drives.index[k]
        q, low, high = (float(x) for x in (wanted[k], drives.low[drive], drives.high[drive]))
        if np.isnan(q):
            yield f"rod {k + 1} does not reach {_name(drives, k)}"
        elif np.isfinite(low):
            room = _ROUNDING * max(abs(low), abs(high))
            if not low - room <= q <= high + room:
                here, first, last = (
                    float(drives.readings(np.full(drives.count, x))[drive]) for x in (q, low, high)
                )
                yield (
                    f"{_name(drives, k)} at {here:.6g} is outside its range from {first:.10g} to "
                    f"{last:.10g}"
                )


def _name(drives: Drives, constraint: int) -> str:
    name: str = drives.names[drives.index[constraint]]
    return name.replace(".", " ")
