"""Verify that the solver finds all poses of random platforms, and record it in the data.

    python tools/verify_solve.py platforms [--count 100000] [--jobs 2]
    python tools/verify_solve.py families [--each 10] [--jobs 2]
    python tools/verify_solve.py all [--check [--sample N]]
    python tools/verify_solve.py show TASK INSTANCE

`platforms` solves random real platforms with six DPP, `families` several random platforms of
each of the 896 families (kinds up to the kinds of angles), both sides of every plane. Each instance
has a hidden real pose, from which its values are measured. What must hold of every result:

- every path is accounted for and ends at an isolated simple finite pose;
- there are as many different poses as the generic count, no two of them nearer than `SEPARATION`;
- the conjugate of every pose is a pose, and exactly those said to be real are their own conjugates;
- every pose satisfies the constraints as stated;
- the hidden pose is among the real ones.

3D3A platforms are solved twice, in closed form and by tracking paths. Work goes through a journal
in ``build/verify-solve/``: interrupted, the same command takes it up again, unless the solver has
changed. A finished run is written to ``data/verification/`` and docs/completeness.md; it does not
depend on ``--jobs``. The exit code is 1 if anything does not hold; with ``--check``, if anything
but a rounding error differs from the record, of which ``--sample`` takes some chunks and
families. `show` prints an instance as a file, for `gsp solve`.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import io
import json
import platform as machine
import sys
import time
import zlib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from recording import ROOT, add_sample, report, sampled, sources_sha256
from scipy.spatial import KDTree

from gspcli import __version__, dumps
from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.kinds import DPP
from gspcli.catalogue.types import CLASSES, CONSTRAINTS, MAX_ANGLES, Family, GspType, families
from gspcli.defaults import SEED
from gspcli.errors import INTERRUPTED
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Units
from gspcli.geometry.measurement import measured
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Point, vector
from gspcli.geometry.quaternions import Field, rotation_from_quaternion
from gspcli.geometry.residuals import residuals
from gspcli.solver import PoseSet, SolveResult, solve
from gspcli.solver.generate import random_instance
from gspcli.solver.tracking import solve_by_tracking, solve_each_by_tracking
from gspcli.workers import Workers

JOURNALS = ROOT / "build" / "verify-solve"
RECORDS = ROOT / "data" / "verification"
PAGE = ROOT / "docs" / "completeness.md"
#: What is between these lines of the page is written from the record.
BEGIN, END = "<!-- record -->", "<!-- end of record -->"
#: What the answers come from; a journal of other sources is begun anew.
SOURCES = (
    "native",
    "gspcli/continuation",
    "gspcli/solver",
    "gspcli/geometry",
    "data/start-systems",
)
#: Platforms in one task.
CHUNK = 500
#: Columns of the record that rounding errors change.
ROUNDING = {"largest_residual", "smallest_separation", "largest_asymmetry"}

#: Poses nearer than this, in the chart of `_charted`, count as the same.
SEPARATION = 1e-9
#: How far the conjugate of a pose may be from a pose, and the hidden pose from a real one.
MATCH = 1e-6
#: Largest residual relative to the length, a complex pose's to the square of its size.
RESIDUAL = 1e-8

Array = NDArray[np.float64]
Pose = tuple[Array, Array]


@dataclass(frozen=True)
class Finding:
    """What is found of one answer.

    Attributes
    ----------
    expected, found, real
        The generic count, the distinct poses, and the real ones.
    residual, separation, asymmetry
        The largest residual, the smallest distance of two poses, and the largest distance of a
        conjugate from the nearest pose.
    problems
        What does not hold; empty if all does.
    """

    expected: int
    found: int
    real: int
    residual: float
    separation: float
    asymmetry: float
    problems: tuple[str, ...]


def examine(
    arrangement: Arrangement, poses: PoseSet | SolveResult, expected: int, hidden: Pose
) -> Finding:
    """Return what is found of the answer to a generic platform with a known real pose."""
    R, T, real = poses.R, poses.T, poses.real
    charted = _charted(arrangement, R, T)
    separation = _distances(charted, charted, 2)[:, 1].min(initial=np.inf)
    to_conjugate, conjugate = _nearest(charted.conj(), charted)
    hidden_R, hidden_T = (part[None].astype(complex) for part in hidden)
    to_hidden, nearest = _nearest(_charted(arrangement, hidden_R, hidden_T), charted)
    size = np.maximum(1, np.abs(R).max((1, 2), initial=0)) + np.abs(T).max(1) / arrangement.length
    relative = residuals(arrangement, R, T)
    relative[:, arrangement.distances] /= arrangement.length
    residual = (relative.max(axis=1) / size**2).max(initial=0)
    own = conjugate == np.arange(len(R))
    statements = {
        "lost paths": poses.account.lost > 0,
        "paths on curves": poses.account.on_curves > 0,
        "poses at infinity": poses.account.at_infinity > 0,
        "spurious ends": poses.account.spurious > 0,
        "multiple poses": bool((poses.multiplicity > 1).any()),
        "wrong number": len(R) != expected,
        "equal poses": separation < SEPARATION,
        "conjugate missing": to_conjugate.max(initial=0) > MATCH,
        "reality wrong": bool((own != real).any()),
        "residual": not residual < RESIDUAL,
        "hidden pose missing": not (len(R) and to_hidden[0] < MATCH and real[nearest[0]]),
    }
    return Finding(
        expected,
        len(R),
        int(real.sum()),
        float(residual),
        float(separation),
        float(to_conjugate.max(initial=0)),
        tuple(name for name, wrong in statements.items() if wrong),
    )


def _charted(arrangement: Arrangement, R: Field, T: Field) -> Field:
    """Return (R, T, 1) scaled to norm 1, so that large poses are compared by relative size."""
    flat = np.concatenate((R.reshape(-1, 9), T / arrangement.length, np.ones((len(R), 1))), axis=1)
    charted: Field = flat / np.linalg.norm(flat, axis=1, keepdims=True)
    return charted


def _distances(points: Field, among: Field, count: int) -> Array:
    return np.asarray(_tree(among).query(_flat(points), count)[0]).reshape(len(points), -1)


def _nearest(points: Field, among: Field) -> tuple[Array, NDArray[np.intp]]:
    distances, index = _tree(among).query(_flat(points))
    return np.asarray(distances), np.asarray(index)


def _tree(points: Field) -> KDTree:
    return KDTree(_flat(points))


def _flat(points: Field) -> Array:
    return np.concatenate((points.real, points.imag), axis=1)


@dataclass(frozen=True)
class Task:
    """Some random platforms: of a type chosen at random in a family, or with six DPP.

    Attributes
    ----------
    name
        The name of the family, or that of a chunk.
    count
        How many instances.
    seed
        The source of randomness, with the name.
    """

    name: str
    count: int
    seed: int

    def rng(self, instance: int) -> np.random.Generator:
        """Return the source of randomness of one of the instances."""
        return np.random.default_rng([self.seed, zlib.crc32(self.name.encode()), instance])


def random_platform(rng: np.random.Generator) -> tuple[Arrangement, Pose]:
    """Return a real platform with six DPP, all coordinates uniform in [-1, 1], and a pose."""
    y, x = rng.uniform(-1, 1, (2, CONSTRAINTS, 3))
    R, T = rotation_from_quaternion(rng.normal(size=4)), rng.uniform(-1, 1, 3)
    arrangement = Arrangement(
        kinds=(DPP,) * CONSTRAINTS,
        y=y,
        x=x,
        u=np.zeros_like(y),
        v=np.zeros_like(x),
        values=np.zeros(CONSTRAINTS),
        sides=np.zeros(CONSTRAINTS, dtype=np.int64),
        in_radians=1.0,
    )
    return arrangement.with_values(measured(arrangement, R, T)), (R, T)


def verify_platforms(task: Task) -> list[Finding]:
    """Solve a chunk of random platforms with six DPP."""
    drawn = [random_platform(task.rng(i)) for i in range(task.count)]
    expected = generic_counts(GspType.of((DPP,) * CONSTRAINTS)).two_sided
    answers = solve_each_by_tracking((arrangement for arrangement, _ in drawn), seed=task.seed)
    return [
        examine(arrangement, poses, expected, hidden)
        for (arrangement, hidden), poses in zip(drawn, answers, strict=True)
    ]


@cache
def families_by_name() -> dict[str, Family]:
    """Return the families by name, such as ``3D3A PL PL LP``."""
    return {family.id: family for platform_class in CLASSES for family in families(platform_class)}


def random_member(task: Task, number: int) -> tuple[Instance, Pose]:
    """Return one of the random instances of a family."""
    rng = task.rng(number)
    types = families_by_name()[task.name].types
    return random_instance(types[rng.integers(len(types))], rng)


def verify_family(task: Task) -> list[Finding]:
    """Solve random platforms of a family; an exception is a finding, so that the run goes on."""
    findings = []
    for number in range(task.count):
        expected = generic_counts(families_by_name()[task.name].types[0]).two_sided
        try:
            findings.append(verify_member(task, number, expected))
        except Exception as error:
            raised = f"raises {type(error).__name__}: {error}"
            findings.append(Finding(expected, 0, 0, 0.0, 0.0, 0.0, (raised,)))
    return findings


def verify_member(task: Task, number: int, expected: int) -> Finding:
    """Solve one of the random platforms of a family."""
    instance, hidden = random_member(task, number)
    arrangement = Arrangement.of(instance)
    answers: list[PoseSet | SolveResult] = [solve(instance, seed=task.seed, certify=False)]
    if len(instance.type.angles) == MAX_ANGLES:
        answers.append(solve_by_tracking(arrangement, seed=task.seed))
    # The worse one of two ways to solve.
    each = [examine(arrangement, answer, expected, hidden) for answer in answers]
    return max(each, key=lambda finding: len(finding.problems))


def read_journal(path: Path, origin: str) -> dict[Task, list[Finding]]:
    """Return what is done already; nothing if the journal belongs to other sources."""
    lines = path.read_text(encoding="utf-8").split("\n") if path.is_file() else []
    if not lines or json.loads(lines[0] or "{}") != {"sources": origin}:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps({"sources": origin}) + "\n", encoding="utf-8")
        return {}
    # What follows the last end of line was cut off by an interruption.
    complete = lines[:-1]
    path.write_text("\n".join(complete) + "\n", encoding="utf-8")
    done = {}
    for line in complete[1:]:
        entry = json.loads(line)
        done[Task(**entry["task"])] = [
            Finding(**{**finding, "problems": tuple(finding["problems"])})
            for finding in entry["findings"]
        ]
    return done


def run(
    tasks: Sequence[Task],
    verify: Callable[[Task], list[Finding]],
    journal: Path,
    origin: str,
    workers: Workers,
) -> dict[Task, list[Finding]]:
    """Do the tasks that the journal does not have yet; return the findings of all."""
    done = read_journal(journal, origin)
    done = {task: done[task] for task in tasks if task in done}
    rest = [task for task in tasks if task not in done]
    reported = began = time.monotonic()
    with journal.open("a", encoding="utf-8") as file:
        found = workers.as_completed(partial(_verified, verify), rest)
        for finished, (task, findings) in enumerate(found, start=1):
            done[task] = findings
            file.write(json.dumps(_entry(task, findings)) + "\n")
            file.flush()
            for number, finding in _problems(findings):
                print(f"{task.name}, {number}: {', '.join(finding.problems)}", file=sys.stderr)
            now = time.monotonic()
            if now - reported > 10 or finished == len(rest):
                reported = now
                left = (now - began) / finished * (len(rest) - finished)
                bad = sum(len(_problems(findings)) for findings in done.values())
                state = f"{len(done)} of {len(tasks)} tasks, {bad} problems"
                print(f"{state}, about {left:.0f} s left", file=sys.stderr)
    return {task: done[task] for task in tasks}


def _verified(verify: Callable[[Task], list[Finding]], task: Task) -> tuple[Task, list[Finding]]:
    return task, verify(task)


def _entry(task: Task, findings: Sequence[Finding]) -> dict[str, object]:
    """Return a line of the journal, as `read_journal` reads it."""
    return {"task": asdict(task), "findings": [asdict(finding) for finding in findings]}


def _problems(findings: Sequence[Finding]) -> list[tuple[int, Finding]]:
    return [(i, finding) for i, finding in enumerate(findings) if finding.problems]


def rows(done: Mapping[Task, list[Finding]]) -> Iterator[dict[str, object]]:
    """Yield a row of the record for each task."""
    for task, findings in done.items():
        real = Counter(finding.real for finding in findings)
        yield {
            "task": task.name,
            "instances": len(findings),
            "expected": " ".join(str(n) for n in sorted({f.expected for f in findings})),
            "complete": sum(not finding.problems for finding in findings),
            "found": sum(finding.found for finding in findings),
            "largest_residual": f"{max(finding.residual for finding in findings):.1e}",
            "smallest_separation": f"{min(finding.separation for finding in findings):.1e}",
            "largest_asymmetry": f"{max(finding.asymmetry for finding in findings):.1e}",
            "real": " ".join(f"{poses}:{times}" for poses, times in sorted(real.items())),
        }


def write(name: str, command: str, origin: str, done: Mapping[Task, list[Finding]]) -> None:
    """Write the record of a finished run, its entry in the manifest, and the page."""
    table = list(rows(done))
    text = io.StringIO()
    writer = csv.DictWriter(text, list(table[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(table)
    RECORDS.mkdir(parents=True, exist_ok=True)
    (RECORDS / f"{name}.csv").write_text(text.getvalue(), encoding="utf-8")
    path = RECORDS / "manifest.json"
    manifest = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    findings = [finding for each in done.values() for finding in each]
    manifest[name] = {
        "command": command,
        "seed": SEED,
        "versions": {
            "gsp": __version__,
            "numpy": np.__version__,
            "python": machine.python_version(),
        },
        "machine": machine.machine(),
        "sources_sha256": origin,
        "sha256": hashlib.sha256(text.getvalue().encode()).hexdigest(),
        "instances": len(findings),
        "poses": sum(finding.found for finding in findings),
        "expected": sum(finding.expected for finding in findings),
        "largest_residual": float(f"{max(finding.residual for finding in findings):.1e}"),
        "smallest_separation": float(f"{min(finding.separation for finding in findings):.1e}"),
        "problems": [
            {"task": task.name, "instance": number, "problems": list(finding.problems)}
            for task, each in done.items()
            for number, finding in _problems(each)
        ],
    }
    document = json.dumps(dict(sorted(manifest.items())), indent=1) + "\n"
    path.write_text(document, encoding="utf-8")
    page = PAGE.read_text(encoding="utf-8")
    before, _, rest = page.partition(BEGIN)
    after = rest.partition(END)[2]
    PAGE.write_text(f"{before}{BEGIN}\n{summary(manifest)}{END}{after}", encoding="utf-8")


def differences(name: str, done: Mapping[Task, list[Finding]], *, whole: bool) -> Iterator[str]:
    """Yield in which rows a run differs from the record, apart from rounding errors.

    Parameters
    ----------
    name
        The run.
    done
        What was found.
    whole
        Whether that is all of the run.
    """
    content = (RECORDS / f"{name}.csv").read_bytes()
    manifest = json.loads((RECORDS / "manifest.json").read_text(encoding="utf-8"))
    if hashlib.sha256(content).hexdigest() != manifest[name]["sha256"]:
        yield f"{name}.csv: this is not the file of the manifest"
    if summary(manifest) not in PAGE.read_text(encoding="utf-8"):
        yield f"docs/{PAGE.name}: the record shown is another one"
    recorded = {row["task"]: row for row in csv.DictReader(content.decode().splitlines())}
    found = {task.name: row for task, row in zip(done, rows(done), strict=True)}
    for task in found if not whole else {**found, **recorded}:
        ours, theirs = found.get(task, {}), recorded.get(task, {})
        for column in sorted({**ours, **theirs}.keys() - ROUNDING):
            if str(ours.get(column)) != theirs.get(column):
                yield f"{name}, {task}: {column} {theirs.get(column)}, now {ours.get(column)}"


def summary(manifest: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the record as a table and a list of problems, in Markdown."""
    lines = [
        "| run | platforms | poses expected | found | with problems | largest residual "
        "| nearest two poses |",
        "|---|---|---|---|---|---|---|",
        *(
            f"| `{run['command']}` | {run['instances']} | {run['expected']} | {run['poses']} "
            f"| {len(run['problems'])} | {run['largest_residual']} "
            f"| {run['smallest_separation']} |"
            for run in manifest.values()
        ),
        "",
    ]
    for problem in (problem for run in manifest.values() for problem in run["problems"]):
        words = ", ".join(problem["problems"])
        lines.append(f'- `show "{problem["task"]}" {problem["instance"]}`: {words}')
    return "\n".join([*lines, ""])


