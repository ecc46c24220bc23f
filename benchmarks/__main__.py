"""Run the benchmarks: `python -m benchmarks [--quick] [--peer fksgp=FOLDER] [--output docs]`."""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from statistics import median

from benchmarks import fksgp, macaulay2, machines, msolve, phc
from benchmarks.cases import CASES, Case, random_instances
from benchmarks.homotopy import Homotopy
from benchmarks.own import Shell, shell, solve_seconds, throughput, write_instance
from benchmarks.peers import Answer, compare
from benchmarks.report import Bar, CaseResult, PeerResult, Report
from benchmarks.sweep import costs, peak_memory, plot, write_csv
from gspcli.geometry.instance import Instance
from gspcli.resources import data_path
from gspcli.solver import solve

SEED = 2003
#: Types whose certified solution from the shell should need most memory: the most solutions, on
#: the way as one system or as many.
_LARGE = ("6DLL", "2PL LP 3DLL", "PL PH HP 3DLL", "3PH 3HP")
_PROGRAM = msolve.executable()


#: We and the peers in process are measured in turns, so often.
SLICES = 8

#: The batch that is compared with a peer: its type, certified, on one thread.
_BATCH = ("6PP", 1)
#: Peers that are no installed programs: where a copy is, is said with ``--peer``.
COPIES = {"fksgp": fksgp.NAME}


def versions(copies: Mapping[str, Path]) -> dict[str, str]:
    """Return the versions of the peers, empty for those that are missing."""
    found = phc.version()
    return {
        fksgp.NAME: fksgp.version(copies.get(fksgp.NAME)),
        "msolve": msolve.version(_PROGRAM),
        "phc -p": found,
        "phc -b": found,
        "M2 track": macaulay2.version(),
    }


def ask(
    peer: str,
    case: Case,
    instance: Instance,
    folder: Path,
    limit: float,
    copies: Mapping[str, Path],
) -> Answer:
    """Let a peer solve an instance of a case."""
    if peer == fksgp.NAME:
        return fksgp.solve(copies[peer], instance, SEED)
    if peer == "msolve":
        return msolve.isolate(_PROGRAM, instance, folder, limit)
    if peer == "phc -b":
        return phc.blackbox(instance, folder, limit, split=case.split)
    homotopy = Homotopy.of(instance, SEED)
    if peer == "phc -p":
        return phc.parameter_homotopy(homotopy, folder, limit)
    return macaulay2.track(homotopy, folder, limit)


def measure_case(
    case: Case,
    peers: Sequence[str],
    *,
    count: int,
    limit: float,
    folder: Path,
    copies: Mapping[str, Path],
) -> CaseResult:
    """Measure ourselves and the peers on the same instances of a case."""
    instances = case.draw(SEED, max(count, 30 if case.instances > 1 else 5))
    ours = [solve(instance) for instance in instances[:count]]
    beside = [peer for peer in peers if peer == fksgp.NAME and fksgp.can(case)]
    seconds: list[float] = []
    in_process: list[list[Answer]] = []
    for _ in range(SLICES):
        seconds += solve_seconds(instances)
        for peer in beside:
            asked = (ask(peer, case, given, folder, limit, copies) for given in instances[:count])
            in_process.append(list(asked))
    result = CaseResult(
        case=case,
        expected=ours[0].expected,
        found=[answer.counts.found for answer in ours],
        real=[answer.counts.real for answer in ours],
        seconds=median(seconds),
    )
    for peer in peers:
        if peer in case.beyond:
            result.peers[peer] = PeerResult([], [], "not tried")
            continue
        if peer == fksgp.NAME and not fksgp.can(case):
            result.peers[peer] = PeerResult([], [], "6-6 only")
            continue
        answers: list[Answer] = []
        for k, instance in enumerate(instances[:count]):
            if peer in beside:
                several = [turn[k] for turn in in_process]
                middle = median(answer.seconds for answer in several)
                answers.append(replace(several[0], seconds=middle))
            else:
                answers.append(ask(peer, case, instance, folder, limit, copies))
            if answers[-1].trouble:
                break
            _say(f"  {peer}: {answers[-1].seconds:.3f} s")
        good = [answer for answer in answers if not answer.trouble]
        result.peers[peer] = PeerResult(
            [answer.seconds for answer in good],
            [compare(answer, mine) for answer, mine in zip(good, ours, strict=False)],
            answers[-1].trouble,
        )
    return result


def memory(folder: Path) -> dict[str, Shell]:
    """Return what the largest types need from the shell, certified, both sides of planes."""
    result = {}
    for type_text in _LARGE:
        instance = next(random_instances(type_text, SEED, one_sided=False))
        result[type_text] = shell(write_instance(instance, folder / "large.yaml"), 1)
    return result


