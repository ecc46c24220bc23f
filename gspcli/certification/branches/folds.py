"""Proof of a fold: two branches of solutions meet while the values move, and both end.

With z a Study point, u a direction and t the time, a fold is a zero of the seventeen equations

    F(z, t) = 0,  p.z = 1,  F'(z, t) u = 0,  p.u = 0,  c.u = 1

(G. Moore and A. Spence, SIAM J. Numer. Anal. 17, 1980), and a simple zero of these is a quadratic
turning point: t has an extremum along the curve of solutions, which passes through it in the
direction u. Krawczyk's test in balls proves exactly one zero in a box.

The proof that a mode reaches the fold uses the curve of solutions (`Fold.sides`, `arcs`). An arc
through the fold is proved in a larger box, together with a constant sign of the second derivative
of t. So t has no other extremum on the arc: it increases up to the fold or decreases after it. The
pose is in this box, or the curve is followed from the pose in further arcs, on which t increases,
up to it.
"""

from __future__ import annotations

from collections.abc import Sequence

import flint
import numpy as np
from flint import arb, arb_mat
from numpy.typing import NDArray

from gspcli.certification.branches.arcs import (
    CONVERGED,
    NARROW,
    PRECISION,
    SHORTEST,
    STEPS,
    Arc,
    near_point,
    towards,
)
from gspcli.certification.branches.fold_system import UNKNOWNS, FoldSystem, unit
from gspcli.certification.branches.taylor import MovingSystem
from gspcli.certification.numbers.balls import float_above, float_ends
from gspcli.records import dataclass

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Fold:
    """A proved fold.

    Attributes
    ----------
    low, high
        Floats; the part of the step before the fold lies between them.
    point, direction
        The Study point there, and the direction u of the two branches, shape (8,); rounded.
    bends
        The sign of the second derivative of t along the branches: -1 if both end at the fold, 1
        if both begin there.
    equations, zero
        The equations, and their zero within `arcs.NARROW`.
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
            The part of the step before the poses.
        radius
            Within this distance from each point, of norm one, there is exactly one pose: the one in
            question.

        Returns
        -------
        list
            For each pose -1 or 1 for its branch, if it is proved that the mode of the pose reaches
            the fold without a singularity before; else 0.
        """
        with flint.ctx.workprec(PRECISION):
            return [_side(self, point, part, radius) for point in points]


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
        The approximate place between them, from 0 to 1.
    point, direction
        A Study point near the fold, in units of `length_scale`, and the approximate direction of
        the branch there, shape (8,).
    """
    with flint.ctx.workprec(PRECISION):
        equations = FoldSystem(system, rows, point)
        x = [*map(arb, point.tolist()), *map(arb, direction.tolist()), arb(part)]
        scale = sum((a * b for a, b in zip(equations.patch, x[:8], strict=True)), arb(0))
        x[:8] = [(value / scale).mid() for value in x[:8]]
        equations.gauge = unit(direction)
        x[8:16] = list(equations.gauge)
        for _ in range(STEPS):
            values, jacobian = equations.at(x)
            try:
                step = jacobian.mid().solve(arb_mat(UNKNOWNS, 1, values).mid()).entries()
            except ZeroDivisionError:
                return None
            x = [(a - b).mid() for a, b in zip(x, step, strict=True)]
            size = max(float_above(s) for s in step)
            if not size < 10:
                return None
            if size < CONVERGED:
                return _krawczyk(equations, x)
    return None


def _krawczyk(system: FoldSystem, x: list[arb]) -> Fold | None:
    values, jacobian = system.at(x)
    try:
        inverse = jacobian.mid().inv().mid()
    except ZeroDivisionError:
        return None
    step = (inverse * arb_mat(UNKNOWNS, 1, values)).entries()
    radius = arb(NARROW)
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


def _side(fold: Fold, point: Array, part: float, radius: float) -> int:
    """Return the branch of a fold with a pose, or 0; see `Fold.sides`."""
    equations = fold.equations
    y = [arb(value) for value in point.tolist()]
    if not (radius < 1 and _dot(equations.patch, y).abs_lower() > 0.5):
        return 0
    pose, _ = near_point(equations, point, part, radius)
    turn = _Turn(fold, pose)
    side = turn.side(pose)
    if side == 0 and turn.proved_nearer():
        found = (turn.side(place) for place in towards(equations, pose, arb(fold.high)))
        side = next(filter(None, found), 0)
    return side


class _Turn:
    """A part of the curve through a fold, with no other fold on it.

    Parameters
    ----------
    fold
        The fold at its centre.
    pose
        Nine balls that it should reach, if this can be proved.
    """

    def __init__(self, fold: Fold, pose: list[arb]) -> None:
        zero, nothing = [value.mid() for value in fold.zero], arb(0)
        direction, gauge = [*zero[8:16], nothing], [*fold.equations.gauge, nothing]
        self.arc = Arc(fold.equations, [*zero[:8], zero[16]], direction, gauge)
        self.fold = [*fold.zero[:8], fold.zero[16]]
        s, apart = self.arc.place(pose)
        self.reach = (s.abs_upper() * 1.0625).mid()
        self.proved = self._proved([a.abs_upper() for a in apart])

    def _proved(self, wanted: list[arb]) -> bool:
        """Whether a box contains the fold on a curve along which t has no other extremum.

        The box is at least as wide as the ball of the fold: where a coordinate does not change
        along the curve, Krawczyk's test alone leaves a box that is narrower than this ball. Each
        width for which the test holds is a proof.
        """
        arc = self.arc
        ball = [a.abs_upper() for a in arc.place(self.fold)[1]]
        wide = [a if a > b else b for a, b in zip(wanted, ball, strict=True)]
        return arc.holds(self.reach, wide) and arc.contains(self.fold) and arc.bends() != 0

    def proved_nearer(self) -> bool:
        """Whether an arc is proved, a shorter one if necessary."""
        while not self.proved and self.reach > SHORTEST:
            self.reach = self.reach / 8
            self.proved = self._proved([arb(0)] * 9)
        return self.proved

    def side(self, place: list[arb]) -> int:
        """Return the side of the fold on which all solutions in balls are on the curve, or 0."""
        if not self.proved or not self.arc.contains(place):
            return 0
        s = self.arc.place(place)[0] - self.arc.place(self.fold)[0]
        return 1 if s > 0 else -1 if s < 0 else 0


def _dot(a: Sequence[arb], b: Sequence[arb]) -> arb:
    return sum((x * y for x, y in zip(a, b, strict=True)), arb(0))
