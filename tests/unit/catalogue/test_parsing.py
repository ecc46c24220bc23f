"""Reading the names of types and families."""

from __future__ import annotations

import random

import pytest

from gspcli.catalogue.coincidence import parse_sharing
from gspcli.catalogue.names import ALIASES, parse_kind, parse_name, parse_type
from gspcli.catalogue.types import CLASSES, all_types, families
from gspcli.errors import TypeNameError


def test_every_id_and_number_is_read_back() -> None:
    for gsp_type in all_types():
        assert parse_type(gsp_type.id) == gsp_type
        assert parse_type(str(gsp_type.number)) == gsp_type


def test_every_sensible_spelling_is_read() -> None:
    shuffle = random.Random(1)
    for gsp_type in all_types():
        words = [kind.name for kind in gsp_type.kinds]
        shuffle.shuffle(words)
        assert parse_type(",".join(words).lower()) == gsp_type
        assert parse_type([gsp_type.platform_class.id, *words]) == gsp_type
        short = [word if word.endswith("LL") else word[1:] for word in words]
        assert parse_type(" , ".join(short)) == gsp_type
        # With the class in front even LL has only one reading.
        assert parse_type([gsp_type.platform_class.id, *(word[1:] for word in words)]) == gsp_type


def test_every_family_id_is_read_back() -> None:
    for platform_class in CLASSES:
        for family in families(platform_class):
            found = parse_name(family.id)
            # Without angles to leave open, a family is its one type.
            assert found in (family, family.types[0])
            assert (found == family) is (platform_class.angles > 0)


@pytest.mark.parametrize(
    ("spelling", "expected"),
    [
        ("6PP", "DPP DPP DPP DPP DPP DPP"),
        ("3PL 3ALL", "DPL DPL DPL ALL ALL ALL"),
        ("PL^2 LP*1 ALL ALH AHH", "DPL DPL DLP ALL ALH AHH"),
        ("3d3a lh lh lh ph ph ph", "DPH DPH DPH ALH ALH ALH"),
        ("#3850", "DLL DLL DLL DLL DLL DLL"),
    ],
)
def test_short_hands(spelling: str, expected: str) -> None:
    assert parse_type(spelling).id == expected


@pytest.mark.parametrize(
    ("spelling", "message"),
    [
        ("", "no type given"),
        ("PP PP", "2 constraints given, a platform has six"),
        ("PX PP PP PP PP PP", r"unknown constraint 'PX': did you mean .*P"),
        ("DLH PP PP PP PP PP", "no distance of this pair"),
        ("APP PP PP PP PP PP", "no angle of this pair"),
        ("LL PP PP PP PP PP", "give the leading letter"),
        ("ALL ALL ALL ALH PP PP", "at most three"),
        ("4000", "1 to 3850"),
        ("2D4A PP PP", "unknown class '2D4A'"),
        ("4D2A PP PP PP ALL ALL ALL", "is of class 3D3A, not 4D2A"),
        ("3D3A PL PL", "names its 3 distances"),
        ("99PP", "six"),
    ],
)
def test_a_wrong_name_says_what_is_wrong(spelling: str, message: str) -> None:
    with pytest.raises(TypeNameError, match=message):
        parse_name(spelling)


def test_a_family_is_not_a_type() -> None:
    with pytest.raises(TypeNameError, match="family of 20 types: add its 3 angles"):
        parse_type("3D3A PL PL LP")


def test_a_kind_needs_its_letter_only_where_it_is_ambiguous() -> None:
    assert parse_kind("pl").name == "DPL"
    assert parse_kind("LH").name == "ALH"
    with pytest.raises(TypeNameError, match="DLL or ALL"):
        parse_kind("LL")


@pytest.mark.parametrize(
    "name", ["hexapod", "Hexapod", "6-6", "6-3", "3–6", "3-3", "6 PP", "6 dpp"]
)
def test_hexapods_have_names_of_their_own(name: str) -> None:
    assert parse_type(name) == parse_type("6DPP")


def test_a_count_may_stand_apart_from_its_kind() -> None:
    assert parse_type("3 PL 3 ALL") == parse_type("3PL 3ALL")
    assert parse_type(["3D3A", "2", "PL", "LP", "3", "ALL"]) == parse_type("PL PL LP 3ALL")


@pytest.mark.parametrize(("name", "points"), [("6-3", (6, 3)), ("3-6", (3, 6)), ("3-3", (3, 3))])
def test_the_patterns_of_names_have_so_many_points(name: str, points: tuple[int, int]) -> None:
    pattern = parse_sharing(name)
    assert (len(pattern.base_primitives), len(pattern.platform_primitives)) == points
    assert pattern == parse_sharing(ALIASES[name].pattern)
