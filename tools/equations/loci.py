"""The locus of a platform primitive for a fixed orientation (Proposition 6.4).

With R fixed, the squared distance is ``wᵀ Q w`` for a projection Q along the directions of the two
primitives. So the points of the platform primitive have the distance d from an affine space of
dimension 3 − rank Q. They lie on a sphere, a cylinder or two parallel planes.
"""

from __future__ import annotations

import sympy
from sympy import Expr, Matrix, Symbol

from gspcli.catalogue.kinds import Kind, Primitive
from gspcli.records import dataclass
from tools.equations.constraint_equations import (
    MOTIONS,
    Vector,
    VectorFrame,
    inner,
    setting,
    squared_distance,
)
from tools.equations.motions import evaluate, motion_blocks

#: The surface by the rank of Q: plane, cylinder, sphere.
SURFACES = {1: "P", 2: "C", 3: "S"}


@dataclass(frozen=True)
class DerivedLocus:
    """The locus of a point of a platform primitive under a fixed orientation.

    Attributes
    ----------
    surface
        The paper's letter (Proposition 6.7): P, S or C.
    text
        The surface in words.
    """

    surface: str
    text: str


def _unit(name: str) -> Matrix:
    """Return a unit vector as rational functions of two parameters: all vectors but one."""
    s, t = Symbol(name + "_s"), Symbol(name + "_t")
    return Matrix([2 * s, 2 * t, 1 - s**2 - t**2]) / (1 + s**2 + t**2)


def quadratic_part(kind: Kind, *, parallel: bool = False) -> Matrix:
    """Return the matrix Q of the squared distance as a quadratic form in T, R being fixed.

    The entries are rational functions of the parameters of the unit vectors. The vectors of the
    platform are already carried by R, which may then be the identity.

    Parameters
    ----------
    kind
        A kind of distance.
    parallel
        Whether the two lines of a DLL are parallel: they then have one direction, not two.
    """
    where = setting(kind)
    vectors = {str(axis.name): _unit(str(axis.name)) for axis in where.axes}
    if len(where.axes) == 2:
        # The base's frame may be turned: one of two directions is its third axis.
        vectors["u"] = sympy.eye(3)[:, 2]
    for part in (where.platform, where.base):
        if len(part.directions) == 2:
            vectors |= _plane_directions(part.directions, vectors[str(_axis(part.axis).name)])
        vectors[str(part.point.name)] = sympy.zeros(3, 1)
    if parallel:
        numerator = inner(where.offset, where.offset)
        numerator -= inner(where.offset, _axis(where.base.axis)) ** 2
        denominator: Expr = sympy.Integer(1)
    else:
        numerator, denominator = squared_distance(kind)
    translation = MOTIONS.expressions["T"]
    blocks = motion_blocks(sympy.eye(3), translation)
    square = evaluate(numerator, vectors, blocks) / evaluate(denominator, vectors, blocks)
    hessian: Matrix = sympy.hessian(square, list(translation)) / 2
    return hessian.applyfunc(sympy.cancel)


def _axis(axis: Vector | None) -> Vector:
    assert axis is not None
    return axis


def _plane_directions(directions: tuple[Vector, ...], normal: Matrix) -> dict[str, Matrix]:
    """Return two orthonormal directions perpendicular to a normal from `_unit`."""
    # The stereographic parametrization is conformal: its tangents are orthogonal.
    parameters = sorted(normal.free_symbols, key=str)
    s, t = parameters
    scale = (1 + s**2 + t**2) / 2
    return {
        str(direction.name): (normal.diff(parameter) * scale).applyfunc(sympy.cancel)
        for direction, parameter in zip(directions, parameters, strict=True)
    }


def locus(kind: Kind, *, parallel: bool = False) -> DerivedLocus:
    """Return the locus that a distance induces (Proposition 6.4).

    Raises
    ------
    ArithmeticError
        If Q is not a projection, so that the locus would be another surface.
    """
    form = quadratic_part(kind, parallel=parallel)
    if (form * form - form).applyfunc(sympy.cancel) != sympy.zeros(3, 3):
        message = f"{kind}: the quadratic form of the distance is not a projection"
        raise ArithmeticError(message)
    # The rank of a projection is its trace.
    surface = SURFACES[int(sympy.cancel(form.trace()))]
    return DerivedLocus(surface, _describe(kind, surface))


def _describe(kind: Kind, surface: str) -> str:
    where = setting(kind)
    center = where.base.point.name
    if surface == "S":
        return f"sphere of radius d about {center}"
    if surface == "C":
        # Directions of parallel lines agree, so the base's serves for both.
        lines = (where.base, where.platform)
        axis = next(_carried(_axis(e.axis)) for e in lines if e.axis is not None)
        return f"cylinder of radius d about the line through {center} along {axis}"
    normals = [_carried(axis) for axis in where.axes]
    return f"two planes with normal {'×'.join(normals)} at distance d from {center}"


def _carried(axis: Vector) -> str:
    return ("R" if axis.frame is VectorFrame.PLATFORM else "") + str(axis.name)


def loci(kind: Kind) -> dict[str, DerivedLocus]:
    """Return the loci of a kind: ``generic`` and, for two lines, ``parallel``; empty for angles."""
    if not kind.is_distance:
        return {}
    found = {"generic": locus(kind)}
    if kind.platform is kind.base is Primitive.LINE:
        found["parallel"] = locus(kind, parallel=True)
    return found
