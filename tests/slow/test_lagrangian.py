"""Forces of the drives against Lagrange's equations, derived numerically with forty digits.

The energies and the ten distances and angles are stated here again, in SI units; nothing of the
package computes them. All derivatives are central differences, whose errors forty digits hide.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from mpmath import mp, mpf

from gspcli.catalogue.kinds import DPP
from gspcli.dynamics import inverse_dynamics
from gspcli.geometry.instance import METRES, AngleUnit, Units
from gspcli.geometry.masses import Dynamics
from gspcli.geometry.primitives import Plane, Point
from gspcli.motion import measure
from tests.support.masses import random_motion, random_platform

pytestmark = pytest.mark.slow

#: Every kind is in one of them.
TYPES = [
    "6DPP",
    "DPL DPP DPP DPP DPH DHP",
    "DLP DPP DPL DPH ALL ALL",
    "DLL DPP DPP DPH DHP DLP",
    "DPP DPL DLP ALH AHL AHH",
    "3DLL 3ALL",
]
STEP = mpf(10) ** -12


def vector(numbers):
    return mp.matrix([mpf(float(x)) for x in numbers])


def dot(a, b):
    return mp.fsum(x * y for x, y in zip(a, b, strict=True))


def cross(a, b):
    return mp.matrix(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def norm(a):
    return mp.sqrt(dot(a, a))


def slope(function, at, along):
    """Return the derivative of a function of a vector along another one."""
    return (function(at + STEP * along) - function(at - STEP * along)) / (2 * STEP)


def unit(k):
    return mp.matrix([mpf(int(i == k)) for i in range(6)])


def turn(r):
    """Return the rotation about a vector by its length: the series of the exponential function."""
    K = mp.matrix([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])
    term = total = mp.eye(3)
    for k in range(1, 12):
        term = term * K / k
        total = total + term
    return total


class Machine:
    """A platform in SI units near a pose; q is a rotation vector and the place of its origin."""

    def __init__(self, instance, R, T):
        self.instance, self.metre = instance, mpf(METRES[instance.units.length])
        self.R = mp.matrix([[mpf(float(x)) for x in row] for row in R])
        self.T = vector(T) * self.metre
        self.masses = instance.dynamics

    def pose(self, q):
        return turn(q[:3]) * self.R, self.T + q[3:]

    def primitive(self, geometry):
        """Return a point in metres and a unit direction, which a point has not."""
        at = vector([x.value for x in geometry.position]) * self.metre
        if isinstance(geometry, Point):
            return at, None
        given = geometry.normal if isinstance(geometry, Plane) else geometry.direction
        along = vector([x.value for x in given])
        return at, along / norm(along)

    def value(self, row, q):
        """Return what a constraint measures, by the definition of its kind."""
        R, T = self.pose(q)
        (y, u), (x, v) = self.primitive(row.platform), self.primitive(row.base)
        r, w = R * y + T - x, None if u is None else R * u
        match row.kind.name:
            case "DPP":
                return norm(r)
            case "DPL":
                return norm(cross(r, v))
            case "DLP":
                return norm(cross(r, w))
            case "DPH":
                return dot(r, v)
            case "DHP":
                return -dot(r, w)
            case "DLL":
                normal = cross(w, v)
                return abs(dot(r, normal)) / norm(normal)
            case "ALL":
                return mp.acos(dot(w, v))
            case "AHH":
                return mp.pi - mp.acos(dot(w, v))
            case _:
                return mp.asin(dot(w, v))

    def bodies(self, q):
        """Yield mass, centre and the points whose motion gives the rest of the energy."""
        R, T = self.pose(q)
        body = self.masses.platform
        centre = vector([x.value for x in body.centre]) * self.metre
        yield mpf(body.mass.value), R * centre + T
        legs = [row for row in self.instance.constraints if row.kind is DPP]
        for row, leg in zip(legs, self.masses.legs, strict=True):
            end, joint = R * self.primitive(row.platform)[0] + T, self.primitive(row.base)[0]
            e = (end - joint) / norm(end - joint)
            for part, start, way in ((leg.cylinder, joint, e), (leg.rod, end, -e)):
                yield mpf(part.mass.value), start + way * mpf(part.centre.value) * self.metre

    def kinetic(self, q, speed):
        """Return the kinetic energy."""
        energy = mpf(0)
        moved = [list(self.bodies(q + sign * STEP * speed)) for sign in (1, -1)]
        for (mass, ahead), (_, behind) in zip(*moved, strict=True):
            velocity = (ahead - behind) / (2 * STEP)
            energy += mass * dot(velocity, velocity) / 2
        R = self.pose(q)[0]
        change = (self.pose(q + STEP * speed)[0] - self.pose(q - STEP * speed)[0]) / (2 * STEP)
        S = R.T * change
        spin = mp.matrix([S[2, 1], S[0, 2], S[1, 0]])
        xx, yy, zz, xy, xz, yz = (mpf(x.value) for x in self.masses.platform.inertia)
        inertia = mp.matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) * self.metre**2
        energy += dot(spin, inertia * spin) / 2
        legs = [row for row in self.instance.constraints if row.kind is DPP]
        for row, leg in zip(legs, self.masses.legs, strict=True):
            across = mpf(leg.cylinder.inertia.value) + mpf(leg.rod.inertia.value)
            turning = slope(lambda x, row=row: self.direction(row, x), q, speed)
            energy += across * self.metre**2 * dot(turning, turning) / 2
        for row, drive in zip(self.instance.constraints, self.masses.drives.inertia, strict=True):
            inertia = mpf(drive.value) * (1 if row.kind.is_distance else self.metre**2)
            rate = slope(lambda x, row=row: self.value(row, x), q, speed)
            energy += inertia * rate**2 / 2
        return energy

    def direction(self, row, q):
        R, T = self.pose(q)
        leg = R * self.primitive(row.platform)[0] + T - self.primitive(row.base)[0]
        return leg / norm(leg)

    def potential(self, q):
        g = vector([x.value for x in self.masses.gravity])
        return -mp.fsum(mass * dot(g, centre) for mass, centre in self.bodies(q))

    def forces(self, speed, acceleration):
        """Return the forces of the drives, by Lagrange's equations at q = 0."""
        q = mp.zeros(6, 1)
        generalized = mp.matrix(6, 1)
        # Inner differences have 24 correct digits: an outer step of 1e-8 leaves 16.
        outer = mpf(10) ** -8

        def momentum(t, k):
            at, rate = q + t * speed + t**2 / 2 * acceleration, speed + t * acceleration
            return (
                self.kinetic(at, rate + outer * unit(k)) - self.kinetic(at, rate - outer * unit(k))
            ) / (2 * outer)

        for k in range(6):
            change = (momentum(outer, k) - momentum(-outer, k)) / (2 * outer)
            lagrangian = [
                self.kinetic(q + s * outer * unit(k), speed)
                - self.potential(q + s * outer * unit(k))
                for s in (1, -1)
            ]
            generalized[k] = change - (lagrangian[0] - lagrangian[1]) / (2 * outer)
        J = mp.matrix(6, 6)
        for i, row in enumerate(self.instance.constraints):
            for k in range(6):
                J[i, k] = slope(lambda x, row=row: self.value(row, x), q, unit(k))
        return np.array([float(x) for x in mp.lu_solve(J.T, generalized)])


