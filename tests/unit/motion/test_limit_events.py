"""Limits along trajectories: where ranges and cones are left."""

from dataclasses import replace

import numpy as np
import pytest

from gspcli.catalogue.kinds import DPH
from gspcli.geometry.instance import Side
from gspcli.geometry.numbers import Number
from gspcli.motion import measure, track
from gspcli.motion.limit_events import _crossings, limit_events
from tests.support.limited import one_leg, study


def test_ranges_are_left_at_the_exact_time():
    machine = study(legs=(85, 95))
    home = measure(machine, np.eye(3), np.array([0, 0, 60.0]))
    values = np.stack((home, home + 8 * np.eye(6)[1], home))
    found = limit_events(track(machine, values, t=[0, 1, 3], near=(np.eye(3), [0, 0, 60.0])))
    ranges = [event for event in found if event.kind == "range"]
    assert [(event.constraint, event.leaves) for event in ranges] == [(1, True), (1, False)]
    part = (95 - home[1]) / 8
    assert ranges[0].low == ranges[0].high == pytest.approx(part)
    assert ranges[1].low == pytest.approx(1 + 2 * (1 - part))


def test_cones_are_left_between_rows():
    machine = study(base_angle=5)
    T = np.array([[k * 3.0, 0, 60] for k in range(6)])
    R = np.broadcast_to(np.eye(3), (6, 3, 3))
    values = measure(machine, R, T)
    found = limit_events(track(machine, values, t=np.arange(6), near=(R[0], T[0])))
    cones = [event for event in found if event.kind == "cone"]
    assert cones
    assert all(event.leaves and event.body == "base" and event.mode for event in cones)
    assert all(event.high - event.low == 1 for event in cones)
    # The first is left where the tilt is five degrees.
    first = cones[0]
    legs = T - machine.constraints[first.constraint].base.point
    legs = legs + machine.constraints[first.constraint].platform.point
    tilt = np.degrees(
        np.arccos(legs @ legs[0] / np.linalg.norm(legs, axis=1) / np.linalg.norm(legs[0]))
    )
    assert tilt[int(first.low)] <= 5 < tilt[int(first.high)]
    assert limit_events(track(study(), values, t=np.arange(6), near=(R[0], T[0]))) == []


@pytest.mark.parametrize(
    ("side", "changes"),
    [
        (Side.POSITIVE, {0: True, 10 / 3: False}),
        (Side.NEGATIVE, {0: True, 2 / 3: False, 2: True}),
        (Side.BOTH, {0: True, 2 / 3: False, 2: True, 10 / 3: False}),
    ],
)
def test_signed_distances_cross_ranges_on_their_side(side, changes):
    """From -2 to 1 in four seconds, with a range from 1/2 to 3/2."""
    machine = one_leg((1, 2))
    planar = replace(
        machine.constraints[0],
        kind=DPH,
        side=side,
        limits=(Number.of("0.5"), Number.of("1.5")),
    )
    machine = replace(machine, constraints=(planar, *machine.constraints[1:]))
    times, outside = _crossings(machine, 0, np.array([0.0, 4]), np.array([-2.0, 1]))
    found, state = {}, False
    for time, now in zip(times, outside, strict=True):
        if now != state:
            found[time], state = now, now
    assert list(found.values()) == list(changes.values())
    assert list(found) == pytest.approx(list(changes))
