"""Constraint equations as people read them: plain text and LaTeX."""

from __future__ import annotations

from collections.abc import Mapping

import sympy
from sympy import Expr

from gspcli.catalogue.kinds import Kind, Primitive
from gspcli.records import dataclass
from tools.equations.constraint_equations import (
    ANGLE,
    DISTANCE,
    RHO,
    CoordinateSystem,
    SymbolicEquation,
    Vector,
    VectorFrame,
    cross,
    dot,
    equations,
    lowest_degree,
    on_moment,
    on_pullback,
    on_rotation,
    on_translation,
    setting,
)


@dataclass(frozen=True)
class Signs:
    """The signs of one way of writing.

    Attributes
    ----------
    dot, times, minus, plus_minus, rho, square
        Signs of operations; `square` is a superscript.
    blocks
        The block T×R as a matrix, and `axial`, the vector of a skew matrix.
    functions
        Prefix of named functions.
    transposed
        Superscript of a transposed matrix.
    """

    dot: str
    times: str
    minus: str
    plus_minus: str
    rho: str
    square: str
    alpha: str
    functions: str
    half: str
    transposed: str
    gap: str


TEXT = Signs("·", "×", "−", "±", "ρ", "²", "α", "", "½", "ᵀ", "")
LATEX = Signs(
    r" \cdot ",
    r" \times ",
    "-",
    r"\pm ",
    r"\rho",
    "^2",
    r"\alpha",
    "\\",
    r"\tfrac{1}{2}",
    r"^{\mathsf T}",
    " ",
)

_ORDER = (RHO, on_moment, on_pullback, on_translation, on_rotation, dot)


def definition(kind: Kind, style: Signs = TEXT) -> str:
    """Return a constraint in R and T, as the paper writes it (Section 4)."""
    where = setting(kind)
    offset = f"R{style.gap}{where.platform.point.name} + T {style.minus} {where.base.point.name}"
    axes = [_carried(axis, style) for axis in where.axes]
    if not kind.is_distance:
        value = write(equations(kind)[0].right, None, style)
        return f"{axes[0]}{style.dot}{axes[1]} = {value}"
    if kind.base is Primitive.PLANE:
        return f"{axes[0]}{style.dot}({offset}) = {style.plus_minus}d"
    if kind.platform is Primitive.PLANE:
        point, moving = where.base.point.name, where.platform.point.name
        to_point = f"{point} {style.minus} R{style.gap}{moving} {style.minus} T"
        return f"{axes[0]}{style.dot}({to_point}) = {style.plus_minus}d"
    square = f"d{style.square}"
    if not axes:
        return f"|{offset}|{style.square} = {square}"
    if len(axes) == 1:
        return f"|({offset}){style.times}{axes[0]}|{style.square} = {square}"
    normal = f"{axes[0]}{style.times}{axes[1]}"
    return f"(({offset}){style.dot}({normal})){style.square} = {square} |{normal}|{style.square}"


def written(
    equation: SymbolicEquation, kind: Kind, coordinates: CoordinateSystem, style: Signs = TEXT
) -> str:
    """Return an equation in the given coordinates; with both signs of d where there are sides."""
    if kind.has_sides and equation.form == "product":
        (height,) = equations(kind, one_sided=True)
        return f"{write(height.left, coordinates, style)} = {style.plus_minus}d"
    left, right = (write(side, coordinates, style) for side in (equation.left, equation.right))
    return f"{left} = {right}"


def why_lowest(kind: Kind) -> str:
    """Return why the lowest degree of a kind is no higher, in words."""
    axes = [_carried(axis, TEXT) for axis in setting(kind).axes]
    offset = f"w = R{setting(kind).platform.point.name} + T − {setting(kind).base.point.name}"
    if not kind.is_distance:
        return "one inner product of two unit vectors, linear in R"
    form = lowest_degree(kind).equation.form
    match form, len(axes):
        case "gram", 0:
            return f"|w|² of {offset} is ρ and inner products linear in R, T and U"
        case "gram", _:
            return (
                f"|w×{axes[0]}|² = |w|² − (w·{axes[0]})², {offset}: "
                f"|w|² is at most quadratic, w·{axes[0]} linear"
            )
        case "product", 1:
            return f"the signed height of the point is one inner product, w·{axes[0]}, {offset}"
        case _:
            return (
                f"the distance times |{axes[0]}×{axes[1]}| is one triple product, "
                f"w·({axes[0]}×{axes[1]}), {offset}"
            )


