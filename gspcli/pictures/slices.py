"""Workspaces as pictures: the boxes over two parameters, or slices of those over three."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gspcli.pictures.figures import ANGLE, PLATFORM, SOFT, styled, written_drawing

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from gspcli.motion import Workspace

Array = NDArray[np.float64]

_SLICES = 6
_COLUMNS = 3


def workspace_slices(found: Workspace, fmt: str) -> bytes:
    """Return a workspace over two or three parameters as a picture.

    Over three there are six slices, evenly between the ends of the third parameter.

    Parameters
    ----------
    found
        The workspace.
    fmt
        ``svg``, ``png`` or ``pdf``.

    Raises
    ------
    GspError
        If matplotlib is not installed.
    """
    with styled():
        from matplotlib.figure import Figure

        flat = len(found.free) == 2
        size = (4.6, 4.4) if flat else (8.4, 6.0)
        figure = Figure(figsize=size, layout="constrained")
        if flat:
            axes = figure.subplots()
            _draw(axes, found, found.inner, found.open)
            _frame(axes, found)
        else:
            panels = figure.subplots(_SLICES // _COLUMNS, _COLUMNS, sharex=True, sharey=True)
            low, high = _ends(found)[2]
            for k, axes in enumerate(panels.flat):
                at = low + (high - low) * (k + 0.5) / _SLICES
                _draw(axes, found, *(_cut(boxes, at) for boxes in (found.inner, found.open)))
                _frame(axes, found, left=k % _COLUMNS == 0, below=k >= _SLICES - _COLUMNS)
                axes.set_title(f"{found.free[2]} = {at:.4g} {_unit(found, 2)}")
        figure.legend(handles=_legend(), loc="outside lower center", ncols=2)
        return written_drawing(figure, fmt)


def _cut(boxes: Array, at: float) -> Array:
    """Return the boxes that a value of the third parameter cuts."""
    return np.asarray(boxes[(boxes[:, 2, 0] <= at) & (at < boxes[:, 2, 1]), :2])


def _ends(found: Workspace) -> Array:
    """Return bounds of the set, or the whole divided box if the set is empty, (d, 2)."""
    outer = found.extents[:, 1]
    whole = found.bounds / found.units[:, None]
    return np.where(np.isnan(outer), whole, outer)


def _draw(axes: Axes, found: Workspace, inner: Array, open_: Array) -> None:
    from matplotlib.collections import PolyCollection

    for boxes, colour in ((open_, ANGLE), (inner, PLATFORM)):
        (left, right), (below, above) = boxes[:, 0].T, boxes[:, 1].T
        corners = np.stack(
            [
                np.stack(pair, axis=1)
                for pair in ((left, below), (right, below), (right, above), (left, above))
            ],
            axis=1,
        )
        axes.add_collection(
            PolyCollection(list(corners), facecolors=colour, edgecolors="none", rasterized=True)
        )
    for k, name in enumerate(found.free[:2]):
        at = found.boxes.home["xyz".index(name[-1]) + (3 if name.startswith("r") else 0)]
        (axes.axvline if k == 0 else axes.axhline)(
            at / found.units[k], color=SOFT, linewidth=0.6, linestyle=(0, (1, 3))
        )


def _frame(axes: Axes, found: Workspace, *, left: bool = True, below: bool = True) -> None:
    (x0, x1), (y0, y1) = _ends(found)[:2]
    room = 0.04 * max(x1 - x0, y1 - y0)
    axes.set(xlim=(x0 - room, x1 + room), ylim=(y0 - room, y1 + room))
    same = found.free[0].startswith("r") == found.free[1].startswith("r")
    axes.set_aspect("equal" if same else "auto")
    if below:
        axes.set_xlabel(f"{found.free[0]} ({_unit(found, 0)})")
    if left:
        axes.set_ylabel(f"{found.free[1]} ({_unit(found, 1)})")


def _unit(found: Workspace, k: int) -> str:
    units = found.instance.units
    return units.angle.value if found.free[k].startswith("r") else units.length


def _legend() -> list[object]:
    from matplotlib.patches import Patch

    return [
        Patch(color=PLATFORM, label="can be reached, proved"),
        Patch(color=ANGLE, label="the boundary is in here; outside none can, proved"),
    ]
