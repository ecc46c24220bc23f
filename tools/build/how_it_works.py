"""Rebuild the drawing of docs/how-it-works.md: the paths to the eight poses of a platform.

    python -m tools.build.how_it_works [--check]

Another version of matplotlib may write other bytes for the same drawing.
"""

from __future__ import annotations

import io
import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from gspcli.continuation.endpoints import random_start
from gspcli.continuation.start import start_system
from gspcli.continuation.systems import System
from gspcli.continuation.tracker import track
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import normalized
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.solver.problem import Problem
from gspcli.spec import load
from tools.recording import ROOT, parser, save

IMAGES = ROOT / "docs" / "images"
#: The platform: six points on six planes.
NAME = "six-planes"
#: Points of each path that are drawn; the seed with the shortest paths of forty.
STEPS, SEED = 200, 11
GREY, BLUE, ORANGE = "#9aa3ad", "#0072b2", "#d55e00"


def coordinate(points: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return the coordinate that is drawn: the quotient e3 / e1 of a quaternion, (..., 4 or 8)."""
    return np.asarray(points[..., 3] / points[..., 1])


def paths(instance: Instance) -> NDArray[np.complex128]:
    """Return the coordinate along all paths of a platform, shape (STEPS + 1, paths)."""
    given = Problem(instance).systems[0].canonical()
    structure, (balanced, _) = given.structure, given.coefficients.balanced()
    target, start = System(structure, balanced), start_system(structure)
    origin, points = random_start(start, seed=SEED, attempt=0), start.points
    rows = [coordinate(points)]
    for step in range(STEPS):
        here, there = (origin.towards(target, (step + k) / STEPS) for k in (0, 1))
        points = normalized(track(here, there, points).points[0])
        rows.append(coordinate(points))
    return np.array(rows)


def drawn(figure: Figure) -> bytes:
    """Return a figure as SVG, the same bytes each time."""
    out = io.BytesIO()
    with mpl.rc_context({"svg.hashsalt": "gsp", "svg.fonttype": "path"}):
        figure.savefig(out, format="svg", metadata={"Date": None})
    return out.getvalue()


def plane() -> Figure:
    """Return an empty complex plane."""
    figure = Figure(figsize=(6.4, 5.2), layout="constrained")
    axes = figure.subplots()
    axes.set_aspect("equal")
    axes.axhline(0, color=GREY, linewidth=0.8)
    axes.set_xlabel("real part")
    axes.set_ylabel("imaginary part")
    axes.spines[["top", "right"]].set_visible(False)
    return figure


def path_picture(instance: Instance) -> bytes:
    """Draw the paths from a solved platform to this one."""
    lines, real = paths(instance), coordinate_of_modes(instance)
    figure = plane()
    (axes,) = figure.axes
    axes.plot(lines.real, lines.imag, color=GREY, linewidth=0.8)
    ends, starts = lines[-1], lines[0]
    is_real = np.abs(ends[:, None] - real).min(axis=1) < 1e-6
    axes.plot(starts.real, starts.imag, "o", color="white", markeredgecolor=GREY, markersize=4)
    axes.plot(ends[~is_real].real, ends[~is_real].imag, "o", color=BLUE, markersize=4)
    axes.plot(ends[is_real].real, ends[is_real].imag, "D", color=ORANGE, markersize=7)
    return drawn(figure)


def coordinate_of_modes(instance: Instance) -> NDArray[np.complex128]:
    """Return the coordinate of the real poses."""
    quaternions = np.array([one.quaternion for one in solve(instance).real_solutions])
    return coordinate(quaternions)


def main() -> int:
    """Write the drawings, or compare them with those on record."""
    arguments = parser(__doc__).parse_args()
    instance = load(instance_files()[NAME])
    files: dict[Path, str | bytes] = {
        IMAGES / "paths.svg": path_picture(instance),
    }
    return save(files, check=arguments.check, confirmed="the paths")


if __name__ == "__main__":
    sys.exit(main())
