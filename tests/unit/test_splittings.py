"""Distances of points and lines that fall into two real quadrics."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gspcli.catalogue.kinds import ALL, DHP, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.geometry.quaternions import pose_from_study
from gspcli.reality.maximize import Search
from gspcli.reality.platforms import Platforms, random_platforms, reduced
from gspcli.reality.solved_platforms import solved
from tools.witnesses.splittings import Splitting, splittings

ANGLES = (ALL, ALL)


@pytest.mark.parametrize(
    "kinds",
    [
        (DPP, DPL, DPH, DHP, *ANGLES),
        (DLP, DHP, DPH, DPP, *ANGLES),
    ],
)
def test_a_carried_constraint_is_exactly_two(kinds: tuple[Kind, ...]) -> None:
    line = next(i for i, kind in enumerate(kinds) if kind in (DPL, DLP))
    carried = [one for one in splittings(kinds) if one.carried and not one.turned]
    assert len(carried) >= 2
    for splitting in carried:
        pattern = splitting.pattern
        rng = np.random.default_rng(5)
        known = pattern.of(reduced(random_platforms(pattern.kinds, 1, rng)))[0]
        gap = 0.3
        value = gap * _sine(splitting, known)
        halves = [_solutions(_with_value(known, line, side)) for side in (value, -value)]
        none = np.eye(3)[None], np.zeros((1, 3))
        whole = _solutions(splitting.lifted(known, *none, gap=gap, reach=1.0, cosine=gap))
        both = np.concatenate(halves)
        # Poses with parallel lines belong to no distance of lines, but to their moment.
        if pattern.kinds[line] is not DLL:
            assert len(whole) == len(both)
        apart = np.abs(whole[:, None] - both).max(axis=-1).min(axis=1)
        assert apart.max() < 1e-6, splitting


def _sine(splitting: Splitting, known: Platforms) -> float:
    """Return the sine of the angle of a plane and the one that carries it, 1 for other carriers."""
    ((line, carriers),) = splitting.carried
    kinds = {splitting.kinds[carriers[-1]], splitting.pattern.kinds[line]}
    if len(kinds) > 1 or len(carriers) > 1:
        return 1.0
    directions = known.v if kinds == {DPH} else known.u
    return float(np.linalg.norm(np.cross(directions[line], directions[carriers[0]])))


def _with_value(platform: Platforms, index: int, value: float) -> Platforms:
    """Return the platform with one plane moved to a distance, or one moment changed by it."""
    kind = platform.kinds[index]
    values, x, y = platform.values.copy(), platform.x.copy(), platform.y.copy()
    if kind is DLL:
        # At right angles the distance of two lines is their moment; both signs are solutions.
        values[index] = abs(value)
    else:
        values[index] = value
    return replace(platform, values=values, x=x, y=y)


def _solutions(platform: Platforms) -> np.ndarray:
    """Return the entries of R and T of all solutions, shape (n, 12)."""
    result = next(platform[None].solutions(3))
    assert result.account.verdict == "complete"
    R, T = pose_from_study(result.points[:, :4], result.points[:, 4:])
    return np.concatenate((R.reshape(-1, 9), T), axis=1)


def test_points_that_turn_multiply_the_real_solutions() -> None:
    kinds = (DPL, DPL, DPL, DPH, DPH, DPH)
    splitting = Splitting(kinds, turned=(0, 1, 2))
    # Three right angles of the axes with themselves: eight rotations, which permute the axes.
    axes, zero = np.concatenate((np.eye(3), np.eye(3))), np.zeros((6, 3))
    y = np.array([[0.0, 0, 0]] * 3 + [[0.2, 0.1, 0], [0, 0.1, 0.3], [-0.1, 0, 0.2]])
    known = Platforms(splitting.pattern.kinds, y, zero, axes, axes, np.zeros(6))
    found = solved(known)
    assert found is not None
    assert found.count == len(found.points) == 8
    R, T = (part.real for part in pose_from_study(found.points[:, :4], found.points[:, 4:]))
    lifted = solved(splitting.lifted(known, R, T, gap=0.1, reach=100.0, cosine=0.1))
    assert lifted is not None
    assert lifted.count == len(lifted.points) == 8 * splitting.factor == 64


def test_steps_stay_in_the_pattern() -> None:
    kinds = (DPP, DPL, DLP, DPH, DHP, ALL)
    splitting = next(one for one in splittings(kinds) if len(one.carried) == 2)
    search = Search(splitting.pattern.kinds, starts=2, steps=6, special=splitting.pattern)
    found = search.attempt(0)
    assert found is not None
    again = splitting.pattern.of(found.platform)
    for part in ("y", "x", "values"):
        assert np.abs(getattr(found.platform, part) - getattr(again, part)).max() < 1e-12


def test_a_type_without_lines_has_nothing_to_split() -> None:
    assert [one.factor for one in splittings((DPP, DPH, DHP, DLL, *ANGLES))] == [1]
