"""The proof by counting, against the rank of the six gradients in exact arithmetic."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterable, Sequence

import pytest

from gspcli.catalogue.coincidence import (
    Bond,
    Vertex,
    coincident_types,
    count_coincident,
    over_constraint,
    parse_sharing,
)
from gspcli.catalogue.types import GspType, all_types

PRIME = 2**31 - 1
Vector = tuple[int, ...]


def cross(a: Vector, b: Vector) -> Vector:
    return tuple((a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2]) % PRIME for i in range(3))


def dot(a: Vector, b: Vector) -> int:
    return sum(x * y for x, y in zip(a, b, strict=True)) % PRIME


def combine(s: int, a: Vector, t: int, b: Vector) -> Vector:
    return tuple((s * x + t * y) % PRIME for x, y in zip(a, b, strict=True))


def gradient(bond: Bond, place: dict[tuple[str, Vertex], tuple[Vector, Vector]]) -> Vector:
    """Return the gradient of a constraint at the identity, up to a factor, as (force, couple)."""
    name = bond.kind.name
    a, u = place["platform", (name[1], bond.platform)]
    b, v = place["base", (name[2], bond.base)]
    if name[0] == "A":
        return (0, 0, 0, *cross(u, v))
    apart = combine(1, b, -1, a)
    if name == "DLL":
        force = cross(u, v)
        foot = combine(dot(force, force), a, dot(cross(apart, v), force), u)
        return (*combine(dot(force, force), force, 0, a), *cross(foot, force))
    force, point = {
        "DPP": (apart, a),
        "DPH": (v, a),
        "DHP": (u, b),
        "DPL": (combine(dot(v, v), apart, -dot(apart, v), v), a),
        "DLP": (combine(dot(u, u), apart, -dot(apart, u), u), b),
    }[name]
    return (*force, *cross(point, force))


def rank(rows: Iterable[Sequence[int]]) -> int:
    remaining = [list(row) for row in rows]
    found = 0
    for column in range(6):
        pivot = next((row for row in remaining if row[column] % PRIME), None)
        if pivot is not None:
            found += 1
            remaining.remove(pivot)
            inverse = pow(pivot[column], -1, PRIME)
            remaining = [
                [(x - row[column] * inverse * y) % PRIME for x, y in zip(row, pivot, strict=True)]
                for row in remaining
            ]
    return found


def random_place(seed: int) -> dict[tuple[str, Vertex], tuple[Vector, Vector]]:
    draw = random.Random(seed)

    def vector() -> Vector:
        return tuple(draw.randrange(PRIME) for _ in range(3))

    return {
        (body, (sort, number)): (vector(), vector())
        for body in ("platform", "base")
        for sort in "PLH"
        for number in range(1, 7)
    }


PLACE = random_place(1)


@pytest.mark.parametrize("gsp_type", all_types()[::101], ids=str)
def test_counting_finds_all_that_is_dependent(gsp_type: GspType) -> None:
    # A rank of six somewhere is a rank of six almost everywhere; less has to be proved by counting.
    for pattern in coincident_types(gsp_type):
        independent = rank(gradient(bond, PLACE) for bond in pattern.bonds) == 6
        assert independent == (over_constraint(pattern.bonds) is None), pattern.notation


@pytest.mark.slow
def test_counting_finds_all_that_is_dependent_in_every_type() -> None:
    dependent: Counter[str] = Counter()
    for gsp_type in all_types():
        patterns = 0
        for pattern in coincident_types(gsp_type):
            patterns += 1
            found = over_constraint(pattern.bonds)
            independent = rank(gradient(bond, PLACE) for bond in pattern.bonds) == 6
            assert independent == (found is None), pattern.notation
            dependent[gsp_type.platform_class.id] += found is not None
        assert patterns == count_coincident(gsp_type)
    print(dict(dependent))


@pytest.mark.parametrize(
    ("notation", "primitives", "freedoms"),
    [
        ("P1-p1 P1-p2 P1-p3 P1-p4 P2-p5 P3-p6", ("P1",), 3),
        ("P1-p1 P1-p2 P1-p3 P2-p4 P3-p4 P4-p4", ("P1", "p4"), 1),
        ("P1-p1 P1-p2 P1-p3 P2-p4 P2-p5 P2-p6", ("P1", "P2"), 1),
        ("L1^l1 L1^l2 L1^h1 P1-p1 P2-p2 P3-p3", ("the direction of L1",), 4),
        ("H1-p1 H1-p2 H2-p3 H2-p4 H1-p5 H2-p6", ("H1", "H2"), 1),
    ],
)
def test_the_reason(notation: str, primitives: tuple[str, ...], freedoms: int) -> None:
    found = over_constraint(parse_sharing(notation).bonds)
    assert found is not None
    assert (set(found.primitives), found.freedoms) == (set(primitives), freedoms)
    assert len(found.constraints) > 6 - freedoms
    assert f"at most {6 - found.freedoms} of these" in found.reason


def test_octahedral_platform_is_not_over_constrained() -> None:
    octahedron = parse_sharing("P1-p1 P1-p2 P2-p2 P2-p3 P3-p3 P3-p1")
    assert over_constraint(octahedron.bonds) is None
