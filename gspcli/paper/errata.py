"""Where the paper's numbers and formulas are wrong, each with a proof that runs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass

from gspcli.catalogue.bounds import type_bounds
from gspcli.catalogue.constraints import constraint_facts
from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPP, KINDS_BY_NAME
from gspcli.catalogue.realization import realization
from gspcli.catalogue.types import CLASSES, all_types
from gspcli.catalogue.varieties import LAZARD, MOURRAIN, MOURRAIN_16, varieties
from gspcli.errors import CheckFailed
from gspcli.paper import table1, table2, table3
from gspcli.paper.printed import Difference


@dataclass(frozen=True)
class Erratum:
    """A statement of the paper that does not hold.

    Attributes
    ----------
    key
        A stable name.
    place
        Where in the paper.
    printed, correct
        What it says and what holds.
    argument
        Why, in a sentence or two.
    proof
        A program that establishes it and returns its evidence; raises `CheckFailed` otherwise.
    """

    key: str
    place: str
    printed: str
    correct: str
    argument: str
    proof: Callable[[], str]

    def document(self) -> dict[str, str]:
        """Return the texts of the erratum by name."""
        return {name: text for name, text in asdict(self).items() if name != "proof"}


def erratum_of(difference: Difference) -> str | None:
    """Return the key of the erratum that accounts for a difference of a table, or None."""
    if difference.table == 1 and (difference.row, difference.column) == ("solution 8", "r21"):
        return "table-1-sign"
    if difference.table == 2 and difference.column in "xy":
        return "table-2-exchanged"
    if difference.table == 3 and difference.row in ("case PSS", "case CCC"):
        return "table-3-columns"
    return None


def _require(condition: bool, message: str) -> None:
    if not condition:
        raise CheckFailed(message)


def _class_size() -> str:
    counted = sum(gsp_type.platform_class == CLASSES[0] for gsp_type in all_types())
    _require(counted == CLASSES[0].size, f"{counted} types enumerated")
    _require(counted != 1220, "the printed number is right")
    return f"enumeration and the binomials of Proposition 2.2 both give {counted}"


def _degree_of_mourrain() -> str:
    from gspcli.symbolic.coordinates import system
    from gspcli.symbolic.varieties import hilbert_function, sampled_hilbert_function

    large, small = varieties()[MOURRAIN], varieties()[MOURRAIN_16]
    _require(small.degree == 40, f"16 coordinates: degree {small.degree}")
    _require(large.degree != 40, "the printed number is right")
    wanted = [
        hilbert_function(large.hilbert_numerator, large.dimension, degree) for degree in (1, 2)
    ]
    ranks = [
        sampled_hilbert_function(system(MOURRAIN), degree, wanted[-1] + 20) for degree in (1, 2)
    ]
    _require(wanted == ranks, f"Hilbert function {wanted}, ranks at random motions {ranks}")
    return (
        f"Singular: degree {large.degree} in 25 coordinates, {small.degree} in 16; the Hilbert "
        f"function of the former, {wanted} in degrees 1 and 2, is found again at random motions"
    )


def _lowest_degrees() -> str:
    from gspcli.symbolic.constraints import lowest_degree

    found = []
    for kind in (DHP, DLP, DLL):
        facts = constraint_facts(kind)
        derived = lowest_degree(kind)
        _require(derived.degree == facts.lowest.two_sided, f"{kind}: {derived.degree} derived")
        _require(derived.degree < facts.paper_mourrain.two_sided, f"{kind} is as printed")
        found.append(f"{kind} {derived.degree} in {facts.lowest_coordinates}")
    return f"equations derived and exactly checked: {'; '.join(found)}"


def _theorem_5_4() -> str:
    types = [t for t in all_types() if type_bounds(t).theorem_5_4 is not None]
    bounds = {type_bounds(t).refined_one_sided.value for t in types}
    printed = varieties()[LAZARD].degree
    _require(len(types) == 35, f"{len(types)} types")
    _require(max(bounds) < printed, f"bounds {bounds}")
    degree = varieties()["R,T"].degree
    _require(bounds == {degree}, f"bounds {bounds}, degree {degree}")
    return (
        f"all {len(types)} types are linear in (R, T), where the motions have degree {degree}: "
        f"at most {degree} solutions instead of {printed}"
    )


def _table_1() -> str:
    from gspcli.symbolic.printed_section_6 import table_1 as prove_row

    (difference,) = table1.differences()
    row = int(difference.row.removeprefix("solution ")) - 1
    return prove_row(table1.printed()[row], table1.compute()[row])


def _table_2() -> str:
    from gspcli.symbolic.printed_section_6 import table_2 as prove_points

    return prove_points(table2.printed(), table2.compute())


def _section_6(name: str) -> Callable[[], str]:
    def proof() -> str:
        from gspcli.symbolic import printed_section_6

        evidence: str = getattr(printed_section_6, name)()
        return evidence

    return proof


def _table_3() -> str:
    counted: dict[str, int] = {}
    for difference in table3.differences():
        case = difference.row.removeprefix("case ")
        surfaces = "".join(sorted(_surface_letters(difference.printed.split()), key="PSC".index))
        _require(surfaces != case, f"{difference.printed} is of case {case}")
        counted[difference.printed] = counted.get(difference.printed, 0) + 1
    printed = [str(entry) for entry in table3.printed()]
    _require(len(printed) == len(table3.compute()) == 56, "56 triples")
    for wrong in counted:
        _require(printed.count(wrong) == 2, f"{wrong} is printed {printed.count(wrong)} times")
    return f"{' and '.join(counted)} are each printed in two cases; both have other surfaces"


def _surface_letters(names: list[str]) -> list[str]:
    return [constraint_facts(KINDS_BY_NAME[f"D{name}"]).surface or "" for name in names]


def _captions() -> str:
    chains = {kind: realization(kind).chain.name for kind in (DPP, DPH)}
    _require(chains[DPP] != chains[DPH], f"{chains}")
    return (
        f"the chain in the figures, {chains[DPH]}, keeps exactly the point/plane distance when "
        f"its driver is held; point/point is {chains[DPP]} of Figure 9"
    )


ERRATA: tuple[Erratum, ...] = (
    Erratum(
        "class-size",
        "Section 1, page 66",
        "a class of 1220 GSPs has analytical solutions",
        "1120",
        "The class is 3D3A, counted in Proposition 2.2 and in the abstract.",
        _class_size,
    ),
    Erratum(
        "mourrain-degree",
        "Section 3, page 69",
        "the variety of Mourrain in 25 coordinates has degree 40",
        "84; the one in 16 coordinates has 40",
        "Theorem 5.2 holds all the same: its constraints use the 16 coordinates R, T, U, ρ only.",
        _degree_of_mourrain,
    ),
    Erratum(
        "proposition-4-1",
        "Proposition 4.1, page 71",
        "DLP, DHP and DLL constraints are of degree four",
        "DLP and DHP are of degree two (a one-sided DHP of degree one), DLL of degree two in "
        "Mourrain's 25 coordinates",
        "U = RᵀT makes the plane of a DHP linear and the cylinder of a DLP quadratic; the mutual "
        "moment of two lines is linear in R and T×R. In Lazard's coordinates four is the lowest "
        "degree of a DLL.",
        _lowest_degrees,
    ),
    Erratum(
        "theorem-5-4",
        "Theorem 5.4, page 73",
        "at most 20 feasible solutions",
        "at most 8",
        "One-sided DPH and angles are linear in R and T alone, so the variety in these twelve "
        "coordinates serves in place of Lazard's.",
        _theorem_5_4,
    ),
    Erratum(
        "equation-12",
        "Equation (12), page 74, second polynomial",
        "h2 of degree 3 in r32 in both coefficients (z20 … z27)",
        "degree 3 in the coefficient of r31, degree 4 in the other",
        "The elimination gives degree 4, and no polynomial of the printed shape vanishes at the "
        "eight rotations.",
        _section_6("equation_12"),
    ),
    Erratum(
        "table-1-sign",
        "Table 1, page 76, solution 8, r21",
        "(3 − √5)/(2(−1 + √5))",
        "(1 − √5)/4, which is the negative",
        "The printed matrix is not orthogonal. (Read from a text layer with flattened fractions; "
        "the sign of the numerator decides.)",
        _table_1,
    ),
    Erratum(
        "equation-14",
        "Algorithm 6.6, equation (14), page 78",
        "L2(x + x1 − x2, …), and index 2 again in the third line",
        "L2(x + x2 − x1, …), L3(x + x3 − x1, …)",
        "Under a fixed orientation p2' = p1' + (p2 − p1) is the point that lies on L2.",
        _section_6("equation_14"),
    ),
    Erratum(
        "equation-15",
        "Equation (15), page 78",
        "… + (d12·y + d13·x + d14)z + (d15·z + d16)y + …",
        "… + (d12·y + d13·x + d14)z + (d15·x + d16)y + …",
        "The printed quadric has two terms in yz and none in xy.",
        _section_6("equation_15"),
    ),
    Erratum(
        "equation-16",
        "Equation (16), page 78, third polynomial",
        "d3·z + d2·y + d1·z + d4",
        "d3·z + d2·y + d1·x + d4",
        "It is the plane of (15).",
        _section_6("equation_16"),
    ),
    Erratum(
        "equation-18",
        "Equation (18), page 79",
        "2x² + r2² − r3² − r1², 2y² + r3² − r1² − r2²",
        "2x² + r3² − r2² − r1², 2y² + r2² − r1² − r3²",
        "r2 and r3 are exchanged against equation (17).",
        _section_6("equation_18"),
    ),
    Erratum(
        "table-2-exchanged",
        "Table 2, page 79",
        "x = ±3√10/2, y = ±3√6/2",
        "x = ±3√6/2, y = ±3√10/2",
        "The consequence of equation (18): the points are those for r2 = 5, r3 = 4.",
        _table_2,
    ),
    Erratum(
        "table-3-columns",
        "Table 3, page 80, cases PSS and CCC",
        "PP PP PP under PSS; LL LP LP under CCC",
        "PH PP PP; LP LP LP",
        "Each of the 56 triples belongs to one case; the two printed ones stand in their own "
        "cases, SSS and PCC, as well.",
        _table_3,
    ),
    Erratum(
        "captions",
        "Figures 5 and 6, page 81, captions",
        "point/point and point/line distance constraint",
        "both are realizations of the point/plane distance, as Section 7 says",
        "The chain of a spherical and a planar joint fixes the distance of a point to a plane.",
        _captions,
    ),
)


def prove(erratum: Erratum) -> str:
    """Run the proof of an erratum and return its evidence.

    Raises
    ------
    CheckFailed
        If the proof does not succeed.
    """
    try:
        return erratum.proof()
    except CheckFailed as failure:
        message = f"erratum {erratum.key} is not proved: {failure}"
        raise CheckFailed(message) from failure
