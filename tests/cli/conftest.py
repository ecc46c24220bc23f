"""Commands in a pseudo-terminal of any width: what a person sees."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable

import pytest

#: Runs a command on the terminal that it has for output, and shows its tables at each width.
_SCRIPT = """
import fcntl, struct, sys, termios
from gspcli.cli.main import run
from gspcli.cli import progress_bars
from gspcli.cli.output import terminal
progress_bars._PATIENCE_SECONDS = 1e6
widths, words = [int(word) for word in sys.argv[1].split(",")], sys.argv[2:]
show = terminal.show
def resize(width):
    fcntl.ioctl(1, termios.TIOCSWINSZ, struct.pack("HHHH", 50, width, 0, 0))
def show_all(tables):
    for width in widths:
        resize(width)
        show(tables)
        print("\\f", flush=True)
terminal.show = show_all
resize(widths[0])
sys.exit(run(words))
"""
_STYLE = re.compile(r"\x1b\[[0-9;]*m")


Pages = Callable[..., tuple[list[str], int]]


@pytest.fixture
def shown() -> Pages:
    """Show a command: ``pages, code = shown("bound", "1", widths=[60, 80])``.

    Computed once, the tables are shown at each of the widths; what a command says without tables
    (errors, help) is shown at the first. After the pages comes what was said last.
    """
    return _shown


def _shown(
    *words: str, widths: list[int], environment: dict[str, str] | None = None, styled: bool = False
) -> tuple[list[str], int]:
    main, terminal = os.openpty()
    settings = {k: v for k, v in os.environ.items() if k not in ("COLUMNS", "LINES", "NO_COLOR")}
    settings |= {"TERM": "xterm-256color", "PYTHONUTF8": "1"} | (environment or {})
    script = [sys.executable, "-c", _SCRIPT, ",".join(map(str, widths)), *words]
    with subprocess.Popen(
        script, stdin=subprocess.DEVNULL, stdout=terminal, stderr=terminal, env=settings
    ) as process:
        os.close(terminal)
        text = _everything(main)
        code = process.wait()
    os.close(main)
    return (text if styled else _STYLE.sub("", text)).split("\f\n"), code


def _everything(terminal: int) -> str:
    received = b""
    while True:
        try:
            block = os.read(terminal, 1 << 16)
        except OSError:  # so does Linux say that the other end is closed
            break
        if not block:
            break
        received += block
    return received.decode().replace("\r\n", "\n")
