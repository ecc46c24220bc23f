"""Machines with cranks and slides, and their inverse kinematics by plane geometry.

Nothing here comes from the formulas of the package: the point of a crank is where two circles meet
in the plane of its circle, that of a slide where its rail leaves a ball.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.primitives import Crank, Geometry, Point, Slide
from gspcli.resources import data_path
from gspcli.spec import load, loads

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Machine:
    """A machine, its home pose, and half the sizes of a box about it, of positions and angles."""

    name: str
    instance: Instance
    R: Array
    T: Array
    room: tuple[float, float]


def machines() -> dict[str, Callable[[], Machine]]:
    """Return the machines by their names."""
    found: dict[str, Callable[[], Machine]] = {}
    for limit in (45, 60, 90):
        found[f"reachy {limit}"] = partial(_cranked, "reachy-mini-head", limit, 0.05, 0.4)
    for limit in (60, 120):
        found[f"t-top {limit}"] = partial(_cranked, "t-top-head", limit, 0.05, 0.3)
    return found | {"paradex": _paradex, "6-PUS": _pus, "mixed": _mixed}


def _cranked(name: str, limit: float, move: float, turn: float) -> Machine:
    instance = load(data_path(f"platforms/{name}.yaml"))
    assert instance.home is not None

    def limited(point: Geometry) -> Point:
        assert isinstance(point, Point)
        assert point.crank is not None
        crank = Crank(point.crank.centre, point.crank.axis, limits=(-limit, limit))
        return Point(point.position, crank=crank)

    rows = tuple(replace(row, base=limited(row.base)) for row in instance.constraints)
    changed = replace(instance, constraints=rows)
    in_radians = instance.units.angle.in_radians
    return Machine(
        f"{name} {limit}", changed, instance.home.R(in_radians), instance.home.T, (move, turn)
    )


def _paradex() -> Machine:
    """Return the modified Paradex: vertical rails, a stroke of 3."""
    instance = load(data_path("platforms/modified-paradex.yaml"))
    slide = Slide((0, 0, 1), limits=(-1.5, 1.5))
    rows = tuple(
        replace(row, base=Point(row.base.position, slide=slide)) for row in instance.constraints
    )
    changed = replace(instance, constraints=rows)
    return Machine("paradex", changed, np.eye(3), np.zeros(3), (2.0, 0.3))


def _pus() -> Machine:
    """Six rails in pairs, tilted outward by 30 degrees."""
    where = np.radians([-10, 10, 110, 130, 230, 250])
    base = np.stack((0.5 * np.cos(where), 0.5 * np.sin(where), np.full(6, 0.15)), axis=1)
    way = np.radians([0, 0, 120, 120, 240, 240])
    rails = np.stack((0.5 * np.cos(way), 0.5 * np.sin(way), np.full(6, math.sqrt(0.75))), axis=1)
    drives = [f"slide: {{direction: {_text(rail)}, range: [-0.15, 0.2]}}" for rail in rails]
    instance = _written(_joints(), base, [0.0, 0.0, 0.6], [""] * 6, drives)
    return Machine("6-PUS", instance, np.eye(3), np.array([0, 0, 0.6]), (0.15, 0.15))


def _mixed() -> Machine:
    """Cranks and a slide on the platform, cranks on the base, and a leg with a range."""
    where = np.radians([-10, 10, 110, 130, 230, 250])
    base = np.stack((0.5 * np.cos(where), 0.5 * np.sin(where), np.full(6, 0.15)), axis=1)
    joints, rng = _joints(), np.random.default_rng(11)
    texts = []
    for k in range(6):
        axis, other = rng.normal(size=(2, 3))
        axis /= np.linalg.norm(axis)
        arm = np.cross(axis, other)
        arm *= 0.06 / np.linalg.norm(arm)
        own = joints[k] if k in (0, 1, 4) else base[k]
        crank = f"crank: {{centre: {_text(own - arm)}, axis: {_text(axis)}, range: [-50, 70]}}"
        slide = f"slide: {{direction: {_text(axis)}, range: [-0.05, 0.04]}}"
        texts.append(slide if k == 4 else crank if k < 4 else "")
    on_platform = [text if k in (0, 1, 4) else "" for k, text in enumerate(texts)]
    on_base = [text if k in (2, 3) else "" for k, text in enumerate(texts)]
    instance = _written(joints, base, [0.0, 0.0, 0.6], on_platform, on_base, "range: [0.4, 0.7]")
    return Machine("mixed", instance, np.eye(3), np.array([0, 0, 0.6]), (0.03, 0.12))


def _joints() -> Array:
    angles = np.radians([-45, 45, 75, 165, 195, 285])
    return np.stack((0.2 * np.cos(angles), 0.2 * np.sin(angles), np.zeros(6)), axis=1)


def _text(vector: Array) -> str:
    return "[" + ", ".join(repr(float(x)) for x in vector) + "]"


def _written(
    joints: Array,
    base: Array,
    home: list[float],
    on_platform: list[str],
    on_base: list[str],
    last: str = "",
) -> Instance:
    """Return a machine from its file."""
    lines = ["gsp: 1", "units: {length: m, angle: deg}", "platform:"]
    for letter, points, drives in (("P", joints, on_platform), ("B", base, on_base)):
        if letter == "B":
            lines.append("base:")
        for k, (point, drive) in enumerate(zip(points, drives, strict=True), 1):
            more = f", {drive}" if drive else ""
            lines.append(f"  {letter}{k}: {{point: {_text(point)}{more}}}")
    lines += [
        f"home: {{position: {_text(np.array(home))}, quaternion: [1, 0, 0, 0]}}",
        "constraints:",
    ]
    for k in range(1, 7):
        more = f", {last}" if last and k == 6 else ""
        lines.append(f"  - {{distance: [P{k}, B{k}], value: home{more}}}")
    return loads("\n".join(lines))


class PlaneGeometry:
    """The numbers of the motors of a machine at poses.

    Parameters
    ----------
    machine
        The machine; its home decides the working modes: the number nearer to zero there.
    """

    def __init__(self, machine: Machine) -> None:
        self.rows = machine.instance.constraints
        self.unit = machine.instance.units.angle.in_radians
        both = [self._both(k, machine.R[None], machine.T[None])[0] for k in range(6)]
        #: Whether it is the second of the two numbers of each motor.
        self.second = [bool(abs(pair[1]) < abs(pair[0])) for pair in both]

    def numbers(self, R: Array, T: Array) -> Array:
        """Return the numbers at poses, angles in radians, shape (n, 6); NaN out of reach."""
        pairs = [self._both(k, R, T) for k in range(6)]
        return np.stack([pair[:, int(self.second[k])] for k, pair in enumerate(pairs)], axis=1)

    def reached(self, R: Array, T: Array) -> NDArray[np.bool_]:
        """Return which poses all motors and legs reach within their ranges, shape (n,)."""
        good = np.ones(len(T), bool)
        for k, numbers in enumerate(self.numbers(R, T).T):
            drive = self.drive(k)[0]
            limits = self.rows[k].limits if drive is None else drive.limits
            good &= ~np.isnan(numbers)
            if limits is None:
                continue
            unit = self.unit if isinstance(drive, Crank) else 1.0
            low, high = (limit.value * unit for limit in limits)
            if isinstance(drive, Crank):
                numbers = low + (numbers - low) % (2 * math.pi)
            with np.errstate(invalid="ignore"):
                good &= (numbers >= low) & (numbers <= high)
        return good

    def drive(self, k: int) -> tuple[Crank | Slide | None, bool]:
        """Return the motor of a constraint, if any, and whether it moves the platform's point."""
        row = self.rows[k]
        assert isinstance(row.platform, Point)
        assert isinstance(row.base, Point)
        if row.platform.drive is not None:
            return row.platform.drive, True
        return row.base.drive, False

    def _both(self, k: int, R: Array, T: Array) -> Array:
        """Return the two numbers of a motor, shape (n, 2)."""
        row = self.rows[k]
        drive, on_platform = self.drive(k)
        y, x = row.platform.point, row.base.point
        if drive is None:
            length = np.linalg.norm(R @ y + T - x, axis=1)
            return np.stack((length, length), axis=1)
        # In the frame of the body of the motor.
        other = np.einsum("nji,nj->ni", R, x - T) if on_platform else R @ y + T
        point, rod = (y if on_platform else x), row.value.value
        with np.errstate(invalid="ignore", divide="ignore"):
            if isinstance(drive, Slide):
                way = np.array([n.value for n in drive.direction])
                way /= np.linalg.norm(way)
                ahead = (other - point) @ way
                beside = np.linalg.norm(np.cross(other - point, way), axis=1)
                half = np.sqrt(rod**2 - beside**2)
                return np.stack((ahead - half, ahead + half), axis=1)
            axis = np.array([n.value for n in drive.axis])
            axis /= np.linalg.norm(axis)
            arm = point - np.array([n.value for n in drive.centre])
            foot = point - (arm - (arm @ axis) * axis)
            radius = np.linalg.norm(point - foot)
            first = (point - foot) / radius
            second = np.cross(axis, first)
            # Circles in the plane of the crank: that of the arm, and that of the ball of the rod.
            height = (other - foot) @ axis
            u, v = (other - foot) @ first, (other - foot) @ second
            far = np.hypot(u, v)
            ball = np.sqrt(rod**2 - height**2)
            ahead = (radius**2 - ball**2 + far**2) / (2 * far)
            aside = np.sqrt(radius**2 - ahead**2)
            ends = [
                np.arctan2(ahead * v + sign * aside * u, ahead * u - sign * aside * v)
                for sign in (-1, 1)
            ]
            return np.stack(ends, axis=1)


