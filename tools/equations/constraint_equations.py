"""The constraint equations of the ten kinds, derived from the definition of distance and angle.

The distance of two primitives is the least distance of a point of one from a point of the other
(paper, Section 4). With ``w = R p + T − q`` from a point of the base primitive to one of the
platform primitive, and their directions d_i, it is the minimum of ``|w + Σ λ_i d_i|²``, a quotient
of Gram determinants (`squared_distance`). Everything else here follows from that quotient: nothing
of it is in the package, whose quadrics are those of `gspcli.geometry.study`.

Names: on the platform the point Y, the line (B, v) and the plane (B, normal v); on the base X,
(A, u) and (A, normal u); v and u are unit vectors.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import Enum
from functools import cache, cached_property

import sympy
from sympy import Expr, Function, Matrix, Symbol

from gspcli.catalogue.kinds import Kind, Primitive
from gspcli.records import dataclass

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
    "T": {"U": lambda r, u: r * u, "TxR": lambda r, w: axial(w * r.T)},
    "U": {"T": lambda r, t: r.T * t, "TxR": lambda r, w: axial(r.T * w)},
    "rho": {
        "T": lambda _, t: t.T * t,
        "U": lambda _, u: u.T * u,
        "TxR": lambda _, w: Matrix([(w.T * w).trace() / 2]),
    },
    "TxR": {"T": lambda r, t: skew(t) * r, "U": lambda r, u: r * skew(u)},
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


DISTANCE, ANGLE = Symbol("d"), Symbol("alpha")
_ONE = sympy.Integer(1)


@dataclass(frozen=True)
class SymbolicPrimitive:
    """A primitive by its vectors.

    Attributes
    ----------
    point
        A point of it.
    axis
        The unit vector of a line, the unit normal of a plane; None for a point.
    directions
        Orthonormal directions in it: none, the line's, or two of the plane's.
    """

    point: Vector
    axis: Vector | None
    directions: tuple[Vector, ...]


def element(primitive: Primitive, frame: VectorFrame) -> SymbolicPrimitive:
    """Return the vectors of a primitive of the platform or the base."""
    vector, names = (platform, "YBv") if frame is VectorFrame.PLATFORM else (base, "XAu")
    point, axis = vector(names[1]), vector(names[2])
    match primitive:
        case Primitive.POINT:
            return SymbolicPrimitive(vector(names[0]), None, ())
        case Primitive.LINE:
            return SymbolicPrimitive(point, axis, (axis,))
        case Primitive.PLANE:
            return SymbolicPrimitive(point, axis, (vector(f"{names[2]}1"), vector(f"{names[2]}2")))


@dataclass(frozen=True)
class Setting:
    """The vectors of a constraint.

    Attributes
    ----------
    platform, base
        The two primitives.
    offset
        The vector w from the base primitive's point to the platform primitive's.
    """

    platform: SymbolicPrimitive
    base: SymbolicPrimitive
    offset: Sum

    @property
    def directions(self) -> tuple[Vector, ...]:
        """The directions of both primitives."""
        return (*self.platform.directions, *self.base.directions)

    @property
    def axes(self) -> tuple[Vector, ...]:
        """The unit vectors of lines and planes, the platform's first."""
        return tuple(axis for axis in (self.platform.axis, self.base.axis) if axis is not None)


def setting(kind: Kind) -> Setting:
    """Return the vectors of a constraint."""
    moving = element(kind.platform, VectorFrame.PLATFORM)
    fixed = element(kind.base, VectorFrame.BASE)
    offset = Sum(((_ONE, moving.point), (_ONE, TRANSLATION), (-_ONE, fixed.point)))
    return Setting(moving, fixed, offset)


@cache
def squared_distance(kind: Kind) -> tuple[Expr, Expr]:
    """Return numerator and denominator of the squared distance, in atoms.

    Minimizes ``|w + Σ λ_i d_i|²`` over the λ_i: the gradient vanishes at one point, since the form
    is positive definite.
    """
    where = setting(kind)
    steps = sympy.symbols(f"lambda:{len(where.directions)}")
    moved = Sum((*where.offset.terms, *zip(steps, where.directions, strict=True)))
    square = _orthonormal(inner(moved, moved), where)
    gradient = [sympy.diff(square, step) for step in steps]
    least = square.subs(sympy.solve(gradient, steps, dict=True)[0]) if steps else square
    numerator, denominator = sympy.fraction(sympy.cancel(sympy.together(least)))
    # The Gram determinant of the directions is 1 where they are orthonormal.
    scale = denominator.subs(dict.fromkeys(denominator.atoms(on_rotation), 0))
    return sympy.expand(numerator / scale), sympy.expand(denominator / scale)


def _orthonormal(form: Expr, where: Setting) -> Expr:
    values = {}
    for part in (where.platform, where.base):
        for a in part.directions:
            for b in part.directions:
                values[dot(a.name, b.name)] = _ONE if a == b else sympy.Integer(0)
    return sympy.expand(form).xreplace(values)


