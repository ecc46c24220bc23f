"""Figures by matplotlib: one look for drawings and charts, and the same bytes every time."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from gspcli.errors import GspError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

INK, SOFT, RULE = "#1d2530", "#5d6876", "#dde1e7"
BASE, PLATFORM, DISTANCE, ANGLE = "#5a6572", "#1f66b0", "#2b323c", "#b4570a"

# matplotlib lists its hundreds of names as a type, which a dict of some of them is not.
_STYLE: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "text.color": INK,
    "axes.edgecolor": SOFT,
    "axes.labelcolor": INK,
    "axes.titlesize": 10,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "grid.color": RULE,
    "grid.linewidth": 0.8,
    "xtick.color": SOFT,
    "ytick.color": SOFT,
    "legend.frameon": False,
    "svg.hashsalt": "gsp",
    "svg.fonttype": "path",
    "path.simplify": False,
}
_DPI = 200
#: What would name the day or the program that wrote a file.
_NO_METADATA = {
    "svg": {"Date": None, "Creator": None},
    "png": {"Software": None},
    "pdf": {"CreationDate": None, "Producer": None, "Creator": None},
}


def require_matplotlib() -> None:
    """Complain if matplotlib is not installed, before any work is done.

    Raises
    ------
    GspError
        What to install.
    """
    if find_spec("matplotlib") is None:
        raise GspError("pictures of this kind need matplotlib: pip install 'gspcli[plot]'")


@contextmanager
def styled() -> Iterator[None]:
    """Draw and write figures in the common look inside this context.

    Raises
    ------
    GspError
        If matplotlib is not installed.
    """
    require_matplotlib()
    from matplotlib import rc_context

    with rc_context(_STYLE):
        yield


def written(figure: Figure, fmt: str) -> bytes:
    """Return a figure as the content of a file of format ``svg``, ``png`` or ``pdf``."""
    buffer = io.BytesIO()
    figure.savefig(
        buffer, format=fmt, dpi=_DPI, bbox_inches="tight", pad_inches=0.06,
        metadata=_NO_METADATA[fmt],
    )  # fmt: skip
    return buffer.getvalue()


#: Names that matplotlib makes from the bits of coordinates, and zeros with a sign.
_NAME = re.compile(r"\b[mp][0-9a-f]{10}\b")
_NEGATIVE_ZERO = re.compile(r"(?<![\w.])-0(?![\w.])")


def written_drawing(figure: Figure, fmt: str) -> bytes:
    """Return the content of a file, as `written`, that the last bits of coordinates do not change.

    In SVG, names are numbered instead.
    """
    content = written(figure, fmt)
    if fmt != "svg":
        return content
    text = _NEGATIVE_ZERO.sub("0", content.decode())
    numbers = {name: k for k, name in enumerate(dict.fromkeys(_NAME.findall(text)), 1)}
    return _NAME.sub(lambda match: f"{match[0][0]}{numbers[match[0]]}", text).encode()
