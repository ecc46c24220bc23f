"""Arms and rails in pictures: they end at the joints, and move along trajectories."""

from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.geometry.drives import Drives
from gspcli.pictures.scene import StrokeStyle
from gspcli.pictures.stage import Poses, scene_of
from tests.support.driven_machines import driven, some_pose


@pytest.mark.parametrize("name", ["reachy-mini-head", "mixed"])
def test_rods_keep_their_lengths_along_poses_and_arms_end_at_their_joints(name) -> None:
    instance = driven(name)
    drives, rng = Drives.of(instance), np.random.default_rng(1)
    poses = [some_pose(instance, rng, spread=0.05)[:2] for _ in range(4)]
    R, T = (np.array(part) for part in zip(*poses, strict=True))
    scene = scene_of(gspcli.solve(instance), [Poses("Trajectory", "t", R, T)])
    shown = scene.series[-1]
    q = drives.inverse(R, T)
    _, ends, _ = drives.ends(R, T, q)
    for k, strokes in enumerate(shown.strokes):
        rod = strokes[0].points
        assert strokes[0].style is StrokeStyle.LEG
        if not drives.driven[k]:
            assert len(strokes) == 1
            continue
        assert np.linalg.norm(rod[:, 0] - rod[:, 1], axis=1) == pytest.approx(drives.rods[k])
        line = strokes[-1].points
        # One end of the arm is the joint of the rod on its body; a rail passes through it.
        joint = rod[:, 0 if drives.on_platform[k] else 1]
        if drives.sorts[drives.index[k]] == "crank":
            assert np.allclose(line[:, 1], joint, atol=1e-9)
            lengths = np.linalg.norm(line[:, 1] - line[:, 0], axis=1)
            assert lengths == pytest.approx(drives.arms[k])
        else:
            along = line[:, 1] - line[:, 0]
            assert np.abs(np.cross(along, joint - line[:, 0])).max() < 1e-9
    assert np.allclose(
        ends + T[:, None], [[s[0].points[n, 0] for s in shown.strokes] for n in range(4)]
    )


def test_in_modes_the_arms_are_where_the_file_states_them() -> None:
    instance = driven("reachy-mini-head")
    drives = Drives.of(instance)
    modes = scene_of(gspcli.solve(instance)).series[0]
    for k, strokes in enumerate(modes.strokes):
        assert np.allclose(
            strokes[-1].points, [drives.middle[k], instance.constraints[k].base.point]
        )


def test_a_machine_without_drives_has_no_further_strokes() -> None:
    legs = scene_of(gspcli.solve(gspcli.example("rubin-m2"))).series[0]
    assert all(len(strokes) == 1 for strokes in legs.strokes)
