"""Singular, a program for polynomial computations (Debian: ``apt-get install singular``)."""

from __future__ import annotations

import shutil
import subprocess
import sys
from functools import cache

from tools.recording import UNABLE

TIME_LIMIT_S = 3600


def run(program: str) -> str:
    """Return what a program prints."""
    _require()
    try:
        done = subprocess.run(
            ["Singular", "-q", "--no-rc"],
            input=program,
            capture_output=True,
            text=True,
            timeout=TIME_LIMIT_S,
            check=True,
        )
    except subprocess.TimeoutExpired:
        sys.stderr.write(f"Singular did not finish within {TIME_LIMIT_S} s\n")
        sys.exit(UNABLE)
    return done.stdout


@cache
def version() -> str:
    """Return the version of Singular."""
    _require()
    done = subprocess.run(["Singular", "--version"], capture_output=True, text=True, check=True)
    return done.stdout.split("version ")[1].split()[0]


@cache
def _require() -> None:
    """End this process if Singular is not installed."""
    if shutil.which("Singular") is None:
        sys.stderr.write(
            "Singular is not installed (Debian: apt-get install singular): nothing was computed\n"
        )
        sys.exit(UNABLE)
