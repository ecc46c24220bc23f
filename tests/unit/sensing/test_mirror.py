"""When each mode has a mirror image: exactly, for points, lines and planes."""

from __future__ import annotations

import numpy as np
import pytest

import gspcli
from gspcli.geometry.arrangement import Arrangement
from gspcli.geometry.measurement import measured
from gspcli.geometry.primitives import vector
from gspcli.geometry.quaternions import rotation_from_vector
from gspcli.resources import instance_files
from gspcli.sensing.mirror import mirror_of, plane_of

SQUARE = [(0, 0), (1, 0), (0, 1), (2, 3)]
#: Where base and platform lie in planes, and where they do not.
PLANAR = {
    "linuxcnc-hexapod",
    "nano-hexapod",
    "rubin-camera",
    "simmechanics-hexapod",
    "simscape-hexapod",
    "t-top-head",
    "workspace-study",
    "workspace-study-cones",
    "hexagons-equal-legs",
    "planar-6-6",
    "planar-hexagons",
    "octahedral-3-3",
}
NOT = {"rubin-m2", "apo-tertiary", "reachy-mini-head", "dietmaier", "modified-paradex"}
NOT |= {"sdss-primary", "three-vee-250mm", "example-6.8"}


@pytest.mark.parametrize("name", sorted(PLANAR | NOT))
def test_shipped_files(name):
    instance = gspcli.load(instance_files()[name])
    assert (mirror_of(instance) is not None) == (name in PLANAR)


@pytest.mark.parametrize(
    "z",
    [
        lambda x, y: 0,
        lambda x, y: f"{x}/3 + {y}/7",
        lambda x, y: f"sqrt(2)*{x} - sqrt(3)*{y} + 1",
        lambda x, y: f"sind(20)*{x} + cos(pi/7)*{y}",
    ],
)
def test_points_in_a_plane_are_proved_to_be(z):
    points = [vector(x, y, z(x, y)) for x, y in SQUARE]
    assert plane_of(points) is not None
    lifted = [*points[:3], vector(2, 3, f"{z(2, 3)} + 1e-19")]
    assert plane_of(lifted) is None


def test_points_on_a_line_span_no_plane():
    assert plane_of([vector(k, 2 * k, 0) for k in range(4)]) is None
    assert plane_of([vector(0, 0, 0), vector(1, 0, 0)]) is None


def mixed(**other):
    """Return a platform of many kinds that a reflection of both bodies in z = 0 keeps."""
    points = [gspcli.Point([x, y, 0]) for x, y in SQUARE]
    flat, upright = (
        gspcli.Line([1, 2, 0], [1, 1, 0]),
        gspcli.Line([3, 1, "1/7"], [0, 0, 2]),
    )
    wall, floor = gspcli.Plane([1, 1, 1], [1, 2, 0]), gspcli.Plane([5, 6, 0], [0, 0, 1])
    parts = {
        "first": gspcli.distance(points[0], points[1], 3),
        "second": gspcli.distance(points[1], flat, 2),
        "third": gspcli.distance(points[2], wall, 1, side="positive"),
        "fourth": gspcli.distance(upright, points[0], 2),
        "fifth": gspcli.distance(points[3], points[2], 2),
        "sixth": gspcli.angle(gspcli.Line([0, 0, 0], [1, 2, 0]), flat, 60),
    } | {name: make(points, flat, upright, wall, floor) for name, make in other.items()}
    return gspcli.instance(list(parts.values()), length="mm", angle="deg")


@pytest.mark.parametrize(
    ("make", "kept"),
    [
        (lambda p, flat, up, wall, floor: gspcli.distance(p[3], up, 2), True),
        (lambda p, flat, up, wall, floor: gspcli.distance(p[3], floor, 2), True),
        (lambda p, flat, up, wall, floor: gspcli.distance(p[3], floor, 2, side="positive"), False),
        (lambda p, flat, up, wall, floor: gspcli.distance(floor, p[3], 2), True),
        (lambda p, flat, up, wall, floor: gspcli.distance(up, flat, 2), True),
        (lambda p, flat, up, wall, floor: gspcli.angle(up, floor, 30), True),
        (lambda p, flat, up, wall, floor: gspcli.angle(up, wall, 30), False),
        (lambda p, flat, up, wall, floor: gspcli.angle(up, flat, 60), False),
        (lambda p, flat, up, wall, floor: gspcli.angle(up, flat, 90), True),
        (lambda p, flat, up, wall, floor: gspcli.angle(wall, floor, 60), False),
        (lambda p, flat, up, wall, floor: gspcli.angle(wall, floor, 90), True),
        (
            lambda p, flat, up, wall, floor: gspcli.distance(
                p[3], gspcli.Line([0, 0, 1], [1, 0, 0]), 2
            ),
            False,
        ),
        (
            lambda p, flat, up, wall, floor: gspcli.distance(
                p[3], gspcli.Line([0, 0, 0], [1, 0, 1]), 2
            ),
            False,
        ),
    ],
)
def test_lines_and_planes(make, kept):
    """What is said to be kept has its value at the image of a pose, or a sign that is left open."""
    instance = mixed(sixth=make)
    mirror = mirror_of(instance)
    assert (mirror is not None) == kept
    known = mirror_of(mixed())
    assert known is not None
    rng = np.random.default_rng(3)
    pose = rotation_from_vector(rng.normal(size=(4, 3))), rng.normal(size=(4, 3))
    bodies = Arrangement.of(instance)
    here, there = (measured(bodies, *one)[:, 5] for one in (pose, known.image(*pose)))
    row = instance.constraints[5]
    alike = np.abs(here) - np.abs(there) if row.kind.is_distance else here - there
    right = row.value.value == 90
    free = kept and not right
    assert (np.abs(alike).max() < 1e-9) == (free or (row.kind.has_sides and not kept))
