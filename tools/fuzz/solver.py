"""Compare answers of `gsp` about random special platforms with exact counts of other programs.

    python -m tools.fuzz.solver [--count N] [--first K] [--jobs N] [--most POSES] [--without-real]

They are those of the campaign's mixtures with other random numbers, and crowds of primitives in a
few places (`special/crowds.py`). Each is counted by msolve and Singular (`special/counts.py`) and
solved with several seeds (`special/answers.py`). The files of those of which something wrong is
said are written to build/attacks. The exit code is 1 then, and 4 if nothing could be counted.
Platforms that the other programs cannot count in time are listed, and not compared.
"""

from __future__ import annotations

import argparse
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from itertools import count as numbers
from types import FrameType

from gspcli import dumps
from gspcli.cli.streams import progress
from tools.oracle import msolve, singular
from tools.recording import CONFIRMED, DIFFERENT, ROOT, UNABLE, add_workers, workers_of
from tools.special.answers import Answer, Judgement, answers
from tools.special.counts import counted
from tools.special.crowds import crowd
from tools.special.mixtures import mixture
from tools.special.parts import Draws
from tools.special.platforms import Platform

FILES = ROOT / "build" / "attacks"
MAKERS = {"crowd": crowd, "mixture": mixture}
#: The other programs are given so long for a platform.
COUNT_LIMIT_S = 120

Tried = tuple[str, dict[str, str] | None, list[Answer], str]


def platform(number: int, most: int) -> Platform:
    """Return one of the platforms, of a type with at most this many poses."""
    name = list(MAKERS)[number % len(MAKERS)]
    for attempt in numbers():
        try:
            instance = MAKERS[name](Draws(f"attack {number} {attempt}"))
        except ValueError:
            continue
        if instance.expected <= most:
            break
    return Platform(f"{name}/{number}", dumps(instance))


def tried(number: int, *, most: int, seeds: int, with_real: bool) -> Tried:
    """Return the row of a platform, None if it was not counted, the answers, and what failed."""
    drawn = platform(number, most)
    name, found, failure = answers(drawn, seeds)
    try:
        with _limited(COUNT_LIMIT_S):
            row = counted(drawn, with_real=with_real)
    except Exception as error:
        return name, None, found, failure or repr(error)[:200]
    return name, {key: str(value) for key, value in row.items()}, found, failure


@contextmanager
def _limited(seconds: int) -> Iterator[None]:
    """Raise TimeoutError in what takes longer; programs that it waits for are ended."""

    def end(number: int, frame: FrameType | None) -> None:
        message = f"not within {seconds} s"
        raise TimeoutError(message)

    before = signal.signal(signal.SIGALRM, end)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def main() -> int:
    """Attack; return the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--count", type=int, default=200, metavar="N", help="how many platforms")
    parser.add_argument("--first", type=int, default=0, metavar="K", help="number of the first")
    add_workers(parser)
    parser.add_argument("--most", type=int, default=96, metavar="POSES", help="of the types")
    parser.add_argument("--seeds", type=int, default=2, metavar="N", help="each solved so often")
    parser.add_argument("--slow", type=float, default=5.0, metavar="SECONDS", help="to be named")
    parser.add_argument("--without-real", dest="with_real", action="store_false")
    arguments = parser.parse_args()
    # Without either of them this ends here.
    msolve.version()
    singular.version()
    judgement, uncounted = Judgement(), 0
    asked = partial(
        tried, most=arguments.most, seeds=arguments.seeds, with_real=arguments.with_real
    )
    chosen = range(arguments.first, arguments.first + arguments.count)
    work = workers_of(arguments).as_completed(asked, chosen)
    for name, row, found, failure in progress(work, total=len(chosen), label="attacking"):
        if row is None:
            uncounted += 1
            print(f"{name}: not counted: {failure}", flush=True)
            continue
        wrong = judgement.wrong
        judgement.add(name, found, failure, row, arguments.slow)
        if name in judgement.remarks:
            print(f"{name}: {judgement.remarks[name]}", flush=True)
        if judgement.wrong > wrong:
            drawn = platform(int(name.partition("/")[2]), arguments.most)
            FILES.mkdir(parents=True, exist_ok=True)
            (FILES / f"{name.replace('/', '_')}.yaml").write_text(drawn.text, encoding="utf-8")
    print(f"\n{judgement.text()}\n")
    if judgement.wrong:
        return DIFFERENT
    if uncounted == len(chosen):
        return UNABLE
    total = judgement.total
    print(
        f"confirmed: {len(chosen) - uncounted} of {len(chosen)} platforms: none wrong, "
        f"{total['right']} right, {total['proved']} of them proved; {total['incomplete']} honestly "
        f"incomplete; {uncounted} not counted"
    )
    return CONFIRMED


if __name__ == "__main__":
    sys.exit(main())
