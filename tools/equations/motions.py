"""The equations of the motions in sets of coordinates, and forms with numbers in them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
import sympy
from sympy import Expr, Matrix, eye

from gspcli.symbolic.exact_motions import RationalMotion
from tools.equations.constraint_equations import (
    EXPRESSIONS,
    MOTIONS,
    RHO,
    SYMBOLS,
    CoordinateSystem,
    cross,
    dot,
    on_moment,
    on_pullback,
    on_rotation,
    on_translation,
)


def equations(coordinates: CoordinateSystem) -> tuple[Expr, ...]:
    """Return integer polynomials that generate the ideal of the motions in these coordinates."""
    r = SYMBOLS["R"]
    matrices = [r.T * r - eye(3), r * r.T - eye(3), r - cofactors(r)]
    for block, ways in EXPRESSIONS.items():
        if block in coordinates.blocks:
            matrices += [
                SYMBOLS[block] - way(r, SYMBOLS[other])
                for other, way in ways.items()
                if other in coordinates.blocks
            ]
    if "TxR" in coordinates.blocks:
        w = SYMBOLS["TxR"]
        # (T×R) Rᵀ = [T] and Rᵀ (T×R) = [U] are skew.
        matrices += [r * w.T + w * r.T, r.T * w + w.T * r]
    expanded = (sympy.expand(entry).primitive()[1] for matrix in matrices for entry in matrix)
    # The symmetric matrices hold some equations twice.
    return tuple(dict.fromkeys(entry for entry in expanded if entry != 0))


def motion_blocks(rotation: Matrix, translation: Matrix) -> dict[str, Matrix]:
    """Return the value of every block at the motion (R, T)."""
    return {
        "R": rotation,
        "T": translation,
        **{block: EXPRESSIONS[block]["T"](rotation, translation) for block in ("U", "rho", "TxR")},
    }


def motion_variables(motion: RationalMotion) -> dict[sympy.Symbol, sympy.Rational]:
    """Return the exact values of the coordinates (R, T), to substitute for the symbols."""
    values = np.concatenate([motion.rotation.ravel(), motion.translation])
    return {
        symbol: sympy.Rational(value.numerator, value.denominator)
        for symbol, value in zip(MOTIONS.symbols, values, strict=True)
    }


def cofactors(matrix: Matrix) -> Matrix:
    """Return the matrix of cofactors of a 3 × 3 matrix (a rotation equals its own)."""
    return Matrix.hstack(*(matrix[:, (k + 1) % 3].cross(matrix[:, (k + 2) % 3]) for k in range(3)))


def evaluate(form: Expr, vectors: Mapping[str, Any], blocks: Mapping[str, Any]) -> Expr:
    """Return a form with its atoms replaced by components.

    Parameters
    ----------
    form
        A polynomial in atoms.
    vectors
        The components of each named vector, matrices of shape (3, 1).
    blocks
        The blocks of coordinates, as by `motion_blocks` or `CoordinateSystem.expressions`.
    """
    known = dict(vectors) | dict(zip(("e1", "e2", "e3"), _unit_columns(), strict=True))

    def vector(name: Expr) -> Any:
        if name.func == cross:
            return vector(name.args[0]).cross(vector(name.args[1]))
        return known[str(name)]

    def pairing(block: str) -> Callable[[Expr, Expr], Expr]:
        return lambda x, y: (vector(x).T * blocks[block] * vector(y))[0]

    replacements: list[tuple[Any, Callable[..., Expr]]] = [
        (dot, lambda x, y: vector(x).dot(vector(y))),
        (on_rotation, pairing("R")),
        (on_moment, pairing("TxR")),
        (on_translation, lambda x: vector(x).dot(blocks["T"])),
        (on_pullback, lambda y: vector(y).dot(blocks["U"])),
    ]
    values = {RHO: blocks["rho"][0]} if form.has(RHO) else {}
    for head, value in replacements:
        values |= {atom: value(*atom.args) for atom in form.atoms(head)}
    return form.xreplace(values)


def _unit_columns() -> Iterable[Any]:
    identity = sympy.eye(3)
    return (identity[:, k] for k in range(3))
