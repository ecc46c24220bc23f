"""Boxes of poses, judged by the kernel, against the poses in them: nothing false is proved.

The lines, points and planes are made up, and one limit or one cone counts at a time.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import product

import flint
import numpy as np
import pytest
from flint import arb

from gspcli import _kernel
from gspcli.certification.numbers.limit_balls import limit_balls
from gspcli.geometry.instance import Instance
from gspcli.motion.workspace.pose_boxes import BoxSet, PoseBoxes
from gspcli.motion.workspace.travels import _first_gap
from gspcli.motion.workspace.workspaces import HomePart
from gspcli.resources import data_path
from gspcli.spec import load

#: What is measured, by the numbers of native/reach.hpp.
MEASURES = ["points", "point-line", "line-point", "point-plane", "plane-point", "lines", "angle"]
#: Half widths of boxes: of the position and of the angles.
BOXES = {
    "moved": (0.3, [0, 0, 0]),
    "turned once": (0.0, [0, 0.5, 0]),
    "turned about the first axis": (0.0, [0.7, 0, 0]),
    "turned about all axes": (0.0, [0.25, 0.3, 0.2]),
    "moved and turned": (0.2, [0.3, 0, 0.2]),
}
TURN = np.array([2, 1, 0], np.int32)
REGULAR, NEGATIVE = int(_kernel.REGULAR), int(_kernel.NEGATIVE)
#: Corners, middles of edges and of faces of a box, and the centre.
NODES = np.array(list(product((-1.0, 0.0, 1.0), repeat=6)))


def unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.linalg.norm(vector)


def judge(
    measure, vectors, low, high, centre, half, *, modulus=False, cone=None, left=1
) -> tuple[str, int]:
    """Return whether a box is ``inside``, ``outside`` or ``open``, and the sign of the determinant.

    Parameters
    ----------
    measure
        What is measured, of one limit or of all six.
    vectors
        Point and direction of the platform, and of the base; shape (4, 3) or (6, 4, 3).
    low, high
        The range.
    cone
        Axis, cosine and whether its joint is on the base.
    left
        The conditions that count.
    """
    balls = np.zeros((6, 4, 3, 2))
    balls[..., 0] = vectors
    ranges = np.zeros((6, 2, 2))
    ranges[:, 0, 0], ranges[:, 1, 0] = low, high
    axis, cosine, of_base = cone or (np.zeros(3), 0.0, False)
    cones = [] if cone is None else [0]
    bounds = np.stack((np.asarray(centre) - half, np.asarray(centre) + half), axis=1)
    found = _kernel.judge_boxes(
        np.broadcast_to(np.asarray(measure, np.int32), 6).copy(),
        np.full(6, modulus),
        balls,
        ranges,
        np.array(cones, np.int32),
        np.array([of_base] * len(cones), bool),
        np.array([[[x, 0.0] for x in axis]] * len(cones)).reshape(-1, 3, 2),
        np.array([[cosine, 0.0]] * len(cones)).reshape(-1, 2),
        TURN,
        bounds=np.where((half > 0)[:, None], bounds, np.asarray(centre)[:, None]),
        free=np.flatnonzero(half > 0).astype(np.int32),
        level=0,
        keys=np.zeros(1, np.uint64),
        left=np.array([left], np.uint32),
        split=False,
        jobs=1,
    )
    inside, signs, open_, _ = found
    if len(inside):
        return "inside", -1 if int(signs[0]) & NEGATIVE else 1
    return ("open" if len(open_) else "outside"), 0


def rotations(angles: np.ndarray) -> np.ndarray:
    """Return the products of turns about z, y and x, ``(n, 3) -> (n, 3, 3)``."""
    R = np.broadcast_to(np.eye(3), (len(angles), 3, 3))
    for axis, angle in zip(TURN, angles.T, strict=True):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        turn = np.zeros((len(angles), 3, 3))
        turn[:, axis, axis] = 1
        turn[:, i, i] = turn[:, j, j] = np.cos(angle)
        turn[:, j, i] = np.sin(angle)
        turn[:, i, j] = -turn[:, j, i]
        R = R @ turn
    return R


def poses(centre, half, seed=0) -> tuple[np.ndarray, np.ndarray]:
    """Return positions and rotations of many poses of a box."""
    more = np.random.default_rng(seed).uniform(-1, 1, (300, 6))
    parameters = centre + half * np.concatenate((NODES, more))
    return parameters[:, :3], rotations(parameters[:, 3:])


def measured(measure: int, vectors, p, E) -> np.ndarray:
    """Return what the kernel measures; of lines the distance itself."""
    y, u, x, v = vectors
    r, w = p + E @ y - x, E @ u
    if measure == 0:
        return (r * r).sum(axis=1)
    if measure == 1:
        return (r * r).sum(axis=1) - (r @ v) ** 2
    along = (r * w).sum(axis=1)
    if measure == 2:
        return (r * r).sum(axis=1) - along**2
    if measure == 3:
        return r @ v
    if measure == 4:
        return -along
    if measure == 5:
        normal = np.cross(w, v)
        return np.abs((r * normal).sum(axis=1)) / np.linalg.norm(normal, axis=1)
    return w @ v


def made_up(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the vectors of a limit and the centre of a box."""
    rng = np.random.default_rng(seed)
    y, x = rng.normal(size=(2, 3))
    u, v = (unit(rng.normal(size=3)) for _ in range(2))
    centre = np.concatenate((2 * rng.normal(size=3), rng.uniform(-0.7, 0.7, 3)))
    return np.array([y, u, x, v]), centre


