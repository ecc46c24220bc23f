"""Platforms that are special but for rounding, against fkSGP: shipped machines, and sampled ones.

Each is solved first, with nothing kept of its geometry; then with other values; then in a batch.
fkSGP solves the same ones in turns, planar ones by its solver for these. The sampled ones are the
machines of six legs of `tests.support.realistic`, drawn at random as people write them.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from statistics import median

import numpy as np

from benchmarks import fksgp
from gspcli.catalogue.kinds import DPP
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.resources import data_path
from gspcli.solver import solve, solve_values
from gspcli.solver.result import SolveResult
from gspcli.solver.solved_starts import SolvedStarts
from gspcli.spec import load
from tests.support.realistic import machines

#: Shipped machines of six legs with poses far away, or of planar and symmetric bodies.
_MACHINES = ("t-top-head", "reachy-mini-head", "rubin-camera", "modified-paradex", "nano-hexapod")
#: This many machines are drawn, and in a quick run.
_DRAWN, _FEW = 60, 6
#: Values change by up to this part of them.
_SPREAD = 0.02
#: This many of them fkSGP solves.
_ASKED = 10
#: What the names of sampled machines begin with.
SAMPLED = "sampled"


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

    @property
    def seconds(self) -> tuple[float, float, float]:
        """The first solution, other values, a batch."""
        return self.first, self.others, self.batch


@dataclass(frozen=True)
class Line:
    """A line of the table: what `MachineResult.seconds` are, and how many times quicker that is."""

    name: str
    seconds: Sequence[float]
    ratios: Sequence[float]
    peer: float | None


def measure(seed: int, folder: Path | None, *, quick: bool) -> Iterator[MachineResult]:
    """Yield what is measured of each; `folder` is that of fkSGP, if there is a copy."""
    for name in _MACHINES:
        yield _machine(name, load(data_path("platforms", f"{name}.yaml")), seed, folder, quick)
    for machine in machines(_FEW if quick else _DRAWN, seed, rows=1):
        if {row.kind for row in machine.instance.constraints} == {DPP}:
            yield _machine(f"{SAMPLED} {machine.name}", machine.instance, seed, folder, quick=True)


def lines(results: Sequence[MachineResult]) -> Iterator[Line]:
    """Yield a line for each shipped machine, the median of the sampled ones, and the worst.

    The worst of each column is that of a machine of its own, as is the least ratio.
    """
    shipped = [x for x in results if not x.name.startswith(SAMPLED)]
    sampled = [x for x in results if x.name.startswith(SAMPLED)]
    for each in shipped:
        yield Line(each.name, each.seconds, [each.ratio(x) for x in each.seconds], each.peer)
    if not sampled:
        return
    seconds = list(zip(*(x.seconds for x in sampled), strict=True))
    ratios = list(zip(*([x.ratio(y) for y in x.seconds] for x in sampled), strict=True))
    peers = [x.peer for x in sampled if x.peer is not None]
    for name, slow, least in (("median", median, median), ("worst", max, min)):
        yield Line(
            f"{len(sampled)} {SAMPLED} machines, {name}",
            [slow(column) for column in seconds],
            [least(column) for column in ratios],
            slow(peers) if peers else None,
        )


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
