"""Instances with short decimals from the numbers of a search, with proofs of their real poses."""

from __future__ import annotations

import math
from bisect import bisect_left
from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import takewhile

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.counts import Witness, witness, witness_with
from gspcli.catalogue.kinds import AHH, AHL, ALH, ALL, DHP, DLL, DPH, Kind, Primitive
from gspcli.catalogue.types import GspType
from gspcli.certification import certify
from gspcli.continuation.tracked_paths import track_all
from gspcli.defaults import SEED
from gspcli.errors import GspError
from gspcli.geometry.arrangement import Arrangement, angle_of
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side, Units
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, Line, Plane, Point, Vector
from gspcli.geometry.quaternions import made_real, pose_from_study
from gspcli.reality.platforms import Platforms, look_real, multiplier
from gspcli.solver.all_poses import careful_paths
from gspcli.solver.problem import Problem
from gspcli.solver.search import Search
from gspcli.solver.study_systems import target_systems

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

#: Decimals that are tried, in units of the size of the platform. If the first number suffices and
#: there are not too many poses, fewer are tried, down to the least.
_DIGITS, _LEAST_DIGITS, _MANY = range(4, 12, 2), 2, 256
#: Distances of planes and of lines that are tried, in the same units; the first is the best. Double
#: precision separates two poses that differ by the last one.
_GAPS = tuple(Fraction(m, 10**k) for k in range(1, 6) for m in (5, 2, 1))
#: The most random attempts at the paths in a search for enough real poses.
_ATTEMPTS = 3
DEFAULT_UNITS = Units("unit", AngleUnit.DEGREE)


def platform_of(instance: Instance) -> tuple[Platforms, float]:
    """Return the numbers of an instance, with lengths of order one, and its typical length."""
    arrangement = Arrangement.of(instance)
    given = arrangement.normalized
    distance = np.array([kind.is_distance for kind in given.kinds])
    values = np.where(given.signs < 0, -given.values, given.values)
    values[given.angles] = given.cosines(given.values)
    y, x = given.y * distance[:, None], given.x * distance[:, None]
    return Platforms(given.kinds, y, x, given.u, given.v, values), arrangement.length


def real_instance(
    platform: Platforms, count: int, *, units: Units = DEFAULT_UNITS, length: float = 1.0
) -> Instance:
    """Return an instance with short decimals near a reduced platform, with as many real poses.

    Parameters
    ----------
    platform
        One reduced platform (`gspcli.reality.platforms`), lengths of order one.
    count
        The number of real poses that the instance must have, on all sides.
    units, length
        Units and typical length of the instance.

    Raises
    ------
    GspError
        If no rounding keeps the number.
    """
    exponent = math.floor(math.log10(length))
    has_gap = multiplier(platform.kinds) > 1
    without = count // multiplier(platform.kinds)
    values = platform.values * np.where([kind.is_distance for kind in platform.kinds], length, 1.0)
    scaled = replace(platform, y=platform.y * length, x=platform.x * length, values=values)

    @cache
    def instance_with(digits: int) -> Instance | None:
        # The rounded platform of the search: one side, at distance zero.
        draft = rounded(scaled, digits, exponent, units)
        if _real_count(draft) != without:
            return None
        return _with_largest_gap(draft, digits, exponent, count) if has_gap else draft

    first = next((digits for digits in _DIGITS if instance_with(digits)), None)
    if first is None:
        raise GspError(f"no rounding of the platform keeps its {count} real poses")
    fewer = takewhile(instance_with, range(first - 1, _LEAST_DIGITS - 1, -1))
    is_quick = first == _DIGITS[0] and count < _MANY
    found = instance_with(min(fewer, default=first) if is_quick else first)
    assert found is not None
    return found


def _with_largest_gap(draft: Instance, digits: int, exponent: int, count: int) -> Instance | None:
    """Return the instance with the largest distances of planes and lines that keep the poses.

    It may have more poses. The result is None if the smallest distance does not keep them; the
    number is assumed to fall with the distance.
    """
    apart = [k for k, row in enumerate(draft.constraints) if row.kind in (DPH, DHP, DLL)]
    instances = [
        draft.with_values(dict.fromkeys(apart, Number.of(gap * Fraction(10) ** exponent)))
        for gap in reversed(_GAPS)
        if (gap * 10**digits).denominator == 1
    ]
    kept = bisect_left(instances, True, key=lambda instance: _real_count(instance) < count)
    return instances[kept - 1] if kept else None


def certified_real(instance: Instance, enough: int | None = None) -> int:
    """Return the number of different real poses of an instance that are proved to exist.

    Parameters
    ----------
    instance
        The platform.
    enough
        Poses that first attempts at the paths do not find are searched for only if fewer than this
        are found; None: always.
    """
    problem = Problem(instance, seed=SEED)
    search = Search(problem)
    careful_paths(search)
    if (found := search.complete) is not None:
        return int(found.real.sum())
    if enough is not None and (real := quickly_certified_real(instance, enough)) >= enough:
        return real
    points = np.concatenate([paths.solutions().points for paths in problem.tracked])
    return _certified(instance, made_real(points[look_real(points)]))


