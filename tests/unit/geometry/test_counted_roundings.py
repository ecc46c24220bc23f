"""Bounds of rounding that are counts: the same formulas, run with numbers that count roundings.

A number keeps the sum of the moduli of its terms, and how many roundings any of these terms has
gone through: it errs by at most so many times u = 2^-53 of that sum, to first order.
"""

from __future__ import annotations

import math
import re
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import gspcli
from gspcli.geometry.enclosures import ROUND, roundings
from gspcli.geometry.machine import Machine
from gspcli.geometry.quaternions import apply, dot, rotation_from_quaternion

U = 2.0**-53


class Counted:
    """The sum of the moduli of some terms, and the most roundings of one of them."""

    def __init__(self, size: float, count: float = 0) -> None:
        self.size, self.count = abs(float(size)), count

    @property
    def error(self) -> float:
        return self.count * U * self.size

    def __add__(self, other: Any) -> Counted:
        other = _of(other)
        if not other.size:
            return self
        if not self.size:
            return other
        return Counted(self.size + other.size, max(self.count, other.count) + 1)

    def __mul__(self, other: Any) -> Counted:
        other = _of(other)
        exact = 0.5 in (math.frexp(x.size)[0] for x in (self, other) if not x.count)
        return Counted(self.size * other.size, self.count + other.count + (not exact))

    def __truediv__(self, other: Any) -> Counted:
        return self * _of(other).inverse()

    def __rtruediv__(self, other: Any) -> Counted:
        return _of(other) * self.inverse()

    __radd__ = __sub__ = __rsub__ = __add__
    __rmul__ = __mul__

    def __pow__(self, power: int) -> Counted:
        assert power == 2
        return self * self

    def __neg__(self) -> Counted:
        return self

    __abs__ = __neg__

    # Of sums of squares, which do not cancel; with the quotient one rounding.
    def inverse(self) -> Counted:
        return Counted(1 / self.size, self.count)

    def sqrt(self) -> Counted:
        return Counted(math.sqrt(self.size), self.count / 2 + 1)

    # Functions of NumPy err by less than two roundings.
    def sin(self) -> Counted:
        return Counted(1, 2 + self.count * self.size)

    cos = sin


def _of(x: Any) -> Counted:
    return x if isinstance(x, Counted) else Counted(x)


def counted(size: Any, count: float = 1, shape: tuple[int, ...] = (3,)) -> np.ndarray:
    """Return numbers of a size, by default rounded once."""
    return np.array([Counted(size, count) for _ in range(math.prod(shape))]).reshape(shape)


def length_of(errors: np.ndarray) -> float:
    """Bound the error of a vector."""
    return float(np.linalg.norm([x.error for x in errors.ravel()]))


def unit(size: float = 0.6) -> np.ndarray:
    """Return a direction as `primitives.unit_vectors` makes it."""
    v = counted(size) / Counted(size, 1)
    return v / np.sqrt(dot(v, v))


def rotation() -> np.ndarray:
    """Return exp(w) R: a turn by numbers that err, and an exact rotation."""
    w = counted(0.5, 2)
    half = np.sqrt(dot(w, w)) * 0.5
    # The sine of half the angle over it is at most one, and errs by less than the sine.
    e = np.concatenate(([np.cos(half)], w * (half.sin() * 0.5)))
    e = np.array([Counted(0.5, x.count) for x in e])
    (R,) = rotation_from_quaternion(e[None])
    return R @ counted(3**-0.5, 0, (3, 3))


def position(R: np.ndarray) -> np.ndarray:
    """Return a point of the platform in the base; the largest coordinates are one."""
    return counted(1, 0) + apply(R, counted(1))


def cosines_of_lines() -> tuple[float, float]:
    """Of a DLL (`equations.skew_lines`): R u . v, with entries of a given rotation."""
    columns = np.outer(unit(), unit()).ravel()
    cosine = counted(0.6, 0, (9,)) @ columns
    return cosine.error, roundings(8, cosine.size)


def squared_sines_of_lines() -> tuple[float, float]:
    """Of a DLL, where the cosine is a double."""
    c = Counted(0.6)
    return (Counted(1) - c * c).error, roundings(8, 1 + c.size**2)


def linear_forms_of_poses() -> tuple[float, float]:
    """Of 24 numbers (`poses.isolation`)."""
    form = counted(0.3, 0, (24,)) @ counted(0.7, 0, (24,))
    return form.error, roundings(1, form.size)


def positions_of_hulls() -> tuple[float, float]:
    """Of two bodies (`collisions.compared`), at a pose that is computed itself."""
    return 2 * length_of(position(rotation())), roundings(16, 2)


def points_of_drives(count: int) -> tuple[float, float]:
    """Of cranks and slides: at most so large, and so far from the middle of their motion."""
    drive = SimpleNamespace(
        middle=counted(1, 10, (6, 3)) * 1.0,
        across=counted(0.7, 10, (6, 3)),
        beside=counted(0.7, 10, (6, 3)),
        cranked=np.ones(6, np.bool_),
        _of_constraints=lambda q: q,
    )
    (first, *_) = Machine.points(drive, counted(math.pi, 1, (6, 1)))  # type: ignore[arg-type]
    return length_of(first), roundings(count, 2)


