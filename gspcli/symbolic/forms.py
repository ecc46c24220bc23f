"""Multilinear forms in the vectors of a platform, written in coordinates of rigid motions.

A vector belongs to the platform (and is carried by R), to the base, or is the translation T. Inner
and triple products of such vectors are expanded by linearity into *atoms*, each linear in one block
of coordinates, because R preserves inner and triple products::

    dot(x, y)   x·y               R(x, y)    x·Ry               T(x)   x·T
    U(y)        T·Ry = y·U        TxR(x, y)  x·(T×Ry)           rho    T·T

The atoms are SymPy applied functions of the names of vectors.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from functools import cache

import sympy
from sympy import Expr, Function, Symbol

from gspcli.records import dataclass
from gspcli.symbolic.coordinate_systems import SYMBOLS


class VectorFrame(Enum):
    """Where a vector belongs."""

    TRANSLATION = 0
    PLATFORM = 1
    BASE = 2


@dataclass(frozen=True)
class Vector:
    """A vector by its name, a symbol or a cross product of two.

    Attributes
    ----------
    name
        The name.
    frame
        Where it belongs.
    """

    name: Expr
    frame: VectorFrame


@dataclass(frozen=True)
class Sum:
    """A linear combination of vectors: pairs (coefficient, vector)."""

    terms: tuple[tuple[Expr, Vector], ...]


cross = Function("cross")
dot = Function("dot")
on_rotation = Function("R")
on_translation = Function("T")
on_pullback = Function("U")
on_moment = Function("TxR")
#: The atom T·T.
RHO: Symbol = SYMBOLS["rho"][0]
#: The translation as a vector.
TRANSLATION = Vector(Symbol("T"), VectorFrame.TRANSLATION)
_ATOMS = (on_rotation, on_translation, on_pullback, on_moment)


def platform(name: str) -> Vector:
    """Return a vector of the platform."""
    return Vector(Symbol(name), VectorFrame.PLATFORM)


def base(name: str) -> Vector:
    """Return a vector of the base."""
    return Vector(Symbol(name), VectorFrame.BASE)


def units(frame: VectorFrame) -> tuple[Vector, ...]:
    """Return the three unit vectors of the axes of a frame."""
    return tuple(Vector(Symbol(f"e{k}"), frame) for k in (1, 2, 3))


def _terms(vector: Vector | Sum) -> tuple[tuple[Expr, Vector], ...]:
    return vector.terms if isinstance(vector, Sum) else ((sympy.Integer(1), vector),)


def inner(a: Vector | Sum, b: Vector | Sum) -> Expr:
    """Return the inner product of two vectors in the base frame, in atoms."""
    return sympy.Add(*(s * t * _inner(x, y) for s, x in _terms(a) for t, y in _terms(b)))


def _inner(a: Vector, b: Vector) -> Expr:
    x, y = sorted((a, b), key=lambda vector: (vector.frame.value, str(vector.name)))
    match x.frame, y.frame:
        case VectorFrame.TRANSLATION, VectorFrame.TRANSLATION:
            return RHO
        case VectorFrame.TRANSLATION, VectorFrame.PLATFORM:
            return on_pullback(y.name)
        case VectorFrame.TRANSLATION, VectorFrame.BASE:
            return on_translation(y.name)
        case VectorFrame.PLATFORM, VectorFrame.BASE:
            return on_rotation(y.name, x.name)
        case _:
            return dot(x.name, y.name)


def triple(a: Vector | Sum, b: Vector, c: Vector) -> Expr:
    """Return det(a, b, c) in the base frame, in atoms; only `a` may contain T."""
    return sympy.Add(*(s * _triple(x, b, c) for s, x in _terms(a)))


def _triple(*vectors: Vector) -> Expr:
    order = sorted(range(3), key=lambda k: (vectors[k].frame.value, k))
    sign = sympy.LeviCivita(*order)
    x, y, z = (vectors[k] for k in order)
    if y.frame is z.frame:
        # x · (y × z), and a cross product of two vectors of a body is a vector of that body
        return sign * _inner(x, Vector(cross(y.name, z.name), z.frame))
    if x.frame is y.frame:
        return sign * _inner(Vector(cross(x.name, y.name), x.frame), z)
    return sign * on_moment(z.name, y.name)


def degree(form: Expr, weights: Mapping[str, int]) -> int | None:
    """Return the total degree of a polynomial in atoms.

    Parameters
    ----------
    form
        The polynomial.
    weights
        The degree of each block of coordinates, such as `CoordinateSystem.degrees`.

    Returns
    -------
    int or None
        None if a block occurs that has no weight.
    """
    monomials = _monomials(form)
    if not {block for monomial in monomials for block, _ in monomial} <= set(weights):
        return None
    return max(
        sum(weights[block] * exponent for block, exponent in monomial) for monomial in monomials
    )


@cache
def _monomials(form: Expr) -> frozenset[tuple[tuple[str, int], ...]]:
    """Return the monomials of a form, as exponents of the blocks of their atoms."""
    atoms = {atom: atom.func.__name__ for atom in form.atoms(*_ATOMS)}
    if form.has(RHO):
        atoms[RHO] = "rho"
    if not atoms:
        return frozenset({()})
    polynomial = sympy.Poly(form, *atoms)
    return frozenset(
        tuple((block, n) for block, n in zip(atoms.values(), exponents, strict=True) if n)
        for exponents in polynomial.monoms()
    )