def write(form: Expr, coordinates: CoordinateSystem | None, style: Signs = TEXT) -> str:
    """Return a polynomial in atoms, d and functions of alpha.

    Blocks that are not among the coordinates are written by those that are.
    """
    terms = sorted(sympy.Add.make_args(form), key=_rank)
    text = ""
    for term in terms:
        coefficient, rest = term.as_coeff_Mul()
        sign = style.minus if coefficient < 0 else "+"
        body = _product(abs(coefficient), rest, coordinates, style)
        if text:
            text += f" {sign} {body}"
        else:
            text = (style.minus if coefficient < 0 else "") + body
    return text


def _rank(term: Expr) -> tuple[int, str]:
    """Return the place of a term in a sum: numbers, plain atoms by their head, squares."""
    _, rest = term.as_coeff_Mul()
    if rest == 1:
        return (-1, "")
    for place, head in enumerate(_ORDER):
        if rest == head or rest.func == head:
            return (place, str(rest))
    return (len(_ORDER), str(rest))


def _product(
    coefficient: Expr, rest: Expr, coordinates: CoordinateSystem | None, style: Signs
) -> str:
    if rest == 1:
        return str(coefficient)
    factors = sorted(sympy.Mul.make_args(rest), key=lambda factor: not factor.has(DISTANCE))
    bodies = [_factor(factor, len(factors) > 1, coordinates, style) for factor in factors]
    if coefficient != 1:
        bodies.insert(0, str(coefficient))
    return " ".join(bodies)


def _factor(
    factor: Expr, among_others: bool, coordinates: CoordinateSystem | None, style: Signs
) -> str:
    if factor.is_Pow:
        base, exponent = factor.args
        assert exponent == 2, factor
        body = write(base, coordinates, style)
        return (body if base.is_Symbol else f"({body})") + style.square
    if factor.is_Add or (among_others and not factor.is_Symbol):
        return f"({write(factor, coordinates, style)})"
    if factor in (DISTANCE, ANGLE):
        return "d" if factor == DISTANCE else style.alpha
    if factor.func in (sympy.sin, sympy.cos):
        return f"{style.functions}{factor.func.__name__} {write(factor.args[0], None, style)}"
    assert coordinates is not None, factor
    return _atom(factor, coordinates, style)


def _atom(atom: Expr, coordinates: CoordinateSystem, style: Signs) -> str:
    blocks = coordinates.blocks
    if atom == RHO:
        for block, text in _rho(style).items():
            if block in blocks:
                return text
    names = [_name(argument, style) for argument in atom.args]
    times, gap = style.times, style.gap
    if atom.func == dot:
        return style.dot.join(names)
    if atom.func == on_rotation:
        return f"{names[0]}{style.dot}R{gap}{names[1]}"
    if atom.func == on_translation:
        return f"{names[0]}{style.dot}{_translation(blocks, style)}"
    if atom.func == on_pullback:
        if "U" in blocks:
            return f"{names[0]}{style.dot}U"
        return f"{_translation(blocks, style)}{style.dot}R{gap}{names[0]}"
    if "TxR" in blocks:
        return f"{names[0]}{style.dot}(T{times}R){gap}{names[1]}"
    if "T" in blocks:
        return f"{names[0]}{style.dot}(T{times}R{gap}{names[1]})"
    return f"{names[0]}{style.dot}R{gap}(U{times}{names[1]})"


def _rho(style: Signs) -> Mapping[str, str]:
    return {
        "rho": style.rho,
        "T": f"T{style.dot}T",
        "U": f"U{style.dot}U",
        "TxR": f"{style.half}|T{style.times}R|{style.square}",
    }


def _translation(blocks: tuple[str, ...], style: Signs) -> str:
    if "T" in blocks:
        return "T"
    if "U" in blocks:
        return f"R{style.gap}U"
    return f"{style.functions}axial((T{style.times}R){style.gap}R{style.transposed})"


def _name(vector: Expr, style: Signs) -> str:
    if vector.func == cross:
        return f"({style.times.join(str(argument) for argument in vector.args)})"
    return str(vector)


def _carried(vector: Vector, style: Signs) -> str:
    prefix = f"R{style.gap}" if vector.frame is VectorFrame.PLATFORM else ""
    return prefix + str(vector.name)
