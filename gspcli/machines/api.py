"""A machine from the file of another program, as `gsp import` reads it."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import KINDS_BY_NAME
from gspcli.defaults import IMPORTED_DIGITS, MEETING_SHARE
from gspcli.errors import ArgumentError
from gspcli.geometry.building import instance as made_instance
from gspcli.geometry.instance import METRES, Constraint, HomePose, Instance, Side
from gspcli.geometry.masses import Dynamics, RigidBody
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Crank, Geometry, Line, Plane, Point, Slide, Vector
from gspcli.geometry.quaternions import quaternion_from_rotation
from gspcli.machines.graph import Graph, NoPlatform, place
from gspcli.machines.recognition import Found, Machine, recognized
from gspcli.machines.source import MarkupElement, SourceLine, parse, text_of
from gspcli.machines.stored import stored_text
from gspcli.records import dataclass
from gspcli.spec.reading import loads
from gspcli.spec.writing import dumps
from gspcli.wording import listed, named, shown

#: What a file can be, by what is in it.
FORMATS = (
    "<mujoco> (MJCF)",
    "<sdf> (SDF)",
    "<robot> (URDF)",
    "<cables> (CASPR)",
    "setp genhexkins (LinuxCNC)",
    "columns bx, by, bz, px, py, pz (a table)",
)


def machine_of(path: Path, *, stored: bool = True) -> Graph | Instance:
    """Return the machine of a file, or the instance that gsp stored in it if that is looked for.

    Raises
    ------
    OSError, GspError
        If it cannot be read; if it has none of the formats, or mistakes.
    """
    text, file = text_of(path), str(path)
    if text.lstrip()[:1] == "<":
        return _marked_up(text, path, stored)
    from gspcli.machines.readers import legs

    if legs.is_hal(text):
        return legs.read_hal(text, path)
    if legs.is_table(text):
        return legs.read_table(text, file, path.stem)
    first = next((line for line in text.splitlines() if line.strip()), "")
    raise SourceLine(file).error(f"found {shown(first)}, expected {listed(FORMATS)}")


def _marked_up(text: str, path: Path, stored: bool) -> Graph | Instance:
    from gspcli.machines.readers import robot_models

    root = parse(text, str(path))
    readers = {"mujoco": robot_models.read_mjcf, "sdf": robot_models.read_sdf}
    if read := readers.get(root.tag):
        return _or_stored(root, path, stored, lambda: read(root, path.stem))
    if root.tag == "robot":
        beside = robot_models.beside(path)
        texts = [text_of(beside)] if beside.exists() else []
        return _or_stored(root, path, stored, lambda: robot_models.read_urdf(root, path), *texts)
    if root.tag in ("cables", "bodies_system"):
        return _caspr(root, path)
    raise root.error(f"found <{root.tag}>, expected {listed(FORMATS)}")


def _or_stored(
    root: MarkupElement, path: Path, stored: bool, read: Callable[[], Graph], *beside: str
) -> Graph | Instance:
    """Return the instance that gsp stored in a model, else what a reader makes of it."""
    text, same = stored_text(root, *beside)
    if text is not None and same and stored:
        return loads(text, name=f"{path.name}, the stored instance")
    graph = read()
    if text is None or same:
        return graph
    note = "the model was changed after gsp wrote it: the instance stored in it is not used"
    return replace(graph, notes=(*graph.notes, note))


def _caspr(root: MarkupElement, path: Path) -> Graph:
    """Read the two files of a robot: NAME_bodies.xml and NAME_cables.xml."""
    from gspcli.machines.readers import legs

    own, other = ("cables", "bodies") if root.tag == "cables" else ("bodies", "cables")
    beside = path.with_name(path.name.replace(f"_{own}", f"_{other}"))
    if beside == path or not beside.exists():
        message = f"found the {own} alone, expected NAME_{own}.xml and NAME_{other}.xml together"
        raise root.error(message)
    found = {own: root, other: parse(text_of(beside), str(beside))}
    name = path.stem.replace(f"_{own}", "")
    return legs.read_cables(found["bodies"], found["cables"], name)


Array = NDArray[np.float64]

#: A file that misses its own values by more than this share of the size states no home.
OPEN = 1e-3
#: A platform with less mass (kilogrammes) is one of kinematics alone.
_WEIGHTLESS = 1e-6
#: Of the size: less is rounding.
_ROUNDING = 1e-12


class _Rounding:
    """Numbers of a machine as decimals, with digits counted from the first one of its size."""

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
    """Return the instance of a machine, with digits counted from the first one of its size.

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
            raise NoPlatform(
                f"chains {shown(first[key])} and {shown(found.chain)} hold the same {what}: these "
                "are at most five different constraints, expected six"
            )
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
    if (drive := found.drive) is not None:
        assert isinstance(ends[1], Point)
        axis, at = rounding.direction(drive.axis), ends[1].position
        if drive.centre is None:
            span = drive.limits and [rounding.length(x) for x in drive.limits]
            ends[1] = Point(at, slide=Slide(axis, span))
        else:
            span = drive.limits and [rounding.share(x) for x in drive.limits]
            ends[1] = Point(at, crank=Crank(rounding.point(drive.centre), axis, span))
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
    if found.held.kind[0] == "A":
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
        if (drive := found.drive) is not None:
            turns = drive.centre is not None
            parts.append(f"base point on a {f'crank of {drive.radius:.6g}' if turns else 'rail'}")
            if drive.limits is not None:
                low, high = drive.limits
                moves, unit = ("turns", "deg") if turns else ("slides", machine.graph.length)
                parts.append(f"which {moves} by {low:.6g} to {high:.6g} {unit}")
        parts += remarks(machine, found)
        lines.append(f"{number} {plain(found.chain)}: {found.letters}: {', '.join(parts)}")
    return lines


