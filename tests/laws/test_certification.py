"""Laws of certificates, on 3D3A platforms whose poses are all given by the closed form."""

from __future__ import annotations

from functools import cache

import numpy as np
from closed_forms import closed_form_poses
from hypothesis import given, settings
from hypothesis import strategies as st

from gspcli.catalogue.names import parse_type
from gspcli.certification import Certificates, certify
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.instance import Instance
from gspcli.geometry.random_instances import random_instance
from gspcli.solver import solve

#: Families with few poses, so that many platforms can be tried.
TYPES = [
    "DPP DPH DHP ALL ALL ALL",
    "DPL DPH DHP ALL ALH AHH",
    "DLP DPH DPH AHL AHL AHH",
    "DLL DHP DHP ALH ALH AHH",
    "DPP DPP DPH ALL AHL AHH",
]
platforms = st.tuples(st.sampled_from(TYPES), st.integers(0, 10**6))
few = settings(max_examples=12)


@cache
def platform(key: tuple[str, int]) -> tuple[Instance, np.ndarray, np.ndarray, np.ndarray]:
    """Return a random instance and all its poses: R, T and which are real."""
    name, seed = key
    source = np.random.default_rng(seed)
    instance, _ = random_instance(parse_type(name), source, one_sided=True)
    arrangement = Arrangement.of(instance)
    poses = closed_form_poses(arrangement)
    assert poses is not None
    return instance, poses.R, poses.T, poses.real


def summary(result: Certificates) -> tuple[int, int, list[bool | None]]:
    return result.certified, result.distinct, [item.real for item in result]


@few
@given(platforms)
def test_all_poses_of_the_closed_form_are_certified_different_and_told_real(
    key: tuple[str, int],
) -> None:
    instance, R, T, real = platform(key)
    assert summary(certify(instance, R, T)) == (len(R), len(R), list(real))


@few
@given(platforms, st.integers(0, 10**6), st.sampled_from([1e-3, 0.1, 10.0]))
def test_poses_that_are_off_are_never_certified(
    key: tuple[str, int], seed: int, size: float
) -> None:
    instance, R, T, _ = platform(key)
    shift = np.random.default_rng(seed).normal(size=T.shape)
    shift *= size / np.abs(shift).max(axis=1, keepdims=True)
    result = certify(instance, R, T + shift)
    # A shifted pose may hit another solution only if one is there.
    gaps = np.abs((T + shift)[:, None] - T).max(axis=2).min(axis=1)
    assert not any(item.certified for item, gap in zip(result, gaps, strict=True) if gap > 1e-4)
    assert (gaps > 1e-4).any()


@few
@given(platforms)
def test_copies_are_recognized(key: tuple[str, int]) -> None:
    instance, R, T, real = platform(key)
    result = certify(instance, np.concatenate((R, R)), np.concatenate((T, T)))
    assert result.certified == 2 * len(R)
    assert result.distinct == len(R)
    assert result.real == real.sum()
    assert [item.same_as for item in result] == [None] * len(R) + list(range(len(R)))


def test_poses_a_million_lengths_away_are_certified():
    """Entries of complex rotations have no bound: what matters is how many digits are right."""
    gsp_type = parse_type("PP PP PP PP PL ALL")
    rng = np.random.default_rng([38, 1, *(kind.order for kind in gsp_type.distances)])
    instance, _ = random_instance(gsp_type, rng, one_sided=True)
    result = solve(instance)
    assert np.abs(result.R).max() > 1e6
    assert result.certified.all()
    assert certify(instance, result.R, result.T).distinct == result.expected
