"""`gsp import`: what it says, what it writes, and errors."""

from __future__ import annotations

from pathlib import Path

import machine_models as models
import pytest

import gspcli


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    path = tmp_path / "robot.xml"
    path.write_text(models.rps(), encoding="utf-8")
    return path


def test_writes_the_file_and_says_a_line_a_constraint(gsp, robot: Path) -> None:
    target = robot.with_name("machine.yaml")
    outcome = gsp("import", str(robot), "-o", str(target))
    assert (outcome.code, outcome.out) == (0, "")
    lines = outcome.err.splitlines()
    assert (
        "MJCF: 8 bodies, 9 joints (3 P, 3 R, 3 S), 2 loops, 3 drives, mobility 3, 0 with"
        in lines[0]
    )
    assert lines[0].endswith("base world (it does not move), platform platform")
    assert lines[1] == "1 s0: R-P*-S: DPP = 1.07703 m, range 0.777033 to 1.37703"
    assert lines[2] == "2 s0: R-P*-S: DPH = 0 m, fixed"
    assert len(lines) == 7
    assert gspcli.load(target) == gspcli.import_machine(robot).instance
    assert gsp("check", str(target)).code == 0


def test_writes_to_standard_output_what_others_read(gsp, robot: Path) -> None:
    outcome = gsp("import", str(robot))
    assert gspcli.loads(outcome.out) == gspcli.import_machine(robot).instance
    other = gsp("import", str(robot), "--base", "platform", "--digits", "6", "--meet", "0")
    found = gspcli.import_machine(robot, base="platform", digits=6, meet=0)
    assert other.out == found.text


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--base", "nothing"], "found no body 'nothing'"),
        (["--meet", "1"], "--meet"),
        (["--digits", "18"], "--digits"),
        (["--digits", "2"], "--digits"),
    ],
)
def test_wrong_options(gsp, robot: Path, options: list[str], says: str) -> None:
    target = robot.with_name("machine.yaml")
    outcome = gsp("import", str(robot), *options, "-o", str(target))
    assert outcome.code == 2
    assert says in outcome.err
    assert outcome.out == ""
    assert not target.exists()


def test_what_is_no_platform_is_refused_in_a_few_lines(gsp, robot: Path) -> None:
    robot.write_text(models.legs(["UPU"] * 6), encoding="utf-8")
    outcome = gsp("import", str(robot))
    assert (outcome.code, outcome.out) == (2, "")
    assert len(outcome.err.splitlines()) <= 3
    assert "which hold 12 constraints, expected six" in outcome.err


def test_files_that_are_none(gsp, tmp_path: Path) -> None:
    assert gsp("import", str(tmp_path / "none.xml")).code == 2
    assert gsp("import", str(tmp_path)).code == 2
    empty = tmp_path / "empty.xml"
    empty.write_bytes(b"")
    assert "expected" in gsp("import", str(empty)).err
    noise = tmp_path / "noise.xml"
    noise.write_bytes(bytes(range(256)) * 8)
    assert gsp("import", str(noise)).code == 2