def quickly_certified_real(instance: Instance, enough: int) -> int:
    """Return the number of proved real poses among those that first attempts find.

    Some attempts with other random paths are made until there are enough.
    """
    points, real, arrangement = np.zeros((0, 8)), 0, Arrangement.of(instance)
    for seed in range(SEED, SEED + _ATTEMPTS):
        points = np.concatenate((points, made_real(_look_real(arrangement, seed))))
        if len(points) >= enough or seed == SEED + _ATTEMPTS - 1:
            real = _certified(instance, points)
        if real >= enough:
            break
    return real


def _certified(instance: Instance, points: Array) -> int:
    """Return how many different real poses are proved near real Study points, shape (n, 8)."""
    R, T = pose_from_study(points[:, :4], points[:, 4:])
    return certify(instance, R, Arrangement.of(instance).restored(R, T)).real


def _real_count(instance: Instance) -> int:
    """Return the number of probably real poses after the first attempt at the paths."""
    return len(_look_real(Arrangement.of(instance), SEED))


def _look_real(arrangement: Arrangement, seed: int) -> Complex:
    """Return the ends of first attempts at the paths that look real, Study points (k, 8)."""
    tracked = track_all(target_systems(arrangement.normalized), seed=seed)
    ends = [paths.first() for paths in tracked]
    points = np.concatenate([end.points[end.has_converged] for end in ends])
    return np.asarray(points[look_real(points)])


def rounded(
    platform: Platforms,
    digits: int,
    exponent: int = 0,
    units: Units = DEFAULT_UNITS,
    *,
    one_sided: bool = False,
) -> Instance:
    """Return the instance of a platform, rounded to decimals; lengths in units of 10^exponent.

    Directions of primitives that are far away, or that meet far points, have more decimals. Both
    sides of DPH and DHP are asked for, or only the side of the values.
    """
    constraints = []
    for i, kind in enumerate(platform.kinds):
        value, places = float(platform.values[i]), digits - exponent
        largest = max(np.abs(platform.y[i]).max(), np.abs(platform.x[i]).max(), 10.0**exponent)
        finely = digits + math.floor(math.log10(largest)) - exponent
        decimals = places if kind.is_distance else digits
        side = Side.BOTH
        if kind.has_sides and one_sided:
            side = Side.NEGATIVE if value < 0 else Side.POSITIVE
        if not kind.is_distance:
            value = angle_of(kind, value) / units.angle.in_radians
        constraints.append(
            Constraint(
                kind,
                _geometry(kind.platform, platform.y[i], platform.u[i], places, finely),
                _geometry(kind.base, platform.x[i], platform.v[i], places, finely),
                _decimal(abs(value) if kind.has_sides else value, decimals),
                side,
            )
        )
    return Instance(tuple(constraints), units)


def _geometry(
    primitive: Primitive, point: Array, direction: Array, places: int, finely: int
) -> Geometry:
    position = _vector(point, places)
    if primitive is Primitive.POINT:
        return Point(position)
    along = _vector(direction, finely)
    return Line(position, along) if primitive is Primitive.LINE else Plane(position, along)


def _vector(values: Array, places: int) -> Vector:
    x, y, z = (_decimal(float(value), places) for value in values)
    return (x, y, z)


def _decimal(value: float, places: int) -> Number:
    return Number.of(round(Fraction(value), places))


def known_instance(gsp_type: GspType, real: int | None = None) -> Instance:
    """Return a recorded platform of a type with a number of real poses; None: the largest one.

    Raises
    ------
    GspError
        If there is no record.
    """
    family = gsp_type.family
    found = witness(family) if real is None else witness_with(family, real)
    if found is None:
        raise GspError(f"{gsp_type.id}: no witness is recorded: search for one")
    name = f"{gsp_type.family.id} with {found.real} real poses"
    return replace(witness_instance(found, gsp_type.angles), name=name)


def witness_instance(found: Witness, angles: tuple[Kind, ...]) -> Instance:
    """Return the instance of a recorded witness with some kinds of angles, in degrees.

    The cosine of the angle of two lines is the sine of that of a line and a plane whose normal
    is one of them, and minus the cosine of that of two planes (Section 4).
    """
    kinds = (*found.family.distances, *angles)
    constraints = []
    for kind, row in zip(kinds, found.rows, strict=True):
        numbers = [Fraction(text) for text in row]
        platform, rest = _read(kind.platform, kind, numbers[:-1])
        base, rest = _read(kind.base, kind, rest)
        value = numbers[-1]
        if kind is AHH:
            value = 180 - value
        elif kind in (ALH, AHL):
            value = 90 - value
        elif not kind.is_distance and kind is not ALL:
            raise ValueError(kind)
        constraints.append(Constraint(kind, platform, base, Number.of(value)))
    return Instance(tuple(constraints), DEFAULT_UNITS)


def _read(
    primitive: Primitive, kind: Kind, numbers: list[Fraction]
) -> tuple[Geometry, list[Fraction]]:
    """Return the primitive that begins a list of numbers, and the rest of the list."""
    if not kind.is_distance:
        numbers = [Fraction(0)] * 3 + numbers
    if primitive is Primitive.POINT:
        a, b, c = map(Number.of, numbers[:3])
        return Point((a, b, c)), numbers[3:]
    a, b, c, p, q, r = map(Number.of, numbers[:6])
    shape = Line if primitive is Primitive.LINE else Plane
    return shape((a, b, c), (p, q, r)), numbers[6:]
