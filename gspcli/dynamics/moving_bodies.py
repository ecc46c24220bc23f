r"""Newton and Euler for the platform and the two bodies of each leg, at poses.

A twist t = (omega, v) is the angular velocity, and the velocity of the origin of the platform, in
the axes of the base. The wrench (moment, force) that moves the bodies as they move, about the
origin of the platform, is

    M(R, T) t' + h(R, T, t) - G(R, T),

and this is computed here as it stands, from the accelerations of the bodies. The mass matrix M is
the wrench of six unit accelerations at rest without gravity, so that nothing is said twice.

A leg runs from x in the base to p = T + R y: with l = |p - x|, e = (p - x) / l its direction. Its
cylinder moves with e alone, the centre of its rod is p - c e. Neither spins about e, unless the
joint at the base is a universal joint with the first axis u: then the leg spins by
c (u x e) . e' / (1 - c^2) with c = u . e. A wrench follows from forces on p and on e by virtual
power: p' = omega x R y + v and e' = (1 - e e^T) p' / l.

A crank or slide moves x, or R y: its number q follows from the pose, since the rod keeps its
length. Then e' = (1 - e e^T) (p' - x') / l. Forces on x, on the
arm and on the carriage act on q, too. The torque of the drive is their sum and the gain times the
force along the rod. On the pose they act by the derivative of q.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gspcli.dynamics.arrays import RowError
from gspcli.dynamics.mass_model import MassModel
from gspcli.geometry.instance import Array
from gspcli.geometry.machine import MachineAtPoses
from gspcli.geometry.quaternions import apply, cross, dot

#: A leg at a smaller angle than this (radians) to the first axis of its universal joint is locked.
_LOCKED = 1e-9


class LegMotion(NamedTuple):
    """How m legs move: rates and accelerations of directions, accelerations of the ends."""

    turning: Array
    """Shape (..., m, 3), as all."""
    turning_rate: Array
    end_rate: Array
    start_rate: Array
    """Of the base's points."""


class BodyWrenches(NamedTuple):
    """What moves the bodies, beside what the drives do for themselves."""

    on_platform: Array
    """About the origin of the platform with the drives still: moment and force, (..., 6)."""
    on_drives: Array
    """By what constraints ask of drives, (..., 6): carriers at the first one of their drive."""


