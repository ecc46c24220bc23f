"""Progress bars: on standard error, on a terminal, for work longer than a second."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from threading import Timer
from typing import TypeVar

Item = TypeVar("Item")

_PATIENCE_SECONDS = 1.0


def progress(items: Iterable[Item], *, total: int | None = None, label: str = "") -> Iterator[Item]:
    """Yield the items; after a second, show a bar on the terminal (see `gspcli.progress`)."""
    if not sys.stderr.isatty():
        yield from items
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True, disable=False) as bars:
        task = bars.add_task(label, total=total, visible=False)
        patience = Timer(_PATIENCE_SECONDS, bars.update, (task,), {"visible": True})
        patience.daemon = True
        patience.start()
        try:
            for item in items:
                yield item
                bars.advance(task)
        finally:
            patience.cancel()