@pytest.mark.parametrize("length", ["m", "mm", "in"])
@pytest.mark.parametrize("angle", list(AngleUnit))
@pytest.mark.parametrize("name", TYPES)
def test_forces_satisfy_the_equations_of_lagrange(name, angle, length):
    rng = np.random.default_rng(11)
    instance, R, T = random_platform(name, rng, universal=False)
    # Another name of the unit is another machine: its lengths are read again.
    angles = {
        i: float(measured)
        for i, measured in enumerate(measure(instance, R, T) * np.pi / 180)
        if angle is AngleUnit.RADIAN and not instance.constraints[i].kind.is_distance
    }
    instance = replace(instance.with_values(angles), units=Units(length, angle))
    assert isinstance(instance.dynamics, Dynamics)
    twist, acceleration = random_motion(instance, rng)
    found = inverse_dynamics(instance, R, T, twists=twist, accelerations=acceleration).forces[0]
    with mp.workdps(60):
        machine = Machine(instance, R, T)
        scale = mp.matrix([1, 1, 1, *[machine.metre] * 3])
        speed, change = (
            mp.matrix([x * s for x, s in zip(vector(given), scale, strict=True)])
            for given in (twist, acceleration)
        )
        expected = machine.forces(speed, change)
    assert np.abs(found - expected).max() <= 1e-9 * np.abs(expected).max()
