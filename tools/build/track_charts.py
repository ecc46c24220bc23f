"""Charts of modes along a trajectory: the values, and where the platform goes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gspcli.pictures.charts import PALETTE
from gspcli.pictures.figures import SOFT, styled, written_drawing

if TYPE_CHECKING:
    from gspcli.motion import Track

#: This many digits of the largest coordinate are drawn: the last bits are not those of another run.
_DIGITS = 6


def track_chart(track: Track, fmt: str) -> bytes:
    """Return the values and the positions x, y, z of the modes over t, side by side.

    Parameters
    ----------
    track
        Modes along a trajectory; each has its own stroke, and its number where it begins and ends.
    fmt
        ``svg``, ``png`` or ``pdf``.
    """
    with styled():
        from matplotlib.figure import Figure

        from gspcli.geometry.readings import readings_of

        figure = Figure(figsize=(7.2, 3.0), layout="constrained")
        left, right = figure.subplots(1, 2)
        units = track.instance.units
        for k, column in enumerate(readings_of(track.instance, track.values).T):
            left.plot(track.t, column, color=SOFT, linewidth=1.0)
            left.annotate(str(k + 1), (track.t[0], column[0]), ha="right", fontsize=7)
        left.set(xlabel="t", ylabel="values", title="values of the constraints")
        strokes = ("-", "--", ":", "-.")
        places = _rounded(track.T)
        for m, mode in enumerate(track.modes.tolist()):
            for k, name in enumerate("xyz"):
                column = places[m, :, k]
                stroke = strokes[m % len(strokes)]
                right.plot(track.t, column, stroke, color=PALETTE[k], linewidth=1.2)
                ends = [0, -1]
                right.plot(track.t[ends], column[ends], "o", color=PALETTE[k], markersize=3)
                place = {"textcoords": "offset points", "xytext": (-4, -2), "ha": "right"}
                first = track.t[0], column[0]
                right.annotate(f"{name} of {mode}", first, fontsize=6, **place)
        right.margins(x=0.14)
        right.set(xlabel="t", ylabel=f"x, y, z ({units.length})", title="positions of the modes")
        return written_drawing(figure, fmt)


def _rounded(places: Any) -> Any:
    """Return coordinates, or NaN, to the digits that are drawn."""
    import numpy as np

    unit = 10.0 ** np.ceil(np.log10(np.nanmax(np.abs(places), initial=1e-300)))
    return np.round(places / unit, _DIGITS) * unit
