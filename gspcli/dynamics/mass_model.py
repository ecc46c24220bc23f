"""The numbers of a platform with masses in SI units, and how its bodies move with the pose."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DPP
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.checking import checked
from gspcli.geometry.instance import Instance
from gspcli.geometry.lengths import METRES
from gspcli.geometry.masses import Leg
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import as_array, unit_vectors
from gspcli.records import dataclass

Array = NDArray[np.float64]


class LegMasses(NamedTuple):
    """The m legs that weigh something, in SI units; their lengths run along each leg."""

    rows: NDArray[np.int64]
    """Which constraints they are, shape (m,)."""
    cylinder: Array
    """Masses at the base, and where their centres are from that joint, shape (2, m, 1)."""
    rod: Array
    """Masses at the platform, and where their centres are from that joint, shape (2, m, 1)."""
    across: Array
    """Inertias of both bodies about their centres across the leg, together, shape (m, 1)."""
    axial: Array
    """Inertias of both about the leg; zero where the leg does not spin, shape (m, 1)."""
    axes: Array
    """First axes of the universal joints, unit vectors; zero where there is none, shape (m, 3)."""


@dataclass(frozen=True, eq=False)
class MassModel:
    """A platform with masses in SI units.

    Attributes
    ----------
    instance
        The platform.
    metre
        Its unit of length in metres.
    bodies
        Its primitives, with lengths in metres.
    mass, centre, inertia
        Of the platform: centre shape (3,), matrix about the centre (3, 3), in its frame.
    legs
        The legs that weigh something.
    rotors
        Inertias of the drives by their values, kg and kg m^2, shape (6,).
    stiffness
        Of the drives, N/m and N m/rad, shape (6,); None if it is not stated.
    gravity
        The acceleration of what falls, shape (3,).
    """

    instance: Instance
    metre: float
    bodies: Arrangement
    mass: float
    centre: Array
    inertia: Array
    legs: LegMasses
    rotors: Array
    stiffness: Array | None
    gravity: Array

    @classmethod
    def of(cls, instance: Instance) -> MassModel:
        """Return the numbers of an instance.

        Raises
        ------
        ArgumentError
            If it states no masses, or some that no platform can have.
        """
        stated = checked(instance).dynamics
        if stated is None:
            message = (
                "found no masses: add `dynamics:` to the instance file, with the mass, centre and "
                "inertia of the platform at least"
            )
            raise ArgumentError(message, "dynamics")
        metre = METRES[instance.units.length]
        numbers = Arrangement.of(instance)
        distances = np.array([kind.is_distance for kind in numbers.kinds])
        values = np.where(distances, metre, 1.0) * numbers.values
        body, drives = stated.platform, stated.drives
        return cls(
            instance,
            metre,
            replace(numbers, y=numbers.y * metre, x=numbers.x * metre, values=values),
            body.mass.value,
            as_array(body.centre) * metre,
            body.matrix * metre**2,
            _leg_masses(instance, stated.legs, metre),
            _six(drives.inertia) * np.where(distances, 1.0, metre**2),
            None if drives.stiffness is None else _six(drives.stiffness),
            as_array(stated.gravity),
        )

    def in_metres(self, twists: Array) -> Array:
        """Return twists, or their derivatives, with lengths in metres, shape (..., 6)."""
        return np.asarray(twists * np.repeat([1.0, self.metre], 3))


def _six(numbers: tuple[Number, ...]) -> Array:
    return np.array([number.value for number in numbers]) * np.ones(6)


def _leg_masses(instance: Instance, legs: tuple[Leg, ...], metre: float) -> LegMasses:
    found = [k for k, row in enumerate(instance.constraints) if row.kind is DPP]
    each = (legs * len(found) if len(legs) == 1 else legs) if legs else ()
    rows = np.array(found[: len(each)], int)
    # Columns: mass, centre, inertia across the leg and about it, for the cylinder and the rod.
    bodies = np.zeros((2, len(each), 4))
    axes = np.zeros((len(each), 3))
    for k, leg in enumerate(each):
        for which, body in enumerate((leg.cylinder, leg.rod)):
            if body is not None:
                parts = (body.mass, body.centre, body.inertia, body.axial)
                bodies[which, k] = [part.value for part in parts]
        if leg.universal is not None:
            axes[k] = unit_vectors([leg.universal])[0]
    bodies[..., 1] *= metre
    bodies[..., 2:] *= metre**2
    moments = bodies[..., 2:].sum(axis=0)
    spins = (axes != 0).any(axis=1)
    cylinder, rod = np.moveaxis(bodies[..., :2], -1, 1)[..., None]
    return LegMasses(rows, cylinder, rod, moments[:, :1], moments[:, 1:] * spins[:, None], axes)
