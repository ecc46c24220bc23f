"""A sample of what `make verify-solve` verifies, and that its checks see what is wrong."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np
import pytest

from gspcli.atlas.journal import Journal
from gspcli.catalogue.counts import generic_counts
from gspcli.continuation.paths import PathAccount
from gspcli.defaults import SEED
from gspcli.solver import solve

MANY = 256


@pytest.fixture(scope="module")
def tool(load_tool):
    return load_tool("verify.solve")


def test_random_platforms_with_six_dpp_are_solved_completely(tool):
    findings = tool.verify_platforms(tool.Task("chunk 0", 300, SEED)).findings
    assert [finding.problems for finding in findings] == [()] * 300
    assert {finding.found for finding in findings} == {40}


def test_random_platforms_of_every_class_are_solved_completely(tool):
    families = [
        family
        for family in tool.families_by_name().values()
        if generic_counts(family.types[0]).two_sided <= MANY
    ]
    assert len(families) > 200
    for family in families[::3]:
        (finding,) = tool.verify_family(tool.Task(family.id, 1, SEED)).findings
        assert finding.problems == (), family.id


@pytest.fixture(scope="module")
def solved(tool):
    """A platform with its poses, complex and real, and the real one it was made from."""
    arrangement, hidden = tool.random_platform(np.random.default_rng(5))
    poses = next(tool.solve_each_by_tracking([arrangement], seed=1))
    assert 0 < poses.real.sum() < 40
    return arrangement, poses, hidden


def without(poses, index):
    keep = np.delete(np.arange(len(poses.R)), index)
    arrays = ("R", "T", "real", "multiplicity")
    return replace(poses, **{name: getattr(poses, name)[keep] for name in arrays})


def test_examine_accepts_the_right_answer(tool, solved):
    arrangement, poses, hidden = solved
    finding = tool.examine(arrangement, poses, 40, hidden)
    assert finding.problems == ()
    assert (finding.found, finding.real) == (40, poses.real.sum())


def test_examine_sees_missing_poses(tool, solved):
    arrangement, poses, hidden = solved
    complex_pose = np.flatnonzero(~poses.real)[0]
    problems = tool.examine(arrangement, without(poses, complex_pose), 40, hidden).problems
    assert {"wrong number", "conjugate missing"} <= set(problems)
    flat = np.abs(poses.T - hidden[1]).max(axis=1)
    problems = tool.examine(arrangement, without(poses, flat.argmin()), 40, hidden).problems
    assert {"wrong number", "hidden pose missing"} <= set(problems)


def test_examine_sees_equal_poses(tool, solved):
    arrangement, poses, hidden = solved
    # Instead of one conjugate pair, another one twice.
    first, second = np.flatnonzero(~poses.real)[[0, -1]]
    R, T = poses.R.copy(), poses.T.copy()
    R[first], T[first] = R[second], T[second]
    problems = tool.examine(arrangement, replace(poses, R=R, T=T), 40, hidden).problems
    assert "equal poses" in problems


def test_examine_sees_wrong_poses(tool, solved):
    arrangement, poses, hidden = solved
    problems = tool.examine(arrangement, replace(poses, T=poses.T + 1e-4), 40, hidden).problems
    assert "residual" in problems
    assert "hidden pose missing" in problems


def test_examine_sees_wrong_reality(tool, solved):
    arrangement, poses, hidden = solved
    problems = tool.examine(arrangement, replace(poses, real=~poses.real), 40, hidden).problems
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
def test_examine_reads_the_account(tool, solved, changes, problem):
    arrangement, poses, hidden = solved
    account = PathAccount(expected=40, found=39, **changes)
    other = replace(poses, account=account)
    assert problem in tool.examine(arrangement, other, 40, hidden).problems


def test_examine_sees_multiple_poses(tool, solved):
    arrangement, poses, hidden = solved
    double = replace(poses, multiplicity=np.full(40, 2))
    assert "multiple poses" in tool.examine(arrangement, double, 40, hidden).problems


def test_the_journal_gives_back_what_was_found(tool, tmp_path):
    finding = tool.Finding(40, 39, 2, 1e-15, 1e-3, 1e-15, ("wrong number",))
    done = tool.Examined(tool.Task("chunk 0", 1, SEED), (finding,))
    with Journal.opened(tmp_path / "journal.jsonl") as journal:
        journal.append(asdict(done))
        assert journal.read(tool.Examined.of_entry) == [done]
    assert done.problems == [(0, finding)]


def test_the_record_of_a_chunk_is_derived_again(tool):
    task = tool.platform_tasks(100_000)[3]
    done = tool.verify_platforms(task)
    assert list(tool.differences("platforms-6-6", [done], whole=False)) == []
    # A real pose less in one platform, and rounding errors.
    first, *others = done.findings
    changed = replace(done, findings=(replace(first, real=first.real - 2, residual=1e-9), *others))
    (difference,) = tool.differences("platforms-6-6", [changed], whole=False)
    assert difference.startswith("platforms-6-6, chunk 3: real ")
    missing = list(tool.differences("platforms-6-6", [done], whole=True))
    assert len({line.split(":")[0] for line in missing}) == 199


def test_a_record_that_is_not_the_manifests_is_seen(load_tool, tmp_path, monkeypatch):
    tool = load_tool("verify.solve_record")
    for path in tool.RECORDS.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    monkeypatch.setattr(tool, "RECORDS", tmp_path)
    assert list(tool.differences("families", [], whole=False)) == []
    record = tmp_path / "families.csv"
    record.write_text(record.read_text().replace(",40,", ",41,", 1))
    (difference,) = tool.differences("families", [], whole=False)
    assert "not the file of the manifest" in difference


def test_a_path_that_jumps_among_thousands_is_made_up_for(tool):
    """Of 2560 poses the paths of this seed miss one; other paths find it."""
    instance = tool.shown("6D PL PL LP PH HP LL", 3)
    result = solve(instance, seed=1)
    assert result.verdict == "complete"
    assert result.proof is not None
