"""The numbers from which a page finds all poses again when values move.

They are the numbers of a geometry for the kernel of the page (viewer/module/). They contain the
coefficients of values in equations, solved systems with complex values from which paths start, the
equations of proofs, poses far away, and the numbers of the step of a controller. The page has no
other mathematics.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from html import escape
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP
from gspcli.certification.equations.local_frames import reach
from gspcli.certification.numbers.doubled import ERROR, Doubled, SineNumbers
from gspcli.certification.poses.many_values import COSINE_ERROR, ValueProofs
from gspcli.continuation.systems import DEGREE_IN_F, Coefficients
from gspcli.continuation.tracker import CAREFUL, DEFAULT, QUICK, TrackerOptions
from gspcli.defaults import COUNT_LIMIT, SEED, TOLERANCE
from gspcli.errors import ArgumentError, GspError
from gspcli.geometry.checking import value_range
from gspcli.geometry.coordinates import BODIES
from gspcli.geometry.enclosures import roundings
from gspcli.geometry.frames import IDENTITY, PoseFrame
from gspcli.geometry.instance import AngleUnit, Instance
from gspcli.geometry.machine import Machine, driven_points
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Crank, Line, Point
from gspcli.geometry.quaternions import quaternion_from_rotation
from gspcli.geometry.readings import factors, offsets, readings_of
from gspcli.motion.following.follower import NEVER, platform_numbers
from gspcli.motion.singularities.pose_clearances import Displacements
from gspcli.pictures.line_drawings import View
from gspcli.pictures.page import data, filled, parts
from gspcli.pictures.scene import Scene
from gspcli.pictures.stage import drawn_drives
from gspcli.records import dataclass
from gspcli.resources import data_path
from gspcli.solver.poses import CountKind, Proof
from gspcli.solver.problem import Problem
from gspcli.solver.solved_starts import SolvedStarts
from gspcli.solver.start import Start
from gspcli.solver.study_systems import coefficients_of

if TYPE_CHECKING:
    from gspcli.certification.counting import ExactCount
    from gspcli.certification.poses.many_values import ValueProofs
    from gspcli.geometry.machine import MovedPoint
    from gspcli.geometry.primitives import Vector
    from gspcli.solver.result import SolveResult


# What a live page needs to go home a safe way: limits, and a small map of poses.
#
# The page tries the straight way of values, then that of poses, then the poses of the map
# (`gspcli.motion.paths.planner`). It proves with the kernel that no pose on the way is singular,
# and looks at the limits itself.


#: Digits of the poses of the map, relative to their sizes: any pose near to them will do.
_DIGITS = 9


def live_home(result: SolveResult) -> dict[str, Any]:
    """Return what a page needs to bring a platform home.

    Returns
    -------
    dict
        ``within``: of each value or motor the least and the largest reading that the file allows,
        or None (distances to planes without sign). ``cones``: of each cone the
        ``points`` of its leg on the platform and the base, its ``body``, its unit ``axis`` in the
        frame of the body and its half ``angle`` in radians; None if cones turn with arms, so that a
        page does not look at them. ``middle``: the middle of the
        points of the platform, which straight ways of poses move on a line. ``signed``: whether
        poses with different signs of det J are apart. ``poses`` of the map: seven numbers each,
        position and quaternion; home is not among them. ``after``: the index of the next pose on
        its way, -1 for home.
    """
    instance = result.instance
    return {
        "within": _within(instance),
        "cones": _cones(result),
        "middle": result.arrangement.platform_centre.tolist(),
        # A distance of two lines turns at zero, where no pose need be singular.
        "signed": all(row.kind is not DLL for row in instance.constraints),
        **_map(result),
    }


def _within(instance: Instance) -> list[list[float] | None]:
    """Return the ranges of values, or of motors, as readings."""
    machine = Machine.of(instance)
    ends = machine.readings(np.stack((machine.low, machine.high)))
    # The page has distances to planes on the side that is asked for.
    negative = ~machine.moved & (machine.stated_arrangement.sides[machine.first] < 0)
    ends = np.where(negative, -ends, ends)
    return [sorted(pair) if np.isfinite(pair).all() else None for pair in ends.T.tolist()]


def _cones(result: SolveResult) -> list[dict[str, Any]] | None:
    instance = result.instance
    machine, joints = Machine.of(instance), result.arrangement
    if machine.cones and machine.moves:
        return None
    return [
        {
            "body": one.body,
            "axis": one.cone.unit.tolist(),
            "points": [points[one.constraint].tolist() for points in (joints.y, joints.x)],
            "angle": one.cone.half_angle.value * result.arrangement.in_radians,
        }
        for one in machine.cones
    ]


def _map(result: SolveResult) -> dict[str, Any]:
    from gspcli.motion.paths.planner import home_map

    try:
        found = home_map(result, 0 if result.home is None else result.home.number - 1)
    except GspError:
        # Such as working modes that are not known: then there are straight ways alone.
        found = None
    if found is None:
        return {"poses": [], "after": []}
    size = float(np.abs(found.T).max()) or 1.0
    decimals = _DIGITS - int(np.floor(np.log10(size)))
    numbers = np.concatenate(
        (found.T.round(decimals), quaternion_from_rotation(found.R).round(_DIGITS)), axis=1
    )
    return {"poses": numbers[1:].tolist(), "after": (found.after[1:] - 1).tolist()}


# The numbers by which a live page moves the joints of a machine whose motors do so.
#
# A crank turns a point on a circle and a slide shifts it on a line. With ``c = cos q, s = sin q``
# of a crank, or ``c = q, s = q^2`` of a slide, the equation of its rod is ``F_0 + c F_1 + s F_2``
# with quadrics F_k that do not depend on q. Let the places of the joint be all points of the plane
# of its circle, or of its line, and let the length of the rod be anything. Then the machine is a
# member of a linear family. A member in general position has as many solutions as any member can
# have that are isolated. This many proved poses at any q are all of them, and straight lines of
# coefficients from a member with complex numbers lead to all poses. The same holds for the family
# in which some motors stand where the file has them: it may have fewer solutions.


#: Random places of joints are multiples of this part, this many of them to either side.
_PLACES = 2**40
#: How far a joint is from where it is stated at random places: radians, or parts of the rod.
_SPREAD = 0.5
#: Where a motor has no range: this turn, in radians, or this part of its rod to either side.
_TURN, _DRIVE_PART = np.pi / 4, 0.3
#: The numbers of sorts of drives in viewer/module/joints.hpp.
_SORTS = {"value": 0, "crank": 1, "slide": 2}


def anywhere(instance: Instance, held: frozenset[str] = frozenset()) -> Instance:
    """Return a member of the family of a machine in general position, without drives.

    Each joint is at a random point of the plane of its circle, or of its line, exactly. Joints with
    one motor are moved alike; those of motors that are held, by names, are where they are stated.
    """
    rng = np.random.default_rng(SEED)
    drawn: dict[tuple[str, str], tuple[Number, Number]] = {}
    rows = []
    for k, row in enumerate(instance.constraints):
        still: dict[str, Any] = {}
        for one in driven_points(row):
            name = one.point.partner or one.name or str(k + 1)
            size = 1.0 if one.drive.sort == "crank" else row.value.value
            if (one.body, name) not in drawn:
                parts = (rng.integers(-_PLACES, _PLACES, 2) * _SPREAD * size).tolist()
                first, second = (Number.of(Fraction(round(x), _PLACES)) for x in parts)
                drawn[one.body, name] = first, second
            place = one.point.position
            if f"{one.drive.sort}.{name}" not in held:
                place = _place(one, *drawn[one.body, name])
            still[one.body] = Point(place, one.point.cone)
        rows.append(replace(row, limits=None, **still) if still else row)
    return replace(instance, constraints=tuple(rows), dynamics=None, home=None)


def _place(one: MovedPoint, along: Number, beside: Number) -> Vector:
    """Return a point of the line of a slide, or of the plane of the circle of a crank, exactly."""
    drive, point = one.drive, one.point.position
    if not isinstance(drive, Crank):
        return _sum(point, _scaled(along, drive.direction))
    # No root is needed: with the axis n of any length two directions are n x arm, n x (n x arm).
    arm = _sum(point, _scaled(Number.of(-1), drive.centre))
    velocity = _cross(drive.axis, arm)
    back = _cross(drive.axis, velocity)
    length = Number.of(Fraction(float(np.linalg.norm([x.value for x in drive.axis])))).fraction
    assert length is not None
    first = beside / Number.of(length)
    second = along / Number.of(length**2)
    return _sum(_sum(point, _scaled(first, velocity)), _scaled(second, back))


def _sum(a: Vector, b: Vector) -> Vector:
    x, y, z = (p + q for p, q in zip(a, b, strict=True))
    return x, y, z


def _scaled(factor: Number, a: Vector) -> Vector:
    x, y, z = (factor * one for one in a)
    return x, y, z


def _cross(a: Vector, b: Vector) -> Vector:
    def entry(j: int, k: int) -> Number:
        return a[j] * b[k] - a[k] * b[j]

    return entry(1, 2), entry(2, 0), entry(0, 1)


def counted(instance: Instance, start: Start) -> list[ExactCount | None]:
    """Return how many isolated poses a machine can have, by which motors have moved.

    Entry ``sum(2**k for k in moved)`` is the count where the motors k, of those that move joints,
    have moved, and the others are where the file has them. None: as many as its family has, of
    which the start is.
    """
    names = [name for name in Machine.of(instance).names if "." in name]
    found: list[ExactCount | None] = [None] * 2 ** len(names)
    values = np.array([row.value.value for row in instance.constraints])
    for size in range(len(names)):
        for moved in combinations(range(len(names)), size):
            # With fewer motors moved there are not more.
            fewer = [sum(2**j for j in moved if j != k) for k in moved]
            if any(found[k] is None for k in fewer):
                continue
            held = frozenset(names) - {names[k] for k in moved}
            count = SolvedStarts().count(anywhere(instance, held), values, SEED, COUNT_LIMIT)
            if count is not None and (count.solutions or 0) < start.found:
                found[sum(2**k for k in moved)] = count
    return found


def apart(instance: Instance) -> Instance:
    """Return a machine in which each rod has a motor of its own, without ranges."""
    rows = []
    for k, row in enumerate(instance.constraints):
        own: dict[str, Any] = {}
        for one in driven_points(row):
            drive: Any = replace(one.drive, limits=None)
            point = replace(one.point, partner="", **{drive.sort: drive})
            own = {one.body: point, f"{one.body}_name": f"{one.name} of {k + 1}"}
        rows.append(replace(row, limits=None, **own) if own else row)
    return replace(instance, constraints=tuple(rows), dynamics=None)


@dataclass(frozen=True, eq=False)
class LiveMotors:
    """The motors of a machine that a live page moves."""

    #: The machine.
    given: Instance
    #: Its drives.
    drives: Machine
    #: A member of its family in general position (`anywhere`).
    family: Instance

    @classmethod
    def of(cls, given: Instance) -> LiveMotors | None:
        """Return the motors of a machine; None if they move no joints."""
        machine = Machine.of(given)
        return cls(given, machine, anywhere(given)) if machine.moves else None

    def terms(self, start: Start) -> Coefficients:
        """Return the three quadrics of each rod, (3, 6, ...), multiplied as those of the start.

        Rows of values have no meaning.
        """
        drives, unit = self.drives, start.length
        given, inner = start.given, start.inner
        cranked = np.array([drives.sorts[k] == "crank" for k in drives.index])
        # A crank at 0, 90 and 180 degrees, a slide at -1, 0 and 1 units.
        steps = np.where(cranked, np.array([[0.0], [0.5], [1.0]]) * np.pi, [[-unit], [0.0], [unit]])
        samples = []
        for step in steps:
            place = np.where(drives.on_platform, 0, 1)
            q = np.zeros(drives.count)
            q[drives.index] = step
            points = drives.points(q)
            y, x = (
                np.where((drives.driven & (place == body))[:, None], (points - centre) / unit, own)
                for body, centre, own in (
                    (0, given.platform_centre, inner.y),
                    (1, given.base_centre, inner.x),
                )
            )
            values = np.where(drives.driven, drives.rods / unit, 1.0)
            samples.append(coefficients_of(inner.kinds, y, x, inner.u, inner.v, values[None])[1])
        found = Coefficients(*(np.concatenate(parts) for parts in zip(*samples, strict=True)))
        found = found.in_units(start.scale)
        square = [kind is DPP for kind in inner.kinds]
        complex_values = start.parameters[0]
        complex_values = np.where(square, np.sqrt(complex_values), complex_values)
        bodies = inner.kinds, inner.y, inner.x, inner.u, inner.v
        own = coefficients_of(*bodies, complex_values[None])[1]
        sizes = own.in_units(start.scale).sizes()[0][0]
        parts = [_parts(x, cranked, unit) for x in found]
        parts[0] = parts[0] / sizes[:, None]
        return Coefficients(*parts)

    def numbers(self, proofs: ValueProofs) -> list[Any]:
        """Return the numbers of viewer/module/joints.cpp after the first."""
        drives, scale = self.drives, proofs.scale
        relations, primitives, forms, tiny = proofs.opened
        found: list[Any] = [scale]
        for k, row in enumerate(self.given.constraints):
            sort = drives.sorts[drives.index[k]] if drives.driven[k] else "value"
            places = np.zeros((3, 3, 3))
            for one in driven_points(row):
                places = _circle(one, scale)
            rod = row.value.value
            found += [_SORTS[sort], drives.on_platform[k], rod, places]
        for k, relation in enumerate(relations):
            found += [relation, np.moveaxis(primitives[:, k], 0, -1)]
        return [*found, forms, tiny]

    def moved(
        self, found: Mapping[str, list[Any]], start: Start
    ) -> tuple[dict[str, Any], Proof | None]:
        """Return the facts about values that a page shows, for motors, and the proof of the counts.

        Besides there are ``index``, the motor of each constraint, ``names`` and ``titles`` of the
        motors, and ``counts``: the numbers of poses by which motors have moved, as `counted`.
        """
        drives = self.drives
        readings = drives.readings(np.zeros(drives.count)).tolist()
        said: dict[str, Any] = {name: [] for name in (*found, "titles")}
        for k, sort in enumerate(drives.sorts):
            user = drives.users(k)[0]
            row = self.given.constraints[user]
            body = BODIES[0] if drives.on_platform[user] else BODIES[1]
            rods = [self.given.constraints[i] for i in drives.users(k)]
            names = " ".join(getattr(rod, f"{body}_name") for rod in rods)
            if sort == "value":
                for name, list_ in found.items():
                    said[name].append(list_[user])
                said["titles"].append(f"{row.platform_name}–{row.base_name}")
                continue
            said["values"].append(readings[k])
            said["ranges"].append(self._range(k, readings[k], user))
            is_turn = sort == "crank"
            radians = is_turn and drives.units[k] == 1
            said["limits"].append([-math.pi, math.pi] if radians else [None, None])
            said["kinds"].append(sort)
            units = self.given.units
            said["units"].append(units.angle.value if is_turn else units.length)
            said["sides"].append(None)
            said["titles"].append(names)
        counts = counted(self.given, start)
        proof = start.proof
        if proof is not None:
            errors = [proof.error, *(count.error for count in counts if count is not None)]
            proof = Proof.modulo(CountKind.GEOMETRY, max(errors)) if max(errors) else proof
        said |= {
            "index": drives.index.tolist(),
            "names": list(drives.names),
            "counts": [start.found if x is None else x.solutions for x in counts],
        }
        return said, proof

    def _range(self, k: int, reading: float, user: int) -> list[float]:
        """Return the least and the largest reading of a slider."""
        drives = self.drives
        ends = np.array([drives.low[k], drives.high[k]])
        if np.isfinite(ends).all():
            ends = (ends / drives.units[k] - drives.offsets[k]) / drives.factors[k]
            return [min(reading, *ends.tolist()), max(reading, *ends.tolist())]
        far = _DRIVE_PART * drives.rods[user]
        if drives.sorts[k] == "crank":
            far = _TURN / drives.units[k]
        return [reading - far, reading + far]


def _parts(samples: Any, cranked: Any, unit: float) -> Any:
    """Return the numbers that samples (3, 6, ...) are made of: alone, by the first, the second."""
    shape = (-1,) + (1,) * (samples.ndim - 2)
    one, two, three = samples
    middle = (one + three) / 2
    crank = np.stack((middle, (one - three) / 2, two - middle))
    slide = np.stack((two, (three - one) / (2 * unit), (middle - two) / unit**2))
    return np.where(cranked.reshape(shape), crank, slide)


def _circle(one: MovedPoint, scale: float) -> Array:
    """Return middle, across and beside of a drive as `Doubled`: vectors, entries, parts."""

    def vectors() -> list[list[Any]]:
        point = [x.ball() for x in one.point.position]
        drive = one.drive
        axis = [x.ball() for x in (drive.axis if isinstance(drive, Crank) else drive.direction)]
        square = axis[0] ** 2 + axis[1] ** 2 + axis[2] ** 2
        if not isinstance(drive, Crank):
            return [point, [0 * x for x in point], [scale * x / square.sqrt() for x in axis]]
        arm = [x - c.ball() for x, c in zip(point, drive.centre, strict=True)]
        height = sum(n * x for n, x in zip(axis, arm, strict=True)) / square
        across = [x - height * n for n, x in zip(axis, arm, strict=True)]
        middle = [x - y for x, y in zip(point, across, strict=True)]
        root = square.sqrt()
        beside = [
            (axis[i] * across[j] - axis[j] * across[i]) / root for i, j in ((1, 2), (2, 0), (0, 1))
        ]
        return [middle, across, beside]

    def part(vector: int, entry: int) -> Doubled:
        # Exact: a power of two.
        return Doubled.near(lambda: vectors()[vector][entry]).scaled(1 / scale)

    return np.array([[part(k, i) for i in range(3)] for k in range(3)])


Array = NDArray[np.float64]

#: This many sets of values within the ranges are what starts are made for.
_ROWS = 1024
#: Where a value has no range: this part of it to either side, of angles of the way to their ends.
_PART = 0.3
#: This many where motors move joints.
_FEW = 16
#: A page that says more needs a moment for each set of values.
_QUICK = 100


class _Numbers:
    """Doubles, one after the other."""

    def __init__(self) -> None:
        self._parts: list[Array] = []

    def put(self, *numbers: ArrayLike) -> None:
        """Append numbers; complex ones as two each."""
        for each in numbers:
            array = np.ascontiguousarray(each)
            if array.dtype.kind == "c":
                array = array.astype(np.complex128).view(np.float64)
            self._parts.append(array.astype(np.float64).ravel())

    def text(self) -> str:
        """Return them in base64, least significant bytes first."""
        return base64.b64encode(np.concatenate(self._parts).astype("<f8").tobytes()).decode()


def live_numbers(result: SolveResult) -> dict[str, Any]:
    """Return what a page needs to solve a platform again for other values.

    Parameters
    ----------
    result
        The platform, solved.

    Returns
    -------
    dict
        ``values`` of the file; the ``ranges`` of sliders (readings, distances to planes without
        sign); the ``limits`` of what values can be (None: no limit); ``kinds``; ``units``. The
        index of the ``home`` mode or None; the ``sides`` of values (1, -1, 0 for both; None without
        sides); whether a solve is ``quick``. The ``proof`` of the count or None and its
        ``reservation`` in words; the ``drives`` (`drawn_drives`); the ``ways`` home (`live_home`);
        the ``numbers``, doubles in base64. Where motors move joints, these are of the m motors
        (`LiveMotors.moved`).

    Raises
    ------
    GspError
        If there is no start from which all poses for other values are found.
    """
    given = result.instance
    motors = LiveMotors.of(given)
    instance = given if motors is None else motors.family
    rows, ranges = _rows(instance)
    problem = Problem(instance, seed=SEED, starts=SolvedStarts())
    corrected = rows * factors(instance) + offsets(instance, signed=False)
    if motors is not None:
        # Members among the sets of values do not help: their joints are elsewhere.
        corrected = corrected[:_FEW]
    if not problem.local_frames.is_none:
        raise _cannot("its frames are far away from its bodies")
    proofs = ValueProofs.of(instance, corrected)
    start = _start(problem, corrected)
    if proofs is None or start is None:
        count = problem.count_geometry()
        if count is not None and not count.solutions:
            raise _cannot("its geometry has poses for special values alone")
        raise _cannot("no start was found that leads to all its poses")
    if motors is not None and start.far is not None:
        raise _cannot("some of its poses are far away wherever its joints are")
    numbers = _Numbers()
    _put_values(numbers, given, start)
    if motors is None:
        _put_pools(numbers, start)
    else:
        numbers.put(0)
    _put_whole(numbers, start, motors)
    _put_proofs(numbers, instance, proofs, start)
    _put_far(numbers, start)
    controller = platform_numbers(given if motors is None else apart(given))
    # The sliders of a page move values that no drive changes, too.
    free = np.full(len(given.constraints), NEVER)
    controller = replace(controller, lowest=-free, highest=free)
    numbers.put(controller.kind, controller.either, controller.doubles)
    arrangement = result.arrangement
    numbers.put(start.found, arrangement.platform_centre, arrangement.extent)
    _put_clearance(numbers, given)
    numbers.put(*([0] if motors is None else [1, *motors.numbers(proofs)]))
    found, proof = _said(problem, ranges), start.proof
    reservation = "" if proof is None else proof.reservation
    if motors is not None:
        found, proof = motors.moved(found, start)
        found["stated"] = _stated(result)
        if proof is not None and proof.error:
            reservation = f"{proof.reservation} (counted with its joints at random places)"
    return {
        **found,
        "home": None if result.home is None else result.home.number - 1,
        "quick": start.found <= _QUICK,
        "proof": proof and proof.to_json(),
        "reservation": reservation,
        "drives": drawn_drives(given),
        "ways": live_home(result),
        "numbers": numbers.text(),
    }


def live_module() -> str:
    """Return the kernel of the page, compressed, in base64."""
    return base64.b64encode(data_path("live", "kernel.wasm.gz").read_bytes()).decode()


def _said(problem: Problem, ranges: list[list[float]]) -> dict[str, Any]:
    """Return the facts about the six values that a page shows."""
    instance, stated = problem.instance, problem.arrangement
    units, rows = instance.units, instance.constraints
    return {
        "values": readings_of(instance, _values(instance), signed=False).tolist(),
        "ranges": ranges,
        "limits": _limits(instance),
        "kinds": [row.kind.name for row in rows],
        "units": [units.length if row.kind.is_distance else units.angle.value for row in rows],
        "sides": [
            side.item() if kind.has_sides else None
            for kind, side in zip(stated.kinds, stated.signs, strict=True)
        ],
    }


def _stated(result: SolveResult) -> dict[str, int] | None:
    """Return how many poses there are where the file has the joints, if that is proved."""
    counts = result.counts
    if result.proof is None or result.verdict != "complete" or counts.certified < counts.found:
        return None
    return {"poses": counts.found, "real": counts.real}


def _cannot(why: str) -> GspError:
    return GspError(f"a page cannot solve this platform: {why}")


def _values(instance: Instance) -> Array:
    return np.array([row.value.value for row in instance.constraints])


def _rows(instance: Instance) -> tuple[Array, list[list[float]]]:
    """Return sets of readings within the ranges, the file's among them, and the ranges."""
    values = _values(instance)
    ends = np.array([_range(instance, i, x) for i, x in enumerate(values.tolist())]).T
    low, high = readings_of(instance, ends, signed=False)
    rng = np.random.default_rng(SEED)
    rows = low + (high - low) * rng.random((_ROWS, len(values)))
    rows[0] = readings_of(instance, values, signed=False)
    return rows, np.stack((low, high), axis=1).tolist()


