"""Travels along axes: against bisection, and where they stop."""

from dataclasses import replace

import numpy as np
import pytest

from gspcli import example
from gspcli.errors import ArgumentError
from gspcli.geometry.instance import Side
from gspcli.geometry.machine import Machine
from gspcli.geometry.numbers import Number
from gspcli.motion.statics.wrenches import wrenches
from gspcli.motion.workspace.travels import moved, travels, violations
from gspcli.motion.workspace.workspaces import workspace
from tests.support.limited import limited, one_leg, study
from tests.support.surface_machines import tripod

AXES = ("x", "y", "z", "rx", "ry", "rz")


@pytest.mark.parametrize("pivot", [(0, 0, 0), (10, -5, 30)])
def test_they_end_where_sampling_leaves_the_limits(pivot):
    instance, R, T = study(), np.eye(3), np.array([3, 1, 85.0])
    for travel in travels(instance, R, T, pivot=pivot):
        for way, sign in ((0, -1), (1, 1)):
            reached, end = travel.reached[way], travel.ends[way]
            assert 0 <= sign * reached <= sign * end
            assert abs(end - reached) < 1e-9
            for value, kept in ((reached * 0.999999, True), (end * 1.000001, False)):
                pose = moved(R, T, {travel.axis: value}, pivot=pivot, in_radians=np.pi / 180)
                assert Machine.of(instance).keeps(*pose) == kept
            # Every pose on the way, too.
            for value in np.linspace(0, reached * 0.999999, 50):
                pose = moved(R, T, {travel.axis: value}, pivot=pivot, in_radians=np.pi / 180)
                assert Machine.of(instance).keeps(*pose)
            assert travel.stops[way]


def test_a_singular_pose_ends_the_travel():
    instance, R, T = study(), np.eye(3), np.array([0, 0, 80.0])
    (free,), (bound,) = (
        travels(instance, R, T, axes=("rx",), connected=connected) for connected in (False, True)
    )
    assert bound.stops[1] == ("singularity",)
    assert bound.ends[1] < free.reached[1] - 1
    signs = []
    for value in (bound.reached[1] * 0.99999, bound.ends[1] * 1.00001):
        pose = moved(R, T, {"rx": value}, in_radians=np.pi / 180)
        signs.append(np.sign(np.linalg.det(wrenches(instance, *pose).jacobian)))
    assert signs[0] == -signs[1]


def test_all_kinds_and_no_end():
    instance, R, T = limited("PP PL LP PH HP DLL", 4, width=0.3)
    for travel in travels(instance, R, T):
        assert travel.reached[0] <= 0 <= travel.reached[1]
        assert travel.ends[0] <= travel.reached[0]
        assert travel.reached[1] <= travel.ends[1]
    # A leg from the pivot lets the platform turn as it likes.
    for travel in travels(one_leg(), np.eye(3), np.array([0, 0, 1.5]), axes=("rx", "rz")):
        assert travel.reached == (-180, 180)
        assert travel.ends == (-np.inf, np.inf)
        assert travel.stops == ((), ())


def test_home_must_keep_the_limits():
    with pytest.raises(ArgumentError, match=r"home does not keep the limits: the value 902\.5"):
        travels(study(), np.eye(3), np.array([0, 0, 900.0]))
    said = violations(study(), np.eye(3), np.array([60, 0, 60.0]))
    assert any(text.startswith("leg 1 is tilted by 38.4188 at the base") for text in said), said
    with pytest.raises(ArgumentError, match="axes: found w"):
        travels(study(), np.eye(3), np.array([0, 0, 60.0]), axes=("w",))
    with pytest.raises(ArgumentError, match="offset: found w"):
        moved(np.eye(3), np.zeros(3), {"w": 1})


def test_a_home_at_a_limit_goes_one_way():
    travel = travels(one_leg((1, 2)), np.eye(3), np.array([0, 0, 2.0]), axes=("z",))[0]
    assert travel.reached[1] == 0
    assert travel.ends[1] < 1e-9
    assert travel.ends[0] == pytest.approx(-1, abs=1e-9)


@pytest.mark.parametrize("machine", [example("three-rps"), tripod()], ids=["values", "cranks"])
def test_an_axis_along_which_fixed_values_change_has_no_travel(machine):
    """The planes of a tripod leave one axis: up and down."""
    fixed = np.flatnonzero(Machine.of(machine).fixed)
    free = list(machine.constraints)
    for k in fixed:
        free[k] = replace(free[k], side=Side.BOTH, limits=(Number.of(-1), Number.of(100)))
    home = machine.home.R(1.0), machine.home.T
    found = {one.axis: one for one in travels(machine, *home, connected=True)}
    wide = {one.axis: one for one in travels(replace(machine, constraints=free), *home, axes=["z"])}
    np.testing.assert_allclose(found["z"].reached, wide["z"].reached, rtol=1e-6)
    for axis in ("x", "y", "rx", "ry", "rz"):
        assert found[axis].reached == (0, 0)
        assert 0 < found[axis].ends[1] < 1e-2
        names = {f"fixed value of {k + 1}" for k in fixed}
        assert found[axis].stops[0]
        assert set(found[axis].stops[0]) <= names
    with pytest.raises(ArgumentError, match=r"poses that keep (it|them) have no volume in x and z"):
        workspace(machine, *home, free=("x", "z"))
    low, high = workspace(machine, *home, free=("z",), connected=True).volume
    assert low <= found["z"].reached[1] - found["z"].reached[0] <= high
    assert violations(machine, home[0], home[1] + [1e-6, 0, 0])
