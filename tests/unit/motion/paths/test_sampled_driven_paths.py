"""Proved ways of machines with motors against samples, and the judge itself."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.motion.paths.pose_ways import WayProof
from tests.support import driven_paths


@pytest.mark.parametrize("name", ["t-top 120", "mixed"])
def test_no_sample_contradicts_a_proved_way(name):
    found = driven_paths.segments(name, 25, 500)
    assert found.proved > 5
    assert found.wrong == 0


def test_ways_that_are_not_proved_are_found_wrong(monkeypatch):
    class Credulous(driven_paths.PoseWays):
        def prove(self, begin, end):
            del begin, end
            return WayProof(1, 1)

    monkeypatch.setattr(driven_paths, "PoseWays", Credulous)
    assert driven_paths.segments("reachy 90", 40, 300).wrong > 0


def test_paths_of_drives_are_followed_to_their_ends():
    assert driven_paths.paths("6-PUS", 1).proved == 1
    draw = driven_paths.Draw("6-PUS", 3)
    R, T = draw.machine.R[None], draw.machine.T[None]
    q = draw.geometry.numbers(R, T)
    rows = [np.concatenate((one, one)) for one in (R, T, q)]
    assert driven_paths.is_kept(draw, *rows)
    rows[2][1] += 1e-3
    assert not driven_paths.is_kept(draw, *rows)
