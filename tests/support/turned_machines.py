"""Special machines in turned frames: each exact coincidence is one of 1e-16, 1e-9 or 1e-6.

    python -m tests.support.turned_machines write     # all answers, one line each, to the record
    python -m tests.support.turned_machines compare   # with the record: none less complete

The base and the platform are drawn in their own frames, where something is special: rods are
parallel, points are on a line, plates are congruent. Both bodies are turned and moved at random,
coordinates are rounded, and the values are those of a random pose.
"""

from __future__ import annotations

import csv
import math
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import mpmath
import numpy as np
from numpy.typing import NDArray

from gspcli.catalogue.kinds import DHP, DPH, DPL, DPP, Kind
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side, Units
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Line, Plane, Point
from gspcli.solver import solve
from gspcli.solver.solved_starts import SolvedStarts

Array = NDArray[np.float64]
#: Kinds, points y of the platform and x of the base, their directions u and v; shapes (6, 3).
Drawn = tuple[Sequence[Kind], Array, Array, Array, Array]

RECORD = Path(__file__).parents[1] / "oracles" / "records" / "turned-machines.csv"
#: Machines of each sort with each rounding, and of those with rods, which take long; decimals, None
#: for doubles.
EACH, FEW, DECIMALS = 8, 2, (None, 9, 6)
WITH_RODS = ("three rods", "two rods", "points on a line at rods", "one axis")
_UNITS = Units("unit", AngleUnit.RADIAN)


def _points(rng: np.random.Generator) -> Array:
    return rng.uniform(-1, 1, (6, 3))


# Machines have the same digits on every processor: products of entries are added one by one, and
# sines are those of mpmath. NumPy's products of matrices, norms and sines differ in the last digit.


def _dot(a: Array, b: Array) -> Array:
    """Return the products of rows, shape (n, 3) each, added from left to right."""
    return np.asarray(a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2])


def _length(rows: Array) -> Array:
    return np.asarray(np.sqrt(_dot(rows, rows)))


def _turned(R: Array, rows: Array) -> Array:
    """Return R x for the rows x."""
    return np.stack([_dot(rows, row) for row in R], axis=1)


def _directions(rng: np.random.Generator) -> Array:
    rows = rng.normal(size=(6, 3))
    return np.asarray(rows / _length(rows)[:, None])


def _ring(angles: Sequence[float]) -> Array:
    turns = [mpmath.radians(mpmath.mpf(float(angle))) for angle in angles]
    return np.array([[float(mpmath.cos(t)), float(mpmath.sin(t)), 0.0] for t in turns])


def _rods(count: int, rng: np.random.Generator) -> Drawn:
    """Points on parallel guide rods of the base."""
    v = _directions(rng)
    v[:count] = v[0]
    return [DPL] * count + [DPP] * (6 - count), _points(rng), _points(rng), _directions(rng), v


def _on_a_line(count: int, rng: np.random.Generator) -> Drawn:
    y = _points(rng)
    y[:count] = y[0] + rng.uniform(-1, 1, (count, 1)) * _directions(rng)[0]
    return [DPP] * 6, y, _points(rng), _directions(rng), _directions(rng)


def _on_a_line_at_rods(rng: np.random.Generator) -> Drawn:
    """Four points of the platform on a line, at distances from lines of the base."""
    _, y, x, u, v = _on_a_line(4, rng)
    return [DPL] * 4 + [DPP] * 2, y, x, u, v


def _on_lines_of_both(rng: np.random.Generator) -> Drawn:
    """Three points of each body on a line, those of other legs."""
    kinds, y, x, u, v = _on_a_line(3, rng)
    x[3:] = x[3] + rng.uniform(-1, 1, (3, 1)) * _directions(rng)[0]
    return kinds, y, x, u, v


def _congruent(rng: np.random.Generator) -> Drawn:
    y = _points(rng)
    return [DPP] * 6, y, y.copy(), _directions(rng), _directions(rng)


def _similar(rng: np.random.Generator) -> Drawn:
    """Similar planar plates, the corners in another order."""
    y = _points(rng)
    y[:, 2] = 0
    return [DPP] * 6, 0.6 * y, y[[1, 2, 3, 4, 5, 0]], _directions(rng), _directions(rng)


