"""The schemas in docs/schemas hold for other output than the runs that they were made from."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import jsonschema
import pytest

from gspcli.cli.main import COMMANDS, run

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
    ["analyze", "@platform-6-3"],
]
#: Commands that print no table: they write files, or are asked one thing at a time.
WITHOUT = {"new", "count", "export", "maximize-real", "view", "clearance", "scan"}


@pytest.mark.parametrize("words", OTHERS, ids=" ".join)
def test_other_output_has_the_published_form(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    schema = json.loads((SCHEMAS / f"{words[0]}.schema.json").read_text(encoding="utf-8"))
    assert run([*words, "--format", "json"]) == 0
    jsonschema.validate(json.loads(capsys.readouterr().out), schema)


def test_every_command_is_described() -> None:
    described = {path.name.partition(".")[0].partition("-")[0] for path in SCHEMAS.glob("*.json")}
    assert set(COMMANDS) - WITHOUT <= described


def test_the_page_is_up_to_date() -> None:
    tool = ROOT / "tools" / "build_output_reference.py"
    done = subprocess.run(
        [sys.executable, str(tool), "--check"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