def shown(name: str, number: int) -> Instance:
    """Return an instance of a run, its doubles written out."""
    task = Task(name, 0, SEED)
    if name in families_by_name():
        return random_member(task, number)[0]
    arrangement, _ = random_platform(task.rng(number))

    def exact(value: float) -> Number:
        return Number.of(repr(float(value)))

    constraints = tuple(
        Constraint(
            DPP,
            Point(vector(*map(exact, y))),
            Point(vector(*map(exact, x))),
            exact(d),
            platform_name=f"P{i}",
            base_name=f"B{i}",
        )
        for i, (y, x, d) in enumerate(
            zip(arrangement.y, arrangement.x, arrangement.values, strict=True), start=1
        )
    )
    return Instance(constraints, Units("unit", AngleUnit.DEGREE))


def platform_tasks(count: int) -> list[Task]:
    """Return the tasks of a run over random platforms with six DPP."""
    sizes = [min(CHUNK, count - k) for k in range(0, count, CHUNK)]
    return [Task(f"chunk {i}", size, SEED) for i, size in enumerate(sizes)]


def family_tasks(each: int) -> list[Task]:
    """Return the tasks of a run over the families, those with the most solutions first."""
    by_size = sorted(
        families_by_name().values(), key=lambda family: -generic_counts(family.types[0]).two_sided
    )
    return [Task(family.id, each, SEED) for family in by_size]


