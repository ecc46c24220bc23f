"""Charts of what a calibration leaves over: residuals in standard deviations, row by row."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gspcli.pictures.figures import ANGLE, PLATFORM, SOFT, styled, written_drawing

if TYPE_CHECKING:
    from gspcli.calibration import Calibration

#: Residuals are drawn to this many decimals: the last bits are not those of another run.
_DECIMALS = 4


def residual_chart(result: Calibration, fmt: str) -> bytes:
    """Return the residuals of readings and of poses by row, and how they are distributed.

    Parameters
    ----------
    result
        A calibration. Residuals are divided by their deviations (and by the scatter, if the
        noise was not stated), so that they should look like a normal distribution; the worst row
        is marked.
    fmt
        ``svg``, ``png`` or ``pdf``.
    """
    with styled():
        import numpy as np
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
                places = np.repeat(rows[:, None], part.shape[1], axis=1)
                left.plot(
                    places.ravel(),
                    part.ravel(),
                    mark,
                    color=color,
                    markersize=3.4 if mark == "o" else 3.0,
                    markeredgewidth=0 if mark == "o" else 0.8,
                    alpha=0.8,
                    label=label,
                )
        if result.worst is not None:
            row = result.worst[0]
            every = np.concatenate((readings[row], poses[row]))
            height = float(every[int(np.nanargmax(np.abs(every)))])
            left.annotate(
                f"row {result.seen.lines[row]}",
                (row + 1, height),
                textcoords="offset points",
                xytext=(5, -3 if height > 0 else 3),
                fontsize=7,
                color=SOFT,
            )
        every = np.concatenate((readings.ravel(), poses.ravel()))
        every = every[np.isfinite(every)]
        limit = max(3.5, 1.08 * float(np.abs(every).max(initial=0.0)))
        steps = np.linspace(-limit, limit, 29)
        right.hist(every, steps, orientation="horizontal", color=SOFT, alpha=0.55)
        middle = np.linspace(-limit, limit, 200)
        # What removes the poses and the numbers found also takes some of the scatter.
        spread = float(np.sqrt(np.mean(every**2))) or 1.0
        bell = np.exp(-0.5 * (middle / spread) ** 2) / (spread * np.sqrt(2 * np.pi))
        right.plot(bell * len(every) * (steps[1] - steps[0]), middle, color=PLATFORM, linewidth=1.1)
        left.set(xlabel="row", ylabel="residual / standard deviation", ylim=(-limit, limit))
        chi = f"chi-squared {result.chi_squared / result.scatter**2:.4g} of {result.freedom}"
        left.set_title(chi)
        left.legend(loc="lower left", ncols=2, fontsize=7)
        right.set(xlabel="how many", title="all")
        return written_drawing(figure, fmt)
