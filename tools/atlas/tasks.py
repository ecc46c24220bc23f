"""The tasks of the atlas: count the solutions of one random system."""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from contextlib import nullcontext
from dataclasses import asdict
from functools import cache, partial
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.counts import all_families
from gspcli.catalogue.kinds import ALL, KINDS_BY_NAME, Kind
from gspcli.catalogue.types import CONSTRAINTS, GspType
from gspcli.certification import certify
from gspcli.continuation.quadrics import BASES, ComplexArray, evaluate, random_quadrics
from gspcli.continuation.systems import EQUATIONS, Coefficients, Structure, System
from gspcli.continuation.tracked_paths import solve_systems
from gspcli.continuation.tracker import CAREFUL, PathStatus, track
from gspcli.defaults import SEED
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import study_from_pose
from gspcli.geometry.random_instances import random_instance
from gspcli.journal import Journal
from gspcli.progress import Progress, silent
from gspcli.records import dataclass
from gspcli.resources import data_json
from gspcli.solver.study_systems import target_systems
from gspcli.workers import HERE, Workers
from tools.atlas.groebner import (
    ModularEquation,
    quadrics_modulo,
    quotient_dimension,
    random_platform,
)
from tools.atlas.intersection_numbers import law

# Trace tests: a check that some solutions of a system are all of them.
#
# Five of the equations cut out a curve. Let the sixth, G = 0 or G H = tau N^2 with factors of a
# space F, move through the systems with G + s k for a general member k of F. On the curve, the
# functions m / k with m in F have poles only where k = 0, and so has s, of the same order. So the
# sum of m / k over *all* solutions is a polynomial in s of degree one: its second differences are
# zero. Those over a part of the solutions are not, unless the part is made of all solutions on some
# components of the curve. The proof is in docs/counts.md.


#: A test is passed if the defect is below this part of `without_one`; without a solution it is
#: about 1.
TOLERANCE = 1e-2
#: The part below which no other random k is tried, and how often paths are followed.
_GOOD = 1e-6
_ATTEMPTS = 3


@dataclass(frozen=True)
class TraceTest:
    """The outcome of a trace test.

    Attributes
    ----------
    defect
        Second difference of the sum over all solutions, relative to the sum of their sizes.
    without_one
        The smallest defect if one solution is omitted.
    """

    defect: float
    without_one: float

    @property
    def passed(self) -> bool:
        """Whether the defect is only rounding, and much larger if one solution is omitted."""
        return self.ratio < TOLERANCE

    @property
    def ratio(self) -> float:
        """The defect divided by the smallest one with an omitted solution."""
        return self.defect / self.without_one if self.without_one > 0 else np.inf


def trace_test(target: System, points: ComplexArray, seed: int) -> TraceTest:
    """Test whether some solutions of a system are all of them.

    Parameters
    ----------
    target
        A system in general position.
    points
        Its regular solutions, Study points of shape (n, 8).
    seed
        Source of the random numbers.

    Returns
    -------
    Trace
        The best of a few attempts: paths may come near to a branch point.
    """
    coefficients, scale = target.coefficients.balanced()
    points = np.array(points, dtype=np.complex128)
    points[:, 4:] /= scale
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    best = TraceTest(np.inf, 0.0)
    for attempt in range(_ATTEMPTS):
        rng = np.random.default_rng([seed, attempt])
        moving = moving_equation(target.structure)
        space = target.structure.spaces[moving]
        member = random_quadrics(space, rng)[0]
        ends = track(
            System(target.structure, coefficients),
            _moved(coefficients, target.structure, moving, member),
            points,
            options=CAREFUL,
        )
        if not (ends.status == PathStatus.REGULAR).all():
            continue
        middle = _functions(space, member, points)
        one, other = (_functions(space, member, ends.points[k::2]) for k in range(2))
        found = _trace(np.concatenate(list(one - 2 * middle + other), axis=1), middle)
        best = min(best, found, key=lambda trace: trace.ratio)
        if best.ratio < _GOOD:
            break
    return best


def moving_equation(structure: Structure) -> int:
    """Return which equation is moved.

    With three angles it is one of them: the other five would leave a curve in pieces, one for
    each orientation. Otherwise it is a distance, not a product if there is another one.
    """
    if structure.spaces.count("a") == 3:
        return structure.spaces.index("a")
    distances = [i for i in range(EQUATIONS) if structure.spaces[i] != "a"]
    return min(distances, key=lambda i: structure.products[i])


