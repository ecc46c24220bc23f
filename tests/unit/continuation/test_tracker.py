"""The tracker: builds, threads and batches agree; failures are reported, not hidden."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from gspcli import _kernel
from gspcli.continuation.endpoints import random_start
from gspcli.continuation.quadrics import random_quadrics
from gspcli.continuation.start import start_system
from gspcli.continuation.systems import Coefficients, FineCoefficients, Structure, System
from gspcli.continuation.tracked_paths import _IN_32_DIGITS, _TO_THE_END, track_all
from gspcli.continuation.tracker import PathStatus, TrackerOptions, track

PRODUCTS = (False, True, False, True, False, False)


@pytest.fixture(scope="module")
def homotopy():
    structure = Structure("pplsss", PRODUCTS).canonical()
    start = start_system(structure)
    rng = np.random.default_rng(7)
    rows = [np.array([random_quadrics(structure.spaces, rng) for _ in range(3)]) for _ in range(2)]
    products = np.array(structure.products)
    targets = Coefficients(
        rows[0], np.where(products[:, None], rows[1], 0), np.where(products, 0.3, 0) * np.ones(6)
    )
    targets = Coefficients(targets.g, targets.h, np.broadcast_to(targets.tau, (3, 6)))
    return random_start(start, 8, 0), targets, start.points


def same(a, b, tolerance=1e-9):
    inner = np.abs((a.points.conj() * b.points).sum(axis=-1))
    return np.abs(inner - 1).max() < tolerance


def test_ends_are_solutions(homotopy):
    start, targets, _ = homotopy
    results = track(*homotopy)
    assert (results.status == PathStatus.REGULAR).all()
    assert (results.residual < 1e-14).all()
    for i in range(3):
        target = System(start.structure, targets.take(i))
        assert target.residuals(results.points[i]).max() < 1e-14


@pytest.mark.parametrize("build", ["portable", "avx2", "avx512"])
def test_builds_agree(homotopy, build):
    if build not in _available():
        pytest.skip(f"this processor cannot run {build}")
    assert same(track(*homotopy), track(*homotopy, build=build))


@pytest.mark.parametrize("build", ["portable", "avx2", "avx512"])
def test_double_double_numbers_agree_with_doubles_and_have_twice_the_digits(homotopy, build):
    if build not in _available():
        pytest.skip(f"this processor cannot run {build}")
    results = track(*homotopy, options=_IN_32_DIGITS, build=build)
    assert (results.status == PathStatus.REGULAR).all()
    assert same(track(*homotopy), results)
    assert results.correction.max() < 1e-26
    assert results.residual.max() < 1e-30


def _available() -> list[str]:
    order = ["portable", "avx2", "avx512"]
    return order[: order.index(_kernel.build()) + 1]


def test_threads_do_not_matter(homotopy):
    one, four = track(*homotopy), track(*homotopy, jobs=4)
    np.testing.assert_array_equal(one.points, four.points)


def test_batched_equals_looped_in_any_order(homotopy):
    start, targets, points = homotopy
    together = track(start, targets, points)
    for i in range(3):
        alone = track(start, targets.take(slice(i, i + 1)), points[::-1])
        np.testing.assert_array_equal(alone.points[0, ::-1], together.points[i])


def test_too_few_steps_fail(homotopy):
    results = track(*homotopy, options=TrackerOptions(max_steps=3))
    assert (results.status == PathStatus.FAILED).all()
    assert (results.left > 0).all()


def test_long_ways_beyond_the_waypoint_are_left_to_the_endgame(homotopy):
    early = TrackerOptions(waypoint=0.5)
    assert (track(*homotopy, options=early).status == PathStatus.REGULAR).all()
    hasty = track(*homotopy, options=TrackerOptions(waypoint=0.5, late_steps=1))
    assert (hasty.status == PathStatus.SINGULAR).mean() > 0.5
    assert (hasty.left[hasty.status == PathStatus.SINGULAR] == 0.5).all()


def test_paths_that_are_followed_in_two_parts_end_where_they_do_in_one(homotopy):
    start, targets, points = homotopy
    target = targets.take(slice(1))
    near = System(start.structure, start.coefficients.towards(target.take(0), 0.875))
    there = track(start, near, points)
    assert (there.status == PathStatus.REGULAR).all()
    on = track(start, target, there.points[0], left=np.full(len(points), 0.125))
    assert (on.status == PathStatus.REGULAR).all()
    assert same(track(start, target, points), on)
    with pytest.raises(ValueError, match="left of the way must have shape"):
        track(start, target, points, left=np.ones(1))


def test_a_path_is_not_at_the_target_where_only_a_double_cannot_tell_it_from_it(homotopy):
    start, targets, points = homotopy
    target = targets.take(slice(1))
    ends = track(start, target, points[:8]).points[0]
    options = replace(_IN_32_DIGITS, waypoint=0.0, min_step=1e-18)
    results = track(start, target, ends, left=np.full(8, 1e-20), options=options)
    # Too near for a step, and yet not there.
    assert (results.status == PathStatus.FAILED).all()
    assert (results.left == 1e-20).all()


def test_points_at_the_target_are_improved_beside_paths_that_are_not_there(homotopy):
    start, targets, points = homotopy
    target = targets.take(slice(1))
    ends = track(start, target, points[:20])
    arrived = np.arange(20) % 3 > 0
    starts = np.where(arrived[:, None], ends.points[0], points[:20])
    options = replace(_TO_THE_END, arrival=1.0)
    results = track(start, target, starts, left=np.where(arrived, 0.0, 1.0), options=options)
    assert (results.status == PathStatus.REGULAR).all()
    assert ((results.steps[0] == 0) == arrived).all()
    assert (results.left == 0).all()
    assert same(ends, results)
    assert (results.correction < 1e-25).all()
    assert np.abs(results.low).max() > 0


def test_a_point_that_is_no_solution_fails(homotopy):
    start, targets, points = homotopy
    wrong = np.roll(points, 1, axis=1)
    results = track(start, targets, wrong)
    assert (results.status == PathStatus.FAILED).all()


def test_not_a_number_fails(homotopy):
    start, targets, points = homotopy
    results = track(start, targets, np.full_like(points[:3], np.nan))
    assert (results.status == PathStatus.FAILED).all()


def test_no_paths(homotopy):
    start, targets, points = homotopy
    assert track(start, targets, points[:0]).points.shape == (3, 0, 8)


def test_wrong_shapes(homotopy):
    start, targets, points = homotopy
    with pytest.raises(ValueError, match="points must have shape"):
        track(start, targets, points[:, :7])
    with pytest.raises(ValueError, match="no build named"):
        track(start, targets, points, build="sse9")


def test_more_digits_are_those_that_doubles_cut_off(homotopy):
    start, targets, points = homotopy
    results = track(start, targets, points[:8], options=_IN_32_DIGITS)
    assert results.low.shape == (3, 8, 1, 8)
    assert track(start, targets, points[:8]).low.shape == (0, 8, 1, 8)
    # On the Study quadric to this many digits, in exact arithmetic.
    real, imaginary = (
        [sum(map(Fraction, parts)) for parts in zip(*rows, strict=True)]
        for rows in _rows(results.points[0, 0], *results.low[0, 0])
    )
    on_quadric = [
        sum(real[k] * real[4 + k] - imaginary[k] * imaginary[4 + k] for k in range(4)),
        sum(real[k] * imaginary[4 + k] + imaginary[k] * real[4 + k] for k in range(4)),
    ]
    assert 0 < max(map(abs, on_quadric)) < 1e-28


def _rows(*arrays):
    """Return the real and the imaginary parts of arrays of complex numbers."""
    return [x.real.tolist() for x in arrays], [x.imag.tolist() for x in arrays]


# Paths followed with more digits: all of them arrive, each once, with the digits asked for.


@pytest.fixture(scope="module")
def tracked_paths():
    structure = Structure("pplsss", (False,) * 6).canonical()
    quadrics = random_quadrics(structure.spaces, np.random.default_rng(5))
    return next(track_all([System.of(structure, quadrics)], seed=1))


@pytest.fixture(scope="module")
def target(tracked_paths):
    exactly = Coefficients(*(x.astype(object) for x in tracked_paths._target.coefficients))
    return FineCoefficients.of(exactly)


def _in_order(tracked_paths, index, target, **options):
    """Return the ends of some paths, points and low parts, in the order of their indices."""
    parts = list(tracked_paths.track(index, target, **options))
    which = np.concatenate([index for index, _ in parts])
    assert sorted(which.tolist()) == list(range(len(index)))
    joined = np.concatenate([ends.points[0] for _, ends in parts])
    more = np.concatenate([ends.more for _, ends in parts])
    order = np.argsort(which)
    return joined[order], more[order]


def _overlaps(one, other):
    one, other = (x / np.linalg.norm(x, axis=1)[:, None] for x in (one, other))
    return np.abs(one.conj() @ other.T)


@pytest.mark.parametrize("few", [1, 12])
def test_paths_that_arrive_early_come_first_and_each_once(tracked_paths, target, few, monkeypatch):
    monkeypatch.setattr("gspcli.continuation.tracked_paths._FEW_STEPS", few)
    index = np.arange(3, 9)
    parts = list(tracked_paths.track(index, target))
    assert len(parts) == (1 if few > 1 else 2)
    assert sorted(np.concatenate([which for which, _ in parts]).tolist()) == list(range(6))
    first = tracked_paths.first().points[0, index]
    for which, ends in parts:
        assert ends.more.shape == (len(which), 1, 8)
        assert ends.has_converged.all()
        # With more digits each path leads where it led with few.
        assert np.diag(_overlaps(ends.points[0], first[which])).min(initial=1) > 1 - 1e-12


def test_ends_have_32_digits(tracked_paths, target):
    """Along other random paths the same solutions are reached, in other multiples."""
    every = np.arange(tracked_paths.count)
    ends, low = _in_order(tracked_paths, every, target)
    others, others_low = _in_order(tracked_paths, every, target, attempt=1)
    overlaps = _overlaps(ends, others)
    partner = overlaps.argmax(axis=1)
    assert overlaps[every, partner].min() > 1 - 1e-12
    ratios = _ratios(others, others_low)
    for one, k in zip(_ratios(ends, low), partner.tolist(), strict=True):
        assert abs(one - ratios[k]) < 1e-22 * abs(one)


def _ratios(points, parts):
    """Return the quotients of the first two coordinates, in many digits."""
    from flint import acb, ctx

    with ctx.workprec(400):
        sums = [
            [sum((acb(x) for x in (high[k], *low[:, k])), acb(0)) for k in (0, 1)]
            for high, low in zip(points.tolist(), parts, strict=True)
        ]
        return [(a / b).mid() for a, b in sums]


def test_no_paths_have_no_ends(tracked_paths, target):
    points, low = _in_order(tracked_paths, np.arange(0), target)
    assert len(points) == len(low) == 0
