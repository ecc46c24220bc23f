"""Branches of made-up equations whose solutions are known: nothing false is proved of a segment.

On the points (1, x, 0, ..., 0) five equations and the Study condition say that all other
coordinates are zero. The sixth is about x^2 = v^2, in each form that an equation can have: two
branches cross at v = 0, and the solution there is double. No segment across it can be proved.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from gspcli import _kernel
from gspcli.certification.branches.parametric_quadrics import Shape, ValueFunction
from gspcli.motion.following.branch_follower import Stop
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
