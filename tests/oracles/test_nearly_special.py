"""Special and nearly special platforms against exact counts (special-platforms.yaml)."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.certification import certify
from gspcli.defaults import SEED
from gspcli.geometry.instance import Side
from gspcli.solver import solve
from gspcli.solver.solved_starts import SolvedStarts
from tests.support.special import answers, candidates, rows
from tests.support.special.platforms import platform, platforms, recorded

SAMPLE = {
    "hexagons": ["shape-1/straight/6-places", "shape-2/turned/9-places"],
    "plates": ["hexagon/1e-2/1", "hexagon/1e-9/2"],
    "joints": ["3-3/spatial/1e-2", "3-3/planar/1e-7", "6-4/spatial/1e-12", "6-3/planar/exact"],
    "bodies": ["congruent/1e-5", "similar-plates/1e-7", "congruent/exact"],
    "double": ["axis-1/exact", "axis-1/+1e-14", "axis-2/-1e-14"],
    # Poses at 1e12 and at 1e25 lengths.
    "parallels": ["DPH-1/1e-8", "DLL-2/1e-12", "DPL-1/1e-12"],
    "line-pairs": ["1/parallel", "1/1e-9"],
    "couplings": ["vees-1/one/1e-9", "vees-2/one/exact"],
    "dependent": ["1/1e-12"],
    "tangent": ["cylinders-52/-1e-10", "cylinders-52/+1e-12", "cylinders-41/+1e-12"],
}


@pytest.mark.parametrize("group", SAMPLE)
def test_nearly_special_platforms_are_what_they_are(group: str) -> None:
    chosen = [platform(f"{group}/{name}") for name in SAMPLE[group]]
    exact = recorded()
    for one in chosen:
        _, found, failure = answers.answers(one, 1)
        assert not failure
        assert [answers.judged(answer, exact[one.id]) for answer in found] == ["right"]
        assert found[0].proof != "none"


@pytest.mark.parametrize(
    ("name", "seed", "poses"),
    [
        # From where one of the paths is in doubles Newton's method leads to the pose of another.
        ("angles/5/1e-10", SEED, 128),
        # One of the paths jumps.
        ("mixtures/64/PP-PP-PP-PP-HP-LL", 20034, 160),
    ],
)
def test_a_pose_that_one_path_missed_is_found_by_following_paths(
    name: str, seed: int, poses: int, monkeypatch
) -> None:
    def eliminated(*_: object) -> None:
        raise AssertionError

    monkeypatch.setattr("gspcli.solver.further._eliminate", eliminated)
    found = solve(platform(name).instance, seed=seed)
    assert found.verdict == "complete"
    assert len(found.R) == found.certified.sum() == poses


@pytest.mark.parametrize(
    "seed", [SEED, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 20))]
)
def test_poses_next_to_conjugates_of_others_are_found(seed: int) -> None:
    """Of 304 poses 64 are within 3e-5 of another one: its conjugate is no conjugate of theirs."""
    found = solve(platform("parallels/DLL-1/1e-6").instance, seed=seed, starts=SolvedStarts())
    assert found.verdict == "complete"
    assert len(found.R) == found.certified.sum() == 304


@pytest.mark.parametrize("digits", [12, 16])
def test_two_poses_beside_parallel_lines_are_found_with_32_digits(digits: int) -> None:
    """Paths to them turn 1e-24 or 1e-32 before their ends: squares of their series overflow."""
    solved = solve(platform(f"line-pairs/2/1e-{digits}").instance)
    assert (solved.verdict, len(solved.R), int(solved.real.sum())) == ("complete", 208, 6)


def test_nothing_said_depends_on_the_seed() -> None:
    chosen = [
        platform(name)
        for name in ("double/axis-2/-1e-14", "line-pairs/1/1e-9", "joints/6-4/spatial/1e-12")
    ]
    for one in chosen:
        _, found, failure = answers.answers(one, 4)
        assert not failure
        said = {(a.verdict, a.found, a.multiple, a.real, a.certified) for a in found}
        assert len(said) == 1


@pytest.mark.parametrize(
    "prefix",
    [
        # Shared with special values in one batch: double poses split by 1e-14, planes in contact.
        "double/axis-1/",
        "couplings/vees-1/one/",
        "degrees/1/60,60,60/",
        "zero/1/",
        "line-pairs/1/1e-9",
    ],
)
def test_batches_with_special_values_say_nothing_wrong(prefix: str) -> None:
    chosen = [p for p in platforms([prefix.partition("/")[0]]) if p.id.startswith(prefix)]
    for geometry in rows.geometries(chosen)[:1]:
        _, remarks = rows.attacked(geometry)
        assert len(remarks) >= len(geometry) + 3
        assert {verdict for _, verdict, _ in remarks} == {"right"}


@pytest.mark.parametrize(
    "name",
    [
        # Complex poses at 4e8 lengths, whose doubles hardly say on which side of a plane they are.
        "parallels/DPH-1/1e-4",
        "parallels/DHP-1/1e-4",
        # N is a negative number, and the quaternion of the conjugate was none.
        "published/rubin-camera-hexapod/pose-1/exact",
        "couplings/vees-1/one/1e-6",
        "double-mixed/PL-PH-PP-PP-PP-PP/+1e-8",
        # Two real poses that doubles do not separate.
        "at-zero/PP-PP-PP-PP-HP-HP/home/1e-14",
    ],
)
def test_certify_takes_what_solve_prints_and_nothing_wrong(name: str) -> None:
    _, remarks = candidates.attacked(platform(name))
    assert len(remarks) > 60
    assert {verdict for _, verdict, _ in remarks} <= set(candidates.HONEST)
    assert [verdict for what, verdict, _ in remarks if what.endswith("as printed")] == ["right"] * 2


def test_two_poses_that_doubles_do_not_tell_apart_are_not_called_one() -> None:
    """With the base 6e7 away T has 8 digits less than two poses 3e-10 apart need."""
    _, remarks = candidates.attacked(platform("zero/1/1e-10"))
    assert {verdict for _, verdict, _ in remarks} <= set(candidates.HONEST)
    [said] = [said for what, _, said in remarks if what == "base far away, as printed"]
    assert "'same_as': None, 'unresolved': [2]}, exit 4" in said


def test_a_side_that_doubles_do_not_tell_is_not_contradicted() -> None:
    """T of 3e12 lengths is written to 1e-4; solutions on other sides are 3e-7 apart."""
    instance = platform("parallels/DHP-1/1e-6").instance
    solved = solve(instance)
    names = {Side.POSITIVE: 1, Side.NEGATIVE: -1, None: 0}
    found = certify(instance, solved.R, solved.T, sides=solved.sides)
    open_ = np.array([item.sides is None for item in found])
    # How many are open depends on the last digits of T.
    assert (np.abs(solved.T[open_]).max(axis=1) > 1e12).all()
    told = [[names[side] for side in item.sides] for item in found if item.sides is not None]
    assert told == solved.sides[~open_].tolist()
    # What is said otherwise of poses that doubles tell stands against what is proved.
    wrong = certify(instance, solved.R, solved.T, sides=-solved.sides)
    near = np.flatnonzero(np.abs(solved.T).max(axis=1) < 1e9)
    assert len(near) > 100
    assert all(wrong[i].sides == found[i].sides for i in near)


def test_residuals_of_lines_next_to_parallel_are_as_small_as_doubles_allow() -> None:
    for digits in (4, 7, 10):
        solved = solve(platform(f"line-pairs/1/1e-{digits}").instance)
        assert solved.certified.all()
        assert solved.residuals.max() < max(1e-9, 1e-15 * 10**digits)
