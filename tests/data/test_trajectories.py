"""The shipped trajectories have the stated properties."""

from __future__ import annotations

import numpy as np

import gspcli
from gspcli.motion import PoseFormat, read_values
from gspcli.resources import data_path


def test_a_loop_of_values_changes_the_mode_without_a_singularity():
    instance = gspcli.load(data_path("trajectories", "mode-change.yaml"))
    path = data_path("trajectories", "mode-change.csv")
    table = read_values(path.read_text(encoding="utf-8"), "loop", instance, PoseFormat())
    assert np.array_equal(table.values[0], table.values[-1])
    start = gspcli.track(instance, table.values[:1])
    assert start.modes.tolist() == [1, 2, 3, 4]
    loop = gspcli.track(instance, table.values, modes=[2])
    assert loop.certified
    assert loop.events == ()
    nearest = np.abs(start.T[:, 0] - loop.T[0, -1]).max(axis=1)
    assert nearest.argmin() == 0
    assert nearest[0] < 1e-12
    # Once more around, and back again.
    twice = gspcli.track(instance, np.concatenate((table.values, table.values[-2::-1])), modes=[2])
    assert twice.events == ()
    assert np.allclose(twice.T[0, -1], start.T[1, 0], atol=1e-12)
