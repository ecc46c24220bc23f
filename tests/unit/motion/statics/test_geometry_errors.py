"""Errors from the geometry: exact derivatives, and poses of platforms that are a little off."""

from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.errors import ArgumentError
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import measure
from gspcli.motion.statics.accuracy import geometry_accuracy, geometry_slopes
from gspcli.motion.statics.wrenches import wrenches
from gspcli.resources import data_path

TYPES = ["6PP", "PP PL LP PH HP DLL", "PL PL LP ALL ALH AHH", "LP HP DLL AHL ALL AHH"]


def platform(name, seed=5):
    instance, (R, T) = random_instance(gspcli.parse_type(name), np.random.default_rng(seed))
    return instance, R, T


def changed(instance, name, motion):
    """Return the instance with a number of one primitive changed."""
    body, primitive, what = name.split(".")
    rows = []
    for row in instance.constraints:
        if getattr(row, f"{body}_name") == primitive:
            part = getattr(row, body)
            if what in "xyz":
                moved = part.point + motion * np.eye(3)["xyz".index(what)]
                part = replace(part, position=moved.tolist())
            else:
                axis = np.linalg.svd(part.unit[None])[2][int(what[-1])]
                turned = part.unit + motion * np.cross(axis, part.unit)
                key = "normal" if hasattr(part, "normal") else "direction"
                part = replace(part, **{key: turned.tolist()})
            row = replace(row, **{body: part})
        rows.append(row)
    return replace(instance, constraints=tuple(rows))


@pytest.mark.parametrize("name", TYPES)
def test_slopes_agree_with_finite_differences(name):
    instance, R, T = platform(name)
    found = geometry_slopes(instance, R, T)
    step = 1e-6
    units = [instance.units.angle.in_radians if not c.kind.is_distance else 1.0
             for c in instance.constraints]  # fmt: skip
    for k, column in enumerate(found.names):
        ends = [measure(changed(instance, column, sign * step), R, T) for sign in (1, -1)]
        difference = (ends[0] - ends[1]) / (2 * step) * units
        np.testing.assert_allclose(difference, found.slopes[:, k], atol=2e-6)
    lines = sum("tilt" in name for name in found.names)
    assert found.tilts.sum() == lines
    assert len(found.names) == len(set(found.names))


@pytest.mark.parametrize("name", TYPES[:3])
def test_the_pose_of_a_platform_that_is_off(name):
    instance, R, T = platform(name)
    given = wrenches(instance, R[None], T[None], point=T[None])
    found = geometry_slopes(instance, R, T)
    rng = np.random.default_rng(1)
    size = 1e-5
    errors = size * rng.choice([-1, 1], len(found.names))
    other = instance
    for column, error in zip(found.names, errors, strict=True):
        other = changed(other, column, error)
    # One step of Newton's method from the stated pose, which is that of the exact derivatives.
    values, radian = measure(instance, R, T), instance.units.angle.in_radians
    off = (measure(other, R, T) - values) * [
        1 if c.kind.is_distance else radian for c in instance.constraints
    ]
    signed = given.angles | np.array([c.kind.name != "DLL" for c in instance.constraints])
    predicted = found.slopes @ errors
    np.testing.assert_allclose(off[signed], predicted[signed], atol=2e-8)
    twist = -given.inverse[0] @ predicted
    bounds = geometry_accuracy(given, size, size / radian)
    assert np.all(abs(twist) <= bounds.worst[0] * (1 + 1e-9))
    assert np.linalg.norm(twist[:3]) <= bounds.turn[0] * (1 + 1e-9)
    assert np.linalg.norm(twist[3:]) <= bounds.shift[0] * (1 + 1e-9)


def test_the_worst_case_is_attained_and_rms_is_that_of_samples():
    instance, R, T = platform("PP PL LP PH HP DLL")
    given = wrenches(instance, R[None], T[None])
    bounds = geometry_accuracy(given, 0.01, 0.2)
    found = geometry_slopes(instance, R, T)
    sizes = np.where(found.tilts, np.radians(0.2), 0.01)
    columns = -given.inverse[0] @ found.slopes * sizes
    attained = (columns * np.sign(columns)).sum(axis=1)
    np.testing.assert_allclose(attained, bounds.worst[0])
    samples = columns @ np.random.default_rng(2).normal(size=(len(sizes), 20000))
    np.testing.assert_allclose(samples.std(axis=1), bounds.rms[0], rtol=0.03)


def test_shared_joints_count_once():
    shared = gspcli.load(data_path("examples", "octahedral-3-3.yaml"))
    text = gspcli.dumps(shared)
    assert len({row.platform_name for row in shared.constraints}) == 3
    result = gspcli.solve(shared)
    given = wrenches(shared, result.R[:1].real, result.T[:1].real)
    assert len(geometry_slopes(shared, given.R, given.T).names) == 18
    apart = replace(
        shared,
        constraints=tuple(
            replace(row, platform_name=f"p{k}", base_name=f"b{k}")
            for k, row in enumerate(shared.constraints)
        ),
    )
    other = replace(given, instance=apart)
    one, two = (geometry_accuracy(each, 0.01) for each in (given, other))
    assert np.all(one.worst <= two.worst * (1 + 1e-9))
    assert not np.allclose(one.worst, two.worst)
    assert text


def test_mistakes():
    instance, R, T = platform("6PP")
    given = wrenches(instance, R[None], T[None])
    for wrong in ((-1, 0), (0, float("nan"))):
        with pytest.raises(ArgumentError, match="expected a number of at least zero"):
            geometry_accuracy(given, *wrong)
