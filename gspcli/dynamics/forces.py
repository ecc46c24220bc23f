"""Inverse dynamics: the forces of the six drives that move a platform as it moves."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gspcli.dynamics.actuation import Actuation, Flags, numbers_at
from gspcli.dynamics.arrays import by_chunks, checked_array, checked_rows, make_read_only, plain
from gspcli.dynamics.mass_model import MassModel, named_drives
from gspcli.dynamics.moving_bodies import MovingBodies
from gspcli.dynamics.trajectories import PoseRates, at_rest, spline_motion
from gspcli.errors import ArgumentError
from gspcli.geometry.instance import METRES, Array, Instance
from gspcli.geometry.machine import Machine
from gspcli.geometry.quaternions import apply
from gspcli.motion import measure
from gspcli.records import EqualByContent, dataclass
from gspcli.ties import first_largest

if TYPE_CHECKING:
    import pandas as pd

#: Poses computed at a time: their intermediate arrays stay in the cache of a core.
_CHUNK = 500
FORCES = tuple(f"F{k}" for k in range(1, 7))


class WorstForce(NamedTuple):
    """The largest force, or torque, of all rows."""

    row: int
    """The row, from 0."""
    drive: int
    """The drive, from 0."""
    force: float
    """In N or N m, with its sign."""


@dataclass(frozen=True, eq=False)
class DriveForces(EqualByContent):
    """Forces of the drives at n poses. All arrays are read-only.

    Attributes
    ----------
    instance
        The platform.
    t
        Times in seconds, shape (n,), or None.
    R, T
        The poses, shapes (n, 3, 3) and (n, 3), in length units.
    twists, accelerations
        How the platform moves there (`PoseRates`), in radians and length units, shape (n, 6).
    forces
        Forces of distances, N, and torques of angles, N m, shape (n, 6): positive if the drive
        pushes towards a greater value. NaN at singular poses. Where a crank or slide is the drive,
        it is the force along its rod.
    powers
        What each of the m drives does, W, shape (n, m).
    singular
        Which poses are singular, shape (n,): no forces are known there.
    nearly_singular
        The condition numbers of those above 1e8, where as many digits of the forces are lost; else
        NaN, shape (n,).
    torques
        What the m drives do: torques of cranks and angles, N m, forces of slides and of distances,
        N, shape (n, m), with the weights and inertias of arms and carriages.
    """

    instance: Instance
    t: Array | None
    R: Array
    T: Array
    twists: Array
    accelerations: Array
    forces: Array
    powers: Array
    singular: Flags
    nearly_singular: Array
    torques: Array

    def __post_init__(self) -> None:
        make_read_only(self)

    def __repr__(self) -> str:
        kinds = self.instance.name or self.instance.type.id
        count = f"{len(self.forces)} pose{'' if len(self.forces) == 1 else 's'}"
        worst = self.worst
        if worst is None:
            return f"<DriveForces of {kinds}: {count}, all singular>"
        unit = self.units[worst.drive]
        where = f"drive {worst.drive + 1} at row {worst.row + 1}"
        return f"<DriveForces of {kinds}: {count}, at most {abs(worst.force):.6g} {unit} ({where})>"

    @property
    def units(self) -> tuple[str, ...]:
        """The unit of each force: N for distances, N m for angles."""
        return tuple("N" if row.kind.is_distance else "N m" for row in self.instance.constraints)

    @cached_property
    def drives(self) -> Machine:
        """The drives."""
        return Machine.of(self.instance)

    @property
    def torque_units(self) -> tuple[str, ...]:
        """The unit of each torque: N m for cranks and angles, N for slides and distances."""
        return tuple("N m" if turns else "N" for turns in self.drives.turns)

    @property
    def in_file_units(self) -> Array:
        """The forces with torques in N times the unit of length, shape (n, 6)."""
        torques = np.array([unit == "N m" for unit in self.units])
        metre = METRES[self.instance.units.length]
        return np.asarray(self.forces / np.where(torques, metre, 1.0))

    @cached_property
    def power(self) -> Array:
        """What all drives do together, W, shape (n,)."""
        return np.asarray(self.powers.sum(axis=-1))

    @cached_property
    def values(self) -> Array:
        """The values at the poses, in the units of the instance, shape (n, 6)."""
        return measure(self.instance, self.R, self.T)

    @property
    def _torque_facts(self) -> dict[str, Any]:
        """The facts about the torques of all rows, for JSON."""
        worst, found = self.worst_torque, None
        if not self.drives.moved.any():
            return {}
        if worst is not None:
            found = {"row": worst.row + 1, "drive": worst.drive + 1, "torque": worst.force}
        return {"torque_units": list(self.torque_units), "worst_torque": found}

    @property
    def torque_columns(self) -> dict[str, Array]:
        """What each drive does, by the names of its column; nothing if all drives are values."""
        if not self.drives.moved.any():
            return {}
        names = [f"torque.{name}" for name in self.drives.names]
        return dict(zip(names, self.torques.T, strict=True))

    @property
    def worst(self) -> WorstForce | None:
        """The largest force; torques count only where there is no distance. None if all are NaN."""
        distances = np.array([row.kind.is_distance for row in self.instance.constraints])
        return self.largest(distances if distances.any() else ~distances)

    @property
    def worst_torque(self) -> WorstForce | None:
        """The largest torque of a crank, or force of a slide without cranks; None without both."""
        sorts = self.drives.sorts
        chosen = np.array([sort == ("crank" if "crank" in sorts else "slide") for sort in sorts])
        sizes = np.where(np.isnan(self.torques) | ~chosen, -1.0, np.abs(self.torques))
        if sizes.max() < 0:
            return None
        row, drive = (int(k) for k in np.unravel_index(first_largest(sizes.ravel()), sizes.shape))
        return WorstForce(row, drive, float(self.torques[row, drive]))

    def largest(self, drives: Flags) -> WorstForce | None:
        """Return the first largest force of some drives, shape (6,); None if there is none."""
        sizes = np.where(np.isnan(self.forces) | ~drives, -1.0, np.abs(self.forces))
        if not sizes.size or sizes.max() < 0:
            return None
        row, drive = (int(k) for k in np.unravel_index(first_largest(sizes.ravel()), sizes.shape))
        return WorstForce(row, drive, float(self.forces[row, drive]))

    def to_frame(self) -> pd.DataFrame:
        """Return a table: t (numbers of rows without times), F1 ... F6 and power.

        With cranks or slides there is a column for what each drive does, ``torque.crank.B1``.
        """
        import pandas as pd

        columns = dict(zip(FORCES, self.forces.T, strict=True))
        columns |= self.torque_columns
        times = np.arange(1.0, len(self.forces) + 1) if self.t is None else self.t
        return pd.DataFrame({"t": times, **columns, "power": self.power})

    def to_json(self) -> dict[str, Any]:
        """Return everything as plain data; singular poses have null for their numbers."""
        worst, count = self.worst, len(self.forces)
        times = [None] * count if self.t is None else self.t.tolist()
        parts = [self.forces, self.powers, self.power, self.nearly_singular]
        columns = [range(1, count + 1), times, *map(plain, parts), self.singular.tolist()]
        keys = ["row", "t", "forces", "powers", "power", "nearly_singular", "singular"]
        if self.drives.moved.any():
            keys.append("torques")
            columns.append(plain(self.torques))
        found = None
        if worst is not None:
            found = {"row": worst.row + 1, "drive": worst.drive + 1, "force": worst.force}
        return {
            "schema": "gsp.dynamics/1",
            **self.instance.to_json(),
            **named_drives(self.instance),
            "force_units": list(self.units),
            **self._torque_facts,
            "worst": found,
            "rows": [dict(zip(keys, row, strict=True)) for row in zip(*columns, strict=True)],
        }


def inverse_dynamics(
    instance: Instance,
    R: ArrayLike,
    T: ArrayLike,
    *,
    t: ArrayLike | None = None,
    twists: ArrayLike | None = None,
    accelerations: ArrayLike | None = None,
    load: ArrayLike = 0.0,
    drives: ArrayLike | None = None,
) -> DriveForces:
    """Return the forces of the drives along poses.

    Parameters
    ----------
    instance
        A platform with masses (``instance.dynamics``).
    R, T
        Poses, shapes (n, 3, 3) and (n, 3), ``x_base = R x_platform + T``, in length units.
    t
        Times in seconds, shape (n,). Without twists the platform moves along quintic splines
        through the poses; without times, too, it stands still at each of them.
    twists, accelerations
        Angular velocity (rad/s) and velocity of the platform's origin (length units/s) in the axes
        of the base, and their derivatives, shape (n, 6); both or none.
    load
        What else acts on the platform: moment about its origin (N m) and force (N) in the axes of
        the base, shape (n, 6) or (6,).
    drives
        Of a platform with cranks or slides: where its m drives are at the poses, shape (n, m) or
        (m,), as readings. By default in the working modes of home (`gspcli.geometry.machine`).

    Raises
    ------
    ArgumentError
        If the instance has no masses, an array has a wrong shape or number, or times do not
        increase. If a value has no derivative at a pose: a distance of 0, parallel lines, an angle
        at the end of its range. If a drive does not reach a pose, or is at a dead point there.

    Notes
    -----
    ``J^T F = M t' + h - G - load`` and, for drives with inertia, ``F += inertia value''``; see
    `gspcli.dynamics.moving_bodies`. Relative errors are about 1e-16 times the condition number of
    the pose. Torques of cranks and forces of slides are ``D^T F``, D the gains of the drives, and
    what the joint on the arm or carriage, its weight and its inertia need beside.

    Examples
    --------
    >>> import numpy as np, gspcli
    >>> from dataclasses import replace
    >>> angles = np.radians([0, 20, 120, 140, 240, 260])
    >>> ring = np.stack((np.cos(angles), np.sin(angles), 0 * angles), axis=1)
    >>> body = gspcli.RigidBody(12, [0, 0, 20], [4e4, 4e4, 7e4, 0, 0, 0])
    >>> hexapod = gspcli.hexapod(300 * ring, 200 * ring[[5, 0, 1, 2, 3, 4]], [250] * 6)
    >>> hexapod = replace(hexapod, dynamics=gspcli.Dynamics(body))
    >>> inverse_dynamics(hexapod, np.eye(3), [10, 20, 150])
    <DriveForces of DPP DPP DPP DPP DPP DPP: 1 pose, at most 87.7488 N (drive 4 at row 1)>
    """
    model = MassModel.of(instance)
    R, T = checked_rows(R, T)
    q = numbers_at(model, R, T, drives)
    times = None if t is None else checked_array(t, (len(R),), "t")
    motion = _motion(R, T, times, twists, accelerations)
    wrench = checked_array(load, (len(R), 6), "load")

    def some(rows: slice) -> tuple[Any, ...]:
        moving = PoseRates(motion.twists[rows], motion.accelerations[rows])
        return _forces(model, R[rows], T[rows] * model.metre, q[rows], moving, wrench[rows])

    return DriveForces(instance, times, R, T, *motion, *by_chunks(len(R), _CHUNK, some))


def _motion(
    R: Array, T: Array, t: Array | None, twists: ArrayLike | None, accelerations: ArrayLike | None
) -> PoseRates:
    if (twists is None) != (accelerations is None):
        message = "found one of twists and accelerations, expected both or none"
        raise ArgumentError(message)
    if twists is not None and accelerations is not None:
        shape = (len(R), 6)
        return PoseRates(
            checked_array(twists, shape, "twists"),
            checked_array(accelerations, shape, "accelerations"),
        )
    return at_rest(len(R)) if t is None else spline_motion(t, R, T)


def _forces(
    model: MassModel, R: Array, T: Array, q: Array, motion: PoseRates, load: Array
) -> tuple[Any, ...]:
    """Return forces, powers, singular poses, conditions of nearly singular, and torques."""
    twists, accelerations = model.in_metres(motion.twists), model.in_metres(motion.accelerations)
    acting, machine = Actuation(model, R, T, q), model.machine
    needed = MovingBodies(model, acting.at).wrenches(twists, accelerations, model.gravity)
    acting.check_rates(twists)
    singular, conditions = acting.conditions()
    columns = np.swapaxes(acting.at.jacobian, -1, -2)
    columns = np.where(singular[:, None, None], np.eye(6), columns)
    wrench = needed.on_platform - load
    forces = np.asarray(np.linalg.solve(columns, wrench[..., None])[..., 0], float)
    torques = (acting.at.gains * forces + needed.on_drives) @ model.users
    if model.rotors.any():
        torques += model.rotors * acting.at.rates(twists, accelerations)[1][..., machine.first]
    forces[singular], torques[singular] = np.nan, np.nan
    values = ~machine.driven
    forces[:, values] = torques[:, machine.index[values]]
    powers: Array = torques * machine.per_drive(apply(acting.pulls, twists))
    return forces, powers, singular, conditions, torques
