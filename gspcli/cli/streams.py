"""The standard streams: escapes what they cannot encode, and reports an error once."""

from __future__ import annotations

import errno
import io
import os
import re
import sys
from collections.abc import Iterable, Iterator
from contextlib import suppress
from threading import Event, Thread
from time import monotonic
from typing import IO, Any, TextIO, TypeVar

import click

from gspcli.wording import named

_LABEL = "error: "
#: These errors without a file name are those of standard output: closed, on a full disk, too long.
_OF_OUTPUT = (errno.EBADF, errno.ENOSPC, errno.EFBIG, errno.EDQUOT, errno.EIO)


def open_streams() -> None:
    """Make the standard streams of this process such that all text can be written to them.

    It is UTF-8 everywhere; in names of files, what is not is escaped. A closed stream is replaced
    by a file that cannot be read or written, standard error by one that discards everything. So no
    other file gets its number. Standard output is written whole, or an error is raised. Without a
    buffer (PYTHONUNBUFFERED) Python would not notice that a full disk or a pipe has taken only a
    part.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        if getattr(sys, name) is None:
            setattr(sys, name, _instead(number))
    whole = io.BufferedWriter(_Whole(sys.stdout.fileno()))
    sys.stdout = io.TextIOWrapper(
        whole, "utf-8", "backslashreplace", line_buffering=sys.stdout.isatty()
    )
    sys.stderr.reconfigure(encoding="utf-8", errors="backslashreplace")  # type: ignore[union-attr]


class _Whole(io.RawIOBase):
    """A file that is written to by its number; a pipe that would not wait is waited for."""

    def __init__(self, number: int) -> None:
        self._number = number

    def fileno(self) -> int:
        return self._number

    def writable(self) -> bool:
        return True

    def isatty(self) -> bool:
        return os.isatty(self._number)

    def write(self, data: Any) -> int:
        while True:
            try:
                return os.write(self._number, data)
            except BlockingIOError:
                import select

                select.select([], [self._number], [])


def _instead(number: int) -> TextIO:
    """Return the replacement of a closed stream; only standard error accepts text."""
    opened = os.open(os.devnull, os.O_RDONLY if number == 1 else os.O_WRONLY)
    if opened != number:
        os.dup2(opened, number)
        os.close(opened)
    return open(number, "r" if number == 0 else "w", encoding="utf-8", closefd=False)


#: Characters that control a terminal: control characters, changes of direction.
_OBEYED = re.compile("[\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]")


def printable(text: str) -> str:
    """Return a text with the characters that control a terminal escaped.

    Line breaks stay.
    """
    return _OBEYED.sub(_written_out, text)


def _written_out(match: re.Match[str]) -> str:
    character = match[0]
    return character if character == "\n" else character.encode("unicode_escape").decode("ascii")


def say(message: str) -> None:
    """Tell the user something on standard error, if it can be written to."""
    rest = message.removeprefix(_LABEL)
    label = message[: len(message) - len(rest)]
    try:
        # Named: the console script is `gsp`, by whichever path it was started.
        click.secho(label, fg="red", bold=True, nl=False, err=True, color=coloured(sys.stderr))
        click.echo(_wrapped(printable(rest), len(label)), err=True)
    except OSError:
        discard(sys.stderr)


def _wrapped(text: str, begun: int) -> str:
    """Return lines that a terminal shows without cutting words, after a first one that is begun."""
    if not sys.stderr.isatty():
        return text
    import shutil
    import textwrap

    width = shutil.get_terminal_size().columns
    lines = text.split("\n")
    for i, line in enumerate(lines):
        if len(line) + (0 if i else begun) > width:
            first = " " * (0 if i else begun)
            parts = textwrap.wrap(
                line, width, initial_indent=first, break_long_words=False, break_on_hyphens=False
            )
            lines[i] = "\n".join(parts)[len(first) :]
    return "\n".join(lines)


def discard(stream: TextIO) -> None:
    """Discard the output of a stream: the interpreter would complain when it flushes the rest."""
    with suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)


def reason(error: OSError) -> str:
    """Return the message of an error of the system, about a file or standard output."""
    why = "it is closed" if error.errno == errno.EBADF else error.strerror or str(error)
    if error.filename:
        return f"{named(error.filename)}: {why}"
    return f"standard output: cannot be written: {why}" if error.errno in _OF_OUTPUT else why


def coloured(stream: IO[str]) -> bool:
    """Return whether to colour a stream: a terminal with colours, unless the user forbids it.

    ``NO_COLOR`` with any text (no-color.org) and ``TERM=dumb`` say no.
    """
    unwanted = os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb"
    return stream.isatty() and not unwanted


Item = TypeVar("Item")

_PATIENCE_SECONDS = 1.0
#: Off a terminal long work says every so many seconds how far it is.
_LINE_SECONDS = 10.0
_REFRESH_SECONDS = 0.1


def progress(
    items: Iterable[Item], *, total: int | None = None, label: str = "", lines: bool = False
) -> Iterator[Item]:
    """Yield the items; after a second, show a bar on the terminal (see `gspcli.progress`).

    Off a terminal nothing is shown or, with `lines`, how far the work is every ten seconds.
    """
    with working(label, total, lines=lines) as report:
        for item in items:
            yield item
            report.done += 1


class working:
    """Show, after a second, that work goes on, and how many items of it are `done`."""

    def __init__(self, label: str, total: int | None = None, *, lines: bool = False) -> None:
        self._label, self._total, self.done = label, total, 0
        self._ended = Event()
        shown = self._bar if sys.stderr.isatty() else self._lines if lines else None
        self._thread = None if shown is None else Thread(target=shown, daemon=True)

    def __enter__(self) -> working:
        # A system that refuses threads gets no report.
        with suppress(RuntimeError):
            if self._thread is not None:
                self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        with suppress(RuntimeError):
            if self._thread is not None:
                self._thread.join()

    def _lines(self) -> None:
        begun = monotonic()
        while not self._ended.wait(_LINE_SECONDS):
            of = "" if self._total is None else f": {self.done} of {self._total}"
            say(f"{self._label}{of} ({monotonic() - begun:.0f} s)")

    def _bar(self) -> None:
        """Show a bar, whose program is not even loaded before."""
        if self._ended.wait(_PATIENCE_SECONDS):
            return
        from rich.console import Console
        from rich.progress import Progress

        with Progress(console=Console(stderr=True), transient=True) as bars:
            task = bars.add_task(self._label, total=self._total)
            while not self._ended.wait(_REFRESH_SECONDS):
                bars.update(task, completed=self.done)
