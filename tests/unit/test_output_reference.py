"""The schemas in docs/schemas hold for other output than the runs that they were made from."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import jsonschema
import pytest

from gspcli.cli.main import run
from tools.build.samples import described, samples

ROOT = Path(__file__).resolve().parents[2]
SCHEMAS = ROOT / "docs" / "schemas"
OTHERS = [
    ["enumerate", "--class", "4D2A", "--only", "PL,LP,A"],
    ["show", "2000"],
    ["bound", "5D1A PP PP PP PP PL"],
    ["constraint", "DHP"],
    ["realize", "3000"],
    ["check", "@nano-hexapod", "@six-planes"],
    ["solve", "@six-planes", "--all"],
    ["solve", "@linuxcnc-hexapod"],
    ["solve", "@sdss-primary", "--all"],
    ["solve", "@rubin-m2", "--reading", "inclinometer = 0, 0 ± 0.1"],
    ["sensors", "@simscape-hexapod", "--random", "3"],
    ["analyze", "@platform-6-3"],
    ["count", "@no-real-pose"],
    ["count", "--type", "DPL DPL DLP ALL ALH AHH", "--geometry", "planar"],
    ["dynamics", "MASSES", "--mode", "1"],
    ["dynamics", "MASSES", "--mode", "2", "--modes"],
    ["clearance", "@figure-3", "--mode", "1"],
    ["clearance", "@t-top-head", "--of", "drives"],
    ["scan", "@platform-6-3", "--vary", "3=1.4:1.5:2", "--vary", "5=1.4:1.5:2"],
    ["workspace", "@workspace-study", "--shift", "x=1:2:2", "--connected"],
    ["workspace", "@workspace-study", "--over", "rx,ry", "--boxes", "--gap", "0.5"],
]


@pytest.mark.parametrize("words", OTHERS, ids=" ".join)
def test_other_output_has_the_published_form(
    words: list[str], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    page = (ROOT / "docs" / "dynamics.md").read_text(encoding="utf-8")
    masses = tmp_path / "masses.yaml"
    masses.write_text(re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)[0], encoding="utf-8")
    words = [str(masses) if word == "MASSES" else word for word in words]
    assert run([*words, "--format", "json"]) == 0
    document = json.loads(capsys.readouterr().out)
    form = document["schema"].removeprefix("gsp.").partition("/")[0]
    schema = json.loads((SCHEMAS / f"{form}.schema.json").read_text(encoding="utf-8"))
    assert schema["title"] == document["schema"]
    jsonschema.validate(document, schema)


def test_every_command_with_json_has_samples() -> None:
    for name, command in described().items():
        assert samples(name, command), f"no example of gsp {name} runs as it is: add to SAMPLES"


def test_every_form_of_the_code_has_a_schema() -> None:
    forms = set()
    for path in (ROOT / "gspcli").rglob("*.py"):
        forms |= set(re.findall(r'"gsp\.([a-z-]+)/\d+"', path.read_text(encoding="utf-8")))
    # Those of a list are made from its name; a scene is data within a page.
    published = {path.name.removesuffix(".schema.json") for path in SCHEMAS.glob("*.json")}
    assert forms - {"scene"} <= published


def test_the_page_is_up_to_date() -> None:
    command = [sys.executable, "-m", "tools.build.output_reference", "--check"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize(
    "path", sorted((ROOT / "data" / "keys").glob("*.json")), ids=lambda p: p.stem
)
def test_a_command_prints_its_keys_without_its_arguments(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    name = path.stem.replace("atlas-", "atlas ")
    assert run([*name.split(), "--keys"]) == 0
    printed = capsys.readouterr().out
    for form in json.loads(path.read_text(encoding="utf-8")):
        assert f"JSON {form['schema']}\n" in printed
        assert all(meaning for _, _, meaning in form["keys"])


def test_a_command_without_json_has_no_keys(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["view", "--keys"]) == 2
    assert "No such option" in capsys.readouterr().err
