"""`gsp count`: the counts, their proofs, and its exit codes."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from pathlib import Path

Run = Callable[..., object]


def test_json_of_a_special_platform(gsp: Run) -> None:
    outcome = gsp("count", "@planar-hexagons", "--format", "json")
    assert (outcome.code, outcome.err) == (0, "")
    document = json.loads(outcome.out)
    assert document["schema"] == "gsp.count/1"
    counts = {key: document[key] for key in ("type_count", "geometry_count", "exact_count")}
    assert counts == {"type_count": 40, "geometry_count": 28, "exact_count": 28}
    assert (document["distinct"], document["finite"]) == (28, True)
    assert document["spurious"] == 0
    assert document["proof"]["type_count"] == {"modulo_random_prime": False}
    assert 0 < document["proof"]["exact_count"]["modulo_random_prime"] < 1e-9


def test_the_same_command_gives_the_same_bytes(gsp: Run) -> None:
    first = gsp("count", "@octahedral-3-3", "--format", "json").out
    assert gsp("count", "@octahedral-3-3", "--format", "json").out == first
    assert gsp("count", "@octahedral-3-3", "--format", "json", "--seed", "1").out != first


def test_table_of_several_platforms(gsp: Run) -> None:
    outcome = gsp("count", "@dietmaier", "@singular-pose", "@six-planes", "--format", "csv")
    rows = list(csv.DictReader(io.StringIO(outcome.out)))
    assert [row["exact_count"] for row in rows] == ["40", "40", "8"]
    assert [row["distinct"] for row in rows] == ["40", "39", "8"]
    assert {row["proof"] for row in rows} == {"proved"}


def test_infinitely_many_is_exit_code_3(gsp: Run) -> None:
    outcome = gsp("count", "@griffis-duffy", "--format", "json")
    assert outcome.code == 3
    document = json.loads(outcome.out)
    assert (document["finite"], document["exact_count"]) == (False, None)
    assert outcome.err == "error: infinitely many complex solutions: @griffis-duffy\n"


def test_what_cannot_be_counted_is_exit_code_4(gsp: Run, tmp_path: Path) -> None:
    text = gsp("example", "dietmaier").out
    path = tmp_path / "arctangent.yaml"
    begin, _, rest = text.rpartition("value: ")
    path.write_text(begin + "value: atan(2)}\n" + rest.partition("\n")[2], encoding="utf-8")
    outcome = gsp("count", str(path), "--format", "json")
    assert outcome.code == 4
    document = json.loads(outcome.out)
    assert (document["geometry_count"], document["exact_count"]) == (40, None)
    assert document["proof"]["exact_count"] is None
    assert "no exact arithmetic for atan outside an angle" in outcome.err


def test_a_limit_that_is_too_low(gsp: Run) -> None:
    outcome = gsp("count", "@parallel-edges", "--effort", "0.001")
    assert outcome.code == 4
    assert "within the limit of 0.001 billion multiplications" in outcome.err


def test_classes_of_geometry(gsp: Run) -> None:
    outcome = gsp("count", "--type", "6PP", "--geometry", "planar,hexagons,3-3", "--format", "csv")
    rows = list(csv.DictReader(io.StringIO(outcome.out)))
    assert [(row["geometry"], row["count"]) for row in rows] == [
        ("planar", "40"),
        ("hexagons", "28"),
        ("3-3", "16"),
    ]


def test_wrong_usage(gsp: Run) -> None:
    assert gsp("count").code == 2
    assert gsp("count", "@dietmaier", "--type", "6PP").code == 2
    outcome = gsp("count", "--type", "5PP+PL", "--geometry", "3-3")
    assert outcome.code == 2
    assert "expected of DPP DPP DPP DPP DPP DPL: generic, planar-base" in outcome.err


def test_a_generic_geometry_too_large_to_count_has_the_generic_count(gsp):
    outcome = gsp("count", "--type", "6DLL", "--effort", "1", "--format", "json")
    assert outcome.code == 0
    (row,) = json.loads(outcome.out)["geometries"]
    assert row == {
        "geometry": "generic",
        "meaning": "nothing special",
        "count": 4096,
        "distinct": 4096,
        "proof": "proved for the type",
        "modulo_random_prime": False,
    }
