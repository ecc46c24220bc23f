"""Platforms near simpler ones have their solutions."""

import numpy as np
import pytest

from gspcli.catalogue.kinds import ALL, DHP, DLL, DPH, DPL, DPP
from gspcli.geometry.quaternions import pose_from_study
from gspcli.reality.platforms import random_platforms, reduced
from gspcli.reality.solved_platforms import Solved, solved
from tools.witnesses.limits import Limit, limits


def _poses(found: Solved) -> np.ndarray:
    R, T = pose_from_study(found.points[:, :4], found.points[:, 4:])
    return np.concatenate((R.reshape(-1, 9), T), axis=-1)


@pytest.mark.parametrize(
    ("kind", "simpler"), [(DPP, DPH), (DPP, DHP), (DPH, ALL), (DHP, ALL)], ids=str
)
def test_each_solution_of_the_simpler_platform_has_one_of_the_other_nearby(kind, simpler):
    limit = Limit((kind, DPH, DHP, DPL, ALL, ALL), 0, simpler)
    simple = solved(reduced(random_platforms(limit.remaining, 1, np.random.default_rng(4)))[0])
    assert simple is not None
    expected = _poses(simple)

    def distance(reach: float) -> float:
        centre = np.full(3, 0.3)
        found = solved(limit.lifted(simple.platform, centre, -centre, reach))
        assert found is not None
        apart = np.abs(_poses(found)[:, None] - expected).max(axis=-1)
        nearest = apart.argmin(axis=0)
        assert len(set(nearest)) == len(expected)
        assert found.real[nearest].tolist() == simple.real.tolist()
        return float(apart.min(axis=0).max())

    assert distance(1e4) < distance(1e3) / 5 < 0.05


def test_alike_constraints_become_simpler_once_and_never_four_angles():
    found = [(one.index, one.simpler) for one in limits((DPP, DPP, DPH, DLL, ALL, ALL))]
    assert found == [(0, DPH), (0, DHP), (2, ALL)]
    assert [one.simpler for one in limits((DPP, DPL, DHP, ALL, ALL, ALL))] == [DPH, DHP]
