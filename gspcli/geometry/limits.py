"""The limits that poses of an instance violate, with its cranks and slides as stated."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from gspcli.geometry.coordinates import BODIES
from gspcli.geometry.instance import Array, Instance
from gspcli.geometry.machine import Machine, driven_points, value_machine
from gspcli.records import dataclass


@dataclass(frozen=True)
class LeftLimit:
    """A limit that a pose violates."""

    #: ``range``, ``cone`` or ``working mode``: a crank or slide acts on its rod from the other side
    #: than at home, so that it would pass a dead point on the way.
    kind: Literal["range", "cone", "working mode"]
    #: The index of the constraint or leg.
    constraint: int
    #: The body of the joint of the cone, or of the point of the drive; None for a range.
    body: Literal["platform", "base"] | None

    def to_json(self) -> dict[str, Any]:
        """Return it as plain data, constraints numbered from 1."""
        return {"kind": self.kind, "constraint": self.constraint + 1, "body": self.body}


def restricts(instance: Instance) -> bool:
    """Return whether an instance has limits, or drives whose working modes at home are known."""
    if value_machine(instance).limited:
        return True
    return instance.home is not None and any(map(driven_points, instance.constraints))


def left_limits(
    instance: Instance, values: Array, R: Array, T: Array
) -> list[tuple[LeftLimit, ...]]:
    """Return the limits that each of n poses violates, ranges first, with drives as stated.

    Parameters
    ----------
    instance
        The platform with its limits.
    values
        What the constraints measure at the poses, shape (n, 6), distances to planes signed.
    R, T
        The poses, shapes (n, 3, 3) and (n, 3).
    """
    still = value_machine(instance)
    limits = [LeftLimit("range", k, None) for k in range(still.count)]
    limits += [LeftLimit("cone", joint.constraint, joint.body) for joint in still.cones]
    parts = [still.outside(still.of_values(values)), still.out_of_cones(R, T)]
    if instance.home is not None and (drives := Machine.of(instance)).moves:
        limits += [
            LeftLimit("working mode", k, BODIES[0] if on_platform else BODIES[1])
            for k, on_platform in enumerate(drives.on_platform.tolist())
        ]
        parts.append(drives.in_other_working_modes(R, T))
    left = np.concatenate(parts, axis=1)
    return [tuple(limits[k] for k in np.flatnonzero(row)) for row in left]
