"""Solutions that are at infinity, or only far away, are told apart; wrong guesses are refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gspcli.catalogue.types import type_by_number
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.distance_forms import measures
from gspcli.geometry.quaternions import dot, normalized, rotation_from_quaternion, study_from_pose
from gspcli.solver.closed_form import solve_closed_form
from gspcli.solver.generate import random_instance
from gspcli.solver.infinity import finite_pose, refined_rotation
from gspcli.solver.rotations import angle_forms


def null_quaternion(rng: np.random.Generator) -> np.ndarray:
    a, b = np.linalg.qr(rng.normal(size=(4, 2)))[0].T
    return (a + 1j * b) / np.sqrt(2)


def forms_through(e: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Three random real quadrics through a complex point of P^3."""
    outer = (e[:, None] * e).reshape(16)
    kernel = np.linalg.svd(np.array([outer.real, outer.imag]))[2][2:]
    forms = (rng.normal(size=(3, 14)) @ kernel).reshape(3, 4, 4)
    return (forms + np.swapaxes(forms, 1, 2)) / 2


@pytest.mark.parametrize("seed", range(5))
def test_a_null_quaternion_is_no_rotation_and_one_near_it_is(seed):
    rng = np.random.default_rng(seed)
    e = null_quaternion(rng)
    assert refined_rotation(forms_through(e, rng), e)[1] is False
    near = normalized(e + 1e-9 * e.conj())
    forms = forms_through(near, rng)
    refined, decided = refined_rotation(forms, near + 1e-8 * rng.normal(size=4))
    assert decided is True
    np.testing.assert_allclose(abs(dot(refined, refined)), 2e-9, rtol=1e-5)
    np.testing.assert_allclose(abs(np.vdot(refined, near)), 1, atol=1e-14)


def test_a_point_on_no_intersection_is_not_decided():
    rng = np.random.default_rng(1)
    forms = forms_through(null_quaternion(rng), rng)
    assert refined_rotation(forms, null_quaternion(rng))[1] is None


@pytest.mark.parametrize("number", [1, 300, 500, 700, 900, 1119])
def test_a_finite_pose_is_refined_to_itself(number):
    arrangement = Arrangement.of(
        random_instance(type_by_number(number), np.random.default_rng(number))[0]
    ).normalized
    poses = solve_closed_form(arrangement)
    angles, distances = arrangement.angles, arrangement.values[arrangement.distances]
    forms = angle_forms(
        arrangement.u[angles], arrangement.v[angles], arrangement.cosines(arrangement.values)
    )
    shapes = measures(arrangement)
    e, f = study_from_pose(poses.R[-1], poses.T[-1])
    size = np.linalg.norm(e)
    found = [
        finite_pose(forms, shapes, signs, distances, e / size, np.array([1, *(f / size)]))
        for signs in shapes.signs
    ]
    # With the signs of another pose Newton's method goes elsewhere or nowhere.
    errors = [np.abs(pose[1] - poses.T[-1]).max() for pose in found if pose]
    assert min(errors) < 1e-9 * (1 + np.abs(poses.T[-1]).max())


@pytest.mark.parametrize("small", [1e-2, 1e-4, 1e-6, 1e-8, 1e-10])
def test_nearly_null_rotations_are_found_or_lost_but_never_infinite(small):
    """Three axes almost parallel, so that a complex rotation has a very small N."""
    rng = np.random.default_rng(5)
    solved = 0
    for triple in range(0, 56, 5):
        e = null_quaternion(rng)
        R = rotation_from_quaternion(normalized(e + small * e.conj() / 2))
        instance, _ = random_instance(type_by_number(1 + 20 * triple), rng)
        given = Arrangement.of(instance)
        v, values = given.v.copy(), given.values.copy()
        for k in given.angles:
            w = R @ given.u[k]
            cosine = rng.uniform(-0.5, 0.5)
            plane = np.array([w.real, w.imag])
            foot = np.linalg.lstsq(plane, np.array([cosine, 0]))[0]
            normal = np.linalg.svd(plane)[2][2]
            if foot @ foot < 1:
                v[k] = foot + np.sqrt(1 - foot @ foot) * normal
                values[k] = np.degrees(np.arccos(cosine))
        poses = solve_closed_form(replace(given, v=v, values=values))
        assert poses.account.at_infinity == poses.account.on_curves == 0
        assert (poses.multiplicity == 1).all()
        assert len(poses.R) == poses.account.found
        solved += poses.account.lost == 0
    assert solved > 8 or small < 1e-3
