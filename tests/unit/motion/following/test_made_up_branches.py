"""Branches of made-up equations whose solutions are known: nothing false is proved of a segment.

On the points (1, x, 0, ..., 0) five equations and the Study condition say that all other
coordinates are zero. The sixth is about x^2 = v^2, in each form that an equation can have: two
branches cross at v = 0, and the solution there is double. No segment across it can be proved.
"""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from gspcli import _kernel
from gspcli.certification.branches.parametric_quadrics import Shape, ValueFunction
from gspcli.certification.branches.taylor import MovingQuadrics
from gspcli.motion.following.branch_follower import FollowOptions, Stop
from gspcli.motion.following.branch_steps import BranchSteps, Segment
from gspcli.motion.following.chord_equations import DEGREE, VALUES, Chord, Parts
from gspcli.motion.following.chords import ChordProofs, on_patch, prove
from gspcli.motion.following.cone_limits import _enclosed, _joined
from tests.support.systems import quadric

NORM = quadric(e00=1, e11=1, e22=1, e33=1)
OTHERS = [quadric(**{f"e0{k}": 1}) for k in (2, 3, 5, 6, 7)]
#: Shape and law of the sixth equation, its quadrics A and B, and bounds of c and of A - c N.
EQUATIONS = {
    "square": (Shape.PLAIN, ValueFunction.SQUARE, quadric(e11=1), None),
    "cosine": (Shape.PLAIN, ValueFunction.COSINE, quadric(e00=1), None),
    "product": (Shape.PRODUCT, ValueFunction.SQUARE, quadric(e11=2), quadric(e01=1)),
    "product of squares": (Shape.PRODUCT, ValueFunction.SQUARE, quadric(e11=1), quadric(e11=3)),
    "product without A": (Shape.PRODUCT, ValueFunction.COSINE, NORM, quadric(e01=1)),
    "lines": (Shape.LINES, ValueFunction.SQUARE, quadric(e01=1), quadric(e01=1)),
    "lines that turn": (Shape.LINES, ValueFunction.SQUARE, quadric(e01=1), quadric(e11=3)),
}
#: Up to there all of the equations have solutions.
FARTHEST = 0.16
SPANS = [(1, 0.1), (1, 0.5), (1, 1), (1, 2), (1, 3), (1, 6), (0.3, 3)]


def point(x: float) -> np.ndarray:
    z = np.array([1.0, x, 0, 0, 0, 0, 0, 0])
    return z / np.linalg.norm(z)


def follow(name: str, rows, x: float, *, near=0.0, halvings=0, moduli=1.0, build=""):
    """Follow the branch near x while v takes the values of the rows."""
    shape, law, a, b = EQUATIONS[name]
    hessians = np.zeros((6, 2, 8, 8))
    hessians[0, 0], hessians[1:, 0] = a, OTHERS
    if b is not None:
        hessians[0, 1] = b
    sizes = np.linalg.norm(hessians, ord=2, axis=(2, 3))
    values = np.zeros((1, len(rows), 6))
    values[0, :, 0] = rows
    laws = np.array([law, *[ValueFunction.LINEAR] * 5], np.int32)
    most = 1.0 if law is ValueFunction.COSINE else np.max(np.square(rows))
    largest = np.array([most, *[0.0] * 5])
    found = _kernel.follow(
        np.array([shape, *[Shape.PLAIN] * 5], np.int32),
        laws,
        np.ones(6),
        largest,
        np.maximum(sizes[:, 0], np.abs(sizes[:, 0] - 2 * largest))
        + 2 * largest * (law is ValueFunction.COSINE),
        hessians,
        sizes,
        sizes * moduli,
        values,
        np.zeros(1, np.int64),
        point(x)[None],
        np.array([near]),
        certify=True,
        most_halvings=halvings,
        jobs=1,
        build=build,
    )
    names = "points stop reached fraction last previous segments tries worst near alone"
    return SimpleNamespace(**{key: part[0] for key, part in zip(names.split(), found, strict=True)})


