"""Starts for flat bodies: the same solutions, and a count that decides whether they are all."""

import numpy as np
import pytest

from gspcli import load, solve
from gspcli.geometry.arrangement import Arrangement
from gspcli.resources import data_path
from gspcli.solver import flat_start
from gspcli.solver.geometry_start import Way, geometry_start
from gspcli.solver.proof import Ground

NAMES = ("nano-hexapod", "simscape-hexapod", "simmechanics-hexapod", "workspace-study")
#: Of the start's parameters, in lengths of order one.
ABOUT = ((0.5,) * 6, (0.5,) * 6)


def geometry(instance):
    inner = Arrangement.of(instance).normalized
    return inner.kinds, np.array([inner.y, inner.x, inner.u, inner.v]).tobytes()


@pytest.mark.parametrize("name", NAMES)
def test_the_solutions_are_those_of_the_stored_start(name):
    given = geometry(load(str(data_path("platforms", f"{name}.yaml"))))
    flat, stored = (geometry_start(*given, *ABOUT, 1, way=way) for way in (Way.FLAT, Way.QUICK))
    assert len(flat.points) == len(stored.points) == 28
    alike = (
        np.abs(flat.points.conj() @ stored.points.T)
        / np.linalg.norm(flat.points, axis=1)[:, None]
        / np.linalg.norm(stored.points, axis=1)
    )
    assert (np.sort(alike, axis=1)[:, -1] > 1 - 1e-9).all()
    assert sorted(alike.argmax(axis=1).tolist()) == list(range(28))


def test_only_legs_of_flat_bodies_with_joints_of_their_own_have_such_a_start():
    for name in ("rubin-m2", "sdss-primary", "linuxcnc-hexapod"):
        given = geometry(load(str(data_path("platforms", f"{name}.yaml"))))
        assert geometry_start(*given, *ABOUT, 1, way=Way.FLAT) is None


def test_where_paths_go_wrong_the_count_says_so(monkeypatch):
    instance = load(str(data_path("platforms", "nano-hexapod.yaml")))
    right = solve(instance)
    follow = flat_start.ends_from_start

    def lost(*args):
        ends = follow(*args)
        ends[np.abs((ends[:, :4] ** 2).sum(axis=1)).argmax()] = np.nan
        return ends

    geometry_start.cache_clear()
    monkeypatch.setattr(flat_start, "ends_from_start", lost)
    found = solve(instance)
    geometry_start.cache_clear()
    assert found.proof.by is right.proof.by is Ground.GEOMETRY
    np.testing.assert_allclose(found.T, right.T, atol=1e-9)
