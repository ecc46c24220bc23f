"""The equations modulo a prime say what the constraints state (paper, Section 4)."""

from __future__ import annotations

from random import Random

import pytest

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP, KINDS, Kind
from gspcli.geometry import study
from tools.atlas.groebner import (
    FramedPrimitive,
    equation,
    quadrics,
    quadrics_modulo,
    random_platform,
)

PRIME = 2147483647


def _vector(random: Random) -> list[int]:
    return [random.randrange(PRIME) for _ in range(3)]


def _rotation(random: Random) -> list[list[int]]:
    norm, rotation, _ = study.motion([random.randrange(PRIME) for _ in range(8)])
    inverse = pow(norm, -1, PRIME)
    return [[entry * inverse % PRIME for entry in row] for row in rotation]


def _dot(a: list[int], b: list[int]) -> int:
    return sum(p * q for p, q in zip(a, b, strict=True)) % PRIME


def _cross(a: list[int], b: list[int]) -> list[int]:
    return [(a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2]) % PRIME for i in range(3)]


def _apply(matrix: list[list[int]], vector: list[int]) -> list[int]:
    return [_dot(row, vector) for row in matrix]


def _functions(R: list[list[int]], T: list[int]) -> list[int]:
    columns = [list(column) for column in zip(*R, strict=True)]
    moments = [_cross(T, column) for column in columns]
    return [
        1,
        *(entry for row in R for entry in row),
        *T,
        *_apply(columns, T),
        _dot(T, T),
        *(moments[j][i] for i in range(3) for j in range(3)),
    ]


def _stated(
    kind: Kind,
    R: list[list[int]],
    T: list[int],
    platform: FramedPrimitive,
    base: FramedPrimitive,
    value: int,
) -> int:
    """Return the left side minus the right side of the equation of Section 4."""
    placed = [p + t for p, t in zip(_apply(R, list(platform.point)), T, strict=True)]
    r = [p - x for p, x in zip(placed, base.point, strict=True)]
    w, v = _apply(R, list(platform.frame[0])), list(base.frame[0])
    if kind is DPP:
        return (_dot(r, r) - value**2) % PRIME
    if kind in (DPL, DLP):
        across = _cross(r, v if kind is DPL else w)
        return (_dot(across, across) - value**2) % PRIME
    if kind is DPH:
        return (_dot(v, r) - value) % PRIME
    if kind is DHP:
        return (-_dot(w, r) - value) % PRIME
    normal = _cross(w, v)
    if kind is DLL:
        return (_dot(r, normal) ** 2 - value**2 * _dot(normal, normal)) % PRIME
    return (_dot(w, v) - value) % PRIME


@pytest.mark.parametrize("kind", KINDS, ids=str)
@pytest.mark.parametrize("sides", [1, 2])
def test_equations_say_what_is_stated(kind: Kind, sides: int) -> None:
    random = Random(f"{kind} {sides}")
    for _ in range(5):
        R, T = _rotation(random), _vector(random)
        platform, base = (
            FramedPrimitive(_vector(random), tuple(_rotation(random)))  # type: ignore[arg-type]
            for _ in range(2)
        )
        value = random.randrange(PRIME)
        given = equation(kind, platform, base, value, sides=sides)
        functions = _functions(R, T)
        first = _dot(given.first, functions)
        stated = _stated(kind, R, T, platform, base, value)
        if given.second is None:
            assert first == stated
        else:
            second = _dot(given.second, functions)
            left = first**2 + given.weight * second**2 - given.square
            if kind.has_sides:
                # The product of the two sides.
                stated *= stated + 2 * value
            assert (left - stated) % PRIME == 0


def test_quadrics_are_norm_times_functions() -> None:
    random = Random(3)
    e = [random.randrange(PRIME) for _ in range(4)]
    f = [random.randrange(PRIME) for _ in range(3)]
    f.insert(0, -_dot(e[1:], f) * pow(e[0], -1, PRIME) % PRIME)
    norm, scaled_rotation, scaled_translation = study.motion([*e, *f])
    inverse = pow(norm, -1, PRIME)
    R = [[entry * inverse % PRIME for entry in row] for row in scaled_rotation]
    T = [entry * inverse % PRIME for entry in scaled_translation]
    point = [*e, *f]
    values = [sum(c * point[i] * point[j] for (i, j), c in q.items()) % PRIME for q in quadrics()]
    assert values[:-1] == [norm * value % PRIME for value in _functions(R, T)]
    assert values[-1] == 0


def test_random_systems_depend_on_nothing_but_the_seed() -> None:
    kinds = (DPP, DPL, DLL)
    assert random_platform(kinds, 3, PRIME, Random(1)) == random_platform(
        kinds, 3, PRIME, Random(1)
    )
    assert random_platform(kinds, 3, PRIME, Random(1)) != random_platform(
        kinds, 3, PRIME, Random(2)
    )
    assert len(random_platform(kinds, 3, PRIME, Random(1))) == len(kinds) + 3
    members = quadrics_modulo("apqlss", PRIME, Random(1))
    used = [{k for k, c in enumerate(member.first) if c} for member in members]
    assert [len(indices) for indices in used] == [10, 13, 13, 19, 17, 17]
