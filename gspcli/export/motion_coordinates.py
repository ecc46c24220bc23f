"""Rigid motions in the coordinates in which systems are written, everything times N."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import field
from functools import cached_property

from gspcli.export.polynomials import Operand, Polynomial, cross, dot
from gspcli.records import dataclass

Vector = Sequence[Polynomial]
_AXES = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
#: The quaternion is q and not e: PHCpack reads e0 as a number.
QUATERNION = ("q0", "q1", "q2", "q3")
DUAL = ("f0", "f1", "f2", "f3")
ROTATION = tuple(f"r{i}{j}" for i in "123" for j in "123")
TRANSLATION = ("t1", "t2", "t3")
#: One more unknown, by which N is not zero: ``w N = 1``.
INVERSE = "w"


@dataclass(frozen=True)
class SymbolicMotion:
    """A rigid motion ``x -> R x + T``.

    Attributes
    ----------
    names
        The unknowns.
    N
        The polynomial by which all others are multiplied.
    R, T, U, rho
        N times the rotation, by rows, T, ``R^T T`` and ``T.T``.
    moment
        From a vector v to ``N (T x R v)``.
    relations
        What the unknowns satisfy, and with it N is not zero, each to be zero.
    """

    names: tuple[str, ...]
    N: Polynomial
    R: tuple[Vector, ...]
    T: Vector
    U: Vector
    rho: Polynomial
    moment: Callable[[Sequence[Operand]], Vector]
    relations: tuple[Polynomial, ...] = field(default=())

    @cached_property
    def columns(self) -> tuple[Vector, ...]:
        """The columns of N R."""
        return tuple(zip(*self.R, strict=True))

    def turned(self, v: Sequence[Operand]) -> Vector:
        """Return ``N R v``."""
        return [dot(row, v) for row in self.R]

    def turned_back(self, v: Sequence[Operand]) -> Vector:
        """Return ``N R^T v``."""
        return [dot(column, v) for column in self.columns]


def study() -> SymbolicMotion:
    """Return motions by unit dual quaternions q + f: N = 1, every pose twice."""
    return _dual_quaternions(_symbols(QUATERNION), _symbols(DUAL), (*QUATERNION, *DUAL), None)


def study_affine() -> SymbolicMotion:
    """Return motions by dual quaternions with q0 = 1: every pose but the half turns, once."""
    one = Polynomial.constant(1)
    e = [one, *_symbols(QUATERNION[1:])]
    names = (*QUATERNION[1:], *DUAL, INVERSE)
    return _dual_quaternions(e, _symbols(DUAL), names, Polynomial.symbol(INVERSE))


def rotation_translation() -> SymbolicMotion:
    """Return motions by the entries of R and T: N = 1, every pose once."""
    entries = _symbols(ROTATION)
    rows = (entries[:3], entries[3:6], entries[6:])
    T = _symbols(TRANSLATION)
    columns = tuple(zip(*rows, strict=True))
    # Two unit rows, perpendicular, and the third is their vector product.
    first, second, third = rows
    product = cross(first, second)
    relations = (
        dot(first, first) - 1,
        dot(second, second) - 1,
        dot(first, second),
        *(a - b for a, b in zip(third, product, strict=True)),
    )
    return SymbolicMotion(
        names=(*ROTATION, *TRANSLATION),
        N=Polynomial.constant(1),
        R=rows,
        T=T,
        U=[dot(column, T) for column in columns],
        rho=dot(T, T),
        moment=lambda v: cross(T, [dot(row, v) for row in rows]),
        relations=relations,
    )


#: The coordinates by the names that the command line gives them.
MOTIONS: dict[str, Callable[[], SymbolicMotion]] = {
    "study": study,
    "study-affine": study_affine,
    "rt": rotation_translation,
}


def _symbols(names: Sequence[str]) -> list[Polynomial]:
    return [Polynomial.symbol(name) for name in names]


def _dual_quaternions(
    e: Vector, f: Vector, names: tuple[str, ...], inverse: Polynomial | None
) -> SymbolicMotion:
    conjugate = [e[0], *(-x for x in e[1:])]
    dual = [f[0], *(-x for x in f[1:])]

    def sandwich(v: Sequence[Operand], left: Vector, right: Vector) -> Vector:
        return _product(_product(left, [Polynomial({}), *v]), right)[1:]

    def moment(v: Sequence[Operand]) -> Vector:
        pairs = zip(sandwich(v, e, dual), sandwich(v, f, conjugate), strict=True)
        return [a + b for a, b in pairs]

    N = dot(e, e)
    return SymbolicMotion(
        names=names,
        N=N if inverse is not None else Polynomial.constant(1),
        R=tuple(zip(*(sandwich(axis, e, conjugate) for axis in _AXES), strict=True)),
        T=[2 * x for x in _product(f, conjugate)[1:]],
        U=[2 * x for x in _product(conjugate, f)[1:]],
        rho=4 * dot(f, f),
        moment=moment,
        relations=(dot(e, f), (N if inverse is None else N * inverse) - 1),
    )


def _product(a: Sequence[Operand], b: Sequence[Operand]) -> list[Polynomial]:
    """Return the product of two quaternions."""
    outer = cross(a[1:], b[1:])
    scalar = dot(a[:1], b[:1]) - dot(a[1:], b[1:])
    pairs = zip(a[1:], b[1:], outer, strict=True)
    return [scalar, *(dot((a[0], p), (q, b[0])) + c for p, q, c in pairs)]
