"""Maps of scans: how many modes there are over one or two values, with the discriminant."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gspcli.pictures.figures import ANGLE, PLATFORM, styled, written

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gspcli.motion.singularities.crossings import Boundary
    from gspcli.motion.singularities.pose_scans import PoseScan
    from gspcli.motion.singularities.value_scans import Scan

Array = NDArray[np.float64]


def mode_map(found: Scan, boundary: Boundary, quantity: str, fmt: str) -> bytes:
    """Return a scan as a picture: a stair over one value, a coloured map over two.

    Parameters
    ----------
    found
        The scan.
    boundary
        Where the number of modes changes: lines over one value, curves with cusps over two.
    quantity
        What the colours of a map are: ``modes``, ``condition`` or ``clearance``.
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
        if len(found.axes) == 2:
            _map(figure, found, boundary, quantity)
        else:
            _stair(figure, found, boundary, quantity)
        return written(figure, fmt)


def _label(found: Scan, k: int) -> str:
    constraint = found.instance.constraints[found.axes[k].constraint]
    units, drive = found.instance.units, found.axes[k].drive
    if drive:
        return f"{drive} ({units.angle.value if drive.startswith('crank.') else units.length})"
    unit = units.length if constraint.kind.is_distance else units.angle.value
    return f"{constraint.kind.name} {found.axes[k].constraint + 1} ({unit})"


_TITLES = {
    "modes": "real modes",
    "condition": "smallest condition number of a mode",
    "clearance": "smallest proved clearance of a mode",
}


def _numbers(found: Scan, quantity: str) -> Array:
    """Return what is shown at each node, NaN where nothing is known."""
    if quantity == "modes":
        return np.where(found.modes < 0, np.nan, found.modes.astype(float))
    numbers = found.conditions if quantity == "condition" else found.clearances
    assert numbers is not None
    return np.where(np.isfinite(numbers) & (found.modes > 0), numbers, np.nan)


def _stair(figure: Figure, found: Scan, boundary: Boundary, quantity: str) -> None:
    axes = figure.subplots()
    axes.plot(found.axes[0].values, _numbers(found, quantity), ".", color=PLATFORM)
    for fold in boundary.crossings:
        axes.axvline(fold.values[0], color=ANGLE, linewidth=0.8)
    axes.set(xlabel=_label(found, 0), ylabel=_TITLES[quantity])
    if quantity != "modes":
        axes.set_yscale("log")
    axes.grid(axis="y")


def _map(figure: Figure, found: Scan, boundary: Boundary, quantity: str) -> None:
    from matplotlib import colormaps
    from matplotlib.colors import BoundaryNorm, LogNorm

    axes = figure.subplots()
    shown = np.ma.masked_invalid(_numbers(found, quantity).T)
    x, y = (np.array(axis.values) for axis in found.axes)
    if quantity == "modes":
        numbers = np.unique(found.modes[found.modes >= 0]).tolist() or [0]
        # One colour for each number that occurs, light for few.
        bounds = [*(number - 0.5 for number in numbers), numbers[-1] + 0.5]
        colours = colormaps["Blues"].resampled(len(numbers) + 1)
        norm: Any = BoundaryNorm(bounds, colours.N, extend="neither")
        ticks: Any = numbers
    else:
        colours, norm, ticks = colormaps["viridis"], LogNorm(), None
    mesh = axes.pcolormesh(x, y, shown, cmap=colours, norm=norm, shading="nearest", rasterized=True)
    for curve in boundary.curves:
        axes.plot(*curve.values.T, color=ANGLE, linewidth=1.0)
        axes.plot(*curve.cusps.T, "o", color=ANGLE, markersize=3.5)
    axes.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
    bar = figure.colorbar(mesh, ax=axes, ticks=ticks)
    bar.set_label(_TITLES[quantity])
    axes.set(xlabel=_label(found, 0), ylabel=_label(found, 1))


def pose_map(found: PoseScan, quantity: str, fmt: str) -> bytes:
    """Return a scan of poses as a picture: a line over one coordinate, a coloured map over two.

    Parameters
    ----------
    found
        The scan; over two coordinates its singular curve is drawn, too.
    quantity
        What is shown: ``determinant``, ``condition`` or ``clearance``.
    fmt
        ``svg``, ``png`` or ``pdf``.
    """
    with styled():
        from matplotlib.figure import Figure

        flat = len(found.axes) == 1
        figure = Figure(figsize=(6.0, 3.0 if flat else 4.4), layout="constrained")
        axes = figure.subplots()
        numbers = {
            "determinant": lambda: found.determinants,
            "condition": lambda: found.conditions,
            "clearance": lambda: found.clearances,
        }[quantity]()
        grids = [np.array(axis.values) for axis in found.axes]
        labels = [f"{axis.name} ({_unit(found, axis.name)})" for axis in found.axes]
        if flat:
            axes.plot(grids[0], numbers, color=PLATFORM)
            if quantity == "determinant":
                axes.axhline(0, color=ANGLE, linewidth=0.8)
            axes.set(xlabel=labels[0], ylabel=quantity)
            return written(figure, fmt)
        shown = np.ma.masked_invalid(numbers.T)
        colours: dict[str, Any] = {"cmap": "viridis"}
        if quantity == "determinant":
            most = float(np.ma.max(np.ma.abs(shown))) or 1.0
            colours = {"cmap": "RdBu", "vmin": -most, "vmax": most}
        elif quantity == "condition":
            colours["norm"] = "log"
        mesh = axes.pcolormesh(*grids, shown, shading="nearest", rasterized=True, **colours)
        for curve in found.curves:
            axes.plot(*curve.T, color=ANGLE, linewidth=1.2)
        figure.colorbar(mesh, ax=axes).set_label(quantity)
        axes.set(xlabel=labels[0], ylabel=labels[1])
        return written(figure, fmt)


def _unit(found: PoseScan, name: str) -> str:
    units = found.instance.units
    return units.angle.value if name.startswith("r") else units.length
