"""One machine with masses, limits and cranks, stated in several ways."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import gspcli
from gspcli.dynamics import inverse_dynamics, natural_modes
from gspcli.geometry.instance import METRES, Instance
from gspcli.geometry.machine import Machine
from gspcli.geometry.numbers import Number
from tests.support.driven_machines import driven, some_pose, weighed
from tests.support.restated import as_data, in_radians, in_unit, stated

MACHINES = ["t-top-head", "delta", "mixed", "6-PUS"]


@pytest.fixture(scope="module", params=MACHINES)
def heavy(request: pytest.FixtureRequest) -> tuple[Instance, np.ndarray, np.ndarray]:
    """Return a machine with masses in metres, and a pose."""
    rng = np.random.default_rng(2)
    machine = weighed(driven(request.param), rng)
    R, T, _ = some_pose(machine, rng)
    metre = METRES[machine.units.length]
    if machine.units.length != "m":
        pytest.skip("stated in another unit")
    return machine, R, np.asarray(T) * metre


@pytest.mark.parametrize("unit", ["mm", "in"])
def test_torques_speeds_and_frequencies_have_no_unit_of_length(heavy: Any, unit: str) -> None:
    machine, R, T = heavy
    other, metre = in_unit(machine, unit), METRES[unit]
    # Rods of one drive let the platform only shift.
    turning = np.array([0.3, -0.2, 0.1]) * (Machine.of(machine).count == 6)
    moving = np.array([0.05, 0.02, -0.04])
    answers = []
    for one, length in ((machine, 1.0), (other, metre)):
        twist = np.concatenate((turning, moving / length))
        found = inverse_dynamics(one, R, T / length, twists=twist, accelerations=2 * twist)
        modes = natural_modes(one, R, T / length, stiffness=1e5)
        answers.append((found.torques, found.powers, found.forces, modes.frequencies))
    for first, second in zip(*answers, strict=True):
        assert second == pytest.approx(first, rel=1e-8, abs=1e-9 * np.abs(first).max())


def moved_home(machine: Instance, degrees: float, lift: float) -> tuple[Any, Any]:
    home = gspcli.solve(machine).home
    R, T = home.R.real, home.T.real
    turn = Rotation.from_euler("x", degrees, degrees=True).as_matrix()
    return (R, T), (turn @ R, T + np.array([0, 0, lift]))


#: Limits of a path of the M2 hexapod of which each in turn is the slowest: drives and the platform
#: in m/s, turning in degrees a second.
LIMITS = {
    "drives": {"drives": 1e-5, "platform": 1.0, "turn": 60.0},
    "platform": {"drives": 1.0, "platform": 1e-5, "turn": 60.0},
    "turn": {"drives": 1.0, "platform": 1.0, "turn": 0.001},
}


def duration(machine: Instance, ends: Any, speed: Any, acceleration: Any) -> float:
    return float(
        np.asarray(gspcli.path(machine, *ends, speed=speed, acceleration=acceleration).t)[-1]
    )


@pytest.mark.parametrize("slow", LIMITS)
def test_each_limit_of_a_path_binds_in_turn_in_each_unit(slow: str) -> None:
    machine = gspcli.example("rubin-m2")
    ends = moved_home(machine, 0.05, 0.001)
    speed, quick = LIMITS[slow], {"drives": 1e3, "platform": 1e3, "turn": 6e4}
    whole = duration(machine, ends, speed, quick)
    # It is this limit that binds: twice as high, the path takes half of the time.
    faster = duration(machine, ends, speed | {slow: 2 * speed[slow]}, quick)
    assert faster == pytest.approx(whole / 2, rel=0.01)
    radians = speed | {"turn": np.radians(speed["turn"])}
    turned = quick | {"turn": np.radians(quick["turn"])}
    assert duration(in_radians(machine), ends, radians, turned) == pytest.approx(whole, rel=1e-6)
    large = {key: x * (1 if key == "turn" else 1000) for key, x in speed.items()}
    fast = {key: x * (1 if key == "turn" else 1000) for key, x in quick.items()}
    ends = [(R, T * 1000) for R, T in ends]
    assert duration(in_unit(machine, "mm"), ends, large, fast) == pytest.approx(whole, rel=1e-6)


#: Where the head of T-Top is at home.
HOME = np.array([0, 0, 0.170294539])


def cranked(change: Callable[[Any], None] = lambda one: None) -> Instance:
    """Return the head of T-Top with ranges of its cranks and a cone at each, stated otherwise."""
    data = as_data(gspcli.example("t-top-head"))
    machine = gspcli.example("t-top-head")
    for k, (one, row) in enumerate(zip(data["base"].values(), machine.constraints, strict=True)):
        at = np.array([x.value for x in row.base.position])
        end = np.array([x.value for x in row.platform.position]) + HOME
        one["point"] = at.tolist()
        one["crank"] = {
            "centre": [Number.of(x).value for x in one["crank"]["centre"]],
            "axis": [Number.of(x).value for x in one["crank"]["axis"]],
            "range": [-40, 50],
        }
        one["cone"] = {"axis": (end - at).tolist(), "half_angle": 12 + k}
        change(one)
    return stated(data)


def volume(machine: Instance) -> tuple[float, float]:
    """Return bounds of the volume about home, on the working modes of home."""
    found = gspcli.workspace(machine, np.eye(3), HOME, tolerance=0.3)
    return found.volume


@pytest.fixture(scope="module")
def whole() -> tuple[float, float]:
    found = volume(cranked())
    assert 0 < found[0] < found[1]
    return found


def test_the_centre_of_a_crank_may_be_anywhere_on_its_axis(whole: tuple[float, float]) -> None:
    def slid(one: Any) -> None:
        crank = one["crank"]
        shift = 0.07 * np.array(crank["axis"]) / np.linalg.norm(crank["axis"])
        crank["centre"] = (np.array(crank["centre"]) + shift).tolist()

    assert volume(cranked(slid)) == pytest.approx(whole, rel=1e-6)


def test_where_a_crank_is_stated_changes_nothing_and_cones_turn_with_arms(
    whole: tuple[float, float],
) -> None:
    def turned(one: Any) -> None:
        crank = one["crank"]
        axis = np.array(crank["axis"]) / np.linalg.norm(crank["axis"])
        turn = Rotation.from_rotvec(np.radians(25) * axis).as_matrix()
        arm = np.array(one["point"]) - crank["centre"]
        one["point"] = (np.array(crank["centre"]) + turn @ arm).tolist()
        one["cone"]["axis"] = (turn @ one["cone"]["axis"]).tolist()
        crank["range"] = [x - 25 for x in crank["range"]]

    machine = cranked(turned)
    # The stated pose has other numbers of the drives: these are the working modes of the first.
    found = gspcli.workspace(
        machine,
        np.eye(3),
        HOME,
        working_modes=Machine.of(cranked()).working_modes(np.eye(3), HOME),
        tolerance=0.3,
    )
    assert found.volume == pytest.approx(whole, rel=1e-6)
