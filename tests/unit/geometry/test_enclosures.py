"""The type of enclosures: each operation contains exact values; each weakened bound is noticed."""

from __future__ import annotations

import math
import re
import types
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import gspcli
from gspcli.geometry import enclosures
from gspcli.geometry.enclosures import (
    ROUND,
    Enclosure,
    Matrix,
    operator_norm,
    roundings,
    spectral_norm,
)
from gspcli.geometry.machine import Machine
from gspcli.geometry.quaternions import apply, dot, rotation_from_quaternion
from tests.support.enclosures import OPERATIONS, Exact, exact, mp, singular_values_hold, violation

SOURCE = Path(enclosures.__file__).read_text("utf-8")


@pytest.mark.parametrize("name", OPERATIONS)
def test_every_member_is_enclosed(name: str) -> None:
    assert violation(enclosures, name) <= 0


def test_singular_values_are_enclosed() -> None:
    assert singular_values_hold(enclosures)


@pytest.mark.parametrize("name", OPERATIONS)
def test_middles_are_those_of_another_arithmetic(name: str) -> None:
    """Of exact inputs. Bounds alone do not tell a wrong formula from a right one."""
    sizes, formula, value, *_ = OPERATIONS[name]
    rng = np.random.default_rng(4)
    given = [np.abs(rng.normal(size=d)) + 0.5 for d in sizes]
    if name == "across":
        given[1] /= np.linalg.norm(given[1])
    if name in ("most", "least", "ends", "widened"):  # They have other middles.
        return
    found = formula(enclosures, *map(Enclosure, given))
    there = [float(x) for x in value(*map(exact, given))]
    np.testing.assert_allclose(found.mid, there, rtol=1e-14)
    assert found.rad <= 1e-12 * np.linalg.norm(there)


def test_linear_parts_alone_are_rounded() -> None:
    """The sum of 0.1 u and 0.2 u errs by 2.8e-17, though both are zero in the middle."""
    parts = [Enclosure(np.zeros(1), 0.0, np.array([[x]])) for x in (0.1, 0.2)]
    found = parts[0] + parts[1]
    off = abs(mp.mpf(0.1) + mp.mpf(0.2) - mp.mpf(float(found.lin[0, 0])))
    assert 0 < off <= mp.mpf(float(found.rad))


def test_what_does_not_depend_on_parameters_joins_what_does() -> None:
    constant = Enclosure([1.0, 2.0, 3.0])
    moving = Enclosure([0.0, 0.0, 1.0], 0.0, np.eye(3), cube=False)
    for found in (constant + moving, moving + constant, moving.cross(constant)):
        assert not found.cube
        assert found.lin.shape == (3, 3)
    assert float((constant * Enclosure([2.0])).mid[2]) == 6


def test_nothing_is_known_of_functions_beyond_their_domains() -> None:
    wide = Enclosure([[1.0], [1.0]], [1.0, 0.5])
    with np.errstate(divide="ignore"):
        functions = [wide.inverse(), wide.sqrt(), wide.unit()]
    for found in functions:
        assert np.isfinite(found.rad).tolist() == [False, True]


def test_bounds_of_norms_of_matrices() -> None:
    rng = np.random.default_rng(1)
    for matrix in [*rng.normal(size=(20, 5, 5)), np.ones((5, 5)), np.eye(5), np.zeros((5, 5))]:
        exact_norm = mp.svd_r(mp.matrix(matrix.tolist()), compute_uv=False)[0]
        assert exact_norm <= mp.mpf(float(operator_norm(matrix)))
        both = matrix + matrix.T
        exact_norm = mp.svd_r(mp.matrix(both.tolist()), compute_uv=False)[0]
        assert exact_norm <= mp.mpf(float(spectral_norm(both)))


