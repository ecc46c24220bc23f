"""Options that give intervals or grids: ``--vary 1=5:7:200``, ``--within x=-1:1``."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from gspcli.errors import GspError
from gspcli.wording import listed, shown

#: What poses vary by: position of the pivot, turns.
PARAMETERS = ("x", "y", "z", "rx", "ry", "rz")
_MOST_NODES = 1_000_000
_SPAN = re.compile(r"(r?[xyz])=([^:]+):([^:]+)(?::(\d{1,9}))?")
_AXIS = re.compile(r"([^=]+)=([^:]+):([^:]+):(\d{1,9})")


def axes_of(texts: Sequence[str], names: Sequence[str]) -> list[tuple[str, tuple[float, ...]]]:
    """Return the name and the nodes of each axis of `--vary`.

    Raises
    ------
    GspError
        If a text is none, or there are too many nodes.
    """
    axes = [_axis(text, names) for text in texts]
    total = math.prod(len(nodes) for _, nodes in axes)
    if total > _MOST_NODES:
        message = f"found {total} nodes, expected at most {_MOST_NODES}"
        raise GspError(message)
    return axes


def _axis(text: str, names: Sequence[str]) -> tuple[str, tuple[float, ...]]:
    import numpy as np

    from gspcli.motion.files.number_tables import wrong_number

    match = _AXIS.fullmatch(text.replace(" ", ""))
    if match is None or match[1] not in names or wrong_number(match[2]) or wrong_number(match[3]):
        form = f"NAME=LOW:HIGH:COUNT with {listed(names)}, such as {names[0]}=5:7:200"
        message = f"--vary: found {shown(text)}, expected {form}"
        raise GspError(message)
    low, high, count = float(match[2]), float(match[3]), int(match[4])
    if not low < high or count < 2:
        message = f"--vary: found {shown(text)}, expected LOW below HIGH and at least two values"
        raise GspError(message)
    if count > _MOST_NODES:
        message = f"found {count} nodes, expected at most {_MOST_NODES}"
        raise GspError(message)
    return match[1], tuple(np.linspace(low, high, count).tolist())


def span_of(option: str, text: str) -> tuple[str, float, float, int | None]:
    """Return the parameter of a pose that an option names, its interval, and how many values.

    Raises
    ------
    GspError
        If the text is none.
    """
    from gspcli.motion.files.number_tables import wrong_number

    match = _SPAN.fullmatch(text.replace(" ", ""))
    if match is None or wrong_number(match[2]) or wrong_number(match[3]):
        end = ":COUNT" if option == "shift" else ""
        message = f"--{option}: found {shown(text)}, expected NAME=LOW:HIGH{end} with NAME one of "
        raise GspError(message + ", ".join(PARAMETERS))
    return match[1], float(match[2]), float(match[3]), int(match[4]) if match[4] else None
