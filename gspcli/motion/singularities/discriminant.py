"""The discriminant over two values, followed as curves.

With z a Study point, u a direction and v two of the values, a singular pose is a zero of

    F(z, v) = 0,  p.z = 1,  F'(z, v) u = 0,  p.u = 0,  c.u = 1,

seventeen equations for eighteen unknowns (G. Moore and A. Spence, SIAM J. Numer. Anal. 17, 1980).
The solutions are smooth curves also where their projection on the plane of values has a cusp: there
only z and u change. The curves are followed by Newton's method in small steps, without proof.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gspcli.certification.branches.fold_system import rounded_along
from gspcli.geometry.enclosures import Enclosure, Matrix
from gspcli.motion.following.branch_follower import MovingPlatform
from gspcli.motion.following.moving_geometry import MovingGeometry
from gspcli.motion.singularities.neighbourhoods import STUDY, equations
from gspcli.motion.singularities.scan_rows import ScanRows
from gspcli.records import dataclass
from gspcli.ties import definite_sign

Array = NDArray[np.float64]

#: Steps along a curve, in units in which points and directions have norm one and the ranges of
#: both values are one: the first, the longest and the shortest.
_FIRST, _LONGEST, _SHORTEST = 5e-3, 2.5e-2, 1e-7
_MOST_POINTS = 20_000
#: Newton's method: the most steps, and the size of a step after which it has converged.
_STEPS, _CONVERGED = 5, 1e-9
#: Points nearer than this to the border of the ranges are on it.
_BORDER = 1e-9
#: The cosine of the largest turn of a curve in one step.
_STRAIGHT = 0.98
#: At a cusp the part of the unit tangent in the values is below this.
_STILL = 1e-4


@dataclass(frozen=True, eq=False)
class Curve:
    """A part of the discriminant.

    Attributes
    ----------
    values
        The two values, in the units of the instance, shape (n, 2).
    unknowns
        z, u and the values as parts of their ranges, shape (n, 18).
    cusps
        The cusps of the curve, shape (m, 2).
    closed
        Whether the last point is the first.
    """

    values: Array
    unknowns: Array
    cusps: Array
    closed: bool

    def contains(self, x: Array) -> bool:
        """Whether a singular pose, shape (18,), is nearer to a point than its neighbours are."""
        square = np.sum((self.unknowns[:, 16:] - x[16:]) ** 2, axis=1)
        for part in (slice(0, 8), slice(8, 16)):
            # z and u are known up to sign, and of norm one.
            square += 2 - 2 * np.abs(self.unknowns[:, part] @ x[part])
        return bool(square.min() < _LONGEST**2)


class _Numbers:
    """Numbers with their derivatives, with the operations of `Jet`."""

    def __init__(self, value: Array, gradient: Array, bend: Array) -> None:
        self.value, self.gradient, self.bend = value, gradient, bend

    @classmethod
    def quadric(cls, matrix: Matrix, x: Array) -> _Numbers:
        gradient = matrix.mid @ x
        return cls(gradient @ x / 2, gradient, matrix.mid)

    def __sub__(self, other: _Numbers) -> _Numbers:
        gradient = self.gradient - other.gradient
        return _Numbers(self.value - other.value, gradient, self.bend - other.bend)

    def __mul__(self, other: _Numbers) -> _Numbers:
        f, g = np.asarray(self.value)[..., None], np.asarray(other.value)[..., None]
        outer = self.gradient[..., :, None] * other.gradient[..., None, :]
        bend = f[..., None] * other.bend + g[..., None] * self.bend
        gradient = f * other.gradient + g * self.gradient
        bend = bend + outer + np.swapaxes(outer, -1, -2)
        return _Numbers(self.value * other.value, gradient, bend)

    def times(self, number: Enclosure) -> _Numbers:
        c = number.mid[0]
        return _Numbers(c[:, 0] * self.value, c * self.gradient, c[..., None] * self.bend)


class Discriminant:
    """The equations of singular poses over two values.

    Parameters
    ----------
    platform
        The equations.
    values
        The six values, in the units of the instance; two of them are replaced.
    varied
        Which two constraints vary, from 0.
    low, high
        The ends of their ranges, shape (2,).
    """

    def __init__(
        self,
        platform: MovingPlatform,
        values: Array,
        varied: tuple[int, int],
        low: Array,
        high: Array,
    ) -> None:
        self.platform = platform
        self.varied = list(varied)
        self._base = np.asarray(values, float)
        self._low, self._span = np.asarray(low, float), np.asarray(high - low, float)
        units = platform.internal(np.ones(6))[self.varied]
        #: The widths of the ranges of the two values, in internal units.
        self._widths = units * self._span

    def plane(self, x: Array) -> Array:
        """Return the two values of some unknowns, (..., 18), in the units of the instance."""
        values: Array = self._low + x[..., 16:] * self._span
        return values

    def start(self, point: Array, values: Array) -> Array | None:
        """Return the unknowns of the singular pose near a Study point, or None.

        Parameters
        ----------
        point
            Shape (8,).
        values
            About the two values, shape (2,).
        """
        w = (values - self._low) / self._span
        rows = self._rows(point, w)
        direction = definite_sign(np.linalg.svd(np.vstack((rows, point)))[2][-1])
        x = np.concatenate((point / np.linalg.norm(point), direction, w))
        return self._corrected(x, x, None)

    def _rows(self, point: Array, w: Array) -> Array:
        """Return F' at a Study point, shape (7, 8)."""
        return self.platform.jacobian(point, self._internal(w))

    def _internal(self, w: Array) -> Array:
        values = self._base.copy()
        values[self.varied] = self._low + w * self._span
        return self.platform.internal(values)

    def _equations(self, x: Array, patch: Array, gauge: Array) -> tuple[Array, Array]:
        """Return the seventeen equations and their derivatives, shape (17, 18)."""
        z, u = x[:8], x[8:16]
        residuals, rows, bent, moving = self._terms(x)
        values = np.concatenate((residuals, [patch @ z - 1], rows @ u, [patch @ u, gauge @ u - 1]))
        matrix = np.zeros((17, 18))
        matrix[:7, :8], matrix[:7, 16:] = rows, moving[0]
        matrix[7, :8] = patch
        matrix[8:15, :8], matrix[8:15, 8:16], matrix[8:15, 16:] = bent, rows, moving[1]
        matrix[15, 8:16], matrix[16, 8:16] = patch, gauge
        return values, matrix

    def _terms(self, x: Array) -> tuple[Array, Array, Array, tuple[Array, Array]]:
        """Return F (7,), F' (7, 8), F''u (7, 8), and the derivatives of F and F'u by w (7, 2)."""
        z, u, values = x[:8], x[8:16], self._internal(x[16:])
        F, rows, bent = np.zeros(7), np.zeros((7, 8)), np.zeros((7, 8))
        first, second = np.zeros((7, 2)), np.zeros((7, 2))
        slopes = self.platform.slopes(values)
        study = _Numbers.quadric(STUDY, z)
        F[0], rows[0], bent[0] = study.value, study.gradient, study.bend @ u
        c = Enclosure(self.platform.coefficients(values)[None, :, None])
        for at, found, factor in equations(self.platform, z, c, _Numbers):
            F[at + 1], rows[at + 1], bent[at + 1] = found.value, found.gradient, found.bend @ u
            for k, row in enumerate(self.varied):
                change = -slopes[row] * self._widths[k]
                first[at + 1, k] = np.where(at == row, change * factor.value, 0.0)
                second[at + 1, k] = np.where(at == row, change * (factor.gradient @ u), 0.0)
        return F, rows, bent, (first, second)

    def _corrected(self, x: Array, at: Array, row: Array | None, goal: float = 0.0) -> Array | None:
        """Return the solution near some unknowns by Newton's method, or None.

        Parameters
        ----------
        x
            The unknowns.
        at
            The unknowns that give the patch and the gauge.
        row
            One more linear equation ``row . x = goal``, shape (18,); the shortest steps if None.
        goal
            Its right side.
        """
        patch, gauge = _units(at)
        for _ in range(_STEPS):
            values, matrix = self._equations(x, patch, gauge)
            try:
                if row is None:
                    step = np.linalg.lstsq(matrix, values, rcond=None)[0]
                else:
                    bordered = np.vstack((matrix, row))
                    step = np.linalg.solve(bordered, np.append(values, row @ x - goal))
            except np.linalg.LinAlgError:
                return None
            size = float(np.linalg.norm(step))
            if not size < 0.5:
                return None
            x = x - step
            if size < _CONVERGED:
                return x
        return None

    def _tangent(self, x: Array, like: Array | None) -> Array:
        """Return the unit tangent of the curve, in the direction of another one if there is one."""
        _, matrix = self._equations(x, *_units(x))
        tangent: Array = np.linalg.svd(matrix)[2][-1]
        if like is None:
            return definite_sign(tangent)
        return tangent if tangent @ like > 0 else -tangent

    def follow(self, start: Array) -> Curve:
        """Return the curve through a singular pose, up to the ends of the ranges."""
        start = _scaled(start)
        tangent = self._tangent(start, None)
        ahead, cusps, closed = self._one_way(start, tangent)
        if not closed:
            behind, more, _ = self._one_way(start, -tangent)
            ahead, cusps = [*behind[:0:-1], *ahead], [*more, *cusps]
        x = np.stack(ahead)
        return Curve(
            self.plane(x),
            x,
            self.plane(np.stack(cusps)) if cusps else np.zeros((0, 2)),
            closed,
        )

    def _one_way(self, start: Array, tangent: Array) -> tuple[list[Array], list[Array], bool]:
        """Follow the curve in one direction: its points, its cusps, and whether it closes."""
        points: list[Array] = [start]
        cusps: list[Array] = []
        x, size = start, _FIRST
        while len(points) < _MOST_POINTS and size > _SHORTEST:
            step = self._step(x, tangent, size)
            if step is None:
                size /= 2
                continue
            new, turned = step
            if turned[16:] @ tangent[16:] < 0:
                cusp = self._cusp(x, tangent, size)
                cusps += [] if cusp is None else [cusp]
            if ((new[16:] < 0) | (new[16:] > 1)).any():
                end = self._cut(x, new)
                # A curve that begins on the border ends there, up to rounding errors.
                if end is not None and np.abs(end - x).max() > _BORDER:
                    points.append(end)
                return points, cusps, False
            points.append(new)
            if len(points) > 4 and _passes(x, new, start):
                return [*points, start], cusps, True
            x, tangent = new, turned
            size = min(size * 1.4, _LONGEST)
        return points, cusps, False

    def _step(self, x: Array, tangent: Array, size: float) -> tuple[Array, Array] | None:
        """Return the point of the curve a step ahead, scaled, and its tangent; or None."""
        ahead = x + size * tangent
        found = self._corrected(ahead, x, tangent, float(tangent @ ahead))
        if found is None or np.linalg.norm(found - ahead) > size / 4:
            return None
        new = _scaled(found)
        turned = self._tangent(new, tangent)
        return (new, turned) if turned @ tangent > _STRAIGHT else None

    def _cusp(self, x: Array, tangent: Array, size: float) -> Array | None:
        """Return the point within a step at which the values stand still, if there is one."""
        low, high, found = 0.0, size, None
        for _ in range(40):
            middle = (low + high) / 2
            step = self._step(x, tangent, middle)
            if step is None:
                return None
            found, turned = step
            low, high = (middle, high) if turned[16:] @ tangent[16:] > 0 else (low, middle)
        still = np.linalg.norm(self._tangent(found, None)[16:]) < _STILL if found is not None else 0
        return found if still else None

    def _cut(self, x: Array, new: Array) -> Array | None:
        """Return the point between two at which the curve leaves the ranges."""
        for k in (16, 17):
            for bound in (0.0, 1.0):
                if (x[k] - bound) * (new[k] - bound) < 0:
                    end = self.at_line(x, new, k - 16, bound)
                    if end is not None and ((end[16:] > -_BORDER) & (end[16:] < 1 + _BORDER)).all():
                        return end
        return None

    def at_line(self, x: Array, y: Array, axis: int, bound: float) -> Array | None:
        """Return the point of the curve between two others where one value is given.

        Parameters
        ----------
        x, y
            Unknowns of neighbouring points.
        axis
            Which of the two values.
        bound
            The value, as a part of its range.
        """
        part = (bound - x[16 + axis]) / (y[16 + axis] - x[16 + axis])
        row = np.zeros(18)
        row[16 + axis] = 1.0
        near = self._corrected((1 - part) * x + part * y, x, row, bound)
        return None if near is None or np.linalg.norm(near - x) > 4 * _LONGEST else near


