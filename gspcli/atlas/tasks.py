"""The tasks of the atlas: count the solutions of one random system."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from random import Random

from gspcli.atlas.groebner import quotient_dimension
from gspcli.atlas.modular_equations import ModularEquation, random_platform, random_quadrics
from gspcli.atlas.tracked_counts import Tracked, tracked
from gspcli.catalogue.counts import all_families, law
from gspcli.catalogue.kinds import KINDS_BY_NAME, Kind
from gspcli.catalogue.types import CONSTRAINTS
from gspcli.defaults import SEED
from gspcli.records import dataclass
from gspcli.resources import data_json

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
            return random_quadrics(self.subject, self.characteristic, random)
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
