"""Study points of all poses of platforms with three angles."""

from __future__ import annotations

from itertools import combinations_with_replacement, islice

import numpy as np
import pytest

from benchmarks.cases import random_instances
from gspcli import _kernel
from gspcli.catalogue.kinds import DISTANCE_KINDS
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.measurement import residuals, sides_of
from gspcli.geometry.quaternions import dot, pose_from_study
from gspcli.geometry.three_angles import StudyPoints, measures, study_points

TRIPLES = [
    " ".join(kind.name for kind in kinds)
    for kinds in combinations_with_replacement(DISTANCE_KINDS, 3)
]


def arrangement(type_text: str, *, one_sided: bool = True) -> Arrangement:
    drawn = random_instances(type_text, 3, one_sided=one_sided)
    return Arrangement.of(next(islice(drawn, 1, None))).normalized


def points_of(given: Arrangement, values: np.ndarray) -> StudyPoints:
    return study_points(given, values[:, given.distances], values)


@pytest.mark.parametrize("triple", TRIPLES)
def test_points_are_poses_on_their_sides(triple):
    given = arrangement(f"{triple} ALL ALH AHH", one_sided=False)
    points, general, signs = points_of(given, given.values[None])
    assert general.tolist() == [True]
    e, f = points[0, ..., :4], points[0, ..., 4:]
    assert np.abs(dot(e, f)).max() < 1e-13
    R, T = pose_from_study(e, f)
    size = np.maximum(1, np.abs(R).max(axis=(-1, -2)) + np.abs(T).max(axis=-1)) ** 2
    for k, (turns, places, relative) in enumerate(zip(R, T, size, strict=True)):
        assert (residuals(given, turns, places).max(axis=1) / relative).max() < 1e-9
        sided = given.sided
        told = sides_of(given, turns, places)[:, sided]
        np.testing.assert_array_equal(told, np.broadcast_to(signs[k, sided], told.shape))


def test_points_that_are_not_real_come_in_exact_pairs():
    given = arrangement("DPL DPL DLP 3ALL")
    points = points_of(given, given.values[None]).points.reshape(-1, 8)
    rows = {tuple(point.tolist()) for point in points}
    assert len(rows) == 64
    assert {tuple(point.conj().tolist()) for point in points} == rows


def test_sets_do_not_depend_on_their_neighbours():
    given = arrangement("DPP DPH DLL ALL ALH AHH")
    rng = np.random.default_rng(4)
    values = given.values * (1 + 0.1 * rng.normal(size=(9, 6)))
    whole = points_of(given, values)
    for k, row in enumerate(values):
        alone = points_of(given, row[None])
        np.testing.assert_array_equal(alone.points[0], whole.points[k])
    assert whole.general.any()


def test_a_set_that_is_not_solved_has_no_points_and_spoils_no_other():
    given = arrangement("DPL DPL DLP 3ALL")
    values = np.repeat(given.values[None], 3, axis=0)
    values[1, given.angles[0]] = np.nan
    points, general, _ = points_of(given, values)
    assert general.tolist() == [True, False, True]
    assert not points[1].any()
    np.testing.assert_array_equal(points[0], points[2])


def test_shapes_are_checked():
    given = arrangement("DPP DPL DLL 3ALL")
    shapes, angles = measures(given), given.angles
    one = np.ones((2, 1))

    def call(cosines: np.ndarray, flat: np.ndarray, curved: np.ndarray) -> None:
        forms = shapes.forms, shapes.spheres, shapes.skew, shapes.signs, shapes.basis
        _kernel.closed_forms(given.u[angles], given.v[angles], cosines, *forms, flat, curved)

    call(np.ones((2, 3)) / 2, one, np.ones((2, 2)))
    with pytest.raises(ValueError, match="cosines, flat and curved"):
        call(np.ones((1, 3)) / 2, one, np.ones((2, 2)))
    with pytest.raises(ValueError, match="three distances"):
        call(np.ones((2, 3)) / 2, one, one)
