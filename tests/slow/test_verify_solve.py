"""One random platform of each of the 896 families; `make verify-solve` takes ten."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

TOOL = Path(__file__).parents[2] / "tools" / "verify_solve.py"


@pytest.mark.slow
@pytest.mark.parametrize("run", [["platforms", "--count", "5000"], ["families", "--each", "1"]])
def test_random_platforms_are_solved_completely(run):
    done = subprocess.run(
        [sys.executable, str(TOOL), *run, "--no-record"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.endswith("0 with problems\n")
