"""What sensors read, how they are written, and how well they tell modes apart."""

from __future__ import annotations

import itertools
import json
import math

import numpy as np
import pytest

import gspcli
from gspcli.errors import ArgumentError, NotFiniteError
from gspcli.geometry.euler import rotation_from_euler
from gspcli.geometry.machine import Machine
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.motion import measure
from gspcli.motion.singularities.scans import Axis, VariedNumbers, boundary, scan_grid
from gspcli.resources import instance_files
from gspcli.sensing.sensor_kinds import KINDS, candidates, parse_reading, parse_sensor
from gspcli.sensing.separations import default_sigmas
from tests.support.driven_machines import driven


def shipped(name):
    return gspcli.load(instance_files()[name])


@pytest.fixture(scope="module")
def m2():
    return shipped("rubin-m2")


@pytest.mark.parametrize("name", ["rubin-m2", "sdss-primary", "octahedral-3-3", "example-6.8"])
def test_candidates_are_written_as_they_are_read(name):
    instance = shipped(name)
    found = candidates(instance)
    assert len(set(map(str, found))) == len(found)
    for sensor in found:
        assert parse_sensor(str(sensor), instance) == sensor
        assert sensor.kind in KINDS


def test_a_leg_reads_what_a_constraint_would(m2):
    rng = np.random.default_rng(0)
    R, T = rotation_from_vector(rng.normal(size=(5, 3))), rng.normal(size=(5, 3))
    rows = m2.constraints
    sensor = parse_sensor("leg P2 B5", m2)
    other = gspcli.hexapod(
        [*(row.base.position for row in rows[1:]), rows[4].base.position],
        [*(row.platform.position for row in rows[:5]), rows[1].platform.position],
        [1] * 6,
    )
    np.testing.assert_allclose(sensor.read(m2, R, T)[:, 0], measure(other, R, T)[:, 5])


def test_an_inclinometer_reads_two_of_three_angles(m2):
    angles = np.array([[10.0, -20.0, 40.0], [170.0, 30.0, -5.0], [-95.0, 80.0, 0.0]])
    R = rotation_from_euler("ZYX", np.radians(angles))
    read = parse_sensor("inclinometer", m2).read(m2, R, np.zeros((3, 3)))
    np.testing.assert_allclose(read, angles[:, :2], atol=1e-9)
    sensor = parse_sensor("inclinometer", m2)
    # Turned by 10 degrees about x, and by 170 about it: 160 between the verticals.
    assert sensor.apart(m2, np.array([10.0, 0.0]), np.array([170.0, 0.0])) == pytest.approx(160)


def test_a_joint_reads_the_angle_of_its_leg(m2):
    """A leg along z, then turned by 30 degrees about x by the right-hand rule."""
    base = m2.constraints[0].base.point
    end = m2.constraints[0].platform.point
    angle = math.radians(30)
    tip = np.add(base, [0, -math.sin(angle), math.cos(angle)])
    sensor = parse_sensor("joint 1 base about x", m2)
    assert sensor.read(m2, np.eye(3), tip - end) == pytest.approx(30)
    apart = sensor.apart(m2, np.array([[-179.0]]), np.array([[179.0]]))
    assert apart == pytest.approx(2)
    seen = parse_sensor("joint 1 platform about x from (0, 0, -1)", m2)
    assert seen.read(m2, np.eye(3), tip - end) == pytest.approx(30)


def test_readings(m2):
    for text in ("leg P1 B2=2.5±.1", "leg  P1  B2 = 5/2 +- 1/10", " leg P1 B2 = 2.5 +/- 0.1 "):
        reading = parse_reading(text, m2)
        assert (reading.values, reading.sigma) == ((2.5,), 0.1)
        assert str(reading) == "leg P1 B2 = 2.5 ± 0.1"
    assert parse_reading("inclinometer = -1, 2 ± 0.1", m2).values == (-1.0, 2.0)
    with pytest.raises(ArgumentError, match="found none"):
        gspcli.fit_readings(gspcli.solve(m2), [])


