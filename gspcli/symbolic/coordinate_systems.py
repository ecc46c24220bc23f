"""Sets of coordinates for rigid motions: Lazard's, Mourrain's and their smaller relatives.

A set of coordinates is a choice of *blocks*, each a vector or matrix function of the motion
``x_base = R x_platform + T``: R itself (nine entries), T, ``U = RᵀT``, ``ρ = T·T`` and
``T×R``, the matrix whose columns are T × R_k, that is Mourrain's (i,j|k,4) up to sign and order
(Section 3, equations (1), (3) and (4)).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, cached_property
from math import comb
from random import Random
from typing import Any

import sympy
from sympy import Matrix, Symbol

from gspcli.records import dataclass
from gspcli.symbolic.rational_motions import (
    RationalMotion,
    Residues,
    monomials,
    random_motion,
    rank,
    residues,
)

#: The blocks in the order in which they are listed.
BLOCKS = ("R", "T", "U", "rho", "TxR")


def _entries(name: str, rows: int, columns: int) -> Matrix:
    def index(i: int, j: int) -> str:
        return f"{i + 1}{j + 1}" if columns > 1 else (f"{i + 1}" if rows > 1 else "")

    return Matrix(rows, columns, lambda i, j: Symbol(name + index(i, j)))


#: The symbols of each block.
SYMBOLS: dict[str, Matrix] = {
    "R": _entries("r", 3, 3),
    "T": _entries("t", 3, 1),
    "U": _entries("u", 3, 1),
    "rho": _entries("rho", 1, 1),
    "TxR": _entries("w", 3, 3),
}


def skew(vector: Matrix) -> Matrix:
    """Return the matrix [x] with ``[x] y = x × y``."""
    x, y, z = vector
    return Matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def axial(matrix: Matrix) -> Matrix:
    """Return the vector x of a matrix [x] = `skew` (x)."""
    return Matrix([matrix[2, 1], matrix[0, 2], matrix[1, 0]])


#: Every way to express one block by R and another block; each is an identity on the motions.
EXPRESSIONS: dict[str, dict[str, Callable[[Matrix, Matrix], Matrix]]] = {
    "T": {
        "U": lambda r, u: r * u,
        "TxR": lambda r, w: axial(w * r.T),
    },
    "U": {
        "T": lambda r, t: r.T * t,
        "TxR": lambda r, w: axial(r.T * w),
    },
    "rho": {
        "T": lambda _, t: t.T * t,
        "U": lambda _, u: u.T * u,
        "TxR": lambda _, w: Matrix([(w.T * w).trace() / 2]),
    },
    "TxR": {
        "T": lambda r, t: skew(t) * r,
        "U": lambda r, u: r * skew(u),
    },
}


@dataclass(frozen=True)
class CoordinateSystem:
    """A choice of blocks as coordinates of the rigid motions.

    Attributes
    ----------
    blocks
        The chosen blocks in the order of `BLOCKS`; the first is always R.
    """

    blocks: tuple[str, ...]

    @property
    def name(self) -> str:
        """The name in the data files, such as ``R,T,U``."""
        return ",".join(self.blocks)

    @cached_property
    def symbols(self) -> tuple[Symbol, ...]:
        """The coordinates, block by block, each block row by row."""
        return tuple(entry for block in self.blocks for entry in SYMBOLS[block])

    @cached_property
    def expressions(self) -> dict[str, Matrix]:
        """Every block that these coordinates determine, as polynomials in them."""
        found = {block: SYMBOLS[block] for block in self.blocks}
        for block, ways in EXPRESSIONS.items():
            if block not in found:
                usable = (other for other in ways if other in self.blocks)
                for other in usable:
                    found[block] = ways[other](SYMBOLS["R"], SYMBOLS[other])
                    break
        return found

    @cached_property
    def degrees(self) -> dict[str, int]:
        """The degree in these coordinates of each block that they determine."""
        return {
            block: max(sympy.Poly(entry, *self.symbols).total_degree() for entry in matrix)
            for block, matrix in self.expressions.items()
        }

    def __str__(self) -> str:
        return self.name


def system(name: str) -> CoordinateSystem:
    """Return the coordinates of the given name, such as ``R,T,U``."""
    return CoordinateSystem(tuple(name.split(",")))


ROTATIONS = system("R")
MOTIONS = system("R,T")
#: Lazard's coordinates, R¹⁵ (Section 3, equation (1)).
LAZARD = system("R,T,U")
#: Mourrain's first coordinates, R¹⁶ (Section 3, equation (3)).
MOURRAIN_16 = system("R,T,U,rho")
#: Mourrain's coordinates, R²⁵ (Section 3, equation (4)).
MOURRAIN = system("R,T,U,rho,TxR")

#: The sets in which some constraint can be of lower degree than in all smaller ones.
SYSTEMS: tuple[CoordinateSystem, ...] = (
    ROTATIONS,
    MOTIONS,
    system("R,U"),
    LAZARD,
    MOURRAIN_16,
    system("R,TxR"),
    system("R,T,TxR"),
    system("R,U,TxR"),
    system("R,T,U,TxR"),
    MOURRAIN,
)


@cache
def _evaluator(coordinates: CoordinateSystem) -> Any:
    blocks = MOTIONS.expressions
    entries = [entry for block in coordinates.blocks for entry in blocks[block]]
    return sympy.lambdify(MOTIONS.symbols, entries, modules=[{}], cse=True)


def coordinates_at(coordinates: CoordinateSystem, motions: Sequence[RationalMotion]) -> Residues:
    """Return the coordinates of exact motions modulo `PRIME`, shape (motions, coordinates)."""
    evaluate = _evaluator(coordinates)
    return residues([evaluate(*m.rotation.flat, *m.translation) for m in motions])


def hilbert_function(numerator: Sequence[int], dimension: int, degree: int) -> int:
    """Return the dimension of the polynomials up to a degree restricted to a variety.

    Parameters
    ----------
    numerator
        Coefficients of h in the Hilbert series h(t) / (1 - t)^(dimension + 1) of the
        projective closure.
    dimension
        Dimension of the variety.
    degree
        The highest total degree of the polynomials.
    """
    terms = (
        coefficient * comb(degree - power + dimension, dimension)
        for power, coefficient in enumerate(numerator[: degree + 1])
    )
    return sum(terms)


def sampled_hilbert_function(coordinates: CoordinateSystem, degree: int, points: int) -> int:
    """Return the rank of all monomials up to a degree at random rational motions.

    It is a proved lower bound of the Hilbert function (a rank modulo a prime, at points of the
    variety), and equal to it for random motions as soon as `points` exceeds it.
    """
    random = Random(0)
    motions = [random_motion(random) for _ in range(points)]
    return rank(monomials(coordinates_at(coordinates, motions), degree))
