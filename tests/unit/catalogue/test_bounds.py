"""The bounds: as the paper has them, consistent, never below a generic count."""

from __future__ import annotations

import re
from itertools import combinations_with_replacement, product
from math import prod

import numpy as np
import pytest
from numpy.typing import NDArray

from gspcli.catalogue.bounds import (
    BOUND_NAMES,
    LAZARD,
    MOURRAIN_16,
    ROTATIONS,
    Bounds,
    coordinates_label,
    family_bounds,
    type_bounds,
    varieties,
)
from gspcli.catalogue.constraints import constraint_facts
from gspcli.catalogue.kinds import (
    ANGLE_KINDS,
    DHP,
    DISTANCE_KINDS,
    DLL,
    DLP,
    DPH,
    DPL,
    DPP,
    Kind,
    Primitive,
)
from gspcli.catalogue.names import parse_name
from gspcli.catalogue.types import CLASSES, Family, GspType, all_types, families
from gspcli.continuation import start
from gspcli.continuation.quadrics import evaluate, gradients
from gspcli.continuation.quadrics import swap_letters as swapped
from gspcli.resources import data_json
from tests.support.study_forms import BODY_TRANSLATION, RHO, TRANSLATION
from tools.atlas.intersection_numbers import LETTERS, intersection_number

FAMILIES = [family for platform_class in CLASSES for family in families(platform_class)]


def bounds(name: str) -> Bounds:
    found = parse_name(name)
    return family_bounds(found) if isinstance(found, Family) else type_bounds(found)


def test_the_example_of_the_requirements() -> None:
    found = bounds("3D3A PL PL LP")
    assert found.theorem_5_3.value == 320
    assert found.theorem_5_3.reason == (
        "Theorem 5.3, no DPP: 20 · 2^2 · 4^1 = 320: "
        "two of degree 2 (DPL, DPL), one of degree 4 (DLP)"
    )
    assert found.table_3 is not None
    assert found.table_3.value == 64
    assert found.table_3.reason == (
        "Table 3: 8 · 8 = 64: 8 orientations, and in each the surfaces CCC meet in 8 points"
    )


def test_the_numbers_that_the_paper_prints() -> None:
    # Proofs of Theorems 5.2 and 5.3: five DPP and one DPL.
    assert bounds("5PP PL").theorem_5_2.value == bounds("5PP PL").theorem_5_3.value == 80
    # Section 5, before Theorem 5.4: six DPH have at most 1280 solutions, 20 feasible ones.
    assert bounds("6PH").theorem_5_3.value == 1280
    theorem = bounds("6PH").theorem_5_4
    assert theorem is not None
    assert theorem.value == 20
    # The original platform.
    assert bounds("6PP").theorem_5_2.value == 40


def test_theorem_5_4_applies_to_35_types() -> None:
    types = [t for t in all_types() if type_bounds(t).theorem_5_4 is not None]
    assert len(types) == 35
    assert {type_bounds(t).refined_one_sided.value for t in types} == {8}


def test_every_entry_of_table_3() -> None:
    seen, misprinted = [], []
    for group in data_json("paper", "table3.json")["groups"]:
        for column in zip(*(row.split() for row in group["rows"]), strict=True):
            family = parse_name("3D3A " + " ".join(column))
            assert isinstance(family, Family)
            found = family_bounds(family).table_3
            assert found is not None
            if f"surfaces {group['surfaces']} " in found.reason:
                assert found.value == group["n1"], family
                seen.append(family)
            else:
                misprinted.append((group["surfaces"], family.id))
    # Two columns contradict the surfaces of their own group and repeat another column.
    assert misprinted == [("PSS", "3D3A PP PP PP"), ("CCC", "3D3A LP LP LL")]
    missing = set(families(CLASSES[0])) - set(seen)
    assert {family.id for family in missing} == {"3D3A PP PP PH", "3D3A LP LP LP"}
    assert bounds("3D3A PP PP PH").values()["table_3"] == 16
    assert bounds("3D3A LP LP LP").values()["table_3"] == 64


def test_theorems_apply_where_they_should() -> None:
    for family in FAMILIES:
        found = family_bounds(family)
        assert (found.table_3 is not None) == (family.platform_class.angles == 3)
        assert (found.theorem_5_4 is not None) == (set(family.distances) == {DPH})


def test_order_of_the_bounds() -> None:
    for family in FAMILIES:
        found = family_bounds(family)
        one, two = found.refined_one_sided.value, found.refined_two_sided.value
        sided = sum(kind.has_sides for kind in family.distances)
        assert two <= found.theorem_5_3.value <= found.theorem_5_2.value
        assert one <= two <= one * 2**sided
        if found.table_3 is not None:
            # Both planes of each DLL.
            assert one == found.table_3.value * 2 ** family.distances.count(DLL)


