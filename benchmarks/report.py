"""The page of results: what was measured as Markdown, with how to repeat it."""

from __future__ import annotations

import os
import platform
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import date
from math import log10
from pathlib import Path
from statistics import median

import numpy as np

from benchmarks.cases import CASES, Case
from benchmarks.machines import MachineResult, lines
from benchmarks.markdown import duration, number, table
from benchmarks.own import Shell, Throughput
from benchmarks.peers import Comparison
from benchmarks.sweep import Cost
from gspcli import __version__, _kernel


@dataclass(frozen=True)
class PeerResult:
    """What a peer did on the instances of a case."""

    seconds: list[float]
    comparisons: list[Comparison]
    trouble: str
    """Why it was not asked on, or empty."""


@dataclass
class CaseResult:
    """What was measured of a case; `peers` is filled in peer by peer."""

    case: Case
    expected: int
    found: list[int]
    real: list[int]
    seconds: float
    peers: dict[str, PeerResult] = field(default_factory=dict)


@dataclass(frozen=True)
class Bar:
    """How many times slower a peer is, beside the least required."""

    name: str
    wanted: float
    measured: float

    @property
    def met(self) -> bool:
        """Whether the measure is at least the required one."""
        return self.measured >= self.wanted

    @property
    def cells(self) -> list[str]:
        """The name, the required ratio, the measured one, and whether it is met."""
        wanted, measured = (f"{number(x)} times" for x in (self.wanted, self.measured))
        return [self.name, f"≥ {wanted}", measured, "met" if self.met else "**missed**"]

    def __str__(self) -> str:
        return "  ".join(self.cells).replace("**", "")


