"""The record of the numbers of real solutions that occur."""

from __future__ import annotations

from random import Random

import pytest

from gspcli.catalogue.counts import (
    PlaceOnLine,
    best_real,
    family_counts,
    platform_at,
    random_rows,
    real_counts,
    recorded_real_counts,
    spelled,
    witness_with,
)
from gspcli.catalogue.kinds import ALL, DHP, DLL, DPH
from gspcli.catalogue.names import parse_type
from gspcli.catalogue.types import CLASSES, families
from gspcli.errors import GspError
from gspcli.reality.witness_proofs import certified_real, known_instance, witness_instance

SAMPLE = 12


def test_all_even_numbers_occur_for_the_6_6_platform() -> None:
    assert real_counts(parse_type("6PP")) == tuple(range(0, 41, 2))


def test_the_numbers_of_the_triples_of_3d3a_are_complete() -> None:
    for family in families(CLASSES[0]):
        # Without spheres and cylinders a rotation, of which 0, 2, 4, 6 or 8 are real, has one
        # position for each choice of two times three sides and signs.
        flat = all(kind in (DPH, DHP, DLL) for kind in family.distances)
        step = 16 if flat else 2
        everything = tuple(range(0, family_counts(family).two_sided + 1, step))
        assert real_counts(family) == everything, family.id


def test_the_best_number_is_the_last_and_none_is_odd() -> None:
    for family, places in recorded_real_counts():
        numbers = [place.real for place in places]
        assert numbers == sorted(set(numbers))
        assert all(count % 2 == 0 for count in numbers)
        assert real_counts(family)[-1] == best_real(family)
        assert numbers[-1] < best_real(family)


def test_a_sample_is_certified_again() -> None:
    small = [
        (f, p) for f, row in recorded_real_counts() for p in row if family_counts(f).two_sided <= 64
    ]
    for family, place in Random(2).sample(small, SAMPLE):
        angles = (ALL,) * family.platform_class.angles
        instance = witness_instance(platform_at(family, place), angles)
        assert certified_real(instance) == place.real


def test_mirrored_families_and_other_angles_have_the_same_numbers() -> None:
    gsp_type = parse_type("DPP DPP DLP ALH AHL AHH")
    instance = known_instance(gsp_type, 12)
    assert instance.type == gsp_type
    assert certified_real(instance) == 12


def test_a_number_that_is_not_known_is_an_error() -> None:
    with pytest.raises(GspError, match=r"no platform with 7 real poses .* 0\.\.40"):
        witness_with(parse_type("6PP").family, 7)


def test_random_rows_are_the_same_everywhere() -> None:
    family = parse_type("3D3A PP PL PH ALL ALL ALL").family
    rows = random_rows(family, 3)
    assert [len(row) for row in rows] == [7, 10, 10, 7, 7, 7]
    assert [str(number) for number in rows[0]] == FIRST


FIRST = ["-14/25", "7/10", "23/50", "4/5", "-69/100", "-7/50", "183/100"]


def test_places_are_read_back() -> None:
    assert PlaceOnLine.read("38:7:0.4375") == PlaceOnLine(38, 7, "0.4375")
    assert str(PlaceOnLine(38, 7, "0.4375")) == "38:7:0.4375"


@pytest.mark.parametrize(
    ("counts", "text"),
    [((), ""), ((8,), "8"), ((0, 2, 4, 8), "0..4 8"), ((0, 16, 32), "0 16 32"), ((0, 2), "0 2")],
)
def test_runs_are_spelled_with_dots(counts: tuple[int, ...], text: str) -> None:
    assert spelled(counts) == text
