"""Realistic machines, drawn at random: hexapods, fixtures, couplings, rotary machines, mixtures.

A machine is drawn as people write one down: round radii and angles, coordinates rounded to some
decimals or computed in floating point, values measured at a pose near home and rounded. Most are
special but for rounding, or exactly.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DPH, DPL, DPP, Kind
from gspcli.defaults import SEED
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side, Units
from gspcli.geometry.measurement import measured
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, Line, Plane, Point
from gspcli.geometry.quaternions import rotation_from_quaternion

Array = NDArray[np.float64]

UNITS = Units("unit", AngleUnit.DEGREE)
#: Which leg shares its joint with which, on the base and on the platform.
_JOINTS = {
    "6-6": (range(6), range(6)),
    "6-3": (range(6), (0, 0, 2, 2, 4, 4)),
    "3-3": ((0, 0, 2, 2, 4, 4), (1, 3, 3, 5, 5, 1)),
}
#: Radii of bases in some units.
_SIZES = (1.0, 1.0, 10.0, 120.0, 300.0)
#: Poses near home: the turn in radians, and the shift as a part of the size.
_TURN, _SHIFT = 0.1, 0.1


@dataclass(frozen=True)
class Machine:
    """A machine with sets of values.

    Attributes
    ----------
    name
        Its structure and number, such as ``6-6/17``.
    text
        What was drawn.
    instance
        With the first set of values.
    rows
        Other sets of values that real poses near home have, rounded likewise, shape (n, 6).
    """

    name: str
    text: str
    instance: Instance
    rows: Array

    @property
    def structure(self) -> str:
        """The first part of the name."""
        return self.name.partition("/")[0]


@dataclass(frozen=True)
class _Drawn:
    """A geometry: what is joined at home, with the decimals of its numbers and of its values."""

    text: str
    joined: Sequence[tuple[Kind, Geometry, Geometry]]
    home: Array
    size: float
    value_decimals: int
    structure: str = ""


def machines(count: int, seed: int = SEED, rows: int = 64, *, begin: int = 0) -> Iterator[Machine]:
    """Yield this many machines, the structures in turns.

    Parameters
    ----------
    count, seed
        How many, and the source of random numbers: each machine depends on its own number alone.
    rows
        Sets of values of each.
    begin
        The number of the first that is made.
    """
    for number in range(begin, count):
        structure = _TURNS[number % len(_TURNS)]
        rng = np.random.default_rng([seed, number])
        drawn = STRUCTURES[structure](rng)
        yield _with_values(f"{drawn.structure or structure}/{number}", drawn, rng, rows)


def _with_values(name: str, drawn: _Drawn, rng: np.random.Generator, rows: int) -> Machine:
    """Return a machine with the values at random poses near home."""
    sides = [Side.POSITIVE if kind in (DPH, DHP) else Side.BOTH for kind, _, _ in drawn.joined]

    def made(values: Sequence[float]) -> Instance:
        numbers = (Number.of(repr(x)) for x in values)
        return Instance(
            tuple(
                Constraint(*joined, number, side)
                for joined, number, side in zip(drawn.joined, numbers, sides, strict=True)
            ),
            UNITS,
        )

    arrangement = Arrangement.of(made([drawn.size] * 6))
    turn = np.concatenate(
        (np.ones((rows + 1, 1)), _TURN * rng.uniform(-0.5, 0.5, (rows + 1, 3))), axis=1
    )
    place = drawn.home + _SHIFT * drawn.size * rng.uniform(-1, 1, (rows + 1, 3))
    values = measured(arrangement, rotation_from_quaternion(turn), place)
    values[:, arrangement.angles] /= arrangement.in_radians
    values = np.abs(values).round(drawn.value_decimals)
    return Machine(name, drawn.text, made(values[0].tolist()), values[1:])


def _written(rng: np.random.Generator, size: float) -> tuple[int | None, str]:
    """Return to how many decimals coordinates are rounded; None for floating point."""
    least = 1 if size <= 1 else 0
    places = int(rng.integers(least, 8))
    return (None, "floating point") if places > 6 else (places, f"{places} decimals")


def _points(points: Array, places: int | None) -> list[Point]:
    rounded = points if places is None else points.round(places)
    return [Point(row) for row in (rounded + 0.0).tolist()]


def _ring(angles: Array, radius: float) -> Array:
    """Return points of a circle at angles in degrees, shape (n, 3)."""
    turns = np.radians(angles)
    return np.stack((radius * np.cos(turns), radius * np.sin(turns), 0 * turns), axis=1)


def _half_angle(rng: np.random.Generator) -> float:
    """Return a half angle in degrees, as round as people choose it."""
    angle = rng.uniform(3, 30)
    return float(rng.choice([round(angle), round(angle), round(2 * angle) / 2, round(angle, 2)]))


def _rings(rng: np.random.Generator, size: float) -> tuple[Array, Array, str]:
    """Return the angles of six joints of base and platform, and what was drawn.

    Pairs are about 0, 120 and 240 degrees on the base, and between these on the platform. They may
    be congruent; corresponding corners of similar hexagons, which make a singular machine, are not.
    """
    sides = np.array([1.0, -1.0] * 3)
    pairs = np.repeat([0.0, 120.0, 240.0], 2)
    base = _half_angle(rng)
    top = base if rng.random() < 0.2 else _half_angle(rng)
    if base + top > 57:
        top = round(57 - base, 2)
    twist = float(rng.choice([0, 0, 0, 15, 30, round(rng.uniform(-30, 30))]))
    text = f"half angles {base:g} and {top:g}, twist {twist:g}"
    return pairs + base * sides, pairs + (60 - top) * sides + twist, text


def _hexapod(rng: np.random.Generator, pattern: str) -> _Drawn:
    """Return two hexagons with threefold symmetry, or triangles."""
    size = float(rng.choice(_SIZES))
    places, written = _written(rng, size)
    base, top, text = _rings(rng, size)
    ratio = 1.0 if rng.random() < 0.1 else round(float(rng.uniform(0.4, 1.0)), 2)
    height = size * round(float(rng.uniform(0.6, 1.5)), 1)
    on_base, on_platform = (list(which) for which in _JOINTS[pattern])
    x = _points(_ring(base, size)[on_base], places)
    y = _points(_ring(top, ratio * size)[on_platform], places)
    return _Drawn(
        f"{text}, radii {size:g} and {ratio * size:g}, {written}",
        [(DPP, a, b) for a, b in zip(y, x, strict=True)],
        np.array([0, 0, height]),
        size,
        4 if size <= 1 else 2,
    )


def _rotary(rng: np.random.Generator) -> _Drawn:
    """Return rods of one length between cranks in some position and a platform."""
    size = float(rng.choice(_SIZES[2:]))
    places, written = _written(rng, size)
    base, top, text = _rings(rng, size)
    ratio = round(float(rng.uniform(0.4, 1.0)), 2)
    arm = size * round(float(rng.uniform(0.1, 0.3)), 2)
    cranks = np.radians(rng.uniform(-40, 40, 6).round(1))
    x = _ring(base, size) + arm * np.stack(
        (
            np.cos(cranks) * np.cos(np.radians(base + 90)),
            np.cos(cranks) * np.sin(np.radians(base + 90)),
            np.sin(cranks),
        ),
        axis=1,
    )
    y = _ring(top, ratio * size)
    return _Drawn(
        f"{text}, radii {size:g} and {ratio * size:g}, arms {arm:g}, {written}",
        [(DPP, a, b) for a, b in zip(_points(y, places), _points(x, places), strict=True)],
        np.array([0, 0, size * round(float(rng.uniform(0.6, 1.5)), 1)]),
        size,
        2,
    )


def _fixture(rng: np.random.Generator) -> _Drawn:
    """Return a 3-2-1 fixture: three supports, two side locators, one end stop."""
    size = float(rng.choice((50.0, 100.0, 200.0)))
    places = int(rng.integers(0, 4))
    xy = rng.uniform(-size, size, (6, 3))
    xy[:3, 2], xy[3:5, 1], xy[5, 0] = -size, -size, -size
    normals = np.array([[0, 0, 1]] * 3 + [[0, 1, 0]] * 2 + [[1, 0, 0]])
    tilt = bool(rng.random() < 0.3)
    if tilt:
        # As measured: a few parts in ten thousand.
        normals = (normals + rng.uniform(-4e-4, 4e-4, (6, 3))).round(5)
    radius = size / 20
    points = _points(xy, places)
    planes = [
        Plane(Point(row).position, _vector(n))
        for row, n in zip((xy - radius * normals).round(places).tolist(), normals, strict=True)
    ]
    return _Drawn(
        f"{places} decimals" + (", tilted planes" if tilt else ""),
        [(DPH, a, b) for a, b in zip(points, planes, strict=True)],
        np.zeros(3),
        radius,
        3,
    )


def _vector(row: Array) -> tuple[Number, Number, Number]:
    x, y, z = (Number.of(repr(float(c) + 0.0)) for c in row)
    return x, y, z


def _coupling(rng: np.random.Generator) -> _Drawn:
    """Return three balls in three vees."""
    size = float(rng.choice((10.0, 25.0, 40.0)))
    places, written = _written(rng, size)
    twist = float(rng.choice([0, 0, 30, round(rng.uniform(-30, 30))]))
    angles = np.array([90.0, 210.0, 330.0]) + rng.choice([0, 0, 15]) * np.array([0, 1, -1])
    balls = _ring(angles, size)
    slope = float(rng.choice((1.0, 1.0, 0.75, math.sqrt(3))))
    joined = []
    for ball, angle in zip(balls, np.radians(angles + 90 + twist), strict=True):
        for sign in (1, -1):
            normal = np.array([sign * slope * math.cos(angle), sign * slope * math.sin(angle), 1.0])
            normal = normal if places is None else normal.round(max(places, 2))
            foot = ball - normal * size / 10
            foot = foot if places is None else foot.round(places)
            (point,) = _points(ball[None], places)
            joined.append((DPH, point, Plane(_vector(foot), _vector(normal))))
    text = f"balls at {', '.join(f'{a:g}' for a in angles)}, slope {slope:.3g}, twist {twist:g}"
    return _Drawn(f"{text}, {written}", joined, np.zeros(3), size / 10, 4)


def _mixture(rng: np.random.Generator) -> _Drawn:
    """Return a hexapod of which some legs are heights, guide rods or sliding joints."""
    size = float(rng.choice(_SIZES))
    places, written = _written(rng, size)
    base, top, text = _rings(rng, size)
    ratio = round(float(rng.uniform(0.4, 1.0)), 2)
    x, y = _ring(base, size), _ring(top, ratio * size)
    kinds = (
        (DPP, DPP, DPP, DPH, DPH, DPH),
        (DPP, DPP, DPP, DPP, DPP, DPH),
        (DPP, DPP, DPP, DPP, DPH, DPH),
        (DPP, DPP, DPP, DHP, DHP, DHP),
        (DPP, DPP, DPP, DPP, DPP, DPL),
        (DPP, DPP, DPP, DPP, DPL, DPL),
    )[int(rng.integers(6))]
    ups, ins = np.array([0.0, 0, 1]), np.array([1.0, 0, 0])
    joined: list[tuple[Kind, Geometry, Geometry]] = []
    ends = zip(kinds, _points(y, places), _points(x, places), strict=True)
    for k, (kind, a, b) in enumerate(ends):
        if kind is DPH:
            joined.append((kind, a, Plane(b.position, _vector(ups))))
        elif kind is DHP:
            joined.append((kind, Plane(a.position, _vector(-ups)), b))
        elif kind is DPL:
            joined.append((kind, a, Line(b.position, _vector(ups if k == 5 else ins))))
        else:
            joined.append((kind, a, b))
    height = size * round(float(rng.uniform(0.6, 1.5)), 1)
    return _Drawn(
        f"{text}, radii {size:g} and {ratio * size:g}, {written}",
        joined,
        np.array([0, 0, height]),
        size,
        4 if size <= 1 else 2,
        " + ".join(f"{kinds.count(kind)} {kind.name[1:]}" for kind in dict.fromkeys(kinds)),
    )


#: The structures, and in which turns they are drawn: most hexapods have six joints a body.
STRUCTURES: dict[str, Callable[[np.random.Generator], _Drawn]] = {
    "6-6": lambda rng: _hexapod(rng, "6-6"),
    "6-3": lambda rng: _hexapod(rng, "6-3"),
    "3-3": lambda rng: _hexapod(rng, "3-3"),
    "fixture": _fixture,
    "coupling": _coupling,
    "rotary": _rotary,
    "mixture": _mixture,
}
_TURNS = (
    "6-6",
    "6-3",
    "6-6",
    "mixture",
    "6-6",
    "3-3",
    "6-6",
    "coupling",
    "6-6",
    "fixture",
    "rotary",
)
