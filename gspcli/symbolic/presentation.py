"""Triangular sets as documents: plain text, LaTeX, and the JSON of `gsp derive`."""

from __future__ import annotations

from typing import Any

from gspcli.symbolic.notation import CODE, LATEX, TEXT, write_definition, write_polynomial
from gspcli.symbolic.triangular import NonVanishing, TriangularSet

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