def remarks(machine: Machine, found: Found) -> list[str]:
    """Return what an instance file cannot state about one constraint."""
    further = machine.graph.remarks.get(found.chain)
    return [plain(said) for said in (*found.remarks, *([further] if further else []))]


def commented_text(machine: Machine, instance: Instance, head: list[str]) -> str:
    """Return the text of the file, with a comment for each constraint and lines at the top."""
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


@dataclass(frozen=True, eq=False)
class ImportedMachine:
    """A machine from the file of another program.

    Attributes
    ----------
    instance
        The platform.
    text
        Its instance file, with comments that say what each chain is, and what the file cannot
        state.
    format
        The format of the file that was read, such as MJCF.
    described
        One line about the file: its bodies, joints and loops, the base and the platform.
    base, platform
        The names of these two bodies in the file.
    chains
        A line for each constraint: its chain, and what the chain holds.
    notes
        What was assumed or left out, and what the file leaves open.
    """

    instance: Instance
    text: str
    format: str
    described: str
    base: str
    platform: str
    chains: tuple[str, ...]
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        bodies = f"base {shown(self.base)}, platform {shown(self.platform)}"
        return f"<ImportedMachine from {self.format}: {self.instance.type.id}; {bodies}>"

    def __str__(self) -> str:
        return self.text


def import_machine(
    file: str | os.PathLike[str],
    *,
    base: str | None = None,
    platform: str | None = None,
    meet: float = MEETING_SHARE,
    digits: int = IMPORTED_DIGITS,
) -> ImportedMachine:
    """Read a machine from the file of another program.

    Parameters
    ----------
    file
        MJCF, SDF, URDF, CASPR, LinuxCNC or a table, as `gsp import --help` lists them.
    base, platform
        The names of the bodies to take as base and platform; found if None.
    meet
        Axes that pass each other at up to this share of the size are taken to meet.
    digits
        Number of digits in the instance, counted from the first digit of the machine's size.

    Raises
    ------
    GspError
        If the file cannot be read, or describes no platform with six constraints.
    """
    if not 0 <= meet < 1:
        raise ArgumentError(f"found {meet}, expected a share from 0 to 1", "meet")
    if not 3 <= digits <= 17:
        raise ArgumentError(f"found {digits}, expected 3 to 17", "digits")
    path = Path(file)
    found = machine_of(path, stored=base is None and platform is None)
    if isinstance(found, Instance):
        note = f"{path.name} is a model that gsp wrote: this is the instance stored in it"
        text = f"# {plain(note)}.\n{dumps(found)}"
        said = f"a model of gsp with {found.type.id}"
        return ImportedMachine(found, text, "gsp", said, "world", "platform", (), (note,))
    try:
        machine = recognized(found, base=base, platform=platform, meet=meet)
        instance = instance_of(machine, digits)
    except NoPlatform as error:
        raise NoPlatform(f"{named(path)}: {found.format}: {error}") from None
    notes = tuple(map(plain, machine.notes))
    bottom, top = (plain(body) for body in (machine.structure.base, machine.structure.platform))
    head = f"Imported from {path.name} ({found.format}): base {bottom}, platform {top}"
    text = commented_text(machine, instance, [head, *notes])
    said = f"{found.format}: {found.described()}; base {bottom} ({machine.structure.reason}), "
    said += f"platform {top}"
    chains = tuple(sentences(machine))
    return ImportedMachine(instance, text, found.format, said, bottom, top, chains, notes)
