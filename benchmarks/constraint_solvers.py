"""Times for authors of constraint solvers: `python -m benchmarks.constraint_solvers`.

Processor times in one process, medians, the columns in turns. Beside them what a numerical solver
does: Newton's method with NumPy from a pose next to one solution, until it stays there.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from statistics import median

import numpy as np

from benchmarks.cases import random_instances
from benchmarks.markdown import duration, number, table
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.measurement import jacobian, measured
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.reality.contradiction import contradiction
from gspcli.resources import data_path
from gspcli.solver import solve, solve_batch
from gspcli.solver.solved_starts import SolvedStarts
from gspcli.spec import load

SEED = 2003
TYPES = ("6PH", "PL PL LP 3ALL", "PP PL LP PH ALL AHH", "6PP", "5PP PL", "6PL")
_ROUNDS = 5
_BATCH = 40
#: How far from the solution Newton's method begins, in radians and lengths of the platform.
_BESIDE = 0.05


class Timed:
    """A platform whose geometry has been solved once, and what is timed of it."""

    def __init__(self, type_text: str) -> None:
        self.type_text = type_text
        self.instance: Instance = next(random_instances(type_text, SEED))
        self.starts = SolvedStarts()
        self.found = solve(self.instance, starts=self.starts)
        arrangement = Arrangement.of(self.instance)
        self._R, self._T = self.found.R[0].real, self.found.T[0].real
        # The same sides, so that the poses are of the same kind.
        factors = 1 + 0.02 * np.random.default_rng(SEED).standard_normal((_BATCH, 6))
        self._values = arrangement.values * factors

    def first(self) -> None:
        """Solve as if nothing had been solved before."""
        solve(self.instance, starts=SolvedStarts())

    def batch(self) -> None:
        """Solve other values of the same geometry."""
        solve_batch(self.instance, self._values, starts=self.starts)

    def newton(self) -> None:
        """Find one pose by Newton's method from another one beside it."""
        arrangement = Arrangement.of(self.instance)
        wanted = measured(arrangement, self._R, self._T)
        R = rotation_from_vector(np.full(3, _BESIDE)) @ self._R
        T = self._T + _BESIDE
        for _ in range(20):
            step = np.linalg.solve(
                jacobian(arrangement, R, T), wanted - measured(arrangement, R, T)
            )
            R, T = rotation_from_vector(step[:3]) @ R, T + step[3:]
            if np.abs(step).max() < 1e-10:
                return
        message = f"{self.type_text}: Newton's method does not end"
        raise RuntimeError(message)


def seconds(run: Callable[[], object]) -> float:
    """Return the processor time of a run."""
    began = time.process_time()
    run()
    return time.process_time() - began


def section() -> str:
    """Return the table and how to read it."""
    rows = []
    for case in map(Timed, TYPES):
        runs = (case.first, case.batch, case.newton)
        for run in runs:
            run()
        turns = [[seconds(run) for run in runs] for _ in range(_ROUNDS)]
        first, batch, newton = map(median, zip(*turns, strict=True))
        batch /= _BATCH
        rows.append(
            [
                case.type_text,
                str(case.found.expected),
                duration(first),
                f"{duration(batch)} ({number(first / batch)}× quicker)",
                f"{number(batch / newton)}×",
            ]
        )
    heading = ["constraints", "solutions", "all, a new geometry", "all, other values"]
    heading += ["that over one Newton"]
    impossible = solve(load(data_path("examples", "no-real-pose.yaml"))).arrangement
    each = median(seconds(lambda: contradiction(impossible)) for _ in range(_ROUNDS))
    return _TEXT + table(heading, rows) + _CONTRADICTION.format(each=duration(each))


_TEXT = """\
The platforms are one random platform of each type, with the sides of planes chosen. *All*
solutions are found, and each is proved. The times are processor times of one machine. On other
machines only the ratios are similar. *Other values*: the same geometry with other values, as
while a dimension is dragged, in a batch of 40. The last column is the ratio of this time to the
time of Newton's method in NumPy for *one* solution, from a pose near it; most of that time is
overhead of Python. `python -m benchmarks.constraint_solvers` measures all of it.

"""
_CONTRADICTION = """
After the shipped `no-real-pose` is solved, `contradiction` takes {each}.
"""


def main() -> int:
    """Print the times."""
    argparse.ArgumentParser(
        prog="python -m benchmarks.constraint_solvers", description=__doc__
    ).parse_args()
    sys.stdout.write(section())
    return 0


if __name__ == "__main__":
    sys.exit(main())
