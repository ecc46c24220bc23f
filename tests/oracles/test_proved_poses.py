"""Real poses proved one by one from the equations in the entries of the motion."""

from __future__ import annotations

import flint
import pytest
from flint import acb, arb

from gspcli.solver import solve
from tests.support.oracle import proved_poses
from tests.support.special.platforms import Platform, platforms, recorded

#: A distance of zero, angles of whole degrees, irrational plates, far, close and double poses.
SAMPLE = (
    "published/rubin-camera-hexapod/home/4-places",
    "zero/1",
    "degrees/1/",
    "exact-hexagons/hexagon-5",
    "parallels/DPL-2/1e-16",
    "double/axis-1/+1e-14",
    "at-zero/PH-PP-PP-PP-PP-PP/home/1e-12",
)
BITS = 480


def _platform(name: str) -> tuple[Platform, dict[str, str]]:
    found = next(p for p in platforms([name.partition("/")[0]]) if p.id.startswith(name))
    return found, recorded()[found.id]


@pytest.mark.parametrize("name", SAMPLE)
def test_as_many_real_poses_are_proved_as_are_known(name: str) -> None:
    platform, row = _platform(name)
    distinct, real = int(row["distinct"]), int(row["real"])
    assert proved_poses.real_poses(platform.instance, distinct) == real


def test_with_two_poses_missing_nothing_is_said(monkeypatch) -> None:
    monkeypatch.setattr(proved_poses, "DIGITS", (60,))
    platform, row = _platform(SAMPLE[0])
    distinct, real = int(row["distinct"]), int(row["real"])
    # One that is missing would be its own conjugate; two may be a pair.
    assert proved_poses.real_poses(platform.instance, distinct + 1) == real + 1
    assert proved_poses.real_poses(platform.instance, distinct + 2) is None
    assert proved_poses.real_poses(platform.instance, distinct - 1) is None


def test_nothing_is_proved_of_what_is_no_pose() -> None:
    platform, _ = _platform(SAMPLE[0])
    pose = solve(platform.instance).solutions[0]
    R, T = [acb(x) for x in pose.R.ravel().tolist()], [acb(x) for x in pose.T.tolist()]
    with flint.ctx.workprec(BITS):
        system = proved_poses.SquareSystem(platform.instance, BITS)
        proved = system.disc(R, T)
        assert proved is not None
        assert proved.real is pose.real
        # From nearby Newton's method leads to the same pose, from far away to none that is proved.
        shaken = system.disc([x + 1e-9 for x in R], [x - 1e-9 for x in T])
        assert shaken is not None
        assert not shaken.is_apart(proved)
        assert system.disc([x + 7 for x in R], T) is None


def test_of_two_poses_in_one_disc_none_is_proved() -> None:
    # A double pose split by 1e-14: two real poses 1e-7 apart.
    platform, row = _platform("double/axis-1/-1e-14")
    found = proved_poses._certificates(platform.instance)
    proved = {}
    # Discs for 180 bits have a radius of 1e-18, those for 60 one of 1e-6; Newton's method has 180.
    for bits in (180, 60):
        with flint.ctx.workprec(180):
            system = proved_poses.SquareSystem(platform.instance, bits)
            discs = [proved_poses._disc(system, platform.instance, item, 15) for item in found]
        proved[bits] = sum(disc is not None for disc in discs)
    assert proved == {180: int(row["distinct"]), 60: int(row["distinct"]) - 2}


def test_a_reflection_is_no_pose() -> None:
    # A plate whose points have z = 0: with the third column of R turned round all distances hold.
    platform, _ = _platform("plates/hexagon")
    assert all(row.platform.position[2].value == 0 for row in platform.instance.constraints)
    pose = solve(platform.instance).solutions[0]
    mirrored = pose.R.copy()
    mirrored[:, 2] *= -1
    T = [acb(x) for x in pose.T.tolist()]
    with flint.ctx.workprec(BITS):
        system = proved_poses.SquareSystem(platform.instance, BITS)
        assert system.disc([acb(x) for x in pose.R.ravel().tolist()], T) is not None
        assert system.disc([acb(x) for x in mirrored.ravel().tolist()], T) is None


def test_discs_that_touch_are_not_apart() -> None:
    one = proved_poses.Disc((acb(0), acb(1)), (arb(0.5), arb(0.25)))
    touching = proved_poses.Disc((acb(0.75), acb(0, 1)), (arb(0.25), arb(2)))
    beyond = proved_poses.Disc((acb(0, 0.8), acb(1)), (arb(0.25), arb(2)))
    assert not one.is_apart(touching)
    assert one.is_apart(beyond)
    assert beyond.is_apart(beyond.conjugate)
    assert one.real
    assert not beyond.real
