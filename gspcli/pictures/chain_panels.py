"""Joint chains on paper: one chain in a panel, as in the paper's Figures 5 to 13."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import Kind, Primitive
from gspcli.catalogue.realization import Realization
from gspcli.pictures.figures import BASE, INK, PLATFORM, SOFT, styled, written
from gspcli.pictures.joint_frames import ChainEnds, MountedJoint, mounted
from gspcli.pictures.joint_symbols import draw_joint
from gspcli.pictures.projection import Paper, View, separate
from gspcli.pictures.strokes import perpendicular

Array = NDArray[np.float64]

#: The size of a joint where a chain is one unit long.
_JOINT = 0.085
#: How far the platform is above the base, and the angle between the directions of an angle.
_HEIGHT, _TILT = 1.0, math.radians(35)
_SHAFT, _SHEET = 0.55, 0.5
_PANEL = 2.7
_MOST_COLUMNS = 3
_VIEW = View(azimuth=-55, elevation=18)


def chain_drawing(chains: Sequence[tuple[str, Realization]], fmt: str) -> bytes:
    """Return a drawing of chains, a panel each, as the content of a file.

    Parameters
    ----------
    chains
        A heading and a chain for each panel.
    fmt
        ``svg``, ``png`` or ``pdf``.

    Raises
    ------
    GspError
        If matplotlib is not installed.
    """
    columns = min(len(chains), _MOST_COLUMNS)
    rows = math.ceil(len(chains) / columns)
    with styled():
        from matplotlib.figure import Figure

        figure = Figure(figsize=(columns * _PANEL, rows * _PANEL * 1.25), layout="constrained")
        grid = figure.subplots(rows, columns, squeeze=False).ravel()
        papers = []
        for axes, (heading, realization) in zip(grid, chains, strict=False):
            paper = Paper(axes, _VIEW, 1.0)
            papers.append(paper)
            _panel(paper, realization)
            axes.set_title(f"{heading}\n{realization.chain.name}", pad=8)
        for axes in grid[len(chains) :]:
            axes.set_axis_off()
        separate(papers)
        return written(figure, fmt)


def draw_links(paper: Paper, joints: Sequence[MountedJoint], ends: ChainEnds) -> None:
    """Draw the links of a chain: bars from the platform through all joints to the base."""
    places = [ends.platform, *(joint.at for joint in joints), *_ground(joints, ends)]
    for a, b in pairwise(places):
        if not np.allclose(a, b):
            paper.line(np.stack((a, b)), INK, 1.8, above=-0.2)


def _ground(joints: Sequence[MountedJoint], ends: ChainEnds) -> list[Array]:
    """Return where the last link ends: at the base, unless a driver is beyond it."""
    return [] if joints[-1].placed.driven else [ends.base]


def _panel(paper: Paper, realization: Realization) -> None:
    """Draw a chain between a piece of the platform above and one of the base below."""
    ends = _canonical(realization.kinds[0])
    joints = mounted(realization, ends, _JOINT)
    outside = joints[-1].placed.driven
    first, last = realization.kinds[0].platform, realization.kinds[0].base
    _piece(paper, first, ends.platform, ends.w, PLATFORM)
    _piece(paper, last, ends.base, ends.v, SOFT if outside else BASE)
    with paper.layer(30.0):
        draw_links(paper, joints, ends)
    for rank, joint in enumerate(reversed(joints)):
        # From the base up, so that the upper one of two that touch is whole.
        with paper.layer(31.0 + rank):
            draw_joint(paper, joint, _JOINT, letter=True)
    if first is Primitive.POINT:
        _plate(paper, ends.platform, +1, PLATFORM)
    if outside:
        _plate(paper, joints[-1].at, -2.2, BASE)
    elif last is Primitive.POINT:
        _plate(paper, ends.base, -1, BASE)
    right = np.array([1.0, 0.0])
    paper.label(ends.platform + np.array([0.5, 0, 0.05]), "platform", PLATFORM, right, fontsize=8)
    paper.label(joints[-1].at + np.array([0.5, 0, -0.12]), "base", BASE, right, fontsize=8)
    paper.finish()


def _canonical(kind: Kind) -> ChainEnds:
    """Return primitives that show a kind well: the platform's above the base's."""
    top, bottom = np.array([0.0, 0.0, _HEIGHT]), np.zeros(3)
    x, z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    skew = np.array([math.cos(_TILT + 0.6), math.sin(_TILT + 0.6), 0.0])
    inclined = np.array([math.cos(_TILT), 0.0, math.sin(_TILT)])
    directions = {
        (Primitive.POINT, Primitive.POINT): (0 * x, 0 * x),
        (Primitive.POINT, Primitive.LINE): (0 * x, x),
        (Primitive.LINE, Primitive.POINT): (x, 0 * x),
        (Primitive.POINT, Primitive.PLANE): (0 * x, z),
        (Primitive.PLANE, Primitive.POINT): (z, 0 * x),
        (Primitive.LINE, Primitive.LINE): (skew, x),
        (Primitive.LINE, Primitive.PLANE): (inclined, z),
        (Primitive.PLANE, Primitive.LINE): (z, inclined),
        (Primitive.PLANE, Primitive.PLANE): (np.cross([0, 1.0, 0], inclined), z),
    }
    w, v = directions[kind.platform, kind.base]
    return ChainEnds(top, bottom, w, v)


def _piece(paper: Paper, sort: Primitive, at: Array, direction: Array, color: str) -> None:
    """Draw a line as a shaft and a plane as a sheet."""
    if sort is Primitive.LINE:
        paper.line(at + np.outer([-_SHAFT, _SHAFT], direction), color, 2.2, above=-0.4)
    elif sort is Primitive.PLANE:
        first = perpendicular(direction)
        second = np.cross(direction, first)
        corners = at + _SHEET * np.array(
            [first + second, first - second, -first - second, second - first]
        )
        paper.polygon(corners, color, 0.16, 1.0)


def _plate(paper: Paper, at: Array, side: float, color: str) -> None:
    """Draw a piece of a body above (1) or below (-1) a point."""
    z = at[2] + side * 1.05 * _JOINT
    paper.line(np.stack((at, [at[0], at[1], z])), color, 2.2, above=-0.5)
    corners = np.array([[0.3, 0.3], [0.3, -0.3], [-0.3, -0.3], [-0.3, 0.3]])
    sheet = np.column_stack((corners + at[:2], np.full(4, z)))
    paper.polygon(sheet, color, 0.3, 1.0)
