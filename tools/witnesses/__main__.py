"""Platforms with many real solutions: looked for, recorded in `data/witnesses/`, and checked.

    python -m tools.witnesses search JOURNAL [--minutes N] [--effort PATHS] [--most SOLUTIONS]
    python -m tools.witnesses lift JOURNAL [--most SOLUTIONS] [--below SHARE]
    python -m tools.witnesses construct JOURNAL [--seconds N] [--minutes N] [--most SOLUTIONS]
        [--below SHARE]
    python -m tools.witnesses shake JOURNAL FAMILY... [--tries N] [--seed N]
    python -m tools.witnesses write JOURNAL
    python -m tools.witnesses check [--sample N]

The first four are ways to find platforms: attempts at random (`search.py`), from platforms of
simpler families (`lift.py`), with lines split into pairs of planes (`construct.py`), by small
changes (`shake.py`). What they find is appended to the journal, a work file, where each begins with
what is known. `write` rounds the best platform of each family to short decimals, certifies its real
poses and records it, if it is better than what is recorded. `check` solves every recorded platform
and certifies its real poses again; it exits with 1 if there are fewer. `search` and `check` take
--jobs N, or --scheduler ADDRESS for the workers of a Dask scheduler.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from gspcli.defaults import SEED
from tools.recording import CONFIRMED, add_sample, add_workers, workers_of
from tools.witnesses import best
from tools.witnesses.construct import construct
from tools.witnesses.known import Known
from tools.witnesses.lift import lift
from tools.witnesses.search import EFFORT, search
from tools.witnesses.shake import shake


def command_line() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    journal, minutes, most, below = (argparse.ArgumentParser(add_help=False) for _ in range(4))
    journal.add_argument("journal", type=Path, metavar="JOURNAL")
    minutes.add_argument("--minutes", type=float, default=60.0, metavar="N")
    most.add_argument("--most", type=int, default=10_000, metavar="SOLUTIONS")
    below.add_argument("--below", type=float, default=1.0, metavar="SHARE")
    parser = argparse.ArgumentParser(
        prog="python -m tools.witnesses",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parts = parser.add_subparsers(dest="part", required=True)
    part = parts.add_parser("search", parents=[journal, minutes, most])
    part.add_argument("--effort", type=int, default=EFFORT, metavar="PATHS")
    add_workers(part)
    parts.add_parser("lift", parents=[journal, most, below])
    part = parts.add_parser("construct", parents=[journal, minutes, most, below])
    part.add_argument("--seconds", type=float, default=5.0, metavar="N", help="for each pattern")
    part = parts.add_parser("shake", parents=[journal])
    part.add_argument("families", nargs="+", metavar="FAMILY")
    part.add_argument("--tries", type=int, default=300, metavar="N")
    part.add_argument("--seed", type=int, default=SEED, metavar="N")
    parts.add_parser("write", parents=[journal])
    part = parts.add_parser("check")
    add_sample(part)
    add_workers(part)
    return parser


def main() -> int:
    """Run the part that the command line asks for; return the exit code."""
    asked = command_line().parse_args()
    if asked.part == "check":
        return best.check(asked.sample, workers_of(asked))
    known = Known(asked.journal)
    if asked.part == "write":
        best.write(asked.journal)
    elif asked.part == "search":
        search(known, asked.minutes, asked.effort, asked.most, workers_of(asked))
    elif asked.part == "lift":
        lift(known, asked.most, asked.below)
    elif asked.part == "construct":
        construct(known, asked.seconds, asked.minutes, asked.most, asked.below)
    else:
        shake(known, asked.families, asked.tries, asked.seed)
    return CONFIRMED


if __name__ == "__main__":
    sys.exit(main())