def _range(instance: Instance, i: int, value: float) -> list[float]:
    """Return between which values a slider goes; a value of zero stays."""
    row = instance.constraints[i]
    if value == 0:
        return [0.0, 0.0]
    if row.limits is not None:
        low, high = sorted(limit.value for limit in row.limits)
        if row.kind.has_sides and low < 0:
            low, high = _PART * abs(value), max(-low, high, abs(value))
        return [min(low, value), max(high, value)]
    if row.kind.is_distance:
        return [value * (1 - _PART), value * (1 + _PART)]
    least, most = value_range(row.kind, instance.units.angle)
    return [value + _PART * (least - value), value + _PART * (most - value)]


def _limits(instance: Instance) -> list[list[float | None]]:
    """Return the least and the greatest value that a pose can have, of each constraint."""
    ends = np.array([value_range(row.kind, instance.units.angle) for row in instance.constraints])
    readings = readings_of(instance, ends.T, signed=False).T
    return [[x if math.isfinite(x) else None for x in pair] for pair in readings.tolist()]


def _start(problem: Problem, rows: Array) -> Start | None:
    from gspcli.solver.all_poses import all_poses
    from gspcli.solver.api import common_start

    return common_start(problem.with_rows(rows), all_poses)


def _put_values(numbers: _Numbers, instance: Instance, start: Start) -> None:
    machine = Machine.of(instance)
    scale, shift = (x[machine.index] for x in (machine.factors, machine.offsets))
    # The page has distances to planes on the side that is asked for.
    shift = np.where(~machine.driven & (machine.stated_arrangement.sides < 0), -shift, shift)
    for i, row in enumerate(instance.constraints):
        kind, law = row.kind, row.kind.law
        height = kind.is_distance and kind.has_sides
        numbers.put(kind.is_distance, kind.is_squared, height, law.is_cosine, law.sign)
        numbers.put(scale[i], shift[i])
    numbers.put(len(start.choices), start.choices, start.length)
    degrees = instance.units.angle is AngleUnit.DEGREE
    sine = SineNumbers.of(degrees=degrees)
    numbers.put(degrees, sine.quarter, sine.unit, len(sine.terms), sine.small, sine.terms)
    numbers.put(COSINE_ERROR, ERROR)


