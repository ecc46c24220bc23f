"""Signs that no regular path can change: those of det J and of its factors.

The determinant of the Jacobian matrix J is not zero on a regular path, so it keeps its sign. It is
a product if the screws of k constraints lie in a space of dimension k at every pose, with a basis
that is continuous and never degenerate. Their determinant in that basis is not zero either, so it
keeps its sign, too. Two factors can vanish together where det J does not change its sign: comparing
signs of det J alone would miss that.

The spaces are:

- of angles: the moments;
- of distances to planes (DPH) with one normal n, and angles to n: the force n and the moments at
  right angles to it; the same with the bodies exchanged (DHP);
- of distances (DPP, DPL, DPH) of one point of the platform: the forces through it; the same for one
  point of the base (DPP, DLP, DHP).

Two of these determinants are products themselves:

- Three distances of one point to lines at right angles that meet (DPL, DLP). With the coordinates
  x, y, z of the point along the lines the determinant of the forces is a multiple of x y z.
- Angles of three directions at right angles to three others at right angles. With the unit
  quaternion q of the turn between them the determinant of the moments is a multiple of q0 q1 q2 q3.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DLP, DPH, DPL, DPP
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.quaternions import quaternion_from_rotation
from gspcli.motion.paths.pose_ways import PoseWays
from gspcli.records import dataclass

Array = NDArray[np.float64]

#: Directions and points that differ by less are the same, relative to the sizes. The numbers of a
#: file are equal or differ by much more.
_SAME = 1e-13
#: A determinant of unit vectors whose modulus is above this has a certain sign: its rounding errors
#: are below a thousandth of that.
_CERTAIN = 1e-9


@dataclass(frozen=True)
class Factor:
    """A factor of det J.

    Attributes
    ----------
    constraints
        The indices of the constraints whose determinant it is.
    space
        What these constraints see, in words.
    """

    constraints: tuple[int, ...]
    space: str

    @property
    def text(self) -> str:
        """The factor in words."""
        names = ", ".join(str(k + 1) for k in self.constraints)
        return f"the factor of constraints {names} ({self.space})"


@dataclass(frozen=True, eq=False)
class PoseClass:
    """The signs at a pose: of det J, and of each factor; 0 where the sign is not proved."""

    signs: tuple[int, ...]

    def differs(self, other: PoseClass) -> int | None:
        """Return the place of the first sign that is proved to differ; None if there is none."""
        for k, (a, b) in enumerate(zip(self.signs, other.signs, strict=True)):
            if a * b < 0:
                return k
        return None

    @property
    def text(self) -> str:
        """The signs, such as ``+-``; ``?`` where one is not proved."""
        return "".join("-?+"[sign + 1] for sign in self.signs)


class Classes:
    """The signs of one platform.

    Parameters
    ----------
    instance
        The platform.
    ways
        Straight ways of the platform, whose limits are not tested.
    """

    def __init__(self, instance: Instance, ways: PoseWays) -> None:
        self.arrangement = Arrangement.of(instance)
        self.ways = ways
        # Points that cranks and slides move are at no time those of the file.
        found = [] if ways.machine.moves else list(_factors(self.arrangement))
        self.factors = tuple(factor for factor, _ in found)
        self._determinants = [determinant for _, determinant in found]

    def of(self, R: Array, T: Array) -> PoseClass:
        """Return the class of a pose, shapes (3, 3) and (3,)."""
        sign = self.ways.at(self.ways.parameters(R, T)).sign
        values = [one(R, T) for one in self._determinants]
        signs = [int(np.sign(v)) if abs(v) > _CERTAIN else 0 for v in values]
        return PoseClass((sign, *signs))

    def name(self, place: int) -> str:
        """Return what a sign is of, in words."""
        return "det J" if place == 0 else self.factors[place - 1].text


Determinant = Callable[[Array, Array], float]


def _factors(a: Arrangement) -> Iterator[tuple[Factor, Determinant]]:
    """Yield the factors with functions that return their determinants at a pose."""
    angles = a.angles.tolist()
    if len(angles) == 3:
        yield Factor(tuple(angles), "angles"), partial(_of_moments, a, angles)
        yield from _of_turns(a, angles)
    for kind, own, said in ((DPH, a.v, "base"), (DHP, a.u, "platform")):
        for members, n in _with_one_direction(a, kind, own):
            planes = [k for k in members if a.kinds[k] is kind]
            if len(members) in (2, 3) and len(members) == (3 if planes else 2):
                space = f"one direction of the {said}"
                yield Factor(tuple(members), space), partial(_of_planes, a, members, n, kind is DPH)
    for kinds, points, said in (((DPP, DPL, DPH), a.y, "platform"), ((DPP, DLP, DHP), a.x, "base")):
        for members in _at_one_point(a, kinds, points):
            if len(members) == 3:
                yield (
                    Factor(tuple(members), f"one point of the {said}"),
                    partial(_of_forces, a, members),
                )
                yield from _of_places(a, members, said == "platform")


def _of_turns(a: Arrangement, members: list[int]) -> Iterator[tuple[Factor, Determinant]]:
    """Yield the signs of the quaternion of a turn between directions at right angles."""
    own, base = a.u[members], a.v[members]
    if not (_are_orthogonal(own) and _are_orthogonal(base)):
        return
    # The opposite of a direction changes no zero of a moment.
    own, base = own * np.linalg.det(own).round(), base * np.linalg.det(base).round()
    for k in (1, 2, 3):
        space = f"entries 0 and {k} of the quaternion of the turn"
        yield Factor(tuple(members), space), partial(_of_quaternion, own, base, k)


def _of_places(
    a: Arrangement, members: list[int], on_platform: bool
) -> Iterator[tuple[Factor, Determinant]]:
    """Yield the signs of the coordinates of a point along lines at right angles that meet."""
    lines = [a.kinds[k] is (DPL if on_platform else DLP) for k in members]
    points, directions = (a.x, a.v) if on_platform else (a.y, a.u)
    if not all(lines) or not _are_orthogonal(directions[members]):
        return
    first, v = points[members], directions[members]
    # The common point in the coordinates along the lines: each line gives two of the three.
    along = first @ v.T
    centre = np.array([(along.sum(axis=0)[k] - along[k, k]) / 2 for k in range(3)])
    off = along - centre
    off[np.arange(3), np.arange(3)] = 0
    if np.abs(off).max() > _SAME * max(float(np.abs(first).max()), a.length):
        return
    for k in range(3):
        space = f"place along the line of constraint {members[k] + 1}"
        yield (
            Factor(tuple(members), space),
            partial(_of_place, a, members[0], v[k], float(centre[k]), on_platform),
        )


def _are_orthogonal(directions: Array) -> bool:
    return bool(np.abs(directions @ directions.T - np.eye(3)).max() < _SAME)


def _with_one_direction(
    a: Arrangement, kind: object, directions: Array
) -> Iterator[tuple[list[int], Array]]:
    """Yield constraints with one common direction of a body, and that direction."""
    angles = set(a.angles.tolist())
    left = [k for k, one in enumerate(a.kinds) if one is kind or k in angles]
    while left:
        n = directions[left[0]]
        same = [k for k in left if np.abs(np.cross(directions[k], n)).max() < _SAME]
        left = [k for k in left if k not in same]
        yield same, n


def _at_one_point(a: Arrangement, kinds: tuple[object, ...], points: Array) -> Iterator[list[int]]:
    """Yield the distances of each common point of a body."""
    left = [k for k, one in enumerate(a.kinds) if one in kinds]
    size = np.abs(points).max(initial=0.0)
    while left:
        here = points[left[0]]
        same = [k for k in left if np.abs(points[k] - here).max() <= _SAME * size]
        left = [k for k in left if k not in same]
        yield same


def _unit(vectors: Array) -> Array:
    """Return unit vectors; zero for vectors that are nearly zero, whose direction is not known."""
    sizes = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.where(sizes > 0, vectors / np.where(sizes > 0, sizes, 1.0), 0.0)


def _of_moments(a: Arrangement, members: list[int], R: Array, T: Array) -> float:
    """Return the determinant of moments of angles."""
    del T
    w, v = a.u[members] @ R.T, a.v[members]
    moments = np.cross(w, v)
    # Near parallel directions a unit moment would have rounding errors that are not small.
    scale = np.maximum(np.linalg.norm(moments, axis=1), 1e-3)[:, None]
    return float(np.linalg.det(moments / scale))


def _across(n: Array) -> Array:
    """Return two unit vectors at right angles to n and to each other, shape (2, 3).

    They depend on n alone, so they are the same at all poses of a path.
    """
    first = _unit(np.cross(n, np.eye(3)[np.abs(n).argmin()]))
    return np.stack((first, np.cross(n, first)))


def _of_quaternion(own: Array, base: Array, k: int, R: Array, T: Array) -> float:
    """Return the product of two entries of the quaternion of a turn between directions."""
    del T
    q = quaternion_from_rotation(base @ R @ own.T)
    return float(q[0] * q[k])


def _of_place(
    a: Arrangement, member: int, v: Array, centre: float, on_platform: bool, R: Array, T: Array
) -> float:
    """Return the place of a point along a line, from where the lines meet, by the sizes."""
    point = R @ a.y[member] + T if on_platform else (a.x[member] - T) @ R
    size = a.length + np.abs(T).max() + np.abs(a.x[member]).max() + abs(centre)
    return float((point @ v - centre) / size)


def _of_planes(
    a: Arrangement, members: list[int], n: Array, of_base: bool, R: Array, T: Array
) -> float:
    """Return the determinant of screws that see one direction n of a body only.

    In the frame of that body; seen from the platform, the base moves.
    """
    if of_base:
        arms, others, far = a.y[members] @ R.T, a.u[members] @ R.T, 0.0
    else:
        arms, others = (a.x[members] - T) @ R, a.v[members] @ R
        far = float(np.abs(T).max() + np.abs(a.x[members]).max())
    middle = arms.mean(axis=0)
    basis = _across(n)
    rows = []
    for k, arm, other in zip(members, arms, others, strict=True):
        plane = a.kinds[k] in (DPH, DHP)
        moment = np.cross(arm - middle, n) if plane else np.cross(other, n)
        row = basis @ moment
        rows.append([*row, 1.0 if plane else 0.0] if len(members) == 3 else row)
    matrix = np.array(rows)
    if len(members) == 3:
        size = np.abs(matrix[:, :2]).max(initial=0.0)
        # Differences of arms have rounding errors relative to these.
        size = max(size, 1e-3 * (far + float(np.abs(arms).max(initial=0.0))), 1e-300)
        planes = matrix[:, 2] == 1.0
        matrix[planes, :2] /= size
    return float(np.linalg.det(matrix))


def _of_forces(a: Arrangement, members: list[int], R: Array, T: Array) -> float:
    """Return the determinant of the unit forces of distances."""
    placed = a.placed(R, T)
    forces = []
    for k in members:
        r, w, v = placed.r[k], placed.w[k], a.v[k]
        kind = a.kinds[k]
        if kind is DPP:
            force = r
        elif kind is DPL:
            force = r - (r @ v) * v
        elif kind is DLP:
            force = r - (r @ w) * w
        else:
            force = v if kind is DPH else w
        # A distance near zero has no direction that is known well.
        size = float(np.linalg.norm(force))
        sizes = (np.linalg.norm(part) for part in (T, a.x[k], a.y[k]))
        known = size > 1e-5 * float(sum(sizes))
        forces.append(force / size if known or kind in (DPH, DHP) else np.zeros(3))
    return float(np.linalg.det(forces))
