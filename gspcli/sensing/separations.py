"""Which additional sensor distinguishes the real modes of a platform: the pair that is worst.

Two modes whose readings differ by d standard deviations of the sensor are confused with the
probability Phi(-d / 2) if the nearer one is taken.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gspcli import __version__
from gspcli.defaults import SEED
from gspcli.errors import ArgumentError, IncompleteError, NotFiniteError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.checking import checked
from gspcli.geometry.instance import Instance
from gspcli.geometry.machine import Machine
from gspcli.geometry.quaternions import apply, vector_from_rotation
from gspcli.geometry.readings import problems_of, readings_of, value_rows, values_of
from gspcli.records import Tabular, dataclass
from gspcli.sensing.sensor_kinds import (
    KINDS,
    Sensor,
    body_normal,
    candidates,
    check_sigmas,
    each_parsed,
    parse_sensor,
)
from gspcli.solver import SolveResult, solve, solve_batch
from gspcli.solver.api import whole

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]

SCHEMA = "gsp.sensors/1"
#: Readings with this difference in standard deviations are distinct: each is accurate to three.
NEED = 6.0
#: Default standard deviations: of lengths as a part of the platform's size, of angles in degrees;
#: with so many digits.
_SIGMA_PART, _SIGMA_DEGREES, _DIGITS = 1e-3, 0.1, 2
#: Sets of values that are solved and compared together.
_CHUNK = 128
#: Decimals of standard deviations up to which equal ones are compared: symmetry makes many equal.
_DECIMALS = 6


@dataclass(frozen=True, eq=False)
class ModeSets:
    """The real modes of a platform at b sets of values: R (b, m, 3, 3) and T (b, m, 3).

    `numbers` are those of the modes among the real ones, from 1; rows with fewer than m are padded
    with 0, (b, m). `complete` says for which sets all poses are known, (b,).
    """

    instance: Instance
    R: Array
    T: Array
    numbers: Index
    complete: Flags

    @classmethod
    def of(
        cls,
        instance: Instance,
        R: NDArray[np.complex128],
        T: NDArray[np.complex128],
        real: Flags,
        complete: Flags,
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

    @classmethod
    def of_result(cls, result: SolveResult) -> ModeSets:
        """Return the modes of a solved instance as the only set: of infinitely many lone ones."""
        shown = result.drawn
        complete = np.array([result.verdict == "complete" or shown is not result])
        return cls.of(shown.instance, shown.R[None], shown.T[None], shown.real[None], complete)

    def on_side(self, side: float) -> ModeSets:
        """Return the modes whose platform is on a side of the base, by the sign of `_heights`."""
        same = np.sign(_heights(self.instance, self.R, self.T)) == side
        return replace(self, numbers=np.where(same, self.numbers, 0))

    @property
    def pairs(self) -> tuple[Index, Index]:
        """The places of the first and the second mode of all pairs in a set, each (p,)."""
        return np.triu_indices(self.numbers.shape[1], 1)

    def differences(self, sensors: Sequence[Sensor], sigmas: Array) -> Array:
        """Return by what the readings of s sensors differ at pairs of modes, shape (s, b, p).

        In standard deviations; infinite where a set has no such pair.
        """
        first, second = self.pairs
        there = (self.numbers[:, first] > 0) & (self.numbers[:, second] > 0)
        found = np.empty((len(sensors), *there.shape))
        for k, (sensor, sigma) in enumerate(zip(sensors, sigmas, strict=True)):
            read = sensor.read(self.instance, self.R, self.T)
            apart = sensor.apart(self.instance, read[:, first], read[:, second])
            found[k] = np.where(there, apart / sigma, np.inf)
        return found


def _heights(instance: Instance, R: Array, T: Array) -> Array:
    """Return how high the middle of the platform is above the plane of the base's points."""
    normal = body_normal(instance, "base")
    if normal is None:
        raise ArgumentError("the base has no sides: its points do not span a plane", "known_side")
    arrangement = Arrangement.of(instance)
    middle = apply(R, arrangement.platform_centre) + T
    return np.asarray((middle - arrangement.base_centre) @ normal)


