"""Platforms of random kinds crowded together: small integers, few places, few directions."""

from __future__ import annotations

from dataclasses import replace

from gspcli.catalogue.kinds import KINDS_BY_NAME
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from tools.special.legs import planes_of
from tools.special.mixtures import random_kinds
from tools.special.parts import Draws, Leg, Vector, assembled, exact, motion, tenth

#: Quaternions of the pose: none, half and quarter turns, thirds, others.
_TURNS = ((1, 0, 0, 0), (0, 0, 0, 1), (1, 1, 0, 0), (1, 1, 1, 1), (2, 0, 0, 1), (2, 1, 0, 2))
#: Directions of integer length.
_DIRECTIONS = ((1, 0, 0), (0, 1, 0), (0, 0, 1), (3, 4, 0), (1, 2, 2))


def _places(random: Draws) -> list[Vector]:
    """Return a few points of small integers, often in a plane or on a line."""
    size, kept = random.choice((1, 2, 3)), random.choice((1, 2, 2, 3, 3))
    return [
        exact(*(random.randint(-size, size) if axis < kept else 0 for axis in range(3)))
        for _ in range(random.randint(2, 6))
    ]


def _directions(random: Draws) -> list[Vector]:
    return [exact(*random.choice(_DIRECTIONS)) for _ in range(random.randint(1, 3))]


def crowd(random: Draws) -> Instance:
    """Return a platform with a pose, unless some of its distances are other small integers."""
    at = motion(random.choice(_TURNS), random.choice(_places(random)))
    ys, xs, us, vs = (make(random) for make in (_places, _places, _directions, _directions))
    six = [
        Leg(KINDS_BY_NAME[name], *(random.choice(pool) for pool in (ys, xs, us, vs)))
        for name in random_kinds(random)
    ]
    if random.random() < 0.4:
        by = tenth(random.randint(2, 12))
        for k in random.sample(range(6), random.randint(1, 3)):
            six[k] = replace(six[k], y=random.shaken(six[k].y, by))
    values: dict[int, Number] = {}
    if random.random() < 0.4:
        distances = [k for k, one in enumerate(six) if one.kind.is_distance]
        for k in random.sample(distances, random.randint(1, len(distances))):
            values[k] = Number.of(random.choice((0, 1, 1, 2, 2, 3)))
    sided = random.choice(((), planes_of(six)))
    return assembled(six, at, one_sided=sided, values=values)
