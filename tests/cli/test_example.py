"""`gsp example`, and `@NAME` wherever a SPEC is expected."""

import json

import pytest

from gspcli.catalogue.names import parse_type
from gspcli.cli.main import run
from gspcli.resources import instance_files


def test_the_list_has_every_file_and_its_counts(capsys):
    assert run(["example", "--format", "json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["schema"] == "gsp.example/1"
    assert [entry["name"] for entry in document["files"]] == list(instance_files())
    entries = {entry["name"]: entry for entry in document["files"]}
    assert entries["dietmaier"]["real"] == entries["dietmaier"]["exact"] == 40
    assert entries["griffis-duffy"]["exact"] == "infinite"
    assert entries["sdss-primary"]["type"] == "2DPP 4DPH"
    assert entries["sdss-primary"]["group"] == "platform"
    for entry in entries.values():
        assert parse_type(entry["type"]).number == entry["number"]


def test_one_is_printed_with_the_schema_beside_it(capsys, tmp_path):
    """Only the address of the schema differs from the shipped file."""
    shipped = instance_files()["rubin-m2"].read_text(encoding="utf-8")
    text = shipped.replace("$schema=../instance", "$schema=instance")
    assert text != shipped
    assert run(["example", "rubin-m2"]) == 0
    assert capsys.readouterr().out == text
    copy = tmp_path / "mine.yaml"
    assert run(["example", "@rubin-m2", "-o", str(copy)]) == 0
    assert copy.read_text(encoding="utf-8") == text


@pytest.mark.parametrize(
    "words",
    [
        ["check", "@dietmaier"],
        ["solve", "@example-6.8"],
        ["show", "@dietmaier"],
        ["realize", "@sdss-primary"],
        ["bound", "@dietmaier"],
    ],
)
def test_a_name_stands_for_the_file(words, capsys):
    assert run(words) == 0
    assert capsys.readouterr().err == ""


def test_a_wrong_name_is_told(capsys):
    assert run(["solve", "@dietmeier"]) == 2
    assert capsys.readouterr().err == (
        "error: found no example or platform 'dietmeier': did you mean dietmaier? "
        "`gsp example` lists them\n"
    )


def test_the_list_is_no_yaml(capsys):
    assert run(["example", "--format", "yaml"]) == 2
    assert "give a NAME" in capsys.readouterr().err
