"""The numbers of a platform with masses in SI units, and how its bodies move with the pose."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DPP
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement, Array
from gspcli.geometry.checking import checked
from gspcli.geometry.instance import METRES, Instance
from gspcli.geometry.machine import Machine
from gspcli.geometry.masses import Arm, Carriage, Dynamics, Leg
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import as_array, unit_vectors
from gspcli.records import dataclass


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


class CarrierMasses(NamedTuple):
    """Arms of cranks and carriages in SI units, by drives; zero where there is none."""

    mass: Array
    """Shape (m,), as all."""
    share: Array
    """Where the centre of mass is, as a part of the way from the axis to the point; 1 of slides."""
    inertia: Array
    """Of arms about their centre of mass, parallel to the axis."""
    moment: Array
    """Of arms about the axis, kg m^2; of carriages the mass."""


@dataclass(frozen=True, eq=False)
class MassModel:
    """A platform with masses in SI units."""

    #: The platform.
    instance: Instance
    #: Its unit of length in metres.
    metre: float
    #: Of the platform: centre shape (3,), matrix about the centre (3, 3), in its frame.
    mass: float
    centre: Array
    inertia: Array
    #: The legs that weigh something.
    legs: LegMasses
    #: Inertias of the m drives, kg and kg m^2, shape (m,).
    rotors: Array
    #: Of the m drives, N/m and N m/rad, shape (m,); None if it is not stated.
    stiffness: Array | None
    #: The acceleration of what falls, shape (3,).
    gravity: Array
    #: The m drives, with lengths in metres.
    machine: Machine
    #: What they move beside the rods.
    carriers: CarrierMasses

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
        body, drives = stated.platform, stated.drives
        machine = Machine.of(instance).scaled(metre)
        rotors = _each(drives.inertia, machine)
        return cls(
            instance,
            metre,
            body.mass.value,
            as_array(body.centre) * metre,
            body.matrix * metre**2,
            _leg_masses(instance, stated.legs, metre),
            rotors * np.where(machine.turns, metre**2, 1.0),
            None if drives.stiffness is None else _each(drives.stiffness, machine),
            as_array(stated.gravity),
            machine,
            _carriers(stated, machine, metre),
        )

    @property
    def bodies(self) -> Arrangement:
        """The primitives where they are stated, with lengths in metres."""
        return self.machine.stated_arrangement

    @cached_property
    def users(self) -> Array:
        """Which constraint, of six, each of m drives has, shape (6, m): ones and zeros."""
        return np.asarray(np.eye(self.machine.count)[self.machine.index])

    def in_metres(self, twists: Array) -> Array:
        """Return twists, or their derivatives, with lengths in metres, shape (..., 6)."""
        return np.asarray(twists * np.repeat([1.0, self.metre], 3))


def named_drives(instance: Instance) -> dict[str, Any]:
    """Return the names of the drives for JSON; nothing where all are values."""
    drives = Machine.of(instance)
    return {"drives": list(drives.names)} if drives.moved.any() else {}


def _each(numbers: tuple[Number, ...], drives: Machine) -> Array:
    """Return numbers of the m drives, shape (m,)."""
    return np.array([number.value for number in numbers]) * np.ones(drives.count)


def _carriers(stated: Dynamics, drives: Machine, metre: float) -> CarrierMasses:
    """Return the arms and carriages in the order of the drives, whose lengths are in metres."""
    mass, share, inertia, moment = np.zeros((4, drives.count))
    groups: tuple[tuple[str, Sequence[Arm | Carriage]], ...]
    groups = ("crank", stated.arms), ("slide", stated.carriages)
    for sort, bodies in groups:
        which = [k for k, one in enumerate(drives.sorts) if one == sort]
        each = [*bodies] * (len(which) if len(bodies) == 1 else 1)
        for k, body in zip(which, each, strict=False):
            mass[k], share[k] = body.mass.value, 1.0
            moment[k] = mass[k]
            if isinstance(body, Arm):
                share[k] = body.centre.value * metre / drives.arms[drives.first[k]]
                inertia[k] = body.inertia.value * metre**2
                moment[k] = inertia[k] + mass[k] * (body.centre.value * metre) ** 2
    if (mass[drives.index[drives.on_platform]] > 0).any():
        message = "found arms with mass on the platform, expected them on the base"
        raise ArgumentError(message, "dynamics.arms")
    return CarrierMasses(mass, share, inertia, moment)


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
