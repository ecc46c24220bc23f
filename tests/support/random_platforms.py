"""Random platforms of which the numbers of poses are known: each has a hidden real pose."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from functools import cache

import numpy as np

from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.kinds import DPP
from gspcli.catalogue.types import CLASSES, CONSTRAINTS, MAX_ANGLES, Family, GspType, families
from gspcli.defaults import SEED
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Units
from gspcli.geometry.measurement import measured
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Point, vector
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.geometry.random_instances import random_instance
from gspcli.solver import PoseSet, solve
from tests.support.examination import Finding, Pose, examine
from tests.support.oracle.poses_by_paths import solve_by_tracking, solve_each_by_tracking


@dataclass(frozen=True)
class Task:
    """Some random platforms: of a type chosen at random in a family, or with six DPP.

    Attributes
    ----------
    name
        The name of the family, or that of a chunk.
    count
        How many instances.
    seed
        The source of randomness, with the name.
    """

    name: str
    count: int
    seed: int

    def rng(self, instance: int) -> np.random.Generator:
        """Return the source of randomness of one of the instances."""
        return np.random.default_rng([self.seed, zlib.crc32(self.name.encode()), instance])


def random_platform(rng: np.random.Generator) -> tuple[Arrangement, Pose]:
    """Return a real platform with six DPP, all coordinates uniform in [-1, 1], and a pose."""
    y, x = rng.uniform(-1, 1, (2, CONSTRAINTS, 3))
    R, T = rotation_from_quaternion(rng.normal(size=4)), rng.uniform(-1, 1, 3)
    arrangement = Arrangement(
        kinds=(DPP,) * CONSTRAINTS,
        y=y,
        x=x,
        u=np.zeros_like(y),
        v=np.zeros_like(x),
        values=np.zeros(CONSTRAINTS),
        sides=np.zeros(CONSTRAINTS, dtype=np.int64),
        in_radians=1.0,
    )
    return arrangement.with_values(measured(arrangement, R, T)), (R, T)


@cache
def families_by_name() -> dict[str, Family]:
    """Return the families by name, such as ``3D3A PL PL LP``."""
    return {family.id: family for platform_class in CLASSES for family in families(platform_class)}


def random_member(task: Task, number: int) -> tuple[Instance, Pose]:
    """Return one of the random instances of a family."""
    rng = task.rng(number)
    types = families_by_name()[task.name].types
    return random_instance(types[rng.integers(len(types))], rng)


def shown(name: str, number: int) -> Instance:
    """Return an instance of a run, its doubles written out."""
    task = Task(name, 0, SEED)
    if name in families_by_name():
        return random_member(task, number)[0]
    arrangement, _ = random_platform(task.rng(number))

    def exact(value: float) -> Number:
        return Number.of(repr(float(value)))

    constraints = tuple(
        Constraint(
            DPP,
            Point(vector(*map(exact, y))),
            Point(vector(*map(exact, x))),
            exact(d),
            platform_name=f"P{i}",
            base_name=f"B{i}",
        )
        for i, (y, x, d) in enumerate(
            zip(arrangement.y, arrangement.x, arrangement.values, strict=True), start=1
        )
    )
    return Instance(constraints, Units("unit", AngleUnit.DEGREE))


def solved_platforms(task: Task) -> list[Finding]:
    """Solve random platforms with six DPP by following paths."""
    drawn = [random_platform(task.rng(i)) for i in range(task.count)]
    expected = generic_counts(GspType.of((DPP,) * CONSTRAINTS)).two_sided
    answers = solve_each_by_tracking((arrangement for arrangement, _ in drawn), seed=task.seed)
    return [
        examine(arrangement, poses, expected, hidden)
        for (arrangement, hidden), poses in zip(drawn, answers, strict=True)
    ]


def solved_member(task: Task, number: int = 0) -> Finding:
    """Solve one of the random platforms of a family; those with three angles in two ways."""
    expected = generic_counts(families_by_name()[task.name].types[0]).two_sided
    instance, hidden = random_member(task, number)
    arrangement = Arrangement.of(instance)
    answers: list[PoseSet] = [solve(instance, seed=task.seed)]
    if len(instance.type.angles) == MAX_ANGLES:
        answers.append(solve_by_tracking(arrangement, seed=task.seed))
    # The worse one of two ways to solve.
    each = [examine(arrangement, answer, expected, hidden) for answer in answers]
    return max(each, key=lambda finding: len(finding.problems))
