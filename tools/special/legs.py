"""Random constraints of any kind for special platforms."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction

from gspcli.catalogue.kinds import (
    DLL,
    DLP,
    DPL,
    KINDS_BY_NAME,
    Kind,
)
from tools.special.parts import (
    Draws,
    Leg,
    Vector,
    cross,
    exact,
    motion,
    plus,
)

#: Gives the random numbers of a platform by its name.
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


def axis_legs(names: str, random: Draws) -> list[Leg]:
    """Return constraints whose forces meet the z axis at home: the pose is double."""
    made = []
    for name in names.split():
        kind = KINDS_BY_NAME[name]
        y, on_axis = random.point(2), exact(0, 0, random.decimal(3, 1))
        force = plus(on_axis, y, -1)
        x = plus(y, force, 2 + random.decimal())
        across = cross(force, random.point())
        u, v = (across if kind in other else force for other in ((DLP, DLL), (DPL, DLL)))
        if kind is DLL:
            u = cross(force, random.point())
        made.append(Leg(kind, y, x, u, v))
    return made