@dataclass
class Report:
    """Everything that a run has measured so far."""

    seed: int
    limit: float
    quick: bool
    versions: dict[str, str]
    cases: list[CaseResult] = field(default_factory=list)
    machines: list[MachineResult] = field(default_factory=list)
    throughputs: list[Throughput] = field(default_factory=list)
    dietmaier: Shell | None = None
    large: dict[str, Shell] = field(default_factory=dict)
    sweep: list[Cost] = field(default_factory=list)
    sweep_memory: float = 0.0
    bars: list[Bar] = field(default_factory=list)

    def markdown(self) -> str:
        """Return the whole page."""
        split = " and ".join(case.key for case in CASES if case.split)
        sections = [self._head(), self._bars(), self._peers(), self._machines(), self._batches()]
        sections += [self._shell(), self._sweep(), _FORMULATIONS.format(split=split)]
        return "\n".join(section for section in sections if section)

    def _head(self) -> str:
        peers = {name.split()[0]: version for name, version in self.versions.items() if version}
        missing = [name for name, version in self.versions.items() if not version]
        known = ", ".join(f"{name} {version}" for name, version in peers.items()) or "none"
        text = _HEAD.format(
            today=date.today().isoformat(),
            version=__version__,
            python=platform.python_version(),
            numpy=np.__version__,
            kernel=_kernel.build(),
            processor=_processor(),
            cores=os.cpu_count(),
            system=platform.system(),
            peers=known,
            seed=self.seed,
            limit=self.limit,
        )
        if missing:
            text += f"\nNot installed, so not measured: {', '.join(missing)}.\n"
        if self.quick:
            text += "\n**A quick run**: one instance a case, a sample of the families.\n"
        return text

    def _bars(self) -> str:
        if not self.bars:
            return ""
        worst = self.bars[0]
        rows = (bar.cells for bar in self.bars)
        bars = table(["what", "wanted", "measured", ""], rows)
        return f"{_BARS.format(name=worst.name, ratio=number(worst.measured))}\n{bars}"

    def _peers(self) -> str:
        if not self.cases:
            return ""
        names = [name for name, version in self.versions.items() if version]
        times = table(
            ["case", "solutions", "gsp", *names],
            ([*_own(result), *(_time(result, name) for name in names)] for result in self.cases),
        )
        text = f"## Peers\n\n{_TIMES}\n{times}"
        if names:
            answers = table(
                ["case", "instances", "gsp found", "real", *names],
                (
                    [
                        result.case.key,
                        str(len(result.found)),
                        _spread(result.found),
                        _spread(result.real),
                        *(_answers(result.peers[name]) for name in names),
                    ]
                    for result in self.cases
                ),
            )
            text += f"\n{_ANSWERS}\n{answers}"
        return text

    def _machines(self) -> str:
        if not self.machines:
            return ""

        def cell(seconds: float, ratio: float) -> str:
            return duration(seconds) + (f" ({number(ratio)}×)" if ratio else "")

        rows = (
            [x.name, *map(cell, x.seconds, x.ratios), duration(x.peer) if x.peer else ""]
            for x in lines(self.machines)
        )
        heading = ["platform", "first", "other values", "in a batch", "fkSGP"]
        return f"## Machines\n\n{_MACHINES}\n{table(heading, rows)}"

    def _batches(self) -> str:
        if not self.throughputs:
            return ""
        rows = (
            [x.type_text, str(x.batch), str(x.jobs), duration(x.seconds), f"{1 / x.seconds:.0f}"]
            for x in self.throughputs
        )
        heading = ["type", "batch", "threads", "wall time each", "per second"]
        return f"## Batches and threads\n\n{_BATCHES}\n{table(heading, rows)}"

    def _shell(self) -> str:
        if self.dietmaier is None:
            return ""
        runs = {"Dietmaier's platform": self.dietmaier, **self.large}
        rows = (
            [name, duration(x.seconds), f"{x.memory:.0f} MB", x.trouble or "done"]
            for name, x in runs.items()
        )
        heading = ["instance", "time above a bare interpreter", "peak memory", ""]
        bare = duration(self.dietmaier.bare)
        return f"## From the shell\n\n{_SHELL.format(bare=bare)}\n{table(heading, rows)}"

    def _sweep(self) -> str:
        if not self.sweep:
            return ""
        verdicts = Counter(row.verdict for row in self.sweep)
        paths = [row for row in self.sweep if row.method == "paths"]
        slope = np.polyfit(
            [log10(row.expected) for row in paths], [log10(row.milliseconds) for row in paths], 1
        )[0]
        slowest = max(self.sweep, key=lambda row: row.milliseconds)
        return _SWEEP.format(
            count=len(self.sweep),
            verdicts=", ".join(f"{n} {verdict}" for verdict, n in verdicts.items()),
            each=duration(median(row.milliseconds / row.expected for row in paths) / 1e3),
            slope=slope,
            slowest=slowest.family,
            longest=duration(slowest.milliseconds / 1e3),
            paths=slowest.expected,
            memory=self.sweep_memory,
        )


def _own(result: CaseResult) -> list[str]:
    return [result.case.key, str(result.expected), duration(result.seconds)]


def _time(result: CaseResult, name: str) -> str:
    peer = result.peers[name]
    if not peer.seconds:
        return peer.trouble
    seconds = median(peer.seconds)
    return f"{duration(seconds)} ({number(seconds / result.seconds)}×)"


def _answers(peer: PeerResult) -> str:
    if not peer.comparisons:
        return peer.trouble
    found, real = (
        [getattr(x, name) for x in peer.comparisons] for name in ("complex_count", "real")
    )
    faults = {
        name: sum(getattr(x, name) for x in peer.comparisons)
        for name in ("lost", "duplicated", "extra")
    }
    text = f"{_spread(found)}; {_spread(real)} real"
    return ", ".join([text, *(f"**{n} {name}**" for name, n in faults.items() if n)])


def _spread(values: Sequence[int]) -> str:
    """Return the one value of all, or all of them."""
    return str(values[0]) if len(set(values)) == 1 else " ".join(map(str, values))


def _processor() -> str:
    path = Path("/proc/cpuinfo")
    lines = path.read_text().splitlines() if path.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


_HEAD = """# Benchmarks

Generated by `make bench`, which repeats it; do not edit.

- {today}; {processor}, {cores} cores, {system}
- gsp {version} (kernel {kernel}), Python {python}, NumPy {numpy}
- peers: {peers}
- seed {seed} for all instances; a peer is stopped after {limit:.0f} s
"""

