"""Invalid command lines, files, streams and signals, by seeds.

- `options`: any command with options and arguments that may be anything (`hostile`);
- `inputs`: instance, pose, value, state and work files that were spoilt;
- `streams`: the same commands, with standard output full, closed or abandoned after some bytes, and
  a disk that is full for files, too;
- `processes`: processes of their own, with closed and full streams, encodings by environment, and
  SIGINT, SIGTERM or SIGHUP after up to a second.

All but the last are run within this process. What must hold: the exit code is 0, 1, 2, 3, 4 or 130
(or that of the signal). No traceback and no message of another library is printed. An error is at
most five lines. Unfinished files are removed.
"""

from __future__ import annotations

import contextlib
import errno
import importlib
import io
import os
import pkgutil
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
import traceback
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from unittest import mock

import gspcli
from gspcli.cli.commands import COMMANDS
from gspcli.cli.main import run
from gspcli.errors import INTERRUPTED
from tests.support.fuzz import hostile as hostile_commands
from tests.support.fuzz.hostile import Hostile
from tools.recording import ROOT

DOCUMENTED = (0, 1, 2, 3, 4, INTERRUPTED)
LIMIT_S = 1.0
MOST_LINES, MOST_CHARACTERS = 5, 700
_LIBRARIES = ("sympy", "pandas", "matplotlib.pyplot", "mpmath", "flint", "yaml")
#: What another library says, or Python.
FOREIGN = ("Traceback", "Warning:", "Exception ignored", "internal error")


@dataclass
class Told:
    """What a run gave: exit code, what was said, warnings, whether standard error was heard."""

    code: int
    err: str
    foreign: list[str] = field(default_factory=list)
    heard: bool = True


class _Full(io.RawIOBase):
    """A file that takes some bytes, then fails."""

    def __init__(self, room: int, number: int) -> None:
        self._room, self._number = room, number

    def writable(self) -> bool:
        return True

    def write(self, data: bytes) -> int:  # type: ignore[override]
        if self._room < len(data):
            raise OSError(self._number, os.strerror(self._number))
        self._room -= len(data)
        return len(data)


@contextlib.contextmanager
def _alarm(seconds: float) -> Iterator[None]:
    """Interrupt what is done after some time, as Ctrl-C does."""

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def within(hostile: Hostile, folder: Path, out: io.IOBase) -> Told:
    """Run a command within this process, in a folder."""
    hostile_commands.write_files(hostile, folder)
    err = io.BytesIO()
    streams = [
        io.TextIOWrapper(io.BufferedWriter(raw), "utf-8", "backslashreplace") for raw in (out, err)
    ]
    stdin = io.TextIOWrapper(io.BytesIO(hostile.stdin))
    before = sys.stdin, Path.cwd()
    os.chdir(folder)
    foreign = []
    try:
        with (
            warnings.catch_warnings(record=True) as caught,
            contextlib.redirect_stdout(streams[0]),
            contextlib.redirect_stderr(streams[1]),
            mock.patch("click.launch"),
        ):
            warnings.simplefilter("always")
            sys.stdin = stdin
            try:
                with _alarm(LIMIT_S):
                    code = run(hostile.words)
            except KeyboardInterrupt:
                code = INTERRUPTED
            except BaseException:
                code = 70
                foreign.append(traceback.format_exc())
    finally:
        sys.stdin = before[0]
        os.chdir(before[1])
    foreign += [f"Warning: {one.message}" for one in caught]
    with contextlib.suppress(OSError, ValueError):
        streams[1].flush()
    told = err.getvalue().decode()
    for stream in streams:
        with contextlib.suppress(OSError, ValueError):
            stream.detach()
    return Told(code, told, foreign)


def attack_within(kind: str, rng: random.Random, folder: Path) -> tuple[Hostile, Told]:
    """Draw a run of one of the kinds within this process, and make it."""
    if kind == "options":
        hostile = hostile_commands.options(rng)
    elif kind == "inputs":
        hostile = hostile_commands.inputs(rng)
    else:
        hostile = rng.choice((hostile_commands.options, hostile_commands.inputs))(rng)
    out: io.IOBase = io.BytesIO()
    if kind == "streams":
        numbers = errno.ENOSPC, errno.EPIPE, errno.EBADF, errno.EIO
        full = _Full(rng.choice((0, 0, 100, 5000)), rng.choice(numbers))
        out = rng.choice((out, full))
    return hostile, within(hostile, folder, out)