def _moved(
    coefficients: Coefficients, structure: Structure, moving: int, member: ComplexArray
) -> Coefficients:
    """Return the systems with G + k and G - k and, for a product, H + k and H - k."""
    count = 4 if structure.products[moving] else 2
    g, h, tau = (np.stack([x] * count) for x in coefficients)
    g[0, moving] += member
    g[1, moving] -= member
    h[2:3, moving] += member
    h[3:4, moving] -= member
    return Coefficients(g, h, tau)


def _functions(space: str, member: ComplexArray, points: ComplexArray) -> ComplexArray:
    """Return m / k for an orthonormal basis of the members m of a space."""
    basis = np.linalg.qr(BASES[space].T)[0].T
    return np.asarray(evaluate(basis, points) / evaluate(member[None], points))


def _trace(differences: ComplexArray, values: ComplexArray) -> TraceTest:
    """Return the outcome from the second differences and the values of each solution."""
    total = differences.sum(axis=0)
    size = np.linalg.norm(values, axis=1).sum()
    rest: NDArray[np.float64] = np.linalg.norm(total - differences, axis=1)
    return TraceTest(float(np.linalg.norm(total) / size), float(rest.min() / size))


@dataclass(frozen=True)
class Tracked:
    """The result of tracking paths to a random platform.

    Attributes
    ----------
    certified
        The number of different poses that are proved to exist.
    trace
        The trace test of the poses that were found; None for both sides.
    """

    certified: int
    trace: TraceTest | None


def tracked(distances: Sequence[Kind], sides: int, seed: int) -> Tracked:
    """Count the poses of one random real platform.

    The poses, complex ones included, are found by tracking paths and proved to be simple in ball
    arithmetic. Simple poses persist when the platform changes, so that their number is a lower
    bound of the generic count.

    Parameters
    ----------
    distances
        The kinds of the distances; the angles are ALL.
    sides
        1 for one side of each DPH and DHP, 2 for both.
    seed
        Source of the random numbers.
    """
    gsp_type = GspType.of([*distances, *[ALL] * (CONSTRAINTS - len(distances))])
    rng = np.random.default_rng([seed, sides, *(kind.order for kind in distances)])
    instance, _ = random_instance(gsp_type, rng, one_sided=sides == 1)
    arrangement = Arrangement.of(instance)
    systems = solve_systems(target_systems(arrangement.normalized), seed=seed)
    R, T = arrangement.poses_of(np.concatenate([found.points for found in systems]))
    certified = certify(instance, R, T).distinct
    if sides == 2:
        return Tracked(certified, None)
    points = np.concatenate(study_from_pose(R, T), axis=-1)
    return Tracked(certified, trace_test(target_systems(arrangement)[0], points, seed))


#: The two largest primes below 2^31.
PRIMES = (2147483647, 2147483629)
#: The largest counts for which Gröbner bases are computed, by the number of sides: their time grows
#: with the third power. Larger two-sided counts follow from one-sided ones and are not tracked.
LIMITS = {1: 1408, 2: 512}


@dataclass(frozen=True)
class Task:
    """One system to count.

    Attributes
    ----------
    subject
        Six letters for general quadrics of six spaces, or the kinds of the distances of a
        platform, such as ``DPL DPL DLP``.
    sides
        2 for both sides of DPH and DHP, else 1.
    characteristic
        The prime, or 0 for a platform with real numbers, for which paths are tracked.
    seed
        Source of the random numbers.
    """

    subject: str
    sides: int
    characteristic: int
    seed: int = SEED

    @property
    def distances(self) -> tuple[Kind, ...] | None:
        """The kinds of the distances; None for general quadrics."""
        if self.subject.islower():
            return None
        return tuple(KINDS_BY_NAME[name] for name in self.subject.split())

    @property
    def expected(self) -> int:
        """The number of solutions by the theorem; for general quadrics by monodromy."""
        if self.distances is None:
            return monodromy_counts()[self.subject]
        open_sides = sum(kind.has_sides for kind in self.distances) * (self.sides - 1)
        return int(law(self.distances) * 2**open_sides)

    def equations(self) -> list[ModularEquation]:
        """Return the random system modulo the prime."""
        random = Random(f"{self.seed} {self.characteristic} {self.sides} {self.subject}")
        if self.distances is None:
            return quadrics_modulo(self.subject, self.characteristic, random)
        angles = CONSTRAINTS - len(self.distances)
        return random_platform(
            self.distances, angles, self.characteristic, random, sides=self.sides
        )

    def run(self, timeout_s: float | None = None) -> int | Tracked | None:
        """Return the number of solutions, or None after the time limit.

        Modulo a prime they are counted with multiplicities. For real numbers only solutions that
        are proved to be different count, and there is no time limit.
        """
        if self.characteristic:
            return quotient_dimension(self.equations(), self.characteristic, timeout_s=timeout_s)
        if self.distances is None:
            message = f"{self.subject}: paths are tracked for platforms only"
            raise ValueError(message)
        return tracked(self.distances, self.sides, self.seed)


