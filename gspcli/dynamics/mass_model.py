"""The numbers of a platform with masses in SI units, and how its bodies move with the pose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DPP
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.checking import checked
from gspcli.geometry.drives import Drives, is_driven
from gspcli.geometry.instance import METRES, Instance
from gspcli.geometry.masses import Arm, Carriage, Dynamics, Leg
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


class CarrierMasses(NamedTuple):
    """Arms of cranks and carriages in SI units, by constraints: zero but for a drive's first."""

    mass: Array
    """Shape (6,), as all."""
    share: Array
    """Where the centre of mass is, as a part of the way from the axis to the point; 1 of slides."""
    inertia: Array
    """Of arms about their centre of mass, parallel to the axis."""
    moment: Array
    """Of arms about the axis, kg m^2; of carriages the mass."""


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
        Inertias of the drives, kg and kg m^2, shape (6,): by constraints, and zero but for the
        first one of a drive that several share.
    stiffness
        Of the m drives, N/m and N m/rad, shape (m,); None if it is not stated.
    gravity
        The acceleration of what falls, shape (3,).
    drives
        What moves the points of distances, in length units; None if all drives are values.
    carriers
        What it moves beside the rods; None if that weighs nothing.
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
    drives: Drives | None = None
    carriers: CarrierMasses | None = None

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
        moved = Drives.of(instance) if is_driven(instance) else None
        turns = ~distances if moved is None else _turns(moved, distances)
        if moved is not None:
            _check_driven(instance, moved)
        return cls(
            instance,
            metre,
            replace(numbers, y=numbers.y * metre, x=numbers.x * metre, values=values),
            body.mass.value,
            as_array(body.centre) * metre,
            body.matrix * metre**2,
            _leg_masses(instance, stated.legs, metre),
            _six(drives.inertia, moved) * np.where(turns, metre**2, 1.0),
            None if drives.stiffness is None else _each(drives.stiffness, moved),
            as_array(stated.gravity),
            moved,
            None if moved is None else _carriers(stated, moved, metre),
        )

    @cached_property
    def turns(self) -> NDArray[np.bool_]:
        """Which constraints are driven by a crank, shape (6,)."""
        assert self.drives is not None
        return np.array([self.drives.sorts[k] == "crank" for k in self.drives.index])

    @cached_property
    def drive_metres(self) -> Array:
        """The units of the numbers of drives in SI units, by constraints: of slides the metre."""
        assert self.drives is not None
        return np.where(self.turns, 1.0, self.metre)

    @cached_property
    def sharing(self) -> Array | None:
        """Which constraint, of six, each of m drives has, shape (6, m); None unless some share."""
        if self.drives is None or len(self.drives.names) == len(self.drives.index):
            return None
        return np.asarray(np.eye(len(self.drives.names))[self.drives.index])

    @property
    def drive_count(self) -> int:
        """How many drives there are."""
        return len(self.bodies.kinds) if self.drives is None else len(self.drives.names)

    def by_constraints(self, numbers: Array) -> Array:
        """Return numbers of m drives by constraints, (..., m) -> (..., 6).

        Those of a drive that several rods share stand at its first one; the others have zero.
        """
        if self.drives is None:
            return numbers
        return np.asarray(numbers[..., self.drives.index] * _first(self.drives))

    def of_drives(self, numbers: Array) -> Array:
        """Return sums over the constraints of each drive, (..., 6) -> (..., m)."""
        return numbers if self.sharing is None else np.asarray(numbers @ self.sharing)

    def in_metres(self, twists: Array) -> Array:
        """Return twists, or their derivatives, with lengths in metres, shape (..., 6)."""
        return np.asarray(twists * np.repeat([1.0, self.metre], 3))


def named_drives(instance: Instance) -> dict[str, Any]:
    """Return the names of the drives for JSON; nothing where all are values."""
    return {"drives": list(Drives.of(instance).names)} if is_driven(instance) else {}


def _six(numbers: tuple[Number, ...], drives: Drives | None) -> Array:
    """Return numbers of drives by constraints: those of a shared drive at its first one."""
    each = _each(numbers, drives)
    return each if drives is None else np.asarray(each[drives.index] * _first(drives))


def _each(numbers: tuple[Number, ...], drives: Drives | None) -> Array:
    """Return numbers of the m drives, shape (m,)."""
    count = 6 if drives is None else len(drives.names)
    return np.array([number.value for number in numbers]) * np.ones(count)


def _first(drives: Drives) -> NDArray[np.bool_]:
    """Return which constraints are the first ones of their drives, shape (6,)."""
    index = drives.index.tolist()
    return np.array([index.index(drive) == k for k, drive in enumerate(index)])


def _turns(drives: Drives, distances: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return whose drive is an angle, shape (6,): of the value, or of a crank."""
    sorts = [drives.sorts[drive] for drive in drives.index]
    return np.array([sort == "crank" for sort in sorts]) | (~drives.driven & ~distances)


def _check_driven(instance: Instance, drives: Drives) -> None:
    for row, driven in zip(instance.constraints, drives.driven, strict=True):
        if driven and row.kind is not DPP:
            name = row.kind.name
            message = f"found a {name} with a crank or slide, expected distances of two points"
            raise ArgumentError(message, "dynamics")


def _carriers(stated: Dynamics, drives: Drives, metre: float) -> CarrierMasses | None:
    """Return the arms and carriages in the order of the drives."""
    if not (stated.arms or stated.carriages):
        return None
    mass, share, inertia, moment = np.zeros((4, 6))
    groups: tuple[tuple[str, Sequence[Arm | Carriage]], ...]
    groups = ("crank", stated.arms), ("slide", stated.carriages)
    for sort, bodies in groups:
        which = [k for k in np.flatnonzero(_first(drives)) if drives.sorts[drives.index[k]] == sort]
        each = [*bodies] * (len(which) if len(bodies) == 1 else 1)
        for k, body in zip(which, each, strict=False):
            mass[k], share[k] = body.mass.value, 1.0
            moment[k] = mass[k]
            if isinstance(body, Arm):
                share[k] = body.centre.value / drives.arms[k]
                inertia[k] = body.inertia.value * metre**2
                moment[k] = inertia[k] + mass[k] * (body.centre.value * metre) ** 2
    if (mass[drives.on_platform] > 0).any():
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
