"""Constraints that are the same leave motions, which are listed and proved; others do not."""

import numpy as np
import pytest

from gspcli import loads, solve
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.residuals import relative_residuals
from gspcli.solver.ledger import Ledger
from gspcli.solver.problem import Problem
from gspcli.solver.results.pose_set import PoseSet
from gspcli.solver.special.infinite_sets import poses_of_repeated

TEXT = """
gsp: 1
units: {{length: m, angle: deg}}
platform: {{{ys}, Z: {{point: [1, 0.2, 0]}}}}
base: {{{xs}, {other}}}
constraints:
{rows}
  - {{distance: [Z, W], value: 2}}
"""
#: A file names equal points apart: a distance of two named points is there once.
YS = ", ".join(f"Y{k}: {{point: [0.1, -0.4, 0.3]}}" for k in range(5))
XS = ", ".join(f"X{k}: {{point: [1.2, 0.3, -0.7]}}" for k in range(5))
OTHERS = {
    "DPP": "W: {point: [0, 1, 2]}",
    "DPH": "W: {plane: {point: [0, 1, 2], normal: [1, 2, 2]}}",
    "DPL": "W: {line: {point: [0, 1, 2], direction: [1, 2, 2]}}",
}


def _platform(kind: str, *values: str) -> Instance:
    rows = (f"  - {{distance: [Y{k}, X{k}], value: {value}}}" for k, value in enumerate(values))
    return loads(TEXT.format(ys=YS, xs=XS, other=OTHERS[kind], rows="\n".join(rows)))


@pytest.mark.parametrize("kind", OTHERS)
def test_five_equal_constraints_leave_a_real_motion(kind: str) -> None:
    instance = _platform(kind, *5 * ["2.25"])
    found = solve(instance)
    assert found.verdict == "infinite"
    assert found.proof is not None
    assert found.proof.error == 0
    motion = next(motion for motion in found.motions if motion.real)
    assert motion.dimension == 4
    sizes = relative_residuals(Arrangement.of(instance), motion.R, motion.T)
    assert np.abs(sizes).max() < 1e-9


def test_other_values_between_the_same_points_are_no_motion() -> None:
    """Five distances of the same two points of which one differs: there is no pose."""
    assert _repeated(_platform("DPP", *4 * ["2.25"], "2.26")) is None


def test_six_different_constraints_are_left_to_counts() -> None:
    assert _repeated(_platform("DPP", "2.1", "2.2", "2.3", "2.4", "2.5")) is None


def _repeated(instance: Instance) -> PoseSet | None:
    problem = Problem(instance)
    return poses_of_repeated(problem, Ledger(problem))
