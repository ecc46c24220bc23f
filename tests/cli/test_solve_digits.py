"""`gsp solve --digits`: every printed digit is proved."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

Run = Callable[..., object]
SPEC = "data/examples/octahedral-3-3.yaml"


def test_digits_in_every_format(gsp: Run) -> None:
    document = json.loads(gsp("solve", SPEC, "--digits", "40", "--format", "json").out)
    rows = list(csv.DictReader(io.StringIO(
        gsp("solve", SPEC, "--digits", "40", "--format", "csv").out
    )))  # fmt: skip
    for entry, row in zip(document["solutions"], rows, strict=True):
        assert [row[f"refined_T{axis}"] for axis in "xyz"] == entry["refined"]["T"]
        for digits, rounded in zip(entry["refined"]["T"], entry["T"], strict=True):
            assert abs(Fraction(digits) - Fraction(rounded)) < Fraction(1, 10**9)
    assert "Proved digits" in gsp("solve", SPEC, "--digits", "5").out


def test_refined_rotations_are_orthogonal_to_the_last_digit(gsp: Run) -> None:
    document = json.loads(gsp("solve", SPEC, "--digits", "60", "--format", "json").out)
    for entry in document["solutions"]:
        rows = [[Fraction(x) for x in row] for row in entry["refined"]["R"]]
        for i in range(3):
            for j in range(3):
                product = sum(a * b for a, b in zip(rows[i], rows[j], strict=True))
                assert abs(product - (i == j)) < Fraction(1, 10**58)


def test_jobs_do_not_change_the_answer(gsp: Run) -> None:
    one = gsp("solve", SPEC, "--all", "--format", "csv").out
    for jobs in ("2", "256"):
        assert one == gsp("solve", SPEC, "--all", "--format", "csv", "--jobs", jobs).out


def test_more_digits_than_python_converts(gsp: Run, tmp_path: Path) -> None:
    """Python refuses to write integers of more than 4300 digits."""
    path = tmp_path / "poses.json"
    gsp("solve", SPEC, "--digits", "4310", "-o", str(path))
    (first, *_) = json.loads(path.read_text())["solutions"]
    assert all(len(text) > 4310 for row in first["refined"]["R"] for text in row)
    proved = gsp("certify", SPEC, str(path), "--digits", "4310", "--format", "json")
    assert proved.code == 0
    assert first["refined"]["T"][0] in proved.out
