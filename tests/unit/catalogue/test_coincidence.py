"""Patterns of shared primitives: listed and counted by independent ways that must agree."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import permutations, product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gspcli.catalogue.coincidence import (
    Bond,
    Sharing,
    Vertex,
    _count,
    canonical_bonds,
    coincident_types,
    count_coincident,
    count_self_mirrored,
    count_up_to_swap,
    invariant_partitions,
    over_constraint,
    parse_sharing,
)
from gspcli.catalogue.kinds import ALL, DLL, DLP, DPL, DPP, KINDS, Kind
from gspcli.catalogue.names import parse_type
from gspcli.catalogue.types import GspType, all_types
from gspcli.errors import TypeNameError

HARDEST = parse_type("DLL DLL DLL ALL ALL ALL")
SAMPLE = [*all_types()[::97], HARDEST, parse_type("6PP")]


@pytest.mark.parametrize("gsp_type", SAMPLE, ids=str)
def test_the_list_is_as_long_as_burnside_says(gsp_type: GspType) -> None:
    patterns = list(coincident_types(gsp_type))
    assert len(patterns) == count_coincident(gsp_type)
    assert len({pattern.bonds for pattern in patterns}) == len(patterns)
    assert [pattern.index for pattern in patterns] == list(range(1, len(patterns) + 1))
    assert all(canonical_bonds(pattern.bonds) == pattern.bonds for pattern in patterns)


def test_the_first_pattern_has_all_primitives_distinct() -> None:
    for gsp_type in all_types()[::31]:
        first = next(coincident_types(gsp_type))
        assert len(first.platform_primitives) == len(first.base_primitives) == 6


def set_partitions(length: int) -> list[tuple[int, ...]]:
    """Return the partitions of a set as words of block numbers in order of appearance."""
    words = [()]
    for _ in range(length):
        words = [(*w, b) for w in words for b in range(1, max(w, default=0) + 2)]
    return words


def patterns_by_brute_force(kinds: tuple[Kind, ...]) -> int:
    """Count orbits of pairs of partitions of the edges under all permutations within kinds."""
    n = len(kinds)
    orders = [o for o in permutations(range(n)) if all(kinds[o[i]] is kinds[i] for i in range(n))]
    partitions = set_partitions(n)

    def unmixed(word: tuple[int, ...], sorts: list[object]) -> bool:
        return all(
            sorts[i] is sorts[j] for i, j in product(range(n), repeat=2) if word[i] == word[j]
        )

    def renamed(word: tuple[int, ...], order: tuple[int, ...]) -> tuple[int, ...]:
        names: dict[int, int] = {}
        return tuple(names.setdefault(word[i], len(names)) for i in order)

    at_platform = [w for w in partitions if unmixed(w, [k.platform for k in kinds])]
    at_base = [w for w in partitions if unmixed(w, [k.base for k in kinds])]
    return len(
        {
            min((renamed(a, order), renamed(b, order)) for order in orders)
            for a in at_platform
            for b in at_base
            if len(set(zip(kinds, a, b, strict=True))) == n
        }
    )


@pytest.mark.parametrize(
    "kinds",
    [
        (DPP,),
        (DPP,) * 4,
        (DLL,) * 2 + (ALL,) * 2,
        (DLL,) * 3 + (ALL,),
        (DPP, DPP, DPL, DLP),
        (DPP, DPP, DPL, DPL),
    ],
    ids=str,
)
def test_the_formula_agrees_with_brute_force(kinds: tuple[Kind, ...]) -> None:
    times = tuple((kind, kinds.count(kind)) for kind in KINDS if kind in kinds)
    assert _count(times) == patterns_by_brute_force(kinds)


@pytest.mark.parametrize("cycle_type", [(1,) * 5, (2, 2), (4,), (3, 2, 1), (2, 2, 1), (6,)])
def test_invariant_partitions_by_brute_force(cycle_type: tuple[int, ...]) -> None:
    image: list[int] = []
    for length in cycle_type:
        start = len(image)
        image += [*range(start + 1, start + length), start]
    blocks = [
        {frozenset(i for i, b in enumerate(word) if b == block) for block in word}
        for word in set_partitions(len(image))
    ]
    unchanged = sum(
        {frozenset(image[i] for i in block) for block in partition} == partition
        for partition in blocks
    )
    assert invariant_partitions(cycle_type) == unchanged


@given(st.sampled_from(SAMPLE), st.integers(min_value=0, max_value=2**32))
def test_renaming_and_reordering_do_not_matter(gsp_type: GspType, seed: int) -> None:
    draw = random.Random(seed)
    pattern = draw.choice(list(coincident_types(gsp_type)))
    names = {(side, sort): draw.sample(range(1, 100), 6) for side in "pb" for sort in "PLH"}
    bonds = [
        Bond(
            bond.kind,
            names["p", bond.kind.short[0]][bond.platform - 1],
            names["b", bond.kind.short[1]][bond.base - 1],
        )
        for bond in pattern.bonds
    ]
    draw.shuffle(bonds)
    assert canonical_bonds(bonds) == pattern.bonds


@pytest.mark.parametrize("gsp_type", SAMPLE[::8], ids=str)
def test_notation_round_trips(gsp_type: GspType) -> None:
    for pattern in list(coincident_types(gsp_type))[::60]:
        assert parse_sharing(pattern.notation) == pattern


def test_notation_of_the_platform_of_figure_2() -> None:
    pattern = parse_sharing("L1-l3, L1^l3, L2-l4, L2^l4, L1^l4, L2-l3")
    assert pattern.type == parse_type("DLL DLL DLL ALL ALL ALL")
    assert pattern.platform_primitives == ("L1", "L2")
    assert pattern.base_primitives == ("l1", "l2")
    assert pattern.id == f"{pattern.type.number}.{pattern.index}"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("P1-p1 P1-p1 P1-p2 P2-p1 P2-p2 P3-p3", "P1-p1 stands twice"),
        ("L1-h1 P1-p1 P1-p2 P2-p1 P2-p2 P3-p3", "there is no distance of L and H"),
        ("P1^p1 P1-p2 P2-p1 P2-p2 P3-p3 P4-p4", "there is no angle of P and P"),
        ("P1-P1 P1-p2", "is no constraint between named primitives"),
        ("P1-p1 P1-p2", "six constraints, not 2"),
        ("L1^l1 L1^l2 L1^l3 L2^l1 P1-p1 P1-p2", "at most three"),
    ],
)
def test_a_wrong_notation_says_what_is_wrong(text: str, expected: str) -> None:
    with pytest.raises(TypeNameError, match=expected):
        parse_sharing(text)


@pytest.mark.parametrize("name", ["6PP", "2PP 2PL 2LP", "PP PH HP ALL ALH AHL", "4DLL 2ALL", "6PL"])
def test_patterns_that_the_exchange_of_bodies_leaves_the_same(name: str) -> None:
    patterns = list(coincident_types(parse_type(name)))
    same = [pattern for pattern in patterns if pattern.mirrored == pattern.notation]
    assert len(same) == count_self_mirrored(parse_type(name))


def test_classes_up_to_the_exchange_of_bodies() -> None:
    gsp_type = parse_type("6PP")

    def class_of(pattern: Sharing) -> str:
        return min(pattern.notation, pattern.mirrored)

    assert len(set(map(class_of, coincident_types(gsp_type)))) == count_up_to_swap(gsp_type)


def test_mirrored_types_have_equally_many_patterns() -> None:
    assert all(count_coincident(t) == count_coincident(t.mirrored) for t in all_types())


def test_mirroring_twice_is_nothing() -> None:
    for pattern in list(coincident_types(GspType.of([DPP, DPL, DPL, DLP, DLL, ALL])))[::10]:
        mirrored = parse_sharing(pattern.mirrored)
        assert mirrored.type == pattern.type.mirrored
        assert mirrored.mirrored == pattern.notation


# The proof by counting, against the rank of the six gradients in exact arithmetic.


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
