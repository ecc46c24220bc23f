"""Symbols of the five joints, drawn in space as the paper's figures draw them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.realization import JointKind
from gspcli.pictures.figures import ANGLE, INK
from gspcli.pictures.joint_frames import MountedJoint
from gspcli.pictures.projection import Paper
from gspcli.pictures.strokes import perpendicular

Array = NDArray[np.float64]

_FREE, _DRIVEN = "#ffffff", "#f8d3ad"
_ROUND = np.linspace(0, 2 * np.pi, 29)
#: Half length and radius of the sleeves, half sides of the boxes, in sizes of a joint.
_CYLINDER, _HINGE = (1.15, 0.46), (0.5, 0.58)
_BOX, _SLAB = (0.95, 0.44, 0.44), (0.14, 1.15, 1.15)
_BALL = 0.58
_EDGE, _ARROW = 0.9, 1.3
#: A symbol whose axis rises less than this on paper lies.
_UPRIGHT = 0.7


def draw_joint(paper: Paper, mounted: MountedJoint, size: float, *, letter: bool) -> None:
    """Draw the symbol of a joint of a size; a driven one is filled and has an arrow."""
    joint, at, axis = mounted.placed.joint, mounted.at, mounted.axis
    driven = mounted.placed.driven
    fill, edge = (_DRIVEN, ANGLE) if driven else (_FREE, INK)
    if joint is JointKind.SPHERICAL:
        _ball(paper, at, _BALL * size, fill, edge)
    elif joint is JointKind.CYLINDRICAL:
        half, radius = (size * part for part in _CYLINDER)
        paper.line(np.stack((at - 2 * half * axis, at + 2 * half * axis)), edge, 1.1)
        _sleeve(paper, at, axis, half, radius, fill, edge)
    elif joint is JointKind.REVOLUTE:
        half, radius = (size * part for part in _HINGE)
        paper.line(np.stack((at - 2 * half * axis, at + 2 * half * axis)), edge, 1.1)
        _sleeve(paper, at, axis, half, radius, fill, edge)
    else:
        box = _BOX if joint is JointKind.PRISMATIC else _SLAB
        if joint is JointKind.PRISMATIC:
            rod = 1.9 * box[0] * size * axis
            paper.line(np.stack((at - rod, at + rod)), edge, 1.6)
        _block(paper, at, axis, [size * half for half in box], fill, edge)
    if driven:
        _arrow(paper, mounted, size)
    if letter:
        # Beside what stands upright, above what lies.
        lies = joint is not JointKind.SPHERICAL and abs(axis @ paper.view.axes[1]) < _UPRIGHT
        way = np.array([-1.0, 1.0] if lies else [-1.0, 0.0])
        paper.label(at, str(mounted.placed), edge, way / np.linalg.norm(way), fontsize=9)


def _ball(paper: Paper, at: Array, radius: float, fill: str, edge: str) -> None:
    right, up, _ = paper.view.axes
    circle = at + radius * (np.outer(np.cos(_ROUND), right) + np.outer(np.sin(_ROUND), up))
    paper.face(circle, fill, edge, _EDGE, above=0.3)
    # The rim of the socket.
    part = _ROUND[(_ROUND > 3.5) & (_ROUND < 5.95)]
    rim = at + 1.28 * radius * (np.outer(np.cos(part), right) + np.outer(np.sin(part), up))
    paper.line(rim, edge, 1.3, above=0.31)


def _sleeve(
    paper: Paper, at: Array, axis: Array, half: float, radius: float, fill: str, edge: str
) -> None:
    """Draw a tube: its far end, its sides, its near end."""
    eye = paper.view.axes[2]
    first = perpendicular(axis)
    second = np.cross(axis, first)
    circle = radius * (np.outer(np.cos(_ROUND), first) + np.outer(np.sin(_ROUND), second))
    near = axis if axis @ eye >= 0 else -axis
    paper.face(at - half * near + circle, fill, edge, _EDGE, above=0.2)
    side = np.cross(axis, eye)
    norm = float(np.linalg.norm(side))
    if norm > 1e-6:
        side = radius * side / norm
        a, b = at - half * near, at + half * near
        paper.face(np.stack((a - side, a + side, b + side, b - side)), fill, fill, 0, above=0.22)
        for sign in (-1, 1):
            paper.line(np.stack((a + sign * side, b + sign * side)), edge, _EDGE, above=0.24)
    paper.face(at + half * near + circle, fill, edge, _EDGE, above=0.26)


def _block(paper: Paper, at: Array, axis: Array, halves: list[float], fill: str, edge: str) -> None:
    """Draw the three visible faces of a box whose first half side is along the axis."""
    eye = paper.view.axes[2]
    first = perpendicular(axis)
    axes = np.stack((axis, first, np.cross(axis, first))) * np.array(halves)[:, None]
    axes *= np.where(axes @ eye >= 0, 1, -1)[:, None]
    for k in range(3):
        a, b = axes[(k + 1) % 3], axes[(k + 2) % 3]
        corners = at + axes[k] + np.array([a + b, a - b, -a - b, b - a])
        paper.face(corners, fill, edge, _EDGE, above=0.2)


def _arrow(paper: Paper, mounted: MountedJoint, size: float) -> None:
    """Draw what the motor does: a push along the axis, or a turn about it."""
    at, axis = mounted.at, mounted.axis
    eye = paper.view.axes[2]
    width = _ARROW * min(1.0, 12 * size / paper.size)
    side = np.cross(axis, eye)
    norm = float(np.linalg.norm(side))
    side = side / norm if norm > 1e-6 else perpendicular(axis)
    if side @ paper.view.axes[0] < 0:
        side = -side
    if mounted.placed.joint is JointKind.PRISMATIC:
        middle = at + 1.05 * size * side
        paper.arrow(middle, middle + 1.3 * size * axis, ANGLE, width)
        paper.arrow(middle, middle - 1.3 * size * axis, ANGLE, width)
        return
    second = np.cross(axis, side)
    turn = np.linspace(-2.0, 2.0, 31)
    arc = at + 1.15 * size * (np.outer(np.cos(turn), side) + np.outer(np.sin(turn), second))
    paper.line(arc, ANGLE, width, above=0.4)
    paper.arrow(arc[-4], arc[-1] + 0.35 * (arc[-1] - arc[-4]), ANGLE, width)
