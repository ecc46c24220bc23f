"""Errata: numbers and formulas of the paper that are wrong or can be sharpened, with proofs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from typing import Literal

from gspcli.errors import CheckFailed
from gspcli.paper import errata_proofs as proofs
from gspcli.paper.printed import Difference
from gspcli.records import dataclass


@dataclass(frozen=True)
class Erratum:
    """A statement of the paper that does not hold, or that holds and can be sharpened.

    Attributes
    ----------
    key
        A stable name.
    sort
        ``wrong``; ``sharpened``: true, but not the best; or ``slip``: a misprint, or words that do
        not fit the formulas.
    place
        The place in the paper.
    printed, correct
        The printed and the correct statement.
    argument
        The reason, in a sentence or two.
    proof
        A function that proves it and returns its evidence; raises `CheckFailed` otherwise.
    """

    key: str
    sort: Literal["wrong", "sharpened", "slip"]
    place: str
    printed: str
    correct: str
    argument: str
    proof: Callable[[], str]

    def document(self) -> dict[str, str]:
        """Return the texts of the erratum by name."""
        return {name: text for name, text in asdict(self).items() if name != "proof"}


def erratum_of(difference: Difference) -> str | None:
    """Return the key of the erratum that explains a difference of a table, or None."""
    if difference.table == 1 and (difference.row, difference.column) == ("solution 8", "r21"):
        return "table-1-sign"
    if difference.table == 2 and difference.column in "xy":
        return "table-2-exchanged"
    if difference.table == 3 and difference.row in ("case PSS", "case CCC"):
        return "table-3-columns"
    return None


ERRATA: tuple[Erratum, ...] = (
    Erratum(
        "class-size",
        "wrong",
        "Section 1, page 66",
        "a class of 1220 GSPs has analytical solutions",
        "1120",
        "The class is 3D3A, counted in Proposition 2.2 and in the abstract.",
        proofs.class_size,
    ),
    Erratum(
        "figure-2",
        "wrong",
        "Section 2, page 67, Figure 2",
        "this platform has at most four solutions",
        "at most four for each choice of signs of its three distances, 32 in all",
        "A distance of two lines is the modulus of a signed one, as that of a point and a plane. "
        "The three angles leave four rotations, and each choice of signs one position.",
        proofs.figure_2,
    ),
    Erratum(
        "mourrain-degree",
        "wrong",
        "Section 3, page 69",
        "the variety of Mourrain in 25 coordinates has degree 40",
        "84; the one in 16 coordinates has 40",
        "Theorem 5.2 holds all the same: its constraints use the 16 coordinates R, T, U, ρ only.",
        proofs.degree_of_mourrain,
    ),
    Erratum(
        "equation-5",
        "slip",
        "Section 4, page 69, equation (5), second line",
        "2[T, RᵀY]",
        "2[T, RY]",
        "[T, RY] = [Y, RᵀT], as in the third line.",
        proofs.printed("equation_5"),
    ),
    Erratum(
        "dll-vectors",
        "slip",
        "Section 4, page 70, DLL",
        "u_i a unit vector parallel to L_i, then v_1 and v_2 in the equation",
        "the same vectors",
        "The equation is that of the distance with v_i = u_i.",
        proofs.printed("distance_of_lines"),
    ),
    Erratum(
        "normals-of-lines",
        "slip",
        "Section 4, page 71, ALH and AHL; page 72, proof of Theorem 5.2",
        "the unit normal vector of a line",
        "a unit vector parallel to the line",
        "A line has no one normal vector; the equations need its direction.",
        proofs.printed("directions_of_lines"),
    ),
    Erratum(
        "proposition-4-1",
        "sharpened",
        "Proposition 4.1, page 71",
        "DLP, DHP and DLL constraints are of degree four",
        "DLP and DHP are of degree two (a one-sided DHP of degree one), DLL of degree two in "
        "Mourrain's 25 coordinates",
        "True, but not the lowest degrees. U = RᵀT makes the plane of a DHP linear and the "
        "cylinder of a DLP quadratic; the mutual moment of two lines is linear in R and T×R. In "
        "Lazard's coordinates four is the lowest degree of a DLL.",
        proofs.lowest_degrees,
    ),
    Erratum(
        "proof-of-5-2",
        "slip",
        "Proof of Theorem 5.2, page 72",
        "By (??), the last equation is of degree two",
        "by the equation of DPL in Section 4, which has no number",
        "A reference that was not resolved.",
        proofs.proof_of_5_2,
    ),
    Erratum(
        "citations",
        "slip",
        "Proofs of Theorems 5.2 and 5.3, page 72",
        "Following Mourrain's treatment [18], Following Lazard's treatment [18]",
        "[15] and [12]",
        "[18] is Stewart's paper of 1965. Section 3 introduces the variety of Mourrain with [15] "
        "and that of Lazard with [12].",
        proofs.citations,
    ),
    Erratum(
        "proof-of-5-3",
        "slip",
        "Proof of Theorem 5.3, page 72",
        "20 · 2 · 2^s · 2^k = 80",
        "20 · 2 · 2^m · 4^s = 80",
        "k is not defined, and s counts the constraints of degree four.",
        proofs.proof_of_5_3,
    ),
    Erratum(
        "after-5-3",
        "slip",
        "After the proof of Theorem 5.3, page 72",
        "[T, T] = l1",
        "[T, T] = d1²",
        "It is the first equation of (9) with Y1 = X1 = 0; there is no l1.",
        proofs.printed("first_distance"),
    ),
    Erratum(
        "page-72",
        "wrong",
        "After the proof of Theorem 5.3, page 72",
        "a class of GSPs the maximal number of solutions for which is 20",
        "8",
        "The class is that of Theorem 5.4. Its bound of 20 holds, and is never attained.",
        proofs.page_72,
    ),
    Erratum(
        "theorem-5-4",
        "sharpened",
        "Theorem 5.4, page 73",
        "at most 20 feasible solutions",
        "at most 8",
        "True, but not the best. One-sided DPH and angles are linear in R and T alone, so the "
        "variety in these twelve coordinates serves in place of Lazard's.",
        proofs.theorem_5_4,
    ),
    Erratum(
        "section-6-1",
        "slip",
        "Section 6.1, page 74",
        "cos(∠(RL1, L4)) = d1, … with L1, L2, L3 on the base",
        "cos(∠(L1, RL4)) = d1, …",
        "R turns the lines of the platform, L4, L5 and L6, as in equation (11).",
        proofs.printed("turned_directions"),
    ),
    Erratum(
        "equation-12",
        "wrong",
        "Equation (12), page 74, second polynomial",
        "h2 of degree 3 in r32 in both coefficients (z20 … z27)",
        "degree 3 in the coefficient of r31, degree 4 in the other",
        "The elimination gives degree 4, and no polynomial of the printed shape vanishes at the "
        "eight rotations.",
        proofs.printed("equation_12"),
    ),
    Erratum(
        "table-1-sign",
        "wrong",
        "Table 1, page 76, solution 8, r21",
        "(3 − √5)/(2(−1 + √5))",
        "(1 − √5)/4, which is the negative",
        "The printed matrix is not orthogonal. (Read from a text layer with flattened fractions; "
        "the sign of the numerator decides.)",
        proofs.table_1,
    ),
    Erratum(
        "equation-14",
        "slip",
        "Algorithm 6.6, equation (14), page 78",
        "L2(x + x1 − x2, …), and index 2 again in the third line",
        "L2(x + x2 − x1, …), L3(x + x3 − x1, …)",
        "Under a fixed orientation p2' = p1' + (p2 − p1) is the point that lies on L2.",
        proofs.printed("equation_14"),
    ),
    Erratum(
        "equation-15",
        "slip",
        "Equation (15), page 78",
        "… + (d12·y + d13·x + d14)z + (d15·z + d16)y + …",
        "… + (d12·y + d13·x + d14)z + (d15·x + d16)y + …",
        "The printed quadric has two terms in yz and none in xy.",
        proofs.printed("equation_15"),
    ),
    Erratum(
        "equation-16",
        "slip",
        "Equation (16), page 78, third polynomial",
        "d3·z + d2·y + d1·z + d4",
        "d3·z + d2·y + d1·x + d4",
        "It is the plane of (15).",
        proofs.printed("equation_16"),
    ),
    Erratum(
        "equation-18",
        "wrong",
        "Equation (18), page 79",
        "2x² + r2² − r3² − r1², 2y² + r3² − r1² − r2²",
        "2x² + r3² − r2² − r1², 2y² + r2² − r1² − r3²",
        "r2 and r3 are exchanged against equation (17).",
        proofs.printed("equation_18"),
    ),
    Erratum(
        "table-2-exchanged",
        "wrong",
        "Table 2, page 79",
        "x = ±3√10/2, y = ±3√6/2",
        "x = ±3√6/2, y = ±3√10/2",
        "The consequence of equation (18): the points are those for r2 = 5, r3 = 4.",
        proofs.table_2,
    ),
    Erratum(
        "table-3-columns",
        "wrong",
        "Table 3, page 80, cases PSS and CCC",
        "PP PP PP under PSS; LL LP LP under CCC",
        "PH PP PP; LP LP LP",
        "Each of the 56 triples belongs to one case; the two printed ones stand in their own "
        "cases, SSS and PCC, as well.",
        proofs.table_3,
    ),
    Erratum(
        "table-3-lines",
        "wrong",
        "Table 3, page 80, columns with LL",
        "the maximal number of solutions N1, 8 for LL LL LL",
        "N1 for one orientation of each pair of lines; 2^k N1 for k pairs, 64 for LL LL LL",
        "Under a given orientation a DLL leaves two planes (page 77). N1 counts one of them, and a "
        "distance of lines, which has no sign, allows both.",
        proofs.lines_of_table_3,
    ),
    Erratum(
        "captions",
        "slip",
        "Figures 5 and 6, page 81, captions",
        "point/point and point/line distance constraint",
        "both are realizations of the point/plane distance, as Section 7 says",
        "The chain of a spherical and a planar joint fixes the distance of a point to a plane.",
        proofs.captions,
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