def test_refined_bounds_do_not_change_when_platform_and_base_are_exchanged() -> None:
    for family in FAMILIES:
        mirrored = Family(
            family.platform_class, tuple(sorted(kind.mirrored for kind in family.distances))
        )
        for name in ("refined_one_sided", "refined_two_sided", "table_3"):
            assert family_bounds(family).values()[name] == family_bounds(mirrored).values()[name]


def test_no_bound_is_below_the_generic_count() -> None:
    counts = data_json("start-systems", "manifest.json")["counts"]
    letters = {DPP: "s", DPL: "p", DPH: "p", DLP: "q", DHP: "q", DLL: "l"}
    exchanged = str.maketrans("pq", "qp")
    generic = {}
    for name, count in counts.items():
        for either in (name, name.translate(exchanged)):
            generic["".join(sorted(either))] = count
    reached = 0
    for family in FAMILIES:
        word = "a" * family.platform_class.angles
        word += "".join(letters[kind] for kind in family.distances)
        pairs = sum(kind in (DPL, DLP, DLL) for kind in family.distances)
        sided = sum(kind.has_sides for kind in family.distances)
        count = generic["".join(sorted(word))] * 2**pairs
        found = family_bounds(family)
        assert found.refined_one_sided.value >= count, family
        assert found.refined_two_sided.value >= count * 2**sided, family
        reached += found.refined_one_sided.value == count
    # As docs/types.md says.
    assert (reached, len(FAMILIES)) == (654, 896)


def test_every_reason_spells_out_its_number() -> None:
    for family in FAMILIES:
        for name, bound in family_bounds(family).items():
            if bound is None:
                continue
            text = re.search(r": (\d[\d ·^]*)(?: = (\d+))?(?:[:,])", bound.reason)
            assert text is not None, bound.reason
            factors = (term.split("^") for term in text[1].split(" · "))
            value = prod(int(term[0]) ** int(term[1] if term[1:] else 1) for term in factors)
            assert value == bound.value == int(text[2] or value), (name, bound.reason)


@pytest.mark.parametrize(
    ("name", "one_sided", "reason"),
    [
        (
            "6PH",
            8,
            "Bezout on the motions in (R, T): 8, all constraints of degree 1; one-sided; "
            "Theorem 5.3 has 1280, with DPH of degree 2 and a variety of degree 20",
        ),
        (
            "6PP",
            40,
            "Bezout on the motions in (R, T, U): 20 · 2^1 = 40: one of degree 2 (DPP); "
            "differences of DPP have degree 1",
        ),
        (
            "5PP DLL",
            120,
            "Bezout on the motions in (R, T, U, ρ): 40 · 3^1 = 120: one of degree 3 (DLL); "
            "Theorem 5.3 has 160, with DLL of degree 4",
        ),
        (
            "6D 6LL",
            4096,
            "Bezout on the motions in (R, T×R): 64 · 2^6 = 4096: "
            "six of degree 2 (DLL, DLL, DLL, DLL, DLL, DLL); "
            "Theorem 5.3 has 81920, with DLL of degree 4",
        ),
    ],
)
def test_refined_bounds_and_their_reasons(name: str, one_sided: int, reason: str) -> None:
    found = bounds(name).refined_one_sided
    assert (found.value, found.reason) == (one_sided, reason)


def test_names_are_those_of_the_catalogue_s_columns() -> None:
    assert BOUND_NAMES == (
        "theorem_5_2",
        "theorem_5_3",
        "theorem_5_4",
        "table_3",
        "refined_one_sided",
        "refined_two_sided",
    )
    assert list(bounds("6PP").values()) == list(BOUND_NAMES)


def test_angles_are_linear_in_all_coordinates() -> None:
    for kind, variety in product(ANGLE_KINDS, varieties()):
        assert constraint_facts(kind).degrees[variety].two_sided == 1


def test_a_type_has_the_bounds_of_its_family() -> None:
    for gsp_type in all_types()[::77]:
        assert type_bounds(gsp_type) == family_bounds(gsp_type.family)
    assert type_bounds(GspType.of([DPP] * 6)).refined_two_sided.value == 40


def test_meanings_and_labels() -> None:
    assert constraint_facts(DLP).meaning == (
        "distance of a line of the platform from a point of the base"
    )
    assert coordinates_label("R,T,U,rho,TxR") == "(R, T, U, ρ, T×R)"