def _put_pools(numbers: _Numbers, start: Start) -> None:
    homotopy = start.homotopy
    if homotopy is None:
        numbers.put(0)
        return
    stages: list[tuple[slice, TrackerOptions]] = [(start.near, QUICK), (slice(1), DEFAULT)]
    has_h = len(homotopy.pivots) + len(homotopy.free) == 7
    numbers.put(len(stages), len(homotopy.free), has_h, homotopy.pivots, homotopy.free)
    numbers.put(homotopy.forms, homotopy.slopes, homotopy.combinations)
    numbers.put(start.reduced.shape[1], start.length)
    for each, options in stages:
        parameters = start.parameters[each]
        numbers.put(len(parameters), parameters, start.unit, start.reduced[each])
        numbers.put(options.predictor_tolerance, options.contraction, options.radius_fraction)
        numbers.put(options.min_step, options.max_steps)


def _put_whole(numbers: _Numbers, start: Start, motors: LiveMotors | None) -> None:
    inner = start.inner
    signs = np.where(start.given.values == 0, 0.0, 1.0)
    given = inner.kinds, inner.y, inner.x, inner.u, inner.v
    # Coefficients are polynomials of second degree in the value.
    structure, found = coefficients_of(*given, np.outer((1.0, 2.0, 3.0), signs))
    order = list(structure.order)
    systems = [x[:, order] for x in found]
    systems[:2] = [x * start.scale**DEGREE_IN_F for x in systems[:2]]
    one, two, three = np.concatenate([x.reshape(3, -1) for x in systems], axis=1)
    square = (one - 2 * two + three) / 2
    slope = two - one - 3 * square
    parts = np.stack((one - slope - square, slope, square))
    if motors is not None:
        terms = [x[:, order] for x in motors.terms(start)]
        moved = [
            np.broadcast_to(
                motors.drives.driven[order].reshape(-1, *(1,) * (x.ndim - 2)), x.shape
            ).reshape(3, -1)
            for x in terms
        ]
        own = np.concatenate([x.reshape(3, -1) for x in terms], axis=1)
        parts = np.where(np.concatenate(moved, axis=1), own, parts)
    system = start.system
    numbers.put(system.structure.is_product, order, *system.coefficients)
    numbers.put(len(start.points), start.points, *parts)
    numbers.put(start.length * float(start.scale))
    for options in (QUICK, CAREFUL):
        numbers.put(options.predictor_tolerance, options.contraction, options.arrival)
        numbers.put(options.radius_fraction, options.min_step, options.waypoint, options.nearest)
        numbers.put(options.max_steps, options.late_steps)