def _units(x: Array) -> tuple[Array, Array]:
    """Return the patch and the gauge at some unknowns: z and u, scaled."""
    z, u = x[:8], x[8:16]
    return z / (z @ z), u / (u @ u)


def _scaled(x: Array) -> Array:
    z, u = x[:8] / np.linalg.norm(x[:8]), x[8:16]
    u = u - (u @ z) * z
    return np.concatenate((z, u / np.linalg.norm(u), x[16:]))


def _passes(x: Array, y: Array, point: Array) -> bool:
    """Whether the part from x to y passes a point, whose z and u are known up to sign."""
    for signs in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        other = point * np.concatenate((np.full(8, signs[0]), np.full(8, signs[1]), (1, 1)))
        d = y - x
        part = np.clip((other - x) @ d / (d @ d), 0, 1)
        if np.linalg.norm(x + part * d - other) < 0.1 * np.linalg.norm(d):
            return True
    return False


class DrivenDiscriminant(Discriminant):
    """The equations of singular poses over two numbers, of which a crank or slide has at least one.

    The equations are those of `Discriminant`; all their coefficients move. They and their
    derivatives come from the equations of folds (`gspcli.certification.branches.fold_system`), once
    along each of the two axes.

    Parameters
    ----------
    rows
        The rows of the scan.
    platform
        The equations.
    """

    def __init__(self, rows: ScanRows, platform: MovingGeometry) -> None:
        self._of = rows
        self._system = platform.system
        self._low, self._span = rows.low, rows.high - rows.low

    def _rows(self, point: Array, w: Array) -> Array:
        return self._along(np.concatenate((point, point, w)), 0)[0][1][:7, :8]

    def _terms(self, x: Array) -> tuple[Array, Array, Array, tuple[Array, Array]]:
        (values, rows), (_, bent) = self._along(x, 0)
        (_, other_rows), (_, other_bent) = self._along(x, 1)
        first = np.column_stack((rows[:7, 8], other_rows[:7, 8]))
        second = np.column_stack((bent[:7, 8], other_bent[:7, 8]))
        return values[:7], rows[:7, :8], bent[:7, :8], (first, second)

    def _along(self, x: Array, axis: int) -> list[tuple[Array, Array]]:
        """Return F and F'u, each with its derivatives by z and by one w: shapes (8,), (8, 9)."""
        read = self.plane(x)
        row = self._of.row(read)
        ahead = row.copy()
        ahead[self._of.varied[axis]] += self._span[axis] * self._of.scales[axis]
        return rounded_along(self._system, (row, ahead), x[:8], x[8:16])
