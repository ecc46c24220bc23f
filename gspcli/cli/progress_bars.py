"""Progress bars: on standard error, on a terminal, for work longer than a second."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from threading import Lock, Timer
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from rich.progress import Progress

Item = TypeVar("Item")

_PATIENCE_SECONDS = 1.0


def progress(items: Iterable[Item], *, total: int | None = None, label: str = "") -> Iterator[Item]:
    """Yield the items; after a second, show a bar on the terminal (see `gspcli.progress`)."""
    if not sys.stderr.isatty():
        yield from items
        return
    bar = _LateBar(label, total)
    try:
        for item in items:
            yield item
            bar.advance()
    finally:
        bar.stop()


@contextmanager
def working(label: str) -> Iterator[None]:
    """Show, after a second, that work of unknown length goes on."""
    bar = _LateBar(label, None) if sys.stderr.isatty() else None
    try:
        yield
    finally:
        if bar is not None:
            bar.stop()


class _LateBar:
    """A bar that appears after a second, and is not even loaded before."""

    def __init__(self, label: str, total: int | None) -> None:
        self._label, self._total = label, total
        self._done = 0
        self._bars: Progress | None = None
        self._stopped = False
        self._lock = Lock()
        self._timer = Timer(_PATIENCE_SECONDS, self._appear)
        self._timer.daemon = True
        # A system that refuses threads gets no bar.
        with suppress(RuntimeError):
            self._timer.start()

    def _appear(self) -> None:
        from rich.console import Console
        from rich.progress import Progress

        with self._lock:
            if self._stopped:
                return
            self._bars = Progress(console=Console(stderr=True), transient=True)
            self._bars.add_task(self._label, total=self._total, completed=self._done)
            self._bars.start()

    def advance(self) -> None:
        with self._lock:
            self._done += 1
            if self._bars is not None:
                self._bars.advance(self._bars.task_ids[0])

    def stop(self) -> None:
        self._timer.cancel()
        with self._lock:
            self._stopped = True
            if self._bars is not None:
                self._bars.stop()
