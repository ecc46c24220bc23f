"""LinuxCNC: joints of a hexapod in a HAL file, home and limits in the INI file beside it."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gspcli.machines.frames import frame, roll_pitch_yaw
from gspcli.machines.graph import Graph
from gspcli.machines.readers.legs import RowLeg, legs_graph
from gspcli.machines.source import SourceLine, text_of
from gspcli.wording import listed, shown

Array = NDArray[np.float64]

_PIN = re.compile(r"\s*setp\s+genhexkins\.(base|platform)\.([0-5])\.([xyz])\s+(\S+)")
_OTHER = re.compile(r"\s*setp\s+genhexkins\.(screw-lead|tool-offset)\s+(\S+)")
_UNITS = {"inch": "in", "in": "in", "imperial": "in", "mm": "mm", "metric": "mm"}


def is_hal(text: str) -> bool:
    """Return whether a text sets pins of the kinematics of hexapods."""
    return any(_PIN.match(line) for line in text.splitlines())


def read(text: str, path: Path) -> Graph:
    """Return the graph of a HAL file.

    Parameters
    ----------
    text
        The file.
    path
        The path of the file. INI files with the kinematics ``genhexkins`` are sought beside it.

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
    if word.lower() not in _UNITS:
        message = f"found {shown(word)}, expected {listed(_UNITS)}"
        raise place("TRAJ", "LINEAR_UNITS").error(message)
    home = settings.get(("TRAJ", "HOME"), settings.get(("TRAJ", "POSITION"), ("", 1)))[0]
    pose = None
    if home:
        numbers = place("TRAJ", "HOME").numbers(home, 6)
        pose = frame(roll_pitch_yaw(np.radians(numbers[3:])), numbers[:3])
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
    return legs, pose, _UNITS[word.lower()]