def _put_proofs(numbers: _Numbers, instance: Instance, proofs: ValueProofs, start: Start) -> None:
    given = start.given
    numbers.put(len(proofs.numbers[0]), *proofs.numbers, given.base_centre, given.platform_centre)
    numbers.put(proofs.scale, TOLERANCE, reach(instance))
    lines = [
        np.outer(row.base.unit, row.platform.unit)
        for row in instance.constraints
        if row.kind is DLL and isinstance(row.platform, Line) and isinstance(row.base, Line)
    ]
    numbers.put(len(lines), *lines, roundings(8, 1.0))


def _put_far(numbers: _Numbers, start: Start) -> None:
    far = start.far
    if far is None:
        numbers.put(0)
        return
    numbers.put(
        len(far.real), far.products, far.numbers, far.errors, far.real, far.values, far.powers
    )
    numbers.put(far.scale, TOLERANCE, len(far.starts), far.origin, far.starts)


def _put_clearance(numbers: _Numbers, instance: Instance) -> None:
    moved = [one for row in instance.constraints for one in driven_points(row)]
    try:
        home = Displacements(instance, np.eye(3)[None], np.zeros((1, 3)))
    except ArgumentError:
        # Its points lie on a line.
        home = None
    # The ellipsoid of the platform's points moves where drives move these.
    if home is None or any(one.body == BODIES[0] for one in moved):
        numbers.put(0)
        return
    given = home.arrangement
    order = (DPP, DPL, DLP, DPH, DHP, DLL)
    kinds = [order.index(kind) if kind in order else len(order) for kind in given.kinds]
    numbers.put(1, kinds, given.y, given.x, given.u, given.v)
    numbers.put(home.centre, home.axes[0], home.radii)