@pytest.mark.parametrize("name", EQUATIONS)
@pytest.mark.parametrize("size", [1e-3, 0.05])
def test_away_from_the_crossing_branches_are_followed(name: str, size: float) -> None:
    for sign in (1, -1):
        found = follow(name, [size, 1.1 * size, 2 * size], sign * size, halvings=10)
        assert found.stop == Stop.END
        assert found.last[0] * found.last[1] * sign > 0
        assert found.alone < 2 * abs(found.last[1])
        assert found.near < 0.01 * size


@pytest.mark.parametrize("name", EQUATIONS)
@pytest.mark.parametrize("size", [1e-3, 0.02, 0.1])
@pytest.mark.parametrize("halvings", [0, 2, 12])
def test_no_branch_is_followed_across_the_crossing(name: str, size: float, halvings: int) -> None:
    for (before, after), sign in ((span, sign) for span in SPANS for sign in (1, -1)):
        found = follow(
            name, [-before * size, after * size], sign * size * before, halvings=halvings
        )
        assert found.stop != Stop.END


@pytest.mark.parametrize("name", EQUATIONS)
def test_where_the_pose_may_be_another_one_no_branch_begins(name: str) -> None:
    """The pose is given up to a distance: no other pose may be within it."""
    x = solution(name, 0.05, 1)
    alone = follow(name, [0.05, 0.052], x).alone
    assert follow(name, [0.05, 0.052], x, near=alone / 8).stop == Stop.END
    for share in (0.3, 0.5, 0.9, 1.1, 3):
        assert follow(name, [0.05, 0.052], x, near=share * alone, halvings=3).stop != Stop.END


@pytest.mark.parametrize(
    "name", [x for x, row in EQUATIONS.items() if row[1] is ValueFunction.SQUARE]
)
def test_terms_that_cancel_make_errors(name: str) -> None:
    """Entries are sums of terms whose moduli may be much larger than the entries."""
    exact, rough = (follow(name, [0.1, 0.103], 0.1, moduli=m) for m in (1.0, 1e4))
    assert exact.stop == rough.stop == Stop.END
    assert rough.near > 100 * exact.near
    assert follow(name, [0.1, 0.103], 0.1, moduli=1e15, halvings=3).stop != Stop.END


def piece(name: str, begin: float, end: float) -> MovingQuadrics:
    """Return the equations for v from one value to another one."""
    shape, law, a, b = EQUATIONS[name]
    quadrics = np.zeros((6, 2, DEGREE + 1, 8, 8))
    quadrics[0, 0, 0], quadrics[1:, 0, 0] = a, OTHERS
    if b is not None:
        quadrics[0, 1, 0] = b
    middle, change = (begin + end) / 2, end - begin
    c = np.array([middle**2, 2 * middle * change, change**2, 0])
    if law is ValueFunction.COSINE:
        # 1 - v^2 / 2 instead.
        c = np.array([1, 0, 0, 0]) - c / 2
    factors = np.zeros((6, DEGREE + 1))
    if shape is Shape.LINES:
        factors[0] = c
    else:
        quadrics[0, 0] -= c[:, None, None] * NORM
    halves = 0.5 ** np.arange(DEGREE + 1)
    at_end = np.einsum("kqdxy,d->kqxy", quadrics, halves), factors @ halves
    return MovingQuadrics(quadrics, np.zeros((6, 2)), factors, np.zeros(6), at_end)


def shapes_of(name: str) -> np.ndarray:
    return np.array([EQUATIONS[name][0], *[Shape.PLAIN] * 5], np.int32)


def solution(name: str, v: float, sign: int) -> float:
    """Return x for a value."""
    shape, law, a, b = EQUATIONS[name]
    c = 1 - v * v / 2 if law is ValueFunction.COSINE else v * v

    def value(x: float) -> float:
        z = np.array([1, x, 0, 0, 0, 0, 0, 0])
        n, first = 1 + x * x, z @ a @ z / 2
        second = 0.0 if b is None else z @ b @ z / 2
        return {
            Shape.PLAIN: first - c * n,
            Shape.PRODUCT: n * (first - c * n) - second**2,
            Shape.LINES: first**2 - c * (n * n - second**2),
        }[shape]

    low, high = 0.0, 1.5 * abs(v)
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (low, middle) if value(middle) * value(1.5 * abs(v)) > 0 else (middle, high)
    return sign * low


