"""Errata: numbers and formulas of the paper that are wrong or can be sharpened, with proofs.

Every proof returns its evidence in a sentence and raises `CheckFailed` if there is none.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import asdict
from math import comb
from typing import TYPE_CHECKING, Literal

import numpy as np

from gspcli.catalogue.bounds import LAZARD, MOURRAIN, MOURRAIN_16, type_bounds, varieties
from gspcli.catalogue.constraints import constraint_facts
from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP, KINDS_BY_NAME
from gspcli.catalogue.realization import realization
from gspcli.catalogue.types import CLASSES, GspType, all_types
from gspcli.defaults import SEED
from gspcli.errors import CheckFailed
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.measurement import polynomial
from gspcli.geometry.quaternions import Field
from gspcli.geometry.random_instances import random_instance
from gspcli.paper.tables import (
    Entry,
    differences,
    differences_3,
    printed_table,
    printed_table_3,
    table_1,
    table_2,
    table_3,
)
from gspcli.progress import Progress, silent
from gspcli.records import dataclass

if TYPE_CHECKING:
    from gspcli.solver import SolveResult


@dataclass(frozen=True)
class Confirmation:
    """The result of a confirmation."""

    #: The numbers of families and instances; every instance had the number of its family.
    families: int
    instances: int


def confirm(*, instances: int = 2, seed: int = SEED, progress: Progress = silent) -> Confirmation:
    """Solve random one-sided instances of every family of Table 3.

    The angles vary over the twenty types of each family. Every combination of a rotation with one
    of the two planes of each DLL must have the number of positions that makes up N1.

    Parameters
    ----------
    instances
        The number of instances of each family.
    seed
        The seed of the instances.
    progress
        Called with the families.

    Raises
    ------
    CheckFailed
        At the first instance with another number of solutions.
    """
    entries = table_3()
    rng = np.random.default_rng(seed)
    for index, entry in enumerate(progress(entries, total=len(entries), label="Table 3")):
        types = entry.family.types
        for turn in range(instances):
            gsp_type = types[(index * instances + turn) % len(types)]
            _confirm_instance(entry, gsp_type, rng)
    return Confirmation(len(entries), len(entries) * instances)


def _confirm_instance(entry: Entry, gsp_type: GspType, rng: np.random.Generator) -> None:
    from gspcli.solver import solve

    instance, _ = random_instance(gsp_type, rng, one_sided=True)
    result = solve(instance)
    counted = Counter(_branches(result))
    rotations = {rotation for rotation, _ in counted}
    planes = 2 ** gsp_type.count(DLL)
    wanted = {entry.n1 // len(rotations)}
    if (
        result.verdict != "complete"
        or len(counted) != len(rotations) * planes
        or set(counted.values()) != wanted
        or sum(counted.values()) != entry.n1 * planes
    ):
        raise CheckFailed(
            f"{gsp_type}: Table 3 says {entry.n1} one-sided solutions, a random instance has "
            f"{sum(counted.values())} over {planes} choices of planes ({result.verdict})"
        )


def _branches(result: SolveResult) -> list[tuple[int, tuple[int, ...]]]:
    """Return for each solution its rotation and, for each DLL, its plane of the two."""
    arrangement = Arrangement.of(result.instance)
    lines = [i for i, kind in enumerate(arrangement.kinds) if kind is DLL]
    moments = (
        np.stack([_mutual_moment(arrangement, i, result.R, result.T) for i in lines], axis=-1)
        if lines
        else np.zeros((len(result.R), 0), complex)
    )
    representatives: list[int] = []
    branches = []
    for k, rotation in enumerate(result.R):
        near = (r for r in representatives if np.allclose(result.R[r], rotation, atol=1e-6))
        first = next(near, k)
        if first == k:
            representatives.append(k)
        # Under one rotation the moment of a line is plus or minus one number.
        signs = np.sign((moments[k] * moments[first].conj()).real).astype(int)
        branches.append((first, tuple(int(sign) for sign in signs)))
    return branches


def _mutual_moment(arrangement: Arrangement, i: int, R: Field, T: Field) -> Field:
    """Return the mutual moment of the lines of a DLL at poses, shape (n,)."""
    r, w, _ = arrangement.placed(R, T)
    return polynomial(DLL).value(r[:, i], w[:, i], arrangement.v[i])


def _require(condition: bool, message: str) -> None:
    if not condition:
        raise CheckFailed(message)


def class_size() -> str:
    """Prove the size of the class 3D3A."""
    counted = sum(gsp_type.platform_class == CLASSES[0] for gsp_type in all_types())
    _require(counted == CLASSES[0].size, f"{counted} types enumerated")
    _require(counted != 1220, "the printed number is right")
    return f"enumeration and the binomials of Proposition 2.2 both give {counted}"


def degree_of_mourrain() -> str:
    """Prove that the variety in 25 coordinates has degree 84, twice, and the one in 16 has 40."""
    from gspcli.symbolic.exact_motions import hilbert_function, sampled_hilbert_function

    # The degrees of x^6 and h x^5: coefficients of t^3 and t^2 in 1 / ((1 - t)^4 (1 - 2t)).
    x6, hx5 = (sum(comb(i + 3, 3) * 2 ** (n - i) for i in range(n + 1)) for n in (3, 2))
    derived = 2 * x6 - 2 * hx5
    large, small = varieties()[MOURRAIN], varieties()[MOURRAIN_16]
    _require(small.degree == 40, f"16 coordinates: degree {small.degree}")
    _require(large.degree != 40, "the printed number is right")
    _require(large.degree == derived, f"x^5 (2x - 2h) = {derived}")
    wanted = [
        hilbert_function(large.hilbert_numerator, large.dimension, degree) for degree in (1, 2)
    ]
    ranks = [sampled_hilbert_function(MOURRAIN, degree, wanted[-1] + 20) for degree in (1, 2)]
    _require(wanted == ranks, f"Hilbert function {wanted}, ranks at random motions {ranks}")
    return (
        "in the notation of docs/counts.md the degree is "
        f"x⁵(2x − 2h) = {derived}. Five of the linear functions are general ones of 1, "
        "R, T, U, T×R; their space has no base points. The sixth has ρ; its base points are on "
        "g = f.f = 0 and so not on the curve of the five. Singular: degree "
        f"{large.degree} in 25 coordinates, {small.degree} in 16; the Hilbert function of the "
        f"former, {wanted} in degrees 1 and 2, is found again at random motions"
    )


def lowest_degrees() -> str:
    """Prove the lowest degrees of DHP, DLP and DLL."""
    from gspcli.symbolic.printed_sections import quadratic_equation

    found = []
    for kind in (DHP, DLP, DLL):
        facts = constraint_facts(kind)
        _require(facts.lowest.two_sided == 2, f"{kind}: {facts.lowest.two_sided} recorded")
        _require(facts.paper_mourrain.two_sided > 2, f"{kind} is as printed")
        coordinates = quadratic_equation(kind)
        _require(coordinates == facts.lowest_coordinates, f"{kind}: in {coordinates}")
        found.append(f"{kind} 2 in {coordinates}")
    return f"equations derived and exactly checked: {'; '.join(found)}"


def theorem_5_4() -> str:
    """Prove the bound of the types of Theorem 5.4."""
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


def entry_of_table_1() -> str:
    """Prove the entry of Table 1."""
    from gspcli.symbolic.printed_sections import table_1 as prove_row

    (difference,) = differences(1, table_1())
    row = int(difference.row.removeprefix("solution ")) - 1
    return prove_row(printed_table(1)[row], table_1()[row])


def entries_of_table_2() -> str:
    """Prove the entries of Table 2."""
    from gspcli.symbolic.printed_sections import table_2 as prove_points

    return prove_points(printed_table(2), table_2())


def _of_section_6(name: str) -> Callable[[], str]:
    """Return a proof from `gspcli.symbolic.printed_sections`."""

    def proof() -> str:
        from gspcli.symbolic import printed_sections

        evidence: str = getattr(printed_sections, name)()
        return evidence

    return proof


def columns_of_table_3() -> str:
    """Prove that two triples of Table 3 are printed twice."""
    counted: dict[str, int] = {}
    for difference in differences_3():
        case = difference.row.removeprefix("case ")
        surfaces = "".join(sorted(_surface_letters(difference.printed.split()), key="PSC".index))
        _require(surfaces != case, f"{difference.printed} is of case {case}")
        counted[difference.printed] = counted.get(difference.printed, 0) + 1
    printed = [str(entry) for entry in printed_table_3()]
    _require(len(printed) == len(table_3()) == 56, "56 triples")
    for wrong in counted:
        _require(printed.count(wrong) == 2, f"{wrong} is printed {printed.count(wrong)} times")
    return f"{' and '.join(counted)} are each printed in two cases; both have other surfaces"


def lines_of_table_3() -> str:
    """Prove that platforms of k DLL and three angles have 2^k times as many solutions as N1."""
    from gspcli.catalogue.counts import best_real, family_counts

    entries = [entry for entry in table_3() if DLL in entry.distances]
    for entry in entries:
        times = 2 ** entry.distances.count(DLL)
        found = family_counts(entry.family).one_sided
        _require(times > 1 and found == times * entry.n1, f"{entry}: {found} solutions")
    (three,) = (entry for entry in entries if set(entry.distances) == {DLL})
    real = best_real(three.family)
    _require(real == 2**3 * three.n1, f"{three}: {real} real solutions of a platform")
    return (
        f"in all {len(entries)} triples with LL the generic count for given sides of planes is 2^k "
        f"times N1, and a recorded platform of {three} has {real} certified real solutions"
    )


def figure_2() -> str:
    """Prove how many solutions a platform of Figure 2 has for each choice of three signs."""
    from gspcli.resources import data_path
    from gspcli.solver import solve
    from gspcli.spec import load

    result = solve(load(data_path("examples", "figure-2.yaml")))
    lines = [i for i, kind in enumerate(result.arrangement.kinds) if kind is DLL]
    moments = [_mutual_moment(result.arrangement, i, result.R, result.T).real for i in lines]
    counted = Counter(tuple(moment > 0 for moment in pose) for pose in zip(*moments, strict=True))
    _require(bool(result.certified.all() and result.real.all()), "not all are real")
    _require(set(counted.values()) == {4} and len(counted) == 8, f"{counted}")
    return (
        f"data/examples/figure-2.yaml has {len(result.R)} certified real poses, four for each of "
        "the eight choices of sign"
    )


def _surface_letters(names: list[str]) -> list[str]:
    return [constraint_facts(KINDS_BY_NAME[f"D{name}"]).surface or "" for name in names]


def captions() -> str:
    """Prove which constraint the chain of Figures 5 and 6 realizes."""
    chains = {kind: realization(kind).chain.name for kind in (DPP, DPH)}
    _require(chains[DPP] != chains[DPH], f"{chains}")
    return (
        f"the chain in the figures, {chains[DPH]}, keeps exactly the point/plane distance when "
        f"its driver is held; point/point is {chains[DPP]} of Figure 9"
    )


def page_72() -> str:
    """Prove that the largest number of solutions of the types of Theorem 5.4 is eight."""
    from gspcli.catalogue.counts import generic_counts

    types = [t for t in all_types() if type_bounds(t).theorem_5_4 is not None]
    counts = {generic_counts(t).one_sided for t in types}
    bounds = {type_bounds(t).refined_one_sided.value for t in types}
    _require(counts == bounds, f"counts {counts}, bounds {bounds}")
    _require(max(counts) < varieties()[LAZARD].degree, "the printed number is right")
    (count,) = counts
    return (
        f"all {len(types)} types have at most {count} solutions, and almost all platforms {count}"
    )


def proof_of_5_3() -> str:
    """Prove that the number in the proof of Theorem 5.3 needs m and 4^s."""
    lazard, first = varieties()[LAZARD].degree, 2
    powers = {(m, s): lazard * first * 2**m * 4**s for m in range(3) for s in range(3)}
    _require(powers[1, 0] == 80, "the example has another number")
    stated = all(40 * 2**m * 4**s == value for (m, s), value in powers.items())
    _require(stated, "the theorem has another number")
    printed = [k for k in range(9) if lazard * first * 2**0 * 2**k == powers[1, 0]]
    _require(printed == [1], f"k is one of {printed}")
    return (
        "with m = 1 and s = 0 the printed number is 80 for k = 1 = m only; 20 · 2 · 2^m · 4^s is "
        "that of the theorem for all m and s up to 2"
    )


#: The references that page 72 and Section 3 cite for rigid motions, as its list prints them.
_REFERENCES = {
    12: "Lazard, D., Generalized Stewart platform: how to compute with rigid motions?",
    15: "Mourrain, B., Enumeration problems in geometry, robotics and vision",
    18: "Stewart, D., A platform with six degrees of freedom",
}
#: Whose treatment is followed on page 72, with the number printed there and that of Section 3.
_FOLLOWED = {"Mourrain": (18, 15), "Lazard": (18, 12)}


def citations() -> str:
    """Prove that [18] is by neither Mourrain nor Lazard, and that the references of Section 3 are.

    The evidence is the list of references.
    """
    for author, (cited, introduced) in _FOLLOWED.items():
        _require(not _REFERENCES[cited].startswith(author), f"[{cited}] is by {author}")
        _require(_REFERENCES[introduced].startswith(author), f"[{introduced}] is not by {author}")
    found = "; ".join(f"[{number}] {text}" for number, text in _REFERENCES.items())
    return f"the list of references has {found}"


def proof_of_5_2() -> str:
    """Prove that the equation meant is that of DPL: the last of (8) is of degree two by it."""
    degree = constraint_facts(DPL).paper_mourrain.two_sided
    _require(degree == 2, f"DPL has degree {degree}")
    return "the last equation of (8) is that of a DPL, of degree two as derived"


@dataclass(frozen=True)
class Erratum:
    """A statement of the paper that does not hold, or that holds and can be sharpened."""

    #: A stable name.
    key: str
    #: ``wrong``; ``sharpened``: true, but not the best; or ``slip``: a misprint, or words that do
    #: not fit the formulas.
    sort: Literal["wrong", "sharpened", "slip"]
    #: The place in the paper.
    place: str
    #: The printed and the correct statement.
    printed: str
    correct: str
    #: The reason, in a sentence or two.
    argument: str
    #: A function that proves it and returns its evidence; raises `CheckFailed` otherwise.
    proof: Callable[[], str]

    def document(self) -> dict[str, str]:
        """Return the texts of the erratum by name."""
        return {name: text for name, text in asdict(self).items() if name != "proof"}


ERRATA: tuple[Erratum, ...] = (
    Erratum(
        "class-size",
        "wrong",
        "Section 1, page 66",
        "a class of 1220 GSPs has analytical solutions",
        "1120",
        "The class is 3D3A, counted in Proposition 2.2 and in the abstract.",
        class_size,
    ),
    Erratum(
        "figure-2",
        "wrong",
        "Section 2, page 67, Figure 2",
        "this platform has at most four solutions",
        "at most four for each choice of signs of its three distances, 32 in all",
        "A distance of two lines is the modulus of a signed one, as that of a point and a plane. "
        "The three angles leave four rotations, and each choice of signs one position.",
        figure_2,
    ),
    Erratum(
        "mourrain-degree",
        "wrong",
        "Section 3, page 69",
        "the variety of Mourrain in 25 coordinates has degree 40",
        "84; the one in 16 coordinates has 40",
        "Theorem 5.2 holds all the same: its constraints use the 16 coordinates R, T, U, ρ only.",
        degree_of_mourrain,
    ),
    Erratum(
        "equation-5",
        "slip",
        "Section 4, page 69, equation (5), second line",
        "2[T, RᵀY]",
        "2[T, RY]",
        "[T, RY] = [Y, RᵀT], as in the third line.",
        _of_section_6("equation_5"),
    ),
    Erratum(
        "dll-vectors",
        "slip",
        "Section 4, page 70, DLL",
        "u_i a unit vector parallel to L_i, then v_1 and v_2 in the equation",
        "the same vectors",
        "The equation is that of the distance with v_i = u_i.",
        _of_section_6("distance_of_lines"),
    ),
    Erratum(
        "normals-of-lines",
        "slip",
        "Section 4, page 71, ALH and AHL; page 72, proof of Theorem 5.2",
        "the unit normal vector of a line",
        "a unit vector parallel to the line",
        "A line has no one normal vector; the equations need its direction.",
        _of_section_6("directions_of_lines"),
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
        lowest_degrees,
    ),
    Erratum(
        "proof-of-5-2",
        "slip",
        "Proof of Theorem 5.2, page 72",
        "By (??), the last equation is of degree two",
        "by the equation of DPL in Section 4, which has no number",
        "A reference that was not resolved.",
        proof_of_5_2,
    ),
    Erratum(
        "citations",
        "slip",
        "Proofs of Theorems 5.2 and 5.3, page 72",
        "Following Mourrain's treatment [18], Following Lazard's treatment [18]",
        "[15] and [12]",
        "[18] is Stewart's paper of 1965. Section 3 introduces the variety of Mourrain with [15] "
        "and that of Lazard with [12].",
        citations,
    ),
    Erratum(
        "proof-of-5-3",
        "slip",
        "Proof of Theorem 5.3, page 72",
        "20 · 2 · 2^s · 2^k = 80",
        "20 · 2 · 2^m · 4^s = 80",
        "k is not defined, and s counts the constraints of degree four.",
        proof_of_5_3,
    ),
    Erratum(
        "after-5-3",
        "slip",
        "After the proof of Theorem 5.3, page 72",
        "[T, T] = l1",
        "[T, T] = d1²",
        "It is the first equation of (9) with Y1 = X1 = 0; there is no l1.",
        _of_section_6("first_distance"),
    ),
    Erratum(
        "page-72",
        "wrong",
        "After the proof of Theorem 5.3, page 72",
        "a class of GSPs the maximal number of solutions for which is 20",
        "8",
        "The class is that of Theorem 5.4. Its bound of 20 holds, and is never attained.",
        page_72,
    ),
    Erratum(
        "theorem-5-4",
        "sharpened",
        "Theorem 5.4, page 73",
        "at most 20 feasible solutions",
        "at most 8",
        "True, but not the best. One-sided DPH and angles are linear in R and T alone, so the "
        "variety in these twelve coordinates serves in place of Lazard's.",
        theorem_5_4,
    ),
    Erratum(
        "section-6-1",
        "slip",
        "Section 6.1, page 74",
        "cos(∠(RL1, L4)) = d1, … with L1, L2, L3 on the base",
        "cos(∠(L1, RL4)) = d1, …",
        "R turns the lines of the platform, L4, L5 and L6, as in equation (11).",
        _of_section_6("turned_directions"),
    ),
    Erratum(
        "equation-12",
        "wrong",
        "Equation (12), page 74, second polynomial",
        "h2 of degree 3 in r32 in both coefficients (z20 … z27)",
        "degree 3 in the coefficient of r31, degree 4 in the other",
        "The elimination gives degree 4, and no polynomial of the printed shape vanishes at the "
        "eight rotations.",
        _of_section_6("equation_12"),
    ),
    Erratum(
        "table-1-sign",
        "wrong",
        "Table 1, page 76, solution 8, r21",
        "(3 − √5)/(2(−1 + √5))",
        "(1 − √5)/4, which is the negative",
        "The printed matrix is not orthogonal. (Read from a text layer with flattened fractions; "
        "the sign of the numerator decides.)",
        entry_of_table_1,
    ),
    Erratum(
        "equation-14",
        "slip",
        "Algorithm 6.6, equation (14), page 78",
        "L2(x + x1 − x2, …), and index 2 again in the third line",
        "L2(x + x2 − x1, …), L3(x + x3 − x1, …)",
        "Under a fixed orientation p2' = p1' + (p2 − p1) is the point that lies on L2.",
        _of_section_6("equation_14"),
    ),
    Erratum(
        "equation-15",
        "slip",
        "Equation (15), page 78",
        "… + (d12·y + d13·x + d14)z + (d15·z + d16)y + …",
        "… + (d12·y + d13·x + d14)z + (d15·x + d16)y + …",
        "The printed quadric has two terms in yz and none in xy.",
        _of_section_6("equation_15"),
    ),
    Erratum(
        "equation-16",
        "slip",
        "Equation (16), page 78, third polynomial",
        "d3·z + d2·y + d1·z + d4",
        "d3·z + d2·y + d1·x + d4",
        "It is the plane of (15).",
        _of_section_6("equation_16"),
    ),
    Erratum(
        "equation-18",
        "wrong",
        "Equation (18), page 79",
        "2x² + r2² − r3² − r1², 2y² + r3² − r1² − r2²",
        "2x² + r3² − r2² − r1², 2y² + r2² − r1² − r3²",
        "r2 and r3 are exchanged against equation (17).",
        _of_section_6("equation_18"),
    ),
    Erratum(
        "table-2-exchanged",
        "wrong",
        "Table 2, page 79",
        "x = ±3√10/2, y = ±3√6/2",
        "x = ±3√6/2, y = ±3√10/2",
        "The consequence of equation (18): the points are those for r2 = 5, r3 = 4.",
        entries_of_table_2,
    ),
    Erratum(
        "table-3-columns",
        "wrong",
        "Table 3, page 80, cases PSS and CCC",
        "PP PP PP under PSS; LL LP LP under CCC",
        "PH PP PP; LP LP LP",
        "Each of the 56 triples belongs to one case; the two printed ones stand in their own "
        "cases, SSS and PCC, as well.",
        columns_of_table_3,
    ),
    Erratum(
        "table-3-lines",
        "wrong",
        "Table 3, page 80, columns with LL",
        "the maximal number of solutions N1, 8 for LL LL LL",
        "N1 for one orientation of each pair of lines; 2^k N1 for k pairs, 64 for LL LL LL",
        "Under a given orientation a DLL leaves two planes (page 77). N1 counts one of them, and a "
        "distance of lines, which has no sign, allows both.",
        lines_of_table_3,
    ),
    Erratum(
        "captions",
        "slip",
        "Figures 5 and 6, page 81, captions",
        "point/point and point/line distance constraint",
        "both are realizations of the point/plane distance, as Section 7 says",
        "The chain of a spherical and a planar joint fixes the distance of a point to a plane.",
        captions,
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
        raise CheckFailed(f"erratum {erratum.key} is not proved: {failure}") from failure
