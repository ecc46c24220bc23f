"""Intersection numbers: three other programs agree, and the centres are what the proof says."""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
import pytest
from numpy.typing import NDArray

from gspcli.catalogue.bounds import LAZARD, MOURRAIN_16, ROTATIONS, varieties
from gspcli.continuation import start
from gspcli.continuation.quadrics import evaluate, gradients
from gspcli.continuation.quadrics import swap_letters as swapped
from tests.support.study_forms import BODY_TRANSLATION, RHO, TRANSLATION
from tools.atlas.intersection_numbers import LETTERS, intersection_number

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
