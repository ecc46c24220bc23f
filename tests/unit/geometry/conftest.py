"""Arrangements and poses to measure at."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from gspcli.catalogue.kinds import KINDS
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import Field, rotation_from_quaternion


def _arrangement_of_all_kinds(rng: np.random.Generator) -> Arrangement:
    """Every kind once: ten constraints, although an instance has six."""
    rows = len(KINDS)

    def directions(letters: list[str]) -> np.ndarray:
        d = rng.normal(size=(rows, 3))
        d /= np.linalg.norm(d, axis=1, keepdims=True)
        return d * np.array([[letter != "P"] for letter in letters])

    return Arrangement(
        kinds=KINDS,
        y=rng.normal(size=(rows, 3)),
        x=rng.normal(size=(rows, 3)),
        u=directions([kind.platform.value for kind in KINDS]),
        v=directions([kind.base.value for kind in KINDS]),
        values=rng.uniform(0.2, 1, size=rows),
        sides=np.zeros(rows, int),
        in_radians=1.0,
    )


def _random_pose(rng: np.random.Generator, imaginary: float = 0.0) -> tuple[Field, Field]:
    e, T = rng.normal(size=4), rng.normal(size=3)
    if imaginary:
        e = e + imaginary * 1j * rng.normal(size=4)
        T = T + imaginary * 1j * rng.normal(size=3)
    return rotation_from_quaternion(e), T


@pytest.fixture
def arrangement_of_all_kinds() -> Callable[..., Arrangement]:
    return _arrangement_of_all_kinds


@pytest.fixture
def random_pose() -> Callable[..., tuple[Field, Field]]:
    return _random_pose
