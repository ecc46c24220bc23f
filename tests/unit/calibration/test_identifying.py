"""Machines from their logs: joints and conventions found without a file to start from."""

from __future__ import annotations

import re
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest

import gspcli
from gspcli.calibration.calibrating import Options
from gspcli.calibration.identifying import ORDERS, Identification, identify, identify_log
from gspcli.calibration.logs import read_log
from gspcli.errors import ArgumentError, IncompleteError, SpecError
from gspcli.geometry.euler import euler_from_rotation, rotation_from_euler
from gspcli.geometry.instance import Instance
from gspcli.geometry.primitives import as_array
from gspcli.geometry.quaternions import quaternion_from_rotation
from gspcli.motion.poses.inverse_kinematics import values_at
from gspcli.resources import instance_files

DOCS = Path(__file__).resolve().parents[3] / "docs"
HEAD = "1,2,3,4,5,6,x,y,z,rx,ry,rz"
MACHINE = "workspace-study"
HEXAPODS = [
    name
    for name, path in instance_files().items()
    if {row.kind.name for row in gspcli.load(path).constraints} == {"DPP"}
]


class Simulated:
    """Lengths and poses of a shipped machine about its home, with a noise of the lengths."""

    def __init__(
        self,
        name: str = MACHINE,
        count: int = 40,
        *,
        order: str = "XYZ",
        turn: float = 0.2,
        move: float = 0.2,
        noise: float = 1e-6,
        seed: int = 1,
    ) -> None:
        self.machine = gspcli.load(instance_files()[name])
        rng = np.random.default_rng(seed)
        self.length = float(np.mean([float(row.value.value) for row in self.machine.constraints]))
        R, T = home(self.machine, self.length)
        self.angles = euler_from_rotation(order, R) + rng.uniform(-turn, turn, (count, 3))
        self.R = rotation_from_euler(order, self.angles)
        self.T = T + move * self.length * rng.uniform(-1, 1, (count, 3))
        self.lengths = values_at(self.machine, self.R, self.T)
        self.lengths += noise * self.length * rng.normal(size=self.lengths.shape)

    def write(self, path: Path, *columns: np.ndarray, head: str = HEAD) -> str:
        """Write a log with these columns, and return its path."""
        rows = np.hstack(columns)
        lines = [",".join(f"{x:.10g}" if np.isfinite(x) else "" for x in row) for row in rows]
        path.write_text("\n".join([head, *lines]) + "\n", encoding="utf-8")
        return str(path)

    def error(self, found: Identification) -> float:
        """Return the largest error of a coordinate, in typical lengths."""
        return (
            max(
                float(np.abs(as_array(getattr(a, body).position) - there).max())
                for a, b in zip(found.instance.constraints, self.machine.constraints, strict=True)
                for body in ("platform", "base")
                for there in [as_array(getattr(b, body).position)]
            )
            / self.length
        )


