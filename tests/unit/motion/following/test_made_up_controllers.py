"""The step of a controller on made-up platforms whose poses are known: nothing false is proved.

Five constraints leave one motion, x. The sixth has two poses for each value, and they are the same
at one value: two branches cross there, and no step across it can be proved.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from gspcli import _kernel
from gspcli.motion import FollowerStatus
from gspcli.motion.following.follower import CONTROLLER_KINDS, NEVER, PlatformNumbers

X, Y, Z = np.eye(3)
NONE = np.zeros(3)
#: Kind, points of the platform and of the base, directions of both: of y, z and the rotation.
HELD = [
    ("DPH", NONE, NONE, NONE, Y),
    ("DPH", Z, NONE, NONE, Y),
    ("DPH", X, NONE, NONE, Y),
    ("DPH", NONE, NONE, NONE, Z),
    ("DPH", X, NONE, NONE, Z),
]
#: Of the position and of two turns: a turn about z is left.
TURNING = [
    ("DPH", NONE, NONE, NONE, X),
    ("DPH", NONE, NONE, NONE, Y),
    ("DPH", NONE, NONE, NONE, Z),
    ("ALH", NONE, NONE, Z, X),
    ("ALH", NONE, NONE, Z, Y),
]


class Crossing(NamedTuple):
    """A platform with a crossing."""

    sixth: tuple[str, np.ndarray, np.ndarray, np.ndarray, np.ndarray]
    others: list[tuple[str, np.ndarray, np.ndarray, np.ndarray, np.ndarray]]
    at: float
    """The value there."""
    crank: tuple[np.ndarray, np.ndarray, float] | None = None


CROSSINGS = {
    "leg": Crossing(("DPP", NONE, NONE, NONE, NONE), HELD, 0.0),
    "point-line": Crossing(("DPL", NONE, NONE, NONE, Z), HELD, 0.0),
    "line-point": Crossing(("DLP", NONE, NONE, Z, NONE), HELD, 0.0),
    "cosine": Crossing(("ALL", NONE, NONE, X, X), TURNING, 0.0),
    "minus cosine": Crossing(("AHH", NONE, NONE, X, X), TURNING, np.pi),
    "sine": Crossing(("ALH", NONE, NONE, X, X), TURNING, np.pi / 2),
    "base crank": Crossing(("BASE_CRANK", NONE, NONE, NONE, NONE), HELD, np.pi / 2, (X, Y, 1.0)),
    "platform crank": Crossing(
        ("PLATFORM_CRANK", NONE, NONE, NONE, NONE), HELD, np.pi / 2, (X, Y, 1.0)
    ),
}


def controller(crossing: Crossing, *, moduli: float = 4.0, most: float = 1e9):
    """Return a controller of a platform in units of its own."""
    rows = [crossing.sixth, *crossing.others]
    points, bases, u, v = (np.array([row[k] for row in rows]) for k in (1, 2, 3, 4))
    A, B, rod = np.zeros((6, 3)), np.zeros((6, 3)), np.zeros(6)
    if crossing.crank:
        A[0], B[0], rod[0] = crossing.crank
    crank = np.linalg.norm(A, axis=1)
    numbers = PlatformNumbers(
        kind=np.array([CONTROLLER_KINDS.index(row[0]) for row in rows], np.uint8),
        Y=points,
        X=bases,
        U=u,
        V=v,
        A=A,
        B=B,
        crank=crank,
        rod=rod,
        lowest=np.full(6, -NEVER),
        highest=np.full(6, NEVER),
        norm_y=np.linalg.norm(points, axis=1) + crank,
        moduli=np.full(6, moduli),
        middle=np.zeros(3),
        origin=np.zeros(3),
        reach=1.0,
        shift=0.0,
        unit=np.ones(6),
        offset=np.zeros(6),
        least=np.full(6, -1e9),
        most=np.full(6, most),
        either=np.zeros(6, np.uint8),
    )
    return _kernel.Controller(numbers.kind, numbers.either, numbers.doubles)


def pose(name: str, value: float, branch: int) -> np.ndarray:
    """Return a pose for a value: position and quaternion."""
    if name in ("leg", "point-line", "line-point"):
        return np.array([branch * value, 0, 0, 1, 0, 0, 0])
    if "crank" in name:
        # |x - cos c| = |cos c| for a rod as long as the crank: one branch is zero.
        x = 2 * np.cos(value) if branch > 0 else 0.0
        return np.array([-x if "platform" in name else x, 0, 0, 1, 0, 0, 0])
    angle = (
        branch * {"cosine": value, "minus cosine": np.pi - value, "sine": np.pi / 2 - value}[name]
    )
    return np.array([0, 0, 0, np.cos(angle / 2), 0, 0, np.sin(angle / 2)])


def started(name: str, value: float, branch: int, **options: float):
    found = controller(CROSSINGS[name], **options)
    assert found.start(pose(name, value, branch)) == FollowerStatus.PROVED
    assert abs(found.values()[0] - value) < 1e-7
    return found


def step(found, value: float) -> FollowerStatus:
    values = np.zeros(6)
    values[0] = value
    return FollowerStatus(found.forward(values))


NAMES = [name for name in CROSSINGS if "crank" not in name]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("branch", [1, -1])
@pytest.mark.parametrize("size", [1e-4, 3e-4, 1e-3, 0.03, 0.2])
def test_no_step_leads_across_the_crossing(name: str, branch: int, size: float) -> None:
    at = CROSSINGS[name].at
    way = -1 if name == "minus cosine" or name == "sine" else 1
    for share in (0.3, 0.5, 0.7, 0.9, 1.0, 1.1, 1.5, 2, 3):
        found = started(name, at + way * size, branch)
        assert step(found, at + way * 1.1 * size) is FollowerStatus.PROVED
        assert step(found, at - way * share * size) is not FollowerStatus.PROVED
        # It goes on where it was; nearer than that to the crossing it may refuse.
        if size >= 1e-3:
            assert step(found, at + way * 0.95 * size) is FollowerStatus.PROVED


@pytest.mark.parametrize("name", NAMES)
def test_no_other_pose_is_nearer_than_a_step_says(name: str) -> None:
    at = CROSSINGS[name].at
    way = -1 if name == "minus cosine" or name == "sine" else 1
    for size in (1e-4, 3e-4, 1e-3):
        found = started(name, at + way * size, 1)
        assert step(found, at + way * 1.05 * size) is FollowerStatus.PROVED
        _, _, alone, *_ = found.report()
        assert 0.1 * size < alone < 2 * size
        assert found.error() < 1e-3 * alone


@pytest.mark.parametrize("name", ["base crank", "platform crank"])
def test_no_step_turns_a_crank_across_the_crossing(name: str) -> None:
    """A rod as long as its crank: at a right angle both poses are the same."""
    for size in (0.03, 0.2):
        for share in (0.5, 1.0, 1.5, 3):
            found = controller(CROSSINGS[name])
            first = np.pi / 2 - size
            assert found.start(pose(name, first, 1)) == FollowerStatus.PROVED
            begun = found.values()[0]
            assert abs(begun - first) < 1e-9
            assert step(found, first + 0.1 * size) is FollowerStatus.PROVED
            assert step(found, np.pi / 2 + share * size) is not FollowerStatus.PROVED


@pytest.mark.parametrize("name", ["leg", "point-line", "line-point"])
def test_numbers_that_are_hardly_known_prove_no_step(name: str) -> None:
    """What rounding may do grows with the moduli of all that coordinates are sums of."""
    errors = []
    for moduli in (4.0, 1e3):
        found = started(name, 0.1, 1, moduli=moduli)
        assert step(found, 0.11) is FollowerStatus.PROVED
        errors.append(found.error())
    # They are of squares.
    assert errors[1] > 1e4 * errors[0]
    assert step(started(name, 0.1, 1, moduli=1e7), 0.11) is not FollowerStatus.PROVED


def test_values_beyond_a_limit_are_refused() -> None:
    found = started("leg", 0.5, 1, most=0.6)
    assert step(found, 0.55) is FollowerStatus.PROVED
    assert step(found, 0.65) is FollowerStatus.RANGE
    assert step(found, np.nan) is FollowerStatus.NOT_FINITE
