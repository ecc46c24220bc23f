"""The constraints as polynomials, from their definitions (Section 4), for other programs.

Directions and normals are kept as written, of any length, so that rational data give rational
coefficients. No code is shared with the quadrics of the path tracker or with the equations of the
certificates: benchmarks and oracles check that all have the same solutions. Other independent
statements are those modulo primes in `gspcli.atlas` and those for Singular in `tools/`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from gspcli import __version__
from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP
from gspcli.export.constants import Constants
from gspcli.export.motion_coordinates import SymbolicMotion
from gspcli.export.polynomials import Polynomial, cross, dot
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Line, Plane
from gspcli.records import dataclass

_ONE = Polynomial.constant(1)
_SIGNS = {Side.POSITIVE: 1, Side.NEGATIVE: -1}
#: An equation as a sum of products of two polynomials, which is zero.
SumOfProducts = tuple[tuple[Polynomial, Polynomial], ...]


@dataclass(frozen=True)
class PolynomialSystem:
    """Polynomials to be zero.

    Attributes
    ----------
    names
        The unknowns, in order.
    polynomials
        In the unknowns and the constants.
    constants
        Irrational numbers by the names that stand for them.
    """

    names: tuple[str, ...]
    polynomials: tuple[Polynomial, ...]
    constants: Mapping[str, Number]

    def rounded(self, digits: int) -> PolynomialSystem:
        """Return it with decimal fractions, of this many digits, for its irrational constants."""
        from gspcli.certification.numbers.balls import decimal_near

        values = {name: decimal_near(number, digits) for name, number in self.constants.items()}
        rows = tuple(row.replaced(values) for row in self.polynomials)
        return replace(self, polynomials=rows, constants={})

    @property
    def title(self) -> str:
        """How many polynomials and unknowns, by which version."""
        sizes = f"{len(self.polynomials)} polynomials in {len(self.names)} unknowns"
        return f"gsp {__version__}: {sizes}"

    @property
    def heading(self) -> str:
        """The heading of solutions as CSV, as `gsp certify` reads them."""
        return ",".join(f"{name},{name}_imag" for name in self.names)


def system(instance: Instance, motion: SymbolicMotion) -> PolynomialSystem:
    """Return the constraints of an instance and the relations of the coordinates."""
    rows, constants = equations(instance, motion)
    polynomials = [constants.reduced(expanded(row)) for row in rows]
    return PolynomialSystem(motion.names, (*polynomials, *motion.relations), constants.names)


def expanded(equation: SumOfProducts) -> Polynomial:
    """Return the polynomial of an equation."""
    return sum((p * q for p, q in equation), start=Polynomial({}))


def equations(instance: Instance, motion: SymbolicMotion) -> tuple[list[SumOfProducts], Constants]:
    """Return one equation for each constraint, and the irrational numbers in them.

    Parallel lines at any distance also satisfy the equation of a DLL.
    """
    constants = Constants()
    rows = [_equation(row, instance.units.angle, motion, constants) for row in instance.constraints]
    return rows, constants


def _equation(
    row: Constraint, unit: AngleUnit, motion: SymbolicMotion, exact: Constants
) -> SumOfProducts:
    y, x = exact.vector(row.platform.position), exact.vector(row.base.position)
    u, v = exact.vector(_direction(row.platform)), exact.vector(_direction(row.base))
    N = motion.N
    if not row.kind.is_distance:
        lengths = exact.norm(_direction(row.platform)) * exact.norm(_direction(row.base))
        aim = exact.reduced(exact.cosine(row, unit) * lengths)
        return ((dot(motion.turned(u), v) - aim * N, _ONE),)
    square = exact.square(row.value)
    turned_y, turned_x = motion.turned(y), motion.turned_back(x)
    # r = R y + T - x, and the same seen from the platform: s = R^T x - U - y.
    r = [a + b - N * c for a, b, c in zip(turned_y, motion.T, x, strict=True)]
    s = [a - b - N * c for a, b, c in zip(turned_x, motion.U, y, strict=True)]
    sphere = N * (exact.reduced(dot(x, x) + dot(y, y)) - square) + motion.rho
    sphere += 2 * (dot(y, motion.U) - dot(x, motion.T) - dot(x, turned_y))
    if row.kind is DPP:
        return ((sphere, _ONE),)
    if row.kind in (DPH, DHP):
        normal, height = (v, dot(v, r)) if row.kind is DPH else (u, dot(u, s))
        if row.side is Side.BOTH:
            size = exact.reduced(dot(normal, normal) * square)
            return ((height, height), (N * size, -N))
        own = row.base if row.kind is DPH else row.platform
        distance = exact.reduced(exact.number(row.value) * exact.norm(_direction(own)))
        return ((height - _SIGNS[row.side] * distance * N, _ONE),)
    if row.kind in (DPL, DLP):
        line, along = (v, dot(v, r)) if row.kind is DPL else (u, dot(u, s))
        return ((exact.reduced(dot(line, line)) * N, sphere), (along, -along))
    if row.kind is not DLL:
        raise ValueError(row.kind)
    turned = motion.turned(u)
    moment = dot(v, motion.turned(cross(y, u))) + dot(v, motion.moment(u))
    moment -= dot(turned, cross(v, x))
    sizes, cosine = exact.reduced(dot(u, u) * dot(v, v)), dot(turned, v)
    # M^2 = d^2 (u^2 v^2 - C^2)
    return (moment, moment), (square * cosine, cosine), (square * sizes * N, -N)


def _direction(geometry: object) -> Sequence[Number]:
    if isinstance(geometry, Line):
        return geometry.direction
    return geometry.normal if isinstance(geometry, Plane) else ()
