"""The ten intersections of three surfaces as triangular sets (paper, Proposition 6.7).

Planes, spheres and cylinders are those of equation (15), the cylinder being any quadric. The
unknowns are the coordinates of a point, ``x < y < z`` as in equation (16).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from gspcli.symbolic import eliminations
from gspcli.symbolic.eliminations import Reduction
from gspcli.symbolic.sparse_polynomials import Polynomial
from gspcli.symbolic.triangular import Elimination, Relation, TriangularPolynomial, TriangularSet

VARIABLES = ("x", "y", "z")

#: The monomials that the coefficients of each surface belong to, as in equation (15).
_FORMS = {
    "P": ("x", "y", "z", ""),
    "S": ("x", "y", "z", ""),
    "C": ("x x", "y y", "z z", "y z", "x z", "z", "x y", "y", "x", ""),
}
_WORDS = {"P": "plane", "S": "sphere", "C": "cylinder"}
_METHODS: dict[str, Callable[[Elimination, Sequence[Polynomial]], Reduction]] = {
    "PPP": eliminations.three_planes,
    "PPC": eliminations.line_and_quadric,
    "PPS": eliminations.line_and_quadric,
    "SSS": eliminations.three_spheres,
    "PSS": eliminations.plane_and_two_spheres,
    "PCC": eliminations.two_conics,
    "SSC": eliminations.two_spheres,
    "PSC": eliminations.two_conics,
    "CCC": eliminations.three_quadrics,
    "SCC": eliminations.three_quadrics,
}
#: The intersections in the order of Table 3.
INTERSECTIONS = tuple(_METHODS)
_SYMBOLS = {letter: [f"{letter}{i}" for i in range(1, 60)] for letter in "kz"}

_CYLINDER_NOTE = (
    "C is any quadric. For the cylinder of radius r about the line through a along u it is "
    "|u|²|p − a|² − (u·(p − a))² − |u|²r² with p = (x, y, z)."
)
_NOTES = {
    "PCC": ("For cylinders about u and v, z6 has the factor |u × v|²: 0 if they are parallel.",),
    "PSC": (
        "The paper prints the third polynomial of (16) with d1·z in place of d1·x.",
        "For a plane with normal n and a cylinder about u, z6 = |n × u|⁴: 0 if they meet in a "
        "circle, which meets the sphere in two points at infinity.",
    ),
    "SCC": (
        "h1 is k1³ times the resultant. For cylinders about u and v, k1 is "
        "2(u2·v2 + u3·v3)(u2·v3 − u3·v2); where it is 0, turn the axes of coordinates.",
    ),
    "CCC": (
        "h1 is k1³ times the resultant. Where k1 is 0, as in Example 6.8, turn the axes of "
        "coordinates.",
    ),
}


def derive_intersection(case: str) -> TriangularSet:
    """Derive the triangular set of one of the `INTERSECTIONS`."""
    parameters = [f"d{i}" for i in range(1, sum(len(_FORMS[letter]) for letter in case) + 1)]
    ring = Elimination(VARIABLES, parameters, _SYMBOLS)
    letters = iter(ring[" ".join(parameters)])
    surfaces = [_surface(ring, letter, letters) for letter in case]
    reduction = _METHODS[case](ring, surfaces)
    notes = _NOTES.get(case, ())
    return TriangularSet(
        case=case,
        title=_title(case),
        source="Proposition 6.7" + (", equation (16)" if case == "PSC" else ""),
        variables=VARIABLES,
        parameters=tuple(parameters),
        system=tuple(map(Relation, _names(case), surfaces)),
        definitions=tuple(ring.definitions),
        elements=tuple(
            map(TriangularPolynomial, ("h1", "h2", "h3"), VARIABLES, reduction.elements)
        ),
        conditions=reduction.conditions,
        steps=reduction.steps,
        notes=(*notes, _CYLINDER_NOTE) if "C" in case else notes,
    )


def derive_example_6_8() -> TriangularSet:
    """Derive the triangular set (18): the three cylinders (17) are linear in the squares."""
    parameters = ("r1", "r2", "r3")
    ring = Elimination(VARIABLES, parameters, {})
    x, y, z = ring["x y z"]
    r1, r2, r3 = ring["r1 r2 r3"]
    cylinders = (x**2 + y**2 - r1**2, x**2 + z**2 - r2**2, y**2 + z**2 - r3**2)
    value, rests = eliminations.cramer(cylinders, VARIABLES, ((2, 0, 0), (0, 2, 0), (0, 0, 2)))
    squares = [-(value * unknown**2 + rest) for unknown, rest in zip((x, y, z), rests, strict=True)]
    return TriangularSet(
        case="6.8",
        title="three cylinders about the axes of coordinates",
        source="Example 6.8, equations (17) and (18)",
        variables=VARIABLES,
        parameters=parameters,
        system=tuple(map(Relation, _names("CCC"), cylinders)),
        definitions=(),
        elements=tuple(map(TriangularPolynomial, ("h1", "h2", "h3"), VARIABLES, squares)),
        conditions=(),
        notes=(
            "The paper prints (18), and Table 2, with r2 and r3 exchanged.",
            "The initials are constants: the set always describes all the solutions, with "
            "multiplicity where x, y or z is 0.",
        ),
    )


def _surface(ring: Elimination, letter: str, letters: Iterator[Polynomial]) -> Polynomial:
    x, y, z = ring["x y z"]
    surface = x**2 + y**2 + z**2 if letter == "S" else ring.ring.zero
    for form in _FORMS[letter]:
        term = next(letters)
        for variable in ring[form]:
            term *= variable
        surface += term
    return surface


def _names(case: str) -> list[str]:
    """Return S1, S2, P for SSP: numbered where a letter is not alone."""
    return [
        letter + (str(case[: i + 1].count(letter)) if case.count(letter) > 1 else "")
        for i, letter in enumerate(case)
    ]


def _title(case: str) -> str:
    articles = ("", "a ", "two ", "three ")
    words = [
        f"{articles[case.count(letter)]}{_WORDS[letter]}{'s' if case.count(letter) > 1 else ''}"
        for letter in dict.fromkeys(case)
    ]
    return " and ".join(words) if len(words) < 3 else f"{', '.join(words[:-1])} and {words[-1]}"
