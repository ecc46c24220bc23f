"""The ranges and cones of a platform for searches of its nearest poses, in units of its size."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.drives import Drives
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.limits import joint_cones
from gspcli.motion.following.platform_numbers import NEVER, PlatformNumbers, motor_of
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: The largest number of joints with a cone.
_CONES = 12


@dataclass(frozen=True, eq=False)
class LimitNumbers:
    """The limits of a platform.

    The fields are those of the struct ``limits`` in ``gspcli/export/controller/nearest.c``, in its
    order and with its meanings; ``leg`` and ``on_base`` have one number for each cone.
    """

    low: Array
    high: Array
    axis: Array
    half: Array
    pivot: Array
    weight: float
    cones: int
    still: bool
    leg: NDArray[np.uint8]
    on_base: NDArray[np.uint8]

    @property
    def arguments(self) -> tuple[Any, ...]:
        """The arguments of ``_kernel.Controller.limit``."""
        names = ("low", "high", "axis", "half", "pivot", "weight")
        doubles = np.concatenate([np.ravel(getattr(self, name)) for name in names])
        return doubles, self.leg, self.on_base, self.still


def limit_numbers(
    instance: Instance,
    numbers: PlatformNumbers,
    *,
    pivot: ArrayLike | None = None,
    still: bool = False,
) -> LimitNumbers:
    """Return the limits of an instance.

    Parameters
    ----------
    instance
        The platform.
    numbers
        The other numbers of the platform.
    pivot
        The point of the platform whose position is compared, shape (3,); its origin if None.
    still
        Whether the platform keeps its rotation.
    """
    low, high = np.full(6, -NEVER), np.full(6, NEVER)
    radian = instance.units.angle.in_radians
    stays = Drives.of(instance).stays
    for k, (row, kind) in enumerate(zip(instance.constraints, numbers.kinds, strict=True)):
        motor = motor_of(row)
        limits = row.limits if motor is None else motor.limits
        if stays[k]:
            limits = row.value, row.value
        if limits is None:
            continue
        unit = radian if kind.endswith("CRANK") or kind[0] == "A" else 1 / numbers.reach
        least, most = (limit.value * unit for limit in limits)
        negative = motor is None and row.side is Side.NEGATIVE
        low[k], high[k] = (-most, -least) if negative else (least, most)
    cones = joint_cones(instance)
    axis, half = np.zeros((_CONES, 3)), np.zeros(_CONES)
    for k, one in enumerate(cones):
        axis[k], half[k] = one.cone.unit, one.cone.half_angle.value * radian
    point = np.zeros(3) if pivot is None else np.asarray(pivot, float)
    return LimitNumbers(
        low=low,
        high=high,
        axis=axis,
        half=half,
        pivot=(point - numbers.middle) / numbers.reach,
        weight=Arrangement.of(instance).length / numbers.reach,
        cones=len(cones),
        still=still,
        leg=np.array([one.constraint for one in cones], np.uint8),
        on_base=np.array([one.body == "base" for one in cones], np.uint8),
    )
