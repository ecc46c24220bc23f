from __future__ import annotations

import os
import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest

from gspcli.geometry import study
from gspcli.geometry.quaternions import pose_from_study


def _point(seed: int) -> list[Fraction]:
    """Return a random rational Study point."""
    source = np.random.default_rng(seed)
    e0, e1, e2, e3, t1, t2, t3 = (Fraction(int(n), 11) for n in source.integers(-30, 30, 7))
    e = [e0, e1, e2, e3]
    return [*e, *(entry / 2 for entry in study.product([0, t1, t2, t3], e))]


@pytest.mark.parametrize("seed", range(5))
def test_forms_are_n_times_the_numbers_of_the_pose(seed: int) -> None:
    point = _point(seed)
    n, rotation, translation = study.motion(point)
    R = [[entry / n for entry in row] for row in rotation]
    T = [entry / n for entry in translation]
    assert study.forms(point) == [n * entry for entry in study.forms_of_pose(R, T)]


@pytest.mark.parametrize("seed", range(5))
def test_motion_moves_a_point_as_the_quaternions_do(seed: int) -> None:
    source = np.random.default_rng(seed)
    e, t, y = source.standard_normal(4), source.standard_normal(3), source.standard_normal(3)
    e /= np.linalg.norm(e)
    conjugate = e * [1, -1, -1, -1]
    moved = np.array(study.product(study.product(e, [0, *y]), conjugate))[1:] + t
    point = [*e, *(np.array(study.product([0, *t], e)) / 2)]
    n, rotation, translation = study.motion(point)
    np.testing.assert_allclose(np.array(rotation) @ y / n + np.array(translation) / n, moved)


def test_hessians_reproduce_the_forms() -> None:
    point = np.array(_point(3))
    for matrix, form in zip(study.form_hessians(), study.forms(list(point)), strict=True):
        matrix = matrix.astype(int)
        assert (matrix == matrix.T).all()
        assert point @ matrix @ point == 2 * form


def test_study_points_are_in_a_real_patch() -> None:
    source = np.random.default_rng(1)
    e = source.standard_normal((30, 4)) + 1j * source.standard_normal((30, 4))
    f = source.standard_normal((30, 4)) + 1j * source.standard_normal((30, 4))
    f -= np.sum(e * f, axis=1, keepdims=True) / np.sum(e * e, axis=1, keepdims=True) * e
    forms = np.array([study.forms([*a, *b]) for a, b in zip(e, f, strict=True)]).T
    n = forms[study.NORM]
    R = np.array([[forms[k] / n for k in row] for row in study.ROTATION]).transpose(2, 0, 1)
    T = np.array([forms[k] / n for k in study.TRANSLATION]).T
    points, patches = study.study_points(R, T)
    rows = np.arange(30)
    assert (points[rows, patches] == 1).all()
    assert (np.abs(points[:, :4]) <= 1 + 1e-12).all()
    given = np.concatenate((e, f), axis=1)
    np.testing.assert_allclose(points, given / given[rows, patches][:, None], rtol=1e-9, atol=1e-9)


def test_few_forms_have_a_monomial_in_common() -> None:
    """The numbers of roundings that bounds allow for depend on it (`numbers.rounding`)."""
    assert (study.form_hessians() != 0).sum(axis=0).max() == 4
    assert np.abs(study.form_hessians()[: study.TRANSLATION[-1] + 1]).sum(axis=2).max() == 2


_DIGEST = """
import numpy as np
from hashlib import sha256
from gspcli.geometry.study import study_points
source = np.random.default_rng(0)
R, T = (source.normal(size=(60, 3, k, 2)) @ [1, 1j] for k in (3, 1))
print(sha256(study_points(R, T[..., 0])[0].tobytes()).hexdigest())
"""


def test_study_points_do_not_depend_on_the_processor() -> None:
    old = {"OPENBLAS_CORETYPE": "Prescott", "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4"}
    command = [sys.executable, "-W", "ignore", "-c", _DIGEST]
    digests = {
        subprocess.run(
            command, env=os.environ | more, capture_output=True, text=True, check=True
        ).stdout
        for more in ({}, old)
    }
    assert len(digests) == 1


@pytest.mark.parametrize("seed", range(3))
def test_study_points_are_those_of_the_quaternion(seed: int) -> None:
    source = np.random.default_rng(seed)
    e, f = source.normal(size=(2, 20, 4, 2)) @ np.array([1, 1j])
    f -= ((e * f).sum(axis=1) / (e * e).sum(axis=1))[:, None] * e
    points, patches = study.study_points(*pose_from_study(e, f))
    expected = np.concatenate((e, f), axis=1)
    expected /= np.take_along_axis(expected, patches[:, None], axis=1)
    np.testing.assert_allclose(points, expected, rtol=1e-10, atol=1e-10)
    assert (np.abs(points[:, :4]) < 1 + 1e-12).all()
