"""Fixtures for all tests."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest
from hypothesis import settings

settings.register_profile("gsp", deadline=None, derandomize=True, max_examples=50)
settings.load_profile("gsp")


# A program for LinuxCNC's own Python, which is run there.
collect_ignore = ["support/linuxcnc/sim.py"]

# `tests.support`, `tools` and `viewer` are found there; the package is the installed one.
sys.path.append(str(Path(__file__).resolve().parents[1]))


@dataclass(frozen=True)
class Outcome:
    """What a run of the command line gave."""

    code: int
    out: str
    err: str


@pytest.fixture
def gsp(capsys: pytest.CaptureFixture[str]) -> Callable[..., Outcome]:
    """Run `gsp` in this process: `gsp("bound", "3D3A PL PL LP").out`."""
    from gspcli.cli.main import run

    def call(*arguments: str) -> Outcome:
        capsys.readouterr()
        code = run([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return Outcome(code, captured.out, captured.err)

    return call
