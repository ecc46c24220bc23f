"""Platforms with a known exact solution, with known multiple ones, and Dietmaier's."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import pytest

from gspcli.catalogue.kinds import AHH, ALL, DLL, DLP, DPH, DPL, DPP, KINDS_BY_NAME, Kind, Primitive
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side, Units
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Line, Plane, Point, vector
from gspcli.geometry.quaternions import cross, rotation_from_quaternion

Triple = list[Fraction]
RADIANS = Units("m", AngleUnit.RADIAN)


@dataclass(frozen=True)
class Known:
    """An instance, and one exact solution of it."""

    instance: Instance
    R: list[Triple]
    T: Triple

    @property
    def floats(self) -> tuple[np.ndarray, np.ndarray]:
        return np.array(self.R, dtype=float), np.array(self.T, dtype=float)


def _dot(a: Triple, b: Triple) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def _cross(a: Triple, b: Triple) -> Triple:
    return [a[k - 2] * b[k - 1] - a[k - 1] * b[k - 2] for k in range(3)]


def _apply(R: list[Triple], a: Triple) -> Triple:
    return [_dot(row, a) for row in R]


def _rotation(w: Fraction, x: Fraction, y: Fraction, z: Fraction) -> list[Triple]:
    n = w * w + x * x + y * y + z * z
    rows = [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]
    return [[entry / n for entry in row] for row in rows]


def _function(name: str, argument: Number | Fraction) -> Number:
    return Number(name, (Number.of(argument),))


def _value(kind: Kind, R: list[Triple], w: Triple, u: Triple, v: Triple) -> Number:
    """Return the exact distance or angle (radians), from the paper's Section 4."""
    turned = _apply(R, u)
    if not kind.is_distance:
        sine = kind not in (ALL, AHH)
        inner = -_dot(turned, v) if kind is AHH else _dot(turned, v)
        cosine = Number("/", (Number.of(inner), _function("sqrt", _dot(u, u) * _dot(v, v))))
        return _function("asin" if sine else "acos", cosine)
    if kind is DPP:
        return _function("sqrt", _dot(w, w))
    if kind in (DPL, DLP):
        axis = v if kind is DPL else turned
        across = _cross(w, axis)
        return _function("sqrt", _dot(across, across) / _dot(axis, axis))
    if kind is DLL:
        common = _cross(turned, v)
        return _function("sqrt", _dot(w, common) ** 2 / _dot(common, common))
    normal = v if kind is DPH else turned
    return _function("sqrt", _dot(w, normal) ** 2 / _dot(normal, normal))


def known_platform(names: str, seed: int, *, sided: bool = True) -> Known:
    """Return random rational geometry with values such that a rational pose is a solution."""
    source = random.Random(seed)

    def number() -> Fraction:
        return Fraction(source.randint(-40, 40), source.randint(7, 19))

    def triple() -> Triple:
        return [number() for _ in range(3)]

    def primitive(sort: Primitive, point: Triple, direction: Triple) -> Point | Line | Plane:
        if sort is Primitive.POINT:
            return Point(vector(*point))
        shape = Line if sort is Primitive.LINE else Plane
        return shape(vector(*point), vector(*direction))

    R, T = _rotation(*(number() + 5 for _ in range(4))), triple()
    constraints = []
    for name in names.split():
        kind = KINDS_BY_NAME[name]
        a, b, u, v = triple(), triple(), triple(), triple()
        w = [x + t - y for x, t, y in zip(_apply(R, a), T, b, strict=True)]
        side = Side.BOTH
        if kind.has_sides and sided:
            height = _dot(w, v) if kind is DPH else -_dot(w, _apply(R, u))
            side = Side.POSITIVE if height > 0 else Side.NEGATIVE
        constraints.append(
            Constraint(
                kind,
                primitive(kind.platform, a, u),
                primitive(kind.base, b, v),
                _value(kind, R, w, u, v),
                side,
            )
        )
    return Known(Instance(tuple(constraints), RADIANS), R, T)


@pytest.fixture(scope="session")
def known() -> Callable[..., Known]:
    return known_platform


