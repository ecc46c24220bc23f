"""`gsp view`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

TRACK = "t,mode,x,y,z,qw,qx,qy,qz\n0,1,0,0,1,1,0,0,0\n1,1,0,0,2,1,0,0,0\n"


def test_a_page_to_a_file(gsp: Callable, tmp_path: Path) -> None:
    target = tmp_path / "platform.html"
    outcome = gsp("view", "@octahedral-3-3", "-o", target)
    assert (outcome.code, outcome.out) == (0, "")
    home, written = outcome.err.splitlines()
    assert home.startswith("home is mode ")
    assert written.startswith(f"{target}: 4 modes (assembly modes), ")
    assert target.read_text(encoding="utf-8").startswith("<!doctype html>")


def test_a_page_to_standard_output(gsp: Callable) -> None:
    outcome = gsp("view", "@no-real-pose")
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out.rstrip().endswith("</html>")


def test_a_page_that_solves(gsp: Callable, tmp_path: Path) -> None:
    target = tmp_path / "live.html"
    outcome = gsp("view", "@octahedral-3-3", "--live", "--set", "1=1.45", "-o", target)
    assert (outcome.code, outcome.out) == (0, "")
    text = target.read_text(encoding="utf-8")
    assert '"values":[1.45,' in text
    assert "WebAssembly" in text


def test_a_track(gsp: Callable, tmp_path: Path) -> None:
    track, target = tmp_path / "track.csv", tmp_path / "view.html"
    track.write_text(TRACK, encoding="utf-8")
    outcome = gsp("view", "@octahedral-3-3", "--track", track, "-o", target)
    assert outcome.code == 0
    assert "2 poses (trajectory of mode 1)" in outcome.err


def test_values_can_be_set(gsp: Callable) -> None:
    assert '"value":1.45}' in gsp("view", "@octahedral-3-3", "--set", "1=1.45").out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("@octahedral-3-3", "--mode", "5"), "found mode 5, expected one of the 4 real poses"),
        (("@octahedral-3-3", "-o", "view.docx"), "no format known from 'view.docx'"),
        (("@octahedral-3-3", "--track", "no.csv"), "no.csv: cannot be read"),
        (("@octahedral-3-3", "--live", "-o", "x.svg"), "--live makes a page (html)"),
        (("@octahedral-3-3", "--live", "--track", "t.csv"), "of a platform, without --track"),
        (("@griffis-duffy", "--live"), "a page cannot solve this platform: "),
        (("-", "--track", "-"), "SPEC and --track cannot both be standard input"),
    ],
)
def test_what_is_wrong_is_said(gsp: Callable, arguments: tuple[str, ...], message: str) -> None:
    outcome = gsp("view", *arguments)
    assert (outcome.code, outcome.out) == (2, "")
    assert message in outcome.err


@pytest.mark.parametrize("suffix", ["svg", "png", "pdf"])
def test_drawings(gsp: Callable, tmp_path: Path, suffix: str) -> None:
    target = tmp_path / f"figure.{suffix}"
    outcome = gsp("view", "@octahedral-3-3", "--from=-40,25", "--mode", "2", "-o", target)
    assert (outcome.code, outcome.out) == (0, "")
    assert target.read_bytes()[:5] in (b"<?xml", b"\x89PNG\r", b"%PDF-")


def test_all_modes_are_more_than_one(gsp: Callable, tmp_path: Path) -> None:
    one, every = tmp_path / "one.svg", tmp_path / "all.svg"
    gsp("view", "@octahedral-3-3", "--no-names", "-o", one)
    gsp("view", "@octahedral-3-3", "--no-names", "--all-modes", "-o", every)
    assert every.stat().st_size > 3 * one.stat().st_size


def test_a_direction_is_two_angles(gsp: Callable) -> None:
    outcome = gsp("view", "@octahedral-3-3", "--from", "up")
    assert outcome.code == 2
    assert "--from: found 'up', expected two angles in degrees" in outcome.err


def test_what_gsp_track_writes_can_be_seen(gsp: Callable, tmp_path: Path) -> None:
    values, track, target = (tmp_path / name for name in ("v.csv", "t.csv", "view.html"))
    values.write_text("t,1\n0,1.5\n1,1.6\n2,1.4\n", encoding="utf-8")
    assert gsp("track", "@octahedral-3-3", values, "-o", track).code == 0
    outcome = gsp("view", "@octahedral-3-3", "--track", track, "-o", target)
    assert outcome.code == 0
    assert "3 poses (trajectory of mode 4)" in outcome.err


def test_the_page_of_trajectories_opens_on_home(gsp: Callable, tmp_path: Path) -> None:
    track, target = tmp_path / "t.csv", tmp_path / "view.html"
    rows = [f"{t},{mode},0,0,{z},1,0,0,0" for t in (0, 1) for mode, z in ((7, -0.01), (8, 0.09))]
    track.write_text("t,mode,x,y,z,qw,qx,qy,qz\n" + "\n".join(rows) + "\n", encoding="utf-8")
    outcome = gsp("view", "@nano-hexapod", "--track", track, "-o", target)
    assert outcome.err.startswith("home is mode 8: nearest to the stated home\n")
    # The modes, then the trajectories in the order of the file.
    assert '"first":2' in target.read_text(encoding="utf-8")