class MovingBodies:
    """The bodies of a platform whose machine is at poses, in metres.

    Raises
    ------
    RowError
        If a leg lies along the first axis of its universal joint, where that locks.
    """

    def __init__(self, model: MassModel, at: MachineAtPoses) -> None:
        self.model, self.at = model, at
        self.centre = apply(at.R, model.centre)
        self.inertia = at.R @ model.inertia @ np.swapaxes(at.R, -1, -2)
        rows = model.legs.rows
        self.arm, along = at.placed.arm[..., rows, :], at.placed.r[..., rows, :]
        self.ways, self.bends = at.ways[..., rows, :], at.bends[..., rows, :]
        self.on_platform = model.machine.on_platform[rows, None]
        self.length = np.sqrt(dot(along, along))[..., None]
        self.e = along / self.length
        if model.legs.axial.any():
            self._place_joints()

    def _place_joints(self) -> None:
        """Note how the universal joints stand to the legs."""
        axes = self.model.legs.axes
        self.cosine = dot(axes, self.e)[..., None]
        self.normal = cross(axes, self.e)
        self.square = dot(self.normal, self.normal)[..., None]
        spins = self.model.legs.axial[:, 0] > 0
        locked = spins & (self.square[..., 0] < _LOCKED**2)
        if locked.any():
            row, *_, k = np.argwhere(np.atleast_2d(locked))[0].tolist()
            message = (
                f"leg {self.model.legs.rows[k] + 1} lies along the first axis of its universal "
                "joint, which locks there: check universal in the instance file"
            )
            raise RowError(row, message)
        # Legs that do not spin have no axis.
        self.square = np.where(spins[:, None], self.square, 1.0)

    def wrench(self, twists: Array, accelerations: Array, gravity: Array) -> Array:
        """Return what moves the bodies so: (moment, force) about the platform's origin, (..., 6).

        With the numbers of the drives as they follow from the pose. Parameters as `wrenches`.
        """
        found = self.wrenches(twists, accelerations, gravity)
        columns = np.swapaxes(self.at.jacobian, -1, -2)
        return np.asarray(found.on_platform + apply(columns, found.on_drives / self.at.gains))

    def wrenches(self, twists: Array, accelerations: Array, gravity: Array) -> BodyWrenches:
        """Return what moves the bodies so.

        Parameters
        ----------
        twists, accelerations
            Of the platform, shape (..., 6), with which the poses are broadcast.
        gravity
            Shape (..., 3).
        """
        omega, alpha = twists[..., :3], accelerations[..., :3]
        force = self.model.mass * (self._centre_rate(twists, accelerations) - gravity)
        spin = apply(self.inertia, alpha) + cross(omega, apply(self.inertia, omega))
        moment = cross(self.centre, force) + spin
        rates, second_rates = self._rates(twists, accelerations)
        on_drives = self._on_carriers(second_rates, gravity)
        if len(self.model.legs.rows):
            motion = self._legs(twists, accelerations, rates, second_rates)
            at_end, at_start = self._on_ends(motion, gravity)
            force = force + at_end.sum(axis=-2)
            moment = moment + cross(self.arm, at_end).sum(axis=-2)
            by_drive = dot(np.where(self.on_platform, at_end, -at_start), self.ways)
            on_drives[..., self.model.legs.rows] += by_drive
        on_platform = np.concatenate((moment, force), axis=-1)
        return BodyWrenches(on_platform, on_drives)

    def _rates(self, twists: Array, accelerations: Array) -> tuple[Array, Array]:
        """Return the rates of what moves points, (..., 6), and their derivatives; zero for none."""
        if self.model.machine.driven.any():
            return self.at.rates(twists, accelerations)
        still = np.zeros(np.broadcast_shapes(self.at.gains.shape, (*twists.shape[:-1], 1)))
        return still, still

    def _on_carriers(self, second_rates: Array, gravity: Array) -> Array:
        """Return what moves arms and carriages, by the first constraints of drives, (..., 6)."""
        carriers, first = self.model.carriers, self.model.machine.first
        found = np.zeros(np.broadcast_shapes(second_rates.shape, (*gravity.shape[:-1], 1)))
        if self.model.machine.moves:
            # The ways are those of the rods: against the points of the base.
            fall = (self.at.ways[..., first, :] * gravity[..., None, :]).sum(axis=-1)
            weights = carriers.mass * carriers.share * fall
            found[..., first] = carriers.moment * second_rates[..., first] + weights
        return found

    def potential_bend(self, twists: Array) -> Array:
        """Return the second derivative of the potential energy along constant twists, (...)."""
        legs, gravity, still = self.model.legs, self.model.gravity, np.zeros(6)
        carriers, first = self.model.carriers, self.model.machine.first
        fall = self.model.mass * (self._centre_rate(twists, still) @ gravity)
        rates, second_rates = self._rates(twists, still)
        if self.model.machine.moves:
            bent = self.at.ways * second_rates[..., None] + self.at.bends * rates[..., None] ** 2
            fall = fall - (bent[..., first, :] @ gravity) @ (carriers.mass * carriers.share)
        if len(legs.rows):
            motion = self._legs(twists, still, rates, second_rates)
            cylinder = legs.cylinder[0] * legs.cylinder[1] * motion.turning_rate
            cylinder = cylinder + legs.cylinder[0] * motion.start_rate
            rod = legs.rod[0] * (motion.end_rate - legs.rod[1] * motion.turning_rate)
            fall = fall + ((cylinder + rod) @ gravity).sum(axis=-1)
        return np.asarray(-fall)

    def _centre_rate(self, twists: Array, accelerations: Array) -> Array:
        """Return the acceleration of the centre of mass of the platform, (..., 3)."""
        omega = twists[..., :3]
        bend = cross(omega, cross(omega, self.centre))
        rate: Array = cross(accelerations[..., :3], self.centre) + accelerations[..., 3:] + bend
        return rate

    def _legs(
        self, twists: Array, accelerations: Array, rates: Array, second_rates: Array
    ) -> LegMotion:
        """Return how the legs move with the platform, and with their drives: rates (..., 6)."""
        t, a = twists[..., None, :], accelerations[..., None, :]
        omega, e, rows = t[..., :3], self.e, self.model.legs.rows
        turned = cross(omega, self.arm)
        q, second = rates[..., rows, None], second_rates[..., rows, None]
        way, change = self.ways * q, self.ways * second + self.bends * q * q
        end_rate = cross(a[..., :3], self.arm) + a[..., 3:] + cross(omega, turned)
        end_rate = end_rate + np.where(self.on_platform, 2 * cross(omega, way) + change, 0.0)
        start_rate = np.where(self.on_platform, 0.0, -change)
        moving, apart = turned + t[..., 3:] + way, end_rate - start_rate
        speed = dot(e, moving)[..., None]
        turning = (moving - speed * e) / self.length
        # From p - x = l e: p'' - x'' = l'' e + 2 l' e' + l e'', l'' = e . (p'' - x'') + l |e'|^2.
        across = apart - dot(e, apart)[..., None] * e - 2 * speed * turning
        rate = across / self.length - dot(turning, turning)[..., None] * e
        return LegMotion(turning, rate, end_rate, start_rate)

    def _on_ends(self, motion: LegMotion, gravity: Array) -> tuple[Array, Array]:
        """Return the forces at both ends of the legs that this motion needs, each (..., m, 3)."""
        legs, rate = self.model.legs, motion.turning_rate
        (mass, place), (rod, below) = legs.cylinder, legs.rod
        fall = gravity[..., None, :]
        on_rod = rod * (motion.end_rate - below * rate - fall)
        on_cylinder = motion.start_rate + place * rate - fall
        on_direction = legs.across * rate + mass * place * on_cylinder
        if legs.axial.any():
            on_direction = on_direction + legs.axial * self._spinning(motion)
        on_direction = on_direction - below * on_rod
        across = on_direction - dot(self.e, on_direction)[..., None] * self.e
        across = across / self.length
        return np.asarray(on_rod + across), np.asarray(mass * on_cylinder - across)

    def _spinning(self, motion: LegMotion) -> Array:
        """Return the forces on directions by unit inertias about legs that spin, (..., m, 3)."""
        c, square, n = self.cosine, self.square, self.normal
        turning = motion.turning
        by = dot(n, turning)[..., None]
        spin = c / square * by
        rate = dot(self.model.legs.axes, turning)[..., None] * (1 + c * c) / square**2 * by
        rate = rate + c / square * dot(n, motion.turning_rate)[..., None]
        return np.asarray(rate * c / square * n + spin * cross(turning, self.e))


def equation_of_motion(
    model: MassModel, R: Array, T: Array, q: Array, twists: Array
) -> tuple[Array, Array]:
    """Return M and h - G without the drives, shapes (..., 6, 6) and (..., 6).

    Parameters
    ----------
    model, R, T, q
        The platform, poses in metres and the numbers of the drives there.
    twists
        How it moves there, shape (..., 6).
    """
    # One after the other: as it moves with gravity, then six unit accelerations at rest.
    moving = np.zeros((*twists.shape[:-1], 7, 6))
    moving[..., 0, :] = twists
    gravity = np.zeros((7, 3))
    gravity[0] = model.gravity
    at = model.machine.at(R[..., None, :, :], T[..., None, :], q[..., None, :])
    rows = MovingBodies(model, at).wrench(moving, np.eye(7, 6, -1), gravity)
    columns = rows[..., 1:, :]
    return (columns + np.swapaxes(columns, -1, -2)) / 2, rows[..., 0, :]
