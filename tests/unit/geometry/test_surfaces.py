"""The surfaces of distances against what the constraints mean."""

from __future__ import annotations

from itertools import combinations_with_replacement
from typing import NamedTuple

import numpy as np
import pytest

from gspcli import _kernel
from gspcli.catalogue.kinds import ALL, DISTANCE_KINDS, DLL, DLP, DPL, DPP
from gspcli.catalogue.types import GspType
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.measurement import measured
from gspcli.geometry.quaternions import (
    dot,
    normalized,
    quaternion_product,
    rotation_from_quaternion,
)
from gspcli.geometry.random_instances import random_instance
from gspcli.geometry.three_angles import Measures, measures

TRIPLES = list(combinations_with_replacement(DISTANCE_KINDS, 3))


class Surfaces(NamedTuple):
    """Surfaces at f rotations (native/closed_form.cpp)."""

    planes: np.ndarray
    """Of each combination of sides: of heights, then of circles; (f, s, planes, 4)."""
    quadrics: np.ndarray
    """Spheres, then cylinders, (f, squares, 4, 4)."""
    basis: np.ndarray
    """Of the f with ``e.f = 0``, (f, 4, 3)."""
    skewness: np.ndarray


def surfaces(shapes: Measures, e: np.ndarray, distances: np.ndarray) -> Surfaces:
    """Return the surfaces at quaternions (f, 4) of norm 1 for distances (f, 3)."""
    found = _kernel.surfaces(
        shapes.forms,
        shapes.spheres,
        shapes.skew,
        shapes.signs,
        shapes.basis,
        np.ascontiguousarray(e),
        np.ascontiguousarray(distances[:, shapes.flat]),
        np.ascontiguousarray(distances[:, shapes.curved]),
    )
    return Surfaces(*found)


def arrangement_of(kinds, seed: int) -> Arrangement:
    instance, _ = random_instance(GspType.of((*kinds, ALL, ALL, ALL)), np.random.default_rng(seed))
    return Arrangement.of(instance).normalized


@pytest.mark.parametrize("kinds", TRIPLES, ids=lambda kinds: "-".join(kind.name for kind in kinds))
@pytest.mark.parametrize("field", ["real", "complex"])
def test_surfaces_at_random_poses(kinds, field):
    """Each form is N, or for cylinders N^2, times what it should be."""
    given = arrangement_of(kinds, 1)
    rng = np.random.default_rng(2)
    e, T = rng.normal(size=(5, 4)), rng.normal(size=(5, 3))
    if field == "complex":
        e, T = e + 1j * rng.normal(size=e.shape), T + 1j * rng.normal(size=T.shape)
    e = normalized(e)
    shapes = measures(given)
    distances = rng.uniform(1, 2, size=(5, 3))
    found = surfaces(shapes, e.astype(complex), distances)
    N = dot(e, e)
    R = rotation_from_quaternion(e)
    if field == "real":
        assert not found.planes.imag.any()
        assert not found.quadrics.imag.any()
    # The place of T in the coordinates of the surfaces, and e.f = 0.
    f = quaternion_product(np.concatenate((np.zeros((5, 1)), T), axis=1), e) / 2
    t = (np.linalg.pinv(found.basis) @ f[..., None])[..., 0]
    X = np.concatenate((np.ones((5, 1)), t), axis=1)
    np.testing.assert_allclose(np.einsum("fk,fkc->fc", e, found.basis), 0, atol=1e-14)
    r, w, _ = given.placed(R, T)
    for j, position in enumerate(shapes.flat):
        i = given.distances[position]
        length = distances[:, position]
        height = measured(given, R, T)[:, i]
        if given.kinds[i] is DLL:
            normal = np.cross(w[:, i], given.v[i])
            length = length * np.sqrt(dot(normal, normal) * N**2) / N
            height = dot(r[:, i], normal)
        for sign, planes in zip(shapes.signs[:, j], found.planes.swapaxes(0, 1), strict=True):
            value = dot(planes[:, j], X)
            assert np.abs(
                np.array([value - N * (height - s * sign * length) for s in (1, -1)])
            ).min(axis=0).max() < 1e-12 * (1 + np.abs(height).max())
    for j, position in enumerate(shapes.curved):
        i = given.distances[position]
        axis = {DPP: np.zeros(3), DPL: given.v[i], DLP: w[:, i]}[given.kinds[i]]
        square = dot(r[:, i], r[:, i]) - dot(r[:, i], axis + 0 * r[:, i]) ** 2
        scale = N if j < shapes.spheres else N**2
        value = np.einsum("fa,fab,fb->f", X, found.quadrics[:, j], X)
        expected = scale * (square - distances[:, position] ** 2)
        np.testing.assert_allclose(value, expected, atol=1e-12 * (1 + np.abs(T).max()) ** 2)
    circles = found.planes[:, 0, len(shapes.flat) :]
    for j in range(1, shapes.spheres):
        difference = found.quadrics[:, j] - found.quadrics[:, 0]
        np.testing.assert_allclose(
            dot(circles[:, j - 1], X), np.einsum("fa,fab,fb->f", X, difference, X), atol=1e-12
        )


def test_skewness_is_the_squared_sine():
    given = arrangement_of((DPP, DLL, DLL), 3)
    e = normalized(np.random.default_rng(4).normal(size=(6, 4)))
    found = surfaces(measures(given), e.astype(complex), np.ones((6, 3)))
    w = given.u[1:3] @ rotation_from_quaternion(e).swapaxes(1, 2)
    sines = np.linalg.norm(np.cross(w, given.v[1:3]), axis=-1)
    np.testing.assert_allclose(found.skewness, (sines**2).min(axis=1))


def test_shapes_are_checked():
    shapes = measures(arrangement_of((DLL, DPL, DPP), 5))
    e = np.ones((1, 4), complex) / 2
    with pytest.raises(ValueError, match="must have shapes"):
        surfaces(shapes, e[:, :3], np.ones((1, 3)))
    with pytest.raises(ValueError, match="must have shapes"):
        surfaces(shapes, e, np.ones((2, 3)))
