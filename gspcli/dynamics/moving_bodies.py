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
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.dynamics.arrays import RowError
from gspcli.dynamics.mass_model import MassModel
from gspcli.geometry.quaternions import apply, cross, dot

Array = NDArray[np.float64]

#: A leg at a smaller angle than this (radians) to the first axis of its universal joint is locked.
_LOCKED = 1e-9


class LegMotion(NamedTuple):
    """How m legs move: rates and accelerations of directions, accelerations of the ends."""

    turning: Array
    """Shape (..., m, 3), as all."""
    turning_rate: Array
    end_rate: Array


class MovingBodies:
    """The bodies of a platform at poses, shapes (..., 3, 3) and (..., 3), in metres.

    Raises
    ------
    RowError
        If a leg lies along the first axis of its universal joint, where that locks.
    """

    def __init__(self, model: MassModel, R: Array, T: Array) -> None:
        self.model = model
        self.R, self.T = R, T
        self.centre = apply(R, model.centre)
        self.inertia = R @ model.inertia @ np.swapaxes(R, -1, -2)
        rows = model.legs.rows
        self.arm = model.bodies.y[rows] @ np.swapaxes(R, -1, -2)
        along = self.arm + T[..., None, :] - model.bodies.x[rows]
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
        if len(self.model.legs.rows):
            at_end = self._on_ends(self._legs(twists, accelerations), gravity)
            force = force + at_end.sum(axis=-2)
            moment = moment + cross(self.arm, at_end).sum(axis=-2)
        return np.concatenate((moment, force), axis=-1)

    def potential(self) -> Array:
        """Return the potential energy of the bodies in gravity, shape (...)."""
        legs, gravity = self.model.legs, self.model.gravity
        fall = self.model.mass * ((self.centre + self.T) @ gravity)
        ends = self.arm + self.T[..., None, :]
        for (mass, place), start, way in (
            (legs.cylinder, self.model.bodies.x[legs.rows], self.e),
            (legs.rod, ends, -self.e),
        ):
            fall = fall + (mass * (start + place * way) @ gravity[:, None]).sum(axis=(-1, -2))
        return np.asarray(-fall)

    def potential_bend(self, twists: Array) -> Array:
        """Return the second derivative of the potential energy along constant twists, (...)."""
        legs, gravity, still = self.model.legs, self.model.gravity, np.zeros(6)
        fall = self.model.mass * (self._centre_rate(twists, still) @ gravity)
        if len(legs.rows):
            motion = self._legs(twists, still)
            cylinder = legs.cylinder[0] * legs.cylinder[1] * motion.turning_rate
            rod = legs.rod[0] * (motion.end_rate - legs.rod[1] * motion.turning_rate)
            fall = fall + ((cylinder + rod) @ gravity).sum(axis=-1)
        return np.asarray(-fall)

    def _centre_rate(self, twists: Array, accelerations: Array) -> Array:
        """Return the acceleration of the centre of mass of the platform, (..., 3)."""
        omega = twists[..., :3]
        bend = cross(omega, cross(omega, self.centre))
        rate: Array = cross(accelerations[..., :3], self.centre) + accelerations[..., 3:] + bend
        return rate

    def _legs(self, twists: Array, accelerations: Array) -> LegMotion:
        t, a = twists[..., None, :], accelerations[..., None, :]
        omega, e = t[..., :3], self.e
        turned = cross(omega, self.arm)
        end_rate = cross(a[..., :3], self.arm) + a[..., 3:] + cross(omega, turned)
        moving = turned + t[..., 3:]
        speed = dot(e, moving)[..., None]
        turning = (moving - speed * e) / self.length
        # From p - x = l e: p'' = l'' e + 2 l' e' + l e'', and l'' = e . p'' + l |e'|^2.
        across = end_rate - dot(e, end_rate)[..., None] * e - 2 * speed * turning
        rate = across / self.length - dot(turning, turning)[..., None] * e
        return LegMotion(turning, rate, end_rate)

    def _on_ends(self, motion: LegMotion, gravity: Array) -> Array:
        """Return the forces at the ends of the legs that move them so, (..., m, 3)."""
        legs, rate = self.model.legs, motion.turning_rate
        (mass, place), (rod, below) = legs.cylinder, legs.rod
        fall = gravity[..., None, :]
        on_rod = rod * (motion.end_rate - below * rate - fall)
        on_direction = legs.across * rate + mass * place * (place * rate - fall)
        if legs.axial.any():
            on_direction = on_direction + legs.axial * self._spinning(motion)
        on_direction = on_direction - below * on_rod
        across = on_direction - dot(self.e, on_direction)[..., None] * self.e
        return np.asarray(on_rod + across / self.length)

    def _spinning(self, motion: LegMotion) -> Array:
        """Return the forces on directions by unit inertias about legs that spin, (..., m, 3)."""
        c, square, n = self.cosine, self.square, self.normal
        turning = motion.turning
        by = dot(n, turning)[..., None]
        spin = c / square * by
        rate = dot(self.model.legs.axes, turning)[..., None] * (1 + c * c) / square**2 * by
        rate = rate + c / square * dot(n, motion.turning_rate)[..., None]
        return np.asarray(rate * c / square * n + spin * cross(turning, self.e))


def equation_of_motion(model: MassModel, R: Array, T: Array, twists: Array) -> tuple[Array, Array]:
    """Return M and h - G without the drives, shapes (..., 6, 6) and (..., 6).

    Parameters
    ----------
    model, R, T
        The platform, and poses in metres.
    twists
        How it moves there, shape (..., 6).
    """
    # One after the other: as it moves with gravity, then six unit accelerations at rest.
    moving = np.zeros((*twists.shape[:-1], 7, 6))
    moving[..., 0, :] = twists
    gravity = np.zeros((7, 3))
    gravity[0] = model.gravity
    bodies = MovingBodies(model, R[..., None, :, :], T[..., None, :])
    rows = bodies.wrench(moving, np.eye(7, 6, -1), gravity)
    columns = rows[..., 1:, :]
    return (columns + np.swapaxes(columns, -1, -2)) / 2, rows[..., 0, :]