def bars(report: Report) -> list[Bar]:
    """Return the ratios to the quickest peer beside the required ones, the worst first."""
    found: list[Bar] = []
    for case in report.cases:
        times = {name: median(peer.seconds) for name, peer in case.peers.items() if peer.seconds}
        if times:
            quickest = min(times, key=lambda name: times[name])
            ratio = times[quickest] / case.seconds
            found.append(Bar(f"{case.case.key}, {quickest} over gsp", case.case.wanted, ratio))
    peer = next((c.peers.get(fksgp.NAME) for c in report.cases if c.case.key == "6-6"), None)
    for batch in report.throughputs:
        if peer and peer.seconds and (batch.type_text, batch.jobs) == _BATCH:
            ratio = median(peer.seconds) / batch.seconds
            found.append(Bar(f"6-6 in a batch, {fksgp.NAME} over gsp", 60, ratio))
    found += _machine_bars(report)
    return sorted(found, key=lambda bar: bar.measured)


def _machine_bars(report: Report) -> list[Bar]:
    """Return the same for platforms that are special but for rounding, the slowest of each sort.

    Of first solutions the median and the least ratio of sampled machines.
    """
    found = [result for result in report.machines if result.peer is not None]
    if not found:
        return []
    over = f"{fksgp.NAME} over gsp"
    others = min(found, key=lambda x: x.ratio(x.others))
    batch = min(found, key=lambda x: x.ratio(x.batch))
    ratios = [x.ratio(x.first) for x in found if x.name.startswith(machines.SAMPLED)]
    return [
        Bar(f"{others.name} with other values, {over}", 3, others.ratio(others.others)),
        Bar(f"{batch.name} in a batch, {over}", 100, batch.ratio(batch.batch)),
        Bar(f"{machines.SAMPLED} machines, first, median, {over}", 0.5, median(ratios)),
        Bar(f"{machines.SAMPLED} machines, first, least, {over}", 0.05, min(ratios)),
    ]


def main() -> int:
    """Measure, write the report."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a rough run of a few minutes")
    parser.add_argument("--case", action="append", help="only this case, and nothing else")
    parser.add_argument(
        "--machines", action="store_true", help="only platforms that are special but for rounding"
    )
    parser.add_argument("--no-peers", action="store_true", help="measure gsp alone")
    parser.add_argument(
        "--peer",
        action="append",
        default=[],
        metavar="NAME=FOLDER",
        help=f"a copy of a peer that is no installed program: {', '.join(COPIES)}",
    )
    parser.add_argument("--limit", type=float, help="seconds after which a peer is stopped")
    parser.add_argument("--output", type=Path, help="folder for the report (else to stdout)")
    arguments = parser.parse_args()
    quick: bool = arguments.quick
    limit = arguments.limit or (20.0 if quick else 150.0)
    copies: dict[str, Path] = {}
    for given in arguments.peer:
        peer, _, place = given.partition("=")
        if peer not in COPIES or not place:
            parser.error(f"--peer {given}: expected one of {', '.join(COPIES)}, =, and a folder")
        copies[COPIES[peer]] = Path(place)
        if not fksgp.version(copies[COPIES[peer]]):
            parser.error(f"--peer {given}: there is no copy of {COPIES[peer]} in this folder")
    known = {} if arguments.no_peers else versions(copies)
    peers = [name for name, version in known.items() if version]
    report = Report(seed=SEED, limit=limit, quick=quick, versions=known)
    chosen = [case for case in CASES if not arguments.case or case.key in arguments.case]
    chosen = [] if arguments.machines else chosen
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for case in chosen:
            _say(case.key)
            count = 1 if quick else case.instances
            report.cases.append(
                measure_case(case, peers, count=count, limit=limit, folder=folder, copies=copies)
            )
        if arguments.machines or not arguments.case:
            _say("machines")
            report.machines += machines.measure(SEED, copies.get(fksgp.NAME), quick=quick)
        if not arguments.case and not arguments.machines:
            measure_rest(report, folder, quick=quick)
    report.bars = bars(report)
    text = report.markdown()
    if arguments.output is None:
        sys.stdout.write(text)
        return 0
    (arguments.output / "benchmarks.md").write_text(text, encoding="utf-8")
    if report.sweep:
        write_csv(report.sweep, arguments.output / "cost.csv")
        (arguments.output / "images" / "cost.svg").write_bytes(plot(report.sweep))
    for bar in report.bars:
        sys.stdout.write(f"{bar}\n")
    return 0


def measure_rest(report: Report, folder: Path, *, quick: bool) -> None:
    """Measure batches, threads, the shell, memory, and the cost over all families."""
    _say("batches")
    report.throughputs = [
        throughput(type_text, size // 10 if quick else size, jobs, SEED)
        for type_text, size in (("6PP", 2000), ("PL PL LP 3ALL", 2000), ("6PL", 40))
        for jobs in (1, 2)
    ]
    _say("shell")
    report.dietmaier = shell(data_path("examples", "dietmaier.yaml"), 3 if quick else 9)
    _say("all families")
    began = time.monotonic()
    for cost in costs(SEED, 60 if quick else 1):
        report.sweep.append(cost)
        if len(report.sweep) % 50 == 0:
            _say(f"  {len(report.sweep)} in {time.monotonic() - began:.0f} s")
    report.sweep_memory = peak_memory()
    if not quick:
        _say("memory")
        report.large = memory(folder)


def _say(text: str) -> None:
    sys.stderr.write(f"{text}\n")


if __name__ == "__main__":
    sys.exit(main())
