"""Two solutions side by side: from near both, and from the one to the other."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from gspcli.certification.equations.frames import OWN
from gspcli.certification.poses.collection import Collection
from gspcli.certification.poses.locator import Located, Locator
from gspcli.certification.poses.partners import is_alone, partner
from gspcli.geometry.quaternions import study_from_pose

SIDES = (0,) * 6


def located(locator: Locator, error: float) -> Located:
    exact = np.concatenate(study_from_pose(np.eye(3), np.array([1.0, 0, 0])))
    shake = np.random.default_rng(5).standard_normal((2, 8))
    [found] = locator.locate((exact + error * (shake[0] + 1j * shake[1]))[None], None, SIDES)
    assert isinstance(found, Located)
    return found


@pytest.mark.parametrize("split", [Fraction(1, 10**14), -Fraction(1, 10**14), Fraction(1, 10**36)])
def test_from_one_of_two_solutions_to_the_other(tangent, split: Fraction) -> None:
    locator = Locator(tangent(1 + split), OWN)
    first = located(locator, 1e-9)
    assert not is_alone(first)
    both = Collection(locator, SIDES)
    assert both.add([first, partner(locator, first)]) == 2
    assert both.real.tolist() == [first.real] * 2
    np.testing.assert_allclose(both.T[0], both.T[1], atol=1e-6)


def test_a_solution_by_itself_is_alone(tangent) -> None:
    assert is_alone(located(Locator(tangent(Fraction(1, 2)), OWN), 1e-1))
