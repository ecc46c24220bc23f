from __future__ import annotations

import flint
import numpy as np
import pytest
from flint import arb

import gspcli
from gspcli.certification.branches.taylor import MovingSystem
from gspcli.geometry.coordinates import choose, coordinates
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.geometry.random_instances import random_instance
from gspcli.motion import FollowOptions, MovingPlatform, measure, track
from gspcli.motion.following.chord_equations import DEGREE, Parts
from gspcli.motion.following.chords import prove
from gspcli.motion.following.moving_geometry import MovingGeometry
from gspcli.motion.following.trajectories import track_from
from gspcli.resources import data_path

MIXED = ["6PP", "6DLL", "PP PL LP PH HP DLL", "PL PL LP ALL ALH AHH"]


def random_platform(gsp_type, seed=1):
    rng = np.random.default_rng(seed)
    instance, (R, T) = random_instance(gspcli.parse_type(gsp_type), rng)
    return rng, instance, R, T


def nominal_values(instance):
    return np.array([constraint.value.value for constraint in instance.constraints])


def matrix_about(axis, angle):
    return rotation_from_vector(np.asarray(axis) / np.linalg.norm(axis) * angle)


@pytest.mark.parametrize("gsp_type", MIXED)
def test_both_proofs_agree_where_only_values_move(gsp_type):
    rng, instance, R, T = random_platform(gsp_type)
    t = np.linspace(0, 1, 6)[:, None]
    turn, move = rng.normal(size=(2, 1, 3)) * 0.03
    values = measure(instance, rotation_from_vector(t * turn) @ R, T + t * move)
    one, other = MovingPlatform(instance), MovingGeometry(instance, ())
    branch = np.zeros(1, int)
    start = one.points(R[None], T[None])
    quick = one.follow(one.internal(values)[None], branch, start)
    slow = other.follow(values[None], branch, start, FollowOptions())
    assert quick.stop == slow.stop == 0
    assert np.allclose(quick.points, slow.points, atol=1e-12)
    if slow.segments[0] == quick.segments[0]:
        assert slow.worst == pytest.approx(quick.worst, rel=0.1)


def test_cranks_about_one_axis_turn_everything():
    text = data_path("examples", "platform-6-6.yaml").read_text(encoding="utf-8")
    head, tail = text.split("base:\n")
    crank = ", crank: {centre: [1, 2, 0.5], axis: [1, -2, 2]}}"
    points, constraints = tail.split("constraints:")
    turning = "\n".join(
        line.replace("]}", "]" + crank) if "{point" in line else line for line in points.split("\n")
    )
    instance = gspcli.loads(f"{head}base:\n{turning}constraints:{constraints}")
    assert gspcli.loads(gspcli.dumps(instance)) == instance
    names = [c.name for c in coordinates(instance)]
    assert len(names) == 6
    angles = np.array([0, 25, -70, 120.0])
    values = np.tile(nominal_values(instance), (4, 1))
    found = track(instance, values, coordinates=dict.fromkeys(names, angles), modes=[1])
    assert found.certified
    assert not found.events
    for k, angle in enumerate(np.radians(angles)):
        Q, centre = matrix_about([1, -2, 2], angle), np.array([1, 2, 0.5])
        assert np.allclose(found.R[0, k], Q @ found.R[0, 0], atol=1e-11)
        assert np.allclose(found.T[0, k], Q @ (found.T[0, 0] - centre) + centre, atol=1e-11)
    # The same in one step as in the other three, and the claim is about the circle, not the chord.
    direct = track(
        instance, values[[0, 3]], coordinates=dict.fromkeys(names, angles[[0, 3]]), modes=[1]
    )
    assert np.allclose(direct.R[0, -1], found.R[0, -1], atol=1e-11)
    assert direct.segments > 3


def test_what_taylor_polynomials_leave_out_is_bounded():
    rng = np.random.default_rng(5)
    instance = gspcli.load(data_path("platforms", "t-top-head.yaml"))
    chosen = choose(instance, [f"crank.B{k}" for k in range(1, 7)])
    system = MovingSystem(instance, chosen)
    values = nominal_values(instance)
    rows = (
        np.concatenate((values, np.zeros(6))),
        np.concatenate((values * 1.01, [90, -60, 40, 80, -70, 30])),
    )
    part = system.on_part(rows, 0.0, 1.0)
    short = part.restricted(-0.25, 0.25, DEGREE)
    worst = np.zeros(2)
    for s in rng.uniform(0, 1, 10):
        with flint.ctx.workprec(128):
            exact = system.on_part(rows, s, s).quadrics[:, :, 0]
        off = np.linalg.norm(
            exact - np.einsum("kqdxy,d->kqxy", part.quadrics, (s - 0.5) ** np.arange(7)),
            ord=2,
            axis=(2, 3),
        )
        assert (off <= part.errors).all()
        worst[0] = max(worst[0], (off[:, 0] / part.errors[:, 0]).max())
        if abs(s - 0.5) <= 0.25:
            tau = (s - 0.5) * 2
            near = np.einsum("kqdxy,d->kqxy", short.quadrics, tau ** np.arange(DEGREE + 1))
            off = np.linalg.norm(exact - near, ord=2, axis=(2, 3))
            assert (off <= short.errors).all()
    # Not by far too much: a bound smaller by a factor of twenty would be wrong.
    assert worst[0] > 0.05
    assert float(arb(1)) == 1


def test_a_chord_to_another_place_is_not_proved():
    _, instance, R, T = random_platform("6PP")
    platform = MovingGeometry(instance, ())
    values = measure(instance, R, T)
    rows = np.stack((values, values * 1.00001))
    start = platform.points(R[None], T[None])
    found = platform.follow(rows[None], np.zeros(1, int), start, FollowOptions())
    part = platform.system.on_part((rows[0], rows[1]), 0.0, 1.0).restricted(-0.5, 0.5, DEGREE)
    parts = Parts.of(platform.system.shapes, [part])
    assert prove(parts, start, found.points[:, 1]).measure[0] < 0.98
    wrong = found.points[:, 1] + 0.05 * np.eye(8)[[5]]
    assert prove(parts, start, wrong).measure[0] > 0.98
    loose = Parts(
        parts.shapes, parts.quadrics, parts.errors + 0.1, *(parts.factors, parts.errors[:, :, 0])
    )
    assert prove(loose, start, found.points[:, 1]).measure[0] > 0.98


def test_following_from_given_poses_needs_no_coordinates():
    _, instance, R, T = random_platform("6PP")
    values = measure(instance, R, T)
    found = track_from(instance, np.stack((values, values * 1.001)), R[None], T[None])
    assert found.coordinates == ()
    assert np.isfinite(found.conditions).all()
