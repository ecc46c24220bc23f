"""From a recognized machine to an instance, and to the text of its file with comments."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import KINDS_BY_NAME
from gspcli.defaults import IMPORTED_DIGITS
from gspcli.errors import ArgumentError
from gspcli.geometry.building import instance as made_instance
from gspcli.geometry.home_pose import HomePose
from gspcli.geometry.instance import Constraint, Instance, Side
from gspcli.geometry.lengths import METRES
from gspcli.geometry.masses import Dynamics, RigidBody
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Crank, Geometry, Line, Plane, Point, Slide, Vector
from gspcli.geometry.quaternions import quaternion_from_rotation
from gspcli.machines.driven_values import Found
from gspcli.machines.frames import place
from gspcli.machines.graph import NoPlatform
from gspcli.machines.recognition import Machine
from gspcli.spec.writing import dumps
from gspcli.wording import shown

Array = NDArray[np.float64]

#: A file that misses its own values by more than this share of the size states no home.
OPEN = 1e-3
#: A platform with less mass (kilogrammes) is one of kinematics alone.
_WEIGHTLESS = 1e-6
#: Of the size: less is rounding.
_ROUNDING = 1e-12


class _Rounding:
    """Numbers of a machine as decimals.

    Parameters
    ----------
    size
        The size of the machine.
    digits
        The number of digits, counted from the first digit of the size.
    """

    def __init__(self, machine: Machine, digits: int) -> None:
        self.digits = digits
        self.decimals = digits - 1 - math.floor(math.log10(machine.size))

    def length(self, value: float) -> Number:
        """Return a length."""
        return Number.of(repr(float(round(float(value), self.decimals)) + 0.0))

    def share(self, value: float) -> Number:
        """Return a number of order one: an entry of a direction, or an angle."""
        return Number.of(repr(float(round(float(value), self.digits)) + 0.0))

    def point(self, point: Array) -> Vector:
        """Return a point."""
        x, y, z = map(self.length, point)
        return x, y, z

    def direction(self, direction: Array) -> Vector:
        """Return a direction."""
        x, y, z = map(self.share, direction)
        return x, y, z


def instance_of(machine: Machine, digits: int = IMPORTED_DIGITS) -> Instance:
    """Return the instance of a machine.

    Parameters
    ----------
    machine
        The machine.
    digits
        The number of digits, counted from the first digit of the machine's size.

    Raises
    ------
    NoPlatform
        If more than three constraints are angles, or one occurs twice.
    """
    rounding = _Rounding(machine, digits)
    rows = [_constraint(found, rounding) for found in machine.constraints]
    angles = sum(row.kind.is_distance is False for row in rows)
    if angles > 3:
        message = f"found {angles} angles, expected at most three: the platform can be moved away"
        raise NoPlatform(message)
    graph = machine.graph
    try:
        found = made_instance(rows, length=graph.length, name=plain(graph.name) or None)
    except ArgumentError as error:
        raise NoPlatform(f"the constraints are no platform: {error}") from None
    _check_repetitions(machine, found)
    if machine.graph.has_home and machine.gap <= OPEN * machine.size:
        R, T = machine.pose[:3, :3], machine.pose[:3, 3]
        quaternion = [rounding.share(x) for x in np.asarray(quaternion_from_rotation(R))]
        found = replace(found, home=HomePose([rounding.length(x) for x in T], quaternion))
    return replace(found, dynamics=_dynamics(machine))


def _check_repetitions(machine: Machine, instance: Instance) -> None:
    """Raise `NoPlatform` if two chains hold the same distance or angle."""
    first: dict[tuple[str, str | None, str | None], str] = {}
    for found, row in zip(machine.constraints, instance.constraints, strict=True):
        key = (row.kind.name, row.platform_name, row.base_name)
        if key in first:
            what = "distance" if row.kind.is_distance else "angle"
            message = (
                f"chains {shown(first[key])} and {shown(found.chain)} hold the same {what}: these "
                "are at most five different constraints, expected six"
            )
            raise NoPlatform(message)
        first[key] = found.chain


def _constraint(found: Found, rounding: _Rounding) -> Constraint:
    held = found.held
    kind = KINDS_BY_NAME[held.kind]
    ends: list[Geometry] = []
    for letter, primitive in zip(held.kind[1:], (held.platform, held.base), strict=True):
        position = rounding.point(primitive.points[0])
        direction = rounding.direction(primitive.directions[0])
        if letter == "P":
            ends.append(Point(position))
        else:
            ends.append((Line if letter == "L" else Plane)(position, direction))
    if found.crank is not None:
        assert isinstance(ends[1], Point)
        centre, axis = rounding.point(found.crank.centre), rounding.direction(found.crank.axis)
        span = found.crank.limits and [rounding.share(x) for x in found.crank.limits]
        ends[1] = Point(ends[1].position, crank=Crank(centre, axis, span))
    if found.rail is not None:
        assert isinstance(ends[1], Point)
        span = found.rail.limits and [rounding.length(x) for x in found.rail.limits]
        slide = Slide(rounding.direction(found.rail.axis), span)
        ends[1] = Point(ends[1].position, slide=slide)
    side = Side.BOTH
    if kind.has_sides and (held.value != 0 or found.driven):
        side = Side.NEGATIVE if found.negative else Side.POSITIVE
    value = _value(abs(held.value), found, rounding)
    limits = found.limits and (
        _value(found.limits[0], found, rounding),
        _value(found.limits[1], found, rounding),
    )
    return Constraint(kind, ends[0], ends[1], value, side, limits=limits)


def _value(value: float, found: Found, rounding: _Rounding) -> Number:
    if found.kind[0] == "A":
        return rounding.share(float(np.degrees(value)))
    return rounding.length(value)


def _dynamics(machine: Machine) -> Dynamics | None:
    """Return the masses of the bodies that move with the platform, if the file states them."""
    graph = machine.graph
    bodies = [(graph.bodies[name], X) for name, X in machine.carried]
    masses = [body.mass for body, _ in bodies if body.mass is not None]
    if graph.length not in METRES or len(masses) < len(bodies) or sum(masses) <= _WEIGHTLESS:
        return None
    centres = np.array([place(X, body.centre) for body, X in bodies])
    centre = np.array(masses) @ centres / sum(masses)
    matrix = np.zeros((3, 3))
    for (body, X), mass, r in zip(bodies, masses, centres - centre, strict=True):
        matrix += X[:3, :3] @ body.inertia @ X[:3, :3].T
        matrix += mass * (r @ r * np.eye(3) - np.outer(r, r))
    moments = np.linalg.eigvalsh(matrix)
    if not (moments[0] > 0 and moments[2] <= (moments[0] + moments[1]) * (1 + 1e-12)):
        return None
    six = [*np.diag(matrix), matrix[0, 1], matrix[0, 2], matrix[1, 2]]
    platform = RigidBody(_said(sum(masses)), list(map(_said, centre)), list(map(_said, six)))
    if graph.gravity is None:
        return Dynamics(platform)
    gravity = graph.bodies[machine.structure.base].pose[:3, :3].T @ graph.gravity
    least = 1e-12 * float(np.linalg.norm(gravity))
    return Dynamics(platform, gravity=[_said(x if abs(x) > least else 0.0) for x in gravity])


def _said(value: float) -> Number:
    """Return a mass, an inertia or an acceleration with 12 digits."""
    return Number.of(repr(float(f"{float(value):.12g}") + 0.0))


def sentences(machine: Machine) -> list[str]:
    """Return a line for each constraint: chain, value, drive, and what a file cannot state."""
    lines = []
    for number, found in enumerate(machine.constraints, 1):
        held = found.held
        if held.kind[0] == "A":
            said = f"{np.degrees(held.value):.6g} deg"
        else:
            said = f"{held.value:.6g} {machine.graph.length}"
        parts = [f"{held.kind} = {said}"]
        if found.limits is not None:
            scale = 180 / np.pi if held.kind[0] == "A" else 1.0
            # A bound that is a rounding error of the machine's size is zero.
            least = _ROUNDING * (1.0 if held.kind[0] == "A" else machine.size)
            low, high = (scale * (x if abs(x) > least else 0.0) for x in found.limits)
            parts.append("fixed" if low == high else f"range {low:.6g} to {high:.6g}")
        if found.crank is not None:
            parts.append(f"base point on a crank of {found.crank.radius:.6g}")
            if found.crank.limits is not None:
                low, high = found.crank.limits
                parts.append(f"which turns by {low:.6g} to {high:.6g} deg")
        if found.rail is not None:
            parts.append("base point on a rail")
            if found.rail.limits is not None:
                low, high = found.rail.limits
                parts.append(f"which slides by {low:.6g} to {high:.6g} {machine.graph.length}")
        parts += remarks(machine, found)
        lines.append(f"{number} {plain(found.chain)}: {found.letters}: {', '.join(parts)}")
    return lines


def remarks(machine: Machine, found: Found) -> list[str]:
    """Return what an instance file cannot state about one constraint."""
    further = machine.graph.remarks.get(found.chain)
    return [plain(said) for said in (*found.remarks, *([further] if further else []))]


def text_of(machine: Machine, instance: Instance, head: list[str]) -> str:
    """Return the text of the file, with a comment for each constraint and lines at the top.

    Parameters
    ----------
    machine
        The machine.
    instance
        Its instance.
    head
        Lines of comment at the top.
    """
    comments = iter(machine.constraints)
    lines = [f"# {plain(line)}" for line in head]
    for line in dumps(instance).splitlines():
        if line.startswith("  - {"):
            found = next(comments)
            said = "; ".join([f"{plain(found.chain)}: {found.letters}", *remarks(machine, found)])
            line = f"{line}  # {said}"
        lines.append(line)
    return "\n".join(lines) + "\n"


def plain(text: str) -> str:
    """Return a text on one line with printable characters only."""
    return "".join(c if c.isprintable() else " " for c in text).strip()[:300]
