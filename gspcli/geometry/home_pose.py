"""The home pose and the frames that an instance file states."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import ArgumentError
from gspcli.geometry.euler import check_sequence, rotation_from_euler
from gspcli.geometry.numbers import Number, Real
from gspcli.geometry.primitives import Components, Vector, exact_vector
from gspcli.geometry.quaternions import rotation_from_quaternion, unit_quaternion
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: The error for a quaternion of zero.
TURNS = "expected a quaternion [w, x, y, z]: any but zero"


@dataclass(frozen=True, init=False)
class HomePose:
    """The stated home of a machine; home is the real pose for its values that is nearest to it.

    Attributes
    ----------
    position
        Of the platform's origin in the base, in the unit of length.
    quaternion
        The rotation, scalar first, of any length; no turn by default, and with `euler`.
    euler
        Instead the order of the axes of `angles`, as `gspcli.geometry.euler` takes it, or None.
    angles
        Turns about x, y and z in the unit of angles; zero without `euler`.
    """

    position: Vector
    quaternion: tuple[Number, ...]
    euler: str | None
    angles: Vector

    def __init__(
        self,
        position: Components,
        quaternion: Sequence[Real] | None = None,
        *,
        euler: str | None = None,
        angles: Components = (0, 0, 0),
    ) -> None:
        turned = tuple(map(Number.of, (1, 0, 0, 0) if quaternion is None else quaternion))
        if len(turned) != 4 or not any(part.value for part in turned):
            raise ArgumentError(f"found {quaternion}, {TURNS}", "quaternion")
        if euler is not None and quaternion is not None:
            message = "found angles, too, expected a quaternion or angles"
            raise ArgumentError(message, "quaternion")
        object.__setattr__(self, "position", exact_vector(position, "position"))
        object.__setattr__(self, "quaternion", turned)
        object.__setattr__(self, "euler", None if euler is None else check_sequence(euler))
        object.__setattr__(self, "angles", exact_vector(angles, "angles"))

    @property
    def T(self) -> Array:
        """The position, shape (3,)."""
        return np.array([part.value for part in self.position])

    def R(self, in_radians: float) -> Array:
        """Return the rotation, shape (3, 3); the unit of angles is given in radians."""
        if self.euler is not None:
            angles = [part.value * in_radians for part in self.angles]
            return rotation_from_euler(self.euler, angles)
        quaternion = unit_quaternion(np.array([part.value for part in self.quaternion]))
        return np.asarray(rotation_from_quaternion(quaternion), float)


@dataclass(frozen=True, init=False)
class Frame(HomePose):
    """A frame that is fixed in a body: as `HomePose`, of the frame in that body.

    `position` is its origin, which files call ``point``; the rotation turns its axes.
    """


@dataclass(frozen=True)
class Frames:
    """The frames that an instance file states.

    Attributes
    ----------
    tool
        In the platform; None for the platform's own frame.
    work
        In the base; None for the base's own frame.
    """

    tool: Frame | None = None
    work: Frame | None = None
