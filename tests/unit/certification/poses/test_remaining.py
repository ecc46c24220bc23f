"""Poses that proofs for many values leave open are decided by themselves."""

import numpy as np
import pytest

from gspcli.catalogue.parsing import parse_type
from gspcli.certification import decide
from gspcli.certification.equations.frames import OWN
from gspcli.certification.poses import remaining
from gspcli.certification.poses.many_values import ValueProofs
from gspcli.certification.poses.remaining import with_remaining
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.quaternions import study_from_pose
from gspcli.solver import solve
from gspcli.solver.generate import random_instance
from gspcli.solver.study_systems import side_choices


@pytest.fixture(scope="module")
def found():
    instance = random_instance(parse_type("DPP DPP DPP DPL DLP DLL"), np.random.default_rng(21))[0]
    poses = solve(instance)
    proofs = ValueProofs(instance, None)
    points = np.concatenate(study_from_pose(poses.R, poses.T), axis=-1)
    found = proofs.decide_own(side_choices(Arrangement.of(instance)), points[None], OWN)
    assert found.complete.all()
    assert 0 < found.real.sum() < len(poses.R)
    return proofs, found


def opened(found, k, **changes):
    """Return what was found with the first and last k poses open."""
    parts = {name: getattr(found, name).copy() for name in ("certified", "real", "deviation")}
    for part, nothing in zip(parts.values(), (False, False, np.inf), strict=True):
        part[0, :k] = part[0, -k:] = nothing
    return found._replace(**parts, complete=np.array([False]), **changes)


def test_the_rest_is_proved_and_all_are_different(found, monkeypatch):
    proofs, given = found
    decided = []

    def counted(instance, R, T):
        decided.append(len(R))
        return decide(instance, R, T)

    monkeypatch.setattr(remaining, "decide", counted)
    again = with_remaining(proofs, opened(given, 2))
    assert decided == [4]
    assert again.complete.all()
    np.testing.assert_array_equal(again.real, given.real)
    np.testing.assert_allclose(again.R, given.R, atol=1e-9)
    np.testing.assert_allclose(again.quaternions, given.quaternions, atol=1e-9)
    assert not again.R[again.real].imag.any()


def test_real_poses_are_exactly_real(found):
    proofs, given = found
    R, T = given.R + 1e-12j, given.T - 1e-12j
    again = with_remaining(proofs, opened(given, 2, R=R, T=T))
    proved = again.real[0].copy()
    proved[2:-2] = False
    assert proved.any()
    assert not again.R[0, proved].imag.any()
    assert not again.T[0, proved].imag.any()


def test_the_same_pose_twice_or_none_is_not_complete(found):
    proofs, given = found
    twice = opened(given, 1)
    twice.R[0, 0], twice.T[0, 0] = given.R[0, 1], given.T[0, 1]
    assert not with_remaining(proofs, twice).complete.any()
    for wrong in (np.nan, 1.0):
        spoilt = opened(given, 1, R=given.R.copy())
        spoilt.R[0, 0] = wrong
        again = with_remaining(proofs, spoilt)
        assert not again.complete.any()
        assert not again.certified[0, 0]
