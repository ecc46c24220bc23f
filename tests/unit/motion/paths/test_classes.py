"""Signs that regular paths keep."""

from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.motion.paths.classes import Classes
from gspcli.motion.paths.pose_ways import PoseWays
from tests.unit.motion.paths.test_pose_ways import ways_of

#: What the factors of some platforms are of.
FACTORS = {
    "platform-6-6": [],
    "sdss-primary": [((0, 1, 2), "one direction of the base")],
    "surfaces-sss": [((3, 4, 5), "angles")],
    "fixture-3-2-1": [((0, 1, 2), "one direction of the platform")],
    "figure-4": [((3, 4, 5), "angles"), ((0, 1, 2), "one point of the platform")],
}


@pytest.mark.parametrize("name", FACTORS)
def test_factors_are_found(name):
    instance = gspcli.example(name)
    classes = Classes(instance, PoseWays(instance, limits=False))
    found = {(one.constraints, one.space) for one in classes.factors}
    expected = set(FACTORS[name])
    if name == "sdss-primary":
        # Which of its planes are parallel the file says.
        assert [len(one.constraints) for one in classes.factors] == [3]
    else:
        assert expected <= found
    assert bool(found) == bool(expected)


@pytest.mark.parametrize(
    "name",
    ["sdss-primary", "surfaces-sss", "surfaces-scc", "fixture-3-2-1", "figure-2", "figure-4"],
)
def test_a_proved_way_keeps_all_signs(name):
    """The proof of ways knows nothing of factors."""
    ways, modes = ways_of(name, limits=False)
    classes = Classes(ways.instance, ways)
    draw = np.random.default_rng(4)
    proved, seen = 0, set()
    for k in range(80):
        begin = modes[k % len(modes)]
        end = begin + draw.normal(size=6) * ways.sizes * 10.0 ** -draw.integers(0, 3)
        first, last = (classes.of(*ways.poses(one)) for one in (begin, end))
        seen.add(first.signs)
        if ways.prove(begin, end).sign:
            proved += 1
            assert first.differs(last) is None
            assert first.signs == last.signs
    assert proved > 10
    assert len(seen) == 4


def test_an_unknown_sign_differs_from_none():
    instance = gspcli.example("surfaces-sss")
    classes = Classes(instance, PoseWays(instance, limits=False))
    R, T = np.eye(3), np.zeros(3)
    at = classes.of(R, T)
    unknown = type(at)((0, 0))
    assert unknown.text == "??"
    assert at.differs(unknown) is None
    assert type(at)((1, -1)).differs(type(at)((1, 1))) == 1
    assert type(at)((1, -1)).differs(type(at)((-1, 1))) == 0
