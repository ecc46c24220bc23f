"""The Python that pages show without output runs: `>>>` examples are run by doctest."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import gspcli
from docs._ext.shown_commands import pages
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.resources import instance_files
from tools.recording import ROOT

MEASURED = ROOT / "docs" / "calibration" / "measured.csv"
#: The page whose model of a machine stands for the file of the reader.
IMPORTED = (ROOT / "docs" / "import.md").read_text("utf-8")

#: Run by a test of its own, with what it prints.
ELSEWHERE = {"dynamics.md"}
BLOCKS = [
    pytest.param(block, id=f"{page.name}-{number}")
    for page in pages()
    if page.name not in ELSEWHERE
    for number, block in enumerate(
        re.findall(r"^```python\n(.*?)^```$", page.read_text("utf-8"), re.DOTALL | re.MULTILINE), 1
    )
]
#: What stands for the files of the reader.
FILES = {
    "platform.yaml": "figure-3",
    "hexapod.yaml": "rubin-m2",
    "machine.yaml": "workspace-study-cones",
    "mine.yaml": "rubin-m2",
}


@pytest.mark.parametrize("block", BLOCKS)
def test_a_block_runs(block: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name, machine in FILES.items():
        Path(name).write_text(instance_files()[machine].read_text("utf-8"), encoding="utf-8")
    model = re.search(r"^```xml\n(.*?)^```$", IMPORTED, re.DOTALL | re.MULTILINE)
    assert model is not None
    Path("robot.xml").write_text(model[1], encoding="utf-8")
    log = MEASURED.with_name("controller-log.csv")
    Path(log.name).write_text(log.read_text("utf-8"), encoding="utf-8")
    exec(block, _measured() if "calibrate" in block else _found())


def _found() -> dict[str, object]:
    """Return what a page has said before: an instance, its poses and their values."""
    instance = gspcli.load(instance_files()[FILES["platform.yaml"]])
    found = gspcli.solve(instance)
    R, T = found.R[found.real].real, found.T[found.real].real
    return {"instance": instance, "R": R, "T": T, "values": np.abs(gspcli.measure(instance, R, T))}


def _measured() -> dict[str, object]:
    """Return the measurements that the page on calibration has as a file."""
    rows = np.loadtxt(MEASURED, delimiter=",", skiprows=2)
    R = rotation_from_quaternion(rows[:, 10:14])
    return {"values": rows[:, 1:7], "R": R, "T": rows[:, 7:10]}


def test_pages_have_blocks() -> None:
    assert len(BLOCKS) >= 7
