"""Screws by plain formulas: enclosures contain what exact members give, and middles are right."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.catalogue.names import parse_type
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.enclosures import Enclosure
from gspcli.geometry.measurement import jacobian
from gspcli.geometry.random_instances import random_instance
from gspcli.motion.paths.between import rows_near
from gspcli.motion.screws import screw
from tests.support.enclosures import Exact, outside

KINDS = [DPP, DPL, DLP, DPH, DHP, DLL, None]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("count", [0, 2])
def test_members_are_enclosed(kind: Kind, count: int) -> None:
    """With parts that are zero at random, so that each term of a bound is once the only one.

    With linear parts in some parameters, or without.
    """
    rng = np.random.default_rng(2)
    for _ in range(60):
        r = 10.0 ** rng.uniform(-17, -0.5)
        vectors = rng.normal(size=(4, 3))
        vectors[2:] /= np.linalg.norm(vectors[2:], axis=1)[:, None]
        radii = r * rng.choice([0, 1, 1], 4) * [1, 1, 1, 0]
        # Of a unit vector the member is scaled again.
        near = radii * [1, 1, 2.2, 0] + [0, 0, 2.0**-50, 2.0**-50]
        lin = rng.normal(size=(4, 3, count)) * r * rng.integers(0, 2, (4, 1, 1))
        # Directions keep their length to first order.
        lin[2:] -= vectors[2:, :, None] * np.einsum("ki,kij->kj", vectors[2:], lin[2:])[:, None]
        near[2:] += (count * np.abs(lin[2:]).sum(axis=(1, 2))) ** 2
        found = screw(kind, *map(Enclosure, vectors, near, lin))
        for _ in range(4):
            u = rng.choice([-1.0, 1.0], size=count)
            members = []
            for k, (x, row, radius) in enumerate(zip(vectors, lin, radii, strict=True)):
                there = Exact(x, rng) + sum(
                    (u[j] * Exact(row[:, j]) for j in range(count)), start=Exact(0 * x)
                )
                there = there.member(radius, unit=k > 1)
                there.is_ball = not count
                members.append(there)
            for enclosure, true in zip(found, screw(kind, *members), strict=True):
                if enclosure is not None:
                    lines = u[: enclosure.lin.shape[-1]]
                    assert outside(enclosure, true, lines.tolist()) <= 0


@pytest.mark.parametrize("name", ["6PP", "6PL", "6DLP", "6PH", "6DHP", "6DLL", "3PP 3ALL"])
def test_rows_are_those_of_the_jacobian_matrix(name: str) -> None:
    instance, (R, T) = random_instance(parse_type(name), np.random.default_rng(3))
    a = Arrangement.of(instance)
    found = rows_near(a, R[None], T[None], np.zeros(1), np.zeros(1), a.length)
    rows = jacobian(a, R, T)
    rows[:, :3] -= np.cross(R @ a.platform_centre, rows[:, 3:])
    rows[:, :3] /= a.length
    rows /= np.linalg.norm(rows, axis=1)[:, None]
    signs = np.sign(np.sum(rows * found.mid[0], axis=1, keepdims=True))
    np.testing.assert_allclose(found.mid[0], rows * signs, atol=1e-12)
    assert found.rad.max() < 1e-10