@dataclass(frozen=True)
class SymbolicEquation:
    """One way to write a constraint: ``left = right``, polynomials in atoms.

    Attributes
    ----------
    left, right
        The two sides; `right` holds the value d or alpha.
    form
        How it is written: ``gram`` (inner products), ``base`` or ``platform`` (squares of
        components in the axes of that frame), ``product`` (one inner or triple product).
    """

    left: Expr
    right: Expr
    form: str


@cache
def equations(kind: Kind, *, one_sided: bool = False) -> tuple[SymbolicEquation, ...]:
    """Return the ways to write a constraint, all with the same zeros on the rigid motions.

    The Gram determinant of three vectors is the square of their triple product, and
    ``|w × d|² = |w|² − (w·d)²`` for a unit vector d: both are identities in the components.

    Parameters
    ----------
    kind
        The kind of constraint.
    one_sided
        Whether the side of a DPH or DHP is chosen: the sign d is that of the point with respect to
        the plane's normal. Makes no difference to the other kinds.
    """
    where = setting(kind)
    if not kind.is_distance:
        return (SymbolicEquation(inner(*where.axes), angle_value(kind), "product"),)
    if kind.has_sides and one_sided:
        return (SymbolicEquation(_height(kind), DISTANCE, "product"),)
    numerator, denominator = squared_distance(kind)
    offset, axes = where.offset, where.axes
    # The simplest first: it is taken where another one has the same degree.
    if kind.has_sides:
        ways = {"product": _height(kind) ** 2, "gram": numerator}
        ways |= {
            name: inner(offset, offset) - square
            for name, square in _moments(offset, axes[0]).items()
        }
    elif len(axes) == 2:
        ways = {"product": triple(offset, *axes) ** 2, "gram": numerator}
    elif len(axes) == 1:
        ways = {"gram": inner(offset, offset) - inner(offset, axes[0]) ** 2}
        ways |= _moments(offset, axes[0])
    else:
        ways = {"gram": numerator}
        ways |= {
            name: sympy.Add(*(inner(offset, e) ** 2 for e in units(frame)))
            for name, frame in _FRAMES.items()
        }
    return tuple(
        SymbolicEquation(left, DISTANCE**2 * denominator, name) for name, left in ways.items()
    )


_FRAMES = {"base": VectorFrame.BASE, "platform": VectorFrame.PLATFORM}


def _moments(offset: Sum, axis: Vector) -> dict[str, Expr]:
    """Return |w × axis|² by its components in the axes of either frame."""
    return {
        name: sympy.Add(*(triple(offset, axis, e) ** 2 for e in units(frame)))
        for name, frame in _FRAMES.items()
    }


def _height(kind: Kind) -> Expr:
    """Return the signed height of the point above the plane, on the side of its normal."""
    where = setting(kind)
    (normal,) = where.axes
    from_plane = where.offset if kind.base is Primitive.PLANE else _negated(where.offset)
    return inner(from_plane, normal)


def _negated(vectors: Sum) -> Sum:
    return Sum(tuple((-coefficient, vector) for coefficient, vector in vectors.terms))


def angle_value(kind: Kind) -> Expr:
    """Return the inner product of the two unit vectors at the angle alpha.

    The angle of two lines is that of their directions. The angle of a line and a plane is the
    complement of that of direction and normal. The angle of two planes is the supplement of that of
    their normals: both point out of the measured wedge (the sign of the paper's equation for AHH).
    """
    planes = (kind.platform, kind.base).count(Primitive.PLANE)
    angle_of_vectors = (ANGLE, sympy.pi / 2 - ANGLE, sympy.pi - ANGLE)[planes]
    return sympy.cos(angle_of_vectors)


def equation(
    kind: Kind, weights: Mapping[str, int], *, one_sided: bool = False
) -> tuple[SymbolicEquation, int] | None:
    """Return an equation of lowest degree and that degree.

    That no polynomial of lower degree has the zeros of the constraint is shown in
    `tools.equations.lower_degrees`.

    Parameters
    ----------
    kind
        The kind of constraint.
    weights
        The degree of each block, such as `CoordinateSystem.degrees`.
    one_sided
        Whether the side of a DPH or DHP is chosen.

    Returns
    -------
    tuple or None
        None if the blocks do not determine what the constraint measures.
    """
    found: tuple[SymbolicEquation, int] | None = None
    for candidate in equations(kind, one_sided=one_sided):
        its_degree = degree(candidate.left - candidate.right, weights)
        if its_degree is not None and (found is None or its_degree < found[1]):
            found = candidate, its_degree
    return found


@dataclass(frozen=True)
class LowestDegree:
    """The lowest degree of a constraint and the smallest coordinates in which it is reached.

    Attributes
    ----------
    degree
        The degree.
    coordinates
        The coordinates.
    equation
        The equation.
    """

    degree: int
    coordinates: CoordinateSystem
    equation: SymbolicEquation


def lowest_degree(kind: Kind, *, one_sided: bool = False) -> LowestDegree:
    """Search the coordinates for the lowest degree of a constraint; the smallest ones win."""
    best: LowestDegree | None = None
    for coordinates in SYSTEMS:
        found = equation(kind, coordinates.degrees, one_sided=one_sided)
        if found is not None and (best is None or found[1] < best.degree):
            best = LowestDegree(found[1], coordinates, found[0])
    assert best is not None, kind
    return best
