"""A machine stated in other ways: units, frames of its bodies, their exchange, the order of rows.

Files are changed as data, and their numbers as expressions, so that nothing is rounded. A
`Statement` says how answers of one are read as answers of the first.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

import gspcli
from gspcli.geometry.instance import METRES, HomePose, Instance
from gspcli.geometry.machine import Machine
from gspcli.geometry.numbers import Number
from gspcli.geometry.quaternions import Field, quaternion_from_rotation

Array = NDArray[np.float64]

#: A rational rotation of the third row's length, and a shift in numbers of the file.
TURN = [["2/3", "-1/3", "2/3"], ["2/3", "2/3", "-1/3"], ["-1/3", "2/3", "2/3"]]
SHIFT = ["7/10", "(-3/10)", "11/10"]
#: Lengths among the numbers of a file, by key, and the power of the unit in them.
LENGTHS = {"point": 1, "centre": 1, "position": 1, "diameter": 1, "inertia": 2, "axial": 2}
POINTS, DIRECTIONS = ("point", "centre"), ("direction", "normal", "axis")


@dataclass(frozen=True)
class Statement:
    """A machine, and how its answers are read as those of the machine that it restates."""

    instance: Instance
    #: Row k here is row order[k] of the first.
    order: tuple[int, ...] = (0, 1, 2, 3, 4, 5)
    #: How many of the units of length here are one of the first.
    length: float = 1.0
    #: Angles of the first in numbers of here.
    angle: float = 1.0
    #: Turn and shift (in numbers of here) of each body.
    turns: Mapping[str, Array] = field(
        default_factory=lambda: {"platform": np.eye(3), "base": np.eye(3)}
    )
    shifts: Mapping[str, Array] = field(
        default_factory=lambda: {"platform": np.zeros(3), "base": np.zeros(3)}
    )
    exchanged: bool = False

    def pose(self, R: Field, T: Field) -> tuple[Field, Field]:
        """Return here what is the pose (R, T) of the first."""
        T = T * self.length
        if self.exchanged:
            R = np.swapaxes(R, -1, -2)
            T = -_times(R, T)
        R = self.turns["base"] @ R @ self.turns["platform"].T
        T = _times(self.turns["base"], T) + self.shifts["base"]
        return R, T - _times(R, self.shifts["platform"])

    def first(self, R: Field, T: Field) -> tuple[Field, Field]:
        """Return the pose of the first that is (R, T) here."""
        T = T + _times(R, self.shifts["platform"]) - self.shifts["base"]
        T = _times(self.turns["base"].T, T)
        R = self.turns["base"].T @ R @ self.turns["platform"]
        if self.exchanged:
            R = np.swapaxes(R, -1, -2)
            T = -_times(R, T)
        return R, T / self.length

    def place(self, point: Array, R: Array, T: Array) -> Array:
        """Return here the point of the first's base that it is where the platform is at (R, T)."""
        point = np.asarray(point) * self.length
        if self.exchanged:
            point = R.T @ (point - T * self.length)
        return self.turns["base"] @ point + self.shifts["base"]

    def rows(self, numbers: Any) -> Array:
        """Return numbers of the six constraints, in the last axis, in the order of the first."""
        return np.asarray(numbers, dtype=float)[..., np.argsort(self.order)]

    def values(self, values: Any) -> Array:
        """Return values of the constraints, or of what moves them, as the first states them."""
        rows = self.instance.constraints
        units = [self.length if row.kind.is_distance else self.angle for row in rows]
        return self.rows(np.asarray(values, dtype=float) / units)


def _times(R: Field, x: Field) -> Field:
    return np.einsum("...ij,...j->...i", R, x)


def as_data(instance: Instance) -> Any:
    """Return the instance file as data."""
    return yaml.safe_load(gspcli.dumps(instance))


def stated(data: Any) -> Instance:
    """Return the instance that data state."""
    return gspcli.loads(yaml.safe_dump(data, sort_keys=False))


def scaled(value: Any, factor: str) -> Any:
    """Return a number, or numbers, times a factor."""
    if isinstance(value, list):
        return [scaled(one, factor) for one in value]
    return f"({value})*{factor}"


