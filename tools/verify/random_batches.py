"""Batches of one geometry each, with a hidden real pose for every set of values."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli import hexapod, load
from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.types import MAX_ANGLES
from gspcli.defaults import SEED
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.measurement import measured
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.solver import PoseBatch, solve_batch
from tools.recording import ROOT
from tools.verify.examination import MATCH, RESIDUAL, SEPARATION, Finding
from tools.verify.random_platforms import Task, families_by_name, random_member

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

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
#: Families with more solutions, for both sides of all planes, take too long; those with three
#: angles are solved in closed form.
_MOST = 160
#: This many sets of values are examined together.
_CHUNK = 250
#: Decimals of the coordinates of random geometries.
_DIGITS = 4


def batch_tasks(rows: int) -> list[Task]:
    """Return a task for each geometry: random legs, random families, special legs."""
    small = [
        name
        for name, family in families_by_name().items()
        if generic_counts(family.types[0]).two_sided <= _MOST
        and len(family.types[0].angles) < MAX_ANGLES
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
    findings: list[Finding] = []
    for begin in range(0, task.count, _CHUNK):
        part = slice(begin, begin + _CHUNK)
        batch = solve_batch(instance, values[part], seed=task.seed)
        findings += _examined(arrangement, batch, (R[part], T[part]))
    # What a geometry has fewer than its type is the same for almost all values.
    expected = int(np.median([finding.found for finding in findings]))
    return tuple(replace(finding, expected=expected) for finding in findings)


def _examined(
    arrangement: Arrangement, batch: PoseBatch, hidden: tuple[Array, Array]
) -> list[Finding]:
    """Return what is found of each set of a batch, as `examination.examine` does of one."""
    lengths = np.array([arrangement.length_with(row) for row in batch.values])
    there = np.arange(batch.real.shape[1]) < batch.number[:, None]
    charted = _charted(np.where(there[..., None, None], batch.R, 0), batch.T, there, lengths)
    apart = _distances(charted, charted, there)
    diagonal = np.arange(len(there[0]))
    apart[:, diagonal, diagonal] = np.inf
    to_conjugates = _distances(charted.conj(), charted, there)
    asymmetry = np.where(there, to_conjugates.min(axis=2, initial=np.inf), 0.0)
    own = to_conjugates.argmin(axis=2) == diagonal
    R, T = (part[:, None].astype(np.complex128) for part in hidden)
    to_hidden = _distances(_charted(R, T, there[:, :1] | True, lengths), charted, there)[:, 0]
    nearest = to_hidden.argmin(axis=1)[:, None]
    size = np.maximum(1, np.abs(batch.R).max(axis=(2, 3)))
    size += np.abs(batch.T).max(axis=2) / lengths[:, None]
    residual = np.where(there, batch.residuals / lengths[:, None] / size**2, 0.0)
    statements = {
        "incomplete": ~batch.complete,
        "not proved": ~batch.proved,
        "multiple poses": (batch.multiplicity > 1).any(axis=1),
        "equal poses": apart.min(axis=(1, 2)) < SEPARATION,
        "conjugate missing": asymmetry.max(axis=1) > MATCH,
        "reality wrong": (there & (own != batch.real)).any(axis=1),
        "residual": ~(residual.max(axis=1) < RESIDUAL),
        "hidden pose missing": ~(
            (to_hidden.min(axis=1) < MATCH) & np.take_along_axis(batch.real, nearest, axis=1)[:, 0]
        ),
    }
    return [
        Finding(
            int(batch.number[k]),
            int(batch.number[k]),
            int(batch.real[k].sum()),
            float(residual[k].max()),
            float(apart[k].min()),
            float(asymmetry[k].max()),
            tuple(name for name, wrong in statements.items() if wrong[k]),
        )
        for k in range(len(batch))
    ]


def _charted(R: Complex, T: Complex, there: NDArray[np.bool_], lengths: Array) -> Complex:
    """Return (R, T, 1) scaled to norm 1 (`examination`), shape (b, n, 13)."""
    place = np.where(there[..., None], T, 0) / lengths[:, None, None]
    flat = np.concatenate((R.reshape(*T.shape[:2], 9), place, np.ones((*T.shape[:2], 1))), axis=2)
    return np.asarray(flat / np.linalg.norm(flat, axis=2, keepdims=True))


def _distances(points: Complex, among: Complex, there: NDArray[np.bool_]) -> Array:
    """Return the distances of points (b, k, 13) from poses (b, n, 13), infinite from none."""
    square = np.zeros((*points.shape[:2], among.shape[1]))
    for a, b in ((points.real, among.real), (points.imag, among.imag)):
        for i in range(points.shape[2]):
            difference = a[:, :, None, i] - b[:, None, :, i]
            difference *= difference
            square += difference
    return np.where(there[:, None, :], np.sqrt(square), np.inf)