@pytest.mark.parametrize("kinds", range(8))
def test_matrices_of_second_derivatives_are_enclosed(kinds: int) -> None:
    """``2 (a H + g g^T) - c (K - 2 b b^T)`` with members of everything."""
    zero = [(kinds >> k) & 1 for k in range(3)]
    rng = np.random.default_rng(kinds)
    for _ in range(6):
        H, K = (0.5 * (x + x.T) for x in rng.normal(size=(2, 3, 3)))
        g, b = rng.normal(size=(2, 3)) * (not zero[1])
        a, c = rng.normal(size=(2, 1)) * (not zero[2])
        radii = 10.0 ** rng.uniform(-9, -1, 4) * (not zero[0])
        given = [Enclosure(x, r) for x, r in zip((a, c, g, b), radii, strict=True)]
        A, C, G, B = given
        h, k = Matrix.exact(H, 1e-3), Matrix.exact(K)
        found = 2.0 * h.times(A) + Matrix.outer(G, G)
        found = found - (k - Matrix.outer(B, B)).times(C)
        for _ in range(4):
            p, q, r, s = (Exact(x.mid, rng).member(float(x.rad)).x for x in given)
            step = rng.normal(size=(3, 3))
            step = (step + step.T) * 1e-3 / np.linalg.norm(step + step.T)
            there = [
                2 * p[0] * (mp.mpf(H[i, j]) + mp.mpf(step[i, j]) * (1 - mp.mpf(2) ** -40))
                + 2 * r[i] * r[j]
                - q[0] * (mp.mpf(K[i, j]) - 2 * s[i] * s[j])
                - mp.mpf(float(found.mid[i, j]))
                for i in range(3)
                for j in range(3)
            ]
            off = mp.svd_r(mp.matrix(3, 3) + mp.matrix([there[:3], there[3:6], there[6:]]))[1][0]
            assert off <= mp.mpf(float(found.rad))
        assert np.linalg.norm(found.mid, ord=2) <= found.top


