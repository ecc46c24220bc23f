"""Platforms with lines, planes and angles that are special, or special but for a shake."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction

from special_hexapods import Named
from special_parts import (
    HOME,
    Draws,
    Leg,
    Motion,
    Vector,
    assembled,
    cross,
    decimals,
    exact,
    motion,
    plus,
    sqrt,
    tenth,
)

from gspcli.catalogue.kinds import (
    ALL,
    DHP,
    DLL,
    DLP,
    DPH,
    DPL,
    DPP,
    KINDS_BY_NAME,
    Kind,
)
from gspcli.geometry.numbers import Number

Draw = Callable[[str], Draws]


def leg(kind: Kind, random: Draws) -> Leg:
    """Return a random constraint with directions of integer length."""
    return Leg(kind, random.point(), random.point(2), random.direction(), random.direction())


def legs(names: str, random: Draws) -> list[Leg]:
    """Return random constraints of kinds such as ``DPP ALL``."""
    return [leg(KINDS_BY_NAME[name], random) for name in names.split()]


def slightly_turned(a: Vector, by: Fraction, random: Draws) -> Vector:
    """Return a direction turned a little, still of rational length."""
    x, y, z = random.point()
    return motion((1, x * by, y * by, z * by), exact(0, 0, 0)).turned(a)


def planes_of(chosen: Sequence[Leg]) -> list[int]:
    """Return the indices of the constraints that have sides."""
    return [k for k, one in enumerate(chosen) if one.kind.has_sides]


#: Two constraints whose directions are nearly parallel, and the others beside them.
BESIDE = {
    DPH: ("DPP DPP DPP DPP", "DPL DPP ALL ALL"),
    DHP: ("DPP DPP DPP DPP", "DPP DLP AHL ALL"),
    DPL: ("DPP DPP DPP DPP", "DPH DPP ALH ALL"),
    DLP: ("DPP DPP DPH DHP", "DPP DHP ALL AHH"),
    DLL: ("DPP DPP DPP DPP", "DPH DPP ALL ALL"),
}


def parallels(draws: Draw) -> Iterator[Named]:
    """Yield two planes or lines of one body that are nearly parallel, with four others."""
    for kind, companions in BESIDE.items():
        for number, names in enumerate(companions, 1):
            random = draws(f"{kind} {number}")
            two, others = [leg(kind, random), leg(kind, random)], legs(names, random)
            at = random.motion()
            for power in (2, 4, 6, 8, 10, 12):
                shake = draws(f"{kind} {number} {power}")
                first, second = two
                second = Leg(
                    kind,
                    second.y,
                    second.x,
                    slightly_turned(first.u, tenth(power), shake),
                    slightly_turned(first.v, tenth(power), shake),
                )
                all_six = [first, second, *others]
                sided = planes_of(all_six) if number == 2 else ()
                name = f"{kind}-{number}/1e-{power}"
                yield name, assembled(all_six, at, one_sided=sided)


def line_pairs(draws: Draw) -> Iterator[Named]:
    """Yield DLL whose lines are parallel, or nearly, in a real pose."""
    for number, names in enumerate(("DPP DPP DPP DPP DPP", "DPH DPL DPP DPP ALL"), 1):
        random = draws(str(number))
        others, at = legs(names, random), random.motion()
        line, v = leg(DLL, random), random.direction()
        aligned = Leg(DLL, line.y, line.x, at.unturned(v), v)
        sided = [k + 1 for k in planes_of(others)]
        yield f"{number}/parallel", assembled([aligned, *others], at, one_sided=sided)
        wrong = {0: Number.of(Fraction(7, 10))}
        yield (
            f"{number}/parallel-elsewhere",
            assembled([aligned, *others], at, one_sided=sided, values=wrong),
        )
        touching = {0: Number.of(0)}
        yield (
            f"{number}/parallel-touching",
            assembled([aligned, *others], at, one_sided=sided, values=touching),
        )
        for power in range(2, 14):
            turned = slightly_turned(aligned.u, tenth(power), draws(f"{number} {power}"))
            nearly = Leg(DLL, line.y, line.x, turned, v)
            yield f"{number}/1e-{power}", assembled([nearly, *others], at, one_sided=sided)


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


def axis_legs(names: str, random: Draws) -> list[Leg]:
    """Return constraints whose forces meet the z axis at home: the pose is double."""
    made = []
    for name in names.split():
        kind = KINDS_BY_NAME[name]
        y, on_axis = random.point(2), exact(0, 0, random.decimal(3, 1))
        force = plus(on_axis, y, -1)
        x = plus(y, force, 2 + random.decimal())
        across = cross(force, random.point())
        made.append(
            Leg(kind, y, x, across if kind is DLP else force, across if kind is DPL else force)
        )
    return made


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
                squares[which] = touching + (sign * tenth(power) if power else 0)
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


def couplings(draws: Draw) -> Iterator[Named]:
    """Yield kinematic couplings: three balls in three vees, and cone, vee and flat."""
    balls = [exact(0, "18.5", 0), exact("-16.021", "-9.25", 0), exact("16.021", "-9.25", 0)]
    towards = [exact(1, 0, 0), exact(1, -2, 0), exact(1, 2, 0)]
    for number, slope in enumerate((Fraction(1), Fraction(3, 4)), 1):
        vees = []
        for ball, (a, b, _) in zip(balls, towards, strict=True):
            for sign in (1, -1):
                normal = exact(sign * a * slope, sign * b * slope, 1)
                vees.append(
                    Leg(DPH, ball, plus(ball, normal, -Fraction(3)), exact(0, 0, 0), normal)
                )
        for sides in ("one", "both"):
            for power in (None, 1, 3, 6, 9, 12):
                shake = draws(f"{number} {sides} {power}")
                by = Fraction(0) if power is None else tenth(power)
                values = {
                    k: decimals(float(one.square(HOME)) ** 0.5, 13) for k, one in enumerate(vees)
                }
                values = {
                    k: Number.of(value.fraction + shake.decimal() * by)
                    for k, value in values.items()
                }
                if power is None:
                    values = {}
                text = "exact" if power is None else f"1e-{power}"
                yield (
                    f"vees-{number}/{sides}/{text}",
                    assembled(
                        vees,
                        HOME,
                        values=values,
                        one_sided=range(6) if sides == "one" else (),
                        length="mm",
                    ),
                )
    cone = [exact(0, 3, 2), exact(-2, -1, 2), exact(2, -1, 2)]
    normals = [*cone, exact(-2, 1, 2), exact(2, -1, 2), exact(0, 0, 1)]
    where = [balls[0]] * 3 + [balls[1]] * 2 + [balls[2]]
    flats = [
        Leg(DPH, ball, plus(ball, n, -1), exact(0, 0, 0), n)
        for ball, n in zip(where, normals, strict=True)
    ]
    blocks = [
        Leg(DPH, exact(*point), exact(*point), exact(0, 0, 0), exact(*normal))
        for point, normal in (
            ((20, 20, 0), (0, 0, 1)),
            ((180, 20, 0), (0, 0, 1)),
            ((100, 130, 0), (0, 0, 1)),
            ((30, 0, 25), (0, 1, 0)),
            ((170, 0, 25), (0, 1, 0)),
            ((0, 75, 25), (1, 0, 0)),
        )
    ]
    for name, six in (("kelvin", flats), ("block", blocks)):
        for power in (None, 2, 5, 8, 11):
            shake = draws(f"{name} {power}")
            by = Fraction(0) if power is None else tenth(power)
            moved = [Leg(o.kind, o.y, o.x, o.u, shake.shaken(o.v, by)) for o in six]
            text = "exact" if power is None else f"1e-{power}"
            yield (
                f"{name}/{text}",
                assembled(moved, HOME, one_sided=range(6), length="mm"),
            )
    # Six actuators of a mirror: four planes and two links.
    mirror = [
        Leg(DPH, exact(*p), exact(*p), exact(0, 0, 0), exact(*n))
        for p, n in (
            ((0, "864.9", 251), (0, 0, 1)),
            (("-749.03", "-432.45", 251), (0, 0, 1)),
            (("749.03", "-432.45", 251), (0, 0, 1)),
            ((0, -1305, 238), (0, 1, 0)),
        )
    ]
    mirror += [Leg(DPP, exact(0, y, 262), exact(-698, y, 262)) for y in (-1277, 1277)]
    for number in range(1, 5):
        random = draws(f"mirror {number}")
        turn = (1, *(random.decimal(Fraction(1, 1000)) for _ in range(3)))
        at = motion(turn, random.point(3))
        yield (
            f"mirror/pose-{number}",
            assembled(
                mirror, at, one_sided=range(4), length="mm", places=None if number % 2 else 6
            ),
        )
    yield "mirror/home", assembled(mirror, HOME, one_sided=range(4), length="mm")


def dependent(draws: Draw) -> Iterator[Named]:
    """Yield three planes with nearly dependent normals, with angles and other kinds."""
    for number, others in enumerate(
        ("ALL ALL ALL", "ALL ALH AHH", "DPP ALL ALL", "DPL DPP ALH"), 1
    ):
        random = draws(str(number))
        planes, rest, at = legs("DPH DPH DPH", random), legs(others, random), random.motion()
        # Of rational length: a direction in the plane of the first two.
        first, second = exact(0, 3, 4), exact(0, 4, -3)
        for power in (2, 4, 6, 8, 10, 12):
            shake = draws(f"{number} {power}")
            third = slightly_turned(exact(0, 5, 12), tenth(power), shake)
            turned = [at.turned(n) for n in (first, second, third)]
            six = [
                *(Leg(DPH, p.y, p.x, p.u, n) for p, n in zip(planes, turned, strict=True)),
                *rest,
            ]
            yield f"{number}/1e-{power}", assembled(six, at, one_sided=range(3))


def far(draws: Draw) -> Iterator[Named]:
    """Yield real poses far away: planes that are nearly parallel to one direction meet there."""
    for number, others in enumerate(("ALL ALL ALL", "ALL ALH DPH", "DPH DPH ALL"), 1):
        random = draws(str(number))
        rest = legs(others, random)
        for power in range(2, 9, 2):
            at = Motion(random.motion().R, exact(10**power, "0.3", "-0.4"))
            six = []
            for p in legs("DPH DPH DPH", random):
                _, b, c = p.v
                six.append(Leg(DPH, p.y, p.x, p.u, (random.decimal() * tenth(power), b, c)))
            for one in rest:
                far_plane = (random.decimal() * tenth(power), one.v[1], one.v[2])
                six.append(Leg(DPH, one.y, one.x, one.u, far_plane) if one.kind is DPH else one)
            yield f"{number}/1e{power}", assembled(six, at)


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
        names = []
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
    "parallels": parallels,
    "line-pairs": line_pairs,
    "angles": angles,
    "degrees": degrees,
    "double-mixed": double,
    "tangent": tangent,
    "couplings": couplings,
    "dependent": dependent,
    "far": far,
    "zero": zero,
    "kinds": every_kind,
}
