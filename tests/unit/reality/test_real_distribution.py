"""Random platforms as arrays, their real solutions, and the distribution of the numbers."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from gspcli.catalogue.kinds import AHH, AHL, ALH, KINDS
from gspcli.catalogue.names import parse_type
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.measurement import residuals
from gspcli.geometry.quaternions import pose_from_study
from gspcli.reality.platforms import Reality, random_platforms, reality
from gspcli.reality.real_distribution import Sample, Tally, tallies
from gspcli.workers import HERE, Workers

TYPES = ("6PP", "DPL DLP DPH DHP DLL ALL", "3D3A PL PH LL ALL ALH AHH")


def _total(wanted: Sample, workers: Workers = HERE) -> Tally:
    total = Tally()
    for part in tallies(wanted, workers):
        total.add(part)
    return total


@pytest.mark.parametrize("name", TYPES)
def test_solutions_satisfy_the_constraints_as_stated(name: str) -> None:
    kinds = parse_type(name).kinds
    platforms = random_platforms(kinds, 2, np.random.default_rng(5))
    for k, solutions in enumerate(platforms.solutions(1)):
        assert len(solutions.points) == solutions.account.expected
        points = solutions.points[reality(solutions.points, solutions.condition).real].real
        R, T = pose_from_study(points[:, :4], points[:, 4:])
        one = platforms[k]
        sine = np.array([kind in (ALH, AHL) for kind in kinds])
        sign = np.where([kind is AHH for kind in kinds], -1.0, 1.0)
        cosine = sign * np.clip(one.values, -1, 1)
        angles = np.where(sine, np.arcsin(cosine), np.arccos(cosine))
        arrangement = Arrangement(
            kinds,
            one.y,
            one.x,
            one.u,
            one.v,
            np.where([kind.is_distance for kind in kinds], np.abs(one.values), angles),
            np.where([kind.has_sides for kind in kinds], np.sign(one.values), 0).astype(int),
            1.0,
        )
        assert residuals(arrangement, R, T).max() < 1e-9


def test_every_platform_has_a_real_solution() -> None:
    for name in TYPES:
        total = _total(Sample(parse_type(name), 10))
        assert total.platforms == 10
        assert min(total.real) >= 1


def test_sides_are_all_combinations_of_signs() -> None:
    kinds = parse_type("DPP DPP DPH DPH DHP ALL").kinds
    one = random_platforms(kinds, 3, np.random.default_rng(0))
    every = one.on_all_sides()
    assert len(every) == 24
    assert np.array_equal(np.abs(every.values), np.abs(np.repeat(one.values, 8, axis=0)))
    assert len({tuple(np.sign(row)) for row in every.values[:8]}) == 8
    assert np.array_equal(every.values[::8], one.values)


def test_six_planes_on_one_side_have_at_most_eight() -> None:
    total = _total(Sample(parse_type("6PH"), 60, one_sided=True))
    assert total.real.total() == 60
    assert set(total.real) <= {2, 4, 6, 8}


def test_a_tally_is_the_same_with_other_processes() -> None:
    wanted = Sample(parse_type("6PP"), 420)
    assert len(wanted.pieces) == 2
    assert _total(wanted) == _total(wanted, Workers(2))


def _reality(points: list[list[complex]], condition: float) -> Reality:
    return reality(np.array(points, complex), np.full(len(points), condition))


def _point(height: float, shift: float = 0.0) -> list[complex]:
    return [1, 0, 0, 0, 0, shift, 1j * height, 0]


def test_reality_near_double_solutions_is_undecided() -> None:
    assert _reality([_point(1e-15), _point(1e-15, 1)], 1).count == 2
    assert _reality([_point(0.1), _point(-0.1)], 1).count == 0
    assert _reality([_point(0.1), _point(-0.1)], 1).decided
    # A pair whose imaginary parts are of the size of the error, and two real ones as near.
    assert not _reality([_point(1e-9), _point(-1e-9)], 1e5).decided
    assert not _reality([_point(0.0), _point(0.0, 1e-9)], 1e8).decided
    assert not _reality([_point(0.0), _point(0.1)], np.inf).decided


def test_kinds_keep_their_identity_in_other_processes() -> None:
    assert all(pickle.loads(pickle.dumps(kind)) is kind for kind in KINDS)
