"""PHCpack: `phc -b` (blackbox) and `phc -p` (parameter homotopy from our start system)."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.homotopy import (
    NAMES,
    UNKNOWNS,
    Homotopy,
    Product,
    blackbox_system,
    split_name,
    split_system,
    terms,
    written_product,
)
from benchmarks.peers import Answer, no_answer
from benchmarks.processes import run
from gspcli.export.answers import read_phcpack
from gspcli.export.formats import phcpack_input
from gspcli.export.polynomial_systems import Style
from gspcli.geometry.instance import Instance

_RULE = "=" * 75


STYLE = Style(exponent="E")


def version() -> str:
    """Return the version, or an empty string if PHCpack is not installed."""
    if shutil.which("phc") is None:
        return ""
    found = re.search(r"PHCv(\S+)", run(["phc", "--version"]).output)
    return found[1] if found else "unknown"


def blackbox(instance: Instance, folder: Path, limit: float, *, split: bool = False) -> Answer:
    """Solve an instance with nothing but its equations, products split if it is said."""
    system, result = folder / "system", folder / "result"
    if split:
        rows = split_system(instance)
    else:
        exact = blackbox_system(instance)
        rows = [terms(row, 1 / max(map(abs, map(float, row.terms.values())))) for row in exact]
    _fresh(result)
    system.write_text(phcpack_input(STYLE.written(row) for row in rows))
    done = run(["phc", "-b", system, result], limit=limit)
    if done.trouble:
        return no_answer(done.trouble)
    # The solutions are appended to the input.
    return Answer(done.cpu, read_solutions(system.read_text(), len(rows))[:, :UNKNOWNS])


def parameter_homotopy(homotopy: Homotopy, folder: Path, limit: float) -> Answer:
    """Track the solutions of the start system to the instance."""
    names = ("target", "output", "start", "solutions")
    target, result, start, solutions = (folder / name for name in names)
    for path, rows in ((target, homotopy.target), (start, homotopy.start)):
        path.write_text(phcpack_input(map(written_sum, rows)))
    solutions.write_text(written_solutions(homotopy.points))
    _fresh(result)
    # Homotopy of degree 1 in t (quicker here than the default 2), then the defaults of all menus.
    answers = [target, result, "n", start, solutions, "k", 1, 0, 0, 0, 0]
    done = run(["phc", "-p"], stdin="\n".join(map(str, answers)) + "\n", limit=limit)
    if done.trouble:
        return no_answer(done.trouble)
    text = result.read_text().rpartition("THE SOLUTIONS")[2]
    return Answer(done.cpu, read_solutions(text))


def written_sum(row: list[Product]) -> str:
    """Return the text of a sum of products."""
    return "+".join(written_product(STYLE, pair) for pair in row)


def read_solutions(text: str, unknowns: int = UNKNOWNS) -> NDArray[np.complex128]:
    """Return the solutions in PHCpack's format, shape (n, unknowns).

    A path that was given up is listed as well, with the point where it was left.
    """
    names, points = read_phcpack(text)
    return points.reshape(-1, unknowns)[:, np.argsort([*map(_position, names)])]


def _position(name: str) -> int:
    """Return the column of an unknown, also of the recorded answers with x1, x2, ..."""
    if name in NAMES:
        return NAMES.index(name)
    return (UNKNOWNS if name.startswith(split_name(0)[0]) else 0) + int(name[1:]) - 1


def written_solutions(points: NDArray[np.complex128]) -> str:
    """Return solutions in PHCpack's format."""
    text = f"{len(points)} {UNKNOWNS}\n{_RULE}\n"
    for number, point in enumerate(points, start=1):
        text += f"solution {number} :\nt : 0.0E+00 0.0E+00\nm : 1\nthe solution for t :\n"
        for name, x in zip(NAMES, point, strict=True):
            text += f" {name} : {x.real:.16E} {x.imag:.16E}\n"
        text += "== err : 0.0E+00 = rco : 1.0E+00 = res : 0.0E+00 ==\n"
    return text


def _fresh(path: Path) -> None:
    # PHCpack asks before it overwrites.
    path.unlink(missing_ok=True)
