"""Which twists constraints leave at a pose, to first order, and which constraints are redundant.

Any number of constraints: fewer than six, six, or more. A twist is described as a screw: the turn
about an axis with its pitch, or a translation. Ranks are numerical.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gspcli.catalogue.kinds import KINDS_BY_NAME, Kind
from gspcli.errors import ArgumentError
from gspcli.geometry.arrangement import Arrangement, Array
from gspcli.geometry.instance import Constraint, Instance
from gspcli.geometry.measurement import jacobian, measured
from gspcli.geometry.numbers import Number
from gspcli.motion.poses.inverse_kinematics import checked_poses
from gspcli.records import EqualByContent, dataclass
from gspcli.wording import counted, listed

#: Singular values and entries below this part of the largest are zero.
_ZERO = 1e-8
#: A distance is zero below this part of the typical length, an angle at its end below this.
_END = 1e-7
#: Entries of a direction that are shown; smaller ones are zero.
_DIGITS = 6


@dataclass(frozen=True, eq=False)
class Screw:
    """A twist that the constraints allow."""

    #: The direction of the turn, or of the translation, in the base; a unit vector.
    axis: Array
    #: The point of the axis that is nearest to the origin of the base; None for a translation.
    point: Array | None
    #: By how much the platform moves along the axis in a full turn; 0 for a pure rotation, None for
    #: a translation.
    pitch: float | None
    #: Turn and velocity of the platform's origin, shape (6,), in radians and lengths.
    twist: Array

    def words(self, unit: str) -> str:
        """Return the screw in words."""
        along = _vector(self.axis)
        if self.point is None:
            return f"translation along {along}"
        where = f"about the axis {along} through {_vector(self.point)}"
        if not self.pitch:
            return f"rotation {where}"
        return f"screw {where}, {self.pitch:.6g} {unit} a turn"

    def to_json(self, unit: str) -> dict[str, Any]:
        """Return the screw as plain data, with its words."""
        parts = vars(self).items()
        plain = {key: x.tolist() if isinstance(x, np.ndarray) else x for key, x in parts}
        return {"words": self.words(unit), **plain}


@dataclass(frozen=True, eq=False)
class AbsentConstraint:
    """A constraint that could be added, and the freedoms that it would restrain."""

    #: The kind and the primitives of the constraint.
    kind: Kind
    platform: str
    base: str
    #: How many freedoms it would remove: 0, 1, or more where it is at the end of its range.
    removes: int
    #: The numbers of the screws that it restrains, from 1.
    touches: tuple[int, ...]

    @property
    def name(self) -> str:
        """Return the constraint as a line of a file."""
        return f"{'distance' if self.kind.is_distance else 'angle'}: [{self.platform}, {self.base}]"


@dataclass(frozen=True, eq=False)
class Freedoms(EqualByContent):
    """The freedoms of a platform that its constraints do not remove.

    Attributes
    ----------
    instance
        The platform, with any number of constraints.
    R, T
        The pose.
    rank
        How many freedoms the constraints remove.
    screws
        A basis of the twists that the constraints allow, 6 - rank of them.
    redundant
        For each constraint that removes no further freedom, numbered from 1: the earlier
        constraints on which it depends.
    off
        By how much each stated value differs from that of the pose, in the units of the instance.
    candidates
        Constraints between primitives of the file that would remove a freedom.
    """

    instance: Instance
    R: Array
    T: Array
    rank: int
    screws: tuple[Screw, ...]
    redundant: dict[int, tuple[int, ...]]
    off: Array
    candidates: tuple[AbsentConstraint, ...]

    def __repr__(self) -> str:
        return f"<Freedoms: {self.sentences[0]}>"

    @property
    def sentences(self) -> list[str]:
        """The remaining freedoms, in sentences."""
        count = len(self.instance.constraints)
        left = 6 - self.rank
        said = counted(count, "constraint") + (" takes" if count == 1 else " take")
        said += f" {self.rank} of 6 freedoms: "
        said += f"{left} left" if left else "none is left"
        lines = [f"{said} (at this pose, to first order)"]
        for number, others in self.redundant.items():
            what = f"constraint {number} is redundant"
            if others:
                verb = "already prevents" if len(others) == 1 else "already prevent"
                names = listed(map(str, others), "and")
                what += f": {names} {verb} what it prevents"
            lines.append(what)
        return lines

    def to_json(self) -> dict[str, Any]:
        """Return all of it as plain data."""
        return {
            "name": self.instance.name,
            "units": {
                "length": self.instance.units.length,
                "angle": self.instance.units.angle.value,
            },
            "constraints": [row.kind.name for row in self.instance.constraints],
            "R": self.R.tolist(),
            "T": self.T.tolist(),
            "rank": self.rank,
            "off": self.off.tolist(),
            "screws": [one.to_json(self.instance.units.length) for one in self.screws],
            "redundant": [
                {"constraint": number, "by": list(others)}
                for number, others in self.redundant.items()
            ],
            "candidates": [
                {**vars(one), "kind": one.kind.name, "touches": list(one.touches)}
                for one in self.candidates
            ],
        }


def freedoms(
    instance: Instance, R: ArrayLike | None = None, T: ArrayLike | None = None
) -> Freedoms:
    """Return which twists the constraints of a platform leave at a pose, to first order.

    Parameters
    ----------
    instance
        The platform with one constraint or more. `gspcli.spec.read` reads files with any number
        if it is asked to (``any_number=True``); ``Instance`` takes any.
    R, T
        The pose, shapes (3, 3) and (3,); the stated home if None.

    Raises
    ------
    ArgumentError
        If there is neither a pose nor a home, or a constraint is wrong.

    Examples
    --------
    >>> import gspcli
    >>> hinge = gspcli.Line([0, 0, 0], [0, 0, 1])
    >>> rows = [
    ...     gspcli.distance(gspcli.Point([0, 0, 0]), gspcli.Point([0, 0, 0]), 0),
    ...     gspcli.angle(hinge, hinge, 0),
    ... ]
    >>> door = gspcli.Instance(tuple(rows), gspcli.example("dietmaier").units)
    >>> (left,) = gspcli.freedoms(door, [[1, 0, 0], [0, 1, 0], [0, 0, 1]], [0, 0, 0]).screws
    >>> print(left.words("mm"))
    rotation about the axis (0, 0, 1) through (0, 0, 0)
    """
    if not instance.constraints:
        message = "found none, expected one constraint at least"
        raise ArgumentError(message, "constraints")
    R, T = _pose(instance, R, T)
    groups = _rows(instance, R, T)
    length = _size(instance)
    scale = np.array([1 / length] * 3 + [1.0] * 3)
    scaled = [rows * scale for rows in groups]
    taken, redundant = np.zeros((0, 6)), {}
    for number, rows in enumerate(scaled, 1):
        more = np.vstack((taken, rows))
        if _rank(more) == _rank(taken):
            redundant[number] = _by(scaled[: number - 1], rows)
        taken = more
    rank = _rank(taken)
    space = np.linalg.svd(taken)[2][rank:] * scale
    screws = tuple(_screws(space, T, length))
    off = _off(instance, R, T)
    candidates = tuple(_candidates(instance, R, T, screws, length)) if screws else ()
    return Freedoms(instance, R, T, rank, screws, redundant, off, candidates)


def _pose(instance: Instance, R: ArrayLike | None, T: ArrayLike | None) -> tuple[Array, Array]:
    """Return the pose, the stated home if none is given."""
    if R is not None and T is not None:
        return checked_poses(R, T)
    home = instance.home
    if home is None:
        message = "found no pose, expected R and T, or an instance with home"
        raise ArgumentError(message, "R")
    return home.R(instance.units.angle.in_radians), home.T


def _size(instance: Instance) -> float:
    """Return a typical length."""
    arrangement = Arrangement.of(instance)
    lengths = [np.abs(arrangement.y).max(), np.abs(arrangement.x).max()]
    distances = [row.value.value for row in instance.constraints if row.kind.is_distance]
    return float(max([*lengths, *distances])) or 1.0


def _rows(instance: Instance, R: Array, T: Array) -> list[Array]:
    """Return the derivatives of each constraint by a twist, shape (k, 6).

    One row; two or three where a distance is zero or directions are parallel: then the value has
    no derivative, and a vector must be zero.
    """
    arrangement = Arrangement.of(instance)
    length = _size(instance)
    with np.errstate(all="ignore"):
        slopes = jacobian(arrangement, R, T)
        values = measured(arrangement, R, T)
    r, w, arm = arrangement.placed(R, T)
    found = []
    for k, kind in enumerate(arrangement.kinds):
        rows = slopes[k][None]
        v = arrangement.v[k]
        if kind.name == "DPP" and np.linalg.norm(r[k]) <= _END * length:
            rows = _shifts(np.eye(3), arm[k])
        elif kind.name in ("DPL", "DLP") and abs(values[k]) <= _END * length:
            line = v if kind.name == "DPL" else w[k]
            across = np.linalg.svd(line[None])[2][1:]
            rows = _shifts(across, arm[k])
            if kind.name == "DLP":
                rows[:, :3] -= np.cross(line, across) * (r[k] @ line)
        elif not kind.is_distance and np.linalg.norm(np.cross(w[k], v)) <= _END:
            across = np.linalg.svd(w[k][None])[2][1:]
            rows = np.hstack((np.cross(w[k], across), np.zeros((2, 3))))
        found.append(np.where(np.isfinite(rows), rows, 0.0))
    return found


def _shifts(directions: Array, arm: Array) -> Array:
    """Return how a point of the platform moves along directions by a twist, shape (k, 6)."""
    return np.hstack((np.cross(arm, directions), directions))


def _rank(rows: Array) -> int:
    """Return the numerical rank of rows, each divided by its length."""
    sizes = np.linalg.norm(rows, axis=1, keepdims=True)
    kept = sizes[:, 0] > 1e-300
    if not kept.any():
        return 0
    s = np.linalg.svd(rows[kept] / sizes[kept], compute_uv=False)
    return int((s > _ZERO * s[0]).sum())


def _by(groups: list[Array], rows: Array) -> tuple[int, ...]:
    """Return the fewest constraints, from 1, of which rows are combinations."""
    needed = list(range(len(groups)))
    for k in reversed(range(len(groups))):
        rest = [groups[j] for j in needed if j != k]
        stack = np.vstack([np.zeros((0, 6)), *rest])
        if _rank(np.vstack((stack, rows))) == _rank(stack):
            needed.remove(k)
    return tuple(k + 1 for k in needed)


def _screws(space: Array, T: Array, length: float) -> list[Screw]:
    """Return a basis of twists in plain forms: principal screws, then translations."""
    if not len(space):
        return []
    scale = np.array([length] * 3 + [1.0] * 3)
    basis = np.linalg.qr((space * scale).T)[0].T
    turns = basis[:, :3]
    U, s, _ = np.linalg.svd(turns)
    count = int((s > _ZERO).sum())
    moves = _plain(U[:, count:].T @ basis)
    turning = U[:, :count].T @ basis
    if len(moves):
        # A velocity along a translation that is allowed does not describe the turn.
        free = np.linalg.qr(moves[:, 3:].T)[0]
        turning[:, 3:] -= turning[:, 3:] @ free @ free.T
    found = [_screw(one / scale, T, length) for one in _principal(turning)]
    return [*found, *(_screw(one / scale, T, length) for one in moves)]


def _principal(turning: Array) -> Array:
    """Return turning twists with perpendicular axes and extreme pitches, plain where alike."""
    if not len(turning):
        return turning
    turns, moves = turning[:, :3], turning[:, 3:]
    gram = turns @ turns.T
    root = np.linalg.inv(np.linalg.cholesky(gram))
    pitches = root @ ((turns @ moves.T + moves @ turns.T) / 2) @ root.T
    values, vectors = np.linalg.eigh(pitches)
    rows = vectors.T @ root @ turning
    # Values in order: alike ones follow each other.
    groups = np.split(rows, np.flatnonzero(np.diff(values) > 1e-6) + 1)
    return np.vstack([_plain(group) for group in groups])


def _plain(rows: Array) -> Array:
    """Return rows that span the same space, with as many zeros as elimination gives."""
    rows = rows.copy()
    used: list[int] = []
    for k in range(len(rows)):
        left = np.abs(rows[k:])
        column = int(np.argmax((left.max(axis=0) > 1e-6 * left.max()) & ~np.isin(range(6), used)))
        best = k + int(left[:, column].argmax())
        rows[[k, best]] = rows[[best, k]]
        rows[k] /= rows[k, column]
        others = np.arange(len(rows)) != k
        rows[others] -= np.outer(rows[others, column], rows[k])
        used.append(column)
    return rows


def _screw(twist: Array, T: Array, length: float) -> Screw:
    """Return a twist as a screw."""
    turn, move = twist[:3], twist[3:]
    size = float(np.linalg.norm(turn))
    if size * length <= _ZERO * max(float(np.linalg.norm(move)), 1e-300):
        axis = move / np.linalg.norm(move)
        return Screw(_signed(axis), None, None, twist)
    axis = turn / size
    signed = _signed(axis)
    point = T + np.cross(turn, move) / size**2
    point = point - (point @ axis) * axis
    pitch = 2 * math.pi * float(turn @ move) / size**2
    if abs(pitch) <= 1e-7 * length:
        pitch = 0.0
    return Screw(signed, _clean(point, length), pitch, twist)


def _signed(axis: Array) -> Array:
    """Return a direction whose largest entry is positive."""
    clean = _clean(axis, 1.0)
    first = clean[np.flatnonzero(np.abs(clean) >= np.abs(clean).max() - 1e-9)[0]]
    signed: Array = clean * np.sign(first) + 0.0
    return signed


def _clean(vector: Array, size: float) -> Array:
    """Return a vector without entries that are rounding errors."""
    return np.where(np.abs(vector) <= 1e-9 * size, 0.0, vector)


def _vector(vector: Array) -> str:
    return f"({', '.join(f'{x:.{_DIGITS}g}' for x in vector.tolist())})"


def _off(instance: Instance, R: Array, T: Array) -> Array:
    """Return by how much stated values differ from those at a pose."""
    arrangement = Arrangement.of(instance)
    values = measured(arrangement, R, T)
    units = np.array(
        [1.0 if kind.is_distance else arrangement.in_radians for kind in arrangement.kinds]
    )
    sides = np.where(arrangement.sides == 0, np.sign(values) + (values == 0), arrangement.sides)
    signed = np.array([kind.has_sides or kind.name == "DLL" for kind in arrangement.kinds])
    return np.asarray(np.where(signed, values * sides, values) / units - arrangement.values)


def _candidates(
    instance: Instance, R: Array, T: Array, screws: Sequence[Screw], length: float
) -> list[AbsentConstraint]:
    """Return the constraints between primitives of the file that would remove a freedom."""
    bodies = [instance.named(body) for body in ("platform", "base")]
    there = {(row.kind, row.platform_name, row.base_name) for row in instance.constraints}
    twists = np.array([one.twist for one in screws])
    twists = twists / np.linalg.norm(twists * ([length] * 3 + [1.0] * 3), axis=1, keepdims=True)
    result = []
    for (here, one), (where, other) in product(bodies[0].items(), bodies[1].items()):
        for quantity in "DA":
            name = quantity + one.primitive.value + other.primitive.value
            kind = KINDS_BY_NAME.get(name)
            if kind is None or (kind, here, where) in there:
                continue
            row = Constraint(kind, one, other, Number.of(1))
            trial = Instance((row,), instance.units)
            (rows,) = _rows(trial, R, T)
            acts = rows @ twists.T
            size = np.linalg.norm(rows * ([1 / length] * 3 + [1.0] * 3), axis=1).max(initial=0.0)
            strong = np.abs(acts).max(axis=0) > 1e-6 * max(size, 1e-300)
            if strong.any():
                touches = tuple((np.flatnonzero(strong) + 1).tolist())
                result.append(
                    AbsentConstraint(kind, here, where, _rank(acts @ np.eye(len(twists))), touches)
                )
    result.sort(key=lambda one: (len(one.touches), one.touches))
    return result
