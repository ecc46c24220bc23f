"""msolve: exact rational input, Groebner bases, real solutions isolated.

It is given the Study parameters with e0 = 1, seven equations in seven unknowns. The entries of R,
T, U and rho instead, with the relations among them, were in no case quicker.
"""

from __future__ import annotations

import ast
import re
import shutil
from pathlib import Path

import numpy as np
from sympy.polys.rings import PolyElement

from bench.homotopy import UNKNOWNS, blackbox_system
from bench.peers import Answer, no_answer
from bench.processes import run
from gspcli.geometry.instance import Instance

#: The virtual environment of the peers that come from PyPI.
PEERS = Path(__file__).resolve().parents[1] / "build" / "peers"
NAMES = ("e1", "e2", "e3", "f0", "f1", "f2", "f3")
_FRACTION = re.compile(r"(-?\d+) / 2\^(\d+)")


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


def written(system: list[PolyElement]) -> str:
    """Return the input file of exact polynomials, with integer coefficients."""
    rows = [str(row.clear_denoms()[1]).replace("**", "^") for row in system]
    return ",".join(NAMES) + "\n0\n" + ",\n".join(rows) + "\n"


def read(result: str, log: str, seconds: float) -> Answer:
    """Return the answer in an output file (the middles of the isolating boxes) and a log."""
    degree = re.search(r"deg. sqfr. elim. pol.\s+(\d+)", log)
    # Numerators and denominators have hundreds of digits; their quotients are floats.
    plain = _FRACTION.sub(lambda m: repr(int(m[1]) / 2 ** int(m[2])), result)
    dimension, (_, boxes) = ast.literal_eval(plain.strip().removesuffix(":"))
    if degree is None or dimension:
        return no_answer("not a finite number of solutions")
    middles = np.array(boxes, float).reshape(-1, UNKNOWNS, 2).mean(axis=2)
    return Answer(seconds, middles.astype(complex), int(degree[1]))
