"""What was perhaps not meant is pointed out: radians among degrees, lengths out of proportion."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from gspcli.cli.commands.solve import _complain
from gspcli.errors import IncompleteError
from gspcli.geometry.building import hexapod
from gspcli.resources import instance_files
from gspcli.spec import out_of_proportion, read_text

HEXAPOD = instance_files()["dietmaier"].read_text(encoding="utf-8")


def _doubts(old: str = "", new: str = "") -> list[str]:
    assert old in HEXAPOD
    return [mistake.message for mistake in read_text(HEXAPOD.replace(old, new, 1)).doubts]


def _first_point() -> str:
    return HEXAPOD[HEXAPOD.index("point: [") :].partition("]")[0] + "]"


@pytest.mark.parametrize(
    ("number", "message"),
    [
        ("cos(60)", "cos(60) is of 60 radians: for degrees write cosd(60)"),
        ("2*sin( -30.5 )", "sin( -30.5 ) is of 30.5 radians: for degrees write sind(30.5)"),
        ("cosd(60)", None),
        ("cos(pi/3)", None),
        ("cos(60*pi/180)", None),
        ("sin(0)", None),
    ],
)
def test_radians_among_degrees(number: str, message: str | None) -> None:
    assert _doubts(_first_point(), f"point: [{number}, 0.2, 0.1]") == ([message] if message else [])


def test_radians_among_radians_are_meant() -> None:
    text = HEXAPOD.replace(_first_point(), "point: [cos(60), 0.2, 0.1]").replace("deg", "rad")
    assert read_text(text).doubts == ()


def test_lengths_out_of_proportion() -> None:
    (message,) = _doubts(_first_point(), "point: [3e9, 0, 0]")
    assert message.startswith("lengths differ by a factor of ")
    assert "of the base are apart by 3e+09" in message or "of the platform are apart" in message


def test_lines_and_planes_out_of_proportion() -> None:
    text = instance_files()["example-6.8"].read_text(encoding="utf-8")
    far = text.replace("L1: {line: {point: [0, 0, 0]", "L1: {line: {point: [3e9, 0, 7e9]", 1)
    assert far != text
    (doubt,) = read_text(far).doubts
    assert "L1 and" in doubt.message
    assert "of the platform are apart by 3" in doubt.message
    # A point of a line is any of its points.
    along = text.replace("L1: {line: {point: [0, 0, 0]", "L1: {line: {point: [0, 0, 7e9]", 1)
    assert read_text(along).doubts == ()


@pytest.mark.parametrize("path", instance_files().values(), ids=lambda path: path.stem)
def test_shipped_files_leave_no_doubts(path: Path) -> None:
    assert read_text(path.read_text(encoding="utf-8")).doubts == ()


def test_missing_poses_are_put_down_to_proportions() -> None:
    instance = read_text(HEXAPOD.replace(_first_point(), "point: [3e9, 0, 0]", 1)).instance
    result = SimpleNamespace(
        counts=None, verdict="incomplete", account=SimpleNamespace(lost=8), expected=40
    )
    for given, reason in ((instance, "lengths differ by"), (read_text(HEXAPOD).instance, "--seed")):
        with pytest.raises(IncompleteError, match=f"8 of 40 expected .*\n.*{reason}"):
            _complain(SimpleNamespace(**vars(result), instance=given))


def test_solving_says_so_on_stderr(gsp, tmp_path: Path) -> None:
    path = tmp_path / "spec.yaml"
    path.write_text(HEXAPOD.replace(_first_point(), "point: [cos(60), 0.2, 0.1]"))
    assert "warning: " in gsp("measure", path, "--pose", "0,0,0,1,0,0,0").err


def test_primitives_without_a_name_are_different_ones() -> None:
    """They were one primitive, so that no length between them was seen."""
    platform = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [2, 0, 1], [3e9, 0, 0]]
    base = [[k, k * k, -1] for k in range(6)]
    made = hexapod(base, platform, range(1, 7))
    bare = replace(
        made,
        constraints=tuple(replace(r, platform_name="", base_name="") for r in made.constraints),
    )
    assert "lengths differ by a factor of" in out_of_proportion(made)
    assert "lengths differ by a factor of" in out_of_proportion(bare)
