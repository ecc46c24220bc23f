"""Derive data/ and the generated documentation again and compare them with what is recorded.

    python tools/verify.py [--fast] [--jobs N] [STEP ...]

`make verify` does everything, which takes hours; `make verify-fast` all that is quick and a sample
of the rest, about a minute. Each step is a command of its own, which can be run by hand. It ends
with 0 if what it derives is what is recorded, with 1 if it is not, and with 4 if it could not be
completed, such as without Singular or msolve: that is never called verified. So does this program.
Interrupted, the same command takes up the long steps again, unless a program has changed.
"""

from __future__ import annotations

import argparse
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from recording import CONFIRMED, DIFFERENT, ROOT, UNABLE, sources_sha256

sys.path.insert(0, str(ROOT))

from gspcli.cli.output import Column, Output, Table, emit
from gspcli.errors import INTERRUPTED

WORK = ROOT / "build" / "verify"
#: What the answers come from: work files of other sources are not used.
SOURCES = ("native", "gspcli", "data/start-systems")
#: Where `make verify` puts msolve.
MSOLVE = "build/peers/lib/python*/site-packages/sage_wheels/bin"


@dataclass(frozen=True)
class Step:
    """Something that is derived again.

    Attributes
    ----------
    name
        Its name on the command line.
    subject
        The records that it derives: patterns of files in the project.
    command
        A program in tools/, or `gsp`, with its arguments.
    whole, sample
        What to add for all of it, and for a sample; None leaves it out of the fast run. In the
        command ``{jobs}`` and ``{work}`` are the number of processes and the folder of work files.
    """

    name: str
    subject: tuple[str, ...]
    command: str
    whole: str = ""
    sample: str | None = ""

    def words(self, *, fast: bool, jobs: int, work: Path) -> list[str]:
        """Return the command."""
        more = self.whole if self.sample is None or not fast else self.sample
        words = shlex.split(f"{self.command} {more}")
        program = ["-m", "gspcli"] if words[0] == "gsp" else [str(ROOT / words[0])]
        rest = (word.format(jobs=jobs, work=work) for word in words[1:])
        return [sys.executable, *program, *rest]