def test_separations_are_those_of_the_definition():
    """Worst pair, in standard deviations, by loops over modes and sensors."""
    instance = shipped("apo-tertiary")
    found = gspcli.sensors(instance)
    result = gspcli.solve(instance)
    R, T = result.R[result.real].real, result.T[result.real].real
    closest = np.inf
    for pair in itertools.combinations(range(len(R)), 2):
        differences = [
            float(s.apart(instance, *(s.read(instance, R[k], T[k]) for k in pair))) / sigma
            for s, sigma in zip(found.sensors, found.sigmas, strict=True)
        ]
        closest = min(closest, max(differences))
        assert (found.separations.least[:, 0] <= np.array(differences) * (1 + 1e-9)).all()
    assert found.separations.closest[0] == pytest.approx(closest)
    for k, sensor in enumerate(found.sensors):
        first, second = found.separations.worst[k, 0] - 1
        read = [sensor.read(instance, R[i], T[i]) for i in (first, second)]
        apart = float(sensor.apart(instance, *read)) / found.sigmas[k]
        assert found.separations.least[k, 0] == pytest.approx(apart)


def test_rows_of_values(m2):
    """Each row is as if it were that of the instance."""
    stated = np.array([row.value.value for row in m2.constraints])
    values = np.array([stated, stated + 0.003])
    found = gspcli.sensors(m2, values, sensors=["leg P1 B2", "inclinometer"])
    for k, row in enumerate(values.tolist()):
        one = gspcli.set_values(m2, [f"{i}={x!r}" for i, x in enumerate(row, 1)])
        alone = gspcli.sensors(one, sensors=["leg P1 B2", "inclinometer"])
        np.testing.assert_allclose(
            found.separations.least[:, k], alone.separations.least[:, 0], rtol=1e-9
        )


def test_rows_with_joints_that_move():
    instance = shipped("t-top-head")
    stated = [[row.value.value for row in instance.constraints]] * 2
    found = gspcli.sensors(
        instance, stated, coordinates={"crank.B1": [0, 5]}, sensors=["leg P1 B2", "inclinometer"]
    )
    alone = gspcli.sensors(instance, sensors=["leg P1 B2", "inclinometer"])
    least = found.separations.least
    np.testing.assert_allclose(least[:, 0], alone.separations.least[:, 0], atol=1e-6)
    assert np.abs(least[1, 1] - least[1, 0]) > 1e-3


def test_the_known_side_leaves_out_mirror_images():
    instance = shipped("simscape-hexapod")
    both, one = (gspcli.sensors(instance, known_side=side) for side in (False, True))
    assert both.separations.modes[0] == 2 * one.separations.modes[0]
    legs = both.of_kind("leg")
    assert both.separations.least[legs].max() < 1e-6


def test_near_a_fold_no_sensor_suffices():
    """Leg 1 of the 3-3 is nearly where a pair of modes meets, as `gsp scan --folds` proves."""
    instance = shipped("octahedral-3-3")
    found = scan_grid(VariedNumbers(instance, [Axis("1", (1.0, 1.5, 2.0, 2.5))]))
    limits = boundary(found)
    fold = limits.crossings[0]
    inside = -1e-9 if fold.change < 0 else 1e-9
    near = gspcli.set_values(instance, [f"1={fold.values[0] * (1 + inside)!r}"])
    found = gspcli.sensors(near)
    assert found.hopeless.all()
    assert not found.suffices
    closest = found.closest_json()
    assert closest["hopeless"] == 1
    assert closest["translation"] < 6 * found.sigmas[0]
    # What is far apart and reads the same is not near a fold.
    far = gspcli.sensors(shipped("simscape-hexapod"), sensors=["leg P1 B2"])
    assert not far.suffices
    assert not far.hopeless.any()


def test_standard_deviations(m2):
    defaults = default_sigmas(m2)
    assert defaults["leg"] == defaults["distance"] == 0.0019
    found = gspcli.sensors(m2, sensors=["leg P1 B2", "inclinometer"], sigma={"leg": 0.0038})
    usual = gspcli.sensors(m2, sensors=["leg P1 B2", "inclinometer"])
    ratio = usual.separations.least[:, 0] / found.separations.least[:, 0]
    assert ratio.tolist() == pytest.approx([2, 1])


