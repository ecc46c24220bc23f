"""The equations of a fold in ball arithmetic, with their derivatives; `folds` has the proofs.

With z a Study point, u a direction and t the time, a fold is a zero of the seventeen equations

    F(z, t) = 0,  p.z = 1,  F'(z, t) u = 0,  p.u = 0,  c.u = 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat, arb_series
from numpy.typing import NDArray

from gspcli.certification import study
from gspcli.certification.moving import Shape
from gspcli.certification.taylor import Element, MovingSystem

Array = NDArray[np.float64]

#: z, u and t.
UNKNOWNS = 17


def unit(direction: Array) -> list[arb]:
    """Return a direction of length one."""
    return [arb(value) for value in (direction / np.linalg.norm(direction)).tolist()]


@dataclass(frozen=True)
class _Moving:
    """An equation at a time: Hessian matrices and c, each with its derivative by time, or None."""

    shape: Shape
    a: tuple[arb_mat, arb_mat | None]
    b: tuple[arb_mat, arb_mat | None] | None
    c: tuple[arb, arb]


class FoldSystem:
    """The seventeen equations with balls for coefficients."""

    def __init__(self, system: MovingSystem, rows: tuple[Array, Array], point: Array) -> None:
        self.system = system
        self.rows = rows
        self.terms = study.form_hessians().reshape(study.COUNT, -1).astype(int).tolist()
        self.patch = unit(point)
        self.gauge: list[arb] = []
        self.norm = self._hessian({study.NORM: arb(1)})
        self.study = self._hessian({study.STUDY: arb(1)})
        #: Those that do not move, by equation and quadric.
        self._still: dict[tuple[int, int], arb_mat] = {}

    def _hessian(self, form: dict[int, arb]) -> arb_mat:
        entries = [arb(0)] * 64
        for index, coefficient in form.items():
            for k, factor in enumerate(self.terms[index]):
                if factor:
                    entries[k] += factor * coefficient
        return arb_mat(8, 8, entries)

    def _moving(self, t: arb) -> list[_Moving]:
        """Return the equations at a time."""
        found = []
        for k, ((shape, _, _, forms), c) in enumerate(
            self.system.equations(self.rows, t, arb(1), 1)
        ):
            quadrics = [self._jet(k, j, form) for j, form in enumerate(forms)]
            b = quadrics[1] if len(quadrics) > 1 else None
            found.append(_Moving(shape, quadrics[0], b, (_part(c, 0), _part(c, 1))))
        return found

    def _jet(self, k: int, j: int, form: dict[int, Element]) -> tuple[arb_mat, arb_mat | None]:
        if not any(isinstance(x, arb_series) for x in form.values()):
            if (k, j) not in self._still:
                self._still[k, j] = self._hessian(form)
            return self._still[k, j], None
        value, slope = ({i: _part(x, d) for i, x in form.items()} for d in (0, 1))
        return self._hessian(value), self._hessian(slope)

    def at(self, x: Sequence[arb]) -> tuple[list[arb], arb_mat]:
        """Return the values (17) and the Jacobian matrix (17, 17) at (z, u, t)."""
        z, u, t = arb_mat(8, 1, list(x[:8])), arb_mat(8, 1, list(x[8:16])), x[16]
        rows = [_equation(None, self, z, u)]
        rows += [_equation(one, self, z, u) for one in self._moving(t)]
        zeros = [arb(0)] * 8
        patch, gauge = self.patch, self.gauge
        values = [value for value, *_ in rows] + [_dot(patch, x[:8]) - 1]
        values += [along for _, _, along, _, _, _ in rows]
        values += [_dot(patch, x[8:16]), _dot(gauge, x[8:16]) - 1]
        matrix = [[*gradient, *zeros, by_t] for _, gradient, _, _, by_t, _ in rows]
        matrix.append([*patch, *zeros, arb(0)])
        matrix += [[*bent, *gradient, along_t] for _, gradient, _, bent, _, along_t in rows]
        matrix += [[*zeros, *patch, arb(0)], [*zeros, *gauge, arb(0)]]
        return values, arb_mat(matrix)

    def bends(self, x: Sequence[arb]) -> int:
        """Return the sign of the second derivative of t along the branches, 0 if not decided.

        With w the derivative of u along the curve, F' w + F''(u, u) + dF/dt t'' = 0 and p.w = 0: a
        linear system for w and t''.
        """
        z, u, t = arb_mat(8, 1, list(x[:8])), arb_mat(8, 1, list(x[8:16])), x[16]
        rows = [_equation(None, self, z, u)]
        rows += [_equation(one, self, z, u) for one in self._moving(t)]
        matrix = [[*gradient, by_t] for _, gradient, _, _, by_t, _ in rows]
        right = [-_dot(bent, x[8:16]) for _, _, _, bent, _, _ in rows]
        matrix += [[*self.patch, arb(0)], [*self.gauge, arb(0)]]
        try:
            solved = arb_mat(matrix).solve(arb_mat(9, 1, [*right, arb(0), arb(0)]))
        except ZeroDivisionError:
            return 0
        second = solved.entries()[8]
        return 1 if second > 0 else -1 if second < 0 else 0


def _part(x: Element, order: int) -> arb:
    """Return a coefficient of a power series, or of a number."""
    if isinstance(x, arb_series):
        return x[order]
    return x if order == 0 else arb(0)


def _equation(
    given: _Moving | None, system: FoldSystem, z: arb_mat, u: arb_mat
) -> tuple[arb, list[arb], arb, list[arb], arb, arb]:
    """Return F, F', F'u, F''u, dF/dt and dF'u/dt of one equation; None is the Study condition."""
    if given is None:
        a = _Quadric(system.study, z, u)
        return a.value, a.gradient, a.along, a.bent, arb(0), arb(0)
    c, change = given.c
    n, a = _Quadric(system.norm, z, u), _Quadric(given.a[0], z, u)
    nothing = a.scaled(arb(0))
    moved_a = nothing if given.a[1] is None else _Quadric(given.a[1], z, u)
    if given.b is None:
        f, by_t = a.plus(n, -c), moved_a.plus(n, -change)
        return (*f.parts, by_t.value, by_t.along)
    b = _Quadric(given.b[0], z, u)
    moved_b = nothing if given.b[1] is None else _Quadric(given.b[1], z, u)
    both = b.times(moved_b)
    if given.shape is Shape.LINES:
        gap = n.squared().plus(b.squared(), arb(-1))
        f = a.squared().plus(gap, -c)
        by_t = a.times(moved_a).scaled(arb(2)).plus(gap, -change).plus(both, 2 * c)
    else:
        f = n.times(a.plus(n, -c)).plus(b.squared(), arb(-1))
        by_t = n.times(moved_a.plus(n, -change)).plus(both, arb(-2))
    return (*f.parts, by_t.value, by_t.along)


