"""The platforms that are timed: random ones with short exact numbers, and Dietmaier's.

The peers that take exact input get the same problem as the others, in the form that suits them. So
directions are integer vectors of integer length, and angles have short cosines: every equation then
has short rational coefficients. (With instances as `gsp new` makes them the equations of planes
have square roots in them, to be replaced by rationals of 16 digits.)
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from itertools import product
from math import gcd, isqrt

import numpy as np

from gspcli.catalogue.kinds import AHH, ALL, Primitive
from gspcli.catalogue.names import parse_type
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side, Units
from gspcli.geometry.measurement import measured
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Geometry, Line, Plane, Point, vector
from gspcli.geometry.quaternions import rotation_from_quaternion
from gspcli.resources import data_path
from gspcli.spec import load

DIGITS = 3
_LONGEST = 21
#: A distance or cosine of less than this rounds to something special: draw again.
_SMALL = 0.05


@dataclass(frozen=True)
class Case:
    """A type of platform to be timed."""

    key: str
    type_text: str
    instances: int
    """How many random instances a full run solves with the peers."""
    path: str = ""
    """The example file that is the one instance, instead of random ones."""
    split: bool = False
    """Whether phc's blackbox does better with products split (`homotopy.split_system`)."""
    planar: bool = False
    """Whether the points of each body are in one plane, z = 0."""
    wanted: float = 10.0
    """How many times quicker than the quickest peer certified solutions are to be."""
    beyond: tuple[str, ...] = ()
    """The peers that are not even tried, because the case is far beyond what they can do."""

    def draw(self, seed: int, count: int) -> list[Instance]:
        """Return instances: `count` random ones, or the one of the file."""
        if self.path:
            return [load(str(data_path("examples", self.path)))]
        drawn = random_instances(self.type_text, seed, planar=self.planar)
        return [next(drawn) for _ in range(count)]


CASES = (
    Case("6-6", "6PP", 5, wanted=5),
    Case("planar 6-6", "6PP", 5, planar=True, wanted=2),
    Case("Dietmaier", "6PP", 1, "dietmaier.yaml", wanted=5),
    Case("6PH", "6PH", 5),
    Case("3PH+3HP", "3PH 3HP", 5),
    Case("3D3A PL PL LP", "PL PL LP 3ALL", 3, split=True),
    Case("5PP+PL", "5PP PL", 3),
    Case("6PL", "6PL", 1),
    Case("6LL", "6DLL", 1, beyond=("msolve", "phc -b")),
)


def random_instances(
    type_text: str, seed: int, *, one_sided: bool = True, planar: bool = False
) -> Iterator[Instance]:
    """Yield random instances of a type, their values measured at a pose and rounded."""
    kinds = parse_type(type_text).kinds
    rng = np.random.default_rng(seed)
    while True:
        # Each once, so that nothing is parallel.
        directions = iter(rng.permutation(_integer_directions()).tolist())
        rows = tuple(
            Constraint(
                kind,
                _primitive(kind.platform, rng, directions, planar=planar),
                _primitive(kind.base, rng, directions, planar=planar),
                Number.of(0),
                platform_name=f"{kind.platform.value}{i}",
                base_name=f"{kind.base.value}{i}",
            )
            for i, kind in enumerate(kinds, start=1)
        )
        draft = Instance(rows, Units("unit", AngleUnit.RADIAN), name=f"{type_text}, seed {seed}")
        instance = _with_values(draft, rng, one_sided)
        if instance is not None:
            yield instance


def _with_values(draft: Instance, rng: np.random.Generator, one_sided: bool) -> Instance | None:
    R, T = rotation_from_quaternion(rng.normal(size=4)), rng.uniform(-1, 1, size=3)
    rows = []
    for row, value in zip(draft.constraints, measured(Arrangement.of(draft), R, T), strict=True):
        if row.kind.is_distance:
            stated = abs(value)
            number, side = Number.of(_decimal(stated)), Side.BOTH
            if row.kind.has_sides and one_sided:
                side = Side.POSITIVE if value > 0 else Side.NEGATIVE
        else:
            cosine = row.kind in (ALL, AHH)
            stated = np.cos(value) if cosine else np.sin(value)
            number = Number("acos" if cosine else "asin", (Number.of(_decimal(stated)),))
            side = Side.BOTH
        if abs(stated) < _SMALL:
            return None
        rows.append(replace(row, value=number, side=side))
    return replace(draft, constraints=tuple(rows))


def _primitive(
    primitive: Primitive, rng: np.random.Generator, directions: Iterator[list[int]], *, planar: bool
) -> Geometry:
    position = vector(*(_decimal(x) for x in rng.uniform(-1, 1, size=3) * (1, 1, not planar)))
    if primitive is Primitive.POINT:
        return Point(position)
    direction = vector(*next(directions))
    return Line(position, direction) if primitive is Primitive.LINE else Plane(position, direction)


def _decimal(value: float) -> Fraction:
    return Fraction(f"{value:.{DIGITS}f}")


@cache
def _integer_directions() -> list[tuple[int, int, int]]:
    """Return the shortest integer vectors, up to sign and scale, whose length is an integer."""
    found = []
    for a, b, c in product(range(-_LONGEST, _LONGEST + 1), repeat=3):
        square = a * a + b * b + c * c
        integer = isqrt(square) ** 2 == square <= _LONGEST**2
        if integer and a > 0 and b and c and gcd(a, b, c) == 1:
            found.append((a, b, c))
    return found
