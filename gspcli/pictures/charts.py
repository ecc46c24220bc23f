"""Bars of a distribution over whole numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping

from gspcli.pictures.figures import PLATFORM, SOFT, styled, written

#: Colours that people with any colour vision can distinguish (Okabe and Ito).
PALETTE = ("#0072b2", "#e69f00", "#009e73", "#d55e00")


def bar_chart(
    heights: Mapping[int, int], fmt: str, *, title: str, x_label: str, y_label: str
) -> bytes:
    """Return the bars of a distribution over whole numbers.

    Parameters
    ----------
    heights
        How often each number occurs.
    fmt
        ``svg``, ``png`` or ``pdf``.
    title, x_label, y_label
        What is shown.

    Raises
    ------
    GspError
        If matplotlib is not installed.
    """
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
