"""The recorded witnesses: complete, consistent with the counts, a sample certified again."""

from __future__ import annotations

import hashlib
from random import Random

import pytest

from gspcli.catalogue.counts import (
    Witness,
    all_families,
    best_real,
    family_counts,
    recorded,
    witness,
)
from gspcli.catalogue.kinds import ALL, DHP, DPH
from gspcli.catalogue.names import parse_type
from gspcli.catalogue.types import CLASSES, CONSTRAINTS, families
from gspcli.reality.witness_proofs import certified_real, known_instance, witness_instance
from gspcli.resources import data_json, data_path

#: A sample is certified again if it takes no longer than this many poses together.
SAMPLE, POSES = 12, 64


def _angles(found: Witness) -> tuple:
    return (ALL,) * (CONSTRAINTS - len(found.family.distances))


def test_every_family_has_a_witness_and_none_exceeds_the_generic_count() -> None:
    for family in all_families():
        real = best_real(family)
        counts = family_counts(family)
        assert real is not None, family.id
        assert 0 < real <= counts.two_sided
        # A pair of conjugate solutions less or more; both sides of planes alike.
        sides = 2 ** sum(kind in (DPH, DHP) for kind in family.distances)
        assert real % sides == 0
        assert (counts.two_sided - real) % 2 == 0


def test_the_manifest_is_of_the_file() -> None:
    content = data_path("witnesses", "real.csv").read_bytes()
    manifest = data_json("witnesses", "manifest.json")
    assert hashlib.sha256(content).hexdigest() == manifest["sha256"]["real.csv"]
    assert manifest["families"] == len(list(recorded()))


def test_table_3_is_reached_by_real_solutions() -> None:
    # N1 is one-sided; one-sided numbers of planes and lines double with the two sides, and with
    # the two signs of the mutual moment.
    for family in families(CLASSES[0]):
        assert best_real(family) == family_counts(family).two_sided, family.id


def test_dietmaiers_number_is_reached() -> None:
    assert best_real(parse_type("6PP")) == 40


def test_exchanged_bodies_have_the_mirrored_family() -> None:
    for found in recorded():
        assert found.exchanged.exchanged.real == found.real
        other = witness(found.exchanged.family)
        assert other is not None
        assert other.real == found.real


def test_a_sample_is_certified_again() -> None:
    small = [found for found in recorded() if found.real <= POSES]
    for found in Random(1).sample(small, min(SAMPLE, len(small))):
        instance = witness_instance(found, _angles(found))
        assert certified_real(instance, found.real) >= found.real


@pytest.mark.parametrize("name", ["3D3A LP PH PP ALH AHL AHH", "4D2A PP HP PP HP AHH ALL"])
def test_other_angles_and_exchanged_bodies_have_as_many(name: str) -> None:
    gsp_type = parse_type(name)
    instance = known_instance(gsp_type)
    assert instance.type == gsp_type
    assert certified_real(instance) == best_real(gsp_type)
