"""The drives of a chain: how they change the value of its constraint, its range, its crank."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.machines.chain_constraints import Held, pose_after
from gspcli.machines.kinds import Primitives, measured
from gspcli.machines.structure import BodyChain, ChainPart
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: A drive changes a value if it does by more than this, as a share of the size, or in radians.
_CHANGED = 1e-9
#: A value is the coordinate of its drive if the slope is 1 to this.
_SLOPE = 1e-6
#: The widest range of a crank, in degrees.
_TURN = 360.0
#: Points of a range at which a value is computed.
_SAMPLES = 17


@dataclass(frozen=True, eq=False)
class ArmOfCrank:
    """What turns the base's point of a constraint.

    Attributes
    ----------
    centre, axis
        A point of the axis and the unit axis in the frame of the base, shape (3,).
    radius
        The distance of the point from it.
    limits
        The least and the greatest angle from where the point is, in degrees; None if they are not
        known, or more than a turn apart.
    """

    centre: Array
    axis: Array
    radius: float
    limits: tuple[float, float] | None


@dataclass(frozen=True, eq=False)
class RailOfCarriage:
    """What moves the base's point of a constraint along a line.

    Attributes
    ----------
    axis
        The unit direction of the rail in the frame of the base, shape (3,).
    limits
        The least and the greatest way from where the point is, if they are known.
    """

    axis: Array
    limits: tuple[float, float] | None


@dataclass(frozen=True, eq=False)
class Found:
    """A constraint of a machine.

    Attributes
    ----------
    held
        The constraint.
    chain
        The name of the chain.
    letters
        The letters of its joints, such as RRP.
    limits
        The smallest and the largest value, if they are known; equal where nothing drives it.
    driven
        Whether a drive changes the value.
    negative
        Of a distance to a plane: whether the point lies where the normal does not point. The
        limits are then those of the modulus.
    crank, rail
        What moves the base's point of a distance of two points: a hinge or a slide.
    remarks
        What an instance file cannot state.
    """

    held: Held
    chain: str
    letters: str
    limits: tuple[float, float] | None
    driven: bool
    negative: bool
    crank: ArmOfCrank | None
    rail: RailOfCarriage | None
    remarks: tuple[str, ...]

    @property
    def kind(self) -> str:
        """Its kind."""
        return self.held.kind


def with_drives(held: Held, chain: BodyChain, length: str) -> Found:
    """Return a constraint with its drives, as far as they are known.

    Parameters
    ----------
    held
        The constraint while the drives are held in the configuration of the file.
    chain
        Its chain.
    length
        The name of the unit of length.
    """
    driven = [(k, p) for k, p in enumerate(chain.parts) if p.held]
    inside = [(k, p) for k, p in driven if p.where == "inside" and _changes(held, chain, k)]
    remarks: list[str] = []
    limits: tuple[float, float] | None = None
    if not driven:
        limits = held.value, held.value
    elif len(inside) == 1:
        place_, drive = inside[0]
        held = _at_the_coordinate(held, chain, place_)
        limits = _limits(held, chain, place_, remarks)
        if not _linear(held, chain, place_):
            remarks.append(f"the value is no coordinate of {_named(drive)}")
    elif inside:
        remarks.append(f"{len(inside)} drives change the value")
    elif all(p.where == "inside" for _, p in driven):
        limits = held.value, held.value
    negative = held.value < 0 or (held.value == 0 and limits is not None and limits[1] <= 0)
    if held.kind in ("DPH", "DHP") and limits is not None and negative:
        limits = -limits[1], -limits[0]
    moved = _moved(held, [p for _, p in driven if p.where == "base"], remarks, length)
    if above := [p for _, p in driven if p.where == "platform"]:
        names = ", ".join(map(_named, above))
        remarks.append(f"the platform's {_sort(held, 1)} is moved by {names}")
    if limits is not None and limits[0] < 0:
        low, high = limits
        remarks.append(f"range [{low:.6g}, {high:.6g}], which passes zero")
        limits = None
    crank = moved if isinstance(moved, ArmOfCrank) else None
    rail = moved if isinstance(moved, RailOfCarriage) else None
    said = tuple(remarks)
    return Found(held, chain.name, chain.letters, limits, bool(inside), negative, crank, rail, said)


def _named(drive: ChainPart) -> str:
    return drive.part.name or {"R": "a hinge", "P": "a slide"}.get(drive.part.letter, "a ball")


def _sort(held: Held, position: int) -> str:
    return {"P": "point", "L": "line", "H": "plane"}[held.kind[position]]


def _value(held: Held, chain: BodyChain, drive: int) -> Callable[[float], float]:
    """Return what the constraint measures after a change of a drive."""

    def value(change: float) -> float:
        X = pose_after(chain, drive, change)
        return float(measured(held.kind, held.platform, held.base, X)[0, 0])

    return value


def _unit(held: Held, chain: BodyChain, drive: int) -> tuple[float, float]:
    """Return the unit of the drive's coordinate and that of the value."""
    size = chain.size
    own = size if chain.parts[drive].part.letter == "P" else 1.0
    return own, 1.0 if held.kind[0] == "A" else size