def test_the_result_says_itself_in_one_line_and_cannot_be_changed(m2):
    stated = [row.value.value for row in m2.constraints]
    found = gspcli.sensors(m2, [stated] * 3)
    assert "\n" not in repr(found)
    json.dumps(found.to_json(), allow_nan=False)
    assert len(found.to_frame()) == len(found.sensors)
    for array in (found.values, found.sigmas, found.separations.least, found.separations.worst):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
    fit = gspcli.fit_readings(gspcli.solve(m2), "inclinometer = 0, 0 ± 1")
    assert "\n" not in repr(fit)
    assert fit.to_frame()["fits"].tolist() == [False, True]
    with pytest.raises(ValueError, match="read-only"):
        fit.off[...] = 0


def test_without_two_modes_there_is_nothing_to_tell_apart():
    found = gspcli.sensors(shipped("no-real-pose"))
    assert (found.suffices, found.best) == (True, None)
    assert found.to_json()["closest"] is None
    assert "no real pose" not in repr(found)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"need": -1}, "need: found -1"),
        ({"sigma": {"legs": 1}}, "sigma: found 'legs'"),
        ({"sigma": {"leg": -1}}, "above 0"),
        ({"sensors": ["inclinometer", "leg P1 B8"]}, r"sensors\[1\], column 8: found 'B8'"),
        ({"sensors": []}, "sensors: found none"),
        ({"values": np.zeros((0, 6))}, "values: found no set of values"),
        ({"values": [[1] * 5]}, r"values: found shape \(1, 5\)"),
        ({"values": [[1, 1, 1, 1, 1, -1]]}, r"values\[0\]\[5\]: found -1"),
        ({"values": [[1] * 6], "coordinates": {"base.B1.x": [1]}}, "expected a drive"),
    ],
)
def test_mistakes(m2, arguments, message):
    with pytest.raises(ArgumentError, match=message):
        gspcli.sensors(m2, **arguments)


def test_the_side_of_a_plane_is_that_of_the_instance():
    instance = shipped("sdss-primary")
    values = measure(instance, np.eye(3), np.zeros(3))
    assert gspcli.sensors(instance, [values], sensors=["inclinometer"]).separations.modes == [8]
    with pytest.raises(ArgumentError, match=r"values\[0\]\[2\]: .* the positive side"):
        gspcli.sensors(instance, [np.where(np.arange(6) == 2, -values, values)])


def test_infinitely_many_poses_are_no_modes():
    with pytest.raises(NotFiniteError):
        gspcli.sensors(shipped("three-vee-250mm"))


SPARE = """\
gsp: 1
units: {length: mm, angle: deg}
platform:
  P1: {point: [0, 0, 0]}
  L1: {line: {point: [3, 1, 0], direction: [1, 2, 2]}}
  H1: {plane: {point: [1, 1, 4], normal: [2, -1, 2]}}
base:
  B1: {point: [10, 0, 0]}
  M1: {line: {point: [0, 9, 1], direction: [4, 0, 3]}}
  G1: {plane: {point: [0, 0, -7], normal: [0, 3, 4]}}
constraints:
"""
PAIRS = {
    "distance P1 M1": "DPL",
    "distance L1 B1": "DLP",
    "distance P1 G1": "DPH",
    "distance H1 B1": "DHP",
    "distance L1 M1": "DLL",
    "angle L1 M1": "ALL",
    "angle L1 G1": "ALH",
    "angle H1 M1": "AHL",
    "angle H1 G1": "AHH",
}


def spare(*rows):
    lines = [f"  - {{{what}: [{a}, {b}], value: 5}}\n" for what, a, b in map(str.split, rows)]
    return gspcli.loads(SPARE + "".join(lines))


