"""Live pages of machines whose motors move joints: their sliders are motors."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from gspcli.geometry.machine import Machine
from gspcli.pictures.stage import Poses, arm_strokes, convex_hull, drawn_drives
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec import load
from tests.support.live_pages import give, opened, settle, text
from tools.recording import ROOT

if TYPE_CHECKING:
    from tests.support.browser import Browser

SOURCES = ROOT / "viewer" / "src" / "live"
MODULES = ("vectors.js", "rotations.js", "drives.js", "hull.js")


@pytest.fixture(scope="module")
def run(chromium: Browser) -> Any:
    """What runs an expression with the functions of the page."""
    texts = [(SOURCES / name).read_text("utf-8") for name in MODULES]
    # Two files have a function of one name.
    texts[-1] = f"const hull = (() => {{ {texts[-1].replace('export ', '')}; return hull; }})();"
    lines = [line for each in texts for line in each.splitlines() if not line.startswith("import")]
    script = "\n".join(lines).replace("export ", "")
    script = "\n".join(line for line in script.splitlines() if "import {" not in line)
    # Each in a function of its own, whatever page the browser shows.
    call = "(() => {{ {}\nreturn JSON.stringify({}); }})()"
    return lambda expression: json.loads(chromium.run(call.format(script, expression)))


def corners(faces: Any) -> set[frozenset[tuple[float, ...]]]:
    """Return the faces of a hull by their corners."""
    return {frozenset(tuple(np.round(p, 9) + 0.0) for p in np.asarray(face)) for face in faces}


CUBE = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
HEXAGON = [[np.cos(a), np.sin(a), 0.3] for a in np.arange(6) * np.pi / 3]


@pytest.mark.parametrize(
    "points",
    [
        np.random.default_rng(1).normal(size=(6, 3)),
        np.random.default_rng(2).normal(size=(7, 3)) * [1, 1, 1e-4],
        np.array(CUBE, float),
        np.array([*HEXAGON, [0, 0, 0.3]]),
        np.array([[0.0, 0, 0], [1, 2, 3], [2, 4, 6], [0.5, 1, 1.5]]),
        np.array([[1.0, 2, 3]] * 4),
        np.array([*HEXAGON, [0, 0, 2], [0, 0, 1]]),
    ],
)
def test_hulls_are_those_of_other_pages(run: Any, points: Any) -> None:
    assert corners(run(f"hull({points.tolist()})")) == corners(convex_hull(points))


@pytest.mark.parametrize("name", ["delta", "hexaglide", "reachy-mini-head"])
def test_arms_and_rails_are_those_of_other_pages_wherever_the_motors_are(
    run: Any, name: str
) -> None:
    instance = load(instance_files()[name])
    drives, drawn = Machine.of(instance), drawn_drives(instance)
    rng = np.random.default_rng(7)
    readings = rng.uniform(-1, 1, drives.count) * (30 if "crank" in drives.sorts else 1)
    places = readings[None]
    poses = Poses(
        "", "", np.eye(3)[None], np.zeros((1, 3)), coordinates=drives.names, places=places
    )
    expected = arm_strokes(instance, poses, 2.0)
    joints = drives.points(drives.from_readings(readings))
    pose = {"R": np.eye(3).ravel().tolist(), "T": [0, 0, 0]}
    for k, drive in enumerate(drawn):
        given, reading = json.dumps(drive), float(readings[drives.index[k]])
        q = f"numberOf({given}, {reading})"
        np.testing.assert_allclose(run(f"pointAt({given}, {q})"), joints[k], rtol=1e-12, atol=1e-12)
        found = run(f"armAt({given}, {q}, {json.dumps(pose)}, 2)")
        (stroke,) = expected[k]
        assert found["style"] == stroke.style.value
        np.testing.assert_allclose(found["points"], stroke.points[0], rtol=1e-12, atol=1e-12)


def listed(browser: Browser) -> list[tuple[float, ...]]:
    """Return x, y, z of each mode of the list."""
    rows = browser.run(
        "[...document.querySelectorAll('#modes tbody tr:not(.gone)')]"
        ".map((row) => [...row.cells].slice(1, 4).map((cell) => cell.textContent))"
    )
    return sorted(tuple(float(x.replace("−", "-")) for x in row) for row in rows)


def is_what_solve_says(browser: Browser, name: str, readings: list[float], places: int) -> None:
    """Compare the page with the machine whose joints are there."""
    instance = load(instance_files()[name])
    drives = Machine.of(instance)
    result = solve(drives.instance_at(drives.from_readings(readings)))
    real = result.counts.real
    # The joints there are rounded: machines with symmetry may get poses at infinity back.
    said = text(browser, "status")
    assert said.startswith(f"{real} ways to assemble it; none is missing ")
    assert said.endswith(f" poses, {real} real: proved")
    there = sorted(map(tuple, (result.T.real[:real].round(places) + 0.0).tolist()))
    np.testing.assert_allclose(listed(browser), there, atol=1.01 * 10.0**-places)


def test_a_crank_turns_and_all_modes_are_found_again(
    browser: Browser, live: Callable[..., Path]
) -> None:
    name = "reachy-mini-head"
    opened(browser, live(name))
    assert (
        text(browser, "status")
        == "16 ways to assemble it; none is missing 40 poses, 16 real: proved"
    )
    assert (
        browser.run("document.querySelector('input[value=values] + span').textContent") == "Motors"
    )
    assert browser.run("[...document.querySelectorAll('#values b')].map((x) => x.textContent)") == [
        f"crank.B{k}" for k in range(1, 7)
    ]
    before = browser.screenshot()
    give(browser, "value-1", 20)
    settle(browser)
    is_what_solve_says(browser, name, [20, 0, 0, 0, 0, 0], 5)
    give(browser, "value-4", -25)
    settle(browser)
    is_what_solve_says(browser, name, [20, 0, 0, -25, 0, 0], 5)
    assert browser.screenshot() != before
    assert browser.messages == []
    browser.run("document.getElementById('home').click()")
    settle(browser)
    assert text(browser, "status").startswith("16 ways to assemble it; none is missing")


def test_carriages_move_with_proof_and_come_back(
    browser: Browser, live: Callable[..., Path]
) -> None:
    opened(browser, live("hexaglide"), "#1=0.75&5=-1.25&mode=2")
    settle(browser)
    is_what_solve_says(browser, "hexaglide", [0.75, 0, 0, 0, -1.25, 0], 3)
    assert browser.run("document.querySelector('#modes [aria-current]').dataset.mode") == "2"
    browser.run("document.getElementById('reset').click()")
    settle(browser)
    is_what_solve_says(browser, "hexaglide", [0] * 6, 3)


def test_one_motor_moves_two_rods_and_a_pose_it_cannot_reach_is_refused(
    browser: Browser, live: Callable[..., Path]
) -> None:
    opened(browser, live("delta"))
    assert browser.run("document.querySelectorAll('#values .slider').length") == 3
    give(browser, "value-2", 20)
    settle(browser)
    is_what_solve_says(browser, "delta", [0, 20, 0], 1)
    at = text(browser, "pose")
    browser.run("document.querySelector('input[name=moved][value=pose]').click()")
    give(browser, "pose-rz", 5)
    settle(browser)
    assert "the motors cannot bring the rods to that pose" in text(browser, "event")
    assert text(browser, "pose") == at
    z = float(browser.run("document.getElementById('pose-z').value"))
    give(browser, "pose-z", z - 20)
    settle(browser)
    assert browser.run("Number(document.getElementById('pose-z').value)") == pytest.approx(z - 20)
    values = browser.run(
        "[1, 2, 3].map((k) => Number(document.getElementById(`value-${k}`).value))"
    )
    assert values[0] != 0
    assert browser.messages == []


def test_what_is_not_proved_is_not_called_complete(
    browser: Browser, live: Callable[..., Path]
) -> None:
    """With all arms alike there are fewer poses than the page can know."""
    opened(browser, live("delta"), "#1=10&2=10&3=10")
    settle(browser)
    said = text(browser, "status")
    assert "none is missing" not in said
    assert said.startswith("16 ways to assemble it are known 28 of 40 poses proved, 12 missing")
