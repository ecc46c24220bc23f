"""Platforms where doubles tell little: T = 0, self-motions, angles 0, 90, 180, many digits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from math import isqrt

from gspcli.catalogue.kinds import DPP
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Point
from tools.special.hexapods import JOINTS, UNITS, Named, hexapod
from tools.special.legs import Draw, axis_legs, legs, planes_of
from tools.special.parts import (
    HOME,
    ZERO,
    Draws,
    Leg,
    Motion,
    Vector,
    assembled,
    decimals,
    exact,
    motion,
    plus,
    tenth,
)

#: Kinds of platforms that are nearly singular where the frames of both bodies coincide.
AT_ZERO = (
    "DPP DPP DPP DPP DPP DPP",
    "DPL DPP DPP DPP DPP DPP",
    "DPH DPP DPP DPP DPP DPP",
    "DPP DPP DPP DPP DHP DHP",
    "DLP DPP DPP DPP DPP DPH",
    "DLL DPH DPP DPP DPP DPP",
    "DPL DPH DHP DPP DPP DPP",
    "DLL DPH DPH DPH DPP DPP",
)


def at_zero(draws: Draw) -> Iterator[Named]:
    """Yield poses at T = 0 that are so near to singular ones, for R = 1 and another R."""
    for names in AT_ZERO:
        random = draws(names)
        six = axis_legs(names, random)
        short = names.replace("D", "").replace(" ", "-")
        other = motion((random.randint(1, 4), *(random.randint(-4, 4) for _ in range(3))), ZERO)
        for text, at in (("home", HOME), ("turned", other)):
            placed = [replace(leg, x=at.turned(leg.x), v=at.turned(leg.v)) for leg in six]
            for power in (2, 4, 5, 6, 7, 8, 9, 10, 12, 14):
                shake = draws(f"{names} {text} {power}")
                k = shake.randrange(6)
                nearly = [*placed]
                nearly[k] = replace(placed[k], x=shake.shaken(placed[k].x, tenth(power)))
                yield (
                    f"{short}/{text}/1e-{power}",
                    assembled(nearly, at, one_sided=planes_of(nearly)),
                )


def _around(points: Sequence[Vector]) -> list[Leg]:
    """Return the six legs of an octahedron between a triangle and the opposite one."""
    ys, xs = points[:3], points[3:]
    return [Leg(DPP, ys[i], xs[j]) for i in range(3) for j in range(3) if i != j]


def _bricard(random: Draws, *, plane: bool) -> tuple[list[Leg], Motion]:
    """Return Bricard's octahedra (1897) with an axis of symmetry, or with a plane of symmetry."""
    ys = random.points(3, 2)
    if plane:
        ys[2] = exact(0, ys[2][1], ys[2][2])
        opposite = [exact(-x, y, z) for x, y, z in ys]
        opposite[2] = plus(exact(0, random.decimal(2), random.decimal(2)), ZERO)
    else:
        opposite = [exact(-x, -y, z) for x, y, z in ys]
    return _around([*ys, *opposite]), HOME


def _line_symmetric(random: Draws) -> tuple[list[Leg], Motion]:
    """Return pairs of legs of which each has the points of the other, at a half turn."""
    ys = random.points(6, 1)
    xs = [ys[k ^ 1] for k in range(6)]
    return hexapod(xs, ys), motion((0, 0, 0, 1), exact(random.decimal(2), random.decimal(2), 0))


def _borel_bricard(random: Draws) -> tuple[list[Leg], Motion]:
    """Return points that a turn about an axis with a shift along it keeps on spheres.

    On half planes through the axis, at radii r and k / r, one height beside the other (R. Bricard,
    1906): zeta^2 + 2 c zeta = 2 k (cos phi - 1) for all of them.
    """
    k, c = 1 + abs(random.decimal()), 1 + abs(random.decimal())
    six = []
    for _ in range(6):
        along = motion((random.randint(1, 4), 0, 0, random.randint(-4, 4)), ZERO).R[0]
        radius, height = Fraction(1, 2) + abs(random.decimal()), random.decimal()
        y = exact(radius * along[0], radius * along[1], height)
        x = exact(k / radius * along[0], k / radius * along[1], height - c)
        six.append(Leg(DPP, y, x))
    return six, HOME


