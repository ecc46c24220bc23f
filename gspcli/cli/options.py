"""How commands and their options are declared; the options that many commands have."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Final, TypeVar

import click
from click.core import ParameterSource

from gspcli.cli.render import Output
from gspcli.cli.streams import say
from gspcli.defaults import SEED
from gspcli.errors import ArgumentError, GspError
from gspcli.wording import listed, shortened, shown

if TYPE_CHECKING:
    from gspcli.cli.specs import Changes
    from gspcli.geometry.frames import PoseFrame
    from gspcli.geometry.instance import Instance
    from gspcli.motion import PoseFormat
    from gspcli.workers import Workers

FORMATS = ("table", "csv", "json", "markdown", "latex")
#: Formats of pictures on paper.
DRAWINGS = ("svg", "png", "pdf")
_SUFFIXES = {
    ".csv": "csv",
    ".json": "json",
    ".jsonl": "jsonl",
    ".md": "markdown",
    ".tex": "latex",
    ".txt": "table",
    ".svg": "svg",
    ".png": "png",
    ".pdf": "pdf",
    ".html": "html",
    ".yaml": "yaml",
}

Function = TypeVar("Function", bound=Callable[..., Any])

#: The word for the home mode.
HOME: Final = "home"
#: The option for poses relative to home.
RELATIVE = "--relative-to"


def order_named(option: str, text: str) -> str:
    """Return the order of axes that an option names; the order of a maker is printed on stderr."""
    from gspcli.geometry.euler import MAKERS, named_order

    order = named_order(text)
    if text.strip().lower() in MAKERS:
        say(f"{option} {text}: the order {order}, about the axes of the platform")
    return order


class Options(SimpleNamespace):
    """What the command line says: each option and argument of a command by its name.

    Commands take it as one object, `o`, and pass it on.
    """

    @cached_property
    def instance(self) -> Instance:
        """The platform of SPEC, with the values of ``--set`` and ``--delta``."""
        from gspcli.cli.specs import load_instance

        return load_instance(self.spec, self.changes)

    @property
    def changes(self) -> Changes:
        """The changes that `value_options` are about."""
        from gspcli.cli.specs import Changes

        return Changes(vars(self).get("settings", ()), vars(self).get("differences", ()))

    @property
    def conventions(self) -> list[str]:
        """The options that are given of `pose_options` and `column_options`."""
        given = vars(self)
        names = {
            "--euler": "euler",
            "--pivot": "pivot",
            RELATIVE: "relative_to",
            "--ignore": "ignore",
            "--columns": "column_names",
        }
        return [option for option, name in names.items() if given.get(name)]

    @cached_property
    def form(self) -> PoseFormat:
        """The form of poses by the options and the platform of SPEC."""
        return self.form_of(self.instance)

    def form_of(self, instance: Instance | None) -> PoseFormat:
        """Return the form of poses by the options and an instance, if there is one."""
        from gspcli.motion import PoseFormat
        from gspcli.motion.files.pose_files import pivot_from_text

        given = vars(self)
        form = PoseFormat(
            None if self.euler is None else order_named("--euler", self.euler),
            (0.0, 0.0, 0.0) if self.pivot is None else pivot_from_text(self.pivot),
            ignore=given.get("ignore", ()),
            columns=given.get("column_names", ()),
            note=say,
        )
        if instance is None:
            if self.relative_to is not None:
                raise GspError(f"{RELATIVE} {HOME}: there is no platform that states a home")
            return form
        return replace(
            form,
            in_radians=instance.units.angle.in_radians,
            length=instance.units.length,
            frame=self.frame_of(instance),
        )

    def frame_of(self, instance: Instance) -> PoseFrame:
        """Return the frame in which poses are printed; quicker than `form`, which has it, too."""
        from gspcli.geometry.frames import PoseFrame

        try:
            return PoseFrame.of(instance, relative=self.relative_to is not None)
        except ArgumentError as error:
            raise GspError(f"{RELATIVE} {HOME}: {error}") from None

    @property
    def workers(self) -> Workers:
        """Where the work is done, by `worker_options`."""
        from gspcli.workers import Workers

        return Workers(self.jobs, self.scheduler)


class Command(click.Command):
    """A command whose help has examples first, then options in groups, then the text.

    Its function gets one argument: `Options`.
    """

    def format_help(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the help."""
        from gspcli.cli.help import write_help

        write_help(self, ctx, formatter)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command, unless options are given that do not go together."""
        assert self.callback is not None
        given, streams = set(), []
        for parameter in self.params:
            name = parameter.opts[-1]
            if isinstance(parameter, click.Argument):
                name = str(parameter.metavar or parameter.name).strip("[].")
            if ctx.get_parameter_source(str(parameter.name)) is ParameterSource.COMMANDLINE:
                given.add(name)
            value = ctx.params.get(str(parameter.name))
            is_stream = isinstance(parameter, click.Argument) and value == "-"
            if is_stream or getattr(value, "is_standard_input", False):
                streams.append(name)
        for broken in getattr(self.callback, "rules", ()):
            if said := broken(given):
                raise click.UsageError(said, ctx)
        if len(streams) > 1:
            raise click.UsageError(f"{' and '.join(streams)} cannot both be standard input", ctx)
        return ctx.invoke(self.callback, Options(**ctx.params))


def together(*options: Callable[[Function], Function]) -> Callable[[Function], Function]:
    """Return a decorator that adds several options in this order."""

    def decorate(function: Function) -> Function:
        for option in reversed(options):
            function = option(function)
        return function

    return decorate


def option(
    declared: str, meaning: str, *, name: str = "", **more: Any
) -> Callable[[Function], Function]:
    """Return an option as helps show it: ``--where CONDITION``; without such a word it is a flag.

    The command gets it by its name, or another one.
    """
    names, _, metavar = declared.partition(" ")
    sort = {"metavar": metavar} if metavar else {} if "type" in more else {"is_flag": True}
    return click.option(names, *filter(None, [name]), help=meaning, **sort, **more)


def _rule(broken: Callable[[set[str]], str]) -> Callable[[Function], Function]:
    """Declare what is said if the options that are given do not go together; else nothing."""

    def declare(function: Function) -> Function:
        function.rules = [broken, *getattr(function, "rules", [])]  # type: ignore[attr-defined]
        return function

    return declare


def exclusive(*names: str) -> Callable[[Function], Function]:
    """Declare options and arguments of which at most one may be given."""

    def broken(given: set[str]) -> str:
        both = [name for name in names if name in given]
        return f"give either {' or '.join(both)}" if len(both) > 1 else ""

    return _rule(broken)


def without(name: str, *others: str) -> Callable[[Function], Function]:
    """Declare options that may not be given with another one."""

    def broken(given: set[str]) -> str:
        wrong = [other for other in others if other in given]
        return f"{listed(wrong, 'and')}: not with {name}" if wrong and name in given else ""

    return _rule(broken)


def needs(name: str, *others: str) -> Callable[[Function], Function]:
    """Declare an option that means nothing without one of others."""

    def broken(given: set[str]) -> str:
        lacks = name in given and given.isdisjoint(others)
        return f"{name} is for {listed(others)}: give it, too" if lacks else ""

    return _rule(broken)


def _keys_option(function: Function) -> Function:
    """Add ``--keys``, which prints what the keys of JSON and the columns of CSV mean."""

    def show(context: click.Context, _: click.Parameter, wanted: bool) -> None:
        if wanted:
            from gspcli.cli.help import meanings
            from gspcli.cli.render import show, text_of_tables

            tables = [*meanings(" ".join(context.command_path.split()[1:]))]
            if sys.stdout.isatty():
                show(tables)
            else:
                sys.stdout.write(text_of_tables(tables))
            context.exit()

    return click.option(
        "--keys",
        is_flag=True,
        is_eager=True,
        expose_value=False,
        callback=show,
        help="Print what the keys of JSON and the columns of CSV mean, and nothing else.",
    )(function)


def _file_options(
    formats: Sequence[str], default: str, more: str = ""
) -> Callable[[Function], Function]:
    """Return ``-o`` and ``--force``; of one format the suffix says nothing."""

    def resolve(context: click.Context, _: click.Parameter, value: str | None) -> None:
        given = context.params
        chosen, path = given.pop("format_", None), None
        if value not in (None, "-"):
            from gspcli.cli.files import check_writable

            path = Path(str(value))
            if chosen is None and len(formats) > 1:
                chosen = _SUFFIXES.get(path.suffix.lower())
                if chosen not in formats:
                    known = ", ".join(end for end, name in _SUFFIXES.items() if name in formats)
                    raise click.BadParameter(
                        f"no format known from {shown(value)}: use --format, or one of {known}"
                    )
            check_writable(path)
        if chosen in DRAWINGS:
            from gspcli.pictures.figures import require_matplotlib

            require_matplotlib()
        part, force = given.pop("part_", None), given.pop("force_", False)
        given["output"] = Output(chosen or default, path, part, force)

    return together(
        click.option(
            "-o",
            "--output",
            "output_file_",
            metavar="FILE",
            expose_value=False,
            callback=resolve,
            help=f"Write to FILE, replacing it{more}.",
        ),
        option(
            "--force",
            "Replace also a file that is read, or one beside that of -o.",
            name="force_",
            is_eager=True,
        ),
    )


def file_option(suffix: str) -> Callable[[Function], Function]:
    """Return ``-o`` of a command that writes one format; the command gets ``output: Output``."""
    return _file_options([suffix], suffix)


def output_options(
    formats: Sequence[str] = FORMATS, default: str = "table", parts: Sequence[str] = ()
) -> Callable[[Function], Function]:
    """Return a decorator that adds ``--format`` and ``-o``; the command gets ``output: Output``."""
    chosen = option(
        "--format",
        f"Output format.  [default: {default}, or by the suffix of -o]",
        name="format_",
        type=click.Choice(list(formats)),
        is_eager=True,
    )
    part = option(
        "--part",
        "Show one table only; CSV holds no more than one.",
        name="part_",
        type=click.Choice(list(parts)),
        is_eager=True,
    )
    keys = [_keys_option] if "json" in formats else []
    file = _file_options(formats, default, "; its suffix gives the format")
    return together(chosen, *keys, *([part] if parts else []), file)


#: The upper limit of counts: a larger one would exceed the memory, or take years.
_MOST = 10**9
#: Processes or threads.
MOST_JOBS = 1000
_LARGEST_SEED = 2**63 - 1


class Whole(click.IntRange):
    """A whole number with a lower limit. The help does not show the upper limit."""

    def __init__(self, least: int, most: int = _MOST) -> None:
        super().__init__(least)
        self._most = most

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number, or fail."""
        number = super().convert(value, param, ctx)
        if number > self._most:
            self.fail(f"{shortened(str(value))} is not at most {self._most}.", param, ctx)
        return number

    def get_metavar(self, *_: Any, **__: Any) -> str:
        """Return what stands for the number in the help."""
        return "N"


