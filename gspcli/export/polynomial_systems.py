"""The constraints as polynomials, from their definitions (Section 4), for other programs.

Directions and normals are kept as written, of any length, so that rational data give rational
coefficients. No code is shared with the quadrics of the path tracker or with the equations of the
certificates: benchmarks and oracles check that all have the same solutions. Other independent
statements are those modulo primes in `gspcli.atlas` and those for Singular in `tools/`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from fractions import Fraction
from functools import cached_property
from math import isqrt, lcm

from gspcli import __version__
from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP
from gspcli.geometry.instance import AngleUnit, Constraint, Instance, Side
from gspcli.geometry.numbers import Number
from gspcli.geometry.primitives import Line, Plane
from gspcli.records import dataclass

Monomial = tuple[str, ...]


@dataclass(frozen=True)
class Polynomial:
    """A polynomial in named symbols over the rational numbers."""

    #: Coefficients by monomial, none zero.
    terms: Mapping[Monomial, Fraction]

    @classmethod
    def constant(cls, value: Fraction | int) -> Polynomial:
        """Return a constant."""
        return cls({(): Fraction(value)} if value else {})

    @classmethod
    def symbol(cls, name: str) -> Polynomial:
        """Return a symbol."""
        return cls({(name,): Fraction(1)})

    @property
    def value(self) -> Fraction | None:
        """The number that the polynomial is, or None."""
        return None if set(self.terms) - {()} else self.terms.get((), Fraction(0))

    @cached_property
    def cleared(self) -> dict[Monomial, int]:
        """Integer coefficients: multiplied by the least common denominator."""
        common = lcm(*(value.denominator for value in self.terms.values()))
        return {monomial: int(value * common) for monomial, value in self.terms.items()}

    def replaced(self, values: Mapping[str, Fraction | int | Polynomial]) -> Polynomial:
        """Return the polynomial with values for some symbols."""
        result: dict[Monomial, Fraction] = {}
        for monomial, coefficient in self.terms.items():
            kept = tuple(name for name in monomial if name not in values)
            factor = Polynomial({kept: coefficient})
            for name in monomial:
                if name in values:
                    factor = factor * values[name]
            for key, value in factor.terms.items():
                result[key] = result.get(key, Fraction(0)) + value
        return _without_zeros(result)

    def __add__(self, other: Operand) -> Polynomial:
        result = dict(self.terms)
        for monomial, value in _of(other).terms.items():
            result[monomial] = result.get(monomial, Fraction(0)) + value
        return _without_zeros(result)

    def __mul__(self, other: Operand) -> Polynomial:
        factors = _of(other).terms
        result: dict[Monomial, Fraction] = {}
        for m, p in self.terms.items():
            for n, q in factors.items():
                monomial = tuple(sorted(m + n))
                result[monomial] = result.get(monomial, Fraction(0)) + p * q
        return _without_zeros(result)

    def __neg__(self) -> Polynomial:
        return Polynomial({monomial: -value for monomial, value in self.terms.items()})

    def __sub__(self, other: Operand) -> Polynomial:
        return self + -_of(other)

    def __rsub__(self, other: Operand) -> Polynomial:
        return _of(other) - self

    __radd__ = __add__
    __rmul__ = __mul__


Operand = Polynomial | Fraction | int


def _of(value: Operand) -> Polynomial:
    return value if isinstance(value, Polynomial) else Polynomial.constant(value)


def _without_zeros(terms: dict[Monomial, Fraction]) -> Polynomial:
    return Polynomial({monomial: value for monomial, value in terms.items() if value})


def dot(a: Sequence[Operand], b: Sequence[Operand]) -> Polynomial:
    """Return the scalar product of two vectors."""
    return sum((_of(p) * q for p, q in zip(a, b, strict=True)), start=Polynomial({}))


def cross(a: Sequence[Operand], b: Sequence[Operand]) -> list[Polynomial]:
    """Return the vector product of two vectors."""
    return [_of(a[i - 2]) * b[i - 1] - _of(a[i - 1]) * b[i - 2] for i in range(3)]


@dataclass(frozen=True)
class Style:
    """How a program writes polynomials."""

    #: Between a symbol and its exponent.
    power: str = "^"
    #: Between numerator and denominator.
    quotient: str = "/"
    #: The imaginary unit.
    imaginary: str = "I"
    #: The letter before the exponent of a floating-point number.
    exponent: str = "e"

    def written(
        self, terms: Mapping[Monomial, complex | Fraction] | Iterable[tuple[complex, Monomial]]
    ) -> str:
        """Return the text of a polynomial, ``0`` for none."""
        pairs = (
            ((value, monomial) for monomial, value in terms.items())
            if isinstance(terms, Mapping)
            else terms
        )
        # msolve and Singular do not understand a sign before the first term.
        text = "".join(self._term(value, monomial) for value, monomial in pairs)
        return text.removeprefix("+") or "0"

    def _term(self, value: complex | Fraction, monomial: Monomial) -> str:
        # Written as a product with powers: msolve does not understand x*x.
        return "*".join([self._number(value), *self._powers(monomial)])

    def _powers(self, monomial: Monomial) -> Iterator[str]:
        for name in dict.fromkeys(monomial):
            count = monomial.count(name)
            yield name if count == 1 else f"{name}{self.power}{count}"

    def _number(self, value: complex | Fraction) -> str:
        if isinstance(value, Fraction | int):
            below = "" if value.denominator == 1 else f"{self.quotient}{value.denominator}"
            return f"{value.numerator:+d}{below}"
        real = self._float(complex(value).real)
        imaginary = complex(value).imag
        return f"+({real}{self._float(imaginary)}*{self.imaginary})" if imaginary else real

    def _float(self, value: float) -> str:
        return f"{value:+.16e}".replace("e", self.exponent)


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
    """A rigid motion ``x -> R x + T``."""

    #: The unknowns.
    names: tuple[str, ...]
    #: The polynomial by which all others are multiplied.
    N: Polynomial
    #: N times the rotation, by rows, T, ``R^T T`` and ``T.T``.
    R: tuple[Vector, ...]
    T: Vector
    U: Vector
    rho: Polynomial
    #: From a vector v to ``N (T x R v)``.
    moment: Callable[[Sequence[Operand]], Vector]
    #: What the unknowns satisfy, and with it N is not zero, each to be zero.
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


#: The symbols of a monomial in alphabetical order, each as often as its exponent says.


_COSINES = {0: "1", 60: "1/2", 90: "0", 120: "-1/2", 180: "-1"}
_ROOTS = {30: ("1/2", 3), 45: ("1/2", 2), 135: ("-1/2", 2), 150: ("-1/2", 3)}
_HALF = Number.of(180)
_PI = Number("pi")


class Constants:
    """Numbers as polynomials; each irrational one gets a name when it is first met.

    Attributes
    ----------
    names
        The irrational numbers by name.
    """

    def __init__(self) -> None:
        self.names: dict[str, Number] = {}
        self._squares: dict[str, Fraction] = {}

    def number(self, number: Number) -> Polynomial:
        """Return an exact number."""
        if number.fraction is not None:
            return Polynomial.constant(number.fraction)
        parts = number.arguments
        match number.operation:
            case "+":
                return self.number(parts[0]) + self.number(parts[1])
            case "-":
                return self.number(parts[0]) - self.number(parts[1])
            case "*":
                return self.reduced(self.number(parts[0]) * self.number(parts[1]))
            case "neg":
                return -self.number(parts[0])
            case "/":
                below = self.number(parts[1]).value
                if below:
                    return self.number(parts[0]) * (1 / below)
            case "sqrt":
                inside = self.number(parts[0]).value
                if inside is not None:
                    return self.root(inside)
        return self._named(number)

    def vector(self, numbers: Sequence[Number]) -> list[Polynomial]:
        """Return an exact vector."""
        return [self.number(number) for number in numbers]

    def square(self, number: Number) -> Polynomial:
        """Return the square of a number; for a square root this is the radicand."""
        if number.operation == "sqrt":
            return self.number(number.arguments[0])
        value = self.number(number)
        return self.reduced(value * value)

    def norm(self, numbers: Sequence[Number]) -> Polynomial:
        """Return the length of a vector."""
        vector = self.vector(numbers)
        square = self.reduced(dot(vector, vector)).value
        if square is not None:
            return self.root(square)
        total = Number.of(0)
        for number in numbers:
            total = Number("+", (total, Number("*", (number, number))))
        return self._named(Number("sqrt", (total,)))

    def root(self, square: Fraction) -> Polynomial:
        """Return the square root of a fraction that is not negative."""
        root = Fraction(isqrt(square.numerator), isqrt(square.denominator))
        if root * root == square:
            return Polynomial.constant(root)
        # sqrt(p/q) = sqrt(p q) / q
        inside, below = square.numerator * square.denominator, square.denominator
        outside = 1
        for factor in range(2, 1000):
            while inside % (factor * factor) == 0:
                inside, outside = inside // (factor * factor), outside * factor
        name = self._named(Number("sqrt", (Number.of(inside),)))
        (key,) = name.terms
        self._squares[key[0]] = Fraction(inside)
        return name * Fraction(outside, below)

    def cosine(self, constraint: Constraint, unit: AngleUnit) -> Polynomial:
        """Return the value of ``R u . v`` of an angle, by Section 4."""
        angle, law = constraint.value, constraint.kind.law
        if law.is_cosine:
            return self._cosine(angle, unit) * law.sign
        quarter = Number.of(90) if unit is AngleUnit.DEGREE else Number("/", (_PI, Number.of(2)))
        function = _undone("asin", angle, unit)
        if function is not None:
            return self.number(function)
        return self._cosine(Number("-", (quarter, angle)), unit)

    def _cosine(self, angle: Number, unit: AngleUnit) -> Polynomial:
        inside = _undone("acos", angle, unit)
        if inside is not None:
            return self.number(inside)
        degrees = angle.fraction
        if unit is AngleUnit.DEGREE and degrees is not None and degrees.denominator == 1:
            whole = int(degrees)
            if whole in _COSINES:
                return Polynomial.constant(Fraction(_COSINES[whole]))
            if whole in _ROOTS:
                factor, square = _ROOTS[whole]
                return self.root(Fraction(square)) * Fraction(factor)
        if unit is AngleUnit.DEGREE:
            angle = Number("/", (Number("*", (angle, _PI)), _HALF))
        return (
            self.number(Number("cos", (angle,))) if angle.fraction != 0 else Polynomial.constant(1)
        )

    def reduced(self, value: Polynomial) -> Polynomial:
        """Return a polynomial without squares of the constants that are roots of fractions."""
        for name, square in self._squares.items():
            terms: dict[tuple[str, ...], Fraction] = {}
            for monomial, coefficient in value.terms.items():
                pairs = monomial.count(name) // 2
                if pairs:
                    first = monomial.index(name)
                    monomial = monomial[:first] + monomial[first + 2 * pairs :]
                terms[monomial] = terms.get(monomial, Fraction(0)) + coefficient * square**pairs
            value = Polynomial({key: number for key, number in terms.items() if number})
        return value

    def _named(self, number: Number) -> Polynomial:
        for name, known in self.names.items():
            if known == number:
                return Polynomial.symbol(name)
        name = f"k{len(self.names) + 1}"
        self.names[name] = number
        return Polynomial.symbol(name)


def _undone(function: str, angle: Number, unit: AngleUnit) -> Number | None:
    """Return x if an angle is written as ``acos(x)`` or, in degrees, ``acos(x)*180/pi``."""
    if unit is AngleUnit.DEGREE:
        if angle.operation != "/" or angle.arguments[1] != _PI:
            return None
        angle = angle.arguments[0]
        if angle.operation != "*" or angle.arguments[1].fraction != 180:
            return None
        angle = angle.arguments[0]
    if angle.operation != function:
        return None
    inside: Number = angle.arguments[0]
    return inside


_ONE = Polynomial.constant(1)
_SIGNS = {Side.POSITIVE: 1, Side.NEGATIVE: -1}
#: An equation as a sum of products of two polynomials, which is zero.
SumOfProducts = tuple[tuple[Polynomial, Polynomial], ...]


@dataclass(frozen=True)
class PolynomialSystem:
    """Polynomials to be zero."""

    #: The unknowns, in order.
    names: tuple[str, ...]
    #: In the unknowns and the constants.
    polynomials: tuple[Polynomial, ...]
    #: Irrational numbers by the names that stand for them.
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
