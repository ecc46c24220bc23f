"""The rows of the Jacobian matrix are the derivatives of what `measure` gives, in every family."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.catalogue.types import CLASSES, families
from gspcli.geometry.quaternions import rotation_from_quaternion, rotation_from_vector
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import measure
from gspcli.motion.statics.wrenches import wrenches

#: Of central differences; they are exact to its square.
STEP = 1e-5


def differences(instance, R, T, point, step):
    """Return central differences of the values by twists about a point, shape (6, 6)."""
    ends = []
    for sign in (step, -step):
        turns = np.array([rotation_from_vector(sign * axis[:3]) for axis in np.eye(6)])
        places = point + turns @ (T - point) + sign * np.eye(6)[:, 3:]
        ends.append(measure(instance, turns @ R, places))
    return (ends[0] - ends[1]).T / (2 * step)


@pytest.mark.parametrize("platform_class", CLASSES, ids=lambda one: one.id)
def test_rows_are_differences_of_measured_values(platform_class):
    signs = set()
    for number, family in enumerate(families(platform_class)):
        # The types of a family in turn: all kinds of angle come with all distances.
        gsp_type = family.types[number % len(family.types)]
        rng = np.random.default_rng((gsp_type.number, 1))
        instance, _ = random_instance(gsp_type, rng)
        R, T = rotation_from_quaternion(rng.normal(size=4)), rng.uniform(-1, 1, size=3)
        point = rng.uniform(-1, 1, size=3)
        given = wrenches(instance, R, T, point=point)
        near, far = (differences(instance, R, T, point, k * STEP) for k in (1, 2))
        units = np.where(given.angles, instance.units.angle.in_radians, 1.0)[:, None]
        # What twice the step changes is three times the error.
        errors = np.abs(near * units - given.jacobian)
        assert (errors <= np.abs(far - near) * units + 1e-8).all(), (gsp_type.id, errors)
        signs |= set(np.sign(given.jacobian[:, 0]).tolist())
    assert {-1.0, 1.0} <= signs
