"""The step of a controller over slides and cranks where branches cross: nothing false is proved.

A platform moves in a plane: along x and y, and about z. Three rods meet in one point when it is at
zero, so that the pose is singular: forces w along the rods are in balance. There the drives move
their ends across the rods. Let F'' be the second derivatives of the squares of the rods. Along
numbers s q' of the drives with sum(w F'' q'^2) = 0 a branch goes through the pose with a motion of
the order of s^2, and crosses others: no step across s = 0 can be proved.
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
#: What keeps a platform in the plane: kind, point of the platform, directions of both bodies.
HELD = [("DPH", NONE, NONE, Z), ("ALH", NONE, Z, X), ("ALH", NONE, Z, Y)]
KINDS = ["BASE_SLIDE", "PLATFORM_SLIDE", "BASE_CRANK", "PLATFORM_CRANK"]


class Node(NamedTuple):
    """Three drives; arrays of shape (3, 3) but for the rods and the numbers of the drives."""

    kind: str
    y: np.ndarray
    """The joints of the platform."""
    x: np.ndarray
    """Those of the base."""
    A: np.ndarray
    """From centres of cranks to their joints; zero for slides."""
    B: np.ndarray
    """Directions of rails; of cranks the axis times A."""
    rods: np.ndarray
    rates: np.ndarray
    """The direction q' in which a branch crosses others."""

    def moved(self, q):
        """Return both joints of the rods where the drives are at q."""
        if "SLIDE" in self.kind:
            way = self.B * q[:, None]
        else:
            way = self.A * (np.cos(q) - 1)[:, None] + self.B * np.sin(q)[:, None]
        return (self.y + way, self.x) if "PLATFORM" in self.kind else (self.y, self.x + way)

    def stated_at(self, q):
        """Return the node with the numbers of its drives counted from q."""
        y, x = self.moved(q)
        if "SLIDE" in self.kind:
            return self._replace(y=y, x=x)
        cosine, sine = np.cos(q)[:, None], np.sin(q)[:, None]
        A, B = self.A * cosine + self.B * sine, self.B * cosine - self.A * sine
        return self._replace(y=y, x=x, A=A, B=B)

    def pose(self, q):
        """Return the pose (x, y, angle) of a branch near zero, by Newton's method, or None."""
        pose = np.zeros(3)
        for _ in range(30):
            y, x = self.moved(q)
            arms = y @ turn(pose[2]).T
            r = arms + np.append(pose[:2], 0) - x
            F = np.einsum("ki,ki->k", r, r) - self.rods**2
            J = 2 * np.column_stack((r[:, :2], arms[:, 0] * r[:, 1] - arms[:, 1] * r[:, 0]))
            pose = pose - np.linalg.lstsq(J, F, rcond=None)[0]
        return pose if np.abs(F).max() < 1e-12 * (1 + self.rods.max() ** 2) else None

    def controller(self, moduli=4.0):
        """Return a controller in units of its own."""
        on_platform, turns = "PLATFORM" in self.kind, "CRANK" in self.kind
        points, bases, A, B, U, V = np.zeros((6, 6, 3))
        points[:3] = self.y - self.A * on_platform
        bases[:3] = self.x - self.A * (not on_platform)
        A[:3], B[:3] = self.A, self.B
        points[3:], U[3:], V[3:] = (np.array([row[k] for row in HELD]) for k in (1, 2, 3))
        names = [self.kind] * 3 + [row[0] for row in HELD]
        crank = np.linalg.norm(B, axis=1)
        numbers = PlatformNumbers(
            kind=np.array([CONTROLLER_KINDS.index(name) for name in names], np.uint8),
            Y=points,
            X=bases,
            U=U,
            V=V,
            A=A,
            B=B,
            crank=crank,
            rod=np.concatenate((self.rods, np.zeros(3))),
            lowest=np.full(6, -NEVER),
            highest=np.full(6, NEVER),
            norm_y=np.linalg.norm(points, axis=1) + crank * (on_platform and turns),
            moduli=np.full(6, moduli),
            middle=NONE,
            origin=NONE,
            reach=1.0,
            shift=0.0,
            unit=np.ones(6),
            offset=np.zeros(6),
            least=np.full(6, -1e9),
            most=np.full(6, 1e9),
            either=np.zeros(6, np.uint8),
        )
        return _kernel.Controller(numbers.kind, numbers.either, numbers.doubles)


