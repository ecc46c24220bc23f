"""Trajectories from files."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gspcli.errors import SpecError
from gspcli.motion import PoseFormat
from gspcli.pictures.stage import scene_of
from gspcli.pictures.whole_views import MOST_POSES, read_tracks
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec import load

PLAIN = PoseFormat()
HEADING = "row,t,mode,x,y,z,qw,qx,qy,qz,condition,clearance"


def test_modes_become_tracks_and_ended_ones_are_skipped() -> None:
    text = "\n".join(
        [
            HEADING,
            "1,0.0,1,0,0,1,1,0,0,0,5,0.1",
            "1,0.0,2,0,0,-1,2,0,0,0,inf,",
            "# a remark",
            "2,0.5,1,0,0,2,0,0,0,3,6,0.2",
            "2,0.5,2,,,,,,,,,",
        ]
    )
    first, second = read_tracks(text, "track.csv", PLAIN)
    assert (first.title, second.title) == ("Trajectory of mode 1", "Trajectory of mode 2")
    assert first.parameter is not None
    assert (first.parameter[0], first.parameter[1].tolist()) == ("t", [0.0, 0.5])
    np.testing.assert_allclose(first.R[1], np.diag([-1, -1, 1]))
    assert first.facts["clearance"] == [0.1, 0.2]
    assert second.conditions is not None
    assert second.conditions.tolist() == [math.inf]
    assert second.facts["clearance"] == [""]


def test_only_poses_are_needed() -> None:
    (track,) = read_tracks("Tx,Ty,Tz,qw,qx,qy,qz\n1,2,3,1,0,0,0\n4,5,6,1,0,0,0", "t.csv", PLAIN)
    assert track.title == "Trajectory"
    assert track.parameter is not None
    assert track.parameter[1].tolist() == [1, 2]
    assert track.conditions is None


def test_poses_are_as_those_that_are_measured() -> None:
    text = "t;x;y;z;rx;ry;rz\n0;1;2;3;0;0;90\n"
    (track,) = read_tracks(text, "t.csv", PoseFormat("xyz", (1.0, 0.0, 0.0), math.pi / 180))
    np.testing.assert_allclose(track.R[0], [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-15)
    np.testing.assert_allclose(track.T[0], [1, 1, 3], atol=1e-15)


def test_drives_that_move_are_read_and_drawn() -> None:
    instance = load(instance_files()["t-top-head"])
    text = "t,x,y,z,qw,qx,qy,qz,crank.B1\n0,0,0,0,1,0,0,0,0\n1,0,0,0,1,0,0,0,90\n"
    (track,) = read_tracks(text, "t.csv", PLAIN)
    assert track.coordinates == ("crank.B1",)
    assert track.places.tolist() == [[0], [90]]
    series = scene_of(solve(instance), [track]).series[-1]
    assert list(series.bodies) == ["base"]
    first, last = (
        {element.name: element.outline[0] for element in body.elements}
        for body in series.bodies["base"]
    )
    crank = instance.constraints[0].base.crank
    assert crank is not None
    turned = crank.moved(instance.constraints[0].base.point, math.pi / 2)
    np.testing.assert_allclose(last["B1"], turned, atol=1e-12)
    np.testing.assert_array_equal(first["B3"], last["B3"])
    # The legs end at the joints, and are as long as is measured.
    legs = [series.strokes[k][0].points for k in range(6)]
    np.testing.assert_allclose(legs[0][1, 1], turned, atol=1e-12)
    lengths = [np.linalg.norm(leg[:, 0] - leg[:, 1], axis=1) for leg in legs]
    np.testing.assert_allclose(np.stack(lengths, axis=1), series.measured, rtol=1e-9)


def test_long_tracks_are_thinned_and_say_so() -> None:
    rows = [f"{k},0,0,1,0,0,0" for k in range(3 * MOST_POSES + 2)]
    (track,) = read_tracks("\n".join(["x,y,z,qw,qx,qy,qz", *rows]), "t.csv", PLAIN)
    assert len(track.T) <= MOST_POSES + 1
    assert track.T[-1, 0] == 3 * MOST_POSES + 1
    assert "of 6002 poses" in track.note


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a,b\n1,2", "t.csv:1:1: found the columns 'a b', expected x y z or tx ty tz"),
        ("", "found nothing, expected a heading and rows"),
        ("x,y,z,qw,qx,qy,qz", "found a heading and no rows"),
        ("mode,x,y,z,qw,qx,qy,qz\n1,,,,,,,", "found no row with a pose"),
        ("x,y,z,qw,qx,qy,qz,condition\n0,0,0,1,0,0,0,ill", "t.csv:2:15: found 'ill'"),
        (
            "x,y,z,qw,qx,qy,qz\n1,2,3,1,0,0,zero",
            "t.csv:2:13: qz: found 'zero', expected a finite number",
        ),
        ("x,y,z,qw,qx,qy,qz\n1,2,3,0,0,0,0", "t.csv:2:7: found a quaternion of length zero"),
    ],
)
def test_mistakes_are_located(text: str, message: str) -> None:
    with pytest.raises(SpecError) as caught:
        read_tracks(text, "t.csv", PLAIN)
    assert message in str(caught.value)
