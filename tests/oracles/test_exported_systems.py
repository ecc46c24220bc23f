"""Exported systems in the programs they are for: as many poses as the solver finds, all certified.

The platforms have short rational coefficients (`benchmarks.cases.random_instances`).
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from benchmarks import msolve
from benchmarks.cases import random_instances
from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.names import parse_type
from gspcli.catalogue.types import all_types
from gspcli.certification import Certificates, certify
from gspcli.export.answers import read_answer, read_candidates
from gspcli.export.formats import FORMATS
from gspcli.export.polynomial_systems import MOTIONS, system
from gspcli.geometry.instance import Instance
from gspcli.resources import data_path
from gspcli.solver import SolveResult, solve
from gspcli.spec import load
from tools.atlas.groebner import msolve_path

MSOLVE = msolve_path() or msolve.executable()
SEED = 3
LIMIT_S = 60
#: One type with each kind of distance, and with each kind of angle.
SAMPLE = ["DPP DPH DHP ALL ALH AHH", "DPL DPH DPH AHL ALL ALL", "DLL DPH DHP DHP ALL ALH"]
SAMPLE += ["DLP DPH DPH DHP DHP ALL"]
#: Planes and angles only: a second for programs that are slow with more.
QUICK = "DPH DPH DPH ALL ALL AHH"
MODULO = 2003
SMALL = 16


def _random_types(count: int) -> list[str]:
    """Return random types that computer algebra can solve in time."""
    small = [t for t in all_types() if generic_counts(t).one_sided <= SMALL]
    chosen = np.random.default_rng(MODULO).choice(len(small), count, replace=False)
    return [small[k].id for k in sorted(chosen)]


@cache
def _solved(name: str) -> tuple[Instance, SolveResult]:
    instance = next(random_instances(name, SEED))
    return instance, solve(instance)


def _run(command: list[str | Path], folder: Path) -> str:
    """Return what a program prints; skip if it does not end in time."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    try:
        done = subprocess.run(
            command, cwd=folder, capture_output=True, text=True, timeout=LIMIT_S, env=environment
        )
    except subprocess.TimeoutExpired:
        pytest.skip(f"{command[0]} takes more than {LIMIT_S} s")
    assert done.returncode == 0, done.stderr[-500:]
    return done.stdout


def _msolve(path: Path) -> str:
    _run([str(MSOLVE), "-f", path.name, "-o", "answer"], path.parent)
    return (path.parent / "answer").read_text(encoding="utf-8")


def _phcpack(path: Path) -> str:
    _run(["phc", "-b", path.name, "answer"], path.parent)
    # The solutions are appended to the input.
    return path.read_text(encoding="utf-8")


def _macaulay2(path: Path) -> str:
    return _run(["M2", "--script", path.name], path.parent)


def _singular(path: Path) -> str:
    return _run(["Singular", "-q", "--no-rc", path.name], path.parent)


#: How to run a program, whether it is here, and the coordinates that suit it.
RUNS: dict[str, tuple[Callable[[Path], str], bool, str]] = {
    "msolve": (_msolve, bool(MSOLVE), "study-affine"),
    "phcpack": (_phcpack, bool(shutil.which("phc")), "study-affine"),
    "macaulay2": (_macaulay2, bool(shutil.which("M2")), "rt"),
    "singular": (_singular, bool(shutil.which("Singular")), "rt"),
}


def _answered(name: str, program: str, coordinates: str, folder: Path) -> tuple[str, Certificates]:
    instance, _ = _solved(name)
    run, present, _ = RUNS[program]
    if not present:
        pytest.skip(f"{program} is not installed")
    path = folder / "system"
    text = FORMATS[program].write(system(instance, MOTIONS[coordinates]()), 40)
    path.write_text(text, encoding="utf-8")
    answer = run(path)
    found = read_answer(answer, program) or read_candidates(answer, program)
    return answer, certify(instance, found.R, found.T)


def _check(name: str, program: str, coordinates: str, folder: Path) -> None:
    _, result = _solved(name)
    answer, proved = _answered(name, program, coordinates, folder)
    twice = 2 if coordinates == "study" else 1
    assert result.counts.found == result.expected == generic_counts(parse_type(name)).one_sided
    if program == "msolve":
        # The real ones only.
        assert proved.certified == proved.distinct == result.counts.real
        return
    if program in ("macaulay2", "singular"):
        assert f"# dimension 0, degree {twice * result.expected}\n" in answer
    assert proved.distinct == result.expected
    assert proved.real == result.counts.real


@pytest.mark.parametrize("name", SAMPLE)
def test_msolve_finds_what_the_solver_finds(name: str, tmp_path: Path) -> None:
    _check(name, "msolve", RUNS["msolve"][2], tmp_path)


@pytest.mark.parametrize("program", ["phcpack", "macaulay2", "singular"])
def test_programs_find_what_the_solver_finds(program: str, tmp_path: Path) -> None:
    _check(QUICK, program, RUNS[program][2], tmp_path)


@pytest.mark.parametrize("coordinates", MOTIONS)
def test_all_coordinates_have_the_same_poses(coordinates: str, tmp_path: Path) -> None:
    _check(SAMPLE[0], "msolve", coordinates, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("program", RUNS)
@pytest.mark.parametrize("name", _random_types(50))
def test_fifty_types_have_equal_counts(name: str, program: str, tmp_path: Path) -> None:
    _check(name, program, RUNS[program][2], tmp_path)


def test_sympy_reads_the_exact_system(tmp_path: Path) -> None:
    """A pose of an instance with square roots and cosines satisfies it."""
    instance = load(data_path("examples", "surfaces-pps.yaml"))
    text = FORMATS["sympy"].write(system(instance, MOTIONS["rt"]()), 40)
    (tmp_path / "system.py").write_text(text, encoding="utf-8")
    pose = solve(instance).real_solutions[0]
    values = [*pose.R.real.ravel().tolist(), *pose.T.real.tolist()]
    code = (
        "from sympy import lambdify\n"
        "from system import system, unknowns\n"
        f"found = lambdify(unknowns, system)(*{values})\n"
        "print(len(system), max(map(abs, found)))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    count, worst = done.stdout.split()
    assert count == "12"
    assert float(worst) < 1e-12
