"""Maps of scans: how many modes there are over one or two values, with the discriminant."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from gspcli.pictures.figures import ANGLE, PLATFORM, styled, written

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gspcli.motion.scanning import Crossing, Scan


def mode_map(found: Scan, folds: Sequence[Crossing], fmt: str) -> bytes:
    """Return a scan as a picture: a stair over one value, a coloured map over two.

    Parameters
    ----------
    found
        The scan.
    folds
        Proved folds on it, drawn as lines or points.
    fmt
        ``svg``, ``png`` or ``pdf``.

    Raises
    ------
    GspError
        If matplotlib is not installed.
    """
    with styled():
        from matplotlib.figure import Figure

        figure = Figure(figsize=(6.0, 4.4 if len(found.axes) == 2 else 3.0), layout="constrained")
        draw = _map if len(found.axes) == 2 else _stair
        draw(figure, found, folds)
        return written(figure, fmt)


def _label(found: Scan, k: int) -> str:
    constraint = found.instance.constraints[found.axes[k].constraint]
    units = found.instance.units
    unit = units.length if constraint.kind.is_distance else units.angle.value
    return f"{constraint.kind.name} {found.axes[k].constraint + 1} ({unit})"


def _stair(figure: Figure, found: Scan, folds: Sequence[Crossing]) -> None:
    axes = figure.subplots()
    modes = np.where(found.modes < 0, np.nan, found.modes.astype(float))
    axes.plot(found.axes[0].values, modes, ".", color=PLATFORM)
    for fold in folds:
        axes.axvline(fold.values[0], color=ANGLE, linewidth=0.8)
    axes.set(xlabel=_label(found, 0), ylabel="real modes")
    axes.grid(axis="y")


def _map(figure: Figure, found: Scan, folds: Sequence[Crossing]) -> None:
    from matplotlib import colormaps
    from matplotlib.colors import BoundaryNorm

    axes = figure.subplots()
    numbers = np.unique(found.modes[found.modes >= 0]).tolist() or [0]
    # One colour for each number that occurs, light for few.
    bounds = [*(number - 0.5 for number in numbers), numbers[-1] + 0.5]
    colours = colormaps["Blues"].resampled(len(numbers) + 1)
    norm = BoundaryNorm(bounds, colours.N, extend="neither")
    shown = np.ma.masked_less(found.modes.T, 0)
    x, y = (np.array(axis.values) for axis in found.axes)
    mesh = axes.pcolormesh(x, y, shown, cmap=colours, norm=norm, shading="nearest", rasterized=True)
    if folds:
        points = np.array([fold.values for fold in folds])
        axes.plot(points[:, 0], points[:, 1], ".", color=ANGLE, markersize=2.5)
    bar = figure.colorbar(mesh, ax=axes, ticks=numbers)
    bar.set_label("real modes")
    axes.set(xlabel=_label(found, 0), ylabel=_label(found, 1))
