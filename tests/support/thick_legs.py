"""Machines whose legs have diameters, and random poses of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gspcli.geometry.instance import Instance, Shapes
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.spec.reading import example

Array = NDArray[np.float64]

#: Diameters of legs, and outlines of both bodies as half sides and heights of plates.
MACHINES = {
    "workspace-study": (20, 120, 200),
    "rubin-camera": (0.09, 0.8, 0.8),
    "apo-tertiary": (0.6, 5, 6),
}


def thick(name: str, near: float | None = None, diameter: float | None = None) -> Instance:
    """Return a machine with shapes; with plates as bodies if `near` is given."""
    given, platform, base = MACHINES[name]
    given = given if diameter is None else diameter
    if near is None:
        return replace(example(name), shapes=Shapes(given))
    plates = [
        [[x * side, y * side, z * side / 20] for x in (-1, 1) for y in (-1, 1) for z in zs]
        for side, zs in ((platform, (0, 1)), (base, (-1, 0)))
    ]
    return replace(example(name), shapes=Shapes(given, *plates, near))


def poses_near(
    R: Array, T: Array, count: int, move: float, turn: float, seed: int
) -> tuple[Array, Array]:
    """Return random poses about one, moved and turned so far at most."""
    draw = np.random.default_rng(seed)
    axes = draw.normal(size=(count, 3))
    half = turn / 2 * draw.uniform(size=(count, 1))
    axes *= np.sin(half) / np.linalg.norm(axes, axis=1, keepdims=True)
    turned = rotation_from_quaternion(np.concatenate((np.cos(half), axes), axis=1))
    shifts = draw.normal(size=(count, 3))
    shifts *= move * draw.uniform(size=(count, 1)) / np.linalg.norm(shifts, axis=1, keepdims=True)
    return turned @ R, T + shifts
