"""Scenes on paper: orthographic line drawings of one assembly mode or of several."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import Primitive
from gspcli.pictures.figures import ANGLE, BASE, DISTANCE, PLATFORM, SOFT, styled, written_drawing
from gspcli.pictures.projection import Paper, View, separate
from gspcli.pictures.scene import DrawnBody, Scene, SceneSeries, StrokeStyle

Array = NDArray[np.float64]

#: Width in points, and dashes, of each stroke.
_STROKES = {
    StrokeStyle.LEG: (2.2, "-"),
    StrokeStyle.PERPENDICULAR: (1.7, "-"),
    StrokeStyle.ARC: (1.6, "-"),
    StrokeStyle.RAY: (0.7, (0, (4, 3))),
    StrokeStyle.SQUARE: (0.7, "-"),
    StrokeStyle.GUIDE: (0.7, (0, (2, 2))),
}
_MAIN = (StrokeStyle.LEG, StrokeStyle.PERPENDICULAR, StrokeStyle.ARC)
_PANEL = 3.4
#: One drawing alone may be larger.
_ALONE = 5.0
#: A panel that needs this many times the room of the middle one has a scale of its own.
_FAR = 2.5
#: With more panels than this, names would be too small to read.
_NAMED_PANELS = 6


def drawing(
    scene: Scene,
    fmt: str,
    modes: Sequence[int],
    view: View | None = None,
    *,
    names: bool = True,
) -> bytes:
    """Return a drawing of assembly modes as the content of a file.

    Parameters
    ----------
    scene
        What to draw.
    fmt
        ``svg``, ``png`` or ``pdf``.
    modes
        Indices of the modes from 0, a panel each; with none, the base alone is drawn.
    view
        From where; a usual one if None.
    names
        Whether primitives and constraints are named.

    Raises
    ------
    GspError
        If matplotlib is not installed.
    """
    panels = [*modes] or [-1]
    columns = math.ceil(math.sqrt(1.3 * len(panels))) if len(panels) > 1 else 1
    rows = math.ceil(len(panels) / columns)
    side = _PANEL if len(panels) > 1 else _ALONE
    if len(panels) > _NAMED_PANELS:
        side /= 1.6
    with styled():
        from matplotlib.figure import Figure

        figure = Figure(figsize=(columns * side, rows * side), layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False).ravel()
        named = names and len(panels) <= _NAMED_PANELS
        papers = [Paper(axes, view or View(), scene.size) for axes in grid[: len(panels)]]
        for paper, mode in zip(papers, panels, strict=True):
            _draw(paper, scene, mode, named=named, fine=len(panels) > _NAMED_PANELS)
            if len(panels) > 1:
                paper.axes.set_title(f"mode {mode + 1}", color=SOFT, pad=8)
        reach, smaller = _scales(papers)
        for paper, times in zip(papers, smaller, strict=True):
            paper.finish(reach * times)
            if times > 1:
                paper.axes.title.set(text=f"{paper.axes.get_title()}, {times:.3g} times smaller")
                paper.axes.title.set_color(ANGLE)
        for axes in grid[len(panels) :]:
            axes.set_axis_off()
        separate(papers)
        return written_drawing(figure, fmt)


def _scales(papers: Sequence[Paper]) -> tuple[Array, list[float]]:
    """Return half the width and height of most panels, and how much smaller each is drawn.

    Panels have the scale of the largest of them. Those that need much more room than the middle
    one, as where a foot is far away, would make specks of the others: they are drawn smaller.
    """
    reaches = np.array([paper.reach for paper in papers])
    sizes = reaches.max(axis=1)
    far = sizes > _FAR * np.median(sizes)
    reach = reaches[~far].max(axis=0)
    return reach, np.where(far, (reaches / reach).max(axis=1), 1.0).tolist()


def _draw(paper: Paper, scene: Scene, mode: int, *, named: bool, fine: bool) -> None:
    modes = scene.series[0]
    weight = 0.6 if fine else 1.0
    draw_body(paper, scene.base, BASE, weight, np.eye(3), np.zeros(3), named=named)
    if mode >= 0:
        draw_body(
            paper, scene.platform, PLATFORM, weight, modes.R[mode], modes.T[mode], named=named
        )
        _constraints(paper, scene, modes, mode, weight, named=named)


def draw_body(
    paper: Paper, body: DrawnBody, color: str, weight: float, R: Array, T: Array, *, named: bool
) -> None:
    """Draw a body that is moved by R and T; `weight` scales the widths of its lines."""

    def placed(points: Array) -> Array:
        return points @ R.T + T

    for face in body.faces:
        corners = placed(face)
        if len(corners) > 2:
            paper.polygon(corners, color, 0.1 if len(body.faces) > 1 else 0.2, 1.1 * weight)
        else:
            paper.line(corners, color, 1.6 * weight)
    centre = placed(np.array([element.centre for element in body.elements])).mean(axis=0)
    for element in body.elements:
        outline = placed(element.outline)
        at = outline.mean(axis=0)
        if element.primitive is Primitive.POINT:
            paper.dot(at, color, 5 * weight)
        elif element.primitive is Primitive.LINE:
            paper.line(outline, color, 1.5 * weight)
            paper.arrow(outline[0] * 0.02 + outline[1] * 0.98, outline[1], color, 1.2 * weight)
            at = outline[1]
        else:
            paper.polygon(outline, color, 0.07, 0.8 * weight)
            assert element.direction is not None
            paper.arrow(at, at + 0.16 * paper.size * (R @ element.direction), color, 0.9 * weight)
            at = outline[2]
        if named:
            way = _outward(paper, at, centre)
            paper.label(at, element.name, color, way, fontsize=9, fontstyle="italic")


def _constraints(
    paper: Paper, scene: Scene, series: SceneSeries, pose: int, weight: float, *, named: bool
) -> None:
    for k, bond in enumerate(scene.bonds):
        color = DISTANCE if bond.kind.is_distance else ANGLE
        for stroke in series.strokes[k]:
            width, dashes = _STROKES[stroke.style]
            shade = color if stroke.style in _MAIN else SOFT
            paper.line(stroke.points[pose], shade, width * weight, linestyle=dashes)
        if named:
            box = {"boxstyle": "circle,pad=0.22", "facecolor": "white", "edgecolor": color}
            paper.label(
                series.labels[pose, k], str(bond.number), color, fontsize=7,
                bbox={**box, "linewidth": 0.7},
            )  # fmt: skip


def _outward(paper: Paper, point: Array, centre: Array) -> Array:
    """Return the direction from a point to its name, away from the middle of the body."""
    (flat, middle), _ = paper.project(np.stack((point, centre)))
    away = flat - middle
    length = float(np.linalg.norm(away))
    if length < 1e-9 * paper.size:
        return np.full(2, math.sqrt(0.5))
    return np.asarray(away / length)
