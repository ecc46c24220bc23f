"""Platforms of six points and points that are special, or special but for a rounding or a shake."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction

from gspcli.catalogue.kinds import DPP
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Units
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Point
from tools.recording import ROOT
from tools.special.parts import (
    HOME,
    Draws,
    Leg,
    Vector,
    assembled,
    decimals,
    exact,
    motion,
    plus,
    rational,
    sqrt,
    tenth,
)

PUBLISHED = ROOT / "data" / "verification" / "published-hexapods.json"

Named = tuple[str, Instance]
UNITS = Units("unit", AngleUnit.DEGREE)


def hexapod(base: Sequence[Vector], platform: Sequence[Vector]) -> list[Leg]:
    """Return six legs."""
    return [Leg(DPP, y, x) for y, x in zip(platform, base, strict=True)]


def published(draws: Callable[[str], Draws]) -> Iterator[Named]:
    """Yield published hexapods at home and at random poses, exactly and as values are printed."""
    for name, entry in json.loads(PUBLISHED.read_text(encoding="utf-8")).items():
        legs = hexapod(*([exact(*p) for p in entry[body]] for body in ("base", "platform")))
        size = max(abs(x) for leg in legs for x in (*leg.y, *leg.x))
        size = Fraction(round(size * 1000), 1000)
        home = exact(*entry["home"]) if entry["home"] else exact(0, 0, size)
        place = name.replace("_", "-")
        at_home = motion((1, 0, 0, 0), home)
        small = max(0, -math.floor(math.log10(size)))
        for places in (None, 9, 3 + small):
            text = "exact" if places is None else f"{places}-places"
            yield f"{place}/home/{text}", assembled(legs, at_home, places=places)
        for number, places in enumerate((None, None, None, 6 + small, 6 + small, 3 + small), 1):
            at = draws(f"{place} {number}").motion(size / 4, near=home)
            text = "exact" if places is None else f"{places}-places"
            yield f"{place}/pose-{number}/{text}", assembled(legs, at, places=places)


def hexagon(radius: float, half: float, turn: float, places: int) -> list[Vector]:
    """Return the rounded corners of a hexagon with threefold symmetry; angles in degrees.

    Two corners each are on both sides of the directions 0, 120 and 240, by the half angle.
    """
    corners = []
    for corner in range(6):
        side = half if corner % 2 else -half
        angle = math.radians(120 * (corner // 2) + side + turn)
        x, y = (rational(decimals(radius * f(angle), places)) for f in (math.cos, math.sin))
        corners.append(exact(x, y, 0))
    return corners


#: Radius and half angle of the base, and of the platform.
SHAPES = (((2.0, 12.0), (1.0, 47.0)), ((1.36, 17.5), (0.79, 37.5)), ((10.0, 8.0), (7.0, 51.0)))


def hexagons(draws: Callable[[str], Draws]) -> Iterator[Named]:
    """Yield hexagons with threefold symmetry, rounded; turned ones have no mirror left."""
    for shape, (base, platform) in enumerate(SHAPES, 1):
        for turn in (0.0, 11.3):
            for places in range(3, 13):
                name = f"shape-{shape}/{'turned' if turn else 'straight'}/{places}-places"
                random = draws(name)
                legs = hexapod(hexagon(*base, 0.0, places), hexagon(*platform, turn, places))
                size = Fraction(base[0])
                at = random.motion(size / 8, near=exact(0, 0, size))
                yield name, assembled(legs, at, places=None if places % 2 else places)


def _orbit(x: Fraction, y: Fraction) -> list[Point]:
    """Return the exact orbit of (x, y sqrt 3) under turns by 120 degrees and a mirror."""
    root = Number("sqrt", (Number.of(3),))
    points = []
    for _ in range(3):
        for mirrored in (y, -y):
            second = Number("*", (Number.of(mirrored), root))
            points.append(Point((Number.of(x), second, Number.of(0))))
        x, y = -x / 2 - 3 * y / 2, (x - y) / 2
    return points


def exact_hexagons(draws: Callable[[str], Draws]) -> Iterator[Named]:
    """Yield hexagons with exact threefold symmetry and random legs."""
    for number in range(1, 7):
        random = draws(str(number))
        base, platform = (
            _orbit(random.decimal(2, 1) + 3, random.decimal(1, 1) + Fraction(1, 7)) for _ in "xy"
        )
        constraints = (
            Constraint(DPP, y, x, Number.of(4 + random.decimal(1, 2)))
            for y, x in zip(platform, base, strict=True)
        )
        yield f"hexagon-{number}", Instance(tuple(constraints), UNITS)


def plates(draws: Callable[[str], Draws]) -> Iterator[Named]:
    """Yield planar plates shaken out of their plane, and hexagons shaken in it."""
    for power in range(1, 13):
        for number in (1, 2):
            name = f"general/1e-{power}/{number}"
            random = draws(f"general {number}")
            base, platform = random.points(6, 2, planar=True), random.points(6, 1, planar=True)
            shake = draws(name)
            base = [plus(x, exact(0, 0, shake.decimal()), tenth(power)) for x in base]
            at = random.motion()
            yield name, assembled(hexapod(base, platform), at)
        for number, turn in enumerate((0.0, 7.7), 1):
            name = f"hexagon/1e-{power}/{number}"
            shake = draws(name)
            base, platform = hexagon(2.0, 12.0, 0.0, 6), hexagon(1.0, 47.0, turn, 6)
            base = [plus(x, exact(shake.decimal(), shake.decimal(), 0), tenth(power)) for x in base]
            at = shake.motion(Fraction(1, 4), near=exact(0, 0, 2))
            yield name, assembled(hexapod(base, platform), at)


#: Which joint each of six legs has on the base and on the platform.
JOINTS = {
    "3-3": ((0, 0, 1, 1, 2, 2), (0, 1, 1, 2, 2, 0)),
    "6-3": ((0, 1, 2, 3, 4, 5), (0, 0, 1, 1, 2, 2)),
    "6-4": ((0, 1, 2, 3, 4, 5), (0, 0, 1, 1, 2, 3)),
}


def split_joints(draws: Callable[[str], Draws]) -> Iterator[Named]:
    """Yield platforms with shared joints, exact and with each of them split a little."""
    for pattern, (on_base, on_platform) in JOINTS.items():
        for number in (1, 2):
            random = draws(f"{pattern} {number}")
            base, platform = random.points(6, 2), random.points(6, 1)
            planar = number == 2
            if planar:
                base = [exact(x, y, 0) for x, y, _ in base]
                platform = [exact(x, y, 0) for x, y, _ in platform]
            at = random.motion()
            for power in (None, *range(1, 15)):
                name = f"{pattern}/{'planar' if planar else 'spatial'}"
                name += "/exact" if power is None else f"/1e-{power}"
                shake = draws(name)
                by = Fraction(0) if power is None else tenth(power)
                xs = [shake.shaken(base[j], by) for j in on_base]
                ys = [shake.shaken(platform[j], by) for j in on_platform]
                yield name, assembled(hexapod(xs, ys), at)


def bodies(draws: Callable[[str], Draws]) -> Iterator[Named]:
    """Yield congruent, similar and affine bodies, exact and shaken."""
    for shape in ("congruent-plates", "similar-plates", "affine-plates", "congruent", "similar"):
        random = draws(shape)
        base = random.points(6, 2, planar="plates" in shape)
        factor = Fraction(1) if "congruent" in shape else Fraction(3, 5)
        stretch = Fraction(7, 10) if "affine" in shape else factor
        platform = [exact(factor * x, stretch * y, factor * z) for x, y, z in base]
        at = random.motion()
        for power in (None, *range(1, 11)):
            name = shape + ("/exact" if power is None else f"/1e-{power}")
            shake = draws(name)
            by = Fraction(0) if power is None else tenth(power)
            ys = [shake.shaken(y, by) for y in platform]
            yield name, assembled(hexapod(base, ys), at)
    for power in range(3, 11):
        name = f"similar-hexagons/{power}-places"
        random = draws("similar-hexagons")
        at = random.motion(Fraction(1, 4), near=exact(0, 0, 2))
        base, platform = hexagon(2.0, 30.0, 0.0, power), hexagon(1.1, 30.0, 0.0, power)
        yield name, assembled(hexapod(base, platform), at, places=power)


def double_poses(draws: Callable[[str], Draws]) -> Iterator[Named]:
    """Yield platforms in a pose where all legs meet an axis: a double pose, exact or split."""
    for number in (1, 2, 3):
        random = draws(str(number))
        platform = random.points(6, 2)
        # Each base point on the line from the joint to a point of the axis.
        base = [
            plus(y, plus(exact(0, 0, random.decimal(3, 1)), y, -1), 2 + random.decimal())
            for y in platform
        ]
        at = HOME
        legs = hexapod(base, platform)
        yield f"axis-{number}/exact", assembled(legs, at)
        for power in range(2, 16, 2):
            for sign in (1, -1):
                squared = legs[0].square(at) + sign * tenth(power)
                name = f"axis-{number}/{'+' if sign > 0 else '-'}1e-{power}"
                yield name, assembled(legs, at, values={0: sqrt(squared)})


def far_apart(draws: Callable[[str], Draws]) -> Iterator[Named]:
    """Yield unsymmetric special positions: points on a line, legs that are parallel."""
    for number in range(1, 5):
        random = draws(f"line {number}")
        base, platform = random.points(6, 2), random.points(6, 1)
        start, along = random.point(), random.point()
        platform[:4] = [plus(start, along, random.decimal(2, 1)) for _ in range(4)]
        at = random.motion()
        yield f"four-on-a-line-{number}/exact", assembled(hexapod(base, platform), at)
        for power in (2, 4, 6, 8, 10):
            shake = draws(f"line {number} {power}")
            shaken = [shake.shaken(y, tenth(power)) for y in platform]
            yield f"four-on-a-line-{number}/1e-{power}", assembled(hexapod(base, shaken), at)
    for number in range(1, 5):
        random = draws(f"parallel {number}")
        platform = random.points(6, 1)
        base = [plus(y, random.point(1, 2)) for y in platform]
        base[1] = plus(platform[1], plus(base[0], platform[0], -1))
        base[2] = plus(platform[2], plus(base[0], platform[0], -1), 2)
        at = HOME
        yield f"parallel-legs-{number}/exact", assembled(hexapod(base, platform), at)
        for power in (3, 6, 9, 12):
            shake = draws(f"parallel {number} {power}")
            moved = [shake.shaken(x, tenth(power)) for x in base]
            yield f"parallel-legs-{number}/1e-{power}", assembled(hexapod(moved, platform), at)


GROUPS = {
    "published": published,
    "hexagons": hexagons,
    "exact-hexagons": exact_hexagons,
    "plates": plates,
    "joints": split_joints,
    "bodies": bodies,
    "double": double_poses,
    "positions": far_apart,
}
