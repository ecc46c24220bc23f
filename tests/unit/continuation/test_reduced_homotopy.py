"""Paths on which only multiples of N move, in fewer unknowns, against those of the same systems."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli import _kernel
from gspcli.catalogue.names import parse_type
from gspcli.continuation.reduced_homotopy import ReducedHomotopy, ends_from_start
from gspcli.continuation.start import path_count, start_system
from gspcli.continuation.systems import Coefficients, System
from gspcli.continuation.tracker import PathStatus
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.random_instances import random_instance
from gspcli.solver.study_systems import coefficients_of, target_systems
from tests.support.systems import solve_system

#: Types with the number of quantities that stay free.
TYPES = {
    "DPP DPP DPP DPP DPP DPP": 1,
    "DPH DPH DPH DHP DHP DHP": 0,
    "DPP DPP DPP DPH DHP ALL": 2,
    "DPP DPP DPP DPH AHL ALH": 3,
    "DPH DPH DHP DHP ALL ALL": 2,
}


class Case:
    """A geometry with a solved complex system, and real targets near it."""

    def __init__(self, name: str, *, planar: bool = False) -> None:
        rng = np.random.default_rng(31)
        instance, _ = random_instance(parse_type(name), rng, one_sided=True)
        given = Arrangement.of(instance).normalized
        y, x = given.y.copy(), given.x.copy()
        if planar:
            y[:, 2], x[:, 0] = 0.0, y[:, 1]
        self.arguments = given.kinds, y, x, given.u, given.v
        values = given.values.copy()
        values[given.angles] = given.cosines(given.values)
        square = [kind.is_distance and not kind.has_sides for kind in given.kinds]
        parameters = np.where(square, values**2, values)
        self.start = parameters + 1j * rng.uniform(0.5, 1, 6)
        self.targets = parameters + rng.uniform(-0.2, 0.2, (5, 6))
        self.square = square
        self.quadrics = coefficients_of(*self.arguments, np.zeros((1, 6)))[1].g[0].real
        self.solutions = solve_system(self.system(self.start), seed=32).points

    def system(self, parameters: np.ndarray) -> System:
        values = np.where(self.square, np.sqrt(parameters.astype(complex)), parameters)
        structure, coefficients = coefficients_of(*self.arguments, values[None])
        return System(structure, Coefficients(*(part[0] for part in coefficients)))

    def track(self, shifts: ReducedHomotopy):
        starts = shifts.points(self.solutions[None])
        targets = self.targets.astype(complex)
        return shifts.track(self.start[None], starts, np.zeros(len(targets), np.int32), targets)


def _check(case: Case, free: int) -> None:
    shifts = ReducedHomotopy.of(case.quadrics)
    assert shifts is not None
    assert len(shifts.free) == free
    ends = case.track(shifts)
    assert not ends.status.any()
    for parameters, study in zip(case.targets, ends.study, strict=True):
        system = case.system(parameters)
        points = study / np.linalg.norm(study, axis=-1, keepdims=True)
        assert np.abs(system.values(points)).max() < 1e-6 * np.abs(case.quadrics).max()
        overlaps = np.abs(points.conj() @ points.T)
        np.fill_diagonal(overlaps, 0)
        assert overlaps.max() < 1 - 1e-9


@pytest.mark.parametrize("name", TYPES)
def test_paths_end_at_different_solutions_of_the_system(name):
    _check(Case(name), TYPES[name])


def test_planar_bodies_leave_two_quantities_free():
    _check(Case("DPP DPP DPP DPP DPP DPP", planar=True), 2)


def _whole(name: str, seed: int = 35, *, planar: bool = False, height: float = 0.0) -> System:
    """Return the system of a platform in canonical order."""
    rng = np.random.default_rng(seed)
    given = Arrangement.of(random_instance(parse_type(name), rng, one_sided=True)[0]).normalized
    if planar:
        given.y[:, 2] *= height
        given.x[:, 0] *= height
    return target_systems(given)[0].canonical()


def _distinct(system: System, study: np.ndarray) -> int:
    """Return how many different solutions of a system some points are at."""
    points = study[np.isfinite(study).all(axis=1)]
    points = points / np.linalg.norm(points, axis=1, keepdims=True)
    assert np.abs(system.normalized().values(points)).max() < 1e-8
    overlaps = np.abs(points.conj() @ points.T)
    np.fill_diagonal(overlaps, 0)
    return int((overlaps.max(axis=1) < 1 - 1e-9).sum())


@pytest.mark.parametrize("name", TYPES)
def test_paths_from_the_stored_start_lead_to_all_solutions(name):
    system = _whole(name)
    study = ends_from_start(start_system(system.structure), system.coefficients.g)
    assert len(study) == path_count(system.structure)
    assert _distinct(system, study) == len(study)


def test_a_geometry_of_lower_rank_than_the_start_is_left_to_others():
    system = _whole("DPP DPP DPP DPP DPP DPP", planar=True)
    assert ends_from_start(start_system(system.structure), system.coefficients.g) is None


@pytest.mark.parametrize("height", [0.0, 1e-13, 1e-9, 1e-4])
def test_paths_lead_to_a_geometry_of_lower_rank_than_the_start(height):
    system = _whole("DPP DPP DPP DPP DPP DPP", planar=True, height=height)
    start = start_system(system.structure)
    study = ends_from_start(start, system.coefficients.g, lower_rank=True)
    # Near a geometry of lower rank N nearly vanishes at some: in doubles these are no Study points.
    at = np.abs((study[:, :4] ** 2).sum(axis=1)) > 1e-6 * np.linalg.norm(study, axis=1) ** 2
    assert _distinct(system, study[at]) == at.sum()
    assert at.sum() > 20


@pytest.mark.parametrize("name", ["DPP DPP DPP DPP DPP DLL", "DPP DPP DPP ALL ALL ALH"])
def test_what_is_not_of_this_sort_is_left_to_others(name):
    rng = np.random.default_rng(33)
    given = Arrangement.of(random_instance(parse_type(name), rng)[0]).normalized
    bodies = given.kinds, given.y, given.x, given.u, given.v
    quadrics = coefficients_of(*bodies, np.zeros((1, 6)))[1].g[0].real
    assert ReducedHomotopy.of(quadrics) is None


def test_small_pivots_are_not_divided_by():
    case = Case("DPP DPP DPP DPP DPP DPP", planar=True)
    noise = np.random.default_rng(34).uniform(-1, 1, (6, 6))
    quadrics = case.quadrics.copy()
    for k, (i, j) in enumerate([(0, 1), (0, 2), (0, 3), (2, 3), (3, 1), (1, 2)]):
        quadrics[:, 10 + 4 * i + j] += 1e-6 * noise[k]
        quadrics[:, 10 + 4 * j + i] -= 1e-6 * noise[k]
    found = ReducedHomotopy.of(quadrics)
    assert len(found.pivots) == 5
    assert np.abs(found.combinations).max() < 1e2
    # The last equation has 1e-6 of the quantities, and no part of it is lost.
    w = [quadrics[:, 10 + 4 * i + j] for i, j in ((0, 1), (0, 2), (0, 3), (2, 3), (3, 1), (1, 2))]
    rest = (found.combinations @ np.stack(w, axis=1))[5, [k for k in found.free if k < 6]]
    np.testing.assert_allclose(found.slopes[5], rest, rtol=1e-9)
    assert 1e-9 < np.abs(rest).max() < 1e-4
    # Paths from solutions without the noise lead to those with it.
    values = np.stack((case.start, case.start)).astype(complex)
    starts = found.points(case.solutions[None])
    ends = found.track(values[:1], starts, np.zeros(1, np.int32), values[1:])
    assert (ends.status == PathStatus.REGULAR).all()
    e, f = ends.study[0, :, :4], ends.study[0, :, 4:]
    residuals = _at(quadrics, e, f) - (e * e).sum(axis=1, keepdims=True) * case.start
    size = np.linalg.norm(ends.study[0], axis=1, keepdims=True) ** 2
    assert np.abs(residuals / size).max() < 1e-12
    # These are not the solutions without it.
    assert np.abs((_at(case.quadrics - quadrics, e, f)) / size).max() > 1e-8


def _at(quadrics: np.ndarray, e: np.ndarray, f: np.ndarray) -> np.ndarray:
    """Return quadrics (6, 27) at Study points, shape (n, 6)."""
    squares = np.stack([e[:, i] * e[:, j] for i in range(4) for j in range(i, 4)], axis=1)
    mixed = (e[:, :, None] * f[:, None, :]).reshape(len(e), 16)
    monomials = np.concatenate((squares, mixed, (f * f).sum(axis=1, keepdims=True)), axis=1)
    return monomials @ quadrics.T


@pytest.mark.parametrize("build", ["portable", "avx2", "avx512"])
def test_every_build_follows_the_same_paths(build, monkeypatch):
    order = ["portable", "avx2", "avx512"]
    if order.index(build) > order.index(_kernel.build()):
        pytest.skip(f"this processor cannot run {build}")
    case = Case("DPP DPP DPP DPP DPP DPP")
    shifts = ReducedHomotopy.of(case.quadrics)
    given = _kernel.track_values
    best = case.track(shifts)
    monkeypatch.setattr(_kernel, "track_values", lambda *a, **k: given(*a, **{**k, "build": build}))
    other = case.track(shifts)
    np.testing.assert_allclose(other.points, best.points, atol=1e-5)