@dataclass(frozen=True, eq=False)
class Separations:
    """How s sensors distinguish the modes at n sets of values."""

    #: The smallest difference of the readings at a pair of modes, in standard deviations, shape (s,
    #: n); infinite if there is at most one mode.
    least: Array
    #: The numbers of these modes, 0 where there are none, shape (s, n, 2).
    worst: Index
    #: The number of modes, shape (n,).
    modes: Index
    #: Whether all poses are known, shape (n,).
    complete: Flags
    #: The largest difference by any sensor of the pair for which this number is smallest, shape
    #: (n,).
    closest: Array
    #: The numbers of that pair, shape (n, 2).
    closest_modes: Index
    #: How far that pair is apart: the largest displacement of a point of the platform, in the unit
    #: of length, and the angle of the turn, in radians; shape (n,).
    distance: Array
    turn: Array


def separations(
    blocks: Iterable[ModeSets], sensors: Sequence[Sensor], sigmas: Array
) -> Separations:
    """Return how sensors distinguish modes at sets of values, in their order."""
    least, worst, *others = zip(*(_of_block(sets, sensors, sigmas) for sets in blocks), strict=True)
    parts = [np.concatenate(part) for part in others]
    return Separations(np.concatenate(least, axis=1), np.concatenate(worst, axis=1), *parts)


def _of_block(
    sets: ModeSets, sensors: Sequence[Sensor], sigmas: Array
) -> tuple[NDArray[np.generic], ...]:
    """Return the fields of `Separations` for some sets."""
    apart, pairs = sets.differences(sensors, sigmas), sets.numbers[:, np.stack(sets.pairs, axis=-1)]
    n, count = len(sets.numbers), (sets.numbers > 0).sum(axis=1)
    if not pairs.shape[1]:
        far, none = np.full(n, np.inf), np.zeros((len(sensors), n, 2), int)
        return np.tile(far, (len(sensors), 1)), none, count, sets.complete, far, none[0], far, far
    rows = np.arange(n)
    at = np.round(apart, _DECIMALS).argmin(axis=2)
    least = np.take_along_axis(apart, at[..., None], axis=2)[..., 0]
    worst = np.where(np.isfinite(least)[..., None], pairs[rows, at], 0)
    best = apart.max(axis=0)
    near = np.round(best, _DECIMALS).argmin(axis=1)
    closest, there = best[rows, near], np.isfinite(best[rows, near])
    (R, T), (Q, S) = ((sets.R[rows, k[near]], sets.T[rows, k[near]]) for k in sets.pairs)
    points = Arrangement.of(sets.instance).y
    way = np.linalg.norm(points @ np.swapaxes(R - Q, 1, 2) + (T - S)[:, None], axis=2).max(axis=1)
    turn = np.linalg.norm(vector_from_rotation(np.swapaxes(Q, 1, 2) @ R), axis=1)
    numbers = np.where(there[:, None], pairs[rows, near], 0)
    moved = [np.where(there, part, np.inf) for part in (way, turn)]
    return least, worst, count, sets.complete, closest, numbers, *moved


