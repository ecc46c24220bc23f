"""Counts of a type from Python are those of `gsp count --type`."""

import json

import pytest

import gspcli
from gspcli.cli.main import run
from gspcli.errors import ArgumentError


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