class Finite(click.FloatRange):
    """A finite number: every option that is a number has this type, or one derived from it."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number, or fail."""
        number = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{shortened(str(value))} is not a finite number.", param, ctx)
        return number


class Positive(Finite):
    """A number above zero that is finite."""

    def __init__(self) -> None:
        super().__init__(0, min_open=True)


def seed_option(more: str = "") -> Callable[[Function], Function]:
    """Return the option `--seed`; the command gets ``seed: int``."""
    return option(
        "--seed", f"Seed of random choices{more}.", type=Whole(0, _LARGEST_SEED), default=SEED
    )


def decimals_option(
    default: int | None, least: int, most: int, more: str
) -> Callable[[Function], Function]:
    """Return the option `--decimals`; the command gets ``decimals: int`` or None."""
    return option(
        "--decimals",
        f"Write numbers with N decimals{more}.",
        type=Whole(least, most),
        default=default,
    )


#: `--one-sided`; the command gets ``one_sided: bool``.
one_sided_option = option("--one-sided", "Choose one side of each PH and HP distance, not both.")


#: `--set` and `--delta`; the command gets them as `Options.changes`.
value_options = together(
    option(
        "--set I=V",
        "Give constraint I (from 1) the value V; may be repeated.",
        name="settings",
        multiple=True,
    ),
    option(
        "--delta I=V",
        "Add V to the value of constraint I; may be repeated.",
        name="differences",
        multiple=True,
    ),
)


#: `--jobs`; the command gets ``jobs: int``.
jobs_option = option(
    "--jobs",
    "How many cores work at once; the answer does not depend on it.  [default: all]",
    type=Whole(1, MOST_JOBS),
    callback=lambda _, __, jobs: jobs or os.cpu_count() or 1,
)

#: Adds ``resume: Path | None``.
resume_option = option(
    "--resume FILE",
    "Keep finished work in FILE, and do not repeat the work that is kept there.",
    type=click.Path(dir_okay=False, path_type=Path),
)


#: `--jobs` and `--scheduler`; the command gets them as `Options.workers`.
worker_options = together(
    exclusive("--jobs", "--scheduler"),
    jobs_option,
    option(
        "--scheduler ADDRESS",
        "Use the workers of this Dask scheduler (pip install 'gspcli[cluster]').",
    ),
)
