"""Gaps between legs and bodies against Coal, a library for collisions."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import gspcli
from gspcli.geometry.machine import Machine
from gspcli.motion import gaps
from tests.support.thick_legs import MACHINES, poses_near, thick

coal = pytest.importorskip("coal")


def hull(points):
    vectors = coal.StdVec_Vec3s()
    for point in points:
        vectors.append(point)
    return coal.Convex.convexHull(vectors, True, "Qt")


def capsule(a, b, diameter):
    """Return a capsule about a segment, and its placement: its axis is z."""
    length = np.linalg.norm(b - a)
    z = (b - a) / length
    x = np.cross(z, np.eye(3)[int(np.abs(z).argmin())])
    x /= np.linalg.norm(x)
    place = coal.Transform3s(np.stack((x, np.cross(z, x), z), axis=1), (a + b) / 2)
    return coal.Capsule(diameter / 2, length), place


def distance(first, second):
    result = coal.DistanceResult()
    return coal.distance(*first, *second, coal.DistanceRequest(), result)


@pytest.mark.parametrize("near", [None, 0.0])
@pytest.mark.parametrize("name", MACHINES)
def test_gaps_of_three_machines(name, near):
    instance = thick(name, near)
    diameter, size = instance.shapes.diameters[0].value, MACHINES[name][1]
    rows = instance.constraints
    y, x = (np.array([getattr(row, body).point for row in rows]) for body in ("platform", "base"))
    height = np.mean([row.value.value for row in rows])
    middle = x.mean(axis=0) - y.mean(axis=0) + [0, 0, 0.9 * height]
    R, T = poses_near(np.eye(3), middle, 25, 0.3 * size, 0.5, 1)
    found = gaps(instance, R, T)
    seen = 0
    for k in range(len(T)):
        at = y @ R[k].T + T[k]
        shapes = {f"leg {i + 1}": capsule(at[i], x[i], diameter) for i in range(6)}
        if near is not None:
            for body, turn, shift in (("platform", R[k], T[k]), ("base", np.eye(3), np.zeros(3))):
                points = np.array([[c.value for c in p] for p in getattr(instance.shapes, body)])
                shapes[f"the {body}"] = hull(points), coal.Transform3s(turn, shift)
        for pair, gap in zip(found.pairs, found.values[k], strict=True):
            one, other = pair.split(" and ")
            if one.startswith("legs"):
                one, other = f"leg {one[5:]}", f"leg {other}"
            expected = distance(shapes[one], shapes[other])
            # Of overlapping shapes it gives the depth.
            if expected > 1e-6 * size:
                assert gap == pytest.approx(expected, abs=1e-5 * size), (k, pair)
                seen += 1
            else:
                assert gap < 1e-5 * size, (k, pair)
    assert seen > 200


def test_gaps_of_a_machine_with_arms():
    """Rods begin where the cranks have their points, and arms lead there from the axes."""
    plain = gspcli.example("t-top-head")
    rows = []
    for row in plain.constraints:
        crank = dataclasses.replace(row.base.crank, diameter=gspcli.Number.of(0.012))
        rows.append(dataclasses.replace(row, base=dataclasses.replace(row.base, crank=crank)))
    shapes = gspcli.Shapes(0.006)
    instance = dataclasses.replace(plain, constraints=tuple(rows), shapes=shapes)
    drives = Machine.of(instance)
    R, T = poses_near(np.eye(3), np.array([0, 0, 0.17]), 25, 0.02, 0.3, 1)
    q = drives.inverse(R, T)
    reached = np.isfinite(q).all(axis=1)
    R, T, q = R[reached], T[reached], q[reached]
    assert len(T) > 10
    found = gaps(instance, R, T)
    for k in range(len(T)):
        base, arm, _ = drives.ends(R[k], T[k], q[k])
        shapes = {f"leg {i + 1}": capsule(arm[i] + T[k], base[i], 0.006) for i in range(6)}
        for i in range(6):
            shapes[f"the arm of B{i + 1}"] = capsule(drives.middle[i], base[i], 0.012)
        for pair, gap in zip(found.pairs, found.values[k], strict=True):
            one, other = pair.split(" and ")
            if one.startswith("legs"):
                one, other = f"leg {one[5:]}", f"leg {other}"
            expected = distance(shapes[one], shapes[other])
            assert expected > 1e-4
            assert gap == pytest.approx(expected, abs=1e-6), (k, pair)
