"""Proof of a fold: where two branches of solutions meet while the values move, and both end.

With z a Study point, u a direction and t the time, a fold is a zero of the seventeen equations

    F(z, t) = 0,  p.z = 1,  F'(z, t) u = 0,  p.u = 0,  c.u = 1

(G. Moore and A. Spence, SIAM J. Numer. Anal. 17, 1980), and a simple zero of these is a quadratic
turning point: t has an extremum along the curve of solutions, which passes through it in the
direction u. Krawczyk's test in balls proves exactly one zero in a box.

That a mode reaches the fold is proved in a larger box (`Fold.sides`), in two steps. For each s in
an interval the nine equations ``F = 0, p.z = 1, c.z = s`` have exactly one solution (z, t) near the
tangent (Krawczyk's test again, for all s at once), so that the solutions are one smooth curve
through the fold. And the seventeen equations have at most one zero for all (z, t) near the curve
with all u that its tangents can have, because the matrix of their derivatives is regular there: so
t has no other extremum, and increases or decreases from the fold to each end of the curve.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import flint
import numpy as np
from flint import arb, arb_mat
from numpy.typing import NDArray

from gspcli.certification.balls import float_above, float_ends, floats_above
from gspcli.certification.fold_system import UNKNOWNS, FoldSystem, unit
from gspcli.certification.rounding import OUTWARD
from gspcli.certification.taylor import MovingSystem

Array = NDArray[np.float64]

_PRECISION = 160
_STEPS = 12
#: Newton's method has converged when a step is below this.
_CONVERGED = 2.0**-100
#: How near to the zero Krawczyk's box is.
_RADIUS = 2.0**-80
#: How often the box about a curve is widened.
_WIDENINGS = 8
#: Of the power method, for weights.
_ITERATIONS = 12


@dataclass(frozen=True, eq=False)
class Fold:
    """A proved fold.

    Attributes
    ----------
    low, high
        Floats between which the part of the step at which it is lies.
    point, direction
        The Study point there, and the direction u of the two branches, shape (8,); rounded.
    bends
        The sign of the second derivative of t along the branches: -1 if both end at the fold, 1
        if both begin there.
    equations, zero
        Of which it is a zero, and the zero, within 2^-80.
    """

    low: float
    high: float
    point: Array
    direction: Array
    bends: int
    equations: FoldSystem
    zero: tuple[arb, ...]

    def sides(self, points: Array, part: float, radius: float) -> list[int]:
        """Prove that poses are on the curve through the fold, with no other fold between.

        Parameters
        ----------
        points
            Study points, shape (n, 8).
        part
            The part of the step at which they are.
        radius
            How near to each of them, in norm one, the pose is that is meant.

        Returns
        -------
        list
            For each pose -1 or 1, on which of the two branches it is: the mode that it belongs to
            reaches the fold, without a singularity before; or 0, if that is not proved.
        """
        with flint.ctx.workprec(_PRECISION):
            return [_side(self, point, arb(part), arb(radius)) for point in points]


def prove_fold(
    system: MovingSystem, rows: tuple[Array, Array], part: float, point: Array, direction: Array
) -> Fold | None:
    """Prove a fold near a point of a branch; None if there is no proof.

    Parameters
    ----------
    system
        What moves.
    rows
        The values, and the coordinates that move, at both ends of a step between rows, in the units
        of the instance; they are taken as exact.
    part
        About where between them, from 0 to 1.
    point, direction
        A Study point near the fold, in units of `length_scale`, and about the direction in which
        the branch moves there, shape (8,).
    """
    with flint.ctx.workprec(_PRECISION):
        equations = FoldSystem(system, rows, point)
        x = [*map(arb, point.tolist()), *map(arb, direction.tolist()), arb(part)]
        scale = sum((a * b for a, b in zip(equations.patch, x[:8], strict=True)), arb(0))
        x[:8] = [(value / scale).mid() for value in x[:8]]
        equations.gauge = unit(direction)
        x[8:16] = list(equations.gauge)
        for _ in range(_STEPS):
            values, jacobian = equations.at(x)
            try:
                step = jacobian.mid().solve(arb_mat(UNKNOWNS, 1, values).mid()).entries()
            except ZeroDivisionError:
                return None
            x = [(a - b).mid() for a, b in zip(x, step, strict=True)]
            size = max(float_above(s) for s in step)
            if not size < 10:
                return None
            if size < _CONVERGED:
                return _krawczyk(equations, x)
    return None


def _krawczyk(system: FoldSystem, x: list[arb]) -> Fold | None:
    values, jacobian = system.at(x)
    try:
        inverse = jacobian.mid().inv().mid()
    except ZeroDivisionError:
        return None
    step = (inverse * arb_mat(UNKNOWNS, 1, values)).entries()
    radius = arb(_RADIUS)
    box = [arb(value, radius) for value in x]
    _, spread = system.at(box)
    defect = inverse * spread - 1
    for row, delta in zip(defect.tolist(), step, strict=True):
        moved = sum((entry.abs_upper() for entry in row), arb(0)) * radius + delta.abs_upper()
        if not moved < radius:
            return None
    low, high = float_ends(box[16])
    bends = system.bends(box)
    if bends == 0:
        return None
    middle = np.array([float(value) for value in x])
    return Fold(low, high, middle[:8], middle[8:16], bends, system, tuple(box))


def _side(fold: Fold, point: Array, part: arb, radius: arb) -> int:
    """Return on which branch of a fold a pose is, or 0; see `Fold.sides`."""
    equations, zero = fold.equations, [value.mid() for value in fold.zero]
    y = [arb(value) for value in point.tolist()]
    scale = _dot(equations.patch, y)
    if not scale.abs_lower() > 0.5:
        return 0
    offset = [a / scale - b for a, b in zip(y, zero, strict=False)]
    s = _dot(equations.gauge, offset)
    # On the patch the radius is at most four times as large, and s is off by as much.
    near = 4 * radius + _RADIUS
    apart = [a - s * u for a, u in zip(offset, zero[8:16], strict=True)]
    wanted = [a.abs_upper() + 8 * near for a in (*apart, part - zero[16])]
    reach = s.abs_upper() + near
    curve = _Curve(fold, zero, reach)
    if not (s.abs_lower() > near and curve.holds(wanted) and curve.has_one_fold()):
        return 0
    return 1 if s > 0 else -1


class _Curve:
    """The solutions through a fold, ``|s| <= reach`` in its direction."""

    def __init__(self, fold: Fold, zero: list[arb], reach: arb) -> None:
        self.equations, self.zero, self.reach = fold.equations, zero, reach
        values, matrix = self.equations.at(zero)
        self.values, self.along, self.whole = values[:7], values[8:15], matrix
        self.inverse = self._square(matrix).mid().inv().mid()

    def _square(self, matrix: arb_mat) -> arb_mat:
        """Return the derivatives of the nine equations by (z, t)."""
        rows = [[*row[:8], row[16]] for row in matrix.tolist()[:8]]
        return arb_mat([*rows, [*self.equations.gauge, arb(0)]])

    def holds(self, wanted: list[arb]) -> bool:
        """Whether the curve is proved in a box that is at least so wide about its tangent."""
        widths = [width * 1.0625 for width in wanted]
        for _ in range(_WIDENINGS):
            self.box = self._around(widths)
            _, matrix = self.equations.at(self.box)
            bent = arb_mat([row[:8] for row in matrix.tolist()[8:15]])
            second = (bent * arb_mat(8, 1, self.zero[8:16])).entries()
            # F at z + s u, by Taylor's formula.
            residuals = [
                f + arb(0, self.reach) * fu + arb(0, self.reach**2 / 2) * fuu.abs_upper()
                for f, fu, fuu in zip(self.values, self.along, second, strict=True)
            ]
            # That p.z = 1, p.u = 0, c.u = 1 hold for the zero itself only.
            residuals += [arb(0, 4 * _RADIUS)] * 2
            moved = (self.inverse * arb_mat(9, 1, residuals)).entries()
            self.matrix = self._square(matrix)
            defect = self.inverse * self.matrix - 1
            needed = [
                shift.abs_upper()
                + sum((a.abs_upper() * w for a, w in zip(row, widths, strict=True)), arb(0))
                for shift, row in zip(moved, defect.tolist(), strict=True)
            ]
            if all(a < b for a, b in zip(needed, widths, strict=True)):
                return True
            widths = [_larger(2 * a, b).mid() for a, b in zip(needed, widths, strict=True)]
            if not all(width < 1 for width in widths[:8]):
                return False
        return False

    def _around(self, widths: list[arb]) -> list[arb]:
        z, u, t = self.zero[:8], self.zero[8:16], self.zero[16]
        places = [a + arb(0, self.reach) * b for a, b in zip(z, u, strict=True)]
        return [
            *(a + arb(0, width) for a, width in zip(places, widths, strict=False)),
            *u,
            t + arb(0, widths[8]),
        ]

    def has_one_fold(self) -> bool:
        """Whether no more than one fold is proved to be on the curve."""
        norm, sizes = _contraction(self.inverse * self.matrix - 1)
        if not norm < 1:
            return False
        # Tangents (z', t') differ from (u, 0) by at most this, in units of the sizes.
        values, _ = self.equations.at(self.box)
        right = arb_mat(9, 1, [*values[8:15], arb(0), arb(0)])
        moved = floats_above((self.inverse * right).entries())
        widths = (moved / sizes).max() / (1 - norm) * sizes * OUTWARD + _RADIUS
        u = [
            arb(value, width)
            for value, width in zip(self.zero[8:16], widths.tolist(), strict=False)
        ]
        _, matrix = self.equations.at([*self.box[:8], *u, self.box[16]])
        return _contraction(self.whole.mid().inv().mid() * matrix - 1)[0] < 1


def _dot(a: Sequence[arb], b: Sequence[arb]) -> arb:
    return sum((x * y for x, y in zip(a, b, strict=False)), arb(0))


def _larger(a: arb, b: arb) -> arb:
    return a if a > b else b


def _contraction(matrix: arb_mat) -> tuple[float, Array]:
    """Return a bound of a norm of a matrix: that of the largest component in units of weights.

    Any weights will do; the best are those of Perron's vector of the moduli.
    """
    moduli = floats_above(matrix.entries()).reshape(matrix.nrows(), matrix.ncols())
    weights = np.ones(len(moduli))
    with np.errstate(all="ignore"):
        for _ in range(_ITERATIONS):
            weights = moduli @ weights + 1e-3 * weights
            weights /= weights.max()
        return float((moduli @ weights / weights).max()) * OUTWARD, weights
