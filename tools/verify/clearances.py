"""Measure how far the bounds of clearances are apart, on random hexapods, and record it.

    python -m tools.verify.clearances [--count 20] [--jobs 2] [--check [--sample N]]

Each random 6-6 platform (sizes and values of order one) has a pose from which it is made. Its
clearances are bounded from below with proof, and from above by the nearest fold or singular pose
found, first quickly, then refined. They are those of the values
(`gspcli.motion.singularities.clearances`) and of the pose
(`gspcli.motion.singularities.pose_clearances`). What must hold: the lower bound is positive and not
above the upper one, refining makes neither worse, the medians of the ratios are at most 4 and 2.
Among many random poses within the refined lower bound of each the determinant of the Jacobian
matrix, computed apart, must have one sign. The record is ``data/verification/clearances.csv``.
"""

from __future__ import annotations

import sys
from dataclasses import asdict, dataclass
from statistics import median

import numpy as np

from gspcli.catalogue.names import parse_type
from gspcli.defaults import SEED
from gspcli.geometry.random_instances import random_instance
from gspcli.motion.singularities.clearances import clearance
from gspcli.motion.singularities.pose_clearances import Displacements, pose_clearance
from tools.recording import ROOT, add_workers, csv_text, parser, sampled, workers_of
from tools.verify.campaigns import conclude

RECORD = ROOT / "data" / "verification" / "clearances.csv"
#: The most that medians of the ratios may be: at once, refined.
MOST = (4.0, 2.0)
OF = ("values", "pose")
#: Random poses within each refined clearance of a pose.
SAMPLES = 100_000


@dataclass(frozen=True)
class Row:
    """The bounds of one platform, of its values or its pose."""

    of: str
    number: int
    lower: float
    upper: float
    refined_lower: float
    refined_upper: float

    @property
    def ratios(self) -> tuple[float, float]:
        """Upper bound by lower bound, at once and refined."""
        return self.upper / self.lower, self.refined_upper / self.refined_lower

    @property
    def holds(self) -> bool:
        """Whether the bounds are in order."""
        return (
            0 < self.lower <= self.refined_lower <= self.refined_upper <= self.upper < float("inf")
        )


def examine(key: tuple[str, int]) -> tuple[Row, bool]:
    """Bound a clearance of a random platform; also whether all samples within have one sign."""
    of, number = key
    rng = np.random.default_rng((SEED, number))
    instance, (R, T) = random_instance(parse_type("6PP"), rng)
    find = clearance if of == "values" else pose_clearance
    once, refined = (find(instance, R, T, refine=refine) for refine in (False, True))
    # Four digits: the last ones depend on the processor.
    bounds = (once.lower, once.upper, refined.lower, refined.upper)
    row = Row(of, number, *(float(f"{bound:.4g}") for bound in bounds))
    return row, of == "values" or one_sign(Displacements(instance, R[None], T[None]), refined.lower)


def one_sign(home: Displacements, size: float) -> bool:
    """Return whether determinants at random poses within a distance have one sign."""
    s = np.random.default_rng(SEED).normal(size=(SAMPLES, 6))
    lengths = size * np.random.default_rng(SEED + 1).uniform(size=SAMPLES) ** (1 / 6)
    s *= (lengths / np.linalg.norm(s, axis=1))[:, None]
    return len(set(np.sign(home.determinants(s)).tolist())) == 1


def main() -> int:
    """Measure, compare or write; return the exit code."""
    options = parser(__doc__, sample=True)
    options.add_argument("--count", type=int, default=20, help="how many platforms")
    add_workers(options)
    arguments = options.parse_args()
    numbers = sampled(range(arguments.count), arguments.sample if arguments.check else None)
    keys = [(of, number) for of in OF for number in numbers]
    examined = list(workers_of(arguments).in_order(examine, keys))
    rows = [row for row, _ in examined]
    wrong = [str(row) for row in rows if not row.holds]
    wrong += [f"{row}: the determinant changes its sign within" for row, one in examined if not one]
    parts = []
    for of in OF:
        medians = [median(row.ratios[k] for row in rows if row.of == of) for k in (0, 1)]
        parts.append(f"of the {of} {medians[0]:.2f} at once, {medians[1]:.2f} refined")
        if len(numbers) == arguments.count and any(
            a > b for a, b in zip(medians, MOST, strict=True)
        ):
            wrong.append(f"of the {of}: the medians are above {MOST}")
    summary = f"{len(numbers)} platforms: median ratio " + "; ".join(parts)
    text = csv_text(list(map(asdict, rows)))
    return conclude(RECORD, text, wrong, summary, check=arguments.check)


if __name__ == "__main__":
    sys.exit(main())
