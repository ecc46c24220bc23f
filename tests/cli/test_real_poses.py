"""Commands that need one real pose number them as `gsp solve` does, on special platforms too."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.cli.pose_options import real_poses
from gspcli.errors import GspError
from gspcli.solver import solve
from tests.support.special.platforms import platforms, recorded

#: Of a platform whose lines touch there was a second mode that met no constraint.
TOUCHING = "line-pairs/2/parallel-touching"
#: This many platforms of the corpus, those with the fewest solutions, one for each group.
COUNT = 12


def _sample() -> list[str]:
    finite = [(int(row["count"]), name) for name, row in recorded().items() if row["count"]]
    by_group: dict[str, str] = {}
    for _, name in sorted(finite):
        by_group.setdefault(name.split("/")[0], name)
    return [*list(by_group.values())[:COUNT], TOUCHING]


@pytest.fixture(scope="module")
def corpus():
    groups = dict.fromkeys(name.split("/")[0] for name in _sample())
    return {platform.id: platform.instance for platform in platforms(groups)}


@pytest.mark.parametrize("name", _sample())
def test_modes_are_those_of_solve(name: str, corpus) -> None:
    result = solve(corpus[name])
    real = recorded()[name]["real"]
    assert result.counts.real == int(real or result.counts.real)
    if not result.counts.real or result.verdict != "complete":
        with pytest.raises(GspError):
            real_poses(corpus[name])
        return
    R, T = real_poses(corpus[name])
    np.testing.assert_array_equal(R, result.R[result.real].real)
    np.testing.assert_array_equal(T, result.T[result.real].real)


def test_lines_that_touch_have_one_mode(corpus) -> None:
    assert len(real_poses(corpus[TOUCHING])[0]) == 1
