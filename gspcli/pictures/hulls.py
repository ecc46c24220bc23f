"""Convex hulls of a dozen points: the shape by which a body is recognized."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from gspcli.ties import definite_sign

Array = NDArray[np.float64]

#: Points nearer to a plane or line than this fraction of the extent are drawn in it: measured
#: bodies are flat only up to their last decimals.
_FLAT = 2e-3
#: Points nearer to each other than this fraction of their coordinates are one.
_SAME = 1e-9


def convex_hull(points: Array) -> tuple[Array, ...]:
    """Return the faces of the convex hull of a few points, each of shape (k, 3).

    Points in one plane give one polygon, points on one line its two ends, and one point (or
    none) no face at all. Every triple of points is tried as a face, which for the dozen points
    of a body is quicker than being clever.
    """
    if not len(points):
        return ()
    offsets = points - points.mean(axis=0)
    extent = np.abs(offsets).max()
    _, singular, axes = np.linalg.svd(offsets, full_matrices=True)
    if extent <= _SAME * np.abs(points).max():
        return ()
    dimension = int((singular > _FLAT * singular[0]).sum())
    if dimension == 1:
        along = offsets @ definite_sign(axes[0])
        return (points[[along.argmin(), along.argmax()]],)
    if dimension == 2:
        return (_polygon(points, definite_sign(axes[2])),)
    faces: dict[frozenset[int], Array] = {}
    for triple in combinations(range(len(points)), 3):
        a, b, c = points[list(triple)]
        normal = np.cross(b - a, c - a)
        norm = np.linalg.norm(normal)
        if norm <= _FLAT * extent**2:
            continue  # a sliver is no face
        heights = (points - a) @ (normal / norm)
        flat = np.abs(heights) <= _FLAT * extent
        if (heights[~flat] > 0).all() or (heights[~flat] < 0).all():
            inside = frozenset(np.flatnonzero(flat).tolist())
            faces.setdefault(inside, _polygon(points[flat], normal / norm))
    return tuple(faces.values())


def _polygon(points: Array, normal: Array) -> Array:
    """Return the corners, in order, of the convex hull of points in a plane."""
    first = np.eye(3)[np.abs(normal).argmin()]
    first = np.cross(normal, first)
    first /= np.linalg.norm(first)
    flat = (points - points.mean(axis=0)) @ np.stack((first, np.cross(normal, first)), axis=1)
    order = sorted(range(len(flat)), key=lambda k: (flat[k, 0], flat[k, 1]))
    size = np.abs(flat).max()

    def half(indices: list[int]) -> list[int]:
        # Andrew's monotone chain.
        chain: list[int] = []
        for k in indices:
            while len(chain) > 1 and _turn(flat[chain[-2]], flat[chain[-1]], flat[k]) <= (
                _SAME * size**2
            ):
                chain.pop()
            chain.append(k)
        return chain[:-1]

    return points[half(order) + half(order[::-1])]


def _turn(a: Array, b: Array, c: Array) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
