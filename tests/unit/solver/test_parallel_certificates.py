"""Certificates where lines are parallel at some poses only: a plate on posts with a longer foot."""

from __future__ import annotations

import pytest

from gspcli import loads
from gspcli.certification import Outcome
from gspcli.certification import certify as certify_alone
from gspcli.geometry.instance import Instance
from gspcli.solver import SolveResult, certify, solve
from tests.support.posts import PLATE_ON_POSTS

SPEC = PLATE_ON_POSTS.replace("F1: {point: [3, 0, 0]}", "F1: {point: [3, 0, 1]}").replace(
    "{distance: [F1, table], value: 0}", "{distance: [F1, table], value: 1}"
)


@pytest.fixture(scope="module")
def plate() -> Instance:
    return loads(SPEC)


@pytest.fixture(scope="module")
def found(plate: Instance) -> SolveResult:
    return solve(plate)


def test_all_poses_are_certified(plate: Instance, found: SolveResult) -> None:
    alone = certify_alone(plate, found.R, found.T)
    assert any(item.outcome is Outcome.NOT_ISOLATED for item in alone)
    proved = certify(plate, found.R, found.T)
    assert proved.distinct == len(found.R)
    assert proved.real == found.counts.real


def test_no_other_pose_is(plate: Instance, found: SolveResult) -> None:
    moved = certify(plate, found.R, found.T + 1e-3)
    assert moved.certified == 0
    other = loads(SPEC.replace("value: 3/2", "value: 1.501"))
    assert certify(other, found.R, found.T).certified == 0


def test_duplicates_are_told(plate: Instance, found: SolveResult) -> None:
    proved = certify(plate, found.R[[0, 1, 0]], found.T[[0, 1, 0]])
    assert [item.same_as for item in proved] == [None, None, 0]
    assert proved.distinct == 2


def test_refined_digits_are_those_of_the_pose(plate: Instance, found: SolveResult) -> None:
    shaken = certify(plate, found.R, found.T + 1e-9)
    assert shaken.certified == len(found.R)
    for item in shaken:
        # A bound: the error of the solution at 64 bits is part of it.
        assert 1e-9 <= item.deviation * shaken.least_length * (1 + 1e-6) < 1e-7
