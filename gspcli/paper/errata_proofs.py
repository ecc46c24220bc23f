"""The proofs of the errata that need the catalogue, the tables or the realizations.

Every function returns its evidence in a sentence and raises `CheckFailed` if there is none.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

from gspcli.catalogue.bounds import LAZARD, MOURRAIN, MOURRAIN_16, type_bounds, varieties
from gspcli.catalogue.constraints import constraint_facts
from gspcli.catalogue.kinds import DHP, DLL, DLP, DPH, DPL, DPP, KINDS_BY_NAME
from gspcli.catalogue.realization import realization
from gspcli.catalogue.types import CLASSES, all_types
from gspcli.errors import CheckFailed
from gspcli.paper import table1, table2, table3


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
    from gspcli.catalogue.intersection_numbers import mourrain_degree
    from gspcli.symbolic.constraint_equations import (
        hilbert_function,
        sampled_hilbert_function,
        system,
    )

    large, small = varieties()[MOURRAIN], varieties()[MOURRAIN_16]
    _require(small.degree == 40, f"16 coordinates: degree {small.degree}")
    _require(large.degree != 40, "the printed number is right")
    _require(large.degree == mourrain_degree(), f"x^5 (2x - 2h) = {mourrain_degree()}")
    wanted = [
        hilbert_function(large.hilbert_numerator, large.dimension, degree) for degree in (1, 2)
    ]
    ranks = [
        sampled_hilbert_function(system(MOURRAIN), degree, wanted[-1] + 20) for degree in (1, 2)
    ]
    _require(wanted == ranks, f"Hilbert function {wanted}, ranks at random motions {ranks}")
    return (
        "in the notation of docs/counts.md the degree is "
        f"x⁵(2x − 2h) = {mourrain_degree()}. Five of the linear functions are general ones of 1, "
        "R, T, U, T×R; their space has no base points. The sixth has ρ; its base points are on "
        "g = f.f = 0 and so not on the curve of the five. Singular: degree "
        f"{large.degree} in 25 coordinates, {small.degree} in 16; the Hilbert function of the "
        f"former, {wanted} in degrees 1 and 2, is found again at random motions"
    )


def lowest_degrees() -> str:
    """Prove the lowest degrees of DHP, DLP and DLL."""
    from gspcli.symbolic.constraint_equations import lowest_degree

    found = []
    for kind in (DHP, DLP, DLL):
        facts = constraint_facts(kind)
        derived = lowest_degree(kind)
        _require(derived.degree == facts.lowest.two_sided, f"{kind}: {derived.degree} derived")
        _require(derived.degree < facts.paper_mourrain.two_sided, f"{kind} is as printed")
        found.append(f"{kind} {derived.degree} in {facts.lowest_coordinates}")
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


def table_1() -> str:
    """Prove the entry of Table 1."""
    from gspcli.symbolic.printed_sections import table_1 as prove_row

    (difference,) = table1.differences()
    row = int(difference.row.removeprefix("solution ")) - 1
    return prove_row(table1.printed()[row], table1.compute()[row])


def table_2() -> str:
    """Prove the entries of Table 2."""
    from gspcli.symbolic.printed_sections import table_2 as prove_points

    return prove_points(table2.printed(), table2.compute())


def printed(name: str) -> Callable[[], str]:
    """Return a proof from `gspcli.symbolic.printed_sections`."""

    def proof() -> str:
        from gspcli.symbolic import printed_sections

        evidence: str = getattr(printed_sections, name)()
        return evidence

    return proof


def table_3() -> str:
    """Prove that two triples of Table 3 are printed twice."""
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


def lines_of_table_3() -> str:
    """Prove that platforms of k DLL and three angles have 2^k times as many solutions as N1."""
    from gspcli.catalogue.counts import best_real, family_counts

    entries = [entry for entry in table3.compute() if DLL in entry.distances]
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
    from gspcli.paper.confirmation import mutual_moment
    from gspcli.resources import data_path
    from gspcli.solver import solve
    from gspcli.spec import load

    result = solve(load(data_path("examples", "figure-2.yaml")))
    lines = [i for i, kind in enumerate(result.arrangement.kinds) if kind is DLL]
    moments = [mutual_moment(result.arrangement, i, result.R, result.T).real for i in lines]
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
