"""fkSGP (E. Martyushev, 2025; MIT licence): 6-6 platforms by an elimination template, in process.

A public Python program, not on PyPI: ``--peer fksgp=FOLDER`` says where a copy of it is.
It gives complex poses, or the real ones by what rounding leaves of imaginary parts; the quicker of
the two, the latter, is timed. Nothing is proved, and its random rotations are seeded here.
"""

from __future__ import annotations

import hashlib
import sys
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from statistics import median
from types import ModuleType
from typing import Any

import numpy as np

from benchmarks.cases import Case
from benchmarks.peers import Answer, no_answer
from gspcli.catalogue.kinds import DPP
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import study_from_pose

NAME = "fkSGP"
#: An instance is solved this often; the median counts.
_TIMES = 5
#: Its function for any six legs, and the one for planar bodies, by the modules they are in.
_GENERAL, _PLANAR = "solver66", "solver6p6p"

Solver = Callable[[Any, Any, Any, int], tuple[Any, Any]]


def version(folder: Path | None) -> str:
    """Return what identifies a copy, or an empty string if there is none."""
    source = folder / "python" / f"{_GENERAL}.py" if folder else None
    if source is None or not source.is_file():
        return ""
    return f"sha256 {hashlib.sha256(source.read_bytes()).hexdigest()[:12]}"


def can(case: Case) -> bool:
    """Whether it can solve the instances of a case: platforms with six legs."""
    return set(case.draw(0, 1)[0].type.kinds) == {DPP}


def solve(folder: Path, instance: Instance, seed: int) -> Answer:
    """Solve an instance."""
    arrangement = Arrangement.of(instance)
    # Both bodies begin at their first point.
    base, platform = arrangement.x - arrangement.x[0], arrangement.y - arrangement.y[0]
    planar = not (base[:, 2].any() or platform[:, 2].any())
    solver = _solver(folder, _PLANAR if planar else _GENERAL)
    squares = arrangement.values**2
    # Its random rotations come from NumPy's global generator.
    np.random.seed(seed)  # noqa: NPY002
    times = []
    for _ in range(_TIMES):
        began = time.process_time()
        solver(base, platform, squares, 1)
        times.append(time.process_time() - began)
    found = solver(base, platform, squares, 0)[0]
    if not np.isfinite(found).all():
        return no_answer("not a number")
    R, t = found[:, :, :3], found[:, :, 3]
    T = t + arrangement.x[0] - R @ arrangement.y[0]
    e, f = study_from_pose(R, T)
    points = np.concatenate((e, f), axis=1)
    return Answer(median(times), points[:, 1:] / points[:, :1])


def _solver(folder: Path, name: str) -> Solver:
    """Return a function of it, loaded without the package's own imports, which need Python 3.12."""
    package = "_fksgp"
    if package not in sys.modules:
        module = ModuleType(package)
        module.__path__ = [str(folder / "python")]
        sys.modules[package] = module
    solver: Solver = getattr(import_module(f"{package}.{name}"), name)
    return solver
