"""What commands say on standard error about what a person has probably not meant."""

from __future__ import annotations

import io
import re
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from gspcli.cli.streams import progress


def test_a_home_in_another_unit_is_doubted(gsp: Callable, tmp_path: Path) -> None:
    text = gsp("example", "nano-hexapod").out
    wrong = re.sub(r"home: .*", "home: {position: [90, 0, 0]}", text)
    assert wrong != text
    file = tmp_path / "wrong.yaml"
    file.write_text(wrong)
    for words in (("solve", file), ("analyze", file, "--mode", "home")):
        outcome = gsp(*words)
        assert outcome.code == 0
        assert "warning: the stated home is" in outcome.err
        assert "more than a tenth of the platform" in outcome.err
    assert "warning" not in gsp("solve", "@nano-hexapod").err


def test_a_name_of_two_kinds_is_explained(gsp: Callable) -> None:
    outcome = gsp("constraint", "LL")
    assert outcome.err == "LL is a distance and an angle: here are both, DLL and ALL\n"
    assert gsp("constraint", "DLL").err == ""


@pytest.mark.parametrize("command", ["measure", "analyze", "clearance", "dynamics"])
def test_values_beside_poses_that_contradict_them_are_named(
    command: str, gsp: Callable, tmp_path: Path
) -> None:
    spec, file = tmp_path / "machine.yaml", tmp_path / "poses.csv"
    body = "{mass: 1, centre: [0, 0, 0], inertia: [1, 1, 1, 0, 0, 0]}"
    machine = gsp("example", "rubin-m2").out
    spec.write_text(f"{machine}dynamics: {{platform: {body}}}\n")
    file.write_text("x,y,z,qw,qx,qy,qz,L1,L2\n0,0,0,1,0,0,0,0.493,0.5\n")
    outcome = gsp(command, spec, file)
    assert outcome.code == 0
    assert "2:21: found 0.5 beside a pose that measures 0.493" in outcome.err
    file.write_text("x,y,z,qw,qx,qy,qz,L1\n0,0,0,1,0,0,0,0.493\n")
    assert gsp(command, spec, file).err == ""


def test_long_work_says_how_far_it_is_off_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gspcli.cli.streams._LINE_SECONDS", 0.01)
    said = io.StringIO()
    monkeypatch.setattr(sys, "stderr", said)
    for item in progress(range(2), total=2, label="nodes", lines=True):
        while f"nodes: {item} of 2" not in said.getvalue():
            pass
    assert re.match(r"nodes: 0 of 2 \(\d+ s\)\n", said.getvalue())
