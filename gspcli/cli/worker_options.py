"""Options about processes and work files: `--jobs`, `--scheduler` and `--resume`."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

from gspcli.cli.number_types import MOST_JOBS, Whole

Function = TypeVar("Function", bound=Callable[..., Any])

_jobs = click.option(
    "--jobs",
    type=Whole(1, MOST_JOBS),
    metavar="N",
    help="How many cores work at once; the answer does not depend on it.  [default: all]",
)

#: Adds ``resume: Path | None``.
resume_option = click.option(
    "--resume",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Keep finished work in FILE, and do not repeat the work that is kept there.",
)


def _cores(jobs: int | None) -> int:
    """Return the number of cores to use."""
    return jobs or os.cpu_count() or 1


def jobs_option(function: Function) -> Function:
    """Add `--jobs`; the command gets ``jobs: int``."""

    @_jobs
    @functools.wraps(function)
    def command(*, jobs: int | None, **others: Any) -> Any:
        return function(jobs=_cores(jobs), **others)

    return command  # type: ignore[return-value]


def worker_options(function: Function) -> Function:
    """Add `--jobs` and `--scheduler`; the command gets ``workers: Workers``."""

    @_jobs
    @click.option(
        "--scheduler",
        metavar="ADDRESS",
        help="Use the workers of this Dask scheduler (pip install 'gspcli[cluster]').",
    )
    @functools.wraps(function)
    def command(*, jobs: int | None, scheduler: str | None, **others: Any) -> Any:
        from gspcli.workers import Workers

        if jobs is not None and scheduler is not None:
            message = "--jobs and --scheduler exclude each other"
            raise click.UsageError(message)
        return function(workers=Workers(_cores(jobs), scheduler), **others)

    return command  # type: ignore[return-value]
