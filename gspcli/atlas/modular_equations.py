"""Random platforms modulo a prime, as equations in Study coordinates.

A linear function of the motion is a list of 26 coefficients, those of 1, R (by rows), T, U, rho and
T x R in the order of `gspcli.certification.equations.study`, whose forms are N times these
functions. Integers represent their residue classes modulo the prime. No code is shared with the
equations of the path tracker or with `gspcli.geometry.constraint_polynomials`, so the two ways of
counting are independent.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from random import Random

from gspcli.catalogue.kinds import ALL, DHP, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.certification.equations import study
from gspcli.records import dataclass

Vector = Sequence[int]
#: Coefficients of 1, R, T, U, rho and T x R.
Function = list[int]

_ROTATION = tuple(k for row in study.ROTATION for k in row)
_MOMENT = tuple(k for row in study.MOMENT for k in row)
#: The functions that span each space of quadrics.
SPANS: dict[str, tuple[int, ...]] = {
    "a": (study.NORM, *_ROTATION),
    "p": (study.NORM, *_ROTATION, *study.TRANSLATION),
    "q": (study.NORM, *_ROTATION, *study.BODY),
    "l": (study.NORM, *_ROTATION, *_MOMENT),
    "s": (study.NORM, *_ROTATION, *study.TRANSLATION, *study.BODY, study.RHO),
}


@dataclass(frozen=True)
class ModularEquation:
    """``A = 0``, or ``A^2 + weight B^2 = square`` for a product of two conjugate quadrics.

    Attributes
    ----------
    first
        The function A.
    second
        The function B, or None.
    weight, square
        The numbers of the product.
    """

    first: Function
    second: Function | None = None
    weight: int = 0
    square: int = 0


@dataclass(frozen=True)
class FramedPrimitive:
    """A primitive: a point of it, and an orthonormal frame that begins with its direction."""

    point: Vector
    frame: tuple[Vector, Vector, Vector]


def equation(
    kind: Kind, platform: FramedPrimitive, base: FramedPrimitive, value: int, *, sides: int = 1
) -> ModularEquation:
    """Return the equation of a constraint (Section 4).

    Parameters
    ----------
    kind
        Its kind.
    platform, base
        The two primitives.
    value
        The distance, signed for DPH and DHP; for angles the value of ``R u . v``.
    sides
        1 for one side of a DPH or DHP, 2 for both.
    """
    y, (u, *around_u) = platform.point, platform.frame
    x, (v, *around_v) = base.point, base.frame
    square = value * value
    if not kind.is_distance:
        return ModularEquation(_function(one=-value, rotation=_outer(v, u)))
    if kind is DPP:
        one = _dot(x, x) + _dot(y, y) - square
        rotation = _outer([-2 * entry for entry in x], y)
        return ModularEquation(
            _function(one, rotation, [-2 * entry for entry in x], [2 * entry for entry in y], 1)
        )
    if kind is DPL:
        first, second = (_above_base(y, x, n) for n in around_v)
        return ModularEquation(first, second, 1, square)
    if kind is DLP:
        first, second = (_above_platform(y, x, n) for n in around_u)
        return ModularEquation(first, second, 1, square)
    if kind is DLL:
        cosine = _function(rotation=_outer(v, u))
        return ModularEquation(_mutual_moment(y, x, u, v), cosine, square, square)
    if kind not in (DPH, DHP):
        raise ValueError(kind)
    height = _above_base(y, x, v) if kind is DPH else _above_platform(y, x, u)
    if sides == 2:
        return ModularEquation(height, _function(), 0, square)
    height[study.NORM] -= value
    return ModularEquation(height)


def _above_base(y: Vector, x: Vector, n: Vector) -> Function:
    """Return ``n . (R y + T - x)``: how high the platform's point is over a base plane."""
    return _function(-_dot(n, x), _outer(n, y), n)


def _above_platform(y: Vector, x: Vector, n: Vector) -> Function:
    """Return ``R n . (x - R y - T)``: how high the base's point is over a platform plane."""
    return _function(-_dot(n, y), _outer(x, n), body=[-entry for entry in n])


def _mutual_moment(y: Vector, x: Vector, u: Vector, v: Vector) -> Function:
    """Return ``(R y + T - x) . (R u x v) = v.R(y x u) - (v x x).R u + v.(T x R u)``."""
    one, other = _outer(v, _cross(y, u)), _outer(_cross(v, x), u)
    rotation = [p - q for p, q in zip(one, other, strict=True)]
    return _function(rotation=rotation, moment=_outer(v, u))


def _function(
    one: int = 0,
    rotation: Sequence[int] = (0,) * 9,
    translation: Vector = (0,) * 3,
    body: Vector = (0,) * 3,
    rho: int = 0,
    moment: Sequence[int] = (0,) * 9,
) -> Function:
    return [one, *rotation, *translation, *body, rho, *moment]


def _dot(a: Vector, b: Vector) -> int:
    return sum(p * q for p, q in zip(a, b, strict=True))


def _cross(a: Vector, b: Vector) -> list[int]:
    return [a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)]


def _outer(a: Vector, b: Vector) -> list[int]:
    return [p * q for p in a for q in b]


def random_platform(
    distances: Sequence[Kind], angles: int, prime: int, random: Random, *, sides: int = 1
) -> list[ModularEquation]:
    """Return the equations of a random platform over the integers modulo a prime.

    Directions come from random quaternions, so that they and the frames about them have
    rational coordinates. The square of a distance is the square of a random number; the cosine
    of an angle is a random number; the angles are ALL.
    """

    def body() -> FramedPrimitive:
        return FramedPrimitive(
            [random.randrange(prime) for _ in range(3)], _random_frame(prime, random)
        )

    return [
        equation(kind, body(), body(), random.randrange(1, prime), sides=sides)
        for kind in [*distances, *[ALL] * angles]
    ]


def _random_frame(prime: int, random: Random) -> tuple[Vector, Vector, Vector]:
    while True:
        norm, rotation, _ = study.motion([random.randrange(prime) for _ in range(4)] + [0] * 4)
        if norm % prime:
            inverse = pow(norm, -1, prime)
            a, b, c = ([entry * inverse % prime for entry in row] for row in rotation)
            return a, b, c


def random_quadrics(spaces: str, prime: int, random: Random) -> list[ModularEquation]:
    """Return random members of spaces of quadrics over the integers modulo a prime."""
    equations = []
    for letter in spaces:
        function = _function()
        for index in SPANS[letter]:
            function[index] = random.randrange(prime)
        equations.append(ModularEquation(function))
    return equations


@cache
def quadrics() -> tuple[dict[tuple[int, ...], int], ...]:
    """Return N times each of the 26 functions, and e.f last, as polynomials in (e, f).

    A polynomial maps the indices of the two factors of a monomial, in rising order, to its
    coefficient, an integer.
    """
    rows = study.form_hessians().astype(int).ravel().tolist()
    found: list[dict[tuple[int, ...], int]] = []
    for start in range(0, len(rows), 64):
        hessian = rows[start : start + 64]
        polynomial: dict[tuple[int, ...], int] = {}
        for i in range(8):
            for j in range(i, 8):
                coefficient = hessian[8 * i + j] // (2 if i == j else 1)
                if coefficient:
                    polynomial[(i, j)] = coefficient
        found.append(polynomial)
    return tuple(found)
