"""Solution sets that are not finite: their local dimension, and poses along a motion.

What is found here is numerical evidence, not a proof: the Jacobian matrix has a kernel at a pose,
and steps along it can be corrected to poses some way off that satisfy every constraint.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from gspcli.catalogue.kinds import AHH, AHL, ALH, ALL, DHP, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import AngleUnit, Constraint
from gspcli.geometry.measurement import COSINE, by_twist, polynomial, velocities
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, Line, Plane, Point, Vector
from gspcli.geometry.quaternions import (
    Field,
    cross,
    dot,
    quaternion_from_rotation,
    rotation_from_quaternion,
)
from gspcli.geometry.tolerances import MEASURED_PARALLEL_SINE
from gspcli.records import dataclass
from gspcli.ties import definite_basis

#: Steps of a sample motion, in radians or typical lengths, and how many of them.
_STEP = 0.05
_STEPS = 24
#: A double pose, such as a leg stretched as far as it goes, is approached by halves: to 1e-6, where
#: residuals are 1e-12.
_CORRECTIONS = 48
#: Relative singular values of the Jacobian matrix below this belong to its kernel.
_KERNEL = 1e-6
#: Cosines this near to one, and distances this near to zero, are at the end of their range.
_END = 1e-12
#: Largest remaining error of a corrected pose, in radians or typical lengths.
_CONVERGED = 1e-11


@dataclass(frozen=True, eq=False)
class Motion:
    """A set of poses around a sample, where solutions are not isolated over the complex numbers."""

    #: Local dimension of the set, as far as independent steps were found. Zero is that of a real
    #: pose from which no real motion begins (`gspcli.geometry.local_motions`).
    dimension: int
    #: Whether the poses are real, so that the platform really moves if the dimension is not zero;
    #: else the set is known only over the complex numbers.
    real: bool
    #: Consecutive poses, shapes (m, 3, 3) and (m, 3); the first is the sample.
    R: Field
    T: Field

    def to_json(self) -> dict[str, Any]:
        """Return the motion as plain data."""
        document = {
            "dimension": self.dimension,
            "real": self.real,
            "R": self.R.real.tolist(),
            "T": self.T.real.tolist(),
        }
        if not self.real:
            document |= {"R_imag": self.R.imag.tolist(), "T_imag": self.T.imag.tolist()}
        return document


def local_motion(arrangement: Arrangement, R: Field, T: Field) -> Motion | None:
    """Return the motion at a pose that satisfies the constraints, or None if none is found.

    Parameters
    ----------
    arrangement
        The platform.
    R, T
        One pose, shapes (3, 3) and (3,), real or complex. A real pose near its real part is
        tried first.
    """
    system = _System(arrangement)
    T = system.inward(R, T)
    real_R = rotation_from_quaternion(quaternion_from_rotation(R).real)
    for start in ((real_R, T.real), (R.astype(complex), T.astype(complex))):
        pose = system.correct(*start, kernel=1)
        if pose is not None:
            motion = _explore(system, pose)
            if motion is not None:
                return motion
    return None


def _explore(system: _System, pose: tuple[Field, Field]) -> Motion | None:
    """Return the motion through a pose that is accurate."""
    kernel = system.kernel(*pose)
    moves = []
    for twist in kernel:
        there = system.step(pose, _STEP * twist, len(kernel))
        if there is not None:
            moves.append(system.displacement(pose, there))
    if not moves:
        return None
    values = np.linalg.svd(np.array(moves), compute_uv=False)
    dimension = int((values > 0.1 * values[0]).sum())
    poses = [pose]
    twist = moves[0] / np.linalg.norm(moves[0])
    while len(poses) <= _STEPS:
        kernel = system.kernel(*poses[-1])
        along = kernel.T @ (kernel.conj() @ twist)
        size = np.linalg.norm(along)
        if size < 0.5:
            break
        there = system.step(poses[-1], _STEP * along / size, len(kernel))
        if there is None:
            break
        twist = system.displacement(poses[-1], there)
        twist = twist / np.linalg.norm(twist)
        poses.append(there)
    R, T = np.array([R for R, _ in poses]), np.array([T for _, T in poses])
    return Motion(dimension, not np.iscomplexobj(R), R, system.outward(R, T))


class _System:
    """Polynomial equations of the constraints, in lengths of order one.

    Some values are the end of their range: lines at an angle of zero, points at distance zero.
    There the one polynomial of the paper is singular, though real poses may well form a smooth set.
    At real poses such a constraint is therefore replaced by what it means: the directions or the
    points are equal.
    """

    def __init__(self, arrangement: Arrangement) -> None:
        self.outer = arrangement
        self.given = arrangement.normalized
        self.targets = self.given.values.copy()
        self.targets[self.given.angles] = self.given.cosines(self.given.values)

    def inward(self, R: Field, T: Field) -> Field:
        """Return the translation of a pose for the normalized arrangement."""
        back = T - self.outer.base_centre + R @ self.outer.platform_centre
        return back / self.outer.length

    def outward(self, R: Field, T: Field) -> Field:
        """Return translations in the frames that were given."""
        return self.outer.restored(R, T)

    def equations(self, R: Field, T: Field) -> tuple[Field, Field]:
        """Return the errors of one pose, shape (m,), and their derivatives by a twist, (m, 6)."""
        r, w, arm = self.given.placed(R, T)
        parts = [self._equations(i, r[i], w[i], arm[i]) for i in range(len(self.given.kinds))]
        errors, rows = zip(*parts, strict=True)
        return np.concatenate(errors), np.concatenate(rows)

    def _equations(self, i: int, r: Field, w: Field, arm: Field) -> tuple[Field, Field]:
        """Return the equations of one constraint, one or three, and their derivatives."""
        kind, v, target = self.given.kinds[i], self.given.v[i], self.targets[i]
        is_real = not np.iscomplexobj(r)
        if kind.is_distance:
            apart = np.abs(cross(w, v)).max() > MEASURED_PARALLEL_SINE
            if kind is DLL and not apart:
                kind = DPL
            squared = kind in (DPP, DPL, DLP)
            if is_real and squared and target < _END:
                return _across(kind, r, w, v, arm)
        elif is_real and abs(target) > 1 - _END:
            return w - np.sign(target) * v, velocities(arm, w)[1]
        form = polynomial(kind)
        value, row = form.value(r, w, v), by_twist(form.gradient(r, w, v), arm, w)
        if not kind.is_distance:
            error = value - target
        elif squared:
            error = value - target**2
        elif kind.has_sides:
            error = value - (self.given.signs[i] or np.where(value.real < 0, -1, 1)) * target
        elif target == 0:
            error = value
        else:
            # The distance is the moment over the sine of the angle of the lines.
            cosine = COSINE.value(r, w, v)
            normal = cross(w, v)
            error = value**2 - target**2 * dot(normal, normal)
            turn = by_twist(COSINE.gradient(r, w, v), arm, w)
            row = 2 * value * row + 2 * target**2 * cosine * turn
        return error[None], row[None]

    def kernel(self, R: Field, T: Field) -> Field:
        """Return an orthonormal basis of the twists that change nothing, shape (k, 6)."""
        _, values, right = np.linalg.svd(self.equations(R, T)[1])
        values = np.concatenate((values, np.zeros(6)))[:6]
        return definite_basis(right[values < _KERNEL * values[0]].conj().T).T

    def correct(self, R: Field, T: Field, kernel: int) -> tuple[Field, Field] | None:
        """Return the pose after shortest corrections, or None if they do not converge.

        The Jacobian matrix is inverted on its largest 6 - kernel singular values only.
        """
        for _ in range(_CORRECTIONS):
            errors, rows = self.equations(R, T)
            if np.abs(errors).max() < _CONVERGED:
                return R, T
            if not (np.isfinite(errors).all() and np.isfinite(rows).all()):
                return None
            left, values, right = np.linalg.svd(rows)
            rank = max(1, min(6 - kernel, int((values > _KERNEL * values[0]).sum())))
            inner = (left[:, :rank].conj().T @ -errors) / values[:rank]
            R, T = _moved(R, T, right[:rank].conj().T @ inner)
        return None

    def step(
        self, pose: tuple[Field, Field], twist: Field, kernel: int
    ) -> tuple[Field, Field] | None:
        """Return the corrected pose after a step, or None if it came back or strayed.

        The kernel may be larger than the set. Then a step along it is not corrected by what is
        orthogonal to it alone, and smaller kernels are tried.
        """
        for size in range(kernel, 0, -1):
            there = self.correct(*_moved(*pose, twist), kernel=size)
            if there is not None:
                length = np.linalg.norm(self.displacement(pose, there)) / np.linalg.norm(twist)
                if 0.5 < length < 2:
                    return there
        return None

    def displacement(self, here: tuple[Field, Field], there: tuple[Field, Field]) -> Field:
        """Return the twist from one pose to another nearby, shape (6,)."""
        turn = there[0] @ here[0].T
        skew = (turn - turn.T) / 2
        omega = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
        return np.concatenate((omega, there[1] - here[1]))


def _across(kind: Kind, r: Field, w: Field, v: Field, arm: Field) -> tuple[Field, Field]:
    """Return the vector that is zero where a DPP, DPL or DLP distance is, and its derivatives."""
    across = polynomial(kind).gradient(r, w, v).r / 2
    slopes, turning = velocities(arm, w)
    if kind is DPP:
        return across, slopes
    line = v if kind is DPL else w
    along = line @ slopes
    if kind is DLP:
        along = along + r @ turning
        slopes = slopes - (r @ line) * turning
    return across, slopes - np.outer(line, along)


def _moved(R: Field, T: Field, twist: Field) -> tuple[Field, Field]:
    """Return the pose after small twists (..., 6); a quaternion (1, omega / 2) turns by omega."""
    one = np.ones_like(twist[..., :1])
    turn = rotation_from_quaternion(np.concatenate((one, twist[..., :3] / 2), axis=-1))
    return turn @ R, T + twist[..., 3:]


# Constraints that are several equations over the real numbers, and one over the complex ones.
#
# Points at distance zero, a point on a line, and parallel directions are one equation each in the
# paper (Section 4): a sum of squares, or the end of the range of a cosine. Over the complex numbers
# it takes away one degree of freedom, over the reals two or three.


#: Angles, in degrees, at which two directions are parallel.
_STRAIGHT = {ALL: ("0", "180"), ALH: ("90",), AHL: ("90",), AHH: ("0", "180")}
_RIGHT = {AngleUnit.DEGREE: Number.of(90), AngleUnit.RADIAN: Number("pi") / Number.of(2)}
_ZERO, _ONE = Number.of(0), Number.of(1)
_AXES: tuple[Vector, ...] = ((_ONE, _ZERO, _ZERO), (_ZERO, _ONE, _ZERO), (_ZERO, _ZERO, _ONE))


def real_statement(row: Constraint, unit: AngleUnit) -> list[Constraint]:
    """Return the equations of a constraint for real poses, except the sense of a direction."""
    zero = row.value.fraction == 0
    if row.kind is DPP and zero:
        return [_of_zero(row, DPH, axis) for axis in _AXES]
    if row.kind is DPL and zero:
        return [_of_zero(row, DPH, normal) for normal in _normals(_direction(row.base))]
    if row.kind is DLP and zero:
        return [_of_zero(row, DHP, normal) for normal in _normals(_direction(row.platform))]
    if not row.kind.is_distance and _exactly(row.value, unit) in _STRAIGHT[row.kind]:
        platform = Line(row.platform.position, _direction(row.platform))
        return [
            replace(row, kind=ALL, platform=platform, base=base, value=_RIGHT[unit])
            for base in (Line(row.base.position, n) for n in _normals(_direction(row.base)))
        ]
    return [row]


def _exactly(value: Number, unit: AngleUnit) -> str:
    """Return an angle of 0, 90 or 180 degrees in degrees, and others in any form."""
    text = str(value)
    return text if unit is AngleUnit.DEGREE else {"pi": "180", "pi / 2": "90"}.get(text, text)


def _of_zero(row: Constraint, kind: Kind, normal: Vector) -> Constraint:
    """Return the distance zero from a plane through the point or the line of a constraint."""
    if kind is DPH:
        return replace(row, kind=kind, base=Plane(row.base.position, normal))
    return replace(row, kind=kind, platform=Plane(row.platform.position, normal))


def _direction(geometry: Geometry) -> Vector:
    assert not isinstance(geometry, Point)
    return geometry.vector


def _normals(direction: Vector) -> list[Vector]:
    """Return two independent vectors normal to a direction: its products with two axes."""
    largest = max(range(3), key=lambda k: abs(direction[k].value))
    i, j = (largest + 1) % 3, (largest + 2) % 3
    normals = []
    for k, other in ((i, j), (j, i)):
        normal = [_ZERO] * 3
        normal[largest], normal[k] = -direction[k], direction[largest]
        normal[other] = _ZERO
        normals.append((normal[0], normal[1], normal[2]))
    return normals
