"""Random instances: of the type asked for, short numbers, a real pose, also for every kind."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.catalogue.coincidence import parse_sharing
from gspcli.catalogue.names import parse_type
from gspcli.catalogue.types import all_types
from gspcli.errors import GspError
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.measurement import residuals
from gspcli.geometry.random_instances import random_instance


@pytest.mark.parametrize("number", range(0, 3850, 193))
@pytest.mark.parametrize("planar", [False, True])
def test_the_pose_is_one_of_the_instance(number: int, planar: bool) -> None:
    gsp_type = all_types()[number]
    rng = np.random.default_rng(number)
    instance, (R, T) = random_instance(gsp_type, rng, planar=planar, one_sided=True)
    assert tuple(constraint.kind for constraint in instance.constraints) == gsp_type.kinds
    assert np.allclose(R @ R.T, np.eye(3), atol=1e-12)
    assert residuals(Arrangement.of(instance), R, T).max() < 1e-11


@pytest.mark.parametrize("digits", [1, 3, 12])
def test_numbers_have_so_many_decimals(digits: int) -> None:
    instance, _ = random_instance(
        parse_type("PL LP DLL PH ALL AHH"), np.random.default_rng(1), digits=digits
    )
    for constraint in instance.constraints:
        for number in (constraint.value, *constraint.platform.position, *constraint.base.position):
            assert number.fraction is not None
            assert (number.fraction * 10**digits).denominator == 1


def test_shared_primitives_are_shared() -> None:
    pattern = parse_sharing("P1-p1 P1-p2 P2-p1 P2-p3 P3-p2 P3-p3")
    instance, _ = random_instance(pattern.bonds, np.random.default_rng(0))
    assert len({constraint.platform for constraint in instance.constraints}) == 3
    assert len({constraint.base for constraint in instance.constraints}) == 3


def test_a_pattern_without_solutions_is_refused() -> None:
    pattern = parse_sharing("P1-p1 P1-p2 P1-p3 P1-p4 P2-p1 P2-p2")
    with pytest.raises(GspError, match="can fix the platform"):
        random_instance(pattern.bonds, np.random.default_rng(0))
