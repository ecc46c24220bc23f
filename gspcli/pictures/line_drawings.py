"""Scenes on paper: orthographic line drawings of one assembly mode or of several."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import Primitive
from gspcli.pictures.figures import ANGLE, BASE, DISTANCE, PLATFORM, SOFT, styled, written_drawing
from gspcli.pictures.scene import DrawnBody, Scene, SceneSeries, StrokeStyle
from gspcli.records import dataclass

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.text import Annotation

Array = NDArray[np.float64]


#: Depths become layers of this many steps.
_LAYERS = 10.0
#: Decimals, in sizes, to which places on paper are rounded.
_DECIMALS = 7
#: Of the panel beside what is drawn, as a fraction of its extent: room for names.
_MARGIN = 0.05


@dataclass(frozen=True)
class View:
    """From where a scene is drawn."""

    #: Direction of the eye about the vertical, degrees from the x axis.
    azimuth: float = -62.0
    #: Height of the eye over the horizon, degrees.
    elevation: float = 20.0

    @property
    def axes(self) -> Array:
        """The directions to the right, up, and to the eye, rows of shape (3, 3)."""
        a, e = math.radians(self.azimuth), math.radians(self.elevation)
        right = [-math.sin(a), math.cos(a), 0.0]
        eye = [math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)]
        return np.array([right, np.cross(eye, right), eye])


@dataclasses.dataclass
class Paper:
    """A panel on which things in space are drawn."""

    #: The panel.
    axes: Axes
    #: From where.
    view: View
    #: The length in space that corresponds to the whole range of layers.
    size: float
    #: The layer of everything, instead of the depth.
    fixed: float | None = None
    #: The smallest and the largest coordinates drawn so far, shape (2, 2).
    extent: Array = field(default_factory=lambda: np.array([[math.inf] * 2, [-math.inf] * 2]))
    #: Names and numbers, each with the direction in which it stands from its point, or None.
    labels: list[tuple[Annotation, Array | None]] = field(default_factory=list)
    #: Polylines beside which names stand, shape (n, 2) each.
    strokes: list[Array] = field(default_factory=list)

    @contextmanager
    def layer(self, layer: float) -> Iterator[None]:
        """Draw everything inside this context in one layer."""
        self.fixed, before = layer, self.fixed
        yield
        self.fixed = before

    def project(self, points: Array) -> tuple[Array, float]:
        """Return points (n, 3) on paper, (n, 2), and the layer of their middle."""
        # Rounded, so that the last bits of a solution do not change the drawing.
        seen = self.size * np.round(points @ self.view.axes.T / self.size, _DECIMALS)
        if self.fixed is not None:
            return seen[:, :2], self.fixed
        return seen[:, :2], 10 + float(seen[:, 2].mean()) / self.size * _LAYERS

    def _include(self, flat: Array) -> None:
        self.extent[0] = np.minimum(self.extent[0], flat.min(axis=0))
        self.extent[1] = np.maximum(self.extent[1], flat.max(axis=0))

    def line(
        self, points: Array, color: str, width: float, *, above: float = 0, **more: Any
    ) -> None:
        """Draw a polyline, width in points."""
        flat, layer = self.project(points)
        self._include(flat)
        self.strokes.append(flat)
        self.axes.plot(
            *flat.T, color=color, linewidth=width, zorder=layer + above,
            solid_capstyle="round", solid_joinstyle="round", **more,
        )  # fmt: skip

    def polygon(self, corners: Array, color: str, alpha: float, edge: float = 0.0) -> None:
        """Fill a polygon, with an edge of a width in points."""
        flat, layer = self.project(corners)
        self._include(flat)
        if edge:
            self.strokes.append(np.concatenate((flat, flat[:1])))
        self.axes.fill(*flat.T, facecolor=color, alpha=alpha, linewidth=0, zorder=layer - 0.05)
        if edge:
            self.axes.fill(*flat.T, fill=False, edgecolor=color, linewidth=edge, zorder=layer)

    def face(self, corners: Array, fill: str, edge: str, width: float, *, above: float = 0) -> None:
        """Fill a polygon so that it hides what is behind it."""
        flat, layer = self.project(corners)
        self._include(flat)
        # Names stand beside it, not in it.
        self.strokes += [np.stack((corner, flat.mean(axis=0))) for corner in flat]
        self.strokes.append(np.concatenate((flat, flat[:1])))
        self.axes.fill(
            *flat.T, facecolor=fill, edgecolor=edge, linewidth=width, zorder=layer + above,
            joinstyle="round",
        )  # fmt: skip

    def dot(self, point: Array, color: str, size: float) -> None:
        """Draw a point as a disc of a diameter in points."""
        flat, layer = self.project(point[None])
        self._include(flat)
        self.axes.plot(
            *flat.T, "o", markersize=size, color=color, zorder=layer + 0.1,
            markeredgewidth=max(0.8, size / 6),
        )  # fmt: skip

    def arrow(self, start: Array, end: Array, color: str, width: float) -> None:
        """Draw an arrow; its head is at the end."""
        flat, layer = self.project(np.stack((start, end)))
        self._include(flat)
        self.axes.annotate(
            "", xy=flat[1], xytext=flat[0], zorder=layer + 0.2, annotation_clip=False,
            arrowprops={
                "arrowstyle": "-|>", "color": color, "linewidth": width, "shrinkA": 0,
                "shrinkB": 0, "mutation_scale": 3 + 5 * width,
            },
        )  # fmt: skip

    def label(
        self, point: Array, words: str, color: str, way: Array | None = None, **more: Any
    ) -> None:
        """Write a name in a direction from its point, or a number on it; `separate` moves both."""
        from matplotlib.patheffects import withStroke

        flat, _ = self.project(point[None])
        self._include(flat)
        halo = [] if "bbox" in more else [withStroke(linewidth=2, foreground="white")]
        text = self.axes.annotate(
            words, xy=flat[0], xytext=(0, 0), color=color, textcoords="offset points",
            ha="center", va="center", annotation_clip=False,
            zorder=100 + len(self.axes.texts) / 1000, path_effects=halo, **more,
        )  # fmt: skip
        self.labels.append((text, way))

    def finish(self, reach: Array | None = None) -> None:
        """Fit the panel to what was drawn (or to a `reach` about its middle), true to scale."""
        self.axes.set_axis_off()
        middle = self.extent.mean(axis=0)
        low, high = middle - (half := self.reach if reach is None else reach), middle + half
        self.axes.set_xlim(low[0], high[0])
        self.axes.set_ylim(low[1], high[1])
        self.axes.set_aspect("equal", adjustable="box")

    @property
    def reach(self) -> Array:
        """Half the width and height of what was drawn, with a margin, shape (2,)."""
        size = self.extent[1] - self.extent[0]
        return np.asarray(size / 2 + _MARGIN * size.max())


def separate(papers: Sequence[Paper]) -> None:
    """Place names and numbers of the finished panels of a figure so that none hides another."""
    figure = papers[0].axes.get_figure(root=True)
    assert figure is not None
    # Only now panels have their places, and texts their sizes.
    figure.draw_without_rendering()
    pixels = 72 / figure.dpi
    for paper in papers:
        labels = []
        for text, way in paper.labels:
            box = text.get_bbox_patch() or text
            size = pixels * np.array(box.get_window_extent().size)
            at = pixels * paper.axes.transData.transform(text.xy)
            labels.append(Label(at, size, way))
        on_paper = [pixels * paper.axes.transData.transform(stroke) for stroke in paper.strokes]
        strokes = [np.stack((stroke[:-1], stroke[1:]), axis=1) for stroke in on_paper]
        segments = np.concatenate(strokes) if strokes else None
        for (text, _), shift in zip(paper.labels, apart(labels, segments), strict=True):
            text.set_position(tuple(shift))


#: Between a point and its name, in points of the paper, and half of the square that is the point's.
_GAP, _POINT = 4.0, 3.5
#: How wide a stroke is that a name hides, in points of the paper.
_STROKE = 1.5
#: Distances of labels from their points, as multiples of the least one.
_FAR = (1.0, 1.8, 3.0)
#: To the right, upwards, to the left, ...: what is not free is left for the next in direction.
_COMPASS = np.array([[np.cos(a), np.sin(a)] for a in np.arange(8) * np.pi / 4]).round(9)


class Label(NamedTuple):
    """A name or a number that is to be placed."""

    #: Its point on the paper, in points of the paper, shape (2,).
    at: Array
    #: Width and height, shape (2,).
    size: Array
    #: The direction in which it stands from its point if there is room, a unit vector of shape
    #: (2,); None for a number, which stands on its point then.
    way: Array | None

    @property
    def shifts(self) -> Iterator[Array]:
        """The steps from the point to the middle of the label, the best first."""
        if self.way is None:
            yield np.zeros(2)
        way = np.ones(2) if self.way is None else self.way
        nearest = _COMPASS[np.argsort(-(_COMPASS @ way).round(6), kind="stable")]
        ways = nearest if self.way is None else np.vstack((self.way, nearest))
        for far in _FAR:
            yield from far * ways * (_GAP + self.size / 2)


def apart(labels: Sequence[Label], strokes: Array | None = None) -> list[Array]:
    """Return the step from its point to the middle of each label; numbers are placed first.

    Names stand beside strokes, shape (n, 2, 2) in points of the paper, numbers on them. Where
    nothing is free the label goes where it hides least.
    """
    points = [label.at for label in labels if label.way is not None]
    taken = [np.stack((at - _POINT, at + _POINT)) for at in points]
    found = [np.zeros(2)] * len(labels)
    for k in sorted(range(len(labels)), key=lambda k: labels[k].way is not None):
        label = labels[k]
        shifts = [*label.shifts]
        boxes = np.array(taken).reshape(-1, 2, 2)
        hidden = [_shared(label.at + shift, label.size, boxes) for shift in shifts]
        if label.way is not None and strokes is not None and len(strokes):
            hidden = [
                area + _STROKE * _crossed(label.at + shift, label.size, strokes)
                for area, shift in zip(hidden, shifts, strict=True)
            ]
        found[k] = shifts[int(np.argmin(hidden))]
        middle = label.at + found[k]
        taken.append(np.stack((middle - label.size / 2, middle + label.size / 2)))
    return found


def _crossed(middle: Array, size: Array, strokes: Array) -> float:
    """Return the length of strokes, shape (n, 2, 2), in a label."""
    start, along = strokes[:, 0] - middle, strokes[:, 1] - strokes[:, 0]
    # Where a stroke enters and leaves the strip of each coordinate, as parts of its length.
    still = np.abs(along) < 1e-9
    safe = np.where(still, 1.0, along)
    ends = np.sort(np.stack((-size / 2 - start, size / 2 - start)) / safe, axis=0)
    inside = np.abs(start) <= size / 2
    low = np.where(still, np.where(inside, -np.inf, np.inf), ends[0]).max(axis=1)
    high = np.where(still, np.inf, ends[1]).min(axis=1)
    part = np.maximum(np.minimum(high, 1.0) - np.maximum(low, 0.0), 0.0)
    return round(float(part @ np.linalg.norm(along, axis=1)), 3)


def _shared(middle: Array, size: Array, boxes: Array) -> float:
    """Return the area that a label shares with boxes, shape (n, 2, 2)."""
    low, high = middle - size / 2, middle + size / 2
    sides = np.minimum(high, boxes[:, 1]) - np.maximum(low, boxes[:, 0])
    return round(float(np.prod(np.maximum(sides, 0), axis=1).sum()), 6)


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
_LARGE = 2.5
#: With more panels than this, names would be too small to read.
_NAMED_PANELS = 6


def drawing(
    scene: Scene, fmt: str, modes: Sequence[int], view: View | None = None, *, names: bool = True
) -> bytes:
    """Return a drawing of assembly modes, a panel each, as the content of a file.

    Modes are indices from 0; without any, the base alone is drawn. `names` are those of primitives
    and constraints.
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
    far = sizes > _LARGE * np.median(sizes)
    reach = reaches[~far].max(axis=0)
    return reach, np.where(far, (reaches / reach).max(axis=1), 1.0).tolist()


def _draw(paper: Paper, scene: Scene, mode: int, *, named: bool, fine: bool) -> None:
    modes, weight = scene.series[0], 0.6 if fine else 1.0
    draw_body(paper, scene.base, BASE, weight, np.eye(3), np.zeros(3), named=named)
    if mode >= 0:
        R, T = modes.R[mode], modes.T[mode]
        draw_body(paper, scene.platform, PLATFORM, weight, R, T, named=named)
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
