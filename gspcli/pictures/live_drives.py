"""The numbers by which a live page moves the joints of a machine whose motors do so.

A crank turns a point on a circle and a slide shifts it on a line. With ``c = cos q, s = sin q`` of
a crank, or ``c = q, s = q^2`` of a slide, the equation of its rod is ``F_0 + c F_1 + s F_2`` with
quadrics F_k that do not depend on q. Let the places of the joint be all points of the plane of its
circle, or of its line, and let the length of the rod be anything. Then the machine is a member of a
linear family. A member in general position has as many solutions as any member can have that are
isolated. This many proved poses at any q are all of them, and straight lines of coefficients from a
member with complex numbers lead to all poses. The same holds for the family in which some motors
stand where the file has them: it may have fewer solutions.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DPP
from gspcli.certification.numbers.doubled import Doubled
from gspcli.continuation.systems import Coefficients
from gspcli.defaults import COUNT_LIMIT, SEED
from gspcli.geometry.coordinates import BODIES
from gspcli.geometry.drive_numbers import driven_points, is_driven
from gspcli.geometry.drives import Drives
from gspcli.geometry.instance import Instance
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Crank, Point
from gspcli.records import dataclass
from gspcli.solver.results.proof import CountKind, Proof
from gspcli.solver.starts.solved_starts import SolvedStarts
from gspcli.solver.starts.start import Start
from gspcli.solver.study_systems import coefficients_of

if TYPE_CHECKING:
    from gspcli.certification.counting import ExactCount
    from gspcli.certification.poses.many_values import ValueProofs
    from gspcli.geometry.drive_numbers import Driven
    from gspcli.geometry.primitives import Vector

Array = NDArray[np.float64]

#: Random places of joints are multiples of this part, this many of them to either side.
_PLACES = 2**40
#: How far a joint is from where it is stated at random places: radians, or parts of the rod.
_SPREAD = 0.5
#: Where a motor has no range: this turn, in radians, or this part of its rod to either side.
_TURN, _PART = np.pi / 4, 0.3
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
                first, second = (rng.integers(-_PLACES, _PLACES, 2) * _SPREAD * size).tolist()
                drawn[one.body, name] = _fraction(first), _fraction(second)
            place = one.point.position
            if f"{one.drive.sort}.{name}" not in held:
                place = _place(one, *drawn[one.body, name])
            still[one.body] = Point(place, one.point.cone)
        rows.append(replace(row, limits=None, **still) if still else row)
    return replace(instance, constraints=tuple(rows), dynamics=None, home=None)


def _fraction(x: float) -> Number:
    return Number.of(Fraction(round(x), _PLACES))


def _place(one: Driven, along: Number, beside: Number) -> Vector:
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
    first = Number("/", (beside, Number.of(length)))
    second = Number("/", (along, Number.of(length**2)))
    return _sum(_sum(point, _scaled(first, velocity)), _scaled(second, back))


def _sum(a: Vector, b: Vector) -> Vector:
    x, y, z = (Number("+", pair) for pair in zip(a, b, strict=True))
    return x, y, z


def _scaled(factor: Number, a: Vector) -> Vector:
    x, y, z = (Number("*", (factor, one)) for one in a)
    return x, y, z


def _cross(a: Vector, b: Vector) -> Vector:
    def entry(j: int, k: int) -> Number:
        return Number("-", (Number("*", (a[j], b[k])), Number("*", (a[k], b[j]))))

    return entry(1, 2), entry(2, 0), entry(0, 1)


def counted(instance: Instance, start: Start) -> list[ExactCount | None]:
    """Return how many isolated poses a machine can have, by which motors have moved.

    Parameters
    ----------
    instance
        The machine.
    start
        Of its family.

    Returns
    -------
    list
        Entry ``sum(2**k for k in moved)`` is the count where the motors k, of those that move
        joints, have moved, and the others are where the file has them. None: as many as the family
        has.
    """
    names = [name for name in Drives.of(instance).names if "." in name]
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


def terms(drives: Drives, start: Start) -> Coefficients:
    """Return the three quadrics of each rod, shape (3, 6, ...), multiplied as those of the start.

    Rows of values have no meaning.
    """
    given, inner = start.given, start.inner
    unit = start.length
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
    own = coefficients_of(inner.kinds, inner.y, inner.x, inner.u, inner.v, complex_values[None])[1]
    sizes = own.in_units(start.scale).sizes()[0][0]
    parts = [_parts(x, cranked, unit) for x in found]
    parts[0] = parts[0] / sizes[:, None]
    return Coefficients(*parts)


@dataclass(frozen=True, eq=False)
class LiveMotors:
    """The motors of a machine that a live page moves.

    Attributes
    ----------
    given
        The machine.
    drives
        Its drives.
    family
        A member of its family in general position (`anywhere`).
    """

    given: Instance
    drives: Drives
    family: Instance

    @classmethod
    def of(cls, given: Instance) -> LiveMotors | None:
        """Return the motors of a machine; None if they move no joints."""
        if not is_driven(given):
            return None
        return cls(given, Drives.of(given), anywhere(given))

    def corrections(self, scale: Array, shift: Array) -> tuple[Array, Array]:
        """Return by which factors and offsets readings become numbers, shape (6,)."""
        drives, k = self.drives, self.drives.index
        return (
            np.where(drives.driven, drives.factors[k], scale),
            np.where(drives.driven, drives.offsets[k], shift),
        )

    def terms(self, start: Start) -> Coefficients:
        """As the function."""
        return terms(self.drives, start)

    def numbers(self, proofs: ValueProofs) -> list[Any]:
        """As `joint_numbers`."""
        return joint_numbers(self.given, self.drives, proofs)

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
        far = _PART * drives.rods[user]
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


def joint_numbers(instance: Instance, drives: Drives, proofs: ValueProofs) -> list[Any]:
    """Return the numbers of viewer/module/joints.cpp after the first."""
    scale = proofs.scale
    relations, primitives, forms, tiny = proofs.opened
    found: list[Any] = [scale]
    for k, row in enumerate(instance.constraints):
        sort = drives.sorts[drives.index[k]] if drives.driven[k] else "value"
        places = np.zeros((3, 3, 3))
        for one in driven_points(row):
            places = _circle(one, scale)
        rod = row.value.value
        found += [_SORTS[sort], drives.on_platform[k], rod, places]
    for k, relation in enumerate(relations):
        found += [relation, np.moveaxis(primitives[:, k], 0, -1)]
    return [*found, forms, tiny]


def _circle(one: Driven, scale: float) -> Array:
    """Return middle, across and beside of a drive as `Doubled`: vectors, entries, parts."""
    from gspcli.certification.numbers.balls import ball

    def vectors() -> list[list[Any]]:
        point = [ball(x) for x in one.point.position]
        drive = one.drive
        axis = [ball(x) for x in (drive.axis if isinstance(drive, Crank) else drive.direction)]
        square = axis[0] ** 2 + axis[1] ** 2 + axis[2] ** 2
        if not isinstance(drive, Crank):
            return [point, [0 * x for x in point], [scale * x / square.sqrt() for x in axis]]
        arm = [x - ball(c) for x, c in zip(point, drive.centre, strict=True)]
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
