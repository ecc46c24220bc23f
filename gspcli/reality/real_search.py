"""Searches for platforms with many real poses: from a type or a platform to an instance.

After P. Dietmaier, *The Stewart-Gough platform of general geometry can have 40 real postures*
(1998): take a conjugate pair of solutions that is close to a fold, move the platform so that the
pair comes together and becomes real, and keep all real solutions from coming together meanwhile. A
step is the shortest change of the platform's numbers that does this to first order, of limited
length. After each step all solutions are followed along a random complex path; the search accepts
no step that loses a real one. It works on reduced platforms (`gspcli.reality.platforms`).
"""

from __future__ import annotations

import itertools
import json
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP, KINDS_BY_NAME, Kind
from gspcli.catalogue.names import any_type
from gspcli.catalogue.types import CONSTRAINTS, GspType
from gspcli.continuation.start import path_count
from gspcli.continuation.systems import Structure, System
from gspcli.continuation.tracked_paths import follow, solve_systems
from gspcli.defaults import SEARCH_SECONDS, SEED
from gspcli.errors import ArgumentError, GspError, IncompleteError
from gspcli.geometry.instance import Instance, Units
from gspcli.geometry.measurement import Gradient, by_twist, polynomial
from gspcli.geometry.quaternions import dot, pose_from_study
from gspcli.geometry.shortest_step import shortest_step
from gspcli.reality.platforms import Platforms, multiplier, random_platforms, reality, reduced
from gspcli.reality.witness_proofs import DEFAULT_UNITS, certified_real, platform_of, real_instance
from gspcli.records import Tabular, dataclass
from gspcli.spec import dumps
from gspcli.spec.document import LARGEST_SPEC, content_of
from gspcli.wording import named
from gspcli.workers import HERE, Workers

#: Numbers of a constraint: y, x, u, v and the value.
NUMBERS = 13
Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

#: The number of nearest real solutions from which each real solution is kept apart.
_NEIGHBOURS = 3

_ROTATIONS = np.zeros((3, 3, 3))
for _i, _j, _k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    _ROTATIONS[_i, _j, _k], _ROTATIONS[_i, _k, _j] = 1.0, -1.0


def free_numbers(kinds: tuple[Kind, ...]) -> NDArray[np.bool_]:
    """Return which numbers of the constraints may change, shape (6, 13).

    Distances of planes and lines stay zero. Directions of points have no gradient.
    """
    free = np.ones((len(kinds), NUMBERS), bool)
    free[:, :6] = np.array([kind.is_distance for kind in kinds])[:, None]
    free[:, -1] = [kind not in (DPH, DHP, DLL) for kind in kinds]
    return free


@dataclass(frozen=True, eq=False)
class Folds:
    """Linear distances to platforms with a double solution, for p pairs of solutions.

    Where two solutions meet, two real ones become a conjugate pair or conversely. Near such a fold
    the square of their distance is a smooth function of the numbers of the platform that changes
    its sign. Its value divided by the length of its gradient is approximately the distance to the
    fold in the space of platforms: Dietmaier's linear model, for all kinds.
    """

    #: Shape (p,).
    distances: Array
    #: Unit vectors of the changes of the numbers away from the fold, shape (p, 6 * 13).
    normals: Array


def moved(platform: Platforms, step: Array) -> Platforms:
    """Return a platform with its numbers changed by a step, shape (78,), directions of norm 1."""
    change = step.reshape(-1, NUMBERS)
    return Platforms(
        platform.kinds,
        platform.y + change[:, :3],
        platform.x + change[:, 3:6],
        _directions(platform.u + change[:, 6:9]),
        _directions(platform.v + change[:, 9:12]),
        platform.values + change[:, 12],
    )


def _directions(vectors: Array) -> Array:
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(lengths > 0, lengths, 1.0))


