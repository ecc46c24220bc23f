"""What the shell completes, by the words that click's scripts are given."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from click.shell_completion import ShellComplete

from gspcli.catalogue.kinds import KINDS
from gspcli.cli.main import cli


def _completed(line: str) -> list[str]:
    """Return what a line with the word to complete at its end can become; files as <file>."""
    _, *words, incomplete = line.split(" ")
    items = ShellComplete(cli, {}, "gsp", "_GSP_COMPLETE").get_completions(words, incomplete)
    return [item.value if item.type == "plain" else f"<{item.type}>" for item in items]


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("gsp sol", ["solve"]),
        ("gsp solve @diet", ["@dietmaier"]),
        ("gsp solve plat", ["<file>"]),
        ("gsp check a.yaml @six", ["@six-planes"]),
        ("gsp show hex", ["hexapod"]),
        ("gsp show DL", ["DLP", "DLL"]),
        ("gsp bound 3d", ["3D3A"]),
        ("gsp realize D", ["<file>", *(kind.name for kind in KINDS if kind.is_distance)]),
        ("gsp enumerate --only PL,AH", ["PL,AHL", "PL,AHH"]),
        ("gsp enumerate --class 5", ["5D1A"]),
        ("gsp enumerate --columns id,gen", ["id,generic_one_sided", "id,generic_two_sided"]),
        ("gsp solve x.yaml --rotation Z", ["ZXY", "ZYX"]),
        ("gsp analyze x.yaml p", ["<file>"]),
        ("gsp track x.yaml v", ["<file>"]),
        ("gsp measure x.yaml p.csv --require range,cond", ["range,condition"]),
        ("gsp solve x.yaml --format j", ["json", "jsonl"]),
        ("gsp solve x.yaml -o p", ["<file>"]),
        ("gsp example fix", ["fixture-3-2-1"]),
        ("gsp bound --part b", ["bounds"]),
        ("gsp atlas ver", ["verify"]),
        ("gsp atlas build --folder d", ["<dir>"]),
    ],
)
def test_completions(line: str, expected: list[str]) -> None:
    assert _completed(line) == expected


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
def test_bash_completes() -> None:
    script = """
eval "$(_GSP_COMPLETE=bash_source gsp)"
COMP_WORDS=(gsp solve @diet) COMP_CWORD=2
_gsp_completion gsp
echo "${COMPREPLY[*]}"
"""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    run = subprocess.run(
        ["bash", "-c", script],
        env={**os.environ, "PATH": path},
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout == "@dietmaier\n"
