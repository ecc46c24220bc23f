"""Platforms with special angles, surfaces that touch, double poses, and all kinds mixed."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from gspcli.catalogue.kinds import (
    ALL,
    DLL,
    DLP,
    DPH,
    DPL,
    DPP,
)
from gspcli.geometry.numbers import Number
from tools.special.hexapods import Named
from tools.special.legs import Draw, axis_legs, legs, planes_of, slightly_turned
from tools.special.parts import (
    HOME,
    Leg,
    Motion,
    Vector,
    assembled,
    cross,
    decimals,
    exact,
    plus,
    sqrt,
    tenth,
)

#: Platforms of which two angles get nearly parallel directions, on one body or both.
ANGLES = (
    "DPH DPL DPP ALL ALL ALL",
    "DPL DPL DPL ALL ALH AHH",
    "DPP DPP DPL ALH ALH AHL",
    "DPP DPP DPP DPP ALL ALL",
    "DPH DPP DLP DPL AHH ALL",
    "DPH DPH DPL DPP ALL AHL",
)


def angles(draws: Draw) -> Iterator[Named]:
    """Yield 3D3A and 4D2A platforms two of whose angles have nearly the same directions."""
    for number, names in enumerate(ANGLES, 1):
        random = draws(str(number))
        six, at = legs(names, random), random.motion()
        first = next(k for k, one in enumerate(six) if not one.kind.is_distance)
        for power in (2, 4, 6, 8, 10, 12):
            shake = draws(f"{number} {power}")
            u = slightly_turned(six[first].u, tenth(power), shake)
            v = six[first + 1].v
            if number % 2:
                v = slightly_turned(six[first].v, tenth(power), shake)
            one = six[first + 1]
            nearly = [*six]
            nearly[first + 1] = Leg(one.kind, one.y, one.x, u, v)
            places = None if power % 4 else 9
            yield (
                f"{number}/1e-{power}",
                assembled(nearly, at, one_sided=planes_of(nearly), places=places),
            )
    for number, names in enumerate(("DPP DPP DPP DPL DPH ALL", "DPL DLP DPP DPH DPP AHL"), 1):
        random = draws(f"5D1A {number}")
        six, at = legs(names, random), random.motion()
        lines = [k for k, one in enumerate(six) if one.kind in (DPL, DLP)]
        axis = six[-1]
        for power in (2, 4, 6, 8, 10, 12):
            shake = draws(f"5D1A {number} {power}")
            nearly = [*six]
            for k in lines:
                one = nearly[k]
                u = slightly_turned(axis.u, tenth(power), shake)
                v = slightly_turned(axis.v, tenth(power), shake)
                nearly[k] = Leg(one.kind, one.y, one.x, u, v)
            yield (
                f"5D1A-{number}/1e-{power}",
                assembled(nearly, at, one_sided=planes_of(nearly)),
            )


def degrees(draws: Draw) -> Iterator[Named]:
    """Yield platforms with three angles of degrees, their axes special or nearly so."""
    x, y, z = exact(1, 0, 0), exact(0, 1, 0), exact(0, 0, 1)
    for number, distances in enumerate(("DPL DPL DPL", "DPH DPL DPP", "DPP DPP DPH"), 1):
        random = draws(str(number))
        shared = random.point()
        chosen = [Leg(one.kind, shared, one.x, one.u, one.v) for one in legs(distances, random)]
        at = Motion(HOME.R, random.point())
        distance_values = {
            k: decimals(float(one.square(at)) ** 0.5, 3) for k, one in enumerate(chosen)
        }
        for text in ("60 60 60", "59.9999 60 60", "45 90 30", "36 72 60", "61.7 45 90.001"):
            for power in (None, 5, 9):
                by = Fraction(0) if power is None else tenth(power)
                shake = draws(f"{number} {text} {power}")
                axes = [
                    Leg(ALL, shared, shared, slightly_turned(u, by, shake), v)
                    for u, v in ((z, z), (y, y), (x, x))
                ]
                values = distance_values | {
                    3 + k: Number.of(value) for k, value in enumerate(text.split())
                }
                name = f"{number}/{text.replace(' ', ',')}/"
                name += "exact" if power is None else f"1e-{power}"
                yield (
                    name,
                    assembled(
                        [*chosen, *axes],
                        at,
                        values=values,
                        degrees=True,
                        one_sided=planes_of(chosen),
                    ),
                )


def double(draws: Draw) -> Iterator[Named]:
    """Yield double poses of platforms with lines and planes, exact and split."""
    for names in (
        "DPL DPP DPP DPP DPP DPP",
        "DPH DPP DPP DPP DPP DPP",
        "DPL DPH DPP DPP DPP DPP",
        "DPP DPP DLP DHP DPP DPP",
        "DPL DLP DPH DPP DPP DPP",
    ):
        random = draws(names)
        six = axis_legs(names, random)
        short = names.replace("D", "").replace(" ", "-")
        yield f"{short}/exact", assembled(six, HOME)
        changed = 1 if "DLP" not in names else 4
        for power in (4, 8, 12):
            for sign in (1, -1):
                squared = six[changed].square(HOME) + sign * tenth(power)
                name = f"{short}/{'+' if sign > 0 else '-'}1e-{power}"
                yield name, assembled(six, HOME, values={changed: sqrt(squared)})


def tangent(draws: Draw) -> Iterator[Named]:
    """Yield Example 6.8 with cylinders that touch, or nearly, and a sphere on planes."""
    x, y, z, origin = exact(1, 0, 0), exact(0, 1, 0), exact(0, 0, 1), exact(0, 0, 0)
    axes = [(z, z), (y, y), (x, x)]
    six = [Leg(DPL, origin, origin, origin, v) for _, v in axes]
    six += [Leg(ALL, origin, origin, u, v) for u, v in axes]
    at_60 = {3: Number.of(60), 4: Number.of(60), 5: Number.of(60)}
    radii = [36, 16, 25]
    for which, touching in ((2, 52), (0, 41), (1, 61)):
        for power in (None, 2, 4, 6, 8, 10, 12, 14):
            for sign in (1, -1) if power else (1,):
                squares = [Fraction(r) for r in radii]
                squares[which] = touching + (sign * tenth(power) if power else Fraction(0))
                values = at_60 | {k: sqrt(s) for k, s in enumerate(squares)}
                text = "exact" if power is None else f"{'+' if sign > 0 else '-'}1e-{power}"
                yield (
                    f"cylinders-{touching}/{text}",
                    assembled(six, HOME, values=values, degrees=True),
                )
    for number, kinds in enumerate(("DPP DPH DPL", "DPP DPP DPH", "DPL DPL DPH"), 1):
        random = draws(str(number))
        three = legs(kinds, random)
        three = [Leg(one.kind, origin, one.x, one.u, one.v) for one in three]
        # At this point the third surface touches the curve of the first two.
        at = Motion(HOME.R, random.point())
        forces = [_gradient(one, at) for one in three[:2]]
        tangential = cross(*forces)
        third = cross(tangential, random.point())
        last = three[2]
        along = cross(third, random.point()) if last.kind is DPL else third
        three[2] = Leg(last.kind, origin, plus(at.T, third, 3), last.u, along)
        turns = legs("ALL ALH AHH", random)
        for power in (None, 3, 6, 9, 12):
            for sign in (1, -1) if power else (1,):
                squared = three[2].square(at) + (sign * tenth(power) if power else 0)
                text = "exact" if power is None else f"{'+' if sign > 0 else '-'}1e-{power}"
                yield (
                    f"surfaces-{number}/{text}",
                    assembled([*three, *turns], at, values={2: sqrt(squared)}, one_sided=()),
                )


def _gradient(one: Leg, at: Motion) -> Vector:
    """Return a normal of the surface of a DPP, DPL or DPH at the point."""
    offset = plus(at.placed(one.y), one.x, -1)
    if one.kind is DPH:
        return one.v
    if one.kind is DPP:
        return offset
    length = sum(c * c for c in one.v)
    along = sum(a * b for a, b in zip(offset, one.v, strict=True))
    return plus(offset, one.v, -along / length)


def zero(draws: Draw) -> Iterator[Named]:
    """Yield distances of zero: points on points, lines and planes, lines that meet."""
    for number, names in enumerate(
        (
            "DPP DPL DPP DPP DPP DPP",
            "DPL DPP DPP DPP DPP DPP",
            "DPL DPL DPP DPP DPP DPP",
            "DLP DPH DPP DPP DPP DPP",
            "DPH DPH DPH DPP DPP DPP",
            "DLL DPP DPP DPP DPP DPP",
            "DLL DLL DPH DPP ALL ALL",
            "DPH DHP DPL DPP ALL AHH",
            "DPL DPH DPP ALL ALH AHL",
        ),
        1,
    ):
        random = draws(str(number))
        six, at = legs(names, random), random.motion()
        first = six[0]
        x = at.placed(first.y)
        moved = {
            DPP: x,
            DPL: plus(x, first.v, random.decimal()),
            DLP: plus(x, at.turned(first.u), random.decimal()),
            DPH: plus(x, cross(first.v, random.point())),
            DLL: plus(x, first.v, random.decimal()),
        }[first.kind]
        six[0] = Leg(first.kind, first.y, moved, first.u, first.v)
        sided = planes_of(six)
        yield f"{number}/meeting", assembled(six, at, one_sided=sided)
        for power in (5, 10):
            near = {0: Number.of(tenth(power))}
            yield f"{number}/1e-{power}", assembled(six, at, one_sided=sided, values=near)


def every_kind(draws: Draw) -> Iterator[Named]:
    """Yield platforms of many families with decimals, one- and two-sided."""
    chooser = draws("families")
    kinds = ["DPP", "DPL", "DLP", "DPH", "DHP", "DLL"]
    turns = ["ALL", "ALH", "AHL", "AHH"]
    for number in range(1, 73):
        random = draws(str(number))
        angles_here = number % 4
        lines = 0
        names: list[str] = []
        while len(names) < 6 - angles_here:
            name = chooser.choice(kinds)
            if name in ("DPL", "DLP", "DLL"):
                if lines == 2:
                    continue
                lines += 1
            names.append(name)
        names += [chooser.choice(turns) for _ in range(angles_here)]
        six, at = legs(" ".join(sorted(names)), random), random.motion()
        six = sorted(six, key=lambda one: one.kind.order)
        sided = planes_of(six)
        if number % 5 == 0:
            sided = sided[:1]
        # Unsymmetric special positions: parallel lines, a point in common, a right angle.
        special = number % 3
        if special == 1:
            six[1] = Leg(six[1].kind, six[0].y, six[1].x, six[0].u, six[1].v)
        elif special == 2:
            six[1] = Leg(six[1].kind, six[1].y, six[0].x, six[1].u, six[0].v)
        name = f"{number}/{'-'.join(one.kind.short for one in six)}"
        places = None if number % 2 else 6
        yield name, assembled(six, at, one_sided=sided, places=places)


GROUPS = {
    "angles": angles,
    "degrees": degrees,
    "double-mixed": double,
    "tangent": tangent,
    "zero": zero,
    "kinds": every_kind,
}
