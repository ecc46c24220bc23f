"""Macaulay2's NumericalAlgebraicGeometry: `trackHomotopy` from our start system.

The homotopy is given as straight-line programs that keep products as products. That is quicker
than `track`, which expands them (for six PL two times), and than `track` in projective space.
Only the tracking is timed, within the process; loading and building the programs is not.
"""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.homotopy import NAMES, UNKNOWNS, Homotopy, Product
from benchmarks.peers import Answer, no_answer
from benchmarks.processes import run
from gspcli.export.polynomial_systems import Style

STYLE = Style(imaginary="ii")
_SCRIPT = """needsPackage "NumericalAlgebraicGeometry";
R = CC[{names}];
t = inputGate "t";
F = {{
{rows}
}};
H = gateHomotopy(transpose gateMatrix{{F}}, gateMatrix{{getVarGates R}}, t);
P = {{{points}}};
before = cpuTime();
found = trackHomotopy(H, P);
<< "seconds " << toExternalString(cpuTime() - before) << endl;
scan(found, s -> << toString status s << " " << demark(" ", flatten apply(coordinates s,
    z -> {{toExternalString realPart z, toExternalString imaginaryPart z}})) << endl);
"""


def version() -> str:
    """Return the version, or an empty string if Macaulay2 is not installed."""
    return run(["M2", "--version"]).output.strip() if shutil.which("M2") else ""


def track(homotopy: Homotopy, folder: Path, limit: float) -> Answer:
    """Track the solutions of the start system to the instance."""
    path = folder / "track.m2"
    path.write_text(script(homotopy))
    done = run(["M2", "--script", path], limit=limit)
    (folder / "track.out").write_text(done.output)
    return no_answer(done.trouble) if done.trouble else read(done.output)


def script(homotopy: Homotopy) -> str:
    """Return the program for Macaulay2."""
    rows = [
        f"(1-t)*({_gates(start)}) + t*({_gates(target)})" if start != target else _gates(target)
        for start, target in zip(homotopy.start, homotopy.target, strict=True)
    ]
    points = ",\n".join(
        "point {{" + ",".join(_number(x) for x in point) + "}}" for point in homotopy.points
    )
    return _SCRIPT.format(names=",".join(NAMES), rows=",\n".join(rows), points=points)


def read(output: str) -> Answer:
    """Return the answer that the program has written."""
    lines = output.splitlines()
    seconds = next(_real(line.split()[1]) for line in lines if line.startswith("seconds"))
    rows = [line.split() for line in lines if re.match(r"[A-Z]\w+ ", line)]
    numbers = [[_real(word) for word in row[1:]] for row in rows if row[0] == "Regular"]
    pairs = np.array(numbers, float).reshape(-1, UNKNOWNS, 2)
    points: NDArray[np.complex128] = pairs[..., 0] + 1j * pairs[..., 1]
    return Answer(seconds, points)


def _gates(row: list[Product]) -> str:
    return " + ".join(
        "*".join(f"gatePolynomial({STYLE.written(factor)}_R)" for factor in pair.factors)
        for pair in row
    )


def _number(x: complex) -> str:
    return f"{x.real:.16e}+({x.imag:.16e})*ii"


def _real(word: str) -> float:
    """Return a number in Macaulay2's external form, such as ``-.25p53e-3``."""
    return float(re.sub(r"p\d+", "", word))
