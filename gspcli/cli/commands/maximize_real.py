"""`gsp maximize-real`: search for a platform with many real poses."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

import click

from gspcli.cli import options
from gspcli.cli.files import check_writable, write_whole
from gspcli.cli.render import write
from gspcli.cli.specs import is_file, load_instance, read_type
from gspcli.cli.streams import progress, say
from gspcli.defaults import SEARCH_SECONDS
from gspcli.errors import INTERRUPTED, CheckFailed

if TYPE_CHECKING:
    from gspcli.reality.real_search import RealSearch, State
    from gspcli.workers import Workers


@click.command(cls=options.Command)
@options.without("--show", "--time", "--attempts", "--seed", "--jobs", "--scheduler", "--resume")
@click.argument("names", nargs=-1, required=True, metavar="TYPE|SPEC")
@options.option("--show", "Do not search: write the best known platform.")
@options.option(
    "--real",
    "Stop at N real poses; the exit code is 1 if fewer are found. With --show: the known platform "
    "with N.  [default: as many as possible, as many as known]",
    type=options.Whole(0),
)
@options.option(
    "--time SECONDS",
    "Stop after this time.",
    name="seconds",
    type=options.Positive(),
    default=SEARCH_SECONDS,
)
@options.option("--attempts", "Stop after N attempts.", name="most", type=options.Whole(1))
@options.seed_option("; an attempt depends only on it and on its number")
@options.worker_options
@options.resume_option
@options.file_option("yaml")
def command(o: options.Options) -> int:
    """Search for a platform with as many real poses as possible.

    The search begins with random platforms of TYPE, or with the instance file SPEC. It moves
    points, lines, planes and values so that pairs of complex poses come together and become real,
    and no real one is lost (after P. Dietmaier, 1998). TYPE may be a family: the kinds of the
    angles make no difference. The best platform found is rounded to short decimals, its real poses
    are certified, and it is written as an instance file. The number of its real poses, with
    both sides of PH and HP distances, is a lower bound of the largest possible number. Stderr has a
    line for each attempt.

    \b
    Examples:
      gsp maximize-real 6PP --real 40 -o forty.yaml
      gsp maximize-real 4D2A PP PP PL PL --time 600 --resume search.json
      gsp maximize-real platform.yaml --attempts 3
      gsp maximize-real 6PP --show | gsp solve -
      gsp maximize-real 6PP --show --real 0
    """
    from gspcli.spec import dumps

    if o.resume is not None:
        check_writable(o.resume)
    given = load_instance(o.names[0]) if len(o.names) == 1 and is_file(o.names[0]) else None
    gsp_type = read_type(o.names) if given is None else given.type
    if o.show:
        from gspcli.reality.witness_proofs import known_instance

        write(o.output, dumps(known_instance(gsp_type, o.real)))
        return 0

    if o.real == 0:
        raise click.UsageError("--real 0 is for --show: a search is for at least one real pose")
    from gspcli.journal import held
    from gspcli.reality.real_search import RealSearch, State, read_state

    search = RealSearch.of(gsp_type if given is None else given, o.real, o.seconds, o.seed)
    subject = search.subject
    with nullcontext() if o.resume is None else held(o.resume):
        state = read_state(o.resume, subject, o.seed) if o.resume else State(subject, o.seed)
        state, interrupted = _searched(search, state, o.most, o.workers, o.resume)
    if state.platform is None and interrupted:
        say("interrupted before the end of an attempt")
        return INTERRUPTED
    found = search.result(state)
    write(o.output, dumps(found.instance))
    say(f"{found.real} real poses, certified")
    if not interrupted and o.real is not None and found.real < o.real:
        raise CheckFailed(
            f"{o.real} real poses were asked for, {found.real} were found: give it more time"
        )
    return INTERRUPTED if interrupted else 0


def _searched(
    search: RealSearch, state: State, most: int | None, workers: Workers, resume: Path | None
) -> tuple[State, bool]:
    """Return the state after the search, and if Ctrl-C ended it; report attempts on stderr."""
    before, each = state.attempts, search.each
    steps = search.steps(state, most, workers)
    try:
        for number, found, state in progress(steps, label="searching"):
            if resume is not None:
                write_whole(resume, state.text())
            if found is not None:
                real = f"{each * found.count} of {each * len(found.points)} real"
                cut = ", cut short" if state.attempts == before else ""
                say(f"attempt {number}: {real} (best: {each * state.real}){cut}")
            before = state.attempts
    except KeyboardInterrupt:
        return state, True
    return state, False