def _planar(rng: np.random.Generator) -> Drawn:
    y, x = _points(rng), _points(rng)
    y[:, 2] = x[:, 2] = 0
    return [DPP] * 6, y, x, _directions(rng), _directions(rng)


def _hexagonal(rng: np.random.Generator) -> Drawn:
    """Hexagons with threefold symmetry."""
    half, other = rng.uniform(5, 25, 2)
    x = _ring([120 * k + s * half for k in range(3) for s in (1, -1)])
    y = 0.6 * _ring([120 * k + s * (60 - other) for k in range(3) for s in (1, -1)])
    return [DPP] * 6, y, x, _directions(rng), _directions(rng)


def _parallel_planes(rng: np.random.Generator) -> Drawn:
    v = _directions(rng)
    v[:3] = v[0]
    kinds = [DPH, DPH, DPH, DPP, DPP, DPP]
    return kinds, _points(rng), _points(rng), _directions(rng), v


def _fixture(rng: np.random.Generator) -> Drawn:
    """Three supports, two side locators, one end stop."""
    y = _points(rng)
    v = np.array([[0, 0, 1.0]] * 3 + [[0, 1, 0]] * 2 + [[1, 0, 0]])
    return [DPH] * 6, y, y - 0.1 * v, _directions(rng), v


def _lines_that_meet(rng: np.random.Generator) -> Drawn:
    """Three guide rods of the base through one point."""
    kinds, y, x, u, v = _rods(3, rng)
    v, x[:3] = _directions(rng), x[0]
    return kinds, y, x + np.pad(v[:3], ((0, 3), (0, 0))), u, v


def _equal_distances(rng: np.random.Generator) -> Drawn:
    """Three points of the platform, corners of a cube, at distances from one of the base."""
    y, x = _points(rng), _points(rng)
    x[:3], y[:3] = x[0], 0.5 * np.eye(3)
    return [DPP] * 6, y, x, _directions(rng), _directions(rng)


def _one_axis(rng: np.random.Generator) -> Drawn:
    """Two guide rods of the base that are one line, and a plane of the platform along it."""
    _, y, x, u, v = _rods(2, rng)
    x[1] = x[0] + rng.uniform(0.5, 1) * v[0]
    return [DPL, DPL, DHP, DPP, DPP, DPP], y, x, u, v


SORTS: dict[str, Callable[[np.random.Generator], Drawn]] = {
    "three rods": lambda rng: _rods(3, rng),
    "two rods": lambda rng: _rods(2, rng),
    "four points on a line": lambda rng: _on_a_line(4, rng),
    "points on a line at rods": _on_a_line_at_rods,
    "lines of both": _on_lines_of_both,
    "congruent": _congruent,
    "similar": _similar,
    "planar": _planar,
    "hexagonal": _hexagonal,
    "parallel planes": _parallel_planes,
    "fixture": _fixture,
    "lines that meet": _lines_that_meet,
    "equal distances": _equal_distances,
    "one axis": _one_axis,
}


def _numbers(row: Array, decimals: int | None) -> list[Number]:
    rounded = row if decimals is None else row.round(decimals)
    return [Number.of(repr(float(x) + 0.0)) for x in rounded.tolist()]


def _direction(place: Array, along: Array, decimals: int | None) -> list[Number]:
    """Return the direction of a line through two rounded points, as a drawing states it."""
    ends = (place + along, place)
    first, second = ends if decimals is None else (end.round(decimals) for end in ends)
    return _numbers(first - second, None if decimals is None else decimals + 1)


def _turn(rng: np.random.Generator) -> Array:
    w, x, y, z = rng.normal(size=4).tolist()
    length = math.sqrt(w * w + x * x + y * y + z * z)
    w, x, y, z = w / length, x / length, y / length, z / length
    return np.array(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    )


