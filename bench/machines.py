"""Platforms that are special but for rounding, against fkSGP: machines and hexagons.

Each is solved first, with nothing kept of its geometry; then with other values; then in a batch.
fkSGP solves the same ones in turns, planar ones by its solver for these.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from statistics import median

import numpy as np

from bench import fksgp
from gspcli.geometry.building import hexapod
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.resources import data_path
from gspcli.solver import solve, solve_values
from gspcli.solver.result import SolveResult
from gspcli.solver.starts.solved_starts import SolvedStarts
from gspcli.spec import load

#: Shipped machines of six legs with poses far away, or of planar and symmetric bodies.
_MACHINES = ("t-top-head", "reachy-mini-head", "rubin-camera", "modified-paradex", "nano-hexapod")
#: Values change by up to this part of them.
_SPREAD = 0.02
#: So many of them fkSGP solves.
_ASKED = 10
FLOATS, DECIMALS = "hexagons of cos and sin", "hexagons of 3 decimals"


@dataclass(frozen=True)
class MachineResult:
    """Processor times of one solution in seconds; a batch for each set of values."""

    name: str
    first: float
    others: float
    batch: float
    peer: float | None
    """Of fkSGP."""

    def ratio(self, seconds: float) -> float:
        """How many times quicker than fkSGP that is; zero if that is not known."""
        return 0.0 if self.peer is None else self.peer / seconds


def hexagons(decimals: int | None) -> Instance:
    """Return regular hexagons, as NumPy computes them or rounded."""
    angles = np.radians([0, 20, 120, 140, 240, 260])
    ring = np.stack((np.cos(angles), np.sin(angles), 0 * angles), axis=1)
    base, top = 300 * ring, 200 * ring[[5, 0, 1, 2, 3, 4]]
    if decimals is not None:
        base, top = base.round(decimals), top.round(decimals)
    return hexapod(base, top, [250, 255] * 3)


def measure(seed: int, folder: Path | None, *, quick: bool) -> Iterator[MachineResult]:
    """Yield what is measured of each; `folder` is that of fkSGP, if there is a copy."""
    for name in _MACHINES:
        yield _machine(name, load(data_path("platforms", f"{name}.yaml")), seed, folder, quick)
    yield _machine(FLOATS, hexagons(None), seed, folder, quick)
    yield _machine(DECIMALS, hexagons(3), seed, folder, quick)


def _machine(
    name: str, instance: Instance, seed: int, folder: Path | None, quick: bool
) -> MachineResult:
    rng, starts = np.random.default_rng(seed), SolvedStarts()
    own = np.array([row.value.value for row in instance.constraints])
    rows = own * (1 + _SPREAD * rng.uniform(-1, 1, (64 if quick else 512, 6)))
    # The second solution of a geometry makes what is kept of it.
    _seconds(lambda: solve(instance, starts=starts))
    _seconds(lambda: solve(instance, starts=starts))
    first, others, peer = [], [], []
    for row in rows[: 10 if quick else 40]:
        other = instance.with_values(
            {i: Number.of(Fraction(x)) for i, x in enumerate(row.tolist())}
        )
        others.append(_seconds(lambda other=other: solve(other, starts=starts)))
        if len(first) < (3 if quick else 9):
            first.append(_seconds(lambda other=other: solve(other, starts=SolvedStarts())))
        if folder is not None and len(peer) < _ASKED:
            peer.append(fksgp.solve(folder, other, seed).seconds)
    list(solve_values(instance, rows, starts=starts))
    began = time.process_time()
    proved = sum(poses.proof is not None for poses in solve_values(instance, rows, starts=starts))
    batch = (time.process_time() - began) / len(rows)
    if proved < len(rows):
        sys.stderr.write(f"{name}: {len(rows) - proved} of {len(rows)} are incomplete\n")
    return MachineResult(name, median(first), median(others), batch, median(peer) if peer else None)


def _seconds(run: Callable[[], SolveResult]) -> float:
    began = time.process_time()
    result = run()
    taken = time.process_time() - began
    if result.proof is None or result.verdict != "complete":
        sys.stderr.write(f"{result.instance.name}: {result.verdict}, not proved\n")
    return taken
