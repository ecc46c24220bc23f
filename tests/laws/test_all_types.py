"""Laws of the solutions of all types: what the answer must not depend on.

Examples are random platforms of random families, of any class, with few enough solutions for a
quick test. All changes of an instance are exact.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matching import pose_set_distance

from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.types import CLASSES, GspType, all_types
from gspcli.geometry.instance import Constraint, Instance, Side
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, Line, Plane, Point, Vector
from gspcli.geometry.quaternions import Field
from gspcli.geometry.random_instances import random_instance
from gspcli.solver import SolveResult, solve
from gspcli.solver.solved_starts import SolvedStarts

MANY = 320
#: Poses agree to this if rounding is the only difference; conditions are up to 1e8 or so.
SAME = 1e-6

Exact = tuple[tuple[Fraction, ...], ...]


def small(gsp_type: GspType) -> bool:
    return generic_counts(gsp_type).two_sided <= MANY


TYPES = {c.id: [t for t in all_types() if t.platform_class == c and small(t)] for c in CLASSES}
seeds = st.integers(0, 10**6)
platforms = st.builds(
    lambda types, number, seed: random_instance(
        types[number % len(types)], np.random.default_rng(seed)
    )[0],
    st.sampled_from(list(TYPES.values())),
    st.integers(0, 10**6),
    seeds,
)
few = settings(max_examples=16)


def answer(instance: Instance, seed: int = 1) -> SolveResult:
    result = solve(instance, seed=seed)
    assert result.verdict == "complete"
    assert result.counts.found == result.expected == generic_counts(instance.type).two_sided
    return result


def assert_same(first: SolveResult, R: Field, T: Field) -> None:
    """Compare poses with others in the frames and units of the first."""
    length = first.arrangement.length
    assert pose_set_distance((first.R, first.T), (R, T), length) < SAME


def fractions(vector: Vector) -> tuple[Fraction, ...]:
    exact = tuple(number.fraction for number in vector)
    assert None not in exact
    return exact  # type: ignore[return-value]


def turn(q: tuple[int, int, int, int]) -> Exact:
    """Return a rational rotation matrix."""
    a, b, c, d = (Fraction(x) for x in q)
    n = a * a + b * b + c * c + d * d
    rows = (
        (a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)),
        (2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)),
        (2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d),
    )
    return tuple(tuple(x / n for x in row) for row in rows)


def moved(geometry: Geometry, R: Exact, T: tuple[int, ...], scale: Fraction) -> Geometry:
    """Return a primitive in another frame and unit, ``scale (R x + T)``."""

    def turned(vector: Vector) -> list[Fraction]:
        exact = fractions(vector)
        return [sum((a * b for a, b in zip(row, exact, strict=True)), Fraction(0)) for row in R]

    def position(vector: Vector) -> Vector:
        x, y, z = (Number.of(scale * (a + b)) for a, b in zip(turned(vector), T, strict=True))
        return x, y, z

    def direction(vector: Vector) -> Vector:
        x, y, z = (Number.of(a) for a in turned(vector))
        return x, y, z

    match geometry:
        case Point():
            return Point(position(geometry.position))
        case Line():
            return Line(position(geometry.position), direction(geometry.direction))
        case Plane():
            return Plane(position(geometry.position), direction(geometry.normal))


def with_constraints(instance: Instance, constraints: list[Constraint]) -> Instance:
    return replace(instance, constraints=tuple(constraints))


def as_floats(R: Exact) -> np.ndarray:
    return np.array(R, dtype=float)


def test_the_sample_has_types_of_every_class():
    assert all(len(types) > 20 for types in TYPES.values())


@given(platforms, seeds)
@few
def test_the_seed_makes_no_difference(instance, seed):
    first, second = answer(instance), answer(instance, seed + 2)
    assert_same(first, second.R, second.T)
    assert first.counts.real == second.counts.real


@given(platforms, st.permutations(range(6)))
@few
def test_the_order_of_constraints_makes_no_difference(instance, order):
    first = answer(instance)
    second = answer(with_constraints(instance, [instance.constraints[i] for i in order]))
    assert_same(first, second.R, second.T)
    assert first.counts.real == second.counts.real


integers = st.integers(-9, 9)
quaternions = st.tuples(st.integers(1, 9), integers, integers, integers)
shifts = st.tuples(*[st.integers(-5, 5)] * 3)


@given(platforms, quaternions, shifts, quaternions, shifts)
@few
def test_frames_make_no_difference(instance, platform_turn, platform_shift, base_turn, base_shift):
    A, B = turn(platform_turn), turn(base_turn)
    one = Fraction(1)
    first = answer(instance)
    second = answer(
        with_constraints(
            instance,
            [
                replace(
                    c,
                    platform=moved(c.platform, A, platform_shift, one),
                    base=moved(c.base, B, base_shift, one),
                )
                for c in instance.constraints
            ],
        )
    )
    # With y' = A y + a and x' = B x + b the pose (R, T) becomes (B R A^T, B T + b - B R A^T a).
    A, B, a, b = as_floats(A), as_floats(B), np.array(platform_shift), np.array(base_shift)
    R = B.T @ second.R @ A
    T = (second.T - b + second.R @ a) @ B
    assert_same(first, R, T)
    assert first.counts.real == second.counts.real


@given(platforms, st.integers(-6, 6))
@few
def test_units_make_no_difference(instance, power):
    scale = Fraction(10) ** power
    still = turn((1, 0, 0, 0))
    first = answer(instance)
    second = answer(
        with_constraints(
            instance,
            [
                replace(
                    c,
                    platform=moved(c.platform, still, (0, 0, 0), scale),
                    base=moved(c.base, still, (0, 0, 0), scale),
                    value=Number.of(c.value.fraction * scale) if c.kind.is_distance else c.value,
                )
                for c in instance.constraints
            ],
        )
    )
    assert_same(first, second.R, second.T / float(scale))
    assert first.counts.real == second.counts.real


@given(platforms)
@few
def test_base_and_platform_may_be_swapped(instance):
    first = answer(instance)
    second = answer(
        with_constraints(
            instance,
            [
                replace(c, kind=c.kind.mirrored, platform=c.base, base=c.platform)
                for c in instance.constraints
            ],
        )
    )
    inverse = np.swapaxes(second.R, 1, 2)
    assert_same(first, inverse, -(inverse @ second.T[..., None])[..., 0])
    assert first.counts.real == second.counts.real


@given(st.sampled_from([t for t in all_types() if small(t)]), seeds)
@settings(max_examples=12)
def test_one_sided_poses_together_are_the_two_sided_ones(gsp_type, seed):
    instance, _ = random_instance(gsp_type, np.random.default_rng(seed))
    sided = [i for i, c in enumerate(instance.constraints) if c.kind.has_sides]
    both = answer(instance)
    parts = [instance]
    for i in sided:
        parts = [
            with_constraints(
                part,
                [replace(c, side=side) if i == k else c for k, c in enumerate(part.constraints)],
            )
            for part in parts
            for side in (Side.POSITIVE, Side.NEGATIVE)
        ]
    results = [solve(part) for part in parts]
    assert all(r.counts.found == generic_counts(gsp_type).one_sided for r in results)
    R, T = (np.concatenate([getattr(r, name) for r in results]) for name in "RT")
    assert_same(both, R, T)
    assert both.counts.real == sum(r.counts.real for r in results)


@pytest.mark.parametrize("name", list(TYPES))
def test_threads_make_no_difference_at_all(name):
    instance, _ = random_instance(TYPES[name][-1], np.random.default_rng(2))
    starts = SolvedStarts()
    one, two = (solve(instance, jobs=jobs, starts=starts) for jobs in (1, 2))
    assert np.array_equal(one.R, two.R)
    assert np.array_equal(one.T, two.T)
