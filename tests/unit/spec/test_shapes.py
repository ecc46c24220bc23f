"""Diameters of legs and hulls of bodies in files: read, written, and their mistakes."""

from dataclasses import replace

import numpy as np
import pytest

from gspcli.errors import SpecError
from gspcli.geometry.euler import rotation_from_euler
from gspcli.geometry.expressed_instances import expressed_instance
from gspcli.geometry.frames import PoseFrame
from gspcli.geometry.home_pose import Frame, Frames
from gspcli.geometry.numbers import Number
from gspcli.geometry.shapes import Shapes
from gspcli.motion import gaps
from gspcli.resources import instance_files
from gspcli.spec import dumps, loads
from gspcli.spec.reading import example

TEXT = instance_files()["workspace-study"].read_text(encoding="utf-8").rstrip() + "\n"
PLATE = "[[100, 0, 0], [-50, 50*sqrt(3), 0], [-50, -50*sqrt(3), 1/3]]"


def test_what_is_stated_is_read_and_written_exactly():
    read = loads(f"{TEXT}shapes: {{diameter: 20}}\n")
    assert read.shapes == Shapes(20)
    assert read.shapes.diameters == (Number.of(20),)
    assert loads(dumps(read)) == read
    text = f"{TEXT}shapes:\n  diameter: [1, 2, 3, 4, 0.1, 1/3]\n  platform: {PLATE}\n"
    text += "  base: [[0, 0, -0.1]]\n  near_joint: sqrt(2)\n"
    read = loads(text)
    assert [x.value for x in read.shapes.diameters] == [1, 2, 3, 4, 0.1, 1 / 3]
    assert (len(read.shapes.platform), len(read.shapes.base)) == (3, 1)
    assert loads(dumps(read)) == read
    assert replace(read, shapes=None) == example("workspace-study")


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ("{}", "46:9: shapes: the key diameter is missing"),
        (
            "20",
            "shapes: found '20', expected a mapping with diameter, platform, base and near_joint",
        ),
        ("{diameter: -1}", "46:20: shapes.diameter: found -1, expected a diameter of at least 0"),
        ("{diameter: []}", "found 0 diameters, expected 6, one for each leg, or one for all"),
        ("{diameter: [1, 2]}", "found 2 diameters, expected 6, one for each leg, or one for all"),
        (
            "{diameter: [1, 2, 3, -4, 5, 6]}",
            "46:30: shapes.diameter[4]: found -4, expected a diameter of at least 0",
        ),
        ("{diameter: wide}", "46:20: shapes.diameter: found 'wide', expected a number"),
        ("{diameter: nan}", "shapes.diameter: found 'nan'"),
        ("{diameter: 1e300}", "found '1e300'"),
        ("{diameter: 1, near_joint: -2}", "shapes.near_joint: found -2, expected a length"),
        ("{diameter: 1, platform: []}", "found no point, expected a list of points"),
        ("{diameter: 1, platform: [1, 2, 3]}", "expected three numbers [x, y, z]"),
        ("{diameter: 1, base: [[1, 2]]}", "46:30: shapes.base[1]: found 2 entries, expected three"),
        (
            "{diameter: 1, base: [[1, 2, 3]]}",
            "46:29: shapes.base: found the hull of the base without near_joint, expected both",
        ),
        ("{diametre: 1}", "found the unknown key 'diametre', expected diameter, platform, base or"),
    ],
)
def test_mistakes_are_told_with_their_places(section, message):
    lines = len(TEXT.splitlines()) + 1
    with pytest.raises(SpecError) as error:
        loads(f"{TEXT}shapes: {section}\n")
    assert message.replace("46:", f"{lines}:") in str(error.value)
    assert len(str(error.value).splitlines()) <= 3


def test_shapes_of_a_platform_without_legs():
    planes = instance_files()["six-planes"].read_text(encoding="utf-8").rstrip()
    with pytest.raises(SpecError, match="no distance of two points: only legs have a diameter"):
        loads(f"{planes}\nshapes: {{diameter: 1}}\n")


def test_gaps_do_not_depend_on_the_frames_in_which_poses_are_expressed():
    shapes = Shapes(20, [[150, 0, 10], [-80, 120, 5]], [[0, 0, -20], [300, 0, -5]], 30)
    frames = Frames(Frame([10, 20, 30], euler="ZYX", angles=[90, 0, 90]), Frame([1, 2, 3]))
    given = replace(example("workspace-study"), shapes=shapes, frames=frames)
    R, T = rotation_from_euler("ZYX", np.array([0.3, -0.2, 0.1])), np.array([5.0, 3.0, 390.0])
    frame = PoseFrame.of(given, pivot=(7, 8, 9))
    moved = gaps(expressed_instance(given, pivot=(7, 8, 9)), *frame.from_platform(R, T))
    assert moved.pairs == gaps(given, R, T).pairs
    assert moved.values == pytest.approx(gaps(given, R, T).values, abs=1e-8)