def in_unit(instance: Instance, unit: str) -> Instance:
    """State a machine in another unit of length."""
    data = as_data(instance)
    factor = "5/127" if unit == "in" else repr(1 / METRES[unit])
    factor = f"{factor}*({METRES[data['units']['length']]!r})" + ("*1000" if unit == "in" else "")
    powers = {1: f"({factor})", 2: f"({factor})*({factor})"}

    def walk(node: Any) -> Any:
        if isinstance(node, list):
            return [walk(one) for one in node]
        if not isinstance(node, dict):
            return node
        lengths = LENGTHS | (
            dict.fromkeys(("value", "range", "offset"), 1) if "distance" in node else {}
        )
        lengths |= dict.fromkeys(("range", "offset"), 1) if "direction" in node else {}
        return {
            key: scaled(value, powers[lengths[key]])
            if key in lengths and not isinstance(value, dict)
            else walk(value)
            for key, value in node.items()
        }

    rotors = data.get("dynamics", {}).pop("drives", None)
    found = walk(data)
    if rotors is not None:
        # A crank turns its rotor; a slide moves its own in kilogrammes.
        rotors["inertia"] = [
            scaled(x, powers[2]) if sort == "crank" else x
            for x, sort in zip(rotors["inertia"], Machine.of(instance).sorts, strict=True)
        ]
        found["dynamics"]["drives"] = rotors
    found["units"]["length"] = unit
    return stated(found)


def in_radians(instance: Instance) -> Instance:
    """State a machine of degrees in radians; its ranges of cranks and cones are angles."""
    data = as_data(instance)
    assert data["units"]["angle"] == "deg"

    def angle(value: Any) -> Any:
        if isinstance(value, list):
            return [angle(one) for one in value]
        return float(np.radians(Number.of(value).value))

    for row in data["constraints"]:
        for key in ("value", "range") if "angle" in row else ():
            if key in row:
                row[key] = angle(row[key])
    for one in [*data["platform"].values(), *data["base"].values()]:
        if "range" in one.get("crank", {}):
            one["crank"]["range"] = angle(one["crank"]["range"])
        if "cone" in one:
            one["cone"]["half_angle"] = angle(one["cone"]["half_angle"])
    data["units"]["angle"] = "rad"
    return stated(data)


def _moved(node: Any) -> Any:
    """Return the primitives of a body in a frame that is turned and shifted."""
    if not isinstance(node, dict):
        return node
    found = {}
    for key, value in node.items():
        found[key] = value if isinstance(value, list) else _moved(value)
        if key in POINTS + DIRECTIONS and isinstance(value, list):
            shifts = SHIFT if key in POINTS else ["0"] * 3
            found[key] = [
                "+".join(f"({a})*({x})" for a, x in zip(row, value, strict=True)) + f"+{shift}"
                for row, shift in zip(TURN, shifts, strict=True)
            ]
    return found


def with_body_moved(instance: Instance, body: str) -> Statement:
    """State the platform, or the base, in a frame that is turned and shifted."""
    data = as_data(instance)
    data[body] = {name: _moved(one) for name, one in data[body].items()}
    turn = np.array([[Number.of(x).value for x in row] for row in TURN])
    shift = np.array([Number.of(x).value for x in SHIFT])
    turns = {"platform": np.eye(3), "base": np.eye(3)} | {body: turn}
    shifts = {"platform": np.zeros(3), "base": np.zeros(3)} | {body: shift}
    return _with_home(Statement(stated(_bare(data)), turns=turns, shifts=shifts), instance)


def reordered(instance: Instance) -> Statement:
    """State the constraints in another order."""
    data = as_data(instance)
    order = (3, 0, 5, 1, 4, 2)
    data["constraints"] = [data["constraints"][k] for k in order]
    data.pop("type", None)
    return Statement(stated(data), order=order)


def exchanged(instance: Instance) -> Statement:
    """State the base as the platform, and the platform as the base."""
    data = _bare(as_data(instance))
    data["platform"], data["base"] = data["base"], data["platform"]
    for row in data["constraints"]:
        key = "distance" if "distance" in row else "angle"
        row[key] = row[key][::-1]
    return _with_home(Statement(stated(data), exchanged=True), instance)


def _bare(data: Any) -> Any:
    """Return the file without what other laws are about."""
    kept = ("gsp", "units", "platform", "base", "constraints")
    return {key: data[key] for key in kept}


def _with_home(found: Statement, first: Instance) -> Statement:
    """Return a statement with the home of the first."""
    if first.home is None:
        return found
    R, T = found.pose(first.home.R(first.units.angle.in_radians), first.home.T)
    home = HomePose(T.tolist(), quaternion_from_rotation(R).tolist())
    return replace(found, instance=replace(found.instance, home=home))


def statements(instance: Instance) -> dict[str, Callable[[], Statement]]:
    """Return the ways to state a machine, by name."""
    ways: dict[str, Callable[[], Statement]] = {
        "another order": lambda: reordered(instance),
        "platform moved": lambda: with_body_moved(instance, "platform"),
        "base moved": lambda: with_body_moved(instance, "base"),
        "bodies exchanged": lambda: exchanged(instance),
    }
    length = instance.units.length
    if length in METRES:
        for unit in {"mm", "in", "m"} - {length}:
            ways[f"in {unit}"] = lambda unit=unit: Statement(
                in_unit(instance, unit), length=METRES[length] / METRES[unit]
            )
    ways["in radians"] = lambda: Statement(in_radians(instance), angle=float(np.radians(1)))
    return ways
