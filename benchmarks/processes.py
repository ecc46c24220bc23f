"""Run a program with a time limit, and measure its time."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import tempfile
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from pathlib import Path
from types import MappingProxyType


@dataclass(frozen=True)
class Finished:
    """The result of a process.

    Attributes
    ----------
    seconds, cpu
        Wall time, and processor time of the process and its children.
    output, errors
        What it wrote.
    trouble
        Why it failed, or empty.
    """

    seconds: float
    cpu: float
    output: str
    errors: str
    trouble: str


_PATIENCE = 20


def run(
    command: Sequence[str | Path],
    *,
    stdin: str = "",
    limit: float = 600.0,
    more: Mapping[str, str] = MappingProxyType({}),
) -> Finished:
    """Run a program and wait for its end; after `limit` seconds of processor time it is stopped.

    Its environment is that of this process, with `more` in it.
    """
    with (
        tempfile.TemporaryFile() as given,
        tempfile.TemporaryFile() as out,
        tempfile.TemporaryFile() as err,
    ):
        given.write(stdin.encode())
        given.seek(0)
        began = time.perf_counter()
        process = subprocess.Popen(
            [str(word) for word in command],
            stdin=given,
            stdout=out,
            stderr=err,
            env=os.environ | more,
            start_new_session=True,
        )
        seconds = ceil(limit)
        resource.prlimit(process.pid, resource.RLIMIT_CPU, (seconds, seconds))
        # On a busy machine the limit of processor time may not be reached; then the wall clock ends
        # it.
        timer = threading.Timer(_PATIENCE * limit, os.killpg, (process.pid, signal.SIGKILL))
        timer.start()
        # Only this call gives the processor time of this child alone.
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.perf_counter() - began
        timer.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        err.seek(0)
        return Finished(
            seconds=wall,
            cpu=usage.ru_utime + usage.ru_stime,
            output=out.read().decode(errors="replace"),
            errors=err.read().decode(errors="replace"),
            trouble=_trouble(process.returncode, limit),
        )


def _trouble(code: int, limit: float) -> str:
    if code in (-signal.SIGKILL, -signal.SIGXCPU):
        return f"> {limit:.0f} s"
    return f"exit code {code}" if code else ""
