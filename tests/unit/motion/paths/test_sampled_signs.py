"""The determinants that judge proved ways agree with those of the measured values' derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.catalogue.names import parse_type
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.measurement import jacobian
from gspcli.geometry.random_instances import random_instance
from gspcli.motion.paths.pose_ways import PoseWays

#: Together all ten kinds.
TYPES = ("6PP", "DPP DPL DLP DPH DHP ALL", "3PP ALL ALH AHL", "2DLL DPP DPL AHH ALH", "3DLL 3ALL")


@pytest.mark.parametrize("name", TYPES)
def test_the_sign_is_that_of_the_derivatives_up_to_one_factor(name, load_tool):
    determinants = load_tool("verify.sampled_signs").determinants
    draw = np.random.default_rng(5)
    instance = random_instance(parse_type(name), draw)[0]
    ways, a = PoseWays(instance, limits=False), Arrangement.of(instance)
    parameters = draw.normal(size=(700, 6)) * ways.sizes
    found = determinants(a, ways.pivot, parameters)
    rows = jacobian(a, *ways.poses(parameters))
    expected = np.linalg.det(rows / np.linalg.norm(rows, axis=-1, keepdims=True))
    certain = np.abs(expected) > 1e-9
    assert certain.sum() > 600
    signs = np.sign(found * expected)[certain]
    assert abs(signs.sum()) == certain.sum()
    assert {*np.sign(found).tolist()} == {-1.0, 1.0}


def test_a_way_through_a_singular_pose_is_seen(load_tool):
    """Between modes of different signs some sample differs."""
    paths = load_tool("verify.paths")
    ways, modes = paths._for_segments("platform-6-6")
    way = modes[0] + (modes[1] - modes[0]) * np.linspace(0, 1, 50)[:, None]
    signs = np.sign(paths.determinants(Arrangement.of(ways.instance), ways.pivot, way))
    assert signs[0] == -signs[-1]
