"""The page on calibration: every command runs, and says what the page says that it says."""

from __future__ import annotations

import re
import shlex
import shutil
from pathlib import Path

import pytest

from gspcli.cli.main import run

DOCS = Path(__file__).resolve().parents[3] / "docs"


def test_every_command_of_the_page_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for path in (DOCS / "calibration").glob("*.csv"):
        shutil.copy(path, tmp_path)
    monkeypatch.chdir(tmp_path)
    page = (DOCS / "calibrate.md").read_text(encoding="utf-8")
    said, refused = "", 0
    lines = re.findall(r"^ {4}\$ gsp (.*)$", page, re.MULTILINE)
    assert len(lines) >= 8
    for line in lines:
        code = run(shlex.split(line))
        printed = capsys.readouterr()
        said += printed.out + printed.err
        doubted = "measured.csv" in line and not re.search(r"--robust|-o wrong", line)
        expected = 4 if "level.csv" in line else 1 if doubted else 0
        assert code == expected, (line, printed.err)
        refused += code == 4
    assert refused == 1
    assert "the data do not fit: chi-squared is 2146 of 102" in said
    assert "16 of 3000 poses within ranges and cones" in said
    assert "lengths to 0.014 mm (median), offset.5 to 0.04" in said
    assert "chi-squared 2146 of 102 degrees of freedom" in said
    assert re.search(r"worst row: 8, 11\d\d of chi-squared \(80\.\d* of 96 without it\)", said)
    assert "tell at most 24, however many" in said
    calibrated = Path("calibrated.yaml").read_text(encoding="utf-8")
    assert calibrated.count(", offset: ") == 6
    assert calibrated.count("# ± ") == 12