class Followed(NamedTuple):
    """Where n ways have led, shapes (n, ...)."""

    R: Array
    T: Array
    regular: NDArray[np.bool_]
    """Whether poses exist at all steps, and det J keeps its sign."""
    working_modes: NDArray[np.bool_]
    """Whether the derivatives of the rods by their motors keep their signs at all steps."""


class Equations:
    """The squares of the rods of a machine by its pose and its motors, and their derivatives.

    Parameters
    ----------
    machine
        The machine.
    """

    def __init__(self, machine: Machine) -> None:
        geometry = PlaneGeometry(machine)
        self.rows, self.drives = geometry.rows, [geometry.drive(k) for k in range(6)]
        self.rods = np.array([row.value.value for row in self.rows])
        self.y = np.array([row.platform.point for row in self.rows])
        self.x = np.array([row.base.point for row in self.rows])

    def followed(self, R: Array, T: Array, q: Array, change: Array, steps: int) -> Followed:
        """Follow a pose by Newton's method while the motors change linearly, in n ways.

        Parameters
        ----------
        R, T, q
            The pose and the motors there.
        change
            Changes of the motors, shape (n, 6).
        steps
            How many to take.
        """
        count = len(change)
        R, T = np.repeat(R[None], count, axis=0), np.repeat(T[None], count, axis=0)
        sign, gain = None, None
        regular, working_modes = np.ones(count, bool), np.ones(count, bool)
        for step in range(steps + 1):
            numbers = q + change * step / steps
            for _ in range(8):
                F, J, _ = self.jets(R, T, numbers)
                twist = np.linalg.solve(J, -F[..., None])[..., 0]
                R, T = _rotations(twist[:, :3]) @ R, T + twist[:, 3:]
            F, J, rate = self.jets(R, T, numbers)
            regular &= np.abs(F).max(axis=1) < 1e-11 * self.rods.max() ** 2
            now = np.sign(np.linalg.det(J))
            if sign is None or gain is None:
                sign, gain = now, np.sign(rate)
            regular &= now == sign
            working_modes &= (np.sign(rate) == gain).all(axis=1)
        return Followed(R, T, regular, working_modes)

    def side(self, R: Array, T: Array, q: Array) -> Array:
        """Return the signs of the determinants at poses, shape (n,)."""
        signs: Array = np.sign(np.linalg.det(self.jets(R, T, q)[1]))
        return signs

    def jets(self, R: Array, T: Array, q: Array) -> tuple[Array, Array, Array]:
        """Return half the squares less those of the rods, and derivatives by twists and motors."""
        count = len(T)
        y, x = (np.repeat(part[None], count, axis=0) for part in (self.y, self.x))
        rods = np.repeat(self.rods[None], count, axis=0)
        speed = np.zeros((count, 6, 3))
        for k, (drive, on_platform) in enumerate(self.drives):
            points = y if on_platform else x
            if drive is None:
                rods[:, k] = q[:, k]
            elif isinstance(drive, Slide):
                way = np.array([n.value for n in drive.direction])
                way /= np.linalg.norm(way)
                points[:, k] += q[:, k, None] * way
                speed[:, k] = way
            else:
                centre = np.array([n.value for n in drive.centre])
                axis = np.array([n.value for n in drive.axis])
                turn = _rotations(q[:, k, None] * axis / np.linalg.norm(axis))
                points[:, k] = centre + turn @ ((self.y if on_platform else self.x)[k] - centre)
                speed[:, k] = np.cross(axis / np.linalg.norm(axis), points[:, k] - centre)
        arm = np.einsum("nij,nkj->nki", R, y)
        r = arm + T[:, None] - x
        rate = np.empty((count, 6))
        for k, (drive, on_platform) in enumerate(self.drives):
            moved = np.einsum("nij,nj->ni", R, speed[:, k]) if on_platform else -speed[:, k]
            rate[:, k] = 1.0 if drive is None else (r[:, k] * moved).sum(axis=1)
        F = ((r * r).sum(axis=2) - rods**2) / 2
        return F, np.concatenate((np.cross(arm, r), r), axis=2), rate


def _rotations(vectors: NDArray[Any]) -> Array:
    """Return the rotations by vectors, by the formula of Rodrigues, ``(n, 3) -> (n, 3, 3)``."""
    angle = np.linalg.norm(vectors, axis=1)[:, None, None]
    x, y, z = vectors.T
    nothing = np.zeros_like(x)
    K = np.stack((nothing, -z, y, z, nothing, -x, -y, x, nothing), axis=1).reshape(-1, 3, 3)
    safe = np.where(angle > 1e-9, angle, 1.0)
    first = np.where(angle > 1e-9, np.sin(safe) / safe, 1.0)
    second = np.where(angle > 1e-9, (1 - np.cos(safe)) / safe**2, 0.5)
    return np.asarray(np.eye(3) + first * K + second * (K @ K))


def upside_down(instance: Instance) -> tuple[Constraint, ...]:
    """Return the constraints of a machine with base and platform exchanged."""
    return tuple(
        replace(
            row,
            platform=row.base,
            base=row.platform,
            platform_name=row.base_name,
            base_name=row.platform_name,
        )
        for row in instance.constraints
    )
