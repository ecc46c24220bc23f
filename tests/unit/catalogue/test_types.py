"""The types of Proposition 2.2: how many, their names and their numbers."""

from __future__ import annotations

from collections import Counter
from itertools import product

import pytest

from gspcli.catalogue.kinds import ANGLE_KINDS, DISTANCE_KINDS, KINDS, Primitive
from gspcli.catalogue.types import CLASSES, GspType, all_types, families, type_by_number
from gspcli.errors import TypeNameError


def test_kinds_are_all_the_pairs_that_have_the_quantity() -> None:
    # A distance of a line or plane to a plane, or an angle with a point, is not one equation.
    points_lines = {Primitive.POINT, Primitive.LINE}
    for platform, base in product(Primitive, repeat=2):
        distance = any(k.platform is platform and k.base is base for k in DISTANCE_KINDS)
        angle = any(k.platform is platform and k.base is base for k in ANGLE_KINDS)
        has_point = Primitive.POINT in (platform, base)
        assert angle is not has_point
        assert distance is (has_point or {platform, base} <= points_lines)


def test_class_sizes_are_those_of_proposition_2_2() -> None:
    counted = Counter(gsp_type.platform_class.id for gsp_type in all_types())
    assert counted == {"3D3A": 1120, "4D2A": 1260, "5D1A": 1008, "6D": 462}
    assert {c.id: c.size for c in CLASSES} == counted


def test_types_are_exactly_the_multisets_of_six_kinds_with_at_most_three_angles() -> None:
    multisets = {
        tuple(sorted(kinds)): None for distances in range(3, 7) for kinds in _multisets(distances)
    }
    assert set(multisets) == {gsp_type.kinds for gsp_type in all_types()}
    assert len(all_types()) == 3850


def _multisets(distances: int) -> set[tuple]:
    # Independent of the module: by repeated insertion instead of combinations.
    grown = {()}
    for position in range(6):
        pool = DISTANCE_KINDS if position < distances else ANGLE_KINDS
        grown = {tuple(sorted((*kinds, kind))) for kinds in grown for kind in pool}
    return grown


def test_numbers_are_stable() -> None:
    # Numbers appear in files and in the literature: these must never change.
    named = {
        1: "DPP DPP DPP ALL ALL ALL",
        1120: "DLL DLL DLL AHH AHH AHH",
        1121: "DPP DPP DPP DPP ALL ALL",
        3388: "DLL DLL DLL DLL DLL AHH",
        3389: "DPP DPP DPP DPP DPP DPP",
        3850: "DLL DLL DLL DLL DLL DLL",
    }
    for number, name in named.items():
        assert type_by_number(number).id == name
    assert [gsp_type.number for gsp_type in all_types()] == list(range(1, 3851))


@pytest.mark.parametrize("number", [0, -1, 3851])
def test_a_number_outside_the_catalogue_is_refused(number: int) -> None:
    with pytest.raises(TypeNameError, match="1 to 3850"):
        type_by_number(number)


def test_families_partition_the_types() -> None:
    grouped = [gsp_type for c in CLASSES for family in families(c) for gsp_type in family.types]
    assert grouped == list(all_types())
    assert sum(1 for c in CLASSES for _ in families(c)) == 56 + 126 + 252 + 462


def test_mirroring_exchanges_platform_and_base() -> None:
    for gsp_type in all_types():
        assert gsp_type.mirrored.mirrored == gsp_type
        assert sorted(gsp_type.mirrored.primitives, key=str) == sorted(
            ((base, platform) for platform, base in gsp_type.primitives), key=str
        )


def test_a_type_needs_six_constraints_and_at_most_three_angles() -> None:
    with pytest.raises(TypeNameError, match="six"):
        GspType.of(KINDS[:5])
    with pytest.raises(TypeNameError, match="at most three"):
        GspType.of(ANGLE_KINDS + DISTANCE_KINDS[:2])
