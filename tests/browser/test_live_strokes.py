"""What the page that solves draws of constraints is what the scenes of Python have."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from gspcli.geometry.instance import Instance
from gspcli.pictures.scene import Scene
from gspcli.pictures.stage import drawn_drives, scene_of
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec import load
from tools.recording import ROOT

if TYPE_CHECKING:
    from tests.support.browser import Browser

SOURCES = ROOT / "viewer" / "src" / "live"
MODULES = ("vectors.js", "rotations.js", "drives.js", "strokes.js")
#: Shorter guides are rounding errors.
SEEN = 1e-9
#: All kinds among them; feet beyond what is drawn of lines and planes; arms, rails with and without
#: a range, and arms on the platform.
NAMES = (
    "example-6.8",
    "figure-3",
    "six-planes",
    "surfaces-ppp",
    "figure-2",
    "point-on-line",
    "delta",
    "hexaglide",
    "three-prs",
    "modified-paradex",
)


@pytest.fixture(scope="module")
def draw(chromium: Browser) -> Any:
    texts = [(SOURCES / name).read_text("utf-8") for name in MODULES]
    lines = [line for text in texts for line in text.splitlines() if not line.startswith("import")]
    script = "\n".join(lines).replace("export ", "")
    # Each in a function of its own, whatever page the browser shows.
    call = "(() => {{ {}\nreturn JSON.stringify({}); }})()"

    def run(*given: Any, function: str = "strokesAt") -> Any:
        wanted = f"{function}({', '.join(json.dumps(x) for x in given)}) ?? null"
        return json.loads(chromium.run(call.format(script, wanted)))

    return run


CORNERS = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]


@pytest.mark.parametrize("foot", [[3, 0.5, 0], [-1.5, -3, 0], [0, 1.2, 0]])
def test_planes_reach_to_feet_on_them(draw: Any, foot: list[float]) -> None:
    plane = {"primitive": "H", "outline": CORNERS, "direction": [0, 0, 1]}
    outline = np.array(draw(plane, foot, 2, function="reaching"))
    inside, before = np.array(foot), np.array(CORNERS)
    assert (outline.min(axis=0) <= np.minimum(inside, before.min(axis=0)) + 1e-12).all()
    assert (outline.max(axis=0) >= np.maximum(inside, before.max(axis=0)) - 1e-12).all()
    # No farther than beyond the foot by the margin, and a rectangle still.
    assert np.abs(outline).max() <= np.abs(inside).max() + 0.25
    assert np.allclose(outline[1] - outline[0], outline[2] - outline[3])


@pytest.mark.parametrize("foot", [[0.9, -0.9, 0], [1, 1, 0], [9, 0, 0]])
def test_planes_do_not_grow_without_need_or_without_end(draw: Any, foot: list[float]) -> None:
    plane = {"primitive": "H", "outline": CORNERS, "direction": [0, 0, 1]}
    assert draw(plane, foot, 2, function="reaching") is None


def bodies(scene: Scene, instance: Instance) -> list[dict[str, Any]]:
    """Return each constraint with both primitives as they are drawn, and its crank or slide."""
    found = {
        body.name: {
            element.name: {
                "primitive": element.primitive.value,
                "outline": element.outline.tolist(),
                "direction": None if element.direction is None else element.direction.tolist(),
            }
            for element in body.elements
        }
        for body in (scene.platform, scene.base)
    }
    return [
        {
            "kind": bond.kind.name,
            "platform": found["platform"][bond.platform_name],
            "base": found["base"][bond.base_name],
            "drive": drive,
        }
        for bond, drive in zip(scene.bonds, drawn_drives(instance), strict=True)
    ]


@pytest.mark.parametrize("name", NAMES)
def test_strokes_are_those_of_the_scene(draw: Any, name: str) -> None:
    instance = load(instance_files()[name])
    scene = scene_of(solve(instance))
    modes = scene.series[0]
    for k in range(len(modes)):
        pose = {"R": modes.R[k].ravel().tolist(), "T": modes.T[k].tolist()}
        for i, constraint in enumerate(bodies(scene, instance)):
            found = draw(constraint, pose, scene.size)
            np.testing.assert_allclose(found["label"], modes.labels[k, i], atol=1e-7 * scene.size)
            expected = [(s.style.value, s.points[k]) for s in modes.strokes[i]]
            drawn = [(stroke["style"], np.array(stroke["points"])) for stroke in found["strokes"]]
            # A guide that no pose needs is none there, and a point here.
            drawn, expected = (
                [x for x in each if x[0] != "guide" or np.ptp(x[1], axis=0).max() > SEEN]
                for each in (drawn, expected)
            )
            assert [style for style, _ in drawn] == [style for style, _ in expected]
            for (_, points), (_, right) in zip(drawn, expected, strict=True):
                np.testing.assert_allclose(points, right, atol=1e-7 * scene.size)
