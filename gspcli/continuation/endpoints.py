"""The ends of all paths of one system, and the test that all are regular."""

from __future__ import annotations

from dataclasses import field
from functools import lru_cache
from random import Random

import numpy as np
from numpy.typing import NDArray

from gspcli.continuation.endgame import ENDGAME, EndgameOptions
from gspcli.continuation.ends import (
    clusters,
    infinite,
    may_coincide,
    regular_error,
)
from gspcli.continuation.paths import PathAccount
from gspcli.continuation.quadrics import ComplexArray, FloatArray
from gspcli.continuation.regularity import clearly_simple
from gspcli.continuation.start import StartSystem
from gspcli.continuation.systems import EQUATIONS, System
from gspcli.continuation.tracker import PathResults
from gspcli.records import dataclass


@dataclass(frozen=True)
class AccountOptions:
    """Settings of the account of all paths."""

    attempts: int = 4
    """Sets of random paths that are tried until nothing is lost. The last is `PARANOID`."""
    end_error: float = 1e-6
    """Largest difference of the two means of the endgame at which its end is known: the error of
    the end is the square of it (`EndgameOptions.samples`), far below `SINGULAR_ERROR`."""
    split: float = 1e-4
    """Two simple solutions are those that a double end stands for if they are not further from it:
    the square root of the error in the values that the endgame leaves, generously."""
    endgame: EndgameOptions = ENDGAME


ACCOUNTS = AccountOptions()
#: Options if the number of solutions is known, so that a lost path is noticed.
COUNTED = AccountOptions(attempts=2)
#: Options for systems with infinitely many solutions: only simple isolated solutions are searched
#: for, and completeness is not claimed.
BESIDE_CURVES = AccountOptions(attempts=2, endgame=EndgameOptions(max_winding=6))


@dataclass(frozen=True, eq=False)
class EndsOnCurve:
    """Ends on a positive-dimensional solution set; as `solve.SolutionCurve`, norm 1."""

    dimension: int
    points: ComplexArray
    motion: ComplexArray
    real: bool


@dataclass(frozen=True, eq=False)
class Endpoints:
    """The ends of all paths of one system; points of norm 1."""

    points: ComplexArray
    multiplicity: NDArray[np.int64]
    condition: FloatArray
    residual: FloatArray
    account: PathAccount
    suspect: bool = False
    """Winding numbers and multiplicities contradict each other."""
    curves: list[EndsOnCurve] = field(default_factory=list)

    @property
    def doubts(self) -> tuple[int, bool]:
        """How many paths are lost, and whether counts contradict each other: less is better."""
        return self.account.lost, self.suspect


@lru_cache(maxsize=256)
def random_start(start: StartSystem, seed: int, attempt: int) -> System:
    """Return the start system with its factors multiplied by random phases: another path."""
    # The import of NumPy's generator takes longer than the solution of most systems.
    draws = Random(f"{seed} {attempt}")
    turns = np.array([[draws.random() for _ in range(EQUATIONS)] for _ in range(2)])
    g, h = np.exp(2j * np.pi * turns)
    return start.system.scaled(g, h)


def all_regular(results: PathResults) -> NDArray[np.bool_]:
    """Return for which targets (B,) all paths end at distinct finite regular solutions."""
    error = regular_error(results.correction)
    good = np.asarray((clearly_simple(results) & ~infinite(results.points, error)).all(axis=1))
    near = may_coincide(results.points, error)[1].any(axis=1)
    for i in np.flatnonzero(good & near):
        good[i] = len(clusters(results.points[i], error[i])) == results.points.shape[1]
    return good


def regular_ends(results: PathResults, i: int) -> Endpoints:
    """Return the ends of the paths to a target for which `all_regular` holds."""
    count = results.points.shape[1]
    return Endpoints(
        results.points[i],
        np.ones(count, dtype=np.int64),
        results.condition[i],
        results.residual[i],
        PathAccount(expected=count, found=count),
    )
