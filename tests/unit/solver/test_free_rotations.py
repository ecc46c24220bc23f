"""Three angles that leave a rotation free: the platform moves, or nothing is left for it."""

from __future__ import annotations

from typing import Any

import pytest
from positions import ORIGIN, P, X, Y, Z, at, cylinders, solved, spheres

from gspcli.geometry.primitives import Line, Plane, vector
from gspcli.geometry.residuals import residuals


def free_angles(name: str) -> tuple[tuple[Any, ...], ...]:
    """Angles that leave a rotation free."""
    x, y, z = (Line(ORIGIN, d) for d in (X, Y, Z))
    back, diagonal = Line(ORIGIN, vector(-1, 0, 0)), Line(ORIGIN, vector(1, 1, 0))
    rows = {
        "one axis twice": ((x, x, 60), (x, x, 60), (z, z, 60)),
        "one axis and its opposite": ((x, x, 60), (back, x, 120), (z, z, 60)),
        "one axis three times": ((x, x, 60), (x, x, 60), (x, x, 60)),
        "one line of the base": ((x, z, 60), (y, z, 60), (z, z, 45)),
        "coplanar lines and one of the base": ((x, z, 60), (y, z, 60), (diagonal, z, 45)),
        "right angles with one line": ((x, x, 90), (y, x, 90), (z, y, 90)),
    }
    return tuple(("ALL", *row) for row in rows[name])


SURFACES = {
    "spheres": tuple(
        ("DPP", at(*y), at(*x), 2)
        for y, x in (((0, 0, 0), (0, 0, 0)), ((1, 0, 0), (1, 1, 0)), ((0, 1, 0), (0, 1, 1)))
    ),
    "cylinders": cylinders(6, 4, 5),
    "planes": tuple(("DPH", P, Plane(ORIGIN, d), 1) for d in (X, Y, Z)),
}


@pytest.mark.parametrize("surfaces", SURFACES)
@pytest.mark.parametrize(
    "name",
    [
        "one axis twice",
        "one axis and its opposite",
        "one axis three times",
        "one line of the base",
        "coplanar lines and one of the base",
        "right angles with one line",
    ],
)
def test_a_free_rotation_is_a_motion(name, surfaces):
    result = solved(*SURFACES[surfaces], *free_angles(name))
    assert result.verdict == "infinite"
    # That there are infinitely many is proved by the count: of so special a set paths may be lost.
    assert result.poses.proof is not None
    assert result.account.lost < 8
    motion = result.motions[0]
    assert motion.real
    assert residuals(result.arrangement, motion.R, motion.T).max() < 1e-9


def test_a_free_rotation_without_any_translation_has_no_pose():
    """Two concentric spheres: path tracking confirms what sample rotations only suggest."""
    result = solved(
        *spheres((at(0, 0, 0), 1), (at(0, 0, 0), 2), (at(1, 0, 0), 1)),
        *free_angles("one axis twice"),
    )
    assert result.verdict == "complete"
    assert (result.counts.found, result.account.at_infinity) == (0, 16)
