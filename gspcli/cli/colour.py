"""Whether output is coloured."""

from __future__ import annotations

import os
from typing import IO


def coloured(stream: IO[str]) -> bool:
    """Return whether to colour a stream: a terminal with colours, unless the user forbids it.

    ``NO_COLOR`` with any text (no-color.org) and ``TERM=dumb`` say no.
    """
    unwanted = os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb"
    return stream.isatty() and not unwanted
