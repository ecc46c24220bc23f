"""The search for real solutions: steps, folds, attempts, states, rounding."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import nnls

from gspcli.catalogue.kinds import DHP, DLL, DPH
from gspcli.catalogue.names import parse_type
from gspcli.defaults import SEED
from gspcli.errors import GspError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import AngleUnit, Units
from gspcli.geometry.quaternions import pose_from_study
from gspcli.geometry.shortest_step import nonnegative_least_squares, shortest_step
from gspcli.reality.platforms import Platforms, look_real, multiplier, random_platforms, reduced
from gspcli.reality.real_search import (
    Search,
    Solved,
    State,
    free_numbers,
    moved,
    neighbours,
    read_state,
    solved,
)
from gspcli.reality.witness_proofs import certified_real, platform_of, real_instance
from tests.support.oracle.poses_by_paths import solve_by_tracking

MIXED = "DPP DPL DLP DPH DHP ALL"


def _solved(name: str, seed: int) -> Solved:
    kinds = parse_type(name).kinds
    platforms = reduced(random_platforms(kinds, 1, np.random.default_rng(seed)))
    found = solved(platforms[0])
    assert found is not None
    return found


@pytest.mark.parametrize("seed", range(20))
def test_nonnegative_least_squares_against_scipy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rows, columns = rng.integers(2, 30, size=2)
    matrix, goal = rng.normal(size=(rows, columns)), rng.normal(size=rows)
    ours = nonnegative_least_squares(matrix, goal)
    best, size = nnls(matrix, goal)
    assert (ours >= 0).all()
    assert np.linalg.norm(matrix @ ours - goal) <= size * (1 + 1e-6) + 1e-6
    assert ours.shape == best.shape


def test_shortest_step_satisfies_the_inequalities_and_is_shortest() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        normals = rng.normal(size=(6, 10))
        least = rng.normal(size=6)
        step = shortest_step(normals, least)
        assert step is not None
        assert (normals @ step >= least - 1e-6).all()
        # Optimal: a nonnegative combination of the rows that hold with equality.
        tight = np.abs(normals @ step - least) < 1e-6
        _, rest = nnls(normals[tight].T, step) if tight.any() else (None, np.linalg.norm(step))
        assert rest < 1e-6


def test_no_step_satisfies_contradictory_inequalities() -> None:
    normals = np.array([[1.0, 0.0], [-1.0, 0.0]])
    assert shortest_step(normals, np.array([1.0, 1.0])) is None
    assert np.array_equal(shortest_step(normals, np.array([-1.0, 0.0])), [0, 0])


@pytest.mark.parametrize("name", [MIXED, "DPP DPP DPL DPH DLL ALH"])
def test_folds_agree_with_differences(name: str) -> None:
    found = _solved(name, 8)
    for kind_of_fold in (0, 1):
        fold = found.folds()[kind_of_fold]
        nearest = int(fold.distances.argmin())
        distance, normal = fold.distances[nearest], fold.normals[nearest]
        step = 1e-6 * normal
        ahead, behind = solved(moved(found.platform, step)), solved(moved(found.platform, -step))
        assert ahead is not None
        assert behind is not None
        # Squares of distances, not divided by their gradients: compare logarithms.
        square = [_square(one, kind_of_fold, nearest, found) for one in (behind, ahead)]
        slope = (np.log(square[1]) - np.log(square[0])) / 2e-6
        assert slope == pytest.approx(1 / distance, rel=1e-3)


def _square(other: Solved, kind_of_fold: int, nearest: int, found: Solved) -> float:
    """Return the squared half distance in another platform of the nearest pair of `found`."""
    index = _members(found, kind_of_fold, nearest)
    X = [_entries(one) for one in (found, other)]
    same = [int(np.abs(X[1] - X[0][k]).sum(axis=1).argmin()) for k in index]
    difference = X[1][same[0]] - X[1][same[1]]
    return float((np.abs(difference) ** 2).sum() / 4)


def _entries(found: Solved) -> np.ndarray:
    R, T = pose_from_study(found.points[:, :4], found.points[:, 4:])
    return np.concatenate((R.reshape(-1, 9), T), axis=1)


def _members(found: Solved, kind_of_fold: int, nearest: int) -> list[int]:
    """Return the two solutions of the nearest fold: it is the one with the least distance."""
    X = _entries(found)
    if kind_of_fold:
        first, second = neighbours(X[found.real].real)
        index = np.flatnonzero(found.real)
        return [int(index[first[nearest]]), int(index[second[nearest]])]
    upper = np.flatnonzero(~found.real & (X.imag @ np.sqrt(np.arange(1, 13)) > 0))[nearest]
    return [int(upper), int(np.abs(X - X[upper].conj()).sum(axis=1).argmin())]


def test_reduced_platforms_have_planes_and_lines_at_zero() -> None:
    kinds = parse_type("DPP DPH DHP DLL ALL ALH").kinds
    platforms = random_platforms(kinds, 2, np.random.default_rng(1))
    without = reduced(platforms)
    zero = [kind in (DPH, DHP, DLL) for kind in kinds]
    assert (without.values[:, zero] == 0).all()
    assert multiplier(kinds) == 8
    assert not free_numbers(kinds)[zero, 12].any()
    # Moving planes changes nothing for one choice of sides.
    kinds = parse_type("DPP DPL DPH DHP DHP ALL").kinds
    platforms = random_platforms(kinds, 1, np.random.default_rng(2))
    before, after = (
        np.sort(np.abs(next(one.solutions(1)).points[:, 0]))
        for one in (platforms, reduced(platforms))
    )
    assert before == pytest.approx(after, abs=1e-9)


def test_all_solutions_of_six_planes_become_real() -> None:
    found = Search(parse_type("6PH").kinds).attempt(0)
    assert found is not None
    assert found.count == 8


def test_small_distances_double_the_real_solutions() -> None:
    found = Search(parse_type("3D3A PH HP LL ALL ALH AHH").kinds, steps=20, starts=8).attempt(0)
    assert found is not None
    count = 8 * found.count
    assert certified_real(real_instance(found.platform, count)) == count


def test_an_attempt_depends_on_seed_and_number_only() -> None:
    search = Search(parse_type("4D2A PH PH LL PP ALL ALL").kinds, starts=2, steps=5)
    first, second = search.attempt(1), search.attempt(1)
    assert first is not None
    assert second is not None
    assert np.array_equal(first.platform.y, second.platform.y)
    other = search.attempt(3)
    assert other is not None
    assert not np.array_equal(first.platform.y, other.platform.y)


def test_a_search_never_loses_a_real_solution() -> None:
    start = _solved("6PP", 5)
    search = Search(start.platform.kinds, start=start.platform, steps=15)
    found = search.attempt(0)
    assert found is not None
    assert found.count >= start.count
    assert len(found.points) == 40


def test_a_search_that_is_late_returns_at_once() -> None:
    start = _solved("6PP", 5)
    search = Search(start.platform.kinds, start=start.platform, deadline=0.0)
    found = search.attempt(0)
    assert found is not None
    assert found.count == start.count


def test_rounding_keeps_units_and_size() -> None:
    start = _solved("DPP DPP DPP DPH ALL AHH", 7)
    count = start.count * 2
    units = Units("mm", AngleUnit.RADIAN)
    large = real_instance(start.platform, count, units=units, length=2500.0)
    assert large.units == units
    assert int(solve_by_tracking(Arrangement.of(large), seed=SEED).real.sum()) == count
    platform, length = platform_of(large)
    assert 500 < length < 20_000
    assert np.abs(platform.y).max() <= 1
    assert all(len(str(c.value)) < 12 for c in large.constraints)


def test_a_number_that_no_rounding_has_is_refused() -> None:
    start = _solved("6PP", 5)
    with pytest.raises(GspError, match="no rounding"):
        real_instance(start.platform, start.count + 2)


def test_states_are_read_back(tmp_path: Path) -> None:
    start = _solved("6PP", 5)
    state = State("6PP", 3).after(0, None).after(1, start)
    path = tmp_path / "state.json"
    path.write_text(state.text())
    back = read_state(path, "6PP", 3)
    assert (back.attempts, back.real) == (2, start.count)
    assert isinstance(back.platform, Platforms)
    assert np.array_equal(back.platform.values, start.platform.values)
    worse = replace(start, real=np.zeros_like(start.real))
    assert back.after(2, worse).real == start.count
    assert read_state(tmp_path / "none.json", "6PP", 3).attempts == 0
    with pytest.raises(GspError, match="another seed"):
        read_state(path, "6PP", 4)
    for wrong in ("{}", state.text().replace('"attempts": 2', f'"attempts": {10**400}')):
        path.write_text(wrong)
        with pytest.raises(GspError, match="not a state"):
            read_state(path, "6PP", 3)


def test_what_looks_real_is_no_matter_of_the_norm() -> None:
    found = _solved(MIXED, 3)
    factors = np.exp(1j * np.arange(len(found.points)))[:, None]
    assert look_real(found.points * factors).tolist() == found.real.tolist()
    assert 0 < found.count < len(found.points)