@dataclass(frozen=True, eq=False)
class SensorResult(Tabular):
    """How well one additional sensor distinguishes the real modes of a platform.

    Attributes
    ----------
    instance
        The platform.
    values
        The n sets of readings of the machine, shape (n, 6); None for those of the instance.
    sensors
        The s sensors.
    sigmas
        Their standard deviations, in the units of the instance, shape (s,).
    close
        Two modes are close if no point of the platform is farther apart than this, in the unit of
        length; no leg distinguishes them.
    need
        The difference in standard deviations that suffices.
    known_side
        Whether only modes on the side of home count.
    separations
        The differences for each sensor at each set.
    """

    instance: Instance
    values: Array | None
    sensors: tuple[Sensor, ...]
    sigmas: Array
    close: float
    need: float
    known_side: bool
    separations: Separations

    def __post_init__(self) -> None:
        for array in (self.values, self.sigmas, *vars(self.separations).values()):
            if array is not None:
                array.setflags(write=False)

    def __repr__(self) -> str:
        name = self.instance.name or self.instance.type.id
        told = int(self.told.sum())
        sets = f"{told} set{'s' * (told != 1)} of values with several modes"
        if self.best is None:
            return f"<SensorResult of {name}: {sets}>"
        best, share = self.sensors[self.best], self.shares[self.best]
        return f"<SensorResult of {name}: {best} tells them apart in {share:.0%} of {sets}>"

    @cached_property
    def told(self) -> Flags:
        """Which sets have more than one mode, all of them known, shape (n,)."""
        return self.separations.complete & (self.separations.modes > 1)

    @cached_property
    def shares(self) -> Array:
        """The part of these sets for which each sensor suffices, shape (s,); NaN without a set."""
        if not self.told.any():
            return np.full(len(self.sensors), np.nan)
        return np.asarray((self.separations.least[:, self.told] >= self.need).mean(axis=1))

    def quantile(self, part: float) -> Array:
        """Return a quantile over these sets of each sensor's worst difference, shape (s,)."""
        if not self.told.any():
            return np.full(len(self.sensors), np.nan)
        return np.asarray(np.quantile(self.separations.least[:, self.told], part, axis=1))

    @cached_property
    def order(self) -> list[int]:
        """The indices of the sensors, the best first: by the part of sets, then by difference."""
        if not self.told.any():
            return list(range(len(self.sensors)))
        surety = np.minimum(self.separations.least[:, self.told], 10 * self.need).mean(axis=1)
        surest, typical = np.round(surety, _DECIMALS), np.round(self.quantile(0.5), _DECIMALS)
        return [int(k) for k in np.lexsort((-typical, -surest, -self.shares))]

    @property
    def best(self) -> int | None:
        """The index of the best sensor; None if no set has two modes."""
        return self.order[0] if self.told.any() and self.sensors else None

    @property
    def suffices(self) -> bool:
        """Whether one sensor suffices for all sets, or no set has two modes."""
        return not self.told.any() or bool((self.shares == 1).any())

    @cached_property
    def hopeless(self) -> Flags:
        """The sets at which two modes are close and no sensor distinguishes them, shape (n,)."""
        near = (self.separations.closest < self.need) & (self.separations.distance < self.close)
        return self.told & near

    def of_kind(self, kind: str) -> list[int]:
        """Return the indices of the sensors of a kind, the best first."""
        return [k for k in self.order if self.sensors[k].kind == kind]

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of the sensors."""
        return tuple(kind for kind in KINDS if self.of_kind(kind))

    def rows(self) -> list[dict[str, Any]]:
        """Return the numbers of each sensor, the best first."""
        low, middle, least = self.quantile(0.05), self.quantile(0.5), self.separations.least
        known = bool(self.told.any())
        rows = []
        for k in self.order:
            at = int(np.round(np.where(self.told, least[k], np.inf), _DECIMALS).argmin())
            first, second = self.separations.worst[k, at].tolist()
            numbers = {
                "least": float(least[k, at]),
                "set": at + 1,
                "first": first,
                "second": second,
                "low": float(low[k]),
                "median": float(middle[k]),
                "share": float(self.shares[k]),
            }
            sensor = self.sensors[k]
            head = {"sensor": str(sensor), "kind": sensor.kind, "sigma": float(self.sigmas[k])}
            rows.append(head | (numbers if known else dict.fromkeys(numbers)))
        return rows

    def to_json(self) -> dict[str, Any]:
        """Return the result as plain data of schema ``gsp.sensors/1``."""
        modes = self.separations.modes[self.separations.complete].tolist()
        return {
            "schema": SCHEMA,
            **self.instance.to_json(),
            "sets": len(self.separations.modes),
            "complete": int(self.separations.complete.sum()),
            "told": int(self.told.sum()),
            "modes": {"least": min(modes), "most": max(modes)} if modes else None,
            "need": self.need,
            "known_side": self.known_side,
            "suffices": self.suffices,
            "sensors": self.rows(),
            "closest": self.closest_json(),
            "version": __version__,
        }

    def closest_json(self) -> dict[str, Any] | None:
        """Return the pair of modes that the sensors distinguish worst; None without a set."""
        if not self.told.any():
            return None
        found = self.separations
        among = self.hopeless if self.hopeless.any() else self.told
        at = int(np.round(np.where(among, found.closest, np.inf), _DECIMALS).argmin())
        return {
            "set": at + 1,
            "modes": found.closest_modes[at].tolist(),
            "least": float(found.closest[at]),
            "translation": float(found.distance[at]),
            "turn": float(found.turn[at]) / self.instance.units.angle.in_radians,
            "hopeless": int(self.hopeless.sum()),
        }


def sensors(
    instance: Instance,
    values: ArrayLike | None = None,
    *,
    coordinates: Mapping[str, ArrayLike] | None = None,
    seed: int = SEED,
    sensors: Sequence[str | Sensor] | None = None,
    sigma: Mapping[str, float] | None = None,
    need: float = NEED,
    known_side: bool = False,
    jobs: int = 1,
) -> SensorResult:
    """Return how well one additional sensor distinguishes the real modes of a platform.

    At each set of values all real modes are found, and the readings of each sensor at them. A
    sensor is judged by the pair of modes whose readings differ least, in its standard deviations.

    Parameters
    ----------
    instance
        The platform.
    values
        Sets of values instead of those of the instance, shape (n, 6), distances to planes signed.
    coordinates
        With values: readings of cranks and slides by the names of the drives, each (n,).
    seed
        The source of randomness of the solver.
    sensors
        The sensors, as `gspcli.sensing.sensor_kinds` writes them; all of its `candidates` if None.
    sigma
        Standard deviations by the kind of sensor (``leg``, ``joint``, ``inclinometer``,
        ``distance``, ``angle``), in the units of the instance. Without one, lengths have a
        thousandth of the platform's size, and angles a tenth of a degree.
    need
        The difference in standard deviations from which on modes count as distinguished.
    known_side
        Whether the side of the base on which the platform is, is known: that of home.
    jobs
        Threads.

    Raises
    ------
    ArgumentError
        If an argument is wrong.
    NotFiniteError, IncompleteError
        If the poses at the values of the instance are infinitely many, or not all known.

    Examples
    --------
    >>> import gspcli
    >>> from gspcli.resources import instance_files
    >>> m2 = gspcli.load(instance_files()["rubin-m2"])
    >>> gspcli.sensors(m2, sensors=["leg P1 B2", "inclinometer"])
    <SensorResult of Rubin Observatory M2 hexapod: ...>
    """
    checked(instance)
    seed, jobs = whole(seed, "seed", least=0), whole(jobs, "jobs", least=1)
    if not (isinstance(need, int | float) and 0 < need < math.inf):
        raise ArgumentError(f"found {need!r}, expected a number above 0", "need")
    chosen = candidates(instance)
    if sensors is not None:
        chosen = each_parsed(sensors, lambda text: parse_sensor(text, instance), "sensors")
    check_sigmas(sigma or {}, KINDS)
    usual = default_sigmas(instance) | {kind: float(x) for kind, x in (sigma or {}).items()}
    deviations = np.array([usual[sensor.kind] for sensor in chosen])
    if values is None:
        rows, blocks = None, [ModeSets.of_result(_finite(instance, seed, jobs))]
    else:
        rows, numbers = _checked_rows(instance, values, coordinates or {})
        blocks = list(_modes(instance, rows, numbers, seed, jobs))
    if known_side:
        side = _home_side(instance, seed, jobs)
        blocks = [block.on_side(side) for block in blocks]
    return SensorResult(
        instance=instance,
        values=rows,
        sensors=tuple(chosen),
        sigmas=deviations,
        close=float(need * usual["leg"]),
        need=float(need),
        known_side=known_side,
        separations=separations(blocks, chosen, deviations),
    )


def default_sigmas(instance: Instance) -> dict[str, float]:
    """Return the standard deviations of sensors by their kind, in the units of the instance."""
    arrangement = Arrangement.of(instance)
    size = arrangement.extent or arrangement.length
    length = float(f"{_SIGMA_PART * size:.{_DIGITS}g}")
    angle = math.radians(_SIGMA_DEGREES) / instance.units.angle.in_radians
    angle = float(f"{angle:.{_DIGITS}g}")
    return {kind: length if kind in ("leg", "distance") else angle for kind in KINDS}


def _checked_rows(
    instance: Instance, values: ArrayLike, coordinates: Mapping[str, ArrayLike]
) -> tuple[Array, Array | None]:
    """Return sets of readings, distances to planes unsigned, (n, 6), and q of drives, (n, m)."""
    rows = value_rows(values)
    if not len(rows):
        raise ArgumentError("found no set of values, expected at least one", "values")
    arrangement = Arrangement.of(instance)
    meant = np.array(values_of(instance, rows))
    wrong = arrangement.sided & (np.sign(meant) == -arrangement.sides) & (arrangement.sides != 0)
    for k, i in np.argwhere(wrong).tolist():
        message = f"found {rows[k, i]:g}, expected the {instance.constraints[i].side.value} side"
        raise ArgumentError(message, f"values[{k}][{i}]")
    machine = Machine.of(instance)
    for name in coordinates:
        if name not in machine.names or not machine.moved[machine.names.index(name)]:
            raise ArgumentError(f"found {name}, expected a drive", "coordinates")
    numbers = machine.read(rows, coordinates) if machine.moves else None
    meant[:, arrangement.sided] = np.abs(meant[:, arrangement.sided])
    for problem in problems_of(instance, meant).values():
        raise ArgumentError(problem)
    return readings_of(instance, meant, signed=False), numbers


def _modes(
    instance: Instance, rows: Array, numbers: Array | None, seed: int, jobs: int
) -> Iterator[ModeSets]:
    """Yield the modes at all sets, in blocks of sets."""
    if numbers is not None:
        drives = Machine.of(instance)
        for q in numbers:
            yield ModeSets.of_result(solve(drives.instance_at(q), seed=seed, jobs=jobs))
        return
    for begin in range(0, len(rows), _CHUNK):
        batch = solve_batch(instance, rows[begin : begin + _CHUNK], seed=seed, jobs=jobs)
        yield ModeSets.of(instance, batch.R, batch.T, batch.real, batch.complete)


def _finite(instance: Instance, seed: int, jobs: int) -> SolveResult:
    """Return the poses of an instance; raise an error if they are infinite or incomplete."""
    result = solve(instance, seed=seed, jobs=jobs)
    if result.verdict == "infinite" and not len(result.lone.R):
        raise NotFiniteError("the poses are infinitely many: there are no modes to tell apart")
    if result.verdict == "incomplete":
        raise IncompleteError("not all poses could be found: gsp solve says what is missing")
    return result


def _home_side(instance: Instance, seed: int, jobs: int) -> float:
    home = _finite(instance, seed, jobs).home
    if home is None:
        message = "the platform has no real pose for its values: no side is that of home"
        raise ArgumentError(message, "known_side")
    side = float(np.sign(_heights(instance, home.R, home.T)))
    if not side:
        message = "at home the middle of the platform is in the plane of the base: on no side"
        raise ArgumentError(message, "known_side")
    return side