def flexible(draws: Draw) -> Iterator[Named]:
    """Yield platforms with self-motions of one parameter, exact and shaken."""
    makers = {
        "bricard-axis": lambda random: _bricard(random, plane=False),
        "bricard-plane": lambda random: _bricard(random, plane=True),
        "line-symmetric": _line_symmetric,
        "borel-bricard": _borel_bricard,
    }
    for name, make in makers.items():
        for number in (1, 2, 3):
            six, at = make(draws(f"{name} {number}"))
            for power in (None, *range(5, 14)):
                shake = draws(f"{name} {number} {power}")
                by = Fraction(0) if power is None else tenth(power)
                shaken = [replace(leg, y=shake.shaken(leg.y, by)) for leg in six]
                text = "exact" if power is None else f"1e-{power}"
                yield f"{name}-{number}/{text}", assembled(shaken, at)


#: Platforms of which one angle is 0, 90 or 180 degrees, or nearly.
RIGHT = (
    "DPP DPP DPP DPP DPP ALL",
    "DPH DPL DPP DPP DPP AHH",
    "DPP DPP DPP DPH ALL ALL",
    "DPL DPH DPP ALL AHH ALL",
)


def right_angles(draws: Draw) -> Iterator[Named]:
    """Yield platforms with angles of 0, 90 and 180 degrees, exact and shaken."""
    for number, names in enumerate(RIGHT, 1):
        random = draws(str(number))
        six, at = legs(names, random), random.motion()
        k = next(k for k, one in enumerate(six) if not one.kind.is_distance)
        for degrees in (0, 90, 180):
            for power in (None, 3, 6, 9, 12, 15):
                by = Fraction(0) if power is None else tenth(power)
                value = {k: Number.of(Fraction(degrees) + (by if degrees < 180 else -by))}
                text = "exact" if power is None else f"1e-{power}"
                yield (
                    f"{number}/{degrees}/{text}",
                    assembled(six, at, places=9, values=value, one_sided=planes_of(six)),
                )


def many_digits(draws: Draw) -> Iterator[Named]:
    """Yield shared joints at sqrt(2), of which one leg has only this many digits."""
    root = Number("sqrt", (Number.of(2),))
    for pattern in ("6-3", "6-4"):
        on_base, on_platform = JOINTS[pattern]
        for planar in (False, True):
            random = draws(f"{pattern} {planar}")
            base, platform = (random.points(6, size, planar=planar) for size in (2, 1))
            for digits in (8, 12, 15, 16, 17, 20, 24, 28):
                near = Number.of(Fraction(isqrt(2 * 100**digits), 10**digits))
                rows = []
                at = draws(f"{pattern} {planar} pose").motion()
                for k in range(6):
                    y, x = platform[on_platform[k]], base[on_base[k]]
                    _, *rest = map(Number.of, y)
                    first = root if k else near
                    size = Leg(DPP, (Fraction(1414, 1000), *y[1:]), x).square(at)
                    joint = Point((Number("*", (first, Number.of(1 + on_platform[k]))), *rest))
                    value = decimals(1 + float(size) ** 0.5, 3)
                    rows.append(Constraint(DPP, joint, Point(tuple(map(Number.of, x))), value))
                name = f"{pattern}/{'planar' if planar else 'spatial'}/{digits}-digits"
                yield name, Instance(tuple(rows), UNITS)


def same_points(draws: Draw) -> Iterator[Named]:
    """Yield five legs between the same two points, or nearly, and another constraint."""
    for name in ("DPP", "DPH", "DPL"):
        random = draws(name)
        y, x, at = random.point(), random.point(2), random.motion()
        other = legs(name, random)[0]
        for power in (None, *range(2, 13)):
            shake = draws(f"{name} {power}")
            by = Fraction(0) if power is None else tenth(power)
            six = [Leg(DPP, shake.shaken(y, by), shake.shaken(x, by)) for _ in range(5)]
            text = "exact" if power is None else f"1e-{power}"
            six = sorted([*six, other], key=lambda one: one.kind.order)
            yield f"{name}/{text}", assembled(six, at, one_sided=planes_of(six))


GROUPS = {
    "at-zero": at_zero,
    "flexible": flexible,
    "right-angles": right_angles,
    "many-digits": many_digits,
    "same-points": same_points,
}
