"""Trajectories of poses for `benchmarks.motion`, each with the platform and its values."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.types import GspType
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.measurement import condition_numbers, jacobian
from gspcli.geometry.quaternions import rotation_from_quaternion, rotation_from_vector
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import measure
from gspcli.spec import loads

Array = NDArray[np.float64]

SEED = 2003
#: Components of wide turns (quaternions, beside a scalar part of one), among how many cycles is
#: chosen, how many are, and at how many poses each is tested.
WIDE, CYCLES, NEAREST, FINE = 0.4, 200, 5, 2000


@dataclass(frozen=True, eq=False)
class Moves:
    """Trajectories, n of them of r rows each.

    Attributes
    ----------
    instance
        The platform.
    R, T, values
        Shapes (n, r, 3, 3), (n, r, 3) and (n, r, 6).
    """

    instance: Instance
    R: Array
    T: Array
    values: Array

    def each(self) -> Iterator[Moves]:
        """Yield the trajectories one by one."""
        for k in range(len(self.T)):
            yield Moves(self.instance, self.R[[k]], self.T[[k]], self.values[[k]])


def cycle(branches: int, rows: int) -> Moves:
    """Return a usual hexapod and smooth closed trajectories."""
    rng = np.random.default_rng(SEED)
    phases = rng.uniform(-np.pi, np.pi, (branches, 1, 6))
    return _swings(phases, np.linspace(0, 2 * np.pi, rows), 0.17)


def near_singularities(rows: int, rows_of_a_cycle: int) -> Moves:
    """Return those of random cycles with wide turns that come nearest to singularities.

    They are gone through again and again. Cycles that meet a singularity are left out: along the
    others the determinant of the Jacobian matrix keeps its sign.
    """
    phases = np.random.default_rng(SEED).uniform(-np.pi, np.pi, (CYCLES, 1, 6))
    moves = _swings(phases, np.linspace(0, 2 * np.pi, FINE), WIDE)
    arrangement = Arrangement.of(moves.instance)
    signs = np.sign(np.linalg.det(jacobian(arrangement, moves.R, moves.T)))
    regular = (signs == signs[:, :1]).all(axis=1)
    conditions = condition_numbers(arrangement, moves.R, moves.T).max(axis=1)
    nearest = np.argsort(-np.where(regular, conditions, 0))[:NEAREST]
    return _swings(phases[nearest], 2 * np.pi / rows_of_a_cycle * np.arange(rows), WIDE)


def _swings(phases: Array, t: Array, turn: float) -> Moves:
    angles = np.radians([[55, 65, 175, 185, 295, 305], [10, 110, 130, 230, 250, 350]])
    sizes = np.array([0.5, 1.0])[:, None]
    corners = np.stack((sizes * np.cos(angles), sizes * np.sin(angles)), axis=-1).round(6)
    instance = loads(_HEXAPOD.format(*corners.reshape(-1).tolist()))
    c = np.sin(t[None, :, None] * (1 + np.arange(6) % 3) + phases)
    ones = np.ones((*c.shape[:2], 1))
    R = rotation_from_quaternion(np.concatenate((ones, turn * c[..., :3]), axis=-1))
    T = np.stack((0.25 * c[..., 3], 0.25 * c[..., 4], 1 + 0.15 * c[..., 5]), axis=-1)
    return Moves(instance, R, T, measure(instance, R, T))


_HEXAPOD = (
    "gsp: 1\nunits: {{length: m, angle: deg}}\nplatform:\n"
    + "".join(f"  P{k}: {{{{point: [{{}}, {{}}, 0]}}}}\n" for k in range(6))
    + "base:\n"
    + "".join(f"  B{k}: {{{{point: [{{}}, {{}}, 0]}}}}\n" for k in range(6))
    + "constraints:\n"
    + "".join(f"  - {{{{distance: [P{k}, B{k}], value: 1}}}}\n" for k in range(6))
)


def small_moves(gsp_type: GspType, branches: int, rows: int) -> Moves:
    """Return a random platform of a type and short smooth trajectories from its pose."""
    rng = np.random.default_rng(SEED)
    instance, (R, T) = random_instance(gsp_type, rng)
    t = np.linspace(0, 1, rows)[None, :, None]
    turn, move = rng.normal(size=(2, branches, 1, 3)) * 0.01
    R, T = rotation_from_vector(t * turn) @ R, T + t * move
    return Moves(instance, R, T, measure(instance, R, T))