def half_of(box: str) -> np.ndarray:
    move, turns = BOXES[box]
    return np.array([move] * 3 + turns)


@pytest.mark.parametrize("box", BOXES)
@pytest.mark.parametrize("measure", range(7), ids=MEASURES)
@pytest.mark.parametrize("modulus", [False, True])
def test_what_is_proved_of_a_range_holds_at_all_poses(
    box: str, measure: int, modulus: bool
) -> None:
    """The range ends just within what some pose of the box measures, or just beyond it."""
    if modulus and measure not in (3, 4):
        return
    half, proved = half_of(box), 0
    for seed in range(40):
        vectors, centre = made_up(seed)
        values = measured(measure, vectors, *poses(centre, half))
        values = np.abs(values) if modulus else values
        least, most = values.min(), values.max()
        step = 1e-9 * (1 + abs(most))
        power = 2 if measure == 5 else 1

        def says(low, high, vectors=vectors, centre=centre, power=power):
            ends = (x if np.isinf(x) else np.sign(x) * abs(x) ** power for x in (low, high))
            return judge(measure, vectors, *ends, centre, half, modulus=modulus)[0]

        everything = -np.inf, 1e9
        assert says(least + step, everything[1]) != "inside"
        assert says(everything[0], most - step) != "inside"
        if most - step > 0 or measure > 2:
            assert says(most - step, everything[1]) != "outside"
        assert says(everything[0], least + step) != "outside"
        room = 2 * (most - least) + 0.3
        proved += says(least - room, most + room) == "inside"
        proved += says(most + room, everything[1]) == "outside"
    assert proved or measure == 5


@pytest.mark.parametrize("modulus", [False, True])
def test_a_direction_turns_while_the_point_moves(modulus: bool) -> None:
    """The point of the base is in the middle: all but that product is linear."""
    u, y = np.eye(3)[0], np.array([0.5, 0.0, 0.0])
    vectors = np.array([y, u, np.zeros(3), u])
    half = half_of("moved and turned")
    values = measured(4, vectors, *poses(np.zeros(6), half))
    low, high = np.sort(np.abs(values) if modulus else values)[[0, -1]]

    def says(low: float, high: float) -> str:
        return judge(4, vectors, low, high, np.zeros(6), half, modulus=modulus)[0]

    assert says(low + 1e-9, 9.0) != "inside"
    assert says(-9.0, high - 1e-9) != "inside"
    assert says(low - 0.3, high + 0.3) == "inside"


