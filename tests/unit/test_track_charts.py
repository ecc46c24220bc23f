from __future__ import annotations

from dataclasses import replace

import pytest

import gspcli
from gspcli.motion import PoseFormat, read_values, track
from gspcli.resources import data_path

pytest.importorskip("matplotlib")


def test_the_loop_is_drawn_with_all_its_modes():
    from tools.build.track_charts import track_chart

    instance = gspcli.load(data_path("trajectories", "mode-change.yaml"))
    text = data_path("trajectories", "mode-change.csv").read_text(encoding="utf-8")
    rows = read_values(text, "v", instance, PoseFormat())
    found = track(instance, rows.values, t=rows.t, modes=[2, 1])
    drawn = track_chart(found, "svg")
    assert drawn.startswith(b"<?xml")
    assert len(track_chart(track(instance, rows.values, t=rows.t, modes=[2]), "svg")) < len(drawn)


def test_last_bits_are_not_seen():
    from tools.build.track_charts import track_chart

    instance = gspcli.load(data_path("trajectories", "mode-change.yaml"))
    text = data_path("trajectories", "mode-change.csv").read_text(encoding="utf-8")
    rows = read_values(text, "v", instance, PoseFormat()).subdivided(30)
    found = track(instance, rows.values, t=rows.t, modes=[2, 1])
    other = replace(found, T=found.T * (1 + 1e-10))
    assert (other.T != found.T).any()
    assert track_chart(other, "svg") == track_chart(found, "svg")