def main() -> int:
    """Verify, write the record, and return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    commands = parser.add_subparsers(dest="command", required=True)
    add = partial(commands.add_parser, formatter_class=argparse.ArgumentDefaultsHelpFormatter)
    helps = {
        "platforms": "random platforms with six DPP",
        "families": "random platforms of all 896 families",
        "all": "both",
    }
    for name, text in helps.items():
        command = add(name, help=text)
        if name != "families":
            command.add_argument(
                "--count", type=int, default=100_000, help="platforms with six DPP"
            )
        if name != "platforms":
            command.add_argument("--each", type=int, default=10, help="platforms of each family")
        command.add_argument("--jobs", type=int, default=1, help="processes")
        command.add_argument("--no-record", action="store_true", help="leave data/ as it is")
        command.add_argument("--check", action="store_true", help="compare with the record")
        add_sample(command)
        command.add_argument("--work", type=Path, default=JOURNALS, help="folder of the journals")
    show = add("show", help="print an instance of a run")
    show.add_argument("task")
    show.add_argument("instance", type=int)
    arguments = parser.parse_args()
    if arguments.command == "show":
        print(dumps(shown(arguments.task, arguments.instance)), end="")
        return 0
    runs: list[tuple[str, str, Callable[[Task], list[Finding]], list[Task]]] = []
    if arguments.command != "families":
        options = f"platforms --count {arguments.count}"
        runs.append(("platforms-6-6", options, verify_platforms, platform_tasks(arguments.count)))
    if arguments.command != "platforms":
        options = f"families --each {arguments.each}"
        runs.append(("families", options, verify_family, family_tasks(arguments.each)))
    origin = sources_sha256(SOURCES)
    bad, platforms = 0, 0
    different: list[str] = []
    for name, options, verify, every in runs:
        tasks = sampled(every, arguments.sample if arguments.check else None)
        done = run(tasks, verify, arguments.work / f"{name}.jsonl", origin, Workers(arguments.jobs))
        if arguments.check:
            different += differences(name, done, whole=len(tasks) == len(every))
            platforms += sum(map(len, done.values()))
            continue
        if not arguments.no_record:
            write(name, f"python tools/verify_solve.py {options}", origin, done)
        findings = [finding for each in done.values() for finding in each]
        wrong = sum(bool(finding.problems) for finding in findings)
        kinds = Counter(problem for finding in findings for problem in finding.problems)
        print(f"{name}: {len(findings)} instances, {wrong} with problems")
        for problem, times in sorted(kinds.items()):
            print(f"  {problem}: {times}")
        bad += wrong
    if arguments.check:
        return report(different, f"all poses of {platforms} random platforms, as recorded")
    return 1 if bad else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)