@pytest.mark.parametrize("box", BOXES)
@pytest.mark.parametrize("of_base", [True, False])
@pytest.mark.parametrize("wide", [False, True])
def test_what_is_proved_of_a_cone_holds_at_all_poses(box: str, of_base: bool, wide: bool) -> None:
    half, proved = half_of(box), 0
    for seed in range(60):
        vectors, centre = made_up(seed)
        axis = unit(np.random.default_rng(seed + 1000).normal(size=3))
        p, E = poses(centre, half)
        r = p + E @ vectors[0] - vectors[2]
        size = np.linalg.norm(r, axis=1)
        cosines = (r @ axis if of_base else -(r * (E @ axis)).sum(axis=1)) / size
        least, most = cosines.min(), cosines.max()
        if (least < 0) != wide:
            continue

        def says(cosine, vectors=vectors, centre=centre, axis=axis):
            cone = axis, cosine, of_base
            return judge(0, vectors, 0, 1e9, centre, half, cone=cone, left=1 << 6)[0]

        assert says(least + 1e-9) != "inside"
        assert says(most - 1e-9) != "outside"
        proved += says(least - 0.3) == "inside"
        proved += says(most + 0.3) == "outside"
    assert proved


def test_numbers_of_a_limit_are_known_within_their_radii() -> None:
    """A range of which the ends are balls is kept only by what lies within both."""
    vectors, centre = np.zeros((4, 3)), np.array([1.0, 0, 0, 0, 0, 0])
    balls = np.zeros((6, 4, 3, 2))
    balls[0, 2, 0, 1] = 0.01
    ranges = np.zeros((6, 2, 2))
    ranges[:, 1, 0] = 1.1**2
    half = np.array([1e-9, 0, 0, 0, 0, 0])
    bounds = np.stack((centre - half, centre + half), axis=1)
    nothing = np.zeros((0, 3, 2)), np.zeros((0, 2))
    assert not vectors.any()
    for radius, high, kept in (
        (0.01, 1.02**2, True),
        (0.05, 1.02**2, False),
        (0.0, 0.99**2, False),
    ):
        balls[0, 2, 0, 1], ranges[0, 1, 0] = radius, high
        for blur in (0.0, 0.1):
            ranges[0, 1, 1] = blur
            inside, _, open_, _ = _kernel.judge_boxes(
                np.zeros(6, np.int32),
                np.zeros(6, bool),
                balls,
                ranges,
                np.zeros(0, np.int32),
                np.zeros(0, bool),
                *nothing,
                TURN,
                bounds=bounds,
                free=np.zeros(1, np.int32),
                level=0,
                keys=np.zeros(1, np.uint64),
                left=np.ones(1, np.uint32),
                split=False,
                jobs=1,
            )
            assert len(inside) == (kept and not blur)
            # With the end unknown it may be kept.
            assert not blur or len(open_)


def wrenches(measures, vectors, p, E) -> np.ndarray:
    """Return determinants of the Jacobian matrices, moments about the pivot first."""
    rows = []
    for measure, (y0, u0, x, v0) in zip(measures, vectors, strict=True):
        y, w = E @ y0, E @ u0
        s = p - x
        r, v = s + y, np.broadcast_to(v0, s.shape)
        along = (r * w).sum(axis=1)[:, None]
        if measure == 0:
            force, moment = r, np.cross(y, s)
        elif measure == 1:
            force = r - (r @ v0)[:, None] * v
            moment = np.cross(y, force)
        elif measure == 2:
            force, moment = r - along * w, np.cross(y, s) - along * np.cross(w, s)
        elif measure == 3:
            force, moment = v, np.cross(y, v)
        elif measure == 4:
            force, moment = w, np.cross(w, s)
        elif measure == 5:
            n = np.cross(w, v)
            square = (n * n).sum(axis=1)[:, None]
            m, c = ((a * b).sum(axis=1)[:, None] for a, b in ((r, n), (w, v)))
            force = square * n
            moment = square * (np.cross(y, n) + np.cross(w, np.cross(v, r))) + m * c * n
        else:
            force, moment = np.zeros_like(s), np.cross(w, v)
        rows.append(np.concatenate((moment, force), axis=1))
    return np.linalg.det(np.stack(rows, axis=1))


SETS = [
    [0] * 6,
    [1, 0, 0, 0, 2, 0],
    [2] * 6,
    [3, 0, 4, 0, 0, 3],
    [5, 0, 0, 5, 0, 0],
    [6, 0, 0, 0, 1, 4],
]


@pytest.mark.parametrize("measures", SETS, ids=str)
@pytest.mark.parametrize("box", BOXES)
def test_no_pose_of_a_regular_box_is_singular(measures: list[int], box: str) -> None:
    """The largest boxes that are proved, and their determinants: of one sign."""
    proved = 0
    for seed in range(6):
        parts = [made_up(100 * seed + k)[0] for k in range(6)]
        centre = made_up(seed)[1]
        for size in np.geomspace(0.02, 3, 12):
            half = size * half_of(box)
            verdict, sign = judge(measures, parts, 0, 1, centre, half, left=REGULAR)
            if verdict != "inside":
                continue
            proved += 1
            found = wrenches(measures, parts, *poses(centre, half))
            assert (np.sign(found) == sign).all()
    assert proved


