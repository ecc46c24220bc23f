"""Table 3 confirmed: random instances of all 56 families are solved and their poses counted."""

from __future__ import annotations

from collections import Counter

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DLL
from gspcli.catalogue.types import GspType
from gspcli.defaults import SEED
from gspcli.errors import CheckFailed
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import apply, cross, dot
from gspcli.geometry.random_instances import random_instance
from gspcli.paper.table3 import Entry, compute
from gspcli.progress import Progress, silent
from gspcli.records import dataclass
from gspcli.solver import SolveResult, solve


@dataclass(frozen=True)
class Confirmation:
    """The result of a confirmation.

    Attributes
    ----------
    families, instances
        The numbers of families and instances; every instance had the number of its family.
    """

    families: int
    instances: int


def confirm(*, instances: int = 2, seed: int = SEED, progress: Progress = silent) -> Confirmation:
    """Solve random one-sided instances of every family of Table 3.

    The angles vary over the twenty types of each family. Every combination of a rotation with one
    of the two planes of each DLL must have the number of positions that makes up N1.

    Parameters
    ----------
    instances
        The number of instances of each family.
    seed
        The seed of the instances.
    progress
        Called with the families.

    Raises
    ------
    CheckFailed
        At the first instance with another number of solutions.
    """
    entries = compute()
    rng = np.random.default_rng(seed)
    for index, entry in enumerate(progress(entries, total=len(entries), label="Table 3")):
        types = entry.family.types
        for turn in range(instances):
            gsp_type = types[(index * instances + turn) % len(types)]
            _confirm_instance(entry, gsp_type, rng)
    return Confirmation(len(entries), len(entries) * instances)


def _confirm_instance(entry: Entry, gsp_type: GspType, rng: np.random.Generator) -> None:
    instance, _ = random_instance(gsp_type, rng, one_sided=True)
    result = solve(instance)
    counted = Counter(_branches(result))
    rotations = {rotation for rotation, _ in counted}
    planes = 2 ** gsp_type.count(DLL)
    wanted = {entry.n1 // len(rotations)}
    if (
        result.verdict != "complete"
        or len(counted) != len(rotations) * planes
        or set(counted.values()) != wanted
        or sum(counted.values()) != entry.n1 * planes
    ):
        message = (
            f"{gsp_type}: Table 3 says {entry.n1} one-sided solutions, a random instance has "
            f"{sum(counted.values())} over {planes} choices of planes ({result.verdict})"
        )
        raise CheckFailed(message)


def _branches(result: SolveResult) -> list[tuple[int, tuple[int, ...]]]:
    """Return for each solution its rotation and, for each DLL, its plane of the two."""
    arrangement = Arrangement.of(result.instance)
    lines = [i for i, kind in enumerate(arrangement.kinds) if kind is DLL]
    moments = (
        np.stack([mutual_moment(arrangement, i, result.R, result.T) for i in lines], axis=-1)
        if lines
        else np.zeros((len(result.R), 0), complex)
    )
    representatives: list[int] = []
    branches = []
    for k, rotation in enumerate(result.R):
        near = (r for r in representatives if np.allclose(result.R[r], rotation, atol=1e-6))
        first = next(near, k)
        if first == k:
            representatives.append(k)
        # Under one rotation the moment of a line is plus or minus one number.
        signs = np.sign((moments[k] * moments[first].conj()).real).astype(int)
        branches.append((first, tuple(int(sign) for sign in signs)))
    return branches


def mutual_moment(
    arrangement: Arrangement, i: int, R: NDArray[np.complex128], T: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """Return (R M1 + T − M2)·(R v1 × v2) for the lines of a constraint (Section 4, DLL)."""
    offset = apply(R, arrangement.y[i]) + T - arrangement.x[i]
    moment: NDArray[np.complex128] = dot(
        offset, cross(apply(R, arrangement.u[i]), arrangement.v[i])
    )
    return moment