def _changes(held: Held, chain: BodyChain, drive: int) -> bool:
    if chain.parts[drive].part.letter == "S":
        return True
    value, (step, unit) = _value(held, chain, drive), _unit(held, chain, drive)
    return any(abs(value(d * step) - held.value) > _CHANGED * unit for d in (0.05, -0.05, 0.1))


def _linear(held: Held, chain: BodyChain, drive: int) -> bool:
    """Return whether the value changes by as much as the coordinate, in the file."""
    if chain.parts[drive].part.letter == "S":
        return False
    value, (step, unit) = _value(held, chain, drive), _unit(held, chain, drive)
    slopes = [(value(d * step) - value(-d * step)) / (2 * d * unit) for d in (1e-4, 1e-2)]
    return step == unit and all(abs(abs(slope) - 1) < _SLOPE for slope in slopes)


def _at_the_coordinate(held: Held, chain: BodyChain, drive: int) -> Held:
    """Return a distance to a plane that is the coordinate of its drive, signed.

    The chain does not say where the plane is: only its normal. Other kinds are unchanged.
    """
    if held.kind not in ("DPH", "DHP") or not _linear(held, chain, drive):
        return held
    value, (step, _) = _value(held, chain, drive), _unit(held, chain, drive)
    sign = 1.0 if value(1e-3 * step) > value(-1e-3 * step) else -1.0
    shift = held.value - sign * chain.parts[drive].part.at
    own, base = held.platform, held.base
    if held.kind == "DPH":
        base = Primitives(base.points + shift * base.directions, sign * base.directions)
    else:
        own = Primitives(own.points + shift * own.directions, sign * own.directions)
    return replace(held, platform=own, base=base, value=sign * (held.value - shift))


def _limits(
    held: Held, chain: BodyChain, drive: int, remarks: list[str]
) -> tuple[float, float] | None:
    """Return the values in the range of a drive, if they are between those at its ends."""
    part = chain.parts[drive].part
    if part.letter == "S" or not (math.isfinite(part.low) and math.isfinite(part.high)):
        return None
    value = _value(held, chain, drive)
    values = [value(x - part.at) for x in np.linspace(part.low, part.high, _SAMPLES)]
    rises = np.diff(values)
    if (rises > 0).all() or (rises < 0).all():
        return min(values), max(values)
    remarks.append(f"{_named(chain.parts[drive])} in [{part.low:.6g}, {part.high:.6g}]")
    return None


def _moved(
    held: Held, outer: list[ChainPart], remarks: list[str], length: str
) -> ArmOfCrank | RailOfCarriage | None:
    """Return what turns or slides the base's point; refuse other drives with what they move."""
    if not outer:
        return None
    drive = outer[0]
    part = drive.part
    primitive = f"the base's {_sort(held, 2)}"
    if len(outer) > 1:
        names = ", ".join(map(_named, outer))
        remarks.append(f"{primitive} is moved by {len(outer)} drives: {names}")
        return None
    bounded = math.isfinite(part.low) and math.isfinite(part.high)
    low, high = part.low - part.at, part.high - part.at
    if part.letter == "R" and held.kind == "DPP":
        point = held.base.points[0]
        centre = part.point + part.axis * ((point - part.point) @ part.axis)
        limits = None
        if bounded:
            low, high = np.degrees([low, high]).tolist()
            if high - low <= _TURN:
                limits = low, high
            else:
                remarks.append(f"the crank {_named(drive)} turns from {low:.6g} to {high:.6g} deg")
        return ArmOfCrank(centre, part.axis, float(np.linalg.norm(point - centre)), limits)
    if part.letter == "P" and held.kind == "DPP":
        return RailOfCarriage(part.axis, (low, high) if bounded else None)
    moves = "slides" if part.letter == "P" else "turns"
    axis = ", ".join(f"{x:.12g}" for x in part.axis)
    said = f"{primitive} {moves} with {_named(drive)} along [{axis}]"
    if part.letter != "P":
        centre = ", ".join(f"{x:.12g}" for x in part.point)
        said = f"{primitive} {moves} with {_named(drive)} about [{axis}] through [{centre}]"
    if bounded and part.letter == "P":
        said += f" by {low:.6g} to {high:.6g} {length}"
    remarks.append(said)
    return None
