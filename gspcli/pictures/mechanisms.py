"""A whole platform on its joint chains, as in the paper's Figures 14 to 16."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL, Kind, Primitive
from gspcli.catalogue.realization import (
    JointAxis,
    JointKind,
    Mechanism,
    MountedChain,
    PlacedJoint,
    Realization,
)
from gspcli.geometry.tolerances import PARALLEL_SINE
from gspcli.pictures.figures import (
    ANGLE,
    BASE,
    INK,
    PLATFORM,
    SOFT,
    styled,
    written,
    written_drawing,
)
from gspcli.pictures.line_drawings import Paper, View, draw_body, separate
from gspcli.pictures.scene import DrawnBody, DrawnPrimitive, Scene
from gspcli.pictures.stage import ConstraintEnds, connection, perpendicular
from gspcli.records import dataclass

#: The size of a joint where a chain is one unit long.
_PANEL_JOINT = 0.085
#: How far the platform is above the base, and the angle between the directions of an angle.
_HEIGHT, _TILT = 1.0, math.radians(35)
_SHAFT, _SHEET = 0.55, 0.5
_PANEL = 2.7
_MOST_COLUMNS = 3
_VIEW = View(azimuth=-55, elevation=18)


def chain_drawing(chains: Sequence[tuple[str, Realization]], fmt: str) -> bytes:
    """Return a drawing of chains, a panel with a heading each, as the content of a file."""
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


def draw_links(paper: Paper, joints: Sequence[MountedJoint], ends: ConstraintEnds) -> None:
    """Draw the links of a chain: bars from the platform through all joints to the base."""
    places = [ends.platform, *(joint.at for joint in joints)]
    if not joints[-1].placed.driven:
        # A driver is beyond the base.
        places.append(ends.base)
    for a, b in pairwise(places):
        if not np.allclose(a, b):
            paper.line(np.stack((a, b)), INK, 1.8, above=-0.2)


def _panel(paper: Paper, realization: Realization) -> None:
    """Draw a chain between a piece of the platform above and one of the base below."""
    ends = _canonical(realization.kinds[0])
    joints = mounted(realization, ends, _PANEL_JOINT)
    outside = joints[-1].placed.driven
    first, last = realization.kinds[0].platform, realization.kinds[0].base
    _piece(paper, first, ends.platform, ends.w, PLATFORM)
    _piece(paper, last, ends.base, ends.v, SOFT if outside else BASE)
    with paper.layer(30.0):
        draw_links(paper, joints, ends)
    for rank, joint in enumerate(reversed(joints)):
        # From the base up, so that the upper one of two that touch is whole.
        with paper.layer(31.0 + rank):
            draw_joint(paper, joint, _PANEL_JOINT, letter=True)
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


def _canonical(kind: Kind) -> ConstraintEnds:
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
    return ConstraintEnds(top, bottom, w, v)


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
    z = at[2] + side * 1.05 * _PANEL_JOINT
    paper.line(np.stack((at, [at[0], at[1], z])), color, 2.2, above=-0.5)
    corners = np.array([[0.3, 0.3], [0.3, -0.3], [-0.3, -0.3], [-0.3, 0.3]])
    sheet = np.column_stack((corners + at[:2], np.full(4, z)))
    paper.polygon(sheet, color, 0.3, 1.0)


#: Distances between joints on one axis, and of a driver beyond the base, in sizes of a joint.
_APART, _BEYOND = 2.6, 3.4
#: Shorter legs than this are drawn longer, in sizes of a joint.
_SHORTEST = 5.0
#: Joints of a short leg are drawn smaller, but not below this part of the size.
_SMALLEST = 0.4


@dataclass(frozen=True, eq=False)
class MountedJoint:
    """A joint in space: where it is, and the unit direction of its axis, shapes (3,)."""

    placed: PlacedJoint
    at: Array
    axis: Array


def mounted(
    realization: Realization, ends: ConstraintEnds, joint: float
) -> tuple[MountedJoint, ...]:
    """Return the joints of a chain in space, from the platform to the base.

    Joints on the leg share the way between the ends; those on a line or in a plane lie side by
    side there; drivers at the base are beyond its primitive. The directions of the axes are
    true, and so are the places of joints at the ends. The size of a joint is a length.
    """
    joints = realization.chain.joints
    way = ends.base - ends.platform
    length = float(np.linalg.norm(way))
    down = way / length if length > PARALLEL_SINE else np.array([0.0, 0.0, -1.0])
    leg = down if realization.kinds[0].is_distance else _hinge(ends, down)
    across = perpendicular(leg)
    directions = {
        JointAxis.PLATFORM: ends.w,
        JointAxis.BASE: ends.v,
        JointAxis.LEG: leg,
        JointAxis.ACROSS: across,
        JointAxis.ACROSS_TOO: np.cross(leg, across),
    }
    places = _places(joints, ends, down, joint)
    if not realization.kinds[0].is_distance and JointAxis.ACROSS in {p.axis for p in joints}:
        # Three hinges and three slides have no place of their own.
        steps = np.linspace(0, 1, len(joints))
        places = [ends.platform + t * way for t in steps]
    return tuple(
        MountedJoint(placed, at, directions[placed.axis])
        for placed, at in zip(joints, places, strict=True)
    )


def fitting(ends: ConstraintEnds, joint: float) -> float:
    """Return the size of joints that find room between the ends, at most `joint`."""
    length = float(np.linalg.norm(ends.platform - ends.base))
    return joint * min(1.0, max(length / (_SHORTEST * joint), _SMALLEST))


def stretched(ends: ConstraintEnds, joint: float) -> ConstraintEnds:
    """Return the ends apart enough to draw joints between them.

    The ends of angles may be anywhere on their lines and planes; where those meet, the ends
    are moved along them.
    """
    if np.linalg.norm(ends.platform - ends.base) >= _SHORTEST * joint:
        return ends
    step = _SHORTEST * joint
    return ConstraintEnds(ends.platform + step * ends.w, ends.base + step * ends.v, ends.w, ends.v)


def _hinge(ends: ConstraintEnds, down: Array) -> Array:
    """Return the axis about which an angle turns: perpendicular to both directions."""
    axis = np.cross(ends.w, ends.v)
    norm = float(np.linalg.norm(axis))
    return axis / norm if norm > PARALLEL_SINE else perpendicular(down)


def _places(
    joints: tuple[PlacedJoint, ...], ends: ConstraintEnds, down: Array, joint: float
) -> list[Array]:
    """Return the places of the joints of a chain, in order."""
    last = len(joints)
    while last and joints[last - 1].driven and joints[last - 1].axis is JointAxis.LEG:
        last -= 1
    inside = joints[:last]
    on_leg = [k for k, placed in enumerate(inside) if placed.axis is JointAxis.LEG]
    at_platform = [k for k, placed in enumerate(inside) if placed.axis is JointAxis.PLATFORM]
    at_base = [k for k, placed in enumerate(inside) if placed.axis is JointAxis.BASE]
    across = [k for k, p in enumerate(inside) if p.axis in (JointAxis.ACROSS, JointAxis.ACROSS_TOO)]
    places: dict[int, Array] = {}
    for rank, k in enumerate(on_leg):
        t = (rank + 1) / (len(on_leg) + 1)
        places[k] = (1 - t) * ends.platform + t * ends.base
    for where, direction, which in (
        (ends.platform, ends.w, at_platform),
        (ends.base, ends.v, at_base),
    ):
        for rank, k in enumerate(which):
            offset = (rank - (len(which) - 1) / 2) * _APART * joint
            places[k] = where + offset * direction
    # In a mirrored chain they are at the platform.
    at_top = bool(across) and bool(on_leg) and across[0] < on_leg[0]
    for rank, k in enumerate(across):
        # Crossing hinges are one universal joint; slides lie one on the other.
        apart = 0.0 if joints[k].joint is JointKind.REVOLUTE else 0.55 * _APART * joint
        if at_top:
            places[k] = ends.platform + rank * apart * down
        else:
            places[k] = ends.base - (len(across) - 1 - rank) * apart * down
    for rank, k in enumerate(range(last, len(joints))):
        places[k] = ends.base + (rank + 1) * _BEYOND * joint * down
    return [places[k] for k in range(len(joints))]


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
    elif joint in (JointKind.CYLINDRICAL, JointKind.REVOLUTE):
        sleeve = _HINGE if joint is JointKind.REVOLUTE else _CYLINDER
        half, radius = (size * part for part in sleeve)
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


Array = NDArray[np.float64]

#: The size of a joint as a part of that of the scene.
_JOINT = 0.042
_SIDE = 5.5
#: Joints stay in this part of a drawn line.
_INSIDE = 0.8


def mechanism_drawing(scene: Scene, mechanism: Mechanism, fmt: str, mode: int) -> bytes:
    """Return a drawing of a mechanism at an assembly mode, from 0, as the content of a file.

    Scene and mechanism are the same platform, with its constraints in the same order.
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

        def depth(ends: ConstraintEnds) -> float:
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


def _ends(scene: Scene, chain: MountedChain, mode: int, size: float) -> ConstraintEnds:
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
        return ConstraintEnds(platform, base, w, v)
    platform, base = R @ on_platform.centre + T, on_base.centre
    if on_platform.primitive is on_base.primitive is Primitive.LINE:
        feet = connection(DLL, *(part[None] for part in (platform, w, base, v)))
        platform = platform + _drawn(on_platform, (feet.platform[0] - platform) @ w) * w
        base = base + _drawn(on_base, (feet.base[0] - base) @ v) * v
    return stretched(ConstraintEnds(platform, base, w, v), size)


def _drawn(element: DrawnPrimitive, along: float) -> float:
    """Return a place on a line, from the middle of its drawn part, inside that part."""
    half = _INSIDE * float(np.linalg.norm(element.outline[1] - element.outline[0])) / 2
    return min(max(along, -half), half)


def _element(body: DrawnBody, name: str) -> DrawnPrimitive:
    return next(element for element in body.elements if element.name == name)


def _direction(element: DrawnPrimitive) -> Array:
    return np.zeros(3) if element.direction is None else element.direction
