"""Gaps between legs and bodies: distances, pairs, and how much gaps can change."""

from dataclasses import replace

import numpy as np
import pytest

from gspcli import _kernel
from gspcli.errors import ArgumentError
from gspcli.geometry.instance import Shapes
from gspcli.motion import gaps
from gspcli.motion.collisions.compared import ComparedShapes
from gspcli.spec.reading import example
from tests.support.thick_legs import MACHINES, poses_near, thick

SEGMENTS, PAIR = np.array([0, 2, 4]), np.array([[0, 1]])
HOME = np.eye(3), np.array([0.0, 0.0, 400.0])


def of_segments(points):
    low, high = _kernel.hull_gaps(np.ascontiguousarray(points, float), SEGMENTS, PAIR)
    return low[:, 0], high[:, 0]


def by_cases(points):
    """Return distances of segments by cases: each end to the other segment, and both lines."""
    a, b, c, d = (points[:, k] for k in range(4))

    def to_segment(p, u, v):
        way = v - u
        along = np.einsum("ni,ni->n", p - u, way) / np.maximum((way**2).sum(axis=1), 1e-300)
        return np.linalg.norm(p - u - np.clip(along, 0, 1)[:, None] * way, axis=1)

    ends = np.min(
        [to_segment(a, c, d), to_segment(b, c, d), to_segment(c, a, b), to_segment(d, a, b)], axis=0
    )
    u, v = b - a, d - c
    n = np.cross(u, v)
    with np.errstate(all="ignore"):
        square = (n**2).sum(axis=1)
        s = (np.cross(c - a, v) * n).sum(axis=1) / square
        t = (np.cross(c - a, u) * n).sum(axis=1) / square
        inside = (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
        lines = np.abs(((c - a) * n).sum(axis=1)) / np.sqrt(square)
    return np.where(inside, np.minimum(ends, lines), ends)


def test_distances_of_segments_are_those_of_the_cases():
    points = np.random.default_rng(1).normal(size=(50_000, 4, 3))
    low, high = of_segments(points)
    expected = by_cases(points)
    assert (low <= expected + 1e-15).all()
    assert (high >= expected - 1e-15).all()
    assert (high - low).max() < 1e-12


@pytest.mark.parametrize("exponent", range(1, 17, 3))
def test_nearly_parallel_segments(exponent):
    draw = np.random.default_rng(exponent)
    points = draw.normal(size=(5000, 4, 3))
    points[:, 3] = points[:, 2] + (points[:, 1] - points[:, 0]) * draw.normal(size=(5000, 1))
    points[:, 3] += 10.0**-exponent * draw.normal(size=(5000, 3))
    # Half of them nearly touch.
    points[:2500, 2:] += (points[:2500, 0] - points[:2500, 2])[:, None]
    points[:2500, 2:] += 1e-9 * draw.normal(size=(2500, 1, 3))
    low, high = of_segments(points)
    expected = by_cases(points)
    assert (low <= expected + 1e-14).all()
    assert (high >= expected - 1e-14).all()
    assert (high - low).max() < 1e-8


def test_segments_of_small_integers():
    """Many are parallel, touch, lie in each other or are points."""
    points = np.random.default_rng(5).integers(-2, 3, size=(50_000, 4, 3)).astype(float)
    low, high = of_segments(points)
    assert np.abs(high - by_cases(points)).max() < 1e-12
    assert (high - low).max() < 1e-12
    assert (low >= 0).all()


@pytest.mark.parametrize("size", [1e-300, 1e-60, 1e60, 1e150, 1e300])
def test_tiny_and_huge_segments(size):
    points = np.random.default_rng(2).normal(size=(1000, 4, 3))
    low, high = of_segments(points * size)
    assert np.abs(high / size - by_cases(points)).max() < 1e-12
    assert (high - low).max() < 1e-12 * size


def test_what_is_not_finite_has_no_distance():
    points = np.ones((3, 4, 3))
    points[0, 1, 2], points[1, 3, 0] = np.nan, np.inf
    low, high = of_segments(points)
    assert np.isnan(low).tolist() == [True, True, False]
    assert np.isnan(high).tolist() == [True, True, False]
    assert of_segments(np.zeros((1, 4, 3))) == ([0.0], [0.0])


def test_wrong_arrays_are_refused():
    points = np.zeros((1, 4, 3))
    for starts, pairs in (
        ([0, 2], [[0, 0]]),
        ([1, 4], [[0, 0]]),
        ([0, 0, 4], [[0, 1]]),
        ([0, 4], [[0, 1]]),
        ([0, 4], [[0, -1]]),
    ):
        with pytest.raises(ValueError, match="hull"):
            _kernel.hull_gaps(points, np.array(starts), np.array(pairs))


def test_hulls_that_overlap_have_distance_zero_and_others_a_plane_between_them():
    draw = np.random.default_rng(3)
    points = draw.normal(size=(2000, 24, 3))
    points[:, 12:] += 3 * draw.normal(size=(2000, 1, 3))
    starts = np.array([0, 12, 24])
    low, high = (one[:, 0] for one in _kernel.hull_gaps(points, starts, PAIR))
    assert (high - low).max() < 1e-7
    assert 100 < (low == 0).sum() < 1900
    # No two points of random combinations are nearer.
    parts = draw.dirichlet(np.full(12, 0.3), size=(2, 2000))
    first, second = (
        np.einsum("nk,nki->ni", part, points[:, 12 * k : 12 * k + 12])
        for k, part in enumerate(parts)
    )
    assert (low <= np.linalg.norm(first - second, axis=1)).all()


def test_legs_that_share_a_joint_are_compared_beyond_a_length_only():
    # Of the 15 pairs of an octahedral hexapod six share a joint of a body each.
    octahedral = example("platform-6-3")
    rows = octahedral.constraints
    shared = [
        (i + 1, j + 1)
        for i in range(6)
        for j in range(i + 1, 6)
        if rows[i].platform_name == rows[j].platform_name
    ]
    assert len(shared) == 3
    apart = ComparedShapes(replace(octahedral, shapes=Shapes(0)))
    assert len(apart.names) == 12
    assert not {f"legs {i} and {j}" for i, j in shared} & {*apart.names}
    beyond = ComparedShapes(replace(octahedral, shapes=Shapes(0, near_joint=0.25)))
    assert len(beyond.names) == 15
    T = np.array([0.1, 0.2, 1.5])
    a = np.array([[x.value for x in row.platform.position] for row in rows]) + T
    b = np.array([[x.value for x in row.base.position] for row in rows])
    found = gaps(beyond.instance, np.eye(3), T)
    u = (b - a) / np.linalg.norm(b - a, axis=1)[:, None]
    i, j = (k - 1 for k in shared[0])
    assert found.values[0, found.pairs.index(f"legs {i + 1} and {j + 1}")] == pytest.approx(
        0.25 * np.linalg.norm(u[i] - u[j])
    )


def test_nothing_to_compare_is_an_error():
    with pytest.raises(ArgumentError, match="states no shapes"):
        gaps(example("workspace-study"), *HOME)
    with pytest.raises(ArgumentError, match="no distance of two points"):
        gaps(replace(example("six-planes"), shapes=Shapes(1)), *HOME)
    with pytest.raises(ArgumentError, match=r"shapes.diameters\[1\]: found -2"):
        gaps(replace(example("workspace-study"), shapes=Shapes([1, -2, 3, 4, 5, 6])), *HOME)


def test_a_leg_of_length_zero_and_touching_legs():
    instance = thick("workspace-study", diameter=0)
    rows = instance.constraints
    # The platform's first joint is at that of the base.
    joints = rows[0].platform.point, rows[0].base.point
    T = joints[1] - joints[0]
    found = gaps(instance, np.eye(3), T)
    assert np.isfinite(found.values).all()
    wide = gaps(thick("workspace-study", diameter=53.0 + 1e-9), np.eye(3), [0, 0, 400])
    thin = gaps(thick("workspace-study"), np.eye(3), [0, 0, 400])
    assert np.allclose(wide.values, thin.values - 33, atol=1e-8)
    for diameter in (0, 20, 53.0):
        one = ComparedShapes(thick("workspace-study", diameter=diameter))
        bounds = one.bounds(np.eye(3)[None], np.array([[0, 0, 400.0]]))
        for bound in bounds:
            assert np.allclose(bound, thin.values + 20 - diameter, atol=1e-8)


@pytest.mark.parametrize("near", [None, 0.0, 1.0])
@pytest.mark.parametrize("name", MACHINES)
def test_gaps_change_at_most_by_what_is_bounded(name, near):
    instance = thick(name, None if near is None else near * MACHINES[name][0])
    compared = ComparedShapes(instance)
    home = np.array([x.value for x in instance.home.position]) if instance.home else None
    T = np.array([0, 0, 400.0]) if home is None else home
    size = MACHINES[name][1]
    for seed, (move, turn) in enumerate([(0.1, 0.1), (0.3, 1.5), (0.0, 0.4), (0.5, 0.0), (0, 3.1)]):
        R, first = poses_near(np.eye(3), T, 40, size, 1.0, seed)
        centre = np.array([0.1, 0.2, -0.1]) * size
        for k in range(40):
            # The centre moves, and the platform turns about it.
            turned, moved = poses_near(R[k], R[k] @ centre + first[k], 25, move * size, turn, k)
            at = compared.bounds(R[k][None], first[k][None])
            there = compared.bounds(turned, moved - turned @ centre)
            far = np.array([move * size]), np.array([turn])
            bound = compared.moves(R[k][None], first[k][None], None, *far, centre)
            assert (there.low <= at.high + bound).all()
            assert (there.high >= at.low - bound).all()