def turn(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def placed(pose):
    """Return the position and quaternion of a pose in the plane."""
    return np.array([*pose[:2], 0, np.cos(pose[2] / 2), 0, 0, np.sin(pose[2] / 2)])


def random_node(kind, rng):
    """Return a node of random sizes; None if no branch goes through it with so little motion."""
    sizes = np.exp(rng.uniform(-2, 3, 4))
    y = np.append(rng.normal(size=(3, 2)) * sizes[0], np.zeros((3, 1)), axis=1)
    along = np.append(rng.normal(size=2) * sizes[1], 0) - y
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    ways = np.exp(rng.normal(size=(2, 3))) * rng.choice([-1, 1], (2, 3)) * sizes[2:, None]
    r = -along * ways[0, :, None]
    A = along * ways[1, :, None] * ("CRANK" in kind)
    B = np.cross(Z, A if "CRANK" in kind else along)
    moments = y[:, 0] * r[:, 1] - y[:, 1] * r[:, 0]
    balance = np.linalg.svd(np.column_stack((r[:, :2], moments)))[0][:, -1]
    bent = np.einsum("ki,ki->k", r, A) * (1 if kind == "BASE_CRANK" else -1)
    weights = balance * (np.einsum("ki,ki->k", B, B) + bent)
    up = weights > 0
    if up.all() or not up.any():
        return None
    squares = rng.uniform(0, 1, 3)
    squares[up] *= -(weights[~up] @ squares[~up]) / (weights[up] @ squares[up])
    rates = np.sqrt(squares) * rng.choice([-1, 1], 3)
    return Node(kind, y, y - r, A, B, np.abs(ways[0]), rates / np.linalg.norm(rates))


def started(node, s):
    """Return a controller at s on the branch, numbers counted from there; None if it is another."""
    pose = node.pose(s * node.rates)
    # The motion is of the second order, and no larger than that of the ends of the rods.
    if pose is None or np.abs(pose).max() > abs(s):
        return None
    found = node.stated_at(s * node.rates).controller()
    if found.start(placed(pose)) != FollowerStatus.PROVED or np.abs(found.values()).max() > 1e-6:
        return None
    return found


def step(found, rates, size):
    return FollowerStatus(found.forward(np.concatenate((rates * size, np.zeros(3)))))


@pytest.mark.parametrize("kind", KINDS)
def test_no_step_moves_drives_across_the_crossing(kind):
    rng, counts = np.random.default_rng(11), np.zeros(2, int)
    for _ in range(60):
        node = random_node(kind, rng)
        for size in (1e-3, 1e-2) if node else ():
            found = started(node, size)
            if found is None:
                continue
            # Away from the crossing, and then across it from there.
            away = step(found, node.rates, 0.1 * size) is FollowerStatus.PROVED
            counts += [1, away]
            if away:
                pose = node.pose(1.1 * size * node.rates)
                assert np.allclose(found.rotation(), placed(pose)[3:], atol=1e-7)
            for share in (0.02, 0.3, 1.0):
                status = step(found, node.rates, -(1 + share) * size)
                assert status is not FollowerStatus.PROVED
    assert counts[0] > 30
    assert counts[1] > 0.7 * counts[0]


def slides(body):
    """Return a node of slides, and where they are on a branch: nearer than the other places."""
    rng = np.random.default_rng(2)
    node = next(filter(None, (random_node(f"{body}_SLIDE", rng) for _ in range(9))))
    node = node._replace(rates=np.abs(node.rates))
    return node, -0.01 * node.rates


@pytest.mark.parametrize("body", ["BASE", "PLATFORM"])
def test_a_slide_far_from_where_it_is_stated_is_known_less_well(body):
    node, q = slides(body)
    errors = []
    for far in (0.0, 100.0):
        found = node.stated_at(q - far).controller()
        assert found.start(placed(node.pose(q))) == FollowerStatus.PROVED
        assert np.allclose(found.values()[:3], far)
        assert step(found, np.ones(3), far + 1e-6) is FollowerStatus.PROVED
        errors.append(found.error())
    assert errors[1] > 100 * errors[0]


@pytest.mark.parametrize("body", ["BASE", "PLATFORM"])
def test_a_slide_that_does_not_reach_is_refused(body):
    node, q = slides(body)
    found = node.stated_at(q).controller()
    assert found.start(placed(node.pose(q))) == FollowerStatus.PROVED
    assert found.start(placed([1e3, 1e3, 0])) == FollowerStatus.RANGE