def folds(
    platform: Platforms, R: Complex, T: Complex, real: NDArray[np.bool_]
) -> tuple[Folds, Folds]:
    """Return the folds of conjugate pairs, and those of real solutions and their neighbours.

    Parameters
    ----------
    platform
        A reduced platform: distances of folds are those to others.
    R, T
        All its solutions, shapes (n, 3, 3) and (n, 3).
    real
        Which are real, shape (n,).
    """
    by_twist, by_number = _gradients(platform, R, T)
    X = np.concatenate((R.reshape(-1, 9), T), axis=-1)
    # Derivatives of the entries of (R, T) by the values of the six equations: (n, 6, 12).
    entries = np.zeros((len(R), 6, 12), complex)
    entries[:, :3, :9] = np.einsum("ikl,slj->skij", _ROTATIONS, R).reshape(-1, 3, 9)
    entries[:, 3:, 9:] = np.eye(3)
    by_value = -np.linalg.solve(np.swapaxes(by_twist, -1, -2), entries)

    def gradient(index: NDArray[np.int64], direction: Array) -> Complex:
        # The derivatives of ``direction . X`` by the numbers, shape (k, 6, 13).
        multipliers = np.einsum("sic,sc->si", by_value[index], direction)
        return np.asarray(multipliers[..., None] * by_number[index])

    # One solution of each pair: in general position the one with a positive imaginary part.
    height = X.imag @ np.sqrt(np.arange(1, 13))
    pairs = np.flatnonzero(~real & (height > 0))
    imaginary = X[pairs].imag
    upper = _folds(platform, (imaginary**2).sum(-1), 2 * gradient(pairs, imaginary).imag)
    first, second = neighbours(X[real].real)
    index = np.flatnonzero(real)
    first, second = index[first], index[second]
    difference = X[first].real - X[second].real
    change = gradient(first, difference).real - gradient(second, difference).real
    return upper, _folds(platform, (difference**2).sum(-1) / 4, change / 2)


def _folds(platform: Platforms, squares: Array, gradients: Array) -> Folds:
    """Return folds from squared half distances (p,) and their gradients (p, 6, 13)."""
    allowed = np.where(free_numbers(platform.kinds), gradients, 0.0)
    for part, directions in ((slice(6, 9), platform.u), (slice(9, 12), platform.v)):
        # The change of a unit direction is perpendicular to it.
        allowed[..., part] -= dot(allowed[..., part], directions)[..., None] * directions
    flat = allowed.reshape(len(squares), len(platform.kinds) * NUMBERS)
    lengths = np.linalg.norm(flat, axis=-1)
    return Folds(squares / lengths, flat / lengths[:, None])