NAMES = list(EQUATIONS)


def chord_proof(name: str, begin: float, end: float, x: float, y: float, *, exact: bool, **changes):
    part = replace(piece(name, begin, end), **changes)
    parts = Parts.of(shapes_of(name), [part])
    ends = point(x)[None], point(y)[None]
    chords = None
    if exact:
        _, z, d = on_patch(*ends)
        values = Chord(parts, z, d).values[0]
        errors = np.full(7, 1e-30)
        chords = [SimpleNamespace(residuals=lambda *_: (values[:, :VALUES], errors))]
    return prove(parts, *ends, chords)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("exact", [False, True])
def test_a_chord_on_a_branch_is_proved(name: str, exact: bool) -> None:
    for size in (1e-3, 0.1):
        x, y = (solution(name, v, 1) for v in (size, 1.1 * size))
        found = chord_proof(name, size, 1.1 * size, x, y, exact=exact)
        assert found.measure[0] < 0.98
        assert found.uniqueness[0] < 2 * size
        assert found.end[0] < 1e-9


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("size", [1e-3, 0.02, 0.1])
@pytest.mark.parametrize("exact", [False, True])
def test_no_chord_across_the_crossing_is_proved(name: str, size: float, exact: bool) -> None:
    for before, after in SPANS:
        begin, end = -before * size, min(after * size, FARTHEST)
        for sign, other in ((1, 1), (1, -1)):
            x, y = solution(name, begin, sign), solution(name, end, other)
            assert chord_proof(name, begin, end, x, y, exact=exact).measure[0] >= 1


@pytest.mark.parametrize("name", NAMES)
def test_what_is_left_out_of_the_quadrics_counts(name: str) -> None:
    """x^2 = v^2 known up to v^2: there may be no solution."""
    size = 0.1
    x, y = (solution(name, v, 1) for v in (size, 1.05 * size))
    for share, proved in ((1e-6, True), (1.5, False), (100.0, False)):
        errors = np.zeros((6, 2))
        errors[0, 0] = 2 * share * size ** (1 if EQUATIONS[name][0] is Shape.LINES else 2)
        found = chord_proof(name, size, 1.05 * size, x, y, exact=False, errors=errors)
        assert (found.measure[0] < 1) == proved
        if proved:
            assert found.end[0] > 1e-9


def proofs(measure, end, uniqueness, radius) -> ChordProofs:
    return ChordProofs(*(np.array([x], float) for x in (measure, end, uniqueness, radius)))


def test_two_proofs_are_of_the_same_zero_only_if_one_is_in_the_ball_of_the_other() -> None:
    near, wide = proofs(0.5, 1e-3, 2e-3, 2e-3), proofs(0.6, 1e-4, 0.1, 0.05)
    both = near.joined(wide)
    assert (both.end[0], both.uniqueness[0], both.radius[0]) == (1e-4, 0.1, 2e-3)
    # The ends are farther from the chord than the other proof allows.
    apart = proofs(0.5, 3e-3, 5e-3, 4e-3).joined(proofs(0.6, 4e-3, 2e-3, 1e-3))
    assert (apart.end[0], apart.uniqueness[0], apart.radius[0]) == (3e-3, 5e-3, 4e-3)
    # What proves nothing adds nothing.
    alone = proofs(0.5, 1e-3, 2e-3, 2e-3).joined(proofs(1.2, 1e-9, 0.1, 1e-9))
    assert (alone.end[0], alone.uniqueness[0], alone.radius[0]) == (1e-3, 2e-3, 2e-3)


class MadeUp(BranchSteps):
    """Follows a branch of a made-up equation."""

    name = "square"

    def _part(self, trajectory, row, begin, end):
        rows = self.values[trajectory, :, 0]
        return piece(self.name, rows[row], rows[row])

    def _piece(self, cursor):
        rows = self.values[0, cursor.row : cursor.row + 2, 0]
        part = 2.0**-cursor.level * np.array([cursor.part, cursor.part + 1])
        return piece(self.name, *(rows[0] + part * (rows[1] - rows[0])))