def directions_of_legs() -> tuple[float, float]:
    """Of cones (`paths.between`): in units of the length of a leg, which may be short."""
    length = 0.01
    leg = length_of(position(rotation()) - counted(1))
    turn = leg / length + length_of(
        counted(length) / np.sqrt(dot(counted(length), counted(length)))
    )
    return turn, roundings(16, 1 + 3 / length)


def parameters_in_the_middle(count: int) -> tuple[float, float]:
    """Of boxes and of ways: between numbers that are at most one."""
    middle = Counted(1) + Counted(0.7) * Counted(0.6) * (Counted(1) - Counted(1))
    return middle.error, roundings(count, 1)


def frames() -> tuple[float, float]:
    """Of size one: the distance of a computed rotation from one, with a sum."""
    R = rotation()
    return length_of(R) + length_of(counted(1, 2)), roundings(16, 1)


def second_derivatives_of_a_point() -> tuple[float, float]:
    """Of N times its position (`statics.accuracy`)."""
    arm = apply(counted(0.6, 0, (3, 3)), counted(1, 1))
    entries = arm[0] + arm[1] + arm[2]
    entries = entries + Counted(1, 1)
    # Of sixteen entries, and of the norm of the matrix, which is at least that of the sum.
    return entries.error, roundings(1, entries.size)


def products_with_factors() -> tuple[float, float]:
    """Of matrices about zero (`pose_clearances`): two sums of six products."""
    A = counted(0.5, 0, (6, 6))
    entry = (A @ counted(0.5, 0, (6, 6)) @ A)[0, 0]
    return entry.error, roundings(2, entry.size)


def sums_of_products() -> tuple[float, float]:
    """Of numbers that are rounded, as the type allows for: 24 of them."""
    total = dot(counted(0.3, 1, (24,)), counted(0.3, 1, (24,)))
    return total.error, ROUND * total.size


def points_of_norm_one() -> tuple[float, float]:
    """Of curves (`branches.curves`): a Study point of doubles over its norm."""
    z = counted(0.5, 0, (8,))
    return length_of(z / np.sqrt(dot(z, z))), roundings(1, 1)


def products_with_inverses() -> tuple[float, float]:
    """Of eight terms (`singularities.neighbourhoods`), with numbers that are rounded."""
    total = dot(counted(0.3, 1, (8,)), counted(0.3, 1, (8,)))
    return total.error, roundings(1, total.size)


#: The counts in the package, in their order in each file. One that changes needs another case here.
COUNTS = {
    "certification/branches/curves.py": [1],
    "certification/equations/skew_lines.py": [8, 8],
    "certification/poses/isolation.py": [1],
    # No proof: where a height may have either sign.
    "geometry/measurement.py": [8],
    "motion/collisions/compared.py": [16, 16],
    "motion/following/follower.py": [16],
    "motion/paths/between.py": [16, 16, 16, 16],
    # The first is of LAPACK, the last of coefficients that err by 2^-50 of their moduli.
    "motion/singularities/neighbourhoods.py": [4, 1, 1, 1, 1, 8],
    "motion/singularities/pose_clearances.py": [2],
    "motion/statics/accuracy.py": [4, 1],
    # No proof: products that may be zero.
    "motion/statics/wrenches.py": [28],
    "motion/workspace/pose_boxes.py": [4],
    # As in `skew_lines`.
    "pictures/live_numbers.py": [8],
}


def test_the_counts_of_the_package_are_those_of_the_cases() -> None:
    root = Path(gspcli.__file__).parent
    found = {}
    for path in sorted(root.rglob("*.py")):
        if counts := re.findall(r"\broundings\((\d+)", path.read_text("utf-8")):
            found[path.relative_to(root).as_posix()] = list(map(int, counts))
    assert found == COUNTS


@pytest.mark.parametrize(
    "case",
    [
        cosines_of_lines,
        squared_sines_of_lines,
        linear_forms_of_poses,
        positions_of_hulls,
        partial(points_of_drives, 4),
        partial(points_of_drives, 16),
        directions_of_legs,
        partial(parameters_in_the_middle, 4),
        partial(parameters_in_the_middle, 16),
        frames,
        second_derivatives_of_a_point,
        products_with_factors,
        sums_of_products,
        points_of_norm_one,
        products_with_inverses,
    ],
)
def test_no_formula_has_more_roundings_than_its_bound_allows(case: Any) -> None:
    error, bound = case()
    assert 0.001 * bound < error <= bound


def test_numbers_count() -> None:
    x = Counted(3, 1)
    assert (x * x).count == 3
    assert (x + x * 0.5).count == 2
    assert (x + Counted(0)).count == 1
    assert np.sqrt(np.array([x * x]))[0].count == 2.5
