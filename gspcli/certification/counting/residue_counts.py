"""Counts of solutions modulo one prime, by the kernel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import cache

import numpy as np
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.certification import study
from gspcli.certification.counting.coordinates import Blocks
from gspcli.certification.counting.equations import FUNCTIONS, Equations, Function

#: More residues than this are not kept at once (1 GB).
MAX_ENTRIES = 2**27


class Outcome(IntEnum):
    """How a computation modulo a prime ended, as the kernel numbers it."""

    FINITE = 0
    INFINITE = 1
    STOPPED = 2


@dataclass(frozen=True)
class ResidueCount:
    """The solutions of six equations modulo a prime.

    Attributes
    ----------
    outcome
        Whether they are finite in number, over the algebraic closure of the prime field.
    solutions
        Their number with multiplicity, if finite.
    distinct
        Values that a random linear form takes on them, never more than there are distinct ones;
        None if not asked for or too much work.
    has_falls
        Whether relations of lower degree came up: without, none is at infinity.
    all_commutators
        Whether every condition of a border basis was checked, rather than a random combination.
    work
        Multiplications.
    """

    outcome: Outcome
    solutions: int
    distinct: int | None
    has_falls: bool
    all_commutators: bool
    work: int


@cache
def _hessians() -> NDArray[np.int64]:
    entries = [int(entry) for entry in study.hessians().entries()]
    return np.array(entries, dtype=np.int64).reshape(study.COUNT, 8, 8)[:FUNCTIONS].copy()


def _matrix(functions: Sequence[Function], width: int, prime: int) -> NDArray[np.uint64]:
    result = np.zeros((len(functions), width), dtype=np.uint64)
    for row, function in zip(result, functions, strict=True):
        for position, coefficient in function.items():
            row[position] = int(coefficient) % prime
    return result


def count(
    equations: Equations,
    blocks: Blocks,
    prime: int,
    *,
    seed: int,
    max_work: int,
    find_distinct: bool = True,
    build: str = "",
) -> ResidueCount:
    """Count the solutions of equations modulo a prime.

    Parameters
    ----------
    equations
        With integers or residues as coefficients.
    blocks
        The coordinates to use.
    prime
        An odd prime below 2^31, or between 2^60 and 2^61.
    seed
        Of random linear forms.
    max_work
        Multiplications after which to stop.
    find_distinct
        Whether to count the values of a random linear form, too.
    build
        The kernel's build; by default the quickest.

    Returns
    -------
    ResidueCount
        The counts.
    """
    width = FUNCTIONS + len(equations.moments)
    squares = [(k, *square) for k, e in enumerate(equations.equations) for square in e.squares]
    outcome, solutions, distinct, falls, all_commutators, work, _ = _kernel.count(
        prime,
        seed=seed,
        blocks=int(blocks),
        hessians=_hessians(),
        moments=_matrix(equations.moments, FUNCTIONS, prime),
        functions=_matrix([e.linear for e in equations.equations], width, prime),
        squares=_matrix([function for _, _, function in squares], width, prime),
        weights=np.array([int(weight) % prime for _, weight, _ in squares], dtype=np.uint64),
        owners=np.array([owner for owner, _, _ in squares], dtype=np.int64),
        find_distinct=find_distinct,
        max_work=max_work,
        max_entries=MAX_ENTRIES,
        build=build,
    )
    return ResidueCount(
        Outcome(outcome),
        solutions,
        None if distinct < 0 else distinct,
        falls > 0,
        all_commutators,
        work,
    )
