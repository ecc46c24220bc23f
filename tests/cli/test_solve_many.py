"""`gsp solve` of many instances: an answer for each, in their order, even if one fails."""

from __future__ import annotations

import csv
import json

import pytest
import yaml

from gspcli.resources import instance_files

NAMES = ["octahedral-3-3", "griffis-duffy", "no-real-pose", "octahedral-3-3"]


def lines_of(names):
    texts = [instance_files()[name].read_text(encoding="utf-8") for name in names]
    return "".join(json.dumps(yaml.safe_load(text)) + "\n" for text in texts)


@pytest.fixture
def instances(tmp_path):
    path = tmp_path / "instances.jsonl"
    path.write_text(lines_of(NAMES), encoding="utf-8")
    return path


def answers(run):
    return [json.loads(line) for line in run.out.splitlines()]


def test_a_row_for_each_file(gsp):
    run = gsp("solve", *(f"@{name}" for name in NAMES), "--format", "csv")
    rows = [row[:1] + row[3:8] for row in csv.reader(run.out.splitlines())]
    assert run.code == 3
    assert [row[0] for row in rows[1:]] == [f"@{name}" for name in NAMES]
    assert rows[1] == rows[4] == ["@octahedral-3-3", "4", "16", "16", "complete", "0"]
    assert rows[2][4:] == ["infinite", "3"]
    assert rows[3][1:] == ["0", "40", "40", "complete", "0"]


def test_a_document_in_each_line_is_that_of_one_instance(gsp, instances):
    run = gsp("solve", instances, "--format", "jsonl", "--all")
    documents = answers(run)
    assert run.code == 3
    assert "4 instances: 3 complete, 1 infinitely many poses" in run.err
    assert [one["instance"] for one in documents] == [
        f"{instances}, line {k}" for k in range(1, len(NAMES) + 1)
    ]
    assert [one["exit_code"] for one in documents] == [0, 3, 0, 0]
    for name, found in zip(NAMES, documents, strict=True):
        alone = json.loads(gsp("solve", f"@{name}", "--all", "--format", "json").out)
        assert {key: found[key] for key in alone} == alone
    assert "infinitely many" in documents[1]["message"]


def test_standard_input_and_processes_change_nothing(gsp, instances, monkeypatch, tmp_path):
    many = lines_of(["octahedral-3-3"] * 18 + ["no-real-pose"])
    instances.write_text(many, encoding="utf-8")
    one = gsp("solve", instances, "--format", "jsonl", "--jobs", "1")
    two = gsp("solve", instances, "--format", "jsonl", "--jobs", "2")
    assert (one.code, one.out, one.err) == (two.code, two.out, two.err)
    assert len(answers(one)) == 19
    path = tmp_path / "a.jsonl"
    gsp("solve", instances, "-o", path)
    assert path.read_text(encoding="utf-8") == one.out


def test_what_is_wrong_with_one_stops_no_other(gsp, instances):
    text = lines_of(["octahedral-3-3"])
    wrong = '{"gsp": 1, "units": 3}\nhello\n\n\x00\n'
    instances.write_bytes((text + wrong + text).encode() + b"\xff\n" + text.encode())
    run = gsp("solve", instances, "--format", "jsonl")
    assert run.code == 2
    documents = answers(run)
    assert [one["exit_code"] for one in documents] == [0, 2, 2, 2, 0, 2, 0]
    assert f"{instances}, line 2:1:21: units: found '3'" in documents[1]["message"]
    assert set(documents[1]) == {"instance", "exit_code", "message"}
    missing = gsp("solve", "@octahedral-3-3", "nothing-there.yaml", "--format", "csv")
    assert missing.code == 2
    assert "nothing-there.yaml" in missing.out.splitlines()[2]


def test_changes_and_options_are_for_all(gsp, instances):
    instances.write_text(lines_of(["octahedral-3-3"] * 2), encoding="utf-8")
    both = answers(gsp("solve", instances, "--set", "1=1.1", "--format", "jsonl"))
    alone = json.loads(gsp("solve", "@octahedral-3-3", "--set", "1=1.1", "--format", "json").out)
    assert all(one["solutions"] == alone["solutions"] for one in both)
    run = gsp("solve", instances, "--near", "0,0,1,1,0,0,0", "--legend")
    assert run.code == 2
    assert "--near and --legend: for one SPEC" in run.err
    assert gsp("solve", "-", "-").code == 2
    empty = instances.with_name("empty.jsonl")
    empty.write_text("\n", encoding="utf-8")
    assert "found no instance" in gsp("solve", empty).err
    assert gsp("solve", empty.with_name("none.jsonl")).code == 2


def test_standard_input(gsp, monkeypatch):
    import subprocess
    import sys

    run = subprocess.run(
        [sys.executable, "-m", "gspcli", "solve", "--lines", "-", "--format", "jsonl"],
        input=lines_of(["octahedral-3-3"]), capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert json.loads(run.stdout)["instance"] == "standard input, line 1"


@pytest.mark.parametrize(
    ("word", "meant"),
    [("figure-3", "@figure-3"), ("Dietmaier.yaml", "@dietmaier"), ("hexa.yml", "hexa.yaml"),
     ("hexas.yaml", "hexa.yaml")],
)  # fmt: skip
def test_what_was_perhaps_meant_by_a_missing_file(gsp, tmp_path, monkeypatch, word, meant):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "hexa.yaml").write_text("gsp: 1\n")
    for command in ("solve", "check", "analyze"):
        run = gsp(command, word)
        assert run.code == 2
        assert run.err == f"error: {word}: there is no such file: did you mean {meant}?\n"
