"""No command replaces a file that it read, or one beside that of -o, unless it is forced to."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest


@pytest.fixture
def machine(gsp: Callable, tmp_path: Path) -> Path:
    file = tmp_path / "servo.yaml"
    assert gsp("example", "nano-hexapod", "-o", file).code == 0
    return file


def test_a_machine_beside_its_export_is_kept(gsp: Callable, machine: Path) -> None:
    before = machine.read_bytes()
    words = ("export", machine, "--to", "urdf", "-o", machine.with_suffix(".urdf"))
    outcome = gsp(*words)
    assert outcome.code == 2
    assert "it is beside the file of -o: --force replaces it" in outcome.err
    assert machine.read_bytes() == before
    assert not machine.with_suffix(".urdf").exists()
    assert gsp(*words, "--force").code == 0
    assert b"closed_loop" in machine.read_bytes()


def test_an_export_is_written_again(gsp: Callable, machine: Path) -> None:
    for to, name in (("urdf", "other.urdf"), ("c", "other.c")):
        for _ in range(2):
            assert gsp("export", machine, "--to", to, "-o", machine.with_name(name)).code == 0


def test_parts_of_csv_are_not_written_over_others(gsp: Callable, tmp_path: Path) -> None:
    kept = tmp_path / "type-bounds.csv"
    kept.write_text("mine\n")
    outcome = gsp("show", "6PP", "-o", tmp_path / "type.csv")
    assert outcome.code == 2
    assert kept.read_text() == "mine\n"


def test_an_import_spares_what_is_no_instance_file(gsp: Callable, machine: Path) -> None:
    robot = machine.with_name("robot.urdf")
    assert gsp("export", machine, "--to", "urdf", "-o", robot).code == 0
    loops = robot.with_suffix(".yaml")
    before = loops.read_bytes()
    outcome = gsp("import", robot, "-o", loops)
    assert (outcome.code, loops.read_bytes()) == (2, before)
    assert "it is no instance file" in outcome.err
    assert gsp("import", robot, "-o", machine).code == 0
