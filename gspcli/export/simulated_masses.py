"""What the bodies of a simulated model weigh: as the instance states, or placeholders.

A simulator needs masses for all bodies, also for the links of chains that stand for constraints
and weigh nothing. Without stated masses each link weighs as much as the platform, since light links
make stiff constraints soft. With them the links weigh a small part of it. Gravity pulls at neither.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from gspcli.dynamics.mass_model import MassModel
from gspcli.geometry.instance import Instance
from gspcli.geometry.masses import Leg, LegBody
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: Kilogrammes of the platform and of each link if nothing is stated.
_MASS = 1.0
#: What links weigh of the platform where its mass is stated: heavier ones settle sooner, and add
#: more inertia.
LIGHT = 1e-3
#: Without a stated stiffness drives give way to gravity by about this part of the size. They have
#: at least and at most this many N/m for each kilogramme of the platform: stiffer ones are not
#: stable with a step of 0.5 ms.
_SAG, _SOFT, _STIFF = 2e-4, 1e4, 4e6
#: The inertia of a joint alone, as a share of that of a link, so that none of two parallel joints
#: of a link is without inertia.
_ROTOR = 0.01
#: Inertias of leg bodies are at least this share of the mass times the square of the size.
_SLENDER = 1e-6
#: Of each link, about its centre: its mass times the square of the size times this.
_ROUND = 0.1
#: The spin of a rod between two balls falls to 1/e in the inverse of this time, seconds.
_SPIN = 3.0


@dataclass(frozen=True, eq=False)
class Inertial:
    """The inertia of a body."""

    #: Kilogrammes.
    mass: float
    #: The centre of mass in the frame of the body, metres, shape (3,).
    centre: Array
    #: The matrix of inertia about it in the axes of the body, kg m^2, shape (3, 3).
    matrix: Array
    #: Whether gravity pulls at it.
    falls: bool = True


class SimulatedMasses:
    """The masses of the model of an instance, in SI units.

    Parameters
    ----------
    instance
        The platform.
    middle
        The middle of the platform's points, in its frame, shape (3,).
    size
        Its typical length, which links have for size, in metres.
    """

    def __init__(self, instance: Instance, middle: Array, size: float) -> None:
        self.model = None if instance.dynamics is None else MassModel.of(instance)
        self.size = size
        model = self.model
        round_body = _ROUND * _MASS * size**2 * np.eye(3)
        self.platform = (
            Inertial(_MASS, middle, round_body)
            if model is None
            else Inertial(model.mass, model.centre, model.inertia)
        )
        link = _MASS if model is None else LIGHT * model.mass
        self.link = Inertial(link, np.zeros(3), _ROUND * link * size**2 * np.eye(3), falls=False)

    def gravity(self, against_z: float | None) -> Array:
        """Return the acceleration of what falls, shape (3,); as stated unless a number is given."""
        if against_z is None and self.model is not None:
            return self.model.gravity
        return np.array([0.0, 0.0, -(9.81 if against_z is None else against_z)])

    def armature(self, kind: str, constraint: int | None) -> float:
        """Return the inertia of a joint alone, with the drive of a constraint (from 0) or none.

        Kilogrammes for slides, kg m^2 for others.
        """
        own = _ROTOR * self.link.mass * (1.0 if kind == "slide" else self.size**2)
        if constraint is None or self.model is None:
            return own
        return own + float(self.model.rotors[self.model.machine.index[constraint]])

    def stiffness(self, constraint: int, *, lever: float = 1.0) -> float:
        """Return how stiff the drive of a constraint is, N/m or N m/rad.

        Parameters
        ----------
        constraint
            The constraint, from 0; the first one of a drive that several share.
        lever
            1 for a force; of a torque the length at which it pulls at the platform.
        """
        if self.model is not None and self.model.stiffness is not None:
            return float(self.model.stiffness[self.model.machine.index[constraint]])
        pull = float(np.linalg.norm(self.gravity(None)))
        of_a_kilogramme = min(max(_SOFT, pull / (_SAG * self.size)), _STIFF)
        return of_a_kilogramme * self.platform.mass * lever**2

    def damping(self, stiffness: float) -> float:
        """Return the damping of a drive that lets the platform's mass come to rest at once."""
        return 2 * math.sqrt(stiffness * self.platform.mass)

    def arm_damping(self, stiffness: float, lever: float) -> float:
        """Return the damping of a crank of a stiffness: of the platform's mass at its arm's end."""
        moment = self.platform.mass * lever**2 + float(self.link.matrix[0, 0])
        return 2 * math.sqrt(stiffness * moment)

    def spin_damping(self, inertial: Inertial, e: Array) -> float:
        """Return the damping of a ball that stops the spin of a rod along e in about a second."""
        return _SPIN * float(e @ inertial.matrix @ e)

    def has_leg(self, constraint: int) -> bool:
        """Return whether a constraint (from 0) is a leg whose bodies weigh something."""
        return self.model is not None and constraint in self.model.legs.rows

    def leg_axis(self, constraint: int) -> Array | None:
        """Return the first axis of a leg's universal joint, a unit vector; None if it has none."""
        assert self.model is not None
        axis = self.model.legs.axes[self.model.legs.rows.tolist().index(constraint)]
        return axis if axis.any() else None

    def leg_bodies(self, constraint: int, e: Array) -> tuple[Inertial, Inertial]:
        """Return cylinder and rod of a leg in the direction e, each in a frame at its joint."""
        leg = self._leg(constraint)
        return self._leg_body(leg.cylinder, e), self._leg_body(leg.rod, -e)

    def rod(self, constraint: int, e: Array) -> Inertial:
        """Return the rod of a constraint (from 0) along e, in a frame at its joint on the base.

        Its bodies are one: a rod does not change its length.
        """
        if not self.has_leg(constraint):
            return self.link
        cylinder, rod = self.leg_bodies(constraint, e)
        assert self.model is not None
        length = float(self.model.bodies.values[constraint])
        parts = [(cylinder, cylinder.centre), (rod, length * e + rod.centre)]
        parts = [(body, centre) for body, centre in parts if body.falls]
        mass = sum(body.mass for body, _ in parts)
        centre = sum((body.mass * at for body, at in parts), np.zeros(3)) / mass
        matrix = np.zeros((3, 3))
        for body, at in parts:
            r = at - centre
            matrix += body.matrix + body.mass * (r @ r * np.eye(3) - np.outer(r, r))
        return Inertial(mass, centre, matrix)

    def carrier(self, constraint: int, across: Array) -> Inertial:
        """Return the arm or the carriage of a constraint, in a frame at its joint.

        Parameters
        ----------
        constraint
            The constraint, from 0; the first one of a drive that several share.
        across
            The arm of a crank in the frame of its body, in length units, shape (3,).
        """
        model = self.model
        drive = 0 if model is None else model.machine.index[constraint]
        if model is None or not model.carriers.mass[drive]:
            return self.link
        mass = float(model.carriers.mass[drive])
        moment = max(float(model.carriers.inertia[drive]), _SLENDER * mass * self.size**2)
        centre = float(model.carriers.share[drive]) * across * model.metre
        return Inertial(mass, centre, moment * np.eye(3))

    def _leg(self, constraint: int) -> Leg:
        assert self.model is not None
        assert self.model.instance.dynamics is not None
        legs = self.model.instance.dynamics.legs
        return legs[0 if len(legs) == 1 else self.model.legs.rows.tolist().index(constraint)]

    def _leg_body(self, body: LegBody | None, way: Array) -> Inertial:
        assert self.model is not None
        least = _SLENDER * self.platform.mass
        if body is None:
            return Inertial(least, np.zeros(3), least * self.size**2 * np.eye(3), falls=False)
        mass, metre = body.mass.value, self.model.metre
        slender = _SLENDER * mass * self.size**2
        across, axial = (
            max(moment.value * metre**2, slender) for moment in (body.inertia, body.axial)
        )
        along = np.outer(way, way)
        matrix = across * (np.eye(3) - along) + axial * along
        return Inertial(mass, body.centre.value * metre * way, matrix)
