"""The closed forms of Section 6, each with its table, document and text."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from gspcli.records import dataclass
from gspcli.symbolic.closed_forms import derive as triangular_set
from gspcli.symbolic.closed_forms import expand_case, parse_case
from gspcli.symbolic.triangular import (
    Definition,
    NonVanishing,
    Polynomial,
    TriangularSet,
    coefficients,
    symbols_of,
)

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Notation:
    """How products and powers are written."""

    #: What stands between factors.
    times: str
    #: Writes a generator.
    symbol: Callable[[str], str]
    #: Writes a generator, already written, to a power above one.
    power: Callable[[str, int], str]
    #: What encloses a sum.
    brackets: tuple[str, str]
    #: Writes a quotient of a numerator (and whether it is a sum) and a divisor (likewise).
    quotient: Callable[[str, bool, str, bool], str]


def _latex_symbol(name: str) -> str:
    letter, index = re.fullmatch(r"([a-z]+)(\d*)", name).groups()  # type: ignore[union-attr]
    return f"{letter}_{{{index}}}" if index else letter


def _in_line(numerator: str, long: bool, divisor: str, sum_: bool) -> str:
    return (f"({numerator})" if long else numerator) + "/" + (f"({divisor})" if sum_ else divisor)


#: Powers as ``x^2``.
TEXT = Notation("*", str, lambda base, k: f"{base}^{k}", ("(", ")"), _in_line)
#: Python's and sympy's own.
CODE = Notation("*", str, lambda base, k: f"{base}**{k}", ("(", ")"), _in_line)
LATEX = Notation(
    " ",
    _latex_symbol,
    lambda base, k: f"{base}^{{{k}}}",
    (r"\left(", r"\right)"),
    lambda numerator, _, divisor, __: rf"\frac{{{numerator}}}{{{divisor}}}",
)


def write_polynomial(polynomial: Polynomial, unknowns: Sequence[str], notation: Notation) -> str:
    """Write a polynomial by descending powers of its unknowns, the highest unknown first.

    Parameters
    ----------
    polynomial
        The polynomial, not zero.
    unknowns
        The unknowns in ascending order; all other generators count as coefficients.
    notation
        One of `TEXT`, `CODE` and `LATEX`.
    """
    present = symbols_of(polynomial)
    return _sum(_terms(polynomial, [name for name in unknowns if name in present], notation))


def write_definition(definition: Definition, notation: Notation) -> str:
    """Write the right-hand side of a definition."""
    numerator = write_polynomial(definition.numerator, (), notation)
    if definition.divisor == 1:
        return numerator
    divisor = write_polynomial(definition.divisor, (), notation)
    return notation.quotient(
        numerator, len(definition.numerator) > 1, divisor, len(definition.divisor) > 1
    )


#: A sign (whether it is a minus) and a term without its sign.
_Term = tuple[bool, str]


def _sum(terms: Sequence[_Term]) -> str:
    (negative, first), *others = terms
    text = ("-" if negative else "") + first
    return text + "".join((" - " if minus else " + ") + term for minus, term in others)


def _terms(polynomial: Polynomial, unknowns: list[str], notation: Notation) -> list[_Term]:
    if not unknowns:
        return _plain_terms(polynomial, notation)
    *lower, leading = unknowns
    terms: list[_Term] = []
    for (degree,), part in coefficients(polynomial, [leading]).items():
        inner = _terms(part, lower, notation)
        if degree == 0:
            terms += inner
            continue
        power = _power(leading, degree, notation)
        if len(inner) == 1:
            ((negative, factor),) = inner
            product = power if factor == "1" else factor + notation.times + power
            terms.append((negative, product))
        else:
            opening, closing = notation.brackets
            terms.append((False, opening + _sum(inner) + closing + notation.times + power))
    return terms


def _plain_terms(polynomial: Polynomial, notation: Notation) -> list[_Term]:
    names = [str(symbol) for symbol in polynomial.ring.symbols]
    terms: list[_Term] = []
    for monomial, coefficient in polynomial.terms():
        factors = [
            _power(name, exponent, notation)
            for name, exponent in zip(names, monomial, strict=True)
            if exponent
        ]
        if abs(coefficient) != 1 or not factors:
            factors.insert(0, str(abs(coefficient)))
        terms.append((coefficient < 0, notation.times.join(factors)))
    # A sum does not begin with a minus if it need not.
    first = next((place for place, (negative, _) in enumerate(terms) if not negative), 0)
    return [terms[first], *terms[:first], *terms[first + 1 :]]


def _power(name: str, exponent: int, notation: Notation) -> str:
    base = notation.symbol(name)
    return base if exponent == 1 else notation.power(base, exponent)


_LONG = 9  # terms from which a coefficient's length is worth saying
_WIDEST = 100  # characters of LaTeX from which a sum goes on in the next line


def to_text(triangular: TriangularSet) -> str:
    """Return a triangular set for people to read, one polynomial a line."""
    names = triangular.variables

    def zero(polynomial: Any) -> str:
        return write_polynomial(polynomial, names, TEXT) + " = 0"

    lines = [
        f"{triangular.case}: {triangular.title}",
        f"{_capital(triangular.source)}. Unknowns {' < '.join(names)}.",
        "",
        "System",
        *(f"  {item.name}: {zero(item.polynomial)}" for item in triangular.system),
        "",
        f"Triangular set, {_count(triangular)}",
        *(
            f"  {item.name}, degree {item.degree} in {item.leading}: {zero(item.polynomial)}"
            for item in triangular.elements
        ),
    ]
    if triangular.steps:
        lines += ["", "Steps of the elimination"]
        lines += [f"  {step.name}: {zero(step.polynomial)}" for step in triangular.steps]
    if triangular.definitions:
        lines += ["", "Coefficients"]
        for definition in triangular.definitions:
            terms = len(definition.numerator)
            size = f" ({terms} terms)" if terms >= _LONG else ""
            lines.append(f"  {definition.symbol}{size} = {write_definition(definition, TEXT)}")
    if triangular.conditions:
        lines += ["", "Must not vanish"]
        for condition in triangular.conditions:
            polynomial = write_polynomial(condition.polynomial, names, TEXT)
            lines.append(f"  {polynomial} ({_role(condition)}); else {condition.meaning}")
    if triangular.notes:
        lines += ["", "Notes", *(f"  {note}" for note in triangular.notes)]
    return "\n".join(lines) + "\n"


def to_document(triangular: TriangularSet) -> dict[str, Any]:
    """Return a triangular set as JSON values; polynomials are strings that sympy reads."""
    names = triangular.variables

    def code(polynomial: Any) -> str:
        return write_polynomial(polynomial, names, CODE)

    return {
        "schema": "gsp.derive/1",
        "case": triangular.case,
        "title": triangular.title,
        "source": triangular.source,
        "unknowns": list(names),
        "parameters": list(triangular.parameters),
        "system": [
            {"name": item.name, "polynomial": code(item.polynomial)} for item in triangular.system
        ],
        "solutions": triangular.solutions,
        "set": [
            {
                "name": item.name,
                "leading": item.leading,
                "degree": item.degree,
                "polynomial": code(item.polynomial),
                "initial": code(item.initial),
            }
            for item in triangular.elements
        ],
        "coefficients": [
            {
                "symbol": item.symbol,
                "value": write_definition(item, CODE),
                "terms": len(item.numerator),
            }
            for item in triangular.definitions
        ],
        "steps": [
            {"name": item.name, "polynomial": code(item.polynomial)} for item in triangular.steps
        ],
        "conditions": [
            {
                "polynomial": code(item.polynomial),
                "initial_of": list(item.elements),
                "if_zero": item.meaning,
            }
            for item in triangular.conditions
        ],
        "notes": list(triangular.notes),
    }


def to_latex(triangular: TriangularSet) -> str:
    """Return a triangular set as a fragment of LaTeX for amsmath, long sums broken into lines."""
    names = triangular.variables

    def zero(polynomial: Any) -> str:
        return write_polynomial(polynomial, names, LATEX) + " = 0"

    order = " < ".join(LATEX.symbol(name) for name in names)
    lines = [
        f"% {triangular.case}: {triangular.title} ({triangular.source})",
        f"% unknowns {' < '.join(names)}; {triangular.solutions} solutions",
        *_aligned(f"& {zero(item.polynomial)}" for item in triangular.system),
        f"Under the order ${order}$ this becomes",
        *_aligned(
            f"{LATEX.symbol(item.name)} &= {zero(item.polynomial)}" for item in triangular.elements
        ),
    ]
    if triangular.definitions:
        lines += [
            "with",
            *_aligned(
                f"{LATEX.symbol(item.symbol)} &= {write_definition(item, LATEX)}"
                for item in triangular.definitions
            ),
        ]
    if triangular.conditions:
        lines += [
            "provided that none of these vanishes:",
            *_aligned(
                f"& {write_polynomial(item.polynomial, names, LATEX)}"
                for item in triangular.conditions
            ),
        ]
    return "\n".join(lines) + "\n"


def _aligned(rows: Any) -> list[str]:
    broken = (line for row in rows for line in _broken(row))
    return [r"\begin{align*}", " \\\\\n".join(f"  {line}" for line in broken), r"\end{align*}"]


def _broken(row: str) -> list[str]:
    """Return a row in lines that TeX can measure, broken before terms outside of brackets."""
    lines, start, depth = [], 0, 0
    for position, character in enumerate(row):
        depth += (character in "({") - (character in ")}")
        new_term = depth == 0 and row[position : position + 3] in (" + ", " - ")
        if new_term and position - start > _WIDEST:
            lines.append(row[start:position])
            start = position
    continued = [rf"& \quad {line.strip()}" for line in [*lines[1:], row[start:]]]
    return [lines[0], *continued] if lines else [row]


def _count(triangular: TriangularSet) -> str:
    product = "·".join(str(degree) for degree in triangular.degrees)
    plural = "s" if triangular.solutions > 1 else ""
    return f"{product} = {triangular.solutions} solution{plural}"


def _role(condition: NonVanishing) -> str:
    if not condition.elements:
        return "divisor in the elimination"
    plural = "s" if len(condition.elements) > 1 else ""
    return f"initial{plural} of {', '.join(condition.elements)}"


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


@dataclass(frozen=True, eq=False)
class Derivation:
    """A case of Section 6, solved.

    Attributes
    ----------
    triangular
        Its triangular set.
    expanded
        Whether its coefficients are written in the parameters alone.
    """

    triangular: TriangularSet
    expanded: bool = False

    def __reduce__(self) -> tuple[Any, ...]:
        # Expressions of SymPy change while they are written: the case is derived again.
        return _derived, (self.triangular.case, self.expanded)

    def __repr__(self) -> str:
        found = self.triangular
        degrees = "·".join(map(str, found.degrees))
        return f"<Derivation of {found.case}: degrees {degrees}, {found.solutions} solutions>"

    def __str__(self) -> str:
        return to_text(self.triangular)

    def to_frame(self) -> pd.DataFrame:
        """Return a row for each polynomial of the set (pandas is imported now)."""
        import pandas as pd

        return pd.DataFrame(self.to_json()["set"])

    def to_json(self) -> dict[str, Any]:
        """Return everything as plain data of schema ``gsp.derive/1``."""
        return to_document(self.triangular)

    def to_latex(self) -> str:
        """Return a fragment of LaTeX for amsmath."""
        return to_latex(self.triangular)


def derive(case: str, *, expand: bool = False) -> Derivation:
    """Derive the triangular set of a case of the paper's Section 6.

    Parameters
    ----------
    case
        An intersection of three surfaces (P plane, S sphere, C cylinder), as ``PSC``; ``AAA`` for
        three angles; or ``6.2`` or ``6.8`` for the example of that number.
    expand
        Whether every coefficient is written in the parameters alone.

    Raises
    ------
    GspError
        If it is none of the cases, or one that is not written out (CCC, SCC).
    """
    name = parse_case(case)
    return _derived(name, expand)


def _derived(case: str, expanded: bool) -> Derivation:
    return Derivation(expand_case(case) if expanded else triangular_set(case), expanded)