_BARS = """\
## How much quicker

**The lowest ratio is {ratio}** ({name}). Each ratio is the time of the quickest peer over the
time of gsp with certified solutions, measured in the same run. In a batch it is the time of each
set of values.
"""

_TIMES = """\
The times are medians over the same instances, on one core. They are processor times, which other
work on the machine changes less. In brackets: the ratio to the time of gsp.

- gsp: `solve` with certificates, in a process that has loaded it.
- msolve and phc: the whole process; they start in milliseconds.
- Macaulay2: the tracking alone.
- fkSGP: its function for real poses only, in the process, in turns with gsp, so that other work
  slows both.

msolve isolates the real solutions of an exact system. Its tutorial says that its computations
over the rationals stop by a probabilistic criterion, which is no proof. Programs that prove poses
are not in the table: HomotopyContinuation.jl certifies solutions that it has found; Cuik and
ALIAS enclose all real solutions in a box.
"""

_ANSWERS = """\
The next table has the numbers of distinct complex solutions, and how many of them are real. There
is one number for each instance where the numbers differ.

- *lost*: solutions of gsp that the peer does not have, over all instances
- *duplicated*: solutions that the peer lists more than once
- *extra*: solutions that the peer lists and gsp does not have

msolve lists the real solutions and counts the others. A numerical solution of a peer counts as
real if its relative imaginary part is below 1e-8: this is a convention and not a proof.
"""

_MACHINES = """\
These platforms have six legs, and would have a special geometry if their numbers were not
rounded. The times are processor times; all answers are certified and proved complete. In
brackets: how many times quicker than fkSGP, measured in turns.

- *first*: no platform of the geometry was solved before
- *other values*: a platform of the geometry was solved before; the values change by 2 %
- *in a batch*: each of 512 sets of values (64 of the sampled machines)

The sampled machines are random, with numbers such as people write (`tests/support/realistic.py`).
The worst time and the worst ratio of a column can be those of two machines.
"""

_BATCHES = """\
Many sets of values of one geometry are solved with `solve_values`; wall time. The geometry was
solved before, and its solutions are kept in the process.
"""

_SHELL = """\
`gsp solve FILE --format json`, with certificates, after its modules were compiled. From the wall
time the {bare} of a Python interpreter without a program are subtracted. The four platforms after
the first are solved for both sides of every plane.
"""

_SWEEP = """\
## Cost and the number of solutions

![cost over the number of solutions](images/cost.svg)

One random one-sided platform of each of {count} families was solved ([data](cost.csv)):
{verdicts}. Where paths are tracked, a path takes {each} (median). The time is proportional to the
count to the power {slope:.2f} (least squares). The slowest family is {slowest}: {longest} for
{paths} paths. The peak memory of the process, which keeps all start systems, is {memory:.0f} MB.
"""

_FORMULATIONS = """\
## How the peers were asked

Random instances have three decimals, directions of integer length and angles with short cosines,
so that all equations have short rational coefficients. (Longer ones slow down exact solvers
much.) The equations are those of [`gsp export`](export.md), and not those that gsp solves.

- All: the Study parameters with e0 = 1, seven equations in seven unknowns. They are e.f = 0, and
  for each constraint a quadric (a quartic for PL, LP, LL).
- msolve: also tried were the entries of R, T, U = R^T T and T.T with their relations, unchanged
  or with linear equations solved beforehand, and other orders of the unknowns. None was quicker.
- phc -b: the equations and nothing else. For {split} each product has an unknown u more,
  `G = d N u` and `u H = d N`, which halves the time. (For 5PP+PL and 6PL it is slower.)
- phc -p and Macaulay2 start from the same solved generic system as gsp.
- phc -p: a homotopy of degree 1 in t (its default of 2 takes a third longer), and its other
  defaults.
- Macaulay2: `trackHomotopy` with its defaults, on straight-line programs that keep products as
  products. `track`, which expands them, is slower.
- 6LL was not tried with msolve, since 6PL has an eighth of the solutions and takes longer than
  the limit. It was not tried with phc -b, which would track 8192 paths by the total degree.
"""
