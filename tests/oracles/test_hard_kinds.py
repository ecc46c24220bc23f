"""Nearly special platforms that are hard: complete, or what is missing is said; nothing is wrong.

The counts are those of msolve and Singular, modulo other primes than those of gsp.
"""

from __future__ import annotations

import re

import pytest

from gspcli.defaults import SEED
from gspcli.solver import solve
from gspcli.solver.solved_starts import SolvedStarts
from gspcli.spec import loads
from tests.support.special.platforms import platform

THREE_GUIDE_RODS = """
gsp: 1
units: {length: m, angle: deg}
platform:
  Y1: {point: [-2, -3, 3]}
  Y2: {point: [3, -3, -2]}
  Y3: {point: [-2, -3, -2]}
  Y4: {point: [1, -1, 4]}
  Y5: {point: [-3, 3, -2]}
  Y6: {point: [-3, -2, -1]}
base:
  X1: {line: {point: [2, -3, 5], direction: [1, 2.00002, 1.99998]}}
  X2: {line: {point: [6, 1, -1], direction: [0.99999, 2.00001, 2]}}
  X3: {line: {point: [-1, 6, -4], direction: [0.99998, 2.00001, 2.00002]}}
  X4: {point: [-4, 1, 4]}
  X5: {point: [-3, -5, -6]}
  X6: {point: [3, -3, -5]}
constraints:
  - {distance: [Y1, X1], value: sqrt(457507800073/33750000003)}
  - {distance: [Y2, X2], value: sqrt(83610144600641/810001800018)}
  - {distance: [Y3, X3], value: sqrt(4490064800485/90000800009)}
  - {distance: [Y4, X4], value: sqrt(62/3)}
  - {distance: [Y5, X5], value: sqrt(115)}
  - {distance: [Y6, X6], value: sqrt(90)}
"""
FOUR_POINTS_ON_A_LINE = """
gsp: 1
units: {length: m, angle: deg}
platform:
  Y1: {point: [0, -4, 0]}
  Y2: {point: [1, -5, -1]}
  Y3: {point: [-2, -2, 2]}
  Y4: {point: [3.0000000001, -6.9999999999, -2.9999999999]}
  Y5: {point: [-1, 1, -4]}
  Y6: {point: [4, 0, 1]}
base:
  X1: {line: {point: [-2, 2, -1], direction: [1, 2, 2]}}
  X2: {point: [6, 5, -5]}
  X3: {point: [0, -1, 1]}
constraints:
  - {distance: [Y1, X1], value: sqrt(6626/225)}
  - {distance: [Y2, X1], value: sqrt(39.04)}
  - {distance: [Y3, X1], value: sqrt(25.04)}
  - {distance: [Y4, X1], value: sqrt(72.9955555533404444444616)}
  - {distance: [Y5, X2], value: sqrt(57)}
  - {distance: [Y6, X3], value: sqrt(28.4)}
"""
TOUCHING_ANGLES = """
gsp: 1
units: {length: m, angle: deg}
platform:
  Y1: {line: {point: [0, 0, 0], direction: [1, 2, 2]}}
  Y2: {line: {point: [0, 0, 0], direction: [2, -1, 2]}}
  Y3: {line: {point: [0, 0, 0], direction: [2, 2, -1]}}
  Y4: {point: [-1, -1, -2]}
base:
  X1: {line: {point: [0, 0, 0], direction: [1/3, 8/3, -4/3]}}
  X2: {line: {point: [0, 0, 0], direction: [-4/3, 7/3, 4/3]}}
  X3: {line: {point: [0, 0, 0], direction: [8/3, 4/3, 1/3]}}
  X4: {point: [-5/3, -25/3, -1/3]}
  X5: {point: [13/3, 2/3, 53/3]}
  X6: {plane: {point: [4/3, -16/3, 17/3], normal: [0, 3, 4]}}
constraints:
  - {angle: [Y1, X1], value: 0}
  - {angle: [Y2, X2], value: 0}
  - {angle: [Y3, X3], value: 0}
  - {distance: [Y4, X4], value: 7}
  - {distance: [Y4, X5], value: sqrt(196.0000000000001)}
  - {distance: [Y4, X6], value: 0, side: positive}
"""
#: The platforms, how many solutions they have, with multiplicity and without.
HARD = {
    "three guide rods parallel up to 1e-5": (THREE_GUIDE_RODS, 320, 320),
    "four points of a body on a line up to 1e-10, with DPL": (FOUR_POINTS_ON_A_LINE, 64, 64),
    "three dependent angles with loci that touch up to 1e-13": (TOUCHING_ANGLES, 16, 2),
}


def check(text, solutions, distinct, seed=SEED):
    """Check that nothing is wrong, and return whether all poses are found."""
    found = solve(loads(text), seed=seed, starts=SolvedStarts())
    assert found.verdict in ("complete", "incomplete")
    assert len(found.R) <= distinct
    assert found.account.found <= solutions
    if found.verdict == "complete":
        assert len(found.R) == distinct
        assert found.account.found == solutions
    else:
        assert found.proof is None
        assert found.account.lost
    return found.verdict == "complete"


@pytest.mark.parametrize("seed", [SEED, *(pytest.param(k, marks=pytest.mark.slow) for k in (1, 2))])
def test_guide_rods_are_complete(seed):
    """Rods are turned apart."""
    assert check(*HARD["three guide rods parallel up to 1e-5"], seed)


@pytest.mark.slow
def test_guide_rods_on_the_platform_are_complete():
    """The same with bodies exchanged: three DLP."""
    text, *counts = HARD["three guide rods parallel up to 1e-5"]
    exchanged = text.translate(str.maketrans("XY", "YX"))
    exchanged = exchanged.replace("platform:", "bodies:").replace("base:", "platform:")
    exchanged = re.sub(r"\[(X\d), (Y\d)\]", r"[\2, \1]", exchanged.replace("bodies:", "base:"))
    assert check(exchanged, *counts)


def test_touching_angles_are_complete():
    """Two poses of eight solutions each are one end for doubles, and two for 32 digits."""
    assert check(*HARD["three dependent angles with loci that touch up to 1e-13"])


@pytest.mark.slow
def test_four_points_on_a_line_are_complete():
    """Poses 1e22 lengths away (six seconds)."""
    assert check(*HARD["four points of a body on a line up to 1e-10, with DPL"])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "poses"),
    [
        # Three parallel lines: paths with 64 digits took a minute (four seconds).
        ("guide-rods/PL-PP-PP-PP/1e-8", 320),
        # Real poses meet where s is real (ten seconds).
        ("points-on-lines/LP-PP-PP/1e-20", 64),
    ],
)
def test_poses_far_away_are_found_from_one_family(name: str, poses: int) -> None:
    found = solve(platform(name).instance, starts=SolvedStarts())
    assert found.verdict == "complete"
    assert len(found.R) == found.certified.sum() == poses
