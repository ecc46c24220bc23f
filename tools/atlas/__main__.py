"""Count all types and intersection numbers again: compare with data/counts, or write it.

    python -m tools.atlas verify [--fast] [--method groebner|tracking|both] [--seed N]
    python -m tools.atlas build [--check]

Without ``--fast`` everything is counted, which takes hours; ``--resume FILE`` lets it be
interrupted and continued. ``build`` writes the same bytes each time and needs msolve.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from pathlib import Path
from random import Random

from gspcli.defaults import SEED
from gspcli.errors import IncompleteError
from gspcli.resources import data_path
from tools.atlas.groebner import msolve_path
from tools.atlas.records import RecordVerdict, contents, differences, recorded, verdict
from tools.atlas.tasks import PRIMES, all_tasks, count_all
from tools.recording import CONFIRMED, DIFFERENT, UNABLE, add_workers, workers_of

#: `verify --fast` counts at most this many tasks, each of at most this many solutions.
_FAST = (40, 256)


def main() -> int:
    """Verify or build; return the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=("verify", "build"))
    parser.add_argument("--fast", action="store_true", help="a random sample of small ones")
    parser.add_argument("--method", choices=("groebner", "tracking", "both"))
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--timeout", type=float, metavar="SECONDS", help="of a Gröbner basis")
    parser.add_argument("--resume", type=Path, metavar="FILE")
    parser.add_argument("--check", action="store_true", help="compare what is built")
    add_workers(parser)
    arguments = parser.parse_args()
    try:
        return _verify(arguments) if arguments.what == "verify" else _build(arguments)
    except IncompleteError as error:
        print(f"{error}\nnothing was computed", file=sys.stderr)
        return UNABLE


def _verify(arguments: argparse.Namespace) -> int:
    chosen = arguments.method or ("both" if msolve_path() else "tracking")
    characteristics = (0,) * (chosen != "groebner") + PRIMES * (chosen != "tracking")
    tasks = all_tasks(seed=arguments.seed, characteristics=characteristics)
    if arguments.fast:
        size, largest = _FAST
        small = [task for task in tasks if recorded(task) <= largest]
        tasks = Random(arguments.seed).sample(small, size)
    results = count_all(
        tasks, journal=arguments.resume, workers=workers_of(arguments), timeout_s=arguments.timeout
    )
    verdicts = {result: verdict(result) for result in map(results.__getitem__, tasks)}
    for result, said in verdicts.items():
        if said is not RecordVerdict.EQUAL:
            print(f"{result.task}: counted {result.count}, {said.value}")
    found = Counter(verdicts.values())
    print(f"confirmed: {found[RecordVerdict.EQUAL]} of {len(verdicts)} counts")
    if found[RecordVerdict.DIFFERENT]:
        return DIFFERENT
    return UNABLE if found[RecordVerdict.UNFINISHED] else CONFIRMED


def _build(arguments: argparse.Namespace) -> int:
    results = count_all(
        all_tasks(),
        journal=arguments.resume,
        workers=workers_of(arguments),
        timeout_s=arguments.timeout,
    )
    files, folder = contents(results), data_path("counts")
    if arguments.check:
        different = differences(folder, files)
        print(f"differs: {', '.join(different)}" if different else f"{len(files)} files confirmed")
        return DIFFERENT if different else CONFIRMED
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    return CONFIRMED


if __name__ == "__main__":
    sys.exit(main())
