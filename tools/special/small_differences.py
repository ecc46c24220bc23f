"""Special platforms that are shaken by very little, and numbers of very different sizes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction

from gspcli.catalogue.kinds import ALL, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.geometry.numbers import Number
from tools.special.hexapods import JOINTS, Named, hexapod
from tools.special.legs import Draw, leg, legs, planes_of
from tools.special.parts import (
    ZERO,
    Draws,
    Leg,
    Motion,
    Vector,
    assembled,
    cross,
    plus,
    sqrt,
    tenth,
)

#: Values of platforms with smaller differences are rounded: squares of these have too many digits.
_EXACT_POWER, _PLACES = 14, 9


def _named(kind: Kind, names: str) -> str:
    return f"{kind.short}-{names.replace('D', '').replace(' ', '-')}"


def _nearly(
    six: list[Leg],
    at: Motion,
    power: int,
    *,
    meeting: int = 0,
) -> Named:
    """Return a platform, its constraints in canonical order, with its power of ten as a name.

    The first ones may meet: their distance is zero. Then planes are two-sided.
    """
    zero = [id(one) for one in six[:meeting]]
    chosen = sorted(six, key=lambda one: one.kind.order)
    known = {k: Number.of(0) for k, one in enumerate(chosen) if id(one) in zero}
    has_angles = not all(one.kind.is_distance for one in chosen)
    places = _PLACES if power > _EXACT_POWER or has_angles else None
    sided = () if meeting else planes_of(chosen)
    return f"1e-{power}", assembled(chosen, at, places=places, one_sided=sided, values=known)


def guide_rods(draws: Draw) -> Iterator[Named]:
    """Yield three lines of one body that are parallel up to this angle."""
    for kind in (DPL, DLP):
        for names in ("DPP DPP DPP", "DPH DPP DPP", "DPH DPP ALL"):
            text = _named(kind, names)
            random = draws(text)
            three, others = [leg(kind, random) for _ in range(3)], legs(names, random)
            at, along = random.motion(), random.direction()
            for power in (5, 8, 11, 14, 20, 30):
                shake = draws(f"{text} {power}")
                rods = [
                    replace(one, u=_off(along, shake, power), v=_off(along, shake, power))
                    for one in three
                ]
                name, platform = _nearly([*rods, *others], at, power)
                yield f"{text}/{name}", platform


def one_axis(draws: Draw) -> Iterator[Named]:
    """Yield lines of one body that are the same line up to this much."""
    for kind in (DPL, DLP):
        for names in ("DPP DPP DPP", "DPH DPP DPP", "DPP DPP DPP DPP"):
            text = _named(kind, names)
            random = draws(text)
            count = 6 - len(names.split())
            points = [leg(kind, random) for _ in range(count)]
            others, at = legs(names, random), random.motion()
            on_axis, along = random.point(), random.direction()
            for power in (5, 9, 14, 20, 30):
                shake = draws(f"{text} {power}")
                lines = []
                for one in points:
                    place, direction = _off(on_axis, shake, power), _off(along, shake, power)
                    if kind is DPL:
                        lines.append(replace(one, x=place, v=direction))
                    else:
                        lines.append(replace(one, y=place, u=direction))
                name, platform = _nearly([*lines, *others], at, power)
                yield f"{text}/{name}", platform


def _off(a: Vector, shake: Draws, power: int) -> Vector:
    """Return a point or a direction that is changed by so little."""
    return shake.shaken(a, tenth(power))


def meeting_lines(draws: Draw) -> Iterator[Named]:
    """Yield two pairs of lines that meet, where some lines are parallel up to this angle.

    They are those of the platform, of the base, of both, or those of each pair at the pose.
    """
    for names in ("DPP DPP DPP DPP", "DPH DPP DPP DPP", "DPH DPP DPP ALL"):
        for where in ("u", "v", "uv", "pose"):
            text = f"{_named(DLL, names)}/{where}"
            random = draws(text)
            two, others, at = [leg(DLL, random) for _ in "12"], legs(names, random), random.motion()
            for power in (5, 9, 12, 20):
                shake = draws(f"{text} {power}")
                first, second = two
                if where == "pose":
                    first, second = (
                        replace(one, v=_off(at.turned(one.u), shake, power)) for one in two
                    )
                else:
                    near = {name: _off(getattr(first, name), shake, power) for name in where}
                    second = second.with_vectors(near)
                lines = [
                    replace(one, x=plus(at.placed(one.y), one.v, shake.decimal()))
                    for one in (first, second)
                ]
                name, platform = _nearly([*lines, *others], at, power, meeting=2)
                yield f"{text}/{name}", platform


#: Types of platforms whose parts have very different sizes.
SCALED = (
    "DPP DPP DPP DPP DPP DPP",
    "DPL DPP DPP DPP DPP DPP",
    "DPH DPP DPP DPP DPP DPP",
    "DPL DPH DPP DPP DPP ALL",
    "DPL DLP DPP DPP DPP DPP",
    "DLL DPP DPP DPP DPP DPP",
    "DPL DPL DLP DPH DPP DPP",
)


def scales(draws: Draw) -> Iterator[Named]:
    """Yield platforms whose points are at distances of 1e-12, 1 and 1e12 from the origins."""
    for names in SCALED:
        short = names.replace("D", "").replace(" ", "-")
        for text, powers in (
            ("small-platform", ((-12,), (0,))),
            ("large-base", ((0,), (12,))),
            ("both", ((-12,), (12,))),
            ("mixed", ((-12, 0, 12), (-12, 0, 12))),
        ):
            random = draws(f"{short} {text}")
            six, at = legs(names, random), random.motion()
            scaled = []
            for k, one in enumerate(six):
                y, x = (Fraction(10) ** choice[k % len(choice)] for choice in powers)
                scaled.append(replace(one, y=plus(ZERO, one.y, y), x=plus(ZERO, one.x, x)))
            yield f"{short}/{text}", assembled(scaled, at, places=15, one_sided=planes_of(six))


def _shared(random: Draws) -> list[Leg]:
    on_base, on_platform = JOINTS["6-3"]
    base, platform = random.points(6, 2), random.points(6, 1)
    return hexapod([base[k] for k in on_base], [platform[k] for k in on_platform])


def _plate(random: Draws) -> list[Leg]:
    return hexapod(random.points(6, 2, planar=True), random.points(6, 1, planar=True))


def _congruent(random: Draws) -> list[Leg]:
    points = random.points(6)
    return hexapod(points, points)


def _similar_plates(random: Draws) -> list[Leg]:
    points = random.points(6, planar=True)
    return hexapod([plus(ZERO, point, Fraction(3, 2)) for point in points], points)


def _collinear(random: Draws) -> list[Leg]:
    start, along = random.point(), random.point()
    points = [plus(start, along, k) for k in (-2, 0, 1, 3)]
    return hexapod(random.points(6, 2), [*points, random.point(), random.point()])


def _parallel_planes(random: Draws) -> list[Leg]:
    two, v = legs("DPH DPH", random), random.direction()
    return [*(replace(one, v=v) for one in two), *legs("DPP DPP DPP DPP", random)]


def _parallel_rods(random: Draws) -> list[Leg]:
    two, v = legs("DPL DPL", random), random.direction()
    return [*(replace(one, v=v) for one in two), *legs("DPP DPP DPP DPP", random)]


def _same_axes(random: Draws) -> list[Leg]:
    u, v = random.direction(), random.direction()
    return [
        *legs("DPL DPP DPP DPP", random),
        *(Leg(ALL, random.point(), random.point(), u, v) for _ in "12"),
    ]


def _crossing_rods(random: Draws) -> list[Leg]:
    two, u = legs("DPL DLP", random), random.direction()
    return [*(replace(one, u=u, v=u) for one in two), *legs("DPH DPP DPP DPP", random)]


#: Platforms in special position; each direction and point is shaken.
SPECIAL: dict[str, Callable[[Draws], list[Leg]]] = {
    "joints-6-3": _shared,
    "plate": _plate,
    "congruent": _congruent,
    "similar-plates": _similar_plates,
    "collinear": _collinear,
    "parallel-planes": _parallel_planes,
    "parallel-rods": _parallel_rods,
    "same-axes": _same_axes,
    "crossing-rods": _crossing_rods,
}


def small_shakes(draws: Draw) -> Iterator[Named]:
    """Yield platforms in special position, shaken by 1e-22 to 1e-57."""
    for text, special in SPECIAL.items():
        random = draws(text)
        six, at = special(random), random.motion()
        for power in (22, 30, 40, 57):
            shake = draws(f"{text} {power}")
            vectors = [
                {
                    name: _off(getattr(one, name), shake, power)
                    for name in "yxuv"
                    if any(getattr(one, name))
                }
                for one in six
            ]
            shaken = [one.with_vectors(near) for one, near in zip(six, vectors, strict=True)]
            name, platform = _nearly(shaken, at, power)
            yield f"{text}/{name}", platform


def touching_angles(draws: Draw) -> Iterator[Named]:
    """Yield three angles of zero, which two determine, and loci of a point that nearly touch."""
    for number, names in enumerate(("DPP DPP DPH", "DPL DPP DPH", "DPP DPP DPP"), 1):
        random = draws(str(number))
        three, at = legs(names, random), random.motion()
        shared = random.point()
        three = [replace(one, y=shared) for one in three]
        centre = at.placed(shared)
        # A plane, and in it a direction along which all other surfaces are tangential.
        tangent, across = random.direction(), random.direction()
        normal = cross(tangent, across)
        placed = []
        for one in three:
            if one.kind is DPH:
                placed.append(replace(one, v=normal, x=centre))
            else:
                force = plus(cross(tangent, normal), normal, random.decimal())
                axis = cross(force, random.point())
                x = plus(centre, force, 1 + random.decimal())
                placed.append(replace(one, x=x, v=axis))
        turns = [random.direction() for _ in range(3)]
        angles = [Leg(ALL, shared, centre, u, at.turned(u)) for u in turns]
        for power in (None, 4, 8, 13, 16):
            by = Fraction(0) if power is None else tenth(power)
            changed = 0 if placed[0].kind is DPP else 1
            values = {k: Number.of(0) for k in (3, 4, 5)}
            values[changed] = sqrt(placed[changed].square(at) + by)
            text = "exact" if power is None else f"1e-{power}"
            sided = [k for k, one in enumerate(placed) if one.kind is DPH]
            platform = assembled([*placed, *angles], at, values=values, one_sided=sided)
            yield f"{number}/{text}", platform


GROUPS = {
    "guide-rods": guide_rods,
    "one-axis": one_axis,
    "meeting-lines": meeting_lines,
    "scales": scales,
    "small-shakes": small_shakes,
    "touching-angles": touching_angles,
}
