"""Charts of distributions, scans, workspaces and residuals."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gspcli.pictures.figures import ANGLE, PLATFORM, SOFT, styled, written, written_drawing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from gspcli.calibration import Calibration
    from gspcli.geometry.instance import Instance
    from gspcli.motion import Workspace
    from gspcli.motion.singularities.scans import Boundary, Scan


def bar_chart(
    heights: Mapping[int, int], fmt: str, *, title: str, x_label: str, y_label: str
) -> bytes:
    """Return the bars of a distribution: how often each whole number occurs."""
    numbers = sorted(heights) or [0]
    # Where all are even, so are the places of the bars.
    step = 1 if any(number % 2 for number in numbers) else 2
    places = range(numbers[0], numbers[-1] + 1, step)
    with styled():
        from matplotlib.figure import Figure

        figure = Figure(figsize=(6.4, 3.2), layout="constrained")
        axes = figure.subplots()
        bars = axes.bar(places, [heights.get(n, 0) for n in places], 0.8 * step, color=PLATFORM)
        if len(places) <= 16:
            # Ones that are too low to see have their number.
            axes.bar_label(bars, fontsize=7, color=SOFT, padding=2)
        axes.set_xticks(places[:: max(1, math.ceil(len(places) / 20))])
        axes.tick_params(axis="x", length=0)
        axes.grid(axis="y")
        axes.set(title=title, xlabel=x_label, ylabel=y_label)
        return written(figure, fmt)


Array = NDArray[np.float64]


def scan_chart(found: Scan, boundary: Boundary, quantity: str, fmt: str) -> bytes:
    """Return a scan as a picture: a line over one number that varies, a coloured map over two.

    Folds, or the singular curve, are drawn, too. What is shown is ``modes``, ``condition`` or
    ``clearance``; over poses the first stands for the determinant.
    """
    if "determinant" in found.numbers and quantity == "modes":
        quantity = "determinant"
    with styled():
        from matplotlib.figure import Figure

        figure = Figure(figsize=(6.0, 4.4 if len(found.axes) == 2 else 3.0), layout="constrained")
        if len(found.axes) == 2:
            _map(figure, found, boundary, quantity)
        else:
            _line(figure, found, boundary, quantity)
        return written(figure, fmt)


def _label(found: Scan, k: int) -> str:
    axis = found.axes[k]
    if axis.constraint is None:
        return f"{axis.name} ({_unit(found.instance, axis.name)})"
    kind, units = found.instance.constraints[axis.constraint].kind, found.instance.units
    unit = units.length if kind.is_distance else units.angle.value
    return f"{kind.name} {axis.name} ({unit})"


_TITLES = {
    "modes": "real modes",
    "condition": "smallest condition number of a mode",
    "clearance": "smallest proved clearance of a mode",
}


def _title(found: Scan, quantity: str) -> str:
    return quantity if "determinant" in found.numbers else _TITLES[quantity]


def _numbers(found: Scan, quantity: str) -> Array:
    """Return what is shown at each node, NaN where nothing is known."""
    numbers = found.numbers[quantity]
    if "determinant" in found.numbers:
        return numbers
    modes = found.numbers["modes"]
    if quantity == "modes":
        return np.where(modes < 0, np.nan, modes.astype(float))
    return np.where(np.isfinite(numbers) & (modes > 0), numbers, np.nan)


def _line(figure: Figure, found: Scan, boundary: Boundary, quantity: str) -> None:
    axes, over_poses = figure.subplots(), "determinant" in found.numbers
    mark = "-" if over_poses else "."
    axes.plot(found.axes[0].values, _numbers(found, quantity), mark, color=PLATFORM)
    axes.set(xlabel=_label(found, 0), ylabel=_title(found, quantity))
    if quantity == "determinant":
        axes.axhline(0, color=ANGLE, linewidth=0.8)
    if over_poses:
        return
    for fold in boundary.crossings:
        axes.axvline(fold.values[0], color=ANGLE, linewidth=0.8)
    if quantity != "modes":
        axes.set_yscale("log")
    axes.grid(axis="y")


def _map(figure: Figure, found: Scan, boundary: Boundary, quantity: str) -> None:
    from matplotlib import colormaps
    from matplotlib.colors import BoundaryNorm

    axes = figure.subplots()
    shown = np.ma.masked_invalid(_numbers(found, quantity).T)
    x, y = (np.array(axis.values) for axis in found.axes)
    # Without a number at any node there is no logarithm, either.
    colours: dict[str, Any] = {"cmap": "viridis", "norm": "log" if shown.count() else None}
    ticks = None
    if quantity == "modes":
        ticks = np.unique(shown.compressed()).astype(int).tolist() or [0]
        # One colour for each number that occurs, light for few.
        bounds = [*(number - 0.5 for number in ticks), ticks[-1] + 0.5]
        blues = colormaps["Blues"].resampled(len(ticks) + 1)
        colours = {"cmap": blues, "norm": BoundaryNorm(bounds, blues.N, extend="neither")}
    elif quantity == "determinant":
        most = float(np.ma.max(np.ma.abs(shown))) or 1.0
        colours = {"cmap": "RdBu", "vmin": -most, "vmax": most}
    elif quantity == "clearance" and "determinant" in found.numbers:
        # It is zero at singular poses.
        colours = {"cmap": "viridis"}
    mesh = axes.pcolormesh(x, y, shown, shading="nearest", rasterized=True, **colours)
    for curve in boundary.curves:
        axes.plot(*curve.values.T, color=ANGLE, linewidth=1.0)
        axes.plot(*curve.cusps.T, "o", color=ANGLE, markersize=3.5)
    figure.colorbar(mesh, ax=axes, ticks=ticks).set_label(_title(found, quantity))
    axes.set(
        xlim=(x[0], x[-1]), ylim=(y[0], y[-1]), xlabel=_label(found, 0), ylabel=_label(found, 1)
    )


def _unit(instance: Instance, name: str) -> str:
    """Return the unit of x, y, z, rx, ry or rz, or of a crank or slide."""
    is_angle = name.startswith(("r", "crank."))
    return instance.units.angle.value if is_angle else instance.units.length


_SLICES = 6
_COLUMNS = 3


def workspace_slices(found: Workspace, fmt: str) -> bytes:
    """Return a workspace over two parameters as a picture, or six even slices of one over three."""
    with styled():
        from matplotlib.figure import Figure
        from matplotlib.patches import Patch

        flat = len(found.free) == 2
        figure = Figure(figsize=(4.6, 4.4) if flat else (8.4, 6.0), layout="constrained")
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
                axes.set_title(f"{found.free[2]} = {at:.4g} {_unit(found.instance, found.free[2])}")
        inside = Patch(color=PLATFORM, label="can be reached, proved")
        edge = Patch(color=ANGLE, label="the boundary is in here; outside none can, proved")
        figure.legend(handles=[inside, edge], loc="outside lower center", ncols=2)
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
        pairs = (left, below), (right, below), (right, above), (left, above)
        corners = list(np.array(pairs).transpose(2, 0, 1))
        axes.add_collection(
            PolyCollection(corners, facecolors=colour, edgecolors="none", rasterized=True)
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
        axes.set_xlabel(f"{found.free[0]} ({_unit(found.instance, found.free[0])})")
    if left:
        axes.set_ylabel(f"{found.free[1]} ({_unit(found.instance, found.free[1])})")


#: Residuals are drawn to this many decimals: the last bits are not those of another run.
_DECIMALS = 4
#: Deviations of an outlier.
_FAR_OUT = 5.0


def residual_chart(result: Calibration, fmt: str) -> bytes:
    """Return the residuals of readings and of poses by row, and how they are distributed.

    Residuals are divided by their deviations (and by the scatter, if the noise was not stated), so
    that they should look like a normal distribution; the worst row is marked.
    """
    with styled():
        from matplotlib.figure import Figure

        readings, poses = (
            np.round(part / result.scatter, _DECIMALS)
            for part in (result.residuals, result.pose_residuals)
        )
        figure = Figure(figsize=(7.2, 3.2), layout="constrained")
        left, right = figure.subplots(1, 2, width_ratios=(2.4, 1), sharey=True)
        rows = np.arange(1, len(readings) + 1)
        for axes in (left, right):
            axes.axhspan(-1.96, 1.96, color=SOFT, alpha=0.12, linewidth=0)
            axes.axhline(0, color=SOFT, linewidth=0.6)
        groups = (("poses", poses, "x", ANGLE), ("readings", readings, "o", PLATFORM))
        for label, part, mark, color in groups:
            if part.size:
                places = np.repeat(rows, part.shape[1])
                size, edge = (3.4, 0) if mark == "o" else (3.0, 0.8)
                left.plot(
                    places, part.ravel(), mark, color=color, markersize=size,
                    markeredgewidth=edge, alpha=0.8, label=label,
                )  # fmt: skip
        # The worst rows: those whose outliers are left out, or the one that adds most.
        outliers = np.asarray(result.outliers.any(axis=1))
        worst = [] if result.worst is None else [result.worst[0]]
        for row in np.flatnonzero(outliers).tolist() or worst:
            every = np.concatenate((readings[row], poses[row]))
            height = float(every[int(np.nanargmax(np.abs(every)))])
            left.annotate(
                f"row {result.seen.lines[row]}" + (", left out" if outliers[row] else ""),
                (row + 1, height), textcoords="offset points",
                xytext=(5, -3 if height > 0 else 3), fontsize=7, color=SOFT,
            )  # fmt: skip
        every = np.concatenate((readings.ravel(), poses.ravel()))
        every = every[np.isfinite(every)]
        limit = max(3.5, 1.08 * float(np.abs(every).max(initial=0.0)))
        steps = np.linspace(-limit, limit, 29)
        right.hist(every, steps, orientation="horizontal", color=SOFT, alpha=0.55)
        middle = np.linspace(-limit, limit, 200)
        # What removes the poses and the numbers found also takes some of the scatter.
        inliers = every[np.abs(every) <= _FAR_OUT] if outliers.any() else every
        spread = float(np.sqrt(np.mean(inliers**2))) or 1.0
        bell = np.exp(-0.5 * (middle / spread) ** 2) / (spread * np.sqrt(2 * np.pi))
        right.plot(bell * len(every) * (steps[1] - steps[0]), middle, color=PLATFORM, linewidth=1.1)
        left.set(xlabel="row", ylabel="residual / standard deviation", ylim=(-limit, limit))
        chi_squared = result.chi_squared / result.scatter**2
        left.set_title(f"chi-squared {chi_squared:.4g} of {result.freedom}")
        left.legend(loc="upper left" if outliers.any() else "lower left", ncols=2, fontsize=7)
        right.set(xlabel="how many", title="all")
        return written_drawing(figure, fmt)
