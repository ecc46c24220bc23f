"""Whole mechanisms: the sum of Kutzbach and Grübler, merged chains, shared joints."""

from __future__ import annotations

import pytest

from gspcli.catalogue.coincidence import coincident_types, parse_sharing
from gspcli.catalogue.names import parse_type
from gspcli.catalogue.realization import mechanism, mechanism_of_type
from gspcli.catalogue.types import GspType, all_types

FIGURE_2 = "L1-l3 L1^l3 L2-l4 L2^l4 L1^l4 L2-l3"


def test_every_type_has_six_freedoms_and_six_motors() -> None:
    for gsp_type in all_types():
        built = mechanism_of_type(gsp_type)
        assert built.moving_freedoms == 6 == built.driven
        assert len(built.chains) == 6
        assert built.shared == ()


def test_the_sum_for_six_legs() -> None:
    built = mechanism_of_type(parse_type("6PP"))
    assert (built.links, built.joints, built.joint_freedoms) == (14, 18, 42)
    assert built.sum_shown == "M = 6 (n - g - 1) + Σf = 6 (14 - 18 - 1) + 42 = 12; 12 - 6 idle = 6"


def test_figure_14_has_four_chains() -> None:
    built = mechanism(parse_sharing(FIGURE_2).bonds)
    names = [mounted.realization.chain.name for mounted in built.chains]
    assert sorted(names) == ["C-P-R*-C", "C-R*-P*-C", "C-R*-P*-C", "C-R-P*-C"]
    assert built.moving_freedoms == built.driven == 6
    together = [mounted for mounted in built.chains if len(mounted.constraints) == 2]
    bonds = parse_sharing(FIGURE_2).bonds
    for mounted in together:
        first, second = (bonds[index] for index in mounted.constraints)
        assert (first.platform, first.base) == (second.platform, second.base)
        assert [first.kind, second.kind] == list(mounted.realization.kinds)


@pytest.mark.parametrize("gsp_type", all_types()[::400], ids=str)
def test_every_pattern_has_six_freedoms_and_six_motors(gsp_type: GspType) -> None:
    for pattern in list(coincident_types(gsp_type))[::7]:
        built = mechanism(pattern.bonds)
        assert built.moving_freedoms == 6 == built.driven
        realized = sorted(index for mounted in built.chains for index in mounted.constraints)
        assert realized == list(range(6))


def test_shared_primitives() -> None:
    built = mechanism(parse_sharing("P1-p1 P1-p2 P2-p2 P2-h1 L1-l1 L2-l1").bonds)
    described = {(shared.body, shared.name): shared.joints for shared in built.shared}
    assert described == {
        ("platform", "P1"): "compound spherical joint: 2 S with one centre",
        ("platform", "P2"): "compound spherical joint: 2 S with one centre",
        ("base", "p1"): "compound spherical joint: 2 S with one centre",
        ("base", "l1"): "2 C on one shaft",
    }
    on_planes = mechanism(parse_sharing("P1-h1 P2-h1 P3-h1 P4-p1 P5-p2 P6-p3").bonds)
    (plane,) = on_planes.shared
    assert (plane.name, plane.joints, len(plane.chains)) == ("h1", "3 E on one plane", 3)