def home(machine: Instance, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a pose of a machine; a made-up one of those whose values have no isolated one."""
    result = gspcli.solve(machine)
    if result.home is not None:
        return result.home.R, result.home.T
    if result.real.any():
        return result.R[result.real].real[0], result.T[result.real].real[0]
    return np.eye(3), length * np.array([0.1, 0.2, 1.0])


@pytest.mark.parametrize("name", HEXAPODS)
def test_a_shipped_hexapod(name: str, tmp_path: Path) -> None:
    """In a convention of its own: the order, the senses and the units are found."""
    rng = np.random.default_rng(HEXAPODS.index(name))
    order, senses = ORDERS[rng.integers(6)], rng.choice([1, -1], 3)
    degrees, factor = bool(rng.integers(2)), [1.0, 1e-3][rng.integers(2)]
    log = Simulated(name, 30, order=order)
    angles = log.angles * senses * (180 / np.pi if degrees else 1)
    found = identify(log.write(tmp_path / "log.csv", log.lengths, log.T * factor, angles))
    turns = found.turns
    assert (turns.order, turns.senses) == (order, tuple(senses))
    assert (turns.in_radians == 1) != degrees
    units = {"mm": 1e-3, "m": 1.0}
    assert units[found.place_unit] / units[found.leg_unit] == pytest.approx(1 / factor)
    assert found.ambiguous == ()
    assert found.doubts == ()
    assert log.error(found) < 2e-4
    # Errors are what the standard deviations say.
    true = np.array(truth(log.machine, found))
    off = (found.calibration.after - true) / found.calibration.sigma
    assert np.abs(off).max() < 5
    assert found.others[0][1] > 20 * found.scatter


def truth(machine: Instance, found: Identification) -> list[float]:
    """Return the true numbers that belong to those found."""
    numbers = []
    for name in found.calibration.names:
        body, point, axis = name.split(".")
        row = machine.constraints[int(point[1:]) - 1]
        numbers.append(float(as_array(getattr(row, body).position)["xyz".index(axis)]))
    return numbers


def test_a_pivot(tmp_path: Path) -> None:
    """The frame of the platform is that of the pivot, or the one in which the pivot is stated."""
    log, at = Simulated(), np.array([3.0, -5.0, 40.0])
    path = log.write(tmp_path / "log.csv", log.lengths, log.T + log.R @ at, np.degrees(log.angles))
    assert log.error(identify(path, pivot=(3.0, -5.0, 40.0))) < 2e-4
    beside = identify(path).instance.constraints
    for row, stated in zip(beside, log.machine.constraints, strict=True):
        apart = as_array(stated.platform.position) - as_array(row.platform.position)
        assert apart == pytest.approx(at, abs=0.1)
        assert as_array(row.base.position) == pytest.approx(as_array(stated.base.position), abs=0.1)


def test_offsets(tmp_path: Path) -> None:
    """A constant that each leg lacks is found if it is asked for, and proposed if it is not."""
    log, lacking = Simulated(), np.array([3.0, 4.0, 5.0, -20.0, 40.0, 10.0])
    path = log.write(tmp_path / "log.csv", log.lengths - lacking, log.T, log.angles)
    found = identify(path, offsets=True)
    assert log.error(found) < 1e-3
    numbers = dict(zip(found.calibration.names, found.calibration.after, strict=True))
    assert [numbers[f"offset.{k}"] for k in range(1, 7)] == pytest.approx(lacking, abs=0.1)
    with pytest.raises(IncompleteError) as raised:
        identify(path)
    last = str(raised.value).splitlines()[-1]
    assert re.match(r"with a constant of each leg \(--estimate offsets\) they fit to 0\.0", last)


def test_rotations_and_their_transposes(tmp_path: Path) -> None:
    log = Simulated()
    q = quaternion_from_rotation(log.R)
    head = HEAD.replace("rx,ry,rz", "qw,qx,qy,qz")
    found = identify(log.write(tmp_path / "log.csv", log.lengths, log.T, q, head=head))
    assert not found.turns.transposed
    assert log.error(found) < 2e-4
    path = log.write(tmp_path / "log.csv", log.lengths, log.T, q * [1, -1, -1, -1], head=head)
    found = identify(path)
    assert found.turns.transposed
    assert log.error(found) < 2e-4
    with pytest.raises(ArgumentError, match="found whole rotations"):
        identify(path, euler="ZYX")


def test_a_heading_with_units(tmp_path: Path) -> None:
    log = Simulated()
    head = "Leg 1 [mm],L2,L3,L4,L5,L6,X [m],Y,Z,Roll [deg],Pitch [deg],Yaw [deg]"
    path = log.write(
        tmp_path / "log.csv", log.lengths, log.T / 1e3, np.degrees(log.angles), head=head
    )
    found = identify(path)
    assert (found.leg_unit, found.place_unit, found.stated_unit) == ("mm", "m", True)
    # The order that the heading says is not taken against the numbers.
    assert found.turns.order == "XYZ"
    assert "XYZ, degrees" in found.sentences[1]
    assert found.to_json()["log"]["angle_unit"] == "deg"
    assert log.error(found) < 2e-4
    with pytest.raises(SpecError, match=r"log.csv:1:1: found the units 'mm', 'in', "):
        identify(
            log.write(
                tmp_path / "log.csv",
                log.lengths,
                log.T,
                log.angles,
                head=head.replace("L2", "L2 [in]"),
            )
        )


def test_an_order_that_is_stated(tmp_path: Path) -> None:
    """Small letters are the same order, written backwards; another one fits worse."""
    log = Simulated()
    path = log.write(tmp_path / "log.csv", log.lengths, log.T, log.angles)
    assert identify(path, euler="zyx").turns.order == "XYZ"
    with pytest.raises(IncompleteError, match="best: --euler ZYX"):
        identify(path, euler="ZYX")


def test_orders_that_fit_as_well(tmp_path: Path) -> None:
    """Small angles and much noise: orders cannot be distinguished, and the message says so."""
    path, wide = tmp_path / "log.csv", Options(prior=1.0)
    log = Simulated("rubin-camera", 100, noise=1e-4, turn=0.007, move=0.5)
    read = read_log(Path(log.write(path, log.lengths, log.T, log.angles)).read_text("utf-8"), "")
    found = identify_log(read, None, np.zeros(3), {}, wide)
    assert found.sentences[2].startswith("ambiguous: --euler ")
    assert len(found.ambiguous) == 1
    assert {found.turns.words(), *found.ambiguous} == {
        "--euler XYZ, radians",
        "--euler XZY, radians",
    }
    # Smaller ones do not even tell the unit; senses of the right-hand rule are taken.
    log = Simulated("rubin-camera", 100, noise=1e-4, turn=0.004, move=0.5)
    read = read_log(Path(log.write(path, log.lengths, log.T, log.angles)).read_text("utf-8"), "")
    found = identify_log(read, None, np.zeros(3), {}, wide)
    assert found.turns.unusual == 0
    assert re.search(r"radians and \d+ others fit as well", found.sentences[2])
    with pytest.raises(IncompleteError, match=r"(?s)the data determine .*\nambiguous: --euler "):
        identify(str(path))


def test_angles_about_one_axis(tmp_path: Path) -> None:
    """Nothing depends on the order then, and the machine is not determined."""
    log = Simulated(turn=0.0)
    log.angles[:, 2] += np.linspace(-0.5, 0.5, 40)
    log.R = rotation_from_euler("XYZ", log.angles)
    lengths = values_at(log.machine, log.R, log.T)
    with pytest.raises(IncompleteError, match="turn the platform, about axes that differ"):
        identify(log.write(tmp_path / "log.csv", lengths, log.T, log.angles))


@pytest.mark.parametrize("heads", [("A", "B", "C"), ("Roll", "Pitch", "Yaw")])
@pytest.mark.parametrize("axes", list(permutations(range(3))))
def test_columns_that_do_not_name_their_axes(
    heads: tuple[str, ...], axes: tuple[int, int, int], tmp_path: Path
) -> None:
    """Which column turns about which axis is found; what is as named is said in no word."""
    log = Simulated(order="ZYX")
    head = HEAD.replace("rx,ry,rz", ",".join(heads))
    path = log.write(tmp_path / "log.csv", log.lengths, log.T, log.angles[:, axes], head=head)
    found = identify(path)
    assert (found.turns.order, found.turns.axes) == ("ZYX", axes)
    assert found.ambiguous == ()
    assert log.error(found) < 2e-4
    about = f"{' '.join(heads)} about {' '.join('xyz'[k] for k in axes)}"
    assert (about in found.sentences[1]) == (axes != (0, 1, 2))
    assert found.to_json()["log"]["axes"] == "".join("xyz"[k] for k in axes)


def test_columns_that_name_their_axes_are_believed(tmp_path: Path) -> None:
    log = Simulated(order="ZYX")
    path = log.write(tmp_path / "log.csv", log.lengths, log.T, log.angles[:, ::-1])
    with pytest.raises(IncompleteError, match="no machine with six legs explains the log"):
        identify(path)


def test_too_little(tmp_path: Path) -> None:
    few, path = Simulated(count=17), tmp_path / "log.csv"
    with pytest.raises(IncompleteError, match=r"found 17 different poses .*at least 18 "):
        identify(few.write(path, few.lengths, few.T, few.angles))
    same = np.repeat(np.arange(10), 10)
    with pytest.raises(IncompleteError, match="found 10 different poses"):
        identify(few.write(path, few.lengths[same], few.T[same], few.angles[same]))
    level = Simulated(turn=0.0)
    with pytest.raises(IncompleteError, match="measure poses that turn the platform"):
        identify(level.write(path, level.lengths, level.T, level.angles))
    still = Simulated(move=0.0)
    with pytest.raises(IncompleteError, match="positions do not change"):
        identify(still.write(path, still.lengths, still.T, still.angles))
    # Noise is no motion: what fits is refused, or doubted.
    shaken = still.T + 1e-4 * np.random.default_rng(0).normal(size=still.T.shape)
    try:
        found = identify(still.write(path, still.lengths, shaken, still.angles))
    except IncompleteError:
        pass
    else:
        assert found.doubts


def test_blank_cells(tmp_path: Path) -> None:
    """Rows that are not whole count with what they have."""
    log = Simulated()
    log.lengths[3, 2] = log.T[7, 1] = log.angles[9, 0] = np.nan
    found = identify(log.write(tmp_path / "log.csv", log.lengths, log.T, log.angles))
    assert len(found.calibration.seen) == 40
    assert log.error(found) < 2e-4


def test_wrong_rows(tmp_path: Path) -> None:
    log = Simulated(count=100)
    log.lengths[:5, 0] += 30
    path = log.write(tmp_path / "log.csv", log.lengths, log.T, log.angles)
    with pytest.raises(IncompleteError, match="no machine with six legs explains the log"):
        identify(path)
    assert log.error(identify(path, robust=True)) < 2e-4


def test_numbers_at_random(tmp_path: Path) -> None:
    log, rng = Simulated(), np.random.default_rng(0)
    path = log.write(tmp_path / "log.csv", rng.uniform(200, 400, (40, 6)), log.T, log.angles)
    with pytest.raises(IncompleteError, match="no machine with six legs explains the log"):
        identify(path)


def test_the_log_of_the_page() -> None:
    """The statements of docs/calibrate.md."""
    found = identify(str(DOCS / "calibration" / "controller-log.csv"))
    assert "--euler XYZ, degrees, rz left-handed" in found.sentences[1]
    machine = gspcli.load(instance_files()[MACHINE])
    off = found.calibration.after - truth(machine, found)
    assert 0.01 < np.abs(off).max() < 0.02
    assert repr(found).startswith("<Identification: --euler XYZ, degrees, rz left-handed, legs")
