"""The arms and carriages of a simulated model: what its drives move beside the platform.

A crank is a hinge with an arm, a slide a carriage on a rail. The rod of a constraint leads from
there to the other body, with a ball joint at either end. Coordinates are zero where the instance
states the points.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from gspcli.catalogue.kinds import DPP
from gspcli.errors import ArgumentError
from gspcli.export.chains import ChainJoint
from gspcli.export.simulated_masses import Inertial, SimulatedMasses
from gspcli.geometry.drive_numbers import is_driven
from gspcli.geometry.drives import Drives
from gspcli.geometry.instance import Instance
from gspcli.records import dataclass


@dataclass(frozen=True, eq=False)
class Carrier:
    """An arm or a carriage, with the joint that its drive moves.

    Vectors are in the frame of its body, in metres.

    Attributes
    ----------
    constraints
        The constraints whose rods it carries, from 0; names in models have the first of them.
    on_platform
        Whether its body is the platform.
    joint
        The hinge or slide, with the coordinate zero and its range. Its point is the origin of the
        carrier's frame: where the arm meets the axis of a crank, or the point of the carriage.
    lever
        The length of the arm, or None for a carriage.
    inertial
        Its mass, centre and inertia.
    """

    constraints: tuple[int, ...]
    on_platform: bool
    joint: ChainJoint
    lever: float | None
    inertial: Inertial

    @property
    def number(self) -> int:
        """The number in names of the model: its first constraint, from 1."""
        return self.constraints[0] + 1

    @property
    def name(self) -> str:
        """The name of its body."""
        return f"{'carriage' if self.lever is None else 'arm'}_{self.number}"


def carriers(instance: Instance, masses: SimulatedMasses, metre: float) -> tuple[Carrier, ...]:
    """Return the arms and carriages of an instance; none if no drive is a crank or a slide."""
    if not is_driven(instance):
        return ()
    drives = Drives.of(instance)
    for row, driven in zip(instance.constraints, drives.driven, strict=True):
        if driven and row.kind is not DPP:
            name = row.kind.name
            message = f"found a {name} with a crank or slide, expected distances of two points"
            raise ArgumentError(f"{message}: models have rods between arms and the other body")
    found = []
    for drive, sort in enumerate(drives.sorts):
        if sort == "value":
            continue
        rows = tuple(int(k) for k in np.flatnonzero(drives.index == drive))
        k = rows[0]
        turns = sort == "crank"
        kind: Literal["hinge", "slide"] = "hinge" if turns else "slide"
        axis = np.cross(drives.across[k], drives.beside[k]) if turns else drives.beside[k]
        axis = axis / np.linalg.norm(axis)
        span = np.array([drives.low[drive], drives.high[drive]]) * (1.0 if turns else metre)
        limits = (float(span[0]), float(span[1])) if np.isfinite(span).all() else None
        found.append(
            Carrier(
                rows,
                bool(drives.on_platform[k]),
                ChainJoint(kind, axis, drives.middle[k] * metre, 0.0, limits),
                float(drives.arms[k]) * metre if turns else None,
                masses.carrier(k, drives.across[k]),
            )
        )
    return tuple(found)
