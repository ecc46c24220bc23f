"""Machines with cranks, rails and shared carriages, with masses made up, at poses they reach."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from gspcli import example
from gspcli.catalogue.kinds import DPP
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.coordinates import choose
from gspcli.geometry.instance import METRES, HomePose
from gspcli.geometry.machine import Machine
from gspcli.geometry.masses import Arm, Carriage, Dynamics, Leg, LegBody, RigidBody
from gspcli.geometry.masses import Drives as DriveMasses
from gspcli.geometry.primitives import Crank, Point, Slide
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.motion.poses.inverse_kinematics import drive_values
from gspcli.solver import solve
from tests.support.masses import DRIVEN

#: Shipped machines with arms or rails, and made-up ones of other sorts.
SHIPPED = tuple(DRIVEN)
MADE_UP = ("6-PUS", "delta", "mixed")


def _rods(y, b, T, points):
    rows = []
    for k in range(6):
        length = float(np.linalg.norm(y[k] + T - b[k]))
        rows.append((Point(y[k]), points[k], length))
    return rows


def _made(y, b, T, ends):
    """Return the instance of rods between platform joints y and driven points, at home in T.

    Parameters
    ----------
    y, b
        The joints as they are at home, shapes (6, 3).
    T
        The translation of home.
    ends
        The two points of each rod: of the platform and of the base.
    """
    from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Units
    from gspcli.geometry.numbers import Number

    rows = []
    for k, (own, base) in enumerate(ends):
        length = float(np.linalg.norm(y[k] + T - b[k]))
        names = {"platform_name": f"P{k + 1}", "base_name": f"B{k + 1}"}
        plain = all(end.crank is None and end.slide is None for end in (own, base))
        # A value without a crank or slide has a motor only if it has a range.
        reach = (Number.of(length / 2), Number.of(2 * length)) if plain else None
        rows.append(Constraint(DPP, own, base, Number.of(length), limits=reach, **names))
    units = Units("m", AngleUnit.DEGREE)
    return Instance(tuple(rows), units, home=HomePose(T.tolist(), [1, 0, 0, 0]))


def six_pus():
    """Rails that lean outward by 30 degrees, in pairs."""
    angles, own = (
        np.radians([-10, 10, 110, 130, 230, 250]),
        np.radians([-45, 45, 75, 165, 195, 285]),
    )
    b = np.stack((0.5 * np.cos(angles), 0.5 * np.sin(angles), np.full(6, 0.15)), 1)
    y = np.stack((0.2 * np.cos(own), 0.2 * np.sin(own), np.zeros(6)), 1)
    middle = np.radians([0, 0, 120, 120, 240, 240])
    rails = np.stack((0.5 * np.cos(middle), 0.5 * np.sin(middle), np.full(6, 0.75**0.5)), 1)
    T = np.array([0, 0, 0.6])
    ends = [(Point(y[k]), Point(b[k], slide=Slide(rails[k]))) for k in range(6)]
    return _made(y, b, T, ends)


def delta():
    """A linear delta: three vertical rails, two parallel rods on each carriage."""
    middle, side = np.radians([90, 90, 210, 210, 330, 330]), np.array([-1, 1] * 3) * 0.03
    out = np.stack((np.cos(middle), np.sin(middle), 0 * middle), 1)
    across = np.stack((-np.sin(middle), np.cos(middle), 0 * middle), 1)
    b, y = 0.2 * out + side[:, None] * across, 0.05 * out + side[:, None] * across
    rail = Slide([0, 0, 1])
    ends = [
        (Point(y[k]), Point(b[k], slide=rail, partner=f"B{k}" if k % 2 else "")) for k in range(6)
    ]
    return _made(y, b, np.array([0, 0, -0.25]), ends)


def mixed():
    """Two cranks and a slide on the platform, two cranks on the base, one driven distance."""
    stated = six_pus()
    y = np.array([row.platform.point for row in stated.constraints])
    b = np.array([row.base.point for row in stated.constraints])
    rng = np.random.default_rng(11)
    axes = rng.normal(size=(6, 3))
    ends = []
    for k, sort in enumerate(["pc", "pc", "bc", "bc", "ps", "v"]):
        point = (y if sort[0] == "p" else b)[k]
        arm = np.cross(axes[k], rng.normal(size=3))
        arm *= 0.06 / np.linalg.norm(arm)
        moved = None
        if sort[-1] == "c":
            moved = Point(point, crank=Crank(point - arm, axes[k]))
        elif sort[-1] == "s":
            moved = Point(point, slide=Slide(axes[k]))
        own = moved if moved is not None and sort[0] == "p" else Point(y[k])
        base = moved if moved is not None and sort[0] == "b" else Point(b[k])
        ends.append((own, base))
    return _made(y, b, np.array([0, 0, 0.6]), ends)


@cache
def driven(name):
    """Return a machine with drives of points."""
    made = {"6-PUS": six_pus, "delta": delta, "mixed": mixed}
    return made[name]() if name in made else example(name)


def weighed(instance, rng):
    """Return a machine with random masses of everything that can have one."""
    numbers, drives = Arrangement.of(instance), Machine.of(instance)
    metre = METRES.get(instance.units.length, 1.0)
    size = numbers.length
    mass = float(rng.uniform(1, 3))
    Q = rotation_from_vector(rng.normal(size=3))
    inertia = Q @ np.diag(rng.uniform(0.3, 0.45, 3)) @ Q.T * mass * size**2
    six = [*np.diag(inertia).tolist(), inertia[0, 1], inertia[0, 2], inertia[1, 2]]
    body = RigidBody(mass, (0.2 * size * rng.normal(size=3)).tolist(), six)
    legs = [
        Leg(*(_leg_body(rng, mass * 0.04, float(row.value.value)) for _ in range(2)))
        for row in instance.constraints
    ]
    cranks = [
        float(drives.arms[drives.users(k)[0]])
        for k, sort in enumerate(drives.sorts)
        if sort == "crank"
    ]
    arms = [
        Arm(
            w := float(rng.uniform(0.03, 0.1) * mass),
            float(rng.uniform(-0.3, 0.8)) * arm,
            w * arm**2 / 12,
        )
        for arm in cranks
    ]
    carriages = [
        Carriage(float(rng.uniform(0.05, 0.2) * mass)) for sort in drives.sorts if sort == "slide"
    ]
    if drives.on_platform.any():
        arms, carriages = [], []
    rotors = [
        float(rng.uniform(0.1, 0.3)) * (0.01 * size**2 if sort == "crank" else 1.0)
        for sort in drives.sorts
    ]
    units = (
        instance.units if instance.units.length in METRES else replace(instance.units, length="m")
    )
    stated = Dynamics(
        body, legs, DriveMasses(rotors), (rng.normal(size=3) - [0, 0, 9]).tolist(), arms, carriages
    )
    assert metre > 0
    return replace(instance, units=units, dynamics=stated)


def _leg_body(rng, mass, length):
    weight = float(rng.uniform(0.3, 1)) * mass
    across = weight * length**2 / 12
    return LegBody(weight, float(rng.uniform(0.1, 0.5)) * length, across, 0.0)


def _home(instance):
    """Return the pose that a machine states as home, else the mode that is called so."""
    home = instance.home
    if home is None:
        mode = solve(instance).home
        return mode.R.real, mode.T.real
    return home.R(instance.units.angle.in_radians), np.array([x.value for x in home.position])


def some_pose(instance, rng, spread=0.12, least=0.2):
    """Return a pose near home at which all drives are far from dead points, and their numbers."""
    drives, size = Machine.of(instance), Arrangement.of(instance).length
    R0, T0 = _home(instance)
    turns = drives.count == 6
    while True:
        R = rotation_from_vector(rng.normal(size=3) * spread * turns) @ R0
        T = T0 + rng.normal(size=3) * size * spread * (1 if turns else 0.2)
        q = drives.inverse(R, T)
        if not np.isnan(q).any() and drives.transmission(drives.gains(R, T, q)).min() > least:
            return R, T, q


def rebased(instance, q):
    """Return a machine stated with its drives at q, where their numbers are zero now."""
    drives = Machine.of(instance)
    rows = []
    for k, row in enumerate(instance.constraints):
        if drives.driven[k]:
            body = "platform" if drives.on_platform[k] else "base"
            point = getattr(row, body)
            moved = Point(
                point.drive.moved(point.point, q[drives.index[k]]),
                crank=point.crank,
                slide=point.slide,
                partner=point.partner,
            )
            row = replace(row, **{body: moved})
        elif row.kind is DPP:
            row = replace(row, value=type(row.value).of(float(q[drives.index[k]])))
        rows.append(row)
    return replace(instance, constraints=tuple(rows), home=None)


def random_motion(instance, rng):
    """Return a twist and its derivative, of a machine with shared drives translations alone."""
    size = Arrangement.of(instance).length
    turns = float(Machine.of(instance).count == 6)
    unit = np.repeat([turns, size], 3)
    return 3 * rng.normal(size=6) * unit, 20 * rng.normal(size=6) * unit


def crank_angles(instance, R, T, *, along=True):
    """Return the cranks of a machine that has no other drives, and their angles in its unit."""
    drives, q = drive_values(instance, R, T, along=along)
    return choose(instance, drives.names), q / drives.units
