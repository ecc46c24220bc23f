"""A whole platform on its joint chains, as in the paper's Figures 14 to 16."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL, Primitive
from gspcli.catalogue.realization import Mechanism, MountedChain
from gspcli.pictures.chain_panels import draw_links
from gspcli.pictures.figures import BASE, PLATFORM, styled, written_drawing
from gspcli.pictures.joint_frames import ChainEnds, fitting, mounted, stretched
from gspcli.pictures.joint_symbols import draw_joint
from gspcli.pictures.line_drawings import draw_body
from gspcli.pictures.projection import Paper, View, separate
from gspcli.pictures.scene import DrawnBody, DrawnPrimitive, Scene
from gspcli.pictures.strokes import connection

Array = NDArray[np.float64]

#: The size of a joint as a part of that of the scene.
_JOINT = 0.042
_SIDE = 5.5
#: Joints stay in this part of a drawn line.
_INSIDE = 0.8


def mechanism_drawing(scene: Scene, mechanism: Mechanism, fmt: str, mode: int) -> bytes:
    """Return a drawing of a mechanism at an assembly mode as the content of a file.

    Parameters
    ----------
    scene, mechanism
        The same platform, its constraints in the same order.
    fmt
        ``svg``, ``png`` or ``pdf``.
    mode
        Index of the mode from 0.

    Raises
    ------
    GspError
        If matplotlib is not installed.
    """
    size = _JOINT * scene.size
    modes = scene.series[0]
    R, T = modes.R[mode], modes.T[mode]
    with styled():
        from matplotlib.figure import Figure

        figure = Figure(figsize=(_SIDE, _SIDE), layout="constrained")
        paper = Paper(figure.subplots(), View(), scene.size)
        draw_body(paper, scene.base, BASE, 1.0, np.eye(3), np.zeros(3), named=True)
        draw_body(paper, scene.platform, PLATFORM, 1.0, R, T, named=True)
        placed = [(chain, _ends(scene, chain, mode, size)) for chain in mechanism.chains]
        # The nearest chain last, each as a whole.

        def depth(ends: ChainEnds) -> float:
            return round(float((ends.platform + ends.base) @ paper.view.axes[2]) / scene.size, 6)

        placed.sort(key=lambda pair: depth(pair[1]))
        for rank, (chain, ends) in enumerate(placed):
            own = fitting(ends, size)
            joints = mounted(chain.realization, ends, own)
            with paper.layer(30.0 + 2 * rank):
                draw_links(paper, joints, ends)
                for joint in joints:
                    draw_joint(paper, joint, own, letter=False)
        paper.finish()
        separate([paper])
        return written_drawing(figure, fmt)


def _ends(scene: Scene, chain: MountedChain, mode: int, size: float) -> ChainEnds:
    """Return what a chain connects at a mode."""
    modes = scene.series[0]
    R, T = modes.R[mode], modes.T[mode]
    number = chain.constraints[0]
    bond, kind = scene.bonds[number], chain.realization.kinds[0]
    on_platform = _element(scene.platform, bond.platform_name)
    on_base = _element(scene.base, bond.base_name)
    w, v = _direction(on_platform), _direction(on_base)
    w = R @ w
    if kind.is_distance:
        platform, base = modes.strokes[number][0].points[mode]
        return ChainEnds(platform, base, w, v)
    platform, base = R @ on_platform.centre + T, on_base.centre
    if on_platform.primitive is on_base.primitive is Primitive.LINE:
        feet = connection(DLL, *(part[None] for part in (platform, w, base, v)))
        platform = platform + _drawn(on_platform, (feet.platform[0] - platform) @ w) * w
        base = base + _drawn(on_base, (feet.base[0] - base) @ v) * v
    return stretched(ChainEnds(platform, base, w, v), size)


def _drawn(element: DrawnPrimitive, along: float) -> float:
    """Return a place on a line, from the middle of its drawn part, inside that part."""
    half = _INSIDE * float(np.linalg.norm(element.outline[1] - element.outline[0])) / 2
    return min(max(along, -half), half)


def _element(body: DrawnBody, name: str) -> DrawnPrimitive:
    return next(element for element in body.elements if element.name == name)


def _direction(element: DrawnPrimitive) -> Array:
    return np.zeros(3) if element.direction is None else element.direction
