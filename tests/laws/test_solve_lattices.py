"""Platforms on a lattice: coordinates are small integers, so that most positions are special."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from closed_forms import closed_form_poses

from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.kinds import ANGLE_KINDS, DISTANCE_KINDS, Kind, Primitive
from gspcli.catalogue.types import GspType
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Units
from gspcli.geometry.measurement import measured, residuals
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, Line, Plane, Point, vector
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.solver.study_systems import side_choices
from tests.support.oracle.poses_by_paths import solve_by_tracking


def nonzero(rng: np.random.Generator, size: int) -> np.ndarray:
    v = rng.integers(-1, 2, size=size)
    return v if v.any() else nonzero(rng, size)


def primitive(sort: Primitive, rng: np.random.Generator) -> Geometry:
    position = vector(*rng.integers(-2, 3, size=3).tolist())
    if sort is Primitive.POINT:
        return Point(position)
    shape = Line if sort is Primitive.LINE else Plane
    return shape(position, vector(*nonzero(rng, 3).tolist()))


def lattice_platform(seed: int, angles: int = 3) -> tuple[Arrangement, np.ndarray, np.ndarray]:
    """A platform whose values are those at a pose of the lattice, and that pose."""
    rng = np.random.default_rng(seed)
    kinds: list[Kind] = [
        *rng.choice(DISTANCE_KINDS, size=6 - angles),
        *rng.choice(ANGLE_KINDS, size=angles),
    ]
    constraints = tuple(
        Constraint(kind, primitive(kind.platform, rng), primitive(kind.base, rng), Number.of(1))
        for kind in kinds
    )
    arrangement = Arrangement.of(Instance(constraints, Units("m", AngleUnit.RADIAN)))
    R = rotation_from_quaternion(nonzero(rng, 4).astype(float))
    T = rng.integers(-2, 3, size=3).astype(float)
    values = measured(arrangement, R, T)
    values = np.where(np.abs(values - np.round(values)) < 1e-12, np.round(values), values)
    values[arrangement.distances] = np.abs(values[arrangement.distances])
    return replace(arrangement, values=values), R, T


def test_the_closed_form_answers_completely_or_not_at_all():
    """Where it answers, there are as many poses as the type has, the known one among them."""
    answered = 0
    for seed in range(300):
        arrangement, R, T = lattice_platform(seed)
        poses = closed_form_poses(arrangement)
        if poses is None:
            continue
        answered += 1
        assert poses.account.verdict == "complete"
        assert len(poses.R) == poses.account.expected
        real = residuals(arrangement, poses.R[poses.real].real, poses.T[poses.real].real)
        assert real.max() < 1e-8
        distance = np.abs(poses.R - R).max(axis=(1, 2)) + np.abs(poses.T - T).max(axis=1)
        assert distance.min() < 1e-8
    assert 10 < answered < 150


@pytest.mark.parametrize("angles", [0, 1, 2, 3])
@pytest.mark.parametrize("block", range(3))
def test_paths_end_the_same_whatever_the_way(angles, block):
    """Most of these have double poses, ends at infinity or lines that are parallel."""
    for seed in range(8 * block, 8 * block + 5):
        arrangement, R, T = lattice_platform(seed, angles)
        if path_count(arrangement) > 128:
            continue
        one, other = (solve_by_tracking(arrangement, seed=way) for way in (1, 2))
        assert one.account.lost == other.account.lost == 0
        assert bool(one.motions) == bool(other.motions)
        for poses in (one, other):
            assert int(poses.multiplicity.sum()) == poses.account.found
        if not one.motions:
            assert sorted(one.multiplicity) == sorted(other.multiplicity)
            assert one.account.at_infinity == other.account.at_infinity
            distance = np.abs(one.R - R).max(axis=(1, 2)) + np.abs(one.T - T).max(axis=1)
            assert distance.min() < 1e-6


def path_count(arrangement: Arrangement) -> int:
    counts = generic_counts(GspType.of(arrangement.kinds))
    return counts.one_sided * len(side_choices(arrangement))
