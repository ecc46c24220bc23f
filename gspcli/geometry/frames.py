"""The frames in which poses are expressed: a tool on the platform, a work frame on the base, home.

An expressed pose is where the tool's frame is in the work frame. Relative to home its position
is the way of the tool's point from home, along the axes of the work frame. Its rotation is the turn
of the platform from home, about these axes. Zero is home.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gspcli.errors import ArgumentError
from gspcli.geometry.instance import Array, Frame, Instance
from gspcli.geometry.quaternions import apply
from gspcli.records import dataclass

#: What to do where home is needed and not stated.
NO_HOME = (
    "the platform states no home: add the pose that is expressed as zero, as "
    "home: {position: [0, 0, 250]}"
)


class Placement(NamedTuple):
    """Where a frame is in another: ``x_other = R x + T``; None for no turn or no shift."""

    R: Array | None = None
    T: Array | None = None

    def shifted(self, point: ArrayLike) -> Placement:
        """Return the frame with its origin at a point that is given in it."""
        if not np.any(point):
            return self
        shift = np.asarray(point, float)
        if self.R is not None:
            shift = self.R @ shift
        return Placement(self.R, shift if self.T is None else self.T + shift)

    @property
    def is_identity(self) -> bool:
        """Whether it is that other frame itself."""
        return self.R is None and self.T is None

    @property
    def matrix(self) -> Array:
        """The rotation, shape (3, 3)."""
        return np.eye(3) if self.R is None else self.R

    @property
    def origin(self) -> Array:
        """The origin, shape (3,)."""
        return np.zeros(3) if self.T is None else self.T


_SAME = Placement()


@dataclass(frozen=True, eq=False)
class PoseFrame:
    """The frame in which poses are expressed; `of` makes it for an instance.

    Attributes
    ----------
    tool
        In the platform.
    work
        In the base.
    home
        The pose that is expressed as zero, or None: poses are those of the tool in the work frame.
    """

    tool: Placement = _SAME
    work: Placement = _SAME
    home: Placement | None = None

    @classmethod
    def of(
        cls, instance: Instance, *, pivot: ArrayLike = (0.0, 0.0, 0.0), relative: bool = False
    ) -> PoseFrame:
        """Return the frame in which poses of an instance are expressed.

        Parameters
        ----------
        instance
            The platform, with its frames and home.
        pivot
            The point whose position is expressed, in the tool's frame, shape (3,).
        relative
            Whether poses are expressed relative to home.

        Raises
        ------
        ArgumentError
            If home is needed and not stated.

        Examples
        --------
        >>> import gspcli
        >>> platform = gspcli.example("nano-hexapod")
        >>> expressed = gspcli.PoseFrame.of(platform, relative=True)
        >>> R, T = expressed.to_platform([[1, 0, 0], [0, 1, 0], [0, 0, 1]], [0, 0, 5])
        >>> bool(abs(T - platform.home.T - [0, 0, 5]).max() < 1e-12)
        True
        """
        unit, stated, home = instance.units.angle.in_radians, instance.frames, instance.home
        tool, work = (
            _SAME if frame is None else Placement(_turn(frame, unit), _shift(frame.T))
            for frame in ((None, None) if stated is None else (stated.tool, stated.work))
        )
        start = None
        if relative:
            if home is None:
                raise ArgumentError(NO_HOME)
            start = Placement(home.R(unit), home.T)
        return cls(tool, work, start).at(pivot)

    def at(self, pivot: ArrayLike) -> PoseFrame:
        """Return the same for poses whose position is that of a point, given in the tool's frame.

        Points add: ``frame.at(a).at(b)`` is ``frame.at(a + b)``.
        """
        if not np.any(pivot):
            return self
        return PoseFrame(self.tool.shifted(pivot), self.work, self.home)

    @property
    def is_identity(self) -> bool:
        """Whether expressed poses are those of the platform's own frame in the base's."""
        return self.home is None and self.tool.is_identity and self.work.is_identity

    @cached_property
    def of_base(self) -> Placement:
        """The frame in the base in which positions are expressed, with the axes of all numbers."""
        if self.home is None:
            return self.work
        at = self.home.matrix @ self.tool.origin + self.home.origin
        return Placement(self.work.R, at)

    @cached_property
    def of_platform(self) -> Placement:
        """The frame of the platform whose pose is expressed."""
        if self.home is None:
            return self.tool
        # At home it has the axes of the work frame, so that the turn is the identity there.
        return Placement(self.home.matrix.T @ self.work.matrix, self.tool.T)

    def to_platform(self, R: ArrayLike, T: ArrayLike) -> tuple[Array, Array]:
        """Return the poses of the platform, ``x_base = R x_platform + T``, of expressed ones.

        Parameters
        ----------
        R, T
            Expressed poses, shapes (..., 3, 3) and (..., 3).
        """
        body, turned, at = self.of_platform, self.turn_to_platform(R), self.point_to_base(T)
        if body.T is not None:
            at = at - apply(turned, np.broadcast_to(body.T, at.shape))
        return turned, at

    def turn_to_platform(self, R: ArrayLike) -> Array:
        """Return the rotations of the platform of expressed ones, shape (..., 3, 3)."""
        base, body, turned = self.of_base, self.of_platform, _numbers(R)
        if base.R is not None:
            turned = base.R @ turned
        return turned if body.R is None else turned @ body.R.T

    def from_platform(self, R: ArrayLike, T: ArrayLike) -> tuple[Array, Array]:
        """Return how poses of the platform are expressed; the inverse of `to_platform`.

        Parameters
        ----------
        R, T
            Poses, shapes (..., 3, 3) and (..., 3), real or complex.
        """
        base, body = self.of_base, self.of_platform
        turned, at = np.asarray(R), np.asarray(T)
        if body.T is not None:
            at = at + apply(turned, np.broadcast_to(body.T, at.shape))
        if base.T is not None:
            at = at - base.T
        if base.R is not None:
            turned, at = base.R.T @ turned, at @ base.R
        if body.R is not None:
            turned = turned @ body.R
        return turned, at

    def point_to_base(self, points: ArrayLike) -> Array:
        """Return points of the base that are expressed by their coordinates, shape (..., 3)."""
        base, at = self.of_base, _numbers(points)
        if base.R is not None:
            at = at @ base.R.T
        return at if base.T is None else at + base.T

    @property
    def words(self) -> str:
        """What expressed poses are, in words; empty for the identity."""
        if self.is_identity:
            return ""
        tool = "the platform" if self.tool.is_identity else "the tool"
        if self.home is not None:
            axes = "the work frame" if self.work.R is not None else "the base"
            return f"poses of {tool} relative to home, along the axes of {axes}"
        return f"poses of {tool} in {'the base' if self.work.is_identity else 'the work frame'}"

    def to_json(self) -> dict[str, Any]:
        """Return the two frames between which poses are expressed, as plain data.

        The pose of the platform is ``A X B^-1`` for an expressed pose X, with A the frame in the
        base and B that of the platform.
        """
        base, body = self.of_base, self.of_platform
        return {
            "relative_to": "work" if self.home is None else "home",
            "base_R": base.matrix.tolist(),
            "base_T": base.origin.tolist(),
            "platform_R": body.matrix.tolist(),
            "platform_T": body.origin.tolist(),
        }


#: Expressed poses are those of the platform's own frame in the base's.
IDENTITY = PoseFrame()


def _numbers(given: ArrayLike) -> Array:
    """Return real or complex numbers as an array."""
    array = np.asarray(given)
    return array if np.iscomplexobj(array) else np.asarray(array, float)


def _turn(frame: Frame, in_radians: float) -> Array | None:
    """Return the rotation of a frame, None if there is none: numbers are unchanged."""
    R = frame.R(in_radians)
    return None if np.array_equal(R, np.eye(3)) else R


def _shift(T: Array) -> Array | None:
    return T if T.any() else None
