"""Platforms of random kinds with several special things at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP, KINDS_BY_NAME
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from tools.special.hexapods import Named
from tools.special.legs import Draw, leg, planes_of
from tools.special.parts import (
    ZERO,
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
    tenth,
)

#: How many.
COUNT = 100
#: Larger platforms are drawn again: counting them twice takes long.
_MOST_POSES = 400
#: Kinds as often as they are drawn, and how many lines' distances there are at most.
_DISTANCES = ("DPP", "DPP", "DPP", "DPL", "DLP", "DPH", "DHP", "DLL")
_ANGLES = ("ALL", "ALH", "AHL", "AHH")
_MOST_LINES = 2

Change = Callable[[list[Leg], Motion, Draws], list[Leg]]


def random_kinds(random: Draws) -> list[str]:
    """Return names of kinds in canonical order: few lines, as large types take long."""
    angles = random.choice((0, 0, 0, 1, 2, 3))
    if random.random() < 0.3:
        return ["DPP"] * 6
    while True:
        names = [random.choice(_DISTANCES) for _ in range(6 - angles)]
        if sum(name in ("DPL", "DLP", "DLL") for name in names) <= _MOST_LINES:
            break
    names += [random.choice(_ANGLES) for _ in range(angles)]
    return sorted(names, key=lambda name: KINDS_BY_NAME[name].order)


def _sharing(six: list[Leg], at: Motion, random: Draws) -> list[Leg]:
    """Give some constraints the points of others."""
    result = list(six)
    for _ in range(random.randint(1, 3)):
        i, j = random.sample(range(6), 2)
        if random.random() < 0.5:
            result[j] = replace(result[j], y=result[i].y)
        else:
            result[j] = replace(result[j], x=result[i].x)
    return result


def _aligned(six: list[Leg], at: Motion, random: Draws) -> list[Leg]:
    """Make directions parallel, opposite, or those of axes."""
    result = list(six)
    for _ in range(random.randint(1, 3)):
        i, j = random.sample(range(6), 2)
        sign = random.choice((1, -1, 2))
        if random.random() < 0.5:
            result[j] = replace(result[j], u=plus(exact(0, 0, 0), result[i].u, sign))
        else:
            result[j] = replace(result[j], v=plus(exact(0, 0, 0), result[i].v, sign))
    return result


def _axes(six: list[Leg], at: Motion, random: Draws) -> list[Leg]:
    """Give all primitives of a body the directions of axes."""
    axes = (exact(1, 0, 0), exact(0, 1, 0), exact(0, 0, 1))
    name = random.choice("uv")
    return [one.with_vectors({name: random.choice(axes)}) for one in six]


def _planar(six: list[Leg], at: Motion, random: Draws) -> list[Leg]:
    """Put the points of a body, or of both, into a plane."""
    which = random.choice((("y",), ("x",), ("x", "y")))
    return [
        one.with_vectors({name: (*getattr(one, name)[:2], Fraction(0)) for name in which})
        for one in six
    ]


def _mirrored(six: list[Leg], at: Motion, random: Draws) -> list[Leg]:
    """Make three constraints the mirror images of the others where the kinds are the same."""
    result = list(six)
    for i in range(3):
        one = six[i]
        result[5 - i] = Leg(six[5 - i].kind, *map(_flipped, (one.y, one.x, one.u, one.v)))
    return result


def _flipped(a: Vector) -> Vector:
    """Return the mirror image of a vector in the plane x = 0."""
    return (-a[0], a[1], a[2])


def _similar(six: list[Leg], at: Motion, random: Draws) -> list[Leg]:
    """Make the points of the base similar to those of the platform."""
    factor = random.choice((Fraction(1), Fraction(3, 2), Fraction(-1)))
    return [replace(one, x=plus(exact(0, 0, 0), one.y, factor)) for one in six]


def _meeting(six: list[Leg], at: Motion, random: Draws) -> list[Leg]:
    """Make a distance zero at the pose."""
    k = random.randrange(6)
    one = six[k]
    if not one.kind.is_distance:
        return six
    x = at.placed(one.y)
    moved = {
        DPP: lambda: x,
        DPL: lambda: plus(x, one.v, random.decimal()),
        DLP: lambda: plus(x, at.turned(one.u), random.decimal()),
        DPH: lambda: plus(x, cross(one.v, random.point())),
        DHP: lambda: plus(x, at.turned(cross(one.u, random.point()))),
        DLL: lambda: plus(x, one.v, random.decimal()),
    }[one.kind]()
    return [*six[:k], replace(one, x=moved), *six[k + 1 :]]


def _parallel(six: list[Leg], at: Motion, random: Draws) -> list[Leg]:
    """Make two directions parallel, or perpendicular, at the pose."""
    chosen = [k for k, one in enumerate(six) if one.kind.name[1] != "P" and one.kind.name[2] != "P"]
    if not chosen:
        return six
    k = random.choice(chosen)
    one = six[k]
    v = at.turned(one.u)
    if random.random() < 0.4:
        a, b, _ = one.u
        v = at.turned((b, -a, Fraction(0)) if a or b else exact(1, 0, 0))
    if random.random() < 0.3:
        v = plus(exact(0, 0, 0), v, -1)
    return [*six[:k], replace(one, v=v), *six[k + 1 :]]


def _collinear(six: list[Leg], at: Motion, random: Draws) -> list[Leg]:
    """Put four points of a body on a line."""
    start, along = random.point(), random.point()
    name = random.choice("yx")
    moved = [one.with_vectors({name: plus(start, along, random.decimal(2, 1))}) for one in six[:4]]
    return [*moved, *six[4:]]


def _singular(six: list[Leg], at: Motion, random: Draws) -> list[Leg]:
    """Put the wrenches of distances on lines that meet an axis."""
    result = []
    for one in six:
        if one.kind is DPP:
            on_axis = at.placed(exact(0, 0, random.decimal(3, 1)))
            y = at.placed(one.y)
            x = plus(y, plus(on_axis, y, -1), 2 + random.decimal())
            one = replace(one, x=x)
        result.append(one)
    return result


CHANGES: tuple[Change, ...] = (
    _sharing,
    _aligned,
    _axes,
    _planar,
    _mirrored,
    _similar,
    _meeting,
    _parallel,
    _collinear,
    _singular,
)


def _shaken(six: list[Leg], by: Fraction, random: Draws) -> list[Leg]:
    result = list(six)
    for k in random.sample(range(6), random.randint(1, 6)):
        one = result[k]
        result[k] = replace(one, y=random.shaken(one.y, by), x=random.shaken(one.x, by))
    return result


def mixture(random: Draws) -> Instance:
    """Return a platform of random kinds with several special things."""
    names, at = random_kinds(random), random.motion()
    if random.random() < 0.2:
        at = motion((1, 0, 0, 0), random.point())
    six = [leg(KINDS_BY_NAME[name], random) for name in names]
    for change in random.sample(CHANGES, random.randint(1, 4)):
        six = change(six, at, random)
    if random.random() < 0.5:
        six = _shaken(six, tenth(random.randint(1, 14)), random)
    if random.random() < 0.2:
        offset = exact(random.choice((1000, 10**6)), random.randint(-9, 9), 0)
        at = Motion(at.R, plus(at.T, offset))
        six = [replace(one, x=plus(one.x, offset)) for one in six]
    if random.random() < 0.2:
        scale = Fraction(10) ** random.randint(-3, 6)
        at = Motion(at.R, plus(exact(0, 0, 0), at.T, scale))
        six = [replace(one, x=plus(ZERO, one.x, scale), y=plus(ZERO, one.y, scale)) for one in six]
    places = random.choice((None, None, None, 2, 4, 6, 9, 12))
    planes = planes_of(six)
    sided = random.choice(((), planes, planes[:1]))
    values: dict[int, Number] = {}
    if random.random() < 0.15:
        k = random.randrange(6)
        if six[k].kind.is_distance:
            values[k] = random.choice((Number.of(0), decimals(random.random() * 2, 2)))
    try:
        return assembled(six, at, places=places, one_sided=sided, values=values)
    except ValueError:
        # Not every direction has a rational length, which exact angles need.
        return assembled(six, at, places=9, one_sided=sided, values=values)


def mixtures(draws: Draw) -> Iterator[Named]:
    """Yield platforms of random kinds with several special things."""
    for number in range(1, COUNT + 1):
        random = draws(str(number))
        instance = mixture(random)
        while instance.expected > _MOST_POSES:
            instance = mixture(random)
        yield f"{number}/{'-'.join(row.kind.short for row in instance.constraints)}", instance


GROUPS = {"mixtures": mixtures}