def _value(kind: Kind, across: Array, w: Array, v: Array) -> float:
    """Return a distance from the vector between two places and the directions w and v there."""
    if kind is DPP:
        return float(_length(across))
    if kind is DPL:
        (a, b, c), (d, e, f) = across.tolist(), v.tolist()
        normal = np.array([b * f - c * e, c * d - a * f, a * e - b * d])
        return float(_length(normal) / _length(v))
    if kind is DHP:
        return float(-_dot(across, w) / _length(w))
    return float(_dot(across, v) / _length(v))


def machine(name: str) -> Instance:
    """Return the machine of a name, such as ``two rods/9/3``."""
    sort, written, number = name.split("/")
    decimals = None if written == "doubles" else int(written)
    rng = np.random.default_rng([list(SORTS).index(sort), int(number)])
    kinds, y, x, u, v = SORTS[sort](rng)
    (P, Q), (s, t) = (_turn(rng), _turn(rng)), rng.uniform(-1, 1, (2, 3))
    y, u, x, v = _turned(P, y) + s, _turned(P, u), _turned(Q, x) + t, _turned(Q, v)
    R, T = _turn(rng), rng.uniform(-1, 1, 3)
    constraints = []
    for i, kind in enumerate(kinds):
        a, b = _numbers(y[i], decimals), _numbers(x[i], decimals)
        c, d = _direction(y[i], u[i], decimals), _direction(x[i], v[i], decimals)
        at, w = _turned(R, np.array([list(map(float, a)), list(map(float, c))]))
        value = _value(
            kind, at + T - np.array(list(map(float, b))), w, np.array(list(map(float, d)))
        )
        platform = Plane(a, c) if kind is DHP else Point(a)
        base = Point(b) if kind in (DPP, DHP) else (Line if kind is DPL else Plane)(b, d)
        side = (Side.NEGATIVE if value < 0 else Side.POSITIVE) if kind.has_sides else Side.BOTH
        (number,) = _numbers(np.array([abs(value)]), decimals)
        constraints.append(Constraint(kind, platform, base, number, side))
    return Instance(tuple(constraints), _UNITS)


def names() -> Iterator[str]:
    """Yield the names of all machines."""
    for sort in SORTS:
        for decimals in DECIMALS:
            for number in range(FEW if sort in WITH_RODS else EACH):
                yield f"{sort}/{'doubles' if decimals is None else decimals}/{number}"


def answer(name: str) -> dict[str, str]:
    """Return what a solution says, as a row of the record."""
    result = solve(machine(name), starts=SolvedStarts())
    proved = "proved" if result.proof is not None else "not proved"
    return {
        "name": name,
        "verdict": result.verdict,
        "poses": str(result.counts.found),
        "real": str(result.counts.real),
        "proof": proved,
    }


def recorded() -> dict[str, dict[str, str]]:
    """Return the rows of the record by name: the answers of the version that wrote it."""
    with RECORD.open(newline="") as lines:
        return {row["name"]: row for row in csv.DictReader(lines)}


def is_as_complete(now: dict[str, str], before: dict[str, str]) -> bool:
    """Whether an answer says as much as the recorded one; wrong answers are never as complete."""
    if before["verdict"] == "not in 20 s":
        return True
    if before["verdict"] == "complete" or now["verdict"] == before["verdict"]:
        return now == before
    return now["verdict"] == "complete"


def main(arguments: Sequence[str]) -> int:
    """Write the record, or compare answers with it; return the exit code."""
    chosen = [name for name in names() if all(text in name for text in arguments[1:])]
    known = recorded() if arguments[0] == "compare" else {}
    rows, worse, slow = [], 0, []
    for name in chosen:
        begin = time.process_time()
        row = answer(name)
        took = time.process_time() - begin
        rows.append(row)
        slow.append((took, name))
        if known and not is_as_complete(row, known[name]):
            worse += 1
            print("less than recorded:", row, known[name], flush=True)
    times = sorted(slow)
    print(f"{len(rows)} machines, {worse} less complete, median {times[len(times) // 2][0]:.3f} s")
    print("slowest:", *(f"{name} {took:.1f} s" for took, name in times[-5:]))
    if not known:
        with RECORD.open("w", newline="") as file:
            writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
    return int(worse > 0)


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
