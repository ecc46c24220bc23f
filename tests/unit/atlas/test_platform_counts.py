"""Counts of a type from Python are those of `gsp count --type`."""

from __future__ import annotations

import json

import pytest

import gspcli
from gspcli.atlas.platform_counts import CLASSES, random_geometry
from gspcli.catalogue.names import parse_name
from gspcli.certification.counting import count_geometry
from gspcli.cli.main import run
from gspcli.errors import ArgumentError, GspError


def test_counts_are_those_of_the_command(capsys):
    run(["count", "--type", "6PP", "--geometry", "generic,3-3", "--format", "json"])
    shown = json.loads(capsys.readouterr().out)
    found = gspcli.count("6PP", geometries=["generic", "3-3"])
    assert found.to_json() == shown
    assert [one.count for one in found.counts] == [40, 16]
    assert found.to_frame()["geometry"].tolist() == ["generic", "3-3"]
    assert repr(found) == "<TypeCounts of DPP DPP DPP DPP DPP DPP: generic 40, 3-3 16>"


@pytest.mark.parametrize("given", ["3DPH 3ALL", 3850, gspcli.parse_type("6PP")])
def test_a_type_is_taken_by_name_number_or_itself(given):
    found = gspcli.count(given, effort=1e-9)
    (one,) = found.counts
    assert one.of_type
    assert one.proof == "proved for the type"
    assert one.count == gspcli.bound(given).counts.two_sided


def test_a_class_that_a_type_cannot_have_is_refused():
    with pytest.raises(ArgumentError, match="geometries: found '3-3', expected of"):
        gspcli.count("3DPH 3ALL", geometries="3-3")


def test_a_platform_is_counted_itself():
    found = gspcli.count(gspcli.example("octahedral-3-3"))
    assert (found.type_count, found.exact.solutions) == (40, 16)


SIX_LEGS = parse_name("DPP DPP DPP DPP DPP DPP")
#: Counts known from the literature or from Gröbner bases of the examples.
KNOWN = {
    "generic": 40,
    "planar": 40,
    "mirror": 36,
    "hexagons": 28,
    "6-4": 32,
    "6-3": 16,
    "3-3": 16,
    "congruent": 24,
    "planar-congruent": 16,
    "regular-hexagons": 0,
}


@pytest.mark.parametrize("name", KNOWN)
@pytest.mark.parametrize("seed", [1, 2])
def test_counts_of_special_geometries(name, seed):
    count = count_geometry(random_geometry(SIX_LEGS, CLASSES[name], seed))
    assert (count.finite, count.solutions, count.distinct) == (True, KNOWN[name], KNOWN[name])


def test_planar_geometries_of_other_types():
    gsp_type = parse_name("DPP DPP DPL DPH ALL ALL")
    for name in ("generic", "planar", "planar-base", "planar-platform"):
        instance = random_geometry(gsp_type, CLASSES[name], 1)
        assert instance.type == gsp_type
        heights = [float(row.base.position[2]) for row in instance.constraints]
        assert (set(heights) == {0.0}) == (name in ("planar", "planar-base"))


def test_classes_of_joints_are_for_six_legs():
    with pytest.raises(GspError, match="expected 6PP"):
        random_geometry(parse_name("DPP DPP DPL DPH ALL ALL"), CLASSES["3-3"], 1)
