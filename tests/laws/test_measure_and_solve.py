"""What a pose measures are the values for which `solve` finds that pose; a sample of the types."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gspcli.catalogue.counts import generic_counts
from gspcli.catalogue.types import GspType, all_types
from gspcli.geometry.instance import Side
from gspcli.geometry.numbers import Number
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import measure
from gspcli.solver import solve

#: Types with more poses are left to tools/verify/round_trips.py, which takes all types.
FEW = 64


def round_trip(gsp_type: GspType, seed: int) -> float:
    """Return how far the nearest real pose of the measured values is from a random pose."""
    rng = np.random.default_rng((gsp_type.number, seed))
    instance, _ = random_instance(gsp_type, rng)
    R, T = rotation_from_quaternion(rng.normal(size=4)), rng.uniform(-1, 1, size=3)
    values = measure(instance, R, T).tolist()
    constraints = []
    for constraint, value in zip(instance.constraints, values, strict=True):
        side = Side.BOTH
        if constraint.kind.has_sides:
            side, value = (Side.NEGATIVE if value < 0 else Side.POSITIVE), abs(value)
        constraints.append(replace(constraint, value=Number.of(repr(value)), side=side))
    result = solve(replace(instance, constraints=tuple(constraints)))
    assert result.verdict == "complete"
    real = result.real
    errors = np.abs(result.R[real].real - R).max(axis=(1, 2))
    errors = np.maximum(errors, np.abs(result.T[real].real - T).max(axis=1))
    # A pose that is nearly singular is only as exact as its condition number allows.
    return float((errors / np.maximum(1.0, 1e-3 * result.conditions[real])).min())


SMALL = [t for t in all_types() if generic_counts(t).one_sided <= FEW]


@pytest.mark.parametrize("gsp_type", SMALL[:: len(SMALL) // 40], ids=lambda t: t.id)
def test_a_sample_of_types(gsp_type):
    assert round_trip(gsp_type, 1) < 1e-9
