"""msolve: exact rational input, Groebner bases, real solutions isolated.

It is given the Study parameters with e0 = 1, seven equations in seven unknowns. The entries of R,
T, U and rho instead, with the relations among them, were in no case quicker.
"""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from benchmarks.homotopy import NAMES, blackbox_system
from benchmarks.peers import Answer, no_answer
from benchmarks.processes import run
from gspcli.errors import SpecError
from gspcli.export.answers import read_msolve
from gspcli.export.formats import msolve_input
from gspcli.export.polynomial_systems import Polynomial
from gspcli.geometry.instance import Instance

#: The virtual environment of the peers that come from PyPI.
PEERS = Path(__file__).resolve().parents[1] / "build" / "peers"


def executable() -> str:
    """Return the msolve that `make bench` installs, or that of the machine, or nothing."""
    found = PEERS.glob("lib/python*/site-packages/sage_wheels/bin/msolve")
    return next(map(str, found), shutil.which("msolve") or "")


def version(program: str) -> str:
    """Return the version of the program, or an empty string for an empty name."""
    if not program:
        return ""
    found = re.search(r"version (\S+)", run([program, "-h"]).output)
    return found[1] if found else "unknown"


def isolate(program: str, instance: Instance, folder: Path, limit: float) -> Answer:
    """Isolate the real solutions of an instance, and count the complex ones."""
    system, result = folder / "system.ms", folder / "result.ms"
    system.write_text(written(blackbox_system(instance)))
    result.unlink(missing_ok=True)
    done = run([program, "-v", "1", "-f", system, "-o", result], limit=limit)
    if done.trouble:
        return no_answer(done.trouble)
    log = done.output + done.errors
    (folder / "log.ms").write_text(log)
    return read(result.read_text(), log, done.cpu)


def written(system: list[Polynomial]) -> str:
    """Return the input file of exact polynomials, with integer coefficients."""
    return msolve_input(NAMES, (row.cleared for row in system), 0)


def read(result: str, log: str, seconds: float) -> Answer:
    """Return the answer in an output file (the middles of the isolating boxes) and a log."""
    degree = re.search(r"deg. sqfr. elim. pol.\s+(\d+)", log)
    try:
        points = read_msolve(result, "msolve")
    except SpecError as error:
        return no_answer(str(error))
    if degree is None:
        return no_answer("not a finite number of solutions")
    return Answer(seconds, points, int(degree[1]))
