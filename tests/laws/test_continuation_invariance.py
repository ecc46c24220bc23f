"""The solutions do not depend on the seed, the order of equations, units, frames or the swap."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gspcli.continuation.quadrics import (
    BASES,
    monomials,
    random_quadrics,
    swap_letters,
    swap_points,
    swap_quadrics,
)
from gspcli.continuation.systems import Structure, System
from tests.support.systems import solve_system

SEEDS = st.integers(0, 2**32 - 1)


def real_system(spaces: str, rng: np.random.Generator) -> System:
    """Random real quadrics through a random real Study point."""
    e, f = rng.standard_normal((2, 4))
    values = monomials(np.r_[e, f - e * (e @ f) / (e @ e)])
    rows = []
    for letter in spaces:
        row = rng.standard_normal(len(BASES[letter])) @ BASES[letter]
        rows.append(row - (row @ values) / (BASES["a"][0] @ values) * BASES["a"][0])
    return System.of(Structure(spaces), rows)


def in_order(target: System, order: np.ndarray) -> System:
    """The same quadrics in another order."""
    spaces = "".join(target.structure.spaces[i] for i in order)
    return System.of(Structure(spaces), target.coefficients.g[order])


def match(a: np.ndarray, b: np.ndarray) -> None:
    """Assert that two sets of points are the same up to factors."""
    assert len(a) == len(b)
    a, b = (x / np.linalg.norm(x, axis=1, keepdims=True) for x in (a, b))
    inner = np.abs(a.conj() @ b.T)
    assert sorted(inner.argmax(axis=1)) == list(range(len(b)))
    assert inner.max(axis=1).min() > 1 - 1e-9


@settings(max_examples=8)
@given(seed=SEEDS, spaces=st.sampled_from(["ssssss", "apqlss", "pppqqs", "aallsp"]))
def test_seed_and_order(seed, spaces):
    rng = np.random.default_rng(seed)
    target = real_system(spaces, rng)
    solutions = solve_system(target)
    assert solutions.account.verdict == "complete"
    again = solve_system(in_order(target, rng.permutation(6)), seed=seed)
    match(solutions.points, again.points)


@settings(max_examples=8)
@given(seed=SEEDS, spaces=st.sampled_from(["ssssss", "aplsss", "pppqss", "aaqlsp"]))
def test_swap(seed, spaces):
    target = real_system(spaces, np.random.default_rng(seed))
    swapped = System.of(Structure(swap_letters(spaces)), swap_quadrics(target.coefficients.g))
    match(solve_system(target).points, swap_points(solve_system(swapped).points))


@settings(max_examples=6)
@given(seed=SEEDS, exponent=st.floats(-6, 6))
def test_unit_of_length(seed, exponent):
    unit = 10.0**exponent
    target = real_system("pqlsss", np.random.default_rng(seed))
    powers = np.r_[np.ones(10), np.full(16, 1 / unit), 1 / unit**2]
    scaled = solve_system(System.of(target.structure, target.coefficients.g * powers)).points
    scaled[:, 4:] /= unit
    match(solve_system(target).points, scaled)


@pytest.mark.parametrize("spaces", ["ssssss", "apqlss"])
def test_real_systems_have_conjugate_solutions(spaces):
    points = solve_system(real_system(spaces, np.random.default_rng(11))).points
    match(points, points.conj())


def test_complex_systems():
    rng = np.random.default_rng(12)
    solutions = solve_system(System.of(Structure("plsssq"), random_quadrics("plsssq", rng)))
    assert solutions.account.verdict == "complete"
    assert len(solutions.points) == solutions.account.expected
