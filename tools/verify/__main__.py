"""Derive data/ and the generated documentation again and compare them with what is recorded.

    python -m tools.verify [--fast] [--jobs N] [STEP ...]

`make verify` does everything, which takes hours; `make verify-fast` all that is quick and a sample
of the rest, about a minute. Each step is a command of its own, which can be run by hand. It ends
with 0 if what it derives is what is recorded, with 1 if it is not, and with 4 if it could not be
completed, such as without Singular or msolve: that is never called verified. So does this program.
Interrupted, the same command takes up the long steps again, unless a program has changed.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from gspcli.cli.render import Output, emit
from gspcli.cli.result import Field, Result
from gspcli.errors import INTERRUPTED
from tools.recording import CONFIRMED, DIFFERENT, ROOT, UNABLE, sources_sha256
from tools.verify.campaigns import SOURCES, WORK
from tools.verify.steps import STEPS, Step

#: Where `make verify` puts msolve.
MSOLVE = "build/peers/lib/python*/site-packages/sage_wheels/bin"


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
    """Run the steps and add their results."""
    for number, step in enumerate(steps, start=1):
        print(f"{number} of {len(steps)}: {step.name}", file=sys.stderr, flush=True)
        outcome = run(step, fast=fast, jobs=jobs, work=work)
        outcomes.append(outcome)
        if outcome.code != CONFIRMED:
            print(outcome.printed, end="", file=sys.stderr, flush=True)


def conclude(outcomes: Sequence[Outcome]) -> int:
    """Print the summary and return the exit code."""
    columns = [
        Field("step", essential=True),
        Field("result", essential=True),
        Field("seconds", align="right", essential=True),
        Field("what", "what was derived again"),
    ]
    unable = [o.step.name for o in outcomes if o.code == UNABLE]
    wrong = [o.step.name for o in outcomes if o.code not in (CONFIRMED, UNABLE)]
    notes = []
    if unable:
        notes.append(f"not verified, for the reasons above: {', '.join(unable)}")
    if wrong:
        notes.append(f"different from the record, or failed: {', '.join(wrong)}")
    emit(Output("table", None), Result(columns, [o.row for o in outcomes], notes=notes))
    return DIFFERENT if wrong else UNABLE if unable else CONFIRMED


def main() -> int:
    """Verify; return the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m tools.verify",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
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
        # Next time everything is derived again.
        shutil.rmtree(work)
    return code


if __name__ == "__main__":
    sys.exit(main())
