"""Machines with arms or rails from the numbers of a drawing."""

import numpy as np
import pytest

from gspcli.errors import GspError
from gspcli.geometry.drives import Drives
from gspcli.solver import solve
from gspcli.spec import read_text
from gspcli.spec.motor_files import motor_file

RADII = "base=80,12 platform=55,10"
MACHINES = {
    "level arms": ("rotary", f"{RADII} horn=24 rod=130", 6),
    "rods from height": ("rotary", f"{RADII} horn=24 height=120 axis-angle=7.5", 6),
    "raised arms": ("rotary", f"{RADII} horn=24 rod=130 height=110 axis-angle=-20 horns=in", 6),
    "rails": ("linear", f"{RADII} rod=200 tilt=25 range=-40:70 unit=cm", 6),
    "rails, height": ("linear", f"{RADII} height=-150", 6),
    "delta": ("linear", "base=200,0 platform=50,30 rod=250 rails=3", 3),
}


@pytest.mark.parametrize("name", MACHINES)
def test_machines_are_at_home_with_all_drives_at_zero(name):
    sort, words, count = MACHINES[name]
    reading = read_text(motor_file(sort, words.split()))
    assert not reading.warnings
    instance = reading.instance
    drives = Drives.of(instance)
    assert drives.count == count
    R, T = instance.home.R(1.0), instance.home.T
    q = drives.inverse(R, T)
    np.testing.assert_allclose(q, 0, atol=1e-10 * drives.rods[0])
    # All motors are alike: the platform rises without turning when all move by the same.
    rise = drives.inverse(R, T + np.array([0, 0, 1e-3]))
    np.testing.assert_allclose(rise, rise[0], rtol=1e-6)
    assert rise[0] > 0
    gains = drives.gains(R, T, q)
    np.testing.assert_allclose(gains, gains[0], rtol=1e-9)


def test_the_numbers_are_those_of_the_drawing():
    instance = read_text(motor_file("rotary", MACHINES["raised arms"][1].split())).instance
    drives = Drives.of(instance)
    points = drives.points(np.zeros(6))
    np.testing.assert_allclose(drives.arms, 24)
    np.testing.assert_allclose(drives.rods, 130)
    for row in instance.constraints:
        np.testing.assert_allclose(
            np.linalg.norm(row.base.crank.centre[0].value + 1j * row.base.crank.centre[1].value), 80
        )
        np.testing.assert_allclose(np.linalg.norm(row.platform.point), 55)
    lengths = np.linalg.norm(
        instance.home.T + [row.platform.point for row in instance.constraints] - points, axis=1
    )
    np.testing.assert_allclose(lengths, 130, rtol=1e-12)
    assert np.degrees(drives.high).tolist() == pytest.approx([60] * 6)


def test_rods_of_a_pair_of_a_delta_are_parallel_and_share_a_carriage():
    instance = read_text(motor_file("linear", MACHINES["delta"][1].split())).instance
    drives = Drives.of(instance)
    _, _, r = drives.ends(np.eye(3), instance.home.T, np.zeros(3))
    for k in range(3):
        first, second = drives.users(k)
        np.testing.assert_allclose(r[first], r[second], atol=1e-12)
    assert instance.home.T[2] < 0


@pytest.mark.parametrize(
    ("sort", "words", "message"),
    [
        ("rotary", "base=80 horn", "found 'horn', expected KEY=NUMBER with base, "),
        ("rotary", "base=80,12 radius=3", "found 'radius=3'"),
        ("rotary", "base=80 base=81", "found base twice"),
        ("rotary", "base=80,12", "platform and horn missing"),
        ("rotary", "base=80 platform=5,5 horn=24 rod=9", "base: found '80', expected RADIUS,HALF_"),
        ("rotary", f"{RADII} horn=24", "found neither rod nor height"),
        ("rotary", f"{RADII} horn=24 rod=x", "rod: found 'x'"),
        ("rotary", f"{RADII} horn=-24 rod=130", "horn: found -24, expected a length above 0"),
        ("rotary", f"{RADII} horn=24 rod=20", "rod: found 20, expected more than 42.9247"),
        ("rotary", f"{RADII} horn=24 rod=130 height=300", "rod 130 does not join arm and platform"),
        ("rotary", f"{RADII} horn=24 rod=130 range=60", "range: found '60', expected LOW:HIGH"),
        ("rotary", f"{RADII} horn=24 rod=130 range=60:-60", "range: found '60:-60'"),
        ("rotary", f"{RADII} horn=24 rod=130 horns=up", "horns: found 'up', expected out or in"),
        ("linear", f"{RADII} rod=130 height=3", "found rod and height, expected one of them"),
        (
            "linear",
            "base=8,60 platform=5,0 rod=30",
            "expected a half angle",
        ),
    ],
)
def test_mistakes_of_a_drawing(sort, words, message):
    with pytest.raises(GspError, match=message):
        motor_file(sort, words.split())


def test_angles_of_a_drawing_are_exact():
    """The file had the fraction 11111000000000000001/…, and the machine was not symmetric."""
    text = motor_file("rotary", ["base=80,11.111", "platform=55,10", "horn=24", "rod=130"])
    assert "80*cosd(11.111)" in text
    assert "80*cosd(108.889)" in text
    result = solve(read_text(text).instance)
    assert result.verdict == "complete"
    words = ["base=80,5*sqrt(2)", "platform=55,10", "horn=24", "rod=130", "axis-angle=sqrt(3)"]
    text = motor_file("rotary", words)
    assert "cosd(120 - (5*sqrt(2)))" in text
    assert "cosd(30 - (sqrt(3)))" in text
