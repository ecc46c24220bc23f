"""Small motions and forces at a pose: screws, Jacobian matrices, statics, stiffness.

A twist is (omega, v): the angular velocity, in radians, and the velocity of a stated point, both in
the axes of the base. A wrench is (force, moment) about that point. All functions take leading batch
axes.

With J t = D q' (`gspcli.geometry.machine`) a force F in the constraints needs the loads ``D^T F``
of the drives; of values D is the identity. Springs of drives and of rods are in series: the rods
give by ``C = D k_q^-1 D^T + k_r^-1`` times F, so that the stiffness of the platform is
``J^T C^-1 J``.
It is finite at a dead point if the rods give. An error dq of the drives and dL of the rods moves
the platform by ``J^-1 (dL + D dq)``.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement, Array
from gspcli.geometry.enclosures import roundings
from gspcli.geometry.instance import Instance
from gspcli.geometry.machine import Machine
from gspcli.geometry.measurement import condition_numbers, value_slopes, without_derivative
from gspcli.geometry.quaternions import apply, cross
from gspcli.records import dataclass
from gspcli.ties import first_largest

#: Above this condition number the inverse matrix has no correct digits.
_CONDITION = 1e14


@dataclass(frozen=True, eq=False)
class Wrenches:
    """The six constraints at poses as wrenches."""

    #: The platform.
    instance: Instance
    #: The poses, shapes (..., 3, 3) and (..., 3).
    R: Array
    T: Array
    #: The point, fixed in the base, that twists and wrenches are about, shape (..., 3).
    point: Array
    #: The unit of length in which lengths and angles are compared.
    length: float
    #: Derivatives of the values, as `measure` gives them, with respect to the twist (omega, v),
    #: shape (..., 6, 6): lengths and radians. Row k is the wrench (moment, force) of constraint k
    #: at unit strength.
    jacobian: Array
    #: The platform in floating point, with its points where the drives have them.
    arrangement: Arrangement
    #: The drives and their numbers, lengths and radians, shape (..., m).
    drives: Machine
    q: Array

    @cached_property
    def angles(self) -> NDArray[np.bool_]:
        """Which constraints are angles, shape (6,)."""
        return np.array([not row.kind.is_distance for row in self.instance.constraints])

    @cached_property
    def forces(self) -> Array:
        """Directions of the forces, unit vectors, zero for angles, shape (..., 6, 3)."""
        return self.jacobian[..., 3:]

    @cached_property
    def moments(self) -> Array:
        """Moments of the unit wrenches about the point, shape (..., 6, 3)."""
        return self.jacobian[..., :3]

    @cached_property
    def pitches(self) -> Array:
        """Pitches of the screws: moment along the force, a length; infinite for angles (..., 6).

        A product is zero if rounding errors of the largest moment may make all of it.
        """
        square = np.einsum("...i,...i->...", self.forces, self.forces)
        along = np.einsum("...i,...i->...", self.forces, self.moments)
        arms = np.linalg.norm(self.moments, axis=-1).max(axis=-1, keepdims=True)
        along = np.where(np.abs(along) <= roundings(28, np.sqrt(square) * arms), 0.0, along)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.angles, np.inf, along / square)

    @cached_property
    def feet(self) -> Array:
        """The point of the axis of each screw nearest to the point; NaN for angles (..., 6, 3)."""
        square = np.einsum("...i,...i->...", self.forces, self.forces)[..., None]
        with np.errstate(divide="ignore", invalid="ignore"):
            arm = cross(self.forces, self.moments) / square
        feet: Array = np.where(self.angles[:, None], np.nan, self.point[..., None, :] + arm)
        return feet

    @cached_property
    def scaled(self) -> Array:
        """The Jacobian matrix free of units, with the length as the unit, shape (..., 6, 6)."""
        rows = np.where(self.angles, self.length, 1.0)
        columns = np.array([1 / self.length] * 3 + [1.0] * 3)
        scaled: Array = self.jacobian * rows[:, None] * columns
        return scaled

    @cached_property
    def singular_values(self) -> Array:
        """Of the scaled Jacobian matrix, the largest first, shape (..., 6)."""
        return np.asarray(np.linalg.svd(self.scaled, compute_uv=False))

    @cached_property
    def conditions(self) -> Array:
        """The condition numbers of the poses with the length as the unit, shape (...).

        They are those of `gsp solve` (`condition_numbers`): for the matrix about the centre of the
        platform with rows of norm one. They do not depend on the point.
        """
        return condition_numbers(self.arrangement, self.R, self.T, self.length)

    @cached_property
    def manipulability(self) -> Array:
        """The product of the singular values, ``|det|`` of the scaled matrix, shape (...)."""
        return np.asarray(self.singular_values.prod(axis=-1))

    @cached_property
    def inverse(self) -> Array:
        """Twists (columns) for unit changes of the values, shape (..., 6, 6); NaN if singular."""
        regular = self.conditions < _CONDITION
        identity = np.broadcast_to(np.eye(6), self.jacobian.shape)
        inverse = np.linalg.inv(np.where(regular[..., None, None], self.jacobian, identity))
        return np.asarray(np.where(regular[..., None, None], inverse, np.nan))

    def reactions(self, force: ArrayLike, moment: ArrayLike, at: ArrayLike) -> Array:
        """Return the reactions of the constraints that hold a load, shape (..., 6).

        Forces for distances, positive if the constraint pushes towards a greater value (a leg under
        compression); moments for angles, in units of force times length.

        Parameters
        ----------
        force, moment
            The load on the platform, in the axes of the base, shape (..., 3).
        at
            The point where the force acts, fixed in the base, shape (..., 3).
        """
        force, moment = np.asarray(force, float), np.asarray(moment, float)
        about = moment + cross(
            np.asarray(at, float) - self.point, np.broadcast_to(force, self.T.shape)
        )
        load = np.concatenate((about, np.broadcast_to(force, about.shape)), axis=-1)
        held: Array = -apply(np.swapaxes(self.inverse, -1, -2), load)
        return held

    @cached_property
    def worst_force(self) -> tuple[NDArray[np.int64], Array, Array]:
        """The direction of a unit force at the point that loads one constraint most.

        Of constraints that are loaded equally the first is taken.

        Returns
        -------
        constraint, direction, reaction
            Index of the constraint, shape (...), the direction of the force, (..., 3), and the
            reaction of the constraint, (...).
        """
        columns = -self.inverse[..., 3:, :]
        sizes = np.linalg.norm(columns, axis=-2)
        constraint = first_largest(np.nan_to_num(sizes, nan=-1.0))
        chosen = np.take_along_axis(columns, constraint[..., None, None], axis=-1)[..., 0]
        reaction = np.take_along_axis(sizes, constraint[..., None], axis=-1)[..., 0]
        return constraint, chosen / reaction[..., None], reaction

    @cached_property
    def gains(self) -> Array:
        """The gain of the drive of each constraint, shape (..., 6)."""
        return self.drives.gains(self.R, self.T, self.q)

    @property
    def matrix(self) -> Array:
        """D, shape (..., 6, m)."""
        return self.drives.matrix(self.gains)

    @property
    def transmissions(self) -> Array:
        """The transmission of each constraint, NaN where its value is the drive, (..., 6)."""
        share = self.drives.transmission(self.gains)
        return np.where(self.drives.driven, share, np.nan)

    def torques(self, reactions: Array) -> Array:
        """Return the loads of the drives that hold forces in the constraints, (..., m)."""
        return np.asarray(apply(np.swapaxes(self.matrix, -1, -2), reactions))

    def compliance(self, motors: ArrayLike | None = None, rods: ArrayLike | None = None) -> Array:
        """Return how far forces in the constraints move their values, C, shape (..., 6, 6).

        Parameters
        ----------
        motors
            Stiffnesses of the drives: force over length, moment over radian, shape (m,); None if
            they do not give.
        rods
            Of the constraints, shape (6,); None if they do not give. Of driven values they stand
            for those of the drives.

        Raises
        ------
        ArgumentError
            If a stiffness is not positive.
        """
        soft = np.zeros(self.drives.count) if motors is None else 1 / _positive(motors)
        own = np.zeros(6)
        if rods is not None:
            soft, own = np.where(self.drives.moved, soft, 0.0), 1 / _positive(rods)
        through: Array = (self.matrix * soft) @ np.swapaxes(self.matrix, -1, -2)
        return through + np.diag(own)

    def stiffness(self, compliance: Array) -> Array:
        """Return ``J^T C^-1 J`` about the point, shape (..., 6, 6); NaN if it is not finite.

        It gives the wrench (moment, force) that holds a small twist (omega, v), without that of a
        preload. It is not finite if the rods do not give and a drive is at a dead point or moves
        two rods.
        """
        scales = np.sqrt(np.abs(np.einsum("...kk->...k", compliance)))
        scales = np.where(scales > 0, scales, 1.0)
        scaled = compliance / scales[..., :, None] / scales[..., None, :]
        ranks = np.asarray(np.linalg.matrix_rank(scaled, tol=1e-9, hermitian=True))
        regular = (ranks == len(self.drives.index))[..., None, None]
        J = self.jacobian
        safe = np.where(regular, compliance, np.eye(6))
        found: Array = np.swapaxes(J, -1, -2) @ np.linalg.solve(safe, J)
        found = (found + np.swapaxes(found, -1, -2)) / 2
        return np.where(regular, found, np.nan)

    def least_stiffness(self, compliance: Array) -> Array:
        """Return the least ratio of a force at the point to its shift, shape (...).

        The platform is free to turn, and the force has the direction of the largest shift. The
        number is the inverse of the largest eigenvalue of the compliance of the point. NaN at
        singular poses, infinite if nothing gives.
        """
        part = self.inverse[..., 3:, :]
        gives = part @ compliance @ np.swapaxes(part, -1, -2)
        known = np.asarray(np.isfinite(gives).all(axis=(-1, -2)))
        largest = np.linalg.eigvalsh(np.where(known[..., None, None], gives, np.eye(3)))[..., -1]
        with np.errstate(divide="ignore"):
            return np.where(known, 1 / np.maximum(largest, 0.0), np.nan)


def wrenches(
    instance: Instance,
    R: ArrayLike,
    T: ArrayLike,
    *,
    point: ArrayLike | None = None,
    length: float | None = None,
    drives: Machine | None = None,
    q: Array | None = None,
) -> Wrenches:
    """Return the constraints at poses as wrenches.

    Parameters
    ----------
    instance
        Geometry and units.
    R, T
        The poses, shapes (..., 3, 3) and (..., 3).
    point
        A point fixed in the base, shape (..., 3); by default the mean of the platform's points of
        distances, at the pose.
    length
        The unit in which lengths and angles are compared; by default the typical length of the
        instance (`Arrangement.length`).
    drives, q
        The drives, and their numbers at the poses, lengths and radians, shape (..., m): points with
        cranks and slides are moved there. They are where they are stated if None.

    Raises
    ------
    ArgumentError
        If the length is not positive, or if a value has no derivative at a pose. These are a
        distance of zero to a point or line, parallel lines of a DLL, and an angle at an end of its
        range.
    """
    R, T = np.asarray(R, float), np.asarray(T, float)
    if drives is None or q is None:
        drives = Machine.of(instance)
        q = drives.stated(R, T)
    arrangement = drives.arrangement(q)
    if length is None:
        length = arrangement.length
    if not (np.isfinite(length) and length > 0):
        message = f"found {length}, expected a positive length"
        raise ArgumentError(message, "length")
    at = (
        T + apply(R, arrangement.platform_centre)
        if point is None
        else np.broadcast_to(np.asarray(point, float), T.shape)
    )
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        rows = value_slopes(arrangement, R, T)
    undefined = ~np.isfinite(rows).all(axis=-1) | without_derivative(arrangement, R, T)
    if undefined.any():
        *place, k = np.argwhere(undefined)[0].tolist()
        pose = f"pose {place[0] + 1} of {len(T)}" if place and len(T) > 1 else "this pose"
        kind = arrangement.kinds[k].name
        message = f"the value of constraint {k + 1} ({kind}) has no derivative at {pose}"
        raise ArgumentError(message)
    arm = np.broadcast_to((at - T)[..., None, :], rows[..., 3:].shape)
    moments = rows[..., :3] - cross(arm, rows[..., 3:])
    matrix = np.concatenate((moments, rows[..., 3:]), axis=-1)
    return Wrenches(instance, R, T, at, float(length), matrix, arrangement, drives, q)


def _positive(each: ArrayLike) -> Array:
    constants = np.asarray(each, float)
    if not (np.isfinite(constants) & (constants > 0)).all():
        message = f"found {constants.tolist()}, expected positive numbers"
        raise ArgumentError(message, "stiffness")
    return constants