def posts(first) -> np.ndarray:
    """Return six planes of the base: the first one alone is about a turn, by its lever."""
    points = np.array([first, [0, 0, 1], [0, 0, 1], [0, 0, 0], [0, 0, 0], [0, 0, 0]], float)
    normals = np.array([[0, 1, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    return np.stack((points, np.zeros((6, 3)), np.zeros((6, 3)), normals), axis=1)


@cache
def first_singular(angle: float) -> float:
    """Return how far a turn about z from an angle is from a singular one, of `posts`."""
    turns = np.linspace(0, 2, 4001)
    signs = [
        np.sign(
            wrenches(
                [3] * 6,
                posts((1.0, 0, 0)),
                np.zeros((len(turns), 3)),
                rotations(np.stack((angle + way * turns, 0 * turns, 0 * turns), axis=1)),
            )
        )
        for way in (1, -1)
    ]
    return min(float(turns[np.argmax(one != one[0])]) for one in signs if (one != one[0]).any())


@pytest.mark.parametrize("angle", [0.0, 0.4, 0.8, -0.6])
def test_a_lever_is_regular_up_to_where_it_is_none(angle: float) -> None:
    """A plane that a lever pushes against: it turns nothing where the lever is along its normal."""
    limit = first_singular(angle)
    centre = np.array([0.0, 0, 0, angle, 0, 0])
    claims = 0
    for share in (0.2, 0.5, 0.9, 1.01, 1.1, 1.3, 1.6, 2.2):
        half = np.array([0, 0, 0, share * limit, 0, 0])
        verdict, _ = judge([3] * 6, posts((1.0, 0, 0)), 0, 1, centre, half, left=REGULAR)
        claims += verdict == "inside"
        assert share < 1 or verdict != "inside"
    assert claims


def test_a_leg_is_regular_up_to_where_it_has_no_length() -> None:
    """Three legs along the axes, and three levers: the first leg at a distance of one."""
    vectors = posts((1.0, 0, 0))
    vectors[3:] = 0
    vectors[3, 2], vectors[4, 2], vectors[5, 2] = np.eye(3) * -1
    measures = [3, 3, 3, 0, 0, 0]
    for share in (0.2, 0.45, 1.01, 1.1, 1.5, 2.5):
        half = np.array([share, 0, 0, 0, 0, 0])
        centre = np.zeros(6)
        verdict, sign = judge(measures, vectors, 0, 1, centre, half, left=REGULAR)
        found = wrenches(measures, vectors, *poses(centre, half))
        assert (verdict == "inside") == (share < 1)
        if share < 1:
            assert (np.sign(found) == sign).all()


def test_boxes_are_connected_through_faces_or_also_corners() -> None:
    def keys(*places):
        return np.array(
            [sum(x << (16 * d) for d, x in enumerate(place)) for place in places], np.uint64
        )

    def labels(places, levels, touching, periodic=(False,) * 4, poles=-1):
        found = _kernel.connected_boxes(
            keys(*places), np.array(levels, np.int32), 4, touching, np.array(periodic), poles
        )
        return len(set(found.tolist()))

    face, corner = [(0, 0, 0, 0), (1, 0, 0, 0)], [(0, 0, 0, 0), (1, 1, 0, 0)]
    assert [labels(face, [2, 2], x) for x in (False, True)] == [1, 1]
    assert [labels(corner, [2, 2], x) for x in (False, True)] == [2, 1]
    assert [labels([(0, 0, 0, 0), (2, 0, 0, 0)], [2, 2], x) for x in (False, True)] == [2, 2]
    # A box and one of half its size.
    assert [labels([(0, 0, 0, 0), (2, 1, 0, 0)], [1, 2], x) for x in (False, True)] == [1, 1]
    assert [labels([(0, 0, 0, 0), (2, 2, 0, 0)], [1, 2], x) for x in (False, True)] == [2, 1]
    # Both ends of a direction are the same place only if that is said, and only for what may be.
    ends = [(0, 0, 0, 0), (3, 0, 0, 0)]
    around = (True, False, False, False)
    assert [labels(ends, [2, 2], x, around) for x in (False, True)] == [2, 1]
    assert labels(ends, [2, 2], True) == 2
    poles = [(0, 0, 0, 0), (0, 2, 0, 0)]
    assert [labels(poles, [2, 2], x, poles=0) for x in (False, True)] == [2, 1]


def test_what_only_touches_the_part_of_home_may_be_connected() -> None:
    part = HomePart.__new__(HomePart)
    part._sign = np.uint32(0)
    part.indices = [0, 1]
    part.bounds = np.array([[0.0, 4], [0, 4], [0, 0], [0, 0], [0, 0], [0, 0]])

    class Boxes:
        home = np.array([0.5, 0.5, 0, 0, 0, 0])
        middle = "ry"

    part.boxes = Boxes()

    def boxes(*places, conditions=0):
        keys = np.array([x | y << 32 for x, y in places], np.uint64)
        return BoxSet(
            keys, np.full(len(keys), conditions, np.uint32), np.full(len(keys), 2, np.int32)
        )

    nothing = boxes()
    inner, maybe = part.split(boxes((0, 0), (1, 0), (2, 1), (3, 3)), nothing)
    assert inner.keys.tolist() == boxes((0, 0), (1, 0)).keys.tolist()
    assert maybe.keys.tolist() == boxes((2, 1)).keys.tolist()
    # The other sign of the determinant is another part.
    other = boxes((1, 0), conditions=NEGATIVE)
    inner, maybe = part.split(BoxSet.joined((boxes((0, 0)), other)), nothing)
    assert inner.keys.tolist() == [0]
    assert not len(maybe.keys)
    # Whose sign is not proved may be connected.
    inner, maybe = part.split(boxes((0, 0)), boxes((1, 0), conditions=REGULAR))
    assert len(maybe.keys) == 1


def test_intervals_from_home_end_at_the_first_gap() -> None:
    assert _first_gap([(0.0, 0.25), (0.25, 0.5), (0.625, 1.0)]) == 0.5
    assert _first_gap([(0.125, 1.0)]) == 0.0
    assert _first_gap([(0.0, 0.5), (0.125, 0.25), (0.5, 1.0)]) == 1.0


@pytest.fixture(scope="module")
def machine() -> Instance:
    return load(data_path("platforms", "workspace-study.yaml"))


def test_balls_of_limits_contain_the_exact_numbers(machine: Instance) -> None:
    """In a frame that is turned: no coordinate is a double."""
    quaternion = [1.0, 0.1, 0.2, 0.3]
    found = limit_balls(machine, quaternion, [0.0, 0.0, 0.0])
    with flint.ctx.workprec(300):
        w, x, y, z = (arb(part) for part in quaternion)
        n = w * w + x * x + y * y + z * z
        first = [1 - 2 * (y * y + z * z) / n, 2 * (x * y - w * z) / n, 2 * (x * z + w * y) / n]
        for k, row in enumerate(machine.constraints):
            point = [number.ball() for number in row.platform.position]
            turned = sum((a * b for a, b in zip(first, point, strict=True)), arb(0))
            nearest, radius = found.vectors[k, 0, 0].tolist()
            assert abs(turned - nearest) <= radius
            assert radius < 1e-12


def test_the_box_of_all_poses_holds_those_that_keep_the_ranges(machine: Instance) -> None:
    """The farthest position of the pivot: a leg and the arm to its point in one line."""
    for k, row in enumerate(machine.constraints):
        rows = [one if one is row else replace(one, limits=None) for one in machine.constraints]
        alone = replace(machine, constraints=tuple(rows))
        boxes = PoseBoxes(alone, np.eye(3), np.zeros(3))
        y, x = boxes._balls.vectors[k, 0, :, 0], boxes._balls.vectors[k, 2, :, 0]
        low, high = boxes.bounds().T
        far = row.limits[1].value
        for way in np.concatenate((np.eye(3), -np.eye(3))):
            place = x + (far + np.linalg.norm(y)) * way
            assert ((low[:3] <= place) & (place <= high[:3])).all()
            low_here, high_here = boxes.bounds(turning=False).T
            place = x - y + far * way
            assert ((low_here[:3] <= place) & (place <= high_here[:3])).all()
