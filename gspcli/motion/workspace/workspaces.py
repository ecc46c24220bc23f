"""The poses that keep the ranges and cones of a platform: proved boxes, and their volume."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.euler import euler_from_rotation
from gspcli.geometry.instance import Instance
from gspcli.motion.workspace.pose_boxes import PARAMETERS, Keys, Levels, PoseBoxes, places
from gspcli.records import EqualByContent, dataclass

if TYPE_CHECKING:
    import pandas as pd

Array = NDArray[np.float64]

#: Relative error of volumes: they are sums of many products in floating point, far more accurate.
ROUNDING = 1e-9
#: Parameters that differ by less, in lengths of the platform and radians, are the same.
_SAME = 1e-7


@dataclass(frozen=True, eq=False)
class Workspace(EqualByContent):
    """The poses that keep all limits, enclosed between two sets of boxes.

    It is proved that every pose of an inner box keeps the limits, and that every pose outside the
    inner and the open boxes violates one.

    Attributes
    ----------
    boxes
        The platform, its home pose and its limits.
    free
        The parameters that vary, of `PARAMETERS`, d of them; the others are those of home.
    connected
        Whether only the part counts that is connected with home by poses that are not singular.
    bounds
        The box that was divided, shape (d, 2); lengths, and radians.
    inner_keys, inner_levels, open_keys, open_levels
        Boxes by their keys in the grid of their level.
    judged
        The number of boxes that were tested.
    """

    boxes: PoseBoxes
    free: tuple[str, ...]
    connected: bool
    bounds: Array
    inner_keys: Keys
    inner_levels: Levels
    open_keys: Keys
    open_levels: Levels
    judged: int

    def __repr__(self) -> str:
        low, high = self.volume
        kinds = self.instance.name or self.instance.type.id
        return f"<Workspace of {kinds}: {low:.6g} to {high:.6g} {self.measure}>"

    def rows(self) -> list[dict[str, Any]]:
        """Return the extent of the set in each parameter, as plain data."""
        rows = []
        for name, ends in zip(self.free, self.extents.tolist(), strict=True):
            (low, high), (least, most) = (
                [None if end != end else end for end in pair] for pair in ends
            )
            row = {"name": name, "least": least, "lowest": low, "highest": high, "most": most}
            rows.append(row)
        return rows

    def to_frame(self) -> pd.DataFrame:
        """Return the extent of the set in each parameter (pandas is imported now)."""
        import pandas as pd

        return pd.DataFrame(self.rows())

    def to_json(self) -> dict[str, Any]:
        """Return the numbers of the volume that `gsp workspace` prints, as plain data."""
        low, high = self.volume
        return {
            "volume": {"lower": low, "upper": high, "unit": self.measure, "gap": self.gap},
            "extents": self.rows(),
            "inner": len(self.inner_keys),
            "open": len(self.open_keys),
            "judged": self.judged,
        }

    @property
    def instance(self) -> Instance:
        """The platform."""
        return self.boxes.instance

    @cached_property
    def units(self) -> Array:
        """The divisors that convert parameters to the units of the instance, shape (d,)."""
        radian = self.instance.units.angle.in_radians
        return np.array([radian if name.startswith("r") else 1.0 for name in self.free])

    @cached_property
    def inner(self) -> Array:
        """Boxes of poses that keep all limits, in the units of the instance, shape (n, d, 2)."""
        return self._corners(self.inner_keys, self.inner_levels) / self.units[:, None]

    @cached_property
    def open(self) -> Array:
        """Undecided boxes, shape (n, d, 2); together with the inner boxes they contain the set."""
        return self._corners(self.open_keys, self.open_levels) / self.units[:, None]

    @cached_property
    def volume(self) -> tuple[float, float]:
        """Proved bounds of the volume, in the units that `measure` names."""
        inner = self._volume(self.inner_keys, self.inner_levels)
        rest = self._volume(self.open_keys, self.open_levels)
        return inner * (1 - ROUNDING), (inner + rest) * (1 + ROUNDING)

    @property
    def gap(self) -> float:
        """The difference of the bounds of the volume, relative to the upper one; 0 if that is 0."""
        low, high = self.volume
        return (high - low) / high if high else 0.0

    @property
    def measure(self) -> str:
        """The unit of the volume.

        If all three angles vary it is the share of all rotations, by the measure that no rotation
        changes.
        """
        units = self.instance.units
        lengths = sum(name in "xyz" for name in self.free)
        angles = len(self.free) - lengths
        parts = [_power(units.length, lengths)] if lengths else []
        if angles == 3:
            parts.append("of all rotations")
        elif angles:
            parts.append(_power(units.angle.value, angles))
        return " ".join(parts)

    @cached_property
    def extents(self) -> Array:
        """The extent of the set in each parameter, proved from both sides, shape (d, 2, 2).

        The first pair is the interval that the inner boxes span, the second one that contains the
        set; NaN if there are no boxes.
        """
        found = np.full((len(self.free), 2, 2), np.nan)
        for k, boxes in enumerate((self.inner, np.concatenate((self.inner, self.open)))):
            if len(boxes):
                found[:, k, 0] = boxes[:, :, 0].min(axis=0)
                found[:, k, 1] = boxes[:, :, 1].max(axis=0)
        return found

    def judged_at(self, points: ArrayLike) -> NDArray[np.int8]:
        """Return the place of points: 1 in an inner box, 0 in an open one, -1 outside, shape (n,).

        Parameters
        ----------
        points
            Values of the free parameters, in the units of the instance, shape (n, d). Angles may be
            any that give the rotation, the middle one beyond a right angle, too.
        """
        given = self._as_bounded(np.asarray(points, float) * self.units)
        low, high = self.bounds.T
        found = np.full(len(given), -1, np.int8)
        with np.errstate(divide="ignore", invalid="ignore"):
            part = (given - low) / (high - low)
        within = ((part >= 0) & (part <= 1)).all(axis=1)
        bits = np.uint64(64 // len(self.free))
        for keys, levels, sign in (
            (self.open_keys, self.open_levels, 0),
            (self.inner_keys, self.inner_levels, 1),
        ):
            for level in np.unique(levels):
                side = 2.0**level
                place = np.minimum(np.where(within[:, None], part, 0) * side, side - 1)
                key = np.zeros(len(given), np.uint64)
                for d in range(len(self.free)):
                    key |= place[:, d].astype(np.uint64) << np.uint64(d * int(bits))
                found[within & np.isin(key, keys[levels == level])] = sign
        return found

    def _as_bounded(self, given: Array) -> Array:
        """Return the same poses with angles by whole turns near the middle of their bounds.

        Each rotation has two triples of angles; that with the middle angle within a right angle.
        """
        given = given.copy()
        turns = [k for k, name in enumerate(self.free) if name.startswith("r")]
        centre = self.bounds.mean(axis=1)
        if len(turns) == 3:
            middle = self.free.index(self.boxes.middle)
            beyond = np.cos(given[:, middle]) < 0
            other = given.copy()
            other[:, turns] += np.pi
            other[:, middle] = np.pi - given[:, middle]
            given = np.where(beyond[:, None], other, given)
        whole = 2 * np.pi * np.round((given - centre)[:, turns] / (2 * np.pi))
        given[:, turns] -= whole
        return given

    def judged_poses(self, R: ArrayLike, T: ArrayLike) -> NDArray[np.int8]:
        """Return the place of poses as `judged_at`; -1 if a parameter that is not free differs.

        Parameters
        ----------
        R, T
            Poses, shapes (n, 3, 3) and (n, 3).
        """
        R, T = np.asarray(R, float), np.asarray(T, float)
        parameters = np.zeros((len(R), 6))
        parameters[:, :3] = T + R @ self.boxes.pivot
        parameters[:, 3:] = euler_from_rotation(self.boxes.sequence, R @ self.boxes.R.T)
        size = np.array([Arrangement.of(self.instance).length] * 3 + [1.0] * 3)
        indices = [PARAMETERS.index(name) for name in self.free]
        fixed = [k for k in range(6) if k not in indices]
        off = np.abs(parameters - self.boxes.home)[:, fixed] / size[fixed]
        found = self.judged_at(parameters[:, indices] / self.units)
        return np.where((off < _SAME).all(axis=1), found, -1).astype(np.int8)

    def _corners(self, keys: Keys, levels: Levels) -> Array:
        low, high = self.bounds.T
        step = (high - low) / 2.0 ** levels[:, None]
        place = places(keys, len(self.free))
        return np.stack((low + place * step, low + (place + 1) * step), axis=2)

    def _volume(self, keys: Keys, levels: Levels) -> float:
        dimensions = len(self.free)
        if sum(name.startswith("r") for name in self.free) < 3:
            whole = float(np.prod((self.bounds[:, 1] - self.bounds[:, 0]) / self.units))
            counts = np.bincount(levels, minlength=1).tolist()
            return whole * sum(
                math.ldexp(count, -dimensions * level) for level, count in enumerate(counts)
            )
        corners = self._corners(keys, levels)
        sides = corners[:, :, 1] - corners[:, :, 0]
        # The measure of the second angle is the difference of its sine.
        middle = self.free.index(self.boxes.middle)
        sides[:, middle] = np.sin(corners[:, middle, 1]) - np.sin(corners[:, middle, 0])
        return float(sides.prod(axis=1).sum() / (8 * math.pi**2))


def _power(unit: str, exponent: int) -> str:
    return unit if exponent == 1 else f"{unit}^{exponent}"
