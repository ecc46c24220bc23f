"""One random platform of each of the 896 families; `make verify-solve` takes ten."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
@pytest.mark.parametrize("run", [["platforms", "--count", "5000"], ["families", "--each", "1"]])
def test_random_platforms_are_solved_completely(run):
    command = [sys.executable, "-m", "tools.verify.solve", *run, "--no-record"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    assert done.stdout.endswith("0 with problems\n")
