"""Where planes and quadrics of projective 3-space meet (native/intersection.hpp)."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli import _kernel

EPS = float(np.finfo(float).eps)


def random_systems(seed: int, planes: int, field: str, shape: tuple[int, int]):
    """Planes (f, s, k, 4) and quadrics (f, 3 - k, 4, 4), the quadrics shared by s systems."""
    rng = np.random.default_rng(seed)
    p = rng.normal(size=(*shape, planes, 4))
    q = rng.normal(size=(shape[0], 3 - planes, 4, 4))
    if field == "complex":
        p, q = p + 1j * rng.normal(size=p.shape), q + 1j * rng.normal(size=q.shape)
    return p, q + np.swapaxes(q, -1, -2)


def solved(planes, quadrics, field="complex"):
    count = len(planes)
    return _kernel.intersect(
        planes.astype(complex),
        quadrics.astype(complex),
        np.full(count, EPS),
        np.full(count, field == "real"),
    )


def planes_product(a, b) -> np.ndarray:
    a, b = np.asarray(a, float), np.asarray(b, float)
    return (np.outer(a, b) + np.outer(b, a)) / 2


@pytest.mark.parametrize("k", [0, 1, 2, 3])
@pytest.mark.parametrize("field", ["real", "complex"])
def test_generic_systems_have_all_their_points(k, field):
    planes, quadrics = random_systems(k, k, field, (50, 2))
    points, errors, ok = solved(planes, quadrics, field)
    assert ok.all()
    assert points.shape == (50, 2, 2 ** (3 - k), 4)
    np.testing.assert_allclose(np.linalg.norm(points, axis=-1), 1, rtol=1e-14)
    quadrics /= np.linalg.norm(quadrics, axis=(-2, -1), keepdims=True)
    planes /= np.linalg.norm(planes, axis=-1, keepdims=True)
    values = np.einsum("fspi,fkij,fspj->fspk", points, quadrics, points)
    assert np.abs(values).max(initial=0) < 2e-15
    assert np.abs(points @ np.swapaxes(planes, -1, -2)).max(initial=0) < 2e-15
    assert errors.max() < 1e-12
    overlaps = np.abs(points @ np.swapaxes(points.conj(), -1, -2)) - np.eye(2 ** (3 - k))
    assert overlaps.max() < 1 - 1e-8


@pytest.mark.parametrize("k", [0, 1, 2, 3])
def test_points_of_real_systems_are_real_or_in_exact_pairs(k):
    points, _, _ = solved(*random_systems(9, k, "real", (50, 1)), "real")
    for row in points.reshape(50, -1, 4):
        imaginary = [z for z in row if z.imag.any()]
        for first, second in zip(imaginary[::2], imaginary[1::2], strict=True):
            np.testing.assert_array_equal(first, second.conj())


@pytest.mark.parametrize("count", [1, 2, 3, 7, 8, 9, 20])
def test_systems_do_not_depend_on_their_neighbours(count):
    planes, quadrics = random_systems(4, 1, "complex", (20, 1))
    every = solved(planes, quadrics)
    for part, whole in zip(solved(planes[:count], quadrics[:count]), every, strict=True):
        np.testing.assert_array_equal(part, whole[:count])


def test_one_bad_system_does_not_spoil_the_others():
    planes, quadrics = random_systems(5, 1, "complex", (8, 1))
    planes[2] = 0
    quadrics[5, 1] = quadrics[5, 0]
    quadrics[6] = np.nan
    points, errors, ok = solved(planes, quadrics)
    assert ok[:, 0].tolist() == [True, True, False, True, True, False, False, True]
    assert np.isinf(errors[~ok]).all()
    assert not points[~ok].any()


def test_tangent_conics_are_not_answered_for():
    """In a plane the circle x² + y² = 1 and the lines (x - 1)(y - x) = 0 touch at (1, 0)."""
    circle = np.diag([-1.0, 1, 1, 0])
    lines = planes_product([-1, 1, 0, 0], [0, -1, 1, 0])
    assert not solved(np.eye(4)[None, None, 3:], np.array([[circle, lines]]), "real")[2].any()


@pytest.mark.parametrize("apart", [1e-5, 1e-7, 0.0])
def test_near_points_are_not_answered_for(apart):
    pair = np.diag([1.0, -(apart**2), 0, 0])
    planes = np.eye(4)[None, None, 2:]
    assert not solved(planes, pair[None, None], "real")[2].any()
    assert solved(planes, np.diag([1.0, -1e-6, 0, 0])[None, None], "real")[2].all()


def test_infinitely_many_points_are_not_answered_for():
    rng = np.random.default_rng(2)
    x, y = np.eye(4)[:2]
    through = [
        planes_product(x, rng.normal(size=4)) + planes_product(y, rng.normal(size=4))
        for _ in range(3)
    ]
    assert not solved(np.zeros((1, 1, 0, 4)), np.array([through]), "real")[2].any()
    coaxial = np.array([[np.diag([-1.0, 1, 1, 0]), np.diag([-2.0, 1, 1, 0])]])
    assert not solved(rng.normal(size=(1, 1, 1, 4)), coaxial, "real")[2].any()


def test_shapes_are_checked():
    planes, quadrics = random_systems(1, 1, "complex", (2, 1))
    one, yes = np.full(2, EPS), np.ones(2, bool)
    with pytest.raises(ValueError, match="quadrics must have shape"):
        _kernel.intersect(planes, quadrics[:, :1], one, yes)
    with pytest.raises(ValueError, match="planes must have shape"):
        _kernel.intersect(planes[..., :3], quadrics, one, yes)
    with pytest.raises(ValueError, match="accuracy and real"):
        _kernel.intersect(planes, quadrics, one[:1], yes)


@pytest.mark.parametrize("build", ["portable", "avx2", "avx512"])
@pytest.mark.parametrize("k", [0, 1, 2, 3])
def test_all_builds_agree(build, k):
    order = ["portable", "avx2", "avx512"]
    if order.index(build) > order.index(_kernel.build()):
        pytest.skip("not for this processor")
    planes, quadrics = random_systems(6, k, "complex", (30, 1))
    one, no = np.full(30, EPS), np.zeros(30, bool)
    points, _, ok = _kernel.intersect(planes.astype(complex), quadrics.astype(complex), one, no)
    others, _, same = _kernel.intersect(
        planes.astype(complex), quadrics.astype(complex), one, no, build=build
    )
    assert ok.all()
    assert same.all()
    overlaps = np.abs(points.conj() @ np.swapaxes(others, -1, -2))
    np.testing.assert_allclose(overlaps.max(axis=-1), 1, atol=1e-12)
