"""Sliders of the pose in a live page, in the frames of the file or relative to home."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

import gspcli
from gspcli.geometry.euler import euler_from_rotation, rotation_from_euler
from gspcli.geometry.frames import PoseFrame
from gspcli.pictures.whole_views import viewed
from gspcli.solver import solve
from tests.support.live_pages import give, opened, text

if TYPE_CHECKING:
    from tests.support.browser import Browser

AXES = ("x", "y", "z", "rx", "ry", "rz")
MACHINE = replace(
    gspcli.example("workspace-study"),
    frames=gspcli.Frames(
        tool=gspcli.Frame([3, -5, 30], euler="xyz", angles=(10, -20, 30)),
        work=gspcli.Frame([100, 20, -7], euler="xyz", angles=(-15, 25, 40)),
    ),
)
FRAMES = {
    "work": (PoseFrame.of(MACHINE), "poses of the tool in the work frame"),
    "home": (
        PoseFrame.of(MACHINE, relative=True),
        "poses of the tool relative to home, along the axes of the work frame",
    ),
    "none": (PoseFrame(), "poses of the platform in the base"),
}


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    folder, result = tmp_path_factory.mktemp("framed"), solve(MACHINE)
    assert result.home is not None
    start = result.home.number - 1

    def write(name: str) -> Path:
        path = folder / f"{name}.html"
        path.write_bytes(viewed(result, "html", start, live=True, frame=FRAMES[name][0])[1])
        return path

    return write


def numbers(browser: Browser, name: str, keys: tuple[str, ...]) -> np.ndarray:
    return np.array(
        [float(browser.run(f"document.getElementById('{name}-{k}').value")) for k in keys]
    )


@pytest.mark.parametrize("name", FRAMES)
def test_sliders_are_expressed_poses(
    browser: Browser, page: Callable[[str], Path], name: str
) -> None:
    frame, words = FRAMES[name]
    opened(browser, page(name))
    browser.run("document.querySelector('input[value=pose]').click()")
    assert text(browser, "coordinates").startswith(words + "; turns about its fixed axes x, y, z")

    def shown(R: np.ndarray, T: np.ndarray) -> np.ndarray:
        turn, at = frame.from_platform(R, T)
        return np.concatenate((at, np.rad2deg(euler_from_rotation("xyz", turn))))

    home = MACHINE.home
    assert home is not None
    start = shown(home.R(1.0), home.T)
    assert numbers(browser, "pose", AXES) == pytest.approx(start, abs=1e-2)
    if name == "home":
        assert start == pytest.approx(np.zeros(6), abs=1e-9)
    # A number that is typed moves the platform there; the values are those of that pose.
    moved = numbers(browser, "pose", AXES)
    for k, step in ((0, 12.0), (4, 5.0), (5, -8.0)):
        moved[k] += step
        give(browser, f"pose-{AXES[k]}", moved[k])
    R, T = frame.to_platform(rotation_from_euler("xyz", np.deg2rad(moved[3:])), moved[:3])
    values = gspcli.measure(MACHINE, R, T)
    assert numbers(browser, "value", tuple("123456")) == pytest.approx(
        np.asarray(values).ravel(), abs=2e-2
    )
