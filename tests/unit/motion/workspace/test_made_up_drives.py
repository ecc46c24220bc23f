"""Motors that move a point of a rod, judged over boxes of poses, against their inverse kinematics.

The cranks and slides are made up, on the base and on the platform, and one counts at a time: also
ranges that hold both working modes, or none, and boxes across dead points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from gspcli import _kernel
from tests.unit.motion.workspace.test_made_up_boxes import TURN, rotations, unit

REACH, REGULAR, NEGATIVE = int(_kernel.REACH), int(_kernel.REGULAR), int(_kernel.NEGATIVE)
#: Half sizes of boxes, and poses in each: corners first.
SIZES, POSES = (0.3, 0.1, 0.03, 0.01), 48


@dataclass
class Motor:
    """A crank or a slide with its rod; the frame of its body, as it is at home."""

    slide: bool
    on_platform: bool
    working_mode: float
    axis: np.ndarray
    middle: np.ndarray
    across: np.ndarray
    beside: np.ndarray
    other: np.ndarray
    rod: float
    low: float
    high: float
    centre: np.ndarray

    @property
    def ranged(self) -> bool:
        return bool(np.isfinite(self.low))

    def point(self, q: float) -> np.ndarray:
        if self.slide:
            return self.middle + q * self.across
        return self.middle + np.cos(q) * self.across + np.sin(q) * self.beside

    def numbers(self, p: np.ndarray, E: np.ndarray) -> np.ndarray:
        """Return q at poses in the working mode, shape (n,); NaN out of reach."""
        seen = (
            np.einsum("nji,nj->ni", E, self.other - p) if self.on_platform else p + E @ self.other
        )
        w = seen - self.middle
        square = (w * w).sum(axis=1)
        with np.errstate(invalid="ignore"):
            if self.slide:
                along = w @ self.across
                return along - self.working_mode * np.sqrt(self.rod**2 - square + along**2)
            a, b = w @ self.across, w @ self.beside
            c = (square + self.across @ self.across - self.rod**2) / 2 / np.hypot(a, b)
            return np.arctan2(b, a) - self.working_mode * np.arccos(c)

    def keeps(self, q: np.ndarray) -> np.ndarray:
        """Return whether numbers are in the range."""
        if not self.ranged:
            return ~np.isnan(q)
        if not self.slide:
            q = self.low + (q - self.low) % (2 * np.pi)
        return (q >= self.low) & (q <= self.high)

    def arrays(self) -> tuple[np.ndarray, ...]:
        vectors = np.zeros((1, 6, 3, 2))
        ends = (self.point(self.low), self.point(self.high)) if self.ranged else (np.zeros(3),) * 2
        for k, part in enumerate((self.middle, self.across, self.beside, self.axis, *ends)):
            vectors[0, k, :, 0] = part
        vectors[..., 1] = 1e-15
        numbers = np.zeros((1, 3, 2))
        numbers[0, :, 0] = self.low, self.high, self.rod**2
        sorts = np.array([[self.slide, self.on_platform]])
        return np.zeros(1, np.int32), sorts, np.array([self.working_mode]), vectors, numbers


def made_up(rng: np.random.Generator, *, slide: bool, on_platform: bool) -> Motor:
    """Return a motor that is somewhere in or about its range at the centre of a box."""
    axis, middle, other = unit(rng.normal(size=3)), *rng.normal(size=(2, 3))
    across, beside = axis, np.zeros(3)
    if not slide:
        across = unit(np.cross(axis, rng.normal(size=3))) * rng.uniform(0.1, 1)
        beside = np.cross(axis, across)
    centre = np.concatenate((1.5 * rng.normal(size=3), rng.uniform(-0.7, 0.7, 3)))
    q = rng.normal() if slide else rng.uniform(-3, 3)
    width = rng.uniform(0.1, 3) if slide else rng.uniform(0.05, 2 * np.pi)
    low = q - width * rng.uniform(-0.2, 1.2)
    low, high = (low, low + width) if rng.uniform() < 0.85 else (-np.inf, np.inf)
    motor = Motor(
        slide, on_platform, rng.choice([-1.0, 1.0]), axis, middle, across, beside, other, 0.0, low,
        high, centre,
    )  # fmt: skip
    p, E = centre[:3], rotations(centre[None, 3:])[0]
    ends = (other, p + E @ motor.point(q)) if on_platform else (p + E @ other, motor.point(q))
    motor.rod = float(np.linalg.norm(ends[0] - ends[1]))
    # At the centre, near it, or far from it: also out of reach.
    motor.centre = centre + rng.normal(size=6) * rng.choice([0, 0.05, 0.5])
    return motor


def at_a_dead_point(motor: Motor, rng: np.random.Generator) -> None:
    """Change the rod so that it is stretched or folded at the centre of the box, or nearly."""
    p, E = motor.centre[:3], rotations(motor.centre[None, 3:])[0]
    seen = E.T @ (motor.other - p) if motor.on_platform else p + E @ motor.other
    w = seen - motor.middle
    if motor.slide:
        motor.rod = float(np.linalg.norm(np.cross(w, motor.across)))
    else:
        height = w @ motor.axis
        beside = np.linalg.norm(w - height * motor.axis)
        arm = np.linalg.norm(motor.across) * rng.choice([-1, 1])
        motor.rod = float(np.hypot(height, beside + arm))
    motor.rod *= 1 + rng.choice([0, 1e-3, -1e-3, 1e-2])


def judge(motor: Motor, half: np.ndarray, left: int, cone=None, others=None) -> tuple[int, int]:
    """Return 1, 0 or -1 for a box inside, open or outside, and the conditions that are open."""
    inside, signs, open_, still = judged(motor, half, left, cone, others)
    if len(inside):
        return 1, int(signs[0])
    return (0, int(still[0])) if len(open_) else (-1, 0)


def judged(
    motor: Motor, half: np.ndarray, left: int, cone=None, others=None, *, parts: bool = False
) -> tuple[np.ndarray, ...]:
    """Judge a box, or its parts: halved in each direction."""
    balls = np.zeros((6, 4, 3, 2))
    balls[0, 2 if motor.on_platform else 0, :, 0] = motor.other
    if others is not None:
        balls[1:, 0, :, 0], balls[1:, 2, :, 0] = others
    ranges = np.zeros((6, 2, 2))
    ranges[:, 0, 0], ranges[:, 1, 0] = -np.inf, np.inf
    axis, cosine, of_base = cone or (np.zeros(3), 0.0, False)
    cones = [] if cone is None else [0]
    bounds = np.stack((motor.centre - half, motor.centre + half), axis=1)
    return _kernel.judge_boxes(
        np.zeros(6, np.int32), np.zeros(6, bool), balls, ranges, np.array(cones, np.int32),
        np.array([of_base] * len(cones), bool),
        np.array([[[x, 0.0] for x in axis]] * len(cones)).reshape(-1, 3, 2),
        np.array([[cosine, 0.0]] * len(cones)).reshape(-1, 2), TURN,
        bounds=np.where((half > 0)[:, None], bounds, motor.centre[:, None]),
        free=np.flatnonzero(half > 0).astype(np.int32), level=int(parts),
        keys=np.zeros(1, np.uint64), left=np.array([left], np.uint32), split=parts, jobs=1,
        drives=motor.arrays(),
    )  # fmt: skip


def box_of(rng: np.random.Generator, size: float) -> np.ndarray:
    """Return half widths: of positions, of angles, or of both."""
    half = rng.uniform(0.1, 1, 6) * size
    which = rng.integers(3)
    half[[slice(3, 6), slice(0, 3), slice(0, 0)][which]] = 0.0
    return half


def poses_of(rng: np.random.Generator, motor: Motor, half: np.ndarray):
    part = rng.uniform(-1, 1, (POSES, 6))
    part[: POSES // 2] = np.sign(part[: POSES // 2])
    parameters = motor.centre + part * half
    return parameters[:, :3], rotations(parameters[:, 3:])


@pytest.mark.parametrize("slide", [False, True], ids=["crank", "slide"])
@pytest.mark.parametrize("on_platform", [False, True], ids=["base", "platform"])
def test_what_is_proved_of_a_motor_holds_at_all_poses(slide: bool, on_platform: bool) -> None:
    rng = np.random.default_rng(3)
    proved, missed, count = 0, 0, 0
    for size in SIZES:
        for _ in range(120):
            motor, half = made_up(rng, slide=slide, on_platform=on_platform), box_of(rng, size)
            if rng.integers(4) == 0:
                at_a_dead_point(motor, rng)
            says, left = judge(motor, half, REACH | motor.ranged)
            q = motor.numbers(*poses_of(rng, motor, half))
            good = motor.keeps(q)
            assert says != 1 or good.all()
            assert says != -1 or not good.any()
            # What is open may still be proved to be reached.
            assert says != 0 or left & REACH or not np.isnan(q).any()
            if size == SIZES[-1]:
                count += 1
                proved += says != 0
                missed += says == 0 and (good.all() or not good.any())
    assert proved > 0.7 * count
    assert missed < 0.08 * count


@pytest.mark.parametrize("slide", [False, True], ids=["crank", "slide"])
@pytest.mark.parametrize("on_platform", [False, True], ids=["base", "platform"])
def test_what_is_proved_of_the_parts_of_a_box_holds_at_all_poses(
    slide: bool, on_platform: bool
) -> None:
    """What is proved of the box is used for its parts."""
    rng = np.random.default_rng(13)
    proved = count = 0
    for size in SIZES:
        for _ in range(100):
            motor, half = made_up(rng, slide=slide, on_platform=on_platform), box_of(rng, size)
            if rng.integers(3) == 0:
                at_a_dead_point(motor, rng)
            inside, _, open_, _ = judged(motor, half, REACH | motor.ranged, parts=True)
            # Poses in the parts, and at their corners.
            part = rng.uniform(-1, 1, (6 * POSES, 6))
            part[::2] = rng.choice([-1, -1e-9, 1e-9, 1], (3 * POSES, 6))
            free = np.flatnonzero(half > 0)
            shifts = np.arange(len(free), dtype=np.uint64) * np.uint64(64 // len(free))
            keys = ((part[:, free] > 0).astype(np.uint64) << shifts).sum(axis=1)
            parameters = motor.centre + part * half
            good = motor.keeps(motor.numbers(parameters[:, :3], rotations(parameters[:, 3:])))
            assert good[np.isin(keys, inside)].all()
            assert not good[~np.isin(keys, np.concatenate((inside, open_)))].any()
            count += 1
            proved += not len(open_)
    assert 0.4 * count < proved < 0.95 * count


def test_both_working_modes_in_the_range_and_none() -> None:
    """The signs of F at the ends of the range are the same: what is between decides."""
    rng = np.random.default_rng(8)
    both = none = 0
    for _ in range(400):
        motor = made_up(rng, slide=False, on_platform=False)
        if not motor.ranged:
            continue
        p, E = motor.centre[None, :3], rotations(motor.centre[None, 3:])
        q = motor.numbers(p, E)
        motor.working_mode = -motor.working_mode
        other = motor.keeps(motor.numbers(p, E))[0]
        motor.working_mode = -motor.working_mode
        says, _ = judge(motor, np.full(6, 1e-4), REACH | 1)
        if other and motor.keeps(q)[0]:
            both += 1
            assert says >= 0
        if np.isnan(q)[0]:
            none += 1
            assert says <= 0
    assert both > 20
    assert none > 20


@pytest.mark.parametrize("of_base", [True, False], ids=["base", "platform"])
@pytest.mark.parametrize("on_platform", [False, True], ids=["driven base", "driven platform"])
@pytest.mark.parametrize("slide", [False, True], ids=["crank", "slide"])
def test_cones_hold_where_the_rod_is(slide: bool, on_platform: bool, of_base: bool) -> None:
    """The axis of a cone at a crank turns with the arm; the rod leads to where the motor is."""
    rng = np.random.default_rng(5)
    proved = count = 0
    for size in (0.1, 0.02):
        for _ in range(90):
            motor, half = made_up(rng, slide=slide, on_platform=on_platform), box_of(rng, size)
            if rng.integers(3) == 0:
                at_a_dead_point(motor, rng)
            p, E = poses_of(rng, motor, half)
            q = motor.numbers(p, E)
            p, E, q = (part[~np.isnan(q)] for part in (p, E, q))
            if not len(q):
                continue
            axis = unit(rng.normal(size=3))
            moved = np.array([motor.point(x) for x in q])
            turned = np.broadcast_to(axis, moved.shape)
            if not slide and on_platform != of_base:
                n, c, s = motor.axis, np.cos(q)[:, None], np.sin(q)[:, None]
                turned = (axis @ n) * n + c * (axis - (axis @ n) * n) + s * np.cross(n, axis)
            ends = (moved, motor.other) if on_platform else (motor.other, moved)
            r = p + np.einsum("nij,nj->ni", E, np.broadcast_to(ends[0], p.shape)) - ends[1]
            if not of_base:
                turned = np.einsum("nij,nj->ni", E, turned)
            cosines = (r * turned).sum(axis=1) / np.linalg.norm(r, axis=1) * (1 if of_base else -1)
            least, most = cosines.min(), cosines.max()

            def says(cosine, motor=motor, half=half, axis=axis):
                return judge(motor, half, 1 << 6, cone=(axis, cosine, of_base))[0]

            assert says(least + 1e-9) != 1
            assert says(most - 1e-9) != -1
            if size == 0.02:
                count += 2
                proved += (says(least - 0.3) == 1) + (says(most + 0.3) == -1)
    assert proved > 0.5 * count


@pytest.mark.parametrize("on_platform", [False, True], ids=["base", "platform"])
@pytest.mark.parametrize("slide", [False, True], ids=["crank", "slide"])
def test_no_pose_of_a_box_proved_regular_is_singular(slide: bool, on_platform: bool) -> None:
    """One row of the matrix moves with the motor."""
    rng = np.random.default_rng(6)
    proved = 0
    for size in (0.1, 0.03, 0.01):
        for _ in range(80):
            motor, half = made_up(rng, slide=slide, on_platform=on_platform), box_of(rng, size)
            if rng.integers(2):
                at_a_dead_point(motor, rng)
            others = rng.normal(size=(2, 5, 3))
            p, E = poses_of(rng, motor, half)
            q = motor.numbers(p, E)
            says, signs = judge(motor, half, REGULAR, others=others)
            assert says >= 0
            if says == 0:
                continue
            proved += 1
            # What is proved is about the poses that the rod reaches, also near dead points.
            p, E, q = (part[~np.isnan(q)] for part in (p, E, q))
            if not len(q):
                continue
            y = np.broadcast_to(others[0], (len(p), 5, 3))
            x = np.broadcast_to(others[1], (len(p), 5, 3))
            moved = np.array([motor.point(a) for a in q])[:, None]
            other = np.broadcast_to(motor.other, moved.shape)
            own = (moved, other) if on_platform else (other, moved)
            y, x = np.concatenate((own[0], y), axis=1), np.concatenate((own[1], x), axis=1)
            arm = np.einsum("nij,nkj->nki", E, y)
            r = arm + p[:, None] - x
            rows = np.concatenate((np.cross(arm, r), r), axis=2)
            assert set(np.sign(np.linalg.det(rows))) == {-1.0 if signs & NEGATIVE else 1.0}
    assert proved > 25


def test_a_range_of_a_whole_turn_leaves_out_nothing() -> None:
    rng = np.random.default_rng(4)
    for _ in range(300):
        motor = made_up(rng, slide=False, on_platform=bool(rng.integers(2)))
        motor.low = rng.uniform(-3, 3)
        motor.high = motor.low + 2 * np.pi
        says, _ = judge(motor, np.full(6, 1e-3), REACH | 1)
        q = motor.numbers(motor.centre[None, :3], rotations(motor.centre[None, 3:]))
        assert says >= 0 or np.isnan(q[0])
        assert says <= 0 or not np.isnan(q[0])


def test_a_range_of_half_a_turn_is_judged_from_both_sides_of_it() -> None:
    """Ranges of half a turn, a little less and a little more, with boxes at both ends."""
    rng = np.random.default_rng(9)
    for change in (0.0, 1e-15, -1e-15, 1e-6, -1e-6, 1e-3, -1e-3):
        for _ in range(60):
            motor = made_up(rng, slide=False, on_platform=bool(rng.integers(2)))
            motor.centre[:3] *= 1e-1
            p, E = motor.centre[None, :3], rotations(motor.centre[None, 3:])
            motor.low = 0.0
            where = motor.numbers(p, E)[0]
            if np.isnan(where):
                continue
            motor.low = where + rng.choice([-1e-2, 1e-2, -1e-4, 1e-4]) - rng.integers(2) * np.pi
            motor.high = motor.low + np.pi + change
            half = np.full(6, 1e-6)
            says, _ = judge(motor, half, REACH | 1)
            good = motor.keeps(motor.numbers(*poses_of(rng, motor, half)))
            assert says != 1 or good.all()
            assert says != -1 or not good.any()


@pytest.mark.parametrize("working_mode", [1.0, -1.0])
def test_the_least_distance_comes_into_the_range_within_a_box(working_mode: float) -> None:
    """At the centre the rod is too short for all of the range; at one end of the box it is not.

    The other joint moves along x, nearly along the circle. It is too far from the first end of the
    range all the time, and comes near to what follows.
    """
    x, y, z = np.eye(3)
    first = np.pi / 2 - 0.1
    motor = Motor(
        False, False, working_mode, z, np.zeros(3), x, y, np.zeros(3), 1.0, first, first + 1,
        np.array([2.00667 * np.cos(first) + 0.005, 2.00667 * np.sin(first), 0, 0, 0, 0]),
    )  # fmt: skip
    reached = motor.numbers(motor.centre[None, :3] - 0.205 * x, np.eye(3)[None])
    assert motor.keeps(reached)[0]
    half = np.array([0.21, 0, 0, 0, 0, 0])
    assert judge(motor, half, REACH | 1)[0] == 0
    assert judge(motor, half / 100, REACH | 1)[0] == -1


@pytest.mark.parametrize("square", [0.88, 1.12], ids=["folded", "stretched"])
def test_the_nearest_place_of_a_motor_changes_within_a_box(square: float) -> None:
    """The other joint is near the axis: it moves across, and the arm would turn with it."""
    x, y, z = np.eye(3)
    motor = Motor(
        False, False, 1.0, z, np.zeros(3), x, y, np.zeros(3), np.sqrt(square), -np.inf, np.inf,
        np.array([0.05, 0, 0, 0, 0, 0]),
    )  # fmt: skip
    half = np.array([0, 0.05, 0, 0, 0, 0])
    corner = motor.numbers(np.array([[0.05, 0.05, 0]]), np.eye(3)[None])
    middle = motor.numbers(np.array([[0.05, 0, 0]]), np.eye(3)[None])
    assert not np.isnan(corner[0])
    assert np.isnan(middle[0])
    assert judge(motor, half, REACH)[0] == 0
    assert judge(motor, half / 50, REACH)[0] == -1
    # At greater heights no rod reaches; at the least height one does.
    motor.centre[2] = 0.15
    assert judge(motor, half + 0.15 * np.eye(6)[2], REACH)[0] == 0


@pytest.mark.parametrize("on_platform", [False, True], ids=["base", "platform"])
@pytest.mark.parametrize("slide", [False, True], ids=["crank", "slide"])
def test_a_box_with_a_singular_pose_is_not_proved_regular(slide: bool, on_platform: bool) -> None:
    """Near a dead point the rod swings far in a small box: into the line of another leg."""
    rng = np.random.default_rng(12)
    tried = 0
    for _ in range(150):
        motor = made_up(rng, slide=slide, on_platform=on_platform)
        at_a_dead_point(motor, rng)
        half = np.full(6, 10.0 ** -rng.uniform(1, 4))
        corner = motor.centre + half * rng.choice([-1.0, 1.0], 6)
        p, E = corner[None, :3], rotations(corner[None, 3:])
        q = motor.numbers(p, E)[0]
        if np.isnan(q):
            continue
        tried += 1
        own = (motor.point(q), motor.other) if on_platform else (motor.other, motor.point(q))
        # The fifth of the other legs is in the line of the rod at this corner.
        start = p[0] + E[0] @ own[0]
        others = rng.normal(size=(2, 5, 3))
        line = own[1] - start
        others[0, 4] = E[0].T @ (start + 0.3 * line - p[0])
        others[1, 4] = start + 1.4 * line
        assert judge(motor, half, REGULAR, others=others)[0] == 0
    assert tried > 40