def followed(name: str, rows, x: float, near: float = 0.0, halvings: int = 3):
    values = np.zeros((1, len(rows), 6))
    values[0, :, 0] = rows
    system = SimpleNamespace(shapes=shapes_of(name))
    follower = MadeUp(system, values, FollowOptions(most_halvings=halvings))
    follower.name = name
    return follower.run(np.zeros(1, np.int64), point(x)[None], np.array([near]))


@pytest.mark.parametrize("name", NAMES)
def test_steps_join_only_where_one_pose_is_meant(name: str) -> None:
    x = solution(name, 0.05, 1)
    first = followed(name, [0.05, 0.052, 0.054], x)
    assert first.stop[0] == Stop.END
    alone = float(first.alone[0])
    assert followed(name, [0.05, 0.052], x, near=alone / 8).stop[0] == Stop.END
    for share in (0.5, 0.9, 1.1, 3):
        assert followed(name, [0.05, 0.052], x, near=share * alone).stop[0] == Stop.STEP
    for rows in ([-0.05, 0.05], [-0.05, 0.1], [-0.01, 0.05]):
        start = solution(name, rows[0], 1)
        assert followed(name, rows, start, halvings=8).stop[0] == Stop.STEP


def segment(end: float, alone: float, **more) -> Segment:
    return Segment(0, 0, 0, 0, np.eye(8)[0], np.eye(8)[0], end, end, alone, **more)


def test_halves_of_a_segment_mean_its_pose_only_if_none_other_is_so_near() -> None:
    for exact in (False, True):
        assert _joined(segment(1e-6, 1e-3), segment(1e-6, 1e-3), exact)
        assert _joined(segment(1e-6, 1e-9), segment(1e-3, 1e-5), exact)
        assert not _joined(segment(1e-6, 1e-7), segment(1e-7, 3e-6), exact)
        assert not _joined(segment(1e-3, 1e-4), segment(1e-3, 1e-4), exact)


def test_quadrics_on_a_segment_are_within_their_bounds() -> None:
    """At points within the radius of the chord, with quadrics that differ by their errors."""
    rng = np.random.default_rng(1)
    for seed in range(20):
        first = point(0.1 * seed)
        last = first + 0.05 * rng.normal(size=8)
        last /= np.linalg.norm(last)
        quadrics = np.zeros((1, 1, 2, DEGREE + 1, 8, 8))
        quadrics[0, 0, 0] = rng.normal(size=(DEGREE + 1, 8, 8)) * [[[1]], [[0.2]], [[0.1]], [[0.1]]]
        quadrics += np.swapaxes(quadrics, -1, -2)
        errors = np.array([[[0.1 * (seed % 2), 0.0]]])
        parts = Parts(
            np.zeros(1, np.int32), quadrics, errors, np.zeros((1, 1, 4)), np.zeros((1, 1))
        )
        radius = [0.0, 0.01, 0.1][seed % 3]
        one = replace(segment(0.0, 1.0), first=first, last=last, radius=radius)
        middle, _, wide, _ = (x[0, 0] for x in _enclosed(parts, [one]))
        _, z, d = (x[0] for x in on_patch(first[None], last[None]))
        most = 0.0
        for tau in np.linspace(-0.5, 0.5, 11):
            matrix = np.einsum("dxy,d->xy", quadrics[0, 0, 0], tau ** np.arange(DEGREE + 1))
            for sign in (1, -1):
                x = z + tau * d
                for _ in range(30):
                    # Uphill, as far as the radius.
                    slope = sign * matrix @ x
                    x = z + tau * d + radius * slope / max(np.linalg.norm(slope), 1e-300)
                extreme = x @ matrix @ x / 2 + sign * errors[0, 0, 0] * x @ x / 2
                most = max(most, sign * (extreme - middle))
        assert most <= wide
        assert most > wide / 4
