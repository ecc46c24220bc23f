"""Whether colour is wanted."""

from __future__ import annotations

import os
from typing import IO


def coloured(stream: IO[str]) -> bool:
    """Return whether to colour what goes to a stream: a terminal that can, and a user who wants.

    ``NO_COLOR`` with any text (no-color.org) and ``TERM=dumb`` say no.
    """
    unwanted = os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb"
    return stream.isatty() and not unwanted
