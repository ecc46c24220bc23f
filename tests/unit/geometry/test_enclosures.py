"""The type of enclosures: each operation contains exact values; each weakened bound is noticed."""

from __future__ import annotations

import types
from pathlib import Path

import numpy as np
import pytest

from gspcli.geometry import enclosures
from gspcli.geometry.enclosures import Enclosure, Matrix, operator_norm, spectral_norm
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