STEPS = (
    Step("paper", ("data/paper/*",), "gsp table all --check"),
    Step("constraints", ("data/constraints.json",), "tools/build_constraints.py --check"),
    Step("varieties", ("data/varieties.json",), "tools/build_varieties.py --check"),
    Step(
        "start-systems",
        ("data/start-systems/*",),
        "tools/build_start_systems.py --check",
        sample="--sample 20",
    ),
    Step(
        "examples",
        ("data/examples/*", "data/platforms/*"),
        "tools/build_example_counts.py --check",
        sample="--sample 12",
    ),
    Step(
        "examples-groebner",
        ("data/examples/*", "data/platforms/*"),
        "tools/build_example_counts.py --check --groebner",
        sample="--sample 6",
    ),
    Step("output", ("docs/output.md", "docs/schemas/*"), "tools/build_output_reference.py --check"),
    Step(
        "shared-joints",
        ("data/verification/coincident-platforms*",),
        "tools/build_coincident_counts.py --check",
    ),
    Step(
        "shared-joints-groebner",
        ("data/verification/coincident-platforms*",),
        "tools/build_coincident_counts.py --check --groebner",
        sample="--sample 6",
    ),
    Step(
        "special-platforms",
        ("data/verification/special-platforms.csv", "data/verification/published-hexapods.json"),
        "tools/verify_special.py count --check --jobs {jobs}",
        sample="--sample 12 --without-real",
    ),
    Step(
        "special-answers",
        ("data/verification/special-platforms.csv",),
        "tools/verify_special.py solve --check --jobs {jobs}",
        sample="--sample 12 --seeds 1",
    ),
    Step(
        "special-batches",
        ("data/verification/special-platforms.csv",),
        "tools/verify_special.py batches --check --jobs {jobs}",
        sample="--sample 8",
    ),
    Step(
        "special-certificates",
        ("data/verification/special-platforms.csv",),
        "tools/verify_special.py certify --check --jobs {jobs}",
        whole="--sample 200",
        sample="--sample 4",
    ),
    Step(
        "tracking",
        ("data/counts/*",),
        "gsp atlas verify --method tracking --jobs {jobs}",
        whole="--work {work}/tracking.jsonl",
        sample="--fast",
    ),
    Step(
        "groebner",
        ("data/counts/*",),
        "gsp atlas verify --method groebner --jobs {jobs}",
        whole="--work {work}/groebner.jsonl",
        sample="--fast",
    ),
    Step(
        "exact-counts",
        ("data/counts/families.csv",),
        "tools/count_families.py --check",
        sample="--sample 25",
    ),
    Step(
        "witnesses",
        ("data/witnesses/real.csv", "data/witnesses/manifest.json"),
        "tools/build_witnesses.py check --jobs {jobs}",
        sample="--sample 12",
    ),
    Step(
        "real-page",
        ("docs/real-counts.md", "docs/images/real-families.svg"),
        "tools/build_real_page.py --check",
    ),
    Step(
        "real-counts",
        ("data/witnesses/counts.csv", "data/witnesses/counts.manifest.json"),
        "tools/build_real_counts.py check --jobs {jobs}",
        sample="--sample 40",
    ),
    Step(
        "solve",
        (
            "data/verification/platforms-6-6.csv",
            "data/verification/families.csv",
            "data/verification/batches.csv",
            "data/verification/manifest.json",
            "docs/completeness.md",
        ),
        "tools/verify_solve.py all --check --jobs {jobs} --work {work}",
        sample="--sample 3",
    ),
    Step(
        "tracks",
        ("data/verification/tracks.csv", "data/trajectories/*"),
        "tools/verify_tracks.py --check --jobs {jobs} --work {work}",
        sample="--sample 2",
    ),
    Step(
        "round-trips",
        ("data/verification/round-trips.csv",),
        "tools/verify_round_trips.py --check --jobs {jobs} --work {work}",
        sample="--sample 20",
    ),
    Step(
        "clearances",
        ("data/verification/clearances.csv",),
        "tools/verify_clearances.py --check --jobs {jobs}",
        sample="--sample 2",
    ),
    Step(
        "sensors",
        ("data/verification/sensors*", "docs/sensors.md"),
        "tools/verify_sensors.py --check --jobs {jobs}",
        sample="--sample 3",
    ),
    Step("view", ("data/view/*",), "tools/build_view.py --check"),
    Step(
        "distribution",
        ("docs/real-counts.md", "docs/images/real-6-6.svg"),
        "tools/build_distribution.py --check --jobs {jobs}",
        sample=None,
    ),
    Step("latex", (), "tools/verify_latex.py --check", sample=None),
    Step("schema", ("docs/instance.schema.json",), "tools/build_schema.py --check"),
    Step(
        "pages",
        ("docs/commands.md", "docs/errata.md", "docs/geometry-counts.md"),
        "tools/build_docs.py --check",
    ),
    Step(
        "counts-page",
        ("docs/counts.md", "docs/images/counts.svg"),
        "tools/build_counts.py --docs --check",
    ),
    Step(
        "pictures",
        ("docs/images/bound.svg", "docs/images/enumerate.svg", "docs/images/solve.svg"),
        "tools/build_pictures.py --check",
    ),
    Step(
        "drawings",
        (
            "docs/images/example-6.8.svg",
            "docs/images/figure-1*.svg",
            "docs/images/[AD]??*.svg",
            "docs/images/platforms/*.svg",
        ),
        "tools/build_drawings.py --check",
    ),
)