_STREAMS = ("", ">/dev/full", "2>/dev/full", ">&-", "2>&-", ">&- 2>&-", "<&- >&- 2>&-", "<&-")
_ENVIRONMENTS: tuple[dict[str, str], ...] = (
    {},
    {"PYTHONIOENCODING": "ascii"},
    {"PYTHONIOENCODING": "cp1252"},
    {"PYTHONUTF8": "0", "LC_ALL": "C", "PYTHONCOERCECLOCALE": "0"},
)


def attack_process(rng: random.Random, folder: Path) -> tuple[Hostile, Told]:
    """Draw a process with its streams, environment and a signal, and make it."""
    hostile = rng.choice((hostile_commands.options, hostile_commands.inputs))(rng)
    # What is in the arguments of a process is bytes without zeros.
    words = [word.replace("\0", "") for word in hostile.words]
    hostile_commands.write_files(hostile, folder)
    redirected = rng.choice(_STREAMS)
    settings = os.environ | {"PYTHONPATH": str(ROOT)} | rng.choice(_ENVIRONMENTS)
    command = ["/bin/sh", "-c", f'exec "$0" -m gspcli "$@" {redirected}', sys.executable, *words]
    number = rng.choice((None, None, signal.SIGINT, signal.SIGTERM, signal.SIGHUP))
    delay = rng.random()
    with subprocess.Popen(
        command,
        cwd=folder,
        env=settings,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
    ) as process:

        def stop() -> None:
            if number is not None:
                time.sleep(delay)
                process.send_signal(number)
            time.sleep(10)
            process.send_signal(signal.SIGINT)

        threading.Thread(target=stop, daemon=True).start()
        _, err = process.communicate(hostile.stdin)
    code = process.returncode
    if number is not None and code == -number:
        code = INTERRUPTED
    heard = "2>" not in redirected
    return hostile, Told(code, err.decode("utf-8", "replace"), heard=heard)


def wrong(hostile: Hostile, told: Told, folder: Path) -> list[str]:
    """Return what does not hold."""
    found = []
    if told.code not in DOCUMENTED:
        found.append(f"exit code {told.code}")
    text = "\n".join([told.err, *told.foreign])
    # Python reports a Ctrl-C while it starts, or within a finalizer.
    if "KeyboardInterrupt" not in text:
        found += [f"{word!r} is said" for word in FOREIGN if word in text]
    lines = told.err.splitlines()
    begin = [k for k, line in enumerate(lines) if line.startswith(("error: ", "Usage: "))]
    is_help = begin and any(line.startswith("Options:") for line in lines)
    if begin and not is_help:
        error = lines[begin[-1] :]
        if len(error) > MOST_LINES:
            found.append(f"an error of {len(error)} lines")
        if max(map(len, error)) > MOST_CHARACTERS:
            found.append(f"a line of {max(map(len, error))} characters")
    if told.code == 2 and told.heard and not begin:
        found.append("exit code 2 without an error")
    left = [path.name for path in folder.iterdir() if path.name.startswith(".")]
    found += [f"{name} is left" for name in left]
    return [f"{problem}: gsp {hostile_commands.text(hostile.words)}" for problem in found]


def attack(kind: str, seed: int) -> tuple[int, list[str]]:
    """Make the run of a seed; return its exit code and what does not hold."""
    rng = random.Random(f"{kind} {seed}")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if kind == "processes":
            hostile, told = attack_process(rng, folder)
        else:
            hostile, told = attack_within(kind, rng, folder)
        problems = wrong(hostile, told, folder)
        if problems:
            problems.append(told.err[:500] + "".join(told.foreign)[-1500:])
        return told.code, problems


def prepare() -> None:
    """Import everything: an import that is interrupted leaves half a module behind."""
    # What a shell starts in the background ignores it, and its processes would, too.
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    for name in (
        *_LIBRARIES,
        *(f"gspcli.cli.commands.{name.replace('-', '_')}" for name in COMMANDS),
    ):
        importlib.import_module(name)
    for info in pkgutil.walk_packages(gspcli.__path__, "gspcli."):
        importlib.import_module(info.name)
