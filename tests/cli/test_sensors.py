"""`gsp sensors` and `gsp solve --reading`: what the page shows, exit codes, mistakes."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from pathlib import Path

import pytest

from gspcli.resources import instance_files

PAGE = Path(__file__).resolve().parents[2] / "docs" / "sensors.md"
READING = "leg P1 B2 = 2.913 ± 0.002"


def test_exit_codes_of_readings(gsp: Callable) -> None:
    assert gsp("solve", "@rubin-m2", "--reading", READING).code == 0
    several = gsp("solve", "@rubin-m2", "--reading", "leg P1 B2 = 2.95 +- 0.1")
    assert (several.code, "2 modes fit" in several.err) == (1, True)
    assert several.out.count(" fits\n") == 2
    none = gsp("solve", "@rubin-m2", "--reading", "leg P1 B2 = 1 +/- 0.1")
    assert (none.code, "no mode fits" in none.err, "fits\n" in none.out) == (1, True, False)


def test_a_reading_in_csv_and_json(gsp: Callable) -> None:
    rows = list(
        csv.DictReader(
            io.StringIO(gsp("solve", "@rubin-m2", "--reading", READING, "--format", "csv").out)
        )
    )
    assert [row["fits"] for row in rows] == ["false", "true"]
    document = json.loads(
        gsp("solve", "@rubin-m2", "--reading", READING, "--format", "json", "--all").out
    )
    assert document["fitting"] == [2]
    assert document["readings"] == [{"sensor": "leg P1 B2", "values": [2.913], "sigma": 0.002}]
    assert document["solutions"][1]["fits"] is True
    ((expected,),) = document["solutions"][1]["expected_readings"]
    assert document["solutions"][1]["off"] == [pytest.approx(abs(expected - 2.913) / 0.002)]
    assert "fits" not in document["solutions"][2]


def test_a_seventh_leg_between_points_of_the_file(gsp: Callable, tmp_path: Path) -> None:
    text = instance_files()["rubin-m2"].read_text(encoding="utf-8")
    text = text.replace("base:\n", "  P7: {point: [0, 0, 1]}\nbase:\n  B7: {point: [1, 0, 0]}\n", 1)
    path = tmp_path / "seven.yaml"
    path.write_text(text, encoding="utf-8")
    table = gsp("sensors", path, "--all-sensors", "--format", "csv").out
    sensors = [row["sensor"] for row in csv.DictReader(io.StringIO(table))]
    assert {"leg P7 B7", "leg P7 B1", "leg P1 B7"} <= set(sensors)
    outcome = gsp("solve", path, "--reading", "leg P7 B7 = sqrt(2) ± 0.001")
    assert outcome.code == 0
    assert "mode 2 fits" in outcome.out


@pytest.mark.parametrize(
    ("text", "column", "message"),
    [
        ("leg P7 B2 = 3 ± 1", 5, "found 'P7', expected a point of the platform"),
        ("leg B2 P7 = 3 ± 1", 5, "the platform's comes first"),
        ("leg P1 B1 = 3 ± 1", 1, "found constraint 1, expected another leg"),
        ("leg P1 = 3 ± 1", 7, "found no more words, expected a point of the base"),
        ("leg P1 B2 B3 = 3 ± 1", 11, "found 'B3', expected nothing more"),
        ("lge P1 B2 = 3 ± 1", 1, "did you mean leg?"),
        ("leg P1 B2", 10, "found no =, expected a reading"),
        ("leg P1 B2 = 3", 14, "found no ±, expected the standard deviation"),
        ("leg P1 B2 = 3 ± 0", 17, "expected a standard deviation above 0"),
        ("leg P1 B2 = -3 ± 1", 13, "expected a distance of at least 0"),
        ("leg P1 B2 = three ± 1", 13, "found 'three'"),
        ("leg P1 (1, 2) = 3 ± 1", 8, "expected three numbers (x, y, z)"),
        ("leg P1 (1, 2, a) = 3 ± 1", 15, "found 'a'"),
        ("inclinometer = 3 ± 1", 16, "found 1 number, expected two numbers, rx and ry"),
        ("joint 7 base about x = 3 ± 1", 7, "found constraint 7, expected a leg (DPP)"),
        ("joint 1 base about z from z = 3 ± 1", 7, "along the direction of zero"),
        ("joint 1 base about w = 3 ± 1", 20, "found 'w', expected a direction"),
    ],
)
def test_a_mistake_is_named_with_its_column(
    gsp: Callable, text: str, column: int, message: str
) -> None:
    outcome = gsp("solve", "@rubin-m2", "--reading", text)
    assert (outcome.code, outcome.out) == (2, "")
    assert f"column {column}: " in outcome.err
    assert message in outcome.err
    assert len(outcome.err.splitlines()) <= 5


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--sigma", "legs=1"), "--sigma: found 'legs', expected one of leg, joint"),
        (("--sigma", "leg=0"), "expected a standard deviation above 0"),
        (("--sensor", "leg P1 B9"), "--sensor 'leg P1 B9', column 8: found 'B9'"),
        (("--set", "1=-2"), "expected a distance of at least 0"),
    ],
)
def test_mistakes(gsp: Callable, words: tuple[str, ...], message: str) -> None:
    outcome = gsp("sensors", "@rubin-m2", *words)
    assert (outcome.code, outcome.out) == (2, "")
    assert message in outcome.err


def test_poses_without_number(gsp: Callable) -> None:
    outcome = gsp("sensors", "@three-vee-250mm")
    assert (outcome.code, outcome.out) == (3, "")
    assert "infinitely many" in outcome.err


def test_nothing_to_tell_apart(gsp: Callable) -> None:
    outcome = gsp("sensors", "@no-real-pose")
    assert outcome.code == 0
    assert "0 real modes: there is nothing to tell apart" in outcome.out


def test_rows_of_a_file(gsp: Callable, tmp_path: Path) -> None:
    path = tmp_path / "path.csv"
    path.write_text("x,y,z,rx,ry,rz\n0,0,0,0,0,0\n0.001,0,0,0,0.1,0\n", encoding="utf-8")
    outcome = gsp("sensors", "@rubin-m2", path, "--euler", "ZYX")
    assert outcome.code == 0
    assert "2 sets of values of the file, with 2 real modes; 2 with more than one" in outcome.out
    path.write_text("1\n0.001\n", encoding="utf-8")
    assert gsp("sensors", "@rubin-m2", path, "--relative").code == 0
    path.write_text("1\nx\n", encoding="utf-8")
    wrong = gsp("sensors", "@rubin-m2", path)
    assert (wrong.code, "path.csv:2:1: 1: found 'x'" in wrong.err) == (2, True)
    assert gsp("sensors", "@rubin-m2", "--relative").code == 2


def test_near_a_fold(gsp: Callable) -> None:
    """A billionth from where a pair of modes vanishes."""
    vary = ("--vary", "1=1:2.5:4", "--folds", "--format", "json")
    fold = json.loads(gsp("scan", "@octahedral-3-3", *vary).out)["folds"][0]
    value = fold["1"] * (1 + (1e-9 if fold["change"] > 0 else -1e-9))
    outcome = gsp("sensors", "@octahedral-3-3", "--set", f"1={value!r}")
    assert outcome.code == 0
    assert "near a fold, where modes meet, no sensor suffices" in outcome.out


def test_encoders_of_motors_tell_no_modes_apart(gsp):
    run = gsp("sensors", "@t-top-head", "--sensor", "crank.B1")
    assert (run.code, run.out) == (2, "")
    assert "crank.B1 reads the same at all modes" in run.err
