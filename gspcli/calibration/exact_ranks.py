"""How many numbers poses of a sort can tell at most, however many there are: ranks modulo a prime.

The derivatives of what is measured are taken at random poses modulo 2^61 - 1, exactly. Their rank
is that at almost all poses of the sort, unless a nonzero minor vanishes at the random ones, which
has a probability of some 1e-16. Irrational coordinates, and directions whose length is no square
modulo the prime, are replaced by random ones: the rank can only be larger for these.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Literal, NamedTuple

from gspcli.calibration.blocks import Block
from gspcli.calibration.parameters import Model
from gspcli.catalogue.kinds import ALL, DHP, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.geometry.instance import Instance
from gspcli.geometry.primitives import Point

PRIME = 2**61 - 1
#: Poses are drawn until all roots exist: half of the numbers have one.
_TRIES = 500
#: And this many directions for which a constant angle has its sine.
_FAILURES = 20

Motion = Literal["all", "translations", "one axis"]
Measured = Literal["pose", "position", "inclination"]
Vector = list[int]


class _Placed(NamedTuple):
    """A primitive modulo the prime."""

    point: Vector
    unit: Vector | None
    motions: list[tuple[Vector | None, Vector | None]]
    """For each parameter a shift or a turn."""


class _Row(NamedTuple):
    """A value and its derivatives: by point and turn of each primitive, and by a twist."""

    value: int | None
    platform: Vector
    base: Vector
    platform_turn: Vector
    base_turn: Vector
    twist: Vector


def exact_rank(
    instance: Instance,
    model: Model,
    *,
    motion: Motion = "all",
    measured: Measured = "pose",
    seed: int = 0,
) -> int | None:
    """Return how many of the free parameters values and poses of a sort can tell, at most.

    None where no such poses have derivatives modulo the prime, as where an angle is always zero.

    Parameters
    ----------
    instance, model
        The platform, and which parameters are free; no frames.
    motion
        How the poses differ: freely, by translations only, or also by turns about one axis.
    measured
        What is known of each pose, exactly: all of it, the position of the platform's origin, or
        the direction of the vertical.
    seed
        Of the random poses.
    """
    rng = random.Random(seed)
    columns = [k for k, chosen in enumerate(model.free) if chosen]
    placed: dict[tuple[str, str], _Placed] = {
        (b.body, b.name): _placed(instance, b, rng) for b in model.blocks
    }
    basis: dict[int, list[int]] = {}
    fixed = _rotation(rng)
    idle = failed = 0
    # Poses are added until none of some tells anything new.
    while idle < 3 and len(basis) < len(columns):
        pose = _pose_with_roots(model, placed, motion, fixed, rng)
        if pose is None:
            fixed, failed = _rotation(rng), failed + 1
            if failed > _FAILURES:
                return None
            continue
        R, rows = pose
        lines = [_line(model, placed, k, row, rng) for k, row in enumerate(rows)]
        by_pose = [row.twist for row in rows]
        if measured != "pose":
            more = _known_of(measured, R)
            lines += [[0] * len(model.free) for _ in more]
            by_pose += more
            lines = _eliminated(by_pose, lines)
        before = len(basis)
        for line in lines:
            _enter(basis, [line[k] for k in columns])
        idle = idle + 1 if len(basis) == before else 0
    return len(basis)


def _dot(a: Sequence[int], b: Sequence[int]) -> int:
    return sum(x * y for x, y in zip(a, b, strict=True)) % PRIME


def _cross(a: Vector, b: Vector) -> Vector:
    return [(a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2]) % PRIME for i in range(3)]


def _times(k: int, a: Vector) -> Vector:
    return [k * x % PRIME for x in a]


def _plus(*vectors: Vector) -> Vector:
    return [sum(parts) % PRIME for parts in zip(*vectors, strict=True)]


def _moved(R: list[Vector], a: Vector) -> Vector:
    return [_dot(row, a) for row in R]


def _back(R: list[Vector], a: Vector) -> Vector:
    return [_dot(column, a) for column in zip(*R, strict=True)]


def _inverse(a: int) -> int:
    return pow(a, -1, PRIME)


def _root(a: int) -> int | None:
    """Return a square root modulo the prime, which is 3 modulo 4; None if there is none."""
    root = pow(a, (PRIME + 1) // 4, PRIME)
    return root if root * root % PRIME == a % PRIME else None


def _rotation(rng: random.Random, *, about_z: bool = False) -> list[Vector]:
    a, b, c, d = (rng.randrange(1, PRIME) for _ in range(4))
    if about_z:
        b = c = 0
    n = _inverse(_dot((a, b, c, d), (a, b, c, d)))
    rows = [
        [a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
        [2 * (b * c + a * d), a * a - b * b + c * c - d * d, 2 * (c * d - a * b)],
        [2 * (b * d - a * c), 2 * (c * d + a * b), a * a - b * b - c * c + d * d],
    ]
    return [_times(n, row) for row in rows]


def _placed(instance: Instance, block: Block, rng: random.Random) -> _Placed:
    geometry = getattr(instance.constraints[block.rows[0]], block.body)

    def entries(vector: Sequence[object]) -> Vector:
        exact = [getattr(number, "fraction", None) for number in vector]
        return [
            rng.randrange(PRIME)
            if one is None
            else one.numerator * _inverse(one.denominator) % PRIME
            for one in exact
        ]

    point = entries(geometry.position)
    if isinstance(geometry, Point):
        axes: list[tuple[Vector | None, Vector | None]] = [
            ([1, 0, 0], None),
            ([0, 1, 0], None),
            ([0, 0, 1], None),
        ]
        return _Placed(point, None, axes)
    unit = _unit(entries(geometry.vector))
    while unit is None:
        unit = _unit([rng.randrange(PRIME) for _ in range(3)])
    first = _cross(unit, [1, 0, 0] if unit[1] or unit[2] else [0, 1, 0])
    second = _cross(unit, first)
    shifts: list[Vector] = [unit] if block.sort == "plane" else [first, second]
    return _Placed(
        point,
        unit,
        [
            *((shift, None) for shift in shifts[: len(block.shifts)]),
            (None, first),
            (None, second),
        ],
    )


def _unit(vector: Vector) -> Vector | None:
    length = _root(_dot(vector, vector))
    return None if not length else _times(_inverse(length), vector)


def _pose_with_roots(
    model: Model,
    placed: dict[tuple[str, str], _Placed],
    motion: Motion,
    fixed: list[Vector],
    rng: random.Random,
) -> tuple[list[Vector], list[_Row]] | None:
    """Return a random pose at which all values exist, with their rows; None if there seems none."""
    ends = [
        tuple(
            next(placed[b.body, b.name] for b in model.blocks if b.body == body and k in b.rows)
            for body in ("platform", "base")
        )
        for k in range(len(model.kinds))
    ]
    for _ in range(_TRIES):
        R = fixed if motion == "translations" else _rotation(rng, about_z=motion == "one axis")
        T = [rng.randrange(PRIME) for _ in range(3)]
        rows: list[_Row] = []
        for kind, (own, other) in zip(model.kinds, ends, strict=True):
            row = _row(kind, own, other, R, T)
            if row is None:
                break
            rows.append(row)
        else:
            return R, rows
    return None


def _row(kind: Kind, own: _Placed, other: _Placed, R: list[Vector], T: Vector) -> _Row | None:
    """Return a value and its derivatives (Section 4 of the paper); None without a root."""
    arm, none = _moved(R, own.point), [0, 0, 0]
    r = _plus(arm, T, _times(-1, other.point))
    w = none if own.unit is None else _moved(R, own.unit)
    v = none if other.unit is None else other.unit
    by_r, by_w, by_v, value = none, none, none, None
    if kind in (DPP, DPL, DLP):
        along = v if kind is DPL else w if kind is DLP else none
        across = _plus(r, _times(-_dot(r, along), along))
        value = _root(_dot(across, across))
        if not value:
            return None
        k = _inverse(value)
        by_r = _times(k, across)
        by_v = _times(-_dot(r, v) * k, r) if kind is DPL else none
        by_w = _times(-_dot(r, w) * k, r) if kind is DLP else none
    elif kind is DPH:
        value, by_r, by_v = _dot(r, v), v, r
    elif kind is DHP:
        value, by_r, by_w = _dot(r, w), w, r
    else:
        cosine = _dot(w, v)
        sine = _root((1 - cosine * cosine) % PRIME)
        if not sine:
            return None
        k = _inverse(sine)
        if kind is DLL:
            moment = _dot(r, _cross(w, v))
            value, turning = moment * k % PRIME, pow(k, 3, PRIME) * moment * cosine
            by_r = _times(k, _cross(w, v))
            by_w = _plus(_times(k, _cross(v, r)), _times(turning, v))
            by_v = _plus(_times(k, _cross(r, w)), _times(turning, w))
        else:
            k = -k if kind is ALL else k
            by_w, by_v = _times(k, v), _times(k, w)
    twist = _plus(_cross(arm, by_r), _cross(w, by_w)) + by_r
    own_turn = none if own.unit is None else _cross(own.unit, _back(R, by_w))
    other_turn = none if other.unit is None else _cross(other.unit, by_v)
    return _Row(value, _back(R, by_r), _times(-1, by_r), own_turn, other_turn, twist)


def _line(
    model: Model,
    placed: dict[tuple[str, str], _Placed],
    k: int,
    row: _Row,
    rng: random.Random,
) -> list[int]:
    """Return the derivatives of a value by all parameters."""
    line = [0] * len(model.free)
    for block, span in model.spans():
        if k not in block.rows:
            continue
        point, turn = (
            (row.platform, row.platform_turn)
            if block.body == "platform"
            else (row.base, row.base_turn)
        )
        motions = placed[block.body, block.name].motions
        for at, (shift, tilt) in zip(range(span.start, span.stop), motions, strict=True):
            line[at] = _dot(shift, point) if shift is not None else _dot(tilt or [0] * 3, turn)
    line[model.geometry + k] = PRIME - 1
    # An angle is no algebraic number of its pose: any other number is as good.
    line[model.geometry + 6 + k] = -(row.value or rng.randrange(1, PRIME)) % PRIME
    return line


def _known_of(measured: Measured, R: list[Vector]) -> list[Vector]:
    """Return the derivatives by a twist of what is known of a pose."""
    axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    if measured == "position":
        return [[0, 0, 0, *axis] for axis in axes]
    turned = [_back(R, _cross(axes[2], axis)) for axis in axes]
    return [[*(turned[j][i] for j in range(3)), 0, 0, 0] for i in range(2)]


def _eliminated(by_pose: list[Vector], lines: list[list[int]]) -> list[list[int]]:
    """Return the combinations of lines in which the pose does not occur."""
    rows = [[*pose, *line] for pose, line in zip(by_pose, lines, strict=True)]
    done = 0
    for column in range(6):
        pivot = next((k for k in range(done, len(rows)) if rows[k][column]), None)
        if pivot is None:
            continue
        rows[done], rows[pivot] = rows[pivot], rows[done]
        inverse = _inverse(rows[done][column])
        for k in range(done + 1, len(rows)):
            if factor := rows[k][column] * inverse % PRIME:
                rows[k] = _less(rows[k], factor, rows[done])
        done += 1
    return [row[6:] for row in rows[done:]]


def _enter(basis: dict[int, list[int]], line: list[int]) -> None:
    """Add a line to a basis in echelon form if it is independent of it."""
    for column in range(len(line)):
        if not line[column]:
            continue
        if column not in basis:
            basis[column] = _times(_inverse(line[column]), line)
            return
        line = _less(line, line[column], basis[column])


def _less(row: list[int], factor: int, other: list[int]) -> list[int]:
    return [(x - factor * y) % PRIME for x, y in zip(row, other, strict=True)]