def all_tasks(*, seed: int = SEED, characteristics: Sequence[int] = (0, *PRIMES)) -> list[Task]:
    """Return every task, those with few solutions first; see `LIMITS`."""
    tasks = [task for c in characteristics for task in _tasks(c, seed)]
    return sorted(tasks, key=lambda task: task.expected)


def _tasks(characteristic: int, seed: int) -> Iterator[Task]:
    if characteristic:
        for spaces in monodromy_counts():
            yield Task(spaces, 1, characteristic, seed)
    for family in all_families():
        subject = " ".join(kind.name for kind in family.distances)
        one_sided = Task(subject, 1, characteristic, seed)
        if not characteristic or one_sided.expected <= LIMITS[1]:
            yield one_sided
        two_sided = Task(subject, 2, characteristic, seed)
        if any(kind.has_sides for kind in family.distances) and two_sided.expected <= LIMITS[2]:
            yield two_sided


@cache
def monodromy_counts() -> dict[str, int]:
    """Return the counts of the start systems: the 119 intersection numbers by monodromy."""
    counts: dict[str, int] = data_json("start-systems", "manifest.json")["counts"]
    return counts


@dataclass(frozen=True)
class Result:
    """The result of a task.

    Attributes
    ----------
    task
        The task.
    count
        The number of solutions; None after the time limit.
    seconds
        The time.
    tracked
        The details of the count if paths were tracked.
    """

    task: Task
    count: int | None
    seconds: float
    tracked: Tracked | None = None

    @classmethod
    def of_entry(cls, entry: dict[str, Any]) -> Result:
        """Return the result in a line of a work file."""
        tracked = entry.get("tracked")
        if tracked is not None:
            trace = tracked["trace"]
            tracked = Tracked(**{**tracked, "trace": None if trace is None else TraceTest(**trace)})
        return cls(Task(**entry["task"]), entry["count"], entry["seconds"], tracked)


def measure(task: Task, timeout_s: float | None = None) -> Result:
    """Run a task."""
    began = time.monotonic()
    found = task.run(timeout_s)
    tracked = found if isinstance(found, Tracked) else None
    count = found.certified if isinstance(found, Tracked) else found
    return Result(task, count, round(time.monotonic() - began, 3), tracked)


def carry_out(
    tasks: Iterable[Hashable],
    do: Callable[[Any], Any],
    *,
    decode: Callable[[dict[str, Any]], Any],
    journal: Path | None = None,
    workers: Workers = HERE,
    progress: Progress = silent,
    label: str = "",
) -> dict[Any, Any]:
    """Return the results of tasks; results in the work file are not computed again.

    Parameters
    ----------
    tasks
        The tasks.
    do
        Returns the result of a task, with the task as its `task`.
    decode
        The inverse of `dataclasses.asdict` for results; see `Journal.read`.
    journal
        The work file, to which each new result is added at once; None for no record.
    workers
        The processes that do them.
    progress, label
        The receiver of the progress, and the name of the work.
    """
    wanted = list(tasks)
    with Journal.opened(journal) if journal else nullcontext() as work_file:
        known = {result.task: result for result in work_file.read(decode)} if work_file else {}
        results = {task: known[task] for task in wanted if task in known}
        missing = [task for task in wanted if task not in results]
        for result in progress(workers.as_completed(do, missing), total=len(missing), label=label):
            results[result.task] = result
            if work_file:
                work_file.append(asdict(result))
    return results


def count_all(
    tasks: Iterable[Task],
    *,
    journal: Path | None = None,
    workers: Workers = HERE,
    timeout_s: float | None = None,
    progress: Progress = silent,
) -> dict[Task, Result]:
    """Return the results of tasks, see `carry_out`; a task ends after the time limit."""
    return carry_out(
        tasks,
        partial(measure, timeout_s=timeout_s),
        decode=Result.of_entry,
        journal=journal,
        workers=workers,
        progress=progress,
        label="counting solutions",
    )
