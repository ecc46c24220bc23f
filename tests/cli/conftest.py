"""Commands in a pseudo-terminal of any width: what a person sees."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator

import pytest

#: Runs the commands that it is sent on the terminal that it has for output, one after the other,
#: and shows their tables at each width.
_SCRIPT = """
import fcntl, json, struct, sys, termios
from gspcli.cli.main import run
from gspcli.cli import render, streams
streams._PATIENCE_SECONDS = 1e6
show = render.show
def resize(width):
    fcntl.ioctl(1, termios.TIOCSWINSZ, struct.pack("HHHH", 50, width, 0, 0))
def show_all(tables):
    for width in widths:
        resize(width)
        show(tables)
        print("\\f", flush=True)
render.show = show_all
for request in sys.stdin:
    widths, words = json.loads(request)
    resize(widths[0])
    code = run(words)
    sys.stderr.flush()
    print(f"\\f{code}\\v", end="", flush=True)
"""
_END = re.compile(r"\f(\d+)\v\Z")
_STYLE = re.compile(r"\x1b\[[0-9;]*m")


Pages = Callable[..., tuple[list[str], int]]


class _Terminal:
    """A process with a terminal, in which commands are run."""

    def __init__(self, environment: dict[str, str]) -> None:
        settings = {
            k: v for k, v in os.environ.items() if k not in ("COLUMNS", "LINES", "NO_COLOR")
        }
        settings |= {"TERM": "xterm-256color", "PYTHONUTF8": "1"} | environment
        self._output, theirs = os.openpty()
        self._process = subprocess.Popen(
            [sys.executable, "-c", _SCRIPT],
            stdin=subprocess.PIPE,
            stdout=theirs,
            stderr=theirs,
            env=settings,
            text=True,
        )
        os.close(theirs)

    def run(self, words: tuple[str, ...], widths: list[int]) -> tuple[str, int]:
        """Return everything on the terminal, and the exit code."""
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps([widths, words]) + "\n")
        self._process.stdin.flush()
        received = b""
        while (end := _END.search(received.decode(errors="ignore"))) is None:
            # Linux raises OSError if the process has ended.
            received += os.read(self._output, 1 << 16)
        text = received.decode().removesuffix(end[0])
        return text.replace("\r\n", "\n"), int(end[1])

    def close(self) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        assert self._process.wait() == 0
        os.close(self._output)


@pytest.fixture(scope="session")
def _usual_terminal() -> Iterator[_Terminal]:
    terminal = _Terminal({})
    yield terminal
    terminal.close()


@pytest.fixture
def shown(_usual_terminal: _Terminal) -> Pages:
    """Show a command: ``pages, code = shown("bound", "1", widths=[60, 80])``.

    Computed once, the tables are shown at each of the widths; what a command says without tables
    (errors, help) is shown at the first. After the pages comes what was said last. Commands are run
    in one process, except in another environment.
    """

    def show(
        *words: str,
        widths: list[int],
        environment: dict[str, str] | None = None,
        styled: bool = False,
    ) -> tuple[list[str], int]:
        terminal = _Terminal(environment) if environment else _usual_terminal
        text, code = terminal.run(words, widths)
        if environment:
            terminal.close()
        return (text if styled else _STYLE.sub("", text)).split("\f\n"), code

    return show
