"""Joint chains in space, and their drawings."""

from __future__ import annotations

import numpy as np
import pytest

from gspcli.catalogue.kinds import ALL, DLL, DPL, DPP, KINDS, Kind
from gspcli.catalogue.realization import (
    REALIZATIONS,
    JointAxis,
    JointKind,
    Realization,
    mechanism,
    outside,
    realization,
)
from gspcli.pictures.mechanisms import chain_drawing, mechanism_drawing, mounted
from gspcli.pictures.stage import ConstraintEnds, first_mode, scene_of
from gspcli.resources import instance_files
from gspcli.solver import solve
from gspcli.spec import load

SIZE = 0.1
X, Z = np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
GROUPS = [*((kind,) for kind in KINDS), (DLL, ALL)]


def ends(kind: Kind) -> ConstraintEnds:
    zero = np.zeros(3)
    directions = {"P": (zero, zero), "L": (np.array([0, 0.6, 0.8]), X), "H": (Z, Z)}
    w, v = directions[kind.platform.value][0], directions[kind.base.value][1]
    return ConstraintEnds(2 * Z, zero, w, v)


@pytest.mark.parametrize("kinds", GROUPS, ids=str)
@pytest.mark.parametrize("name", REALIZATIONS)
def test_joints_are_apart_and_in_order(kinds: tuple[Kind, ...], name: str) -> None:
    made = REALIZATIONS[name](*kinds)
    joints = mounted(made, ends(kinds[0]), SIZE)
    assert tuple(joint.placed for joint in joints) == made.chain.joints
    heights = [joint.at[2] for joint in joints]
    assert heights == sorted(heights, reverse=True) or JointAxis.PLATFORM in {
        joint.placed.axis for joint in joints[1:]
    }
    for joint in joints:
        length = np.linalg.norm(joint.axis)
        assert length == pytest.approx(
            0 if joint.placed.joint is JointKind.SPHERICAL else 1, abs=1e-9
        )


def test_joints_at_the_ends_are_on_their_primitives() -> None:
    first, driver, last = mounted(realization(DPL), ends(DPL), SIZE)
    np.testing.assert_allclose(first.at, [0, 0, 2])
    np.testing.assert_allclose(driver.at, [0, 0, 1])
    np.testing.assert_allclose(driver.axis, [0, 0, -1])
    np.testing.assert_allclose((last.at, last.axis), ([0, 0, 0], X))


def test_an_outside_driver_is_beyond_the_base() -> None:
    *_, at_base, driver = mounted(outside(DPP), ends(DPP), SIZE)
    assert driver.placed.driven
    assert driver.at[2] < at_base.at[2] - SIZE


def test_crossing_hinges_are_one_joint() -> None:
    joints = mounted(REALIZATIONS["alternative"](DPP), ends(DPP), SIZE)
    np.testing.assert_allclose(joints[-1].at, joints[-2].at)
    assert joints[-1].axis @ joints[-2].axis == pytest.approx(0)


def colours(svg: bytes) -> int:
    """Return how many parts are filled as driven joints are."""
    return svg.count(b"fill: #f8d3ad")


@pytest.mark.parametrize("made", [realization(DPP), outside(DPL), realization(DLL, ALL)], ids=str)
def test_driven_joints_are_marked(made: Realization) -> None:
    one = chain_drawing([("one", made)], "svg")
    assert colours(one) > 0
    held = Realization(made.kinds, made.chain.locked, "held")
    if not any(placed.driven for placed in held.chain.joints):
        assert colours(chain_drawing([("held", held)], "svg")) == 0


@pytest.mark.parametrize("name", ["figure-2", "figure-3", "figure-4", "sdss-primary"])
def test_whole_mechanisms_are_drawn(name: str) -> None:
    instance = load(instance_files()[name])
    result = solve(instance)
    scene = scene_of(result, only=first_mode(result))
    built = mechanism(instance.constraints)
    svg = mechanism_drawing(scene, built, "svg", 0)
    assert svg == mechanism_drawing(scene, built, "svg", 0)
    assert colours(svg) >= 3 * built.driven
