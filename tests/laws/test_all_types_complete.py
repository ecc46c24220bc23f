"""Random platforms of all types are solved completely; what examines them sees what is wrong."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gspcli.catalogue.counts import generic_counts
from gspcli.continuation.paths import PathAccount
from gspcli.defaults import SEED
from gspcli.solver import solve
from tests.support.examination import examine
from tests.support.oracle.poses_by_paths import solve_each_by_tracking
from tests.support.random_platforms import (
    Task,
    families_by_name,
    random_platform,
    shown,
    solved_member,
    solved_platforms,
)

MANY = 256


def test_random_platforms_with_six_dpp_are_solved_completely():
    findings = solved_platforms(Task("chunk 0", 300, SEED))
    assert [finding.problems for finding in findings] == [()] * 300
    assert {finding.found for finding in findings} == {40}


def test_random_platforms_of_every_class_are_solved_completely():
    families = [
        family
        for family in families_by_name().values()
        if generic_counts(family.types[0]).two_sided <= MANY
    ]
    assert len(families) > 200
    for family in families[::3]:
        assert solved_member(Task(family.id, 1, SEED)).problems == (), family.id


@pytest.mark.slow
def test_random_platforms_of_every_family_are_solved_completely():
    for name in families_by_name():
        assert solved_member(Task(name, 1, SEED)).problems == (), name


@pytest.fixture(scope="module")
def solved():
    """A platform with its poses, complex and real, and the real one it was made from."""
    arrangement, hidden = random_platform(np.random.default_rng(5))
    poses = next(solve_each_by_tracking([arrangement], seed=1))
    assert 0 < poses.real.sum() < 40
    return arrangement, poses, hidden


def without(poses, index):
    keep = np.delete(np.arange(len(poses.R)), index)
    arrays = ("R", "T", "real", "multiplicity")
    return replace(poses, **{name: getattr(poses, name)[keep] for name in arrays})


def test_examine_accepts_the_right_answer(solved):
    arrangement, poses, hidden = solved
    finding = examine(arrangement, poses, 40, hidden)
    assert finding.problems == ()
    assert (finding.found, finding.real) == (40, poses.real.sum())


def test_examine_sees_missing_poses(solved):
    arrangement, poses, hidden = solved
    complex_pose = np.flatnonzero(~poses.real)[0]
    problems = examine(arrangement, without(poses, complex_pose), 40, hidden).problems
    assert {"wrong number", "conjugate missing"} <= set(problems)
    flat = np.abs(poses.T - hidden[1]).max(axis=1)
    problems = examine(arrangement, without(poses, flat.argmin()), 40, hidden).problems
    assert {"wrong number", "hidden pose missing"} <= set(problems)


def test_examine_sees_equal_poses(solved):
    arrangement, poses, hidden = solved
    # Instead of one conjugate pair, another one twice.
    first, second = np.flatnonzero(~poses.real)[[0, -1]]
    R, T = poses.R.copy(), poses.T.copy()
    R[first], T[first] = R[second], T[second]
    problems = examine(arrangement, replace(poses, R=R, T=T), 40, hidden).problems
    assert "equal poses" in problems


def test_examine_sees_wrong_poses(solved):
    arrangement, poses, hidden = solved
    problems = examine(arrangement, replace(poses, T=poses.T + 1e-4), 40, hidden).problems
    assert "residual" in problems
    assert "hidden pose missing" in problems


def test_examine_sees_wrong_reality(solved):
    arrangement, poses, hidden = solved
    problems = examine(arrangement, replace(poses, real=~poses.real), 40, hidden).problems
    assert "reality wrong" in problems


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"lost": 1}, "lost paths"),
        ({"at_infinity": 1}, "poses at infinity"),
        ({"on_curves": 1}, "paths on curves"),
        ({"spurious": 1}, "spurious ends"),
    ],
)
def test_examine_reads_the_account(solved, changes, problem):
    arrangement, poses, hidden = solved
    account = PathAccount(expected=40, found=39, **changes)
    other = replace(poses, account=account)
    assert problem in examine(arrangement, other, 40, hidden).problems


def test_examine_sees_multiple_poses(solved):
    arrangement, poses, hidden = solved
    double = replace(poses, multiplicity=np.full(40, 2))
    assert "multiple poses" in examine(arrangement, double, 40, hidden).problems


def test_a_path_that_jumps_among_thousands_is_made_up_for():
    """Of 2560 poses the paths of this seed miss one; other paths find it."""
    instance = shown("6D PL PL LP PH HP LL", 3)
    result = solve(instance, seed=1)
    assert result.verdict == "complete"
    assert result.proof is not None
