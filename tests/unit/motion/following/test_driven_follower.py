"""The step of a controller over rails and arms: its numbers, its proofs, what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gspcli
from gspcli.export.controller.writing import controller
from gspcli.geometry.machine import Machine
from gspcli.motion import FollowerStatus
from gspcli.motion.following.follower import platform_numbers
from tests.support.driven_machines import driven, some_pose
from tests.support.independent_machines import upside_down


def swapped(instance):
    """Return the machine with base and platform exchanged, and its home pose."""
    T = np.array([x.value for x in instance.home.position])
    home = gspcli.HomePose((-T).tolist(), [1, 0, 0, 0])
    return replace(instance, constraints=upside_down(instance), home=home)


@pytest.mark.parametrize("name", ["6-PUS", "mixed", "reachy-mini-head", "t-top-head"])
@pytest.mark.parametrize("turned", [False, True])
def test_a_step_reaches_the_pose_of_the_drives(name, turned) -> None:
    instance = driven(name)
    instance = swapped(instance) if turned else instance
    drives, rng = Machine.of(instance), np.random.default_rng(2)
    T0 = np.array([x.value for x in instance.home.position])
    for _ in range(5):
        R, T, q = some_pose(instance, rng, spread=0.05)
        follower = gspcli.Follower(instance, np.eye(3), T0)
        assert np.allclose(drives.from_readings(follower.values), drives.inverse(np.eye(3), T0))
        assert follower.forward(drives.readings(q)) is FollowerStatus.PROVED
        assert np.allclose(follower.R, R, atol=1e-12)
        assert np.allclose(follower.T, T, atol=1e-12)
        # q' = J t / g, in the units of the file.
        expected = drives.jacobian(R, T, q) / drives.gains(R, T, q)[:, None]
        expected /= drives.units[:, None]
        assert np.allclose(follower.jacobian, expected, atol=1e-10 * np.abs(expected).max())


def test_a_range_and_readings_of_a_slide_are_kept() -> None:
    instance = driven("6-PUS")
    point = instance.constraints[2].base
    slide = gspcli.Slide(point.slide.direction, [-0.05, 0.1], offset=0.02, scale=0.25)
    moved = replace(instance.constraints[2], base=replace(point, slide=slide))
    rows = list(instance.constraints)
    rows[2] = moved
    instance = replace(instance, constraints=tuple(rows))
    follower = gspcli.Follower(instance, np.eye(3), [0, 0, 0.6])
    # At home q = 0: the reading is -offset / (1 + scale).
    assert follower.values == pytest.approx([0, 0, -0.016, 0, 0, 0], abs=1e-12)
    inside, outside = ((q - 0.02) / 1.25 for q in (0.0999, 0.1001))
    values = follower.values
    values[2] = outside
    assert follower.forward(values) is FollowerStatus.RANGE
    values[2] = inside
    assert follower.forward(values) is FollowerStatus.PROVED
    drives = Machine.of(instance)
    q = drives.inverse(follower.R, follower.T)
    assert q == pytest.approx([0, 0, 0.0999, 0, 0, 0], abs=1e-12)
    with_margin = gspcli.Follower(instance, np.eye(3), [0, 0, 0.6], margin=0.01)
    values[2] = outside
    assert with_margin.forward(values) is FollowerStatus.PROVED


def test_the_end_of_what_a_rod_reaches_is_never_crossed() -> None:
    """Carriages that go apart until a rod is straight between joint and rail: a fold."""
    instance = driven("6-PUS")
    follower = gspcli.Follower(instance, np.eye(3), [0, 0, 0.6])
    way, last = np.array([1.0, -1, 1, -1, 1, -1]), 0.0
    for size in np.arange(0.01, 1.0, 0.01):
        if follower.forward(size * way) is not FollowerStatus.PROVED:
            break
        last = size
    else:
        pytest.fail("proved a metre apart")
    drives = Machine.of(instance)
    _, _, r = drives.ends(follower.R, follower.T, last * way)
    assert np.allclose(np.linalg.norm(r, axis=-1), drives.rods, rtol=1e-12)
    J = drives.jacobian(follower.R, follower.T, last * way)
    begun = drives.jacobian(np.eye(3), np.array([0, 0, 0.6]), np.zeros(6))
    # It is refused since it becomes singular, or since it is too long: not beyond a change of sign.
    assert np.linalg.det(J) * np.linalg.det(begun) > 0


def test_shared_carriages_are_refused_in_one_line() -> None:
    with pytest.raises(gspcli.ArgumentError, match=r"slide\.B1: several rods share it"):
        platform_numbers(driven("delta"))


def test_the_program_names_its_slides_and_nothing_else_changes() -> None:
    header, source = controller(driven("6-PUS"), "rails")
    assert "1 slide B1 P1-B1" in header
    assert "The value of a slide is its way from where the file states its joint" in header
    assert "of the two places of a slide the one nearer to zero" in header
    assert "or a slide does not reach" in header
    assert "BASE_SLIDE" in source
    assert "crank_angle" not in source
    legs = controller(gspcli.example("nano-hexapod"), "legs")
    assert "SLIDE" not in "".join(legs)
