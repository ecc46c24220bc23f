"""`gsp sample`: table, CSV, JSON, picture, and an interruption."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from gspcli.catalogue.names import parse_type
from gspcli.reality import real_distribution
from gspcli.reality.platforms import Reality
from gspcli.reality.real_distribution import Sample, Tally
from gspcli.solver import solve
from gspcli.spec import load
from gspcli.workers import Workers

WORDS = ("sample", "6PH", "--one-sided", "--count", "20")


def test_table(gsp) -> None:
    done = gsp(*WORDS)
    assert done.code == 0
    lines = done.out.splitlines()
    assert lines[0] == ("DPH DPH DPH DPH DPH DPH: real ones of 8 solutions for one choice of sides")
    assert lines[2].endswith("; 0 undecided, 0 incomplete")
    assert lines[4].split() == ["real", "solutions", "platforms", "share"]
    assert "########" in done.out


def test_csv_and_json_agree(gsp) -> None:
    document = json.loads(gsp(*WORDS, "--format", "json").out)
    assert document["schema"] == "gsp.sample/1"
    assert document["expected"] == 8
    assert document["platforms"] == 20
    rows = gsp(*WORDS, "--format", "csv").out.splitlines()
    assert rows[0] == "real,platforms,share"
    assert {row.split(",")[0]: int(row.split(",")[1]) for row in rows[1:]} == document["real"]
    assert sum(document["real"].values()) == 20


def test_the_seed_decides(gsp) -> None:
    assert gsp(*WORDS, "--seed", "1").out == gsp(*WORDS, "--seed", "1").out
    assert gsp(*WORDS, "--seed", "1").out != gsp(*WORDS, "--seed", "2").out


def test_picture(gsp, tmp_path: Path) -> None:
    path = tmp_path / "planes.svg"
    assert gsp(*WORDS, "-o", path).code == 0
    root = ElementTree.fromstring(path.read_text())
    assert root.tag.endswith("svg")
    assert root.attrib["viewBox"]


def test_an_interruption_shows_what_is_known(gsp, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(wanted: Sample, workers: Workers) -> Iterator[Tally]:
        del workers
        yield Sample(wanted.gsp_type, 7, one_sided=True).tally(0)
        raise KeyboardInterrupt

    monkeypatch.setattr(real_distribution, "tallies", interrupted)
    done = gsp("sample", "6PH", "--one-sided", "--count", "3000", "--format", "json")
    assert done.code == 130
    assert done.err == "interrupted after 7 of 3000 platforms\n"
    assert json.loads(done.out)["platforms"] == 7


def test_a_family_is_sampled_by_one_of_its_types(gsp) -> None:
    family = json.loads(gsp("sample", "3D3A PH PH PH", "--count", "20", "--format", "json").out)
    assert family["type"]["id"] == "DPH DPH DPH ALL ALL ALL"
    words = ("sample", family["type"]["id"], "--count", "20", "--format", "json")
    assert json.loads(gsp(*words).out) == family


@pytest.mark.parametrize("sides", [(), ("--one-sided",)])
def test_doubtful_platforms_are_kept(
    gsp, sides, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name, wanted = "DPP DPP DPH DHP ALL AHH", Sample(parse_type("2PP PH HP ALL AHH"), 3, 5)
    truth = replace(wanted, one_sided=bool(sides)).tally(0).real
    monkeypatch.setattr(real_distribution, "reality", lambda *_: Reality(np.zeros(0, bool), False))
    words = ("--count", "3", "--seed", "5", "--jobs", "1", "--save", tmp_path / "new", *sides)
    done = gsp("sample", name, *words, "--format", "json")
    assert (done.code, json.loads(done.out)["undecided"]) == (0, 3)
    found = Counter()
    for k in range(3):
        instance = load(tmp_path / "new" / f"undecided-5-0-{k}.yaml")
        assert instance.type == wanted.gsp_type
        found[solve(instance).counts.real] += 1
    assert found == truth


def test_errors(gsp, tmp_path: Path) -> None:
    done = gsp(*WORDS, "-o", tmp_path / "missing" / "x.csv")
    assert (done.code, done.out) == (2, "")
    assert "cannot be written" in done.err
    assert gsp("sample", "7PP").code == 2
    assert gsp("sample", "6PP", "--count", "0").code == 2
