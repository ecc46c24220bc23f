"""Writing of an `Instance` as the text of a file that is read as the same instance."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from gspcli.errors import ArgumentError, GspError
from gspcli.geometry.checking import expected
from gspcli.geometry.instance import Constraint, Instance, Side
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Crank, Geometry, Line, Plane, Point, Slide
from gspcli.wording import named

if TYPE_CHECKING:
    from gspcli.geometry.instance import HomePose, Shapes
    from gspcli.geometry.masses import Dynamics, Leg

_PLAIN = re.compile(r"[A-Za-z][A-Za-z0-9_.']*( [A-Za-z0-9_.']+)*")
_BODIES = ("platform", "base")
_NOT_TEXT = {"null", "true", "false", "yes", "no", "on", "off", "y", "n"}


def dump(instance: Instance, file: str | Path | TextIO) -> None:
    """Write an instance to a file, given by its path or open for text; as `dumps`.

    Raises
    ------
    ArgumentError
        If it is neither.
    GspError
        If the file cannot be written.
    """
    text = dumps(instance)
    if isinstance(file, str | Path):
        try:
            Path(file).write_text(text, encoding="utf-8")
        except OSError as error:
            reason = error.strerror or str(error)
            raise GspError(f"{named(str(file))}: cannot be written: {reason}") from error
        return
    if not hasattr(file, "write"):
        message = f"found a {type(file).__name__}, expected a path or an open file"
        raise ArgumentError(message, "file")
    file.write(text)


def dumps(instance: Instance) -> str:
    """Return the text of a file for an instance: readable, and exact for every number.

    Primitives without a name get one: P1, L1, H1 and so on.

    Raises
    ------
    GspError
        If two different primitives of a body have one name, or if the argument is no instance.
    """
    expected(instance)
    named = {where: [n for body, n, _ in instance.further if body == where] for where in _BODIES}
    rows = instance.constraints
    platform = _Body("platform", [*(row.platform_name for row in rows), *named["platform"]])
    base = _Body("base", [*(row.base_name for row in rows), *named["base"]])
    constraints = [
        _constraint(
            constraint,
            platform.named(constraint.platform_name, constraint.platform),
            base.named(constraint.base_name, constraint.base),
        )
        for constraint in rows
    ]
    for where, name, geometry in instance.further:
        (platform if where == "platform" else base).named(name, geometry)
    header = ["gsp: 1"]
    if instance.name is not None:
        header.append(f"name: {scalar(instance.name)}")
    if instance.source is not None:
        header.append(f"source: {scalar(instance.source)}")
    units = instance.units
    header.append(f"units: {{length: {scalar(units.length)}, angle: {units.angle.value}}}")
    lines = [*header, *platform.lines(), *base.lines(), "constraints:", *constraints]
    if instance.home is not None:
        lines.append(f"home: {{{_placed(instance.home, 'position')}}}")
    frames = instance.frames
    if frames is not None:
        stated = {"tool": frames.tool, "work": frames.work}
        given = [f"{key}: {{{_placed(f, 'point')}}}" for key, f in stated.items() if f is not None]
        lines.append(f"frames: {{{', '.join(given)}}}")
    if instance.readings:
        lines += ["readings:", *(f"  - {scalar(one)}" for one in instance.readings)]
    if instance.shapes is not None:
        lines.append(f"shapes: {{{_shapes(instance.shapes)}}}")
    if instance.dynamics is not None:
        lines += ["dynamics:", *_dynamics(instance.dynamics)]
    return "\n".join(lines) + "\n"


def scalar(text: str) -> str:
    """Return a text as a YAML scalar, in quotation marks if necessary."""
    if _PLAIN.fullmatch(text) and text.lower() not in _NOT_TEXT:
        return text
    return '"' + "".join(map(_escaped, text)) + '"'


def _escaped(character: str) -> str:
    if character in '"\\':
        return "\\" + character
    if character.isprintable():
        return character
    return f"\\u{ord(character):04x}" if ord(character) < 0x10000 else f"\\U{ord(character):08x}"


class _Body:
    """The primitives of one body in the order of their first use."""

    def __init__(self, key: str, names: Iterable[str]) -> None:
        self.key = key
        self.reserved = set(names)
        self.primitives: dict[str, Geometry] = {}

    def named(self, name: str, geometry: Geometry) -> str:
        """Return the name of a primitive, as a YAML scalar."""
        if not name:
            letter, number = geometry.primitive.value, 1
            while (name := f"{letter}{number}") in self.reserved:
                number += 1
            self.reserved.add(name)
        if self.primitives.setdefault(name, geometry) != geometry:
            message = f"the name {name} stands for two different primitives of the {self.key}"
            raise GspError(message)
        return scalar(name)

    def lines(self) -> list[str]:
        """Return the section of the file."""
        rows = [
            f"  {scalar(name)}: {_primitive(g, self.primitives)}"
            for name, g in self.primitives.items()
        ]
        return [f"{self.key}:", *rows]


def _vector(vector: Sequence[Number]) -> str:
    return "[" + ", ".join(map(str, vector)) + "]"


def _primitive(geometry: Geometry, body: Collection[str]) -> str:
    position = _vector(geometry.position)
    match geometry:
        case Point(cone=cone, drive=drive, partner=partner):
            tilt = turn = ""
            if partner in body:
                turn = f", with: {scalar(partner)}"
            elif drive is not None:
                turn = f", {drive.sort}: {{{_drive(drive)}}}"
            if cone is not None:
                tilt = f", cone: {{axis: {_vector(cone.axis)}, half_angle: {cone.half_angle}}}"
            return f"{{point: {position}{turn}{tilt}}}"
        case Line():
            return f"{{line: {{point: {position}, direction: {_vector(geometry.direction)}}}}}"
        case Plane():
            return f"{{plane: {{point: {position}, normal: {_vector(geometry.normal)}}}}}"


def _drive(drive: Crank | Slide) -> str:
    """Return the entries of a crank or slide."""
    if isinstance(drive, Crank):
        said = f"centre: {_vector(drive.centre)}, axis: {_vector(drive.axis)}"
        thick = "" if drive.diameter is None else f", diameter: {drive.diameter}"
        return said + _of_readings(drive) + thick
    return f"direction: {_vector(drive.direction)}" + _of_readings(drive)


def _of_readings(one: Constraint | Crank | Slide) -> str:
    """Return what a constraint, a crank or a slide states of its readings."""
    said = ""
    if one.limits is not None:
        low, high = map(one.reading_of, one.limits)
        said += f", range: [{low}, {high}]"
    for key in ("tolerance", "offset", "scale"):
        if (number := getattr(one, key)) is not None:
            said += f", {key}: {number}"
    return said


def _constraint(constraint: Constraint, platform: str, base: str) -> str:
    quantity = "distance" if constraint.kind.is_distance else "angle"
    side = "" if constraint.side is Side.BOTH else f", side: {constraint.side.value}"
    value = f"value: {constraint.reading_of(constraint.value)}{_of_readings(constraint)}{side}"
    return f"  - {{{quantity}: [{platform}, {base}], {value}}}"


def _placed(home: HomePose, origin: str) -> str:
    """Return home, or a frame, whose origin has this key."""
    said = f"{origin}: {_vector(home.position)}"
    if home.euler is not None:
        turns = zip(("rx", "ry", "rz"), home.angles, strict=True)
        return ", ".join((said, *(f"{key}: {x}" for key, x in turns), f"euler: {home.euler}"))
    return f"{said}, quaternion: {_vector(home.quaternion)}"


def _shapes(shapes: Shapes) -> str:
    said = [f"diameter: {_several(shapes.diameters)}"]
    for key, points in (("platform", shapes.platform), ("base", shapes.base)):
        if points:
            said.append(f"{key}: [{', '.join(map(_vector, points))}]")
    if shapes.near_joint is not None:
        said.append(f"near_joint: {shapes.near_joint}")
    return ", ".join(said)


def _dynamics(dynamics: Dynamics) -> list[str]:
    """Return the lines about masses."""
    body, legs, drives = dynamics.platform, dynamics.legs, dynamics.drives
    lines = [
        f"  gravity: {_vector(dynamics.gravity)}",
        f"  platform: {{mass: {body.mass}, centre: {_vector(body.centre)}, "
        f"inertia: {_vector(body.inertia)}}}",
    ]
    if len(legs) == 1:
        lines.append(f"  legs: {_leg(legs[0])}")
    elif legs:
        lines += ["  legs:", *(f"    - {_leg(leg)}" for leg in legs)]
    said = [f"inertia: {_several(drives.inertia)}"]
    if drives.stiffness is not None:
        said.append(f"stiffness: {_several(drives.stiffness)}")
    lines.append(f"  drives: {{{', '.join(said)}}}")
    arms = [f"{{mass: {a.mass}, centre: {a.centre}, inertia: {a.inertia}}}" for a in dynamics.arms]
    carriages = [f"{{mass: {one.mass}}}" for one in dynamics.carriages]
    for key, entries in (("arms", arms), ("carriages", carriages)):
        if entries:
            one = len(entries) == 1
            lines.append(f"  {key}: {entries[0] if one else '[' + ', '.join(entries) + ']'}")
    return lines


def _several(numbers: Sequence[Number]) -> str:
    return str(numbers[0]) if len(numbers) == 1 else _vector(numbers)


def _leg(leg: Leg) -> str:
    said = [
        f"{name}: {{mass: {body.mass}, centre: {body.centre}, inertia: {body.inertia}, "
        f"axial: {body.axial}}}"
        for name, body in (("cylinder", leg.cylinder), ("rod", leg.rod))
        if body is not None
    ]
    if leg.universal is not None:
        said.append(f"universal: {_vector(leg.universal)}")
    return f"{{{', '.join(said)}}}"