@pytest.fixture(scope="session")
def tangent() -> Callable[[Fraction], Instance]:
    """A platform whose solutions near (1, 0, 0) are R = 1, T = (1, 0, +-sqrt(d^2 - 1))."""

    def build(d: Fraction) -> Instance:
        known = known_platform("ALL ALH AHH", 5)
        identity = [[Fraction(int(i == j)) for j in range(3)] for i in range(3)]
        angles = []
        for row in known.instance.constraints:
            u, v = (
                [n.fraction for n in (g.direction if isinstance(g, Line) else g.normal)]
                for g in (row.platform, row.base)
            )
            value = _value(row.kind, identity, [], u, v)
            angles.append(Constraint(row.kind, row.platform, row.base, value))
        origin = vector(0, 0, 0)
        point, centre = Point(origin), Point(origin)
        planes = [Plane(origin, vector(2, 0, 0)), Plane(origin, vector(0, 3, 0))]
        dph = KINDS_BY_NAME["DPH"]
        return Instance(
            (
                *angles,
                Constraint(dph, point, planes[0], Number.of(1), Side.POSITIVE),
                Constraint(dph, point, planes[1], Number.of(0)),
                Constraint(DPP, point, centre, Number.of(d)),
            ),
            RADIANS,
        )

    return build


#: P. Dietmaier, The Stewart-Gough platform of general geometry can have 40 real postures (1998).
_BASE = """0,0,0 1.107915,0,0 0.549094,0.756063,0 0.735077,-0.223935,0.525991
           0.514188,-0.526063,-0.368418 0.590473,0.094733,-0.205018"""
_PLATFORM = """0,0,0 0.542805,0,0 0.956919,-0.528915,0 0.665885,-0.353482,1.402538
               0.478359,1.158742,0.107672 -0.137087,-0.235121,0.353913"""
_LEGS = "1 0.645275 1.086284 1.503439 1.281933 0.771071"


@pytest.fixture(scope="session")
def dietmaier() -> Instance:
    def points(text: str) -> Sequence[Point]:
        return [Point(vector(*triple.split(","))) for triple in text.split()]

    rows = zip(points(_PLATFORM), points(_BASE), _LEGS.split(), strict=True)
    constraints = tuple(Constraint(DPP, y, x, Number.of(d)) for y, x, d in rows)
    return Instance(constraints, Units("m", AngleUnit.DEGREE))


@pytest.fixture(scope="session")
def forty(dietmaier: Instance) -> tuple[np.ndarray, np.ndarray]:
    """All real poses of Dietmaier's platform, by Newton's method from random ones."""
    y = np.array([row.platform.point for row in dietmaier.constraints])
    x = np.array([row.base.point for row in dietmaier.constraints])
    d = np.array([row.value.value for row in dietmaier.constraints])
    source = np.random.default_rng(0)
    R = rotation_from_quaternion(source.standard_normal((3000, 4)))
    T = source.standard_normal((3000, 3))
    for _ in range(60):
        arms = y @ np.swapaxes(R, 1, 2)
        legs = arms + T[:, None] - x
        jacobian = 2 * np.concatenate((cross(arms, legs), legs), axis=-1)
        error = (legs**2).sum(-1) - d**2
        step = -np.linalg.solve(jacobian, error[..., None])[..., 0]
        # Far away a full step does not converge.
        step /= np.maximum(1, 2 * np.abs(step).max(axis=1, keepdims=True))
        turn = np.concatenate((np.ones((len(R), 1)), step[:, :3] / 2), axis=1)
        R, T = rotation_from_quaternion(turn) @ R, T + step[:, 3:]
    done = np.abs(error).max(axis=1) < 1e-12
    R, T = R[done], T[done]
    poses = np.concatenate((R.reshape(-1, 9), T), axis=1)
    kept: list[int] = []
    for k, pose in enumerate(poses):
        if all(np.abs(pose - poses[other]).max() > 1e-3 for other in kept):
            kept.append(k)
    return R[kept], T[kept]
