"""Results in notebooks: the page of `gsp view` in a frame."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

from gspcli.pictures.page import page
from gspcli.pictures.staging import first_mode, scene_of

if TYPE_CHECKING:
    from gspcli.solver.result import SolveResult

_HEIGHT = 620


def notebook_view(result: SolveResult) -> str:
    """Return a result as HTML for a notebook: its page in a frame of its own.

    Parameters
    ----------
    result
        What `gspcli.solver.solve` found.
    """
    document = escape(page(scene_of(result), first_mode(result.drawn)))
    title = escape(result.instance.name or result.instance.type.id)
    # In a frame of its own the page's style and scripts touch nothing of the notebook's.
    return (
        f'<iframe srcdoc="{document}" title="{title}" sandbox="allow-scripts allow-downloads" '
        f'style="width: 100%; height: {_HEIGHT}px; border: 1px solid #8884; border-radius: 6px">'
        "</iframe>"
    )