@pytest.mark.parametrize("kind", DISTANCE_KINDS)
def test_exchange_of_platform_and_base_exchanges_t_and_u(kind: Kind) -> None:
    exchanged = {"T": "U", "U": "T"}
    degrees = constraint_facts(kind).degrees
    mirrored = constraint_facts(kind.mirrored).degrees
    order = ("R", "T", "U", "rho", "TxR")
    for name, row in degrees.items():
        blocks = sorted((exchanged.get(b, b) for b in name.split(",")), key=order.index)
        assert mirrored[",".join(blocks)] == row
    assert (kind.platform is Primitive.PLANE) == (kind is DHP)


# Intersection numbers: three other programs agree, and the centres are what the proof says.


#: All 195 with at most three angles.
NUMBERS = [
    "".join(chosen)
    for chosen in combinations_with_replacement(LETTERS, 6)
    if chosen.count("a") <= 3
]
#: Spaces and those that contain them.
LARGER = {"a": "pqls", "p": "s", "q": "s"}


def test_monodromy_found_the_same_numbers() -> None:
    assert len(NUMBERS) == 195
    for spaces in NUMBERS:
        assert intersection_number(spaces) == start.intersection_number(spaces)


def test_four_angles_have_no_common_rotation() -> None:
    assert {intersection_number(f"aaaa{x}{y}") for x in LETTERS for y in LETTERS} == {0}


def test_exchanging_the_bodies_changes_nothing() -> None:
    for spaces in NUMBERS:
        assert intersection_number(swapped(spaces)) == intersection_number(spaces)


def test_larger_spaces_have_no_fewer_common_points() -> None:
    for spaces in NUMBERS:
        for smaller, larger in LARGER.items():
            for letter in larger if smaller in spaces else "":
                enlarged = spaces.replace(smaller, letter, 1)
                assert intersection_number(enlarged) >= intersection_number(spaces)


def test_degrees_of_the_motions_in_coordinates() -> None:
    degrees = {name: variety.degree for name, variety in varieties().items()}
    assert intersection_number("ssssss") == degrees[MOURRAIN_16]
    assert intersection_number("pppqqq") == degrees[LAZARD]
    assert intersection_number("aaappp") == degrees[ROTATIONS]
    assert intersection_number("llllll") == degrees["R,TxR"]
    assert intersection_number("pppppp") == degrees["R,T"]


@pytest.mark.parametrize("spaces", ["ppppp", "ppppppp", "pppppx", ""])
def test_six_letters_are_needed(spaces: str) -> None:
    with pytest.raises(ValueError, match="six letters"):
        intersection_number(spaces)


def _quaternion(matrix: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return the quaternion of a matrix; its norm is the determinant."""
    (p, q), (r, s) = matrix
    return np.array([(p + s) / 2, (p - s) / 2j, (q - r) / 2, (q + r) / 2j])


def _rank(forms: NDArray[np.float64], point: NDArray[np.complex128]) -> int:
    """Return the rank of the differentials of e.f and of some forms."""
    study = np.roll(point, 4)[None]
    return int(np.linalg.matrix_rank(np.vstack([study, gradients(forms, point[None])[0]])))


def test_the_centres_are_smooth_and_meet_cleanly() -> None:
    # On g = 0 the members of p vanish where T does, as a scheme; likewise q and U.
    rng = np.random.default_rng(1)
    a, b, c = rng.normal(size=(3, 2)) + 1j * rng.normal(size=(3, 2))
    both = np.vstack([TRANSLATION, BODY_TRANSLATION])
    e = _quaternion(np.outer(a, b))
    for f, vanishing, codimension in (
        (np.outer(c, b), TRANSLATION, 3),
        (np.outer(a, c), BODY_TRANSLATION, 3),
        (np.outer(a, b), both, 4),
    ):
        point = np.concatenate([e, _quaternion(f)])
        assert np.allclose(evaluate(vanishing, point[None]), 0)
        assert abs(point[:4] @ point[4:]) < 1e-12
        # With g, the codimension in Y; the form e.f is the equation of Y itself.
        assert _rank(vanishing, point) == codimension
        # There f.f vanishes once.
        assert np.allclose(evaluate(RHO[None], point[None]), 0)
        assert _rank(np.vstack([RHO[None]]), point) == 2
    # Elsewhere on N = 0, neither T nor U vanishes.
    f = rng.normal(size=4) + 0j
    f -= e.conj() * (e @ f) / np.vdot(e, e)
    point = np.concatenate([e, f])
    assert abs(e @ f) < 1e-12
    for forms in (TRANSLATION, BODY_TRANSLATION):
        assert np.abs(evaluate(forms, point[None])).max() > 1e-3
