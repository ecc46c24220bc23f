"""Trajectories from files."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gspcli.errors import SpecError
from gspcli.pictures.tracks import MOST_POSES, read_tracks

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
    first, second = read_tracks(text, "track.csv")
    assert (first.title, second.title) == ("Trajectory of mode 1", "Trajectory of mode 2")
    assert first.parameter is not None
    assert (first.parameter[0], first.parameter[1].tolist()) == ("t", [0.0, 0.5])
    np.testing.assert_allclose(first.R[1], np.diag([-1, -1, 1]))
    assert first.facts["clearance"] == [0.1, 0.2]
    assert second.conditions is not None
    assert second.conditions.tolist() == [math.inf]
    assert second.facts["clearance"] == [""]


def test_only_poses_are_needed() -> None:
    (track,) = read_tracks("Tx,Ty,Tz,qw,qx,qy,qz\n1,2,3,1,0,0,0\n4,5,6,1,0,0,0", "t.csv")
    assert track.title == "Trajectory"
    assert track.parameter is not None
    assert track.parameter[1].tolist() == [1, 2]
    assert track.conditions is None


def test_long_tracks_are_thinned_and_say_so() -> None:
    rows = [f"{k},0,0,1,0,0,0" for k in range(3 * MOST_POSES + 2)]
    (track,) = read_tracks("\n".join(["x,y,z,qw,qx,qy,qz", *rows]), "t.csv")
    assert len(track.T) <= MOST_POSES + 1
    assert track.T[-1, 0] == 3 * MOST_POSES + 1
    assert "of 6002 poses" in track.note


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a,b\n1,2", "t.csv:1:1: found the columns a b, expected x y z qw qx qy qz"),
        ("", "found the columns (none)"),
        ("x,y,z,qw,qx,qy,qz", "found no row with a pose"),
        ("x,y,z,qw,qx,qy,qz\n1,2,3,1,0,0,zero", "t.csv:2:1: qz: found 'zero', expected a number"),
        ("x,y,z,qw,qx,qy,qz\n1,2,3,0,0,0,0", "t.csv:2:1: found a quaternion of length zero"),
    ],
)
def test_mistakes_are_located(text: str, message: str) -> None:
    with pytest.raises(SpecError) as caught:
        read_tracks(text, "t.csv")
    assert message in str(caught.value)
