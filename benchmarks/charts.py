"""Charts of the pages: points and bubbles on logarithmic axes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from gspcli.pictures.figures import ANGLE, PLATFORM, SOFT, styled, written

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Of groups, as people with any sight of colours tell them apart (Okabe and Ito 2008).
PALETTE = ("#0072b2", "#e69f00", "#009e73", "#d55e00")
#: Area of a bubble of weight one, in square points.
_BUBBLE = 1.6


def scatter_chart(
    groups: Mapping[str, Sequence[tuple[float, float]]], fmt: str, *, x_label: str, y_label: str
) -> bytes:
    """Return points on logarithmic axes, a colour for each group.

    Parameters
    ----------
    groups
        Points by the name of their group.
    fmt
        ``svg``, ``png`` or ``pdf``.
    x_label, y_label
        What the axes show.

    Raises
    ------
    GspError
        If matplotlib is not installed.
    """
    with styled():
        from matplotlib.figure import Figure

        figure = Figure(figsize=(6.4, 4.2), layout="constrained")
        axes = figure.subplots()
        for color, (name, points) in zip((PLATFORM, ANGLE), groups.items(), strict=False):
            x, y = zip(*points, strict=True) if points else ((), ())
            axes.plot(
                x, y, "o", color=color, markersize=3.2, markeredgewidth=0, alpha=0.55, label=name
            )
        axes.set_xscale("log", base=2)
        axes.set_yscale("log")
        _plain(axes)
        axes.legend(loc="upper left")
        axes.set(xlabel=x_label, ylabel=y_label)
        return written(figure, fmt)


class Bubble(NamedTuple):
    """A disc in a chart: where it is, its area, and the group that gives its colour."""

    x: float
    y: float
    weight: float
    group: str


def bubble_chart(
    panels: Mapping[str, Sequence[Bubble]], fmt: str, *, x_label: str, y_label: str, note: str
) -> bytes:
    """Return panels of bubbles on binary logarithmic axes, with the line on which both agree.

    Parameters
    ----------
    panels
        Bubbles by the title of their panel.
    fmt
        ``svg``, ``png`` or ``pdf``.
    x_label, y_label, note
        What is shown; the note is below the panels.

    Raises
    ------
    GspError
        If matplotlib is not installed.
    """
    groups = sorted({bubble.group for bubbles in panels.values() for bubble in bubbles})
    colours = dict(zip(groups, PALETTE, strict=False))
    with styled():
        from matplotlib.figure import Figure
        from matplotlib.lines import Line2D

        figure = Figure(figsize=(4.4 * len(panels), 4.0), layout="constrained")
        for axes, (title, bubbles) in zip(
            figure.subplots(1, len(panels), squeeze=False, sharey=True)[0],
            panels.items(),
            strict=True,
        ):
            # Large ones first, so that they cover no small ones.
            ordered = sorted(bubbles, key=lambda bubble: -bubble.weight)
            axes.scatter(
                [bubble.x for bubble in ordered],
                [bubble.y for bubble in ordered],
                [_BUBBLE * bubble.weight for bubble in ordered],
                color=[colours[bubble.group] for bubble in ordered],
                alpha=0.6,
                linewidths=0,
            )
            axes.set_xscale("log", base=2)
            axes.set_yscale("log", base=2)
            ends = (min(b.y for b in bubbles), max(b.y for b in bubbles))
            axes.plot(ends, ends, color=SOFT, linewidth=0.9, linestyle=(0, (4, 3)), zorder=0)
            _plain(axes)
            axes.set(title=title, xlabel=x_label)
        figure.axes[0].set_ylabel(y_label)
        marks = [
            Line2D([], [], marker="o", linestyle="", color=color, alpha=0.7, label=name)
            for name, color in colours.items()
        ]
        figure.legend(handles=marks, loc="outside lower left", ncols=len(marks))
        figure.text(0.99, 0.03, note, ha="right", va="center", color=SOFT)
        return written(figure, fmt)


def _plain(axes: Axes) -> None:
    """Write the numbers of logarithmic axes as numbers, not as powers."""
    from matplotlib.ticker import FuncFormatter, NullLocator

    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_locator(NullLocator())
    axes.grid(visible=True)