# The page that solves a platform again while one moves its values or its pose.
#
# One file, like the page of `gspcli.pictures.page`, with the kernel in WebAssembly in it and the
# numbers from which it solves (`gspcli.pictures.live_numbers`).


def live_page(
    scene: Scene,
    live: Mapping[str, Any],
    start: int = 0,
    view: View | None = None,
    *,
    names: bool = True,
    frame: PoseFrame = IDENTITY,
) -> str:
    """Return the live page of a scene, a whole HTML document.

    The page solves from what `live_numbers` returns, and follows the assembly mode `start` first,
    from 0. Sliders of the pose express it in a frame.
    """
    said = parts(scene, start, view, {"start": start, "names": names})
    if live["reservation"]:
        said["footer"] += escape(f" That no pose is missing is proved, {live['reservation']}.")
    content = data({**live, "frame": _expressed(frame)})
    return filled("live.html", {**said, "live": content, "module": live_module()})


def _expressed(frame: PoseFrame) -> dict[str, Any]:
    """Return how sliders express poses: frames in both bodies, by rows, and the text about them."""
    what = frame.words or "poses of the platform in the base"
    return {
        **{
            body: {"R": one.matrix.ravel().tolist(), "T": one.origin.tolist()}
            for body, one in (("base", frame.of_base), ("platform", frame.of_platform))
        },
        "words": f"{what}; turns about its fixed axes x, y, z, one after the other (--euler xyz)",
    }
