"""Verify that `solve` finds each pose again from what it measures, for all types, and record it.

    python -m tools.verify.round_trips [--types N] [--jobs 2] [--work FOLDER] [--check [--sample N]]

For each of the 3850 types the values of a random platform are measured at a random pose
(`gspcli.motion.measure`). The platform with these values is solved with the sides of planes on
which the pose is, and, if the type has planes, again with both sides. What must hold each time: the
set is complete, proved or not as recorded, and the pose is among the real ones, within rounding. If
not, the exit code is 1. The record has a line for each type, with the numbers of real poses:
``data/verification/round-trips.csv``. Interrupted, the same command takes the work up again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gspcli.catalogue.types import all_types, type_by_number
from gspcli.defaults import SEED
from gspcli.geometry.instance import Instance, Side
from gspcli.geometry.numbers import Number
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import measure
from gspcli.solver import SolveResult, solve
from tools.recording import ROOT, csv_text, sampled
from tools.verify.campaigns import TaskRow, conclude, exit_after, options, results

RECORD = ROOT / "data" / "verification" / "round-trips.csv"
#: How far from the pose the nearest one may be; a thousandth of this times its condition number.
EXACT = 1e-9


@dataclass(frozen=True)
class Found:
    """One solution set.

    Attributes
    ----------
    real
        The number of real poses.
    complete, proved
        The statement about the set.
    met
        Whether the pose that was measured is one of them.
    """

    real: int
    complete: bool
    proved: bool
    met: bool


@dataclass
class RoundTrip(TaskRow):
    """What came back for a type: with the sides of the pose, and with both."""

    number: int
    one_sided: Found
    two_sided: Found | None

    @classmethod
    def of_entry(cls, entry: Mapping[str, Any]) -> RoundTrip:
        """Return what a line of the work file stands for."""
        one, two = entry["one_sided"], entry["two_sided"]
        return cls(entry["number"], Found(**one), None if two is None else Found(**two))

    @property
    def holds(self) -> bool:
        """Whether the pose came back each time, from a complete set."""
        sets = [found for found in (self.one_sided, self.two_sided) if found is not None]
        return all(found.complete and found.met for found in sets)

    @property
    def row(self) -> dict[str, object]:
        """Its row of the record."""
        row: dict[str, object] = {"number": self.number, "id": type_by_number(self.number).id}
        for name, found in (("one_sided", self.one_sided), ("two_sided", self.two_sided)):
            for key in ("real", "complete", "proved", "met"):
                row[f"{name}_{key}"] = "" if found is None else int(getattr(found, key))
        return row


def examine(number: int) -> RoundTrip:
    """Measure a random pose of a random platform of a type, and solve."""
    rng = np.random.default_rng((SEED, number))
    instance = random_instance(type_by_number(number), rng)[0]
    R, T = rotation_from_quaternion(rng.normal(size=4)), rng.uniform(-1, 1, size=3)
    values = measure(instance, R, T).tolist()
    sides = [
        (Side.NEGATIVE if value < 0 else Side.POSITIVE) if constraint.kind.has_sides else Side.BOTH
        for constraint, value in zip(instance.constraints, values, strict=True)
    ]
    both = [Side.BOTH] * len(sides)
    return RoundTrip(
        number,
        solved(instance, values, sides, R, T),
        solved(instance, values, both, R, T) if sides != both else None,
    )


def solved(
    instance: Instance,
    values: Sequence[float],
    sides: Sequence[Side],
    R: np.ndarray,
    T: np.ndarray,
) -> Found:
    """Solve a platform for measured values, and look for a pose among the real ones."""
    constraints = [
        replace(row, value=Number.of(repr(abs(value) if row.kind.has_sides else value)), side=side)
        for row, value, side in zip(instance.constraints, values, sides, strict=True)
    ]
    result = solve(replace(instance, constraints=tuple(constraints)))
    return Found(
        int(result.real.sum()),
        result.verdict == "complete",
        result.proof is not None,
        met(result, R, T),
    )


def met(result: SolveResult, R: np.ndarray, T: np.ndarray) -> bool:
    """Return whether a pose is a real one of a result, as exactly as its condition allows."""
    real = result.real
    errors = np.abs(result.R[real].real - R).max(axis=(1, 2))
    errors = np.maximum(errors, np.abs(result.T[real].real - T).max(axis=1))
    return bool((errors < EXACT * np.maximum(1.0, 1e-3 * result.conditions[real])).any())


def main() -> int:
    """Measure and solve, compare or write; return the exit code."""
    parser = options(__doc__)
    parser.add_argument("--types", type=int, default=3850, help="how many types, evenly spread")
    arguments = parser.parse_args()
    every = [gsp_type.number for gsp_type in all_types()]
    chosen = [every[k * len(every) // arguments.types] for k in range(arguments.types)]
    numbers = sampled(chosen, arguments.sample if arguments.check else None)
    done = results(
        numbers,
        examine,
        RoundTrip.of_entry,
        arguments,
        name="round-trips",
        label="measuring and solving",
    )
    twice = sum(trip.two_sided is not None for trip in done)
    summary = f"{len(done)} poses of {len(done)} types found again, {twice} also on both sides"
    wrong = [f"{trip.row}" for trip in done if not trip.holds]
    text = csv_text([trip.row for trip in done])
    return conclude(RECORD, text, wrong, summary, check=arguments.check)


if __name__ == "__main__":
    exit_after(main)
