"""Machines that are stated as legs between points: two balls and a driven slide each."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gspcli.errors import SpecError
from gspcli.geometry.euler import rotation_from_euler
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.machines.graph import Body, Graph, Joint, NoPlatform, Part, ball, frame, matrix, place
from gspcli.machines.source import MarkupElement, SourceLine, text_of
from gspcli.records import dataclass
from gspcli.wording import counted, listed, shown

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RowLeg:
    """A leg."""

    #: What the file calls it.
    name: str
    #: Its joints, each in the frame of its body, shape (3,).
    base: Array
    platform: Array
    #: Its length; None for the length at the pose of the file.
    length: float | None = None
    #: The range of the length.
    low: float = 0.0
    high: float = math.inf


def legs_graph(
    format: str,
    name: str,
    legs: Sequence[RowLeg],
    pose: Array | None,
    *,
    length: str,
    platform: Body | None = None,
    notes: Sequence[str] = (),
    remarks: Mapping[str, str] | None = None,
) -> Graph:
    """Return the graph of a machine with legs; format, name, length, notes as `Graph` has them.

    The file may state the pose of the platform, shape (4, 4), and its mass, centre and inertia.
    """
    X = _above(legs) if pose is None else pose
    bodies = {"base": Body("base", np.eye(4))}
    bodies["platform"] = Body("platform", X) if platform is None else replace(platform, pose=X)
    names = [leg.name for leg in legs]
    made: list[Joint] = []
    for number, leg in enumerate(legs, 1):
        said = leg.name if names.count(leg.name) == 1 else f"{leg.name} ({number})"
        end = place(X, leg.platform)
        apart = float(np.linalg.norm(end - leg.base))
        e = (end - leg.base) / apart if apart > 0 else np.eye(3)[2]
        value = apart if leg.length is None else leg.length
        for part in ("foot", "head"):
            bodies[f"{said}, {part}"] = Body(f"{said}, {part}", np.eye(4))
        slide = Part("P", e, leg.base, value, leg.low, leg.high, True, said)
        made += [
            Joint(f"{said}, base", "base", f"{said}, foot", np.eye(4), (ball(leg.base, said),)),
            # The length is that of the file, for any pose that the file states.
            Joint(said, f"{said}, foot", f"{said}, head", frame(T=e * (value - apart)), (slide,)),
            Joint(
                f"{said}, platform",
                f"{said}, head",
                "platform",
                X,
                (ball(end, said),),
                True,
                abs(value - apart),
            ),
        ]
    return Graph(
        format,
        name,
        bodies,
        tuple(made),
        world="base",
        length=length,
        drives_known=True,
        has_home=pose is not None,
        notes=tuple(notes),
        remarks={} if remarks is None else remarks,
    )


def _above(legs: Sequence[RowLeg]) -> Array:
    """Return a pose as far above the base as the longest leg, where the file states none."""
    longest = max((leg.length or leg.low for leg in legs), default=1.0)
    return frame(T=(0, 0, longest or 1.0))


def read_cables(bodies: MarkupElement, cables: MarkupElement, name: str) -> Graph:
    """Return the graph of a robot with one rigid body: roots ``bodies_system`` and ``cables``.

    Raises
    ------
    SpecError, NoPlatform
        If something in the files is wrong; if there is more than one body, or it is guided.
    """
    links = list(bodies.everywhere("link_rigid"))
    if len(links) != 1:
        names = listed([shown(link.get("name")) for link in links[:6]] or ["none"], "and")
        message = f"found {counted(len(links), 'moving body').replace('bodys', 'bodies')} ({names})"
        raise NoPlatform(f"{message}, expected one, the platform")
    link = links[0]
    pose = _pose(link.child("joint"))
    physical = link.child("physical")
    centre = _vector(physical.child("com_location"))
    chosen = cables.get("default_cable_set")
    sets = cables.all("cable_set")
    if not sets:
        raise cables.error("found no <cable_set>, expected one")
    cable_set = next((s for s in sets if s.get("id") == chosen), sets[0])
    legs, remarks = [], {}
    for cable in cable_set.children:
        leg = _cable(cable, centre)
        legs.append(leg)
        least, most = (cable.said(f"properties/force_{end}") for end in ("min", "max"))
        if least and most:
            low, high = cable.number(least), cable.number(most)
            remarks[leg.name] = f"tension {low:g} to {high:g} N"
    notes = []
    if len(sets) > 1:
        notes.append(f"of {len(sets)} sets of cables this is {shown(cable_set.get('id'))}")
    notes.append("CASPR states no unit of length: metres; cables only pull, gsp's legs also push")
    platform = Body("platform", pose, physical.decimal("mass"), centre, _inertia(physical))
    return legs_graph(
        "CASPR",
        link.get("name") or name,
        legs,
        pose,
        length="m",
        platform=platform,
        notes=notes,
        remarks=remarks,
    )


def _vector(element: MarkupElement) -> Array:
    return element.numbers(element.text, 3)


def _pose(joint: MarkupElement) -> Array:
    """Return the first pose of the body."""
    kind = joint.get("type")
    if kind == "SPATIAL_QUATERNION":
        q = joint.numbers(joint.needed("q_initial"), 7)
        if not np.any(q[3:]):
            raise joint.error("found the quaternion 0 0 0 0, expected any other")
        return frame(rotation_from_quaternion(q[3:]), q[:3])
    if kind == "SPATIAL_EULER_XYZ":
        q = joint.numbers(joint.needed("q_initial"), 6)
        return frame(rotation_from_euler("XYZ", q[3:]), q[:3])
    message = f"found a body guided by the joint {shown(kind)}, expected a free one (SPATIAL_...)"
    raise NoPlatform(message)


def _cable(cable: MarkupElement, centre: Array) -> RowLeg:
    name = cable.get("name") or cable.tag
    ends: dict[str, list[Array]] = {}
    attachments = list(cable.everywhere("attachment"))
    for attachment in attachments:
        link = (attachment.said("link") or "").strip()
        place = _vector(attachment.child("location"))
        if link == "1" and cable.get("attachment_reference") == "com":
            place = place + centre
        ends.setdefault(link, []).append(place)
    if set(ends) != {"0", "1"} or len(attachments) != 2:
        message = f"found {counted(len(attachments), 'attachment')} of the cable {shown(name)}, "
        raise NoPlatform(message + "expected two: one on the base (0), one on the platform (1)")
    return RowLeg(name, ends["0"][0], ends["1"][0])


def _inertia(physical: MarkupElement) -> Array:
    found = physical.first("inertia")
    if found is None:
        return np.zeros((3, 3))
    return matrix(lambda entry: found.decimal(f"I{entry[1:]}"), np.eye(4))


_PIN = re.compile(r"\s*setp\s+genhexkins\.(base|platform)\.([0-5])\.([xyz])\s+(\S+)")
_OTHER = re.compile(r"\s*setp\s+genhexkins\.(screw-lead|tool-offset)\s+(\S+)")
_UNITS_OF_INI = {"inch": "in", "in": "in", "imperial": "in", "mm": "mm", "metric": "mm"}


def is_hal(text: str) -> bool:
    """Return whether a text sets pins of the kinematics of hexapods."""
    return any(_PIN.match(line) for line in text.splitlines())


def read_hal(text: str, path: Path) -> Graph:
    """Return the graph of a HAL file, with the INI file of ``genhexkins`` beside it.

    Raises
    ------
    SpecError
        With the line of what is wrong.
    """
    file = str(path)
    pins: dict[tuple[str, str, str], float] = {}
    notes = []
    for number, line in enumerate(text.splitlines(), 1):
        if match := _PIN.match(line):
            pins[match[1], match[2], match[3]] = SourceLine(file, number).number(match[4])
        elif (match := _OTHER.match(line)) and SourceLine(file, number).number(match[2]) != 0:
            notes.append(f"{match[1]} is {match[2]}: not read")
    if len(pins) != 36:
        missing = [
            f"genhexkins.{body}.{i}.{axis}"
            for body in ("base", "platform")
            for i in "012345"
            for axis in "xyz"
            if (body, i, axis) not in pins
        ]
        raise SourceLine(file).error(f"found {len(pins)} of 36 pins, expected also {missing[0]}")
    ends = [
        [np.array([pins[body, i, axis] for axis in "xyz"]) for i in "012345"]
        for body in ("base", "platform")
    ]
    settings, where = _settings(path)
    if settings is None:
        message = "found no lengths: expected an INI file beside it, with KINEMATICS = genhexkins"
        raise SourceLine(file).error(message)
    legs, pose, unit = _stated(settings, where, ends)
    notes.append(f"home, limits and unit are those of {where.name}")
    return legs_graph("LinuxCNC", path.stem, legs, pose, length=unit, notes=notes)


def _settings(path: Path) -> tuple[dict[tuple[str, str], tuple[str, int]] | None, Path]:
    """Return the settings of the first INI file for a hexapod, with their lines."""
    for file in sorted(path.parent.glob("*.ini")):
        section, found = "", dict[tuple[str, str], tuple[str, int]]()
        for number, line in enumerate(text_of(file).splitlines(), 1):
            said = line.split("#")[0].strip()
            if said.startswith("[") and said.endswith("]"):
                section = said[1:-1]
            elif "=" in said:
                key, _, value = said.partition("=")
                found.setdefault((section, key.strip()), (value.strip(), number))
        if "genhexkins" in found.get(("KINS", "KINEMATICS"), ("", 0))[0]:
            return found, file
    return None, path


def _stated(
    settings: dict[tuple[str, str], tuple[str, int]], where: Path, ends: list[list[Array]]
) -> tuple[list[RowLeg], Array | None, str]:
    """Return the legs, the pose at home and the unit of length."""
    file = str(where)

    def place(section: str, key: str) -> SourceLine:
        line = settings.get((section, key), ("", 1))[1]
        return SourceLine(file, line, 1, f"[{section}]{key}")

    word = settings.get(("TRAJ", "LINEAR_UNITS"), ("mm", 1))[0]
    if word.lower() not in _UNITS_OF_INI:
        message = f"found {shown(word)}, expected {listed(_UNITS_OF_INI)}"
        raise place("TRAJ", "LINEAR_UNITS").error(message)
    home = settings.get(("TRAJ", "HOME"), settings.get(("TRAJ", "POSITION"), ("", 1)))[0]
    pose = None
    if home:
        numbers = place("TRAJ", "HOME").numbers(home, 6)
        pose = frame(rotation_from_euler("ZYX", np.radians(numbers[3:])), numbers[:3])
    legs = []
    for i, (base, platform) in enumerate(zip(*ends, strict=True)):
        joint = f"JOINT_{i}"
        values = {}
        for key in ("HOME", "MIN_LIMIT", "MAX_LIMIT"):
            if (joint, key) in settings:
                values[key] = place(joint, key).number(settings[joint, key][0])
        low = max(values.get("MIN_LIMIT", 0.0), 0.0)
        length = values.get("HOME") or None
        legs.append(
            RowLeg(f"strut {i}", base, platform, length, low, values.get("MAX_LIMIT", math.inf))
        )
    if pose is None and any(leg.length is None for leg in legs):
        message = "found neither a home of all struts nor of the pose, expected one of them"
        raise place("TRAJ", "HOME").error(message)
    return legs, pose, _UNITS_OF_INI[word.lower()]


#: Words for the bodies, in the order of `_POINTS`.
_BASE = {"b", "base", "bottom", "fixed", "ground", "a"}
_PLATFORM = {"p", "platform", "top", "moving", "plate", "head"}
_POINTS = tuple(body + axis for body in "bp" for axis in "xyz")
#: Words for the other columns.
_WORDS = {
    "name": ("name", "leg", "strut", "joint", "actuator", "no", "number", "id", "i"),
    "length": ("length", "value", "l", "leglength", "strutlength", "distance"),
    "min": ("min", "lmin", "minl", "minimum", "minlength", "lengthmin", "shortest", "low"),
    "max": ("max", "lmax", "maxl", "maximum", "maxlength", "lengthmax", "longest", "high"),
}
_UNITS = {"m", "dm", "cm", "mm", "um", "µm", "km", "in", "inch", "ft"}
_HEADING = re.compile(r"([^\[(]*)(?:[\[(]([^\])]*)[\])])?\s*")
_NUMBER = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")


@dataclass(frozen=True)
class _Column:
    """What a column is, and the unit in its heading."""

    meaning: str
    unit: str


def read_table(text: str, file: str, name: str) -> Graph:
    """Return the graph of a table: its first row has headings; comments begin with ``#``.

    Raises
    ------
    SpecError
        With the line and the column of what is wrong.
    """
    lines = [(i, line) for i, line in enumerate(text.splitlines(), 1) if _counts(line)]
    if not lines:
        raise SourceLine(file).error("found an empty table")
    delimiter = max("\t;,", key=lines[0][1].count)
    head, *rows = [(i, _cells(line, delimiter)) for i, line in lines]
    columns = _columns(head[1], SourceLine(file, head[0]))
    units = {column.unit for column in columns if column.unit}
    if len(units) > 1:
        message = f"found columns in {listed(sorted(units), 'and')}, expected one unit"
        raise SourceLine(file, head[0]).error(message)
    comma = delimiter != ","
    legs = [_leg(number, cells, columns, SourceLine(file, i), comma)
            for number, (i, cells) in enumerate(rows, 1)]  # fmt: skip
    ignored = [shown(c) for c, m in zip(head[1], columns, strict=True) if not m.meaning]
    notes = ["the table states no pose: no home is written"]
    if all(column.meaning != "length" for column in columns):
        notes.append("the table states no lengths: they are those in the middle of min and max")
    if ignored:
        notes.append(f"not read: {listed(ignored, 'and')}")
    if not units:
        notes.append("the table states no unit: lengths are taken for mm")
    if any(leg.length is None for leg in legs):
        message = "found no length of each leg, expected a column length, or columns min and max"
        raise SourceLine(file, head[0]).error(message)
    return legs_graph("table", name, legs, None, length=units.pop() if units else "mm", notes=notes)


def is_table(text: str) -> bool:
    """Return whether the first row of a text has the headings of joints."""
    first = next((line for line in text.splitlines() if _counts(line)), "")
    cells = _cells(first, max("\t;,", key=first.count))
    return sum(_meaning(_split(cell)[0]) in _POINTS for cell in cells) >= 2


def _counts(line: str) -> bool:
    """Return whether a line is a row: not empty, and no comment."""
    return bool(line.strip(" \t;,")) and not line.lstrip().startswith("#")


def _cells(line: str, delimiter: str) -> list[str]:
    try:
        rows = list(csv.reader(io.StringIO(line), delimiter=delimiter, skipinitialspace=True))
    except csv.Error:
        return [line]
    return [cell.strip() for cell in rows[0]] if rows else []


def _split(heading: str) -> tuple[str, str]:
    match = _HEADING.fullmatch(heading)
    return (match[1].strip(), (match[2] or "").strip()) if match else (heading, "")


def _meaning(heading: str) -> str:
    """Return what a heading means: one of `_POINTS` or `_WORDS`, or nothing."""
    text = heading.lower()
    for meaning, words in _WORDS.items():
        if re.sub(r"[\s_.-]", "", text) in words:
            return meaning
    words_ = [word for word in re.split(r"[\s_.,:-]+", text) if word]
    if len(words_) == 1 and len(words_[0]) > 1:
        word = words_[0]
        # bx, xb, basex: one letter is the axis.
        words_ = [word[:-1], word[-1]] if word[-1] in "xyz" else [word[1:], word[0]]
    axes = [word for word in words_ if word in ("x", "y", "z")]
    bodies = {
        body for word in words_ for body, names in (("b", _BASE), ("p", _PLATFORM)) if word in names
    }
    known = len(axes) + sum(word in _BASE | _PLATFORM | {"joint", "point"} for word in words_)
    if len(axes) == 1 and len(bodies) == 1 and known == len(words_):
        return bodies.pop() + axes[0]
    return ""


def _columns(headings: Sequence[str], place: SourceLine) -> list[_Column]:
    columns = []
    for heading in headings:
        words, unit = _split(heading)
        meaning = _meaning(words)
        if meaning and meaning != "name" and unit and unit not in _UNITS:
            raise place.error(f"found the unit {shown(unit)}, expected {listed(sorted(_UNITS))}")
        columns.append(_Column(meaning, unit if meaning != "name" else ""))
    for meaning in (*_POINTS, *_WORDS):
        same = [shown(h) for h, c in zip(headings, columns, strict=True) if c.meaning == meaning]
        if len(same) > 1:
            raise place.error(f"found {listed(same, 'and')}, expected one column for {meaning}")
    missing = [m for m in _POINTS if all(c.meaning != m for c in columns)]
    if missing:
        found = listed(map(shown, headings[:20]), "and")
        message = f"found the columns {found}, expected also {listed(missing, 'and')}"
        raise place.error(message + " (b for the base, p for the platform)")
    return columns


def _leg(
    number: int, cells: list[str], columns: list[_Column], place: SourceLine, comma: bool
) -> RowLeg:
    if len(cells) != len(columns):
        raise place.error(f"found {len(cells)} cells, expected {len(columns)}")
    found: dict[str, str] = {}
    values: dict[str, float] = {}
    for k, (cell, column) in enumerate(zip(cells, columns, strict=True), 1):
        found[column.meaning] = cell
        if column.meaning not in ("", "name") and cell:
            values[column.meaning] = _number(
                cell, SourceLine(place.location.file, place.location.line, k), comma
            )
    missing = [m for m in _POINTS if m not in values]
    if missing:
        raise place.error(f"found no number for {listed(missing, 'and')}")
    low, high = values.get("min"), values.get("max")
    length = values.get("length")
    if length is None and low is not None and high is not None:
        length = (low + high) / 2
    if (length is not None and length <= 0) or (
        low is not None and high is not None and low > high
    ):
        raise place.error("found a length of zero or less, or a smallest above the largest")
    ends = [np.array([values[body + axis] for axis in "xyz"]) for body in "bp"]
    return RowLeg(
        found.get("name") or f"leg {number}",
        ends[0],
        ends[1],
        length,
        0.0 if low is None else low,
        math.inf if high is None else high,
    )


def _number(cell: str, place: SourceLine, comma: bool) -> float:
    """Return a number; its decimal point may be a comma where cells are not divided by commas."""
    text = cell.replace(",", ".") if comma and cell.count(",") == 1 and "." not in cell else cell
    if not _NUMBER.fullmatch(text):
        error: SpecError = place.error(f"found {shown(cell)}, expected a number")
        raise error
    return place.number(text)
