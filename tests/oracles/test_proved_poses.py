"""Real poses proved one by one from the equations in the entries of the motion."""

from __future__ import annotations

from collections.abc import Callable
from types import ModuleType

import flint
import pytest
from flint import acb, arb

from gspcli.solver import solve

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


@pytest.fixture
def proofs(load_tool: Callable) -> ModuleType:
    return load_tool("oracle.proved_poses")


def _platform(name: str, load_tool: Callable):
    made = load_tool("special.platforms")
    chosen = next(p for p in made.platforms([name.partition("/")[0]]) if p.id.startswith(name))
    return chosen, made.recorded()[chosen.id]


@pytest.mark.parametrize("name", SAMPLE)
def test_as_many_real_poses_are_proved_as_are_known(name: str, proofs, load_tool) -> None:
    platform, row = _platform(name, load_tool)
    distinct, real = int(row["distinct"]), int(row["real"])
    assert proofs.real_poses(platform.instance, distinct) == real


def test_with_two_poses_missing_nothing_is_said(proofs, load_tool, monkeypatch) -> None:
    monkeypatch.setattr(proofs, "DIGITS", (60,))
    platform, row = _platform(SAMPLE[0], load_tool)
    distinct, real = int(row["distinct"]), int(row["real"])
    # One that is missing would be its own conjugate; two may be a pair.
    assert proofs.real_poses(platform.instance, distinct + 1) == real + 1
    assert proofs.real_poses(platform.instance, distinct + 2) is None
    assert proofs.real_poses(platform.instance, distinct - 1) is None


def test_nothing_is_proved_of_what_is_no_pose(proofs, load_tool) -> None:
    platform, _ = _platform(SAMPLE[0], load_tool)
    pose = solve(platform.instance).solutions[0]
    R, T = [acb(x) for x in pose.R.ravel().tolist()], [acb(x) for x in pose.T.tolist()]
    with flint.ctx.workprec(BITS):
        system = proofs.SquareSystem(platform.instance, BITS)
        proved = system.disc(R, T)
        assert proved is not None
        assert proved.real is pose.real
        # From nearby Newton's method leads to the same pose, from far away to none that is proved.
        shaken = system.disc([x + 1e-9 for x in R], [x - 1e-9 for x in T])
        assert shaken is not None
        assert not shaken.is_apart(proved)
        assert system.disc([x + 7 for x in R], T) is None


def test_of_two_poses_in_one_disc_none_is_proved(proofs, load_tool) -> None:
    # A double pose split by 1e-14: two real poses 1e-7 apart.
    platform, row = _platform("double/axis-1/-1e-14", load_tool)
    found = proofs._certificates(platform.instance)
    proved = {}
    # Discs for 180 bits have a radius of 1e-18, those for 60 one of 1e-6; Newton's method has 180.
    for bits in (180, 60):
        with flint.ctx.workprec(180):
            system = proofs.SquareSystem(platform.instance, bits)
            discs = [proofs._disc(system, platform.instance, item, 15) for item in found]
        proved[bits] = sum(disc is not None for disc in discs)
    assert proved == {180: int(row["distinct"]), 60: int(row["distinct"]) - 2}


def test_a_reflection_is_no_pose(proofs, load_tool) -> None:
    # A plate whose points have z = 0: with the third column of R turned round all distances hold.
    platform, _ = _platform("plates/hexagon", load_tool)
    assert all(row.platform.position[2].value == 0 for row in platform.instance.constraints)
    pose = solve(platform.instance).solutions[0]
    mirrored = pose.R.copy()
    mirrored[:, 2] *= -1
    T = [acb(x) for x in pose.T.tolist()]
    with flint.ctx.workprec(BITS):
        system = proofs.SquareSystem(platform.instance, BITS)
        assert system.disc([acb(x) for x in pose.R.ravel().tolist()], T) is not None
        assert system.disc([acb(x) for x in mirrored.ravel().tolist()], T) is None


def test_discs_that_touch_are_not_apart(proofs) -> None:
    one = proofs.Disc((acb(0), acb(1)), (arb(0.5), arb(0.25)))
    touching = proofs.Disc((acb(0.75), acb(0, 1)), (arb(0.25), arb(2)))
    beyond = proofs.Disc((acb(0, 0.8), acb(1)), (arb(0.25), arb(2)))
    assert not one.is_apart(touching)
    assert one.is_apart(beyond)
    assert beyond.is_apart(beyond.conjugate)
    assert one.real
    assert not beyond.real