# A text of the module, what replaces it, and the operation that is wrong then.
WEAKENED = [
    ("da * db + ROUND", "0 * da * db + ROUND", "cross"),
    ("a * other.rad +", "0 * a * other.rad +", "dot"),
    ("+ self.rad * b +", "+ 0 * self.rad * b +", "dot"),
    ("da * db + ROUND * (a + da) * (b + db)", "da * db", "dot"),
    ("rad = self.rad + other.rad + ROUND", "rad = self.rad + ROUND", "add"),
    ("rad = self.rad + other.rad + ROUND", "rad = other.rad + ROUND", "add"),
    ("other.rad + ROUND * (self.most + other.most)", "other.rad", "add"),
    ("ROUND * (self.most + other.most)", "ROUND * (size(self.mid) + size(other.mid))", "add"),
    ("rad = self.rad + other.rad + ROUND", "rad = np.maximum(self.rad, other.rad) + ROUND", "add"),
    ("(self.rad + ROUND * self.most)", "self.rad", "factor"),
    ("np.abs(f[..., 0]) * (self.rad +", "(self.rad +", "factor"),
    (
        "rad = of * self.rad + ROUND * _frobenius(matrix) * self.most",
        "rad = of * self.rad",
        "under",
    ),
    ("rad = of * self.rad + ROUND", "rad = 0.9 * of * self.rad + ROUND", "under rank one"),
    ("of * self.reach**2 / 2", "of * self.rad**2 / 2", "quadric rank one"),
    ("of * self.reach**2 / 2", "of * self.reach**2 / 4", "quadric rank one"),
    ("rad = size(gradient) * self.rad + of", "rad = of", "quadric"),
    ("rad + ROUND * _frobenius(matrix) * self.most**2", "rad", "quadric"),
    ("+ bend * reach**2 / 2", "", "cos"),
    ("+ bend * reach**2 / 2", "+ bend * reach**2 / 4", "cos"),
    ("+ bend * reach**2 / 2", "+ bend * self.rad**2 / 2", "cos"),
    ("rad + error + 4 * ROUND * np.abs(value[..., 0])", "rad + error", "inverse"),
    ("(self.rad + ROUND * reach)", "0", "sin"),
    ("2 / self.least**3", "1 / self.least**3", "inverse"),
    ("2 / self.least**3", "2 / size(self.mid)**3", "inverse"),
    ("0.25 / np.where", "0.1 / np.where", "sqrt"),
    ("low = self.ends[0]", "low = self.mid[..., 0]", "sqrt"),
    ("np.cos(self.mid), np.ones", "np.cos(self.mid), 0.5 * np.ones", "sin"),
    ("-np.sin(self.mid), np.ones", "-np.sin(self.mid), np.zeros", "cos"),
    ("self.reach**2 / (2 * n[..., 0] * (2 - OUT))", "0", "norm"),
    ("self.reach**2 / (2 * n[", "self.reach**2 / (8 * n[", "norm"),
    ("rad + 4 * ROUND * self.most", "rad", "norm"),
    ("reach / (least + reach / 2)", "reach / (least + reach)", "unit"),
    ("+ 0.58 * reach**2 / least**2", "", "unit"),
    ("+ 0.58 * reach**2", "+ 0.1 * reach**2", "unit"),
    ("self.rad / (least + reach) +", "", "unit"),
    ("rad + 4 * ROUND, np.inf", "rad, np.inf", "unit"),
    ("rad = self.rad + unit.rad * size(self.mid) + ROUND", "rad = self.rad + ROUND", "across"),
    ("rad = self.rad + unit.rad", "rad = unit.rad", "across"),
    ("size(self.mid) + ROUND * self.most", "size(self.mid)", "across"),
    ("np.sqrt(squares) * OUT + TINY", "max(part.rad for part in parts)", "joined"),
    ("np.sqrt(squares) * OUT + TINY", "parts[0].rad", "joined"),
    ("columns.sum(axis=-1) if self.cube else", "", "most"),
    ("(self.slope + self.rad) * OUT", "self.rad * OUT", "most"),
    ("(self.slope + self.rad) * OUT", "np.maximum(self.slope, self.rad) * OUT", "most"),
    ("(self.slope + self.rad) * OUT", "self.slope * OUT", "most"),
    ("(size(self.mid) + self.reach) * OUT", "(size(self.mid) + self.rad) * OUT", "most"),
    ("- self.reach * OUT, 0.0)", "- self.rad * OUT, 0.0)", "least"),
    ("(self.reach + ROUND * np.abs(self.mid[..., 0])) * OUT", "self.rad * OUT", "ends"),
    ("rad * OUT, np.inf), lin", "rad * 0.999, np.inf), lin", "dot"),
    ("ROUND * np.maximum(size(mid), scale)", "0 * np.maximum(size(mid), scale)", "rounded"),
    ("self.rad + np.asarray(more))", "self.rad)", "widened"),
    ("self.rad + np.asarray(more))", "np.asarray(more))", "widened"),
    ("vectors)) * OUT + TINY", "vectors)) * 0.9", "most"),
    ("ROUND = 2.0**-48", "ROUND = 2.0**-54", "24 terms"),
    ("(size(rows.reach) + 16", "(rows.reach.max(axis=-1) + 16", "singular values"),
    ("size(rows.reach) + 16 * ROUND * values[..., 0]", "size(rows.reach)", "singular values"),
]


@pytest.mark.parametrize(
    ("old", "new", "name"), WEAKENED, ids=[f"{name} {k}" for k, (_, _, name) in enumerate(WEAKENED)]
)
def test_weakened_bounds_are_noticed(old: str, new: str, name: str) -> None:
    assert SOURCE.count(old) == 1
    weakened = types.ModuleType("weakened")
    exec(compile(SOURCE.replace(old, new), "weakened", "exec"), weakened.__dict__)
    if name == "singular values":
        assert not singular_values_hold(weakened)
    else:
        assert not violation(weakened, name, cases=150, members=8) <= 0


# Bounds of rounding that are counts: the same formulas, run with numbers that count roundings.


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
