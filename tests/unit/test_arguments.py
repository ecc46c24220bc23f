"""What functions take: poses in several forms; what they refuse is a `GspError` that names it."""

import inspect

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import gspcli
from gspcli.errors import ArgumentError, GspError

HEXAPOD = gspcli.example("nano-hexapod")
T = np.array([[0.0, 0.0, 0.01], [0.001, 0.0, 0.01]])


def test_poses_are_pairs_rotations_of_scipy_and_modes_of_results():
    result = gspcli.solve(HEXAPOD)
    turned = Rotation.from_euler("ZYX", [[0.1, 0, 0], [0, 0.1, 0]])
    assert np.array_equal(
        gspcli.measure(HEXAPOD, turned, T), gspcli.measure(HEXAPOD, turned.as_matrix(), T)
    )
    home = result.home
    expected = gspcli.measure(HEXAPOD, home.R, home.T)
    for pose in (home, (home.R, home.T), result.solutions[home.number - 1]):
        assert np.array_equal(gspcli.measure(HEXAPOD, pose), expected)
    assert gspcli.path(HEXAPOD, home, home).verdict == "proved"
    assert len(gspcli.analyze(HEXAPOD, home).to_frame()) == 1


def test_one_rotation_stands_for_many_translations():
    both = np.broadcast_to(np.eye(3), (2, 3, 3))
    assert np.array_equal(gspcli.measure(HEXAPOD, np.eye(3), T), gspcli.measure(HEXAPOD, both, T))
    with pytest.raises(ArgumentError, match=r"R has shape \(3, 3, 3\) and T \(2, 3\)"):
        gspcli.measure(HEXAPOD, np.broadcast_to(np.eye(3), (3, 3, 3)), T)


def test_real_poses_are_real_arrays():
    result = gspcli.solve(HEXAPOD)
    assert result.real_R.dtype == result.real_T.dtype == float
    assert result.real_R.shape == (result.counts.real, 3, 3)
    assert np.array_equal(result.real_T, result.T[result.real])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: gspcli.track(HEXAPOD, "a.csv"), "values: found a str, expected an array of"),
        (lambda: gspcli.analyze(HEXAPOD, None, None), "R: found a NoneType, expected a pose"),
        (lambda: gspcli.measure(HEXAPOD, np.eye(3) * 1j, T), "R: found complex numbers"),
        (lambda: gspcli.path(HEXAPOD, 1.5, 1), "start: found a float, expected a pose"),
        (lambda: gspcli.sample("6PP", "a"), "count: found 'a', expected a number"),
        (lambda: gspcli.identify("nope.csv"), "nope.csv: cannot be read: No such file"),
        (lambda: gspcli.dump(HEXAPOD, "/nonexistent/x"), "cannot be written: No such file"),
        (lambda: gspcli.maximize_real("6PP", seconds=-1), "seconds: found -1, expected more"),
    ],
)
def test_wrong_arguments_are_named(call, message):
    with pytest.raises(GspError, match=message):
        call()


def test_kinds_of_types_may_be_texts():
    types = gspcli.TypeList(gspcli.all_types())
    assert len(types.where(only="PP")) == 1
    assert len(types.where(only="PP PL", having=["PL"])) == len(types.where(only="PP PL")) - 1


def test_help_of_solve_does_not_change():
    before = str(inspect.signature(gspcli.solve))
    gspcli.solve(HEXAPOD)
    assert str(inspect.signature(gspcli.solve)) == before
    assert "<SolvedStarts>" in before