@dataclass(frozen=True)
class _Jet:
    """A function at z: value, gradient, their derivatives along u."""

    value: arb
    gradient: list[arb]
    along: arb
    bent: list[arb]

    @property
    def parts(self) -> tuple[arb, list[arb], arb, list[arb]]:
        return self.value, self.gradient, self.along, self.bent

    def scaled(self, factor: arb) -> _Jet:
        """Return a multiple of the function."""
        return _Jet(
            factor * self.value,
            [factor * x for x in self.gradient],
            factor * self.along,
            [factor * x for x in self.bent],
        )

    def plus(self, other: _Jet, factor: arb) -> _Jet:
        """Return the function plus a multiple of another."""
        return _Jet(
            self.value + factor * other.value,
            [a + factor * b for a, b in zip(self.gradient, other.gradient, strict=True)],
            self.along + factor * other.along,
            [a + factor * b for a, b in zip(self.bent, other.bent, strict=True)],
        )

    def times(self, other: _Jet) -> _Jet:
        """Return the product with another function."""
        pairs = list(zip(self.gradient, other.gradient, strict=True))
        return _Jet(
            self.value * other.value,
            [self.value * b + other.value * a for a, b in pairs],
            self.value * other.along + other.value * self.along,
            [
                self.along * b + self.value * bb + other.along * a + other.value * aa
                for (a, b), aa, bb in zip(pairs, self.bent, other.bent, strict=True)
            ],
        )

    def squared(self) -> _Jet:
        """Return the square of the function."""
        return self.times(self)


class _Quadric(_Jet):
    """The jet of a quadric with a given Hessian matrix."""

    def __init__(self, hessian: arb_mat, z: arb_mat, u: arb_mat) -> None:
        gradient, bent = (hessian * z).entries(), (hessian * u).entries()
        super().__init__(
            _dot(gradient, z.entries()) / 2, gradient, _dot(gradient, u.entries()), bent
        )


def _dot(a: Sequence[arb], b: Sequence[arb]) -> arb:
    return sum((p * q for p, q in zip(a, b, strict=True)), arb(0))
