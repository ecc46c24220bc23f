"""Exact members of enclosures, with 60 digits: what every operation and every proof must contain.

An operation is registered with the same function of exact vectors. Its inputs are sparse: middles,
linear parts and radii are zero at random, so that each term of a bound is once the only one.
Members are drawn at the edge.

A proof by plain formulas does not know its type. Run with `Exact`, it computes with one member of
each input, and where it allows for a difference (`widened`) the adversary moves by a vector of just
that length. So every enclosure that a proof returns must contain what the adversary returns.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from mpmath import MPContext

mp = MPContext()
mp.dps = 60

Vector = list[Any]


class Exact:
    """A vector of 60 digits with the operations of `Enclosure`."""

    is_ball = True

    def __init__(self, x: Sequence[Any], rng: np.random.Generator | None = None) -> None:
        self.x = [mp.mpf(v) if isinstance(v, (int, float)) else v for v in x]
        self.rng = rng or np.random.default_rng(11)

    def _new(self, x: Sequence[Any]) -> Exact:
        return Exact(x, self.rng)

    def __add__(self, other: Exact) -> Exact:
        return self._new([a + b for a, b in zip(self.x, other.x, strict=True)])

    def __sub__(self, other: Exact) -> Exact:
        return self._new([a - b for a, b in zip(self.x, other.x, strict=True)])

    def __neg__(self) -> Exact:
        return self._new([-a for a in self.x])

    def __mul__(self, other: Exact) -> Exact:
        short, long = (self, other) if len(self.x) == 1 else (other, self)
        return self._new([short.x[0] * b for b in long.x])

    def __rmul__(self, factor: float) -> Exact:
        return self._new([mp.mpf(float(factor)) * b for b in self.x])

    def dot(self, other: Exact) -> Exact:
        return self._new([sum(a * b for a, b in zip(self.x, other.x, strict=True))])

    def cross(self, other: Exact) -> Exact:
        a, b = self.x, other.x
        pairs = ((1, 2), (2, 0), (0, 1))
        return self._new([a[i] * b[j] - a[j] * b[i] for i, j in pairs])

    def across(self, unit: Exact) -> Exact:
        return self - unit * unit.dot(self)

    def norm(self) -> Exact:
        return self._new([mp.sqrt(self.dot(self).x[0])])

    def unit(self) -> Exact:
        far = self.norm().x[0]
        return self._new([v / far for v in self.x])

    def inverse(self) -> Exact:
        return self._new([1 / self.x[0]])

    def sqrt(self) -> Exact:
        return self._new([mp.sqrt(self.x[0])])

    def sin(self) -> Exact:
        return self._new([mp.sin(self.x[0])])

    def cos(self) -> Exact:
        return self._new([mp.cos(self.x[0])])

    def under(self, matrix: np.ndarray, of: object = None) -> Exact:
        return self._new(
            [
                sum(mp.mpf(float(a)) * b for a, b in zip(row, self.x, strict=True))
                for row in np.asarray(matrix)
            ]
        )

    def quadric(self, matrix: np.ndarray, of: object = None) -> Exact:
        return self._new([self.dot(self.under(matrix)).x[0] / 2])

    @property
    def most(self) -> Any:
        return self.norm().x[0]

    def take(self, *index: object) -> Exact:
        return self

    def widened(self, more: Any) -> Exact:
        away = [mp.mpf(v) for v in self.rng.normal(size=len(self.x))]
        far = length(away)
        return self._new([a + mp.mpf(more) * b / far for a, b in zip(self.x, away, strict=True)])

    def member(self, radius: float, *, unit: bool = False) -> Exact:
        """Return a vector at the edge of a ball about this one."""
        found = self.widened(mp.mpf(radius) * (1 - mp.mpf(2) ** -48))
        return found.unit() if unit else found


class ExactJet:
    """A function of a vector of 60 digits with its derivatives, with the operations of `Jet`."""

    def __init__(self, value: Any, gradient: Exact, bend: list[Exact]) -> None:
        self.value, self.gradient, self.bend = value, gradient, bend

    @classmethod
    def quadric(cls, matrix: Any, x: Exact) -> ExactJet:
        """Return a quadric of one matrix, moved at random by its radius."""
        middle = matrix.mid.reshape(matrix.mid.shape[-2:])
        step = x.rng.normal(size=middle.shape)
        step = step + step.T
        share = float(np.squeeze(matrix.rad)) * (1 - 1e-12) / np.linalg.norm(step)
        bend = [Exact(a) + Exact(b * share) for a, b in zip(middle, step, strict=True)]
        gradient = Exact([row.dot(x).x[0] for row in bend])
        return cls(gradient.dot(x).x[0] / 2, gradient, bend)

    def _with(self, other: ExactJet, sign: int) -> ExactJet:
        bend = [a + sign * b for a, b in zip(self.bend, other.bend, strict=True)]
        return ExactJet(
            self.value + sign * other.value, self.gradient + sign * other.gradient, bend
        )

    def __add__(self, other: ExactJet) -> ExactJet:
        return self._with(other, 1)

    def __sub__(self, other: ExactJet) -> ExactJet:
        return self._with(other, -1)

    def __mul__(self, other: ExactJet) -> ExactJet:
        f, g = Exact([self.value]), Exact([other.value])
        bend = [
            f * h + g * k + Exact([p]) * other.gradient + Exact([q]) * self.gradient
            for h, k, p, q in zip(
                other.bend, self.bend, self.gradient.x, other.gradient.x, strict=True
            )
        ]
        return ExactJet(self.value * other.value, f * other.gradient + g * self.gradient, bend)

    def times(self, number: Exact) -> ExactJet:
        bend = [number * row for row in self.bend]
        return ExactJet(self.value * number.x[0], number * self.gradient, bend)


def outside(enclosure: Any, exact: Exact, u: Sequence[float] = ()) -> float:
    """Return by which part of the radius a value is outside; not positive if it is inside."""
    middle = np.atleast_1d(enclosure.mid)
    lin = np.broadcast_to(enclosure.lin, (len(middle), len(u)))
    at = [
        mp.mpf(float(a))
        + sum(mp.mpf(float(b)) * mp.mpf(float(c)) for b, c in zip(row, u, strict=True))
        for a, row in zip(middle, lin, strict=True)
    ]
    off = length([a - b for a, b in zip(exact.x, at, strict=True)])
    radius = mp.mpf(float(np.squeeze(enclosure.rad)))
    return float((off - radius) / (radius + mp.mpf(10) ** -300))


def length(x: Vector) -> Any:
    return mp.sqrt(sum(v * v for v in x))


def exact(x: Any) -> Vector:
    return [mp.mpf(float(v)) for v in np.atleast_1d(x)]


# What is registered: a name, the sizes of the vectors, the formula with the module of enclosures,
# and the same formula of exact vectors.
Operation = tuple[tuple[int, ...], Callable[..., Any], Callable[..., Vector], bool, bool]
OPERATIONS: dict[str, Operation] = {}


def _encloses(
    name: str,
    sizes: tuple[int, ...],
    formula: Callable[..., Any],
    value: Callable[..., Any],
    *,
    positive: bool = False,
    of_unit: bool = False,
) -> None:
    def computed(*given: Vector) -> Vector:
        found = value(*map(Exact, given))
        return found.x if isinstance(found, Exact) else list(found)

    OPERATIONS[name] = sizes, formula, computed, positive, of_unit


THIRDS = 1 / np.linspace(3, 5, 24)
MATRIX = np.random.default_rng(3).normal(size=(4, 4))
#: Of rank one: the norm is that of Frobenius.
ONE = np.outer([1, 2, 3, 4.0], [1, 1, -1, 2.0])
SYMMETRIC, SQUARE = MATRIX + MATRIX.T, np.outer([1, 2, 3, 4.0], [1, 2, 3, 4.0])

_encloses("add", (3, 3), lambda E, a, b: a + b, lambda a, b: a + b)
_encloses("sub", (3, 3), lambda E, a, b: a - b, lambda a, b: a - b)
_encloses("number times vector", (1, 3), lambda E, a, b: a * b, lambda a, b: a * b)
_encloses("factor", (3,), lambda E, a: (-10 / 3) * a, lambda a: (-10 / 3) * a)
_encloses("dot", (3, 3), lambda E, a, b: a.dot(b), lambda a, b: a.dot(b))
_encloses("cross", (3, 3), lambda E, a, b: a.cross(b), lambda a, b: a.cross(b))
_encloses("norm", (3,), lambda E, a: a.norm(), lambda a: a.norm(), positive=True)
_encloses("unit", (3,), lambda E, a: a.unit(), lambda a: a.unit(), positive=True)
_encloses("sqrt", (1,), lambda E, a: a.sqrt(), lambda a: a.sqrt(), positive=True)
_encloses("inverse", (1,), lambda E, a: a.inverse(), lambda a: a.inverse(), positive=True)
_encloses("sin", (1,), lambda E, a: a.sin(), lambda a: a.sin())
_encloses("cos", (1,), lambda E, a: a.cos(), lambda a: a.cos())
_encloses("under", (4,), lambda E, a: a.under(MATRIX), lambda a: a.under(MATRIX))
_encloses("under rank one", (4,), lambda E, a: a.under(ONE), lambda a: a.under(ONE))
_encloses("quadric", (4,), lambda E, a: a.quadric(SYMMETRIC), lambda a: a.quadric(SYMMETRIC))
_encloses("quadric rank one", (4,), lambda E, a: a.quadric(SQUARE), lambda a: a.quadric(SQUARE))
_encloses(
    "24 terms", (24,), lambda E, a: a.dot(E.Enclosure(THIRDS)), lambda a: a.dot(Exact(THIRDS))
)
_encloses(
    "rounded",
    (3,),
    lambda E, a: E.Enclosure(
        a.mid,
        (E.Enclosure.rounded(a.mid).rad + a.rad + 1.01 * 2.0**-49 * a.reach) * (1 + 2.0**-50),
        a.lin,
        cube=a.cube,
    ),
    lambda a: [x * (1 + mp.mpf(2) ** -49) for x in a.x],
)
_encloses("widened", (3,), lambda E, a: a.widened(0.5), lambda a: [a.x[0] + mp.mpf(0.5), *a.x[1:]])
_encloses("joined", (2, 1), lambda E, a, b: E.joined(a, b), lambda a, b: [*a.x, *b.x])
_encloses("across", (3, 3), lambda E, a, e: a.across(e), lambda a, e: a.across(e), of_unit=True)
_encloses(
    "most",
    (3,),
    lambda E, a: E.Enclosure(0 * a.mid[:1], a.most, 0 * a.lin[:1], cube=a.cube),
    lambda a: a.norm(),
)
_encloses(
    "least",
    (3,),
    lambda E, a: E.Enclosure(np.array([8.0]), 8 - a.least + 2.0**-49, 0 * a.lin[:1], cube=a.cube),
    lambda a: [min(a.most, mp.mpf(8))],
    positive=True,
)
_encloses(
    "ends",
    (1,),
    lambda E, a: E.Enclosure(
        np.array([sum(a.ends) / 2] * 2),
        np.sqrt(2) * np.subtract(*a.ends[::-1]) / 2 * (1 + 2.0**-48),
        np.zeros((2, a.lin.shape[-1])),
    ),
    lambda a: [a.x[0], a.x[0]],
)


def _sparse(
    rng: np.random.Generator, E: Any, d: int, m: int, *, cube: bool, positive: bool, unit: bool
) -> Any:
    """Return an enclosure of vectors with d components, with parts that are zero at random."""
    kinds = rng.integers(0, 2, 3)
    scale = 10.0 ** rng.integers(-3, 4)
    mid = rng.normal(size=d) * (kinds[0] or positive or unit)
    if unit:
        mid /= np.linalg.norm(mid)
        radius = kinds[2] * rng.uniform(0, 0.9) + 2.0**-51
        return E.Enclosure(mid, radius, np.zeros((d, m)), cube=cube)
    if positive:
        mid = np.abs(mid) if d == 1 else mid
        scale = 1.0
    far = np.linalg.norm(mid) if positive else 1.0
    share = rng.dirichlet([1, 1]) * rng.uniform(0.2, 0.95)
    lin = rng.normal(size=(d, m)) * kinds[1]
    if m and lin.any():
        columns = np.linalg.norm(lin, axis=0)
        lin *= share[0] * far / (columns.sum() if cube else np.linalg.norm(columns))
    return E.Enclosure(mid * scale, kinds[2] * share[1] * far * scale, lin * scale, cube=cube)


def _member(rng: np.random.Generator, x: Any, u: Vector, *, unit: bool) -> Vector:
    """Return an exact vector of an enclosure for parameters u, mostly at its edge."""
    m = [
        a + sum(mp.mpf(float(b)) * c for b, c in zip(row, u, strict=True))
        for a, row in zip(exact(x.mid), x.lin, strict=True)
    ]
    how = rng.integers(0, 3)
    away = exact(rng.normal(size=len(m)))
    if how and length(m) > 0:
        away = [(-1 if how == 1 else 1) * v for v in m]
    far, r = length(away), mp.mpf(float(x.rad))
    found = [a + r * b / far for a, b in zip(m, away, strict=True)]
    if not unit:
        return found
    found = [v / length(found) for v in found] if length(found) > 0 else m
    gap = length([a - b for a, b in zip(found, m, strict=True)])
    if gap > r:
        found = [a + r / gap * (b - a) for a, b in zip(m, found, strict=True)]
        found = [v / length(found) for v in found]
        if length([a - b for a, b in zip(found, m, strict=True)]) > r:
            return [v / length(m) for v in m]
    return found


def violation(E: Any, name: str, cases: int = 60, members: int = 6, seed: int = 1) -> float:
    """Return the largest part of the radius by which a value was outside, of an operation.

    `E` is the module of enclosures.
    """
    sizes, formula, value, positive, of_unit = OPERATIONS[name]
    rng = np.random.default_rng(seed)
    worst = -1.0
    for _ in range(cases):
        m = int(rng.integers(0, 3)) * (not of_unit)
        cube = bool(rng.integers(0, 2)) or not m
        units = [of_unit and k == 1 for k in range(len(sizes))]
        given = [
            _sparse(rng, E, d, m, cube=cube, positive=positive, unit=unit)
            for d, unit in zip(sizes, units, strict=True)
        ]
        with np.errstate(all="ignore"):
            out = formula(E, *given)
        if not np.isfinite(out.rad).all() or not np.isfinite(out.mid).all():
            continue
        for _ in range(members):
            u = rng.choice([-1.0, 1.0], size=m) if rng.integers(0, 4) else rng.uniform(-1, 1, m)
            if m and not cube:
                u = u / np.linalg.norm(u) * (1 - 2.0**-50)
            chosen = [
                _member(rng, x, exact(u) if m else [], unit=unit)
                for x, unit in zip(given, units, strict=True)
            ]
            try:
                there = value(*chosen)
            except ZeroDivisionError:
                continue
            if any(isinstance(v, mp.mpc) for v in there):
                return float("inf")  # a finite radius where the function is not real
            worst = max(worst, outside(out, Exact(there), u.tolist()))
    return worst


def singular_values_hold(E: Any, seed: int = 2, cases: int = 12) -> bool:
    """Return whether bounds of singular values hold for members (of 4 x 4 matrices by rows)."""
    rng = np.random.default_rng(seed)
    for k in range(cases):
        mid = np.linalg.qr(rng.normal(size=(4, 4)))[0] * [1, 1, 1, 10.0 ** -rng.integers(0, 3)]
        radius = (0.0, 0.02, 1e-9)[k % 3]
        low, high = E.singular_values(E.Enclosure(mid, np.full(4, radius)))
        u, _, v = np.linalg.svd(mid)
        for sign in (-1, 1):
            which = 0 if sign > 0 else -1
            step = sign * np.outer(u[:, which], v[which])
            step *= radius * (1 - 1e-12) / max(np.linalg.norm(step, axis=1).max(), 1e-300)
            there = mp.matrix(mid.tolist()) + mp.matrix(step.tolist())
            values = mp.svd_r(there, compute_uv=False)
            if not (mp.mpf(float(low)) <= values[3] and values[0] <= mp.mpf(float(high))):
                return False
    return True