@dataclass(frozen=True)
class Outcome:
    """How a step ended: its exit code, what it printed and how long it took."""

    step: Step
    code: int
    printed: str
    seconds: float

    @property
    def result(self) -> str:
        """The exit code in words."""
        if self.code == CONFIRMED:
            return "confirmed"
        if self.code == UNABLE:
            return "NOT VERIFIED"
        # An exception ends Python with 1 too, but what differs is printed.
        return "DIFFERS" if self.code == DIFFERENT and self.printed else f"FAILED ({self.code})"

    @property
    def row(self) -> dict[str, object]:
        """The row of the summary."""
        last = self.printed.strip().rpartition("\n")[2]
        return {
            "step": self.step.name,
            "result": self.result,
            "seconds": f"{self.seconds:.1f}",
            "what": last.removeprefix("confirmed: ") if self.code == CONFIRMED else "",
        }


def run(step: Step, *, fast: bool, jobs: int, work: Path) -> Outcome:
    """Run a step; its complaints and progress go to standard error."""
    folders = [*map(str, ROOT.glob(MSOLVE)), os.environ.get("PATH", os.defpath)]
    one_thread = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL")}
    environment = {**os.environ, **one_thread, "PATH": os.pathsep.join(folders)}
    began = time.monotonic()
    done = subprocess.run(
        step.words(fast=fast, jobs=jobs, work=work),
        stdout=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        env=environment,
        check=False,
    )
    return Outcome(step, done.returncode, done.stdout, time.monotonic() - began)


def verify(
    steps: Sequence[Step], outcomes: list[Outcome], *, fast: bool, jobs: int, work: Path
) -> None:
    """Run the steps and add what comes out."""
    for number, step in enumerate(steps, start=1):
        print(f"{number} of {len(steps)}: {step.name}", file=sys.stderr, flush=True)
        outcome = run(step, fast=fast, jobs=jobs, work=work)
        outcomes.append(outcome)
        if outcome.code != CONFIRMED:
            print(outcome.printed, end="", file=sys.stderr, flush=True)


def conclude(outcomes: Sequence[Outcome]) -> int:
    """Print the summary and return the exit code."""
    columns = [
        Column("step", essential=True),
        Column("result", essential=True),
        Column("seconds", align="right", essential=True),
        Column("what", "what was derived again"),
    ]
    unable = [o.step.name for o in outcomes if o.code == UNABLE]
    wrong = [o.step.name for o in outcomes if o.code not in (CONFIRMED, UNABLE)]
    notes = []
    if unable:
        notes.append(f"not verified, for the reasons above: {', '.join(unable)}")
    if wrong:
        notes.append(f"different from the record, or failed: {', '.join(wrong)}")
    emit(Output("table", None), Table(columns, [o.row for o in outcomes], notes=notes))
    return DIFFERENT if wrong else UNABLE if unable else CONFIRMED


def main() -> int:
    """Verify; return the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    names = [step.name for step in STEPS]
    parser.add_argument("--fast", action="store_true", help="samples of what takes long")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes")
    parser.add_argument("steps", nargs="*", metavar="STEP", help=f"of {', '.join(names)}")
    arguments = parser.parse_args()
    if unknown := set(arguments.steps) - set(names):
        parser.error(f"no such step: {', '.join(sorted(unknown))}; there are {', '.join(names)}")
    quick = [step.name for step in STEPS if step.sample is not None]
    chosen = arguments.steps or (quick if arguments.fast else names)
    steps = [step for step in STEPS if step.name in chosen]
    work = WORK / sources_sha256(SOURCES)[:12]
    if arguments.fast:
        work = Path(tempfile.mkdtemp())
    work.mkdir(parents=True, exist_ok=True)
    outcomes: list[Outcome] = []
    try:
        verify(steps, outcomes, fast=arguments.fast, jobs=arguments.jobs, work=work)
    except KeyboardInterrupt:
        conclude(outcomes)
        print("interrupted: the same command takes up the long steps again", file=sys.stderr)
        return INTERRUPTED
    finally:
        if arguments.fast:
            shutil.rmtree(work)
    code = conclude(outcomes)
    if code == CONFIRMED and not arguments.fast:
        # Next time everything is derived anew.
        shutil.rmtree(work)
    return code


if __name__ == "__main__":
    sys.exit(main())
