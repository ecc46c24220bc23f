"""Laws of sensors: no dependence on frames, names and order; swapped bodies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.catalogue.names import parse_type
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.geometry.random_instances import random_instance
from gspcli.resources import instance_files
from gspcli.sensing.sensor_kinds import candidates

SIGMA = {"leg": 0.001, "joint": 0.1, "inclinometer": 0.1}
HEXAPODS = range(3)


def hexapod(seed, *, planar=False):
    """Return a random hexapod whose joints are named P1 to P6 on both bodies, and its pose."""
    rng = np.random.default_rng(seed)
    instance, pose = random_instance(parse_type("6PP"), rng, planar=planar)
    rows = instance.constraints
    joints = [[row.base.position for row in rows], [row.platform.position for row in rows]]
    return gspcli.hexapod(*joints, [row.value for row in rows]), pose, rng


def moved(points, R, T):
    return [(R @ point + T).tolist() for point in points]


def ends(instance):
    rows = instance.constraints
    return [row.base.point for row in rows], [row.platform.point for row in rows]


def lengths(instance):
    return [row.value.value for row in instance.constraints]


def least(instance, **options):
    found = gspcli.sensors(instance, sigma=SIGMA, need=1.0, **options)
    return {str(s): v for s, v in zip(found.sensors, found.separations.least[:, 0], strict=True)}


@pytest.mark.parametrize("seed", HEXAPODS)
def test_legs_do_not_depend_on_frames(seed):
    instance, _, rng = hexapod(seed)
    base, platform = ends(instance)
    names = [str(s) for s in candidates(instance) if s.kind == "leg"]
    before = least(instance, sensors=names)
    motions = [(rotation_from_vector(rng.normal(size=3)), rng.normal(size=3)) for _ in range(2)]
    other = gspcli.hexapod(
        moved(base, *motions[0]), moved(platform, *motions[1]), lengths(instance)
    )
    after = least(other, sensors=names)
    assert before.keys() == after.keys()
    assert list(after.values()) == pytest.approx(list(before.values()), rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("seed", HEXAPODS)
def test_all_sensors_stay_with_their_bodies(seed):
    """Turned together with the frames all sensors tell the same modes apart equally well."""
    instance, _, rng = hexapod(seed)
    base, platform = ends(instance)
    B, P = (rotation_from_vector(rng.normal(size=3)) for _ in range(2))
    other = gspcli.hexapod(
        moved(base, B, np.zeros(3)), moved(platform, P, np.zeros(3)), lengths(instance)
    )

    def vector(numbers):
        return f"({', '.join(map(repr, numbers.tolist()))})"

    a, p, q = rng.normal(size=(3, 3))
    first = [
        f"leg {vector(p)} {vector(q)}",
        f"joint 2 base about {vector(a)} from {vector(q)}",
        f"joint 3 platform about {vector(a)} from {vector(p)}",
        "inclinometer",
    ]
    second = [
        f"leg {vector(P @ p)} {vector(B @ q)}",
        f"joint 2 base about {vector(B @ a)} from {vector(B @ q)}",
        f"joint 3 platform about {vector(P @ a)} from {vector(P @ p)}",
        f"inclinometer {vector(B[:, 2])}",
    ]
    before = gspcli.sensors(instance, sensors=first, sigma=SIGMA).separations
    after = gspcli.sensors(other, sensors=second, sigma=SIGMA).separations
    assert before.modes == after.modes
    np.testing.assert_allclose(after.least, before.least, rtol=1e-6, atol=1e-6)


def test_the_order_of_the_legs_and_their_names_mean_nothing():
    instance, _, rng = hexapod(4)
    order = rng.permutation(6).tolist()
    rows = [
        replace(instance.constraints[k], platform_name=f"Q{k}", base_name=f"A{k}") for k in order
    ]
    other = replace(instance, constraints=tuple(rows))
    before, after = least(instance), least(other)
    assert sorted(before.values()) == pytest.approx(sorted(after.values()), rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("seed", HEXAPODS)
def test_swapped_bodies(seed):
    """What tells modes apart tells their inverses apart: legs and joints change their bodies."""
    instance, _, _ = hexapod(seed)
    base, platform = ends(instance)
    swapped = gspcli.hexapod(
        [point.tolist() for point in platform],
        [point.tolist() for point in base],
        lengths(instance),
    )
    names = [str(s) for s in candidates(instance) if s.kind in ("leg", "joint")]
    other = {"platform": "base", "base": "platform"}

    def exchanged(name):
        kind, first, second, *rest = name.split(" ")
        if kind == "leg":
            return f"leg {second} {first}"
        return " ".join([kind, first, other[second], *rest])

    before = gspcli.sensors(instance, sensors=names, sigma=SIGMA).separations.least
    after = gspcli.sensors(swapped, sensors=list(map(exchanged, names)), sigma=SIGMA)
    np.testing.assert_allclose(after.separations.least, before, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_planar_bodies_have_mirror_modes_that_no_leg_tells_apart(seed):
    instance, _, _ = hexapod(10 + seed, planar=True)
    found = gspcli.sensors(instance)
    assert found.separations.least[found.of_kind("leg")].max() < 1e-6


def test_a_wrong_reading_picks_no_mode():
    """Readings of every mode pick it; readings between those of neighbours pick none."""
    for name in ("rubin-m2", "apo-tertiary", "nano-hexapod"):
        result = gspcli.solve(gspcli.load(instance_files()[name]))
        found = gspcli.sensors(result.instance)
        best = found.sensors[found.best]
        real = result.real
        reads = best.read(result.instance, result.R[real].real, result.T[real].real)[:, 0]
        gap = float(np.diff(np.sort(reads)).min())
        for k, value in enumerate(reads.tolist()):
            right = f"{best} = {value + gap / 50!r} ± {gap / 20!r}"
            assert gspcli.fit_readings(result, [right]).mode == k + 1
            wrong = f"{best} = {value + gap / 2!r} ± {gap / 20!r}"
            fit = gspcli.fit_readings(result, [wrong])
            assert (fit.mode, fit.modes) == (None, [])
            assert gspcli.fit_readings(result, [right, wrong]).modes == []
