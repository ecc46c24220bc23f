"""The options `--jobs` and `--scheduler`: who does the work."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable
from typing import Any, TypeVar

import click

from gspcli.cli.number_types import MOST_JOBS, Whole

Function = TypeVar("Function", bound=Callable[..., Any])


def worker_options(function: Function) -> Function:
    """Add the two options; the command gets ``workers: Workers``."""

    @click.option(
        "--jobs",
        type=Whole(1, MOST_JOBS),
        metavar="N",
        help="Processes that work at once.  [default: all cores]",
    )
    @click.option(
        "--scheduler",
        metavar="ADDRESS",
        help="Let the workers of this Dask scheduler do it (pip install 'gspcli[cluster]').",
    )
    @functools.wraps(function)
    def command(*, jobs: int | None, scheduler: str | None, **others: Any) -> Any:
        from gspcli.workers import Workers

        if jobs is not None and scheduler is not None:
            message = "--jobs and --scheduler exclude each other"
            raise click.UsageError(message)
        return function(workers=Workers(jobs or os.cpu_count() or 1, scheduler), **others)

    return command  # type: ignore[return-value]
