"""The options ``--format`` and ``-o``: the format of a result, and its file."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import click

from gspcli.cli.output.files import check_writable
from gspcli.records import dataclass
from gspcli.wording import shown

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


@dataclass(frozen=True)
class Output:
    """Where a result goes and in which format.

    Attributes
    ----------
    format
        One of `FORMATS` (or the formats the command allows).
    path
        The file, or None for standard output.
    part
        The one table that is asked for, None for all.
    """

    format: str
    path: Path | None
    part: str | None = None


def _keys_option(function: Function) -> Function:
    """Add ``--keys``, which prints what the keys of JSON and the columns of CSV mean."""

    def show(context: click.Context, _: click.Parameter, wanted: bool) -> None:
        if wanted:
            from gspcli.cli.output import keys, terminal

            tables = list(keys.meanings(" ".join(context.command_path.split()[1:])))
            if sys.stdout.isatty():
                terminal.show(tables)
            else:
                sys.stdout.write(terminal.render(tables))
            context.exit()

    return click.option(
        "--keys",
        is_flag=True,
        is_eager=True,
        expose_value=False,
        callback=show,
        help="Print what the keys of JSON and the columns of CSV mean, and nothing else.",
    )(function)


#: The help of `-o`, the same in all commands.
_FILE_HELP = "Write to FILE, replacing it"


def file_option(suffix: str) -> Callable[[Function], Function]:
    """Return ``-o`` of a command that writes one format; the command gets ``output: Output``.

    Parameters
    ----------
    suffix
        The format.
    """

    def resolve(context: click.Context, parameter: click.Parameter, value: str | None) -> None:
        del parameter
        path = None if value in (None, "-") else Path(str(value))
        if path is not None:
            check_writable(path)
        context.params["output"] = Output(suffix, path)

    return click.option(
        "-o",
        "--output",
        "output_file_",
        metavar="FILE",
        expose_value=False,
        callback=resolve,
        help=f"{_FILE_HELP}.",
    )


def output_options(
    formats: Sequence[str] = FORMATS, default: str = "table", parts: Sequence[str] = ()
) -> Callable[[Function], Function]:
    """Return a decorator that adds ``--format`` and ``-o``; the command gets ``output: Output``.

    Parameters
    ----------
    formats
        What the command can write.
    default
        The format without ``--format`` and ``-o``.
    parts
        Names of its tables if there are several: ``--part`` chooses one.
    """

    def decorate(function: Function) -> Function:
        def resolve(context: click.Context, _: click.Parameter, value: str | None) -> str | None:
            path = value
            if path == "-":
                path = None
            chosen = context.params.pop("format_", None)
            if chosen is None and path is not None:
                chosen = _SUFFIXES.get(Path(path).suffix.lower())
                if chosen not in formats:
                    known = ", ".join(s for s, name in _SUFFIXES.items() if name in formats)
                    message = f"no format known from {shown(path)}: use --format, or one of {known}"
                    raise click.BadParameter(message)
            if path is not None:
                check_writable(Path(path))
            if chosen in DRAWINGS:
                from gspcli.pictures.figures import require_matplotlib

                require_matplotlib()
            part = context.params.pop("part_", None)
            context.params["output"] = Output(chosen or default, Path(path) if path else None, part)
            return None

        function = click.option(
            "-o",
            "--output",
            "output_file_",
            metavar="FILE",
            expose_value=False,
            callback=resolve,
            help=f"{_FILE_HELP}; its suffix gives the format.",
        )(function)
        if parts:
            function = click.option(
                "--part",
                "part_",
                type=click.Choice(list(parts)),
                is_eager=True,
                help="Show one table only; CSV holds no more than one.",
            )(function)
        if "json" in formats:
            function = _keys_option(function)
        return click.option(
            "--format",
            "format_",
            type=click.Choice(list(formats)),
            is_eager=True,
            help=f"Output format.  [default: {default}, or by the suffix of -o]",
        )(function)

    return decorate
