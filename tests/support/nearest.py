"""Machines whose nearest poses within limits are asked for, and whether a pose keeps the limits.

The distances of joints and the tilts of legs are computed again, with vectors only, and compared
without tolerance, but for fixed values.
"""

from __future__ import annotations

import numpy as np

import gspcli
from gspcli.geometry.primitives import Plane
from tests.support.independent_machines import Machine, machines

#: Machines with legs, and examples with motors.
LEGS = ("rubin-camera", "rubin-m2", "three-rps", "workspace-study", "workspace-study-cones")
MOTORS = ("reachy-mini-head", "hexaglide", "delta")
#: Machines with motors of `tests.support.independent_machines`.
MADE = ("t-top 60", "6-PUS", "paradex")
MACHINES = (*LEGS, *MOTORS, *MADE)
#: Standard deviations of the poses asked for, from home: radians, and parts of the typical length.
TURN, SHIFT = 0.4, 0.2


def machine_of(name: str) -> Machine:
    """Return a machine with the pose where it is."""
    if name in MADE:
        return machines()[name]()
    instance = gspcli.example(name)
    home = gspcli.solve(instance).home
    if home is None:  # of rods that share a motor the stated pose is one of many
        stated = instance.home
        assert stated is not None
        return Machine(name, instance, stated.R(instance.units.angle.in_radians), stated.T, (0, 0))
    return Machine(name, instance, home.R.real, home.T.real, (0, 0))


def kept(instance: gspcli.Instance, R: np.ndarray, T: np.ndarray) -> bool:
    """Return whether all legs keep their ranges and cones, from vectors alone.

    Other distances are those of points and planes.
    """
    for row in instance.constraints:
        platform = R @ np.array([x.value for x in row.platform.position]) + T
        base = np.array([x.value for x in row.base.position])
        leg = platform - base
        if row.kind.name == "DPP":
            value = float(np.sqrt(leg @ leg))
        elif isinstance(row.base, Plane):
            value = float(leg @ row.base.unit)
        else:
            raise ValueError(row.kind.name)
        if row.limits is not None:
            low, high = (limit.value for limit in row.limits)
            value = abs(value) if row.side.value == "both" else value
            # A fixed value is met by the pose of the values, not by its doubles.
            room = 1e-9 * (1 + abs(low)) if low == high else 0.0
            if not low - room <= value <= high + room:
                return False
        for joint, direction, turn in ((row.base, leg, np.eye(3)), (row.platform, -leg, R)):
            cone = getattr(joint, "cone", None)
            if cone is None:
                continue
            half = cone.half_angle.value * instance.units.angle.in_radians
            if direction @ (turn @ cone.unit) < np.cos(half) * np.sqrt(leg @ leg):
                return False
    return True