@pytest.mark.parametrize("text", PAIRS)
def test_a_distance_or_an_angle_reads_what_a_constraint_would(text):
    others = [row for row in ("distance P1 B1", *PAIRS) if row != text]
    without, within = spare(*others[:6]), spare(text, *others[:5])
    sensor = parse_sensor(text, without)
    assert str(sensor) == text
    assert sensor.measured.name == PAIRS[text]
    rng = np.random.default_rng(1)
    R, T = rotation_from_vector(rng.normal(size=(9, 3))), rng.normal(size=(9, 3)) * 20
    found, expected = sensor.read(without, R, T)[:, 0], measure(within, R, T)[:, 0]
    np.testing.assert_allclose(found, expected, rtol=1e-13)
    assert sensor.apart(without, np.array([3.0]), np.array([5.0])) == 2
    with pytest.raises(ArgumentError, match="found constraint 1, expected another"):
        parse_sensor(text, within)


def test_a_distance_of_two_points_is_a_leg():
    platform = spare(*list(PAIRS)[:6])
    assert str(parse_sensor("distance P1 B1", platform)) == "leg P1 B1"
    assert str(parse_sensor("distance P1 (1, 2, 3)", platform)) == "leg P1 (1, 2, 3)"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("distance H1 M1 = 1 +- 1", "column 1: found a plane and a line, which have no distance"),
        ("angle P1 M1 = 1 +- 1", "column 1: found a point and a line, which have no angle"),
        ("distance M1 B1 = 1 +- 1", "column 10: found 'M1', expected a point, line or plane of"),
        ("distance L1 B1 = -1 +- 1", "column 18: found -1, expected a distance of at least 0"),
        ("angle L1 M1 = 181 +- 1", "column 15: found 181, expected an angle of LL from 0 to 180"),
        ("angle H1 = 1 +- 1", "column 9: found no more words, expected a point, line or plane"),
    ],
)
def test_mistakes_of_distances_and_angles(text, message):
    with pytest.raises(ArgumentError, match=message):
        parse_reading(text, spare(*list(PAIRS)[2:5], *list(PAIRS)[6:9]))


def test_a_distance_to_a_plane_has_a_sign():
    platform = spare("distance P1 B1", *list(PAIRS)[:2], *list(PAIRS)[3:6])
    assert parse_reading("distance P1 G1 = -2 +- 1", platform).values == (-2.0,)


def test_a_point_and_a_line_tell_modes_apart():
    given = spare("distance P1 B1", *list(PAIRS)[1:3], *list(PAIRS)[6:9])
    R, T = rotation_from_vector(np.array([0.3, -0.2, 0.5])), np.array([4.0, 3.0, 25.0])
    values = measure(given, R, T)
    at = gspcli.set_values(given, {k + 1: abs(x) for k, x in enumerate(values)})
    result = gspcli.solve(at)
    near = [np.abs(one.T - T).max() < 1e-9 for one in result.real_solutions]
    assert sum(near) == 1
    reading = parse_sensor("distance P1 M1", at).read(at, R, T)[0]
    fit = gspcli.fit_readings(result, [f"distance P1 M1 = {float(reading)!r} +- 0.001"])
    assert len(near) > 1
    assert fit.mode == near.index(True) + 1


@pytest.mark.parametrize("name", ["6-PUS", "mixed", "delta"])
def test_rails_and_arms_move_and_rods_stay(name):
    """Each row is the machine with its joints moved: solving that gives the same modes."""
    machine = driven(name)
    drives = Machine.of(machine)
    home = gspcli.solve(machine).home
    q = drives.nearest(home.R, home.T)
    rows = np.tile([float(row.value.value) for row in machine.constraints], (2, 1))
    readings = drives.readings(np.stack((q, q + 0.01)))
    given = {}
    for k, column in enumerate(readings.T):
        if drives.names[k].isdecimal():
            rows[:, int(drives.names[k]) - 1] = column
        else:
            given[drives.names[k]] = column
    found = gspcli.sensors(machine, rows, coordinates=given, sensors=["inclinometer"])
    for k, moved in enumerate((q, q + 0.01)):
        result = gspcli.solve(drives.instance_at(moved))
        assert found.separations.modes[k] == result.counts.real > 1
