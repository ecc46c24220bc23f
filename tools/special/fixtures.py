"""Platforms with lines and planes that are special, or special but for a shake."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from gspcli.catalogue.kinds import (
    DHP,
    DLL,
    DLP,
    DPH,
    DPL,
    DPP,
)
from gspcli.geometry.numbers import Number
from tools.special.hexapods import Named
from tools.special.legs import Draw, leg, legs, planes_of, slightly_turned
from tools.special.parts import (
    HOME,
    Leg,
    Motion,
    assembled,
    decimals,
    exact,
    motion,
    plus,
    rational,
    tenth,
)

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
            # Numbers of more than 400 characters are not read.
            for power in (*range(2, 20, 2), 19 if kind is DLL else 20):
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
        for power in range(2, 21):
            turned = slightly_turned(aligned.u, tenth(power), draws(f"{number} {power}"))
            nearly = Leg(DLL, line.y, line.x, turned, v)
            yield f"{number}/1e-{power}", assembled([nearly, *others], at, one_sided=sided)


#: The balls of a kinematic coupling.
_BALLS = [exact(0, "18.5", 0), exact("-16.021", "-9.25", 0), exact("16.021", "-9.25", 0)]


def couplings(draws: Draw) -> Iterator[Named]:
    """Yield kinematic couplings: three balls in three vees, and cone, vee and flat."""
    yield from _vees(draws)
    yield from _planes(draws)
    yield from _mirrors(draws)


def _vees(draws: Draw) -> Iterator[Named]:
    """Yield three balls in three vees of two slopes."""
    towards = [exact(1, 0, 0), exact(1, -2, 0), exact(1, 2, 0)]
    for number, slope in enumerate((Fraction(1), Fraction(3, 4)), 1):
        vees = []
        for ball, (a, b, _) in zip(_BALLS, towards, strict=True):
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
                    k: Number.of(rational(value) + shake.decimal() * by)
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


def _planes(draws: Draw) -> Iterator[Named]:
    """Yield cone, vee and flat (Kelvin's coupling), and a block on six points."""
    cone = [exact(0, 3, 2), exact(-2, -1, 2), exact(2, -1, 2)]
    normals = [*cone, exact(-2, 1, 2), exact(2, -1, 2), exact(0, 0, 1)]
    where = [_BALLS[0]] * 3 + [_BALLS[1]] * 2 + [_BALLS[2]]
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


def _mirrors(draws: Draw) -> Iterator[Named]:
    """Yield a mirror on six actuators: four planes and two links."""
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
        turn = [Fraction(1), *(random.decimal(Fraction(1, 1000)) for _ in range(3))]
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


GROUPS = {
    "parallels": parallels,
    "line-pairs": line_pairs,
    "couplings": couplings,
    "dependent": dependent,
    "far": far,
}