def neighbours(X: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the pairs of points (n, 12) that are neighbours, each pair once."""
    if len(X) < 2:
        return np.zeros(0, int), np.zeros(0, int)
    squares = (X**2).sum(-1)
    distances = squares[:, None] + squares - 2 * X @ X.T
    np.fill_diagonal(distances, np.inf)
    count = min(_NEIGHBOURS, len(X) - 1)
    nearest = np.argpartition(distances, count - 1, axis=-1)[:, :count]
    pairs = np.stack((np.repeat(np.arange(len(X)), count), nearest.ravel()), axis=-1)
    first, second = np.unique(np.sort(pairs, axis=-1), axis=0).T
    return first, second


def _gradients(platform: Platforms, R: Complex, T: Complex) -> tuple[Complex, Complex]:
    """Return derivatives of the equations by a twist (n, 6, 6) and by their numbers (n, 6, 13).

    The equations are the polynomials of `gspcli.geometry.measurement` less their stated
    values.
    """
    r, w, arm = platform.placed(R, T)
    v = np.broadcast_to(platform.v, w.shape)
    by_r, by_w, by_v = (np.zeros(w.shape, complex) for _ in range(3))
    by_value = np.zeros(w.shape[:2], complex)
    for i, kind in enumerate(platform.kinds):
        gradient = polynomial(kind).gradient(r[:, i], w[:, i], v[:, i])
        by_r[:, i], by_w[:, i], by_v[:, i] = gradient
        if not kind.is_distance:
            by_value[:, i] = -1.0
        elif kind in (DPP, DPL, DLP):
            by_value[:, i] = -2 * platform.values[i]
    rates = by_twist(Gradient(by_r, by_w, by_v), arm, w)
    by_number = np.concatenate((by_r @ R, -by_r, by_w @ R, by_v, by_value[..., None]), axis=-1)
    return rates, by_number


@dataclass(frozen=True, eq=False)
class Solved:
    """A reduced platform with all its solutions."""

    #: One platform, no leading axes.
    platform: Platforms
    #: Its equations.
    system: System
    #: Solutions in Study coordinates, N = 1, shape (n, 8).
    points: Complex
    #: Which are real, shape (n,).
    real: NDArray[np.bool_]

    @property
    def count(self) -> int:
        """The number of real solutions."""
        return int(self.real.sum())

    def folds(self) -> tuple[Folds, Folds]:
        """Return the folds of conjugate pairs and those of real solutions."""
        R, T = pose_from_study(self.points[:, :4], self.points[:, 4:])
        return folds(self.platform, R, T, self.real)

    @property
    def margin(self) -> float:
        """The linear distance to the nearest fold of real solutions."""
        return float(self.folds()[1].distances.min(initial=np.inf))


def solved(platform: Platforms, seed: int = SEED) -> Solved | None:
    """Return a platform with all solutions, or None if some cannot be found or decided."""
    system = next(platform[None].systems())
    result = next(solve_systems([system], seed=seed))
    if len(result.points) != result.account.expected:
        return None
    found = reality(result.points, result.condition)
    if not found.decided:
        return None
    return Solved(platform, system, result.points, found.real)


def followed_from(known: Solved, platform: Platforms, rng: np.random.Generator) -> Solved | None:
    """Return a platform near another with all solutions, followed from those of the other."""
    system = next(platform[None].systems())
    ends = follow(known.system, known.points, system, rng=rng)
    if ends is None:
        return None
    found = reality(ends.points, ends.condition)
    return Solved(platform, system, ends.points, found.real) if found.decided else None


#: Sizes of random platforms, in turn by the number of the attempt. Types with distances of points
#: and lines begin with the small ones, which have more real solutions there.
_SIZES = (1.0, 0.3)
#: Real solutions are kept this far from folds, or if they are nearer, ...
_MARGIN = 0.005
#: ... moved away by the first factor. For a given platform they are kept beyond the second factor
#: only: near limits too many folds are near to move away from all of them.
_GROWTH, _LEEWAY = 1.3, 0.8
#: First, largest and smallest length of a step; numbers are of the order of one.
_RADIUS, _MAX_RADIUS, _MIN_RADIUS = 0.05, 0.3, 1e-3
#: The largest ratio of the shortest step for a pair to its part towards the fold.
_DETOUR = 4.0
#: Mean rank, by distance, of the conjugate pair that a step brings together.
_RANK = 2.0
#: An attempt ends after this many steps without a new real pair.
_PATIENCE = 200
#: Solutions are followed from those of the last platform; after this many steps all are solved.
_AFRESH = 50
#: Limits of the numbers: points, distances, and the least difference from 1 of a cosine.
_LARGEST, _SMALLEST, _COSINE = 4.0, 0.02, 1e-3
#: Distance to folds up to which a finished platform is improved, and with how many steps.
_COMFORT, _IMPROVEMENTS = 0.03, 60


def _acceptable(platform: Platforms, limit: float = _LARGEST) -> bool:
    """Return whether the numbers of a platform are neither too large nor degenerate."""
    values = np.abs(platform.values)
    distance = np.array([kind.is_distance for kind in platform.kinds])
    smallest = np.where([kind in (DPH, DHP, DLL) for kind in platform.kinds], 0.0, _SMALLEST)
    return bool(
        _largest(platform) < limit
        and (values >= np.where(distance, smallest, 0.0)).all()
        and (values[~distance] < 1 - _COSINE).all()
    )


def _largest(platform: Platforms) -> float:
    """Return the largest number of a platform."""
    parts = (platform.y, platform.x, platform.values)
    return max(float(np.abs(part).max()) for part in parts)


def _centred(platform: Platforms) -> Platforms:
    """Return a platform with origins in the middle of its points, of which few may be far."""
    distance = np.array([kind.is_distance for kind in platform.kinds])
    y, x = (
        (part - np.median(part[distance], axis=0)) * distance[:, None]
        for part in (platform.y, platform.x)
    )
    return replace(platform, y=y, x=x)


@dataclass(frozen=True)
class Search:
    """The settings of a search."""

    #: The kinds of the six constraints.
    kinds: tuple[Kind, ...]
    #: Source of the random numbers.
    seed: int = SEED
    #: The number of real solutions of a reduced platform at which the search may end; None: all
    #: solutions.
    target: int | None = None
    #: The reduced platform that every attempt begins with; random ones if None.
    start: Platforms | None = None
    #: Time (`time.time`, the same on all machines) at which attempts end.
    deadline: float | None = None
    #: The number of random platforms at the beginning of an attempt; the best one is improved.
    starts: int = 32
    #: The number of platforms that an attempt may solve after that; None for no limit.
    steps: int | None = None

    @property
    def structure(self) -> Structure:
        """The structure of the systems of reduced platforms."""
        platforms = reduced(random_platforms(self.kinds, 1, np.random.default_rng(self.seed)))
        return next(platforms.systems()).structure.canonical()

    @property
    def is_late(self) -> bool:
        """Whether the deadline has passed."""
        return self.deadline is not None and time.time() > self.deadline

    @property
    def _limit(self) -> float:
        """The largest size of numbers."""
        return _LARGEST if self.start is None else max(_LARGEST, 1.5 * _largest(self.start))

    def attempt(self, number: int) -> Solved | None:
        """Return the best platform that one attempt finds, None if it finds none in time."""
        rng = np.random.default_rng([self.seed, number])
        best = self._first(rng, number)
        if best is None:
            return None
        best = self._raised(best, rng)
        return self.comfortable(best, number)

    def _first(self, rng: np.random.Generator, number: int) -> Solved | None:
        if self.start is not None:
            return solved(_centred(self.start), self.seed)
        best: Solved | None = None
        platforms = reduced(random_platforms(self.kinds, self.starts, rng))
        lines = any(kind in (DPL, DLP) for kind in self.kinds)
        size = _SIZES[(number + lines) % len(_SIZES)]
        platforms = replace(platforms, y=size * platforms.y, x=size * platforms.x)
        for k in range(self.starts):
            if best is not None and self.is_late:
                break
            found = solved(_centred(platforms[k]), self.seed)
            if found is not None and (best is None or found.count > best.count):
                best = found
        return best

    def _moved(self, best: Solved, step: Array | None) -> Platforms | None:
        """Return the platform after a step, if there is one and its numbers are acceptable."""
        if step is None:
            return None
        platform = _centred(moved(best.platform, step))
        return platform if _acceptable(platform, self._limit) else None

    def _raised(self, best: Solved, rng: np.random.Generator) -> Solved:
        """Return the platform after steps that make pairs real."""
        goal = min(self.target or len(best.points), len(best.points))
        radius, idle, followed = _RADIUS, 0, 0
        near = best.folds()
        while best.count < goal and idle < _PATIENCE and not self.is_late:
            if followed == self.steps:
                break
            idle += 1
            step = _raising_step(near, radius, rng, _GROWTH if self.start is None else _LEEWAY)
            platform, new = self._moved(best, step), None
            if platform is not None:
                followed += 1
                new = (
                    followed_from(best, platform, rng)
                    if followed % _AFRESH
                    else solved(platform, self.seed)
                )
            if new is None or new.count < best.count:
                radius = radius / 2 if radius > 2 * _MIN_RADIUS else _RADIUS
                continue
            radius = min(1.5 * radius, _MAX_RADIUS)
            if new.count > best.count:
                idle = 0
            best, near = new, new.folds()
        return best

    def comfortable(self, best: Solved, number: int) -> Solved:
        """Return a platform with as many real solutions, farther from folds, to be rounded."""
        rng = np.random.default_rng([self.seed, number, 1])
        radius, nearest = _RADIUS, best.margin
        for _ in range(_IMPROVEMENTS):
            if nearest > _COMFORT or radius < _MIN_RADIUS or self.is_late:
                break
            real = best.folds()[1]
            near = real.distances < nearest + 2 * radius
            wanted = np.minimum(nearest + radius, 1.5 * nearest)
            step = shortest_step(
                real.normals[near], wanted - real.distances[near], _DETOUR * radius
            )
            platform = self._moved(best, step)
            new = None if platform is None else followed_from(best, platform, rng)
            further = nearest if new is None else new.margin
            if new is None or new.count < best.count or further <= nearest:
                radius /= 2
                continue
            best, nearest, radius = new, further, min(1.5 * radius, _MAX_RADIUS)
        return best


def _raising_step(
    near: tuple[Folds, Folds], radius: float, rng: np.random.Generator, growth: float
) -> Array | None:
    """Return a step of about a length at most that brings one conjugate pair together."""
    pairs, real = near
    rank = min(int(rng.exponential(_RANK)), len(pairs.distances) - 1)
    chosen = np.argsort(pairs.distances)[rank]
    towards = min(float(pairs.distances[chosen]) + _MARGIN, radius)
    close = real.distances < 3 * radius + _MARGIN
    kept = np.minimum(_MARGIN, growth * real.distances[close])
    return shortest_step(
        np.concatenate((-pairs.normals[[chosen]], real.normals[close])),
        np.concatenate(([towards], kept - real.distances[close])),
        _DETOUR * radius,
    )


def attempts(
    search: Search, first: int = 0, end: int | None = None, workers: Workers = HERE
) -> Iterator[tuple[int, Solved | None]]:
    """Yield the numbers and results of attempts, in order, until the deadline has passed.

    Each attempt depends only on the search and its number, unless the deadline ends it.

    Parameters
    ----------
    search
        The search.
    first, end
        The first attempt, and the first that is not made any more.
    workers
        The processes that make them.
    """
    numbers = itertools.count(first) if end is None else range(first, end)
    wanted = itertools.takewhile(lambda _: not search.is_late, numbers)
    yield from enumerate(workers.in_order(search.attempt, wanted), start=first)


SCHEMA = "gsp.maximize-real/1"
_PARTS = ("y", "x", "u", "v", "values")
_SHAPES = [*[(CONSTRAINTS, 3)] * 4, (CONSTRAINTS,)]


@dataclass(frozen=True, eq=False)
class State:
    """The outcome of the first attempts of a search."""

    #: The type, or the content of the instance file.
    subject: str
    #: The seed of the search.
    seed: int
    #: The number of attempts that are done.
    attempts: int = 0
    #: The number of real solutions of the best reduced platform; 0 if there is none yet.
    real: int = 0
    #: That platform.
    platform: Platforms | None = None

    def after(self, number: int, found: Solved | None) -> State:
        """Return the state after one more attempt."""
        state = replace(self, attempts=number + 1)
        if found is None or found.count <= self.real:
            return state
        return replace(state, real=found.count, platform=found.platform)

    def text(self) -> str:
        """Return the content of the file."""
        names = ("subject", "seed", "attempts", "real")
        document: dict[str, Any] = {"schema": SCHEMA} | {key: getattr(self, key) for key in names}
        if self.platform is not None:
            document["kinds"] = [kind.name for kind in self.platform.kinds]
            document |= {part: getattr(self.platform, part).tolist() for part in _PARTS}
        return json.dumps(document) + "\n"


def read_state(path: Path, subject: str, seed: int) -> State:
    """Return the state in a file; that of a new search if there is no file.

    Raises
    ------
    GspError
        If the file is no state, or that of another search.
    """
    try:
        content = content_of(path, LARGEST_SPEC)
    except FileNotFoundError:
        return State(subject, seed)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise GspError(f"{named(path)}: cannot be read: {reason}") from error
    try:
        document = json.loads(content)
        if document["schema"] != SCHEMA:
            raise ValueError
        platform = None
        if "kinds" in document:
            kinds = tuple(KINDS_BY_NAME[name] for name in document["kinds"])
            parts = [np.array(document[part], float) for part in _PARTS]
            finite = all(np.isfinite(part).all() for part in parts)
            if [part.shape for part in parts] != _SHAPES or not finite:
                raise ValueError
            platform = Platforms(kinds, *parts)
        counts = map(document.get, ("attempts", "real"))
        if any(type(n) is not int or not 0 <= n < 2**63 for n in counts):
            raise ValueError
        names = ("subject", "seed", "attempts", "real")
        state = State(**{key: document[key] for key in names}, platform=platform)
    except (ArithmeticError, ValueError, KeyError, TypeError, RecursionError) as error:
        message = f"{path}: this is not a state of gsp maximize-real: choose another file"
        raise GspError(message) from error
    if (state.subject, state.seed) != (subject, seed):
        message = f"{path}: this is the state of a search for other numbers or with another seed"
        raise GspError(message)
    return state


@dataclass(frozen=True, eq=False)
class RealSearch:
    """A search for a type, or from a first platform."""

    #: The search among reduced platforms.
    search: Search
    #: The type or platform, by its name in a file of the state.
    subject: str
    #: Units and typical length of the instance that is found.
    units: Units = DEFAULT_UNITS
    length: float = 1.0

    @classmethod
    def of(
        cls, given: GspType | Instance, real: int | None, seconds: float, seed: int = SEED
    ) -> RealSearch:
        """Return a search for a number of real poses, or as many as possible, that begins now."""
        if real is not None and real < 1:
            raise ArgumentError(f"found {real}, expected at least one real pose", "real")
        kinds, start = (given if isinstance(given, GspType) else given.type).kinds, None
        platform, length = (None, 1.0) if isinstance(given, GspType) else platform_of(given)
        if platform is not None:
            kinds, start = platform.kinds, reduced(platform)
        wanted = None if real is None else -(-real // multiplier(kinds))
        search = Search(kinds, seed, wanted, start, time.time() + seconds)
        if isinstance(given, GspType):
            return cls(search, given.id)
        return cls(search, dumps(given), given.units, length)

    @property
    def each(self) -> int:
        """The number of real poses for each real pose of a reduced platform."""
        return multiplier(self.search.kinds)

    def steps(
        self, state: State, most: int | None = None, workers: Workers = HERE
    ) -> Iterator[tuple[int, Solved | None, State]]:
        """Yield number and outcome of each attempt, and the state after it.

        An attempt that the deadline ends does not count, but may have found a better platform.

        Parameters
        ----------
        state
            The first state.
        most
            The most attempts, if there is a limit.
        workers
            The processes that make them.
        """
        everything = path_count(self.search.structure)
        goal = everything if self.search.target is None else min(self.search.target, everything)

        def done(state: State) -> bool:
            return state.real >= goal or (most is not None and state.attempts >= most)

        if done(state):
            return
        for number, found in attempts(self.search, state.attempts, most, workers):
            after = state.after(number, found)
            cut = self.search.is_late
            state = replace(after, attempts=state.attempts) if cut else after
            yield number, found, state
            if done(state) or cut:
                return

    def result(self, state: State) -> RealSearchResult:
        """Return the best platform of a state as an instance, its real poses certified.

        Raises
        ------
        IncompleteError
            If no platform was solved.
        GspError
            If not all of its real poses can be certified.
        """
        if state.platform is None:
            raise IncompleteError("no platform was solved in the time given: give more")
        wanted = self.each * state.real
        found = real_instance(state.platform, wanted, units=self.units, length=self.length)
        real = certified_real(found)
        if real < wanted:
            raise GspError(f"only {real} of {wanted} real poses could be certified")
        name = f"{found.type.family.id} with {real} real poses"
        return RealSearchResult(replace(found, name=name), real, state.attempts)


@dataclass(frozen=True, eq=False)
class RealSearchResult(Tabular):
    """A platform with many real poses.

    Attributes
    ----------
    instance
        The platform.
    real
        The number of certified real poses: a lower bound of the largest number for the type.
    attempts
        The number of attempts.
    """

    instance: Instance
    real: int
    attempts: int

    def __repr__(self) -> str:
        return f"<RealSearchResult of {self.instance.type.id}: {self.real} real poses, certified>"

    def rows(self) -> list[dict[str, Any]]:
        """Return the type and the counts, one row."""
        return [{"type": self.instance.type.id, "real": self.real, "attempts": self.attempts}]

    def to_json(self) -> dict[str, Any]:
        """Return everything as plain data; ``spec`` is the text of the instance file."""
        return {
            **self.instance.to_json(),
            "real": self.real,
            "attempts": self.attempts,
            "spec": dumps(self.instance),
        }


def maximize_real(
    given: GspType | Instance | str,
    *,
    real: int | None = None,
    seconds: float = SEARCH_SECONDS,
    attempts: int | None = None,
    seed: int = SEED,
    workers: Workers = HERE,
) -> RealSearchResult:
    """Search for a platform with as many real poses as possible.

    Parameters
    ----------
    given
        A type or its name, the kinds of whose angles make no difference, or a platform to begin
        with.
    real
        The number of real poses that suffices; as many as possible if None.
    seconds, attempts
        The limits of the search.
    seed
        The seed: an attempt depends on it and on the number of the attempt only.
    workers
        The processes that make the attempts.

    Raises
    ------
    IncompleteError
        If no platform was solved in the time given.
    """
    if not seconds > 0:
        raise ArgumentError(f"found {seconds}, expected more than 0", "seconds")
    named = any_type(given) if isinstance(given, str) else given
    search = RealSearch.of(named, real, seconds, seed)
    state = State(search.subject, seed)
    for _, _, after in search.steps(state, attempts, workers):
        state = after
    return search.result(state)
