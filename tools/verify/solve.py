"""Verify that the solver finds all poses of random platforms, and record it in the data.

    python -m tools.verify.solve platforms [--count 100000] [--jobs 2]
    python -m tools.verify.solve families [--each 10] [--jobs 2]
    python -m tools.verify.solve batches [--rows 2000] [--jobs 2]
    python -m tools.verify.solve all [--check [--sample N]]
    python -m tools.verify.solve show TASK INSTANCE

`platforms` solves random real platforms with six DPP. `families` solves several random platforms of
each of the 896 families (kinds up to the kinds of angles), with both sides of every plane.
`batches` solves many sets of values of each of 50 geometries; all must be proved complete. Each
instance has a hidden real pose, from which its values are measured; what must hold of every answer
is in `examination`. 3D3A platforms are solved twice, in closed form and by tracking paths.

Work goes through a journal in ``build/verify/``: interrupted, the same command takes it up
again, unless the solver has changed. A finished run is written to ``data/verification/`` and
docs/random-platforms.md; it does not depend on ``--jobs``. The exit code is 1 if anything does not
hold; with ``--check``, if anything but a rounding error differs from the record, of which
``--sample`` takes some chunks and families. `show` prints an instance of the first two as a file,
for `gsp solve`.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from gspcli import dumps
from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.kinds import DPP
from gspcli.catalogue.types import CONSTRAINTS, MAX_ANGLES, GspType
from gspcli.geometry.arrangement import Arrangement
from gspcli.solver import PoseSet, SolveResult, solve
from tools.oracle.poses_by_paths import solve_by_tracking, solve_each_by_tracking
from tools.recording import (
    add_sample,
    add_workers,
    report,
    sampled,
    sources_sha256,
)
from tools.verify.campaigns import add_work, exit_after, results
from tools.verify.examination import Finding, examine
from tools.verify.random_batches import batch_tasks, examine_batch
from tools.verify.random_platforms import (
    Task,
    families_by_name,
    family_tasks,
    platform_tasks,
    random_member,
    random_platform,
    shown,
)
from tools.verify.solve_record import Examined, differences, write

#: What the answers come from: journals of other sources have other names.
SOURCES = (
    "native",
    "gspcli/continuation",
    "gspcli/certification",
    "gspcli/solver",
    "gspcli/geometry",
    "data/start-systems",
)


def verify_platforms(task: Task) -> Examined:
    """Solve a chunk of random platforms with six DPP."""
    drawn = [random_platform(task.rng(i)) for i in range(task.count)]
    expected = generic_counts(GspType.of((DPP,) * CONSTRAINTS)).two_sided
    answers = solve_each_by_tracking((arrangement for arrangement, _ in drawn), seed=task.seed)
    findings = (
        examine(arrangement, poses, expected, hidden)
        for (arrangement, hidden), poses in zip(drawn, answers, strict=True)
    )
    return Examined(task, tuple(findings))


def verify_family(task: Task) -> Examined:
    """Solve random platforms of a family; an exception is a finding, so that the run goes on."""
    findings = []
    for number in range(task.count):
        expected = generic_counts(families_by_name()[task.name].types[0]).two_sided
        try:
            findings.append(verify_member(task, number, expected))
        except Exception as error:
            raised = f"raises {type(error).__name__}: {error}"
            findings.append(Finding(expected, 0, 0, 0.0, 0.0, 0.0, (raised,)))
    return Examined(task, tuple(findings))


def verify_member(task: Task, number: int, expected: int) -> Finding:
    """Solve one of the random platforms of a family."""
    instance, hidden = random_member(task, number)
    arrangement = Arrangement.of(instance)
    answers: list[PoseSet | SolveResult] = [solve(instance, seed=task.seed)]
    if len(instance.type.angles) == MAX_ANGLES:
        answers.append(solve_by_tracking(arrangement, seed=task.seed))
    # The worse one of two ways to solve.
    each = [examine(arrangement, answer, expected, hidden) for answer in answers]
    return max(each, key=lambda finding: len(finding.problems))


def verify_batch(task: Task) -> Examined:
    """Solve many sets of values of one geometry together."""
    return Examined(task, examine_batch(task))


@dataclass(frozen=True)
class Run:
    """One of the runs: the name of its record, its option, and how it is done."""

    record: str
    option: str
    default: int
    help: str
    tasks: Callable[[int], list[Task]]
    verify: Callable[[Task], Examined]


RUNS = {
    "platforms": Run(
        "platforms-6-6",
        "count",
        100_000,
        "platforms with six DPP",
        platform_tasks,
        verify_platforms,
    ),
    "families": Run(
        "families", "each", 10, "platforms of each family", family_tasks, verify_family
    ),
    "batches": Run(
        "batches", "rows", 2000, "sets of values of a geometry", batch_tasks, verify_batch
    ),
}


def told(name: str, done: Sequence[Examined]) -> int:
    """Print how a run ended; return how many platforms have problems."""
    wrong = [(e.task, number, finding) for e in done for number, finding in e.problems]
    for task, number, finding in wrong:
        print(f"{task.name}, {number}: {', '.join(finding.problems)}")
    print(f"{name}: {sum(len(e.findings) for e in done)} instances, {len(wrong)} with problems")
    return len(wrong)


def options() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    commands = parser.add_subparsers(dest="command", required=True)
    add = partial(commands.add_parser, formatter_class=argparse.ArgumentDefaultsHelpFormatter)
    for name in (*RUNS, "all"):
        command = add(name, help="all of them" if name == "all" else RUNS[name].help)
        for run in RUNS.values() if name == "all" else [RUNS[name]]:
            command.add_argument(f"--{run.option}", type=int, default=run.default, help=run.help)
        add_workers(command)
        command.add_argument("--no-record", action="store_true", help="leave data/ as it is")
        command.add_argument("--check", action="store_true", help="compare with the record")
        add_sample(command)
        add_work(command)
    show = add("show", help="print an instance of a run")
    show.add_argument("task")
    show.add_argument("instance", type=int)
    return parser


def main() -> int:
    """Verify, write the record, and return the exit code."""
    arguments = options().parse_args()
    if arguments.command == "show":
        print(dumps(shown(arguments.task, arguments.instance)), end="")
        return 0
    bad, platforms = 0, 0
    different: list[str] = []
    for name in RUNS if arguments.command == "all" else [arguments.command]:
        run = RUNS[name]
        size = getattr(arguments, run.option)
        every = run.tasks(size)
        tasks = sampled(every, arguments.sample if arguments.check else None)
        done = results(
            tasks,
            run.verify,
            Examined.of_entry,
            arguments,
            name=run.record,
            label=f"solving {run.help}",
            sources=SOURCES,
        )
        if arguments.check:
            different += differences(run.record, done, whole=len(tasks) == len(every))
            platforms += sum(len(examined.findings) for examined in done)
            continue
        if not arguments.no_record:
            command = f"python -m tools.verify.solve {name} --{run.option} {size}"
            write(run.record, command, sources_sha256(SOURCES), done)
        bad += told(run.record, done)
    if arguments.check:
        return report(different, f"all poses of {platforms} random platforms, as recorded")
    return 1 if bad else 0


if __name__ == "__main__":
    exit_after(main)
