"""Patterns of special platforms: shared points and directions, right angles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DLL, DPH, Kind
from gspcli.reality.platforms import Platforms
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: Numbers of a constraint: y, x, u, v and the value.
NUMBERS = 13
_VALUE = 12


@dataclass(frozen=True)
class Pattern:
    """A kind of special platforms.

    Attributes
    ----------
    kinds
        The kinds of the constraints.
    same_points, same_u, same_v
        Groups of constraints that share their point of the platform and that of the base, their
        direction on the platform, or that of the base.
    right_angles
        Whether the angles are right angles.
    """

    kinds: tuple[Kind, ...]
    same_points: tuple[tuple[int, ...], ...] = ()
    same_u: tuple[tuple[int, ...], ...] = ()
    same_v: tuple[tuple[int, ...], ...] = ()
    right_angles: bool = False

    @property
    def free(self) -> NDArray[np.bool_]:
        """The numbers of the constraints that may change, shape (6, 13).

        Distances of planes and lines stay zero. Directions of points have no gradient.
        """
        free = np.ones((len(self.kinds), NUMBERS), bool)
        free[:, :6] = np.array([kind.is_distance for kind in self.kinds])[:, None]
        free[:, _VALUE] = [
            kind not in (DPH, DHP, DLL) and (kind.is_distance or not self.right_angles)
            for kind in self.kinds
        ]
        return free

    def projected(self, gradients: Array) -> Array:
        """Return the parts of gradients (..., 6, 13) that stay in the pattern."""
        allowed = np.where(self.free, gradients, 0.0)
        for groups, part in (
            (self.same_points, slice(0, 6)),
            (self.same_u, slice(6, 9)),
            (self.same_v, slice(9, 12)),
        ):
            for members in map(list, groups):
                allowed[..., members, part] = allowed[..., members, part].mean(-2, keepdims=True)
        return np.asarray(allowed)

    def of(self, platforms: Platforms) -> Platforms:
        """Return reduced platforms, changed to platforms of the pattern."""
        y, x, u, v = (getattr(platforms, part).copy() for part in "yxuv")
        for groups, parts in ((self.same_points, (y, x)), (self.same_u, (u,)), (self.same_v, (v,))):
            for first, *others in groups:
                for part in parts:
                    part[..., others, :] = part[..., [first], :]
        values = platforms.values.copy()
        if self.right_angles:
            values[..., [not kind.is_distance for kind in self.kinds]] = 0.0
        return replace(platforms, y=y, x=x, u=u, v=v, values=values)
