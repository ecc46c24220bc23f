"""`gsp maximize-real`: search for a platform with many real poses."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from gspcli.cli.names import is_file, load_instance, read_type
from gspcli.cli.number_types import Positive, Seed, Whole
from gspcli.cli.output import Output, check_writable, write, write_whole
from gspcli.cli.progress_bars import progress
from gspcli.cli.streams import say
from gspcli.cli.worker_options import worker_options
from gspcli.defaults import SEED
from gspcli.errors import INTERRUPTED, CheckFailed, GspError, IncompleteError

if TYPE_CHECKING:
    from gspcli.catalogue.types import GspType
    from gspcli.geometry.instance import Instance, Units
    from gspcli.reality.maximize import Search
    from gspcli.reality.state import State
    from gspcli.workers import Workers


@click.command()
@click.argument("names", nargs=-1, required=True, metavar="TYPE|SPEC")
@click.option("--show", is_flag=True, help="Do not search: write the best known platform.")
@click.option(
    "--real",
    "wanted_real",
    type=Whole(0),
    help="With --show: a known platform with so many real poses.  [default: as many as known]",
)
@click.option(
    "--target",
    type=Whole(1),
    help="Stop at so many real poses; exit code 1 if they are not reached.  [default: all]",
)
@click.option(
    "--time",
    "seconds",
    type=Positive(),
    default=60.0,
    show_default=True,
    help="Stop after so many seconds.",
)
@click.option("--attempts", "most", type=Whole(1), help="Stop after so many attempts in all.")
@click.option(
    "--seed",
    default=SEED,
    show_default=True,
    type=Seed(),
    help="Seed of the random numbers; attempts depend on it and on their number only.",
)
@worker_options
@click.option(
    "--state",
    "state_file",
    metavar="FILE",
    help="Continue from FILE, and save what is found there.",
)
@click.option(
    "-o", "--output", "path", metavar="FILE", help="Write to FILE instead of stdout, replacing it."
)
def command(
    names: tuple[str, ...],
    show: bool,
    wanted_real: int | None,
    target: int | None,
    seconds: float,
    most: int | None,
    seed: int,
    workers: Workers,
    state_file: str | None,
    path: str | None,
) -> int:
    """Search for a platform with as many real poses as possible.

    The search begins with random platforms of TYPE, or with the instance file SPEC, and moves
    points, lines, planes and values so that pairs of complex poses come together and become
    real, without losing a real one (after P. Dietmaier, 1998). TYPE may be a family: the kinds
    of the angles make no difference. The best platform found is rounded to short decimals, its
    real poses are certified, and it is written as an instance file. Their number, sides of PH
    and HP distances left open, is a lower bound of what is possible. A line for each attempt
    goes to stderr.

    \b
    Examples:
      gsp maximize-real 6PP --target 40 -o forty.yaml
      gsp maximize-real 4D2A PP PP PL PL --time 600 --state search.json
      gsp maximize-real platform.yaml --attempts 3
      gsp maximize-real 6PP --show | gsp solve -
      gsp maximize-real 6PP --show --real 0
    """
    from gspcli.spec import dumps

    output = _writable_output(path, state_file)
    given = load_instance(names[0]) if len(names) == 1 and is_file(names[0]) else None
    gsp_type = read_type(names) if given is None else given.type
    if show:
        _show_known(gsp_type, wanted_real, output)
        return 0
    if wanted_real is not None:
        message = "--real chooses what --show writes: add --show, or search with --target"
        raise click.UsageError(message)

    from gspcli.reality.maximize import Search
    from gspcli.reality.platforms import multiplier, reduced
    from gspcli.reality.state import State, read_state
    from gspcli.reality.witness_proofs import DEFAULT_UNITS, platform_of

    kinds, start, length, units = gsp_type.kinds, None, 1.0, DEFAULT_UNITS
    if given is not None:
        platform, length = platform_of(given)
        kinds, start, units = platform.kinds, reduced(platform), given.units
    each = multiplier(kinds)
    wanted = None if target is None else -(-target // each)
    search = Search(kinds, seed, wanted, start, time.time() + seconds)
    subject = gsp_type.id if given is None else dumps(given)
    state = (
        State(subject, seed) if state_file is None else read_state(Path(state_file), subject, seed)
    )
    interrupted = False
    try:
        state = _searched(search, state, most, workers, state_file)
    except _Interrupted as interruption:
        state, interrupted = interruption.state, True
    if state.platform is None:
        if interrupted:
            say("interrupted before the end of an attempt")
            return INTERRUPTED
        message = "no platform was solved in the time given: use a greater --time"
        raise IncompleteError(message)
    instance, real = _witness(state, each, units, length)
    write(output, dumps(instance))
    say(f"{real} real poses, certified")
    if not interrupted and target is not None and real < target:
        message = f"{target} real poses were asked for, {real} were found: give it more time"
        raise CheckFailed(message)
    return INTERRUPTED if interrupted else 0


class _Interrupted(Exception):
    """Ctrl-C, with what is known so far."""

    def __init__(self, state: State) -> None:
        self.state = state


def _writable_output(path: str | None, state_file: str | None) -> Output:
    """Return where the platform goes, once it is sure that both files can be written."""
    output = Output("yaml", None if path in (None, "-") else Path(str(path)))
    for file in (output.path, state_file):
        if file is not None:
            check_writable(Path(file))
    return output


def _show_known(gsp_type: GspType, real: int | None, output: Output) -> None:
    """Write the best known platform, or one with so many real poses."""
    from gspcli.reality.witness_proofs import known_instance
    from gspcli.spec import dumps

    _reject_search_options()
    write(output, dumps(known_instance(gsp_type, real)))


def _reject_search_options() -> None:
    """Complain of options for the search where none is made."""
    context = click.get_current_context()
    ignored = [
        parameter.opts[0]
        for parameter in context.command.params
        if parameter.name not in ("names", "show", "wanted_real", "path")
        and context.get_parameter_source(str(parameter.name)) is ParameterSource.COMMANDLINE
    ]
    if ignored:
        message = f"--show makes no search: leave out {', '.join(ignored)}"
        raise click.UsageError(message)


def _searched(
    search: Search, state: State, most: int | None, workers: Workers, state_file: str | None
) -> State:
    """Return the state after the search; reports each attempt on stderr."""
    from gspcli.continuation.start import path_count
    from gspcli.reality.maximize import attempts
    from gspcli.reality.platforms import multiplier

    each = multiplier(search.kinds)
    everything = path_count(search.structure)
    goal = everything if search.target is None else min(search.target, everything)
    if state.real >= goal or (most is not None and state.attempts >= most):
        return state
    try:
        made = attempts(search, state.attempts, most, workers)
        for number, found in progress(made, label="searching"):
            # An attempt that the deadline cut short is not done, but may have found something.
            after = state.after(number, found)
            cut = search.is_late
            state = replace(after, attempts=state.attempts) if cut else after
            if state_file is not None:
                write_whole(Path(state_file), state.text())
            if found is not None:
                say(
                    f"attempt {number}: {each * found.count} of {each * len(found.points)} real"
                    f" (best: {each * state.real})" + (", cut short" if cut else "")
                )
            if state.real >= goal or cut or (most is not None and state.attempts >= most):
                break
    except KeyboardInterrupt:
        raise _Interrupted(state) from None
    return state


def _witness(state: State, each: int, units: Units, length: float) -> tuple[Instance, int]:
    """Return the instance and how many real poses of it are certified."""
    from gspcli.reality.witness_proofs import certified_real, real_instance

    assert state.platform is not None
    instance = real_instance(state.platform, each * state.real, units=units, length=length)
    real = certified_real(instance)
    if real < each * state.real:
        message = f"only {real} of {each * state.real} real poses could be certified"
        raise GspError(message)
    return replace(instance, name=f"{instance.type.family.id} with {real} real poses"), real
