"""The real modes at sets of values: given ones, random ones in ranges or about home."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.coordinates import choose, moved
from gspcli.geometry.drive_numbers import is_driven, shares_drives
from gspcli.geometry.drives import Drives
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.limits import out_of_motor_range
from gspcli.geometry.numbers import Number
from gspcli.geometry.quaternions import apply, rotation_from_vector
from gspcli.geometry.readings import readings_of, values_of
from gspcli.geometry.value_rows import problems_of, value_rows
from gspcli.motion.poses.cranks import drive_values
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.records import dataclass
from gspcli.sensing.candidates import body_normal
from gspcli.solver import SolveResult, solve, solve_batch
from gspcli.wording import listed, shown, suggestion

Array = NDArray[np.float64]

#: The largest shift of random poses from home, as a part of the size, and the largest turn.
SPREAD, TURN = 0.1, 15.0
#: Sets of values that are solved and compared together.
_CHUNK = 128
#: The most poses that are drawn for each pose that cranks and slides can reach.
_DRAWS = 100


@dataclass(frozen=True, eq=False)
class ModeSets:
    """The real modes at each of b sets of values; rows with fewer than m modes are padded.

    Attributes
    ----------
    instance
        The geometry, drives moved.
    R, T
        Shapes (b, m, 3, 3) and (b, m, 3).
    numbers
        The number of each mode among the real ones, from 1; 0 for padding; shape (b, m).
    complete
        For which sets of values all poses are known, shape (b,).
    """

    instance: Instance
    R: Array
    T: Array
    numbers: NDArray[np.int64]
    complete: NDArray[np.bool_]

    @classmethod
    def of(
        cls,
        instance: Instance,
        R: NDArray[np.complex128],
        T: NDArray[np.complex128],
        real: NDArray[np.bool_],
        complete: NDArray[np.bool_],
    ) -> ModeSets:
        """Return the real poses of sets; shapes (b, n, 3, 3), (b, n, 3), (b, n) and (b,)."""
        numbers = np.where(real, real.cumsum(axis=1), 0)
        order = np.argsort(~real, axis=1, kind="stable")[:, : max(real.sum(axis=1), default=0)]
        rows = np.arange(len(real))[:, None]
        numbers = numbers[rows, order]
        there = (numbers > 0)[..., None]
        rotations = np.where(there[..., None], R[rows, order].real, np.eye(3))
        translations = np.where(there, T[rows, order].real, 0.0)
        return cls(instance, rotations, translations, numbers, complete)

    @property
    def count(self) -> NDArray[np.int64]:
        """The number of modes of each set, shape (b,)."""
        return np.asarray((self.numbers > 0).sum(axis=1))

    def on_side(self, side: float) -> ModeSets:
        """Return the modes whose platform is on a side of the base, by the sign of `heights`."""
        same = np.sign(heights(self.instance, self.R, self.T)) == side
        return replace(self, numbers=np.where(same, self.numbers, 0))


def heights(instance: Instance, R: Array, T: Array) -> Array:
    """Return the height of the middle of the platform above the plane nearest to the base's points.

    Raises
    ------
    ArgumentError
        If the points of the base do not span a plane.
    """
    normal = body_normal(instance, "base")
    if normal is None:
        message = "the base has no sides: its points do not span a plane"
        raise ArgumentError(message, "known_side")
    arrangement = Arrangement.of(instance)
    middle = apply(R, arrangement.platform_centre) + T
    return np.asarray((middle - arrangement.base_centre) @ normal)


def home_of(result: SolveResult) -> tuple[Array, Array]:
    """Return the home pose.

    Raises
    ------
    ArgumentError
        If no pose is real.
    """
    if result.home is None:
        message = (
            "the platform has no real pose for its values, about which others could be drawn: "
            "give the values between which to draw"
        )
        raise ArgumentError(message, "instance")
    return result.home.R, result.home.T


@dataclass(frozen=True, eq=False)
class ValueSets:
    """The n sets of values at which modes are distinguished.

    Attributes
    ----------
    drawn
        Their origin: ``given``, ``rows``, ``within``, ``ranges``, ``poses``, ``cranks``, ``drives``
        or ``motors`` (about home in the numbers of the drives).
    values
        The readings of the machine, distances to planes without a sign, shape (n, 6).
    platforms
        The instance at each set if primitives move, else empty.
    known
        The modes, if they are known already.
    """

    drawn: str
    values: Array
    platforms: tuple[Instance, ...] = ()
    known: tuple[ModeSets, ...] = ()

    def modes(self, instance: Instance, seed: int, jobs: int) -> Iterator[ModeSets]:
        """Yield the modes at all sets, in blocks of sets."""
        yield from self.known
        for one in self.platforms:
            yield _modes_of(solve(one, seed=seed, jobs=jobs))
        if not (self.known or self.platforms):
            for begin in range(0, len(self.values), _CHUNK):
                rows = self.values[begin : begin + _CHUNK]
                batch = solve_batch(instance, rows, seed=seed, jobs=jobs)
                yield ModeSets.of(instance, batch.R, batch.T, batch.real, batch.complete)


def _modes_of(result: SolveResult) -> ModeSets:
    """Return the modes of a solved instance as the only set.

    If the poses are infinitely many, these are the real isolated ones, if no other pose is real.
    """
    shown = result.drawn
    complete = np.array([result.verdict == "complete" or shown is not result])
    return ModeSets.of(shown.instance, shown.R[None], shown.T[None], shown.real[None], complete)


def given(result: SolveResult) -> ValueSets:
    """Return the values of a solved instance as the only set."""
    return ValueSets("given", _stated(result.instance)[None], known=(_modes_of(result),))


def _stated(instance: Instance) -> Array:
    """Return the readings of the machine at the values of its file, shape (6,)."""
    return np.array([row.reading_of(row.value).value for row in instance.constraints])


def rows_of(
    instance: Instance, values: ArrayLike, coordinates: Mapping[str, ArrayLike]
) -> ValueSets:
    """Return sets of values that a caller gives, with primitives that move.

    Parameters
    ----------
    instance
        The platform.
    values
        Shape (n, 6), distances to planes signed, as `gspcli.measure` has them.
    coordinates
        Numbers of primitives at each set, by name (`gspcli.geometry.coordinates`), shape (n,) each.

    Raises
    ------
    ArgumentError
        If shapes are wrong, or a point is on the side of a plane that the instance excludes.
    """
    rows = value_rows(values)
    if not len(rows):
        message = "found no set of values, expected at least one"
        raise ArgumentError(message, "values")
    arrangement = Arrangement.of(instance)
    meant = values_of(instance, rows)
    wrong = arrangement.sided & (np.sign(meant) == -arrangement.sides) & (arrangement.sides != 0)
    for k, i in np.argwhere(wrong).tolist():
        message = f"found {rows[k, i]:g}, expected the {instance.constraints[i].side.value} side"
        raise ArgumentError(message, f"values[{k}][{i}]")
    meant = meant.copy()
    meant[:, arrangement.sided] = np.abs(meant[:, arrangement.sided])
    for problem in problems_of(instance, meant).values():
        raise ArgumentError(problem)
    chosen = choose(instance, list(coordinates))
    rows = readings_of(instance, meant, signed=False)
    if not chosen:
        return ValueSets("rows", rows)
    numbers = np.stack([np.asarray(column, float) for column in coordinates.values()], axis=-1)
    if numbers.shape != (len(rows), len(chosen)):
        message = f"found shape {numbers.shape[:1]}, expected {len(rows)} numbers for each name"
        raise ArgumentError(message, "coordinates")
    given_rows = [dict(enumerate(map(Number.of, row))) for row in meant.tolist()]
    platforms = [
        moved(instance.with_values(row), chosen, place)
        for row, place in zip(given_rows, numbers, strict=True)
    ]
    return ValueSets("rows", rows, tuple(platforms))


def values_within(
    instance: Instance, within: Mapping[int, tuple[float, float]], count: int, seed: int
) -> Array:
    """Return random values, uniform in intervals by index, the others constant, (count, 6)."""
    values = np.tile(_stated(instance), (count, 1))
    parts = np.random.default_rng(seed).uniform(size=values.shape)
    for k, (low, high) in within.items():
        values[:, k] = low + (high - low) * parts[:, k]
    return values


def ranges_of(instance: Instance) -> dict[int, tuple[float, float]] | None:
    """Return the ranges of the constraints by index; None if one is missing or all are constant."""
    rows = instance.constraints
    spans = {
        k: (row.reading_of(row.limits[0]).value, row.reading_of(row.limits[1]).value)
        for k, row in enumerate(rows)
        if row.limits
    }
    varies = any(low < high for low, high in spans.values())
    return spans if len(spans) == len(rows) and varies else None


def about_home(instance: Instance, home: tuple[Array, Array], count: int, seed: int) -> ValueSets:
    """Return the readings of the machine at random poses about home, or the platforms there.

    The middle of the platform is moved by up to `SPREAD` of its size along each axis, and the
    platform turned about it by up to `TURN` degrees. Where cranks and slides move its joints,
    platforms with moved joints are returned. Where they move several legs each, which reach almost
    no pose together, slides move by up to `SPREAD` of the size and cranks turn by up to `TURN`.

    Raises
    ------
    ArgumentError
        If the cranks and slides reach too few of the poses.
    """
    rng = np.random.default_rng(seed)
    if is_driven(instance):
        drives = Drives.of(instance)
        if shares_drives(instance):
            return _at("motors", drives, _near(drives, home, count, rng))
        drawn = "drives" if "slide" in drives.sorts else "cranks"
        return _at(drawn, drives, _reached(instance, home, count, rng))
    if all(row.limits and row.limits[0] == row.limits[1] for row in instance.constraints):
        message = "no value varies: each range is one value; give those between which to draw"
        raise ArgumentError(message, "instance")
    values = values_at(instance, *_poses(instance, home, count, rng))
    distances = Arrangement.of(instance).distances
    values[:, distances] = np.abs(values[:, distances])
    return ValueSets("poses", readings_of(instance, values, signed=False))


def motors_within(
    instance: Instance, spans: Mapping[str, tuple[float, float]], count: int, seed: int
) -> ValueSets:
    """Return platforms with readings of motors drawn in intervals, by the names of the drives.

    The others stay: cranks and slides where their points are stated, values as stated.

    Raises
    ------
    ArgumentError
        If a name is that of no drive.
    """
    drives = Drives.of(instance)
    readings = np.tile(drives.readings(_as_stated(drives)), (count, 1))
    parts = np.random.default_rng(seed).uniform(size=readings.shape)
    for name, (low, high) in spans.items():
        if name not in drives.names:
            known = listed(drives.names)
            message = f"found {shown(name)}, expected {known}{suggestion(name, drives.names)}"
            raise ArgumentError(message, f"within[{name!r}]")
        k = drives.names.index(name)
        readings[:, k] = low + (high - low) * parts[:, k]
    return _at("within", drives, drives.from_readings(readings))


def _as_stated(drives: Drives) -> Array:
    """Return the numbers of the drives as the file states them, shape (m,)."""
    rows = drives.instance.constraints
    found = np.zeros(drives.count)
    for k, (name, moves) in enumerate(_motors(drives)):
        if not moves:
            row = rows[int(name) - 1]
            found[k] = row.value.value * (-1 if row.side is Side.NEGATIVE else 1)
    return found * drives.units


def _motors(drives: Drives) -> list[tuple[str, bool]]:
    return list(zip(drives.names, drives.moved.tolist(), strict=True))


def _at(drawn: str, drives: Drives, q: Array) -> ValueSets:
    """Return the sets of values of platforms whose drives are at q, shape (n, m)."""
    values = np.tile(_stated(drives.instance), (len(q), 1))
    readings = drives.readings(q)
    for k, (name, moves) in enumerate(_motors(drives)):
        if not moves:
            sided = drives.instance.constraints[int(name) - 1].kind.has_sides
            values[:, int(name) - 1] = np.abs(readings[:, k]) if sided else readings[:, k]
    return ValueSets(drawn, values, tuple(drives.instance_at(row) for row in q))


def _near(drives: Drives, home: tuple[Array, Array], count: int, rng: np.random.Generator) -> Array:
    """Return random numbers of drives about home, within their ranges, shape (count, m)."""
    size = SPREAD * Arrangement.of(drives.instance).extent
    far = np.array([np.radians(TURN) if sort == "crank" else size for sort in drives.sorts])
    middle = drives.nearest(*home)
    middle = np.where(np.isfinite(middle), middle, _as_stated(drives))
    q = middle + far * rng.uniform(-1, 1, (count, drives.count))
    return np.clip(q, drives.low, drives.high)


def _reached(
    instance: Instance, home: tuple[Array, Array], count: int, rng: np.random.Generator
) -> Array:
    """Return the numbers of drives at random poses about home that they reach, (count, m)."""
    found: list[Array] = []
    number = 0
    for _ in range(_DRAWS):
        poses = _poses(instance, home, count, rng)
        drives, q = drive_values(instance, *poses, along=False)
        kept = np.isfinite(q).all(axis=1) & ~out_of_motor_range(drives, q).any(axis=1)
        found.append(q[kept])
        number += int(kept.sum())
        if number >= count:
            return np.concatenate(found)[:count]
    sorts = {"crank": "cranks", "slide": "slides"}
    what = " and ".join(word for sort, word in sorts.items() if sort in drives.sorts)
    message = f"the {what} reach {number} of {_DRAWS * count} poses about home"
    raise ArgumentError(message, "instance")


def _poses(
    instance: Instance, home: tuple[Array, Array], count: int, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Return random poses about home, shapes (count, 3, 3) and (count, 3)."""
    arrangement = Arrangement.of(instance)
    axes = rng.normal(size=(count, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    turns = np.radians(TURN) * rng.uniform(size=(count, 1))
    R = rotation_from_vector(axes * turns) @ home[0]
    centre = arrangement.platform_centre
    shift = SPREAD * arrangement.extent * rng.uniform(-1, 1, (count, 3))
    return R, home[0] @ centre + home[1] + shift - R @ centre
