"""Counts of solutions modulo one prime, by the kernel."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gspcli import _kernel
from gspcli.certification.counting.motion_equations import (
    FUNCTIONS,
    Blocks,
    Function,
    MotionEquation,
    MotionEquations,
)
from gspcli.geometry import study
from gspcli.records import dataclass

#: The most residues that are kept together (1 GB).
MAX_ENTRIES = 2**27


class Ending(IntEnum):
    """The end of a computation modulo a prime, with the numbers of the kernel."""

    FINITE = 0
    INFINITE = 1
    STOPPED = 2


@dataclass(frozen=True)
class Step:
    """A step of an elimination: independent rows and the pivot of each."""

    #: The degree d. Columns are the products of normal monomials of degree d - 1 and variables,
    #: then the normal monomials below, both in degree reverse lexicographic order.
    degree: int
    #: For each row the number of a generator, or two variables and the exponents of the normal
    #: monomial whose commutator it is.
    sources: list[list[int]]
    #: For each row the column of its pivot after the elimination.
    pivots: list[int]


@dataclass(frozen=True)
class EliminationTrace:
    """The record of a computation modulo a prime, to repeat it in other arithmetic."""

    #: The prime.
    prime: int
    #: Functions of a motion: the variables, and all coordinates in use with 1.
    variables: list[int]
    coordinates: list[int]
    #: The first generators: quadrics that vanish on the motions, coefficients of the products ``x_i
    #: x_j``, j <= i, of the coordinates, row by row.
    relations: list[list[int]]
    #: The generators behind them: numbers of the equations that are not linear.
    quadrics: list[int]
    #: The steps, a fall of degree after each whose pivots are not all in its degree.
    steps: list[Step]


@dataclass(frozen=True)
class ResidueCount:
    """The solutions of six equations modulo a prime."""

    #: Whether their number is finite, over the algebraic closure of the prime field.
    outcome: Ending
    #: Their number with multiplicity, if finite.
    solutions: int
    #: Values that a random linear form takes on them, never more than there are distinct ones; None
    #: if not asked for or too much work.
    distinct: int | None
    #: For each of the groups asked for the number of solutions where none of its members vanishes,
    #: with multiplicity, and distinct; fewer pairs if it is too much work.
    apart: tuple[tuple[int, int], ...]
    #: Whether relations of lower degree were found; without them no solution is at infinity.
    has_falls: bool
    #: All relations are sums of products of equations and monomials up to this degree.
    reach: int
    #: Whether every condition of a border basis was checked, rather than a random combination.
    all_commutators: bool
    #: The number of multiplications.
    work: int
    #: The record of the elimination, if asked for.
    followed: EliminationTrace | None = None


def _matrix(functions: Sequence[Function], width: int, prime: int) -> NDArray[np.uint64]:
    result = np.zeros((len(functions), width), dtype=np.uint64)
    for row, function in zip(result, functions, strict=True):
        for position, coefficient in function.items():
            row[position] = int(coefficient) % prime
    return result


def count(
    equations: MotionEquations,
    blocks: Blocks,
    prime: int,
    *,
    conditions: Sequence[MotionEquation] = (),
    groups: Sequence[Sequence[int]] = (),
    find_distinct: bool = True,
    trace: bool = False,
    **options: Any,
) -> ResidueCount:
    """Count the solutions of equations modulo a prime.

    Parameters
    ----------
    equations
        With integers or residues as coefficients.
    blocks
        The coordinates to use.
    prime
        An odd prime below 2^30, or between 2^60 and 2^61.
    conditions, groups
        Functions in coordinates, as sides of equations, and groups of their numbers.
    find_distinct
        Whether to count the values of a random linear form, too.
    trace
        Whether to record the elimination.
    **options
        Of the kernel. `seed`: of random linear forms. `max_work`: the most multiplications.
        `moment_relations`: whether to find all quadrics that vanish on the motions and contain
        moments; else the moments are coordinates of their own, and what defines them is among the
        equations (`with_moments`). `build`: of the kernel, by default the quickest.
    """
    width = FUNCTIONS + len(equations.moments)
    rows = [*equations.equations, *conditions]
    squares = [(k, *square) for k, row in enumerate(rows) for square in row.squares]
    outcome, solutions, distinct, apart, apart_distinct, *facts, followed = _kernel.count(
        prime,
        blocks=int(blocks),
        hessians=study.form_hessians()[:FUNCTIONS].astype(np.int64),
        moments=_matrix(equations.moments, FUNCTIONS, prime),
        functions=_matrix([row.linear for row in rows], width, prime),
        squares=_matrix([function for _, _, function in squares], width, prime),
        weights=np.array([int(weight) % prime for _, weight, _ in squares], dtype=np.uint64),
        owners=np.array([owner for owner, _, _ in squares], dtype=np.int64),
        equations=len(equations.equations),
        groups=[[len(equations.equations) + k for k in group] for group in groups],
        max_entries=MAX_ENTRIES,
        find_distinct=find_distinct,
        trace=trace,
        **options,
    )
    falls, reach, all_commutators, work = facts
    record = None
    if followed is not None:
        variables, coordinates, relations, numbers, steps = followed
        record = EliminationTrace(
            prime, variables, coordinates, relations, numbers, [Step(*step) for step in steps]
        )
    return ResidueCount(
        Ending(outcome),
        solutions,
        None if distinct < 0 else distinct,
        tuple(zip(apart, apart_distinct, strict=True)),
        falls > 0,
        reach,
        bool(all_commutators),
        work,
        record,
    )
