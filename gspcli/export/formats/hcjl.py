"""HomotopyContinuation.jl: homotopies in Julia."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gspcli.export.format import SystemFormat
from gspcli.export.polynomials import Style

if TYPE_CHECKING:
    from gspcli.export.polynomial_systems import PolynomialSystem


def write(system: PolynomialSystem, digits: int) -> str:
    """Return a script for Julia with HomotopyContinuation.jl."""
    del digits
    style = Style(quotient="//")
    rows = ",\n".join(style.written(row.terms) for row in system.polynomials)
    constants = "".join(
        f"{name} = {number.value!r} # {number}\n" for name, number in system.constants.items()
    )
    return (
        f"# {system.title}\n"
        "using HomotopyContinuation\n"
        f"@var {' '.join(system.names)}\n"
        f"{constants}"
        f"F = System([\n{rows}\n], variables = [{', '.join(system.names)}])\n"
        "found = solutions(solve(F))\n"
        f'println("{system.heading}")\n'
        "for s in found\n"
        '    println(join(["$(real(z)),$(imag(z))" for z in s], ","))\n'
        "end\n"
    )


FORMAT = SystemFormat(write, "doubles")
