"""Derive data/ again and compare it with what is recorded.

    python -m tools.verify [--fast] [--jobs N] [STEP ...]

`make verify` does everything, which takes hours; `make verify-fast` all that is quick and a sample
of the rest, about a minute. Each step is a command of its own, which can be run by hand. It ends
with 0 if what it derives is what is recorded, with 1 if it is not, and with 4 if it could not be
completed, such as without Singular or msolve: that is never called verified. So does this program.
"""

from __future__ import annotations

import argparse
import os
import shlex
import subprocess
import sys
import time
from typing import NamedTuple

from tools.recording import CONFIRMED, DIFFERENT, ROOT, UNABLE

#: Where `make verify` puts msolve.
MSOLVE = "build/peers/lib/python*/site-packages/sage_wheels/bin"


class Step(NamedTuple):
    """Something that is derived again.

    Attributes
    ----------
    subject
        The records that it derives.
    command
        A program of the project, or `gsp`, with its arguments; ``{jobs}`` is the number of
        processes.
    sample
        What to add for a sample; None leaves it out of the fast run.
    """

    subject: str
    command: str
    sample: str | None = ""

    def words(self, *, fast: bool, jobs: int) -> list[str]:
        """Return the command."""
        words = shlex.split(f"{self.command} {(self.sample or '') if fast else ''}")
        module = "gspcli" if words[0] == "gsp" else words[0]
        return [sys.executable, "-m", module, *(word.format(jobs=jobs) for word in words[1:])]


STEPS = {
    "paper": Step("data/paper", "gsp table all --check"),
    "schema": Step("data/instance.schema.json", "tools.data.schema --check"),
    "constraints": Step("data/constraints.json", "tools.data.constraints --check"),
    "varieties": Step("data/varieties.json", "tools.data.varieties --check"),
    "start-systems": Step("data/start-systems", "tools.data.start_systems --check", "--sample 20"),
    "examples": Step(
        "data/examples, data/platforms", "tools.data.example_counts --check", "--sample 12"
    ),
    "examples-groebner": Step(
        "data/examples, data/platforms",
        "tools.data.example_counts --check --groebner",
        "--sample 6",
    ),
    "shared-joints": Step(
        "tests/oracles/records/coincident-platforms.csv", "tools.data.coincident_counts --check"
    ),
    "shared-joints-groebner": Step(
        "tests/oracles/records/coincident-platforms.csv",
        "tools.data.coincident_counts --check --groebner",
        "--sample 6",
    ),
    "tracking": Step("data/counts", "tools.atlas verify --method tracking --jobs {jobs}", "--fast"),
    "groebner": Step("data/counts", "tools.atlas verify --method groebner --jobs {jobs}", "--fast"),
    "exact-counts": Step(
        "data/counts/families.csv", "tools.data.family_counts --check", "--sample 25"
    ),
    "witnesses": Step(
        "data/witnesses", "tools.data.witnesses --check --jobs {jobs}", "--sample 40"
    ),
    "view": Step("data/view", "viewer.pages --check"),
    "live-module": Step("data/live", "viewer.kernel --check --jobs {jobs}", None),
}
RESULTS = {CONFIRMED: "confirmed", UNABLE: "NOT VERIFIED", DIFFERENT: "DIFFERS"}


def run(step: Step, *, fast: bool, jobs: int) -> tuple[int, str]:
    """Run a step; return its exit code and what it prints."""
    folders = [*map(str, ROOT.glob(MSOLVE)), os.environ.get("PATH", os.defpath)]
    one_thread = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL")}
    done = subprocess.run(
        step.words(fast=fast, jobs=jobs),
        stdout=subprocess.PIPE,
        text=True,
        cwd=ROOT,
        env={**os.environ, **one_thread, "PATH": os.pathsep.join(folders)},
        check=False,
    )
    # An exception ends Python with 1 too, but what differs is printed.
    failed = done.returncode == DIFFERENT and not done.stdout
    return -1 if failed else done.returncode, done.stdout.strip()


def main() -> int:
    """Verify; return the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m tools.verify",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--fast", action="store_true", help="a sample of what takes long")
    parser.add_argument("--jobs", type=int, default=1, metavar="N", help="processes at work")
    parser.add_argument("steps", nargs="*", metavar="STEP", help=f"of {', '.join(STEPS)}")
    arguments = parser.parse_args()
    if unknown := sorted(set(arguments.steps) - set(STEPS)):
        parser.error(f"found {', '.join(unknown)}, expected steps: {', '.join(STEPS)}")
    quick = [name for name, step in STEPS.items() if step.sample is not None]
    codes = []
    for name in arguments.steps or (quick if arguments.fast else STEPS):
        began = time.monotonic()
        code, printed = run(STEPS[name], fast=arguments.fast, jobs=arguments.jobs)
        seconds = f"{time.monotonic() - began:.1f} s"
        said = printed if code else printed.rpartition("\n")[2].removeprefix("confirmed: ")
        print(f"{name:22}  {RESULTS.get(code, 'FAILED'):12}  {seconds:>8}  {said}", flush=True)
        codes.append(code)
    wrong = any(code not in (CONFIRMED, UNABLE) for code in codes)
    return DIFFERENT if wrong else UNABLE if UNABLE in codes else CONFIRMED


if __name__ == "__main__":
    sys.exit(main())
