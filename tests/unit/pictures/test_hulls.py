"""Hulls of a few points."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from gspcli.pictures.stage import convex_hull

CUBE = np.array([*product((0.0, 1.0), repeat=3)])


def test_a_cube_has_six_squares_and_inner_points_none() -> None:
    faces = convex_hull(np.concatenate((CUBE, [[0.5, 0.5, 0.5], [0.5, 0.5, 0.0]])))
    assert sorted(len(face) for face in faces) == [4] * 6


def test_corners_come_in_order() -> None:
    (face,) = convex_hull(np.array([[0, 0, 3], [1, 1, 3], [1, 0, 3], [0, 1, 3], [0.5, 0.2, 3.0]]))
    sides = np.linalg.norm(face - np.roll(face, 1, axis=0), axis=1)
    np.testing.assert_allclose(sides, 1)


@pytest.mark.parametrize(
    ("points", "corners"),
    [
        (np.empty((0, 3)), []),
        (np.ones((4, 3)), []),
        (np.outer([3.0, 1.0, 2.0], [1.0, 1.0, 0.0]), [2]),
    ],
)
def test_less_than_a_plane(points: np.ndarray, corners: list[int]) -> None:
    assert [len(face) for face in convex_hull(points)] == corners


def test_a_measured_plate_is_one_polygon() -> None:
    turns = np.arange(6) * np.pi / 3
    plate = np.column_stack((np.cos(turns), np.sin(turns), 1e-4 * (-1.0) ** np.arange(6)))
    (face,) = convex_hull(plate + 1000.0)
    assert len(face) == 6


def test_every_point_is_inside_the_hull() -> None:
    points = np.random.default_rng(7).normal(size=(12, 3))
    faces = convex_hull(points)
    centre = points.mean(axis=0)
    for a, b, c in faces:
        normal = np.cross(b - a, c - a)
        outward = normal * np.sign(normal @ (a - centre))
        assert ((points - a) @ outward <= 1e-9).all()
    corners = {tuple(corner) for face in faces for corner in face}
    # Euler's formula for a hull of triangles.
    assert len(faces) == 2 * len(corners) - 4
