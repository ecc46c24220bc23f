"""Batches of one geometry each, with a hidden real pose for every set of values."""

from __future__ import annotations

import numpy as np
from examination import Finding, Pose, examine
from numpy.typing import NDArray
from random_platforms import Task, families_by_name, random_member
from recording import ROOT

from gspcli import hexapod, load
from gspcli.catalogue.counts import generic_counts
from gspcli.defaults import SEED
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.measurement import measured
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.solver import PoseSet, solve_values

Array = NDArray[np.float64]

#: Geometries with six legs that are special, by their files.
SPECIAL = (
    "examples/octahedral-3-3",
    "examples/planar-6-6",
    "examples/planar-hexagons",
    "examples/platform-5-5",
    "examples/platform-6-3",
    "examples/platform-6-4",
    "platforms/linuxcnc-hexapod",
    "platforms/nano-hexapod",
    "platforms/simmechanics-hexapod",
    "platforms/simscape-hexapod",
)
_RANDOM, _FAMILIES = 20, 20
#: Families with more solutions, for both sides of all planes, take too long.
_MOST = 100
#: Decimals of the coordinates of random geometries.
_DIGITS = 4


def batch_tasks(rows: int) -> list[Task]:
    """Return a task for each geometry: random legs, random families, special legs."""
    small = [
        name
        for name, family in families_by_name().items()
        if generic_counts(family.types[0]).two_sided <= _MOST
    ]
    chosen = np.random.default_rng(SEED).choice(small, _FAMILIES, replace=False).tolist()
    names = [*(f"legs {i}" for i in range(_RANDOM)), *sorted(chosen), *SPECIAL]
    return [Task(name, rows, SEED) for name in names]


def geometry_of(task: Task) -> Instance:
    """Return the geometry of a task, with some values."""
    if task.name in SPECIAL:
        return load(ROOT / "data" / f"{task.name}.yaml")
    if task.name in families_by_name():
        return random_member(task, 0)[0]
    base, platform = task.rng(0).uniform(-1, 1, (2, 6, 3)).round(_DIGITS)
    return hexapod(base, platform, np.ones(6))


def hidden_poses(task: Task, arrangement: Arrangement) -> tuple[Array, Array, Array]:
    """Return rotations, translations and the values measured there, shape (rows, 6)."""
    rng = task.rng(1)
    R = rotation_from_quaternion(rng.normal(size=(task.count, 4)))
    T = arrangement.restored(R, arrangement.extent * rng.uniform(-1, 1, (task.count, 3)), 1.0)
    values = measured(arrangement, R, T)
    values[:, arrangement.distances] = np.abs(values[:, arrangement.distances])
    values[:, arrangement.angles] /= arrangement.in_radians
    return R, T, np.asarray(values)


def examine_batch(task: Task) -> tuple[Finding, ...]:
    """Solve a batch, and return what is found of each set of values."""
    instance = geometry_of(task)
    arrangement = Arrangement.of(instance)
    R, T, values = hidden_poses(task, arrangement)
    answers = list(solve_values(instance, values, seed=task.seed))
    # What a geometry has fewer than its type is the same for almost all values.
    expected = int(np.median([poses.account.found for poses in answers]))
    return tuple(
        _examined(arrangement.with_values(row), poses, expected, (rotation, place))
        for row, poses, rotation, place in zip(values, answers, R, T, strict=True)
    )


def _examined(arrangement: Arrangement, poses: PoseSet, expected: int, hidden: Pose) -> Finding:
    finding = examine(arrangement, poses, expected, hidden)
    problems = set(finding.problems)
    if poses.proof is not None and poses.account.verdict == "complete":
        problems -= {"poses at infinity"}
    else:
        problems.add(f"{poses.account.verdict}, not proved")
    return Finding(**{**vars(finding), "problems": tuple(sorted(problems))})
