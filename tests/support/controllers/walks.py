"""Machines whose exported controllers are run, and walks of their values.

Half of the walks go through the values of poses that move smoothly about home. The others go
straight in a random direction of values, where most branches end in a fold.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

import gspcli
from gspcli.catalogue.types import all_types, type_by_number
from gspcli.geometry.coordinates import coordinates
from gspcli.geometry.instance import Instance
from gspcli.geometry.primitives import Geometry, Point
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.geometry.random_instances import random_instance
from tests.support.controllers.compiled import CompiledController, poses_of
from tests.support.independent_machines import machines, upside_down
from tools.recording import ROOT

Array = NDArray[np.float64]
PLATFORMS = ROOT / "data" / "platforms"
TYPES = 50
#: Machines with cranks and slides beside those of ``data/platforms``, without their ranges.
RAILS = ("6-PUS", "6-PUS inverted", "mixed")
#: Rows of a walk, and the size of a step in the values of poses: radians, and parts of the size.
ROWS, STEP = 101, 0.01
#: How much longer the straight steps of some machines are: their folds are farther away.
LONGER = 4
#: How often the motions of walks are tried by half where cranks or slides do not reach.
HALVINGS = 6
#: How far poses move from home.
FAR = 0.3


def names() -> list[str]:
    """Return the machines, and the numbers of types evenly spread."""
    shipped = sorted(p.stem for p in PLATFORMS.glob("*.yaml"))
    count = len(list(all_types()))
    return [*shipped, *RAILS] + [str(1 + k * (count - 1) // (TYPES - 1)) for k in range(TYPES)]


def platform(
    name: str, rng: np.random.Generator, home: float | None = None
) -> tuple[Instance, tuple[Array, Array]]:
    """Return the platform of a name and a pose of it, parallel at a height if one is given."""
    if name.isdigit():
        return random_instance(type_by_number(int(name)), rng)
    if name in RAILS:
        made = machines()[name.removesuffix(" inverted")]()
        instance = _unlimited(made.instance)
        if name.endswith("inverted"):
            return _inverted(instance), (made.R.T, -made.R.T @ made.T)
        return instance, (made.R, made.T)
    instance = gspcli.load(PLATFORMS / f"{name}.yaml")
    if home is not None:
        return instance, (np.eye(3), np.array([0.0, 0.0, home]))
    mode = gspcli.solve(instance).home
    assert mode is not None
    return instance, (mode.R, mode.T)


def _unlimited(instance: Instance) -> Instance:
    """Return a machine without ranges, so that its walks come to folds and dead points."""

    def free(point: Geometry) -> Geometry:
        if not isinstance(point, Point):
            return point
        if point.crank is not None:
            return replace(point, crank=replace(point.crank, limits=None))
        if point.slide is not None:
            return replace(point, slide=replace(point.slide, limits=None))
        return point

    rows = [
        replace(row, platform=free(row.platform), base=free(row.base), limits=None)
        for row in instance.constraints
    ]
    return replace(instance, constraints=tuple(rows))


def _inverted(instance: Instance) -> Instance:
    """Return a machine of distances of points whose base is the platform."""
    return replace(instance, constraints=upside_down(instance), home=None)


def _motors(instance: Instance) -> list[str]:
    """Return the names of the cranks and slides."""
    return [one.name for one in coordinates(instance) if one.is_drive]


def walk_values(
    instance: Instance,
    program: CompiledController,
    R: Array,
    T: Array,
    walks: int,
    rng: np.random.Generator,
    *,
    longer: bool = False,
) -> tuple[Array, Array]:
    """Return the values of walks, shape (n, r, 6), and the poses where they begin, shape (n, 7).

    Longer ones stay where cranks and slides reach, but go straight away farther.
    """
    size = max(
        float(np.abs(row.value.value)) for row in instance.constraints if row.kind.is_distance
    )
    size = max(size, float(np.linalg.norm(T)))
    weights = rng.normal(size=(walks, 3, 6)) / 2
    s = np.arange(ROWS) * STEP / FAR
    waves = np.stack([np.sin(s), 1 - np.cos(s), np.sin(2 * s) / 2], axis=0)
    twists = FAR * np.einsum("nwk,wr->nrk", weights, waves)
    for _ in range(HALVINGS if longer else 1):
        poses = poses_of(rotation_from_vector(twists[..., :3]) @ R, T + size * twists[..., 3:])
        values, stuck = _values_along(program, poses)
        # Arms and rails that are short reach less.
        twists[stuck] /= 2
    away = slice(None, None, 2)
    steps = np.diff(values, axis=1)
    pace = np.linalg.norm(steps, axis=2).mean()
    direction = rng.normal(size=(len(values[away]), 1, 6))
    direction *= pace / np.linalg.norm(direction, axis=2, keepdims=True)
    if longer:
        # Angles of cranks and ways of slides have different units; and folds are farther away.
        direction *= LONGER * 6**0.5 * np.abs(steps).mean(axis=(0, 1)) / pace
    values[away] = values[away, :1] + np.arange(ROWS)[:, None] * direction
    return _in_ranges(instance, values), poses[:, 0]


def _values_along(program: CompiledController, poses: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return the values of poses, and which walks stay where a crank or slide does not reach."""
    walks, rows, _ = poses.shape
    values, ever = np.empty((walks, rows, 6)), np.zeros(walks, bool)
    near = None
    for k in range(rows):
        values[:, k], status = program.inverse(poses[:, k], near)
        near = values[:, k]
        stuck = status != 0
        values[stuck, k] = values[stuck, max(k - 1, 0)]
        ever |= stuck
    return values, ever


def _in_ranges(instance: Instance, values: Array) -> Array:
    """Return walks that go at most twice as far as ranges; struts of one length keep it.

    Values of cranks and slides are no values of constraints.
    """
    if _motors(instance):
        return values
    changes = values - values[:, :1]
    for k, row in enumerate(instance.constraints):
        if row.limits is None:
            continue
        low, high = (limit.value for limit in row.limits)
        if low == high:
            changes[..., k] = 0
            continue
        far = np.abs(changes[..., k]).max(axis=1)
        room = np.maximum(high - values[:, 0, k], values[:, 0, k] - low)
        part = np.minimum(1, 2 * room / np.where(far > 0, far, 1))
        changes *= np.where(far > 0, part, 1)[:, None, None]
    return values[:, :1] + changes
